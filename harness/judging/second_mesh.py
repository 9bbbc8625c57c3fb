"""Whether errors that do not fall with tau are errors in space: a second mesh tells."""

import numpy as np

from esfem.judging.validate import Runs

SHARE = 0.1  # of the error, from which on the part that falls with h explains it


def falls_with_h(runs: Runs, order: float | None) -> bool | None:
    """Whether a finer mesh has a smaller error at the same tau; None if there is no second mesh.

    Parameters
    ----------
    order : expected in h; 1 if it is not known. Of an error C + A h^order the part A h^order must
        be a tenth on the finer of the two finest meshes, at the smallest tau that both have.
    """
    runs = runs.at(np.isfinite(runs.error))
    for tau in np.unique(runs.tau[np.isfinite(runs.tau)]):
        pair = runs.at(runs.tau == tau)  # coarse before fine
        if len(pair) > 1:
            (coarse, fine), (before, after) = pair.h[-2:], pair.error[-2:]
            growth = (coarse / fine) ** (order or 1.0) - 1.0
            return bool(before - after > SHARE * growth * after)
    return None
