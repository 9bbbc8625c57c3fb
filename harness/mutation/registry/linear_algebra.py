"""The block solve and its iteration."""

from harness.mutation.patching import Edit, Mutant
from harness.mutation.registry.making import one

BLOCK = "solver.block_system:BlockSystem"
FRESH, OLDER = f"{BLOCK}._with_factors", f"{BLOCK}._with_older_factors"
LINEAR_MUTANTS = (
    one(
        "linear algebra",
        "gmres-tolerance",
        "GMRES stops at 1e-2",
        "solver.reaction:Known.guesses",
        "w, self.tolerance",
        "w, 1e-2",
    ),
    Mutant(
        "f-lagged",
        "linear algebra",
        "F w of the guess of w, no iteration",
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
        "pair-lagged",
        "the linearised pair (H, V) without iteration",
        f"{BLOCK}.solve_pair",
        "coefficient * found",
        "0.0 * coefficient * found",
    ),
    one(
        "linear algebra",
        "pair-without-its-guess",
        "the coupling of the guess of (H, V) left out",
        f"{BLOCK}.solve_pair",
        "y[:, :1] + answer(start - known)",
        "y[:, :1] + 0.0 * answer(start - known)",
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
        "K: d -> w of (F d, 0) is O(tau^(1/2)), for it is lam/(c + lam^2) on a mode of A = lam M; "
        "so d, which is O(tau^q), is O(tau^(q+1/2)) wrong, and w after the last pass O(tau^(q+1))",
    ),
)
