"""Colours, markers and style that all plots and reports share.

Okabe and Ito's colours, which colour-blind readers can tell apart. Nothing is told by colour alone:
series differ in their markers too, and verdicts in their symbols.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
MARKERS = ("o", "s", "^", "D", "v", "P", "*", "h")
STYLE: "dict[RcKeyType, Any]" = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "legend.frameon": False,
    "svg.hashsalt": "esfem-willmore",  # the same data give the same file
    "svg.fonttype": "none",
}


@dataclass(frozen=True)
class Look:
    """How a verdict looks: a colour of the palette, and a symbol that tells it without colour."""

    colour: str
    symbol: str


# By the outcome that a verdict is.
LOOKS: dict[str, Look] = {
    "pass": Look(PALETTE[2], "✓"),
    "super": Look(PALETTE[0], "▲"),
    "inconclusive": Look(PALETTE[4], "?"),
    "suspect": Look(PALETTE[3], "!"),
    "fail": Look(PALETTE[1], "✗"),
    "not exercised": Look(PALETTE[7], "⊘"),
    "no claim": Look(PALETTE[7], "○"),
}
