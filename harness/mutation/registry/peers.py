"""Mistakes that programs of others make."""

from harness.mutation.patching import Edit, Mutant
from harness.mutation.registry.making import EVOLVE, EXACT, INITIAL, STEP

U_PAST = "u_past = combine(delta[1:], [s.u for s in past])"
PEER_Z = "(1.0 + (f.S**2).sum((-2, -1)))[:, None] * (f.z - (f.S**2).sum((-2, -1))[:, None] * f.nu)"

START, SELF = "start(t)", "extrapolated_start(mesh, block, history[0], t, tau, scheme, theta)"
BY_BDF = "step(mesh, block, history, t, tau, scheme, theta)"
STAYS = "replace(history[0], t=t)"

PEER_MUTANTS = (
    Mutant(
        "peer-does-nothing",
        "peers",
        "the initial State at all times",
        tuple(Edit(EVOLVE, f"state = {way}", f"state = {STAYS}") for way in (BY_BDF, START, SELF)),
    ),
    Mutant(
        "peer-does-half",
        "peers",
        "x by half of the velocity",
        (Edit(STEP, "x = (tau * v - x_past)", "x = (0.5 * tau * v - x_past)"),),
    ),
    Mutant(
        "peer-bdf-on-positions-only",
        "peers",
        "BDF q for x, Euler for u",
        (
            Edit(STEP, U_PAST, "u_past = -past[0].u"),
            Edit(STEP, "renew(delta[0] / tau, ", "renew(1.0 / tau, "),
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
