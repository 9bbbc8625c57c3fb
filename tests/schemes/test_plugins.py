"""Schemes as plug-ins: the registry, options, recovery, variants of kll, and what studies show."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from studies import BDF_LINES, small_study, write_study

from esfem import schemes
from esfem.common.bad_input import BadInput
from esfem.measuring.shape import SHAPES
from esfem.meshes import surface_mesh
from esfem.results.run_studies import run_studies
from esfem.results.study_result import StudyResult
from esfem.runs.run_case import run_case
from esfem.runs.stepping import completed
from esfem.runs.store import case_key, key
from esfem.runs.work import Orders, keeper_of
from esfem.schemes import OFFERS, Level, Plugin, named_scheme, scheme_file, scheme_names
from esfem.solver import Levels, Scheme, State, evolve
from esfem.solver.assembly import mass_matrix
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import geometry
from esfem.solver.scheme import Work
from esfem.studies.case import Case
from esfem.studies.catalogue import scheme_studies
from esfem.studies.study import load_study

OWN = ("dziuk", "bgn", "kll-mcf")
IN_PLACE_OF_KLL = (BDF_LINES, "")


def case(scheme: dict, solution: str = "sphere", law: str = "willmore", **changes) -> Case:
    plain = {
        "solution": {"name": solution},
        "law": {"name": law},
        "scheme": {"degree": 2, **scheme},
        "vertices": 60,
        "tau": 2.5e-4,
        "final_time": 1e-3,
    }
    return Case.model_validate({**plain, **changes})


KLL = {"name": "kll", "bdf": 1, "project": True, "theta": False}
CASES = {
    "kll": case(KLL),
    "dziuk": case({"name": "dziuk"}),
    "bgn": case({"name": "bgn"}),
    "kll-mcf": case({"name": "kll-mcf", "bdf": 2}, "shrinking_sphere", "mean_curvature"),
}
each_scheme = pytest.mark.parametrize("name", CASES)


def record_of(one: Case):
    surface = surface_mesh(one.solution.initial().mesh_surface, one.vertices)
    return run_case(one, surface)[0]


class TestRegistry:
    def test_all_schemes_are_walked(self):
        assert tuple(sorted(CASES)) == scheme_names()

    @each_scheme
    def test_a_file_is_a_scheme(self, name):
        assert isinstance(named_scheme(name), Plugin)
        assert scheme_file(name).stem == name.replace("-", "_")

    @each_scheme
    def test_what_is_not_offered_is_recovered(self, name):
        scheme = named_scheme(name)
        assert sorted((*scheme.offers, *scheme.recovered)) == sorted(OFFERS)

    def test_unknown_name_is_refused_with_those_there_are(self):
        with pytest.raises(ValueError, match=r"scheme = 'rusu': must be one of bgn, dziuk, kll"):
            named_scheme("rusu")

    def test_a_file_without_a_scheme_is_refused(self, tmp_path, monkeypatch):
        (tmp_path / "empty_one.py").write_text("SCHEME = 3")
        monkeypatch.setattr(schemes, "__path__", [*schemes.__path__, str(tmp_path)])
        with pytest.raises(ValueError, match=r"'empty-one': its file must define SCHEME"):
            named_scheme("empty-one")

    @pytest.mark.parametrize("offers", [("x", "kappa"), ("nu",)])
    def test_a_scheme_offers_x_and_known_quantities(self, offers):
        with pytest.raises(ValueError, match="offers = "):
            Plugin("title", ("willmore",), offers, step=lambda problem, past, t: past[0])

    @pytest.mark.parametrize("laws", [(), ("wilmore",)])
    def test_a_scheme_solves_known_laws(self, laws):
        with pytest.raises(ValueError, match=r"laws = .*must be among willmore"):
            Plugin("title", laws, ("x",), step=lambda problem, past, t: past[0])

    def test_an_energy_needs_levels(self):
        kll = named_scheme("kll")
        with pytest.raises(ValueError, match="energy: must not be given with run"):
            replace(kll, energy=lambda problem, level: 0.0)

    def test_a_scheme_has_a_step_or_a_run(self):
        with pytest.raises(ValueError, match="step: "):
            Plugin("title", ("willmore",), ("x",))


class TestRuns:
    @each_scheme
    def test_every_level_is_measured(self, name):
        record = record_of(CASES[name])
        assert record.status == "ok"
        np.testing.assert_allclose(record.t, 2.5e-4 * np.arange(5), rtol=1e-12, atol=0)
        assert all(len(values) == 5 for values in record.levels.values())

    @each_scheme
    def test_runs_repeat_themselves(self, name):
        first, second = (record_of(CASES[name]) for _ in range(2))
        assert first.levels == second.levels

    @pytest.mark.parametrize("name", OWN)
    def test_a_breakdown_is_a_result(self, name):
        """Start values with noise of their own size make no surface."""
        record = record_of(CASES[name].model_copy(update={"disturbance": 1.0}))
        assert record.status in ("diverged", "failed")
        assert record.reason

    @pytest.mark.parametrize(
        ("fails", "status"), [(ZeroDivisionError, "failed"), (None, "diverged")]
    )
    def test_failures_have_names(self, fails, status, monkeypatch):
        def step(problem, past, t):
            if fails:
                raise fails("pivot")
            return Level(t, np.nan * past[0].x, v=past[0].x)

        plugin = replace(named_scheme("dziuk"), step=step)
        monkeypatch.setattr("esfem.runs.stepping.named_scheme", lambda name: plugin)
        record = record_of(CASES["dziuk"])
        assert (record.status, record.stopped_at) == (status, 2.5e-4)

    def test_nodes_that_slide_are_measured_by_shape(self):
        record = record_of(CASES["bgn"])
        assert not record.l2 and not record.idle_l2
        assert {f"err_{name}" for name in SHAPES} <= record.levels.keys()

    def test_checkpoints_are_for_kll_alone(self, tmp_path):
        study = load_study(write_study(tmp_path))
        from esfem.runs.store import Cell

        mesh = surface_mesh("sphere", 60)
        for name, one in CASES.items():
            cell = Cell(study.name, tmp_path, one, mesh)
            assert (keeper_of(cell, Orders(checkpoint=30.0)) is None) == (name != "kll")


class TestLevels:
    """What a scheme gives is held against what it promises."""

    def record(self, monkeypatch, **changes):
        plugin = replace(named_scheme("dziuk"), **changes)
        monkeypatch.setattr("esfem.runs.stepping.named_scheme", lambda name: plugin)
        return record_of(CASES["dziuk"])

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            (lambda x, t: Level(t + 1.0, x, v=x), "gives a level at t = 1.0002"),
            (lambda x, t: None, "gives None, must be a Level"),
            (lambda x, t: Level(t, x), "it offers x, v, and its step gives x"),
            (lambda x, t: Level(t, x, v=x, H=x[:, 0]), "and its step gives x, H, v"),
            (lambda x, t: Level(t, x[:-1], v=x), r"its x has shape \(\d+, 3\), must be"),
            (lambda x, t: Level(t, x, v=x[:, 0]), r"its v has shape \(\d+,\), must be"),
        ],
    )
    def test_a_level_that_is_not_what_was_promised_is_refused(self, given, message, monkeypatch):
        with pytest.raises(BadInput, match=f"scheme 'dziuk': .*{message}"):
            self.record(monkeypatch, step=lambda problem, past, t: given(past[0].x, t))

    def test_a_start_is_at_time_zero(self, monkeypatch):
        def late(problem):
            return Level(5.0, problem.initial.x)

        with pytest.raises(BadInput, match=r"gives a level at t = 5\.0, must be at 0\.0"):
            self.record(monkeypatch, start=late)

    def test_the_start_of_a_scheme_is_its_first_level(self, monkeypatch):
        def larger(problem):
            level = named_scheme("dziuk").start(problem)
            return replace(level, x=1.1 * level.x)

        plain, record = record_of(CASES["dziuk"]), self.record(monkeypatch, start=larger)
        assert record.levels["area"][0] == pytest.approx(1.21 * plain.levels["area"][0])

    def test_a_bad_scheme_ends_a_sweep_with_its_message(self, command, tmp_path, monkeypatch):
        source = scheme_file("dziuk").read_text().replace("t, x, v=(x", "2 * t, x, v=(x")
        (tmp_path / "too_late.py").write_text(source)
        monkeypatch.setattr(schemes, "__path__", [*schemes.__path__, str(tmp_path)])
        study = write_study(
            tmp_path,
            (BDF_LINES, 'name = "too-late"'),
            ('claim = "section-7"\n', ""),
        )
        status, said = command("run", study, "--out", tmp_path / "out")
        assert status == 2 and "scheme 'too-late': gives a level at t = " in said


class TestKeys:
    def test_what_studies_of_before_do_not_name_is_what_it_was(self):
        """Of options that came later the first value is what was done before there was one."""
        plain = CASES["kll"].model_dump(mode="json")
        later = {"velocity": "interpolated", "reaction": "implicit"}
        scheme = {key: value for key, value in plain["scheme"].items() if key not in later}
        names = ("name", "degree", "quadrature", "bdf", "project", "theta", "start", "tolerance")
        assert sorted(scheme) == sorted(names)
        case = {key: value for key, value in plain.items() if key != "first_steps"}
        read = Case.model_validate({**case, "scheme": scheme})
        assert read.first_steps == 1
        assert {name: getattr(read.scheme, name) for name in later} == later

    @pytest.mark.parametrize("change", [{"velocity": "ritz"}, {"project": "nu"}])
    def test_variants_have_keys_of_their_own(self, change):
        assert case_key(case({**KLL, **change}), "m") != case_key(CASES["kll"], "m")

    @each_scheme
    def test_a_case_is_read_back_as_it_was(self, name):
        assert Case.model_validate(CASES[name].model_dump(mode="json")) == CASES[name]

    def test_the_file_of_a_scheme_counts_for_its_own_records(self, monkeypatch):
        before = {name: key(one, "m") for name, one in CASES.items()}
        monkeypatch.setattr("esfem.runs.store.stepping_digest", lambda path: "changed")
        assert {name: key(one, "m") == before[name] for name, one in CASES.items()} == {
            name: name == "kll" for name in CASES
        }


class TestRecovery:
    @pytest.fixture(scope="class")
    @staticmethod
    def found(raised, torus):
        """Errors in L2 of what is recovered from x alone, and from x and H, on two meshes."""

        def errors(V: int) -> dict[str, float]:
            mesh, x = raised("torus", V, 2)
            f, geo = torus.fields(x), geometry(mesh, x)
            before = Level(0.0, x - 0.1 * f.V[:, None] * f.nu)
            bare = completed(mesh, Level(0.1, x), before, Work(0, {}))
            given = completed(mesh, Level(0.1, x, H=f.H), before, Work(0, {}))
            M = mass_matrix(geo)

            def norm(e: np.ndarray) -> float:
                return float(np.sqrt(np.sum(e * (M @ e))))

            return {
                "h": mesh_width(geo),
                **{name: norm(getattr(bare, name) - getattr(f, name)) for name in ("nu", "H", "V")},
                "z": norm(given.z - f.z),
                "v": norm(bare.v - f.V[:, None] * f.nu),
            }

        return errors(240), errors(960)

    @pytest.mark.parametrize(("name", "least"), [("nu", 1.6), ("H", 0.8), ("V", 1.6), ("z", 1.5)])
    def test_converges(self, found, name, least):
        """Order 2 of the normal of P_2, a little less on these meshes; one less for H from x."""
        coarse, fine = found
        assert np.log(coarse[name] / fine[name]) / np.log(coarse["h"] / fine["h"]) > least

    def test_velocity_is_the_difference_of_levels(self, found):
        assert max(errors["v"] for errors in found) < 1e-12

    def test_what_is_there_is_kept(self, raised, torus):
        mesh, x = raised("torus", 60, 2)
        f = torus.fields(x)
        level = Level(0.1, x, f.nu, f.H, f.V, f.z, f.v)
        state = completed(mesh, level, Level(0.0, x), Work(0, {}))
        for name in OFFERS:
            np.testing.assert_array_equal(getattr(state, name), getattr(level, name))

    def test_is_marked_in_tables(self):
        studies = map(load_study, scheme_studies())
        headings = {s.name: StudyResult(s, Path(), None, None, []).headings for s in studies}
        shown = headings["schemes-clifford-dziuk"]
        assert shown["nu"] == "nu (recovered)"
        assert (shown["x"], shown["v"]) == ("x", "v")
        assert all(name == shown for name, shown in headings["schemes-clifford-kll"].items())


class TestVariantsOfKLL:
    def last(self, raised, torus, **options) -> State:
        mesh, x = raised("torus", 60, 2)
        f = torus.fields(x)
        initial = State(0.0, x, f.nu, f.H, f.V, f.z)
        *_, last = evolve(mesh, initial, Scheme(**options), Levels.equal(1e-3, 3))
        return last

    def test_ritz_velocity_is_near_the_interpolated_one(self, raised, torus):
        ritz, nodal = (self.last(raised, torus, velocity=v) for v in ("ritz", "interpolated"))
        product = ritz.V[:, None] * ritz.nu
        assert 0 < np.abs(ritz.v - product).max() < 0.2 * np.abs(product).max()
        assert 0 < np.abs(ritz.x - nodal.x).max() < 1e-3
        np.testing.assert_array_equal(nodal.v, nodal.V[:, None] * nodal.nu)

    def test_projection_of_nu_alone_leaves_z(self, raised, torus):
        alone, both = (self.last(raised, torus, project=p) for p in ("nu", True))
        for state in (alone, both):
            np.testing.assert_allclose(np.linalg.norm(state.nu, axis=1), 1.0, rtol=1e-14)
        normal = [np.abs(np.einsum("ja,ja->j", s.z, s.nu)).max() for s in (alone, both)]
        assert normal[0] > 1e-6 > 1e-12 > normal[1]


class TestStudies:
    @pytest.mark.parametrize("path", scheme_studies(), ids=lambda path: path.stem)
    def test_names_follow_their_files(self, path):
        assert load_study(path).name == f"schemes-{path.stem}"

    def test_the_schemes_share_meshes_times_and_steps(self):
        by_ground: dict[str, list] = {}
        for path in scheme_studies():
            if path.stem.endswith(("-kll", "-dziuk")) or path.stem.endswith("-bgn"):
                study = load_study(path)
                ground = path.stem.rpartition("-")[0]
                if study.law.name == "willmore":
                    contents = (study.solution, study.law, study.sweep)
                    by_ground.setdefault(ground, []).append(contents)
        assert len(by_ground) == 5
        for contents in by_ground.values():
            assert len(contents) == 3
            assert all(content == contents[0] for content in contents)

    def test_a_theorem_of_kll_is_not_claimed_for_others(self, tmp_path):
        path = write_study(tmp_path, (BDF_LINES, 'name = "bgn"'))
        with pytest.raises(BadInput, match="is made for scheme = kll, not for bgn"):
            load_study(path)

    def test_the_theorem_is_not_claimed_with_ritz_velocity(self, tmp_path):
        path = write_study(
            tmp_path,
            ("section-7", "order-k"),
            ("theta = false", 'theta = true\nvelocity = "ritz"'),
        )
        with pytest.raises(BadInput, match="velocity = interpolated, not for ritz"):
            load_study(path)

    def test_sliding_nodes_are_not_compared_with_the_finest(self, tmp_path):
        path = write_study(
            tmp_path,
            ('claim = "section-7"\n', ""),
            ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"'),
            (BDF_LINES, 'name = "bgn"'),
        )
        with pytest.raises(BadInput, match="nodes of scheme 'bgn' slide"):
            load_study(path)

    @each_scheme
    def test_a_study_of_every_scheme_runs_to_its_verdicts(self, name, tmp_path):
        study = load_study(small_study(tmp_path, claim=None, superconvergent=None))
        one = CASES[name]
        sweep = {"vertices": [30, 60], "tau": [5e-4], "final_time": 1e-3}
        parts = {
            "scheme": one.scheme,
            "solution": one.solution,
            "law": one.law,
            "sweep": study.sweep.model_copy(update=sweep),
        }
        (result,) = run_studies([study.model_copy(update=parts)], tmp_path / "out", jobs=1)
        assert len(result.records) == 2 and (result.records["status"] == "ok").all()
        assert {v.verdict for v in result.verdicts} <= {"no claim", "not exercised"}
        assert f"scheme {name}: P2, " in (result.folder / "table.md").read_text()
