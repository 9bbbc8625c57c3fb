"""The terms of F1, F2, f2, g1 and g2."""

from harness.mutation.registry.making import one, term

FORMS = "solver.forms"
F2_ = f"{FORMS}:f2"
BODY_T1, BODY_T2 = "(grad_H2 - c.Q * c.H)", "+ apply(c.S, S_grad_H)"
FLUX_T3, FLUX_T4 = "flux = 2.0 *", "+ c.Q[..., None, None] * IDENTITY"

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
