"""What is run to be committed: the paper, the schemes, seeded bugs, the judge, rough starts."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.campaigns.contest import PARTS
from esfem.cli.exit_statuses import exit_statuses
from esfem.cli.options import Jobs, Records, Report
from esfem.common.console import plain_console


def paper(
    *,
    out: Report = Path("results/paper"),
    runs: Records = Path("results/runs/paper"),
    jobs: Jobs,
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
    from esfem.campaigns.paper.plan import committed_plan, plan_in
    from esfem.campaigns.paper.run import run_paper

    every = long or bool(only)  # who names a long study has asked for it
    whole = committed_plan(every) if studies is None else plan_in(studies, every)
    plan = whole.only(only) if only else whole
    with exit_statuses(runs):
        status = run_paper(plan, out, runs, jobs, plain_console())
    raise typer.Exit(status)


def schemes(
    *,
    out: Report = Path("results/schemes"),
    runs: Records = Path("results/runs/schemes"),
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="PART", help=f"Among {', '.join(PARTS)}; may be repeated."),
    ] = None,
    scheme: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A scheme that takes part too; may be repeated."),
    ] = None,
    jobs: Jobs,
) -> None:
    """Compare the schemes: studies, errors, drifts, largest stable tau, mesh quality, seconds.

    Interrupted, studies go on from their records; each other part is repeated as a whole. Exit
    status: that of the studies, as for `esfem run`; dziuk and bgn claim nothing.

    Example: `esfem schemes --only comparison --only orders --scheme my-scheme`
    """
    from esfem.campaigns.contest.run import run_contest
    from esfem.judging.outcome import exit_status

    with exit_statuses(runs):
        results = run_contest(only or PARTS, out, runs, jobs, plain_console(), scheme or ())
    raise typer.Exit(exit_status(result.outcome for result in results))


def mutants(
    *,
    only: Annotated[
        list[str] | None, typer.Option(help="A mutant or a group of them; may be repeated.")
    ] = None,
    jobs: Jobs,
    every: Annotated[
        bool, typer.Option("--all", help="Run all studies, also after one has failed.")
    ] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Leave out mutants that have a current result.")
    ] = False,
    shams: Annotated[
        bool,
        typer.Option(
            "--shams",
            help="Sham schemes instead, in all order studies, or in those that --only names.",
        ),
    ] = False,
    out: Report = Path("results/mutants"),
) -> None:
    """Make the program wrong, line by line, and see whether the verdicts notice.

    Each result is stored at once; interrupted, `--resume` goes on from there. Exit status: 0 they
    notice all that matters, 1 a mutant survives, 130 interrupted.

    With `--shams` schemes are tried that do nothing, move at half the speed, or are a step late:
    each takes the place of `kll`, and the studies that claim an order have to say so.

    Example: `esfem mutants --only theta --jobs 2`
    """
    from esfem.campaigns.mutants.run import run_mutants
    from esfem.campaigns.mutants.sham_trials import run_shams

    with exit_statuses(out, command="the same command with --resume"):
        if shams:
            status = run_shams(only or (), jobs, out, plain_console())
        else:
            status = run_mutants(only or (), jobs, every, resume, out, plain_console())
    raise typer.Exit(status)


def judge_report(*, out: Report = Path("results/judge"), jobs: Jobs) -> None:
    """Judge tables of known order, and count how often the judge and the usual rules err.

    Example: `esfem judge-report --out results/judge`
    """
    from esfem.campaigns.judge.run import run_simulation

    with exit_statuses(out, resumes=False):
        run_simulation(out, jobs, plain_console(stderr=True))


def rough_starts(*, out: Report = Path("results/rough-starts"), jobs: Jobs) -> None:
    """Measure the order in tau at a rough start, with and without divided first steps.

    Example: `esfem rough-starts --jobs 2`
    """
    from esfem.campaigns.rough_starts.run import run_rough_starts

    with exit_statuses(out, resumes=False):
        run_rough_starts(out, jobs, plain_console(stderr=True))
