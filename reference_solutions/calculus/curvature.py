"""Curvatures of a level set phi = 0 from the derivatives of phi.

Letters: p, pp, ppp, pppp are the derivatives of phi of order 1 to 4, the axis of the points, n,
last: (3, n), (3, 3, n), ... Further q = |p|^2, L = Lap phi, B = p.pp.p, and

    H = div(p/|p|) = F q^{-3/2},  F = L q - B.

Indices k, l behind a letter are its derivatives in space.
"""

import numpy as np

from esfem.reference_solutions.exact import Array


def normal_and_shape(p: Array, pp: Array) -> tuple[Array, Array]:
    """nu = p/|p| (3, n) and S = P pp P / |p| (3, 3, n), with P = I - nu nu^T."""
    length = np.sqrt((p * p).sum(0))
    nu = p / length
    P = projection(nu)
    return nu, symmetric(matmul(matmul(P, pp), P)) / length


def all_fields(p: Array, pp: Array, ppp: Array, pppp: Array) -> tuple[Array, ...]:
    """nu, H, z, S, grad_z, Lap_Gamma H.

    With h = grad H and hh = D^2 H in space and P = I - nu nu^T,

        z = P h,  grad_Gamma z = P hh P - (nu.h) S - (S z) nu^T,  Lap_Gamma H its trace.
    """
    nu, S = normal_and_shape(p, pp)
    H, h, hh = mean_curvature(p, pp, ppp, pppp)
    P = projection(nu)
    z, h_nu = matvec(P, h), (nu * h).sum(0)
    tangential = symmetric(matmul(matmul(P, hh), P)) - h_nu * S
    grad_z = tangential - outer(matvec(S, z), nu)
    return nu, H, z, S, grad_z, np.einsum("aan->n", tangential)


def mean_curvature(p: Array, pp: Array, ppp: Array, pppp: Array) -> tuple[Array, Array, Array]:
    """H (n,), grad H (3, n) and D^2 H (3, 3, n) in space."""
    q, q_k, q_kl = squared_length(p, pp, ppp)
    F, F_k, F_kl = numerator(p, pp, ppp, pppp)
    r = q**-1.5  # H = F r
    r_k, r_kl = -1.5 * r / q * q_k, r / q * (3.75 / q * outer(q_k, q_k) - 1.5 * q_kl)
    H_kl = F_kl * r + outer(F_k, r_k) + outer(r_k, F_k) + F * r_kl
    return F * r, F_k * r + F * r_k, H_kl


def squared_length(p: Array, pp: Array, ppp: Array) -> tuple[Array, Array, Array]:
    """q = |p|^2 and its derivatives."""
    p_ppp = np.einsum("an,akln->kln", p, ppp)
    return (p * p).sum(0), 2.0 * matvec(pp, p), 2.0 * (matmul(pp, pp) + p_ppp)


def numerator(p: Array, pp: Array, ppp: Array, pppp: Array) -> tuple[Array, Array, Array]:
    """F = L q - B and its derivatives."""
    q, q_k, q_kl = squared_length(p, pp, ppp)
    L, L_k, L_kl = (np.einsum(f"aa{i}n->{i}n", d) for i, d in (("", pp), ("k", ppp), ("kl", pppp)))
    w = matvec(pp, p)
    C = np.einsum("an,akln->kln", p, ppp)
    pp_C = matmul(pp, C)
    B = (p * w).sum(0)
    B_k = 2.0 * matvec(pp, w) + matvec(C, p)
    B_kl = 2.0 * (np.einsum("an,akln->kln", w, ppp) + matmul(pp, matmul(pp, pp)))
    B_kl += 2.0 * (pp_C + transpose(pp_C))
    B_kl += np.einsum("an,akln->kln", p, np.einsum("bn,abkln->akln", p, pppp))
    F_kl = L_kl * q + outer(L_k, q_k) + outer(q_k, L_k) + L * q_kl - B_kl
    return L * q - B, L_k * q + L * q_k - B_k, F_kl


def projection(nu: Array) -> Array:
    """I - nu nu^T."""
    return np.eye(3)[:, :, None] - outer(nu, nu)


def outer(a: Array, b: Array) -> Array:
    """a_i b_j, (3, 3, n)."""
    return a[:, None] * b[None]


def matvec(A: Array, b: Array) -> Array:
    """A_ij b_j, (3, n)."""
    return np.einsum("ijn,jn->in", A, b)


def matmul(A: Array, B: Array) -> Array:
    """A_ij B_jk, (3, 3, n)."""
    return np.einsum("ijn,jkn->ikn", A, B)


def transpose(A: Array) -> Array:
    """A_ji, (3, 3, n)."""
    return np.swapaxes(A, 0, 1)


def symmetric(A: Array) -> Array:
    """(A + A^T) / 2, free of the asymmetry of rounding."""
    return 0.5 * (A + transpose(A))


def adjugate(A: Array) -> tuple[Array, Array]:
    """The adjugate of symmetric A (3, 3, n), and its determinant (n,)."""
    a, b, c = A
    adj = np.stack([np.cross(s, t, axis=0) for s, t in ((b, c), (c, a), (a, b))])
    return adj, (a * adj[0]).sum(0)
