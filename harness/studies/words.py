"""Studies and flows in words: what was run, and what errors are."""

from collections.abc import Callable
from typing import Any, NamedTuple

from esfem.schemes import SchemeOptions
from esfem.studies.case import Law
from esfem.studies.quantities import norm
from esfem.studies.study import Study

PROJECTIONS = {True: "on", False: "off", "nu": "of nu alone"}
# Of a scheme, as far as it has them; the rest is told if it is unusual.
OPTIONS: dict[str, Callable[[Any], str]] = {
    "bdf": lambda order: f"BDF{order}",
    "project": lambda which: f"projection {PROJECTIONS[which]}",
    "theta": lambda on: f"theta {'on' if on else 'off'}",
    "reaction": lambda how: f"reaction {how}",
}
ALWAYS_TOLD = ("name", "degree", *OPTIONS)


class Words(NamedTuple):
    """A study in words: the case in one line, its scheme with the options, what its errors are."""

    case: str
    scheme: str
    errors: str


def words(study: Study) -> Words:
    """The study in words."""
    return Words(describe(study), ", ".join(options(study.scheme)), norms(study))


def norms(study: Study) -> str:
    """What the errors in the tables are, in words."""
    shown: dict[str, list[str]] = {}
    for name in study.variables:
        shown.setdefault(norm(name, study.initial), []).append(name)
    return "; ".join(f"{', '.join(names)}: {words}" for words, names in shown.items())


def describe(study: Study) -> str:
    """The case in one line: solution, law, scheme, final time."""
    return (
        f"solution {named(study.solution.name, study.solution.parameters)}, "
        f"{asked(study.law, study.scheme)}"
        f"{study.sweep.said_of_first_steps(study.scheme.order)}, T = {study.sweep.final_time:g}"
    )


def asked(law: Law, scheme: SchemeOptions) -> str:
    """What is solved and how, of a study as of a flow: the law, and the scheme with its options."""
    return f"law {named(law.name, law.parameters)}, scheme {', '.join(options(scheme))}"


def named(name: str, parameters: dict[str, Any]) -> str:
    """A name with its parameters, if there are any: "torus (R = 1, r = 0.6)"."""
    values = ", ".join(f"{key} = {_value(value)}" for key, value in parameters.items())
    return f"{name} ({values})" if values else name


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return value if isinstance(value, str) else f"{value:g}"


def options(scheme: SchemeOptions) -> list[str]:
    """The name and the options of a scheme, as far as it has them."""
    found, values = [f"{scheme.name}: P{scheme.degree}"], dict(scheme)
    found += [word(values[name]) for name, word in OPTIONS.items() if name in values]
    for name, field in type(scheme).model_fields.items():
        if name not in ALWAYS_TOLD and values[name] != field.default:
            found.append(f"{name} {values[name]}")
    return found
