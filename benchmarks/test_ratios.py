"""What does not depend on the machine much: the ratio to the textbook way, and growth with N."""

import gc
from collections.abc import Callable
from time import perf_counter

import numpy as np
import pytest

from benchmarks.cases import flow
from benchmarks.textbook import textbook_step
from solver.scheme import projected
from solver.threads import one_blas_thread

REPETITIONS = 5


def seconds(call: Callable[[], object], repetitions: int = REPETITIONS) -> float:
    """The least time of some calls."""
    times = []
    for _ in range(repetitions):
        gc.collect()
        started = perf_counter()
        call()
        times.append(perf_counter() - started)
    return min(times)


@pytest.mark.parametrize("kind", ["rest", "moving"])
@pytest.mark.parametrize("vertices", [960, 3840])
def test_step_against_textbook(benchmark, kind, vertices):
    f = flow(kind, vertices)
    with one_blas_thread():
        u, w = textbook_step(f)
        state = f.step()
        nu, z = projected(u[:, 1:], w[:, 1:])
        for ours, theirs in ((state.nu, nu), (state.H, u[:, 0]), (state.z, z)):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-7 * max(1, np.abs(z).max()))
        textbook = seconds(lambda: textbook_step(f), 3)
        step = seconds(f.step)
        benchmark.pedantic(f.step, rounds=3)
    benchmark.extra_info.update(textbook=textbook, step=step, ratio=textbook / step)


@pytest.mark.parametrize("kind", ["rest", "moving"])
def test_growth_with_N(benchmark, kind):
    """The exponent e of seconds = c N^e by least squares over N = 3834 .. 61434."""
    flows = [flow(kind, vertices) for vertices in (960, 3840, 15360)]
    with one_blas_thread():
        times = [seconds(f.step) for f in flows]
        benchmark.pedantic(flows[0].step, rounds=3)
    N = [f.mesh.node_count for f in flows]
    exponent = float(np.polyfit(np.log(N), np.log(times), 1)[0])
    benchmark.extra_info.update(nodes=N, seconds=times, exponent=exponent)
