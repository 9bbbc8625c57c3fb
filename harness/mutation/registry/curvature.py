"""The shape operator and what the forms are evaluated with."""

from harness.mutation.registry.making import one

CURVATURE, SHAPE = "solver.forms:curvature", "solver.forms:shape_operator"
FIELDS = "H, nu = u_at[..., 0], u_at[..., 1:]"

CURVATURE_MUTANTS = (
    one(
        "curvature",
        "s-not-symmetrised",
        "S = grad nu",
        SHAPE,
        "matrix_times(0.5, matrix_plus(grad_nu, transpose(grad_nu)))",
        "grad_nu",
        "the exact grad nu is symmetric, so both differ by O(h^k) of the interpolation: same order",
    ),
    one(
        "curvature",
        "s-transposed",
        "S = (grad nu)^T",
        SHAPE,
        "matrix_times(0.5, matrix_plus(grad_nu, transpose(grad_nu)))",
        "transpose(grad_nu)",
        "as s-not-symmetrised: the exact grad nu is symmetric",
    ),
    one(
        "curvature",
        "s-antisymmetric",
        "S = (grad nu - (grad nu)^T)/2",
        SHAPE,
        "grad_nu, transpose(grad_nu)",
        "grad_nu, matrix_times(-1.0, transpose(grad_nu))",
    ),
    one("curvature", "s-without-half", "S = grad nu + (grad nu)^T", SHAPE, "0.5", "1.0"),
    one(
        "curvature",
        "s2-is-h-squared",
        "|S|^2 = H^2",
        CURVATURE,
        FIELDS,
        f"{FIELDS}\n    S2 = H**2",
    ),
    one(
        "curvature",
        "s2-umbilic",
        "|S|^2 = H^2/2, right on spheres alone",
        CURVATURE,
        FIELDS,
        f"{FIELDS}\n    S2 = 0.5 * H**2",
    ),
    one(
        "curvature",
        "h-is-mean-of-curvatures",
        "Q of H/2",
        CURVATURE,
        "(H, S2, geo.points",
        "(0.5 * H, S2, geo.points",
    ),
    one(
        "curvature",
        "grad-h-not-projected",
        "grad H with a normal part H n",
        CURVATURE,
        "nu, grad_H, S",
        "nu, grad_H + H[..., None] * geo.normal, S",
    ),
    one(
        "curvature",
        "nu-of-the-mesh",
        "the forms use the normal of the mesh for nu_h",
        CURVATURE,
        "u_at[..., 1:]",
        "geo.normal",
    ),
)
