"""The sizes of errors that are known: those of BDF on a round sphere."""

import numpy as np

from esfem.measuring.lift import ROUNDING
from esfem.reference_solutions.discrete import RadialRun
from esfem.studies.case import Case

SIZES = {"size_x": "x", "size_v": "v", "size_H": "H", "size_V": "V"}


def size_errors(case: Case, found: dict[str, float]) -> dict[str, float]:
    """``err_size_<variable>``: how far the measured error of a variable is from its known size.

    Relative; NaN where the known size is zero or rounding. ``found`` has the measured errors
    ``err_<variable>`` of a case whose solution is a round sphere. The size is known if normals are
    projected.
    """
    known = RadialRun(
        case.initial,
        case.law.name,
        case.law.parameters,
        case.scheme.bdf,
        case.tau,
        round(case.final_time / case.tau),
        self_started=not case.exact_start,
        reaction=case.scheme.reaction,
        first_steps=case.first_steps,
    ).errors()
    return {
        f"err_{size}": abs(found[f"err_{name}"] / known[name] - 1.0)
        if known[name] > ROUNDING
        else np.nan
        for size, name in SIZES.items()
    }
