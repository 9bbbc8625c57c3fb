"""The correction of section 3.4."""

from harness.mutation.registry.making import EVOLVE, STEP, one

CORRECTION = "solver.scheme:correction"
THETA_MUTANTS = (
    one(
        "theta",
        "theta-flipped",
        "-theta",
        STEP,
        "on.g + theta",
        "on.g - theta",
    ),
    one(
        "theta",
        "theta-doubled",
        "2 theta",
        STEP,
        "on.g + theta",
        "on.g + 2.0 * theta",
    ),
    one("theta", "theta-dropped", "no theta", CORRECTION, "if not scheme.theta:", "if True:"),
    one(
        "theta",
        "theta-without-g",
        "theta = M w0 + A u0",
        CORRECTION,
        " - on.g",
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
        "the defect of exact nodal values is O(h^k) at any time and differs at tau and 0 by "
        "O(tau h^k); the theorem asks no more of theta",
    ),
    one(
        "theta",
        "theta-in-the-u-equations",
        "theta on the right of the u-equations",
        STEP,
        "a, b = on.f - on.M",
        "a, b = on.f + theta - on.M",
    ),
)
