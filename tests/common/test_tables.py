"""Tables of text are read as they are printed: the same numbers, names and places come back."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from printed_tables import DEALII, WRITERS, rates, trixi

from esfem.common.bad_input import BadInput
from esfem.common.decoding import decoded
from esfem.common.tables import decimal_mark, number, parsed, table_in, tables_in

NAMES = ("h", "tau", "L2", "H1 error", "u", "err_x", "cpu time", "DoFs")


@st.composite
def tables(draw) -> pd.DataFrame:
    """Columns of numbers with four significant digits; some are missing, not in the first one."""
    levels = draw(st.integers(3, 7))
    names = draw(st.permutations(NAMES))[: draw(st.integers(2, 5))]
    columns = {}
    for j, name in enumerate(names):
        start, order = draw(st.floats(1e-3, 90.0)), draw(st.floats(0.3, 4.0))
        values = start * 0.5 ** (order * np.arange(levels))
        if j and draw(st.booleans()):
            values[draw(st.integers(1, levels - 1))] = np.nan
        columns[name] = [float(f"{v:.3e}") for v in values]
    return pd.DataFrame(columns)


def as_numbers(text: str) -> pd.DataFrame:
    """What is read, without columns that have no name."""
    table = table_in(text)
    mark = decimal_mark(cell for row in table.rows for cell in row.cells)
    assert mark is not None
    columns = {
        name: [number(cell, mark) for cell in table.column(i)]
        for i, name in enumerate(table.names)
        if name not in ("", "..")
    }
    assert len(columns) + ("" in table.names or ".." in table.names) == len(table.names)
    return pd.DataFrame(columns)


@pytest.mark.parametrize("dialect", WRITERS)
@settings(max_examples=25, deadline=None)
@given(table=tables())
def test_what_was_printed_is_read(dialect, table):
    printed = WRITERS[dialect](_spaceless(table) if dialect in ONE_WORD else table)
    read = as_numbers(printed)
    wanted = _spaceless(table) if dialect in ONE_WORD else table
    assert list(read) == list(wanted), printed
    np.testing.assert_array_equal(read.to_numpy(), wanted.to_numpy(), err_msg=printed)


# Where single blanks part the names, names are one word.
ONE_WORD = ("savetxt", "Fortran", "Fortran, three digits")


def _spaceless(table: pd.DataFrame) -> pd.DataFrame:
    return table.rename(columns=lambda name: name.replace(" ", "_"))


MARKS = {
    "comma": ",",
    "semicolon": ";",
    "tab": "\t",
    "Fortran": " ",
    "tabulate orgtbl": "|",
    "num of siunitx": "&",
}


@pytest.mark.parametrize("dialect", MARKS)
@settings(max_examples=30, deadline=None)
@given(table=tables(), at=st.integers(0, 6), longer=st.booleans(), data=st.data())
def test_a_row_of_another_length_is_refused_and_shifts_nothing(dialect, table, at, longer, data):
    """One field more or less, in a row or in the names."""
    mark = MARKS[dialect]
    table = _spaceless(table.fillna(1.0))
    lines = WRITERS[dialect](table).split("\n")
    rows = [i for i, line in enumerate(lines) if mark in line.strip() and "---" not in line]
    i = rows[at % len(rows)]
    fields = lines[i].split(mark) if mark != " " else lines[i].split()
    j = data.draw(st.integers(1, len(fields) - 1))
    fields[j:j] = ["7.0"] if longer else []
    if not longer:
        del fields[j if mark != "|" else max(1, j - 1)]
    lines[i] = (mark if mark != " " else "  ").join(fields)
    try:
        read = as_numbers("\n".join(lines))
    except (ValueError, AssertionError):  # refused
        return
    for name in read:
        wanted = table.get(name, read[name])
        np.testing.assert_array_equal(read[name], wanted, err_msg="\n".join(lines))


@settings(max_examples=40, deadline=None)
@given(table=tables(), width=st.integers(1, 3))
def test_pandas_as_print_shows_it_is_read_to_its_digits(table, width):
    """Without a format pandas chooses its own digits: six or seven."""
    read = as_numbers(table.to_string())
    assert list(read) == list(table)
    wanted = table.to_numpy()
    near = np.isclose(read.to_numpy(), wanted, rtol=1e-5, atol=1e-6, equal_nan=True)
    assert near.all(), table.to_string()


@st.composite
def convergence_tables(draw) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Cells and unknowns of uniform refinement, and errors in some norms."""
    levels, dim = draw(st.integers(3, 6)), draw(st.integers(1, 3))
    sides = draw(st.integers(2, 9)) * 2 ** np.arange(levels)
    counts = pd.DataFrame({"cycle": range(levels), "cells": sides**dim, "dofs": (sides + 1) ** dim})
    counts = counts[list(draw(st.permutations(list(counts)))[: draw(st.integers(1, 3))])]
    names = draw(
        st.permutations(
            ["L2", "H1", "$L^2$-error", "||u-u_h||_H1", "val L2", "grad L2", "val L2-post"]
        )
    )
    errors = {}
    for name in names[: draw(st.integers(1, 3))]:
        wiggle = np.exp(
            0.02 * np.array(draw(st.lists(st.floats(-1, 1), min_size=levels, max_size=levels)))
        )
        e = draw(st.floats(1e-3, 9.0)) * 0.5 ** (draw(st.floats(0.6, 4.0)) * np.arange(levels))
        errors[name] = [float(f"{v:.3e}") for v in e * wiggle]
    return counts, pd.DataFrame(errors)


@pytest.mark.parametrize("kind", DEALII)
@settings(max_examples=40, deadline=None)
@given(both=convergence_tables())
def test_deal_ii_is_read_as_it_is_printed(kind, both):
    counts, errors = both
    text = DEALII[kind](counts, errors)
    table = table_in(text)
    for name, values in (*counts.items(), *errors.items()):
        at = table.names.index(name)
        np.testing.assert_array_equal([number(c) for c in table.column(at)], values, err_msg=text)
        if name in errors:
            printed = [number(c) for c in table.column(at + 2)]
            np.testing.assert_allclose(printed, rates(values.to_numpy()), atol=0.006)


@settings(max_examples=40, deadline=None)
@given(
    both=convergence_tables(),
    names=st.sampled_from([["scalar"], ["rho", "rho_v1"], ["a", "b", "c"]]),
)
def test_trixi_is_read_as_it_is_printed(both, names):
    _, errors = both
    values = [float(f"{v:.2e}") for v in errors.iloc[:, 0]]
    tables = {
        norm: pd.DataFrame({name: np.array(values) * (i + 1) for i, name in enumerate(names)})
        for norm in ("l2", "linf")
    }
    table = table_in(trixi(tables))
    assert table.halves and len(table.rows) == len(values)
    for norm, wanted in tables.items():
        for name in names:
            read = [number(c) for c in table.column(table.names.index(f"{norm} {name}"))]
            np.testing.assert_allclose(read, wanted[name], rtol=6e-3)


def test_trixi_s_blocks_lose_no_row():
    """Not below an empty line, nor where a terminal has broken the lines."""
    text = trixi({"l2": pd.DataFrame({"rho": [0.1, 0.025, 0.00625], "v": [0.1, 0.05, 0.025]})})
    lines = text.split("\n")
    assert len(table_in("\n".join([*lines[:5], "", *lines[5:]])).rows) == 3
    broken = "\n".join([*lines[:5], lines[5][:30], lines[5][30:], *lines[6:]])
    with pytest.raises(BadInput, match="line 6: has 3 fields, and there are 4 names in line 4"):
        table_in(broken)


STEP_7 = """\
n cells         H1                   L2
0    64 2.858e+00    -    - 1.840e+00     -    -
1   256 1.199e+00 2.38 1.25 3.570e-02 51.54 5.69
2  1024 7.565e-01 1.58 0.66 1.192e-02  2.99 1.58
"""


def test_a_table_of_deal_ii_s_documents_is_read():
    """A name over two columns without rates, too."""
    table = table_in(STEP_7)
    assert table.names[:3] == ("n", "cells", "H1") and table.names[5] == "L2"
    assert table.column(1) == ("64", "256", "1024")
    assert table.column(5) == ("1.840e+00", "3.570e-02", "1.192e-02")
    assert table.dialect == "deal.II's ConvergenceTable"


STEP_51 = """\
cells dofs      val L2        grad L2      val L2-post
   16    80 1.804e+01    - 2.207e+01    - 1.798e+01    -
   36   168 6.125e+00 2.66 9.472e+00 2.09 6.084e+00 2.67
   64   288 9.785e-01 6.38 4.260e+00 2.78 7.102e-01 7.47
 9216 37248 4.690e-03 1.97 3.228e-02 1.97 1.599e-04 2.96
"""


def test_names_of_two_words_over_errors_and_rates_shift_none():
    """Eight words stand above eight columns, and are five names."""
    table = table_in(STEP_51)
    assert table.names == (
        *("cells", "dofs", "val L2", "val L2 (rate)", "grad L2", "grad L2 (rate)"),
        *("val L2-post", "val L2-post (rate)"),
    )
    assert table.column(4)[0] == "2.207e+01"


CONSOLE = f"""\
Solving with Q1 elements, global refinement
===========================================

Cycle 0:
   Number of active cells:       64
   Number of degrees of freedom: 81
Cycle 1:
   Number of active cells:       256
   Number of degrees of freedom: 289

cycle cells dofs     L2        H1      Linfty
    0    64    81 1.840e+00 2.858e+00 1.835e+00
    1   256   289 3.570e-02 1.199e+00 1.307e-01

{STEP_7}
"""


class TestConsole:
    """What a program prints of its run, pasted whole."""

    def test_has_its_tables(self):
        names = [table.names[:3] for table in tables_in(CONSOLE)]
        assert names == [("cycle", "cells", "dofs"), ("n", "cells", "H1")]
        assert table_in(CONSOLE, 2).column(1) == ("64", "256", "1024")

    def test_one_table_in_it_needs_no_choice(self):
        head, _, table = CONSOLE.partition("cycle cells")
        text = head + "cycle cells" + table.partition("\n\n")[0]
        assert table_in(text).names[-1] == "Linfty"

    @pytest.mark.parametrize("row", ["2 1024", "2  1024  1089 1.192e-02 7.565e-01 7.168e-02 9.0"])
    def test_a_row_apart_is_not_lost(self, row):
        """Below an empty line, and of another length: it may belong to the table above."""
        with pytest.raises(BadInput):
            tables_in(f"{CONSOLE}\n{row}\n")


class TestOddities:
    def test_a_text_above_the_names_is_no_row(self):
        assert table_in("Results for P2, run 12\n\nh  L2 error\n0.5  1\n0.25  0.25\n").names == (
            *("h", "L2 error"),
        )

    @pytest.mark.parametrize(
        "fence", [("```text", "```"), ("@code", "@endcode"), ("<pre>", "</pre>")]
    )
    def test_fences_around_a_table_are_no_rows(self, fence):
        table = table_in(f"{fence[0]}\n{STEP_7}{fence[1]}\n")
        assert table.names == table_in(STEP_7).names and len(table.rows) == 3

    def test_two_lines_of_names_in_latex_are_one(self):
        text = r"""\begin{tabular}{rrr}
        & \multicolumn{2}{c}{$L^2$} \\ \cmidrule(lr){2-3}
        {$h$} & {error} & {EOC} \\ \midrule
        $2^{-1}$ & \num{1e-1} & --- \\
        $\frac{1}{4}$ & \textbf{2.5e-2} & 2.00 \\[2pt]
        \end{tabular}"""
        table = table_in(text)
        assert [name.replace("{", "").replace("}", "") for name in table.names] == [
            *("$h$", "$L^2$ error", "$L^2$ EOC"),
        ]
        assert [number(cell) for cell in table.column(0)] == [0.5, 0.25]

    def test_names_and_cells_are_shown_on_one_line(self):
        """Whatever a quoted field holds: no line of ours is broken, no terminal is steered."""
        table = table_in('h,"L2\nerror","a\x1b[2Jb"\n0.5,1,"x\ty"\n')
        assert table.names == ("h", "L2 error", "a [2Jb")
        assert table.rows[0].cells[2] == "x y" and table.rows[0].line == 3
        with pytest.raises(BadInput, match=r"fields \(1, \[2J, 3\)"):
            table_in("h,e\n1,\x1b[2J,3\n")

    def test_one_of_several_tables_is_chosen(self):
        text = "# Notes\n\n| h | L2 |\n|---|---|\n| 1 | 2 |\n\ntext\n\n"
        text += "| n | H1 |\n|---|---|\n| 3 | 4 |\n"
        assert [table.names for table in tables_in(text)] == [("h", "L2"), ("n", "H1")]
        with pytest.raises(BadInput, match=r"2 tables \(1: h, L2; 2: n, H1\): choose with --table"):
            table_in(text)
        assert table_in(text, 2).column(1) == ("4",)
        with pytest.raises(BadInput, match="must be 1 to 2"):
            table_in(text, 3)

    def test_numbers_without_names_are_numbered(self):
        table = table_in("0.5 1.0\n0.25 0.25\n")
        assert table.names == ("1", "2") and not table.named

    def test_an_index_of_pandas_shifts_no_column(self):
        """Names of two words look like one name more."""
        frame = pd.DataFrame({"h": [0.5, 0.25], "L2 error": [0.1, 0.025]})
        table = table_in(frame.to_string())
        assert table.names == ("", "h", "L2 error") and table.column(1) == ("0.50", "0.25")

    def test_the_name_of_an_index_of_pandas_is_none_of_its_columns(self):
        """Two words in a line of its own, above two columns."""
        frame = pd.DataFrame({"mesh size": ["1.0e-01", "5.0e-02"], "L2": [0.1, 0.025]})
        table = table_in(frame.set_index("mesh size").to_string())
        assert table.names == ("mesh size", "L2") and table.column(0) == ("1.0e-01", "5.0e-02")
        table = table_in("         Results\nh error\n1.0e-01 0.1\n5.0e-02 0.025\n")
        assert table.names == ("h", "error")

    def test_pandas_breaks_wide_tables_into_blocks(self):
        names = [f"L2 error of u_{i}" for i in range(8)]
        frame = pd.DataFrame({name: 0.5 ** np.arange(4) / (i + 1) for i, name in enumerate(names)})
        text = frame.to_string(line_width=60, float_format="{:.6e}".format)
        assert "\\" in text
        table = table_in(text)
        assert table.names == ("", *names)
        for i, name in enumerate(names, start=1):
            read = [number(cell) for cell in table.column(i)]
            np.testing.assert_allclose(read, frame[name], rtol=1e-6)
        assert [row.cells[0] for row in table.rows] == ["0", "1", "2", "3"]
        with pytest.raises(BadInput, match=r"blocks .* have rows 3 and 7 beside each other"):
            table_in("\n7 ".join(text.rsplit("\n3 ", 1)))

    @pytest.mark.parametrize(
        "text",
        [
            "2×2 DataFrame\n Row │ h        L2      \n     │ Float64  Float64 \n"  # noqa: RUF001
            "─────┼──────────────────\n   1 │    0.5      1.0\n   2 │   0.25     0.25\n",
            "# A tibble: 2 x 2\n      h    L2\n  <dbl> <dbl>\n1  0.5   1   \n2  0.25  0.25\n",
            "     h   L2\n1 0.50 1.00\n2 0.25 0.25\n",
        ],
        ids=["Julia", "tibble", "R"],
    )
    def test_frames_of_julia_and_r_have_numbers_of_rows(self, text):
        table = table_in(text)
        assert table.names[-2:] == ("h", "L2") and len(table.rows) == 2
        assert [[number(c) for c in row.cells[-2:]] for row in table.rows] == [
            *([0.5, 1.0], [0.25, 0.25]),
        ]

    def test_boxes_of_unicode_are_bars(self):
        text = "┌─────┬─────┐\n│ h   ┆ L2  │\n│ --- ┆ --- │\n│ f64 ┆ f64 │\n"
        text += "╞═════╪═════╡\n│ 0.5 ┆ 1.0 │\n└─────┴─────┘\n"
        table = table_in(text)
        assert table.names == ("h", "L2") and table.column(0) == ("0.5",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("  \n\n", "is empty"),
        ("h,error\n", "no rows below its names h, error"),
        ("h,error\n1,2,3\n", r"row 1 \(line 2\): has 3 fields \(1, 2, 3\), and there are 2 names"),
        ("h,error\n\n1,2\n3\n", r"row 2 \(line 4\): has 1 field \(3\)"),
        ("h error\n1 2\n3 4 5\n", r"row 2 \(line 3\): has 3 fields"),
        ("h;error\n1;2;3\n", r"row 1 \(line 2\): has 3 fields"),
        ("| h | e |\n|---|---|\n| 1 | 2 | 3 |\n", r"row 1 \(line 3\): has 3 fields"),
        ("\\begin{tabular}{ll}\nh & e \\\\\n1 & 2 & 3 \\\\\n\\end{tabular}", r"\(line 3\): has 3"),
        ("\\begin{tabular}{ll}\nh & e \\\\\n1 & 2 \\\\\n", "does not end"),
        ('h,error\n"1,2\n3,4\n', "line 2 cannot be read"),
        ("0.5 1\n0.25 2 3\n", r"row 2 \(line 2\): has 3 fields .* are 2 in row 1"),
    ],
)
def test_what_is_no_table_is_refused_by_its_line(text, said):
    with pytest.raises(BadInput, match=said):
        table_in(text)


class TestNumbers:
    @pytest.mark.parametrize(
        ("cell", "value"),
        [
            *(
                ("2.5D-01", 0.25),
                ("1.5d0", 1.5),
                ("0.41-102", 4.1e-103),
                (".25", 0.25),
                ("1.", 1.0),
            ),
            *(("1/8", 0.125), ("$1/8$", 0.125), (r"\frac{1}{8}", 0.125), ("$2^{-3}$", 0.125)),
            *((r"\num{4.1e-2}", 0.041), (r"$4.1\cdot10^{-2}$", 0.041), ("4.1×10⁻²", 0.041)),  # noqa: RUF001
            *(("4.1 x 10^-2", 0.041), ("4.1*^-2", 0.041), ("−3", -3.0), ("1'024", 1024.0)),  # noqa: RUF001
            *(
                ("1,024", 1024.0),
                ("1 024", 1024.0),
                ("**4e-2**", 0.04),
                (r"4\%", 0.04),
                ("+1", 1.0),
            ),
            *(("16×16", 16.0), ("8 x 8 x 8", 8.0)),  # noqa: RUF001
            *(("pi/8", np.pi / 8), (r"$2\pi/16$", np.pi / 8), ("0.5π", np.pi / 2)),
            *(("inf", np.inf), ("-Infinity", -np.inf), (r"$\infty$", np.inf), ("1.#INF", np.inf)),
        ],
    )
    def test_forms(self, cell, value):
        assert number(cell) == pytest.approx(value, rel=1e-15)

    @pytest.mark.parametrize(
        "cell",
        ["", "-", "--", "---", "\u2013", "NaN", "n/a", "None", "<NA>", "{-}", "#NV", "#DIV/0!"],
    )
    def test_missing(self, cell):
        assert np.isnan(number(cell))

    @pytest.mark.parametrize(
        "cell", ["mean", "0,25", "4 8", "****", "0.1.2", "1e", "x", "1..2", "h", "16x8"]
    )
    def test_no_numbers(self, cell):
        assert parsed(cell) is None

    @pytest.mark.parametrize(
        ("cells", "mark"),
        [
            (["0.25", "4e-2"], "point"),
            (["0,25", "4,1E-02"], "comma"),
            (["0,250", "0,125"], "comma"),
            (["1,024", "4.1e-2"], "point"),
            (["1.024,5"], "comma"),
            (["1,024.5"], "point"),
            (["0,25", "1.089"], "comma"),
            (["1,024", "4,096"], None),
        ],
    )
    def test_decimal_mark(self, cells, mark):
        assert decimal_mark(cells) == mark

    def test_with_decimal_commas_a_point_parts_thousands_or_is_no_number(self):
        assert number("1.089", "comma") == 1089 and parsed("0.041", "comma") is None

    @given(st.floats(allow_nan=False, allow_infinity=False))
    def test_what_python_writes_is_read(self, value):
        assert number(repr(value)) == value


class TestDecoding:
    TEXT = "h,Fehler\n0.5,größer\n"

    @pytest.mark.parametrize(
        "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]
    )
    def test_of_unicode(self, encoding):
        assert decoded(self.TEXT.encode(encoding)) == self.TEXT

    def test_others_are_named_by_byte_and_line_and_read_on_request(self):
        content = self.TEXT.encode("cp1252")
        with pytest.raises(BadInput, match=r"UTF-8 text: byte 0xf6 in line 2; .*--encoding cp1252"):
            decoded(content)
        assert decoded(content, "cp1252") == self.TEXT
        with pytest.raises(BadInput, match="--encoding utf-9: is unknown"):
            decoded(content, "utf-9")

    def test_binary_is_no_text(self):
        with pytest.raises(BadInput, match="cannot be read"):
            decoded(b"PK\x03\x04\0\0\0\x08")
