"""Measured floors: what an error of a study cannot fall below, for reasons other than its order.

Two cells of each study that claims an order are run again, each side by side with a variation of
itself, and how far their States lie apart is the floor (`esfem.runs.run_pair`): both runs have one
mesh and one set of exact nodes, so that this is the difference of their errors. That of the norms
of the errors would be too small, for a difference that is orthogonal to the error changes its norm
to second order only.

Rounding, which grows under refinement, is measured on the finest cell, with start values that are
disturbed by as much; there too half the time step, for what a step changes in an error in space
falls with h, and on a coarser mesh would be too large a floor. A hundredth of the solver's
tolerance, and quadrature exact to two degrees more, are tried on the finest mesh of at most a
quarter of its vertices. This costs about three runs more, without errors to measure.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from esfem.judging.floors import FloorName
from esfem.studies.case import Case
from esfem.studies.quantities import QUANTITIES
from esfem.studies.study import Study

DISTURBANCE = 1e-13  # of the start values, relative: what rounding makes in some hundred steps
COARSER = 4  # the measured cell has at most this part of the finest vertices


# Other values of a case; of its scheme, if it is that which has such an option.
VARIATIONS: dict[FloorName, Callable[[Case], dict[str, Any]]] = {
    "rounding": lambda case: {"disturbance": DISTURBANCE},
    "tau": lambda case: {"tau": case.tau / 2.0},
    "solver": lambda case: {"tolerance": case.scheme.solved_to / 100.0},
    "quadrature": lambda case: {"quadrature": case.scheme.exactness + 2},
}


class Pair(NamedTuple):
    """A cell of the sweep, and its variation, which is run beside it."""

    case: Case
    varied: Case


def floor_pairs(study: Study) -> dict[FloorName, Pair]:
    """What is run to measure each floor; {} if no order is claimed.

    Only what binds. An order in tau is not limited by tau or by the quadrature of space, and what
    is measured of exact States alone by neither tau nor the solver. A stationary solution has no
    floor in tau: its discrete flow moves, but no further than errors in space drive it, so that
    what the time step changes is a small part of an error that is O(h^k) itself, and falls with it.
    Neither have errors against the finest level, which are differences of runs at one time step:
    theirs in time cancel as far as they do not depend on h. The finest level itself has no error
    there, and the finest cell is that of the level before it.
    """
    claim, solution = study.claimed, study.initial
    if claim is None or claim.order is None:
        return {}
    against_finest = solution.reference == "finest"
    idle = {"tau", "quadrature"} if claim.direction == "tau" else set()
    in_time = any(QUANTITIES[v].in_time for v in claim.variables)
    idle |= {"tau"} if solution.stationary or against_finest or not in_time else set()
    sizes, tau = sorted(study.sweep.vertices), min(study.sweep.tau)
    sizes = sizes[:-1] if against_finest else sizes
    small = [V for V in sizes if COARSER * V <= sizes[-1]] or sizes[:1]
    cells = {c.vertices: c for c in study.cases() if c.tau == tau}
    idle |= set() if cells[sizes[0]].iterates and in_time else {"solver"}
    finest, coarser = cells[sizes[-1]], cells[small[-1]]
    at_finest = ("rounding", "tau")
    measured = {f: finest if f in at_finest else coarser for f in VARIATIONS if f not in idle}
    changes = {f: VARIATIONS[f](case) for f, case in measured.items()}
    return {f: Pair(case, _changed(case, changes[f])) for f, case in measured.items()}


def _changed(case: Case, values: dict[str, Any]) -> Case:
    if values.keys() <= type(case).model_fields.keys():
        return case.model_copy(update=values)
    return case.model_copy(update={"scheme": case.scheme.model_copy(update=values)})
