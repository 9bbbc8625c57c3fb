"""Tables of words on a console: aligned, whole, plain where they are not coloured."""

import io

from rich.console import Console

from esfem.common.console import print_table


def printed(*arguments, width=80, colour=None, **options) -> str:
    look = {"force_terminal": colour is not None, "color_system": colour}
    console = Console(file=io.StringIO(), width=width, markup=False, emoji=False, **look)
    print_table(*arguments[:1], console, *arguments[1:], **options)
    return console.file.getvalue()


def test_columns_are_aligned_and_nothing_trails():
    found = printed([("x", "1.5"), ("long", "10")], ["", "order"], right=[1])
    assert found == "      order\nx       1.5\nlong     10\n"


def test_a_table_without_headings_is_its_rows():
    assert printed([("a", "b"), ("ccc", "d")]) == "a    b\nccc  d\n"


def test_no_word_is_cut_or_wrapped_on_a_narrow_terminal():
    words = ["w" * 30] * 4
    assert printed([words], width=40) == "  ".join(words) + "\n"


def test_letters_of_double_width_count_twice():
    assert printed([("曲面", "1"), ("abcde", "2")]) == "曲面   1\nabcde  2\n"


def test_words_are_no_markup():
    assert printed([("[b]x", ":warning:")]) == "[b]x  :warning:\n"


def test_a_table_without_rows_is_its_headings():
    assert printed([], ["a", "b"]) == "a  b\n"
    assert printed([]) == ""


def test_verdicts_have_their_colours():
    found = printed([("x", "FAIL"), ("y", "PASS"), ("FAILED", "none")], colour="standard")
    assert "\x1b[1;31mFAIL" in found and "\x1b[32mPASS" in found
    assert "\x1b" not in found.splitlines()[2]
