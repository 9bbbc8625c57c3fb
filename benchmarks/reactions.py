"""The three ways to take the reaction terms: errors, cost, and the largest stable step of each.

On solutions that move: the breathing ellipsoid and the Helfrich sphere, where all six variables are
known, and the red blood cell, where W is known from the axisymmetric solver. What the defaults of
studies and flows go by (README, "Decisions").
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from harness.case import Case
from harness.comparison.contest import GROUNDS, PRINCIPAL
from harness.comparison.stability import is_stable, largest_stable
from harness.errors import VARIABLES
from harness.files import write_text
from harness.meshing import surface_mesh
from harness.provenance import provenance_line
from harness.rows import run_errors
from harness.runner import run_case

OUT = Path("results/bench/reactions.csv")
REACTIONS = ("implicit", "extrapolated", "linearised")
CELL = {"name": "surface", "surface": "red_blood_cell", "reference": "axisymmetric"}
BREATHING = {"name": "breathing_ellipsoid", "amplitude": 0.25, "period": 0.2}
HELFRICH = {"name": "helfrich", "spontaneous_curvature": 1.0}
# Solution, law, degree, vertices, final time, time steps.
GROUND: tuple[tuple[dict[str, Any], dict[str, Any], int, int, float, tuple[float, ...]], ...] = (
    (BREATHING, {"name": "willmore"}, 4, 240, 0.025, (0.0025, 0.00125, 0.000625)),
    ({"name": "helfrich_sphere"}, HELFRICH, 3, 240, 0.5, (0.05, 0.025, 0.0125)),
    (CELL, {"name": "willmore"}, 2, 480, 0.2, (0.02, 0.01, 0.005, 0.0025)),
)
STABLE_ON, STABLE_V = ("Clifford torus", "red blood cell", "ellipsoid 2:1:1"), 120


def runs() -> Iterator[dict[str, Any]]:
    """A row a run: the largest errors against the interpolation, or of W; seconds of the steps."""
    for (solution, law, degree, V, T, taus), q, reaction in product(GROUND, (1, 2, 3), REACTIONS):
        for tau in taus:
            theta = solution is not CELL
            options = {"degree": degree, "bdf": q, "project": True, "theta": theta}
            case = Case.model_validate(
                {
                    "solution": solution,
                    "law": law,
                    "scheme": {**options, "reaction": reaction},
                    "vertices": V,
                    "tau": tau,
                    "final_time": T,
                    "compare_at": () if theta else (T,),
                }
            )
            record, _ = run_case(case, surface_mesh(case.solution.initial().mesh_surface, V))
            found = run_errors(record)
            names = {name: f"nodal_{name}" for name in VARIABLES} if theta else {"W": "err_W"}
            parts = ("assembly", "factorisation", "krylov", "rest")
            yield {
                "solution": solution["name"],
                "bdf": q,
                "reaction": reaction,
                "tau": tau,
                **{name: found.get(column) for name, column in names.items()},
                "iterations": sum(record.iterations) / max(1, len(record.iterations)),
                "seconds": sum(record.seconds[part] for part in parts),
                "status": record.status,
            }


def orders(table: pd.DataFrame) -> pd.DataFrame:
    """The order in tau of each error, from the two finest steps."""
    names = [name for name in (*VARIABLES, "W") if name in table]

    def of(runs: pd.DataFrame) -> pd.Series:
        fine, coarse = runs.sort_values("tau").iloc[0], runs.sort_values("tau").iloc[1]
        return np.log2(coarse[names].astype(float) / fine[names].astype(float))

    return table.groupby(["solution", "bdf", "reaction"])[["tau", *names]].apply(of)


def stable_steps() -> pd.DataFrame:
    """The largest step of 20 that stay bounded, by surface and reaction, BDF1 and P2."""
    rows = {}
    for ground in STABLE_ON:
        for reaction in REACTIONS:
            options = {**PRINCIPAL["kll"], "reaction": reaction}

            def stable(tau: float, options: Any = options, ground: str = ground) -> bool:
                return is_stable(options, GROUNDS[ground], STABLE_V, tau)

            rows[ground, reaction] = largest_stable(stable)
    return pd.Series(rows).unstack()


def main() -> None:
    """Write `OUT` and print what is decided by."""
    table = pd.DataFrame(runs())
    write_text(OUT, f"# {provenance_line()}\n{table.to_csv(index=False)}")
    finest = table[table["tau"] == table.groupby("solution")["tau"].transform("min")]
    shown = finest.drop(columns=["tau", "status"]).set_index(["solution", "bdf", "reaction"])
    print(shown.to_string(float_format="{:.2e}".format))
    print("order in tau, from the two finest steps")
    print(orders(table).to_string(float_format="{:.2f}".format))
    print("largest stable tau, P2, BDF1, V = 120")
    print(stable_steps().to_string(float_format="{:.3g}".format))


if __name__ == "__main__":
    main()
