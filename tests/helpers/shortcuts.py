"""What tests leave out unless they ask for it: processes of their own, and the layout of figures.

Another process takes two seconds to start, and what a test patches does not reach it. To lay out
and to write the figures of a study takes two seconds more, to compute a small one takes one.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from esfem.runs.executors import LocalProcesses

PROCESSES, SAVE = LocalProcesses.run, Figure.savefig
BLANK = {".svg": '<svg xmlns="http://www.w3.org/2000/svg"/>', ".pdf": "%PDF-1.4"}


def run_here(self, function: Callable, items) -> Iterator[tuple[Any, Any]]:
    """As `LocalProcesses.run`, in this process."""
    return ((item, function(item)) for item in items)


def save_blank(self, place, **how: Any) -> None:
    """As `Figure.savefig`; a file with lines alone is left blank."""
    blank = BLANK.get(Path(place).suffix) if isinstance(place, str | Path) else None
    if blank is None:
        SAVE(self, place, **how)
    else:
        Path(place).write_text(blank)


@contextmanager
def computed_by(run: Callable) -> Iterator[None]:
    """Cells are computed by this method of `LocalProcesses`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LocalProcesses, "run", run)
        yield


@contextmanager
def saved_by(save: Callable) -> Iterator[None]:
    """Figures are saved by this method of `Figure`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", save)
        yield
