"""Study and flow files for tests: small ones, and the text of variations of them."""

import json
import re
from pathlib import Path

SMALL = """
[study]
name = "small"
title = "A small study"
claim = "section-7"
superconvergent = { x = "A", nu = "B", H = "C" }

[solution]
name = "sphere"
radius = 1.0

[law]
name = "willmore"

[scheme]
degree = 2
bdf = 2
project = true
theta = false
reaction = "extrapolated"

[sweep]
vertices = [30, 60, 120, 240, 480]
tau = [0.25, 0.125]
final_time = 0.5
"""

# What is replaced where another scheme than kll takes part.
BDF_LINES = 'bdf = 2\nproject = true\ntheta = false\nreaction = "extrapolated"'

SMALL_FLOW = """
[flow]
name = "small"
title = "A small flow"

[start]
surface = "ellipsoid"
vertices = 60

[law]
name = "willmore"

[scheme]
degree = 2
bdf = 2
project = true
theta = false

[time]
tau = 0.01
final_time = 0.06

[output]
every = 0.02
pictures = [0.0, 0.05]

[checks]
energy_decreases = true
"""


def write_study(folder: Path, *replacements: tuple[str, str], name: str = "study.toml") -> Path:
    """The small study with pieces of its text replaced; each must occur."""
    return write_varied(folder / name, SMALL, *replacements)


def small_study(folder: Path, *replacements: tuple[str, str], **lines: object) -> Path:
    """The small study with other values after these keys, None for no such line, and pieces of its
    text replaced; ``name`` is also that of the file."""
    text = SMALL
    for key, value in lines.items():
        line = "" if value is None else f"{key} = {json.dumps(value)}\n"
        found = re.search(rf"^{key} = .*\n", text, re.MULTILINE)
        assert found, key
        text = text[: found.start()] + line + text[found.end() :]
    return write_varied(folder / f"{lines.get('name', 'study')}.toml", text, *replacements)


def write_flow(folder: Path, *replacements: tuple[str, str]) -> Path:
    """The small flow with pieces of its text replaced; each must occur."""
    return write_varied(folder / "small.toml", SMALL_FLOW, *replacements)


def write_varied(path: Path, text: str, *replacements: tuple[str, str]) -> Path:
    """Write the text with pieces of it replaced; each must occur."""
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path
