"""The registry of seeded bugs: one line of the program made wrong, in the groups of the paper.

What each `Edit` replaces must occur once in its function; when the program changes, the tests name
the mutants that have to follow.
"""

from collections.abc import Sequence

from harness.mutation.patching import Edit, Mutant

FORMS, GEOMETRY, ASSEMBLY = "solver.forms", "solver.geometry", "solver.assembly"
LOADS = f"{FORMS}:loads"
STEP, EVOLVE, START = "solver.scheme:step", "solver.flow:evolve", "solver.flow:extrapolated_start"
CURVATURE, SHAPE, F2_ = f"{FORMS}:curvature", f"{FORMS}:shape_operator", f"{FORMS}:f2"
FIELDS = "H, nu = u_at[..., 0], u_at[..., 1:]"
FLUX = f"{FORMS}:f2_flux"
BODY_T1, BODY_T2 = "dot(grad_H, grad_H) - Q * H", ", apply(S, S_grad_H)"
FLUX_T3, FLUX_T4 = "times(2.0 *", ", times(Q, b)"


def one(
    group: str, name: str, what: str, where: str, old: str, new: str, equivalent: str = ""
) -> Mutant:
    """A mutant of a single edit."""
    return Mutant(name, group, what, (Edit(where, old, new),), equivalent)


def term(
    group: str, name: str, formula: str, where: str, old: str, variants: Sequence[str]
) -> tuple[Mutant, ...]:
    """A term dropped, with the other sign, and twice as large."""
    ways = (("dropped", "dropped"), ("flipped", "with the other sign"), ("doubled", "doubled"))
    return tuple(
        one(group, f"{name}-{way}", f"{formula} {said}", where, old, new)
        for (way, said), new in zip(ways, variants, strict=True)
    )


FORM_MUTANTS = (
    *term(
        "forms",
        "f2-grad-h-squared",
        "f2: |grad H|^2 nu",
        F2_,
        BODY_T1,
        ("-Q * H", "-dot(grad_H, grad_H) - Q * H", "2.0 * dot(grad_H, grad_H) - Q * H"),
    ),
    *term(
        "forms",
        "f2-s-squared-grad-h",
        "f2: S^2 grad H",
        F2_,
        BODY_T2,
        tuple(f", times({s}, apply(S, S_grad_H))" for s in (0.0, -1.0, 2.0)),
    ),
    *term(
        "forms",
        "f2-flux",
        "f2: 2 (S grad H) . grad phi nu",
        FLUX,
        FLUX_T3,
        ("times(0.0 *", "times(-2.0 *", "times(4.0 *"),
    ),
    *term(
        "forms",
        "f2-q-divergence",
        "f2: Q grad phi",
        FLUX,
        FLUX_T4,
        (", times(0.0 * Q, b)", ", times(-Q, b)", ", times(2.0 * Q, b)"),
    ),
    *term(
        "forms",
        "f2-q-h-nu",
        "f2: Q H nu",
        F2_,
        BODY_T1,
        tuple(f"dot(grad_H, grad_H) {s} * Q * H" for s in ("- 0.0", "+ 1.0", "- 2.0")),
    ),
    one(
        "forms",
        "f2-flux-transposed",
        "f2: (nu . grad phi) S grad H",
        FLUX,
        "times(2.0 * dot(apply(S, grad_H), b), nu)",
        "times(2.0 * dot(nu, b), apply(S, grad_H))",
    ),
    *term("forms", "f1", "F1", f"{FORMS}:F1", "-S2", ("-0.0 * S2", "S2", "-2.0 * S2")),
    *term(
        "forms",
        "f2-matrix",
        "F2",
        f"{FORMS}:F2",
        "Sz = apply(S, z)",
        tuple(f"Sz = times({s}, apply(S, z))" for s in (0.0, -1.0, 2.0)),
    ),
    one("forms", "f2-hs-dropped", "F2: -S^2 alone", f"{FORMS}:F2", "times(H,", "times(0.0 * H,"),
    one("forms", "f2-s2-dropped", "F2: H S alone", f"{FORMS}:F2", "times(-1.0,", "times(0.0,"),
    one("forms", "f2-hs-plus-s2", "F2: H S + S^2", f"{FORMS}:F2", "times(-1.0,", "times(1.0,"),
    *term(
        "forms",
        "g1",
        "g1: Q",
        f"{FORMS}:g1",
        "return Q",
        ("return 0.0 * Q", "return -Q", "return 2.0 * Q"),
    ),
    *term(
        "forms",
        "g2",
        "g2: |S|^2 nu",
        f"{FORMS}:g2",
        "times(S2",
        ("times(0.0 * S2", "times(-S2", "times(2.0 * S2"),
    ),
)

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
        "law(H, S2",
        "law(0.5 * H, S2",
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

WILLMORE, HELFRICH, FORCED = "solver.laws:willmore", "solver.laws:helfrich", "solver.laws:forced"
LAW_MUTANTS = (
    *term(
        "law",
        "willmore-cubic",
        "Willmore: -H^3/2",
        WILLMORE,
        "-0.5 *",
        ("-0.0 *", "0.5 *", "-1.0 *"),
    ),
    *term(
        "law",
        "willmore-s2",
        "Willmore: |S|^2 H",
        WILLMORE,
        "+ S2 * H",
        ("", "- S2 * H", "+ 2.0 * S2 * H"),
    ),
    one(
        "law",
        "willmore-is-surface-diffusion",
        "Willmore: Q = 0",
        WILLMORE,
        "-0.5 * H**3 + S2 * H",
        "np.zeros_like(H)",
    ),
    one(
        "law",
        "surface-diffusion-is-willmore",
        "surface diffusion: Q of Willmore",
        "solver.laws:surface_diffusion",
        "np.zeros_like(H)",
        "-0.5 * H**3 + S2 * H",
    ),
    one(
        "law",
        "helfrich-sign",
        "Helfrich: H + H0",
        HELFRICH,
        "H - spontaneous_curvature",
        "H + spontaneous_curvature",
    ),
    one("law", "helfrich-factor", "Helfrich: H (H - H0)^2", HELFRICH, "- 0.5 * H", "- H"),
    one("law", "helfrich-not-squared", "Helfrich: H (H - H0)/2", HELFRICH, "excess**2", "excess"),
    one("law", "forcing-dropped", "no forcing", FORCED, "t) + f(x, t)", "t)"),
    one("law", "forcing-flipped", "forcing with the other sign", FORCED, "t) + f", "t) - f"),
)

JACOBIAN, GEOMETRY_ = f"{GEOMETRY}:from_jacobian", f"{GEOMETRY}:geometry"
FLAT = """element = reference_element(mesh.degree, quadrature_degree)
    corners = np.column_stack([1.0 - element.nodes.sum(axis=1), element.nodes])
    flat = np.empty_like(x)
    flat[mesh.cells] = corners @ x[mesh.triangles]
    x = flat"""
ELEMENT = "element = reference_element(mesh.degree, quadrature_degree)"
FRAME, DUAL = f"{GEOMETRY}:frame", "cross(J1, N), cross(N, J0)"
DUAL_IS_J = "times(det, J0), times(det, J1)"
RULE = "2 * degree + 2 if quadrature_degree is None"
GEOMETRY_MUTANTS = (
    one(
        "geometry",
        "no-inverse-metric",
        "grad u = J du",
        FRAME,
        DUAL,
        "times(det, J0), times(det, J1)",
    ),
    one(
        "geometry",
        "metric-off-diagonal",
        "stiffness with (J^T J)^-1_01 of the other sign",
        f"{ASSEMBLY}:stiffness_matrix",
        "in inverse_metric(geo)",
        "in np.array([[[1.0]], [[-1.0]], [[1.0]]]) * inverse_metric(geo)",
    ),
    one(
        "geometry",
        "dual-basis-swapped",
        "the columns of B exchanged",
        FRAME,
        DUAL,
        "cross(N, J0), cross(J1, N)",
    ),
    one(
        "geometry",
        "area-element-squared",
        "dA = det J^T J, in the solver and in the norms",
        JACOBIAN,
        "root * element.weights",
        "root**2 * element.weights",
    ),
    one(
        "geometry",
        "area-element-of-the-plane",
        "dA of the reference triangle",
        JACOBIAN,
        "root * element.weights",
        "np.ones_like(root) * element.weights",
    ),
    one(
        "geometry",
        "area-element-doubled",
        "dA twice as large",
        GEOMETRY_,
        "J = np.swapaxes(reference_gradient(mesh, element, x), -1, -2)\n"
        "    return from_jacobian(mesh, element, values(mesh, element, x), J)",
        "J = np.swapaxes(reference_gradient(mesh, element, x), -1, -2)\n"
        "    geo = from_jacobian(mesh, element, values(mesh, element, x), J)\n"
        "    return Geometry(mesh, element, geo.points, 2.0 * geo.dA, geo.normal, geo.B)",
    ),
    one(
        "geometry",
        "normal-reversed",
        "inward normal of the mesh",
        FRAME,
        "1.0 / root",
        "-1.0 / root",
    ),
    one("geometry", "linear-geometry", "flat triangles at degree k", GEOMETRY_, ELEMENT, FLAT),
    one(
        "geometry",
        "flat-nodes",
        "nodes of degree k on the chords",
        "solver.mesh:elevate",
        "raised, project(nodes)",
        "raised, nodes",
    ),
    one(
        "geometry",
        "edge-nodes-not-reversed",
        "edge nodes numbered as each element sees them",
        "solver.mesh:triangulation",
        "np.where(reversed_, along[::-1], along)",
        "np.where(reversed_, along, along)",
    ),
    one(
        "assembly",
        "quadrature-degree-1",
        "one quadrature point",
        "solver.reference_element:reference_element",
        RULE,
        "1 if quadrature_degree is None",
    ),
    one(
        "assembly",
        "quadrature-degree-k",
        "quadrature exact to degree k",
        "solver.reference_element:reference_element",
        RULE,
        "degree if quadrature_degree is None",
    ),
    one(
        "assembly",
        "quadrature-degree-2k-1",
        "quadrature exact to degree 2k - 1",
        "solver.reference_element:reference_element",
        RULE,
        "2 * degree - 1 if quadrature_degree is None",
        "6 points at k = 2: the perturbed forms are still consistent to O(h^k) and coercive",
    ),
    one(
        "assembly",
        "stiffness-half-mixed",
        "the mixed derivatives once instead of twice",
        "solver.reference_element:ReferenceElement.stiffness_table",
        "products[0, 1] + products[1, 0]",
        "products[0, 1]",
    ),
    one(
        "assembly",
        "gradient-load-sign",
        "int G . grad phi with the other sign",
        LOADS,
        "local[:3] += ",
        "local[:3] -= ",
    ),
    one(
        "assembly",
        "load-without-area",
        "loads without the area element",
        LOADS,
        "(geo.dA, geo.B",
        "(np.broadcast_to(geo.element.weights, geo.dA.shape), geo.B",
    ),
)

U_PAST = "u_past = combine(delta[1:], [s.u for s in past])"
X_EXT = "x_ext = combine(gamma, [s.x for s in past])"
COEFFICIENTS = "past = list(history)[: scheme.bdf.order]"
X_NEW = "x = (tau * V[:, None] * nu - x_past) / delta[0]"
TIME_MUTANTS = (
    one(
        "time",
        "delta-off",
        "delta_1 one per cent off",
        STEP,
        COEFFICIENTS,
        f"{COEFFICIENTS}\n    delta[1] *= 1.01",
    ),
    one(
        "time",
        "delta-0-of-euler",
        "c = 1/tau for every order",
        STEP,
        "block.renew(delta[0] / tau, M, A)",
        "block.renew(1.0 / tau, M, A)",
    ),
    one(
        "time",
        "gamma-off",
        "gamma_0 one per cent off",
        STEP,
        COEFFICIENTS,
        f"{COEFFICIENTS}\n    gamma[0] *= 1.01",
    ),
    one(
        "time",
        "gamma-of-lower-order",
        "extrapolation by the last values alone",
        STEP,
        COEFFICIENTS,
        f"{COEFFICIENTS}\n    gamma = [1.0] + [0.0] * (len(gamma) - 1)",
    ),
    one(
        "time",
        "x-not-extrapolated",
        "assembly on the last surface",
        STEP,
        X_EXT,
        "x_ext = past[0].x",
    ),
    one(
        "time",
        "u-not-extrapolated",
        "the forms of the last u",
        STEP,
        "u_ext = combine(gamma, [s.u for s in past])",
        "u_ext = past[0].u",
    ),
    one(
        "time",
        "history-reversed",
        "u^{n-j} in the wrong order",
        STEP,
        U_PAST,
        "u_past = combine(delta[1:], [s.u for s in past[::-1]])",
    ),
    one(
        "time",
        "x-by-old-velocity",
        "x^n by the velocity at n - 1",
        STEP,
        X_NEW,
        "x = (tau * past[0].v - x_past) / delta[0]",
    ),
    one(
        "time",
        "x-by-extrapolated-normal",
        "x^n by V^n nu_ext",
        STEP,
        X_NEW,
        "x = (tau * V[:, None] * u_ext[:, 1:] - x_past) / delta[0]",
        "nu_ext = nu + O(tau^q), so the velocity is consistent of the same order",
    ),
    one(
        "time",
        "law-at-old-time",
        "Q(t - tau)",
        STEP,
        "scheme.law, t)",
        "scheme.law, t - tau)",
    ),
    one(
        "time",
        "time-off-by-one",
        "t_n = (n - 1) tau",
        EVOLVE,
        "initial.t + n * tau",
        "initial.t + (n - 1) * tau",
    ),
    one(
        "time",
        "start-of-low-order",
        "self-start by one Euler step",
        START,
        "for m in range(1, q + 1):\n        s = state",
        "for m in (1,) * q:\n        s = state",
    ),
    one(
        "time",
        "start-one-order-less",
        "self-start extrapolated once too few",
        START,
        "q = scheme.bdf.order",
        "q = max(scheme.bdf.order - 1, 1)",
        "start values with a local error O(tau^q) keep the order q of u and x",
    ),
    one(
        "time",
        "start-repeats",
        "start values are those of t = 0",
        EVOLVE,
        "state = start(time(n))",
        "state = replace(initial, t=time(n))",
    ),
)

CORRECTION = "solver.scheme:correction"
THETA_MUTANTS = (
    one(
        "theta",
        "theta-flipped",
        "-theta",
        STEP,
        "tau, g + theta",
        "tau, g - theta",
    ),
    one(
        "theta",
        "theta-doubled",
        "2 theta",
        STEP,
        "tau, g + theta",
        "tau, g + 2.0 * theta",
    ),
    one("theta", "theta-dropped", "no theta", CORRECTION, "if not scheme.theta:", "if True:"),
    one(
        "theta",
        "theta-without-g",
        "theta = M w0 + A u0",
        CORRECTION,
        "- forms.loads(geo, c)[1]",
        "",
    ),
    one(
        "theta",
        "theta-law-at-wrong-time",
        "theta with the forcing at t = tau",
        EVOLVE,
        "correction(mesh, initial, scheme)",
        "correction(mesh, replace(initial, t=initial.t + tau), scheme)",
    ),
    one(
        "theta",
        "theta-at-wrong-time",
        "theta of the exact State at t = tau",
        EVOLVE,
        "correction(mesh, initial, scheme)",
        "correction(mesh, start(initial.t + tau) if start else initial, scheme)",
        "theta of exact nodal values at any time is O(h^k), and at t = tau it is exact as at 0",
    ),
    one(
        "theta",
        "theta-in-the-u-equations",
        "theta on the right of the u-equations",
        STEP,
        "a, b = f - M",
        "a, b = f + theta - M",
    ),
)

PROJECTED, UNIT = "solver.scheme:projected", "solver.scheme:unit"
AFTER, EXTRAPOLATION = "        nu, z = projected(nu, z)\n", "unit(u_ext[:, 1:])"
PROJECTION_MUTANTS = (
    Mutant(
        "projection-skipped",
        "projection",
        "no projection though asked for",
        (Edit(STEP, AFTER, "        pass\n"), Edit(STEP, EXTRAPOLATION, "u_ext[:, 1:]")),
    ),
    one(
        "projection",
        "projection-skipped-after-the-step",
        "nu / |nu| of the extrapolation alone",
        STEP,
        AFTER,
        "        pass\n",
    ),
    one(
        "projection",
        "extrapolated-normal-not-projected",
        "nu_ext not normalised",
        STEP,
        EXTRAPOLATION,
        "u_ext[:, 1:]",
        "past normals are unit, so |nu_ext| = 1 + O(tau^q): the paper itself projects no more",
    ),
    one(
        "projection",
        "z-not-projected",
        "z keeps its normal part",
        PROJECTED,
        "return nu, z - np.einsum",
        "return nu, z - 0.0 * np.einsum",
        "z enters the next step as first guess alone, and its own normal part is O(h^k)",
    ),
    one(
        "projection",
        "z-projected-twice",
        "z - 2 (z . nu) nu",
        PROJECTED,
        "return nu, z - np.einsum",
        "return nu, z - 2.0 * np.einsum",
        "as z-not-projected: the normal part of z is O(h^k) with either sign",
    ),
    one(
        "projection",
        "z-normal-part-only",
        "z = (z . nu) nu",
        PROJECTED,
        "return nu, z - np.einsum",
        "return nu, np.einsum",
    ),
    Mutant(
        "projection-always",
        "projection",
        "projection though not asked for",
        (
            Edit(STEP, "if scheme.project:  # differs", "if True:  # differs"),
            Edit(STEP, "if scheme.project:\n        # differs", "if True:\n        # differs"),
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

BLOCK = "solver.block_system:BlockSystem"
FRESH, OLDER = f"{BLOCK}._with_factors", f"{BLOCK}._with_older_factors"
LINEAR_MUTANTS = (
    one(
        "linear algebra",
        "gmres-tolerance",
        "GMRES stops at 1e-2",
        STEP,
        "w_start, tolerance",
        "w_start, 1e-2",
    ),
    Mutant(
        "f-lagged",
        "linear algebra",
        "F w of the extrapolated w, no iteration",
        (
            Edit(FRESH, "coefficient * answer", "0.0 * coefficient * answer"),
            Edit(
                OLDER,
                "return y, ",
                "return y + defect - sum(c * d for c, d in zip(coefficients, directions)), ",
            ),
        ),
    ),
    one(
        "linear algebra",
        "root-not-divided",
        "u not divided by sqrt(c)",
        f"{BLOCK}._solution",
        "y.real / self._root",
        "y.real",
    ),
    one(
        "linear algebra",
        "b-not-scaled",
        "b not multiplied by sqrt(c)",
        f"{BLOCK}._right",
        "self._root * b",
        "b",
    ),
    one(
        "linear algebra",
        "stiffness-flipped",
        "sqrt(c) M - i A",
        "solver.block_system:_combined",
        "+ 1j * A.data",
        "- 1j * A.data",
    ),
    Mutant(
        "iteration-without-f",
        "linear algebra",
        "GMRES sees half of F",
        (
            Edit(FRESH, "self._solve(F(d), 0.0)", "self._solve(0.5 * F(d), 0.0)"),
            Edit(OLDER, "- F(d.imag)", "- 0.5 * F(d.imag)"),
        ),
        "the defect is that of d = w - w_start = O(tau^q) alone, and the solve contracts it",
    ),
)

INITIAL, EXACT = "harness.schemes:initial_state", "harness.errors:exact_state"
PEER_Z = "(1.0 + (f.S**2).sum((-2, -1)))[:, None] * (f.z - (f.S**2).sum((-2, -1))[:, None] * f.nu)"
ENERGY = "solver.functionals:willmore_energy"
START_MUTANTS = (
    one(
        "start",
        "nu-reversed",
        "nu points inwards at t = 0",
        INITIAL,
        "p, f.nu, f.H",
        "p, -f.nu, f.H",
    ),
    Mutant(
        "all-reversed",
        "start",
        "nu, H, V and z for the inward orientation",
        (
            Edit(INITIAL, "p, f.nu, f.H, V, f.z", "p, -f.nu, -f.H, -V, -f.z"),
            Edit(EXACT, "x, f.nu, f.H, f.V, f.z", "x, -f.nu, -f.H, -f.V, -f.z"),
        ),
    ),
    one("start", "h-halved", "H = (k1 + k2)/2 at t = 0", INITIAL, "f.nu, f.H", "f.nu, f.H / 2"),
    one("start", "v-zero", "V = 0 at t = 0", INITIAL, "f.H, V, f.z", "f.H, 0.0 * V, f.z"),
    one("start", "z-zero", "z = 0 at t = 0", INITIAL, "V, f.z)", "V, 0.0 * f.z)"),
    one("start", "energy-without-half", "W = int H^2", ENERGY, "0.5 *", "1.0 *"),
)

LIFT, RECORD = "harness.errors:lifted_surface", "harness.recorder:Recorder.__call__"
RUN_ERRORS = "harness.rows:run_errors"
LIFT_MUTANTS = (
    one(
        "errors",
        "lift-without-closest-point",
        "Gamma is Gamma_h* in the norms",
        LIFT,
        "Y = solution.closest_point(points, t)",
        "Y = points",
        "Gamma_h* lies within O(h^{k+1}) of Gamma and its tangents within O(h^k): equivalent norms",
    ),
    one(
        "errors",
        "lift-derivative-identity",
        "J_Y = J",
        LIFT,
        "J_Y = solution.closest_point_derivative(points, t) @ J",
        "J_Y = J",
        "the tangential part of J_Y - J is O(h^{k+1}), beyond the error that is measured",
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
        "errors of a smooth flow are of the same order at each t > 0 as in the maximum",
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

PEER_MUTANTS = (
    Mutant(
        "peer-bdf-on-positions-only",
        "peers",
        "BDF q for x, Euler for u",
        (
            Edit(STEP, U_PAST, "u_past = -past[0].u"),
            Edit(STEP, "block.renew(delta[0] / tau, M, A)", "block.renew(1.0 / tau, M, A)"),
        ),
    ),
    Mutant(
        "peer-z-initialised-wrongly",
        "peers",
        "z = Lap nu + |S|^2 Lap nu at t = 0 and in start values",
        (
            Edit(INITIAL, "f.H, V, f.z)", f"f.H, V, {PEER_Z})"),
            Edit(EXACT, "f.H, f.V, f.z)", f"f.H, f.V, {PEER_Z})"),
        ),
    ),
)

MUTANTS: tuple[Mutant, ...] = (
    *FORM_MUTANTS,
    *CURVATURE_MUTANTS,
    *LAW_MUTANTS,
    *GEOMETRY_MUTANTS,
    *TIME_MUTANTS,
    *THETA_MUTANTS,
    *PROJECTION_MUTANTS,
    *LINEAR_MUTANTS,
    *START_MUTANTS,
    *LIFT_MUTANTS,
    *PEER_MUTANTS,
)
