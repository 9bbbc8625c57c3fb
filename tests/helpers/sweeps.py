"""A small sweep, and what it has stored."""

import numpy as np
import pandas as pd

from esfem.measuring.lift import VARIABLES

SMALLER = {"vertices": [30, 60]}
ERRORS = [f"err_{name}" for name in VARIABLES]


def times_of_records(out) -> dict[str, int]:
    return {p.name: p.stat().st_mtime_ns for p in (out / "small" / "records").glob("*.json")}


def assert_same_numbers(one: pd.DataFrame, other: pd.DataFrame) -> None:
    # Runs of one program on one machine; threads may reorder sums, so not to the last bit.
    np.testing.assert_allclose(one[ERRORS], other[ERRORS], rtol=1e-9, atol=1e-13)
