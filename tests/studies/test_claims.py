"""The claims: each speaks for the studies that its source covers, and for no others.

What the sources cover stands here a second time, as they were read: a study inside for each claim,
and for each key that the source restricts the values outside.
"""

from typing import Any

import pytest
from pydantic import ValidationError

from esfem.studies.case import Case
from esfem.studies.catalogue import scheme_studies
from esfem.studies.claims import Claim, claims, covering
from esfem.studies.quantities import QUANTITIES
from esfem.studies.study import Study, load_study

SPHERE, TORUS = {"name": "sphere"}, {"name": "clifford_torus"}
BREATHING = {"name": "breathing_ellipsoid", "amplitude": 0.25, "period": 1.0}
LOGISTIC = {"name": "logistic_sphere"}
SHRINKING = {"name": "shrinking_sphere"}
FLOW = {"name": "surface", "surface": "ellipsoid"}
ON_AXIS = {**FLOW, "reference": "axisymmetric"}
START, ROUND = {**FLOW, "reference": "start"}, {"name": "torus", "r": 0.6}
WAVY = {"name": "perturbed_sphere", "degree": 2, "amplitude": 0.001}
WAVY_TORUS = {"name": "perturbed_clifford_torus", "m": 2, "amplitude": 0.01}
HELFRICH = {"name": "helfrich", "spontaneous_curvature": 1.0}
LAWS = {"helfrich": HELFRICH}
KLL = {"degree": 2, "bdf": 2, "project": True, "theta": False}
MCF = {"name": "kll-mcf", "degree": 2, "bdf": 2}
PLAIN = {"name": "bgn", "degree": 2}
ANY_DEGREE, ANY_BDF = [1, 2, 3, 4], [1, 2, 3, 4, 5]


def inside(
    solution: dict[str, Any], law: str = "willmore", scheme: dict[str, Any] = KLL, **options: Any
) -> dict[str, Any]:
    """A study, by its tables."""
    return {
        "solution": solution,
        "law": LAWS.get(law, {"name": law}),
        "scheme": {**scheme, **options},
    }


THETA = {**KLL, "theta": True}
PURE = {**THETA, "project": False}
PAPER = {**KLL, "reaction": "extrapolated"}

# Of each claim studies inside, and by key what its source does not cover: the change of the first
# one, by table. A key of several values is tried with all of them.
INSIDE: dict[str, list[dict[str, Any]]] = {
    "theorem": [
        *(inside(SPHERE, scheme=PURE, degree=k) for k in (2, 3, 4)),
        *(inside(TORUS, scheme=PURE, bdf=q) for q in ANY_BDF),
        inside(FLOW, scheme=PURE),
    ],
    "order-k": [
        *(inside(BREATHING, scheme=THETA, project=p) for p in (True, False, "nu")),
        *(inside(BREATHING, scheme=THETA, degree=k) for k in (2, 3, 4)),
        *(inside(BREATHING, law, THETA) for law in ("helfrich", "surface_diffusion")),
        inside(TORUS, scheme=THETA, bdf=5),
        inside(FLOW, "surface_diffusion", PURE),
    ],
    "order-k-sharp": [inside(BREATHING, scheme=THETA), inside(BREATHING, "helfrich", PURE)],
    "theta-at-rest": [
        *(inside(SPHERE, scheme=THETA, degree=k) for k in ANY_DEGREE),
        *(inside(SPHERE, "surface_diffusion", PURE, bdf=q) for q in ANY_BDF),
    ],
    "section-7": [
        inside(SPHERE, scheme=PAPER),
        inside(SPHERE, scheme=PAPER, project=False),
        inside(TORUS, scheme=PAPER, bdf=1),
    ],
    "bdf-order": [
        *(inside(BREATHING, bdf=q) for q in ANY_BDF),
        *(inside(BREATHING, degree=k) for k in ANY_DEGREE),
        inside(LOGISTIC, "helfrich", THETA, velocity="ritz"),
        inside(SPHERE, "surface_diffusion"),
    ],
    "bdf-order-z": [
        *(inside(BREATHING, bdf=q) for q in ANY_BDF),
        inside(BREATHING, "helfrich", THETA, velocity="ritz"),
    ],
    "error-size": [
        *(inside(LOGISTIC, degree=k) for k in (3, 4)),
        *(inside(LOGISTIC, degree=4, bdf=q, theta=True) for q in ANY_BDF),
        inside(LOGISTIC, "helfrich", degree=4),
    ],
    "decay-rate-sphere": [
        *(inside(WAVY, scheme=THETA, degree=k) for k in (2, 3, 4)),
        inside(WAVY, "surface_diffusion", PURE),
    ],
    "decay-rate": [
        *(inside(WAVY, degree=k) for k in ANY_DEGREE),
        inside(WAVY, "surface_diffusion", PLAIN),
        inside(WAVY, scheme={**PLAIN, "name": "dziuk"}),
    ],
    "decay-rate-torus": [
        *(inside(WAVY_TORUS, scheme=THETA, degree=k) for k in (2, 3, 4)),
        inside(WAVY_TORUS, scheme=PURE),
    ],
    "energy-law": [
        *(inside(ON_AXIS, law, THETA) for law in ("willmore", "helfrich")),
        inside(WAVY, scheme=PURE),
        inside(ON_AXIS, "mean_curvature", MCF),
    ],
    "surface-diffusion-balances": [
        *(inside(ON_AXIS, "surface_diffusion", THETA, degree=k) for k in (2, 3, 4)),
        inside(WAVY, "surface_diffusion", PURE),
    ],
    "off-constraint-growth": [
        *(inside(SPHERE, project=p) for p in (False, True, "nu")),
        *(inside(SPHERE, project=False, degree=k) for k in ANY_DEGREE),
    ],
    "axisymmetric-energy": [
        *(inside(ON_AXIS, degree=k) for k in (2, 3, 4)),
        *(inside(ON_AXIS, law, PLAIN) for law in ("willmore", "helfrich", "surface_diffusion")),
        inside(ON_AXIS, scheme={**PLAIN, "name": "dziuk"}),
    ],
    "axisymmetric-law-energy": [
        *(inside(ON_AXIS, "helfrich", degree=k) for k in (2, 3, 4)),
        inside(ON_AXIS, "helfrich", PLAIN),
    ],
    "axisymmetric-integrals": [
        *(inside(ON_AXIS, "surface_diffusion", degree=k) for k in (2, 3, 4)),
        inside(ON_AXIS),
        inside(ON_AXIS, "mean_curvature", MCF),
    ],
    "axisymmetric-flow": [
        *(inside(ON_AXIS, scheme=THETA, degree=k) for k in (2, 3, 4)),
        *(inside(ON_AXIS, law, PURE) for law in ("helfrich", "surface_diffusion")),
        inside(ON_AXIS, "mean_curvature", MCF),
    ],
    "mcf-theorem": [
        *(inside(SHRINKING, "mean_curvature", MCF, degree=k) for k in (2, 3, 4)),
        *(inside(SHRINKING, "mean_curvature", MCF, bdf=q) for q in ANY_BDF),
    ],
    "mcf-bdf": [
        *(inside(SHRINKING, "mean_curvature", MCF, degree=k) for k in (2, 3, 4)),
        *(inside(SHRINKING, "mean_curvature", MCF, bdf=q) for q in (2, 3, 4, 5)),
    ],
    "start-of-w": [
        *(inside(ROUND, degree=k) for k in (2, 3, 4)),
        *(inside(START, law) for law in ("willmore", "helfrich", "surface_diffusion")),
        inside(BREATHING, "helfrich", bdf=3, project=False),
    ],
    "start-with-theta": [
        *(inside(ROUND, scheme=THETA, degree=k) for k in ANY_DEGREE),
        inside(START, "surface_diffusion", PURE),
    ],
    "defects": [
        *(inside(BREATHING, degree=k) for k in (2, 3, 4)),
        *(inside(BREATHING, law, THETA) for law in ("helfrich", "surface_diffusion")),
        inside(TORUS),
    ],
    "flow-map": [
        *(inside(BREATHING, scheme=THETA, degree=k) for k in (2, 3, 4)),
        inside(BREATHING, "helfrich", PURE),
        inside(SHRINKING, "mean_curvature", MCF),
    ],
    "gauss-bonnet": [
        *(inside(BREATHING, scheme=THETA, degree=k) for k in (2, 3, 4)),
        inside(FLOW, "surface_diffusion", PURE),
        inside(SHRINKING, "mean_curvature", MCF),
    ],
}

OTHER_SCHEME, ONLY_MCF = [{"scheme": PLAIN}], [{"scheme": MCF}]
NO_WILLMORE = [{"solution": BREATHING, "law": {"name": "surface_diffusion"}}, {"law": HELFRICH}]
MCF_FLOW = [{"solution": SHRINKING, "law": {"name": "mean_curvature"}}]
FORCED, RITZ = [{"solution": BREATHING}], [{"options": {"velocity": "ritz"}}]


def options(key: str, *values: Any) -> list[dict[str, Any]]:
    """Changes of one option of the scheme."""
    return [{"options": {key: value}} for value in values]


OUTSIDE: dict[str, dict[str, list[dict[str, Any]]]] = {
    "theorem": {
        "scheme": OTHER_SCHEME,
        "law": [*NO_WILLMORE, *MCF_FLOW, {"law": {"name": "surface_diffusion"}}],
        "forced": FORCED,
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "project": options("project", True, "nu"),
        "velocity": RITZ,
    },
    "order-k": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "order-k-sharp": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "solution": [{"solution": s} for s in (SPHERE, TORUS, LOGISTIC, FLOW)],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "theta-at-rest": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": HELFRICH}],
        "solution": [{"solution": s} for s in (TORUS, LOGISTIC, FLOW)],
        "theta": options("theta", False),
    },
    "section-7": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "surface_diffusion"}}],
        "solution": [{"solution": s} for s in (LOGISTIC, BREATHING, FLOW)],
        "degree": options("degree", 1, 3, 4),
        "bdf": [
            *options("bdf", 1, 3, 4, 5),
            {"solution": TORUS},
            {"solution": TORUS, "options": {"bdf": 3}},
        ],
        "theta": options("theta", True),
        "project": [
            *options("project", "nu"),
            {"solution": TORUS, "options": {"bdf": 1, "project": False}},
        ],
        "velocity": RITZ,
        "reaction": options("reaction", "implicit", "linearised"),
    },
    "bdf-order": {"scheme": OTHER_SCHEME, "law": MCF_FLOW},
    "bdf-order-z": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "solution": [{"solution": s} for s in (SPHERE, LOGISTIC, FLOW)],
    },
    "error-size": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "surface_diffusion"}}],
        "solution": [{"solution": s} for s in (SPHERE, BREATHING, FLOW)],
        "degree": options("degree", 1, 2),
        "project": options("project", False, "nu"),
        "velocity": RITZ,
    },
    "decay-rate-sphere": {
        "scheme": [*ONLY_MCF, *OTHER_SCHEME],
        "law": [{"law": HELFRICH}, *MCF_FLOW],
        "solution": [{"solution": s} for s in (SPHERE, WAVY_TORUS, FLOW)],
        "amplitude": [{"solution": {**WAVY, "amplitude": a}} for a in (0.002, -0.3)],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "decay-rate": {
        "scheme": ONLY_MCF,
        "law": [{"law": HELFRICH}, *MCF_FLOW],
        "solution": [{"solution": s} for s in (SPHERE, WAVY_TORUS, FLOW)],
        "amplitude": [{"solution": {**WAVY, "amplitude": a}} for a in (0.002, -0.3)],
    },
    "decay-rate-torus": {
        "scheme": [*ONLY_MCF, *OTHER_SCHEME],
        "law": [{"law": {"name": "surface_diffusion"}}],
        "solution": [{"solution": s} for s in (TORUS, WAVY)],
        "amplitude": [
            {"solution": {**WAVY_TORUS, "amplitude": 0.02}},
            {"solution": {**WAVY_TORUS, "scale": 0.5}},
        ],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "energy-law": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "surface_diffusion"}}],
        "forced": FORCED,
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "surface-diffusion-balances": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "willmore"}}, {"law": HELFRICH}],
        "forced": FORCED,
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "off-constraint-growth": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "surface_diffusion"}}],
        "solution": [{"solution": s} for s in (TORUS, LOGISTIC)],
        "theta": options("theta", True),
        "velocity": RITZ,
    },
    "axisymmetric-energy": {
        "scheme": ONLY_MCF,
        "law": [{"law": {"name": "mean_curvature"}}],
        "solution": [{"solution": s} for s in (SPHERE, TORUS, BREATHING)],
        "degree": options("degree", 1),
    },
    "axisymmetric-law-energy": {
        "scheme": [*ONLY_MCF, {"scheme": {**PLAIN, "name": "dziuk"}}],
        "law": [{"law": {"name": name}} for name in ("willmore", "surface_diffusion")],
        "solution": [{"solution": s} for s in (BREATHING, LOGISTIC)],
        "degree": options("degree", 1),
    },
    "axisymmetric-integrals": {
        "scheme": [{"scheme": {**PLAIN, "name": "dziuk"}}],
        "law": [{"law": HELFRICH}],
        "solution": [{"solution": s} for s in (SPHERE, WAVY)],
        "degree": options("degree", 1),
    },
    "axisymmetric-flow": {
        "scheme": OTHER_SCHEME,
        "law": [{"law": {"name": "mean_curvature"}}],
        "solution": [{"solution": s} for s in (SPHERE, WAVY)],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "mcf-theorem": {
        "scheme": [{"scheme": KLL}],
        "law": [{"solution": SPHERE, "law": {"name": "willmore"}}],
        "degree": options("degree", 1),
        "velocity": options("velocity", "interpolated"),
    },
    "mcf-bdf": {
        "scheme": [{"scheme": KLL}],
        "law": [{"solution": SPHERE, "law": {"name": "willmore"}}],
        "degree": options("degree", 1),
        "bdf": options("bdf", 1),
        "velocity": options("velocity", "interpolated"),
    },
    "start-of-w": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "degree": options("degree", 1),
        "theta": options("theta", True),
    },
    "start-with-theta": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "theta": options("theta", False),
    },
    "defects": {
        "scheme": OTHER_SCHEME,
        "law": MCF_FLOW,
        "solution": [{"solution": s} for s in (SPHERE, LOGISTIC, START)],
        "degree": options("degree", 1),
    },
    "flow-map": {
        "scheme": [{"scheme": PLAIN}],
        "law": [{"law": {"name": "mean_curvature"}}],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
    "gauss-bonnet": {
        "scheme": [{"scheme": PLAIN}],
        "law": [{"law": {"name": "mean_curvature"}}],
        "degree": options("degree", 1),
        "theta": options("theta", False),
        "velocity": RITZ,
    },
}
# Where a range names all that there is, no study can be outside.
ALL_THERE_IS = {
    "degree": set(ANY_DEGREE),
    "bdf": set(ANY_BDF),
    "project": {True, False, "nu"},
    "forced": {True, False},
}


def changed(tables: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    """The tables with some in the place of others, and with other options of the scheme."""
    found = {**tables, **{k: v for k, v in change.items() if k != "options"}}
    return {**found, "scheme": {**found["scheme"], **change.get("options", {})}}


def case(tables: dict[str, Any]) -> Case:
    return Case.model_validate({**tables, "vertices": 30, "tau": 0.01, "final_time": 0.1})


def study(claim: str, tables: dict[str, Any]) -> Study:
    sweep = {"vertices": [30, 60], "tau": [0.01, 0.005], "final_time": 0.1}
    about = {"name": "one", "title": "One", "claim": claim}
    return Study.model_validate({**tables, "study": about, "sweep": sweep})


def outside() -> list[Any]:
    return [
        pytest.param(name, key, change, id=f"{name}-{key}-{i}")
        for name, by_key in OUTSIDE.items()
        for key, changes in by_key.items()
        for i, change in enumerate(changes)
    ]


def test_every_claim_has_studies_inside_and_outside():
    assert list(INSIDE) == list(OUTSIDE) == list(claims())


@pytest.mark.parametrize("name", claims())
def test_every_key_that_a_range_restricts_has_a_value_outside(name):
    for covered in claims()[name].covers:
        free = {
            key
            for key, allowed in covered.restricted().items()
            if key in ALL_THERE_IS and ALL_THERE_IS[key] == set(allowed)
        }
        if covered.solution is not None or covered.law == ("mean_curvature",):
            free |= {"forced"}  # all that is named here is forced, or nothing
        assert set(covered.restricted()) - free <= set(OUTSIDE[name])


@pytest.mark.parametrize(
    ("name", "tables"), [(name, tables) for name in INSIDE for tables in INSIDE[name]]
)
def test_a_study_inside_is_accepted(name, tables):
    assert claims()[name].objection(case(tables)) is None
    assert study(name, tables).study.claim == name


@pytest.mark.parametrize(("name", "key", "change"), outside())
def test_a_study_outside_is_refused_by_the_key(name, key, change):
    objection = claims()[name].objection(case(changed(INSIDE[name][0], change)))
    assert objection.startswith(f"is made for {key} = ")
    assert ", not for " in objection and "\n" not in objection


def test_a_refused_study_tells_claim_value_and_what_is_allowed():
    with pytest.raises(
        ValidationError,
        match=r"\[study\] claim = 'mcf-bdf': is made for bdf = 2, 3, 4 or 5, not for 1",
    ):
        study("mcf-bdf", inside(SHRINKING, "mean_curvature", MCF, bdf=1))


def test_of_several_ranges_the_one_that_fits_farthest_is_told():
    """BDF3 on the torus: the sphere's BDF2 is no help there."""
    found = claims()["section-7"].objection(case(inside(TORUS, bdf=3)))
    assert found == "is made for bdf = 1, not for 3"


def test_the_first_covering_claim_is_found():
    names = ("theorem", "order-k")
    assert covering(names, case(inside(TORUS, scheme=PURE))).name == "theorem"
    assert covering(names, case(inside(TORUS, scheme=THETA))).name == "order-k"
    assert covering(names, case(inside(TORUS))) is None


@pytest.mark.parametrize("name", ["theorem", "mcf-theorem", "mcf-bdf"])
def test_what_is_proved_is_not_called_ours(name):
    assert "ours" not in claims()[name].source


@pytest.mark.parametrize(
    "name", ["order-k", "order-k-sharp", "bdf-order", "off-constraint-growth", "gauss-bonnet"]
)
def test_what_no_publication_proves_is_called_ours(name):
    assert claims()[name].source.startswith("ours")


def test_no_publication_is_cited_for_bdf_on_willmore_flow():
    assert "no published proof of a full discretisation of Willmore flow by BDF" in (
        claims()["bdf-order"].source
    )


def test_bdf1_of_mean_curvature_flow_claims_nothing():
    studies = {path.stem: load_study(path) for path in scheme_studies()}
    claimed = {s.scheme.bdf: s.study.claim for n, s in studies.items() if "sphere-bdf" in n}
    assert claimed == {1: None, 2: "mcf-bdf", 3: "mcf-bdf"}


def test_every_claim_names_its_source_and_known_variables():
    for claim in claims().values():
        assert len(claim.source) > 20
        assert set(claim.variables) <= set(QUANTITIES)


class TestBadClaims:
    GOOD = claims()["theorem"].model_dump()
    COVERS = GOOD["covers"][0]

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"about": "full"}, "about = 'full' must name bdf in every range"),
            ({"covers": [{**COVERS, "bdf": [2]}]}, "bdf is for about = 'full', not 'semi'"),
            ({"direction": "tau", "order": "q"}, "direction = 'tau' needs about = 'full'"),
            ({"covers": []}, "at least 1 item"),
            ({"covers": [{**COVERS, "degree": []}]}, "at least 1 item"),
            ({"covers": [{**COVERS, "degres": [2]}]}, "Extra inputs are not permitted"),
            ({"covers": [{**COVERS, "project": ["z"]}]}, "'nu'"),
            ({"order": None}, "must have an order, a limit, or both"),
            ({"converges": False}, "converges = false is for a limit alone"),
            ({"limit": {"W": 1.0}}, r"unknown: \['W'\], without: \[\]"),
            ({"order": None, "limit": {"x": 1.0}}, r"without: \['H', 'V', 'nu', 'v', 'z'\]"),
            ({"order": None, "limit": 1.0, "sharp": True}, "sharp = true needs an order"),
            ({"variables": ["y"]}, r"variables = \['y'\]: must be among x, nu"),
        ],
    )
    def test_a_claim_that_contradicts_itself_is_refused(self, change, message):
        Claim(**self.GOOD)
        with pytest.raises(ValidationError, match=message):
            Claim(**{**self.GOOD, **change})


@pytest.mark.parametrize("name", INSIDE)
def test_no_claim_is_made_for_crude_integrals_or_solves(name):
    setup = INSIDE[name][0]
    degree = setup["scheme"]["degree"]
    crude = changed(setup, {"options": {"quadrature": 2 * degree + 1}})
    said = f"is made for quadrature = {2 * degree + 2} at least, not for {2 * degree + 1}"
    assert claims()[name].objection(case(crude)) == said
    finer = changed(setup, {"options": {"quadrature": 2 * degree + 4}})
    assert claims()[name].objection(case(finer)) is None
    if setup["scheme"].get("name", "kll") == "kll":
        loose = {"tolerance": 1e-6, "reaction": "implicit"}
        said = claims()[name].objection(case(changed(setup, {"options": loose})))
        assert said == "is made for tolerance = 1e-08 at most, not for 1e-06"
