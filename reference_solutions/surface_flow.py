"""The flow of a named surface: its start is exact, what follows is known from other computations.

The reference for t > 0 is either the finest level of the same study, or, for surfaces of
revolution, the axisymmetric solver of `esfem.reference_solutions.axisymmetric`; or there is none,
and only the "start" is looked at, or what holds of any surface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from esfem.reference_solutions import laws
from esfem.reference_solutions.axisymmetric import ProfileFlow, evolve_profile
from esfem.reference_solutions.exact import Array, StartFields, length_of
from esfem.reference_solutions.surfaces import named_surface

REFERENCES = ("finest", "axisymmetric", "start")


@dataclass(frozen=True)
class SurfaceFlow:
    """The flow that starts from the surface named ``surface``, with errors against ``reference``.

    Raises
    ------
    ValueError
        If there is no such surface or reference, or the surface has no profile and the reference is
        the axisymmetric one.
    """

    surface: str
    reference: str = "finest"
    name: ClassVar[str] = "surface"
    title: ClassVar[str] = "flow of a named surface, without exact solution"
    laws: ClassVar[tuple[str, ...]] = tuple(laws.ALL)
    stationary: ClassVar[bool] = False
    always_exact: ClassVar[bool] = False
    measures: ClassVar[tuple[str, ...]] = ()
    scale: ClassVar[float] = 1.0
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        if self.reference not in REFERENCES:
            allowed = ", ".join(REFERENCES)
            raise ValueError(f"reference = {self.reference!r}: must be one of {allowed}")
        surface = named_surface(self.surface)
        if self.reference == "axisymmetric" and surface.profile is None:
            raise ValueError(
                f"reference = 'axisymmetric': surface {self.surface!r} gives no profile curve"
            )

    @property
    def mesh_surface(self) -> str:
        return self.surface

    @property
    def length(self) -> float:
        return length_of(named_surface(self.surface).area)

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    def forcing(self, law: str, parameters: Mapping[str, float]) -> None:
        laws.check(law, parameters, laws.ALL)

    def closest_point(self, x: Array, t: float = 0.0) -> Array:
        return named_surface(self.surface).closest_point(x)

    def fields(self, y: Array, t: float = 0.0) -> StartFields:
        return named_surface(self.surface).fields(y)

    def profile_flow(
        self, law: str, parameters: Mapping[str, float], times: Sequence[float]
    ) -> ProfileFlow:
        """The axisymmetric flow at the times, the first of which is 0; computed once a process."""
        return _profile_flow(
            self.surface, law, parameters.get("spontaneous_curvature", 0.0), tuple(times)
        )


@lru_cache
def _profile_flow(surface: str, law: str, H0: float, times: tuple[float, ...]) -> ProfileFlow:
    profile = named_surface(surface).profile
    if profile is None:
        raise ValueError(f"surface {surface!r} gives no profile curve")
    return evolve_profile(profile(), law, times, H0)
