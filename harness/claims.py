"""Claims as data: what is expected, from which source, and under which assumptions."""

import tomllib
from functools import lru_cache
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, model_validator

from harness.case import SchemeOptions
from harness.quantities import QUANTITIES

CLAIMS_FILE = Path(__file__).with_name("claims.toml")


class Claim(BaseModel):
    """One line of the claims table.

    ``order`` is a number, "k" for the polynomial degree, or "q" for the order of the BDF method of
    the study; ``direction`` is what tends to zero; the observed order may fall short of it by
    ``tolerance``. A claim with a ``limit`` instead bounds the error of the finest run, and asks
    that the errors fall if it ``converges``; otherwise it bounds those of all judged runs. An order
    is ``sharp`` if more than it, and ``tolerance``, is impossible, and a bug of the measurement.
    It is about these ``schemes``, with this ``velocity`` if one is named.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    statement: str
    source: str
    norm: str
    variables: tuple[str, ...]
    direction: Literal["h", "tau"]
    order: float | Literal["k", "q"] | None = None
    tolerance: float = 0.0
    sharp: bool = False
    limit: float | None = None
    converges: bool = True
    degrees: tuple[int, ...]
    needs_theta: bool
    schemes: tuple[str, ...] = ("kll",)
    velocity: str | None = None

    def expected_order(self, degree: int, bdf: int) -> float:
        """The order that is claimed for P_k elements and order q in time; NaN if none is."""
        if self.order is None:
            return float("nan")
        return float({"k": degree, "q": bdf}.get(self.order, self.order))

    @model_validator(mode="after")
    def _one_kind(self) -> "Claim":
        if (self.order is None) == (self.limit is None):
            raise ValueError(f"claim {self.name!r}: must have an order or a limit, and not both")
        if self.sharp and self.order is None:
            raise ValueError(f"claim {self.name!r}: sharp = true needs an order")
        unknown = [v for v in self.variables if v not in QUANTITIES]
        if unknown:
            raise ValueError(f"variables = {unknown}: must be among {', '.join(QUANTITIES)}")
        return self

    def objection(self, scheme: SchemeOptions) -> str | None:
        """Why the claim says nothing about such a scheme, or None."""
        if scheme.name not in self.schemes:
            return f"is made for scheme {', '.join(self.schemes)}, not for {scheme.name}"
        if scheme.degree not in self.degrees:
            return (
                f"is made for degree {', '.join(map(str, self.degrees))}, not for {scheme.degree}"
            )
        if self.needs_theta and not scheme.theta:
            return "is made for theta = true only"
        if self.velocity is not None and scheme.velocity != self.velocity:
            return f"is made for velocity = {self.velocity!r} only"
        return None


@lru_cache
def claims() -> dict[str, Claim]:
    """All claims by name."""
    table = tomllib.loads(CLAIMS_FILE.read_text(encoding="utf-8"))
    return {name: Claim(name=name, **entry) for name, entry in table.items()}
