"""The harness: studies, sweeps, errors by lifts, orders and verdicts.

>>> from harness import run_study
>>> records = run_study("harness/studies/sphere.toml")  # doctest: +SKIP
>>> records[["h", "tau", "err_x"]]  # doctest: +SKIP
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.api import run_studies, run_study
    from harness.bad_input import BadInput
    from harness.study import Study, load_study

__all__ = ["BadInput", "Study", "load_study", "run_studies", "run_study"]
HOME = {
    "BadInput": "harness.bad_input",
    "Study": "harness.study",
    "load_study": "harness.study",
    "run_studies": "harness.api",
    "run_study": "harness.api",
}


def __getattr__(name: str) -> Any:
    """Loads a name when it is first used: every pytest session imports the package for its plugin,
    and should not pay for pandas and sympy."""
    if name not in HOME:
        raise AttributeError(f"module 'harness' has no attribute {name!r}")
    return getattr(import_module(HOME[name]), name)
