"""Claims as data: what is expected, from which source, and under which assumptions."""

import tomllib
from functools import lru_cache
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict

CLAIMS_FILE = Path(__file__).with_name("claims.toml")


class Claim(BaseModel):
    """One line of the claims table.

    ``order`` is a number, "k" for the polynomial degree, or "q" for the order of the BDF method of
    the study; ``direction`` is what tends to zero; the observed order may fall short of it by
    ``tolerance``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    statement: str
    source: str
    norm: str
    variables: tuple[Literal["x", "nu", "H", "V", "z", "v"], ...]
    direction: Literal["h", "tau"]
    order: float | Literal["k", "q"]
    tolerance: float
    degrees: tuple[int, ...]
    needs_theta: bool

    def expected_order(self, degree: int, bdf: int) -> float:
        """The order that is claimed for P_k elements and BDF q."""
        return float({"k": degree, "q": bdf}.get(self.order, self.order))

    def objection(self, degree: int, theta: bool) -> str | None:
        """Why the claim says nothing about such a scheme, or None."""
        if degree not in self.degrees:
            return f"is made for degree {', '.join(map(str, self.degrees))}, not for {degree}"
        if self.needs_theta and not theta:
            return "is made for theta = true only"
        return None


@lru_cache
def claims() -> dict[str, Claim]:
    """All claims by name."""
    table = tomllib.loads(CLAIMS_FILE.read_text(encoding="utf-8"))
    return {name: Claim(name=name, **entry) for name, entry in table.items()}
