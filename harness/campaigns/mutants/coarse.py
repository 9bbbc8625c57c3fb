"""The set of studies that tries a mutant: default studies, on fewer cells, by `coarse.toml`."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from esfem.studies.study import STUDIES, Study, load_study


@dataclass(frozen=True)
class Coarse:
    """A default study with another sweep; what is None stays as it is there.

    Where the study has times of comparison, the final time is the only one. ``superconvergent``
    variables are so on the coarse meshes, beside those of the study.
    """

    name: str
    vertices: list[int] | None = None
    tau: list[float] | None = None
    final_time: float | None = None
    superconvergent: Sequence[str] = ()

    def study(self) -> Study:
        """The study, checked like any other."""
        study = load_study(STUDIES / f"{self.name}.toml")
        sweep = study.sweep.model_dump()
        for key in ("vertices", "tau"):
            sweep[key] = getattr(self, key) or list(sweep[key])
        if self.final_time is not None:
            sweep["final_time"] = self.final_time
            sweep["compare_at"] = [self.final_time] if sweep["compare_at"] else []
        about = study.study.model_dump()
        about["superconvergent"] += self.superconvergent
        return Study.model_validate({**study.model_dump(), "study": about, "sweep": sweep})


_TOLD = tomllib.loads(Path(__file__).with_name("coarse.toml").read_text(encoding="utf-8"))
SET = tuple(Coarse(**told) for told in _TOLD["study"])
FIRST: dict[str, str] = _TOLD["first"]  # the study that a group of mutants is tried by first


def coarse_studies(names: Sequence[str] = ()) -> tuple[Study, ...]:
    """The studies of the set, or those of these names, in the order in which they are tried."""
    return tuple(coarse.study() for coarse in SET if not names or coarse.name in names)
