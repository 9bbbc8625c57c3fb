"""Tables of errors as programs print them, each from the same columns of numbers.

A writer takes a DataFrame of numbers with at most four significant digits, and gives the text;
what is read from it must be these numbers.  Missing numbers are NaN.
"""

import io
from collections.abc import Callable

import numpy as np
import pandas as pd

Writer = Callable[[pd.DataFrame], str]


def scientific(value: float) -> str:
    return "NaN" if np.isnan(value) else f"{value:.3e}"


def with_marks(table: pd.DataFrame, form: Callable[[float], str]) -> list[list[str]]:
    """Names and cells as words."""
    return [list(table.columns), *([form(v) for v in row] for row in table.to_numpy())]


def joined(table: pd.DataFrame, mark: str, form: Callable[[float], str] = scientific) -> str:
    return "\n".join(mark.join(words) for words in with_marks(table, form)) + "\n"


def german(value: float) -> str:
    """As a spreadsheet in a German locale writes it."""
    return "" if np.isnan(value) else f"{value:.3E}".replace(".", ",")


def fortran(value: float) -> str:
    """A field of D16.8."""
    if np.isnan(value):
        return f"{'NaN':>16}"
    mantissa, exponent = f"{value:.8e}".split("e")
    return f"{mantissa}D{exponent}".rjust(16)


def bare_fortran(value: float) -> str:
    """Es24.16e3 without its letter, as gfortran prints exponents of three digits."""
    return f"{'NaN':>24}" if np.isnan(value) else f"{value:.16e}".replace("e-", "-0").rjust(24)


def of_savetxt(table: pd.DataFrame, **how: str) -> str:
    stream = io.StringIO()
    np.savetxt(stream, table.to_numpy(), header=how.get("delimiter", " ").join(table), **how)
    return stream.getvalue()


def matlab(table: pd.DataFrame) -> str:
    """As `disp` shows a table: names centred above lines of underscores."""
    cells = with_marks(table, scientific)
    widths = [max(len(words[j]) for words in cells) for j in range(table.shape[1])]
    head = "    ".join(name.center(width) for name, width in zip(cells[0], widths, strict=True))
    rule = "    ".join("_" * width for width in widths)
    rows = (
        "    ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
        for row in cells[1:]
    )
    return "\n".join(f"    {line}" for line in (head, rule, "", *rows)) + "\n"


def pandas_kept(table: pd.DataFrame) -> str:
    return table.to_string(float_format=scientific)


def pandas_indexed(table: pd.DataFrame) -> str:
    return indexed(table).to_string(float_format=scientific)


def indexed(table: pd.DataFrame) -> pd.DataFrame:
    """The first column as the index, in words: pandas formats no index."""
    first = str(table.columns[0])
    return table.assign(**{first: [scientific(v) for v in table[first]]}).set_index(first)


# What each writes has all columns of the table, in their order, with their names.
WRITERS: dict[str, Writer] = {
    "comma": lambda t: joined(t, ","),
    "comma and blank": lambda t: joined(t, ", "),
    "quoted": lambda t: joined(t.rename(columns=lambda n: f'"{n}"'), ","),
    "comma at the end": lambda t: joined(t, ",").replace("\n", ",\n"),
    "semicolon": lambda t: joined(t, ";"),
    "tab": lambda t: joined(t, "\t"),
    "German": lambda t: joined(t, ";", german),
    "German tabs": lambda t: joined(t, "\t", german),
    "German with its mark": lambda t: "sep=;\n" + joined(t, ";", german).replace("\n", "\r\n"),
    "comments above": lambda t: "# made by a solver\n# version 3\n" + joined(t, ","),
    "percent": lambda t: "% " + joined(t, "  "),
    "hash": lambda t: "#" + joined(t, "\t"),
    "units": lambda t: joined(t, ",").replace("\n", f"\n{','.join(['[-]'] * t.shape[1])}\n", 1),
    "blank lines": lambda t: joined(t, ",").replace("\n", "\n\n"),
    "savetxt": of_savetxt,
    "savetxt with commas": lambda t: of_savetxt(t, delimiter=","),
    "Fortran": lambda t: joined(t, " ", fortran),
    "Fortran, three digits": lambda t: joined(t, " ", bare_fortran),
    "MATLAB": matlab,
    "to_csv": lambda t: t.to_csv(index=False),
    "to_csv with an index": lambda t: t.to_csv(),
    "to_csv, German": lambda t: t.to_csv(index=False, sep=";", decimal=","),
    "to_csv, nan": lambda t: t.to_csv(index=False, na_rep="nan"),
    "to_string": pandas_kept,
    "to_string without an index": lambda t: t.to_string(float_format=scientific, index=False),
    "to_string, h its index": pandas_indexed,
    "to_markdown": lambda t: t.to_markdown(floatfmt=".3e"),
    "to_markdown without an index": lambda t: t.to_markdown(index=False, floatfmt=".3e"),
    "to_latex": lambda t: t.to_latex(float_format=scientific),
    "to_latex without an index": lambda t: t.to_latex(index=False, float_format=scientific),
    "to_latex, h its index": lambda t: indexed(t).to_latex(float_format=scientific),
    **{
        f"tabulate {kind}": lambda t, kind=kind: t.to_markdown(tablefmt=kind, floatfmt=".3e")
        for kind in (
            *("github", "grid", "psql", "orgtbl", "rst", "simple", "presto", "pretty", "plain"),
            *("fancy_grid", "outline", "latex", "latex_booktabs", "tsv", "rounded_grid"),
        )
    },
    "Excel, UTF-16": lambda t: joined(t, "\t", german).replace("\n", "\r\n"),
    "powers of ten": lambda t: joined(t, " & ", in_math).replace("\n", " \\\\\n"),
    "num of siunitx": lambda t: tabular(t, lambda v: f"\\num{{{scientific(v)}}}"),
}


def in_math(value: float) -> str:
    if np.isnan(value):
        return "---"
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"${mantissa} \\cdot 10^{{{int(exponent)}}}$"


def tabular(table: pd.DataFrame, form: Callable[[float], str]) -> str:
    head, *rows = (" & ".join(words) + r" \\" for words in with_marks(table, form))
    lines = [rf"\begin{{tabular}}{{{'r' * table.shape[1]}}}", r"\toprule", head, r"\midrule", *rows]
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def rates(errors: np.ndarray) -> np.ndarray:
    """The rates of halved meshes, NaN at the first."""
    return np.r_[np.nan, np.log2(errors[:-1] / errors[1:])]


def dealii_columns(errors: pd.DataFrame, form: str = "{:.3e}") -> dict[str, list[list[str]]]:
    """Words a column: each error of the table with its reduction and its rate behind it."""
    found = {}
    for name, e in errors.items():
        rate = rates(e.to_numpy())
        words = [["-", "-"], *([f"{2**r:.2f}", f"{r:.2f}"] for r in rate[1:])]
        found[str(name)] = [[form.format(v), *pair] for v, pair in zip(e, words, strict=True)]
    return found


def dealii_text(counts: pd.DataFrame, errors: pd.DataFrame) -> str:
    """As deal.II's ConvergenceTable prints with headers: fields flush right, each name centred over
    an error and its two rates, the last field wider where a name needs it."""
    columns: dict[str, list[list[str]]] = {
        str(name): [[str(v)] for v in values] for name, values in counts.items()
    }
    head, body = "", ["" for _ in range(len(counts))]
    for name, cells in (columns | dealii_columns(errors)).items():
        widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
        missing = len(name) - (sum(widths) + len(widths) - 1)
        widths[-1] += max(missing, 0)
        width = sum(widths) + len(widths) - 1
        front = (width - len(name)) // 2
        head += " " * front + name + " " * (width - len(name) - front) + " "
        for i, row in enumerate(cells):
            body[i] += "".join(cell.rjust(w) + " " for cell, w in zip(row, widths, strict=True))
    return "\n".join([head, *body]) + "\n"


def _flat(counts: pd.DataFrame, errors: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    names = [str(name) for name in counts]
    rows = [[str(v) for v in row] for row in counts.to_numpy()]
    for name, cells in dealii_columns(errors).items():
        names += [name, f"{name}...red.rate", f"{name}...red.rate.log2"]
        rows = [row + more for row, more in zip(rows, cells, strict=True)]
    return names, rows


def dealii_org(counts: pd.DataFrame, errors: pd.DataFrame) -> str:
    names, rows = _flat(counts, errors)
    widths = [max(len(r[j]) for r in [names, *rows]) for j in range(len(names))]
    lines = (
        "| " + "".join(cell.ljust(w) + " | " for cell, w in zip(row, widths, strict=True))
        for row in [names, *rows]
    )
    return "\n".join(lines) + "\n"


def dealii_described(counts: pd.DataFrame, errors: pd.DataFrame) -> str:
    names, rows = _flat(counts, errors)
    head = [f"# {i + 1}: {name}" for i, name in enumerate(names)]
    return "\n".join([*head, *(" ".join(row) + " " for row in rows)]) + "\n"


def dealii_tex(counts: pd.DataFrame, errors: pd.DataFrame) -> str:
    _, rows = _flat(counts, errors)
    spans = [f"\n\\multicolumn{{3}}{{|c|}}{{{name}}}" for name in errors]
    head = " & ".join([*(f"{name}" for name in counts), *spans]) + "\\\\ \\hline"
    body = (" & ".join(row) + "\\\\ \\hline" for row in rows)
    kind = "c|" * (counts.shape[1] + 3 * errors.shape[1])
    opening = ["\\begin{table}[H]", "\\begin{center}", f"\\begin{{tabular}}{{|{kind}}} \\hline"]
    return "\n".join([*opening, head, *body, "\\end{tabular}", "\\end{center}", "\\end{table}", ""])


DEALII: dict[str, Callable[[pd.DataFrame, pd.DataFrame], str]] = {
    "text": dealii_text,
    "org": dealii_org,
    "described": dealii_described,
    "tex": dealii_tex,
}


def trixi(errors: dict[str, pd.DataFrame]) -> str:
    """As Trixi's convergence_test prints: a block a norm, a pair of columns a variable."""
    lines = ["#" * 100]
    for norm, table in errors.items():
        lines += [norm, "".join(f"{name:<20}" for name in table)]
        lines += [f"{'error':<10}{'EOC':<10}" * table.shape[1]]
        found = [rates(table[name].to_numpy()) for name in table]
        for i, row in enumerate(table.to_numpy()):
            eoc = ["-" if i == 0 else f"{r[i]:.2f}" for r in found]
            lines += ["".join(f"{v:<10.2e}{r:<10}" for v, r in zip(row, eoc, strict=True))]
        means = "".join(f"{'mean':<10}{np.nanmean(r):<10.2f}" for r in found)
        lines += ["", means, "-" * 100]
    return "\n".join(lines) + "\n"
