"""The block solve and its iteration."""

from harness.mutation.registry.making import STEP, one

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
        "K: d -> w of (F d, 0) is O(tau^(1/2)), for it is lam/(c + lam^2) on a mode of A = lam M; "
        "so d, which is O(tau^q), is O(tau^(q+1/2)) wrong, and w after the last pass O(tau^(q+1))",
    ),
)
