"""Results for the tests of the paper's checks: where each holds, and where it fails."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
from stored import recast

from esfem.flows.flow_file import load_flow
from esfem.flows.flow_results import Check, CheckedFlow
from esfem.results.error_verdicts import PREFIXES, ErrorVerdict
from esfem.results.study_result import StudyResult
from esfem.results.verdicts import Verdict
from esfem.studies.catalogue import flow_path, study_path
from esfem.studies.study import Study, load_study

VARIABLES = ("x", "nu", "H", "V", "z", "v")
LADDER = (30, 60, 120, 240)
LONG = tuple(30 * 2**i for i in range(7))  # on which the judge can tell an order
BOUND, NO_CLAIM = {"limit": 1e-7}, "no claim"
FLOORS = pd.DataFrame(columns=["floor", "variable", "vertices", "tau", "value"])  # none measured


def study(name="paper-sphere", **sweep) -> Study:
    found = load_study(study_path(name))
    return found.model_copy(update={"sweep": found.sweep.model_copy(update=sweep)})


def runs(
    error=lambda h, tau: h**2,
    taus=(0.2, 0.1),
    stopped=(),
    ratio=2**-0.5,
    ladder=LADDER,
    **columns,
):
    """A row a run; the error of x, nu, H and v is ``error``."""
    rows = []
    for i, vertices in enumerate(ladder):
        for tau in taus:
            h, ok = ratio**i, (vertices, tau) not in stopped
            e = error(h, tau) if ok else None
            errors = {f"err_{name}": e for name in VARIABLES}
            rows.append({"vertices": vertices, "tau": tau, "h": h, **errors, **columns})
            rows[-1] |= {"status": "ok" if ok else "diverged", "stopped_at": None if ok else 0.5}
    return pd.DataFrame(rows)


def verdict(outcome="pass", observed=2.0, half=0.05, **facts) -> Verdict:
    ends = {"lower": observed - half, "upper": observed + half}
    part = ErrorVerdict("error", "", outcome, "why", observed=observed, **ends)
    blank = Verdict("s", "", "", "x", "h", (part,), expected=2.0, tolerance=0.2)
    return recast(blank, **facts)


def data(*verdicts, of=None, records=None) -> StudyResult:
    records = runs() if records is None else records
    return StudyResult(of or study(), Path(), records, FLOORS, list(verdicts))


def judgeable(error=lambda h, tau: h**2, taus=(0.2, 0.1, 0.05)) -> StudyResult:
    """Of so many meshes that the judge can tell an order."""
    table = runs(error, taus, ladder=LONG, seconds=1.0, final_time=1.0)
    return data(of=study(vertices=list(LONG), tau=list(taus)), records=table)


def energy(value):
    return data(records=runs(willmore_T=value))


def flow(nodes=4978, status="ok", verdicts=("pass", "pass")) -> CheckedFlow:
    names = ("energy at rest", "surface at rest")
    return CheckedFlow(
        flow=load_flow(flow_path("ellipsoid")),
        nodes=nodes,
        status=status,
        reason="",
        seconds=1.0,
        checks=[Check(n, v, 0.0, 0.01, n) for n, v in zip(names, verdicts, strict=True)],
        environment={},
    )


def normals(without=0.99, kept=1.0, count=1914) -> list[dict]:
    rows = []
    for name, low in (("without", without), ("with", kept)):
        row = {"projections": name, "nodes": count}
        for quantity in ("|nu|", "distance", "W"):
            row |= {f"least {quantity}": low, f"greatest {quantity}": 1.0, f"exact {quantity}": 1.0}
        rows.append(row)
    return rows


X = {"variables": ["x"]}
PLAIN = {**X, "error": "error"}
HALVED, STEADY = (lambda h, tau: tau), (lambda h, tau: h**2 + 1e-3 * tau)
SETTING = {"nodes": 4978, "first": 0.2, "halvings": 8, "final_time": 4.0}
REST = {"names": ["energy at rest", "surface at rest"]}
SQUARED = {"squared": 2.0, "bound": 1e-12}
TORUS, HELFRICH = study("paper-torus"), study("helfrich-bdf2")
# By check: what it is given where it holds, what where it fails, and its parameters.
EXAMPLES = {
    "orders": ([data(verdict())], [data(verdict("fail", 1.0))], X),
    "orders_by_step": ([judgeable()], [judgeable(lambda h, tau: h if tau == 0.1 else h**2)], PLAIN),
    "bounded": (
        [data(verdict(**BOUND), records=runs(lambda h, tau: 1e-9))],
        [data(verdict("fail", **BOUND))],
        X,
    ),
    "exceeds": (
        [data(verdict()), data(verdict("super", 3.0))],
        [data(verdict()), data(verdict(observed=2.2))],
        PLAIN,
    ),
    "at_least": (
        [data(verdict(NO_CLAIM, 2.0))],
        [data(verdict(NO_CLAIM, 0.5))],
        {**X, "below_degree": 1, "tolerance": 0.2},
    ),
    "space_dominates": (
        [data(records=runs(STEADY))],
        [data(records=runs(HALVED))],
        {**PLAIN, "share": 0.5},
    ),
    "never_exceeds_space": (
        [data(records=runs(STEADY))],
        [data(records=runs(lambda h, tau: h**2 * (1.0 + 15.0 * (h == 1.0) * (tau - 0.1))))],
        PLAIN,
    ),
    "all_finish": ([data(), data()], [data(), data(records=runs(stopped=[(30, 0.2)]))], {}),
    "more_runs_finish": (
        [data(), data(records=runs(stopped=[(30, 0.2)]))],
        [data(records=runs(stopped=[(30, 0.2)])), data()],
        {},
    ),
    "printed_energy": ([data()], [data(of=TORUS)], {"printed": "25.1327"}),
    "final_energy": ([energy(25.1328)], [energy(25.2)], {"bound": 1e-4}),
    "rests_exactly": ([data(of=TORUS)], [data(of=HELFRICH)], {"bound": 1e-12}),
    "moves_discretely": ([data()], [data(records=runs(lambda h, tau: 1e-13))], {"bound": 1e-9}),
    "mesh_widths": ([data(), data()], [data(), data(records=runs(ratio=0.5))], {"tolerance": 0.05}),
    "time_steps": ([data(), data()], [data(), data(of=study(tau=[0.2, 0.05]))], {"first": 0.2}),
    "radii": ([data(of=TORUS)], [data()], SQUARED),
    "graded": ([data(of=TORUS)], [data()], {"part": 0.25}),
    "flow_setting": ([flow()], [flow(nodes=4977)], SETTING),
    "flow_checks": ([flow()], [flow(verdicts=("pass", "fail"))], REST),
    "nodes": ([normals()], [normals(count=954)], {"count": 1914}),
    "normals_deviate": ([normals()], [normals(without=1.0)], {"bound": 1e-3}),
    "normals_kept": ([normals()], [normals(kept=0.999)], {"bound": 1e-12}),
    "stays_nearer": ([normals()], [normals(kept=0.9)], {"quantity": "distance"}),
}
WITHOUT_VERDICT = {"observed", "stops", "growth"}  # tell what was seen, where nothing is claimed


def in_both(holding, failing, errors) -> list[StudyResult]:
    """Results whose first error is as in those where a check holds, and its second as in those
    where it fails."""
    return [_merged(*pair, errors) for pair in zip(holding, failing, strict=True)]


def _merged(one: StudyResult, other: StudyResult, errors) -> StudyResult:
    columns = {
        f"{PREFIXES[error]}{name}": result.records[f"err_{name}"]
        for error, result in zip(errors, (one, other), strict=True)
        for name in VARIABLES
    }
    parts = [
        tuple(replace(p, name=e) for e, p in zip(errors, (*v.parts, *w.parts), strict=True))
        for v, w in zip(one.verdicts, other.verdicts, strict=True)
    ]
    verdicts = [replace(v, parts=p) for v, p in zip(one.verdicts, parts, strict=True)]
    return replace(one, records=one.records.assign(**columns), verdicts=verdicts)
