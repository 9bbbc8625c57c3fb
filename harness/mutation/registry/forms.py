"""The terms of F1, F2, f2, g1 and g2."""

from harness.mutation.registry.making import one, term

FORMS = "solver.forms"
F2_, FLUX = f"{FORMS}:f2", f"{FORMS}:f2_flux"
BODY_T1, BODY_T2 = "dot(grad_H, grad_H) - Q * H", ", apply(S, S_grad_H)"
FLUX_T3, FLUX_T4 = "times(2.0 *", ", times(Q, b)"

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
    one(
        "forms",
        "f-dropped-extrapolated",
        "F w~ left out where w is extrapolated",
        "solver.reaction:extrapolated",
        "a + on.F(known.w)",
        "a",
    ),
    one(
        "forms",
        "f2-dropped-linearised",
        "F w~ left out where the pair (H, V) is linearised",
        "solver.reaction:linearised",
        "a + on.F(known.w)",
        "a",
    ),
    one(
        "forms",
        "pair-f1-flipped",
        "F1 (V^n - V~) with the other sign",
        "solver.forms:_linear",
        "F1(S2[p], V)",
        "-F1(S2[p], V)",
    ),
    one(
        "forms",
        "pair-of-w-and-u-swapped",
        "(V, H) for (H, V) in the linearised pair",
        "solver.forms:_linear",
        "H, V = pair[0, p], pair[1, p]",
        "V, H = pair[0, p], pair[1, p]",
    ),
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
