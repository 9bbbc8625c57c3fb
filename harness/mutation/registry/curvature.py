"""The shape operator and what the forms are evaluated with."""

from harness.mutation.registry.making import one

CURVATURE = "solver.forms:curvature"

CURVATURE_MUTANTS = (
    one(
        "curvature",
        "s-not-symmetrised",
        "S = grad nu",
        CURVATURE,
        "0.5 * (grad_nu + np.swapaxes(grad_nu, -1, -2))",
        "grad_nu",
        "the exact grad nu is symmetric, so both differ by O(h^k) of the interpolation: same order",
    ),
    one(
        "curvature",
        "s-transposed",
        "S = (grad nu)^T",
        CURVATURE,
        "0.5 * (grad_nu + np.swapaxes(grad_nu, -1, -2))",
        "np.swapaxes(grad_nu, -1, -2)",
        "as s-not-symmetrised: the exact grad nu is symmetric",
    ),
    one(
        "curvature",
        "s-antisymmetric",
        "S = (grad nu - (grad nu)^T)/2",
        CURVATURE,
        "grad_nu + np.swap",
        "grad_nu - np.swap",
    ),
    one("curvature", "s-without-half", "S = grad nu + (grad nu)^T", CURVATURE, "0.5 *", ""),
    one(
        "curvature",
        "s2-is-h-squared",
        "|S|^2 = H^2",
        CURVATURE,
        'np.einsum("epab,epab->ep", S, S)',
        "H**2",
    ),
    one(
        "curvature",
        "s2-umbilic",
        "|S|^2 = H^2/2, right on spheres alone",
        CURVATURE,
        'np.einsum("epab,epab->ep", S, S)',
        "0.5 * H**2",
    ),
    one(
        "curvature",
        "h-is-mean-of-curvatures",
        "Q of H/2",
        CURVATURE,
        "law(H, S2",
        "law(0.5 * H, S2",
    ),
    one(
        "curvature",
        "grad-h-not-projected",
        "grad H with a normal part H n",
        CURVATURE,
        "grad_u[..., 0], S",
        "grad_u[..., 0] + H[..., None] * geo.normal, S",
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
