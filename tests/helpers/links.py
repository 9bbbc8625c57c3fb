"""The installed package as a tree of links, for tools that do not see an editable install.

``python tests/helpers/links.py build/types`` makes build/types/esfem with the children of
harness/, and solver/ and reference_solutions/ beside them: what a wheel holds.
"""

import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def link(place: Path, root: Path = ROOT) -> None:
    """Make the folder ``place`` anew, with the package esfem of that checkout in it."""
    shutil.rmtree(place, ignore_errors=True)
    package = place / "esfem"
    package.mkdir(parents=True)
    for child in (*(root / "harness").iterdir(), root / "solver", root / "reference_solutions"):
        if child.name != "__pycache__":
            (package / child.name).symlink_to(child)


if __name__ == "__main__":
    link(Path(sys.argv[1]))
