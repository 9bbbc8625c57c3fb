"""`esfem flow`: what it writes, that it goes on after an interruption, and how it fails."""

import csv
import json

import numpy as np
import pytest
import trimesh
from rich.console import Console
from studies import SMALL_FLOW, write_varied

from harness.bad_input import BadInput
from harness.checkpoint import Keeper
from harness.flows.checks import energy_decreases
from harness.flows.command import COMMITTED, run_flow
from harness.flows.evolution import compute, identity_of
from harness.flows.flow_file import load_flow
from harness.flows.frames import read_frame, stored_levels
from harness.flows.history import COLUMNS, History, read_history
from harness.flows.report import NO_CLAIM
from harness.flows.start import start_of
from harness.meshing import committed_mesh_path, surface_mesh

QUIET = Console(quiet=True)
LEVELS = [0, 2, 4, 5, 6]


def write_flow(folder, *changes, text=SMALL_FLOW):
    return write_varied(folder / "small.toml", text, *changes)


def test_a_flow_writes_history_frames_and_checks(command, tmp_path):
    status, out = command("flow", write_flow(tmp_path), "--out", tmp_path / "out", "--no-pictures")
    folder = tmp_path / "out" / "small"
    assert status == 0
    assert "PASS  runs to the end" in out and "PASS  energy decreases" in out
    rows = list(csv.DictReader((folder / "history.csv").read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS and len(rows) == 7
    assert stored_levels(folder) == LEVELS
    assert json.loads((folder / "checks.json").read_text())["checks"][1]["verdict"] == "pass"
    assert "PASS" in (folder / "report.md").read_text()
    assert not (folder / "checkpoint.npz").exists()


def test_a_stored_flow_is_not_computed_again(command, tmp_path):
    words = ("flow", write_flow(tmp_path), "--out", tmp_path / "out", "--no-pictures")
    command(*words)
    path = tmp_path / "out" / "small" / "history.csv"
    before = path.stat().st_mtime_ns
    assert "is stored" in command(*words)[1]
    assert path.stat().st_mtime_ns == before
    assert "is stored" not in command(*words, "--force")[1]
    write_flow(tmp_path, ("tau = 0.01", "tau = 0.005"))
    assert "is stored" not in command(*words)[1]


def test_a_flow_that_is_computed_anew_and_killed_does_not_count_as_stored(command, tmp_path):
    words = ("flow", write_flow(tmp_path), "--out", tmp_path / "out", "--no-pictures")
    command(*words)
    folder = tmp_path / "out" / "small"
    flow = load_flow(tmp_path / "small.toml")
    start = start_of(flow, tmp_path, tmp_path, QUIET)
    identity = identity_of(flow, start)

    def kill(n, state, history):
        raise Killed

    keeper = Keeper(folder / "checkpoint.npz", identity, flow.levels, flow.scheme.bdf)
    with pytest.raises(Killed):
        compute(flow, start, folder, identity, keeper, kill)
    assert stored_levels(folder) == [0]
    assert "is stored" not in command(*words)[1]


class Killed(Exception):
    pass


def test_an_interrupted_flow_goes_on_to_the_last_bit(tmp_path, monkeypatch):
    monkeypatch.setattr("solver.flow.FORGETS_EVERY", 1)  # every level may be resumed
    flow = load_flow(write_flow(tmp_path))
    start = start_of(flow, tmp_path, tmp_path, QUIET)
    identity = identity_of(flow, start)

    def evolved(folder, watch):
        keeper = Keeper(
            folder / "checkpoint.npz", identity, flow.levels, flow.scheme.bdf, None, steps=1
        )
        return compute(flow, start, folder, identity, keeper, watch)

    def kill(n, state, history):
        if n == 3:
            raise Killed

    whole, interrupted = tmp_path / "whole", tmp_path / "interrupted"
    evolved(whole, lambda *_: None)
    with pytest.raises(Killed):
        evolved(interrupted, kill)
    seen = []
    evolved(interrupted, lambda n, *_: seen.append(n))
    assert seen == [3, 4, 5, 6]
    for n in LEVELS:
        for name in ("x", "nu", "H", "V", "z"):
            a, b = (getattr(read_frame(folder, n), name) for folder in (whole, interrupted))
            assert np.array_equal(a, b)
    a, b = (
        read_history(folder / "history.csv").column("energy") for folder in (whole, interrupted)
    )
    assert np.array_equal(a, b) and len(a) == 7


def test_a_flow_that_diverges_keeps_its_last_state_and_exits_with_1(command, tmp_path):
    path = write_flow(
        tmp_path,
        ('surface = "ellipsoid"\nvertices = 60', 'surface = "red_blood_cell"\nvertices = 60'),
        ("tau = 0.01", "tau = 0.5"),
        ("final_time = 0.06", "final_time = 20.0"),
        ("every = 0.02\npictures = [0.0, 0.05]", "every = 20.0"),
    )
    status, out = command("flow", path, "--out", tmp_path / "out", "--no-pictures")
    assert status == 1
    assert "FAIL  runs to the end: diverged at t" in out
    last = len(read_history(tmp_path / "out" / "small" / "history.csv").rows) - 1
    assert stored_levels(tmp_path / "out" / "small") == sorted({0, last})


def test_a_mesh_of_a_user_flows_and_claims_no_order(command, tmp_path):
    mesh = surface_mesh("ellipsoid", 240)
    trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False).export(tmp_path / "mine.stl")
    path = write_flow(
        tmp_path, ('surface = "ellipsoid"\nvertices = 60', 'mesh = "mine.stl"\nscale = 2.0')
    )
    status, out = command("flow", path, "--out", tmp_path / "out", "--no-pictures")
    folder = tmp_path / "out" / "small"
    assert status == 0
    assert "no order claim applies" in out
    assert NO_CLAIM in (folder / "report.md").read_text()
    # W does not change with the scale; that of the ellipsoid is 30.903, here estimated from edges
    # as long as half the radius of curvature of its tips.
    assert read_history(folder / "history.csv").column("energy")[0] == pytest.approx(
        30.903, rel=2e-2
    )


def test_a_broken_mesh_is_bad_input_and_leaves_nothing(command, tmp_path):
    mesh = surface_mesh("ellipsoid", 60)
    open_ = trimesh.Trimesh(mesh.vertices, mesh.triangles[:-1], process=False)
    open_.export(tmp_path / "mine.ply")
    path = write_flow(tmp_path, ('surface = "ellipsoid"\nvertices = 60', 'mesh = "mine.ply"'))
    status, out = command("flow", path, "--out", tmp_path / "out", "--no-pictures")
    assert status == 2
    assert "mine.ply: not closed: 3 of 115 faces" in out
    assert not (tmp_path / "out" / "small").exists()


FINDINGS = [
    (('name = "small"', 'name = "Small"'), "[flow] name = 'Small'"),
    (("vertices = 60", 'vertices = 60\nmesh = "a.stl"'), "exactly one of them"),
    (("vertices = 60", ""), "vertices: belongs to surface"),
    (("vertices = 60", "vertices = 60\nscale = 2.0"), "scale = 2.0: is for a mesh only"),
    (('surface = "ellipsoid"', 'surface = "cube"'), "must be one of"),
    (('surface = "ellipsoid"\nvertices = 60', 'mesh = "absent.stl"'), "absent.stl: cannot be read"),
    (("vertices = 60", "vertices = 5"), "at least 12"),
    (("tau = 0.01", "tau = 0.011"), "final_time = 0.06: must be a whole multiple"),
    (("tau = 0.01", "tau = -1.0"), "greater than 0"),
    (("every = 0.02", "every = 0.015"), "[output] every = 0.015: must be a whole multiple"),
    (("pictures = [0.0, 0.05]", "pictures = [0.07]"), "[output] pictures = 0.07"),
    (("degree = 2", "degree = 5"), "[scheme] degree = 5"),
    (("bdf = 2", "bdf = 2\nstart = 'exact'"), "must be 'self'"),
    (("energy_decreases = true", 'ends_at = "cube"'), "[checks] ends_at = 'cube'"),
    (("energy_decreases = true", 'reference = "axisymmetric"'), "only both together"),
    (('name = "willmore"', 'name = "surface_diffusion"'), "is for law 'willmore'"),
    (("[checks]", "[cheques]"), "[cheques]: unknown key"),
    (("[checks]", "[checks"), "is not valid TOML"),
]


@pytest.mark.parametrize(("change", "message"), FINDINGS)
def test_bad_input_is_one_line_and_status_2(command, tmp_path, change, message):
    status, out = command("flow", write_flow(tmp_path, change), "--out", tmp_path / "out")
    assert status == 2
    assert message in " ".join(out.split())
    assert "Traceback" not in out
    assert not (tmp_path / "out" / "small").exists()


def test_an_unknown_name_lists_the_committed_flows(command, tmp_path):
    status, out = command("flow", "cube", "--out", tmp_path)
    assert status == 2
    assert "ellipsoid, red-blood-cell, rippled-torus" in " ".join(out.split())


@pytest.mark.parametrize("path", sorted(COMMITTED.glob("*.toml")), ids=lambda path: path.stem)
def test_the_committed_flows_are_those_of_the_figure(path):
    flow = load_flow(path)
    assert flow.name == path.stem
    assert (flow.time.tau, flow.time.final_time) == (0.2 / 2**8, 4.0)
    assert len(flow.pictured) == 6 and flow.pictured[0] == 0
    assert flow.checks.energy_decreases and flow.checks.ends_at
    assert flow.checks.stationary_from == 3.0
    assert committed_mesh_path(flow.start.surface, flow.start.vertices).exists()


def test_an_increase_of_the_energy_is_seen():
    history = History()
    for t, W in enumerate((3.0, 2.0, 2.0 + 1e-7, 1.0)):
        history.rows.append((float(t), W, *[0.0] * (len(COLUMNS) - 2)))
    check = energy_decreases(history)
    assert check.verdict == "fail" and "at t = 2" in check.text
    history.rows[2] = (2.0, 2.0 + 1e-12, *[0.0] * (len(COLUMNS) - 2))
    assert energy_decreases(history).verdict == "pass"


@pytest.mark.parametrize("library", ["pyvista", "matplotlib"])
def test_pictures_are_made_with_and_without_pyvista(tmp_path, monkeypatch, library):
    import matplotlib.pyplot as plt

    from harness.flows import pictures

    if library == "pyvista":
        pytest.importorskip("pyvista")
    else:
        monkeypatch.setattr(pictures, "find_spec", lambda name: None)
    flow = load_flow(write_flow(tmp_path))
    checks = run_flow(flow, tmp_path, tmp_path, 30.0, False, True, QUIET)
    assert all(check.verdict == "pass" for check in checks)
    image = plt.imread(tmp_path / "small" / "surfaces.png")
    assert image.shape[0] > 200 and image[..., :3].std() > 0.1  # not one colour
    assert {"energy.svg", "energy.pdf"} <= {path.name for path in (tmp_path / "small").iterdir()}


def test_a_file_that_is_a_folder_is_bad_input(tmp_path):
    folder = tmp_path / "flow.toml"
    folder.mkdir()
    with pytest.raises(BadInput, match="cannot be read"):
        load_flow(folder)
