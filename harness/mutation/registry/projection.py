"""The projection of section 7.1."""

from harness.mutation.patching import Edit, Mutant
from harness.mutation.registry.making import STEP, one

PROJECTED, UNIT = "solver.scheme:projected", "solver.scheme:unit"
AFTER, EXTRAPOLATION = "    nu, z = projected(nu, z, scheme.project)\n", "unit(u_ext[:, 1:])"
PROJECTION_MUTANTS = (
    Mutant(
        "projection-skipped",
        "projection",
        "no projection though asked for",
        (Edit(STEP, AFTER, "    pass\n"), Edit(STEP, EXTRAPOLATION, "u_ext[:, 1:]")),
    ),
    one(
        "projection",
        "projection-skipped-after-the-step",
        "nu / |nu| of the extrapolation alone",
        STEP,
        AFTER,
        "    pass\n",
    ),
    one(
        "projection",
        "extrapolated-normal-not-projected",
        "nu_ext not normalised",
        STEP,
        EXTRAPOLATION,
        "u_ext[:, 1:]",
        "past normals are unit, so |nu_ext| = 1 + O(tau^q); section 7.1 itself projects no more",
    ),
    one(
        "projection",
        "z-not-projected",
        "z keeps its normal part",
        PROJECTED,
        "else z - np.einsum",
        "else z - 0.0 * np.einsum",
        "z enters the next step by F2 z~ alone; z . nu is of the size of the error of z",
    ),
    one(
        "projection",
        "z-projected-twice",
        "z - 2 (z . nu) nu",
        PROJECTED,
        "else z - np.einsum",
        "else z - 2.0 * np.einsum",
        "as z-not-projected: z . nu is of the size of the error of z, with either sign",
    ),
    one(
        "projection",
        "z-normal-part-only",
        "z = (z . nu) nu",
        PROJECTED,
        "else z - np.einsum",
        "else np.einsum",
    ),
    Mutant(
        "projection-always",
        "projection",
        "projection though not asked for",
        (
            Edit(STEP, "if scheme.project:  # differs", "if True:  # differs"),
            Edit(STEP, AFTER, "    nu, z = projected(nu, z, True)\n"),
        ),
    ),
    one(
        "projection",
        "length-inverted",
        "nu / |nu|^2",
        UNIT,
        "np.linalg.norm(nu, axis=1, keepdims=True)",
        "np.linalg.norm(nu, axis=1, keepdims=True) ** 2",
    ),
    one(
        "projection",
        "length-of-all-components",
        "nu / max |nu|",
        UNIT,
        "np.linalg.norm(nu, axis=1, keepdims=True)",
        "np.linalg.norm(nu, axis=1).max()",
    ),
)
