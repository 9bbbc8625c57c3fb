"""All experiments of the paper, their figures, and its sentences, checked."""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from time import perf_counter

from rich.console import Console
from rich.text import Text

from esfem.campaigns.paper.ablation import ablation, run_ablation
from esfem.campaigns.paper.convergence import convergence, stopped_early
from esfem.campaigns.paper.evolutions import run_flows
from esfem.campaigns.paper.growth import growth
from esfem.campaigns.paper.normalisation import normalisation
from esfem.campaigns.paper.plan import NEEDED, Plan
from esfem.campaigns.paper.sentences import Line, judged, sentences
from esfem.campaigns.paper.stored_results import EXTRA, FLOWS, Missing
from esfem.campaigns.publish import MOST_BYTES, copy_flows, copy_studies, size
from esfem.common.console import STYLES
from esfem.common.files import write_json
from esfem.judging.outcome import exit_status
from esfem.report.extra import Extra, write_extra
from esfem.report.write import write_report
from esfem.results.run_studies import run_studies

# The extra sections of the report by the names of their files, and what makes them from the folder
# of the runs; `Missing` names what has not been run.
EXTRAS: dict[str, Callable[[Path], Extra]] = {
    "figure-1-sphere-unprojected": partial(convergence, name="paper-sphere-unprojected"),
    "figure-2-normalisation": normalisation,
    "figure-3-sphere": partial(convergence, name="paper-sphere"),
    "figure-4-torus": partial(convergence, name="paper-torus"),
    "figure-4-growth": growth,
    "figure-5-ablation": ablation,
    "figure-6-divergence": stopped_early,
    "figure-7-sphere-degree-3": partial(convergence, name="paper-sphere-degree-3"),
    "figure-7-sphere-degree-4": partial(convergence, name="paper-sphere-degree-4"),
    "figure-8-torus-degree-3": partial(convergence, name="paper-torus-degree-3"),
    "figure-8-torus-degree-4": partial(convergence, name="paper-torus-degree-4"),
}


def run_paper(plan: Plan, out: Path, runs: Path, jobs: int, console: Console) -> int:
    """Run what is not stored, then write everything that is made from it.

    Parameters
    ----------
    plan : what is run; figures and sentences are made of all that is stored.
    out, runs : the folders of the light part of the results, and of all results.
    jobs : number of processes.
    console : is told.

    Returns
    -------
    The exit status, see `esfem.judging.outcome.exit_status`; of sentences about the plan alone.

    Raises
    ------
    BadInput
        If a study or flow file is wrong, or a folder cannot be written.
    """
    started = perf_counter()
    compute(plan, runs, jobs, console)
    found = write(plan, out, runs, console)
    console.print(f"esfem paper: {(perf_counter() - started) / 60:.1f} minutes")
    return found


def compute(plan: Plan, runs: Path, jobs: int, console: Console) -> None:
    """The flows, which take longest, then the cells of all studies in one sweep, the ablation."""
    if plan.flows:
        console.rule(Text(f"{len(plan.flows)} flows", style="bold"), align="left")
        run_flows(plan.flows, runs / FLOWS, jobs, console)
    if plan.studies:
        console.rule(Text(f"{len(plan.studies)} studies", style="bold"), align="left")
        run_studies(plan.studies, runs, console, jobs=jobs)
    if plan.ablation:
        console.rule(Text("ablation", style="bold"), align="left")
        run_ablation(runs, jobs, console)


def write(plan: Plan, out: Path, runs: Path, console: Console) -> int:
    """Extra sections, sentences, the light part of the results, the report; the exit status."""
    console.rule(Text("figures, tables, sentences", style="bold"), align="left")
    write_extras(runs, out / "extra", console)
    copy_studies(runs, out, [p.stem for p in plan.studies])
    copy_flows(runs / FLOWS, out / FLOWS, [p.stem for p in plan.flows])
    lines = [line for s in sentences() for line in judged(s, runs, out / "extra")]
    write_json(out / "sentences.json", lines)
    show(lines, console)
    console.print(f"report: {write_report(out, out / 'report', console.print)}", soft_wrap=True)
    bytes_ = size(out)
    over = f", more than {MOST_BYTES / 1e6:g} MB" if bytes_ > MOST_BYTES else ""
    console.print(f"written to {out}: {bytes_ / 1e6:.1f} MB{over}", soft_wrap=True)
    return status(lines, plan)


def write_extras(runs: Path, folder: Path, console: Console) -> None:
    """Write those that can be made from what is stored below ``runs``; remove the others."""
    for name, make in EXTRAS.items():
        try:
            made = make(runs)
        except Missing as missing:
            made = None
            console.print(f"no {name}: {missing}", soft_wrap=True)
        for path in folder.glob(f"{name}.*"):
            path.unlink()
        if made is not None:
            write_extra(folder, name, made)
            console.print(f"made {name}")


def show(lines: Sequence[Line], console: Console) -> None:
    """Print a line a sentence, and how many there are of each verdict."""
    for line in lines:
        verdict = line.verdict.upper()
        found = f"{line.measured or line.note} (expected: {line.expected or '-'})"
        text = Text.assemble((f"{verdict:13}", STYLES.get(verdict, "")), f" {line.section}: ")
        where = f"{line.study}{f' in {line.error}' * bool(line.error)}"
        console.print(text + Text(f"{line.quote}\n{'':15}{where}: {found}"), soft_wrap=True)
    counts = Counter(line.verdict for line in lines)
    console.print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))


def concerns(line: Line, plan: Plan) -> bool:
    """Whether the plan runs all that the sentence is checked by."""
    needed: list[str] = []
    for kind, _, rest in (name.partition("/") for name in line.study.split(", ")):
        needed += NEEDED[rest] if kind == EXTRA else [rest or kind]
    return all(name in plan.names for name in needed)


def status(lines: Sequence[Line], plan: Plan) -> int:
    """The exit status: of the sentences about what the plan runs."""
    return exit_status(line.verdict for line in lines if concerns(line, plan))
