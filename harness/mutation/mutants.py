"""The registry of seeded bugs: one line of the program made wrong, in the groups of the paper.

What each `Edit` replaces must occur once in its function; when the program changes, the tests name
the mutants that have to follow.
"""

from collections.abc import Sequence

from harness.mutation.patching import Edit, Mutant

FORMS, GEOMETRY, ASSEMBLY = "solver.forms", "solver.geometry", "solver.assembly"
STEP, EVOLVE, START = "solver.scheme:step", "solver.flow:evolve", "solver.flow:extrapolated_start"
CURVATURE, F2_ = f"{FORMS}:curvature", f"{FORMS}:f2"
BODY_T1, BODY_T2 = "(grad_H2 - c.Q * c.H)", "+ apply(c.S, S_grad_H)"
FLUX_T3, FLUX_T4 = "flux = 2.0 *", "+ c.Q[..., None, None] * IDENTITY"


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
        ("(-c.Q * c.H)", "(-grad_H2 - c.Q * c.H)", "(2.0 * grad_H2 - c.Q * c.H)"),
    ),
    *term(
        "forms",
        "f2-s-squared-grad-h",
        "f2: S^2 grad H",
        F2_,
        BODY_T2,
        ("", "- apply(c.S, S_grad_H)", "+ 2.0 * apply(c.S, S_grad_H)"),
    ),
    *term(
        "forms",
        "f2-flux",
        "f2: 2 (S grad H) . grad phi nu",
        F2_,
        FLUX_T3,
        ("flux = 0.0 *", "flux = -2.0 *", "flux = 4.0 *"),
    ),
    *term(
        "forms",
        "f2-q-divergence",
        "f2: Q grad phi",
        F2_,
        FLUX_T4,
        ("", "- c.Q[..., None, None] * IDENTITY", "+ 2.0 * c.Q[..., None, None] * IDENTITY"),
    ),
    *term(
        "forms",
        "f2-q-h-nu",
        "f2: Q H nu",
        F2_,
        BODY_T1,
        ("grad_H2", "(grad_H2 + c.Q * c.H)", "(grad_H2 - 2.0 * c.Q * c.H)"),
    ),
    one(
        "forms",
        "f2-flux-transposed",
        "f2: (nu . grad phi) S grad H",
        F2_,
        "S_grad_H[..., :, None] * c.nu[..., None, :]",
        "c.nu[..., :, None] * S_grad_H[..., None, :]",
    ),
    *term("forms", "f1", "F1", f"{FORMS}:F1", "-c.S2", ("-0.0 * c.S2", "c.S2", "-2.0 * c.S2")),
    *term(
        "forms",
        "f2-matrix",
        "F2",
        f"{FORMS}:F2",
        "load(geo, ",
        ("load(geo, 0.0 * ", "-load(geo, ", "2.0 * load(geo, "),
    ),
    one("forms", "f2-hs-dropped", "F2: -S^2 alone", f"{FORMS}:F2", "c.H[..., None] * Sz", "0.0"),
    one("forms", "f2-s2-dropped", "F2: H S alone", f"{FORMS}:F2", "- apply(c.S, Sz)", ""),
    one("forms", "f2-hs-plus-s2", "F2: H S + S^2", f"{FORMS}:F2", "- apply", "+ apply"),
    *term(
        "forms",
        "g1",
        "g1: Q",
        f"{FORMS}:g1",
        "load(geo, c.Q)",
        ("load(geo, 0.0 * c.Q)", "-load(geo, c.Q)", "load(geo, 2.0 * c.Q)"),
    ),
    *term(
        "forms",
        "g2",
        "g2: |S|^2 nu",
        f"{FORMS}:g2",
        "load(geo, c.S2",
        ("load(geo, 0.0 * c.S2", "load(geo, -c.S2", "load(geo, 2.0 * c.S2"),
    ),
)

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
DUAL = "np.stack([np.cross(J1, N), np.cross(N, J0)], axis=-1) / det[..., None, None]"
RULE = "2 * degree + 2 if quadrature_degree is None"
GEOMETRY_MUTANTS = (
    one("geometry", "no-inverse-metric", "grad u = J du", JACOBIAN, DUAL, "J"),
    one(
        "geometry",
        "metric-off-diagonal",
        "stiffness with (J^T J)^-1_01 of the other sign",
        f"{ASSEMBLY}:stiffness_matrix",
        "np.stack(inverse_metric(geo), axis=-1)",
        "np.stack(inverse_metric(geo), axis=-1) * [1.0, -1.0, 1.0]",
    ),
    one(
        "geometry",
        "dual-basis-swapped",
        "the columns of B exchanged",
        JACOBIAN,
        "np.cross(J1, N), np.cross(N, J0)",
        "np.cross(N, J0), np.cross(J1, N)",
    ),
    one(
        "geometry",
        "area-element-squared",
        "dA = det J^T J, in the solver and in the norms",
        JACOBIAN,
        "root * element.weights",
        "det * element.weights",
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
        JACOBIAN,
        "N / root",
        "-N / root",
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
        "products[:, 0, 1] + products[:, 1, 0]",
        "products[:, 0, 1]",
    ),
    one(
        "assembly",
        "gradient-load-sign",
        "int G . grad phi with the other sign",
        f"{ASSEMBLY}:gradient_load",
        "return _scatter",
        "return -_scatter",
    ),
    one(
        "assembly",
        "load-without-area",
        "loads without the area element",
        f"{ASSEMBLY}:load",
        "geo.dA.reshape(",
        "np.broadcast_to(geo.element.weights, geo.dA.shape).reshape(",
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
        "block.factor(delta[0] / tau, M, A)",
        "block.factor(1.0 / tau, M, A)",
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
        "forms.g(geo, curv) + theta",
        "forms.g(geo, curv) - theta",
    ),
    one(
        "theta",
        "theta-doubled",
        "2 theta",
        STEP,
        "forms.g(geo, curv) + theta",
        "forms.g(geo, curv) + 2.0 * theta",
    ),
    one("theta", "theta-dropped", "no theta", CORRECTION, "if not scheme.theta:", "if True:"),
    one(
        "theta",
        "theta-without-g",
        "theta = M w0 + A u0",
        CORRECTION,
        "- forms.g(geo, c)",
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
        "a = forms.f(geo, curv) - M @ u_past / tau",
        "a = forms.f(geo, curv) + theta - M @ u_past / tau",
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
LINEAR_MUTANTS = (
    one(
        "linear algebra",
        "gmres-tolerance",
        "GMRES stops at 1e-2",
        STEP,
        "scheme.tolerance\n",
        "1e-2\n",
    ),
    one(
        "linear algebra",
        "f-lagged",
        "F w of the extrapolated w, no iteration",
        f"{BLOCK}.solve_coupled",
        "w_start + d.reshape(shape)",
        "w_start",
    ),
    one(
        "linear algebra",
        "root-not-divided",
        "u not divided by sqrt(c)",
        f"{BLOCK}.solve",
        "y.real / self._root",
        "y.real",
    ),
    one(
        "linear algebra",
        "b-not-scaled",
        "b not multiplied by sqrt(c)",
        f"{BLOCK}.solve",
        "1j * self._root * b",
        "1j * b",
    ),
    one(
        "linear algebra",
        "stiffness-flipped",
        "sqrt(c) M - i A",
        f"{BLOCK}.factor",
        "+ 1j * A.data",
        "- 1j * A.data",
    ),
    one(
        "linear algebra",
        "iteration-without-f",
        "GMRES sees half of F",
        f"{BLOCK}.solve_coupled",
        "self.solve(F(d), zero)",
        "self.solve(0.5 * F(d), zero)",
        "the defect is that of d = w - w_ext = O(tau^q) alone, and the last pass contracts it",
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
            Edit(STEP, "block.factor(delta[0] / tau, M, A)", "block.factor(1.0 / tau, M, A)"),
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
