"""Which studies, which flows and which program the paper's experiments are."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from esfem.common.bad_input import BadInput
from esfem.studies.catalogue import committed_flows, long_studies, paper_studies, study_path
from esfem.studies.study import load_study

# Committed for other purposes too: the torus at moderate steps; what the theorem and its proof say
# of the torus and of moving surfaces; beyond the paper theta at rest, surface diffusion, another
# law.
REUSED = (
    "clifford",
    "clifford-degree-2",
    "clifford-unprojected",
    "clifford-degree-3",
    "theta-at-rest",
    "start-torus-with-theta",
    *(f"start-torus-degree-{k}" for k in (2, 3, 4)),
    *(f"start-ellipsoid-degree-{k}" for k in (3, 4)),
    *(f"defects-ellipsoid-degree-{k}" for k in (3, 4)),
    "flow-map-ellipsoid",
    "flow-map-ellipsoid-degree-3",
    *(f"ellipsoid-degree-{k}{theta}" for k in (2, 3, 4) for theta in ("", "-no-theta")),
    "helfrich-bdf2",
    "axisymmetric-ellipsoid-surface-diffusion",
)
ABLATION = "ablation"
# What the extra tables are made from that sentences name.
NEEDED: dict[str, tuple[str, ...]] = {
    "figure-2-normalisation": (),
    "figure-4-growth": ("paper-torus", "paper-torus-bdf2"),
}


@dataclass(frozen=True)
class Plan:
    """The study files and the flow files to run, and whether to run the ablation."""

    studies: tuple[Path, ...]
    flows: tuple[Path, ...]
    ablation: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the studies, those of the flows, and that of the ablation."""
        files = tuple(path.stem for path in (*self.studies, *self.flows))
        return (*files, ABLATION) if self.ablation else files

    def only(self, names: Sequence[str]) -> "Plan":
        """The plan with these experiments alone.

        Raises
        ------
        BadInput
            If there is none of that name.
        """
        for name in names:
            if name not in self.names:
                raise BadInput(f"--only {name}: must be one of {', '.join(self.names)}")
        return Plan(
            tuple(path for path in self.studies if path.stem in names),
            tuple(path for path in self.flows if path.stem in names),
            ABLATION in names,
        )


def committed_plan(long: bool = False) -> Plan:
    """All that is committed below harness/studies/paper, what is reused, and the ablation; the
    ``long`` studies on request alone."""
    studies = (*paper_studies(), *(study_path(name) for name in REUSED))
    further = long_studies() if long else ()
    return Plan((*studies, *further), tuple(committed_flows().values()), ablation=True)


def plan_in(folder: Path, long: bool = False) -> Plan:
    """FOLDER/*.toml as studies and FOLDER/flows/*.toml as flows; FOLDER/long/*.toml on request.

    Raises
    ------
    BadInput
        If there is none, or a file is not named after its study.
    """
    further = sorted(folder.glob("long/*.toml")) if long else ()
    studies = (*sorted(folder.glob("*.toml")), *further)
    plan = Plan(studies, tuple(sorted(folder.glob("flows/*.toml"))))
    if not plan.names:
        raise BadInput(f"--studies {folder}: holds neither STUDY.toml nor flows/FLOW.toml")
    for path in plan.studies:
        if load_study(path).name != path.stem:
            raise BadInput(f"{path}: must be named after its study, {load_study(path).name}.toml")
    return plan
