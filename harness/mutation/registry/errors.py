"""The norms of errors."""

from harness.mutation.registry.making import one

LIFT, RECORD = "harness.errors:lifted_surface", "harness.recorder:Recorder.__call__"
RUN_ERRORS = "harness.rows:run_errors"
ERROR_MUTANTS = (
    one(
        "errors",
        "lift-without-closest-point",
        "Gamma is Gamma_h* in the norms",
        LIFT,
        "Y = solution.closest_point(points, t)",
        "Y = points",
        "Gamma_h* is within O(h^{k+1}) of Gamma, its tangents within O(h^k): what is compared "
        "changes by O(h^k) in H^1, the order that is claimed",
    ),
    one(
        "errors",
        "lift-derivative-identity",
        "J_Y = J",
        LIFT,
        "J_Y = solution.closest_point_derivative(points, t) @ J",
        "J_Y = J",
        "D closest_point = I - nu nu^T + O(d), d = O(h^{k+1}), and J is tangential to O(h^k): the "
        "norms, quadratic in the error, change by a factor 1 + O(h^k)",
    ),
    one(
        "errors",
        "position-not-projected",
        "the gradient of the position is I",
        "harness.errors:_stack_exact",
        "np.eye(3) - f.nu[..., :, None] * f.nu[..., None, :]",
        "np.eye(3) + 0.0 * f.nu[..., :, None] * f.nu[..., None, :]",
        "J_Y is tangential, J_Y^T (I - nu nu^T) = J_Y^T: the same numbers",
    ),
    one(
        "errors",
        "h1-without-gradient",
        "the H^1 norm is that of L^2",
        "harness.errors:norms_by_variable",
        "l2[c].sum() + seminorm[c].sum()",
        "l2[c].sum()",
    ),
    one(
        "errors",
        "gradient-without-metric",
        "|de|^2 by reference coordinates",
        "harness.errors:weighted_metric",
        "np.stack(inverse_metric(geo))",
        "np.stack([np.ones_like(geo.dA), np.zeros_like(geo.dA), np.ones_like(geo.dA)])",
    ),
    one(
        "errors",
        "exact-gradient-of-z-missing",
        "grad z = 0 in the norm",
        "harness.errors:_stack_exact",
        "f.grad_V[..., None], f.grad_z",
        "f.grad_V[..., None], 0.0 * f.grad_z",
    ),
    one(
        "errors",
        "error-quadrature-degree-1",
        "norms by one quadrature point",
        "harness.errors:error_quadrature",
        "2 * degree + 4",
        "1",
    ),
    one(
        "errors",
        "error-off-by-one",
        "the surface of t - tau in the norms",
        RECORD,
        "self._lifted_errors(state)",
        "self._lifted_errors(State(max(state.t - self.case.tau, 0.0), "
        "state.x, state.nu, state.H, state.V, state.z))",
    ),
    one(
        "errors",
        "error-at-the-end-only",
        "max over t replaced by t = T",
        RUN_ERRORS,
        '_{name}"] = max(record.h1[name])',
        '_{name}"] = record.h1[name][-1]',
    ),
    one(
        "errors",
        "error-at-the-start-only",
        "max over t replaced by t = 0",
        RUN_ERRORS,
        '_{name}"] = max(record.h1[name])',
        '_{name}"] = record.h1[name][0]',
    ),
)
