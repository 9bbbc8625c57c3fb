"""The light part of results, which is committed: tables and verdicts, no records; of each flow a
few files."""

import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from PIL import Image

from esfem.common.files import write_text
from esfem.results.result_files import TABLES, VERDICTS

MOST_BYTES = 15_000_000
OF_A_FLOW = ("checks.json", "energy.svg")
PICTURES = "surfaces.png"
COLOURS = 128  # of a published picture: a quarter of the bytes, and hardly to be seen
MOST_LEVELS = 500  # of a published history: a flow of 5000 steps would fill a megabyte


def copy_studies(runs: Path, out: Path, names: Sequence[str]) -> None:
    """Copy the light part of those studies from ``runs`` to ``out``.

    What is not there, or not finished, is left as it is. verdicts.json, which names the other files
    of a study with their digests, comes last.
    """
    for name in names:
        _copy(files_of_study(runs / name), runs / name, out / name)


def files_of_study(folder: Path) -> tuple[str, ...]:
    """The tables of a study and verdicts.json; none if that is not there.

    Figures are left to the report, which draws them anew.
    """
    return (*TABLES, VERDICTS) if (folder / VERDICTS).exists() else ()


def copy_flows(runs: Path, out: Path, names: Sequence[str]) -> None:
    """Copy the light part of those flows from ``runs`` to ``out``."""
    for name in names:
        source, target = runs / name, out / name
        _copy(OF_A_FLOW, source, target)
        if (source / PICTURES).is_file():
            fewer_colours(source / PICTURES, target / PICTURES)
        if (source / "history.csv").is_file():
            text = thinned((source / "history.csv").read_text(encoding="utf-8"), MOST_LEVELS)
            write_text(target / "history.csv", text)


def _copy(names: Iterable[str], source: Path, target: Path) -> None:
    """Copy those of the files that are there."""
    for name in names:
        if (source / name).is_file():
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source / name, target / name)


def fewer_colours(source: Path, target: Path) -> None:
    """The PNG picture with a palette of `COLOURS` of its own."""
    with Image.open(source, formats=["PNG"]) as picture:
        few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(target, "png", optimize=True)


def thinned(table: str, most: int) -> str:
    """The CSV table with its head, every so many lines so that about ``most`` are left, and its
    last line."""
    head, *lines = table.splitlines(keepends=True)
    stride = max(1, -(-len(lines) // most))
    kept = [line for i, line in enumerate(lines) if i % stride == 0 or i == len(lines) - 1]
    return "".join([head, *kept])


def size(folder: Path) -> int:
    """Bytes of all files in the folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
