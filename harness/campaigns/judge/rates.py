"""Rates of the simulation: how often the judge and the usual rules were wrong."""

import pandas as pd
from scipy.stats import beta

from esfem.campaigns.judge.simulation import false_fail, false_pass
from esfem.campaigns.judge.usual import RULES

JUDGES = ("judge", *RULES)


def rates(rows: pd.DataFrame) -> pd.DataFrame:
    """One row a kind and judge: shares of false passes, false fails, no verdict and right ones."""
    found = []
    for (kind, limit), of_kind in rows.groupby(["kind", "limit"], sort=False):
        found += [{"kind": kind, "limit": limit, **shares(of_kind, judge)} for judge in JUDGES]
    return pd.DataFrame(found)


def shares(rows: pd.DataFrame, judge: str) -> dict[str, float | int | str]:
    """The shares of one judge on these tables."""
    wrong_pass, wrong_fail = false_pass(rows, judge), false_fail(rows, judge)
    silent = rows[judge] == "inconclusive"
    return {
        "by": judge,
        "tables": len(rows),
        "false_pass": float(wrong_pass.mean()),
        "false_fail": float(wrong_fail.mean()),
        "inconclusive": float(silent.mean()),
        "right": float((~(wrong_pass | wrong_fail | silent)).mean()),
    }


def totals(rows: pd.DataFrame) -> pd.DataFrame:
    """The shares of each judge over all kinds that are no limit."""
    counted = rows[~rows["limit"]]
    return pd.DataFrame([shares(counted, judge) for judge in JUDGES])


def clean_passes(rows: pd.DataFrame) -> dict[str, float]:
    """How many of the clean tables pass, by each judge."""
    clean = rows[rows["clean"]]
    return {judge: float((clean[judge] == "pass").mean()) for judge in JUDGES}


def pass_table(rows: pd.DataFrame, kind: str) -> pd.DataFrame:
    """Shares of PASS and SUPER by the judge for each scatter (down) and number of levels."""
    of_kind = rows[rows["kind"] == kind]
    green = of_kind["judge"].isin(("pass", "super"))
    table = of_kind.assign(green=green).pivot_table(
        index="scatter", columns="levels", values="green", aggfunc="mean"
    )
    return table


def upper_bound(share: float, tables: int) -> float:
    """The 95 % upper bound (Clopper and Pearson) of a share seen in so many tables."""
    wrong = round(share * tables)
    return 1.0 if wrong == tables else float(beta.ppf(0.95, wrong + 1, tables - wrong))
