"""Studies, verdicts and flows in words: what was run, what errors are, why a verdict."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness.case import Law
from harness.energies import ROUNDING
from harness.floors import floor_lines
from harness.quantities import norm
from harness.schemes import SchemeOptions, named_scheme
from harness.selection import exclusions
from harness.study import Study
from harness.verdict import Verdict

if TYPE_CHECKING:
    from harness.flows.flow_file import FlowFile

ALWAYS_TOLD = (
    "name",
    "degree",
    "bdf",
    "project",
    "theta",
    "reaction",
)  # of a scheme; the rest if unusual
PROJECTIONS = {True: "on", False: "off", "nu": "of nu alone"}


def remarks(
    study: Study, records: pd.DataFrame, floors: pd.DataFrame, verdicts: list[Verdict]
) -> list[str]:
    """What explains the verdicts: reasons, next runs, masked runs, floors, what was not judged."""
    return [
        *reasons(verdicts),
        *(f"{v.variable}, next run: {v.next_run}" for v in verdicts if v.next_run),
        *masked_lines(verdicts),
        *floor_lines(floors, study.variables),
        *exclusions(study, records),
        *energy_lines(study, records),
    ]


def is_forced(study: Study) -> bool:
    """Whether the law is forced, so that its energy need not decrease."""
    solution = study.solution.initial()
    return solution.forcing(study.law.name, study.law.parameters) is not None


def energy_lines(study: Study, records: pd.DataFrame) -> list[str]:
    """Whether the energy of the law falls in the runs that ended; nothing of a table that does not
    know it."""
    energy = f"energy: {study.law.energy}"
    if is_forced(study):
        return [f"{energy}; the flow is forced, so that none need decrease, and none is checked"]
    ended = records[records["energy_rise"].notna()] if "energy_rise" in records else records[:0]
    if ended.empty:
        return []
    worst = ended.loc[ended["energy_rise"].idxmax()]
    if worst["energy_rise"] <= ROUNDING:
        return [f"{energy}; it falls in every step of the runs that ended"]
    at = f"V = {worst['vertices']}, tau = {worst['tau']:g}"
    return [f"{energy}; in a step it rises by up to {worst['energy_rise']:.1e} of its start ({at})"]


def reasons(verdicts: list[Verdict]) -> list[str]:
    """Why: a line a reason, with the variables that it holds for."""
    shown: dict[str, list[str]] = {}
    for verdict in verdicts:
        shown.setdefault(verdict.reason, []).append(verdict.variable)
    return [f"{', '.join(names)}: {reason}" for reason, names in shown.items()]


def masked_lines(verdicts: list[Verdict]) -> list[str]:
    """The runs that were masked for a floor or for the other parameter, a line a variable; those
    that stopped early are told by `harness.selection.exclusions`."""
    lines = []
    for verdict in verdicts:
        masked = [m for m in verdict.masked if m.floor or "of the error" in m.reason]
        if masked:
            runs = "; ".join(f"h = {m.h:.3g}, tau = {m.tau:g}: {m.reason}" for m in masked)
            lines.append(f"{verdict.variable} masked: {runs}")
    return lines


def norms(study: Study) -> str:
    """What the errors in the tables are, in words."""
    solution = study.solution.initial()
    shown: dict[str, list[str]] = {}
    for name in study.variables:
        shown.setdefault(norm(name, solution), []).append(name)
    return "; ".join(f"{', '.join(names)}: {words}" for words, names in shown.items())


def describe(study: Study) -> str:
    """The case in one line: solution, law, scheme, final time."""
    return (
        f"solution {named(study.solution.name, study.solution.parameters)}, "
        f"{asked(study.law, study.scheme)}"
        f"{study.sweep.said_of_first_steps(study.scheme.order)}, T = {study.sweep.final_time:g}"
    )


def describe_flow(flow: "FlowFile", nodes: int) -> str:
    """A flow on so many nodes in one line: start, law, scheme, time step, final time."""
    start, time = flow.start, flow.time
    scaled = f" (scale = {start.scale:g})" if start.scale != 1.0 else ""
    origin = (
        f"mesh {Path(start.mesh).name}{scaled}"
        if start.mesh
        else f"surface {start.surface}, V = {start.vertices}"
    )
    return (
        f"{origin}, N = {nodes}, {asked(flow.law, flow.scheme)}"
        f"{time.said_of_first_steps(flow.scheme.bdf)}, "
        f"tau = {time.tau:g}, T = {time.final_time:g}"
    )


def asked(law: Law, scheme: SchemeOptions) -> str:
    """What is solved and how, of a study as of a flow: the law, and the scheme with its options."""
    return f"law {named(law.name, law.parameters)}, scheme {', '.join(options(scheme))}"


def named(name: str, parameters: dict[str, Any]) -> str:
    """A name with its parameters, if there are any: "torus (R = 1, r = 0.6)"."""
    values = ", ".join(
        f"{key} = {value}" if isinstance(value, str) else f"{key} = {value:g}"
        for key, value in parameters.items()
    )
    return f"{name} ({values})" if values else name


def options(scheme: SchemeOptions) -> list[str]:
    """The name and the options of a scheme, as far as it has them."""
    found = [f"{scheme.name}: P{scheme.degree}"]
    if hasattr(scheme, "bdf"):
        found.append(f"BDF{scheme.bdf}")
    if hasattr(scheme, "project"):
        found.append(f"projection {PROJECTIONS[scheme.project]}")
    if hasattr(scheme, "theta"):
        found.append(f"theta {'on' if scheme.theta else 'off'}")
    if hasattr(scheme, "reaction"):
        found.append(f"reaction {scheme.reaction}")
    for name, field in type(scheme).model_fields.items():
        value = getattr(scheme, name)
        if name not in ALWAYS_TOLD and value != field.default:
            found.append(f"{name} {value}")
    return found


def headings(study: Study) -> dict[str, str]:
    """What stands above the errors of each variable: it says what was recovered, not solved for."""
    recovered = named_scheme(study.scheme.name).recovered
    found = {}
    for name in study.variables:
        marked = name in recovered or (name == "W" and "H" in recovered)
        found[name] = f"{name} (recovered)" if marked else name
    return found


def nodal_headings(study: Study, runs: pd.DataFrame) -> dict[str, str]:
    """`headings` of the errors against the interpolation; none where runs do not measure them."""
    return {name: shown for name, shown in headings(study).items() if f"nodal_{name}" in runs}


def one_line(text: str) -> str:
    """The text with every run of blanks and line ends as one blank: no line escapes a comment."""
    return " ".join(text.split())
