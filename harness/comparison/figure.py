"""Error against seconds of the processor: which scheme gives more for them."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from harness.comparison.contest import ENTRANTS, GROUNDS, March, case_of, march
from harness.plots import MARKERS, PALETTE, STYLE
from harness.provenance import provenance_line

GROUND = "red blood cell"
LADDER = (60, 120, 240, 480)
LABELS = {"distance": "distance of the surfaces", "W": "energy $W$, relative"}


def ladders(tau: float, T: float) -> dict[str, list[March]]:
    """By entrant, its marches on finer and finer meshes of one surface, to the same time."""
    return {
        entrant: [march(case_of(entrant, GROUNDS[GROUND], V, tau, T)) for V in LADDER]
        for entrant in ENTRANTS
    }


def save_cost_figure(path: Path, found: dict[str, list[March]]) -> None:
    """Write the figure: distance and error of W, a line a scheme, a marker a mesh of `LADDER`."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
        for axis, name in zip(axes, ("distance", "W"), strict=True):
            for i, (entrant, marches) in enumerate(found.items()):
                points = np.array([(m.cpu, getattr(m, name)) for m in marches])
                axis.loglog(*points.T, marker=MARKERS[i], color=PALETTE[i], label=entrant)
            axis.set_xlabel("CPU seconds")
            axis.set_title(LABELS[name], fontsize=9)
            axis.margins(0.08)
        axes[0].set_ylabel("error at the end")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        note = f"error against CPU seconds, {GROUND}; {provenance_line()}"
        figure.savefig(path, metadata={"Description": note, "Date": None})
        plt.close(figure)
