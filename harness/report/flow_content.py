"""The tables and pictures of one flow."""

import base64
import io
from pathlib import Path

import pandas as pd
from PIL import Image

from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import describe_flow
from esfem.flows.flow_results import FlowResult
from esfem.report.content import Table

WIDEST = 1100  # pixels of an embedded picture
COLOURS = 256


def course(result: FlowResult) -> str:
    """The flow in one line, how it ended, for example "diverged: element 3 is inverted", what it
    took, and what is claimed."""
    ending = f"{result.status}: {result.reason}" if result.reason else result.status
    described, claim = describe_flow(result.flow, result.nodes), result.order_claim
    return f"{described}; {ending}; {cost(result)}; order claim: {claim}"


def cost(result: FlowResult) -> str:
    """For example "5126 steps in 93 s, 0.1 GMRES iterations a step".

    A published history has not all levels: steps are counted by their times, and iterations are
    the mean of those that are there.
    """
    history = result.history
    steps = result.flow.levels.at(history.last("t"))
    iterations = history.column("iterations")[1:].mean() if steps else 0.0
    return f"{steps} steps in {result.seconds:.0f} s, {iterations:.1f} GMRES iterations a step"


def checks(result: FlowResult) -> Table:
    """What was expected of the flow, and whether it did it."""
    rows = [
        {
            "verdict": check.verdict.upper(),
            "check": check.name,
            "measured": f"{check.measured:.3g}",
            "bound": f"{check.bound:.3g}",
            "in words": check.text,
        }
        for check in result.checks
    ]
    columns = ["verdict", "check", "measured", "bound", "in words"]
    return Table("checks", "Checks", pd.DataFrame(rows, columns=columns))


def levels(result: FlowResult) -> Table:
    """The first, the middle and the last level, and the extremes of each column."""
    history = result.history
    names = ("t", "energy", "willmore", "area", "volume", "least_normal", "greatest_normal")
    names += ("least_area_element", "speed", "iterations")
    rows = []
    for which, n in {"start": 0, "middle": len(history.rows) // 2, "end": -1}.items():
        values = {name.replace("_", " "): f"{history.column(name)[n]:.6g}" for name in names}
        rows.append({"level": which, **values})
    for which, extreme in {"least": "min", "greatest": "max"}.items():
        found = {name: getattr(history.column(name), extreme)() for name in names}
        rows.append({"level": which, **{k.replace("_", " "): f"{v:.6g}" for k, v in found.items()}})
    tells = f"energy: {history.energy}; willmore: W = 1/2 int H^2"
    return Table("levels", "Levels", pd.DataFrame(rows), tells=tells, leading=False)


def provenance(result: FlowResult) -> dict[str, str]:
    """Where the numbers come from."""
    stored = dict(result.environment)
    told = [stored.pop(name, "not stored") for name in ("version", "numerics", "machine")]
    return {
        "program": f"esfem-willmore {told[0]} (numerics {told[1]})",
        "machine": told[2],
        "libraries of the run": ", ".join(f"{name} {number}" for name, number in stored.items()),
    }


def pictures(result: FlowResult) -> dict[str, str]:
    """The PNG pictures in its folder by name, made smaller, as data URIs."""
    found = sorted(result.folder.glob("*.png"))
    return {path.stem: f"data:image/png;base64,{_smaller(path)}" for path in found}


def _smaller(path: Path) -> str:
    """A picture of so many colours and pixels at most, in base64."""
    try:
        with Image.open(path, formats=["PNG"]) as picture:  # others may start programs
            small = picture.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise BadInput(f"{path}: no picture that can be read: {error}") from error
    small.thumbnail((WIDEST, 4 * WIDEST))
    stream = io.BytesIO()
    palette = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE)  # keeps white white
    small.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(stream, "png")
    return base64.b64encode(stream.getvalue()).decode("ascii")
