"""Generated derivatives: right, and kept on disk in a way that no damage can hurt."""

import subprocess
import sys

import numpy as np
import pytest
import sympy
from sympy.abc import a, x, y, z

from reference_solutions.calculus import generated

EXPRESSIONS = (
    x**5 * y - z**-4,
    sympy.sin(x * y) / sympy.sqrt(z),
    0.1 * x**7 + sympy.exp(-y),
    sympy.Integer(3),
)


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return generated.cache_directory()


def test_derivatives_are_those_of_arbitrary_precision():
    points = np.random.default_rng(0).uniform(0.5, 2.0, (3, 5))
    found = generated.derivatives(EXPRESSIONS, (x, y, z), 4)(*points)
    assert found.shape == (35, 4, 5)
    for m, index in enumerate(generated.indices(3, 4)):
        for i, expression in enumerate(EXPRESSIONS):
            by = [(x, y, z)[k] for k in index]
            exact = sympy.diff(expression, *by) if by else expression
            for n in range(5):
                value = exact.evalf(30, subs=dict(zip((x, y, z), points[:, n], strict=True)))
                # A few roundings of terms that may cancel.
                np.testing.assert_allclose(found[m, i, n], float(value), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("n", range(1, 20))
def test_power_is_a_power(n):
    assert generated.power(3, n) == 3**n


def test_strange_symbols_are_named():
    with pytest.raises(ValueError, match=r"holds a, but its variables are x, y, z"):
        generated.derivatives((a * x,), (x, y, z), 1)


def test_what_numpy_cannot_say_is_refused():
    with pytest.raises(ValueError, match=r"f\(x\).*: cannot be written in NumPy"):
        generated.derivatives((sympy.Function("f")(x),), (x,), 0)


def test_slow_generation_is_kept(cache_folder, monkeypatch):
    monkeypatch.setattr(generated, "SLOW", 0.0)
    text = generated.cached_source(EXPRESSIONS, (x, y, z), 1)
    (path,) = cache_folder.iterdir()
    monkeypatch.setattr(generated, "source", lambda *_: pytest.fail("generated again"))
    assert generated.cached_source(EXPRESSIONS, (x, y, z), 1) == text
    assert path.read_text().endswith(text)


def test_fast_generation_is_not_kept(cache_folder):
    generated.cached_source((x + 1,), (x,), 0)
    assert not cache_folder.exists()


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("expression", [x**2, x**3])
def test_each_source_has_its_file(cache_folder, monkeypatch, order, expression):
    monkeypatch.setattr(generated, "SLOW", 0.0)
    generated.cached_source((x,), (x,), 1)
    generated.cached_source((expression,), (x,), order)
    assert len(list(cache_folder.iterdir())) == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda t: t[: len(t) // 2],
        lambda t: t.replace("numpy", "numpi"),
        lambda t: "",
        lambda t: "#",
    ],
)
def test_damaged_file_is_made_again(cache_folder, monkeypatch, damage):
    monkeypatch.setattr(generated, "SLOW", 0.0)
    text = generated.cached_source((x**9,), (x,), 1)
    (path,) = cache_folder.iterdir()
    whole = path.read_text()
    path.write_text(damage(whole))
    assert generated.cached_source((x**9,), (x,), 1) == text
    assert path.read_text() == whole


def test_a_folder_closed_to_us_does_no_harm(tmp_path, monkeypatch):
    monkeypatch.setattr(generated, "SLOW", 0.0)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert "def function(x)" in generated.cached_source((x**8,), (x,), 1)


def test_programs_without_a_surface_do_not_load_sympy():
    code = "import sys, harness.cli, reference_solutions.surfaces as s; s.surface_names(); "
    code += "sys.exit('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
