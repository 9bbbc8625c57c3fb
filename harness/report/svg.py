"""SVG for a page that holds many: figures drawn here become part of it, any other a picture.

What this program drew is made small, and no id occurs twice. What comes from a file may hold
anything: as a picture it runs no script, loads nothing and styles nothing but itself.
"""

import io
import re
from base64 import b64encode
from pathlib import Path
from xml.etree import ElementTree

from matplotlib.figure import Figure

from esfem.common.bad_input import BadInput
from esfem.common.drawing import styled
from esfem.common.files import reading

SVG = "{http://www.w3.org/2000/svg}"
XLINK = "{http://www.w3.org/1999/xlink}href"
NUMBER = re.compile(r"-?\d+\.\d{2,}")
DIGITS = 2  # behind the point, of coordinates: a hundredth of a point cannot be seen
FONTS = re.compile(r"font-family: 'DejaVu Sans'[^;]*sans-serif;? ?")  # the page names them once
SERIES = re.compile(r"series-(\d+)-")
REFERENCE = re.compile(r"url\(#([^)]+)\)")
NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))  # the page says it for all


def drawn(figure: Figure) -> str:
    """The figure as the text of an SVG file, the same for the same data."""
    stream = io.StringIO()
    with styled():
        figure.savefig(stream, format="svg", metadata=NO_METADATA)
    return stream.getvalue()


def picture(path: Path) -> str:
    """An SVG file, whatever is in it, as the address of an <img>: ``data:image/svg+xml;...``.

    Raises
    ------
    BadInput
        If it cannot be read, or is no SVG document.
    """
    with reading(path):
        content = path.read_bytes()
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # the last: its encoding
        raise BadInput(f"{path}: no SVG: {error}") from error
    if root.tag != f"{SVG}svg":
        raise BadInput(f"{path}: no SVG: its root is {root.tag}")
    return f"data:image/svg+xml;base64,{b64encode(content).decode('ascii')}"


def inline(text: str, prefix: str, title: str) -> str:
    """What `drawn` made, as an element to be put into HTML.

    Ids begin with ``prefix``, groups named "series-0-..." have the class s0; ``title`` is what it
    shows, in words.
    """
    root = ElementTree.fromstring(text)
    values = [value for element in root.iter() for value in element.attrib.values()]
    referred = {element.get(XLINK, "")[1:] for element in root.iter()}
    referred = referred.union(*map(REFERENCE.findall, values))
    for element in root.iter():
        _rewrite(element, prefix, referred)
    _share_styles(root, prefix)
    _entitle(root, prefix, title)
    return ElementTree.tostring(root, encoding="unicode")


def _rewrite(element: ElementTree.Element, prefix: str, referred: set[str]) -> None:
    """One element as it is to be in the page: names, attributes, no blanks around elements."""
    element.tag = element.tag.removeprefix(SVG)
    element.tail = _unless_blank(element.tail)
    if len(element):
        element.text = _unless_blank(element.text)
    if element.tag == "style" and element.text:
        element.text = element.text.replace("*{", f"#{prefix} *{{")
    attributes = dict(element.attrib)
    element.attrib.clear()
    for name, value in attributes.items():
        if name == XLINK:
            element.set("href", f"#{prefix}-{value[1:]}")
        elif name != "id":
            element.set(name, _shortened(REFERENCE.sub(rf"url(#{prefix}-\1)", value)))
        elif value in referred:
            element.set("id", f"{prefix}-{value}")
        elif series := SERIES.match(value):
            element.set("class", f"s{series[1]}")


def _unless_blank(text: str | None) -> str | None:
    return text if text and text.strip() else None


def _share_styles(root: ElementTree.Element, prefix: str) -> None:
    """Each style once, as a class: they are most of the text of a figure."""
    found: dict[str, str] = {}
    for element in root.iter():
        style = FONTS.sub("", element.attrib.pop("style", "")).rstrip("; ")
        if style:
            name = found.setdefault(style, f"c{len(found)}")
            element.set("class", f"{element.get('class', '')} {name}".strip())
    rules = ElementTree.Element("style")
    rules.text = "".join(f"#{prefix} .{name}{{{style}}}" for style, name in found.items())
    root.insert(0, rules)


def _shortened(value: str) -> str:
    """Numbers with no more digits than can be seen, one blank between them."""
    short = NUMBER.sub(lambda found: f"{float(found[0]):.{DIGITS}f}".rstrip("0").rstrip("."), value)
    return " ".join(short.split())


def _entitle(root: ElementTree.Element, prefix: str, title: str) -> None:
    """Give it a name for those who cannot see it, and the width of its place."""
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    width = root.get("viewBox", "0 0 600 400").split()[2]
    root.set("style", f"--w: {width}")
    root.attrib |= {"id": prefix, "role": "img", "aria-labelledby": f"{prefix}-title"}
    heading = ElementTree.Element("title", {"id": f"{prefix}-title"})
    heading.text = title
    root.insert(0, heading)
