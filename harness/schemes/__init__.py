"""Schemes: what one is to the harness, and all of them by name.

Each file here is a scheme and is found by itself. The file ``my_scheme.py`` defines ``SCHEME``, a
`Plugin`, and is the scheme "my-scheme"; README tells how. None is imported before it is asked for.

A scheme is given by its start, its step, and what it offers. A step gets the last `Level`s and
gives the next one; of that only t and x must be there. What a level lacks of a State is recovered
from it (`esfem.runs.stepping`), and marked as recovered in the tables.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from typing import Annotated, Any, Literal

from pydantic import Field

from esfem.common.input import Section
from esfem.solver import LAWS, Levels, Mesh, State
from esfem.solver.laws import AnyLaw, mean_curvature
from esfem.solver.reference_element import Array

DEFAULT_SCHEME = "kll"
OFFERS = ("x", "nu", "H", "V", "z", "v")
# V = Lap H + Q, and the law of second order.
ALL_LAWS = {**LAWS, "mean_curvature": mean_curvature}


class SchemeOptions(Section):
    """[scheme]: what every scheme takes; the options of a scheme are a class that extends it.

    What others ask of any scheme is declared here, and answered for one that has no such option.
    """

    name: str
    degree: Annotated[int, Field(ge=1, le=4)]
    quadrature: Annotated[int, Field(ge=1, le=30)] | None = None  # exactness; 2k + 2 if None

    @property
    def exactness(self) -> int:
        """The degree to which quadrature in the assembly is exact."""
        return 2 * self.degree + 2 if self.quadrature is None else self.quadrature

    def iterates(self, exact_start: bool) -> bool:
        """Whether some step iterates, so that its tolerance is part of the error; the first levels
        of a multistep method may be given by an exact solution."""
        return False

    def objection(self, exact_start: bool) -> str | None:
        """Why the options do not go together in such a run, or None."""
        return None

    @property
    def order(self) -> int:
        """The order in time: that of the BDF, where the scheme has one, else 1."""
        return 1

    @property
    def first_levels(self) -> Literal["exact", "self"] | None:
        """Where the first levels of a multistep method come from, if the options say so."""
        return None

    @property
    def solved_to(self) -> float:
        """The tolerance of what iterates; 0 if nothing does."""
        return 0.0


class BDFOptions(SchemeOptions):
    """[scheme] of a scheme that takes its steps by BDF."""

    bdf: Annotated[int, Field(ge=1, le=5)]
    start: Literal["exact", "self"] | None = None  # exact if the solution is known at all times

    @cached_property
    def order(self) -> int:
        """That of the BDF."""
        return self.bdf

    @cached_property
    def first_levels(self) -> Literal["exact", "self"] | None:
        """``start``."""
        return self.start


@dataclass(frozen=True)
class Problem:
    """What is to be solved.

    Attributes
    ----------
    mesh : the P_k mesh.
    initial : the exact nodal x, nu, H, V, z at t = 0.
    law : Q(H, S2, x, t) of V = Lap H + Q, forcing included; None for mean curvature flow.
    forcing : f(x, t) of V = Lap H + Q + f, or None.
    tau : the time step to the level that is asked for.
    options : the table [scheme] of the study, in the class that the scheme names.
    exact : the exact State at a time, where the first levels of a run shall be exact; or None.
    """

    mesh: Mesh
    initial: State
    law: AnyLaw | None
    forcing: Callable[[Array, float], Array] | None
    tau: float
    options: SchemeOptions
    exact: Callable[[float], State] | None = None


@dataclass(frozen=True)
class Level:
    """What a scheme knows at time t.

    Nodal x, nu, z, v (N, 3) and H, V (N,), None where the scheme has none; ``memory`` is what else
    its next step needs, and the harness does not look at it.
    """

    t: float
    x: Array
    nu: Array | None = None
    H: Array | None = None
    V: Array | None = None
    z: Array | None = None
    v: Array | None = None
    memory: Any = None


# All States of a problem at these time levels; and of an interrupted run the last States, newest
# first, after which it goes on.
Run = Callable[[Problem, Levels, Sequence[State]], Iterator[State]]


def exact_start(problem: Problem) -> Level:
    """The initial State as it is."""
    s = problem.initial
    return Level(s.t, s.x, s.nu, s.H, s.V, s.z, s.v)


def one_level(options: SchemeOptions) -> int:
    """A one-step method."""
    return 1


@dataclass(frozen=True)
class Plugin:
    """A scheme.

    Attributes
    ----------
    title : one line.
    laws : the names of the laws that it solves.
    offers : the quantities of its levels, among `OFFERS`; x is one of them.
    step : takes the problem, the last levels, newest first, and t to the level at t. Any
        ArithmeticError, RuntimeError or LinAlgError ends the run as a failure of the solver.
    start : the level at t = 0.
    options : what [scheme] may hold, an extension of `SchemeOptions`.
    remembers : how many of the last levels a step is given, from the options, all at distances of
        its own size; near the start there are fewer.
    substeps : its first steps can be made of substeps: it starts itself wherever it is given fewer
        levels than it remembers, and takes its step from the problem.
    slides : its nodes move along the surface too: errors are those of the shape, not of the nodes.
    energy : the discrete Willmore energy of a level, where a scheme that is given by its step has
        one of its own, for `esfem schemes`; records of studies always have the energy of the law
        and 1/2 int H^2, of the H that is offered or recovered.
    run : all States of a problem, for a scheme with a loop of its own, in place of step and start.
        Such a run can be resumed.

    Raises
    ------
    ValueError
        If neither step nor run is given, or both are, or run and energy; or an offer or a law is
        not known.
    """

    title: str
    laws: tuple[str, ...]
    offers: tuple[str, ...]
    step: Callable[[Problem, Sequence[Level], float], Level] | None = None
    start: Callable[[Problem], Level] = exact_start
    options: type[SchemeOptions] = SchemeOptions
    remembers: Callable[[Any], int] = one_level
    substeps: bool = False
    slides: bool = False
    energy: Callable[[Problem, Level], float] | None = None
    run: Run | None = None

    def __post_init__(self) -> None:
        if (self.step is None) == (self.run is None):
            raise ValueError("step: a scheme must have a step or a run, and not both")
        if self.run is not None and self.energy is not None:
            raise ValueError("energy: must not be given with run, which has States and no levels")
        unknown = [name for name in self.offers if name not in OFFERS]
        if unknown or "x" not in self.offers:
            raise ValueError(
                f"offers = {self.offers!r}: must be x and others of {', '.join(OFFERS)}"
            )

        strange = [name for name in self.laws if name not in ALL_LAWS]
        if strange or not self.laws:
            raise ValueError(f"laws = {self.laws!r}: must be among {', '.join(ALL_LAWS)}")

    @property
    def recovered(self) -> tuple[str, ...]:
        """What the harness recovers."""
        return tuple(name for name in OFFERS if name not in self.offers)


def scheme_names() -> tuple[str, ...]:
    """The names of all schemes, sorted: those of their files, with - for _."""
    return tuple(sorted(module.name.replace("_", "-") for module in iter_modules(__path__)))


@cache
def named_scheme(name: str) -> Plugin:
    """The scheme of that name.

    Raises
    ------
    ValueError
        If there is none, or its file defines no ``SCHEME``.
    """
    if name not in scheme_names():
        raise ValueError(f"scheme = {name!r}: must be one of {', '.join(scheme_names())}")
    scheme = getattr(import_module(_module(name)), "SCHEME", None)
    if not isinstance(scheme, Plugin):
        raise ValueError(f"scheme {name!r}: its file must define SCHEME, a esfem.schemes.Plugin")
    return scheme


def scheme_file(name: str) -> Path:
    """The file of a scheme."""
    spec = find_spec(_module(name))
    assert spec is not None and spec.origin is not None, name
    return Path(spec.origin)


def _module(name: str) -> str:
    return f"{__name__}.{name.replace('-', '_')}"
