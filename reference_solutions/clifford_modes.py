"""The linearised Willmore flow at the Clifford torus R = 1, r = 1/sqrt(2), and its eigenmodes."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from esfem.reference_solutions.exact import Array

POINTS = 64  # around the tube; Fourier coefficients fall like (sqrt(2) - 1)^k: 1e-12 at k = 32
NEUTRAL = 1e-6  # rates of neutral modes are roundings of 64^4, the least true one is 2.4


def linearised_operator(m: int, points: int = POINTS) -> Array:
    """L in psi_t = L psi for normal perturbations psi(theta) cos(m phi), (points, points).

    L psi is the variation of V = Lap H + Q along psi nu, psi given at equidistant theta:

        delta H     = -Lap psi - |S|^2 psi,
        delta |S|^2 = -2 <S, Hess psi> - 2 psi tr S^3,
        (delta Lap) H = -2 psi <S, Hess H> - (2 S grad psi + psi grad H - H grad psi) . grad H,
        delta Q     = (|S|^2 - 3 H^2 / 2) delta H + H delta |S|^2,

    where delta g = 2 psi S changes the Laplacian. <S, Hess> has no mixed part, for S is diagonal.
    """
    R, r = 1.0, np.sqrt(0.5)
    theta = 2.0 * np.pi * np.arange(points) / points
    k = np.fft.fftfreq(points, 1.0 / points)
    transform = np.fft.fft(np.eye(points), axis=0)
    # Odd derivatives drop the highest frequency, which has no sine.
    odd = np.where(2 * np.abs(k) == points, 0.0, k)
    d1 = np.fft.ifft(1j * odd[:, None] * transform, axis=0).real
    d2 = np.fft.ifft(-(k**2)[:, None] * transform, axis=0).real

    c, s = np.cos(theta), np.sin(theta)
    rho = R + r * c
    kappa = c / rho
    H, S2, S3 = 1.0 / r + kappa, 1.0 / r**2 + kappa**2, 1.0 / r**3 + kappa**3
    dH = -R * s / (r * rho**2)  # grad H = dH e_theta
    ddH = -R * (c / rho**2 + 2.0 * r * s**2 / rho**3) / r**2

    def times(a: Array) -> Array:
        return np.diag(a)

    # Hess psi along and across the meridian.
    along = d2 / r**2
    across = -times(m**2 / rho**2) - times(s / (r * rho)) @ d1
    laplace = along + across
    grad = d1 / r
    delta_H = -laplace - times(S2)
    delta_S2 = -2.0 * (along / r + times(kappa) @ across) - 2.0 * times(S3)
    delta_laplace_H = (
        -2.0 * times(ddH / r - kappa * s * dH / rho)
        - times((2.0 / r - H) * dH) @ grad
        - times(dH**2)
    )
    delta_Q = times(S2 - 1.5 * H**2) @ delta_H + times(H) @ delta_S2
    return laplace @ delta_H + delta_laplace_H + delta_Q


@cache
def decaying_modes(m: int) -> tuple[tuple[float, Array], ...]:
    """The two slowest decaying modes of angular number m: (rate, coefficients).

    The mode is psi(theta) = Re sum_k coefficients[k] e^{ik theta}, with max |psi| = 1 and the
    greatest coefficient positive; it decays like exp(-rate t).
    """
    values, vectors = np.linalg.eig(linearised_operator(m))
    slowest = [i for i in np.argsort(-values.real) if -values[i].real > NEUTRAL][:2]
    return tuple((float(-values[i].real), _normalised(vectors[:, i].real)) for i in slowest)


def _normalised(psi: Array) -> Array:
    """The coefficients of the mode with these nodal values (points,)."""
    n = len(psi) // 2
    coefficients = np.fft.rfft(psi)[:n] / len(psi)
    coefficients[1:] *= 2.0
    coefficients[np.abs(coefficients) < 1e-13 * np.abs(coefficients).max()] = 0.0
    # The modes are even or odd: sum a_k cos(k theta), or sum b_k sin(k theta) with -i b_k here.
    parts = coefficients.real if _is_even(coefficients) else 1j * coefficients.imag
    fine = np.exp(1j * np.outer(2.0 * np.pi * np.arange(1024) / 1024, np.arange(n))) @ parts
    greatest = parts[np.argmax(np.abs(parts))]
    return parts / (np.abs(fine.real).max() * np.sign(greatest.real - greatest.imag))


def _is_even(coefficients: NDArray[np.complex128]) -> bool:
    return np.abs(coefficients.real).max() > np.abs(coefficients.imag).max()
