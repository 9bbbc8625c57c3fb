"""What holds if nothing else is asked, on the command line and in Python alike."""

from pathlib import Path

DEFAULT_OUT = Path("results/runs")  # results of a study go to its folder there
EVERY_SECONDS = 30.0  # from checkpoint to checkpoint
