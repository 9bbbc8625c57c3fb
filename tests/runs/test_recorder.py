"""What a run measures beside its errors: what a scheme that does nothing would have."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest

from esfem.measuring.lift import VARIABLES, errors, lifted_surface
from esfem.meshes import surface_mesh
from esfem.runs.problem import initial_state
from esfem.runs.recorder import IDLE, Recorder, idle_levels
from esfem.runs.run_case import computational_mesh, run_case
from esfem.runs.store import read_record, record_path, write_record
from esfem.schemes.kll import KLLOptions
from esfem.studies.case import Case, Law, Solution

BREATHING = Solution(name="breathing_ellipsoid", amplitude=0.25)
AT_REST = Solution(name="clifford_torus", scale=0.5)
STEPS = 40


def case_of(solution: Solution, steps: int = STEPS, **scheme) -> Case:
    options = KLLOptions(degree=2, bdf=2, project=True, theta=True, **scheme)
    law, tau = Law(name="willmore"), 1e-3
    return Case(
        solution=solution, law=law, scheme=options, vertices=60, tau=tau, final_time=steps * tau
    )


def started(case: Case):
    """A recorder, and the initial State."""
    surface = surface_mesh(case.initial.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, case.initial, case.scheme.degree)
    recorder = Recorder(case, mesh, p, case.initial, 0.0)
    return recorder, initial_state(case.law, p, case.initial)


@pytest.mark.parametrize("steps", [1, 10, 16, 17, 400])
def test_the_idle_levels_are_few_and_the_last_is_one(steps):
    found = idle_levels(steps)
    assert {0, steps} <= found <= set(range(steps + 1))
    assert len(found) == min(steps, IDLE) + 1
    assert max(np.diff(sorted(found))) <= np.ceil(steps / IDLE)


@pytest.mark.parametrize("solution", [BREATHING, AT_REST])
def test_a_scheme_that_does_nothing_has_the_idle_errors(solution):
    case = case_of(solution)
    recorder, start = started(case)
    for n in range(STEPS + 1):
        recorder(n, replace(start, t=case.levels.t(n)))
    found = recorder.fields()
    levels = [0] if case.initial.stationary else sorted(idle_levels(STEPS))
    assert found["moved"] is False
    for norm in ("l2", "seminorm"):
        for name in VARIABLES:
            expected = [found[norm][name][n] for n in levels]
            assert found[f"idle_{norm}"][name] == expected
            assert max(expected) == max(found[norm][name])


def test_the_idle_error_is_that_of_the_start_on_the_surface_of_later():
    case = case_of(BREATHING, steps=4)
    record, _ = run_case(case, surface_mesh("sphere", 60))
    mesh, p = computational_mesh(surface_mesh("sphere", 60), case.initial, 2)
    start, X = initial_state(case.law, p, case.initial), case.initial.trajectories(p)
    for n, t in enumerate(record.t):
        found = errors(lifted_surface(mesh, case.initial, X(t), t), start)
        for name in VARIABLES:
            assert record.idle_l2[name][n] == found[name].l2
            assert record.idle_seminorm[name][n] == found[name].seminorm
    assert record.moved
    assert record.idle_h1()["x"][-1] > 1.5 * record.h1()["x"][-1]  # though V = 60 is coarse


def test_at_rest_idling_is_the_error_at_the_start():
    record, _ = run_case(case_of(AT_REST, steps=4), surface_mesh("clifford_torus", 60))
    for name in VARIABLES:
        assert record.idle_h1()[name] == record.h1()[name][:1]
        assert record.nodal_h1()[name][0] == 0.0 < record.nodal_h1()[name][-1]


@pytest.mark.parametrize("field", ["x", "nu", "H", "V", "z", "own_v"])
def test_it_has_moved_once_one_nodal_value_differed(field):
    """Also if it comes back."""
    case = case_of(AT_REST, steps=4)
    recorder, start = started(case)
    start = replace(start, own_v=start.v)
    other = getattr(start, field).copy()
    other.flat[0] = np.nextafter(other.flat[0], np.inf)
    moved = []
    for n, state in enumerate([start, start, replace(start, **{field: other}), start]):
        recorder(n, replace(state, t=case.levels.t(n)))
        moved.append(recorder.fields()["moved"])
    assert moved == [False, False, True, True]


def test_a_restored_recorder_goes_on_as_the_one_that_was_interrupted():
    """Also where all that moved did so before, and is back."""
    case = case_of(BREATHING, steps=4)
    (recorder, start), (other, _) = started(case), started(case)
    states = [start, replace(start, H=start.H + 1.0), start, start, start]
    for n, state in enumerate(states):
        if n == 3:
            other.restore(recorder.arrays())
        for each in (recorder, other)[: 1 if n < 3 else 2]:
            each(n, replace(state, t=case.levels.t(n)))
    one, two = recorder.fields(), other.fields()
    assert {**one, "seconds": {}} == {**two, "seconds": {}}
    assert two["moved"] is True
    assert len(two["idle_l2"]["x"]) == 5


def test_where_nodes_slide_idling_is_measured_by_shape():
    scheme = {"scheme": {"name": "bgn", "degree": 1}}
    case = Case.model_validate({**dict(case_of(BREATHING, steps=4)), **scheme})
    record, _ = run_case(case, surface_mesh("sphere", 60))
    assert record.idle_l2 == {} and record.moved
    for name, values in record.idle_levels.items():
        assert values[0] == record.levels[f"err_{name}"][0], name
    assert record.idle_levels["distance"][-1] > 1.2 * record.levels["err_distance"][-1]


def test_a_record_of_another_version_is_told_of_and_left_alone(tmp_path):
    record, _ = run_case(case_of(AT_REST, steps=1), surface_mesh("clifford_torus", 60))
    write_record(tmp_path, "key", record)
    assert read_record(tmp_path, "key", pytest.fail) == record
    path = record_path(tmp_path, "key")
    stored = json.loads(path.read_text())
    stored["record"]["h1"] = stored["record"].pop("seminorm")
    digest = hashlib.sha256(json.dumps(stored["record"], sort_keys=True).encode()).hexdigest()
    text = json.dumps({"digest": digest, "record": stored["record"]})
    path.write_text(text)
    lines: list[str] = []
    assert read_record(tmp_path, "key", lines.append) is None
    assert "another version" in lines[0] and path.read_text() == text
