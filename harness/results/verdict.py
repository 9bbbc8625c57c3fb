"""What a verdict is: an outcome, and the evidence for it."""

from dataclasses import dataclass

from esfem.judging import Masked
from esfem.judging.outcome import Outcome
from esfem.studies.claims import Direction

NAN = float("nan")


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` (with ``tolerance``) is NaN unless an order is claimed, ``limit`` unless a bound on
    the error is. ``observed`` is the order over the judged window, [``lower``, ``upper``] its
    interval over all models within reach, ``constant`` that of E = constant s^observed, ``scatter``
    the standard deviation of log E about it; NaN where there was nothing to fit. ``error`` is that
    of the finest judged run. ``tau`` and ``vertices`` say which runs were judged, ``masked`` which
    were not, and ``next_run`` what would settle an inconclusive case.
    """

    study: str
    claim: str
    source: str
    variable: str
    norm: str
    direction: Direction
    verdict: Outcome
    reason: str
    expected: float = NAN
    tolerance: float = NAN
    limit: float = NAN
    observed: float = NAN
    lower: float = NAN
    upper: float = NAN
    constant: float = NAN
    scatter: float = NAN
    error: float = NAN
    model: str = ""
    next_run: str = ""
    tau: tuple[float, ...] = ()
    vertices: tuple[int, ...] = ()
    masked: tuple[Masked, ...] = ()

    def error_at(self, s: float) -> float:
        """The fitted error at h or tau = s."""
        return self.constant * s**self.observed
