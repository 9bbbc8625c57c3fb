"""The registry of seeded bugs, read from `mutants.toml`."""

import tomllib
from pathlib import Path
from typing import Any

from esfem.campaigns.mutants.patching import Edit, Mutant


def _mutant(group: str, entry: dict[str, Any]) -> Mutant:
    """The mutant of one table: its edits, or the only one, which stands in the table itself."""
    rest = {key: value for key, value in entry.items() if key not in ("where", "old", "new")}
    edits = rest.pop("edits", None) or [{key: entry[key] for key in ("where", "old", "new")}]
    return Mutant(group=group, edits=tuple(Edit(**edit) for edit in edits), **rest)


_GROUPS = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))
MUTANTS: tuple[Mutant, ...] = tuple(
    _mutant(group, entry) for group, entries in _GROUPS.items() for entry in entries
)
