"""BDF, extrapolation, start values and the time itself."""

from harness.mutation.registry.making import EVOLVE, STEP, one

START = "solver.flow:extrapolated_start"
U_PAST = "u_past = combine(delta[1:], [s.u for s in past])"
X_EXT = "x_ext = combine(gamma, [s.x for s in past])"
COEFFICIENTS = "past = list(history)[: scheme.bdf.order]"
X_NEW = "x = (tau * v - x_past)"
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
        "block.renew(delta[0] / tau, on.M, on.A)",
        "block.renew(1.0 / tau, on.M, on.A)",
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
        "x = (tau * past[0].v - x_past)",
    ),
    one(
        "time",
        "x-by-extrapolated-normal",
        "x^n by V^n nu_ext",
        STEP,
        X_NEW,
        "x = (tau * V[:, None] * u_ext[:, 1:] - x_past)",
        "nu_ext - nu = O(tau^q) in H^1, so v, and by it x, change by O(tau^q): the order of BDF q",
    ),
    one(
        "time",
        "law-at-old-time",
        "Q(t - tau)",
        STEP,
        "scheme.law, t, scheme",
        "scheme.law, t - tau, scheme",
    ),
    one(
        "time",
        "time-off-by-one",
        "t_n = (n - 1) tau",
        EVOLVE,
        "t, tau, history = levels.t(n), ",
        "t, tau, history = levels.t(n - 1), ",
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
    ),
    one(
        "time",
        "start-repeats",
        "start values are those of t = 0",
        EVOLVE,
        "state = start(t)",
        "state = replace(initial, t=t)",
    ),
)
