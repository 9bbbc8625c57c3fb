"""The simulation: how often the judge and the usual rules were wrong, as report.md, rates.csv and
rates.svg."""

import time
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import Progress
from scipy.stats import beta

from esfem.campaigns.judge.kinds import kinds
from esfem.campaigns.judge.simulation import RULES, false_fail, false_pass, simulate
from esfem.common.closure import closure, digest
from esfem.common.drawing import PALETTE, legend_below, save_figure, styled, subplots
from esfem.common.files import write_text
from esfem.common.provenance import provenance_line, version

SIMULATION = "esfem.campaigns.judge.simulation"
JUDGES = ("judge", *RULES)
SEED = 22360  # those below 1000, 2026, 3141, 14142, 16180, 27182, 57721 were looked at before
INSTANCES = 300
PARTS = {"right": 0, "inconclusive": 7, "false_fail": 4, "false_pass": 1}  # their colours
LIMIT = 0.01
CLEAN = 0.9
DEFINITIONS = """\
Truth is the order as the swept parameter goes to 0 with the term of the other one taken away. A
*false pass* accepts an order that is more than 0.2 above it, a *false fail* (SUSPECT included)
rejects one that is there; INCONCLUSIVE is neither, and not right either. The usual rules accept an
order from k - 0.2 on and know no INCONCLUSIVE. Where two terms make an error, the one that rules as
h -> 0 is the larger one on the finest level; kinds marked * leave that ground, where no table can
tell, and are not in the totals. What is right was defined (`harness/campaigns/judge/kinds.py`)
before the first run; "clean", "slowly" and "odd gaps" joined later. No table of this seed was seen
before."""


def run_simulation(
    out: Path, jobs: int, console: Console, instances: int = INSTANCES, seed: int = SEED
) -> None:
    """Run the simulation with a progress bar and write the report."""
    start = time.perf_counter()
    with Progress(console=console) as progress:
        task = progress.add_task("judging", total=len(kinds()))
        rows = simulate(instances, seed, lambda: progress.advance(task), jobs=jobs)
    write(rows, seed, time.perf_counter() - start, out)
    console.print(f"{len(rows)} tables judged; written to {out}")


def write(rows: pd.DataFrame, seed: int, seconds: float, out: Path) -> None:
    """report.md, rates.csv and rates.svg of the simulated ``rows``."""
    found = rates(rows)
    stamp = found.assign(seed=seed, version=version(), program=program_digest())
    write_text(out / "rates.csv", stamp.to_csv(index=False, float_format="%.6f"))
    write_text(out / "report.md", markdown(rows, found, seed, seconds))
    save_figure(figure(found), out / "rates.svg", f"seed {seed}", [".svg"])


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
    return of_kind.assign(green=green).pivot_table(
        index="scatter", columns="levels", values="green", aggfunc="mean"
    )


def upper_bound(share: float, tables: int) -> float:
    """The 95 % upper bound (Clopper and Pearson) of a share seen in so many tables."""
    wrong = round(share * tables)
    return 1.0 if wrong == tables else float(beta.ppf(0.95, wrong + 1, tables - wrong))


def program_digest() -> str:
    """Hash of the judge, and of the tables that it was given."""
    return digest(closure(SIMULATION))


def markdown(rows: pd.DataFrame, found: pd.DataFrame, seed: int, seconds: float) -> str:
    """The report: totals, goals, kinds, passes by scatter and levels."""
    parts = [
        f"<!-- {provenance_line()}; seed {seed}; {seconds:.0f} s -->",
        "# The judge, judged",
        f"{len(rows)} synthetic tables of known order, {rows['kind'].nunique()} kinds, "
        f"seed {seed}, {seconds:.0f} s.\n\n{DEFINITIONS}",
        "![Shares of right, silent and false verdicts](rates.svg)",
        "## All kinds, shares in %",
        _totals(rows),
        "## Goals",
        _goals(rows, found),
        "## Kinds: the judge's shares in %, and all false verdicts of the usual rules",
        _kinds(found),
        "## A pure power of the claimed order: PASS or SUPER in % by scatter and levels",
        _percent(pass_table(rows, "pure, order as claimed")),
    ]
    return "\n\n".join(parts) + "\n"


def _totals(rows: pd.DataFrame) -> str:
    table = totals(rows).set_index("by").drop(columns="tables")
    table["clean tables passed"] = pd.Series(clean_passes(rows))
    return _percent(table.rename(columns=lambda name: name.replace("_", " ")))


def _goals(rows: pd.DataFrame, found: pd.DataFrame) -> str:
    """Each goal with what was seen, its 95 % bound, and the worst kind."""
    judge = totals(rows).set_index("by").loc["judge"]
    by_kind = found[(found["by"] == "judge") & ~found["limit"]].set_index("kind")
    lines = []
    for name in ("false_pass", "false_fail"):
        bound = upper_bound(judge[name], int(judge["tables"]))
        worst = by_kind[name].idxmax()
        lines.append(
            f"- {name.replace('_', ' ')} <= {LIMIT:.0%}: "
            f"{'reached' if judge[name] <= LIMIT else 'NOT reached'}, {judge[name]:.2%} "
            f"(below {bound:.2%} with 95 % confidence); "
            f"most in a kind {by_kind[name][worst]:.1%}"
            + (f" ({worst})" if by_kind[name][worst] > 0 else "")
        )
    passed = clean_passes(rows)["judge"]
    lines.append(
        f"- clean tables of five levels or more that PASS >= {CLEAN:.0%}: "
        f"{'reached' if passed >= CLEAN else 'NOT reached'}, {passed:.1%}"
    )
    return "\n".join(lines)


def _kinds(found: pd.DataFrame) -> str:
    names = found["kind"] + found["limit"].map({True: " *", False: ""})
    found = found.assign(kind=names, false=found["false_pass"] + found["false_fail"])
    order = found["kind"].unique()
    judge = found[found["by"] == "judge"].set_index("kind")
    table = judge[list(PARTS)].rename(columns=lambda name: name.replace("_", " "))
    wrong = found.pivot(index="kind", columns="by", values="false").loc[order, list(JUDGES[1:])]
    return _percent(table.join(wrong.rename(columns=lambda name: f"false: {name}")))


def _percent(table: pd.DataFrame) -> str:
    """The table of shares as markdown, in per cent."""
    shown = (100.0 * table).map(lambda share: "-" if pd.isna(share) else f"{share:.1f}")
    shown.columns = [str(column) for column in shown.columns]
    return shown.to_markdown(disable_numparse=True)


@styled()
def figure(found: pd.DataFrame) -> Figure:
    """Stacked bars a kind, one panel a judge."""
    chart, axes = subplots(1, len(JUDGES), (11.0, 9.0), sharey=True)
    for axis, judge in zip(axes, JUDGES, strict=True):
        one = found[found["by"] == judge]
        labels = one["kind"] + one["limit"].map({True: " *", False: ""})
        left = 0.0 * one["right"]
        for part, color in PARTS.items():
            name = part.replace("_", " ")
            axis.barh(labels, one[part], left=left, color=PALETTE[color], label=name)
            left = left + one[part]
        axis.set_title(judge)
        axis.set_xlim(0.0, 1.0)
        axis.margins(y=0.01)
        axis.grid(False)
    axes[0].invert_yaxis()
    axes[0].tick_params(axis="y", labelsize=8)
    legend_below(chart, axes[0])
    return chart
