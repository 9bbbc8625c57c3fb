"""The velocity laws and the forcing."""

from harness.mutation.registry.making import one, term

WILLMORE, HELFRICH = "solver.laws:willmore_Q", "solver.laws:helfrich_Q"
FORCED = "solver.laws:forced"
WILLMORE_q, HELFRICH_q = "solver.laws:willmore_q", "solver.laws:helfrich_q"
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
        "solver.laws:surface_diffusion_Q",
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
    *term(
        "law",
        "willmore-q",
        "linearised Willmore: |S|^2 in q",
        WILLMORE_q,
        "return S2",
        ("return 0.0 * S2", "return -S2", "return 2.0 * S2"),
    ),
    one(
        "law",
        "helfrich-q-without-h0",
        "linearised Helfrich: q of Willmore",
        HELFRICH_q,
        "H - spontaneous_curvature",
        "H",
    ),
    one(
        "law",
        "forced-q-dropped",
        "q = 0 where there is a forcing",
        FORCED,
        "with_split(law).q",
        "surface_diffusion_q",
    ),
    one("law", "willmore-q-is-newton", "dQ/dH in place of q", WILLMORE_q, "- 0.5 *", "- 1.5 *"),
    one("law", "forcing-dropped", "no forcing", FORCED, "t) + f(x, t)", "t)"),
    one("law", "forcing-flipped", "forcing with the other sign", FORCED, "t) + f", "t) - f"),
)
