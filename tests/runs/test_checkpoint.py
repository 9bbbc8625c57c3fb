"""Checkpoints: to the last bit, of the right run only, whole or not at all."""

import errno
import os
import subprocess
from dataclasses import fields as fields_of
from dataclasses import replace

import numpy as np
import pytest
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.meshes import surface_mesh
from esfem.runs.checkpoint import Checkpoint, Keeper, read_checkpoint, write_checkpoint
from esfem.runs.run_case import Record, run_case
from esfem.solver import Levels, State, remembered
from esfem.studies.study import load_study

IDENTITY = {"numerics": "abc", "tau": "0.1"}
LEVELS = Levels.equal(1.0, 1000)
TIMES = ("seconds", "environment")  # the only fields of a record that may differ
MEASURED = [field.name for field in fields_of(Record) if field.name not in TIMES]


class Killed(BaseException):
    """Ends a run where a kill would."""


def state(t: float, nodes: int = 5) -> State:
    rng = np.random.default_rng(round(1000 * t))
    vectors = [rng.standard_normal((nodes, 3)) for _ in range(3)]
    return State(t, vectors[0], vectors[1], *rng.standard_normal((2, nodes)), vectors[2])


def checkpoint(depth: int = 2) -> Checkpoint:
    past = tuple(state(0.3 - 0.1 * j) for j in range(depth))
    return Checkpoint(past, {"levels/energy": np.array([0.1, np.nan, np.inf])})


@pytest.fixture(autouse=True)
def any_level(monkeypatch):
    """Every level is resumable, so that short runs show what long ones do."""
    monkeypatch.setattr("esfem.solver.flow.FORGETS_EVERY", 1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "checkpoints" / "run.npz"


def same(one: State, other: State) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(fields(one), fields(other), strict=True))


def fields(s: State) -> tuple:
    return (s.t, s.x, s.nu, s.H, s.V, s.z, s.v)


class TestFile:
    def test_what_is_written_is_read_to_the_last_bit(self, path):
        write_checkpoint(path, IDENTITY, checkpoint(3))
        found = read_checkpoint(path, IDENTITY)
        assert len(found.past) == 3
        assert all(same(a, b) for a, b in zip(found.past, checkpoint(3).past, strict=True))
        np.testing.assert_array_equal(found.arrays["levels/energy"], [0.1, np.nan, np.inf])

    def test_a_velocity_that_is_not_V_nu_is_kept(self, path):
        own = replace(state(0.3), own_v=np.ones((5, 3)))
        write_checkpoint(path, IDENTITY, Checkpoint((own, state(0.2)), {}))
        past = read_checkpoint(path, IDENTITY).past
        np.testing.assert_array_equal(past[0].v, 1.0)
        assert past[1].own_v is None

    def test_that_of_another_run_is_refused_by_name_and_value(self, path):
        write_checkpoint(path, IDENTITY, checkpoint())
        with pytest.raises(BadInput, match="numerics is abc there, def here"):
            read_checkpoint(path, {**IDENTITY, "numerics": "def"})
        with pytest.raises(BadInput, match=r"tau is 0\.1 there, 0\.2 here"):
            read_checkpoint(path, {**IDENTITY, "tau": "0.2"})

    @pytest.mark.parametrize("fraction", [0.0, 0.3, 0.7, 0.99])
    def test_a_truncated_one_is_refused(self, path, fraction):
        write_checkpoint(path, IDENTITY, checkpoint())
        content = path.read_bytes()
        path.write_bytes(content[: int(fraction * len(content))])
        with pytest.raises(BadInput, match="damaged"):
            read_checkpoint(path, IDENTITY)

    def test_a_changed_byte_is_noticed(self, path):
        write_checkpoint(path, IDENTITY, checkpoint())
        content = bytearray(path.read_bytes())
        place = content.find(checkpoint().past[0].x.tobytes())
        content[place] ^= 1
        path.write_bytes(content)
        with pytest.raises(BadInput, match="damaged"):
            read_checkpoint(path, IDENTITY)


class TestKeeper:
    def keeper(self, path, **options) -> Keeper:
        return Keeper(path, IDENTITY, LEVELS, 2, **options)

    def test_a_short_run_writes_nothing(self, path):
        keeper = self.keeper(path, seconds=3600.0)
        for n in range(100):
            keeper.keep(n, state(n), dict)
        assert not path.exists()

    def test_every_so_many_steps(self, path):
        keeper = self.keeper(path, seconds=None, steps=3)
        written = []
        for n in range(10):
            keeper.keep(n, state(n), lambda n=n: {"n": np.array(n)})
            if path.exists():
                written.append(int(read_checkpoint(path, keeper._identity).arrays["n"]))
        assert written == [3, 3, 3, 6, 6, 6, 9]

    def test_it_keeps_the_last_states_newest_first(self, path):
        keeper = self.keeper(path, steps=8)
        for n in range(9):
            keeper.keep(n, state(n), dict)
        newest = [8.0 - j for j in range(remembered(2))]
        assert [s.t for s in self.keeper(path).resume().past] == newest

    def test_nothing_to_resume_is_none(self, path):
        assert self.keeper(path).resume() is None

    def test_a_command_refuses_and_a_sweep_starts_anew(self, path):
        write_checkpoint(path, {"format": "1", **IDENTITY, "tau": "0.2"}, checkpoint())
        with pytest.raises(BadInput, match=r"tau is 0\.2 there"):
            self.keeper(path).resume()
        lines: list[str] = []
        assert self.keeper(path, refused=lines.append).resume() is None
        assert "tau is 0.2 there, 0.1 here" in lines[0]

    def test_writing_takes_a_small_share_of_the_time(self, path, monkeypatch):
        now = [0.0]
        monkeypatch.setattr("esfem.runs.checkpoint.monotonic", lambda: now[0])
        monkeypatch.setattr("esfem.runs.checkpoint.write_checkpoint", lambda *_: slow())
        written = []

        def slow():
            written.append(now[0])
            now[0] += 2.0

        keeper = self.keeper(path, seconds=1.0)
        for n in range(100):
            now[0] += 1.0
            keeper.keep(n, state(n), dict)
        assert 2 <= len(written) <= 4

    def test_done_leaves_nothing_not_even_of_killed_writers(self, path):
        keeper = self.keeper(path, steps=1)
        for n in range(3):
            keeper.keep(n, state(n), dict)
        path.with_name(f".{path.name}.writing-elsewhere-1-2").touch()
        keeper.discard()
        assert list(path.parent.iterdir()) == []

    def test_a_full_disk_is_told_and_the_last_one_kept(self, path, monkeypatch):
        lines: list[str] = []
        keeper = self.keeper(path, steps=1, say=lines.append)
        for n in range(2):
            keeper.keep(n, state(n), dict)
        good = path.read_bytes()

        def full(descriptor):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr("esfem.common.files.os.fsync", full)
        keeper.keep(2, state(2), dict)
        keeper.keep(3, state(3), dict)
        assert len(lines) == 1
        assert path.read_bytes() == good and len(list(path.parent.iterdir())) == 1
        assert "No space left on device" in lines[0] and "the one before is kept" in lines[0]


@pytest.fixture
def small_disk(tmp_path):
    """A folder with 64 kB; skipped where nothing can be mounted."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("a file system of its own cannot be mounted here")
    yield folder
    subprocess.run(["umount", folder], check=True)


def test_a_really_full_disk_keeps_the_last_checkpoint(small_disk):
    path, lines = small_disk / "run.npz", []
    keeper = Keeper(path, IDENTITY, LEVELS, 2, steps=1, say=lines.append)
    for n, size in enumerate([1, 1, 10_000]):
        keeper.keep(n, state(n), lambda size=size: {"much": np.zeros(size)})
    assert len(keeper.resume().arrays["much"]) == 1
    assert "No space left on device" in lines[0] and len(lines) == 1
    assert [p.name for p in small_disk.iterdir()] == ["run.npz"]


HELFRICH = [
    ('name = "sphere"\nradius = 1.0', 'name = "helfrich_sphere"'),
    ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0'),
    ("theta = false", "theta = true"),
    ("tau = [0.25, 0.125]", "tau = [0.03125]"),
    ('claim = "section-7"', ""),
]
RUNS = {
    "BDF2, stationary": [("tau = [0.25, 0.125]", "tau = [0.03125]")],
    "BDF1, moving": [*HELFRICH, ("bdf = 2", "bdf = 1")],
    **{
        f"BDF2, {reaction}": [*HELFRICH, ('"extrapolated"', f'"{reaction}"')]
        for reaction in ("implicit", "linearised")
    },
    "BDF4, self-started": [*HELFRICH, ("bdf = 2", 'bdf = 4\nstart = "self"')],
    "BDF3, first steps divided": [
        *HELFRICH,
        ("bdf = 2", 'bdf = 3\nstart = "self"'),
        ("final_time = 0.5", "final_time = 0.25\nfirst_steps = 3"),
    ],
    "compared": [
        ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"'),
        ("vertices = [30, 60, 120, 240, 480]", "vertices = [60, 240]"),
        ("tau = [0.25, 0.125]", "tau = [0.005]\ncompare_at = [0.02, 0.05]"),
        ("final_time = 0.5", "final_time = 0.05"),
        ('claim = "section-7"', ""),
    ],
}


@pytest.fixture(params=RUNS)
def case(request, tmp_path):
    return load_study(write_study(tmp_path, *RUNS[request.param])).cases()[0]


@pytest.mark.parametrize("steps", [1, 3])
def test_a_run_goes_on_to_the_last_bit(case, path, steps):
    surface = surface_mesh(case.solution.initial().mesh_surface, case.vertices)
    expected, snapshots = run_case(case, surface)

    def keeper() -> Keeper:
        return Keeper(path, IDENTITY, case.levels, case.scheme.bdf, steps=steps)

    for stop in (1, 2, case.steps // 2, case.steps):

        def kill(fraction, stop=stop):
            if fraction >= stop / case.steps:
                raise Killed

        with pytest.raises(Killed):
            run_case(case, surface, kill, keeper())
    fractions: list[float] = []
    record, again = run_case(case, surface, fractions.append, keeper())
    last = range(case.steps - len(fractions) + 1, case.steps + 1)
    assert fractions == [n / case.steps for n in last] and len(fractions) <= steps + 1
    for name in MEASURED:
        assert getattr(record, name) == getattr(expected, name), name
    np.testing.assert_array_equal(again, snapshots)


def test_the_seconds_of_all_parts_are_counted(case, path):
    surface = surface_mesh(case.solution.initial().mesh_surface, case.vertices)
    keeper = Keeper(path, IDENTITY, case.levels, case.scheme.bdf, steps=case.steps)
    first, _ = run_case(case, surface, keeper=keeper)
    keeper = Keeper(path, IDENTITY, case.levels, case.scheme.bdf)
    second, _ = run_case(case, surface, keeper=keeper)
    assert second.seconds["total"] > 0.5 * first.seconds["total"]
    assert second.seconds["krylov"] == first.seconds["krylov"]
