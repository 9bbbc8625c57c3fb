"""Which studies and which flows the paper's experiments are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from harness.bad_input import BadInput
from harness.catalogue import paper_studies, study_path
from harness.flows.command import committed_flows
from harness.study import load_study

# Committed for other purposes too: the torus at moderate steps; beyond the paper theta at rest,
# moving surfaces, surface diffusion, another law.
REUSED = (
    "clifford",
    "clifford-degree-2",
    "theta-at-rest",
    *(f"ellipsoid-degree-{k}{theta}" for k in (2, 3, 4) for theta in ("", "-no-theta")),
    "helfrich-bdf2",
    "axisymmetric-ellipsoid-surface-diffusion",
)


@dataclass(frozen=True)
class Plan:
    """The study files and the flow files to run."""

    studies: tuple[Path, ...]
    flows: tuple[Path, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the studies, and then those of the flows."""
        return tuple(path.stem for path in (*self.studies, *self.flows))

    def only(self, names: Sequence[str]) -> "Plan":
        """The plan with these studies and flows alone.

        Raises
        ------
        BadInput
            If there is none of that name.
        """
        for name in names:
            if name not in self.names:
                raise BadInput(f"--only {name}: must be one of {', '.join(self.names)}")
        studies = tuple(path for path in self.studies if path.stem in names)
        return replace(
            self, studies=studies, flows=tuple(path for path in self.flows if path.stem in names)
        )


def committed_plan() -> Plan:
    """All that is committed below harness/studies/paper, and what is reused."""
    studies = (*paper_studies(), *(study_path(name) for name in REUSED))
    return Plan(tuple(studies), tuple(committed_flows().values()))


def plan_in(folder: Path) -> Plan:
    """FOLDER/*.toml as studies and FOLDER/flows/*.toml as flows.

    Raises
    ------
    BadInput
        If there is none, or a file is not named after its study.
    """
    plan = Plan(tuple(sorted(folder.glob("*.toml"))), tuple(sorted(folder.glob("flows/*.toml"))))
    if not plan.names:
        raise BadInput(f"--studies {folder}: holds neither STUDY.toml nor flows/FLOW.toml")
    for path in plan.studies:
        if load_study(path).name != path.stem:
            raise BadInput(f"{path}: must be named after its study, {load_study(path).name}.toml")
    return plan
