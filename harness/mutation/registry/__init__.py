"""The registry of seeded bugs: one line of the program made wrong, in the groups of the paper.

What each `Edit` replaces must occur once in its function; when the program changes, the tests name
the mutants that have to follow.
"""

from harness.mutation.patching import Mutant
from harness.mutation.registry.assembly import ASSEMBLY_MUTANTS
from harness.mutation.registry.curvature import CURVATURE_MUTANTS
from harness.mutation.registry.errors import ERROR_MUTANTS
from harness.mutation.registry.forms import FORM_MUTANTS
from harness.mutation.registry.geometry import GEOMETRY_MUTANTS
from harness.mutation.registry.laws import LAW_MUTANTS
from harness.mutation.registry.linear_algebra import LINEAR_MUTANTS
from harness.mutation.registry.peers import PEER_MUTANTS
from harness.mutation.registry.projection import PROJECTION_MUTANTS
from harness.mutation.registry.start import START_MUTANTS
from harness.mutation.registry.theta import THETA_MUTANTS
from harness.mutation.registry.time import TIME_MUTANTS

MUTANTS: tuple[Mutant, ...] = (
    *FORM_MUTANTS,
    *CURVATURE_MUTANTS,
    *LAW_MUTANTS,
    *GEOMETRY_MUTANTS,
    *ASSEMBLY_MUTANTS,
    *TIME_MUTANTS,
    *THETA_MUTANTS,
    *PROJECTION_MUTANTS,
    *LINEAR_MUTANTS,
    *START_MUTANTS,
    *ERROR_MUTANTS,
    *PEER_MUTANTS,
)
