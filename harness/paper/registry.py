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
    observed,
    orders,
    orders_by_step,
)
from harness.paper.run_checks import (
    all_finish,
    growth,
    more_runs_finish,
    never_exceeds_space,
    space_dominates,
    stops,
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
        *(orders, orders_by_step, bounded, exceeds, at_least, observed),
        *(space_dominates, never_exceeds_space, more_runs_finish, all_finish, stops, growth),
        *(printed_energy, final_energy, rests_exactly, moves_discretely),
        *(mesh_widths, time_steps, radii, graded),
        *(flow_setting, flow_checks, nodes, normals_deviate, normals_kept, stays_nearer),
    )
}
