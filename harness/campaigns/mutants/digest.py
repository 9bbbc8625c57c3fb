"""Which judge and which studies a campaign was run with."""

import hashlib
from collections.abc import Iterable
from functools import lru_cache

from esfem.campaigns.mutants.coarse import coarse_studies
from esfem.campaigns.mutants.registry import MUTANTS
from esfem.common.closure import closure, digest
from esfem.common.provenance import numerics_digest, stepping_digest
from esfem.meshes import surface_mesh
from esfem.schemes import scheme_file
from esfem.studies.claims import claims
from esfem.studies.study import Study

# What runs the studies, with and without an edit, and judges them: with all that it imports.
CAMPAIGN = "esfem.campaigns.mutants.campaign"


@lru_cache
def campaign_digest() -> str:
    """Hash of all that the result of a mutant depends on: numerics, judge, claims, studies, edits.

    Comments, docstrings and layout do not count.
    """
    studies = coarse_studies()
    claimed = sorted({study.study.claim or "" for study in studies} & claims().keys())
    content = [
        numerics_digest(),
        digest(closure(CAMPAIGN)),
        *(stepping_digest(scheme_file(name)) for name in sorted({s.scheme.name for s in studies})),
        *(claims()[name].model_dump_json() for name in claimed),
        *(study.model_dump_json() for study in studies),
        *mesh_digests(studies),
        repr([(mutant.name, mutant.edits) for mutant in MUTANTS]),
    ]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]


def mesh_digests(studies: Iterable[Study]) -> list[str]:
    """The digests of all triangulations that the studies run on."""
    wanted = {
        (study.initial.mesh_surface, vertices)
        for study in studies
        for vertices in study.sweep.vertices
    }
    return [surface_mesh(*which).digest for which in sorted(wanted)]
