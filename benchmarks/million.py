"""One step with a million nodes: seconds by part and memory, as JSON on the standard output."""

import json
import resource
import sys
from dataclasses import replace
from time import perf_counter

from benchmarks.cases import BDF2, start
from esfem.common.provenance import machine
from esfem.solver import Levels, Scheme, evolve
from esfem.solver.threads import thread_count

VERTICES = 250_002  # N = 4 V - 6 = 1,000,002


def main() -> None:
    """BDF2 after its start-up by exact values is bought with one more State, not with substeps."""
    vertices = int(sys.argv[1]) if len(sys.argv) > 1 else VERTICES
    mesh, initial = start(vertices, 0.0)
    before = gibibytes()
    levels = Levels.equal(0.05, 3)
    states = evolve(
        mesh, initial, Scheme(bdf=BDF2, theta=True), levels, lambda t: replace(initial, t=t)
    )
    next(states), next(states)  # the start values
    first, second = timed(states), timed(states)
    result = {
        "machine": machine(),
        "threads": thread_count(),
        "nodes": mesh.node_count,
        "step": first,
        "next_step": second,
        "gibibytes_of_mesh_and_fields": before,
        "gibibytes_at_most": gibibytes(),
    }
    print(json.dumps(result, indent=1))


def timed(states) -> dict[str, float]:
    """The seconds of one step, whole with guards and by part."""
    started = perf_counter()
    state = next(states)
    whole = perf_counter() - started
    return {"whole": whole, **state.work.seconds, "iterations": state.work.iterations}


def gibibytes() -> float:
    """The most memory that this process has used so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


if __name__ == "__main__":
    main()
