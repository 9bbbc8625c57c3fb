"""`esfem flow`: what it writes, that it goes on after an interruption, and how it fails."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from rich.console import Console
from studies import write_flow

from esfem.campaigns.publish import thinned
from esfem.common.bad_input import BadInput
from esfem.flows.evolution import compute, identity_of
from esfem.flows.flow_file import Checks, load_flow
from esfem.flows.flow_results import (
    NO_CLAIM,
    frame_path,
    read_flows,
    read_frame,
    stored_levels,
    write_frame,
)
from esfem.flows.history import COLUMNS, read_history
from esfem.flows.run_flow import run_flow
from esfem.flows.start import check_start, start_of
from esfem.meshes import committed_mesh_path, surface_mesh
from esfem.report.sections import cost
from esfem.runs.checkpoint import Keeper
from esfem.solver.laws import energy_of
from esfem.studies.catalogue import committed_flows, flow_path

QUIET = Console(quiet=True)
LEVELS = [0, 2, 4, 5, 6]
W = energy_of("willmore")


def test_a_flow_writes_history_frames_and_checks(command, tmp_path):
    status, out = command("flow", write_flow(tmp_path), "--out", tmp_path / "out", "--no-pictures")
    folder = tmp_path / "out" / "small"
    assert status == 0
    assert "PASS  runs to the end" in out and "PASS  energy decreases" in out
    rows = list(csv.DictReader((folder / "history.csv").read_text().splitlines()))
    assert tuple(rows[0]) == COLUMNS and len(rows) == 7
    assert stored_levels(folder) == LEVELS
    assert json.loads((folder / "checks.json").read_text())["checks"][1]["verdict"] == "pass"
    assert not (folder / "checkpoint.npz").exists()


def test_frames_keep_the_velocity_of_the_scheme(tmp_path):
    flow = load_flow(write_flow(tmp_path, ("theta = false", 'theta = false\nvelocity = "ritz"')))
    run_flow(flow, tmp_path, tmp_path / "out", 30.0, False, False, QUIET)
    frame = read_frame(tmp_path / "out" / "small", LEVELS[1])
    assert np.abs(frame.v - frame.V[:, None] * frame.nu).max() > 1e-3


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
    monkeypatch.setattr("esfem.solver.flow.FORGETS_EVERY", 1)  # every level may be resumed
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
        read_history(folder / "history.csv", W).column("energy") for folder in (whole, interrupted)
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
    last = len(read_history(tmp_path / "out" / "small" / "history.csv", W).rows) - 1
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
    assert json.loads((folder / "checks.json").read_text())["order_claim"] == NO_CLAIM
    # W does not change with the scale; that of the ellipsoid is 30.903, here estimated from edges
    # as long as half the radius of curvature of its tips.
    history = read_history(folder / "history.csv", W)
    assert history.column("energy")[0] == pytest.approx(30.903, rel=2e-2)


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
    (("every = 0.02", "every = 1e-12"), "[output] every = 1e-12: must be a whole multiple"),
    (("pictures = [0.0, 0.05]", "pictures = [0.07]"), "[output] pictures = 0.07"),
    (("degree = 2", "degree = 5"), "[scheme] degree = 5"),
    (("bdf = 2", "bdf = 2\nstart = 'exact'"), "must be 'self'"),
    (("energy_decreases = true", 'ends_at = "cube"'), "[checks] ends_at = 'cube'"),
    (("energy_decreases = true", 'reference = "axisymmetric"'), "only both together"),
    (
        ("pictures = [0.0, 0.05]", f"pictures = {[round(0.001 * i, 3) for i in range(61)]}"),
        "[output] pictures: 61 times, must be 60 at most",
    ),
    (("[checks]", "[checks]\nstationary_from = 0.06"), "[checks] stationary_from = 0.06: must be"),
    (("[checks]", "[checks]\nstationary_from = 0.07"), "[checks] stationary_from = 0.07: must be"),
    (
        ("[checks]", "[checks]\nreference = 'axisymmetric'\nreference_at = [0.01, 0.01]"),
        "[checks] reference_at = 0.01: occurs twice",
    ),
    (("[checks]", "[cheques]"), "[cheques]: unknown key"),
    (("[checks]", "[checks"), "is not valid TOML"),
]


FINER = ("tau = 0.01", "tau = 0.001")  # for many pictures


@pytest.mark.parametrize(("change", "message"), FINDINGS)
def test_bad_input_is_one_line_and_status_2(command, tmp_path, change, message):
    changes = (change, FINER) if "61 times" in message else (change,)
    status, out = command("flow", write_flow(tmp_path, *changes), "--out", tmp_path / "out")
    assert status == 2
    assert message in " ".join(out.split())
    assert "Traceback" not in out
    assert not (tmp_path / "out" / "small").exists()


# Each of [checks], at times at which nothing else asks for a frame.
ASKED = {
    "energy_decreases": (True, ["energy decreases", "energy falls"]),
    "ends_at": ("sphere", ["ends at the energy of a sphere"]),
    "ends_within": (100.0, []),
    "stationary_from": (0.03, ["energy at rest", "surface at rest"]),
    "stationary_within": (100.0, []),
    "reference": ("axisymmetric", ["W at t = 0.01", "W at t = 0.05"]),
    "reference_at": ([0.01, 0.05], []),
    "reference_within": (0.5, []),
}


def test_every_check_is_made_of_a_flow_without_further_frames(command, tmp_path):
    assert ASKED.keys() == Checks.model_fields.keys()
    asked = "\n".join(
        f"{key} = {str(value).lower() if value is True else repr(value)}"
        for key, (value, _) in ASKED.items()
    )
    path = write_flow(
        tmp_path,
        ("every = 0.02\npictures = [0.0, 0.05]", ""),
        ("energy_decreases = true", asked),
    )
    status, _ = command("flow", path, "--out", tmp_path / "out", "--no-pictures")
    assert status == 0
    made = json.loads((tmp_path / "out" / "small" / "checks.json").read_text())["checks"]
    expected = [name for _, names in ASKED.values() for name in names]
    assert [check["name"] for check in made] == ["runs to the end", *expected]
    assert stored_levels(tmp_path / "out" / "small") == [0, 3, 6]


class TestBeforeTheFirstStep:
    """What would be lost after all steps is refused before them."""

    def refused(self, command, tmp_path, *changes, pictures="--no-pictures") -> str:
        words = ("flow", write_flow(tmp_path, *changes), "--out", tmp_path / "out", pictures)
        status, out = command(*words)
        assert status == 2 and len(out.strip().splitlines()) == 1
        assert not (tmp_path / "out" / "small" / "history.csv").exists()
        return out

    def test_a_reference_that_fails(self, command, tmp_path, monkeypatch):
        def singular(*_):
            raise RuntimeError("rtol = 1e-09: not met at t = 0.02: step size too small")

        monkeypatch.setattr("esfem.reference_solutions.surface_flow._profile_flow", singular)
        asked = "reference = 'axisymmetric'\nreference_at = [0.05]"
        out = self.refused(command, tmp_path, ("[checks]", f"[checks]\n{asked}"))
        assert "[checks] reference_at = 0.05: the axisymmetric solver does not get there" in out
        assert "rtol = 1e-09: not met at t = 0.02" in out

    def test_a_library_for_the_pictures_that_is_broken(self, command, tmp_path, monkeypatch):
        def broken(name):
            raise ImportError("libGL.so.1: cannot open shared object file")

        monkeypatch.setattr("esfem.flows.run_flow.find_spec", lambda name: True)
        monkeypatch.setattr("esfem.flows.run_flow.import_module", broken)
        out = self.refused(command, tmp_path, pictures="--pictures")
        assert "pyvista: is installed, but cannot be imported: libGL.so.1" in out

    def test_a_start_that_means_nothing(self, tmp_path):
        flow = load_flow(write_flow(tmp_path))
        start = start_of(flow, tmp_path, tmp_path, QUIET)
        bad = replace(start, state=replace(start.state, nu=-start.state.nu))
        with pytest.raises(
            BadInput, match=r"\[start\] no flow can start there: element .* inverted"
        ):
            check_start(flow, bad)


def test_pictures_that_cannot_be_written_lose_neither_numbers_nor_checks(
    command, tmp_path, monkeypatch
):
    def full(*_):
        raise OSError("No space left on device")

    words = ("flow", write_flow(tmp_path), "--out", tmp_path / "out")
    folder = tmp_path / "out" / "small"
    with monkeypatch.context() as context:
        context.setattr("esfem.flows.pictures.save_surfaces", full)
        status, out = command(*words)
    assert status == 2 and "PASS  energy decreases" in out and "No space left on device" in out
    (result,) = read_flows(folder.parent)
    assert result.outcome == "pass" and not (folder / "surfaces.png").exists()
    status, out = command(*words)
    assert status == 0 and "is stored" in out
    assert (folder / "surfaces.png").exists()


@pytest.mark.parametrize("content", [b"", b"PK damaged"])
def test_a_damaged_frame_is_named(tmp_path, content):
    frame_path(tmp_path, 3).parent.mkdir()
    frame_path(tmp_path, 3).write_bytes(content)
    with pytest.raises(BadInput, match=r"00000003\.npz: no frame that can be read"):
        read_frame(tmp_path, 3)


def test_an_unknown_name_lists_the_committed_flows(command, tmp_path):
    status, out = command("flow", "cube", "--out", tmp_path)
    assert status == 2
    told = " ".join(out.split()).partition("those are ")[2].split(", ")
    assert sorted(told) == sorted(committed_flows())


@pytest.mark.parametrize("path", committed_flows().values(), ids=lambda path: path.stem)
def test_the_committed_flows_are_those_of_the_figure(path):
    flow = load_flow(path)
    assert flow.name == path.stem
    assert (flow.time.tau, flow.time.final_time) == (0.2 / 2**8, 4.0)
    assert flow.scheme.bdf == 2
    assert len(flow.pictured) == (2 if flow.scheme.reaction == "extrapolated" else 6)
    assert flow.checks.energy_decreases and flow.checks.ends_at
    assert flow.checks.stationary_from == 3.0
    assert committed_mesh_path(flow.start.surface, flow.start.vertices).exists()


@pytest.mark.parametrize("name", ["ellipsoid", "red-blood-cell", "rippled-torus"])
def test_beside_each_committed_flow_stands_the_same_one_extrapolated(name):
    both = [load_flow(flow_path(stem)) for stem in (name, f"{name}-extrapolated")]
    assert [flow.scheme.reaction for flow in both] == ["linearised", "extrapolated"]
    schemes = [flow.scheme.model_copy(update={"reaction": None}) for flow in both]
    for one, other in (schemes, *([getattr(f, k) for f in both] for k in ("start", "time", "law"))):
        assert one == other
    assert both[0].checks == both[1].checks


def test_a_surface_is_drawn_and_given_to_paraview(command, tmp_path):
    pytest.importorskip("pyvista")
    import matplotlib.pyplot as plt

    assert command("flow", write_flow(tmp_path), "--out", tmp_path)[0] == 0
    image = plt.imread(tmp_path / "small" / "surfaces.png")
    assert image.shape[0] > 200 and image[..., :3].std() > 0.1  # not one colour
    written = {path.name for path in (tmp_path / "small").iterdir()}
    assert {"energy.svg", "energy.pdf", "small.pvd"} <= written
    names = [f"small-{n:08d}.vtu" for n in LEVELS]
    assert sorted(path.name for path in (tmp_path / "small" / "vtu").iterdir()) == names


def test_what_a_flow_took_is_told_of_a_thinned_history_too(command, tmp_path):
    command("flow", write_flow(tmp_path), "--out", tmp_path, "--no-pictures")
    path = tmp_path / "small" / "history.csv"
    (whole,) = read_flows(tmp_path)
    assert cost(whole).startswith("6 steps in ")
    path.write_text(thinned(path.read_text(), 3))
    (fewer,) = read_flows(tmp_path)
    assert len(fewer.history.rows) < 7 and cost(fewer).startswith("6 steps in ")


def test_without_pyvista_a_line_says_how_to_get_it(command, tmp_path, monkeypatch):
    monkeypatch.setattr("esfem.flows.run_flow.find_spec", lambda name: None)
    status, out = command("flow", write_flow(tmp_path), "--out", tmp_path)
    assert status == 0
    assert out.count("pip install 'esfem-willmore[pictures]'") == 1
    written = {path.name for path in (tmp_path / "small").iterdir()}
    assert "energy.svg" in written and not written & {"surfaces.png", "small.pvd", "vtu"}


def test_files_for_paraview_grow_with_the_flow(tmp_path, monkeypatch):
    """A flow that is killed leaves a whole series of the frames so far."""
    pytest.importorskip("pyvista")
    flow = load_flow(write_flow(tmp_path))

    def kill(folder, n, state):
        if n == LEVELS[3]:
            raise Killed
        write_frame(folder, n, state)

    monkeypatch.setattr("esfem.flows.evolution.write_frame", kill)
    with pytest.raises(Killed):
        run_flow(flow, tmp_path, tmp_path, 30.0, False, True, QUIET)
    text = (tmp_path / "small" / "small.pvd").read_text()
    assert text.count("<DataSet") == 3 and text.endswith("</VTKFile>")
    monkeypatch.undo()
    run_flow(flow, tmp_path, tmp_path, 30.0, False, True, QUIET)
    assert (tmp_path / "small" / "small.pvd").read_text().count("<DataSet") == len(LEVELS)


def test_a_file_that_is_a_folder_is_bad_input(tmp_path):
    folder = tmp_path / "flow.toml"
    folder.mkdir()
    with pytest.raises(BadInput, match="cannot be read"):
        load_flow(folder)
