"""Measured floors: what an error of a study cannot fall below, for reasons other than its order.

Two cells of each study that claims an order are run again, and what changes in the error is the
floor. Rounding, which grows under refinement, is measured on the finest cell, with start values
that are disturbed by as much. Half the time step, a hundredth of the solver's tolerance, and
quadrature exact to two degrees more, are tried on the finest mesh of at most a quarter of its
vertices. This costs about two runs more.
"""

from collections.abc import Callable
from typing import Any

from esfem.judging.floors import FloorName
from esfem.studies.case import Case
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


def measured_cells(study: Study) -> dict[FloorName, Case]:
    """By floor, the cell of the sweep whose variation measures it; {} if no order is claimed.

    Only what binds: a stationary solution has no floor in tau, and an order in tau is not limited
    by tau or by the quadrature of space. Errors against the finest level have no floors, for that
    run does not come in variations.
    """
    claim, solution = study.claimed, study.initial
    if claim is None or claim.order is None or solution.reference == "finest":
        return {}
    idle = {"tau", "quadrature"} if claim.direction == "tau" else set()
    idle |= {"tau"} if solution.stationary else set()
    sizes, tau = sorted(study.sweep.vertices), min(study.sweep.tau)
    small = [V for V in sizes if COARSER * V <= sizes[-1]] or sizes[:1]
    cells = {c.vertices: c for c in study.cases() if c.tau == tau}
    idle |= set() if cells[sizes[0]].iterates else {"solver"}
    finest, coarser = cells[sizes[-1]], cells[small[-1]]
    return {f: finest if f == "rounding" else coarser for f in VARIATIONS if f not in idle}


def floor_cases(study: Study) -> dict[FloorName, Case]:
    """The variations to run, by the floor that each measures."""
    cells = measured_cells(study)
    changes = {name: VARIATIONS[name](cell) for name, cell in cells.items()}
    return {name: _changed(cell, changes[name]) for name, cell in cells.items()}


def _changed(case: Case, values: dict[str, Any]) -> Case:
    if values.keys() <= type(case).model_fields.keys():
        return case.model_copy(update=values)
    return case.model_copy(update={"scheme": case.scheme.model_copy(update=values)})
