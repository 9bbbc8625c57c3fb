"""The checks that a sentence may name."""

from collections.abc import Callable

from harness.paper.finding import Finding
from harness.paper.flow_checks import (
    flow_checks,
    flow_setting,
    nodes,
    normals_deviate,
    normals_kept,
    stays_nearer,
)
from harness.paper.order_checks import (
    at_least,
    bounded,
    exceeds,
    more_runs_finish,
    observed,
    orders,
    space_dominates,
)
from harness.paper.setting_checks import (
    final_energy,
    graded,
    mesh_widths,
    moves_discretely,
    printed_energy,
    radii,
    rests_exactly,
    time_steps,
)

Check = Callable[..., Finding]
CHECKS: dict[str, Check] = {
    check.__name__: check
    for check in (
        *(orders, bounded, exceeds, at_least, observed, space_dominates, more_runs_finish),
        *(printed_energy, final_energy, rests_exactly, moves_discretely),
        *(mesh_widths, time_steps, radii, graded),
        *(flow_setting, flow_checks, nodes, normals_deviate, normals_kept, stays_nearer),
    )
}
