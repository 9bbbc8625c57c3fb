"""What a run is judged by: the names, symbols and norms of its errors, and how they are measured.

Each quantity is a column ``err_<name>`` of the table of runs.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from esfem.measuring.energies import OF_ITS_OWN, quantity_of
from esfem.measuring.lift import ROUNDING, VARIABLES
from esfem.measuring.shape import SHAPES
from esfem.reference_solutions import InitialSurface, SurfaceFlow
from esfem.reference_solutions.discrete import RadialRun
from esfem.reference_solutions.exact import Array
from esfem.reference_solutions.sphere import RoundSphere
from esfem.schemes import DEFAULT_SCHEME, named_scheme
from esfem.schemes.kll import KLLOptions
from esfem.studies.case import Case, Law

# L = sqrt(area(Gamma(0)) / 4 pi), the unit of length of a solution: 1 on the unit sphere.
H1 = "|e|^2 / L^2 + |grad e|^2"
LIFTED = f"L-infinity(0,T; H^1(Gamma)), {H1}"
# The error against the interpolation, the paper's nodal error e_u, on the surface interpolated in
# the exact nodes.
NODAL = f"u_h - I_h u in L-infinity(0,T; H^1(Gamma_h*)), {H1}"
FINEST = f"maximum over the compared times, in H^1, {H1}, against finest"
AXISYMMETRIC = (
    "largest error over the compared times, against the axisymmetric solver; relative but for the "
    "distance of the surfaces"
)
TO_THE_START = (
    "largest error over the compared times, against the axisymmetric solver, relative to the "
    "energy at the start"
)

SHAPE = (
    "maximum over all time levels: largest distance to Gamma(t), and relative errors of W, area "
    "and volume; the nodes slide"
)
BALANCE = (
    "largest error over all time levels of the balance E(t) + int_0^t D = E(0), relative to the "
    "energy at the start; D = int V_h^2, of surface diffusion int z_h^2"
)
DRIFT = "largest change of the enclosed volume over all time levels, relative to that at the start"
SIZE = "difference of the error in L-infinity(0,T; H^1) from its known size, relative to that"

SIZES = {"size_x": "x", "size_v": "v", "size_H": "H", "size_V": "V"}  # that are known

# The growth of | |nu| - 1 | is measured over the last decade below this: above the error of
# interpolation, below nonlinear growth.
DECADE_END = 1e-2
# A mode is followed until it has shrunk to this part; from its start, but for the first level.
FOLLOWED = 0.1


@dataclass(frozen=True)
class Quantity:
    """``tex`` is its symbol, ``norm`` says what its error is; ``value`` is a column that shows what
    was measured itself. Those ``on_request`` are shown only where a claim names them, and then
    those ``beside`` them, without a claim; what is ``measured_apart`` is measured only there too
    (`esfem.studies.case.Case.also`). ``in_time`` says that it depends on the time step. ``lacking``
    says why a run that ended may have no error: NaN."""

    tex: str
    norm: str
    value: str | None = None
    on_request: bool = False
    measured_apart: bool = False
    beside: tuple[str, ...] = ()
    in_time: bool = True
    lacking: str = "the run measured no number"


def _apart(tex: str, norm: str, *, in_time: bool = False, beside: tuple[str, ...] = ()) -> Quantity:
    """A quantity that is measured, and shown, only where a claim names it."""
    return Quantity(tex, norm, on_request=True, measured_apart=True, beside=beside, in_time=in_time)


START = "w(0) - I_h w, from M w(0) = g + theta - A u with exact nodal x and u, in {}"
# By the end of the name the norm, in words and around its symbol.
START_NORMS = {
    "": ("H^-1_h(Gamma_h*)", "%s"),
    "_l2": ("L^2(Gamma_h*)", r"\|%s\|_{L^2}"),
    "_h1": ("H^1(Gamma_h*)", r"\|%s\|_{H^1}"),
}
DEFECT = "defect of exact nodal values at the final time, in H^-1_h(Gamma_h*)"
# By the end of the name its symbol and in words.
DEFECT_OF = {"": ("d_{%s}", DEFECT), "_dt": (r"\dot d_{%s}", f"d/dt of the {DEFECT}")}
FLOW_MAP = "X_h^l - X in L-infinity(0,T; H^1(Gamma(0)))"
GAUSS_BONNET = "largest |1/2 int (H_h^2 - |S_h|^2) - 2 pi chi| at a time level"

STARTS_OF_W = {
    f"start_{name}{which}": _apart(
        symbol % rf"\bar e_{{{name}}}",
        START.format(norm),
        beside=() if which else (f"start_{name}_l2", f"start_{name}_h1"),
    )
    for name in ("V", "z")
    for which, (norm, symbol) in START_NORMS.items()
}
DEFECTS = {
    f"defect_{name}{which}": _apart(symbol % tex, norm)
    for which, (symbol, norm) in DEFECT_OF.items()
    for name, tex in {"H": "H", "nu": r"\nu", "V": "V", "z": "z"}.items()
}

QUANTITIES: dict[str, Quantity] = {
    "x": Quantity("x", LIFTED),
    "nu": Quantity(r"\nu", LIFTED),
    "H": Quantity("H", LIFTED),
    "V": Quantity("V", LIFTED),
    "z": Quantity("z", LIFTED),
    "v": Quantity("v", LIFTED),
    "decay": Quantity(
        r"\lambda",
        "relative error of the decay rate of the mode",
        "decay_rate",
        lacking="a decay rate needs three levels on which the mode keeps its sign, above rounding",
    ),
    "growth": Quantity(
        r"\omega",
        "error of the growth rate of max ||nu| - 1|, relative to that without projection",
        "growth_rate",
        on_request=True,
        lacking="a growth rate needs three levels above rounding and below a hundredth",
    ),
    **{
        f"size_{name}": Quantity(
            rf"\|e_{{{name}}}\|", SIZE, on_request=True, lacking="the known size is rounding"
        )
        for name in SIZES.values()
    },
    "W": Quantity("W", AXISYMMETRIC, "willmore_T"),
    OF_ITS_OWN: Quantity("E", TO_THE_START, "energy_T"),
    "area": Quantity("A", AXISYMMETRIC),
    "volume": Quantity(r"\mathcal{V}", AXISYMMETRIC),
    "distance": Quantity("d", AXISYMMETRIC),
    **STARTS_OF_W,
    **DEFECTS,
    "flow_map": _apart("X", FLOW_MAP, in_time=True),
    "gauss_bonnet": _apart(r"\int K", GAUSS_BONNET, in_time=True),
    "energy_law": Quantity(r"\delta E", BALANCE, on_request=True),
    "volume_drift": Quantity(r"\delta \mathcal{V}", DRIFT, on_request=True),
}


def asked_for(names: Iterable[str]) -> tuple[str, ...]:
    """The quantities of these names, each with those that are shown beside it."""
    return tuple(n for name in names for n in (name, *QUANTITIES[name].beside))


def requestable(solution: InitialSurface, scheme: str = DEFAULT_SCHEME) -> tuple[str, ...]:
    """The quantities that are measured apart of the runs of a solution if a claim names them.

    The equations in which exact nodal values leave something are those of the default scheme; H and
    nu must be solved for, and nodes must be labels, where these are looked at.
    """
    plugin, exact = named_scheme(scheme), solution.always_exact
    equations = scheme == DEFAULT_SCHEME
    return (
        *(STARTS_OF_W if equations else ()),
        *(DEFECTS if equations and exact else ()),
        *(("flow_map",) if exact and not plugin.slides else ()),
        *(("gauss_bonnet",) if {"nu", "H"} <= set(plugin.offers) else ()),
    )


def measured(
    solution: InitialSurface, scheme: str = DEFAULT_SCHEME, law: Law | None = None
) -> tuple[str, ...]:
    """The quantities whose errors the runs of a solution have, with a scheme of that name and a
    law, whose energy counts where it is neither W nor the area, and its `balances`; beside those
    that are measured apart (`requestable`), which are all there is where nothing but the start is
    known."""
    if solution.reference == "start":
        return ()
    return (*_against_reference(solution, scheme, law), *balances(solution, law))


def balances(solution: InitialSurface, law: Law | None) -> tuple[str, ...]:
    """What is known of the flow by its law alone, if nothing forces it: how fast its energy falls,
    and whether the volume stays."""
    if law is None or solution.forcing(law.name, law.parameters) is not None:
        return ()
    return ("energy_law", "volume_drift") if law.name == "surface_diffusion" else ("energy_law",)


def _against_reference(solution: InitialSurface, scheme: str, law: Law | None) -> tuple[str, ...]:
    """The quantities that are compared with exact, computed or finer ones."""
    if solution.reference == "axisymmetric":
        further = law is not None and quantity_of(law.energy) == OF_ITS_OWN
        return (SHAPES[0], OF_ITS_OWN, *SHAPES[1:]) if further else SHAPES
    if isinstance(solution, SurfaceFlow):
        return (*VARIABLES,)
    if not solution.always_exact:
        return solution.measures
    if named_scheme(scheme).slides:
        return SHAPES
    return (*VARIABLES, *solution.measures) if scheme == DEFAULT_SCHEME else (*VARIABLES,)


def norm(name: str, solution: InitialSurface) -> str:
    """What the error of a quantity is, in words."""
    if solution.reference == "finest":
        return FINEST
    return SHAPE if name in SHAPES and solution.always_exact else QUANTITIES[name].norm


def size_errors(
    case: Case, found: dict[str, float], length: float | None = None
) -> dict[str, float]:
    """``err_size_<variable>``: how far the measured error of a variable is from its known size.

    Relative; NaN where the known size is zero or rounding. ``found`` has the measured errors
    ``err_<variable>`` of a case whose solution is a round sphere, in H^1 with this unit of length,
    by default that of the solution. The size is known if normals are projected.
    """
    solution, scheme = case.initial, case.scheme
    assert isinstance(solution, RoundSphere) and isinstance(scheme, KLLOptions)
    known = RadialRun(
        solution,
        case.law.name,
        case.law.parameters,
        scheme.bdf,
        case.tau,
        round(case.final_time / case.tau),
        self_started=not case.exact_start,
        reaction=scheme.reaction,
        first_steps=case.first_steps,
    ).errors(length)
    return {
        f"err_{size}": abs(found[f"err_{name}"] / known[name] - 1.0)
        if known[name] > ROUNDING
        else np.nan
        for size, name in SIZES.items()
    }


def odd_part(amplitude: Sequence[float], opposite: Sequence[float]) -> list[float]:
    """Half the difference of the amplitudes of two runs from opposite ones, level by level.

    What the discrete surface does of itself drops out, and so do the terms of even order of the
    law, of which the linear rate knows nothing: what is left of it is of second order, relative.
    """
    return (np.subtract(amplitude, opposite) / 2.0).tolist()


def decay_rate(t: Sequence[float], amplitude: Sequence[float]) -> float:
    """The rate r of a ~ exp(-r t) by least squares, until a has shrunk to `FOLLOWED`.

    NaN if there are fewer than three levels to fit, or one of them has another sign than the first
    or is of the size of `ROUNDING`.
    """
    if not abs(amplitude[0]) > ROUNDING:
        return float("nan")
    a = np.asarray(amplitude) / amplitude[0]
    used = np.flatnonzero(a < FOLLOWED)
    end = used[0] + 1 if len(used) else len(a)
    if not np.min(a[1:end], initial=np.inf) > ROUNDING / abs(amplitude[0]):
        return float("nan")
    return -_slope(t[1:end], a[1:end])


def growth_rate(t: Sequence[float], least: Sequence[float], greatest: Sequence[float]) -> float:
    """The rate of max ||nu| - 1| over the last decade before it reaches `DECADE_END`, or T.

    0 if it never exceeds `ROUNDING`: the few units in the last place by which normalised lengths
    miss 1 go up and down, and the slope of that is no growth. NaN if there are fewer than three
    levels above `ROUNDING` to fit.
    """
    deviation = np.maximum(np.abs(np.asarray(least) - 1.0), np.abs(np.asarray(greatest) - 1.0))
    if np.max(deviation) <= ROUNDING:
        return 0.0
    beyond = np.flatnonzero(deviation >= DECADE_END)
    end = beyond[0] + 1 if len(beyond) else len(t)
    start = 1 + int(np.argmax(deviation[1:end] >= deviation[end - 1] / 10.0)) if end > 1 else 1
    used = [n for n in range(start, end) if deviation[n] > ROUNDING]
    return _slope(np.asarray(t)[used], deviation[used])


def _slope(t: Sequence[float] | Array, a: Array) -> float:
    """d log a / dt by least squares, a > 0; NaN for fewer than three levels."""
    if len(t) < 3:
        return float("nan")
    return float(np.polyfit(t, np.log(a), 1)[0])
