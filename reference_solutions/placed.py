"""Where a solution lies: its centre, about which the formulas of each class are written."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

import numpy as np

from esfem.reference_solutions.exact import Array, finite


@dataclass(frozen=True)
class Placed:
    """A surface or an evolution that lies about ``centre``, all its points moved there.

    A base class, for each solution is written about the origin and none knows of the centre: the
    methods named in `MOVED` are taken with points less the centre, and give points plus the centre.
    They must not call each other, or the centre is taken off twice.

    Raises
    ------
    ValueError
        If ``centre`` is not three finite numbers.
    """

    centre: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), kw_only=True)

    def __post_init__(self) -> None:
        given = tuple(self.centre)
        if len(given) != 3:
            raise ValueError(f"centre = {self.centre!r}: must be three numbers [x, y, z]")
        finite(**dict(zip(("centre[0]", "centre[1]", "centre[2]"), given, strict=True)))
        x, y, z = map(float, given)
        object.__setattr__(self, "centre", (x, y, z))

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        for name, moved in MOVED.items():
            if name in vars(cls):
                setattr(cls, name, moved(vars(cls)[name]))


Method = Callable[..., Any]


def _about(self: Placed, x: Array) -> Array:
    """The points x (..., 3) seen from the centre; themselves if that is the origin."""
    return x - np.array(self.centre) if any(self.centre) else x


def _back(self: Placed, x: Array) -> Array:
    """The points x (..., 3) about the centre in space."""
    return x + np.array(self.centre) if any(self.centre) else x


def _of_points(method: Method) -> Method:
    """What is made of points x, and is the same wherever these lie."""

    @wraps(method)
    def moved(self: Placed, x: Array, *rest: Any, **options: Any) -> Any:
        return method(self, _about(self, x), *rest, **options)

    return moved


def _to_points(method: Method) -> Method:
    """Points made of points x."""

    @wraps(method)
    def moved(self: Placed, x: Array, *rest: Any) -> Array:
        return _back(self, method(self, _about(self, x), *rest))

    return moved


def _trajectories(method: Method) -> Method:
    """Curves of points made of points p."""

    @wraps(method)
    def moved(self: Placed, p: Array) -> Callable[[float], Array]:
        X = method(self, _about(self, p))
        return lambda t: _back(self, X(t))

    return moved


def _forcing(method: Method) -> Method:
    """A function of points, or None."""

    @wraps(method)
    def moved(self: Placed, *of: Any) -> Callable[[Array, float], Array] | None:
        f = method(self, *of)
        return None if f is None else lambda x, t: f(_about(self, x), t)

    return moved


MOVED: dict[str, Callable[[Method], Method]] = {
    "closest_point": _to_points,
    "closest_point_derivative": _of_points,
    "fields": _of_points,
    "trajectories": _trajectories,
    "forcing": _forcing,
    "mode_amplitude": _of_points,
}
