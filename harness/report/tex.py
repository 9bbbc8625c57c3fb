"""The report as LaTeX: a minimal document, and a file a section that can be put into a paper."""

from collections.abc import Iterable, Mapping
from textwrap import wrap

from esfem.common.provenance import provenance_line
from esfem.common.tex_text import escaped, one_line
from esfem.flows.flow_results import FlowResult
from esfem.report import flow_content, study_content
from esfem.report.content import (
    Table,
    overview_table,
    own_provenance,
    plain_table,
    sentences_table,
    summary,
)
from esfem.report.drawings import Drawings, anchor_of, extra_figure, flow_pictures
from esfem.report.inputs import Extra, Inputs
from esfem.results.remarks import remarks
from esfem.results.study_result import StudyResult
from esfem.results.tables import latex

COLUMN = {"n": "r", "t": "l"}
SHORT_COLUMN = 0.075  # of the width of the text; what is left is for the columns of long texts
MANY = 12  # columns, from which letters are smaller
HEAD = 12  # letters of a line of a head
MAIN = r"""\documentclass[a4paper]{article}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage[margin=18mm]{geometry}
\usepackage{amsmath,array,booktabs,graphicx,longtable}
\setlength{\emergencystretch}{3em}
\title{%s}
\date{}
\begin{document}
\maketitle
%s
\end{document}
"""


def tex_files(inputs: Inputs, drawings: Drawings, title: str) -> dict[str, str]:
    """The texts of all files by name: ``main.tex`` and those that it reads."""
    files = {"summary": summary_tex(inputs)}
    if inputs.sentences:
        files["sentences"] = longtable(sentences_table(inputs.sentences), "sentences")
    files |= {anchor_of(r): study_tex(r, drawings) for r in inputs.studies}
    files |= {anchor_of(r): flow_tex(r, drawings) for r in inputs.flows}
    extras = enumerate(inputs.extras.values())
    files |= {f"extra-{i}": extra_tex(i, extra, inputs) for i, extra in extras}
    files["provenance"] = "\\section*{Provenance}\n" + facts(own_provenance(inputs))
    head = f"% {one_line(provenance_line())}\n"
    body = "\n".join(rf"\input{{{name}}}" for name in files)
    texts = {f"{name}.tex": f"{head}{text}\n" for name, text in files.items()}
    return {"main.tex": head + MAIN % (escaped(title), body), **texts}


def summary_tex(inputs: Inputs) -> str:
    """The headline and the verdict on each study and flow."""
    table = overview_table(inputs)
    said = rf"\section{{What holds}} {escaped(summary(inputs).headline)}."
    return f"{said}\n\n{longtable(table, 'all')}" if len(table.frame) else said


def study_tex(result: StudyResult, drawings: Drawings) -> str:
    """One study: claim, verdicts, figures, errors and rates, what was not judged, meshes, times."""
    study, anchor = result.study, anchor_of(result)
    claim = study.claimed
    stated = "none" if claim is None else f"{claim.name}: {claim.statement} ({claim.source})"
    outcome = result.outcome.upper()
    parts = [
        rf"\section{{{escaped(study.title)}: {escaped(outcome)}}}\label{{sec:{anchor}}}",
        escaped(f"{result.words.case}. Errors: {result.words.errors}."),
        rf"\par\noindent\textbf{{Claim}} {escaped(stated)}.",
        longtable(study_content.verdicts(result), anchor),
        *figures(anchor, drawings),
        items(remarks(result)),
        latex(result),
        *(
            longtable(table, anchor)
            for table in (
                study_content.masked(result),
                study_content.meshes(result),
                study_content.timings(result),
            )
            if len(table.frame)
        ),
        facts(study_content.provenance(result)),
        r"\clearpage",
    ]
    return "\n\n".join(parts)


def flow_tex(result: FlowResult, drawings: Drawings) -> str:
    """One flow: its checks, pictures, and numbers."""
    anchor, outcome = anchor_of(result), result.outcome.upper()
    parts = [
        rf"\section{{{escaped(result.flow.flow.title)}: {outcome}}}\label{{sec:{anchor}}}",
        escaped(f"{flow_content.course(result)}."),
        longtable(flow_content.checks(result), anchor),
        *(figure(file, f"{result.flow.flow.title}: surfaces") for file in flow_pictures(result)),
        *figures(anchor, drawings),
        longtable(flow_content.levels(result), anchor),
        facts(flow_content.provenance(result)),
        r"\clearpage",
    ]
    return "\n\n".join(parts)


def extra_tex(i: int, extra: Extra, inputs: Inputs) -> str:
    """A section of its own; its figure is shown if it is there as PDF too."""
    parts = [rf"\section{{{escaped(extra.title)}}}", escaped(extra.text)]
    if extra.figure is not None:
        shown = [figure(file, extra.alt) for file in extra_figure(i, extra, inputs.folder)]
        parts += shown or [
            escaped(f"(Figure in HTML only, there is no PDF beside it: {extra.alt})")
        ]
    if extra.table:
        parts.append(longtable(plain_table("table", extra.title, extra.table), f"extra-{i}"))
    return "\n\n".join(parts)


def figures(anchor: str, drawings: Drawings) -> Iterable[str]:
    """The figures of a section, each with what it shows as caption."""
    return (figure(f"{anchor}-{name}.pdf", d.shows) for name, d in drawings[anchor].items())


def figure(file: str, caption: str) -> str:
    """A floating figure as wide as the text, or as it is if it is smaller."""
    return "\n".join(
        [
            r"\begin{figure}[htbp]\centering",
            rf"\includegraphics[width=\linewidth,height=0.45\textheight,keepaspectratio]{{{file}}}",
            rf"\caption{{{escaped(caption)}}}",
            r"\end{figure}",
        ]
    )


def longtable(table: Table, anchor: str) -> str:
    """A booktabs table that may go over several pages."""
    kinds = table.classes
    long = kinds.count("")
    width = (0.95 - SHORT_COLUMN * (len(kinds) - long)) / max(long, 1)
    paragraph = rf">{{\raggedright\arraybackslash}}p{{{max(width, 0.12):.2f}\linewidth}}"
    columns = "".join(COLUMN.get(kind, paragraph) for kind in kinds)
    heads = " & ".join(map(head, table.frame.columns, kinds))
    lines = [" & ".join(escaped(str(e)) for e in row) for row in table.frame.to_numpy().tolist()]
    caption = f"{table.title}. {table.tells}".strip()
    letters = r"\tiny" if len(kinds) >= MANY else r"\scriptsize"
    parts = [
        rf"\begingroup{letters}\setlength{{\tabcolsep}}{{3pt}}",
        rf"\begin{{longtable}}{{{columns}}}",
        rf"\caption{{{escaped(caption)}}}\label{{tab:{anchor}-{table.name}}}\\",
        rf"\toprule {heads} \\ \midrule \endhead",
        r"\bottomrule \endfoot",
        *(rf"{line} \\" for line in lines),
        r"\end{longtable}\endgroup",
    ]
    return "\n".join(parts)


def head(name: object, kind: str) -> str:
    """What stands above a column; above numbers and short texts it may take several lines."""
    lines = wrap(escaped(str(name)), HEAD, break_long_words=False, break_on_hyphens=False)
    if not kind or len(lines) < 2:
        return " ".join(lines)
    side, stacked = "r" if kind == "n" else "l", r" \\ ".join(lines)
    return rf"\shortstack[{side}]{{{stacked}}}"


def items(lines: Iterable[str]) -> str:
    """A list; nothing for no lines."""
    entries = "\n".join(rf"\item {escaped(line)}" for line in lines)
    return f"\\begin{{itemize}}\n{entries}\n\\end{{itemize}}" if entries else ""


def facts(pairs: Mapping[str, str]) -> str:
    """Names and values, a line each."""
    lines = (rf"\item[{escaped(k)}] {escaped(v)}" for k, v in pairs.items())
    return "\\begin{description}\\footnotesize\n" + "\n".join(lines) + "\n\\end{description}"
