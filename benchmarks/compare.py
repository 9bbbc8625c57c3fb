"""Compare a run of the benchmarks with the committed one, and both with the targets.

Ratios are judged, not seconds: another machine, or a busy one, is slower in both parts of a ratio.
The status is 1 if a target is missed or a ratio is worse than the committed one by more than
`SLACK`.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

SLACK = 0.3  # repeated runs on a busy machine differ by a fifth


@dataclass(frozen=True)
class Judged:
    """A number that is judged: at least the target where larger is better, else at most."""

    value: float
    target: float
    larger_is_better: bool

    def misses(self, bound: float) -> bool:
        """Whether the value is on the wrong side of a bound."""
        return self.value < bound if self.larger_is_better else self.value > bound

    def worse_than(self, other: "Judged") -> bool:
        """Whether it is worse than another beyond the slack."""
        return self.misses(other.value * (1.0 - SLACK if self.larger_is_better else 1.0 + SLACK))


TARGET_RATIO = {3834: 15.0, 15354: 30.0}
TARGET_EXPONENT = 1.15
TARGET_ASSEMBLY = 1.0  # seconds of assembly over those of factorisation and Krylov iteration


def judged(results: dict) -> dict[str, Judged]:
    """The judged numbers of a file of results by name."""
    found: dict[str, Judged] = {}
    for one in results["benchmarks"]:
        info, parameters = one["extra_info"], one["params"] or {}
        kind, N = parameters.get("kind"), 4 * parameters.get("vertices", 0) - 6
        if "ratio" in info:
            found[f"textbook / step, {kind}, N = {N}"] = Judged(
                info["ratio"], TARGET_RATIO[N], True
            )
        elif "exponent" in info:
            found[f"exponent of N, {kind}"] = Judged(info["exponent"], TARGET_EXPONENT, False)
        elif "seconds" in info:
            s = info["seconds"]
            share = s["assembly"] / (s["factorisation"] + s["krylov"])
            found[f"assembly / rest of step, {kind}, N = {N}"] = Judged(
                share, TARGET_ASSEMBLY, False
            )
    return found


def main() -> int:
    """Print the table and return the status."""
    new, old = (json.loads(Path(path).read_text(encoding="utf-8")) for path in sys.argv[1:3])
    for results, name in ((new, "new"), (old, "committed")):
        info = results["machine_info"]
        print(f"{name:>9}: {info['machine']}, {info['threads']} threads")
    status, before = 0, judged(old)
    print(f"\n{'':44}{'new':>9}{'committed':>11}{'target':>9}")
    for name, now in judged(new).items():
        remarks = ["misses its target"] if now.misses(now.target) else []
        if name in before and now.worse_than(before[name]):
            remarks.append("worse than committed")
        status = 1 if remarks else status
        committed = f"{before[name].value:.3g}" if name in before else "-"
        bound = f"{'>=' if now.larger_is_better else '<='} {now.target:g}"
        print(f"{name:44}{now.value:9.3g}{committed:>11}{bound:>9}  {', '.join(remarks)}")
    return status


if __name__ == "__main__":
    sys.exit(main())
