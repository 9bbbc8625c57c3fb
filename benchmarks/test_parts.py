"""The parts of a step, and a small run."""

from time import process_time

import numpy as np
import pytest

from benchmarks.cases import Flow, flow, start
from esfem.solver import Levels, Scheme, evolve, scheme
from esfem.solver.system import System, assembled
from esfem.solver.threads import one_blas_thread, thread_count

if thread_count() == 1:  # as in test_ratios: of the processor, whatever else the machine does
    scheme.perf_counter = process_time

VERTICES = (240, 960, 3840, 15360)  # N = 954, 3834, 15354, 61434

STEPS = 12

each_size = pytest.mark.parametrize("vertices", VERTICES)


@pytest.fixture(autouse=True)
def _as_in_a_flow():
    with one_blas_thread():
        yield


def system(f: Flow) -> System:
    latest = f.history[0]
    return assembled(f.mesh, latest.x, latest.u, f.scheme.law, f.t, None)


@each_size
def test_assembly(benchmark, vertices):
    benchmark.group = f"N={4 * vertices - 6}"
    benchmark(system, flow("moving", vertices))


@each_size
def test_F(benchmark, vertices):
    benchmark.group = f"N={4 * vertices - 6}"
    f = flow("moving", vertices)
    benchmark(system(f).F, f.history[0].w)


@each_size
def test_factorisation(benchmark, vertices):
    benchmark.group = f"N={4 * vertices - 6}"
    f = flow("moving", vertices)
    on = system(f)
    benchmark(f.block.factor, 1.5 / f.tau, on.M, on.A)


@each_size
def test_solve(benchmark, vertices):
    benchmark.group = f"N={4 * vertices - 6}"
    f = flow("moving", vertices)
    on = system(f)
    f.block.factor(1.5 / f.tau, on.M, on.A)
    benchmark(f.block.solve, on.f, on.g)


@each_size
@pytest.mark.parametrize("kind", ["rest", "moving"])
def test_step(benchmark, kind, vertices):
    """Steps in a row, as in a flow: most use the factors again; the mean by part is kept too."""
    benchmark.group = f"N={4 * vertices - 6}"
    works, states = [], flow(kind, vertices).steps()
    next(states)  # with it the pattern is analysed
    benchmark.pedantic(lambda: works.append(next(states).work), rounds=STEPS)
    parts = {part: np.mean([work.seconds[part] for work in works]) for part in works[0].seconds}
    iterations = np.mean([work.iterations for work in works])
    benchmark.extra_info.update(seconds=parts, iterations=iterations)


def test_run(benchmark):
    """Twenty steps with all guards on N = 954 nodes, start-up included."""
    (mesh, initial), levels = start(240, 0.1), Levels.equal(1e-3, 20)
    benchmark.pedantic(
        lambda: list(evolve(mesh, initial, Scheme(), levels)), rounds=5, warmup_rounds=1
    )
