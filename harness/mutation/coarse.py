"""The set of studies that tries a mutant: default studies, on fewer cells."""

from collections.abc import Sequence
from dataclasses import dataclass

from harness.study import STUDIES, Study, load_study


@dataclass(frozen=True)
class Coarse:
    """A default study with another sweep; what is None stays as it is there.

    Where the study has times of comparison, the final time is the only one. ``superconvergent``
    variables are so on the coarse meshes, beside those of the study.
    """

    name: str
    vertices: tuple[int, ...] | None = None
    tau: tuple[float, ...] | None = None
    final_time: float | None = None
    superconvergent: tuple[str, ...] = ()

    def study(self) -> Study:
        """The study, checked like any other."""
        study = load_study(STUDIES / f"{self.name}.toml")
        sweep = study.sweep.model_dump()
        for key in ("vertices", "tau"):
            sweep[key] = list(getattr(self, key) or sweep[key])
        if self.final_time is not None:
            sweep["final_time"] = self.final_time
            sweep["compare_at"] = [self.final_time] if sweep["compare_at"] else []
        about = study.study.model_dump()
        about["superconvergent"] += self.superconvergent
        return Study.model_validate({**study.model_dump(), "study": about, "sweep": sweep})


# The cheapest and most revealing first,
SET: tuple[Coarse, ...] = (
    Coarse("theta-at-rest"),
    Coarse("error-size"),
    Coarse("decay-sphere-2", vertices=(30, 60, 120, 240), tau=(0.0025,)),
    Coarse(
        "clifford",
        vertices=(60, 120, 240, 480, 960),
        tau=(0.0125,),
        final_time=0.125,
        superconvergent=("x",),
    ),
    Coarse("error-size-helfrich"),
    Coarse("error-size-linearised"),
    Coarse("sphere-degree-3", vertices=(30, 60, 120, 240, 480), final_time=0.125),
    Coarse("growth-projected", vertices=(30, 60, 120, 240), tau=(0.02,)),
    Coarse(
        "axisymmetric-ellipsoid-surface-diffusion",
        vertices=(60, 120, 240, 480),
        tau=(0.002,),
        final_time=0.02,
    ),
    Coarse("ellipsoid-degree-2", vertices=(60, 120, 240, 480, 960), tau=(0.01,)),
    Coarse("growth-unprojected", tau=(0.01,)),
)
# except where a group has its own.
FIRST = {
    "forms": "decay-sphere-2",
    "projection": "growth-projected",
    **dict.fromkeys(("errors", "law", "peers", "time"), "error-size"),
}


def coarse_studies(names: Sequence[str] = ()) -> tuple[Study, ...]:
    """The studies of the set, or those of these names, in the order in which they are tried."""
    return tuple(coarse.study() for coarse in SET if not names or coarse.name in names)
