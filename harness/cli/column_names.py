r"""What the name of a column says: "n cells", "L2 error", "$\|e\|_{L^2}$", "rate_h1", "Fehler"."""

import re
import unicodedata
from typing import Literal

Kind = Literal["h", "tau", "cells", "dofs", "error", "rate", "status", "variable", ""]

TEX = {
    **{r"\\(?:infty|infinity)": "inf", r"\\(?:tau)": "tau", r"\\(?:Delta|delta)": "delta "},
    **{r"\\(?:max)": "max", r"\\(?:rm|mathrm|text|bf|textbf|mathbf|operatorname|it|mathit)": " "},
}
SIGNS = str.maketrans({"τ": "tau", "Δ": "delta ", "δ": "delta ", "∞": "inf", "‖": " ", "#": " "})
NAMES: dict[Kind, tuple[str, ...]] = {
    "h": (
        *("h", "hmax", "maxh", "meshwidth", "meshsize", "dx", "deltax", "gridspacing", "spacing"),
        *("cellsize", "gridsize", "elementsize", "maxcellsize", "meshparameter", "celldiameter"),
        *(
            "maxdiameter",
            "diameter",
            "hmean",
            "havg",
            "gitterweite",
            "maschenweite",
            "schrittweite",
        ),
    ),
    "tau": (
        *("tau", "dt", "deltat", "timestep", "timestepsize", "steplength", "zeitschritt"),
        *("zeitschrittweite",),
    ),
    "cells": (
        *(
            "n",
            "nx",
            "cells",
            "ncells",
            "nocells",
            "numcells",
            "numberofcells",
            "nc",
            "activecells",
        ),
        *("nactivecells", "numberofactivecells", "elements", "nelements", "numelements", "nelem"),
        *("nelems", "numberofelements", "ne", "nel", "elems", "points", "npoints", "gridpoints"),
        *("resolution", "zellen", "elemente", "1h", "1dx", "hinv", "invh"),
        *("grid", "mesh"),
    ),
    "dofs": (
        *("dofs", "dof", "ndofs", "ndof", "numdofs", "numdof", "numberofdofs", "freedofs"),
        *("unknowns", "nunknowns", "degreesoffreedom", "numberofdegreesoffreedom", "nodes"),
        *("nnodes", "numberofunknowns", "freiheitsgrade", "vertices", "nvertices"),
    ),
    "status": ("status", "state", "success"),
    "variable": ("variable", "var", "norm", "quantity", "field", "component", "groesse"),
}
NORM = (
    r"l1|l2|linf(?:ty|inity)?|lmax|max|sup|rms|rmse|mae|h1semi|h1|h2semi|h2|h3|hdiv|hcurl|h0|"
    r"energy|grad|gradient|dg|w1inf|w11|linftyl2|linfl2|l2l2|l2h1|linfh1"
)
ERROR = re.compile(
    rf"(?:abs|rel|d)?(?:e|er|err|errors?|fehler)?({NORM})(?:semi|norm|seminorm)?(?:e|err|errors?|fehler)?"
)
PLAIN_ERROR = re.compile(
    r"(?:abs|rel|absolute|relative|max)?(?:e|er|err|errs|errors?|fehler|errornorm|discrepancy|defect)"
)
RATE = re.compile(
    r".*(?:rates?|eoc|roc|ooc)|(?:rates?|eoc|roc|ooc).*|orders?|ordnung|slope|ratio|reduction|red|"
    r"conv|(?:order|ord)[a-z]?[12]|[a-z][12](?:order|ord)|convergence"
)
# Norms of derivatives: in them an order is lost, or two, against norms of values.
DERIVATIVES = {
    **dict.fromkeys(("h1", "h1semi", "grad", "gradient", "energy", "dg", "w1inf", "w11"), 1),
    **dict.fromkeys(("l2h1", "linfh1", "hdiv", "hcurl"), 1),
    **{"h2": 2, "h2semi": 2, "h3": 3},
}


FILLING = ("of", "the", "no", "nr", "number", "num", "total", "anzahl", "der")
BARS = re.compile(r"\|\||‖|\\\||\\lVert|\\Vert")


def kind(name: str) -> Kind:
    """What a column of this name has, "" if the name does not tell."""
    if name.strip() == "E":  # an energy as often as an error
        return ""
    words, together = tokens(name), compact(name)
    if known := _known(tokens(re.sub(r"\s*[\[(][^\[(]*[\])]\s*$", "", name))):
        return known
    if any(RATE.fullmatch(word) for word in words) or together in ("p", "cr"):
        return "rate"
    if any(ERROR.fullmatch(word) or PLAIN_ERROR.fullmatch(word) for word in (*words, together)):
        return "error"
    return "error" if BARS.search(name) else ""


def _known(words: tuple[str, ...]) -> Kind:
    """The kind of a name that is one of `NAMES`, or one with its symbol: "mesh size h"."""
    words = tuple(word for word in words if word not in FILLING) or words
    for known, names in NAMES.items():
        if "".join(words) in names:
            return known
        if len(words) > 1 and "".join(words[:-1]) in names and words[-1] in names:
            return known
    return ""


def norm(name: str) -> str:
    """The norm that a name speaks of: l2, h1, linf, ...; "" if of none."""
    for word in (*tokens(name), compact(name)):
        if found := ERROR.fullmatch(word):
            return "linf" if found[1] in ("linfty", "linfinity", "lmax", "max", "sup") else found[1]
    return ""


def derivatives(name: str) -> int:
    """How many derivatives the norm of a column measures, as far as its name tells."""
    return DERIVATIVES.get(norm(name), 0)


def tokens(name: str) -> tuple[str, ...]:
    """The words of a name, in small letters: of "$|u-u_h|_{L^2}$" they are u, u, h, l2."""
    return tuple(re.findall(r"[a-z0-9]+", _spelt(name)))


def compact(name: str) -> str:
    """The letters and digits of a name, in small letters."""
    return "".join(tokens(name))


def _spelt(name: str) -> str:
    for form, word in TEX.items():
        name = re.sub(form + "(?![A-Za-z])", word, name)
    name = unicodedata.normalize("NFKC", name.translate(SIGNS)).lower().replace("ß", "ss")
    name = unicodedata.normalize("NFKD", name)
    name = re.sub(r"\\[a-z]+|[\u0300-\u036f{}$]", "", name)
    # L^2, L_2, H^1, L_inf, h_max are one word.
    name = re.sub(
        r"(?<![a-z0-9])(l|h|w)[\^_]+(\d+|inf(?:ty|inity)?|max|div)(?![a-z])", r"\1\2", name
    )
    return re.sub(r"(?<![a-z])([lh])\^?\{?(\d|inf)\}?", r" \1\2", name)
