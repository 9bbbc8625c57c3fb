"""floors.csv: the measured floors, beside the errors of the run they were measured on."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from esfem.judging.floors import FloorName
from esfem.measuring.differences import DISTANCE
from esfem.measuring.energies import OF_ITS_OWN, scale_of
from esfem.reference_solutions import decays
from esfem.runs.run_pair import PairRecord
from esfem.studies.case import Law
from esfem.studies.quantities import decay_rate
from esfem.studies.study import Study

COLUMNS = ("floor", "variable", "vertices", "tau", "error", "nodal", "value", "key")
RELATIVE = {"W": "willmore", "area": "area", "volume": "volume"}  # errors, by name of the level


def floors_table(
    study: Study,
    records: pd.DataFrame,
    pairs: Mapping[FloorName, tuple[str, PairRecord]],
) -> pd.DataFrame:
    """A line a floor and variable: the error of the run of the sweep, that against the
    interpolation (NaN where runs do not measure it), and the floor of both.

    Parameters
    ----------
    records : the rows (`esfem.results.records.record_row`) of the sweep.
    pairs : by floor the key and the record of the runs that measure it.

    With order q, u_tau - u_{tau/2} is the part 1 - 2^-q of the error in time.
    """
    lines = []
    for name, (key, pair) in pairs.items():
        vertices, tau = pair.case["vertices"], pair.case["tau"]
        at = (records["vertices"] == vertices) & (records["tau"] == tau)
        if not at.any():  # the run of the sweep itself has no record yet
            continue
        run = records[at].iloc[0]
        part = 1.0 - 2.0**-study.scheme.order if name == "tau" else 1.0
        for variable in study.variables:
            errors = (run.get(f"{of}_{variable}", np.nan) for of in ("err", "nodal"))
            value = difference(study, variable, pair) / part
            lines.append((name, variable, vertices, tau, *errors, value, key))
    return pd.DataFrame(lines, columns=list(COLUMNS))


def difference(study: Study, variable: str, pair: PairRecord) -> float:
    """How far two runs lie apart in a variable, in the units of its error, at most over the times
    at which they were compared.

    That of a number is its change, which has a sign, not that of its error. NaN where one of the
    runs stopped early, which tells nothing, and of what is not measured at each level.
    """
    if pair.status != "ok":
        return np.nan
    if variable in pair.norms:
        return max(pair.norms[variable]) * _in_the_unit_of_the_claim(study, variable)
    both = pair.levels, pair.varied_levels
    one, other = ({name: np.array(values) for name, values in of.items()} for of in both)
    if variable in RELATIVE:
        q = RELATIVE[variable]
        return float(np.max(np.abs(other[q] / one[q] - 1.0)))
    if variable == OF_ITS_OWN:
        energy = Law(**pair.case["law"]).energy
        scale = scale_of(energy, one["energy"][0], one["willmore"][0])
        return float(np.max(np.abs(other["energy"] - one["energy"])) / scale)
    if variable == "decay" and decays(study.initial):
        rates = [decay_rate(pair.t, levels["amplitude"]) for levels in both]
        return abs(rates[1] - rates[0]) / study.initial.decay_rate
    return np.nan


def _in_the_unit_of_the_claim(study: Study, variable: str) -> float:
    """What bounds a norm in H^1 with the unit of length of the claim by that with L, as a factor:
    |d|^2 / l^2 + |grad d|^2 <= max(1, L / l)^2 (|d|^2 / L^2 + |grad d|^2)."""
    asked, L = study.claimed_length, study.initial.length
    return max(1.0, L / asked) if asked is not None and variable != DISTANCE else 1.0
