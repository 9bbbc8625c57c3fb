"""What the fixture ``esfem_order`` of pytest calls: why an order of convergence is not there."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from rich.console import Console

from esfem.cli.judge import show_judgements
from esfem.common.bad_input import BadInput
from esfem.judging import judge_table
from esfem.judging.validate import Direction
from esfem.results.run_studies import run_studies
from esfem.results.tables import print_result
from esfem.studies.study import Study

GREEN = ("pass", "super")
WIDTH = 120  # columns of a message


def guard_table(
    h: ArrayLike,
    errors: ArrayLike,
    order: float,
    *,
    tau: ArrayLike | None = None,
    direction: Direction = "h",
    tolerance: float = 0.2,
    **options: Any,
) -> str:
    """What speaks against the claimed order, with the judge's table; "" if it is met.

    Parameters
    ----------
    h, errors, tau : one entry a run; h or tau may be one number for all of them.
    order : the claimed order in ``direction``, "h" or "tau".
    tolerance : of the order.
    options : of `esfem.judging.judge_table`, such as ``declared_super=True``.

    Raises
    ------
    BadInput
        If they make no table that can be judged.
    """
    if direction not in ("h", "tau"):
        raise BadInput(f"direction = {direction!r}: must be 'h' or 'tau'")
    for name, value in (("order", order), ("tolerance", tolerance)):
        if not (np.isfinite(value) and value > 0):
            raise BadInput(f"{name} = {value!r}: must be positive and finite")
    columns = {"h": h, "error": errors} | ({} if tau is None else {"tau": tau})
    shaped = {name: np.asarray(column) for name, column in columns.items()}
    try:
        table = pd.DataFrame(dict(zip(shaped, np.broadcast_arrays(*shaped.values()), strict=True)))
    except ValueError as error:
        shapes = ", ".join(f"{name} {column.shape}" for name, column in shaped.items())
        raise BadInput(f"h, errors and tau must be as long as each other, not {shapes}") from error
    judgement = judge_table(table, order, direction=direction, tolerance=tolerance, **options)
    if judgement.outcome in GREEN:
        return ""
    said, console = _console()
    show_judgements("esfem_order", {"": judgement}, order, direction, tolerance, console)
    console.print(table.to_string(index=False))
    return said.getvalue()


def guard_study(study: Study | Path | str, *, out: Path | str, jobs: int = 1) -> str:
    """What speaks against the claims of a study, with its tables; "" if all are met.

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
    if result.outcome in GREEN:
        return ""
    said, console = _console()
    print_result(result, console)
    return said.getvalue()


def _console() -> tuple[io.StringIO, Console]:
    """A console that writes plain text, and where to."""
    said = io.StringIO()
    return said, Console(file=said, width=WIDTH, markup=False, emoji=False, highlight=False)
