"""Stored results for the tests of regression: planted errors, fitted as the judge does."""

import numpy as np
import pandas as pd

from harness.judging import judge_table
from harness.regression import Stored

LADDER = (60, 120, 240, 480, 960)
TAU = 0.01


def stored(error, variable="x", claim="theorem", mesh="a", **facts) -> Stored:
    """Results of one variable with errors ``error(h)`` over the ladder, order 2 expected."""
    h = np.array(LADDER) ** -0.5
    e = np.asarray(error(h), dtype=float)
    j = judge_table(pd.DataFrame({"h": h, "error": e}), 2.0)
    records = pd.DataFrame({"vertices": LADDER, "tau": TAU, "h": h, "status": "ok"})
    records["mesh_digest"] = mesh
    records[f"err_{variable}"] = e
    window = [v for v, s in zip(LADDER, h, strict=True) if s in j.window]
    verdict = {
        **{"variable": variable, "verdict": j.outcome, "claim": claim, "direction": "h"},
        **{"expected": 2.0, "tolerance": 0.2, "limit": None},
        **{"observed": number(j.order), "lower": number(j.lower), "upper": number(j.upper)},
        **{"constant": number(j.constant), "scatter": number(j.scatter)},
        **{"vertices": window, "tau": [TAU] if window else []},
        **facts,
    }
    parameters = {"solution": {}, "law": {}, "scheme": {}, "sweep": {"final_time": 1.0}}
    content = {"study": "s", "version": "0.1.0", "numerics": "abc", "parameters": parameters}
    return Stored({**content, "verdicts": [verdict]}, records)


def number(value: float) -> float | None:
    """As it stands in verdicts.json."""
    return float(value) if np.isfinite(value) else None


def scattered(size: float, seed: int):
    """0.7 h^2 with log-normal scatter."""
    factors = np.exp(size * np.random.default_rng(seed).normal(size=len(LADDER)))
    return lambda h: 0.7 * h**2 * factors
