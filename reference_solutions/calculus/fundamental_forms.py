"""Curvatures of a surface X(a, b) from the jet of X at each point (`reference_solutions.jets`).

A jet here has the shape (k, k, 3, n) for vectors and (k, k, n) for scalars: the axis of the points,
n, is last. X1 x X2 points outward. Letters: E = X1.X1, F = X1.X2, G = X2.X2, N = X1 x X2,
q = |N|^2 = EG - F^2, the dual basis X^1 = (G X1 - F X2)/q, X^2 = (E X2 - F X1)/q, and

    H = -(G X11 - 2 F X12 + E X22) . N q^{-3/2},  S = -sum_ij (X_ij . nu) X^i X^j^T.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from esfem.reference_solutions.calculus.curvature import outer
from esfem.reference_solutions.exact import Array
from esfem.reference_solutions.jets import derivative, multiply, power


def dot(a: Array, b: Array) -> Array:
    """The scalar product."""
    return multiply(a, b).sum(axis=2)


def cross(a: Array, b: Array) -> Array:
    """The vector product."""
    s, t = [1, 2, 0], [2, 0, 1]
    return multiply(a[:, :, s], b[:, :, t]) - multiply(a[:, :, t], b[:, :, s])


def scaled(f: Array, a: Array) -> Array:
    """The scalar f times the vector a."""
    return multiply(f[:, :, None], a)


@dataclass(frozen=True, eq=False)
class Forms:
    """The forms above as jets of the order of X less two."""

    X: Array

    @cached_property
    def first(self) -> tuple[Array, Array]:
        """X1, X2."""
        k = len(self.X) - 2
        return derivative(self.X, 0)[:k, :k], derivative(self.X, 1)[:k, :k]

    @cached_property
    def second(self) -> tuple[Array, Array, Array]:
        """X11, X12, X22."""
        X1, X2 = derivative(self.X, 0), derivative(self.X, 1)
        return derivative(X1, 0), derivative(X1, 1), derivative(X2, 1)

    @cached_property
    def metric(self) -> tuple[Array, Array, Array]:
        """E, F, G."""
        X1, X2 = self.first
        return dot(X1, X1), dot(X1, X2), dot(X2, X2)

    @cached_property
    def N(self) -> Array:
        """X1 x X2."""
        return cross(*self.first)

    @cached_property
    def q(self) -> Array:
        """|N|^2, the square of the area element."""
        return dot(self.N, self.N)

    @cached_property
    def dual(self) -> tuple[Array, Array]:
        """X^1, X^2."""
        (X1, X2), (E, F, G), r = self.first, self.metric, power(self.q, -1.0)
        return (
            scaled(r, scaled(G, X1) - scaled(F, X2)),
            scaled(r, scaled(E, X2) - scaled(F, X1)),
        )

    @cached_property
    def H(self) -> Array:
        """The mean curvature."""
        (E, F, G), (L, M, P) = self.metric, (dot(second, self.N) for second in self.second)
        sum_ = multiply(G, L) - 2.0 * multiply(F, M) + multiply(E, P)
        return -multiply(sum_, power(self.q, -1.5))

    def nu(self) -> Array:
        """The outward normal (3, n)."""
        return self.N[0, 0] / np.sqrt(self.q[0, 0])

    def S(self) -> Array:
        """The shape operator (3, 3, n), exactly symmetric."""
        nu = self.nu()
        L, M, P = (-(second[0, 0] * nu).sum(0) for second in self.second)
        s, t = (basis[0, 0] for basis in self.dual)
        mixed = outer(s, t)
        return L * outer(s, s) + P * outer(t, t) + M * (mixed + np.swapaxes(mixed, 0, 1))


def normal_and_shape(X: Array) -> tuple[Array, Array]:
    """nu (3, n) and S (3, 3, n) from a jet of order 2."""
    forms = Forms(X)
    return forms.nu(), forms.S()


def all_fields(X: Array) -> tuple[Array, ...]:
    """nu, H, z, S, grad_z, Lap_Gamma H from a jet of order 4.

    z = sum_i H_i X^i as a jet, and grad_Gamma z = sum_i X^i z_i.
    """
    forms = Forms(X)
    dual = [basis[:2, :2] for basis in forms.dual]
    zero = np.zeros(())
    z = sum((scaled(derivative(forms.H, i), dual[i]) for i in range(2)), zero)
    grad_z = sum((outer(dual[i][0, 0], derivative(z, i)[0, 0]) for i in range(2)), zero)
    laplace_H = np.einsum("aan->n", grad_z)
    return forms.nu(), forms.H[0, 0], z[0, 0], forms.S(), grad_z, laplace_H
