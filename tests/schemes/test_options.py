"""Every option of [scheme], from a study file and from a flow file to the scheme that is run."""

from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import numpy as np
import pytest
from rich.console import Console
from studies import BDF_LINES, SMALL, SMALL_FLOW, write_varied

import esfem.flows.evolution
import esfem.schemes.kll
from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import FlowFile, describe_flow, load_flow
from esfem.flows.start import exact_start
from esfem.meshes import surface_mesh
from esfem.report.write import write_report
from esfem.results.run_studies import run_studies
from esfem.runs.problem import problem_of
from esfem.runs.run_case import computational_mesh
from esfem.runs.stepping import states
from esfem.schemes import SchemeOptions, named_scheme, scheme_names
from esfem.solver import Scheme, State
from esfem.studies.study import Study, load_study
from esfem.studies.words import asked, describe, options

# Of each option of each scheme values of which no two may give the same numbers: of switches and
# words all that are allowed.
EVERY = {"degree": (1, 2), "quadrature": (4, 9)}
VALUES: dict[str, dict[str, tuple[Any, ...]]] = {
    "kll": {
        **EVERY,
        "bdf": (1, 2),
        "project": (True, False, "nu"),
        "theta": (True, False),
        "start": ("exact", "self"),
        "tolerance": (1e-10, 1e-3),
        "velocity": ("interpolated", "ritz"),
        "reaction": ("implicit", "extrapolated", "linearised"),
    },
    "kll-mcf": {
        **EVERY,
        "bdf": (1, 2),
        "start": ("exact", "self"),
        "velocity": ("interpolated", "ritz"),
    },
    "dziuk": EVERY,
    "bgn": EVERY,
}
# Not of `esfem.solver.Scheme`: the mesh has the degree, and `evolve` is told where to start.
BESIDE_THE_SCHEME = ("degree", "start")
NOT_OF_FLOWS = {"start": "must be 'self'"}
CASES = [(name, option) for name, values in VALUES.items() for option in values]
each_case = pytest.mark.parametrize(("name", "option"), CASES)

SOLUTIONS = {"mean_curvature": "shrinking_sphere", "willmore": "breathing_ellipsoid"}
NEEDED = {"bdf": 2, "project": True, "theta": False, "reaction": "implicit"}
TAU, STEPS = 1e-3, 3


def toml(value: Any) -> str:
    """A value as a TOML file has it."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def scheme_table(name: str, **changes: Any) -> str:
    """The lines of [scheme]."""
    needed = {key: value for key, value in NEEDED.items() if key in VALUES[name]}
    given = {"name": name, "degree": 2, **needed, **changes}
    return "\n".join(f"{key} = {toml(value)}" for key, value in given.items())


LINES = "degree = 2\nbdf = 2\nproject = true\ntheta = false"


def study_of(folder: Path, name: str, **changes: Any) -> Study:
    """A study of one run of the scheme, its options changed."""
    law = "willmore" if "willmore" in named_scheme(name).laws else "mean_curvature"
    return load_study(
        write_varied(
            folder / "study.toml",
            SMALL,
            (f"degree = 2\n{BDF_LINES}", scheme_table(name, **changes)),
            ('claim = "section-7"\nsuperconvergent = { x = "A", nu = "B", H = "C" }\n', ""),
            ('name = "sphere"\nradius = 1.0', f'name = "{SOLUTIONS[law]}"'),
            ('name = "willmore"', f'name = "{law}"'),
            ("vertices = [30, 60, 120, 240, 480]", "vertices = [60]"),
            ("tau = [0.25, 0.125]", f"tau = [{TAU}]"),
            ("final_time = 0.5", f"final_time = {STEPS * TAU}"),
        )
    )


def flow_of(folder: Path, **changes: Any) -> FlowFile:
    """A flow of a few steps, its options changed."""
    return load_flow(
        write_varied(
            folder / "flow.toml",
            SMALL_FLOW,
            (LINES, scheme_table("kll", **changes)),
            ("every = 0.02\npictures = [0.0, 0.05]", ""),
            ("tau = 0.01", f"tau = {TAU}"),
            ("final_time = 0.06", f"final_time = {STEPS * TAU}"),
        )
    )


def state_of_study(study: Study) -> State:
    """The last State of its run."""
    (case,) = study.cases()
    solution = case.solution.initial()
    surface = surface_mesh(solution.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    *_, last = states(problem_of(case, mesh, p, solution), case.levels)
    return last


def state_of_flow(flow: FlowFile, folder: Path) -> State:
    """Its last State."""
    start = exact_start(flow, folder / "meshes", Console(quiet=True))
    *_, last = states(esfem.flows.evolution.problem_of(flow, start), flow.levels)
    return last


def differ(first: State, second: State) -> bool:
    """Whether two States are not the same to the last bit."""
    return any(
        not np.array_equal(getattr(first, name), getattr(second, name))
        for name in ("x", "nu", "H", "V", "z", "v")
    )


def all_differ(found: list[State]) -> bool:
    return all(differ(first, second) for first, second in combinations(found, 2))


@pytest.fixture
def scheme_used(monkeypatch) -> Callable[[Callable[[], State]], Scheme]:
    """The `Scheme` that a computation hands to `esfem.solver.evolve`."""
    seen: list[Scheme] = []
    true = esfem.schemes.kll.evolve

    def spy(mesh, initial, scheme, *rest, **named):
        seen.append(scheme)
        return true(mesh, initial, scheme, *rest, **named)

    monkeypatch.setattr(esfem.schemes.kll, "evolve", spy)

    def of(compute: Callable[[], State]) -> Scheme:
        compute()
        return seen.pop()

    return of


def words_allowed(options: type[SchemeOptions], name: str) -> set[Any]:
    """The switches and words that an option takes, as its type says; none for numbers."""

    def of(kind: Any) -> set[Any]:
        if kind is bool:
            return {True, False}
        if get_origin(kind) is Literal:
            return set(get_args(kind))
        return set().union(*map(of, get_args(kind)))

    return of(options.model_fields[name].annotation)


class TestWalk:
    def test_covers_every_option_of_every_scheme(self):
        assert tuple(sorted(VALUES)) == scheme_names()
        for name, values in VALUES.items():
            assert values.keys() == named_scheme(name).options.model_fields.keys() - {"name"}

    @each_case
    def test_covers_every_word_an_option_takes(self, name, option):
        assert words_allowed(named_scheme(name).options, option) <= set(VALUES[name][option])
        assert len(VALUES[name][option]) >= 2


class TestOptionsReachTheNumbers:
    @each_case
    def test_of_studies(self, name, option, tmp_path):
        values = VALUES[name][option]
        assert all_differ([state_of_study(study_of(tmp_path, name, **{option: v})) for v in values])

    @pytest.mark.parametrize("option", [o for o in VALUES["kll"] if o not in NOT_OF_FLOWS])
    def test_of_flows(self, option, tmp_path):
        values = VALUES["kll"][option]
        flows = [flow_of(tmp_path, **{option: value}) for value in values]
        assert all_differ([state_of_flow(flow, tmp_path) for flow in flows])

    @pytest.mark.parametrize("option", NOT_OF_FLOWS)
    def test_what_a_flow_cannot_take_is_refused(self, option, tmp_path):
        with pytest.raises(BadInput, match=NOT_OF_FLOWS[option]):
            flow_of(tmp_path, **{option: VALUES["kll"][option][0]})

    @pytest.mark.parametrize("option", [o for o in VALUES["kll"] if o not in BESIDE_THE_SCHEME])
    def test_studies_and_flows_make_the_same_scheme(self, option, scheme_used, tmp_path):
        found = []
        for value in VALUES["kll"][option]:
            study = study_of(tmp_path, "kll", **{option: value})
            flow = flow_of(tmp_path, **{option: value})
            of_study = scheme_used(lambda study=study: state_of_study(study))
            of_flow = scheme_used(lambda flow=flow: state_of_flow(flow, tmp_path))
            assert settings(of_study) == settings(of_flow)
            found.append(settings(of_flow))
        assert all(a != b for a, b in combinations(found, 2))


def settings(scheme: Scheme) -> dict[str, Any]:
    """All of a Scheme but its law."""
    return {name: value for name, value in vars(scheme).items() if name != "law"}


class TestOptionsAreTold:
    @each_case
    def test_of_studies(self, name, option, tmp_path):
        values = VALUES[name][option]
        told = {describe(study_of(tmp_path, name, **{option: value})) for value in values}
        assert len(told) == len(values)

    @pytest.mark.parametrize("option", [o for o in VALUES["kll"] if o not in NOT_OF_FLOWS])
    def test_of_flows(self, option, tmp_path):
        values = VALUES["kll"][option]
        told = {describe_flow(flow_of(tmp_path, **{option: value}), 1) for value in values}
        assert len(told) == len(values)

    def test_in_the_tables_and_reports_of_studies_and_flows(self, command, tmp_path):
        """Options that are seldom used, from the files to all that is made of them."""
        changes = {"project": "nu", "velocity": "ritz", "theta": True}
        study, flow = study_of(tmp_path, "kll", **changes), flow_of(tmp_path, **changes)
        told = asked(study.law, study.scheme)
        assert "projection of nu alone, theta on, reaction implicit, velocity ritz" in told
        assert asked(flow.law, flow.scheme) == told
        out = tmp_path / "out"
        run_studies([tmp_path / "study.toml"], out=out, jobs=1)
        words = (tmp_path / "flow.toml", "--out", out / "flows", "--no-pictures")
        assert command("flow", *words)[0] == 0
        write_report(out, out / "report")
        scheme = ", ".join(options(study.scheme))
        tex = " ".join(path.read_text() for path in (out / "report" / "tex").glob("*.tex"))
        for text in (
            (out / "small" / "table.md").read_text(),
            (out / "small" / "table.tex").read_text(),
        ):
            assert scheme in text
        for text in ((out / "report" / "index.html").read_text(), tex):
            assert text.count(scheme) >= 2  # of the study and of the flow
