"""The report as LaTeX: a minimal document, and a file a section that can be put into a paper."""

from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from esfem.common.provenance import provenance_line
from esfem.common.tex_text import escaped, one_line
from esfem.report.content import (
    Table,
    overview_table,
    own_provenance,
    plain_table,
    sentences_table,
    summary,
)
from esfem.report.drawings import extra_figure, flow_pictures
from esfem.report.results_folder import ResultsFolder
from esfem.report.sections import ERRORS, Section
from esfem.results.tables import latex

COLUMN = {"n": "r", "t": "l"}
SHORT_COLUMN = 0.075  # of the width of the text; what is left is for the columns of long texts
MANY = 12  # columns, from which letters are smaller
HEAD = 12  # letters of a line of a head


def tex_files(
    results: ResultsFolder, studies: Sequence[Section], flows: Sequence[Section], title: str
) -> dict[str, str]:
    """The texts of all files by name: ``main.tex`` and those that it reads."""
    files = {"summary": _summary(results)}
    if results.sentences:
        files["sentences"] = longtable(sentences_table(results.sentences), "sentences")
    for section, result in zip(studies, results.studies, strict=True):
        files[section.anchor] = _section(section, errors=latex(result))
    for section, flow in zip(flows, results.flows, strict=True):
        files[section.anchor] = _section(section, pictures=flow_pictures(flow))
    files |= {f"extra-{i}": _extra(i, stem, results) for i, stem in enumerate(results.extras)}
    files["provenance"] = "\\section*{Provenance}\n" + _part("facts", own_provenance(results))
    head = f"% {one_line(provenance_line())}\n"
    texts = {"main": _filled("main.tex", title=title, files=files), **files}
    return {f"{name}.tex": f"{head}{text}\n" for name, text in texts.items()}


def _summary(results: ResultsFolder) -> str:
    """The headline and the verdict on each study and flow."""
    headline = summary(results).headline
    return _filled("summary.tex", headline=headline, overview=overview_table(results))


def _section(section: Section, errors: str = "", pictures: Iterable[str] = ()) -> str:
    """A study or a flow: verdicts, figures, errors and rates as tables that fit a page, what was
    not judged, meshes, times."""
    tables = [table for table in section.tables[1:] if not table.name.startswith(ERRORS)]
    more = {"errors": errors, "pictures": pictures, "tables": tables}
    return _filled("section.tex", section=section, **more)


def _extra(i: int, stem: str, results: ResultsFolder) -> str:
    """A section of its own; its figure is shown if it is there as PDF too."""
    extra, anchor = results.extras[stem], f"extra-{i}"
    figures = extra_figure(i, extra, results.folder)
    table = plain_table("table", extra.title, extra.table) if extra.table else None
    return _filled("extra.tex", extra=extra, anchor=anchor, figures=figures, table=table)


def longtable(table: Table, anchor: str) -> str:
    """A booktabs table that may go over several pages."""
    return _part("longtable", table, anchor)


def _columns(table: Table) -> str:
    """The columns for ``longtable``; those of long texts share the width that is left."""
    kinds = table.classes
    long = kinds.count("")
    width = (0.95 - SHORT_COLUMN * (len(kinds) - long)) / max(long, 1)
    paragraph = rf">{{\raggedright\arraybackslash}}p{{{max(width, 0.12):.2f}\linewidth}}"
    return "".join(COLUMN.get(kind, paragraph) for kind in kinds)


def _heads(table: Table) -> str:
    return " & ".join(map(_head, table.frame.columns, table.classes))


def _head(name: object, kind: str) -> str:
    """What stands above a column; above numbers and short texts it may take several lines."""
    lines = wrap(escaped(str(name)), HEAD, break_long_words=False, break_on_hyphens=False)
    if not kind or len(lines) < 2:
        return " ".join(lines)
    side, stacked = "r" if kind == "n" else "l", r" \\ ".join(lines)
    return rf"\shortstack[{side}]{{{stacked}}}"


def _letters(table: Table) -> str:
    return r"\tiny" if len(table.frame.columns) >= MANY else r"\scriptsize"


TEMPLATES = Environment(
    loader=PackageLoader("esfem.report"),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    block_start_string="<%",
    block_end_string="%>",
    variable_start_string="<<",
    variable_end_string=">>",
    comment_start_string="<#",
    comment_end_string="#>",
)
TEMPLATES.filters["tex"] = escaped
TEMPLATES.globals |= {"columns": _columns, "heads": _heads, "letters": _letters}


def _filled(template: str, **values: Any) -> str:
    return TEMPLATES.get_template(template).render(values)


def _part(macro: str, *values: Any) -> str:
    return str(getattr(TEMPLATES.get_template("parts.tex").module, macro)(*values)).rstrip("\n")
