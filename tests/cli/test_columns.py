"""Which columns are taken for what: by names that all know, numbers of cells, printed rates."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from printed_tables import DEALII, WRITERS, joined, trixi

from esfem.cli.column_names import derivatives, kind, norm
from esfem.cli.column_reader import Asked
from esfem.cli.columns import chosen_columns
from esfem.cli.judge_options import claims, parsed_floors, parsed_levels, parsed_orders
from esfem.cli.series import Claim
from esfem.common.bad_input import BadInput
from esfem.common.tables import table_in


def chosen(text, **asked):
    return chosen_columns(table_in(text), Asked(**asked))


def of_columns(**columns):
    return joined(pd.DataFrame(columns), ",", lambda v: f"{v:.6g}")


H = np.array([0.25, 0.125, 0.0625, 0.03125])
E = np.array([4.1e-2, 1.04e-2, 2.61e-3, 6.53e-4])


class TestNames:
    @pytest.mark.parametrize(
        "name",
        [
            *("h", "H", "hmax", "h_max", "$h$", r"$h_{\max}$", "dx", r"$\Delta x$", "Δx", "h [m]"),
            *("mesh size", "mesh size h", "Gitterweite", "Schrittweite h"),
        ],
    )
    def test_of_mesh_widths(self, name):
        assert kind(name) == "h"

    @pytest.mark.parametrize(
        "name", ["tau", "τ", r"$\tau$", "dt", "Δt", r"$\Delta t$", "time step"]
    )
    def test_of_time_steps(self, name):
        assert kind(name) == "tau"

    @pytest.mark.parametrize(
        "name", ["n", "N", "cells", "n cells", "# cells", r"\# cells", "nx", "1/h"]
    )
    def test_of_cells(self, name):
        assert kind(name) == "cells"

    @pytest.mark.parametrize("name", ["dofs", "n_dofs", "# DoFs", "ndof", "unknowns", "# of dofs"])
    def test_of_unknowns(self, name):
        assert kind(name) == "dofs"

    @pytest.mark.parametrize(
        ("name", "of"),
        [
            *(
                ("error", ""),
                ("Error", ""),
                ("err", ""),
                ("Fehler", ""),
                ("err_x", ""),
                ("e_h", ""),
            ),
            *(("L2", "l2"), ("l2_error", "l2"), ("L2 error", "l2"), ("e_L2", "l2"), ("eL2", "l2")),
            *(("$L^2$-error", "l2"), (r"$\|u-u_h\|_{L^2(\Omega)}$", "l2"), ("p_L2_error", "l2")),
            *(("Linfty", "linf"), ("L∞", "linf"), (r"$L^\infty$", "linf"), ("Max error", "linf")),
            *(("H1", "h1"), ("|u|_H1", "h1"), ("errH1", "h1"), ("l2 rho", "l2"), ("L1", "l1")),
            ("||u-u_h||", ""),
        ],
    )
    def test_of_errors_and_their_norms(self, name, of):
        assert kind(name) == "error" and norm(name) == of

    @pytest.mark.parametrize(
        "name",
        [
            *("rate", "rate_l2", "L2 rate", "L2...red.rate", "L2...red.rate.log2", "EOC", "order"),
            *("l2 rho EOC", "L2 (rate)", "L2 order", "eoc_L2", "$L^2$ EOC"),
        ],
    )
    def test_of_rates(self, name):
        assert kind(name) == "rate"

    @pytest.mark.parametrize("name", ["cycle", "time", "cg", "cpu", "nu", "E", "iterations", ""])
    def test_others_are_not_guessed(self, name):
        assert kind(name) == ""

    def test_norms_of_derivatives_lose_orders(self):
        assert [derivatives(n) for n in ("L2", "Linf", "error", "H1", "energy", "H2")] == [
            *(0, 0, 0, 1, 1, 2),
        ]


class TestWidths:
    def test_h_itself_comes_first(self):
        found = chosen(of_columns(n=1 / H, dofs=(1 + 1 / H) ** 2, h=H, dx=H / 2, L2=E))
        assert "h: h; errors: L2" in found.said
        np.testing.assert_allclose(found.series[0].h, H)

    def test_cells_in_a_direction_are_inverted(self):
        found = chosen(of_columns(N=1 / H, L2=E))
        assert "h: 1 / N" in found.said
        np.testing.assert_allclose(found.series[0].h, H)

    @pytest.mark.parametrize("dim", [1, 2, 3])
    def test_unknowns_need_the_dimension(self, dim):
        text = of_columns(dofs=H ** -float(dim), L2=E)
        np.testing.assert_allclose(chosen(text, dofs="dofs", dim=dim).series[0].h, H, rtol=1e-5)
        with pytest.raises(BadInput, match="--dofs dofs --dim"):
            chosen(text)
        with pytest.raises(BadInput, match="needs --dim"):
            chosen(text, dofs="dofs")

    def test_a_number_that_grows_by_four_is_unclear(self):
        text = of_columns(cells=H**-2.0, L2=E)
        with pytest.raises(BadInput, match=r"--cells cells\) or of all \(--cells cells --dim 2"):
            chosen(text)
        np.testing.assert_allclose(chosen(text, cells="cells", dim=2).series[0].h, H)
        np.testing.assert_allclose(chosen(text, cells="cells").series[0].h, H**2)

    @pytest.mark.parametrize("dim", [1, 2, 3])
    def test_printed_rates_tell_the_dimension(self, dim):
        """The same numbers of cells, and rates as a program in that dimension prints them."""
        log = np.log(E[:-1] / E[1:]) / np.log(H[:-1] ** -2.0 / H[1:] ** -2.0)
        rates = ",".join(["-", *(f"{-dim * r:.2f}" for r in log)]).split(",")
        rows = zip(H**-2.0, E, rates, strict=True)
        text = "cells,L2,rate\n" + "\n".join(f"{n:g},{e:g},{r}" for n, e, r in rows)
        found = chosen(text)
        assert "as the rates beside L2 say" in found.said
        np.testing.assert_allclose(found.series[0].h, H ** (2.0 / dim))

    @pytest.mark.parametrize("printed", DEALII)
    def test_deal_ii_needs_no_options(self, printed):
        counts = pd.DataFrame({"cycle": range(4), "cells": [16, 64, 256, 1024]})
        text = DEALII[printed](counts, pd.DataFrame({"L2": E, "H1": np.sqrt(E)}))
        found = chosen(text)
        assert "h: cells^(-1/2), as the rates beside L2 say; errors: L2, H1" in found.said
        np.testing.assert_allclose(found.series[0].h, H)
        np.testing.assert_allclose(found.series[1].error, np.sqrt(E), rtol=1e-3)

    @pytest.mark.parametrize("order", [1, 2])
    def test_a_reduction_is_no_rate(self, order):
        """In one dimension errors of order 1 and 2 fall by 2 and 4, which are rates in two."""
        e = 0.3 * H**order
        text = "cells,L2,rate\n" + "".join(
            f"{1 / h:g},{v:g},{2.0**order if i else '-'}\n"
            for i, (h, v) in enumerate(zip(H, e, strict=True))
        )
        assert "h: 1 / cells; errors" in chosen(text).said

    def test_rates_alone_may_say_that_h_is_halved(self):
        text = "L2,EOC\n" + "\n".join(
            f"{e:g},{r}" for e, r in zip(E, ["-", "1.98", "1.99", "2.00"], strict=True)
        )
        found = chosen(text)
        assert "halved from row to row" in found.said
        np.testing.assert_allclose(found.series[0].h, [1, 0.5, 0.25, 0.125])

    def test_rates_of_another_ratio_say_nothing(self):
        text = "L2,EOC\n4.1e-2,-\n1.04e-2,0.99\n2.61e-3,1.0\n6.53e-4,1.0\n"
        with pytest.raises(BadInput, match="--ratio R"):
            chosen(text)
        np.testing.assert_allclose(chosen(text, ratio=0.25).series[0].h[1], 0.25)

    def test_trixi_halves(self):
        tables = {norm: pd.DataFrame({"rho": E, "v": E / 2}) for norm in ("l2", "linf")}
        found = chosen(trixi(tables))
        assert "halved from row to row, as Trixi does" in found.said
        assert [s.name for s in found.series] == ["l2 rho", "l2 v", "linf rho", "linf v"]

    def test_trixi_halves_unless_its_rates_say_another_thing(self):
        text = trixi({"l2": pd.DataFrame({"rho": E})})
        assert "1.98" in text
        with pytest.raises(BadInput, match="l2 rho are not those of meshes that are halved"):
            chosen(text.replace("1.98", "0.99"))
        two = trixi({"l2": pd.DataFrame({"rho": E[:2]})})
        assert "as Trixi does" in chosen(two).said

    def test_the_numbers_of_the_levels_are_no_cells(self):
        with pytest.raises(BadInput, match="no column of mesh widths"):
            chosen(of_columns(n=[0, 1, 2, 3], L2=E))
        with pytest.raises(BadInput, match="no column of mesh widths"):
            chosen(of_columns(n=[1, 2, 3, 4], L2=E))

    def test_a_study_in_time_needs_no_h(self):
        found = chosen(of_columns(dt=H, error=E))
        assert found.series[0].h is None
        np.testing.assert_allclose(found.series[0].tau, H)

    def test_printed_rates_that_are_not_those_of_h_are_mentioned(self):
        rows = zip(H**2, E, ["-", "1.98", "1.99", "2.00"], strict=True)
        text = "h,L2,rate\n" + "\n".join(f"{h:g},{e:g},{r}" for h, e, r in rows)
        said = chosen(text).said
        assert "mind: row 4 (line 5) prints a rate of 2 for L2, and it is 0.999 in this h" in said
        assert "mind" not in chosen(text, ratio=0.5).said

    def test_two_options_for_one_thing_are_refused(self):
        with pytest.raises(BadInput, match="--h and --cells: give one"):
            chosen(of_columns(h=H, L2=E), h="h", cells="h")

    def test_without_names_columns_are_asked_for_by_number(self):
        text = "\n".join(f"{h} {e}" for h, e in zip(H, E, strict=True))
        with pytest.raises(BadInput, match="columns without names"):
            chosen(text)
        np.testing.assert_allclose(chosen(text, h="1", errors=("2",)).series[0].error, E)


class TestErrors:
    def test_several_errors_are_several_series(self):
        found = chosen(of_columns(h=H, L2=E, H1=np.sqrt(E), cpu=E))
        assert [s.name for s in found.series] == ["L2", "H1"]

    def test_columns_are_found_whatever_their_case(self):
        found = chosen(of_columns(H=H, Fehler=E, u=E * 2), errors=("U",))
        np.testing.assert_allclose(found.series[0].error, 2 * E)

    def test_an_unknown_column_is_told_with_those_there_are(self):
        with pytest.raises(BadInput, match="--error L3: there is no such column; there are h, L2"):
            chosen(of_columns(h=H, L2=E), errors=("L3",))
        with pytest.raises(BadInput, match="no column of errors is known among h, u"):
            chosen(of_columns(h=H, u=E))

    def test_two_columns_of_one_name_are_refused(self):
        with pytest.raises(BadInput, match="2 columns are called so"):
            chosen("h,L2,L2\n1,1,1\n", errors=("L2",))
        with pytest.raises(BadInput, match="2 columns are called L2: give them two names"):
            chosen("h,L2,L2\n1,1,1\n")

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            ("h,error\n1,1\n0.5,oops\n", r"row 2 \(line 3\), column error: 'oops' is no number"),
            ("h,error\nx,1\n0.5,2\n0.25,3\n", r"row 1 \(line 2\), column h: 'x' is no number"),
            ("h;error\n0,5;0,1\n0,25;0.05\n", r"'0.05' is no number with a decimal comma"),
            ("h;error\n1,024;2,048\n", "--decimal comma or --decimal point"),
            ("h,error,status\n1,1,ok\n0.5,1,maybe\n", r"row 2 .*column status: 'maybe' is unknown"),
            ("   h  error\n0  1    1\n..  ..   ..\n9  0.5  1\n", "rows were cut out"),
        ],
    )
    def test_what_is_no_number_is_refused_by_its_place(self, text, said):
        with pytest.raises(BadInput, match=said):
            chosen(text)

    def test_an_open_decimal_mark_is_closed_by_its_option(self):
        text = "h;error\n1,024;2,048\n"
        assert chosen(text, decimal="comma").series[0].h[0] == 1.024
        assert chosen(text, decimal="point").series[0].h[0] == 1024

    def test_a_row_of_means_is_left_out_and_said(self):
        found = chosen("n,h,error\n1,0.5,1\n2,0.25,0.3\n4,0.125,0.1\nmean,1.7,\n")
        assert len(found.series[0]) == 3
        assert "left out: row 4 (line 5), without an error" in found.said

    def test_a_run_without_an_error_is_kept(self):
        assert len(chosen("h,error\n0.5,1\n0.25,\n0.125,0.1\n").series[0]) == 3

    def test_a_run_that_failed_is_kept_with_its_word(self):
        assert chosen("h,error,status\n1,1,converged\n0.5,1,Diverged\n").series[0].status == (
            *("ok", "diverged"),
        )

    def test_variables_below_each_other_are_series(self):
        text = "variable,h,error\nu,0.5,1\np,0.5,2\nu,0.25,3\np,0.25,4\n"
        found = chosen(text)
        assert [(s.name, list(s.error)) for s in found.series] == [("u", [1, 3]), ("p", [2, 4])]
        assert [s.name for s in chosen(text, variable="p").series] == ["p"]


ODD = "0123456789.,;|\t \n-+eE&\\\\{}#%\"'hLN$=_/*^()[]\u03c0\u2026\u00a0"


@settings(max_examples=150, deadline=None)
@given(
    kind=st.sampled_from([*WRITERS, *DEALII]),
    edits=st.lists(st.tuples(st.floats(0, 1), st.sampled_from(["", *ODD])), max_size=6),
)
def test_whatever_the_text_it_is_read_or_refused_in_words(kind, edits):
    """Letters lost or added anywhere: no error but BadInput."""
    errors = pd.DataFrame({"L2 error": E, "H1": np.sqrt(E)})
    if kind in DEALII:
        text = DEALII[kind](pd.DataFrame({"cells": [16, 64, 256, 1024]}), errors)
    else:
        text = WRITERS[kind](errors.assign(h=H))
    for place, letter in edits:
        i = int(place * len(text))
        text = text[:i] + letter + text[i + (not letter) :]
    try:
        found = chosen(text)
    except BadInput as error:
        assert len(str(error)) > 10
    else:
        assert all(len(one) for one in found.series)


class TestClaims:
    SERIES = chosen(of_columns(h=H, L2=E, Linf=E, H1=E)).series

    def claimed(self, *orders, chosen=False, series=SERIES, **common):
        found = claims(series, parsed_orders(orders), Claim(order=1.0, **common), chosen)
        return {one.name: claim.order for one, claim in found}

    def test_each_column_has_its_own_order(self):
        assert self.claimed("L2=2", "linf=2", "H1=1") == {"L2": 2, "Linf": 2, "H1": 1}

    def test_what_has_no_order_is_not_judged_unless_it_was_chosen(self):
        assert self.claimed("L2=2") == {"L2": 2}
        with pytest.raises(BadInput, match="--order: is missing for Linf, H1"):
            self.claimed("L2=2", chosen=True)

    def test_one_order_is_none_for_norms_of_different_orders(self):
        with pytest.raises(BadInput, match="L2 and H1 are norms of different orders"):
            self.claimed("2")
        assert self.claimed("2", series=self.SERIES[:2]) == {"L2": 2, "Linf": 2}
        assert self.claimed("2", "H1=1") == {"L2": 2, "Linf": 2, "H1": 1}

    def test_a_norm_names_all_its_variables(self):
        series = chosen(of_columns(h=H, **{"l2 rho": E, "l2 v": E, "linf rho": E})).series
        assert self.claimed("l2=4", series=series) == {"l2 rho": 4, "l2 v": 4}
        assert self.claimed("l2 v=3", series=series) == {"l2 v": 3}

    def test_the_order_in_the_other_parameter_is_known_by_its_name(self):
        found = claims(self.SERIES[:1], {"": 2.0, "tau": 1.0}, Claim(order=1.0), False)
        assert (found[0][1].order, found[0][1].other_order) == (2, 1)
        found = claims(self.SERIES[:1], {"h": 2.0, "tau": 1.0}, Claim(1.0, direction="tau"), False)
        assert (found[0][1].order, found[0][1].other_order) == (1, 2)

    def test_a_label_that_names_nothing_is_refused(self):
        with pytest.raises(BadInput, match=r"--order H2=3: no errors are called so; there are L2"):
            self.claimed("H2=3")

    @pytest.mark.parametrize("option", ["0", "-1", "nan", "inf", "l2=", "l2=x", ""])
    def test_an_order_is_positive_and_finite(self, option):
        with pytest.raises(BadInput, match="--order"):
            parsed_orders([option])

    def test_an_order_is_given_once(self):
        with pytest.raises(BadInput, match="an order of l2 is given"):
            parsed_orders(["l2=2", "l2=3"])

    @pytest.mark.parametrize("option", ["rounding", "rounding=-1", "noise=1e-3", "rounding=x"])
    def test_a_floor_has_a_known_name_and_a_size(self, option):
        with pytest.raises(BadInput, match="--floor"):
            parsed_floors([option])

    @pytest.mark.parametrize(
        ("option", "levels"), [(":", (0, None)), ("3:", (2, None)), (":4", (0, 4)), ("2:3", (1, 3))]
    )
    def test_levels_are_counted_from_the_coarsest(self, option, levels):
        assert parsed_levels(option) == levels

    @pytest.mark.parametrize("option", ["3", "0:", "3:2", "a:b", ""])
    def test_other_levels_are_refused(self, option):
        with pytest.raises(BadInput, match="--levels"):
            parsed_levels(option)
