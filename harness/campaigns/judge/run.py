"""The simulation: how often the judge, the one before it and the usual rules were wrong, as
report.md, rates.csv, calibration.csv and figures."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import Progress
from scipy.stats import beta

from esfem.campaigns.judge.kinds import kinds
from esfem.campaigns.judge.simulation import RULES, false_fail, false_pass, judged, simulate, there
from esfem.common.closure import closure, digest
from esfem.common.drawing import PALETTE, legend_below, save_figure, styled, subplots
from esfem.common.files import write_text
from esfem.common.provenance import provenance_line, version

SIMULATION = "esfem.campaigns.judge.simulation"
JUDGES = ("judge", *RULES)
# The judge by intervals with integer exponents, on the same tables: it ran from the commit by which
# the simulation grew, and its rates are data.
BEFORE = Path(__file__).with_name("before.csv")
SHOWN = ("judge", "before", *RULES)
SEED = 22360  # those below 1000, 2026, 3141, 14142, 16180, 27182, 57721 were looked at before
INSTANCES = 300
PARTS = {"right": 0, "inconclusive": 7, "false_fail": 4, "false_pass": 1}  # their colours
BINS = (0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.98, 0.99, 1.0)
# Goals: shares over all kinds, in the worst kind, and of what is right in groups of kinds.
FALSE, WORST, RIGHT = 0.002, 0.02, {"today": 0.55, "published": 0.85, "clean of 4": 0.99}
GROUPS = {
    "today": "kinds of the simulation before it grew",
    "grown": "kinds by which it grew",
    "published": "published-like tables",
    "clean of 4": "clean tables of 4 levels",
}
TIMED = 200  # tables
DEFINITIONS = """\
Truth is the order as the swept parameter goes to 0 with the term of the other one taken away. A
*false pass* accepts an order that is more than 0.2 above it, a *false fail* (SUSPECT included)
rejects one that is there; INCONCLUSIVE is neither, and not right either. The usual rules accept an
order from k - 0.2 on and know no INCONCLUSIVE. Kinds marked * ask for more than a table shows, and
are not in the totals; kinds marked † were held out: nobody saw a verdict on them before this
report. Totals are means over kinds. What is right was defined (`harness/campaigns/judge/kinds.py`)
before the first run, and the kinds were frozen before the judge was written. No table of this seed
was seen before. *before* is the judge by intervals with integer exponents, on the same tables."""


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
    """report.md, rates.csv, calibration.csv, rates.svg and calibration.svg of ``rows``."""
    found = pd.concat([rates(rows), before(rows)], ignore_index=True)
    trust = calibration(rows)
    stamp = found.assign(seed=seed, version=version(), program=program_digest())
    write_text(out / "rates.csv", stamp.to_csv(index=False, float_format="%.6f"))
    write_text(out / "calibration.csv", trust.to_csv(index=False, float_format="%.6f"))
    write_text(out / "report.md", markdown(rows, found, trust, seed, seconds))
    save_figure(figure(found), out / "rates.svg", f"seed {seed}", [".svg"])
    save_figure(calibration_figure(trust), out / "calibration.svg", f"seed {seed}", [".svg"])


def rates(rows: pd.DataFrame) -> pd.DataFrame:
    """One row a kind and judge: shares of false passes, false fails, no verdict and right ones."""
    found = []
    facts = ["kind", "group", "limit", "held_out"]
    for of_kind, some in rows.groupby(facts, sort=False):
        known = dict(zip(facts, of_kind, strict=True))
        found += [{**known, **shares(some, judge)} for judge in JUDGES]
    return pd.DataFrame(found)


def before(rows: pd.DataFrame) -> pd.DataFrame:
    """The stored rates of the judge before, of the kinds in ``rows``."""
    stored = pd.read_csv(BEFORE).drop(columns=["seed", "version", "seconds"])
    facts = rows[["kind", "group", "limit", "held_out"]].drop_duplicates()
    return facts.merge(stored, on="kind")


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


def totals(found: pd.DataFrame) -> pd.DataFrame:
    """The means over all kinds that are no limit, of each judge."""
    counted = found[~found["limit"]]
    table = counted.groupby("by", sort=False)[["tables", *PARTS]].mean()
    return table.assign(tables=counted.groupby("by", sort=False)["tables"].sum())


def by_group(found: pd.DataFrame, judge: str) -> pd.DataFrame:
    """The means over the kinds of each group, and of those held out or not."""
    own = found[(found["by"] == judge) & ~found["limit"]]
    parts = {words: own[own["group"] == group] for group, words in GROUPS.items()}
    joined = own[own["group"] == "grown"]
    parts["of those: held out †"] = joined[joined["held_out"]]
    parts["of those: not held out"] = joined[~joined["held_out"]]
    return pd.DataFrame({name: part[list(PARTS)].mean() for name, part in parts.items()}).T


def calibration(rows: pd.DataFrame) -> pd.DataFrame:
    """For each bin of the judge's probability: tables, its mean, and the share with that order."""
    counted = rows[~rows["limit"] & rows["truth"].notna() & rows["probability"].notna()]
    place = np.clip(np.searchsorted(BINS, counted["probability"], side="right"), 1, len(BINS) - 1)
    groups = counted.assign(there=there(counted)).groupby(place)
    return pd.DataFrame(
        [
            {
                "from": BINS[number - 1],
                "to": BINS[number],
                "tables": len(some),
                "probability": float(some["probability"].mean()),
                "there": float(some["there"].mean()),
            }
            for number, some in groups
        ]
    )


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


def time_a_table(seed: int, tables: int = TIMED) -> tuple[float, float]:
    """Mean and largest milliseconds of the processor that the judge takes for a table, over kinds;
    each table is judged twice and the lower one counts."""
    rng, found = np.random.default_rng(seed), []
    chosen = kinds()
    for number in range(tables):
        made = chosen[number % len(chosen)].draw(rng)
        took = []
        for _ in range(2):
            start = time.process_time()
            judged(made)
            took.append(time.process_time() - start)
        found.append(1e3 * min(took))
    return float(np.mean(found)), float(np.max(found))


def import_time(repetitions: int = 5) -> float:
    """Seconds that `import esfem.judging` takes beyond numpy and scipy.special; the least of so
    many."""
    code = (
        "import time, numpy, scipy.special; start = time.perf_counter(); import esfem.judging; "
        "print(time.perf_counter() - start)"
    )
    run = [sys.executable, "-c", code]
    return min(
        float(subprocess.run(run, capture_output=True, text=True, check=True).stdout)
        for _ in range(repetitions)
    )


def markdown(
    rows: pd.DataFrame, found: pd.DataFrame, trust: pd.DataFrame, seed: int, seconds: float
) -> str:
    """The report: totals, goals, calibration, kinds, passes by scatter and levels."""
    mean, largest = time_a_table(seed + 1)
    parts = [
        f"<!-- {provenance_line()}; seed {seed}; {seconds:.0f} s -->",
        "# The judge, judged",
        f"{len(rows)} synthetic tables of known order, {rows['kind'].nunique()} kinds, "
        f"seed {seed}, {seconds:.0f} s.\n\n{DEFINITIONS}",
        "![Shares of right, silent and false verdicts](rates.svg)",
        "## Means over kinds, in %",
        _percent(totals(found).drop(columns="tables").rename(columns=_words)),
        "## Means over groups of kinds, in %",
        _groups(found),
        "## Goals",
        _goals(found, trust),
        "## Probability and truth",
        "Of tables given a probability of at least the claimed order - 0.2, how many have it:",
        _calibration(trust),
        "![Probability and truth](calibration.svg)",
        f"A table takes {mean:.0f} ms of one processor, at most {largest:.0f} ms in {TIMED}; "
        f"`import esfem.judging` {import_time():.2f} s beyond numpy and scipy.special.",
        "## Kinds: shares in % of the judge, of the one before, and false verdicts of the usual "
        "rules",
        _kinds(found),
        "## A pure power of the claimed order: PASS or SUPER in % by scatter and levels",
        _percent(pass_table(rows, "pure, order as claimed")),
    ]
    return "\n\n".join(parts) + "\n"


def _words(name: str) -> str:
    return name.replace("_", " ")


def _groups(found: pd.DataFrame) -> str:
    """Beside each other, the judge's and the one before."""
    now, then = by_group(found, "judge"), by_group(found, "before")
    joined = {_words(name): now[name] for name in PARTS}
    joined |= {f"before: {_words(name)}": then[name] for name in PARTS}
    return _percent(pd.DataFrame(joined))


def _goals(found: pd.DataFrame, trust: pd.DataFrame) -> str:
    """Each goal with what was seen, its 95 % bound, and the worst kind."""
    judge = totals(found).loc["judge"]
    by_kind = found[(found["by"] == "judge") & ~found["limit"]].set_index("kind")
    lines = []
    for name in ("false_pass", "false_fail"):
        bound = upper_bound(judge[name], int(judge["tables"]))
        worst = by_kind[name].nlargest(3)
        said = ", ".join(f"{kind} {share:.1%}" for kind, share in worst.items() if share > 0)
        lines.append(
            f"- {_words(name)} <= {FALSE:.1%}: {_reached(judge[name] <= FALSE)}, {judge[name]:.2%} "
            f"(below {bound:.2%} with 95 % confidence)"
        )
        lines.append(
            f"- {_words(name)} <= {WORST:.0%} in every kind: "
            f"{_reached(worst.iloc[0] <= WORST)}; most in {said or 'none'}"
        )
    groups = by_group(found, "judge")["right"]
    for group, least in RIGHT.items():
        share = groups[GROUPS[group]]
        lines.append(
            f"- right >= {least:.0%}, {GROUPS[group]}: {_reached(share >= least)}, {share:.1%}"
        )
    some = trust[(trust["from"] == 0.9) & (trust["to"] == 0.95)]
    share = float(some["there"].iloc[0]) if len(some) else float("nan")
    lines.append(
        "- calibrated: of tables given a probability of 0.9 to 0.95, 88 to 97 % have the order: "
        f"{_reached(0.88 <= share <= 0.97)}, {share:.1%}"
    )
    return "\n".join(lines)


def _reached(is_so: bool) -> str:
    return "reached" if is_so else "NOT reached"


def _calibration(trust: pd.DataFrame) -> str:
    table = trust.assign(
        **{
            "probability from": trust["from"].map("{:g}".format),
            "to": trust["to"].map("{:g}".format),
        }
    )
    table["mean probability in %"] = (100 * trust["probability"]).map("{:.1f}".format)
    table["have the order, in %"] = (100 * trust["there"]).map("{:.1f}".format)
    names = ["probability from", "to", "tables", "mean probability in %", "have the order, in %"]
    return table[names].to_markdown(index=False, disable_numparse=True)


def _marked(found: pd.DataFrame) -> pd.Series:
    """The names of kinds with their marks."""
    limit, out = found["limit"].map({True: " *", False: ""}), found["held_out"]
    return found["kind"] + limit + out.map({True: " †", False: ""})


def _kinds(found: pd.DataFrame) -> str:
    found = found.assign(kind=_marked(found), false=found["false_pass"] + found["false_fail"])
    order = found["kind"].unique()
    judge = found[found["by"] == "judge"].set_index("kind")
    then = found[found["by"] == "before"].set_index("kind")
    table = judge[list(PARTS)].rename(columns=_words)
    table = table.join(then[list(PARTS)].rename(columns=lambda name: f"before: {_words(name)}"))
    wrong = found.pivot(index="kind", columns="by", values="false").loc[order, list(RULES)]
    return _percent(table.join(wrong.rename(columns=lambda name: f"false: {name}")))


def _percent(table: pd.DataFrame) -> str:
    """The table of shares as markdown, in per cent."""
    shown = (100.0 * table).map(lambda share: "-" if pd.isna(share) else f"{share:.1f}")
    shown.columns = [str(column) for column in shown.columns]
    return shown.to_markdown(disable_numparse=True)


@styled()
def figure(found: pd.DataFrame) -> Figure:
    """Stacked bars a kind, one panel a judge."""
    chart, axes = subplots(1, len(SHOWN), (13.0, 20.0), sharey=True)
    for axis, judge in zip(axes, SHOWN, strict=True):
        one = found[found["by"] == judge]
        labels = _marked(one)
        left = 0.0 * one["right"]
        for part, color in PARTS.items():
            axis.barh(labels, one[part], left=left, color=PALETTE[color], label=_words(part))
            left = left + one[part]
        axis.set_title(judge)
        axis.set_xlim(0.0, 1.0)
        axis.margins(y=0.005)
        axis.grid(False)
    axes[0].invert_yaxis()
    axes[0].tick_params(axis="y", labelsize=7)
    legend_below(chart, axes[0])
    return chart


@styled()
def calibration_figure(trust: pd.DataFrame) -> Figure:
    """The share of tables with the order over the probability that the judge gave them."""
    chart, axes = subplots(1, 1, (5.0, 4.5))
    axis = np.ravel(axes)[0]
    axis.plot([0.0, 1.0], [0.0, 1.0], color=PALETTE[7], label="as said")
    share, n = trust["there"], trust["tables"]
    half = 1.96 * np.sqrt(np.maximum(share * (1 - share), 1e-12) / n)
    axis.errorbar(trust["probability"], share, yerr=half, fmt="o", color=PALETTE[0], label="seen")
    axis.set_xlabel("probability of at least the claimed order - 0.2")
    axis.set_ylabel("share of tables that have it")
    legend_below(chart, axis)
    return chart
