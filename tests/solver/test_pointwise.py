"""Formulas and kernels: compiled and interpreted alike, one thread or several, cached safely."""

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import esfem.solver
from esfem.solver import forms, pointwise
from esfem.solver.geometry import geometry
from esfem.solver.laws import willmore
from esfem.solver.pointwise import (
    POINTS_A_THREAD,
    apply,
    at,
    cross,
    dot,
    flat,
    interpreted,
    kernel,
    matrix_at,
    put,
    put_matrix,
    transpose,
)

ROOT = Path(esfem.solver.__file__).parent.parent


def everything(rough) -> np.ndarray:
    """All that kernels compute in a step, as one long vector."""
    geo = geometry(rough.mesh, rough.x)
    c = forms.curvature(geo, rough.u, willmore, 0.0)
    fields = (geo.dA, geo.normal, geo.B, c.grad_H, c.S, c.S2, *forms.loads(geo, c))
    return np.concatenate([a.ravel() for a in (*fields, forms.F(geo, c, rough.w))])


@kernel
def turned(start, stop, a, b):
    for p in range(start, stop):
        put(b, p, cross(at(a, p), at(b, p)))


class TestVocabulary:
    @pytest.fixture
    def ab(self):
        return np.random.default_rng(0).standard_normal((2, 3, 5))

    def test_vectors_are_those_of_numpy(self, ab):
        a, b = ab
        np.testing.assert_allclose(dot(a, b), np.einsum("ap,ap->p", a, b), rtol=0, atol=1e-14)
        np.testing.assert_allclose(cross(a, b), np.cross(a, b, axis=0), rtol=0, atol=1e-14)

    def test_matrices_act_by_rows(self):
        A, a = np.random.default_rng(0).standard_normal((2, 3, 3))
        np.testing.assert_allclose(apply(A, a[0]), A @ a[0], rtol=0, atol=1e-14)
        np.testing.assert_array_equal(transpose(A), A.T)

    def test_a_matrix_is_stored_as_a_fortran_field(self):
        field = np.asfortranarray(np.random.default_rng(0).standard_normal((4, 2, 3, 3)))
        np.testing.assert_array_equal(matrix_at(flat(field), 5), field[1, 1])  # p = E q + e
        copy = np.zeros_like(flat(field))
        put_matrix(copy, 5, field[1, 1])
        np.testing.assert_array_equal(copy[..., 5], flat(field)[..., 5])


class TestKernel:
    @pytest.mark.parametrize("k", [1, 2, 4])
    def test_interpreted_computes_the_same(self, make_rough, k):
        rough = make_rough(k)
        compiled = everything(rough)
        with interpreted():
            expected = everything(rough)
        np.testing.assert_allclose(compiled, expected, rtol=1e-11, atol=1e-11)

    def test_threads_compute_the_same_bits(self, monkeypatch):
        a, b = np.random.default_rng(0).standard_normal((2, 3, 3 * POINTS_A_THREAD + 7))
        results = []
        for threads in (1, 2, 5):
            monkeypatch.setattr("esfem.solver.pointwise.thread_count", lambda n=threads: n)
            results.append(b.copy())
            turned(a, results[-1])
        np.testing.assert_allclose(results[0], np.cross(a, b, axis=0), rtol=0, atol=1e-14)
        np.testing.assert_array_equal(results[1], results[0])
        np.testing.assert_array_equal(results[2], results[0])


class TestCache:
    """Numba's index of a cache is a pickle: whoever may write there may run code."""

    @pytest.fixture
    def place(self, tmp_path, monkeypatch):
        """The parent of the cache, in which there is nothing yet."""
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "new" / "cache"))
        return tmp_path / "new" / "cache"

    def test_a_folder_is_made_that_is_closed_to_others(self, place):
        before = os.umask(0o002)
        try:
            folder = cache_folder()
        finally:
            os.umask(before)
        assert folder.parent == place and folder.name.startswith("kernels-")
        assert folder.stat().st_mode & 0o777 == 0o700

    def test_it_is_used_again_whatever_the_umask_makes_of_its_files(self, place):
        folder = cache_folder()
        (folder / "solver").mkdir(mode=0o775)
        (folder / "solver" / "index.nbi").touch(mode=0o664)
        os.chmod(place, 0o777)  # a checkout under umask 002, or a folder of all in a container
        assert cache_folder() == folder

    @pytest.mark.parametrize("mode", [0o701, 0o710, 0o720, 0o702, 0o755, 0o775, 0o777])
    def test_one_that_is_open_to_others_is_refused(self, place, caplog, mode):
        os.chmod(cache_folder(), mode)
        assert cache_folder() is None
        (line,) = caplog.messages
        assert f"has mode {mode:04o}, must be 0700; it is not used" in line

    def test_one_of_somebody_else_is_refused(self, place, caplog, monkeypatch):
        folder, us = cache_folder(), os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: us + 1)
        assert cache_folder() is None
        (line,) = caplog.messages
        assert f"{folder}: belongs to user {us}, must be that of user {us + 1}" in line

    def test_one_with_a_file_of_somebody_else_is_refused(self, place, caplog, monkeypatch):
        file = cache_folder() / "index.nbi"
        file.touch()
        whose = os.lstat
        other = SimpleNamespace(st_uid=os.geteuid() + 1, st_mode=whose(file).st_mode)
        monkeypatch.setattr(os, "lstat", lambda path: other if path == file else whose(path))
        assert cache_folder() is None
        assert f"{file}: belongs to user" in caplog.text

    def test_a_link_is_not_followed(self, place, caplog):
        folder = cache_folder()
        folder.rename(place / "elsewhere")
        folder.symlink_to(place / "elsewhere")
        assert cache_folder() is None
        assert "is a link, must be a folder" in caplog.text

    def test_what_cannot_be_written_is_left_alone_without_a_word(self, place, caplog):
        """The kernels of an installation for all users belong to somebody else by right."""
        place.parent.mkdir()
        place.touch()
        assert cache_folder() is None
        assert not caplog.messages

    @pytest.mark.slow
    @pytest.mark.parametrize("mode", [0o700, 0o777])
    def test_a_foreign_index_is_run_from_a_folder_that_is_ours_alone_only(self, tmp_path, mode):
        """The danger is real: what lies in the closed folder, which nobody can have put there, is
        run. A refused cache costs time: the numbers are there all the same."""
        run = interpreter(tmp_path / "cache")
        assert run.stderr == ""
        (folder,) = (tmp_path / "cache").iterdir()
        (index, *_) = folder.rglob("*inverse_metric*.nbi")
        sign = tmp_path / "was-here"
        index.write_bytes(f"cbuiltins\nopen\n(V{sign}\nVw\ntR.".encode())  # open(sign, "w")
        os.chmod(folder, mode)
        again = interpreter(tmp_path / "cache")
        assert again.stdout == run.stdout
        assert sign.exists() == (mode == 0o700)
        assert len(again.stderr.splitlines()) == (mode == 0o777), again.stderr


def cache_folder() -> Path | None:
    """The folder as a new process finds it."""
    return pointwise._cache_folder.__wrapped__()


def interpreter(cache: Path) -> subprocess.CompletedProcess:
    """A process that computes with a kernel, and with that cache."""
    program = (
        "import numpy as np; from esfem.solver.geometry import _inverse_metric\n"
        "G = np.empty((3, 4)); _inverse_metric(np.arange(24.0).reshape(2, 3, 4), *G); print(G)"
    )
    return subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
