"""Stored results for the tests of regression: planted errors, fitted as the judge does."""

from dataclasses import fields, replace

import numpy as np
import pandas as pd

from esfem.campaigns.baseline.change import Stored
from esfem.judging import judge_table
from esfem.results.error_verdicts import ErrorVerdict
from esfem.results.result_files import StoredResult
from esfem.results.verdicts import Verdict
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study

LADDER = (60, 120, 240, 480, 960)
TAU = 0.01
SPHERE = load_study(study_path("sphere"))


def stored(error, variable="x", claim="theorem", mesh="a", **facts) -> Stored:
    """Results of one variable with errors ``error(h)`` over the ladder, order 2 expected."""
    h = np.array(LADDER) ** -0.5
    e = np.asarray(error(h), dtype=float)
    j = judge_table(pd.DataFrame({"h": h, "error": e}), 2.0)
    records = pd.DataFrame({"vertices": LADDER, "tau": TAU, "h": h, "status": "ok"})
    records["mesh_digest"] = mesh
    records[f"err_{variable}"] = e
    window = [v for v, s in zip(LADDER, h, strict=True) if s in j.window]
    part = ErrorVerdict(
        "error",
        norm="",
        outcome=j.outcome,
        reason="",
        observed=j.order,
        lower=j.lower,
        upper=j.upper,
        constant=j.constant,
        scatter=j.scatter,
        vertices=tuple(window),
        tau=(TAU,) if window else (),
    )
    verdict = Verdict("s", claim, "", variable, "h", (part,), expected=2.0, tolerance=0.2)
    return Stored(content(recast(verdict, **facts)), records)


def recast(verdict: Verdict, /, **facts) -> Verdict:
    """The verdict with other facts; what is told of an error is so of each part, ``verdict`` is
    their outcome."""
    own = {f.name for f in fields(Verdict)}
    of_parts = {"outcome" if k == "verdict" else k: v for k, v in facts.items() if k not in own}
    parts = tuple(replace(part, **of_parts) for part in verdict.parts)
    return replace(verdict, **{"parts": parts, **{k: v for k, v in facts.items() if k in own}})


def of_study(result: Stored, **parts: dict[str, object]) -> Stored:
    """The same results of a study that has other options in these parts, whether it could be run
    or not."""
    study = result.content.parameters
    other = {name: getattr(study, name).model_copy(update=new) for name, new in parts.items()}
    study = study.model_copy(update=other)
    return replace(result, content=replace(result.content, parameters=study))


def content(*verdicts: Verdict) -> StoredResult:
    """verdicts.json of a study "s"."""
    return StoredResult(
        study="s",
        title="",
        verdict="no claim",
        excluded=[],
        verdicts=list(verdicts),
        parameters=SPHERE,
        version="0.1.0",
        numerics="abc",
        command="",
        machine="",
        dependencies={},
        seconds=0.0,
        stamp="",
    )


def scattered(size: float, seed: int):
    """0.7 h^2 with log-normal scatter."""
    factors = np.exp(size * np.random.default_rng(seed).normal(size=len(LADDER)))
    return lambda h: 0.7 * h**2 * factors
