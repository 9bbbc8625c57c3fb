"""The judge, judged: verdicts on synthetic tables against their truth.

Beside the judge stand the usual rules, true if order k is accepted.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from esfem.campaigns.judge.instance import Instance, Kind
from esfem.campaigns.judge.kinds import kinds
from esfem.judging import Judgement, judge_table
from esfem.judging.decision import SUSPECT
from esfem.judging.table_columns import Array

DRAWN = ("claim", "truth", "scatter", "levels", "clean")  # of a table, with its verdicts
TOLERANCE = 0.2  # below the order, as everywhere


def all_pairs(h: Array, e: Array, k: float) -> bool:
    """Every pairwise rate is at least k - 0.2."""
    return bool((_rates(h, e) >= k - TOLERANCE).all())


def last_pair(h: Array, e: Array, k: float) -> bool:
    """The rate of the finest pair is."""
    return bool(_rates(h, e)[-1] >= k - TOLERANCE)


def plain_slope(h: Array, e: Array, k: float) -> bool:
    """The least-squares slope over all levels is."""
    return bool(np.polyfit(np.log(h), np.log(e), 1)[0] >= k - TOLERANCE)


def gci(h: Array, e: Array, k: float) -> bool:
    """Roache's: the order of the three finest levels is, and they are in the asymptotic range.

    The order p solves (e1 - e2) / (e2 - e3) = (h1^p - h2^p) / (h2^p - h3^p); the range is
    |(e2 - C) / (e3 - C) / (h2 / h3)^k - 1| < 0.1 for the extrapolated C.
    """
    differences = e[-3] - e[-2], e[-2] - e[-1]
    if differences[0] * differences[1] <= 0:
        return False
    p = np.linspace(0.05, 9.0, 900)
    left = (h[-3] ** p - h[-2] ** p) / (h[-2] ** p - h[-1] ** p)
    order = float(p[np.argmin(np.abs(np.log(left * differences[1] / differences[0])))])
    if order < k - TOLERANCE:
        return False
    C = e[-1] - differences[1] / ((h[-2] / h[-1]) ** order - 1.0)
    return bool(abs(C) < 0.1 * e[-1])


def _rates(h: Array, e: Array) -> Array:
    return np.diff(np.log(e)) / np.diff(np.log(h))


RULES: dict[str, Callable[[Array, Array, float], bool]] = {
    "all pairs": all_pairs,
    "last pair": last_pair,
    "plain slope": plain_slope,
    "GCI": gci,
}


def simulate(
    instances: int,
    seed: int,
    advance: Callable[[], None] = lambda: None,
    jobs: int = 1,
    which: Callable[[Kind], bool] = lambda kind: True,
) -> pd.DataFrame:
    """One row a table: its kind, claim, truth, the judge's outcome and what each rule said.

    ``advance`` is called once a kind; neither ``jobs`` processes nor the kinds chosen by ``which``
    change the tables of a kind.
    """
    chosen = [number for number, kind in enumerate(kinds()) if which(kind)]
    work = (delayed(_judged_kind)(number, instances, seed) for number in chosen)
    rows = []
    for some in Parallel(n_jobs=jobs, return_as="generator")(work):
        rows += some
        advance()
    return pd.DataFrame(rows)


def _judged_kind(number: int, instances: int, seed: int) -> list[dict[str, Any]]:
    kind, rng = kinds()[number], np.random.default_rng([seed, number])
    return [_judged(kind, kind.draw(rng)) for _ in range(instances)]


def _judged(kind: Kind, made: Instance) -> dict[str, Any]:
    judgement = judged(made)
    s, e = _line(made)
    return {
        "kind": kind.name,
        "limit": kind.limit,
        "group": kind.group,
        "held_out": kind.held_out,
        **{name: getattr(made, name) for name in DRAWN},
        "judge": judgement.outcome,
        "code": judgement.code,
        "probability": judgement.probability,
        **{name: _said(rule, s, e, made.claim) for name, rule in RULES.items()},
    }


def judged(made: Instance) -> Judgement:
    """The judge's word on a table."""
    return judge_table(
        made.table,
        made.order,
        direction=made.direction,
        floors=made.floors,
        other_order=made.other_order,
        levels_min=made.levels_min,
    )


def _line(made: Instance) -> tuple[Array, Array]:
    """What a usual rule sees: the finite errors on the finest line."""
    table = made.table[np.isfinite(made.table["error"])]
    other = "tau" if made.direction == "h" else "h"
    if other in table and table[other].nunique() < len(table):  # else they are refined together
        table = table[table[other] == table[other].min()]
    table = table.sort_values(made.direction, ascending=False)
    return table[made.direction].to_numpy(), table["error"].to_numpy()


def _said(rule: Callable[[Array, Array, float], bool], s: Array, e: Array, k: float) -> str:
    """A rule knows yes and no; without three levels it says nothing."""
    if len(s) < 3:
        return "inconclusive"
    return "pass" if rule(s, e, k) else "fail"


def there(rows: pd.DataFrame) -> pd.Series:
    """Whether the tables have the claimed order, up to the tolerance."""
    return rows["truth"] >= rows["claim"] - TOLERANCE


def false_pass(rows: pd.DataFrame, said: str) -> pd.Series:
    """Whether an order was accepted that is not there."""
    return rows[said].isin(("pass", "super")) & ~there(rows)


def false_fail(rows: pd.DataFrame, said: str) -> pd.Series:
    """Whether an order was rejected that is there."""
    right = (rows[said] == "suspect") & (rows["truth"] > rows["claim"] + SUSPECT)
    return rows[said].isin(("fail", "suspect")) & there(rows) & ~right
