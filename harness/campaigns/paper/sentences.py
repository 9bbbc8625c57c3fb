"""The paper's quantitative sentences, each decided by a named check of stored results."""

import tomllib
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
from esfem.results.study_result import StudyResult

SENTENCES = Path(__file__).with_name("sentences.toml")


class Sentence(BaseModel):
    """One entry of `sentences.toml`.

    ``label`` is that of the paper's LaTeX source, ``section`` its number, ``quote`` verbatim;
    ``studies`` name what the check is given: "STUDY", "flows/FLOW" or "extra/TABLE"; ``part`` is
    that of the grids of the studies on which the sentence is read, ``note`` says how it is read.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    label: str
    section: str
    quote: str
    studies: list[str] = Field(min_length=1)
    check: str
    parameters: dict[str, Any] = Field(default_factory=dict)
    part: Part | None = None
    note: str = ""

    @model_validator(mode="after")
    def _fits_the_check(self) -> "Sentence":
        if self.check not in CHECKS:
            raise ValueError(f"check = {self.check!r}: must be one of {', '.join(CHECKS)}")
        wanted = signature(CHECKS[self.check])
        try:
            wanted.bind(*self.studies, **self.parameters)
        except TypeError as error:
            raise ValueError(
                f"studies = {self.studies!r}, parameters = {self.parameters!r}: "
                f"check {self.check}{wanted}: {error}"
            ) from error
        if self.part is not None and any("/" in name for name in self.studies):
            raise ValueError(f"part: is for studies alone, not for {', '.join(self.studies)}")
        return self

    def read_on(self, found: Evidence) -> Evidence:
        """What the check is given of what was found: the part that the sentence is read on."""
        if self.part is None or not isinstance(found, StudyResult):
            return found
        return within(found, self.part)


@dataclass(frozen=True)
class Line:
    """One line of sentences.json; ``numerics`` is the digest of the program that judged it."""

    label: str
    section: str
    quote: str
    study: str
    measured: str
    expected: str
    verdict: Outcome
    note: str
    numerics: str = field(default_factory=numerics_digest)


def sentences(path: Path = SENTENCES) -> list[Sentence]:
    """All sentences, in the paper's order."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    return [Sentence.model_validate(entry) for entry in table["sentence"]]


def judged(sentence: Sentence, runs: Path, extra: Path) -> Line:
    """The sentence with what was measured; inconclusive if a study has not been run.

    Parameters
    ----------
    runs, extra : the folders of studies and flows, and of extra tables.
    """
    try:
        found = [sentence.read_on(evidence(runs, extra, name)) for name in sentence.studies]
        finding = CHECKS[sentence.check](*found, **sentence.parameters)
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
    )
