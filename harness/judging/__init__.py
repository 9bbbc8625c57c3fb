"""The judge: pure functions of a table of errors; knows neither solver nor studies."""

from harness.judging.floors import Floor, Masked
from harness.judging.judge import judge_table
from harness.judging.judgement import Judgement, worst

__all__ = ["Floor", "Judgement", "Masked", "judge_table", "worst"]
