"""Which runs of a study are judged, and which are not, by name."""

from itertools import product

import pandas as pd

from harness.claims import claims
from harness.quantities import is_self_convergence
from harness.study import Study
from harness.verdict import Direction

LEVELS = 4  # that a bound is judged on
INDEPENDENT = 0.02  # relative spread over all time steps, below which an error is all in space
SHARE = 0.1  # of the error, from which on the part in space is all of it
APART = 2.0  # a mesh judged against the finest one is coarser by this factor
NEARLY = 0.98  # meshes of V and 4 V vertices differ in h by 2, but for a few per cent


def direction(study: Study) -> Direction:
    """In which parameter the study is judged: that of its claim, else that with more levels, which
    is h where there is no error in time."""
    if study.study.claim is not None:
        return claims()[study.study.claim].direction
    solution = study.solution.initial()
    if is_self_convergence(solution) or solution.stationary:
        return "h"
    return "tau" if len(study.sweep.tau) > len(study.sweep.vertices) else "h"


def judged_runs(study: Study, records: pd.DataFrame) -> pd.DataFrame:
    """The runs on which a bound is judged, coarse before fine; no rows if there are too few.

    In h the finest `LEVELS` meshes of the sweep, at the finest tau at which all of them ran to the
    end: a hole in the ladder is not bridged. In tau all completed time steps on the finest mesh.
    """
    finished = records[records["status"] == "ok"]
    if direction(study) == "tau":
        runs = finished[finished["vertices"] == max(study.sweep.vertices)]
        return runs.sort_values("tau", ascending=False)
    finest = sorted(set(study.sweep.vertices) - set(too_fine(study, records)))[-LEVELS:]
    for tau in sorted(study.sweep.tau):
        runs = finished[(finished["tau"] == tau) & finished["vertices"].isin(finest)]
        if len(runs) == LEVELS:
            return runs.sort_values("h", ascending=False)
    return records.iloc[:0]


def too_fine(study: Study, records: pd.DataFrame) -> list[int]:
    """The meshes too near to the finest level to be judged against it, that level included."""
    if not is_self_convergence(study.solution.initial()):
        return []
    finest = records.loc[records["vertices"] == max(study.sweep.vertices), "h"].min()
    return sorted(records.loc[~(records["h"] >= APART * NEARLY * finest), "vertices"].unique())


def missing_runs(study: Study, records: pd.DataFrame) -> list[tuple[int, float]]:
    """The cells (V, tau) of the sweep that have no record."""
    there = set(zip(records["vertices"], records["tau"], strict=True))
    return [cell for cell in product(study.sweep.vertices, study.sweep.tau) if cell not in there]


def exclusions(study: Study, records: pd.DataFrame) -> list[str]:
    """What was not judged, by name: missing and stopped runs, and levels near a reference."""
    lines = [
        f"missing: V = {v}, tau = {t:g} has no record" for v, t in missing_runs(study, records)
    ]
    if is_self_convergence(study.solution.initial()):
        meshes = ", ".join(map(str, too_fine(study, records)))
        lines.append(f"not judged: V = {meshes}, the finest level or within a factor 2 of its h")
    for t in sorted(records["tau"].unique(), reverse=True):
        stopped = records[(records["tau"] == t) & ~records["status"].isin(("ok", "reference"))]
        runs = [
            f"V = {r.vertices} ({r.status} at t = {r.stopped_at:g})" for r in stopped.itertuples()
        ]
        if runs:
            lines.append(f"stopped early, tau = {t:g}: {', '.join(runs)}")
    return lines


def judged_table(study: Study, records: pd.DataFrame, variable: str) -> pd.DataFrame:
    """The columns that `judge_table` reads, and vertices, of all runs that may be judged."""
    runs = records[~records["vertices"].isin(too_fine(study, records))]
    columns = ["vertices", "h", "tau", "status", "seconds", "final_time"]
    return runs[columns].assign(error=runs[f"err_{variable}"])


def unfit(study: Study, records: pd.DataFrame) -> str:
    """Why nothing can be judged; "" if something can."""
    missing = missing_runs(study, records)
    failed = int((records["status"] == "failed").sum())
    if missing or failed:
        return f"{len(missing)} runs missing, {failed} with solver failure"
    return ""


def in_space_alone(study: Study, records: pd.DataFrame, variable: str) -> bool:
    """Whether the error is the same at all time steps, and measured to be that of the mesh."""
    finished = records[records["status"] == "ok"]
    column = f"err_{variable}"
    by_mesh = [runs for _, runs in finished.groupby("h")]  # fine before coarse
    if len(by_mesh) < 2 or len(by_mesh[0]) < 2:
        return False
    error, coarser = by_mesh[0].set_index("tau")[column], by_mesh[1].set_index("tau")[column]
    growth = (by_mesh[1]["h"].iloc[0] / by_mesh[0]["h"].iloc[0]) ** study.scheme.degree - 1.0
    share = (coarser - error).abs() / growth / error
    constant = error.max() < (1 + INDEPENDENT) * error.min()
    return bool(constant and (share.reindex(error.index) > SHARE).all())
