"""Whether errors that do not fall with tau are errors in space: a second mesh tells."""

import pandas as pd

SHARE = 0.1  # of the error, from which on the part that falls with h explains it


def falls_with_h(runs: pd.DataFrame, order: float | None) -> bool | None:
    """Whether a finer mesh has a smaller error at the same tau; None if there is no second mesh.

    Parameters
    ----------
    runs : validated, with columns h, tau, error.
    order : expected in h; 1 if it is not known. Of an error C + A h^order the part A h^order must
        be a tenth on the finer of the two finest meshes, at the smallest tau that both have.
    """
    for _, pair in runs[runs["error"].notna()].sort_values("h").groupby("tau"):
        if len(pair) > 1:
            fine, coarse = pair.iloc[0], pair.iloc[1]
            growth = (coarse["h"] / fine["h"]) ** (order or 1.0) - 1.0
            return bool(coarse["error"] - fine["error"] > SHARE * growth * fine["error"])
    return None
