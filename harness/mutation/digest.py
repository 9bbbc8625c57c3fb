"""Which judge and which studies a campaign was run with."""

import hashlib
from functools import lru_cache
from pathlib import Path

import harness
from harness.claims import claims
from harness.mutation.coarse import coarse_studies
from harness.mutation.registry import MUTANTS
from harness.provenance import code, numerics_digest

# From records to verdicts, beside the numerics; and the campaign.
JUDGES = (
    *(f"harness/{name}.py" for name in ("claims", "eoc", "floors", "limits", "quantities")),
    *(f"harness/{name}.py" for name in ("rows", "selection", "sizes", "verdicts")),
    *("reference_solutions/discrete/*.py", "harness/mutation/campaign.py"),
)
NOT_JUDGING = ("command", "kinds", "report", "simulation", "usual")  # of harness/judging


@lru_cache
def campaign_digest() -> str:
    """Hash of all that the result of a mutant depends on: numerics, judge, claims, studies, edits.

    Comments, docstrings and layout do not count.
    """
    root = Path(harness.__file__).resolve().parent.parent
    files = [path for pattern in JUDGES for path in sorted(root.glob(pattern))]
    files += [
        path for path in sorted(root.glob("harness/judging/*.py")) if path.stem not in NOT_JUDGING
    ]
    content = [
        numerics_digest(),
        *map(code, files),
        *(claim.model_dump_json() for claim in claims().values()),
        *(study.model_dump_json() for study in coarse_studies()),
        repr([(mutant.name, mutant.edits) for mutant in MUTANTS]),
    ]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]
