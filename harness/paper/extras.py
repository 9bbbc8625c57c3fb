"""All extra sections of the report, by the names of their files."""

from pathlib import Path

from rich.console import Console

from harness.paper.ablation import ablation
from harness.paper.convergence import convergence
from harness.paper.divergence import divergence
from harness.paper.extra import Maker, NoData, write_extra
from harness.paper.growth import growth
from harness.paper.normalisation import normalisation

EXTRAS: dict[str, Maker] = {
    "figure-1-sphere-unprojected": convergence("paper-sphere-unprojected"),
    "figure-2-normalisation": normalisation,
    "figure-3-sphere": convergence("paper-sphere"),
    "figure-4-torus": convergence("paper-torus"),
    "figure-4-growth": growth,
    "figure-5-ablation": ablation,
    "figure-6-divergence": divergence,
    "figure-7-sphere-degree-3": convergence("paper-sphere-degree-3"),
    "figure-7-sphere-degree-4": convergence("paper-sphere-degree-4"),
    "figure-8-torus-degree-3": convergence("paper-torus-degree-3"),
    "figure-8-torus-degree-4": convergence("paper-torus-degree-4"),
}


def write_extras(runs: Path, folder: Path, console: Console) -> None:
    """Write those that can be made from what is stored below ``runs``; remove the others."""
    for name, make in EXTRAS.items():
        made = make(runs)
        for path in folder.glob(f"{name}.*"):
            path.unlink()
        if isinstance(made, NoData):
            console.print(f"no {name}: {made.reason}", soft_wrap=True)
            continue
        write_extra(folder, name, made)
        console.print(f"made {name}")
