r"""The posterior of an order over a grid of runs in both parameters.

The error in the judged parameter s, a = A s^p e^g, and that in the other one, b = B o^q, add as
vectors do:

    E^2 = a^2 + 2 rho a b + b^2,   rho in [-1, 1];

rho = 1 adds norms, an upper bound, and rho = -1 is cancellation.  q, the ratio b / a on the finest
levels, rho and the shape g (pure, a next order, a saturation) run over a grid.  About each of its
points the best p, and the best ratio within the step of the grid, are found by Gauss and Newton,
and both are integrated over as normal (`posterior.mixture`).  Scatter is independent, or that of
the meshes: one number for all runs with the same s, and a little on top.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from esfem.judging.families import NAMES, Orders
from esfem.judging.posterior import HIGHEST, LOWEST, Posterior, mixture
from esfem.judging.scatter import SIZE_PRIOR, SIZES, printed_variance
from esfem.judging.table_columns import Array

FEWEST_RUNS = 6
WIDEST = (HIGHEST - LOWEST) / 4.0  # twice this each way holds all orders that are thought of
# rho: norms that add, vectors at any angle, parts that cancel.
ADD, CANCEL, CELLS = 0.22, 0.06, 8
RATIOS = np.linspace(-7.0, 5.0, 25)  # log of b / a on the finest levels
WITHIN = float(RATIOS[1] - RATIOS[0]) / np.sqrt(12.0)  # of the ratio, in a step
ORDERS = {0.5: 0.1, 1.0: 0.3, 1.5: 0.1, 2.0: 0.3, 3.0: 0.12, 4.0: 0.08}  # q, where it is not known
AROUND = {0.0: 0.70, -1.0: 0.10, -0.5: 0.07, 0.5: 0.07, 1.0: 0.06}  # q about what is expected
SHAPES = {0.0: 0.64, 1.0: 0.18, 2.0: 0.18}  # m of the next order or saturation; 0: pure
FIRST, SPLIT = 700, 3  # points that are kept, and parts into which their cells of rho are split
TYPICAL = 0.02  # scatter by which the best ratios are found
POLISH = 4  # steps for the likeliest point, free of its start
SHARED = (0.55, 0.25, 0.20)  # priors: independent, of the meshes with 0.1 % or with 1 % on top
ON_TOP = (1e-3, 1e-2)
NEAR = 0.3  # the least ratio of the smaller to the larger part where they may cancel
ALMOST = -0.9  # rho, from which down to -1 they do
TINY = 1e-5  # of the larger part: what is left where they cancel


@dataclass(frozen=True)
class JointFit:
    """The likeliest point: A s^p and B o^q, at an angle ``rho``; ``q_given`` if q was expected.

    ``p_interval`` holds p with 95 %, ``scatter`` is that of log E, ``share`` that of the part in o
    on the finest levels, on average over all fits, and ``cancels`` the probability that the parts
    cancel somewhere in the table.
    """

    A: float
    p: float
    p_interval: tuple[float, float]
    B: float
    q: float
    q_given: bool
    rho: float
    scatter: float
    share: float
    cancels: float

    def other_term(self, value: float) -> float:
        """B o^q at o = ``value``."""
        return float(np.exp(np.clip(np.log(self.B) + self.q * np.log(value), -700.0, 700.0)))


@dataclass(frozen=True)
class Grid:
    """Runs at s and o with errors e, (n,), and logarithms from the finest level."""

    s: Array
    o: Array
    e: Array

    @property
    def x(self) -> Array:
        """log(s / s_finest)."""
        return np.log(self.s / self.s.min())

    @property
    def t(self) -> Array:
        """log(o / o_finest)."""
        return np.log(self.o / self.o.min())

    @property
    def enough(self) -> bool:
        """Whether both parts can be told apart."""
        few = len(self.e) < FEWEST_RUNS
        return not few and len(np.unique(self.s)) >= 3 and len(np.unique(self.o)) >= 2


@dataclass(frozen=True)
class Points:
    """Points of the grid of parameters with p and ``ratio`` about them, (points,).

    ``start`` is the ratio of the grid, ``g`` the shape of the part in s, (points, n).
    """

    prior: Array
    q: Array
    start: Array
    rho: Array
    width: Array
    g: Array
    family: NDArray[np.int_]
    p: Array
    ratio: Array

    def __len__(self) -> int:
        return len(self.prior)

    def at(self, chosen: NDArray[np.int_]) -> "Points":
        """Some of them."""
        return Points(**{name: values[chosen] for name, values in vars(self).items()})

    def split(self) -> "Points":
        """Each in parts of its cell of rho."""
        within = (np.arange(SPLIT) - (SPLIT - 1) / 2) / SPLIT
        part = self.at(np.repeat(np.arange(len(self)), SPLIT))
        rho = part.rho + part.width * np.tile(within, len(self))
        return replace(part, rho=rho, prior=part.prior - np.log(SPLIT))

    def residual(self, grid: Grid, y: Array) -> tuple[Array, Array, Array]:
        """What is left of log errors y, and the derivatives of the model by p and the ratio."""
        log_r = self.ratio[:, None] + self.q[:, None] * grid.t - self.p[:, None] * grid.x - self.g
        r = np.exp(np.clip(log_r, -40.0, 40.0))
        rho = self.rho[:, None]
        square = 1.0 + r * (2.0 * rho + r) + TINY**2 * (1.0 + r * r)
        by_ratio = r * (rho + r) / square
        left = y - self.p[:, None] * grid.x - self.g - 0.5 * np.log(square)
        return left, grid.x * (1.0 - by_ratio), by_ratio

    def stepped(self, grid: Grid, y: Array, scatter: float = TYPICAL) -> tuple["Points", Array]:
        """After one step of Gauss and Newton in p and the ratio; what was to be minimised.

        The smaller the ``scatter``, the less the ratio is bound to its start.
        """
        parts = [v - v.mean(axis=1, keepdims=True) for v in self.residual(grid, y)]
        left, a, b = parts
        ridge = (scatter / WITHIN) ** 2
        away = self.ratio - self.start
        aa, ab = (a * a).sum(axis=1) + 1e-9, (a * b).sum(axis=1)
        bb = (b * b).sum(axis=1) + ridge
        la, lb = (left * a).sum(axis=1), (left * b).sum(axis=1) - ridge * away
        det = np.maximum(aa * bb - ab**2, 1e-15)
        p = np.clip(self.p + np.clip((bb * la - ab * lb) / det, -2.0, 2.0), -3.0, 12.0)
        ratio = self.ratio + np.clip((aa * lb - ab * la) / det, -0.5, 0.5)
        return replace(self, p=p, ratio=ratio), (left**2).sum(axis=1) + ridge * away**2


def plane_posterior(grid: Grid, k: float, q: float | None) -> tuple[Posterior, JointFit]:
    """The posterior of the order in s, claimed k, and the likeliest fit; ``q`` as expected."""
    points, y = _points(grid, k, q), np.log(grid.e)
    for _ in range(2):
        points, cost = points.stepped(grid, y)
    points = points.at(np.argsort(cost)[:FIRST]).split()
    for _ in range(3):
        points, _ = points.stepped(grid, y)
    return _weighed(points, grid, y, k, q is not None)


def _points(grid: Grid, k: float, q: float | None) -> Points:
    """All points with their log priors."""
    around = ORDERS if q is None else {q + shift: w for shift, w in AROUND.items() if q + shift > 0}
    g, g_prior, family = _shapes(grid.x)
    width = 2.0 / CELLS
    rho = np.array([1.0, -1.0, *(-1.0 + width * (np.arange(CELLS) + 0.5))])
    rho_prior = np.array([ADD, CANCEL, *([(1.0 - ADD - CANCEL) / CELLS] * CELLS)])
    orders, order_prior = np.array(list(around)), np.array(list(around.values()))
    sizes = (len(orders), len(RATIOS), len(rho), len(g))
    i, j, n, m = (axis.ravel() for axis in np.indices(sizes))
    prior = order_prior[i] / order_prior.sum() * rho_prior[n] * g_prior[m] / len(RATIOS)
    return Points(
        np.log(prior),
        orders[i],
        RATIOS[j],
        rho[n],
        np.where(np.abs(rho[n]) < 1.0, width, 0.0),
        g[m],
        family[m],
        # Where b is small the errors fall as a does, elsewhere anything may hide.
        np.where(RATIOS[j] < 0.0, _slope(grid), k),
        RATIOS[j].copy(),
    )


def _slope(grid: Grid) -> float:
    """The mean slope of log e on the lines of s."""
    member = np.eye(len(np.unique(grid.o)))[np.unique(grid.o, return_inverse=True)[1]]
    share = member / member.sum(axis=0)
    x, y = (v - member @ (share.T @ v) for v in (grid.x, np.log(grid.e)))
    return float(x @ y / max(float(x @ x), 1e-12))


def _shapes(x: Array) -> tuple[Array, Array, NDArray[np.int_]]:
    """g of the part in s with priors and families: pure, a next order, a saturation."""
    g, prior, family = [], [], []
    for m, weight in SHAPES.items():
        if m == 0.0:
            g, prior, family = [np.zeros_like(x)], [weight], [NAMES.index("pure power")]
            continue
        for v in (-1.0, -1.0 - 0.6 * m * float(x.max())):
            bent = np.log1p(np.exp(v + m * x))
            g += [bent, -bent]
            prior += [weight / 3.0, weight / 6.0]
            family += [NAMES.index("next order"), NAMES.index("saturation")]
    return np.array(g), np.array(prior), np.array(family)


def _weighed(
    points: Points, grid: Grid, y: Array, k: float, q_given: bool
) -> tuple[Posterior, JointFit]:
    """The likelihood about the best p and ratios, for each pattern of scatter."""
    left, by_p, by_ratio = points.residual(grid, y)
    left = left - left.mean(axis=1, keepdims=True)
    vectors = (np.ones_like(left), by_ratio, by_p, left)
    member = np.eye(len(np.unique(grid.s)))[np.unique(grid.s, return_inverse=True)[1]]
    sums = [vector @ member for vector in vectors]
    count = member.sum(axis=0)
    pairs = [(a, b) for a in range(4) for b in range(a, 4)]
    inner = {(a, b): (vectors[a] * vectors[b]).sum(axis=1) for a, b in pairs}
    products = {(a, b): sums[a] * sums[b] for a, b in pairs}
    printed = float(printed_variance(grid.e).mean())
    away = points.ratio - points.start
    found, sizes = [], []
    for size, how_often in zip(SIZES, SIZE_PRIOR / SIZE_PRIOR.sum(), strict=True):
        for number, share in enumerate(SHARED):
            common = size**2 if number else 0.0
            own = (ON_TOP[number - 1] ** 2 if number else size**2) + printed
            weight = common / (own + common * count)
            G = {ab: (inner[ab] - products[ab] @ weight) / own for ab in pairs}
            G[1, 1] = G[1, 1] + 1.0 / WITHIN**2
            G[1, 3] = G[1, 3] - away / WITHIN**2
            G[3, 3] = G[3, 3] + (away / WITHIN) ** 2
            log_det = np.log(G[0, 0])
            _eliminate(G, 0)
            log_det = log_det + np.log(np.maximum(G[1, 1], 1e-12)) + 2.0 * np.log(WITHIN)
            _eliminate(G, 1)
            spread = np.maximum(G[2, 2], 1e-9)
            change = G[2, 3] / spread
            rss = np.maximum(G[3, 3] - change**2 * spread, 0.0)
            log_det = log_det + len(y) * np.log(own) + np.log1p(common * count / own).sum()
            level = points.prior + np.log(how_often * share) - 0.5 * (log_det + rss)
            # Where the table says nothing of the order, it is anywhere among those thought of.
            order = np.clip(points.p + change, LOWEST, k + HIGHEST)
            found.append((level, order, np.minimum(1.0 / np.sqrt(spread), WIDEST)))
            sizes.append(size)
    level, p, sd = (np.stack(values, axis=1) for values in zip(*found, strict=True))
    none, zero = np.full(len(points), np.nan), np.zeros(len(points))
    result = mixture(level, p, sd, k, Orders(points.family, zero - np.inf, none, none, zero, zero))
    return result, _likeliest(result, points, np.array(sizes), grid, y, q_given)


def _eliminate(G: dict[tuple[int, int], Array], pivot: int) -> None:
    """Takes one unknown out of the normal equations."""
    for a in range(pivot + 1, 4):
        for b in range(a, 4):
            G[a, b] = G[a, b] - G[pivot, a] * G[pivot, b] / np.maximum(G[pivot, pivot], 1e-12)


def _likeliest(
    result: Posterior, points: Points, sizes: Array, grid: Grid, y: Array, q_given: bool
) -> JointFit:
    """The likeliest point, and how likely the parts cancel."""
    top = int(np.argmax(np.bincount(result.shape, result.weight, len(points))))
    one = points.at(np.array([top]))
    for _ in range(POLISH):
        one, _ = one.stepped(grid, y, scatter=1e-4)
    left, _, _ = one.residual(grid, y)
    p, q = float(one.p[0]), float(one.q[0])
    log_a = float(left.mean()) - p * np.log(grid.s.min())
    log_b = float(one.ratio[0] + left.mean()) - q * np.log(grid.o.min())
    log_r = points.ratio[:, None] + points.q[:, None] * grid.t - points.p[:, None] * grid.x
    near = (np.abs(log_r - points.g) < -np.log(NEAR)).any(axis=1) & (points.rho <= ALMOST)
    lower, upper = result.quantile(0.025, 0.975)
    return JointFit(
        A=float(np.exp(np.clip(log_a, -300, 300))),
        p=p,
        p_interval=(lower, upper),
        B=float(np.exp(np.clip(log_b, -300, 300))),
        q=q,
        q_given=q_given,
        rho=float(one.rho[0]),
        scatter=float(np.exp(result.weight @ np.log(sizes[result.pattern]))),
        share=float(result.weight @ (1.0 / (1.0 + np.exp(-points.ratio)))[result.shape]),
        cancels=result.share(near[result.shape]),
    )
