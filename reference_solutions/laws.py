"""The velocity laws V = Lap_Gamma H + Q a second time, independent of those of the solver."""

from collections.abc import Mapping
from typing import TypeVar

from esfem.reference_solutions.exact import Array, StartFields

Numbers = TypeVar("Numbers", float, Array)

# Name of the law -> names of its parameters.
PARAMETERS: dict[str, tuple[str, ...]] = {
    "willmore": (),
    "helfrich": ("spontaneous_curvature",),
    "surface_diffusion": (),
}
# The law of second order, V = -H, which is no V = Lap H + Q.
MEAN_CURVATURE = "mean_curvature"
ALL = {**PARAMETERS, MEAN_CURVATURE: ()}


def Q(law: str, parameters: Mapping[str, float], H: Numbers, S2: Numbers) -> Numbers:
    """The nonlinear part of the velocity, from the mean curvature H (...) and |S|^2 (...).

    - willmore: -H^3/2 + |S|^2 H, gradient flow of 1/2 int H^2;
    - helfrich: |S|^2 (H - H0) - H (H - H0)^2 / 2, gradient flow of 1/2 int (H - H0)^2, with
      H0 = ``spontaneous_curvature``;
    - surface_diffusion: 0.

    Raises
    ------
    ValueError
        If there is no such law, or its parameters are not those given.
    """
    check(law, parameters)
    if law == "willmore":
        return H * (S2 - H**2 / 2)
    if law == "helfrich":
        H0 = parameters["spontaneous_curvature"]
        return (H - H0) * (S2 - H * (H - H0) / 2)
    return 0.0 * H


def q(law: str, parameters: Mapping[str, float], H: Numbers, S2: Numbers) -> Numbers:
    """The part of Q that is multiplied by H: Q = q H + r.

    - willmore: |S|^2 - H^2/2, r = 0;
    - helfrich: |S|^2 - (H - H0)^2/2, r = -H0 |S|^2;
    - surface_diffusion: 0, r = 0.

    Raises
    ------
    ValueError
        As `Q`.
    """
    check(law, parameters)
    if law == "surface_diffusion":
        return 0.0 * H
    return S2 - (H - parameters.get("spontaneous_curvature", 0.0)) ** 2 / 2


def velocity(law: str, parameters: Mapping[str, float], fields: StartFields) -> Array:
    """V = Lap_Gamma H + Q, or -H: the velocity (...) that the unforced law gives a surface."""
    if law == MEAN_CURVATURE:
        return -fields.H
    S2 = (fields.S**2).sum(axis=(-2, -1))
    return fields.laplace_H + Q(law, parameters, fields.H, S2)


def check(
    law: str, parameters: Mapping[str, float], among: Mapping[str, tuple[str, ...]] = PARAMETERS
) -> None:
    """Raise ValueError unless the law is known and given exactly the parameters it takes."""
    if law not in among:
        raise ValueError(f"law = {law!r}: must be one of {', '.join(among)}")
    if set(parameters) != set(among[law]):
        takes = ", ".join(among[law]) or "none"
        raise ValueError(f"parameters = {dict(parameters)!r}: law {law!r} takes {takes}")


def check_unforced(
    name: str,
    laws: tuple[str, ...],
    needed: Mapping[str, float],
    law: str,
    parameters: Mapping[str, float],
) -> None:
    """Raise ValueError unless the solution ``name`` solves the law as it stands, without forcing.

    ``laws`` are the laws that it solves and ``needed`` the parameters they must have.
    """
    check(law, parameters, ALL)
    if law not in laws:
        raise ValueError(f"law = {law!r}: solution {name!r} solves {', '.join(laws)}")
    for key, value in parameters.items():
        if value != needed[key]:
            raise ValueError(f"{key} = {value!r}: must be {needed[key]!r} for solution {name!r}")
