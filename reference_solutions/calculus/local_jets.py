"""Jets of a map X at each point, in two local right-handed parameters, from its derivatives.

On two periodic angles the local parameters are the angles. On the unit sphere they are a, b of the
orthographic chart about each point s by itself, (1 - r/2 - r^2/8 - ...) s + a e1 + b e2 with
r = a^2 + b^2, e1 x e2 = s: there is no pole. Shapes are those of `fundamental_forms`.
"""

from math import factorial

import numpy as np

from esfem.reference_solutions.calculus.generated import Index, indices
from esfem.reference_solutions.exact import Array
from esfem.reference_solutions.jets import multiply


def angle_jet(D: Array, order: int) -> Array:
    """The jet (order+1, order+1, 3, n) from derivatives D (indices, 3, n) by two angles."""
    jet = np.zeros((order + 1, order + 1, *D.shape[1:]))
    for m, index in enumerate(indices(2, order)):
        i, j = index.count(0), index.count(1)
        jet[i, j] = D[m] / (factorial(i) * factorial(j))
    return jet


def sphere_jet(s: Array, D: Array, order: int) -> Array:
    """The jet (order+1, order+1, 3, n) at s (3, n) from derivatives D (indices, 3, n) by x, y, z.

    Taylor's series of X with the jet of the chart less s for its increments.
    """
    increment = chart(s, order)
    monomials: dict[Index, Array] = {(k,): increment[:, :, k] for k in range(3)}

    def monomial(index: Index) -> Array:
        if index not in monomials:
            monomials[index] = multiply(monomial(index[:-1]), increment[:, :, index[-1]])
        return monomials[index]

    jet = np.zeros((order + 1, order + 1, *D.shape[1:]))
    jet[0, 0] = D[0]
    for m, index in enumerate(indices(3, order)):
        if index and np.any(D[m]):
            repeated = np.prod([factorial(index.count(k)) for k in range(3)])
            for i in range(3):
                if np.any(D[m, i]):
                    jet[:, :, i] += monomial(index) * (D[m, i] / repeated)
    return jet


def chart(s: Array, order: int) -> Array:
    """The jet (order+1, order+1, 3, n), order <= 4, of the chart about s (3, n), less s."""
    jet = np.zeros((5, 5, *s.shape))
    jet[1, 0], jet[0, 1] = sphere_frame(s)
    for (i, j), factor in {(2, 0): 4, (0, 2): 4, (4, 0): 1, (2, 2): 2, (0, 4): 1}.items():
        if i + j <= order:
            jet[i, j] = -factor / 8.0 * s
    return jet[: order + 1, : order + 1]


def sphere_frame(s: Array) -> tuple[Array, Array]:
    """Unit tangents e1, e2 (3, n) of the sphere at s (3, n), e1 x e2 = s.

    References
    ----------
    Duff et al., Building an orthonormal basis, revisited, J. Comput. Graph. Tech. 6 (2017).
    """
    sign = np.copysign(1.0, s[2])
    a = -1.0 / (sign + s[2])
    b = s[0] * s[1] * a
    e1 = np.stack([1.0 + sign * s[0] ** 2 * a, sign * b, -sign * s[0]])
    return e1, np.stack([b, sign + s[1] ** 2 * a, -s[1]])
