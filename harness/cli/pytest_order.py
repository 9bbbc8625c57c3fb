"""What the fixture ``esfem_order`` of pytest calls: whether an order of convergence is there."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike
from rich.console import Console

from esfem.cli.judge_options import parsed_levels, positive
from esfem.cli.judgement_output import headline, rows, show_judgements
from esfem.cli.series import LEVELS_MIN, Array, Claim, Judged, Series, judged
from esfem.common.bad_input import BadInput
from esfem.judging import Floor
from esfem.judging.floors import FloorName
from esfem.judging.outcome import Outcome
from esfem.judging.validate import Direction
from esfem.results.run_studies import run_studies
from esfem.results.study_result import StudyResult
from esfem.results.tables import print_result
from esfem.studies.study import Study

GREEN = ("pass", "super")
WIDTH = 120  # columns of a message

Floors = Mapping[str, float] | Sequence[Floor]


@dataclass(frozen=True)
class Guarded:
    """What was found of one claim: the outcome, a line that says why, all there is to say of it,
    and the cells of the session's summary: claim, order and interval."""

    outcome: Outcome
    line: str
    told: str
    cells: tuple[str, ...]

    @property
    def met(self) -> bool:
        """Whether the claim is met."""
        return self.outcome in GREEN


def guard_table(
    h: ArrayLike,
    errors: ArrayLike,
    order: float,
    *,
    tau: ArrayLike | None = None,
    direction: Direction | None = None,
    tolerance: float = 0.2,
    other_order: float | None = None,
    at_least: bool = False,
    floors: Floors = (),
    steady: bool = False,
    levels: str = ":",
    levels_min: int = LEVELS_MIN,
    stationary: bool = False,
    declared_super: bool = False,
) -> Guarded:
    """What the judge says of a claimed order.

    Parameters
    ----------
    h, errors, tau : one entry a run; h or tau may be one number for all of them.
    order : the claimed order in ``direction``.
    direction : "h", or "tau"; by default h, or tau if it alone changes.
    tolerance : of the order.
    other_order : the order in the other parameter, where it is known.
    at_least : a higher order is expected, and passes.
    floors : by name, what errors cannot fall below: ``{"rounding": 1e-14}``.
    steady : the solution does not move, so that there is no error in time.
    levels : those to judge, such as "3:"; 1 is the coarsest.
    levels_min : judge so few levels, 3 at least.
    stationary, declared_super : ``steady`` and ``at_least``, as `judge_table` calls them.

    Raises
    ------
    BadInput
        If they make no table that can be judged.
    """
    if direction not in (None, "h", "tau"):
        raise BadInput(f"direction = {direction!r}: must be 'h' or 'tau'")
    for name, value in (("order", order), ("tolerance", tolerance)):
        positive(name, str(value), f"= {value!r}")
    if other_order is not None:
        positive("other_order", str(other_order), f"= {other_order!r}")
    if not isinstance(levels, str):
        raise BadInput(f"levels = {levels!r}: must be text, such as '3:'")
    if not (isinstance(levels_min, int | np.integer) and levels_min >= 3):
        raise BadInput(f"levels_min = {levels_min!r}: must be a whole number, 3 at least")
    claim = Claim(
        order=float(order),
        direction=direction,
        tolerance=float(tolerance),
        other_order=None if other_order is None else float(other_order),
        at_least=at_least or declared_super,
        steady=steady or stationary,
        floors=_floors(floors),
        levels=parsed_levels(levels),
        levels_min=levels_min,
    )
    return _guarded(judged(_series(h, errors, tau), claim))


def guard_study(study: Study | Path | str, *, out: Path | str, jobs: int = 1) -> Guarded:
    """What the verdicts on a study say of its claims.

    A study that judges nothing, for want of a claim or because it exercises none, meets nothing.

    Parameters
    ----------
    study : name of a committed study, a study file, or a Study.
    out : results go to ``out/<name of the study>``, and what is stored there is not repeated.
    jobs : number of processes.

    Raises
    ------
    BadInput
        If there is no such study, or it cannot be run.
    """
    result = run_studies([study], out, jobs=jobs)[0]
    said, console = _console()
    print_result(result, console)
    line = _study_line(result)
    cells = (result.study.name, "", "")
    return Guarded(result.outcome, line, f"{line}\n{said.getvalue()}", cells)


def _study_line(result: StudyResult) -> str:
    """Verdict, and the variables whose verdicts are not green, with reasons."""
    bad = [v for v in result.verdicts if v.verdict not in (*GREEN, "no claim", "not exercised")]
    found = bad or result.verdicts
    why = "; ".join(
        f"{v.variable} {v.verdict.upper()}" + (f": {v.reason}" if v.reason else "") for v in found
    )
    return f"{result.outcome.upper()}: study {result.study.name}: {why}"


def _floors(floors: Floors) -> tuple[Floor, ...]:
    if not isinstance(floors, Mapping):
        return tuple(floors)
    known: dict[str, Any] = dict(floors)
    names = get_args(FloorName)
    strange = [name for name in known if name not in names]
    if strange:
        raise BadInput(f"floors = {known!r}: names must be of {', '.join(names)}")
    try:
        return tuple(Floor(name, value) for name, value in known.items())  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise BadInput(f"floors = {known!r}: {error}") from error


def _series(h: ArrayLike, errors: ArrayLike, tau: ArrayLike | None) -> Series:
    """The runs, as long as the longest of these columns."""
    columns = {"h": h, "errors": errors} | ({} if tau is None else {"tau": tau})
    known = {name: _numbers(name, column) for name, column in columns.items()}
    try:
        shaped = dict(zip(known, np.broadcast_arrays(*known.values()), strict=True))
    except ValueError as error:
        shapes = ", ".join(f"{name} {column.shape}" for name, column in known.items())
        raise BadInput(f"h, errors and tau must be as long as each other, not {shapes}") from error
    if shaped["errors"].ndim != 1:
        raise BadInput(f"errors: must be one number a run, not of shape {shaped['errors'].shape}")
    n = len(shaped["errors"])
    if n == 0:
        raise BadInput("errors: there are none")
    return Series(
        name="",
        h=shaped["h"],
        tau=shaped.get("tau"),
        error=shaped["errors"],
        status=("ok",) * n,
        places=tuple(f"run {i + 1}" for i in range(n)),
    )


def _numbers(name: str, column: ArrayLike) -> Array:
    """A column as numbers: of Decimal, Fraction, text or whatever float takes."""
    try:
        cells = np.asarray(column, dtype=object)
        return np.array([float(cell) for cell in cells.ravel()]).reshape(cells.shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise BadInput(f"{name}: must be numbers: {error}") from error


def _guarded(one: Judged) -> Guarded:
    said, console = _console()
    show_judgements(headline(one), [one], console)
    columns = {"h": one.series.h, "tau": one.series.tau, "error": one.series.error}
    shown = {name: values for name, values in columns.items() if values is not None}
    console.print("  ".join(f"{name:>12}" for name in shown))
    for cells in zip(*shown.values(), strict=True):
        console.print("  ".join(f"{cell:12.6g}" for cell in cells))
    _, _, claim, order, interval, *_ = rows([one])[0]
    return Guarded(one.judgement.outcome, headline(one), said.getvalue(), (claim, order, interval))


def _console() -> tuple[io.StringIO, Console]:
    """A console that writes plain text, and where to."""
    said = io.StringIO()
    return said, Console(file=said, width=WIDTH, markup=False, emoji=False, highlight=False)
