"""All commands, and how the program ends.

A command imports what it calls when it is called, so that `esfem --help` loads no numerics.

Exit status: 0 every claim holds, 1 a claim failed, 3 inconclusive, 2 bad input,
4 a worker process was killed, 130 interrupted.
"""

import sys
from collections.abc import Callable
from io import TextIOWrapper
from typing import Annotated

import typer

from esfem.cli import baseline, campaigns, flow, judge, mesh, report, run
from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console

COMMANDS: dict[str, Callable[..., None]] = {
    "run": run.run,
    "list": run.list_,
    "table": run.table,
    "judge": judge.judge,
    "mutants": campaigns.mutants,
    "mesh": mesh.mesh,
    "flow": flow.flow,
    "check": baseline.check,
    "baseline": baseline.baseline,
    "paper": campaigns.paper,
    "report": report.report,
    "compare": report.compare,
    "schemes": campaigns.schemes,
    "judge-report": campaigns.judge_report,
    "rough-starts": campaigns.rough_starts,
}
app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="Convergence verification for evolving surface finite elements.  \n"
    "Example: `esfem run sphere clifford --jobs 2`",
)
for name, command in COMMANDS.items():
    app.command(name)(command)


def _version(asked: bool) -> None:
    if asked:
        from esfem.common.provenance import numerics_digest, version

        typer.echo(f"esfem-willmore {version()} (numerics {numerics_digest()})")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_version,
            is_eager=True,
            help="Print version and digest of the code that computes, and exit.",
        ),
    ] = False,
) -> None:
    """What may stand before the command."""


def main() -> None:
    """Entry point: bad input is one line on standard error and exit status 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not know all our characters
    try:
        app()
    except (BadInput, OSError) as error:  # standard output may be a full disk too
        line = " ".join(str(error).splitlines())
        plain_console(stderr=True).print(f"esfem: {line}", soft_wrap=True)
        sys.exit(2)
