"""Which studies and flows there are, and which file a name means."""

from collections.abc import Iterable
from pathlib import Path

from esfem.common.bad_input import BadInput
from esfem.common.files import reading
from esfem.studies.study import STUDIES, Study, load_study


def default_studies() -> list[Path]:
    """The committed studies, which `make convergence` runs."""
    return sorted(STUDIES.glob("*.toml"))


def full_studies() -> list[Path]:
    """The further committed studies, which `esfem run --all` runs too."""
    return sorted(STUDIES.glob("full/*.toml"))


def paper_studies() -> list[Path]:
    """The committed studies of the paper's figures, which `esfem paper` runs."""
    return sorted(STUDIES.glob("paper/*.toml"))


def long_studies() -> list[Path]:
    """The committed studies with runs of over five minutes, which `esfem paper --long` runs."""
    return sorted(STUDIES.glob("paper/long/*.toml"))


def scheme_studies() -> list[Path]:
    """The committed studies that compare schemes; each is run by its name."""
    return sorted(STUDIES.glob("schemes/*.toml"))


def study_sets() -> dict[str, list[Path]]:
    """All committed studies, by the set and how it is run."""
    return {
        "studies": default_studies(),
        "further studies (esfem run --all)": full_studies(),
        "studies of the paper (esfem paper)": paper_studies(),
        "long studies of the paper (esfem paper --long)": long_studies(),
        "studies of schemes, named schemes/NAME (esfem schemes)": scheme_studies(),
    }


def study_path(name: str) -> Path:
    """The file of that name, or else the committed study.

    Raises
    ------
    BadInput
        If there is neither.
    """
    named = default_studies() + full_studies() + paper_studies() + long_studies()
    committed = {path.stem: path for path in named}
    committed |= {f"schemes/{path.stem}": path for path in scheme_studies()}
    return _file(name, committed, "study")


def load_studies(studies: Iterable[Study | Path | str]) -> list[Study]:
    """Each study itself, or from its file, or by its name (`study_path`).

    Raises
    ------
    BadInput
        If a file cannot be read or says what is not allowed, or two studies have one name.
    """
    loaded = [_loaded(study) for study in studies]
    names = [study.name for study in loaded]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(
                f"[study] name = {name!r}: two of the given studies would share this folder"
            )
    return loaded


def _loaded(study: Study | Path | str) -> Study:
    if isinstance(study, Study):
        return study
    return load_study(study_path(str(study)))


def committed_flows() -> dict[str, Path]:
    """The committed flow files by name."""
    return {path.stem: path for path in sorted(STUDIES.glob("paper/flows/*.toml"))}


def flow_path(name: str) -> Path:
    """The file of that name, or else the committed flow.

    Raises
    ------
    BadInput
        If there is neither.
    """
    return _file(name, committed_flows(), "flow")


def _file(name: str, committed: dict[str, Path], what: str) -> Path:
    """The file of that name, or else what is committed under it."""
    path = Path(name)
    with reading(name):
        is_file = path.is_file()
    if is_file or path.suffix == ".toml":
        return path
    if name not in committed:
        raise BadInput(
            f"{name}: cannot be read: neither a file nor a committed {what}; "
            f"those are {', '.join(committed)}"
        )
    return committed[name]
