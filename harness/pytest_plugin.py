"""The pytest plugin: fixture ``esfem_order``, marker ``esfem_expects``, and a table of all orders.

Every pytest session of this environment loads this file, so that it imports nothing but pytest.
"""

from collections.abc import Callable
from inspect import signature
from pathlib import Path
from typing import Any

import pytest

PROPERTY = (
    "esfem_order"  # of a report, by which orders come from the workers of xdist, and to JUnit
)
EXPECTABLE = ("inconclusive", "fail", "suspect", "not exercised")
MARKER = (
    "esfem_expects(outcome, ..., reason=''): esfem_order is expected to end so "
    f"({', '.join(map(repr, EXPECTABLE))}); the test is xfailed then, and fails else"
)
HEADINGS = ("test", "verdict", "claim", "order", "95 % interval")
LONGEST = 60  # letters of the name of a test in the table


def pytest_configure(config: pytest.Config) -> None:
    """Makes the marker known."""
    config.addinivalue_line("markers", MARKER)


@pytest.fixture(scope="session")
def esfem_results(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where studies leave their results: in the cache of pytest, so that the next session only runs
    what changed; in a temporary folder without a cache."""
    cache = getattr(request.config, "cache", None)
    return tmp_path_factory.mktemp("esfem") if cache is None else Path(cache.mkdir("esfem"))


@pytest.fixture
def esfem_order(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Fails the test unless an order of convergence is there.

    ``esfem_order(h, errors, 2)`` judges a table, with the keywords of
    `esfem.cli.pytest_order.guard_table`; ``esfem_order(study="clifford")`` runs a study and asserts
    its verdicts (`guard_study`).
    """

    def assert_order(*table: Any, study: Any = None, **options: Any) -> None:
        __tracebackhide__ = True
        found, wrong = _guarded(request, table, study, options)
        if wrong:
            pytest.fail(f"esfem_order: {wrong}")
        request.node.user_properties.append(
            (PROPERTY, "; ".join([found.outcome.upper(), *found.cells]))
        )
        expected, reason = _expected(request)
        if expected and found.outcome in expected:
            pytest.xfail(": ".join(part for part in (found.line, reason) if part))
        if expected:
            pytest.fail(f"{found.line}\nexpected was {' or '.join(expected)}\n{found.told}")
        if not found.met:
            pytest.fail(found.told)

    return assert_order


def _guarded(
    request: pytest.FixtureRequest, table: tuple[Any, ...], study: Any, options: dict[str, Any]
) -> tuple[Any, str]:
    """What was found, or what is wrong with the arguments."""
    from esfem.cli import pytest_order
    from esfem.common.bad_input import BadInput

    if study is not None and table:
        return None, "either h, errors and an order, or a study"
    called: Callable[..., Any] = pytest_order.guard_table
    if study is not None:
        called, table = pytest_order.guard_study, (study,)
        if "out" not in options:
            options = {**options, "out": request.getfixturevalue("esfem_results")}
    known = signature(called).parameters
    unknown = [name for name in options if name not in known]
    if unknown:
        return None, f"unknown keyword {unknown[0]}; must be one of {', '.join(known)}"
    try:
        signature(called).bind(*table, **options)
    except TypeError as error:
        return None, str(error)
    try:
        return called(*table, **options), ""
    except BadInput as error:
        return None, str(error)


def _expected(request: pytest.FixtureRequest) -> tuple[tuple[str, ...], str]:
    """The outcomes that the marker names, and its reason."""
    __tracebackhide__ = True
    marker = request.node.get_closest_marker("esfem_expects")
    if marker is None:
        return (), ""
    words = tuple(str(word).lower() for word in marker.args)
    strange = [word for word in words if word not in EXPECTABLE]
    if strange or not words:
        told = f"esfem_expects({', '.join(map(repr, marker.args))})"
        pytest.fail(f"{told}: must name some of {', '.join(map(repr, EXPECTABLE))}")
    return words, str(marker.kwargs.get("reason", ""))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """A table of all orders that the session judged, whichever worker did."""
    rows = [HEADINGS]
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") != "call":
                continue
            for name, said in report.user_properties:
                if name == PROPERTY:
                    rows.append((report.nodeid[-LONGEST:], *str(said).split("; ", 3)))
    if len(rows) == 1:
        return
    rows[1:] = sorted(rows[1:])
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADINGS))]
    terminalreporter.section("orders of convergence (esfem)")
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        terminalreporter.write_line("  ".join(cells).rstrip())
