"""Start values, and the energy."""

from harness.mutation.patching import Edit, Mutant
from harness.mutation.registry.making import EXACT, INITIAL, one

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
