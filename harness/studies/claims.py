"""Claims as data: what is expected, from which source, and for what studies the source speaks."""

import tomllib
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from esfem.reference_solutions import decays
from esfem.studies.case import Setup
from esfem.studies.quantities import QUANTITIES

Direction = Literal["h", "tau"]  # what tends to zero
LOOSEST = 1e-8  # hundred times the default: its part of an error is measured as a floor
CLAIMS_FILE = Path(__file__).parent / "theory" / "claims.toml"


T = TypeVar("T")
Values = Annotated[tuple[T, ...], Field(min_length=1)]  # those that are allowed


class Range(BaseModel):
    """A range that a source covers: of each key the values that it allows.

    A key that is left out, or None, is not restricted. ``forced`` says whether the solution solves
    the law with a forcing; ``amplitude`` bounds that of a perturbation, relative to the size of
    the surface; the other keys are names, and options of the scheme.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    # From the coarse to the fine: the first misfit of a study is the one that it is told.
    scheme: Values[str] = ("kll",)
    law: Values[str]
    solution: Values[str] | None = None
    forced: Values[bool] = (False,)
    amplitude: float | None = None
    degree: Values[int]
    bdf: Values[int] | None = None
    theta: Values[bool] | None = None
    project: Values[bool | Literal["nu"]] | None = None
    velocity: Values[str] | None = None
    reaction: Values[str] | None = None

    def restricted(self) -> dict[str, Any]:
        """The keys that are restricted, in their order, and to what."""
        found = {key: getattr(self, key) for key in type(self).model_fields}
        return {key: allowed for key, allowed in found.items() if allowed is not None}

    def misfit(self, setup: Setup) -> str | None:
        """The first key whose value is not allowed; None if the range covers the setup."""
        for key, allowed in self.restricted().items():
            value = value_of(setup, key)
            if key == "amplitude":
                if value is None or not value <= allowed:
                    return key
            elif value not in allowed:
                return key
        return None

    def told(self, setup: Setup, key: str) -> str:
        """What of that key is allowed, and what the setup has."""
        allowed, value = getattr(self, key), _word(value_of(setup, key))
        if key == "amplitude":
            return f"{key} = {allowed:g} at most, not for {value}"
        return f"{key} = {_either(allowed)}, not for {value}"


class Claim(BaseModel):
    """One line of the claims table.

    ``order`` is a number, "k" for the polynomial degree, or "q" for the order of the BDF method of
    the study; ``direction`` is what tends to zero; the observed order may fall short of it by
    ``tolerance``. An order is ``sharp`` if more than it, and ``tolerance``, is impossible, a bug of
    the measurement: of u_h - u alone, for u_h - I_h u may fall faster. A ``limit`` beside an order
    bounds the error of the finest judged run, and both must hold; it may be a table, of the
    variables that it bounds. A limit alone does so too, and asks that the errors fall if the claim
    ``converges``; otherwise it bounds those of all judged runs. Norms in H^1 are those of the
    ``length`` that the source takes for 1; without one, of the unit of length of the solution.

    ``about`` is what the source speaks of: a scheme discrete in space alone ("semi"), whose claims
    hold for every small tau and restrict no BDF; one discrete in time too ("full"), whose claims
    name their BDF orders; or the "flow" itself. A study must lie in one of the ranges it
    ``covers``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    statement: str
    source: str
    norm: str
    about: Literal["semi", "full", "flow"]
    variables: tuple[str, ...]
    direction: Direction
    order: float | Literal["k", "q"] | None = None
    tolerance: float = 0.0
    sharp: bool = False
    length: float | None = None
    limit: float | dict[str, float] | None = None
    converges: bool = True
    covers: Annotated[tuple[Range, ...], Field(min_length=1)]

    def expected_order(self, degree: int, bdf: int) -> float:
        """The order that is claimed for P_k elements and order q in time; NaN if none is."""
        if self.order is None:
            return float("nan")
        orders = {"k": degree, "q": bdf}
        return float(orders[self.order] if isinstance(self.order, str) else self.order)

    def limit_of(self, variable: str) -> float | None:
        """The bound on the error of a variable; None if there is none."""
        return self.limit.get(variable) if isinstance(self.limit, dict) else self.limit

    @model_validator(mode="after")
    def _one_kind(self) -> "Claim":
        if self.order is None and self.limit is None:
            raise ValueError(f"claim {self.name!r}: must have an order, a limit, or both")
        if self.sharp and self.order is None:
            raise ValueError(f"claim {self.name!r}: sharp = true needs an order")
        if self.length is not None and not 0.0 < self.length < float("inf"):
            raise ValueError(f"claim {self.name!r}: length = {self.length:g}: must be positive")
        if not self.converges and self.order is not None:
            raise ValueError(f"claim {self.name!r}: converges = false is for a limit alone")
        if isinstance(self.limit, dict):
            foreign = sorted(self.limit.keys() - set(self.variables))
            free = sorted(set(self.variables) - self.limit.keys()) if self.order is None else []
            if foreign or free:
                raise ValueError(
                    f"claim {self.name!r}: limit must be of its variables, and of all "
                    f"of them without an order; unknown: {foreign}, without: {free}"
                )
        unknown = [v for v in self.variables if v not in QUANTITIES]
        if unknown:
            raise ValueError(f"variables = {unknown}: must be among {', '.join(QUANTITIES)}")
        return self

    @model_validator(mode="after")
    def _speaks_of_time(self) -> "Claim":
        named = [covered.bdf is not None for covered in self.covers]
        if self.about == "full" and not all(named):
            raise ValueError(f"claim {self.name!r}: about = 'full' must name bdf in every range")
        if self.about != "full" and any(named):
            raise ValueError(f"claim {self.name!r}: bdf is for about = 'full', not {self.about!r}")
        if self.about != "full" and self.direction == "tau":
            raise ValueError(f"claim {self.name!r}: direction = 'tau' needs about = 'full'")
        return self

    def objection(self, setup: Setup) -> str | None:
        """Why the claim says nothing about such a setup, or None.

        Of several ranges the one that fits farthest is told. No source speaks of integrals or
        systems that are solved less exactly than by default: a quadrature below 2k + 2, a tolerance
        above `LOOSEST`.
        """
        exact = 2 * setup.scheme.degree + 2
        if setup.scheme.exactness < exact:
            return f"is made for quadrature = {exact} at least, not for {setup.scheme.exactness}"
        if setup.scheme.solved_to > LOOSEST:
            tolerance = f"{setup.scheme.solved_to:g}"
            return f"is made for tolerance = {LOOSEST:g} at most, not for {tolerance}"
        misfits = {}
        for covered in reversed(self.covers):
            misfit = covered.misfit(setup)
            if misfit is None:
                return None
            misfits[misfit] = covered
        farthest = max(misfits, key=list(Range.model_fields).index)
        return f"is made for {misfits[farthest].told(setup, farthest)}"


def value_of(setup: Setup, key: str) -> Any:
    """What a setup has for a key of `Range`; None if it has no such thing."""
    match key:
        case "scheme":
            return setup.scheme.name
        case "law":
            return setup.law.name
        case "solution":
            return setup.solution.name
        case "forced":
            return setup.forced
        case "amplitude":
            return setup.initial.relative_amplitude if decays(setup.initial) else None
    return dict(setup.scheme).get(key)


@lru_cache
def claims() -> dict[str, Claim]:
    """All claims by name."""
    table = tomllib.loads(CLAIMS_FILE.read_text(encoding="utf-8"))
    return {name: Claim(name=name, **entry) for name, entry in table.items()}


def covering(names: Iterable[str], setup: Setup) -> Claim | None:
    """The first of the named claims that covers the setup; None if none does."""
    return next((c for c in map(claims().__getitem__, names) if c.objection(setup) is None), None)


def _either(values: Iterable[Any]) -> str:
    """For example "2, 3 or 4"."""
    *most, last = map(_word, values)
    return f"{', '.join(most)} or {last}" if most else last


def _word(value: Any) -> str:
    """A value as a study file writes it, without quotes; "none" for what is not there."""
    if value is None:
        return "none"
    return str(value).lower() if isinstance(value, bool) else f"{value}"
