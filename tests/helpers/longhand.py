"""The paper's matrices and forms once more, slowly: loops over elements, points, basis functions.

An independent witness of `solver.geometry`, `solver.assembly` and `solver.forms`, written from the
component formulas of section 3.3 with its own Lagrange basis and `numpy.linalg`.  Only the nodes of
the elements and the quadrature rule are those of the solver.  Integrals are sums over `points_of`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from esfem.solver import Mesh
from esfem.solver.reference_element import reference_element

Integrand = Callable[["Point", int], float]  # of a point and a local basis function


def lattice(k: int) -> np.ndarray:
    """The nodes of P_k: vertices, the edges opposite to vertices 0, 1, 2, then the interior."""
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    nodes = list(corner)
    for a, b in ((1, 2), (0, 2), (0, 1)):
        nodes += [((k - m) * corner[a] + m * corner[b]) / k for m in range(1, k)]
    nodes += [np.array([i / k, j / k]) for j in range(1, k) for i in range(1, k - j)]
    return np.array(nodes)


def monomials(k: int, r: float, s: float) -> tuple[np.ndarray, np.ndarray]:
    """r^a s^b, a + b <= k, and their derivatives (n, 2)."""
    powers = [(a, b) for a in range(k + 1) for b in range(k + 1 - a)]
    value = [r**a * s**b for a, b in powers]
    d_r = [a * r ** max(a - 1, 0) * s**b for a, b in powers]
    d_s = [b * r**a * s ** max(b - 1, 0) for a, b in powers]
    return np.array(value), np.stack([d_r, d_s], axis=1)


@dataclass(frozen=True)
class Point:
    """A quadrature point: element, its nodes, position, weight dA, basis values and gradients."""

    element: int
    nodes: np.ndarray
    position: np.ndarray
    weight: float
    phi: np.ndarray
    grad: np.ndarray

    def value(self, u: np.ndarray) -> np.ndarray:
        """sum_j u_j phi_j of nodal u (N,) or (N, C)."""
        return sum(self.phi[i] * u[j] for i, j in enumerate(self.nodes))

    def gradient(self, u: np.ndarray) -> np.ndarray:
        """Gradients of the components as columns: (N,) -> (3,), (N, C) -> (3, C)."""
        return sum(np.multiply.outer(self.grad[i], u[j]) for i, j in enumerate(self.nodes))


def points_of(mesh: Mesh, x: np.ndarray) -> Iterator[Point]:
    """All quadrature points of Gamma_h[x]."""
    k = mesh.degree
    vandermonde = np.array([monomials(k, r, s)[0] for r, s in lattice(k)])
    coefficients = np.linalg.inv(vandermonde)  # column i: phi_i in monomials
    rule = reference_element(k)
    for element, nodes in enumerate(mesh.cells):
        for (r, s), weight in zip(rule.points, rule.weights, strict=True):
            value, derivative = monomials(k, r, s)
            phi, dphi = value @ coefficients, coefficients.T @ derivative
            J = sum(np.outer(x[j], dphi[i]) for i, j in enumerate(nodes))
            G = J.T @ J
            grad = np.array([J @ np.linalg.solve(G, d) for d in dphi])
            position = sum(phi[i] * x[j] for i, j in enumerate(nodes))
            area_element = np.sqrt(np.linalg.det(G))
            yield Point(element, nodes, position, weight * area_element, phi, grad)


def matrix(mesh: Mesh, points: list[Point], entry) -> np.ndarray:
    """sum over points of weight * entry(point, i, j), dense (N, N)."""
    result = np.zeros((mesh.node_count, mesh.node_count))
    for p in points:
        for (i, row), (j, column) in product(enumerate(p.nodes), repeat=2):
            result[row, column] += p.weight * entry(p, i, j)
    return result


def mass(mesh: Mesh, points: list[Point]) -> np.ndarray:
    return matrix(mesh, points, lambda p, i, j: p.phi[i] * p.phi[j])


def stiffness(mesh: Mesh, points: list[Point]) -> np.ndarray:
    return matrix(mesh, points, lambda p, i, j: p.grad[i] @ p.grad[j])


def vector(mesh: Mesh, points: list[Point], entry: Integrand) -> np.ndarray:
    """sum over points of weight * entry(point, i), (N,)."""
    result = np.zeros(mesh.node_count)
    for p in points:
        for i, row in enumerate(p.nodes):
            result[row] += p.weight * entry(p, i)
    return result


def components(mesh: Mesh, points: list[Point], entry) -> np.ndarray:
    """The same for l = 0, 1, 2: weight * entry(point, i, l), (N, 3)."""
    columns = [vector(mesh, points, lambda p, i, l=l: entry(p, i, l)) for l in range(3)]
    return np.stack(columns, axis=1)


class Fields:
    """H, nu, grad H, A_h, |A_h|^2 and Q_h = -H^3/2 + |A_h|^2 H at a point, from u = (H; nu)."""

    def __init__(self, p: Point, u: np.ndarray) -> None:
        self.H, self.nu = p.value(u[:, 0]), p.value(u[:, 1:])
        self.grad_H, grad_nu = p.gradient(u[:, 0]), p.gradient(u[:, 1:])
        self.A = (grad_nu + grad_nu.T) / 2
        self.A2 = np.linalg.norm(self.A) ** 2
        self.Q = -(self.H**3) / 2 + self.A2 * self.H


def fields_of(points: list[Point], u: np.ndarray) -> dict[int, Fields]:
    return {id(p): Fields(p, u) for p in points}


def F1(mesh: Mesh, points: list[Point], u: np.ndarray, V: np.ndarray) -> np.ndarray:
    at = fields_of(points, u)
    return vector(mesh, points, lambda p, i: -at[id(p)].A2 * p.value(V) * p.phi[i])


def F2(mesh: Mesh, points: list[Point], u: np.ndarray, z: np.ndarray) -> np.ndarray:
    at = fields_of(points, u)

    def entry(p: Point, i: int, l: int) -> float:
        H, A = at[id(p)].H, at[id(p)].A
        return ((H * A - A @ A) @ p.value(z))[l] * p.phi[i]

    return components(mesh, points, entry)


def f2_terms(mesh: Mesh, points: list[Point], u: np.ndarray) -> dict[str, np.ndarray]:
    """The five integrals of f2, in the paper's order and with the paper's signs; f2 is their sum.

    With phi = phi_i e_l the matrix grad phi has the single column l, so (grad phi nu) is
    grad phi_i nu_l and the divergence of phi is component l of grad phi_i.
    """
    at = fields_of(points, u)

    def grad_H_squared(p: Point, i: int, l: int) -> float:
        f = at[id(p)]
        return (f.grad_H @ f.grad_H) * f.nu[l] * p.phi[i]

    def A_squared(p: Point, i: int, l: int) -> float:
        f = at[id(p)]
        return (f.A @ f.A @ f.grad_H)[l] * p.phi[i]

    def divergence(p: Point, i: int, l: int) -> float:
        f = at[id(p)]
        grad_phi = np.zeros((3, 3))
        grad_phi[:, l] = p.grad[i]
        return 2 * (f.A @ f.grad_H) @ (grad_phi @ f.nu)

    def grad_Q(p: Point, i: int, l: int) -> float:
        return at[id(p)].Q * p.grad[i][l]

    def Q_H(p: Point, i: int, l: int) -> float:
        f = at[id(p)]
        return -f.Q * f.H * f.nu[l] * p.phi[i]

    terms = (grad_H_squared, A_squared, divergence, grad_Q, Q_H)
    return {term.__name__: components(mesh, points, term) for term in terms}


def f2(mesh: Mesh, points: list[Point], u: np.ndarray) -> np.ndarray:
    return sum(f2_terms(mesh, points, u).values())


def g1(mesh: Mesh, points: list[Point], u: np.ndarray) -> np.ndarray:
    at = fields_of(points, u)
    return vector(mesh, points, lambda p, i: at[id(p)].Q * p.phi[i])


def g2(mesh: Mesh, points: list[Point], u: np.ndarray) -> np.ndarray:
    at = fields_of(points, u)
    return components(mesh, points, lambda p, i, l: at[id(p)].A2 * at[id(p)].nu[l] * p.phi[i])


def F_matrix(mesh: Mesh, points: list[Point], u: np.ndarray) -> np.ndarray:
    """F(x, u) as a dense matrix (4N, 4N) on w = (V; z_1; z_2; z_3)."""
    at = fields_of(points, u)
    N = mesh.node_count
    result = np.zeros((4, N, 4, N))
    result[0, :, 0] = matrix(mesh, points, lambda p, i, j: -at[id(p)].A2 * p.phi[i] * p.phi[j])
    tensor = {key: f.H * f.A - f.A @ f.A for key, f in at.items()}
    for l, m in product(range(3), repeat=2):
        result[1 + l, :, 1 + m] = matrix(
            mesh, points, lambda p, i, j, l=l, m=m: tensor[id(p)][l, m] * p.phi[i] * p.phi[j]
        )
    return result.reshape(4 * N, 4 * N)


# The columns of w = (V; z_1; z_2; z_3) that a reaction takes from the new time level.
AT_NEW_LEVEL = {
    "implicit": (0, 1, 2, 3),
    "extrapolated": (),
    "linearised": (0,),
    "implicit-F1": (0,),
    "implicit-F2": (1, 2, 3),
}


def dQ_matrix(mesh: Mesh, points: list[Point], u: np.ndarray) -> np.ndarray:
    """int q phi_i phi_j, dense (N, N), with q = |A_h|^2 - H^2/2: Willmore's Q_h is q H."""
    at = fields_of(points, u)

    def entry(p: Point, i: int, j: int) -> float:
        return (at[id(p)].A2 - at[id(p)].H ** 2 / 2) * p.phi[i] * p.phi[j]

    return matrix(mesh, points, entry)


def step(
    mesh: Mesh,
    history: list[tuple[np.ndarray, np.ndarray, np.ndarray]],
    tau: float,
    delta: list[float],
    gamma: list[float],
    theta: np.ndarray,
    project: bool,
    reaction: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, u, w after one linearly implicit BDF step from (x, u, w) at t - tau, t - 2 tau, ...

    The whole 8N x 8N matrix, dense; theta (N, 4).
    """
    N = mesh.node_count
    x_ext = sum(g * x for g, (x, _, _) in zip(gamma, history, strict=True))
    u_ext = sum(g * u for g, (_, u, _) in zip(gamma, history, strict=True))
    w_ext = sum(g * w for g, (_, _, w) in zip(gamma, history, strict=True))
    if project:
        for j in range(N):
            u_ext[j, 1:] /= np.linalg.norm(u_ext[j, 1:])
    points = list(points_of(mesh, x_ext))
    M, A = mass(mesh, points), stiffness(mesh, points)
    M4, A4, F = np.kron(np.eye(4), M), np.kron(np.eye(4), A), F_matrix(mesh, points, u_ext)
    f = np.column_stack([np.zeros(N), f2(mesh, points, u_ext)])
    g = np.column_stack([g1(mesh, points, u_ext), g2(mesh, points, u_ext)]) + theta
    u_past = sum(d * u for d, (_, u, _) in zip(delta[1:], history, strict=True))
    x_past = sum(d * x for d, (x, _, _) in zip(delta[1:], history, strict=True))
    F_new = np.zeros_like(F)
    for column in AT_NEW_LEVEL[reaction]:
        F_new[:, column * N : (column + 1) * N] = F[:, column * N : (column + 1) * N]
    F_w_ext = ((F - F_new) @ w_ext.T.ravel()).reshape(4, N).T
    dQ = np.zeros_like(A4)
    if reaction == "linearised":
        dQ[:N, :N] = dQ_matrix(mesh, points, u_ext)
        g[:, 0] -= dQ[:N, :N] @ u_ext[:, 0]
    whole = np.block([[delta[0] / tau * M4, -(A4 + F_new)], [A4 - dQ, M4]])
    right = np.concatenate([(f + F_w_ext - M @ u_past / tau).T.ravel(), g.T.ravel()])
    u, w = np.linalg.solve(whole, right).reshape(2, 4, N).transpose(0, 2, 1)
    if project:
        for j in range(N):
            u[j, 1:] /= np.linalg.norm(u[j, 1:])
            w[j, 1:] -= (w[j, 1:] @ u[j, 1:]) * u[j, 1:]
    v = np.array([w[j, 0] * u[j, 1:] for j in range(N)])
    return (tau * v - x_past) / delta[0], u, w
