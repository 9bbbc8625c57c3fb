"""Two runs in lockstep: compared where both have a level, resumed to the last bit, or stopped."""

from dataclasses import replace

import numpy as np
import pytest
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.measuring.differences import differences
from esfem.measuring.lift import VARIABLES, interpolation, nodal_errors
from esfem.meshes import surface_mesh
from esfem.runs import run_pair as module
from esfem.runs import store
from esfem.runs.checkpoint import Keeper
from esfem.runs.run_case import computational_mesh, run_case
from esfem.runs.run_pair import common_levels, run_pair
from esfem.solver import Levels
from esfem.studies.study import load_study

IDENTITY = {"numerics": "abc"}
MEASURED = ("t", "norms", "levels", "varied_levels", "status", "stopped", "stopped_at", "reason")
MOVING = [
    ('name = "sphere"\nradius = 1.0', 'name = "helfrich_sphere"'),
    ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0'),
    ("theta = false", "theta = true"),
    ("tau = [0.25, 0.125]", "tau = [0.03125]"),
    ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"),
    ('claim = "section-7"', ""),
]
TWICE = "tau = [0.03125]", "tau = [0.0625]"
STARTED = ("bdf = 2", 'bdf = 3\nstart = "self"')
COMPARED = [
    ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"'),
    ("vertices = [30, 60, 120, 240, 480]", "vertices = [60, 240]"),
    ("tau = [0.25, 0.125]", "tau = [0.005]\ncompare_at = [0.02, 0.05]"),
    ("final_time = 0.5", "final_time = 0.05"),
    ('claim = "section-7"', ""),
]
RUNS = {
    "moving": MOVING,
    "implicit": [*MOVING, ('"extrapolated"', '"implicit"')],
    "first steps divided": [
        *MOVING,
        TWICE,
        STARTED,
        ("final_time = 0.5", "final_time = 0.5\nfirst_steps = 4"),
    ],
    "compared": COMPARED,
}


class Killed(BaseException):
    """Ends a run where a kill would."""


def study_of(tmp_path, *changes):
    return load_study(write_study(tmp_path, *changes))


def pairs_of(study):
    """The first cell with two variations of it."""
    case = study.cases()[0]
    changes = {"rounding": {"disturbance": 1e-13}, "tau": {"tau": case.tau / 2.0}}
    return {name: (case, case.model_copy(update=change)) for name, change in changes.items()}


def mesh_of(case):
    return surface_mesh(case.initial.mesh_surface, case.vertices)


def computed(case):
    """The levels of BDF2 without the start value, which is the exact solution."""
    return [0, *range(2, case.steps + 1)]


class TestCommonLevels:
    def test_half_the_step_has_every_second_level(self):
        whole, half = Levels.equal(0.1, 20), Levels.equal(0.05, 40)
        assert list(common_levels(whole, half)) == [(n, 2 * n) for n in range(21)]

    def test_substeps_are_common_where_both_have_them(self):
        """Of BDF2 with 4 substeps in each first step: to tau every one, then every whole step."""
        whole, half = Levels.started(0.1, 5, 2, 4), Levels.started(0.05, 10, 2, 4)
        common = list(common_levels(whole, half))
        assert [whole.t(n) for n, _ in common] == pytest.approx([half.t(m) for _, m in common])
        assert [n for n, _ in common] == [0, 1, 2, 3, 4, 6, 8, 9, 10, 11]


def test_the_same_run_twice_lies_nowhere_apart(tmp_path):
    case = study_of(tmp_path, *MOVING).cases()[0]
    record = run_pair(case, case, mesh_of(case))
    assert {n for norms in record.norms.values() for n in norms} == {0.0}
    assert record.levels == record.varied_levels
    assert record.t == [n * case.tau for n in computed(case)]


def test_each_level_is_that_of_the_run_alone(tmp_path):
    case, varied = pairs_of(study_of(tmp_path, *MOVING))["tau"]
    record = run_pair(case, varied, mesh_of(case))
    one, other = (run_case(c, mesh_of(case))[0] for c in (case, varied))
    at = computed(case)
    assert record.t == [one.t[n] for n in at] == [other.t[2 * n] for n in at]
    assert record.levels["area"] == [one.levels["area"][n] for n in at]
    assert record.varied_levels["area"] == [other.levels["area"][2 * n] for n in at]


def test_flows_are_compared_where_their_errors_are(tmp_path):
    case, varied = pairs_of(study_of(tmp_path, *COMPARED))["tau"]
    record = run_pair(case, varied, mesh_of(case))
    assert record.t == list(case.compare_at)
    assert all(len(norms) == 2 for norms in record.norms.values())


def test_a_difference_orthogonal_to_the_error_counts_whole(tmp_path, monkeypatch):
    """The norm of the error shows it to second order only."""
    case = study_of(tmp_path, *MOVING).cases()[-1]
    solution = case.initial
    mesh, p = computational_mesh(mesh_of(case), solution, case.scheme.degree)
    exact = interpolation(mesh, solution, p, 0.0)
    rng = np.random.default_rng(0)
    e, d = rng.standard_normal((2, mesh.node_count))
    matrix = exact.mass / solution.length**2 + exact.stiffness
    d -= (d @ (matrix @ e)) / (e @ (matrix @ e)) * e
    d *= 1e-3 * np.sqrt((e @ (matrix @ e)) / (d @ (matrix @ d)))
    one = replace(exact.nodes, H=exact.nodes.H + e)
    other = replace(one, H=one.H + d)
    given = iter([one, other])
    monkeypatch.setattr(module, "states", lambda *_: iter([next(given)]))
    monkeypatch.setattr(module, "common_levels", lambda *_: [(0, 0)])
    norm = run_pair(case, case, mesh_of(case)).norms["H"][0]
    assert norm == pytest.approx(np.sqrt(d @ (matrix @ d)), rel=1e-3)
    shown = abs(nodal_errors(exact, other)["H"].h1(1.0) - nodal_errors(exact, one)["H"].h1(1.0))
    assert 0 < shown < 1e-2 * norm


@pytest.mark.parametrize("run", ["case", "varied"])
def test_a_run_that_stops_early_is_named_and_ends_both(tmp_path, run):
    """Start values that are wrong by 300 % end a run at once."""
    good = study_of(tmp_path, *MOVING).cases()[0]
    bad = good.model_copy(update={"disturbance": 3.0})
    pair = (bad, good) if run == "case" else (good, bad)
    record = run_pair(*pair, mesh_of(good))
    alone, _ = run_case(bad, mesh_of(good))
    assert (record.status, record.stopped) == (alone.status, run)
    assert (record.stopped_at, record.reason) == (alone.stopped_at, alone.reason)
    assert record.status != "ok" and len(record.t) <= len(alone.t)


@pytest.mark.parametrize("name", ["rounding", "tau"])
@pytest.mark.parametrize("kind", RUNS)
@pytest.mark.parametrize("every", [1, 3])
def test_a_pair_goes_on_to_the_last_bit(tmp_path, monkeypatch, kind, name, every):
    """Also where the levels after which the two can go on are at different times."""
    monkeypatch.setattr("esfem.solver.flow.FORGETS_EVERY", every)
    case, varied = pairs_of(study_of(tmp_path, *RUNS[kind]))[name]
    surface, path = mesh_of(case), tmp_path / "checkpoint.npz"
    expected = run_pair(case, varied, surface)
    assert expected.status == "ok" and max(expected.norms["x"]) > 0.0

    def keeper() -> Keeper:
        beside = varied.levels, varied.scheme.order
        order = case.scheme.order
        return Keeper(path, IDENTITY, case.levels, order, None, steps=1, beside=beside)

    for stop in (2, case.steps // 2, case.steps):

        def kill(fraction, stop=stop):
            if fraction >= stop / case.steps:
                raise Killed

        with pytest.raises(Killed):
            run_pair(case, varied, surface, kill, keeper())
    fractions: list[float] = []
    record = run_pair(case, varied, surface, fractions.append, keeper())
    assert len(fractions) <= every + 1
    for field in MEASURED:
        assert getattr(record, field) == getattr(expected, field), field


class TestStore:
    @pytest.fixture
    def pair(self, tmp_path):
        return pairs_of(study_of(tmp_path, *MOVING))["tau"]

    def test_what_is_written_is_read_and_what_was_edited_set_aside(self, tmp_path, pair):
        record, lines = run_pair(*pair, mesh_of(pair[0])), []
        store.write_record(tmp_path, "key", record)
        read = store.read_pair(tmp_path, "key", lines.append)
        assert (read, lines) == (record, [])
        path = store.record_path(tmp_path, "key")
        path.write_text(path.read_text().replace('"stopped": ""', '"stopped": "case"'))
        assert store.read_pair(tmp_path, "key", lines.append) is None
        assert "does not match its digest" in lines[0] and not path.exists()

    def test_the_key_holds_both_runs(self, pair):
        case, varied = pair
        keys = {store.key(case, "mesh"), store.key(varied, "mesh")}
        keys |= {store.key(case, "mesh", varied), store.key(varied, "mesh", case)}
        assert len(keys) == 4

    def test_the_checkpoint_of_a_run_alone_is_refused(self, tmp_path, pair, monkeypatch):
        monkeypatch.setattr("esfem.solver.flow.FORGETS_EVERY", 1)
        case, varied = pair
        path = tmp_path / "checkpoint.npz"
        alone = Keeper(path, IDENTITY, case.levels, 2, steps=1)
        run_case(case, mesh_of(case), keeper=alone)
        both = Keeper(path, {**IDENTITY, "varied": "x"}, case.levels, 2, beside=(varied.levels, 2))
        with pytest.raises(BadInput, match="varied is absent there"):
            run_pair(case, varied, mesh_of(case), keeper=both)


def test_all_six_variables_are_compared_on_the_surface_of_the_case(tmp_path):
    """The last State of each run, compared by hand."""
    case, varied = pairs_of(study_of(tmp_path, *MOVING))["tau"]
    last = {}

    def spied(mesh, state, other, length):
        last["given"] = differences(mesh, state, other, length)
        last["swapped"] = differences(mesh, other, state, length)
        return last["given"]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "differences", spied)
        record = run_pair(case, varied, mesh_of(case))
    found = {name: norms[-1] for name, norms in record.norms.items()}
    assert found == last["given"] != last["swapped"]
    assert found.keys() >= VARIABLES.keys()
