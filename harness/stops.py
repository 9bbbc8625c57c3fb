"""How a command that computes ends when it cannot go on."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from harness.bad_input import BadInput
from harness.executors import WorkerLost
from harness.printing import plain_console


@contextmanager
def stops(out: Path) -> Iterator[None]:
    """Exit status 130 if interrupted, 4 if a worker was killed, 2 if ``out`` cannot be written."""
    try:
        yield
    except KeyboardInterrupt:
        plain_console(stderr=True).print(
            "\ninterrupted: what had finished is stored; the same command continues from there"
        )
        raise typer.Exit(130) from None
    except WorkerLost as error:
        plain_console(stderr=True).print(f"esfem: {error}; the same command continues from there")
        raise typer.Exit(4) from None
    except OSError as error:
        place = error.filename or f"--out {out}"
        raise BadInput(f"{place}: cannot be written: {error.strerror or error}") from error
