"""The LaTeX of a report: balanced, complete, and compiled where there is a compiler."""

import re
import shutil
import subprocess

import pandas as pd
import pytest
from pages import BASELINE, HOSTILE

from esfem.common.tex_text import ESCAPES, PHRASES, SYMBOLS, escaped
from esfem.report.content import Table
from esfem.report.tex import longtable
from esfem.results.result_files import load_result
from esfem.results.tables import latex

PDFLATEX = shutil.which("pdflatex")
MATH = re.compile(r"(?<!\\)\$[^$]*\$")


@pytest.fixture
def tex(report):
    return report / "tex"


def objections(text):
    """What is wrong with the nesting of environments and braces."""
    stack, wrong = [], []
    text = re.sub(r"(?<!\\)%.*", "", text)  # a comment may say what it likes
    for kind, name in re.findall(r"\\(begin|end)\{(\w+)\}", text):
        if kind == "begin":
            stack.append(name)
        elif not stack or stack.pop() != name:
            wrong.append(f"\\end{{{name}}} ends another environment")
    bare = re.sub(r"\\[{}\\]", "", text)
    wrong += ["braces"] * (bare.count("{") != bare.count("}"))
    return wrong + [f"{name} is not ended" for name in stack]


@pytest.mark.slow
def test_every_file_is_balanced_and_refers_to_files_that_are_there(tex):
    files = {path.stem: path.read_text(encoding="utf-8") for path in tex.glob("*.tex")}
    assert {"main", "summary", "sentences", "study-clifford", "flow-small", "extra-0"} <= set(files)
    for name, text in files.items():
        assert objections(text) == [], name
        for read in re.findall(r"\\input\{([^}]+)\}", text):
            assert read in files
        for figure in re.findall(r"\\includegraphics\[[^]]*\]\{([^}]+)\}", text):
            assert (tex / figure).stat().st_size > 0


@pytest.mark.slow
def test_figures_have_names_that_latex_can_read_and_foreign_ones_are_numbered(tex):
    texts = [path.read_text(encoding="utf-8") for path in tex.glob("*.tex")]
    shown = re.findall(r"\\includegraphics\[[^]]*\]\{(.*)\}", "\n".join(texts))
    assert all(re.fullmatch(r"[a-z0-9-]+\.(pdf|png)", name) for name in shown)
    assert {"flow-small-picture-0.png", "extra-0-figure.pdf"} < set(shown)
    assert {path.name for path in tex.iterdir() if path.suffix != ".tex"} == set(shown)


@pytest.mark.slow
def test_every_study_has_its_verdicts_and_errors(tex, folder):
    text = (tex / "study-clifford.tex").read_text(encoding="utf-8")
    result = load_result(folder / "clifford")
    for verdict in result.verdicts:
        assert f"{verdict.observed:.2f}" in text
        assert f"[{verdict.lower:.2f}, {verdict.upper:.2f}]" in text
    # Of each tau the errors, and those against the interpolation.
    assert text.count(r"\begin{tabular}") == 2 * len(result.study.sweep.tau)


@pytest.mark.slow
def test_no_label_occurs_twice(tex):
    texts = [path.read_text(encoding="utf-8") for path in tex.glob("*.tex")]
    labels = re.findall(r"\\label\{([^}]+)\}", "".join(texts))
    assert 15 < len(labels) == len(set(labels)) < 60


@pytest.mark.slow
def test_the_document_is_whole(tex):
    main = (tex / "main.tex").read_text(encoding="utf-8")
    assert main.count(r"\begin{document}") == main.count(r"\end{document}") == 1


@pytest.mark.slow
@pytest.mark.skipif(PDFLATEX is None, reason="without pdflatex nothing is compiled")
def test_it_compiles(tex):
    command = [PDFLATEX, "-interaction=nonstopmode", "-halt-on-error", "main.tex"]
    done = subprocess.run(command, cwd=tex, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Missing character" not in done.stdout


def test_a_foreign_title_is_text():
    found = MATH.sub("", escaped(HOSTILE))
    assert r"\end{document}" not in found
    assert not re.search(r"(?<!\\)[$&%#_]", found)


@pytest.mark.parametrize("character", [*ESCAPES, *SYMBOLS, "ß", "é", "漢", "Ж", "\u202e"])
def test_every_character_is_known_ascii_or_shown_as_its_number(character):
    found = escaped(character)
    assert found.isascii() or found in "ßé"
    if character in "漢Ж\u202e":
        assert found == f"[U+{ord(character):04X}]"


@pytest.mark.parametrize("phrase", PHRASES)
def test_phrases_are_formulas_wherever_they_stand(phrase):
    assert escaped(f"a_{phrase}_b") == rf"a\_{PHRASES[phrase]}\_b"


def test_the_heads_of_rate_tables_are_formulas():
    result = load_result(BASELINE / "clifford")
    heads = [line for line in latex(result).splitlines() if "EOC" in line]
    assert any(r"& $\nu$ & EOC & $H$ & EOC" in line for line in heads)
    assert not any(r"\$" in line for line in heads)


def test_a_long_table_has_a_column_for_each_name():
    frame = pd.DataFrame({"a": ["1"], "b": ["x_y"], "c": ["w " * 40]})
    found = longtable(Table("t", "A & B", frame), "s")
    assert re.search(r"\{longtable\}\{rl>\{[^}]*\}p\{0\.\d\d\\linewidth\}\}", found)
    assert r"1 & x\_y & " in found
    assert r"A \& B" in found
    assert objections(found) == []
