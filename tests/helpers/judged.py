"""Tables of errors for the tests of the judge."""

import numpy as np
import pandas as pd

LADDER = 0.7 * 0.5 ** (np.arange(6) / 2)
TAUS = (0.1, 0.05, 0.025)


def line(e, h=LADDER) -> pd.DataFrame:
    """A table of the errors e(h), or of given ones."""
    return pd.DataFrame({"h": h, "error": e(h) if callable(e) else e})


def grid(e, h=LADDER, taus=TAUS) -> pd.DataFrame:
    """A table of the errors e(h, tau) over a whole grid."""
    S, T = (a.ravel() for a in np.meshgrid(h, taus))
    return pd.DataFrame({"h": S, "tau": T, "error": e(S, T)})


def scattered(seed: int, size: float, n: int = len(LADDER)) -> np.ndarray:
    """Log-normal factors about 1."""
    return np.exp(size * np.random.default_rng(seed).normal(size=n))
