"""What does not depend on the machine much: the ratio to the textbook way, and growth with N."""

import gc
from collections.abc import Callable
from time import perf_counter, process_time

import numpy as np
import pytest

from benchmarks.cases import Flow, flow
from benchmarks.textbook import textbook_step
from esfem.solver.scheme import projected
from esfem.solver.threads import one_blas_thread, thread_count

STEPS = 8
# With one thread what counts is the time of the processor: others on the machine do not disturb it.
clock = process_time if thread_count() == 1 else perf_counter


def seconds(call: Callable[[], object], calls: int = 1, repetitions: int = 3) -> float:
    """The mean time of so many calls in a row; the least of some repetitions."""
    times = []
    for _ in range(repetitions):
        gc.collect()
        started = clock()
        for _ in range(calls):
            call()
        times.append((clock() - started) / calls)
    return min(times)


def seconds_a_step(f: Flow) -> float:
    """Of steps in a row, as in a flow: with a factorisation where one is needed."""
    states = f.steps()
    next(states)  # with it the pattern is analysed
    return seconds(lambda: next(states), calls=STEPS)


@pytest.mark.parametrize("kind", ["rest", "moving"])
@pytest.mark.parametrize("vertices", [960, 3840])
def test_step_against_textbook(benchmark, kind, vertices):
    f = flow(kind, vertices)
    with one_blas_thread():
        u, w = textbook_step(f)
        state = next(f.steps())
        nu, z = projected(u[:, 1:], w[:, 1:])
        for ours, theirs in ((state.nu, nu), (state.H, u[:, 0]), (state.z, z)):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-7 * max(1, np.abs(z).max()))
        textbook, step = seconds(lambda: textbook_step(f)), seconds_a_step(f)
        states = f.steps()
        benchmark.pedantic(lambda: next(states), rounds=STEPS)
    benchmark.extra_info.update(textbook=textbook, step=step, ratio=textbook / step)


@pytest.mark.parametrize("kind", ["rest", "moving"])
def test_growth_with_N(benchmark, kind):
    """The exponent e of seconds = c N^e by least squares over N = 3834 .. 61434."""
    flows = [flow(kind, vertices) for vertices in (960, 3840, 15360)]
    with one_blas_thread():
        times = [seconds_a_step(f) for f in flows]
        states = flows[0].steps()
        benchmark.pedantic(lambda: next(states), rounds=STEPS)
    N = [f.mesh.node_count for f in flows]
    exponent = float(np.polyfit(np.log(N), np.log(times), 1)[0])
    benchmark.extra_info.update(nodes=N, seconds=times, exponent=exponent)
