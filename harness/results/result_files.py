"""The results of a study on disk, written and read: tables, plots and verdicts.json.

verdicts.json is written last and holds a digest of every file and of itself: what was edited by
hand, damaged or half-written is refused when it is read, and written anew by `write_results`.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
from pydantic import BeforeValidator, ValidatorFunctionWrapHandler, WrapValidator

from esfem.common import provenance
from esfem.common.bad_input import BadInput
from esfem.common.closure import closure, digest
from esfem.common.files import plain, read_json, reading, write_text
from esfem.judging.outcome import Outcome
from esfem.results.error_verdicts import NAN, ErrorVerdict
from esfem.results.records_file import ANEW, read_records
from esfem.results.study_result import StudyResult, judged
from esfem.results.tables import latex, markdown, rates_table, verdicts_frame
from esfem.results.verdicts import Verdict
from esfem.studies.study import Study

VERDICTS = "verdicts.json"
HISTORY = "history.json"  # beside it in a baseline: its moves
TABLES = ("records.csv", "floors.csv", "rates.csv", "verdicts.csv", "table.md", "table.tex")
PLOTS = ("errors.svg", "errors.pdf", "energy.svg", "energy.pdf")


def _as_written(entry: Any, validated: ValidatorFunctionWrapHandler) -> Any:
    """An entry of verdicts.json as a Verdict; null is NaN, and every field must be there.

    What follows from its parts must be what is told beside them. An entry of a version that judged
    u_h - u alone has one part.
    """
    if not isinstance(entry, dict):
        return validated(entry)
    told = dict(entry) if "parts" in entry else _of_one_part(entry)
    _complete(Verdict, told)
    for part in told["parts"] if isinstance(told["parts"], list) else []:
        _complete(ErrorVerdict, part)
    beside = {name: told.pop(name) for name in DERIVED if name in told}
    found = validated(_numbers(told))
    for name, value in beside.items():
        if value != derived(found)[name]:
            raise ValueError(f"{name} = {value!r}: of its parts it is {derived(found)[name]!r}")
    return found


DERIVED = ("verdict", "decides")  # of the parts of a verdict, told beside them


def derived(verdict: Verdict) -> dict[str, str]:
    """What readers of files need not work out: the verdict, and which error decides."""
    return {"verdict": verdict.verdict, "decides": verdict.deciding.name}


def _of_one_part(entry: dict[str, Any]) -> dict[str, Any]:
    """An entry with parts, from one of a version that judged u_h - u alone."""
    part = {"name": "error", "outcome": entry.get("verdict")}
    names = {f.name for f in fields(ErrorVerdict)} - part.keys()
    part |= {name: entry[name] for name in names if name in entry}
    part.setdefault("probability", None)  # that version knew none
    _complete(ErrorVerdict, part)
    rest = {name: value for name, value in entry.items() if name not in names}
    return {**rest, "parts": [part], "decides": "error"}


def _complete(kind: type, entry: Any) -> None:
    """Raise ValueError if a field of the dataclass is not there."""
    lacking = [f.name for f in fields(kind) if isinstance(entry, dict) and f.name not in entry]
    if lacking:
        raise ValueError(f"lacks {lacking[0]!r}: was written by another version")


def _numbers(entry: Any) -> Any:
    if isinstance(entry, dict):
        return {key: _numbers(value) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_numbers(value) for value in entry]
    return NAN if entry is None else entry


def _declared_then(parameters: Any) -> Any:
    """The study file as it was stored; a version that asked for no reason had a list of what
    superconverges."""
    about = parameters.get("study") if isinstance(parameters, dict) else None
    if not isinstance(about, dict) or not isinstance(about.get("superconvergent"), list):
        return parameters
    named = dict.fromkeys(about["superconvergent"], "declared, by a version that did not ask why")
    return {**parameters, "study": {**about, "superconvergent": named}}


@dataclass(frozen=True)
class StoredResult:
    """verdicts.json: what was judged, how, and by which program.

    ``verdict`` is the worst of the ``verdicts``, ``excluded`` names what was not judged,
    ``parameters`` are the study file, ``stamp`` is a hash of what the files were made from,
    ``files`` are the digests of those beside this one, and ``digest`` is that of all the rest.
    """

    study: str
    title: str
    verdict: Outcome
    excluded: list[str]
    verdicts: list[Annotated[Verdict, WrapValidator(_as_written)]]
    parameters: Annotated[Study, BeforeValidator(_declared_then)]
    version: str
    numerics: str
    command: str
    machine: str
    dependencies: dict[str, str]
    seconds: float
    stamp: str
    files: dict[str, str] = field(default_factory=dict)
    digest: str = ""


def write_results(result: StudyResult) -> None:
    """Write all files of the study into its folder, unless the same are there already."""
    folder, outcome = result.folder, result.outcome
    rates, texts = rates_table(result), (markdown(result), latex(result))
    stamp = _stamp(result)
    if _is_current(folder, stamp):
        return
    from esfem.results.plots import save_plots  # matplotlib is slow to load

    origin = {"version": provenance.version(), "numerics": provenance.numerics_digest()}
    made = (table.assign(**origin) for table in (rates, verdicts_frame(result.verdicts)))
    frames = (result.records, result.floors, *made)
    tables = (*(frame.to_csv(index=False) for frame in frames), *texts)
    for name, text in zip(TABLES, tables, strict=True):
        write_text(folder / name, text)
    save_plots(folder, result)
    stored = StoredResult(
        study=result.study.name,
        title=result.study.title,
        verdict=outcome,
        excluded=result.excluded,
        verdicts=result.verdicts,
        parameters=result.study,
        **origin,
        command=provenance.command(),
        machine=provenance.machine(),
        dependencies=provenance.dependencies(),
        seconds=float(result.records["seconds"].sum()),
        stamp=stamp,
        files={name: file_digest(folder / name) for name in TABLES + PLOTS},
    )
    content = plain(stored)
    for entry, verdict in zip(content["verdicts"], result.verdicts, strict=True):
        entry |= derived(verdict)
    content["digest"] = own_digest(content)
    write_text(folder / VERDICTS, json.dumps(content, indent=1))


def _stamp(result: StudyResult) -> str:
    """Hash of what the files are made from: study, its claim, records, and the code that judges,
    tabulates and draws, which is this module and all that it imports."""
    claim = result.study.claimed
    content = [
        result.study.model_dump_json(),
        *(table.to_csv(index=False) for table in (result.records, result.floors)),
        claim.model_dump_json() if claim else "",
        code_digest(),
    ]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()


@cache
def code_digest() -> str:
    """Hash of the code that makes the files of a study from its records."""
    return digest(closure(__name__))


def _is_current(folder: Path, stamp: str) -> bool:
    try:
        stored = read_json(folder / VERDICTS, dict[str, Any])
        check_digests(folder, stored, TABLES + PLOTS)
    except BadInput:
        return False
    return stored.get("stamp") == stamp


def read_verdicts(folder: Path, context: dict[str, str] | None = None) -> StoredResult:
    """What verdicts.json in the folder of a study holds.

    With the ``context`` `studies.study.CLAIMED_THEN` the study may claim what it may not today.

    Raises
    ------
    BadInput
        If the file is missing, damaged, of another version, or was edited.
    """
    path = folder / VERDICTS
    found = read_json(path, StoredResult, ANEW, context)
    check_digests(folder, read_json(path, dict[str, Any], ANEW))
    return found


def load_result(folder: Path) -> StudyResult:
    """The results in the folder of a study, with the verdicts that are stored there.

    Raises
    ------
    BadInput
        If verdicts.json, records.csv or floors.csv is missing, damaged or was edited.
    """
    return result_of(folder, read_verdicts(folder))


def result_of(folder: Path, stored: StoredResult) -> StudyResult:
    """The results in the folder of a study, of which verdicts.json has been read already."""
    study = stored.parameters
    records = read_records(folder, study.variables, study.law.energy)
    check_files(folder, stored.files, ("records.csv", "floors.csv"))
    floors = pd.read_csv(folder / "floors.csv")
    return StudyResult(study, folder, records, floors, stored.verdicts)


def load_results(folder: Path) -> list[StudyResult]:
    """The results stored in the folder of a study, or in the folders in it; see `load_result`."""
    with reading(folder):
        found = sorted([*folder.glob(VERDICTS), *folder.glob(f"*/{VERDICTS}")])
    return [load_result(path.parent) for path in found if not path.parent.name.startswith(".")]


def judged_afresh(result: StudyResult) -> StudyResult:
    """The result with the verdicts of this program and today's claims on its records.

    Raises
    ------
    BadInput
        If they cannot be judged.
    """
    try:
        return judged(result.study, result.folder, result.records, result.floors)
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{result.folder}: records cannot be judged: {error!r}") from error


def not_a_baseline(out: Path) -> None:
    """Raise BadInput if results written to ``out`` would move a baseline."""
    if any(out.glob(f"*/{HISTORY}")):
        raise BadInput(f"--out {out}: holds baselines, which `esfem baseline --update` alone moves")


def check_digests(folder: Path, stored: dict[str, Any], names: Sequence[str] = ()) -> None:
    """Whether the content of verdicts.json and the named files are as they were written.

    Raises
    ------
    BadInput
        Naming the first file that is not.
    """
    path = folder / VERDICTS
    if "digest" not in stored or not isinstance(stored.get("files"), dict):
        raise BadInput(f"{path}: holds no digests; {ANEW}")
    if stored["digest"] != own_digest(stored):
        raise BadInput(f"{path}: was edited or damaged; {ANEW}")
    check_files(folder, stored["files"], names)


def check_files(folder: Path, digests: dict[str, str], names: Sequence[str]) -> None:
    """Whether the named files have these digests; BadInput, naming the first that has not."""
    for name in names:
        with reading(folder / name, ANEW):
            found = file_digest(folder / name)
        if digests.get(name) != found:
            raise BadInput(f"{folder / name}: was edited or damaged; {ANEW}")


def file_digest(path: Path) -> str:
    """SHA-256 of the bytes of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def own_digest(content: dict[str, Any]) -> str:
    """Digest of verdicts.json without the field that holds it."""
    rest = {name: value for name, value in content.items() if name != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()
