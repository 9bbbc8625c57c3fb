"""All extra sections of the report, by the names of their files."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from rich.console import Console

from esfem.campaigns.paper.ablation import ablation
from esfem.campaigns.paper.convergence import convergence
from esfem.campaigns.paper.divergence import divergence
from esfem.campaigns.paper.growth import growth
from esfem.campaigns.paper.normalisation import normalisation
from esfem.campaigns.paper.sources import Missing
from esfem.report.extra import Extra, write_extra

# What makes them from the folder of the runs; `Missing` names what has not been run.
EXTRAS: dict[str, Callable[[Path], Extra]] = {
    "figure-1-sphere-unprojected": partial(convergence, name="paper-sphere-unprojected"),
    "figure-2-normalisation": normalisation,
    "figure-3-sphere": partial(convergence, name="paper-sphere"),
    "figure-4-torus": partial(convergence, name="paper-torus"),
    "figure-4-growth": growth,
    "figure-5-ablation": ablation,
    "figure-6-divergence": divergence,
    "figure-7-sphere-degree-3": partial(convergence, name="paper-sphere-degree-3"),
    "figure-7-sphere-degree-4": partial(convergence, name="paper-sphere-degree-4"),
    "figure-8-torus-degree-3": partial(convergence, name="paper-torus-degree-3"),
    "figure-8-torus-degree-4": partial(convergence, name="paper-torus-degree-4"),
}


def write_extras(runs: Path, folder: Path, console: Console) -> None:
    """Write those that can be made from what is stored below ``runs``; remove the others."""
    for name, make in EXTRAS.items():
        try:
            made = make(runs)
        except Missing as missing:
            made = None
            console.print(f"no {name}: {missing}", soft_wrap=True)
        for path in folder.glob(f"{name}.*"):
            path.unlink()
        if made is not None:
            write_extra(folder, name, made)
            console.print(f"made {name}")
