"""How a study walks through the program: which rooms and modules call which, by sys.setprofile.

``python tests/helpers/walk.py`` prints the walk of a small study from ``esfem run --jobs 1`` to its
verdict. Cells are computed in a process of their own, so what is followed is all but the numerics.
docs/walk.md tells it in ten lines.
"""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from dis import get_instructions
from functools import cache, cached_property
from inspect import CO_GENERATOR
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType, FrameType
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
HARNESS = ROOT / "harness"
ROOMS = tuple(sorted(path.parent.name for path in HARNESS.glob("*/__init__.py")))


@dataclass(frozen=True)
class Call:
    """A call from one module of harness/ into another one, by a way that no call took before.

    It ``reads`` where it is hidden behind a dot: a property of a value that was handed over.
    """

    caller: str  # module
    module: str
    function: str
    leaves: str  # room
    room: str
    reads: bool


def calls(walk: Callable[[], Any]) -> tuple[list[Call], Counter[str]]:
    """The calls from module to module while ``walk`` runs, in order, and how many each module got.

    The caller is the nearest function of harness/ on the stack. A call counts once for each way,
    from function to function, on which it is reached: a loop is walked once. What an import runs,
    and a generator that goes on, are no calls.
    """
    found: list[Call] = []
    received: Counter[str] = Counter()
    ways: set[tuple[tuple[str, str], ...]] = set()

    def profile(frame: FrameType, event: str, _: Any) -> None:
        if event != "call" or module_of(frame) is None or goes_on(frame):
            return
        way = stack(frame)
        if any(function == "<module>" for _, function in way):
            return
        (caller, _), (module, function) = (("", ""), *way)[-2:]
        leaves, room = room_of(caller) if caller else "", room_of(module)
        if module == caller and leaves == room:
            return
        received[module] += 1
        if way not in ways:
            ways.add(way)
            reads = is_property(frame)
            found.append(Call(caller, module, function, leaves, room, reads))

    sys.setprofile(profile)
    try:
        walk()
    finally:
        sys.setprofile(None)
    return found, received


def stack(frame: FrameType | None) -> tuple[tuple[str, str], ...]:
    """Module and function of the frames of harness/, the outermost first."""
    found = []
    while frame is not None:
        if (module := module_of(frame)) is not None:
            found.append((module, frame.f_code.co_qualname))
        frame = frame.f_back
    return tuple(reversed(found))


def goes_on(frame: FrameType) -> bool:
    """Whether it is a generator that was left before."""
    return bool(frame.f_code.co_flags & CO_GENERATOR) and frame.f_lasti > begins(frame.f_code)


@cache
def begins(code: CodeType) -> int:
    """The offset at which its function is entered."""
    return next(step.offset for step in get_instructions(code) if step.opname == "RESUME")


def module_of(frame: FrameType) -> str | None:
    """The dotted name of a module in a room of esfem; None of any other."""
    name = frame.f_globals.get("__name__", "")
    return name if name.startswith("esfem.") and name.split(".")[1] in ROOMS else None


def is_property(frame: FrameType) -> bool:
    """Whether the function is a property of a class, or makes a dataclass."""
    owner, _, name = frame.f_code.co_qualname.rpartition(".")
    if owner.endswith("<locals>"):
        return name == "__init__"
    place: Any = sys.modules[frame.f_globals["__name__"]]
    for part in filter(None, owner.split(".")):
        place = getattr(place, part)
    return isinstance(vars(place).get(name), property | cached_property)


def room_of(module: str) -> str:
    """The room of a module."""
    return module.split(".")[1]


def stays(found: Sequence[Call]) -> list[str]:
    """The rooms that are entered from another one, in order; twice in a row is one stay."""
    rooms = [call.room for call in found if call.room != call.leaves]
    return [room for room, _ in groupby(rooms)]


def way(found: Sequence[Call]) -> list[str]:
    """The functions that are called from another room, in the order of first calls; without those
    of common, with a leading underscore, and properties."""
    names = (
        f"{call.module.removeprefix('esfem.')}.{call.function}"
        for call in found
        if call.room not in (call.leaves, "common")
        and not (call.reads or call.function.rpartition(".")[2].startswith("_"))
    )
    return list(dict.fromkeys(names))


def walk_of_study(folder: Path) -> tuple[list[Call], Counter[str]]:
    """The calls from ``esfem run`` to the verdict of a small study that claims an order."""
    from studies import write_study

    from esfem.cli import main
    from esfem.schemes import named_scheme

    named_scheme.cache_clear()  # what was called before is called again
    path = write_study(folder)
    sys.argv = ["esfem", "run", str(path), "--out", str(folder / "out"), "--jobs", "1"]

    def run() -> None:
        with suppress(SystemExit):
            main()

    return calls(run)


def show(found: Sequence[Call], received: Counter[str]) -> None:
    """Print the walk: the rooms in order, and what is called in each."""
    called = [call for call in found if not call.reads]
    knowing = [call for call in found if call.room != "common"]
    print(f"{len(stays(found))} stays, {len(stays(called))} without properties")
    print(f"{len(stays(knowing))} stays beside those in common, which knows no mathematics")
    print(f"selection was called {received['esfem.results.selection']} times")
    outward = [call for call in called if call.room != call.leaves]
    for room, entered in groupby(outward, lambda call: call.room):
        names = (f"{call.module.removeprefix('esfem.')}.{call.function}" for call in entered)
        print(f"{room:10} {', '.join(dict.fromkeys(names))}")


if __name__ == "__main__":
    with TemporaryDirectory() as place:
        show(*walk_of_study(Path(place)))
