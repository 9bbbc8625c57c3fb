"""The paper's quantitative sentences, each decided by a named check of stored results."""

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from inspect import signature
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from esfem.campaigns.paper.sentence_checks import CHECKS
from esfem.campaigns.paper.stored_results import (
    Evidence,
    Finding,
    Missing,
    Part,
    evidence,
    within,
)
from esfem.common.provenance import numerics_digest
from esfem.judging.outcome import Outcome
from esfem.results.error_verdicts import ErrorName
from esfem.results.study_result import StudyResult
from esfem.results.tables import SYMBOLS

SENTENCES = Path(__file__).with_name("sentences.toml")


class Sentence(BaseModel):
    """One entry of `sentences.toml`.

    ``label`` is that of the paper's LaTeX source, ``section`` its number, ``quote`` verbatim;
    ``studies`` name what the check is given: "STUDY", "flows/FLOW" or "extra/TABLE"; ``part`` is
    that of the grids of the studies on which the sentence is read, ``note`` says how it is read.
    A sentence that does not say which error it is about has ``errors``, and is judged in each.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    label: str
    section: str
    quote: str
    studies: list[str] = Field(min_length=1)
    check: str
    parameters: dict[str, Any] = Field(default_factory=dict)
    errors: list[ErrorName] = Field(default_factory=list)
    part: Part | None = None
    note: str = ""

    @model_validator(mode="after")
    def _fits_the_check(self) -> "Sentence":
        if self.check not in CHECKS:
            raise ValueError(f"check = {self.check!r}: must be one of {', '.join(CHECKS)}")
        wanted = signature(CHECKS[self.check])
        for error in self.read_in:
            try:
                wanted.bind(*self.studies, **self.given(error))
            except TypeError as misfit:
                raise ValueError(
                    f"studies = {self.studies!r}, parameters = {self.given(error)!r}: "
                    f"check {self.check}{wanted}: {misfit}"
                ) from misfit
        if len(set(self.errors)) < len(self.errors):
            raise ValueError(f"errors = {self.errors!r}: must be different ones")
        if self.part is not None and any("/" in name for name in self.studies):
            raise ValueError(f"part: is for studies alone, not for {', '.join(self.studies)}")
        return self

    @property
    def read_in(self) -> list[ErrorName | None]:
        """The errors in which it is judged, a line each; None where its check knows them itself."""
        return [*self.errors] or [None]

    def given(self, error: ErrorName | None) -> dict[str, Any]:
        """The parameters of its check, for a line about that error."""
        return self.parameters if error is None else {**self.parameters, "error": error}

    def read_on(self, found: Evidence) -> Evidence:
        """What the check is given of what was found: the part that the sentence is read on."""
        if self.part is None or not isinstance(found, StudyResult):
            return found
        return within(found, self.part)


@dataclass(frozen=True)
class Line:
    """One line of sentences.json.

    ``error`` says in which error it was judged, where the sentence does not; ``numerics`` is the
    digest of the program that judged it.
    """

    label: str
    section: str
    quote: str
    study: str
    measured: str
    expected: str
    verdict: Outcome
    note: str
    error: str = ""
    numerics: str = field(default_factory=numerics_digest)


def sentences(path: Path = SENTENCES) -> list[Sentence]:
    """All sentences, in the paper's order."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    return [Sentence.model_validate(entry) for entry in table["sentence"]]


def judged(sentence: Sentence, runs: Path, extra: Path) -> list[Line]:
    """The sentence with what was measured, a line for each error in which it is judged;
    inconclusive if a study has not been run.

    Parameters
    ----------
    runs, extra : the folders of studies and flows, and of extra tables.
    """
    return [_judged(sentence, error, runs, extra) for error in sentence.read_in]


def _judged(sentence: Sentence, error: ErrorName | None, runs: Path, extra: Path) -> Line:
    found: list[Evidence] = []
    try:
        found = [sentence.read_on(evidence(runs, extra, name)) for name in sentence.studies]
        finding = CHECKS[sentence.check](*found, **sentence.given(error))
    except Missing as missing:
        finding = Finding("", "", "inconclusive", str(missing))
    notes = [note for note in (sentence.note, finding.note) if note]
    return Line(
        label=sentence.label,
        section=sentence.section,
        quote=sentence.quote,
        study=", ".join(sentence.studies),
        measured=finding.measured,
        expected=finding.expected,
        verdict=finding.verdict,
        note="; ".join(notes),
        error="" if error is None else _told(error, found),
    )


def _told(error: ErrorName, found: Iterable[Evidence]) -> str:
    """The error in symbols, and the unit of length of its norm where a claim has one."""
    lengths = {f.study.claimed_length for f in found if isinstance(f, StudyResult)} - {None}
    return ", ".join([SYMBOLS[error], *(f"L = {length:g}" for length in lengths)])
