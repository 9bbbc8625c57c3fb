"""`esfem flow`: one evolution, its numbers, files for ParaView, pictures and checks."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.cli.exit_statuses import exit_statuses
from esfem.cli.options import Checkpoint, Force
from esfem.common.console import plain_console
from esfem.common.defaults import DEFAULT_OUT, EVERY_SECONDS


def flow(
    file: Annotated[
        str,
        typer.Argument(metavar="FILE.toml", help="A flow file, or the name of a committed one."),
    ],
    out: Annotated[Path, typer.Option(help="Results go to OUT/NAME.")] = DEFAULT_OUT / "flows",
    checkpoint: Checkpoint = EVERY_SECONDS,
    force: Force = False,
    pictures: Annotated[bool, typer.Option(help="Make pictures and files for ParaView.")] = True,
) -> None:
    """Evolve one surface: history.csv, files for ParaView, pictures, and the checks it asks for.

    Exit status 0 if all checks hold, 1 if one fails.

    Example: `esfem flow ellipsoid --out results/runs/flows`
    """
    from esfem.flows.flow_file import load_flow
    from esfem.flows.run_flow import run_flow
    from esfem.judging.outcome import exit_status
    from esfem.studies.catalogue import flow_path

    path = flow_path(file)
    asked = load_flow(path)
    with exit_statuses(out):
        checks = run_flow(asked, path.parent, out, checkpoint, force, pictures, plain_console())
    raise typer.Exit(exit_status(check.verdict for check in checks))
