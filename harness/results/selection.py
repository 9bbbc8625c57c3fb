"""Which runs of a study are judged, and which are not, by name."""

from dataclasses import dataclass
from itertools import product

import pandas as pd

from esfem.studies.study import Study

LEVELS = 4  # that a bound is judged on
INDEPENDENT = 0.1  # relative spread over all time steps, below which an error is all in space
SHARE = 0.1  # of the error, from which on the part in space is all of it
APART = 2.0  # a mesh judged against the finest one is coarser by this factor
NEARLY = 0.98  # meshes of V and 4 V vertices differ in h by 2, but for a few per cent


@dataclass(frozen=True)
class Selection:
    """What is judged of a study.

    Attributes
    ----------
    runs : those that may be judged against an order.
    bounded : those on which a bound is judged, coarse before fine; no rows if there are too few.
    unfit : why nothing can be judged; "" if something can.
    moves : False if no State of any run to be judged differs from the initial one.
    space_alone : the columns of errors that are the same at all time steps, and measured to be
        those of the mesh.
    """

    runs: pd.DataFrame
    bounded: pd.DataFrame
    unfit: str
    moves: bool
    space_alone: tuple[str, ...]


def selection(study: Study, records: pd.DataFrame) -> Selection:
    """What is judged of a study with these records."""
    runs = records[~records["vertices"].isin(too_fine(study, records))]
    errors = [f"{kind}_{name}" for name in study.variables for kind in ("err", "nodal")]
    return Selection(
        runs=runs,
        bounded=bounded_runs(study, records),
        unfit=unfit(study, records),
        moves=moves(runs),
        space_alone=tuple(e for e in errors if e in runs and in_space_alone(study, runs, e)),
    )


def moves(runs: pd.DataFrame) -> bool:
    """Whether a State of a run that ended differs from its initial one, be it by rounding; True in
    a table of a version that does not tell."""
    ended = runs[runs["status"] == "ok"]
    if "moved" not in ended or ended.empty or ended["moved"].isna().any():
        return True
    return bool(ended["moved"].astype(bool).any())


def bounded_runs(study: Study, records: pd.DataFrame) -> pd.DataFrame:
    """The runs on which a bound is judged, coarse before fine; no rows if there are too few.

    In h the finest `LEVELS` meshes of the sweep, at the finest tau at which all of them ran to the
    end: a hole in the ladder is not bridged. In tau all completed time steps on the finest mesh.
    """
    finished = records[records["status"] == "ok"]
    if study.direction == "tau":
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
    if study.initial.reference != "finest":
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
    if study.initial.reference == "finest":
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


def unfit(study: Study, records: pd.DataFrame) -> str:
    """Why nothing can be judged; "" if something can. A run that stopped is masked, no more."""
    missing = missing_runs(study, records)
    return f"{len(missing)} runs missing" if missing else ""


def in_space_alone(study: Study, records: pd.DataFrame, column: str) -> bool:
    """Whether the error of that column is the same at all time steps, and measured to be that of
    the mesh; not of a surface at rest, and not where the order in h is judged."""
    if study.direction != "tau" or study.initial.stationary:
        return False
    finished = records[records["status"] == "ok"]
    by_mesh = [runs for _, runs in finished.groupby("h")]  # fine before coarse
    if len(by_mesh) < 2 or len(by_mesh[0]) < 2:
        return False
    error, coarser = by_mesh[0].set_index("tau")[column], by_mesh[1].set_index("tau")[column]
    growth = (by_mesh[1]["h"].iloc[0] / by_mesh[0]["h"].iloc[0]) ** study.scheme.degree - 1.0
    share = (coarser - error).abs() / growth / error
    constant = error.max() < (1 + INDEPENDENT) * error.min()
    return bool(constant and (share.reindex(error.index) > SHARE).all())
