"""Formulas and kernels: compiled and interpreted alike, one thread or several, cached safely."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import solver
from solver import forms
from solver.geometry import geometry
from solver.laws import willmore
from solver.pointwise import (
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

ROOT = Path(solver.__file__).parent.parent


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
            monkeypatch.setattr("solver.pointwise.thread_count", lambda n=threads: n)
            results.append(b.copy())
            turned(a, results[-1])
        np.testing.assert_allclose(results[0], np.cross(a, b, axis=0), rtol=0, atol=1e-14)
        np.testing.assert_array_equal(results[1], results[0])
        np.testing.assert_array_equal(results[2], results[0])


class TestCache:
    @pytest.mark.slow
    @pytest.mark.parametrize("folder", ["new", "file"])
    def test_of_a_place_that_can_be_written_or_not(self, tmp_path, folder):
        """What is no folder cannot be written: then each process compiles for itself."""
        place = tmp_path / folder
        if folder == "file":
            place.write_text("")
        program = "from solver.pointwise import _cache_folder as f; import solver.forms; print(f())"
        run = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "NUMBA_CACHE_DIR": str(place), "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert run.stdout.startswith("None" if folder == "file" else str(place / "kernels-"))
