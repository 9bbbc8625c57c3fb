"""How a command that computes ends when it cannot go on."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console


@contextmanager
def exit_statuses(
    out: Path, resumes: bool = True, command: str = "the same command"
) -> Iterator[None]:
    """Exit status 130 if interrupted, 4 if a worker was killed, 2 if ``out`` cannot be written.

    Parameters
    ----------
    out : the folder of the results.
    resumes : whether the ``command`` goes on from what is stored there.
    """
    from esfem.runs.executors import WorkerLost

    again = f"{command} continues from there" if resumes else "nothing is stored"
    try:
        yield
    except KeyboardInterrupt:
        stored = "what had finished is stored; " if resumes else ""
        plain_console(stderr=True).print(f"\ninterrupted: {stored}{again}")
        raise typer.Exit(130) from None
    except WorkerLost as error:
        plain_console(stderr=True).print(f"esfem: {error}; {again}")
        raise typer.Exit(4) from None
    except OSError as error:
        place = error.filename or f"--out {out}"
        raise BadInput(f"{place}: cannot be written: {error.strerror or error}") from error
