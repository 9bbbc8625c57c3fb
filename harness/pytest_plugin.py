"""The pytest plugin: the fixture ``esfem_order``.

Every pytest session of this environment loads this file, so that it imports nothing but pytest.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def esfem_results(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where studies leave their results: in the cache of pytest, so that the next session only runs
    what changed; in a temporary folder without a cache."""
    cache = getattr(request.config, "cache", None)
    return tmp_path_factory.mktemp("esfem") if cache is None else Path(cache.mkdir("esfem"))


@pytest.fixture
def esfem_order(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Fails the test unless an order of convergence is there.

    ``esfem_order(h, errors, 2)`` judges a table, with the options of
    `esfem.cli.pytest_order.guard_table`; ``esfem_order(study="clifford")`` runs a study and asserts
    its verdicts (`guard_study`).
    """

    def assert_order(*table: Any, study: Any = None, **options: Any) -> None:
        __tracebackhide__ = True
        from esfem.cli import pytest_order

        if study is None:
            objection = pytest_order.guard_table(*table, **options)
        elif table:
            raise TypeError("esfem_order: either h, errors and an order, or a study")
        else:
            if "out" not in options:
                options["out"] = request.getfixturevalue("esfem_results")
            objection = pytest_order.guard_study(study, **options)
        if objection:
            pytest.fail(objection)

    return assert_order
