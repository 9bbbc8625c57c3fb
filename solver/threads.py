"""How many threads: OMP_NUM_THREADS if it is set, as in the processes of a sweep, or all cores."""

import os


def thread_count() -> int:
    """Threads that this process may use."""
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
