"""The harness: studies, sweeps, errors by lifts, orders and verdicts.

>>> from esfem import run_study
>>> records = run_study("harness/studies/sphere.toml")  # doctest: +SKIP
>>> records[["h", "tau", "err_x"]]  # doctest: +SKIP
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from esfem.common.bad_input import BadInput
    from esfem.results.run_studies import run_studies, run_study
    from esfem.studies.study import Study, load_study

__all__ = ["BadInput", "Study", "load_study", "run_studies", "run_study"]
HOME = {
    "BadInput": "esfem.common.bad_input",
    "Study": "esfem.studies.study",
    "load_study": "esfem.studies.study",
    "run_studies": "esfem.results.run_studies",
    "run_study": "esfem.results.run_studies",
}


def __getattr__(name: str) -> Any:
    """Loads a name when it is first used: every pytest session imports the package for its plugin,
    and should not pay for pandas and sympy."""
    if name not in HOME:
        raise AttributeError(f"module 'harness' has no attribute {name!r}")
    return getattr(import_module(HOME[name]), name)
