"""Experimental orders of convergence: signed rates and least-squares orders.  Arithmetic only."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Fit:
    """log e ~ log constant + order log h by least squares.

    ``uncertainty`` is the standard error of the order (NaN for two levels), ``levels`` the number
    of points.
    """

    order: float
    uncertainty: float
    constant: float
    levels: int


def rates(h: ArrayLike, e: ArrayLike) -> NDArray[np.float64]:
    """Signed rates log(e_l / e_{l+1}) / log(h_l / h_{l+1}) of consecutive levels, (levels - 1,).

    Growing errors give negative rates.  A pair with an error that is zero or not finite has no
    rate: NaN.

    Raises
    ------
    ValueError
        If the lengths differ, or h is not positive and strictly decreasing.
    """
    h, e = _levels(h, e)
    usable = np.isfinite(e) & (e > 0)
    log_e = np.log(np.where(usable, e, np.nan))
    return -np.diff(log_e) / -np.diff(np.log(h))


def fit_order(h: ArrayLike, e: ArrayLike) -> Fit:
    """The least-squares order over all given levels.

    Raises
    ------
    ValueError
        If there are fewer than two levels, h is not strictly decreasing, or an error is not
        positive and finite.
    """
    h, e = _levels(h, e)
    if len(h) < 2:
        raise ValueError(f"h: must have at least two levels, has {len(h)}")
    if not (np.isfinite(e) & (e > 0)).all():
        raise ValueError(f"e = {e}: all errors must be positive and finite")
    log_h, log_e = np.log(h), np.log(e)
    centred = log_h - log_h.mean()
    spread = float(centred @ centred)
    order = float(centred @ log_e) / spread
    intercept = float(log_e.mean() - order * log_h.mean())
    residual = log_e - intercept - order * log_h
    freedom = len(h) - 2
    uncertainty = (
        float(np.sqrt(residual @ residual / freedom / spread)) if freedom else float("nan")
    )
    return Fit(order, uncertainty, float(np.exp(intercept)), len(h))


def _levels(h: ArrayLike, e: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    h, e = np.asarray(h, dtype=float), np.asarray(e, dtype=float)
    if h.shape != e.shape or h.ndim != 1:
        raise ValueError(
            f"h, e: must be sequences of one length, have shapes {h.shape} and {e.shape}"
        )
    if not ((h > 0).all() and np.isfinite(h).all() and (np.diff(h) < 0).all()):
        raise ValueError(f"h = {h}: must be positive and strictly decreasing")
    return h, e
