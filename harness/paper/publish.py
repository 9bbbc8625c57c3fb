"""What `esfem paper` publishes of its results: studies, and of each flow a few files."""

from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from harness.files import write_text
from harness.light import copy, copy_studies
from harness.paper.evidence import FLOWS

MOST_BYTES = 15_000_000
OF_A_FLOW = ("checks.json", "energy.svg")
PICTURES = "surfaces.png"
COLOURS = 128  # of a published picture: a quarter of the bytes, and hardly to be seen
MOST_LEVELS = 500  # of a published history: a flow of 5000 steps would fill a megabyte


def publish(runs: Path, out: Path, studies: Sequence[str], flows: Sequence[str]) -> None:
    """Copy the light part of those studies and flows from ``runs`` to ``out``."""
    copy_studies(runs, out, studies)
    for name in flows:
        source, target = runs / FLOWS / name, out / FLOWS / name
        copy(OF_A_FLOW, source, target)
        if (source / PICTURES).is_file():
            fewer_colours(source / PICTURES, target / PICTURES)
        if (source / "history.csv").is_file():
            text = thinned((source / "history.csv").read_text(encoding="utf-8"), MOST_LEVELS)
            write_text(target / "history.csv", text)


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
