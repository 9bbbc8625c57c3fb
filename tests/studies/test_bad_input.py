"""Bad input: one clear line with file, key, value and bound, status 2, nothing half-written."""

import subprocess
import sys

import pytest
from studies import BDF_LINES, write_study

from esfem.studies.catalogue import default_studies
from esfem.studies.study import load_study

SPHERE = 'name = "sphere"\nradius = 1.0'
ELLIPSOID = 'name = "surface"\nsurface = "ellipsoid"'
WAVE = 'name = "surface"\nsurface = "wave_torus"'
HEAD = 'claim = "{}"\nsuperconvergent = {{ x = "A", nu = "B", H = "C" }}\n\n[solution]\n{}'
ABOUT_SPHERE = HEAD.format("section-7", SPHERE)
ABOUT_WAVES = HEAD.format("bdf-order", 'name = "perturbed_sphere"')

# What is replaced in the small study, by what, and what the message must name.
LADDER = "vertices = [30, 60, 120, 240, 480]"
FINDINGS = [
    ("degree = 2", "degree = 7", ["[scheme] degree = 7", "less than or equal to 4"]),
    ("degree = 2", "degree = 0", ["[scheme] degree = 0", "greater than or equal to 1"]),
    ("degree = 2", "degree = 2.0", ["[scheme] degree = 2.0", "integer"]),
    ("bdf = 2", "bdf = 6", ["[scheme] bdf = 6", "less than or equal to 5"]),
    ("bdf = 2", "bdf = 0", ["[scheme] bdf = 0", "greater than or equal to 1"]),
    ("bdf = 2", "bdf = true", ["[scheme] bdf = True", "integer"]),
    ("bdf = 2", "bdf = 5", ["[scheme] bdf = 5", "at least bdf times tau"]),
    ("project = true", "project = 1", ["[scheme] project = 1", "boolean"]),
    ("theta = false", "theta = false\ntheat = 1", ["[scheme] theat", "theta"]),
    (
        "theta = false",
        'theta = false\nname = "rusu"',
        ["[scheme] name = 'rusu'", "bgn, dziuk, kll"],
    ),
    ("theta = false", "theta = false\nname = 3", ["[scheme] name = 3", "bgn, dziuk, kll"]),
    ("theta = false", 'theta = false\nname = "dziuk"', ["bdf: unknown", "of name, degree"]),
    ("theta = false", "", ["[scheme] theta", "missing"]),
    ("project = true", 'project = "z"', ["[scheme] project = 'z'", "'nu'"]),
    ("theta = false", 'theta = false\nvelocity = "l2"', ["velocity = 'l2'", "'ritz'"]),
    (
        'name = "willmore"',
        'name = "mean_curvature"',
        ["name = 'mean_curvature'", "solves willmore"],
    ),
    (
        BDF_LINES,
        'name = "dziuk"',
        ["claim = 'section-7'", "scheme = kll, not for dziuk"],
    ),
    ("theta = false", "theta = false\ntolerance = 0.5", ["[scheme] tolerance = 0.5", "0.01"]),
    (
        "theta = false",
        "theta = false\ntolerance = 0.001",
        ["[scheme] tolerance = 0.001: has no effect", "direct solves; leave it out"],
    ),
    (
        "tau = [0.25, 0.125]\nfinal_time = 0.5",
        "tau = [1e-323]\nfinal_time = 3e-323",
        ["[sweep] tau = 1e-323", "1e-30"],
    ),
    ("tau = [0.25, 0.125]", "tau = [0.25, 0.0]", ["[sweep] tau[1] = 0.0", "greater than 0"]),
    ("tau = [0.25, 0.125]", "tau = [-0.25]", ["[sweep] tau[0] = -0.25", "greater than 0"]),
    ("tau = [0.25, 0.125]", "tau = [inf]", ["[sweep] tau[0] = inf", "finite"]),
    ("tau = [0.25, 0.125]", "tau = [0.2]", ["final_time = 0.5", "multiple of tau = 0.2"]),
    ("tau = [0.25, 0.125]", "tau = [1.0]", ["final_time = 0.5", "multiple of tau = 1.0"]),
    ("tau = [0.25, 0.125]", "tau = []", ["[sweep] tau = []", "at least 1"]),
    ("tau = [0.25, 0.125]", "tau = [1e-320]", ["[sweep] tau = 1e-320", "1e-30"]),
    ("final_time = 0.5", "final_time = 1e308", ["[sweep] tau = 0.25", "10,000,000 steps"]),
    ("final_time = 0.5", "final_time = nan", ["[sweep] final_time = nan", "finite"]),
    ("final_time = 0.5", "", ["[sweep] final_time", "missing"]),
    (
        LADDER,
        "vertices = [5]",
        ["vertices = 5", "at least 6", "sphere"],
    ),
    (
        LADDER,
        "vertices = [3]",
        ["[sweep] vertices[0] = 3", "equal to 4"],
    ),
    (LADDER, "vertices = [30, 30]", ["vertices = [30, 30]", "twice"]),
    (LADDER, "vertices = 30", ["[sweep] vertices = 30", "list"]),
    ('name = "sphere"', 'name = "cube"', ["[solution] name = 'cube'", "sphere, clifford_torus"]),
    ("radius = 1.0", "radius = -1.0", ["[solution] radius = -1.0", "positive"]),
    ("radius = 1.0", 'radius = "one"', ["[solution] radius = 'one'", "number"]),
    ("radius = 1.0", "radius = 1e300", ["[solution] radius = 1e+300", "1e-06 to 1e+06"]),
    ("radius = 1.0", f"radius = {10**400}", ["[solution] radius = 1000", "1e-06 to 1e+06"]),
    ("radius = 1.0", "centre = [1e7, 0, 0]", ["[solution] centre = [", "must be 1e+06 at most"]),
    ("radius = 1.0", "radius = 1e-3\ncentre = [0, 2e3, 0]", ["1e+06 times that of the surface"]),
    ("radius = 1.0", "centre = [0, 0]", ["[solution] centre = [0, 0]: must be three numbers"]),
    ("radius = 1.0", "centre = [0, 0, nan]", ["[solution] centre = [0, 0, nan]"]),
    ("radius = 1.0", "centre = 1.0", ["[solution] centre = 1.0: must be three numbers"]),
    ("radius = 1.0", "diameter = 1.0", ["[solution] diameter: unknown key", "radius"]),
    ('name = "willmore"', 'name = "mcf"', ["[law] name = 'mcf'", "willmore, helfrich"]),
    ('name = "willmore"', 'name = "helfrich"', ["[law] spontaneous_curvature", "missing"]),
    (
        'name = "willmore"',
        'name = "helfrich"\nspontaneous_curvature = 1.0',
        ["[law] law = 'helfrich'", "'sphere' solves willmore"],
    ),
    ('claim = "section-7"', 'claim = "hope"', ["[study] claim = 'hope'", "theorem, ", "section-7"]),
    (
        'claim = "section-7"',
        'claim = "theorem"',
        ["[study] claim = 'theorem'", "theta = true, not for false"],
    ),
    ("degree = 2", "degree = 1", ["[study] claim = 'section-7'", "degree = 2, not for 1"]),
    ('name = "small"', 'name = "../up"', ["[study] name = '../up'", "a-z, 0-9"]),
    ('name = "small"', 'name = "meshes"', ["[study] name = 'meshes'", "must not be"]),
    ('title = "A small study"', 'title = "a\\u0000b"', ["[study] title", "printable"]),
    ("[sweep]", "sweep = 3\n[other]", ["sweep"]),
    (
        'claim = "section-7"',
        'claim = "decay-rate-sphere"',
        ["claim = 'decay-rate-sphere'", "solution = perturbed_sphere, not for sphere"],
    ),
    (ABOUT_SPHERE, ABOUT_WAVES, ["judges x, nu, H, V, v, not measured of 'perturbed_sphere'"]),
    ("final_time = 0.5", "final_time = 0.5\ncompare_at = [0.25]", ["compare_at", "'surface' only"]),
    ("final_time = 0.5", "final_time = 0.5\ncompare_at = [0.2]", ["compare_at = 0.2", "0.25"]),
    ("final_time = 0.5", "final_time = 0.5\ncompare_at = [1e-10]", ["compare_at = 1e-10", "whole"]),
    ("final_time = 0.5", "final_time = 0.5\ncompare_at = [0.75]", ["compare_at = 0.75", "at most"]),
    (SPHERE, 'name = "surface"', ["[solution] surface: is missing"]),
    (SPHERE, 'name = "surface"\nsurface = "cube"', ["surface = 'cube'", "red_blood_cell"]),
    (SPHERE, 'name = "surface"\nsurface = 3', ["surface = 3", "word in quotes"]),
    (SPHERE, f"{ELLIPSOID}\nreference = 'hope'", ["reference = 'hope'", "finest, axisymmetric"]),
    (SPHERE, f"{WAVE}\nreference = 'axisymmetric'", ["'wave_torus' gives no profile"]),
    (SPHERE, 'name = "perturbed_sphere"\namplitude = 0.5', ["amplitude = 0.5", "0.3"]),
    (
        LADDER,
        "vertices = [10000000]",
        ["vertices", "at most 200,000"],
    ),
    ("[law]", "[lore]", ["[law]", "missing", "[lore]", "unknown key"]),
    ("[law]", "[law", ["not valid TOML", "line"]),
]


def assert_refused(result: tuple[int, str, str], *named: str) -> None:
    status, _, err = result
    assert status == 2
    assert len(err.strip().splitlines()) == 1
    assert "Traceback" not in err
    for word in named:
        assert word in err


@pytest.mark.parametrize(("old", "new", "named"), FINDINGS, ids=[new for _, new, _ in FINDINGS])
def test_a_bad_study_is_one_line_that_names_file_key_value_and_bound(
    esfem, tmp_path, old, new, named
):
    path = write_study(tmp_path, (old, new))
    result = esfem("run", path, "--out", tmp_path / "out")
    assert_refused(result, *named)
    assert "study.toml" in result[2] or "study 'small'" in result[2]
    assert not (tmp_path / "out").exists()


HELFRICH = [
    ('name = "sphere"', 'name = "helfrich_sphere"\nspontaneous_curvature = -1.0'),
    ('claim = "section-7"\n', ""),
]


def test_a_solution_that_is_extinct_before_the_final_time_is_refused(esfem, tmp_path):
    law = ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = -1.0')
    result = esfem("run", write_study(tmp_path, *HELFRICH, law), "--out", tmp_path / "out")
    assert_refused(result, "[sweep] final_time = 0.5", "helfrich_sphere", "before t = 0.12186043")


def test_a_spontaneous_curvature_that_is_not_the_solutions_is_refused(esfem, tmp_path):
    law = ('name = "willmore"', 'name = "helfrich"\nspontaneous_curvature = 1.0')
    result = esfem("run", write_study(tmp_path, *HELFRICH, law), "--out", tmp_path / "out")
    assert_refused(result, "[law] spontaneous_curvature = 1.0", "must be -1.0")


def test_an_unreadable_study_is_named(esfem, tmp_path):
    assert_refused(esfem("run", tmp_path / "none.toml"), "none.toml", "cannot be read")


def test_a_binary_study_is_named(esfem, tmp_path):
    (tmp_path / "study.toml").write_bytes(b"\xff\xfe\x00")
    assert_refused(esfem("run", tmp_path / "study.toml"), "study.toml", "UTF-8")


def test_an_unwritable_folder_is_named(esfem, tmp_path):
    (tmp_path / "file").touch()
    result = esfem("run", write_study(tmp_path), "--out", tmp_path / "file" / "out")
    assert_refused(result, "--out", "cannot be written")


def test_two_studies_of_one_name_are_refused(esfem, tmp_path):
    first, second = write_study(tmp_path), write_study(tmp_path, name="other.toml")
    assert_refused(esfem("run", first, second, "--out", tmp_path), "name = 'small'")


def test_jobs_must_be_positive(esfem, tmp_path):
    assert_refused(esfem("run", write_study(tmp_path), "--jobs", 0), "--jobs 0", "at least 1")


def test_a_folder_without_results_is_refused(esfem, tmp_path):
    assert_refused(esfem("table", tmp_path), str(tmp_path), "no results")


def test_damaged_results_are_refused(esfem, tmp_path):
    (tmp_path / "verdicts.json").write_text("{")
    assert_refused(esfem("table", tmp_path), "cannot be read")


def test_an_unknown_surface_is_refused(esfem):
    assert_refused(esfem("mesh", "cube", "--vertices", 40), "'cube'", "sphere, clifford_torus")


def test_too_few_vertices_are_refused(esfem):
    assert_refused(esfem("mesh", "sphere", "--vertices", 3), "vertices = 3", "at least 6")


def test_an_unknown_mesh_format_is_refused(esfem, tmp_path):
    result = esfem("mesh", "sphere", "--vertices", 30, "--out", tmp_path / "mesh.xyz")
    assert_refused(result, "mesh.xyz", ".npz, .ply")


def test_the_installed_command_refuses_without_a_traceback(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "esfem", "run", tmp_path / "none.toml"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert_refused((done.returncode, done.stdout, done.stderr), "none.toml")


def test_a_committed_study_is_valid_and_bears_the_name_of_its_file():
    assert len(default_studies()) >= 7
    for path in default_studies():
        assert load_study(path).name == path.stem
