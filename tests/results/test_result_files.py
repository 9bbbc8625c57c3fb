"""The files of a study: complete, readable by others, and not written twice."""

import json
import re
import shutil
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from shortcuts import SAVE, saved_by
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.judging.eoc import rates
from esfem.measuring.lift import VARIABLES
from esfem.report.sections import errors as errors_of
from esfem.report.write import write_report
from esfem.results.plots import energy_figure, error_figure, known_energies
from esfem.results.records_file import read_records
from esfem.results.remarks import energy_lines
from esfem.results.result_files import (
    PLOTS,
    TABLES,
    file_digest,
    load_result,
    own_digest,
    read_verdicts,
    write_results,
)
from esfem.results.run_studies import run_studies
from esfem.results.study_result import StudyResult, judged
from esfem.results.tables import rates_table
from esfem.solver.laws import energy_of
from esfem.studies.claims import claims
from esfem.studies.study import CLAIMED_THEN, load_study

COLUMNS = (
    "study solution law scheme degree bdf project theta vertices nodes h h_max tau steps "
    "final_time status stopped_at energy_0 energy_T energy_rise willmore_0 willmore_T seconds "
    "gmres_mean version machine"
).split()


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    with saved_by(SAVE):
        return run_studies([write_study(folder)], out=folder / "out", jobs=1)[0]


@pytest.fixture
def copy(result, tmp_path):
    """A folder of results of its own, for a test that damages it."""
    return shutil.copytree(result.folder, tmp_path / "out" / "small")


def test_every_file_is_written(result):
    names = {path.name for path in result.folder.iterdir() if path.is_file()}
    assert names == {*TABLES, *PLOTS, "verdicts.json"}


def test_records_csv_has_the_promised_columns_and_reads_back(result):
    read = pd.read_csv(result.folder / "records.csv")
    norms = [f"err_{name}{suffix}" for name in VARIABLES for suffix in ("", "_l2")]
    assert {*COLUMNS, *norms} <= set(read.columns)
    np.testing.assert_array_equal(read["err_x"], result.records["err_x"])


def test_the_h1_error_is_at_least_the_l2_error(result):
    for name in VARIABLES:
        assert (result.records[f"err_{name}"] >= result.records[f"err_{name}_l2"]).all()


def test_rates_csv_holds_signed_rates_with_the_true_ratio(result):
    table = pd.read_csv(result.folder / "rates.csv")
    runs = result.records[result.records["tau"] == 0.125].sort_values("h", ascending=False)
    of_x = table[table["variable"].eq("x") & table["tau"].eq(0.125) & table["direction"].eq("h")]
    np.testing.assert_allclose(of_x["eoc"], rates(runs["h"], runs["err_x"]), rtol=1e-12)
    # Two time steps with four pairs of meshes, and five meshes with a pair of time steps.
    assert len(table) == len(VARIABLES) * (2 * 4 + 5)


def test_verdicts_json_says_what_was_judged_and_how_it_was_made(result):
    stored = json.loads((result.folder / "verdicts.json").read_text())
    assert {v["variable"] for v in stored["verdicts"]} == set(VARIABLES)
    of_x = next(v for v in stored["verdicts"] if v["variable"] == "x")
    assert set("study claim source variable expected verdict decides".split()) <= of_x.keys()
    assert [part["name"] for part in of_x["parts"]] == ["error", "interpolation"]
    for part in of_x["parts"]:
        assert set("norm observed lower upper constant outcome reason".split()) <= part.keys()
    deciding = next(part for part in of_x["parts"] if part["name"] == of_x["decides"])
    assert of_x["expected"] == 2.0 and of_x["verdict"] == deciding["outcome"]
    for key in ("version", "command", "parameters", "machine", "seconds"):
        assert stored[key]


def test_the_markdown_table_has_a_section_a_tau_and_a_row_a_mesh(result):
    """Twice: the errors, and those against the interpolation."""
    text = (result.folder / "table.md").read_text()
    assert text.startswith("<!-- esfem-willmore ")
    assert "## tau = 0.25" in text and "## tau = 0.125" in text
    assert len(re.findall(r"^\| +240 ", text, re.MULTILINE)) == 4
    assert text.count("Against the interpolation, u_h - I_h u in L-infinity(0,T;") == 2


def test_the_latex_table_is_balanced_booktabs(result):
    text = (result.folder / "table.tex").read_text()
    assert text.startswith("% esfem-willmore ")
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == 4
    for rule in (r"\toprule", r"\midrule", r"\bottomrule"):
        assert text.count(rule) == 4
    rows = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert {line.count("&") for line in rows} == {2 + 2 * len(VARIABLES)}


def test_errors_that_are_all_zero_are_drawn_as_exact(result):
    """An axis of logarithms has no zero; a warning would be an error here."""
    drawn = error_figure(replace(result, records=result.records.assign(err_x=0.0, nodal_x=0.0)))
    panel = drawn.axes[0]
    assert "exact up to rounding" in [text.get_text() for text in panel.texts]
    assert all((line.get_ydata() > 0).all() for line in panel.lines if len(line.get_ydata()))


def test_a_slope_is_shown_where_one_is_claimed_below_all_that_is_drawn(result):
    """x, nu and H are claimed, V, z and v are not."""
    panels = error_figure(result).axes[:6]
    slopes = [[text for text in panel.texts if text.get_text() == "2"] for panel in panels]
    assert [len(found) for found in slopes] == [1, 1, 1, 0, 0, 0]
    for panel in panels[:3]:
        (triangle,) = [line for line in panel.lines if len(line.get_xdata()) == 4]
        ends = [
            (line.get_xdata(), line.get_ydata()) for line in panel.lines if line is not triangle
        ]
        lowest = min(y.min() for x, y in ends if len(x))
        assert max(triangle.get_ydata()[:2]) < lowest


@pytest.mark.parametrize("name", [n for n in PLOTS if n.endswith(".svg")])
def test_svg_plots_are_well_formed_and_say_how_they_were_made(result, name):
    text = (result.folder / name).read_text()
    ElementTree.fromstring(text)
    assert "esfem-willmore" in text and "command:" in text


@pytest.mark.parametrize("name", [n for n in PLOTS if n.endswith(".pdf")])
def test_pdf_plots_are_pdf(result, name):
    assert (result.folder / name).read_bytes().startswith(b"%PDF")


def test_unchanged_results_are_not_written_again(result):
    before = {p.name: p.stat().st_mtime_ns for p in result.folder.iterdir() if p.is_file()}
    run_studies([result.study], out=result.folder.parent, jobs=1)
    after = {p.name: p.stat().st_mtime_ns for p in result.folder.iterdir() if p.is_file()}
    assert after == before


@pytest.mark.parametrize(
    ("claim", "rewritten"), [("section-7", True), ("theorem", False)], ids=["its own", "another"]
)
def test_an_edited_claim_is_judged_anew(result, copy, monkeypatch, claim, rewritten):
    """By the stamp: how the claim is worded counts, too, for it stands in the files."""
    edited = {**claims(), claim: claims()[claim].model_copy(update={"source": "elsewhere"})}
    monkeypatch.setattr("esfem.studies.study.claims", lambda: edited)
    assert is_rewritten(result, copy) == rewritten


def test_results_of_other_code_are_written_again(result, copy, monkeypatch):
    assert not is_rewritten(result, copy)
    monkeypatch.setattr("esfem.results.result_files.code_digest", lambda: "another")
    assert is_rewritten(result, copy)


def is_rewritten(result, folder) -> bool:
    before = (folder / "table.md").stat().st_mtime_ns
    study = result.study.model_copy()  # what was derived of it is derived again
    write_results(judged(study, folder, result.records, result.floors))
    return (folder / "table.md").stat().st_mtime_ns != before


def test_a_lost_file_is_written_again(result):
    (result.folder / "table.md").unlink()
    run_studies([result.study], out=result.folder.parent, jobs=1)
    assert (result.folder / "table.md").exists()


@pytest.mark.parametrize("name", ["records.csv", "table.md", "errors.svg", "verdicts.json"])
def test_an_edited_or_emptied_file_is_written_again(result, copy, name):
    damaged = (copy / name).read_bytes().replace(b"2", b"7") if name != "errors.svg" else b""
    (copy / name).write_bytes(damaged)
    run_studies([result.study], out=copy.parent, jobs=1)
    assert (copy / name).read_bytes() != damaged
    load_result(copy)


def test_what_was_written_reads_back(result):
    found = load_result(result.folder)
    records, floors = found.records, found.floors
    assert found.study == result.study
    as_written = result.records.drop(columns="reason")  # an empty text reads as NaN
    pd.testing.assert_frame_equal(records.drop(columns="reason"), as_written, check_dtype=False)
    pd.testing.assert_frame_equal(floors, result.floors, check_dtype=False)


@pytest.mark.parametrize("name", ["records.csv", "verdicts.json"])
def test_edited_results_are_refused(result, copy, name):
    text, machine = (copy / name).read_text(), result.records["machine"].iloc[0]
    assert machine in text
    (copy / name).write_text(text.replace(machine, "Abacus"))
    with pytest.raises(BadInput, match=rf"{name}: was edited or damaged; `esfem run` writes it"):
        load_result(copy)


@pytest.mark.parametrize("claim", ["theorem", "hope"])
def test_what_may_not_be_claimed_any_more_is_read_for_comparison_alone(copy, claim):
    path = copy / "verdicts.json"
    content = json.loads(path.read_text())
    content["parameters"]["study"]["claim"] = claim
    path.write_text(json.dumps({**content, "digest": own_digest(content)}))
    with pytest.raises(BadInput, match=f"claim = '{claim}'"):
        load_result(copy)
    assert read_verdicts(copy, CLAIMED_THEN).parameters.study.claim == claim


def test_results_without_digests_are_refused(copy):
    stored = json.loads((copy / "verdicts.json").read_text())
    del stored["digest"]
    (copy / "verdicts.json").write_text(json.dumps(stored))
    with pytest.raises(BadInput, match="no digests"):
        load_result(copy)


ODD_RECORDS = [
    (lambda r: r.iloc[:0], "holds no run"),
    (lambda r: pd.concat([r, r.iloc[[0]]]), "vertices = 30, tau = 0.25 occurs twice"),
    (lambda r: r.astype({"err_x": object}).replace({"err_x": {r.err_x[0]: "much"}}), "err_x = muc"),
    (lambda r: r.assign(err_nu=-r.err_nu), "err_nu = -"),
    (lambda r: r.assign(err_nu=np.nan), "err_nu = nan"),
    (lambda r: r.assign(h=np.inf), "h = inf: must be a positive number"),
    (lambda r: r.assign(tau=0.0), "tau = 0.0: must be a positive number"),
    (lambda r: r.assign(nodes=30.5), "nodes = 30.5: must be a positive whole number"),
    (lambda r: r.assign(steps=1e30), "steps = 1e"),
    (lambda r: r.assign(seconds=True), "seconds = True: must be a number"),
    (lambda r: r.assign(status="fine"), "status = fine: must be one of ok, diverged, failed"),
    (lambda r: r.drop(columns="nodes"), "column nodes is missing"),
    (lambda r: r.drop(columns="stopped_at"), "column stopped_at is missing"),
    (lambda r: r.drop(columns="status"), "column status is missing"),
]


@pytest.mark.parametrize(("change", "named"), ODD_RECORDS, ids=[n for _, n in ODD_RECORDS])
def test_odd_records_are_refused_by_file_column_and_value(result, tmp_path, change, named):
    change(result.records).to_csv(tmp_path / "records.csv", index=False)
    with pytest.raises(BadInput, match=r"records\.csv") as refusal:
        read_records(tmp_path, list(VARIABLES))
    assert named in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


class TestRecordsOfBefore:
    """Tables of versions that wrote W into the columns of the energy."""

    def read(self, result, folder, energy):
        old = result.records.drop(columns=["willmore_0", "willmore_T", "energy_rise"])
        old.to_csv(folder / "records.csv", index=False)
        return read_records(folder, list(VARIABLES), energy)

    def test_of_willmore_flow_are_read(self, result, tmp_path):
        records = self.read(result, tmp_path, energy_of("willmore"))
        for end in ("0", "T"):
            expected = result.records[f"energy_{end}"]
            np.testing.assert_array_equal(records[f"energy_{end}"], expected)
            np.testing.assert_array_equal(records[f"willmore_{end}"], expected)

    def test_of_flows_of_the_area_have_the_area_as_energy(self, result, tmp_path):
        records = self.read(result, tmp_path, energy_of("surface_diffusion"))
        np.testing.assert_array_equal(records["energy_T"], result.records["area_T"])
        np.testing.assert_array_equal(records["willmore_T"], result.records["energy_T"])

    def test_do_not_know_a_helfrich_energy(self, result, tmp_path):
        records = self.read(result, tmp_path, energy_of("helfrich", spontaneous_curvature=1.0))
        assert records[["energy_0", "energy_T"]].isna().all().all()
        np.testing.assert_array_equal(records["willmore_T"], result.records["energy_T"])

    def test_make_tables_figures_and_a_report(self, copy):
        """The whole way of results that an earlier version left."""
        old = pd.read_csv(copy / "records.csv")
        old = old.drop(columns=["willmore_0", "willmore_T", "energy_rise"])
        old.to_csv(copy / "records.csv", index=False)
        stored = json.loads((copy / "verdicts.json").read_text())
        stored["files"]["records.csv"] = file_digest(copy / "records.csv")
        stored["digest"] = own_digest(stored)
        (copy / "verdicts.json").write_text(json.dumps(stored))
        found = load_result(copy)
        assert (found.records["willmore_T"] == old["energy_T"]).all()
        assert not any("energy:" in line for line in energy_lines(found))
        pages = write_report(copy.parent, copy.parent / "report", lambda line: None)
        assert pages.exists()


def test_the_table_says_whether_the_energy_of_the_law_falls(result):
    records = result.records
    line = "energy: Willmore energy W = 1/2 int H^2; "
    calm = energy_lines(replace(result, records=records.assign(energy_rise=0.0)))
    assert calm == [f"{line}it falls in every step of the runs that ended"]
    rises = [2e-4, *[0.0] * (len(records) - 1)]
    first = records.iloc[0]
    at = f"V = {first['vertices']}, tau = {first['tau']:g}"
    said = energy_lines(replace(result, records=records.assign(energy_rise=rises)))
    assert said == [
        f"{line}in a step it rises by up to 2.0e-04 of its start ({at}): "
        "no theorem excludes rises of order h^k + tau^q"
    ]
    assert line in (result.folder / "table.md").read_text()


def test_of_a_forced_flow_it_says_that_no_energy_need_fall(tmp_path, result):
    forced = ('name = "sphere"\nradius = 1.0', 'name = "logistic_sphere"')
    study = load_study(write_study(tmp_path, forced, ('claim = "section-7"', "")))
    (said,) = energy_lines(replace(result, study=study))
    assert "the flow is forced, so that none need decrease, and none is checked" in said


@pytest.mark.parametrize(
    ("solution", "law", "E"),
    [
        ('name = "sphere"\nradius = 2.0', 'name = "surface_diffusion"', 16 * np.pi),
        (
            'name = "helfrich_sphere"\nradius = 2.0',
            'name = "helfrich"\nspontaneous_curvature = 1.0',
            0.0,
        ),
        (
            'name = "logistic_sphere"\nr0 = 1.5\nr1 = 1.5',
            'name = "helfrich"\nspontaneous_curvature = 0.4',
            2 * np.pi * (2 - 0.6) ** 2,
        ),
    ],
)
def test_the_dashed_lines_of_the_plot_are_the_exact_energy_and_W(tmp_path, solution, law, E):
    swaps = (('name = "sphere"\nradius = 1.0', solution), ('name = "willmore"', law))
    study = load_study(write_study(tmp_path, *swaps, ('claim = "section-7"\n', "")))
    known = known_energies(study)
    assert known["energy_T"] == pytest.approx(E, rel=1e-6, abs=1e-6)
    assert known["willmore_T"] == pytest.approx(8 * np.pi, rel=1e-12)
    records = pd.DataFrame({"h": [0.5, 0.4], "tau": 0.25, "status": "ok", "vertices": [30, 60]})
    records = records.assign(energy_T=E, willmore_T=25.0)
    figure = energy_figure(StudyResult(study, tmp_path, records, pd.DataFrame(), []))
    assert [axis.get_ylabel().partition(" $")[0] for axis in figure.axes] == [
        study.law.energy.name,
        "Willmore energy",
    ]


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"a,b\n1,2\n1,2,3\n", b"a\n1,2\n"])
def test_records_that_are_no_table_are_refused_in_one_line(tmp_path, content):
    (tmp_path / "records.csv").write_bytes(content)
    with pytest.raises(BadInput, match=r"records\.csv") as refusal:
        read_records(tmp_path, list(VARIABLES))
    assert len(str(refusal.value).splitlines()) == 1


@pytest.mark.parametrize("content", ["", "[]", "{", "[" * 100000, '{"parameters": {}}', "{}"])
def test_odd_verdicts_are_refused_in_one_line(copy, content):
    (copy / "verdicts.json").write_text(content)
    with pytest.raises(BadInput, match=r"verdicts\.json") as refusal:
        load_result(copy)
    assert len(str(refusal.value).splitlines()) == 1


def test_the_rates_of_a_single_run_have_a_header(result):
    everything = rates_table(result)
    single = rates_table(replace(result, records=result.records.iloc[:1]))
    assert single.empty
    assert list(single.columns) == list(everything.columns)


def test_the_report_leads_with_one_series_and_folds_the_others(result):
    """Twice: the errors, and those against the interpolation; no table says more than its title."""
    tables = errors_of(result)
    assert [t.name for t in tables] == ["errors-0", "nodal-0", "errors-1", "nodal-1"]
    assert [t.leading for t in tables] == [True, True, False, False]
    assert all(t.tells == "" for t in tables)
