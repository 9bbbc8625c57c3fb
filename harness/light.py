"""The light part of the results, which is committed: tables and verdicts, no records."""

import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from harness.result_files import TABLES, VERDICTS


def copy_studies(runs: Path, out: Path, names: Sequence[str]) -> None:
    """Copy the light part of those studies from ``runs`` to ``out``.

    What is not there, or not finished, is left as it is. verdicts.json, which names the other files
    of a study with their digests, comes last.
    """
    for name in names:
        copy(files_of_study(runs / name), runs / name, out / name)


def files_of_study(folder: Path) -> tuple[str, ...]:
    """The tables of a study and verdicts.json; none if that is not there.

    Figures are left to the report, which draws them anew.
    """
    return (*TABLES, VERDICTS) if (folder / VERDICTS).exists() else ()


def copy(names: Iterable[str], source: Path, target: Path) -> None:
    """Copy those of the files that are there."""
    for name in names:
        if (source / name).is_file():
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source / name, target / name)
