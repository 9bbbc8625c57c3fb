"""The judge stands alone: numpy and scipy.special, light to import, quick."""

import subprocess
import sys
import time

import numpy as np
import pytest
from judged import LADDER, TAUS, grid, line, scattered

from esfem.judging import judge_table

IMPORT = """
import sys, numpy, scipy.special
before, start = set(sys.modules), __import__("time").process_time()
import esfem.judging
print(__import__("time").process_time() - start)
print(*sorted({name.split(".")[0] for name in set(sys.modules) - before}))
"""


def imported() -> tuple[float, set[str]]:
    """Seconds of the processor, and the top names of what is loaded besides."""
    run = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True)
    seconds, names = run.stdout.strip().splitlines()
    return float(seconds), set(names.split())


def test_it_needs_numpy_and_special_functions_only():
    own = imported()[1] - set(sys.stdlib_module_names)
    assert {name for name in own if not name.startswith("__editable__")} <= {
        "esfem",
        "numpy",
        "scipy",
    }


def test_judging_needs_no_more_than_importing_does():
    code = (
        "import sys; from esfem.judging import judge_table; h = [2.0**-i for i in range(5)]; "
        "judge_table({'h': h, 'error': [s * s for s in h]}, 2.0); "
        "sys.exit(bool({'pandas', 'scipy.optimize', 'matplotlib'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.slow
def test_it_is_light_to_import():
    assert min(imported()[0] for _ in range(5)) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    "table",
    [
        *(
            line(LADDER[:n] ** 2 * scattered(1, size, n), LADDER[:n])
            for n in (4, 6)
            for size in (0.0, 0.1)
        ),
        line(0.5 ** (2 * np.arange(8)) * scattered(1, 0.3, 8), 0.5 ** np.arange(8)),
        grid(lambda h, tau: h**2 + 0.3 * tau, taus=(*TAUS, 0.0125)),
    ],
    ids=["4", "4 with scatter", "6", "6 with scatter", "8 with much", "grid"],
)
def test_a_table_takes_no_time(table):
    """30 ms of one processor that has nothing else to do; twice that where it has."""
    took = []
    for _ in range(5):
        start = time.process_time()
        judge_table(table, 2.0)
        took.append(time.process_time() - start)
    assert min(took) < 0.06
