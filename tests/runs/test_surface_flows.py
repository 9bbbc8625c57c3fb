"""Studies of named surfaces: against the axisymmetric solver, and against the finest level."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from studies import BDF_LINES, small_study, write_study

import esfem.runs.against_finest
from esfem.common.bad_input import BadInput
from esfem.measuring.error_columns import columns
from esfem.measuring.lift import VARIABLES, unknowns
from esfem.measuring.shape import against_profile, lattice_surface
from esfem.meshes import surface_mesh
from esfem.reference_solutions import SurfaceFlow
from esfem.reference_solutions.laws import velocity
from esfem.results.records import record_row
from esfem.results.run_studies import run_studies
from esfem.results.selection import bounded_runs, too_fine
from esfem.results.verdicts import judge
from esfem.runs.problem import initial_state
from esfem.runs.run_case import computational_mesh, run_case
from esfem.runs.store import cells_of, key, read_record, read_snapshots, snapshots_path
from esfem.schemes.kll import KLLOptions
from esfem.solver.functionals import area, volume, willmore_energy
from esfem.solver.geometry import geometry
from esfem.studies.case import Case, Law, Solution
from esfem.studies.study import load_study

SURFACE = ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"')
NO_CLAIM = ('claim = "section-7"\n', "")


def case(reference: str, **changes) -> Case:
    scheme = KLLOptions(degree=2, bdf=2, project=True, theta=True)
    given = {
        "solution": Solution(name="surface", surface="ellipsoid", reference=reference),
        "law": Law(name="willmore"),
        "scheme": scheme,
        "vertices": 120,
        "tau": 0.01,
        "final_time": 0.04,
        "compare_at": (0.02, 0.04),
    }
    return Case(**{**given, **changes})


@pytest.fixture(scope="module")
def flow_record():
    return run_case(case("axisymmetric"), surface_mesh("ellipsoid", 120))


@pytest.fixture(scope="module")
def self_study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("self")
    compared = ("final_time = 0.01", "final_time = 0.01\ncompare_at = [0.005, 0.01]")
    values = {"claim": None, "vertices": [120, 240, 480], "tau": [0.005], "final_time": 0.01}
    return small_study(folder, SURFACE, compared, **values)


class TestAxisymmetric:
    def test_energy_area_volume_and_shape_agree(self, flow_record):
        compared = flow_record[0].compared
        assert compared["t"] == pytest.approx([0.02, 0.04])
        for name, bound in (("W", 0.02), ("area", 0.01), ("volume", 0.01), ("distance", 0.02)):
            assert 0 < max(compared[name]) < bound, name

    def test_distances_both_ways_are_alike(self, flow_record):
        compared = flow_record[0].compared
        np.testing.assert_allclose(compared["distance_back"], compared["distance"], rtol=0.5)

    def test_a_larger_surface_does_not_agree(self):
        solution = SurfaceFlow("ellipsoid", "axisymmetric")
        mesh, p = computational_mesh(surface_mesh("ellipsoid", 240), solution, 2)
        flow = solution.profile_flow("willmore", {}, (0.0, 0.01))
        exact = initial_state(Law(name="willmore"), p, solution)
        for factor in (1.0, 1.01):
            state = replace(exact, x=factor * exact.x, H=exact.H / factor)
            geo = geometry(mesh, state.x)
            W = willmore_energy(geo, state.H)
            numbers = {"energy": W, "willmore": W, "area": area(geo), "volume": volume(geo)}
            found = against_profile(mesh, state, numbers, flow, 0)
            expected = {"W": 0.0, "area": factor**2 - 1, "volume": factor**3 - 1}
            for name, error in expected.items():
                assert found[name] == pytest.approx(error, abs=1e-3), name
            assert found["distance"] == pytest.approx(2.0 * (factor - 1.0), abs=2e-3)

    def test_the_lattice_surface_has_the_area_of_the_curved_one(self):
        surface = surface_mesh("ellipsoid", 120)
        mesh, p = computational_mesh(surface, SurfaceFlow("ellipsoid"), 3)
        points, triangles = lattice_surface(mesh, p)
        corners = points[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat = 0.5 * np.linalg.norm(normal, axis=1).sum()
        assert flat == pytest.approx(area(geometry(mesh, p)), rel=2e-3)
        assert (np.einsum("fa,fa->f", normal, corners.mean(axis=1)) > 0).all()

    def test_a_state_at_another_time_is_refused_however_small_the_times(self):
        """Two times below 1e-8 are not close because both are small."""
        solution = SurfaceFlow("ellipsoid", "axisymmetric")
        mesh, p = computational_mesh(surface_mesh("ellipsoid", 60), solution, 1)
        exact = initial_state(Law(name="willmore"), p, solution)
        flow = solution.profile_flow("willmore", {}, (0.0, 1e-9))
        numbers = dict.fromkeys(("energy", "willmore", "area", "volume"), 1.0)
        against_profile(mesh, replace(exact, t=1e-9), numbers, flow, 1)
        for t, i in ((2e-9, 1), (1e-9, 0)):
            with pytest.raises(ValueError, match=f"state.t = {t!r}: must be"):
                against_profile(mesh, replace(exact, t=t), numbers, flow, i)

    def test_a_flow_keeps_no_snapshots(self, flow_record):
        assert flow_record[1] is None


HELFRICH = Law(name="helfrich", spontaneous_curvature=1.0)
MCF = {"scheme": {"name": "kll-mcf", "degree": 2, "bdf": 2}, "law": Law(name="mean_curvature")}


@pytest.fixture(scope="module")
def helfrich():
    asked = case("axisymmetric", law=HELFRICH, tau=0.0025, final_time=0.02, compare_at=(0.02,))
    return run_case(asked, surface_mesh("ellipsoid", 120))[0]


@pytest.fixture(scope="module")
def mcf():
    asked = Case.model_validate({**dict(case("axisymmetric")), **MCF})
    return run_case(asked, surface_mesh("ellipsoid", 120))[0]


class TestEnergies:
    """Flows of an ellipsoid, which is nowhere a sphere, by laws whose energy is not W."""

    def test_helfrich_flow_agrees_in_W_and_in_its_own_energy(self, helfrich):
        """W differs from E by 23: compared with each other, the error is 3."""
        assert helfrich.levels["energy"][0] == pytest.approx(6.9549, rel=0.01)
        assert helfrich.levels["willmore"][0] == pytest.approx(30.9032, rel=0.01)
        for name, bound in (("W", 2e-3), ("energy", 5e-3), ("area", 1e-3), ("volume", 1e-3)):
            assert 0 < helfrich.compared[name][0] < bound, name

    def test_mean_curvature_flow_agrees_with_the_axisymmetric_solver(self, mcf):
        assert mcf.levels["energy"] == mcf.levels["area"]
        for name, bound in (("W", 5e-3), ("area", 2e-3), ("volume", 2e-3), ("distance", 1e-2)):
            assert 0 < max(mcf.compared[name]) < bound, name

    @pytest.mark.parametrize("flow", ["helfrich", "mcf"])
    def test_the_energy_of_the_law_falls(self, flow, request):
        record = request.getfixturevalue(flow)
        assert (np.diff(record.levels["energy"]) < 0).all()

    def test_rows_have_both_energies_and_the_largest_rise(self, helfrich):
        row = record_row("small", "key", helfrich)
        assert row["energy_T"] == helfrich.levels["energy"][-1]
        assert row["willmore_T"] == helfrich.levels["willmore"][-1]
        assert row["energy_rise"] == 0.0
        assert row["err_energy"] == helfrich.compared["energy"][0]


AXISYMMETRIC = (SURFACE[0], f'{SURFACE[1]}\nreference = "axisymmetric"')
BY_KLL = f"degree = 2\n{BDF_LINES}"


def test_the_claim_on_W_and_the_energy_is_judged_on_both(tmp_path):
    law = ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0')
    claim = ('claim = "section-7"', 'claim = "axisymmetric-law-energy"')
    one = ("tau = [0.25, 0.125]", "tau = [0.125]")
    study = load_study(write_study(tmp_path, AXISYMMETRIC, law, claim, one))
    assert study.variables == ("W", "energy", "area", "volume", "distance")
    runs = pd.DataFrame({"vertices": [30, 60, 120, 240, 480], "status": "ok", "tau": 0.125})
    runs = runs.assign(h=runs["vertices"] ** -0.5, seconds=1.0, final_time=0.5)
    for name in study.variables:
        runs[f"err_{name}"] = 1e-2 * runs["h"] ** 2
    wrong = runs.assign(err_energy=3.0 + runs["h"])  # W compared with E
    for records, outcome in ((runs, "pass"), (wrong, "fail")):
        verdicts = {v.variable: v.verdict for v in judge(study, records)}
        assert (verdicts["W"], verdicts["energy"]) == ("pass", outcome)
        assert verdicts["area"] == "no claim"


@pytest.mark.parametrize("law", ["willmore", "surface_diffusion"])
def test_the_claim_on_an_energy_of_its_own_needs_one(tmp_path, law):
    claim = ('claim = "section-7"', 'claim = "axisymmetric-law-energy"')
    path = write_study(tmp_path, AXISYMMETRIC, ('name = "willmore"', f'name = "{law}"'), claim)
    with pytest.raises(BadInput, match=f"is made for law = helfrich, not for {law}"):
        load_study(path)


def test_mean_curvature_flow_beyond_its_end_is_refused_before_anything_is_computed(tmp_path):
    law = ('name = "willmore"', 'name = "mean_curvature"')
    scheme = (BY_KLL, 'name = "kll-mcf"\ndegree = 2\nbdf = 2')
    path = write_study(tmp_path, AXISYMMETRIC, NO_CLAIM, law, scheme)
    with pytest.raises(BadInput, match=r"study 'small': \[sweep\] compare_at = 0\.5: the axisym"):
        run_studies([path], tmp_path / "out")
    assert not list((tmp_path / "out").rglob("*.json"))


class TestStart:
    def test_the_velocity_is_that_of_the_law(self):
        solution = SurfaceFlow("red_blood_cell")
        _, p = computational_mesh(surface_mesh("red_blood_cell", 120), solution, 2)
        state = initial_state(Law(name="surface_diffusion"), p, solution)
        np.testing.assert_allclose(state.V, solution.fields(p).laplace_H, rtol=1e-12)
        helfrich = {"spontaneous_curvature": 0.7}
        other = initial_state(Law(name="helfrich", **helfrich), p, solution)
        np.testing.assert_allclose(other.V, velocity("helfrich", helfrich, solution.fields(p)))

    def test_the_key_changes_with_the_file_of_the_surface(self, monkeypatch):
        before = key(case("finest"), "mesh")
        monkeypatch.setattr("esfem.runs.store.surface_digest", lambda name: "another")
        assert key(case("finest"), "mesh") != before


@pytest.fixture(scope="module")
def result(self_study):
    return run_studies([self_study], self_study.parent / "out")[0]


class TestAgainstFinest:
    def test_the_finest_level_is_a_reference_and_the_others_have_errors(self, result):
        assert result.records["status"].tolist() == ["ok", "ok", "reference"]
        errors = result.records[[f"err_{name}" for name in result.study.variables]]
        assert errors.iloc[:2].gt(0).all().all()
        assert errors.iloc[2].isna().all()
        assert errors.iloc[1].lt(errors.iloc[0]).all()

    def test_so_have_their_errors_against_the_interpolation(self, result):
        """Columns as of an exact solution."""
        runs, names = result.records, result.study.variables
        assert set(columns(names)) <= set(runs)
        nodal = runs[[f"nodal_{name}" for name in names]].to_numpy()
        plain = runs[[f"err_{name}" for name in names]].to_numpy()
        assert np.isnan(nodal[2]).all() and (nodal[1] < nodal[0]).all()
        assert (0 < nodal[:2]).all() and (nodal[:2] < plain[:2]).all()
        assert runs["t_nodal_x"].isin([0.005, 0.01]).tolist() == [True, True, False]

    def test_the_initial_state_kept_for_ever_has_an_error_that_no_mesh_lowers(self, result):
        runs, names = result.records, result.study.variables
        idle = runs[[f"idle_{name}" for name in names]].to_numpy()
        plain = runs[[f"err_{name}" for name in names]].to_numpy()
        np.testing.assert_allclose(idle[1], idle[0], rtol=0.15)
        assert (idle[1] > 10 * plain[1]).all() and np.isnan(idle[2]).all()
        assert runs["moved"].all()

    def test_a_run_that_did_nothing_has_the_idle_error(self, self_study, result, monkeypatch):
        """The coarse run's snapshots replaced by its start."""
        module, study = esfem.runs.against_finest, load_study(self_study)
        surfaces = {V: surface_mesh("ellipsoid", V) for V in study.sweep.vertices}
        cells = {c.case.vertices: c for c in cells_of(study, result.folder, surfaces)}
        coarse, finest = cells[120], cells[480]
        _, p = computational_mesh(coarse.surface, coarse.case.initial, 2)
        start = unknowns(initial_state(coarse.case.law, p, coarse.case.initial))

        def snapshots(folder, record_key):
            kept = read_snapshots(folder, record_key)
            return kept if record_key == finest.key else np.stack([start] * len(kept))

        found: dict[str, str] = {}
        monkeypatch.setattr(module, "read_snapshots", snapshots)
        monkeypatch.setattr(module, "write_text", lambda path, text: found.update(text=text))
        module._compare([(coarse, finest)])
        errors, row = json.loads(found["text"]), result.records.iloc[0]
        for name in result.study.variables:
            assert errors[f"err_{name}"] == errors[f"idle_{name}"] == row[f"idle_{name}"]

    def test_only_levels_twice_as_coarse_may_be_judged(self, result):
        assert too_fine(result.study, result.records) == [240, 480]
        assert any("V = 240, 480" in line for line in result.excluded)

    def test_tables_say_that_it_is_self_convergence(self, result):
        assert "against finest" in (result.folder / "table.md").read_text()
        assert all("against finest" in verdict.norm for verdict in result.verdicts)

    def test_what_was_compared_is_read_again(self, self_study, result, monkeypatch):
        monkeypatch.setattr(esfem.runs.against_finest, "_compare", None)
        again = run_studies([self_study], self_study.parent / "out")[0]
        pd.testing.assert_frame_equal(again.records, result.records)

    def test_damaged_snapshots_are_set_aside_with_their_record(self, self_study, result):
        folder, record_key = result.folder, result.records["key"].iloc[0]
        path = snapshots_path(folder, record_key)
        path.write_bytes(path.read_bytes()[:-100])
        lines: list[str] = []
        assert read_record(folder, record_key, lines.append) is None
        assert "snapshots" in lines[0]
        again = run_studies([self_study], self_study.parent / "out")[0]
        numbers = [f"err_{name}" for name in result.study.variables]
        pd.testing.assert_frame_equal(again.records[numbers], result.records[numbers])

    def test_without_its_finest_run_nothing_has_an_error(self, self_study, result):
        study = load_study(self_study)
        records = result.records.assign(status=["ok", "ok", "diverged"])
        assert bounded_runs(study, records).empty
        assert {v.verdict for v in judge(study, records)} == {"no claim"}


@pytest.mark.slow
def test_errors_against_the_interpolation_fall_with_order_k_on_a_surface_that_moves(tmp_path):
    """Both parts with order k = 2 at least, in all variables; those against the interpolation are
    free to fall faster, and measured 1.9 to 3.3 from one mesh to the next."""
    compared = ("final_time = 0.01", "final_time = 0.01\ncompare_at = [0.005, 0.01]")
    values = {"vertices": [60, 120, 240, 960], "tau": [0.005], "final_time": 0.01, "claim": None}
    path = small_study(tmp_path, SURFACE, compared, **values)
    runs = run_studies([path], tmp_path / "out")[0].records.iloc[:3]
    for name in VARIABLES:
        plain, nodal = (
            np.polyfit(np.log(runs["h"]), np.log(runs[f"{kind}_{name}"]), 1)[0]
            for kind in ("err", "nodal")
        )
        assert 1.7 < plain < 2.4, name
        assert 1.9 < nodal < 3.6, name


def test_the_reference_of_a_stopped_finest_run_is_missing(self_study, tmp_path, monkeypatch):
    """Coarser runs are then kept, shown as runs without errors."""
    from esfem.runs import store

    out = tmp_path / "out"
    done = run_studies([self_study], out)[0]
    path = done.folder / "records" / f"{done.records['key'].iloc[-1]}.json"
    content = json.loads(path.read_text())
    assert content["record"]["status"] == "ok"
    original = store.read_record

    def stopped(folder, record_key, complain):
        record = original(folder, record_key, complain)
        if record.case["vertices"] != 480:
            return record
        return type(record)(**{**vars(record), "status": "diverged", "stopped_at": 0.005})

    monkeypatch.setattr(store, "read_record", stopped)
    again = run_studies([self_study], out)[0]
    assert again.records["status"].tolist() == ["reference", "reference", "diverged"]
    assert again.records["err_x"].isna().all()
