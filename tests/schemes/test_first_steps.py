"""``first_steps``: each of the first q steps of BDF q in substeps, in studies and flows."""

import numpy as np
import pytest
from studies import BDF_LINES, SMALL_FLOW, small_study, write_study, write_varied

from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import load_flow
from esfem.meshes import surface_mesh
from esfem.reference_solutions import HelfrichSphere, ShrinkingSphere
from esfem.reference_solutions.discrete import RadialRun
from esfem.results.records import record_row, run_errors
from esfem.runs.run_case import Record, run_case
from esfem.runs.store import content
from esfem.schemes import named_scheme, scheme_names
from esfem.studies.case import Case
from esfem.studies.quantities import SIZES
from esfem.studies.study import STUDIES, load_study
from esfem.studies.words import describe

MOVING = [
    ('name = "sphere"\nradius = 1.0', 'name = "helfrich_sphere"'),
    ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0'),
    ('claim = "section-7"', ""),
    ("bdf = 2", 'bdf = 2\nstart = "self"'),
    ("tau = [0.25, 0.125]", "tau = [0.05]"),
]


def computed(case: Case) -> Record:
    surface = surface_mesh(case.solution.initial().mesh_surface, case.vertices)
    return run_case(case, surface)[0]


def moving(tmp_path, first_steps: int, *more: tuple[str, str]) -> Case:
    said = ("final_time = 0.5", f"final_time = 0.5\nfirst_steps = {first_steps}")
    return load_study(write_study(tmp_path, *MOVING, said, *more)).cases()[0]


class TestOfAStudy:
    def test_levels_are_the_substeps_and_then_whole_steps(self, tmp_path):
        """BDF2, tau = 0.05, five substeps: all of them are measured, and counted as steps."""
        case = moving(tmp_path, 5)
        record = computed(case)
        times = [*(0.01 * np.arange(11)), *(0.05 * np.arange(3, 11))]
        np.testing.assert_allclose(record.t, times, rtol=1e-14, atol=0)
        row = record_row("small", "key", record)
        assert row["steps"] == case.steps == 18
        assert row["tau"] == 0.05
        assert len(record.iterations) == 18 and len(record.h1()["x"]) == 19

    def test_one_is_as_if_nothing_had_been_said(self, tmp_path):
        """Also in the key of the record."""
        without = load_study(write_study(tmp_path, *MOVING)).cases()[0]
        assert content(moving(tmp_path, 1), "mesh") == content(without, "mesh")
        assert content(moving(tmp_path, 2), "mesh") != content(without, "mesh")

    def test_a_case_is_read_back_from_its_record(self, tmp_path):
        case = moving(tmp_path, 3)
        assert Case.model_validate(case.model_dump(mode="json")) == case

    @pytest.mark.parametrize("first_steps", [1, 4])
    def test_errors_are_those_of_the_recursion(self, first_steps):
        """BDF3 on a growing sphere, where the scheme is a recursion for R, H and V: V = 60, within
        2e-3. With the other number of substeps the errors are others by a fifth at least."""
        case = load_study(STUDIES / "error-size.toml").cases()[0]
        case = case.model_copy(update={"first_steps": first_steps, "vertices": 60})
        found = run_errors(computed(case))
        assert all(found[f"err_{size}"] < 2e-3 for size in SIZES)
        other = case.model_copy(update={"first_steps": 5 - first_steps})
        different = known_errors(other)
        assert all(abs(found[f"err_{name}"] / different[name] - 1) > 0.2 for name in ("x", "H"))

    def test_times_of_comparison_are_found_among_them(self, tmp_path):
        case = load_study(
            small_study(
                tmp_path,
                *MOVING[1:4],
                ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "p2_sphere"'),
                ('surface = "p2_sphere"', 'surface = "p2_sphere"\nreference = "axisymmetric"'),
                ("tau = [0.01]", "tau = [0.01]\ncompare_at = [0.01, 0.05]\nfirst_steps = 3"),
                vertices=[120],
                tau=[0.01],
                final_time=0.05,
            )
        ).cases()[0]
        assert computed(case).compared["t"] == [0.01, 0.05]

    def test_it_is_told(self, tmp_path):
        moving(tmp_path, 4)
        words = describe(load_study(tmp_path / "study.toml"))
        assert "start self, each of the first 2 steps in 4 substeps, T = 0.5" in words

    def test_mean_curvature_flow_takes_them_too(self):
        """BDF2 on a shrinking sphere, self-started: its area at order 2, with smaller errors."""
        plain, divided = (mcf_errors_of_area(first_steps) for first_steps in (1, 4))
        assert np.log2(plain[0] / plain[1]) == pytest.approx(2.0, abs=0.25)
        assert np.log2(divided[0] / divided[1]) == pytest.approx(2.0, abs=0.25)
        assert all(small < 0.6 * large for small, large in zip(divided, plain, strict=True))

    def test_a_scheme_with_equal_steps_does_not_take_them(self):
        assert [n for n in scheme_names() if named_scheme(n).substeps] == ["kll", "kll-mcf"]


def mcf_errors_of_area(first_steps: int) -> list[float]:
    """At t = 0.1 with tau = 0.01 and 0.005; P4 on V = 60 has an error in space of 2e-5."""
    errors = []
    for tau in (0.01, 0.005):
        plain = {
            "solution": {"name": "shrinking_sphere"},
            "law": {"name": "mean_curvature"},
            "scheme": {"name": "kll-mcf", "degree": 4, "bdf": 2, "start": "self"},
            "vertices": 60,
            "tau": tau,
            "final_time": 0.1,
            "first_steps": first_steps,
        }
        record = computed(Case.model_validate(plain))
        assert len(record.t) - 1 == round(0.1 / tau) + 2 * (first_steps - 1)
        area = 4.0 * np.pi * ShrinkingSphere().radius_at(0.1) ** 2
        errors.append(abs(record.levels["area"][-1] - area))
    return errors


def known_errors(case: Case) -> dict[str, float]:
    return RadialRun(
        case.solution.initial(),
        "willmore",
        {},
        3,
        case.tau,
        10,
        True,
        case.scheme.reaction,
        case.first_steps,
    ).errors()


@pytest.mark.parametrize("q", [1, 2, 3, 4])
def test_the_recursion_keeps_the_order_of_the_method(q):
    """On the Helfrich sphere, within 0.25: rates rise towards q."""
    law = ("helfrich", {"spontaneous_curvature": 1.0})
    errors = [
        RadialRun(HelfrichSphere(1.0, 1.0), *law, q, 1.0 / n, n, True, "implicit", 4).errors()
        for n in (160, 320)
    ]
    for name in ("x", "H", "V"):
        assert np.log2(errors[0][name] / errors[1][name]) == pytest.approx(q, abs=0.25), name


class TestOfAFlow:
    def test_frames_and_pictures_are_at_their_times(self, tmp_path):
        said = ("final_time = 0.06", "final_time = 0.06\nfirst_steps = 3")
        flow = load_flow(write_varied(tmp_path / "flow.toml", SMALL_FLOW, said))
        assert flow.levels.steps == 10
        assert flow.framed == [0, 6, 8, 9, 10]
        assert [flow.levels.t(n) for n in flow.framed] == [0.0, 0.02, 0.04, 0.05, 0.06]
        assert flow.pictured == [0, 9]


REFUSED = [
    ((), "first_steps = 4: is for a run that starts itself; solution 'sphere' gives exact start"),
    (
        [("theta = false", 'theta = false\nstart = "exact"')],
        "first_steps = 4: is for a run that starts itself",
    ),
    (
        [
            (BDF_LINES, 'name = "dziuk"'),
            ('claim = "section-7"', ""),
        ],
        "first_steps = 4: scheme 'dziuk' takes equal steps, must be 1",
    ),
    ([("first_steps = 4", "first_steps = 0")], "first_steps = 0: .*greater than or equal to 1"),
    ([("first_steps = 4", "first_steps = 2.0")], "first_steps = 2.0: .*integer"),
    ([("first_steps = 4", "first_steps = 10001")], "first_steps = 10001: .*10000"),
]


@pytest.mark.parametrize(("more", "message"), REFUSED)
def test_what_cannot_be_divided_is_refused(tmp_path, more, message):
    said = ("final_time = 0.5", "final_time = 0.5\nfirst_steps = 4")
    path = write_study(tmp_path, said, *more)
    with pytest.raises(BadInput, match=rf"\[sweep\] {message}"):
        load_study(path)


@pytest.mark.parametrize("first_steps", ["0", "1.0", '"3"'])
def test_a_flow_refuses_what_is_no_number_of_substeps(tmp_path, first_steps):
    said = ("tau = 0.01", f"tau = 0.01\nfirst_steps = {first_steps}")
    path = write_varied(tmp_path / "flow.toml", SMALL_FLOW, said)
    with pytest.raises(BadInput, match=r"\[time\] first_steps = "):
        load_flow(path)
