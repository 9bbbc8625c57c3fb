"""A whole study, from its file to its verdicts, in another unit of length and at another place.

With all lengths times l, and times as the law has them, each number of the records is that of the
study at l = 1 times a power of l: to the last bit if l is a power of two, for then no operation
rounds differently, unless something compares a length with a number.
"""

import numpy as np
import pandas as pd
import pytest

from esfem.results.run_studies import run_studies
from esfem.results.study_result import StudyResult

STUDY = """
[study]
name = "scaled"
title = "A study of size {l:g}"
{claim}

[solution]
{solution}

[law]
name = "{law}"

[scheme]
degree = 2
{scheme}

[sweep]
vertices = {vertices}
tau = [{tau!r}]
final_time = {final_time!r}
"""
ELLIPSOID = 'name = "breathing_ellipsoid"\namplitude = 0.25\nperiod = {time!r}\nscale = {l!r}'
SPHERE = 'name = "shrinking_sphere"\nradius = {l!r}'
# (solution, law, lines of the scheme, lines of the claim, tau at l = 1, power of l of the time)
KLL = "bdf = 3\nproject = true\ntheta = true"
SCHEMES = {
    "kll": (ELLIPSOID, "willmore", KLL, 'claim = "order-k"', 1 / 128, 4),
    "bgn": (ELLIPSOID, "willmore", 'name = "bgn"', "", 1 / 64, 4),
    "dziuk": (ELLIPSOID, "willmore", 'name = "dziuk"', "", 1 / 64, 4),
    "kll-mcf": (
        SPHERE,
        "mean_curvature",
        'name = "kll-mcf"\nbdf = 3',
        'claim = "mcf-theorem"\n[study.superconvergent]\n'
        + "\n".join(f'{name} = "on a sphere"' for name in ("x", "v", "nu", "H")),
        1 / 128,
        2,
    ),
}
STEPS = 4
# Powers of l; of V and v that of the time less one is taken off.
LENGTHS = {"x": 1, "nu": 0, "H": -1, "z": -2, "distance": 1, "W": 0, "area": 0, "volume": 0}
NUMBERS = {"h": 1, "h_max": 1, "length": 1, "energy_rise": 0, "least_normal": 0}
NUMBERS |= {f"willmore_{end}": 0 for end in "0T"} | {f"area_{end}": 2 for end in "0T"}
NUMBERS |= {f"volume_{end}": 3 for end in "0T"} | {"gmres_mean": 0, "greatest_normal": 0}
SAME = ["vertices", "nodes", "steps", "status", "mesh_digest", "moved"]


def run(folder, scheme: str, l: float = 1.0, centre: str = "", vertices=(30, 60)) -> StudyResult:
    """The study of that size, and at that centre."""
    solution, law, lines, claim, tau, power = SCHEMES[scheme]
    time = float(l) ** power
    text = STUDY.format(
        l=l,
        claim=claim,
        solution=solution.format(l=float(l), time=time) + centre,
        law=law,
        scheme=lines,
        vertices=list(vertices),
        tau=tau * time,
        final_time=STEPS * tau * time,
    )
    path = folder / "scaled.toml"
    path.write_text(text)
    return run_studies([path], folder / "runs")[0]


def powers(records: pd.DataFrame, power_of_time: int) -> dict[str, int]:
    """By column the power of l: H^1 norms are those of |e|^2 / L^2 + |grad e|^2, L^2 ones one more,
    and shapes have relative errors, or a distance."""
    of = LENGTHS | {"V": 1 - power_of_time, "v": 1 - power_of_time}
    found = {name: power for name, power in NUMBERS.items() if name in records}
    found |= {name: power_of_time for name in records if name[:2] == "t_"} | {"tau": power_of_time}
    for column in records:
        kind, _, rest = column.partition("_")
        name, _, norm = rest.partition("_")
        if kind not in ("err", "nodal", "idle") or name not in of:
            continue
        shape = name in ("distance", "W", "area", "volume")
        found[column] = of[name] + (norm == "l2" and not shape)
    return found


def scaled(result: StudyResult, l: float) -> pd.DataFrame:
    """The numbers of the records in units of l."""
    power_of_time = SCHEMES[result.study.scheme.name][-1]
    records = result.records
    return pd.DataFrame(
        {name: records[name] / l**p for name, p in powers(records, power_of_time).items()}
    )


def assert_same_verdicts(found: StudyResult, expected: StudyResult, tolerance: float) -> None:
    """The same words, and orders that differ by no more than that."""
    pairs = list(zip(found.verdicts, expected.verdicts, strict=True))
    assert [(v.variable, v.verdict) for v, _ in pairs] == [
        (v.variable, v.verdict) for _, v in pairs
    ]
    for v, w in pairs:
        np.testing.assert_allclose(v.observed, w.observed, rtol=0, atol=tolerance)
    assert found.outcome == expected.outcome


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """By scheme and meshes, the study of size 1; computed once."""
    made: dict[object, StudyResult] = {}

    def of(scheme: str, vertices) -> StudyResult:
        if (scheme, vertices) not in made:
            made[scheme, vertices] = run(tmp_path_factory.mktemp("unit"), scheme, vertices=vertices)
        return made[scheme, vertices]

    return of


@pytest.mark.parametrize("scheme", SCHEMES)
class TestScaling:
    FEW, LADDER = (30, 60), (30, 60, 120, 240, 480)

    @pytest.mark.parametrize("exponent", [-10, 10])
    def test_by_a_power_of_two_to_the_last_bit(self, tmp_path, unit, scheme, exponent):
        l, expected = 2.0**exponent, unit(scheme, self.FEW)
        found = run(tmp_path, scheme, l, vertices=self.FEW)
        pd.testing.assert_frame_equal(found.records[SAME], expected.records[SAME])
        one, many = scaled(expected, 1.0), scaled(found, l)
        assert len(one.columns) > 20
        pd.testing.assert_frame_equal(many, one, check_exact=True)
        assert_same_verdicts(found, expected, 1e-9)

    @pytest.mark.slow
    @pytest.mark.parametrize("l", [1e-3, 1e3])
    def test_by_any_factor_to_rounding(self, tmp_path, unit, scheme, l):
        expected = unit(scheme, self.LADDER)
        found = run(tmp_path, scheme, l, vertices=self.LADDER)
        self.assert_close(scaled(found, l), scaled(expected, 1.0))
        assert_same_verdicts(found, expected, 1e-6)

    @pytest.mark.slow
    def test_at_an_offset_of_1e5_radii(self, tmp_path, unit, scheme):
        expected = unit(scheme, self.LADDER)
        found = run(tmp_path, scheme, 1.0, "\ncentre = [1e5, 0, 0]", self.LADDER)
        # Positions are rounded by 1e5 eps, and so their gradients by as much over h.
        lost = 1e5 * np.finfo(float).eps / expected.records["h"].min()
        self.assert_close(scaled(found, 1.0), scaled(expected, 1.0), lost)
        assert_same_verdicts(found, expected, 1e-6)

    @staticmethod
    def assert_close(found: pd.DataFrame, expected: pd.DataFrame, lost: float = 0.0) -> None:
        """Errors to 1e-6, or to what rounding takes from positions."""
        assert list(found) == list(expected)
        for name in found:
            np.testing.assert_allclose(
                found[name], expected[name], rtol=1e-6, atol=lost, err_msg=name
            )
