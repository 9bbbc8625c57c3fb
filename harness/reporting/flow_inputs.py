"""The stored flows of a folder, as `esfem flow` wrote them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import to_json

from harness.bad_input import BadInput
from harness.files import read_json
from harness.flows.checks import Check
from harness.flows.flow_file import FlowFile
from harness.flows.history import History, read_history


@dataclass(frozen=True)
class FlowResult:
    """A flow with its numbers at each time level, its checks, and the content of checks.json."""

    folder: Path
    flow: FlowFile
    history: History
    checks: list[Check]
    content: dict[str, Any]

    @property
    def holds(self) -> bool:
        """Whether it ran to its end and all checks hold."""
        return all(check.verdict == "pass" for check in self.checks)


def read_flows(folder: Path) -> list[FlowResult]:
    """The flows in the folders of a folder, by name; none if it does not exist.

    Raises
    ------
    BadInput
        If the files of a flow are damaged.
    """
    return [_read_flow(path.parent) for path in sorted(folder.glob("*/checks.json"))]


def _read_flow(folder: Path) -> FlowResult:
    try:
        content = read_json(folder / "checks.json", dict[str, Any])
        flow = FlowFile.model_validate_json(to_json(content["flow"]))
        history = read_history(folder / "history.csv", flow.law.energy)
        checks = [Check(**check) for check in content["checks"]]
    except (OSError, ValidationError, ValueError, KeyError, TypeError) as error:
        line = " ".join(str(error).split())
        raise BadInput(f"{folder}: holds no flow that can be read: {line}") from error
    if not history.rows:
        raise BadInput(f"{folder / 'history.csv'}: holds no time level")
    return FlowResult(folder, flow, history, checks, content)
