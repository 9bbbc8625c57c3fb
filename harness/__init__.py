"""The harness: studies, sweeps, errors by lifts, orders and verdicts.

>>> from harness import run_study
>>> records = run_study("harness/studies/sphere.toml")  # doctest: +SKIP
>>> records[["h", "tau", "err_x"]]  # doctest: +SKIP
"""

from harness.api import run_studies, run_study
from harness.bad_input import BadInput
from harness.study import Study, load_study

__all__ = ["BadInput", "Study", "load_study", "run_studies", "run_study"]
