"""`esfem paper`: all experiments of the paper, their figures, and its sentences, checked."""

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from harness.api import run_studies
from harness.bad_input import BadInput
from harness.paper.evidence import EXTRA
from harness.paper.evolutions import run_flows
from harness.paper.plan import NEEDED, Plan, committed_plan, plan_in
from harness.paper.publish import MOST_BYTES, publish, size
from harness.paper.sentences import Line, judged, sentences, write_sentences
from harness.printing import STYLES, plain_console
from harness.stops import stops
from harness.verdict import exit_status

OUT, RUNS = Path("results/paper"), Path("results/runs/paper")


def paper(
    out: Annotated[Path, typer.Option(help="Tables, figures and sentences go there.")] = OUT,
    runs: Annotated[Path, typer.Option(help="Records and checkpoints go there.")] = RUNS,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(
            help="Run this study, long ones too, this flow or the ablation alone; may be repeated."
        ),
    ] = None,
    studies: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Other study files, flow files in its flows/, long studies in its long/.",
        ),
    ] = None,
    long: Annotated[
        bool, typer.Option("--long", help="Also the studies with runs of more than five minutes.")
    ] = False,
) -> None:
    """Reproduce section 7 of the paper: figures, tables, and each quantitative sentence checked.

    Exit status: 0 every sentence that was checked holds, 1 one does not, 3 inconclusive. With
    `--only`, sentences about other studies do not count.

    Example: `esfem paper --only paper-sphere --only ellipsoid --jobs 2`
    """
    if jobs is not None and jobs < 1:
        raise BadInput(f"--jobs {jobs}: must be at least 1")
    # Who names a long study has asked for it.
    every = long or bool(only)
    whole = committed_plan(every) if studies is None else plan_in(studies, every)
    plan = whole.only(only) if only else whole
    with stops(runs):
        status = run_paper(plan, out, runs, jobs, plain_console())
    raise typer.Exit(status)


def run_paper(plan: Plan, out: Path, runs: Path, jobs: int | None, console: Console) -> int:
    """Run what is not stored, then write everything that is made from it.

    Parameters
    ----------
    plan : what is run; figures and sentences are made of all that is stored.
    out, runs : the folders of the light part of the results, and of all results.
    jobs : number of processes, by default all cores.
    console : is told.

    Returns
    -------
    The exit status, see `harness.verdict.exit_status`; of sentences about the plan alone.

    Raises
    ------
    BadInput
        If a study or flow file is wrong, or a folder cannot be written.
    """
    started = perf_counter()
    compute(plan, runs, jobs, console)
    status = write(plan, out, runs, console)
    console.print(f"esfem paper: {(perf_counter() - started) / 60:.1f} minutes")
    return status


def compute(plan: Plan, runs: Path, jobs: int | None, console: Console) -> None:
    """The flows, which take longest, then the cells of all studies in one sweep, the ablation."""
    if plan.flows:
        console.rule(Text(f"{len(plan.flows)} flows", style="bold"), align="left")
        run_flows(plan.flows, runs / "flows", jobs or os.cpu_count() or 1, console)
    if plan.studies:
        console.rule(Text(f"{len(plan.studies)} studies", style="bold"), align="left")
        run_studies(plan.studies, runs, console, jobs=jobs)
    if plan.ablation:
        from harness.paper.ablation import run_ablation  # matplotlib is slow to load

        console.rule(Text("ablation", style="bold"), align="left")
        run_ablation(runs, jobs, console)


def write(plan: Plan, out: Path, runs: Path, console: Console) -> int:
    """Extra sections, sentences, the light part of the results, the report; the exit status."""
    from harness.paper.extras import write_extras  # matplotlib is slow to load
    from harness.reporting.write import write_report

    console.rule(Text("figures, tables, sentences", style="bold"), align="left")
    write_extras(runs, out / "extra", console)
    publish(runs, out, [p.stem for p in plan.studies], [p.stem for p in plan.flows])
    lines = [judged(sentence, runs, out / "extra") for sentence in sentences()]
    write_sentences(out / "sentences.json", lines)
    show(lines, console)
    console.print(f"report: {write_report(out, out / 'report', console.print)}", soft_wrap=True)
    bytes_ = size(out)
    over = f", more than {MOST_BYTES / 1e6:g} MB" if bytes_ > MOST_BYTES else ""
    console.print(f"written to {out}: {bytes_ / 1e6:.1f} MB{over}", soft_wrap=True)
    return exit_status(line.verdict for line in lines if concerns(line, plan))


def show(lines: Sequence[Line], console: Console) -> None:
    """Print a line a sentence, and how many there are of each verdict."""
    for line in lines:
        verdict = line.verdict.upper()
        found = f"{line.measured or line.note} (expected: {line.expected or '-'})"
        text = Text.assemble((f"{verdict:13}", STYLES.get(verdict, "")), f" {line.section}: ")
        console.print(text + Text(f"{line.quote}\n{'':15}{line.study}: {found}"), soft_wrap=True)
    counts = Counter(line.verdict for line in lines)
    console.print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))


def concerns(line: Line, plan: Plan) -> bool:
    """Whether the plan runs all that the sentence is checked by."""
    needed: list[str] = []
    for kind, _, rest in (name.partition("/") for name in line.study.split(", ")):
        needed += NEEDED[rest] if kind == EXTRA else [rest or kind]
    return all(name in plan.names for name in needed)
