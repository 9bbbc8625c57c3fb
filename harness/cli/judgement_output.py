"""What the judge said, as text for a terminal, as Markdown, as LaTeX, and as a figure."""

from collections.abc import Sequence
from itertools import chain
from math import isnan
from typing import TYPE_CHECKING

from esfem.cli.series import Judged
from esfem.common.console import print_table
from esfem.common.drawing import series_look, styled, subplots
from esfem.common.tex_text import escaped, one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from rich.console import Console

    from esfem.judging import Judgement

HEADINGS = ("", "verdict", "claim", "order", "95 % interval", "window", "scatter", "model")


def show_judgements(title: str, judged: Sequence[Judged], console: "Console") -> None:
    """Print the judge's table of each series, with cause, next run, and what was left out."""
    console.print(title, soft_wrap=True)
    print_table(rows(judged), console, HEADINGS)
    for line in remarks(judged):
        console.print(line, soft_wrap=True)


def headline(one: Judged) -> str:
    """Verdict, order, interval and cause in one line."""
    j = one.judgement
    seen = f"order {j.order:.2f} in [{j.lower:.2f}, {j.upper:.2f}]" if j.window else "no order seen"
    claim = f"claimed {_claim(one)}"
    head = "; ".join(
        part for part in (f"{j.outcome.upper()}: {seen}, {claim}", j.certainty) if part
    )
    return f"{head}: {j.cause}" if j.cause else head


def rows(judged: Sequence[Judged]) -> list[tuple[str, ...]]:
    """The cells of the table, a row a series, as `HEADINGS` says."""
    return [
        (one.series.name, one.judgement.outcome.upper(), _claim(one), *_numbers(one.judgement))
        for one in judged
    ]


def remarks(judged: Sequence[Judged]) -> list[str]:
    """Cause, next run, masked runs and notes, a line each; what holds for all is said once."""
    lines: dict[str, list[str]] = {}
    for one in judged:
        for line in chain(_words(one), one.notes):
            lines.setdefault(line, []).append(one.series.name)
    return [
        line if len(names) == len(judged) else f"{', '.join(names)}: {line}"
        for line, names in lines.items()
    ]


def markdown(title: str, judged: Sequence[Judged]) -> str:
    """The table and its remarks in Markdown."""
    cells = [tuple(cell.replace("|", "\\|") for cell in row) for row in (HEADINGS, *rows(judged))]
    head, *body = (f"| {' | '.join(row)} |" for row in cells)
    table = [head, f"|{'---|' * len(HEADINGS)}", *body]
    return "\n".join([title, "", *table, "", *(f"- {line}" for line in remarks(judged)), ""])


def latex(title: str, judged: Sequence[Judged]) -> str:
    """The table as a tabular of LaTeX, with its remarks as comments."""
    lines = [
        " & ".join(escaped(cell) for cell in row) + r" \\" for row in (HEADINGS, *rows(judged))
    ]
    head = [
        f"% {one_line(title)}",
        rf"\begin{{tabular}}{{ll{'r' * (len(HEADINGS) - 3)}l}}",
        r"\hline",
    ]
    notes = [f"% {one_line(line)}" for line in remarks(judged)]
    return "\n".join(
        [*head, lines[0], r"\hline", *lines[1:], r"\hline", r"\end{tabular}", *notes, ""]
    )


@styled()
def figure(title: str, judged: Sequence[Judged]) -> "Figure":
    """The errors on axes of logarithms, the fit over the judged levels, and the claimed slope."""
    drawn, axis = subplots(size=(5.5, 4.2))
    for i, one in enumerate(judged):
        _draw(axis, one, i)
    directions = {one.judgement.direction for one in judged}
    names = {"h": "mesh width $h$", "tau": r"time step $\tau$"}
    axis.set_xlabel(" or ".join(names[d] for d in sorted(directions)))
    axis.set_ylabel("error")
    axis.legend(fontsize=8)
    drawn.suptitle(title, fontsize=9, parse_math=False)
    return drawn


def _draw(axis: "Axes", one: Judged, i: int) -> None:
    import numpy as np

    j, series = one.judgement, one.series
    s = series.h if j.direction == "h" else series.tau
    assert s is not None
    seen = np.isfinite(series.error) & (series.error > 0)
    window = np.isin(np.round(np.log(s), 9), np.round(np.log(j.window or (1.0,)), 9)) & bool(
        j.window
    )
    look, name = series_look(i), series.name or "error"
    axis.loglog(s[seen & ~window], series.error[seen & ~window], ls="", mfc="none", **look)
    label = f"{name}: {j.outcome.upper()}" + (f", order {j.order:.2f}" if j.window else "")
    axis.loglog(s[seen & window], series.error[seen & window], ls="", label=label, **look)
    if j.window and j.constant == j.constant:
        ends = np.array([j.window[0], j.window[-1]])
        axis.loglog(ends, j.constant * ends**j.order, "-", color=look["color"])
        last = j.constant * ends[-1] ** j.order
        slope = {"color": look["color"], "linestyle": ":", "label": f"{name}: slope {j.claimed:g}"}
        axis.loglog(ends, last * (ends / ends[-1]) ** j.claimed, **slope)


def _claim(one: Judged) -> str:
    claim = one.claim
    least = "at least " if claim.at_least else ""
    return f"{least}{one.judgement.claimed:.3g} - {claim.tolerance:g} in {one.judgement.direction}"


def _numbers(j: "Judgement") -> tuple[str, ...]:
    if not j.window:
        return ("-",) * 5
    ends = f"{j.window[0]:.3g}..{j.window[-1]:.3g}"
    return (
        f"{j.order:.2f}",
        f"[{j.lower:.2f}, {j.upper:.2f}]",
        f"{len(j.window)} of {j.levels}, {ends}",
        f"{100 * j.scatter:.1f} %",
        j.model,
    )


def _words(one: Judged) -> list[str]:
    """Cause, next run, joint fit and masked runs, a line each."""
    j = one.judgement
    lines = [j.certainty] if j.certainty else []
    lines += [f"cause: {j.cause}"] if j.cause else []
    lines += [f"next run: {j.next_run}"] if j.next_run else []
    if j.joint is not None:
        other = "tau" if j.direction == "h" else "h"
        given = " (given)" if j.joint.q_given else ""
        lines.append(
            f"joint fit: {j.joint.A:.3g} {j.direction}^{j.joint.p:.2f} + "
            f"{j.joint.B:.3g} {other}^{j.joint.q:.2f}{given}, "
            f"scatter {100 * j.joint.scatter:.1f} %"
        )
    for masked in j.masked:
        known = {"h": masked.h, "tau": masked.tau}
        if one.series.h is None:
            del known["h"]
        where = ", ".join(
            f"{name} = {value:.3g}" for name, value in known.items() if not isnan(value)
        )
        lines.append(f"masked: {where}: {masked.reason}")
    return lines
