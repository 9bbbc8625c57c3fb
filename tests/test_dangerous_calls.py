"""No file that is read can make this program run code: read from the sources themselves."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PLACES = [path for path in sorted(ROOT.iterdir()) if path.is_dir() and path.name[0] != "."]
SOURCES = [path for place in PLACES for path in sorted(place.rglob("*.py"))]

# What these modules read may hold code, and runs it.
MODULES = ("pickle", "_pickle", "cPickle", "cloudpickle", "dill", "jsonpickle", "marshal", "shelve")
BUILT_IN = ("eval", "exec", "compile", "__import__")
# Of whatever module or object: they read pickles, or run a text.
ANYWHERE = ("read_pickle", "unsafe_load", "full_load", "parse_expr", "run_path", "eval", "exec")
QUALIFIED = (
    *("joblib.load", "torch.load", "yaml.load", "yaml.load_all", "code.InteractiveInterpreter"),
    *("os.system", "os.popen", "subprocess.getoutput", "subprocess.getstatusoutput"),
)
# Functions that are safe with this keyword alone.
SAFE_WITH = {"numpy.load": ("allow_pickle", False), "sympy.sympify": ("strict", True)}
NEVER = ("allow_pickle", "shell")

# Which call may be where, and why.
ALLOWED = {
    ("reference_solutions/calculus/generated.py", "exec"),  # a text made just before
    # The program's own text, a mutant's edit in it.
    ("harness/campaigns/mutants/mutant.py", "compile"),
    ("harness/campaigns/mutants/mutant.py", "exec"),
    ("tests/test_readme.py", "exec"),  # README's examples
}


def calls(text: str) -> Iterator[str]:
    """What stands in a source by which a file that is read could run code, by name."""
    tree = ast.parse(text)
    aliases = imported_names(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [alias.name for alias in node.names]
            modules = names if isinstance(node, ast.Import) else [node.module or ""]
            yield from (name for name in modules if name.partition(".")[0] in MODULES)
            yield from (name for name in names if name in ANYWHERE)
        elif isinstance(node, ast.Name) and node.id in BUILT_IN:  # called, or handed to `map`
            yield node.id
        elif isinstance(node, ast.Call):
            yield from _called(node, aliases)


def called(path: Path) -> set[str]:
    return set(calls(path.read_text(encoding="utf-8")))


def imported_names(tree: ast.AST) -> dict[str, str]:
    """What names of the source stand for: {"np": "numpy", "load": "numpy.load"}."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.asname or alias.name: alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
    return found


def _called(node: ast.Call, aliases: dict[str, str]) -> Iterator[str]:
    keywords = {keyword.arg: keyword.value for keyword in node.keywords}
    first, _, rest = ast.unparse(node.func).partition(".")
    name = ".".join(filter(None, (aliases.get(first, first), rest)))
    module, _, last = name.rpartition(".")
    if (module and last in ANYWHERE) or name in QUALIFIED:
        yield name
    safe, value = SAFE_WITH.get(name, (None, None))
    if safe is not None and not _is(keywords.get(safe), value):
        yield name
    for keyword in NEVER:
        if keyword in keywords and not _is(keywords[keyword], False):
            yield f"{name}({keyword})"


def _is(node: ast.expr | None, value: object) -> bool:
    return isinstance(node, ast.Constant) and node.value is value


@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.name)
def test_no_source_runs_what_it_reads(place):
    sources = (path for path in SOURCES if path.is_relative_to(place))
    found = {(path.relative_to(ROOT).as_posix(), name) for path in sources for name in called(path)}
    assert found <= ALLOWED


def test_all_packages_are_read():
    assert {path.relative_to(ROOT).parts[0] for path in SOURCES} >= {
        *("benchmarks", "harness", "reference_solutions", "solver", "tests")
    }


def test_what_is_allowed_is_there():
    """An exception that is no longer needed is to be struck out."""
    for place, name in ALLOWED:
        assert name in called(ROOT / place)


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from pickle import loads",
        "def f():\n    import cloudpickle.compat",
        "eval('1')",
        "x = [exec(t) for t in y]",
        "map(eval, lines)",
        "__import__('os')",
        "import numpy as np\nnp.load('a.npz')",
        "import numpy as np\nnp.load('a.npz', allow_pickle=True)",
        "import numpy as np\nnp.load('a.npz', allow_pickle=flag)",
        "import numpy as np\nnp.load('a.npz', **options)",
        "from numpy import load\nload('a.npy')",
        "from numpy import load as read\nread('a.npy')",
        "import numpy as np\nnp.lib.format.read_array(stream, allow_pickle=True)",
        "import numpy\nnumpy.save('a.npy', a, allow_pickle=True)",
        "import pandas as pd\npd.read_pickle('a')",
        "import pandas\nframe.eval('x')",
        "import yaml\nyaml.load(text, Loader)",
        "from yaml import load\nload(text)",
        "import joblib\njoblib.load('a')",
        "import os\nos.system('ls')",
        "from os import popen\npopen('ls')",
        "import sympy\nsympy.sympify(text)",
        "import subprocess\nsubprocess.run('ls', shell=True)",
        "from sympy.parsing.sympy_parser import parse_expr",
    ],
)
def test_every_way_is_found(text):
    assert list(calls(text))


@pytest.mark.parametrize(
    "text",
    [
        "import numpy as np\nnp.load('a.npz', allow_pickle=False)",
        "import json\njson.load(stream)",
        "import re\nre.compile('a')",
        "import tomllib\ntomllib.load(stream)",
        "'eval(1)'",
        "import platform\nplatform.system()",
        "import sympy\nsympy.sympify(text, strict=True)",
        "expression.evalf(30)",
        "import subprocess\nsubprocess.run(['ls'])",
    ],
)
def test_what_is_harmless_is_not_found(text):
    assert not list(calls(text))
