"""``esfem mesh``: closed surfaces in each format, whole or not at all."""

import errno

import pytest
import trimesh

from esfem.meshes import SurfaceMesh


@pytest.fixture
def printed(esfem):
    """The command line: its status and standard output."""
    return lambda *words: esfem(*words)[:2]


@pytest.mark.parametrize("ending", [".npz", ".ply", ".stl", ".PLY", ".NPZ"])
def test_mesh_writes_a_closed_surface_of_the_asked_size(printed, tmp_path, ending):
    path = tmp_path / f"mesh{ending}"
    status, out = printed("mesh", "sphere", "--vertices", 60, "--out", path)
    assert status == 0 and "radius ratio" in out
    if ending.lower() == ".npz":
        assert len(SurfaceMesh.load(path).vertices) == 60
    else:
        mesh = trimesh.load(path)
        assert mesh.is_watertight and len(mesh.vertices) == 60


def test_a_mesh_that_cannot_be_written_leaves_the_old_one(printed, tmp_path, monkeypatch):
    path = tmp_path / "mesh.ply"
    path.write_text("old")

    def full(mesh, file, file_type):
        file.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("trimesh.Trimesh.export", full)
    assert printed("mesh", "sphere", "--vertices", 60, "--out", path)[0] == 2
    assert [p.name for p in tmp_path.iterdir()] == ["mesh.ply"]
    assert path.read_text() == "old"
