"""Which schemes are compared, on which surfaces and meshes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.schemes import named_scheme, scheme_names
from esfem.studies.case import Case

Options = Mapping[str, Any]

# By the word that tables show: the options beside the degree. The first ones stand for their
# scheme in figures and sentences; the others are variants of kll.
PRINCIPAL: dict[str, Options] = {
    "kll": {"name": "kll", "bdf": 1, "project": True, "theta": False},
    "kll, theta": {"name": "kll", "bdf": 1, "project": True, "theta": True},
    "dziuk": {"name": "dziuk"},
    "bgn": {"name": "bgn"},
}
VARIANTS: dict[str, Options] = {
    "kll, theta, nu alone projected": {**PRINCIPAL["kll, theta"], "project": "nu"},
    "kll, theta, not projected": {**PRINCIPAL["kll, theta"], "project": False},
    "kll, theta, Ritz velocity": {**PRINCIPAL["kll, theta"], "velocity": "ritz"},
    "kll, theta, BDF2": {**PRINCIPAL["kll, theta"], "bdf": 2},
    "kll, theta, extrapolated": {**PRINCIPAL["kll, theta"], "reaction": "extrapolated"},
    "kll, theta, linearised": {**PRINCIPAL["kll, theta"], "reaction": "linearised"},
}
LAW = "willmore"
ON_AXIS = {"name": "surface", "reference": "axisymmetric"}
GROUNDS: dict[str, dict[str, Any]] = {
    "sphere": {"name": "sphere"},
    "Clifford torus": {"name": "clifford_torus"},
    "1 + 0.2 P2 sphere": {**ON_AXIS, "surface": "p2_sphere"},
    "red blood cell": {**ON_AXIS, "surface": "red_blood_cell"},
    "ellipsoid 2:1:1": {**ON_AXIS, "surface": "ellipsoid"},
}


@dataclass(frozen=True)
class Sizes:
    """Meshes, steps and times of the parts of the contest: of the large table, of the largest
    stable tau, of the figure of costs, of the long flow, of orders and decay rates, of the costs.
    """

    V: int = 240
    tau: float = 2.5e-4
    time: float = 0.05
    V_stable: int = 120
    ladder: tuple[int, ...] = (60, 120, 240, 480)
    long_V: int = 120
    long_tau: float = 0.005
    long_time: float = 2.0
    degrees: tuple[int, ...] = (1, 2, 3)
    order_V: tuple[int, ...] = (30, 60, 120, 240, 480)
    order_tau: float = 1.25e-4
    order_time: float = 2.5e-3
    decay_V: tuple[int, ...] = (30, 60, 120, 240)
    decay_tau: float = 5e-4
    decay_time: float = 0.01
    decay_amplitude: float = 1e-3
    cost_V: int = 960  # a sphere whose P_2 mesh has 3834 nodes
    cost_tau: float = 1e-4
    cost_steps: int = 8


@dataclass(frozen=True)
class Contest:
    """Who competes, on which ``grounds`` and meshes, in how many processes, and who is told;
    ``folder`` is where extras go. The ``variants`` of kll are in the tables, not in the figures."""

    folder: Path
    console: Console
    jobs: int = 1
    entrants: Mapping[str, Options] = field(default_factory=lambda: PRINCIPAL)
    variants: Mapping[str, Options] = field(default_factory=lambda: VARIANTS)
    grounds: Sequence[str] = tuple(GROUNDS)
    sizes: Sizes = Sizes()

    @property
    def everyone(self) -> dict[str, Options]:
        """The entrants with the variants of kll."""
        return {**self.entrants, **self.variants}


def principal(further: Sequence[str] = ()) -> dict[str, Options]:
    """The entrants of figures and sentences, with the schemes of these names at their defaults.

    Raises
    ------
    BadInput
        If there is no such scheme, it does not solve Willmore flow, or it has no defaults.
    """
    able = [name for name in scheme_names() if LAW in named_scheme(name).laws]
    entrants = dict(PRINCIPAL)
    for name in further:
        if name not in able:
            raise BadInput(f"--scheme {name}: must be one of {', '.join(able)}")
        entrants.setdefault(name, {"name": name})
        try:
            case_of(entrants[name], GROUNDS["sphere"], 30, 1.0, 1.0)
        except ValidationError as error:
            why = "; ".join(e["msg"].removeprefix("Value error, ") for e in error.errors())
            raise BadInput(f"--scheme {name}: cannot run with its defaults: {why}") from error
    return entrants


def case_of(
    options: Options, solution: dict[str, Any], V: int, tau: float, T: float, degree: int = 2
) -> Case:
    """The case of an entrant of the contest."""
    return Case.model_validate(
        {
            "solution": solution,
            "law": {"name": LAW},
            "scheme": {**options, "degree": degree},
            "vertices": V,
            "tau": tau,
            "final_time": T,
            "compare_at": (T,) if solution["name"] == "surface" else (),
        }
    )
