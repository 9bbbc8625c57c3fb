"""Which schemes are compared, and on which surfaces."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from harness.bad_input import BadInput
from harness.case import Case
from harness.schemes import named_scheme, scheme_names

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
