"""SVG for a page that holds many: small, without outside references, and no id twice."""

import io
import re
from pathlib import Path
from xml.etree import ElementTree

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from harness.bad_input import BadInput
from harness.palette import STYLE

SVG = "{http://www.w3.org/2000/svg}"
XLINK = "{http://www.w3.org/1999/xlink}href"
DROPPED = ("metadata", "script", "foreignObject", "title", "desc", "image", "a")
NUMBER = re.compile(r"-?\d+\.\d{2,}")
DIGITS = 2  # behind the point, of coordinates: a hundredth of a point cannot be seen
FONTS = re.compile(r"font-family: 'DejaVu Sans'[^;]*sans-serif;? ?")  # the page names them once
SERIES = re.compile(r"series-(\d+)-")
REFERENCE = re.compile(r"url\(\s*['\"]?#([^)'\"]+)['\"]?\s*\)")


def drawn(figure: Figure) -> str:
    """The figure as the text of an SVG file, the same for the same data; the figure is closed."""
    stream = io.StringIO()
    with plt.rc_context(STYLE):
        figure.savefig(stream, format="svg", metadata={"Date": None})
    plt.close(figure)
    return stream.getvalue()


def read_svg(path: Path) -> str:
    """The text of an SVG file; BadInput if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read: {error}") from error


def inline(text: str, prefix: str, title: str) -> str:
    """An SVG document as an element to be put into HTML.

    Ids begin with ``prefix``, groups named "series-0-..." have the class s0; ``title`` is what it
    shows, in words. Scripts, pictures, links and what points out of the document are left out.

    Raises
    ------
    BadInput
        If it is no SVG document.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise BadInput(f"figure of {prefix}: no SVG: {error}") from error
    if root.tag != f"{SVG}svg":
        raise BadInput(f"figure of {prefix}: no SVG: its root is {root.tag}")
    _drop(root)
    referred = _referred(root)
    for element in root.iter():
        _rewrite(element, prefix, referred)
    _share_styles(root, prefix)
    _entitle(root, prefix, title)
    return ElementTree.tostring(root, encoding="unicode")


def _drop(parent: ElementTree.Element) -> None:
    """Take away what an inline figure neither needs nor may have, and blanks between elements."""
    for child in list(parent):
        if not isinstance(child.tag, str) or child.tag.removeprefix(SVG) in DROPPED:
            parent.remove(child)
        else:
            child.tail = child.tail if child.tail and child.tail.strip() else None
            _drop(child)
    if parent.text and not parent.text.strip() and len(parent):
        parent.text = None


def _referred(root: ElementTree.Element) -> set[str]:
    """The ids that something in the document points to."""
    found = set()
    for element in root.iter():
        for name, value in element.attrib.items():
            found |= {value[1:]} if name in ("href", XLINK) and value.startswith("#") else set()
            found |= set(REFERENCE.findall(value))
        found |= set(REFERENCE.findall(element.text or ""))
    return found


def _rewrite(element: ElementTree.Element, prefix: str, referred: set[str]) -> None:
    """Names and attributes of one element as they are to be in the page."""
    element.tag = element.tag.removeprefix(SVG)
    attributes = dict(element.attrib)
    element.attrib.clear()
    if element.tag == "style":
        element.text = (element.text or "").replace("*{", f"#{prefix} *{{").replace("@import", "")
    for name, value in attributes.items():
        if name == "id":
            series = SERIES.match(value)
            if series:
                element.set("class", f"s{series[1]}")
            if value in referred:
                element.set("id", f"{prefix}-{value}")
        elif name in ("href", XLINK):
            if value.startswith("#"):
                element.set("href", f"#{prefix}-{value[1:]}")
        elif not name.startswith(("on", "{")):
            element.set(name, _shortened(REFERENCE.sub(rf"url(#{prefix}-\1)", value)))


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
