"""The judge: pure functions of a table of errors; knows neither solver nor studies."""

from esfem.judging.floors import Floor, Masked
from esfem.judging.judge import judge_table
from esfem.judging.judgement import Alternative, Judgement, worst

__all__ = ["Alternative", "Floor", "Judgement", "Masked", "judge_table", "worst"]
