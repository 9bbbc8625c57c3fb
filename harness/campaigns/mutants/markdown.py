"""results/mutants: mutants.csv for programs, report.md for eyes, and by what they were made."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

import pandas as pd

from esfem.campaigns.mutants.campaign import SET, Catch, Key, Seen, Trial, coarse_studies
from esfem.campaigns.mutants.mutant import MUTANTS
from esfem.common.closure import closure, digest
from esfem.common.files import write_text
from esfem.common.provenance import numerics_digest, provenance_line, stepping_digest, version
from esfem.meshes import surface_mesh
from esfem.schemes import scheme_file
from esfem.studies.claims import claims
from esfem.studies.study import STUDIES, load_study

# What runs the studies, with and without an edit, and judges them: with all that it imports.
CAMPAIGN = "esfem.campaigns.mutants.campaign"
RESULTS = ("FAIL", "not green", "survived", "equivalent")
COLUMNS = (
    *("mutant", "group", "what", "result", "study", "variable", "outcome", "observed", "reason"),
    *("all", "change", "change_of", "seconds"),
)
NUMBERS = ("change", "seconds", "observed")
WIDEST = 200  # characters of a cell
HEADS = ("caught by FAIL", "caught, not green", "survived", "equivalent")
REPORT = """\
<!-- {origin} -->

# Seeded bugs

Each line of the program below was made wrong at run time, and default studies, on fewer cells \
(the last table), were run until one failed: {seconds:.0f} s in all. Program, judge, claims, \
studies and mutants: campaign {campaign}; another of these makes the report stale, and \
`tests/campaigns/test_mutants.py` says so. *Not green* is INCONCLUSIVE or a crash; *change* is the \
largest relative change of an error of the finest run of a study that claims an order.

{summary}

## Survivors

{survivors}

## Equivalent mutants

{equivalent}

## Caught

{caught}

## The studies

Default studies (`harness/studies`), in this order but for the groups that have a first one of \
their own; the columns are the cells that are run of each.

{studies}

## The program itself

{program}
"""


@lru_cache
def campaign_digest() -> str:
    """Hash of all that the result of a mutant depends on: numerics, judge, claims, studies, edits.

    Comments, docstrings and layout do not count.
    """
    studies = coarse_studies()
    meshes = {(s.initial.mesh_surface, vertices) for s in studies for vertices in s.sweep.vertices}
    claimed = sorted({study.study.claim or "" for study in studies} & claims().keys())
    content = [
        numerics_digest(),
        digest(closure(CAMPAIGN)),
        *(stepping_digest(scheme_file(name)) for name in sorted({s.scheme.name for s in studies})),
        *(claims()[name].model_dump_json() for name in claimed),
        *(study.model_dump_json() for study in studies),
        *(surface_mesh(*which).digest for which in sorted(meshes)),
        repr([(mutant.name, mutant.edits) for mutant in MUTANTS]),
    ]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]


def frame(trials: Sequence[Trial]) -> pd.DataFrame:
    """A line a mutant, in the order of the registry."""
    table = pd.DataFrame([_row(trial) for trial in trials], columns=list(COLUMNS)).assign(
        version=version(), numerics=numerics_digest(), campaign=campaign_digest()
    )
    return _in_order(table)


def _row(trial: Trial) -> dict[str, object]:
    mutant = trial.mutant
    best = trial.best or Catch("", "", "", float("nan"), mutant.equivalent)
    return {
        "mutant": mutant.name,
        "group": mutant.group,
        "what": mutant.what,
        "result": trial.result,
        **asdict(best),
        "all": ", ".join(f"{c.study} {c.variable} {c.outcome}" for c in trial.catches),
        "change": trial.change,
        "change_of": trial.where,
        "seconds": round(trial.seconds, 2),
    }


def _in_order(table: pd.DataFrame) -> pd.DataFrame:
    """The lines in the order of the registry."""
    place = {mutant.name: i for i, mutant in enumerate(MUTANTS)}
    return table.sort_values("mutant", key=lambda names: names.map(place), ignore_index=True)


def summary(table: pd.DataFrame) -> str:
    """The counts by group, in Markdown."""
    counts = pd.crosstab(table["group"], table["result"]).reindex(columns=RESULTS, fill_value=0)
    counts = counts.reindex(list(dict.fromkeys(table["group"])))
    counts.loc["all"] = counts.sum()
    counts = counts.set_axis(HEADS, axis=1).rename_axis("group").reset_index()
    return counts.to_markdown(index=False)


def markdown(table: pd.DataFrame, expected: Mapping[Key, Seen]) -> str:
    """The report."""
    by_result = {result: table[table["result"] == result] for result in RESULTS}
    caught = table[table["result"].isin(RESULTS[:2])]
    return REPORT.format(
        origin=provenance_line(),
        seconds=table["seconds"].sum(),
        campaign=campaign_digest(),
        summary=summary(table),
        survivors=_table(by_result["survived"], "mutant what change change_of") or "None.",
        equivalent=_table(by_result["equivalent"], "mutant what reason change change_of"),
        caught=_table(caught, "group mutant what study variable outcome reason"),
        studies=_cells().to_markdown(index=False, disable_numparse=True),
        program=_table(_own(expected), "study variable verdict observed reason"),
    )


def _cells() -> pd.DataFrame:
    """The cells that are run of each study."""
    rows = []
    for coarse in SET:
        study = coarse.study()
        whole = study == load_study(STUDIES / f"{coarse.name}.toml")
        cells = [", ".join(map(str, v)) for v in (study.sweep.vertices, study.sweep.tau)]
        final_time = str(study.sweep.final_time)
        rows.append((coarse.name, *cells, final_time, "as it is" if whole else ""))
    return pd.DataFrame(rows, columns=["study", "V", "tau", "T", "note"])


def _own(expected: Mapping[Key, Seen]) -> pd.DataFrame:
    """What the studies say of the program itself."""
    rows = [
        (*key, s.outcome, s.observed, s.reason.partition(";")[0]) for key, s in expected.items()
    ]
    return pd.DataFrame(rows, columns=["study", "variable", "verdict", "observed", "reason"])


def _table(table: pd.DataFrame, columns: str) -> str:
    """These columns in Markdown, cells cut to `WIDEST`; "" if there are no lines."""
    safe = table[columns.split()].map(
        lambda x: x[:WIDEST].replace("|", "\\|") if isinstance(x, str) else x
    )
    return safe.to_markdown(index=False, floatfmt=".3g") if len(table) else ""


def kept(table: pd.DataFrame, out: Path) -> pd.DataFrame:
    """The ``table`` with the lines of the stored one for mutants that were not tried again.

    They are kept if the same program, judge and studies made them and the registry still has them.
    """
    path = out / "mutants.csv"
    if not path.exists():
        return table
    old = pd.read_csv(path, keep_default_na=False, na_values=dict.fromkeys(NUMBERS, ""))
    if "campaign" not in old:  # by a version that did not tell
        return table
    names = {mutant.name for mutant in MUTANTS} - set(table["mutant"])
    old = old[old["mutant"].isin(names) & (old["campaign"] == campaign_digest())]
    return _in_order(pd.concat([old, table]) if len(old) else table)


def write(table: pd.DataFrame, expected: Mapping[Key, Seen], out: Path) -> None:
    """mutants.csv and report.md of a whole campaign."""
    write_lines(table, out)
    write_text(out / "report.md", markdown(table, expected))


def write_lines(table: pd.DataFrame, out: Path) -> None:
    """mutants.csv, of as many mutants as have been tried."""
    out.mkdir(parents=True, exist_ok=True)
    write_text(out / "mutants.csv", table.to_csv(index=False, float_format="%.4g"))
