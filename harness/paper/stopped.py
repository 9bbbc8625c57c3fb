"""Runs that stop early, in words."""

import pandas as pd


def stopped_runs(records: pd.DataFrame) -> str:
    """For example "V = 30: tau = 0.1 (t = 1), 0.05 (t = 0.85); V = 60: tau = 0.05 (t = 1)"."""
    stopped = records[records["status"] != "ok"].sort_values("tau", ascending=False)
    lines = []
    for vertices, runs in stopped.groupby("vertices"):
        ends = ", ".join(f"{run.tau:g} (t = {run.stopped_at:.3g})" for run in runs.itertuples())
        lines.append(f"V = {vertices}: tau = {ends}")
    return "; ".join(lines)
