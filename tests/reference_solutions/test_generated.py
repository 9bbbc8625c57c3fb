"""Generated derivatives: right, refused by name, and generated in memory alone."""

import subprocess
import sys

import numpy as np
import pytest
import sympy
from sympy.abc import a, x, y, z

from esfem.reference_solutions.calculus import generated

EXPRESSIONS = (
    x**5 * y - z**-4,
    sympy.sin(x * y) / sympy.sqrt(z),
    0.1 * x**7 + sympy.exp(-y),
    sympy.Integer(3),
)


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


def test_a_text_is_no_expression():
    """Sympy would evaluate it as Python."""
    with pytest.raises(ValueError, match="SympifyError: 'x'"):
        generated.derivatives(("x",), (x,), 0)


@pytest.mark.parametrize("n", range(1, 20))
def test_power_is_a_power(n):
    assert generated.power(3, n) == 3**n


def test_strange_symbols_are_named():
    with pytest.raises(ValueError, match=r"holds a, but its variables are x, y, z"):
        generated.derivatives((a * x,), (x, y, z), 1)


def test_what_numpy_cannot_say_is_refused():
    with pytest.raises(ValueError, match=r"f\(x\).*: cannot be written in NumPy"):
        generated.derivatives((sympy.Function("f")(x),), (x,), 0)


def test_source_is_generated_once_a_process(monkeypatch):
    first = generated.derivatives((x**8 + 1,), (x,), 1)
    monkeypatch.setattr(generated, "source", lambda *_: pytest.fail("generated again"))
    assert generated.derivatives((x**8 + 1,), (x,), 1) is first


def test_no_source_is_kept_in_a_file():
    """Modules aside, which Python may load meanwhile, no file is opened."""
    opened, watching = [], [True]

    def hook(event, arguments):
        if watching and event == "open" and not str(arguments[0]).endswith((".py", ".pyc")):
            opened.append(arguments)

    sys.addaudithook(hook)  # it stays until the process ends
    found = generated.derivatives((x**9 + 1,), (x,), 2)(np.array([2.0]))
    watching.clear()
    assert opened == []
    np.testing.assert_array_equal(found[:, 0, 0], [513.0, 2304.0, 9216.0])


def test_programs_without_a_surface_do_not_load_sympy():
    code = "import sys, esfem.results.tables\n"
    code += "from esfem.reference_solutions.surfaces import surface_names\nsurface_names()\n"
    code += "sys.exit('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
