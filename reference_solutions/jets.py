"""Taylor polynomials in two variables, truncated: derivatives of parametrised surfaces without end.

A jet of order n is an array (n+1, n+1, ...): entry [i, j] is the coefficient of h^i k^j, that is
the derivative divided by i! j!, and entries with i + j > n are 0. The axes behind are those of
points and components.
"""

from collections.abc import Sequence
from math import factorial

import numpy as np

from esfem.reference_solutions.exact import Array

Derivatives = Sequence[Array] | Sequence[float]


def multiply(a: Array, b: Array) -> Array:
    """The product of two jets, to the lower of their orders."""
    n = min(len(a), len(b))
    result = np.zeros((n, n, *np.broadcast_shapes(a.shape[2:], b.shape[2:])))
    for i in range(n):
        for j in range(n - i):
            for k in range(n - i - j):
                for l in range(n - i - j - k):
                    result[i + k, j + l] += a[i, j] * b[k, l]
    return result


def power(a: Array, exponent: float) -> Array:
    """The jet a^exponent by the binomial series in the part of a without constant term."""
    constant = a[0, 0]
    rest = a / constant
    rest[0, 0] = 0.0
    result, term = np.zeros_like(a), np.zeros_like(a)
    term[0, 0] = constant**exponent
    for k in range(len(a)):
        result += term
        term = multiply(term, rest) * ((exponent - k) / (k + 1))
    return result


def derivative(a: Array, axis: int) -> Array:
    """The derivative by the first (axis 0) or second variable, of an order less."""
    n = len(a) - 1
    factors = np.arange(1.0, n + 1)
    if axis == 0:
        shifted = a[1:, :n] * factors.reshape(-1, 1, *[1] * (a.ndim - 2))
    else:
        shifted = a[:n, 1:] * factors.reshape(1, -1, *[1] * (a.ndim - 2))
    return shifted


def dot(a: Array, b: Array) -> Array:
    """The scalar product over the last axis."""
    return multiply(a, b).sum(axis=-1)


def cross(a: Array, b: Array) -> Array:
    """The vector product over the last axis."""
    p, q = [1, 2, 0], [2, 0, 1]
    return multiply(a[..., p], b[..., q]) - multiply(a[..., q], b[..., p])


def separable(first: Derivatives, second: Derivatives) -> Array:
    """The jet of f(h) g(k) from the derivatives 0, ..., n of f and of g, each (...)."""
    n = len(first)
    result = np.zeros((n, n, *np.broadcast_shapes(np.shape(first[0]), np.shape(second[0]))))
    for i in range(n):
        for j in range(n - i):
            result[i, j] = first[i] * second[j] / (factorial(i) * factorial(j))
    return result


def frame(X: Array) -> tuple[Array, list[Array], Array]:
    """Jets of nu, of the dual basis X^i (X^i . X_j = delta_ij) and of the area element.

    X (n, n, ..., 3) is the surface; its parameters are left-handed seen from outside.
    """
    X1, X2 = derivative(X, 0), derivative(X, 1)
    normal = cross(X2, X1)
    square = dot(normal, normal)
    nu = multiply(normal, power(square, -0.5)[..., None])
    inverse = power(square, -1.0)[..., None]
    dual = [
        multiply(cross(normal, X2), inverse),
        multiply(cross(normal, X1), -inverse),
    ]
    return nu, dual, power(square, 0.5)


def gradient(dual: list[Array], f: Array) -> Array:
    """The jet of grad_Gamma f = sum_i X^i d_i f, the axis of the gradient before that of f."""
    vector = f.ndim == dual[0].ndim
    total = np.zeros(())
    for i, basis in enumerate(dual):
        d_f = derivative(f, i)
        if vector:
            total = total + multiply(basis[..., :, None], d_f[..., None, :])
        else:
            total = total + multiply(basis, d_f[..., None])
    return total
