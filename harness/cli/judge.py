"""`esfem judge`: anybody's table of errors, read as it was printed, judged, shown and written."""

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console
from esfem.common.files import reading, write_json, write_text, writing

if TYPE_CHECKING:  # slow to load
    from esfem.cli.column_reader import Asked
    from esfem.cli.columns import Chosen
    from esfem.cli.series import Claim, Judged

DIRECTIONS: tuple[Literal["h", "tau"], ...] = ("h", "tau")
DECIMALS: tuple[Literal["point", "comma"], ...] = ("point", "comma")
PLOTS = (".pdf", ".svg", ".png")
LARGEST = 10_000_000  # bytes of a table; that of a thousand levels has some 100,000


def judge(
    file: Annotated[
        str, typer.Argument(metavar="FILE|-", help="A table, in whatever dialect; - for stdin.")
    ],
    order: Annotated[
        list[str],
        typer.Option(
            metavar="[NAME=]K",
            help="The claimed order, or one a column or norm: --order l2=3 --order h1=2. "
            "With tau=Q, the order in the other parameter.",
        ),
    ],
    h: Annotated[str | None, typer.Option("--h", metavar="COLUMN", help="Mesh widths.")] = None,
    dofs: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Unknowns: h = dofs^(-1/dim).")
    ] = None,
    cells: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Cells in a direction, or of all with --dim."),
    ] = None,
    dim: Annotated[int | None, typer.Option(help="Dimension of the mesh.")] = None,
    ratio: Annotated[
        float | None, typer.Option(help="From h of a row to that of the next, e.g. 0.5.")
    ] = None,
    tau: Annotated[str | None, typer.Option(metavar="COLUMN", help="Time steps.")] = None,
    error: Annotated[
        list[str] | None, typer.Option(metavar="COLUMN", help="Errors; several are allowed.")
    ] = None,
    variable: Annotated[str | None, typer.Option(help="Judge this variable alone.")] = None,
    direction: Annotated[str | None, typer.Option(help="The swept parameter: h or tau.")] = None,
    tolerance: Annotated[float, typer.Option(help="Of the order.")] = 0.2,
    at_least: Annotated[
        bool, typer.Option("--at-least", help="A higher order is expected, and passes.")
    ] = False,
    floor: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="What errors cannot fall below: rounding=1e-14."),
    ] = None,
    steady: Annotated[
        bool, typer.Option("--steady", help="The solution does not move: no error in time.")
    ] = False,
    levels: Annotated[
        str, typer.Option(metavar="FIRST:LAST", help="Levels to judge; 1 is the coarsest.")
    ] = ":",
    levels_min: Annotated[int, typer.Option(help="Judge so few levels, 3 at least.")] = 4,
    table: Annotated[int | None, typer.Option(help="Which of several tables, from 1.")] = None,
    decimal: Annotated[
        str | None, typer.Option(help="point or comma, where the table leaves it open.")
    ] = None,
    encoding: Annotated[
        str | None, typer.Option(help="Of the file, if it is neither UTF-8 nor UTF-16.")
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write all as JSON there; - prints.")] = None,
    markdown: Annotated[Path | None, typer.Option(help="Write Markdown there; - prints.")] = None,
    latex: Annotated[Path | None, typer.Option(help="Write LaTeX there; - prints.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw there: .pdf, .svg or .png.")] = None,
) -> None:
    """Judge the order of convergence of anybody's table of errors.

    Exit status: 0 the order is met, 1 it is not, 3 undecided or not exercised, 2 bad input.

    Example: `esfem judge errors.csv --order 2`
    """
    from esfem.cli.column_reader import Asked
    from esfem.cli.judge_options import parsed_floors, parsed_levels, parsed_orders, positive
    from esfem.cli.series import Claim
    from esfem.judging import worst
    from esfem.judging.judgement import EXIT

    for option, number in (("--tolerance", tolerance), ("--ratio", ratio)):
        if number is not None:
            positive(option, str(number))
    if ratio is not None and ratio >= 1:
        raise BadInput(f"--ratio {ratio:g}: must be below 1: h falls from row to row")
    if dim is not None and dim not in (1, 2, 3):
        raise BadInput(f"--dim {dim}: must be 1, 2 or 3")
    if levels_min < 3:
        raise BadInput(f"--levels-min {levels_min}: an order needs 3 levels at least")
    _check_word("--direction", direction, DIRECTIONS)
    _check_word("--decimal", decimal, DECIMALS)
    if plot is not None and plot.suffix not in PLOTS:
        raise BadInput(f"--plot {plot}: must end with {', '.join(PLOTS)}")
    orders = parsed_orders(order)
    which: Any = direction
    mark: Any = decimal
    common = Claim(
        order=1.0,
        direction=which,
        tolerance=tolerance,
        at_least=at_least,
        steady=steady,
        floors=parsed_floors(floor or ()),
        levels=parsed_levels(levels),
        levels_min=levels_min,
    )
    asked = Asked(h, dofs, cells, dim, ratio, tau, tuple(error or ()), variable, mark)
    read = _read(file, encoding, table, asked)
    judged = _judged(file, read, orders, common, bool(error))
    title = f"{file}: {read.said}"
    outcome = worst([one.judgement for one in judged])
    content = _content(file, read.said, judged, orders, common, outcome)
    _write(title, judged, content, {"json": json, "markdown": markdown, "latex": latex})
    if plot is not None:
        _plot(title, judged, plot)
    raise typer.Exit(EXIT[outcome])


def _check_word(option: str, word: str | None, allowed: Sequence[str]) -> None:
    if word is not None and word not in allowed:
        raise BadInput(f"{option} {word}: must be one of {', '.join(allowed)}")


def _read(file: str, encoding: str | None, which: int | None, asked: "Asked") -> "Chosen":
    """The series in a file, or in what comes from standard input."""
    from esfem.cli.columns import chosen_columns
    from esfem.common.decoding import decoded
    from esfem.common.tables import table_in

    with reading(file):
        with nullcontext(sys.stdin.buffer) if file == "-" else open(file, "rb") as stream:
            content = stream.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise BadInput(f"{file}: has more than {LARGEST:,} bytes: that is no table of errors")
    try:
        return chosen_columns(table_in(decoded(content, encoding), which), asked)
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from error


def _judged(
    file: str, read: "Chosen", orders: dict[str, float], common: "Claim", chosen: bool
) -> "list[Judged]":
    from esfem.cli.judge_options import claims
    from esfem.cli.series import judged

    found = []
    for series, claim in claims(read.series, orders, common, chosen):
        try:
            found.append(judged(series, claim))
        except BadInput as error:
            of = f"{series.name}: " if series.name else ""
            raise BadInput(f"{file}: {of}{error}") from error
    return found


def _content(
    file: str,
    said: str,
    judged: "Sequence[Judged]",
    orders: dict[str, float],
    common: "Claim",
    outcome: str,
) -> dict[str, Any]:
    """What the file of JSON holds."""
    from esfem.common.provenance import command, machine, version

    return {
        "version": version(),
        "command": command(),
        "machine": machine(),
        "file": file,
        "read": said,
        "orders": orders,
        "tolerance": common.tolerance,
        "outcome": outcome,
        "judgements": {one.series.name: one.judgement for one in judged},
        "notes": {one.series.name: one.notes for one in judged},
    }


def _write(
    title: str,
    judged: "Sequence[Judged]",
    content: dict[str, Any],
    places: dict[str, Path | None],
) -> None:
    """Print the table, or what goes to "-" in its stead, and write the files."""
    from esfem.cli import judgement_output as output

    texts = {"markdown": output.markdown, "latex": output.latex}
    if Path("-") not in places.values():
        output.show_judgements(title, judged, plain_console())
    for kind, place in places.items():
        if place is None:
            continue
        with writing(f"--{kind} {place}"):
            if place == Path("-"):
                typer.echo(_as_json(content) if kind == "json" else texts[kind](title, judged))
            elif kind == "json":
                write_json(place, content)
            else:
                write_text(place, texts[kind](title, judged))


def _as_json(content: dict[str, Any]) -> str:
    from json import dumps

    from esfem.common.files import plain

    return dumps(plain(content), indent=1)


def _plot(title: str, judged: "Sequence[Judged]", place: Path) -> None:
    from esfem.cli.judgement_output import figure
    from esfem.common.drawing import save_figure

    with writing(f"--plot {place}"):
        save_figure(figure(title, judged), place, title, endings=(place.suffix,))
