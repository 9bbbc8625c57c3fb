"""P_k Lagrange tables and quadrature on the reference triangle {(r, s): r, s >= 0, r + s <= 1}."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import basix
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREES = (1, 2, 3, 4)


@dataclass(frozen=True)
class ReferenceElement:
    """Values of the P_k basis at the points of a quadrature rule.

    Attributes
    ----------
    degree : polynomial degree k; n = (k+1)(k+2)/2 nodes, equispaced, in the order of basix:
        vertices, edges, interior.
    nodes : (n, 2) the lattice.
    points, weights : (Q, 2), (Q,) quadrature, the weights sum to 1/2, the area of the triangle.
    phi : (Q, n) values phi_i at point p.
    dphi : (Q, 2, n) reference derivatives d_r phi_i at point p.
    """

    degree: int
    nodes: Array
    points: Array
    weights: Array
    phi: Array
    dphi: Array

    @cached_property
    def dphi_table(self) -> Array:
        """d_r phi_i at point p, (2 Q, n), r before p, for integrals against grad phi."""
        return np.ascontiguousarray(self.dphi.swapaxes(0, 1)).reshape(-1, self.dphi.shape[-1])

    @cached_property
    def mass_table(self) -> Array:
        """phi_i phi_j at point p, (n n, Q): all local mass matrices are one product with it."""
        table = np.einsum("pi,pj->ijp", self.phi, self.phi)
        return np.ascontiguousarray(table).reshape(-1, len(self.weights))

    @cached_property
    def stiffness_table(self) -> Array:
        """d_r phi_i d_s phi_j at point p for rs = 00, 01 (symmetrised), 11: (n n, 3 Q)."""
        products = np.einsum("pri,psj->rsijp", self.dphi, self.dphi)
        entries = [products[0, 0], products[0, 1] + products[1, 0], products[1, 1]]
        return np.stack(entries, axis=2).reshape(-1, 3 * len(self.weights))


def _lagrange(degree: int) -> basix.finite_element.FiniteElement:
    if degree not in DEGREES:
        raise ValueError(f"degree = {degree!r}: must be one of {DEGREES}")
    return basix.create_element(
        basix.ElementFamily.P, basix.CellType.triangle, degree, basix.LagrangeVariant.equispaced
    )


def lattice(degree: int) -> Array:
    """The nodes of P_k on the reference triangle, shape (n, 2)."""
    return np.array(_lagrange(degree).points)


def tabulate(degree: int, points: Array) -> tuple[Array, Array]:
    """Values (P, n) and reference derivatives (P, 2, n) of the P_k basis at given points (P, 2)."""
    table = np.asarray(_lagrange(degree).tabulate(1, points))[..., 0]
    return np.array(table[0]), np.array(table[1:].transpose(1, 0, 2), order="C")


@lru_cache
def reference_element(degree: int, quadrature_degree: int | None = None) -> ReferenceElement:
    """The P_k element with a rule exact to ``quadrature_degree``, by default 2k + 2.

    Raises
    ------
    ValueError
        If ``degree`` is not in 1..4 or ``quadrature_degree`` is below 1.
    """
    nodes = lattice(degree)
    exactness = 2 * degree + 2 if quadrature_degree is None else quadrature_degree
    if exactness < 1:
        raise ValueError(f"quadrature_degree = {quadrature_degree!r}: must be at least 1")
    # Copies: a cached view would keep objects of basix alive until after its module is gone.
    rule = basix.make_quadrature(basix.CellType.triangle, exactness)
    points, weights = (np.array(a) for a in rule)
    phi, dphi = tabulate(degree, points)
    return ReferenceElement(degree, nodes, points, weights, phi, dphi)
