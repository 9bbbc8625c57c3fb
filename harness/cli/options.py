"""Options that several commands share, each declared and checked once."""

import os
from pathlib import Path
from typing import Annotated

import typer

from esfem.common.bad_input import BadInput


def _cores() -> int:
    return os.cpu_count() or 1


def _jobs(number: int) -> int:
    if number < 1:
        raise BadInput(f"--jobs {number}: must be at least 1")
    return number


def _seconds(number: float) -> float:
    if not number >= 0:
        raise BadInput(f"--checkpoint {number:g}: must be at least 0 seconds")
    return number


Jobs = Annotated[
    int,
    typer.Option(
        default_factory=_cores,
        show_default=False,
        callback=_jobs,
        help="Number of processes; by default all cores.",
    ),
]
Checkpoint = Annotated[
    float,
    typer.Option(
        metavar="SECONDS", callback=_seconds, help="From checkpoint to checkpoint of a long run."
    ),
]
Out = Annotated[Path, typer.Option(help="Results of a study are in OUT/STUDY.")]
Report = Annotated[Path, typer.Option(help="Tables, figures and the report go there.")]
Records = Annotated[Path, typer.Option(help="Records and checkpoints go there.")]
Force = Annotated[bool, typer.Option("--force", help="Compute again what is stored.")]
Executor = Annotated[
    str, typer.Option(help="local: processes of this machine; dask: workers of a cluster.")
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Of dask, e.g. tls://login-node:8786.")
]
