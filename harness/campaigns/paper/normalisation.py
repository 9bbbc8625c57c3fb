"""Figure "normalisation": a sphere with and without the projections of nu_h and z_h.

The histories are computed here, in a few seconds, since the records of studies hold no distances
from the origin.
"""

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from esfem.campaigns.paper.stored_results import Row
from esfem.common.drawing import PALETTE, legend_below, styled, subplots
from esfem.meshes import surface_mesh
from esfem.reference_solutions import StationarySphere
from esfem.report.extra import Extra
from esfem.runs.loop import measured
from esfem.runs.problem import problem_of
from esfem.runs.recorder import level_numbers
from esfem.runs.run_case import computational_mesh
from esfem.runs.stepping import states
from esfem.schemes.kll import KLLOptions
from esfem.studies.case import Case, Law, Solution

EXACT = StationarySphere(radius=1.0)
CASE = Case(
    solution=Solution(name="sphere", radius=EXACT.radius),
    law=Law(name="willmore"),
    scheme=KLLOptions(degree=2, bdf=2, project=True, theta=False, reaction="extrapolated"),
    vertices=480,
    tau=0.025,
    final_time=1.0,
)
# By quantity what stands above its panel, the numbers of a level with its least and its greatest
# value, and its exact value.
QUANTITIES = {
    "|nu|": (r"$|\nu_h|$", "least_normal", "greatest_normal", 1.0),
    "distance": ("distance from the origin", "least_distance", "greatest_distance", EXACT.radius),
    "W": ("$W_h$", "willmore", "willmore", EXACT.willmore(0.0)),
}
NUMBERS = ("t", *dict.fromkeys(name for _, *both, _ in QUANTITIES.values() for name in both))
COLOURS = {"without": "black", "with": PALETTE[1]}  # projections


def case(project: bool) -> Case:
    """The run of the figure."""
    return CASE.model_copy(update={"scheme": CASE.scheme.model_copy(update={"project": project})})


def history(of: Case) -> tuple[pd.DataFrame, int]:
    """A row a time level that is reached, with its `NUMBERS`; and the nodes."""
    solution = of.initial
    surface = surface_mesh(solution.mesh_surface, of.vertices)
    mesh, p = computational_mesh(surface, solution, of.scheme.degree)
    rows: list[dict[str, float]] = []
    measured(
        states(problem_of(of, mesh, p, solution), of.levels),
        lambda n, state: rows.append(level_numbers(NUMBERS, mesh, state, of.law.energy)),
    )
    return pd.DataFrame(rows), mesh.node_count


def normalisation(runs: Path) -> Extra:
    """The figure, and a row a run with the extremes over all times; ``runs`` is not read."""
    histories = {name: history(case(name == "with")) for name in COLOURS}
    table = [summary(name, *found) for name, found in histories.items()]
    return Extra(
        title="Figure: the effect of the projections",
        text=(
            f"Sphere of radius 1, P2, BDF2, F w extrapolated, {table[0]['nodes']} nodes, "
            f"tau = {CASE.tau:g}: least (circles) and greatest (stars) length of the nodal "
            "normals, least and greatest distance of the nodes from the origin, and the Willmore "
            "energy, with and without projections. The table has the extremes over all time "
            "levels."
        ),
        table=table,
        figure=figure({name: found for name, (found, _) in histories.items()}),
        alt="Length of the normals, distance from the origin and Willmore energy against time",
    )


def summary(name: str, found: pd.DataFrame, nodes: int) -> Row:
    """One line of the table."""
    reached = float(found["t"].iloc[-1])
    row: Row = {"projections": name, "nodes": nodes, "tau": CASE.tau, "reached t": reached}
    for quantity, (_, least, greatest, exact) in QUANTITIES.items():
        row[f"least {quantity}"] = float(found[least].min())
        row[f"greatest {quantity}"] = float(found[greatest].max())
        row[f"exact {quantity}"] = exact
    return row


@styled()
def figure(histories: dict[str, pd.DataFrame]) -> Figure:
    """Three panels against time."""
    drawn, axes = subplots(1, len(QUANTITIES), (9.0, 3.1))
    for axis, (quantity, (title, least, greatest, exact)) in zip(
        axes, QUANTITIES.items(), strict=True
    ):
        for name, found in histories.items():
            look = {"color": COLOURS[name], "linewidth": 0.8, "label": f"{name} projections"}
            axis.plot(found["t"], found[least], marker="o", mfc="none", markevery=(0, 2), **look)
            if quantity != "W":  # its marks lie between those of the other line
                look |= {"label": None, "markersize": 6, "markevery": (1, 2)}
                axis.plot(found["t"], found[greatest], marker="*", **look)
        axis.axhline(exact, color="0.6", linewidth=0.8, linestyle="--", label="exact")
        axis.set(xlabel="$t$", title=title)
        axis.ticklabel_format(useOffset=False)
    legend_below(drawn, axes[0])
    return drawn
