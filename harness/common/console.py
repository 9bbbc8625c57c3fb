"""How the command line looks: a plain console, the colours of verdicts, tables of aligned words."""

from collections.abc import Collection, Sequence

from rich.console import Console
from rich.text import Text

STYLES = {
    **dict.fromkeys(("PASS", "SUPER", "better"), "green"),
    **dict.fromkeys(("FAIL", "SUSPECT", "worse"), "bold red"),
    **dict.fromkeys(("INCONCLUSIVE", "NOT EXERCISED", "unknown"), "yellow"),
}


def plain_console(stderr: bool = False) -> Console:
    """A console that shows titles and paths as they are: "[b]" and ":x:" mean nothing to it."""
    return Console(stderr=stderr, markup=False, emoji=False, highlight=False)


def print_table(
    rows: Sequence[Sequence[str]],
    console: Console,
    headings: Sequence[str] | None = None,
    right: Collection[int] = (),
) -> None:
    """Print aligned columns, however wide the terminal is; the words of `STYLES` in their colours.

    Parameters
    ----------
    rows : as many words each.
    console : is told.
    headings : a word a column, above them.
    right : the numbers of the columns that are flush right.
    """
    looks = [] if headings is None else [[Text(word, "bold") for word in headings]]
    looks += [[Text(word, STYLES.get(word, "")) for word in row] for row in rows]
    for i, column in enumerate(zip(*looks, strict=True)):
        width = max(word.cell_len for word in column)
        for word in column:
            word.align("right" if i in right else "left", width)
    for words in looks:
        line = Text("  ").join(words)
        line.rstrip()
        console.print(line, soft_wrap=True)
