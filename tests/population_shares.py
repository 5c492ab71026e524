"""Joint shares: how many people are inside several limits at once, of a survey and of ways of
drawing people like those of one half of it, which are compared with the other half."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaln, stdtr, stdtrit

from workbench import draw_people
from workbench.body.people.sampling import fit_population
from workbench.model.arrays import Bools, Floats
from workbench.model.population import COCKPIT, SEXES, Population

__all__ = [
    "RULES",
    "Draw",
    "HeldOut",
    "Rule",
    "chance_rules",
    "gaussian",
    "held_out",
    "joint_shares",
    "likeliest_freedom",
    "synthetic",
    "t_copula",
]

STEPS = {"mass": 0.1, "interpupillary_breadth": 0.0005}
"""Steps in which ANSUR II was recorded [m; kg], where it is not a millimetre."""

SEATED = (
    "sitting_height",
    "eye_height_sitting",
    "buttock_knee_length",
    "knee_height_sitting",
    "popliteal_height",
    "thigh_clearance",
    "abdominal_extension_depth_sitting",
    "hip_breadth_sitting",
)
BREADTHS = (
    "hip_breadth_sitting",
    "bideltoid_breadth",
    "forearm_forearm_breadth",
    "waist_breadth",
    "chest_depth",
)
HEAD = (
    "head_length",
    "head_breadth",
    "interpupillary_breadth",
    "menton_sellion_length",
    "bizygomatic_breadth",
)


@dataclass(frozen=True)
class Rule:
    """What a workplace or a garment asks of a person: each measure between two percentiles [%] of
    the sex, 0 and 100 for no limit."""

    name: str
    measures: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def inside(self, people: Population, survey: Population) -> Bools:
        """(P,) who of one sex is within the limits, inclusive, that the survey's people give."""
        rows = people.of(self.measures).measures
        limits = survey.of(self.measures).measures
        edges = (
            np.array([_percentile(column, p) for column, p in zip(limits.T, levels, strict=True)])
            for levels in (self.low, self.high)
        )
        low, high = edges
        return np.asarray(np.all((rows >= low) & (rows <= high), axis=1))


def _percentile(column: Floats, level: float) -> float:
    """The least value measured that so many percent do not exceed; infinite for 0 and 100."""
    if level in (0, 100):
        return -np.inf if level == 0 else np.inf
    return float(np.percentile(column, level, method="inverted_cdf"))


def both(name: str, measures: Sequence[str], tail: float) -> Rule:
    """All measures between two percentiles, the same number at either end."""
    return Rule(name, tuple(measures), (tail,) * len(measures), (100 - tail,) * len(measures))


def upper(name: str, measures: Sequence[str], high: float) -> Rule:
    """Clearance: no measure above a percentile."""
    return Rule(name, tuple(measures), (0,) * len(measures), (high,) * len(measures))


def lower(name: str, measures: Sequence[str], low: float) -> Rule:
    """Reach: no measure below a percentile."""
    return Rule(name, tuple(measures), (low,) * len(measures), (100,) * len(measures))


RULES = (
    both("cockpit, six measures, 5 to 95", COCKPIT, 5),
    both("cockpit, six measures, 1 to 99", COCKPIT, 1),
    both("cockpit, three measures, 5 to 95", (COCKPIT[3], COCKPIT[1], COCKPIT[0]), 5),
    both("seated, eight measures, 5 to 95", SEATED, 5),
    both("seated, eight measures, 10 to 90", SEATED, 10),
    upper(
        "clearance, six measures, up to 95",
        (
            "sitting_height",
            "thigh_clearance",
            "buttock_knee_length",
            "knee_height_sitting",
            "bideltoid_breadth",
            "hip_breadth_sitting",
        ),
        95,
    ),
    upper(
        "clearance, eight measures, up to 90", (*SEATED[2:], "bideltoid_breadth", "foot_length"), 90
    ),
    lower(
        "reach, five measures, from 10",
        (
            "thumb_tip_reach",
            "buttock_popliteal_length",
            "eye_height_sitting",
            "overhead_fingertip_reach_sitting",
            "hand_length",
        ),
        10,
    ),
    lower("reach and view, eight measures, from 5", (*COCKPIT, "stature", "popliteal_height"), 5),
    Rule(
        "cockpit, reach from 5, clearance up to 95",
        (
            "thumb_tip_reach",
            "buttock_popliteal_length",
            "eye_height_sitting",
            "sitting_height",
            "buttock_knee_length",
            "thigh_clearance",
        ),
        (5, 5, 5, 0, 0, 0),
        (100, 100, 95, 95, 95, 95),
    ),
    Rule(
        "chair, four measures",
        (
            "popliteal_height",
            "buttock_popliteal_length",
            "hip_breadth_sitting",
            "elbow_rest_height",
        ),
        (5, 5, 0, 5),
        (95, 95, 95, 95),
    ),
    Rule(
        "light and tall, heavy and short left out",
        ("stature", "mass", "sitting_height", "waist_circumference"),
        (25, 0, 10, 0),
        (100, 75, 90, 75),
    ),
    both("stature, mass, sitting height, 10 to 90", ("stature", "mass", "sitting_height"), 10),
    both("stature, mass, reach, 25 to 75", ("stature", "mass", "thumb_tip_reach"), 25),
    upper("breadths, five measures, up to 75", BREADTHS, 75),
    both("helmet, five measures, 2 to 98", HEAD, 2),
    both(
        "gloves and shoes, five measures, 1 to 99",
        ("hand_length", "hand_breadth", "foot_length", "foot_breadth_horizontal", "mass"),
        1,
    ),
    both(
        "vest, four circumferences, 10 to 90",
        (
            "chest_circumference",
            "waist_circumference",
            "neck_circumference",
            "biceps_circumference_flexed",
        ),
        10,
    ),
)
"""Rules of plausible workplaces and garments, of 3 to 8 measures, of one and of two sides."""


def chance_rules(count: int, measures: Sequence[str], seed: int) -> tuple[Rule, ...]:
    """Rules nobody chose: 3 to 8 measures at random, limits of one or two sides at random."""
    chance = np.random.default_rng(seed)
    found = []
    for number in range(count):
        size = int(chance.integers(3, 9))
        names = chance.choice(np.array(measures), size, replace=False)
        sides = chance.integers(0, 3, size)
        tails = chance.choice([1.0, 2.0, 5.0, 10.0, 25.0], size)
        low = tuple(0.0 if side == 1 else tail for side, tail in zip(sides, tails, strict=True))
        high = tuple(
            100.0 if side == 0 else 100 - tail for side, tail in zip(sides, tails, strict=True)
        )
        found.append(Rule(f"chance {number}", tuple(map(str, names)), low, high))
    return tuple(found)


def joint_shares(people: Population, survey: Population, rules: Sequence[Rule]) -> Floats:
    """(R,) percent of people of one sex inside each rule, with the limits of the survey."""
    return np.array([100 * rule.inside(people, survey).mean() for rule in rules])


Draw = Callable[[Population, int, int], Population]
"""People of one sex like some measured ones: how many, and the seed."""


def synthetic(people: Population, count: int, seed: int) -> Population:
    """Draw the synthetic people of the workbench."""
    model = fit_population(people, name="half")
    return draw_people(model, count, seed=seed, men=_men(people), synthetic=True)


def gaussian(people: Population, count: int, seed: int) -> Population:
    """Draw from the Gaussian copula of the same figures, in the steps of the survey."""
    model = replace(fit_population(people, name="half"), people=None)
    drawn = draw_people(model, count, seed=seed, men=_men(people))
    return replace(drawn, measures=_recorded(drawn.measures, model.names))


def t_copula(people: Population, count: int, seed: int, *, freedom: float) -> Population:
    """Draw from the t copula of some degrees of freedom, in the steps of the survey."""
    chance = np.random.default_rng(seed)
    levels = _middle_ranks(people.measures)
    factor = np.linalg.cholesky(np.corrcoef(stdtrit(freedom, levels).T))
    normal = chance.standard_normal((count, len(people.names))) @ factor.T
    drawn = stdtr(freedom, normal * np.sqrt(freedom / chance.chisquare(freedom, (count, 1))))
    values = np.stack(
        [np.quantile(column, drawn[:, k]) for k, column in enumerate(people.measures.T)], axis=1
    )
    codes = np.full(count, people.sex[0])
    measures = _recorded(values, people.names)
    return Population(people.names, codes, np.ones(count), measures, "t copula")


def likeliest_freedom(people: Population, tried: Sequence[float]) -> float:
    """Of some degrees of freedom those with the greatest likelihood of a t copula for these people
    of one sex."""
    levels = _middle_ranks(people.measures)
    return max(tried, key=lambda freedom: _likelihood(levels, freedom))


def _likelihood(levels: Floats, freedom: float) -> float:
    """Log-likelihood of the t copula with Pearson's correlation of its scores, for levels (P, M)."""
    scores = stdtrit(freedom, levels)
    count, size = scores.shape
    factor = np.linalg.cholesky(np.corrcoef(scores.T))
    square = (np.linalg.solve(factor, scores.T) ** 2).sum(axis=0)
    joint = (
        gammaln((freedom + size) / 2)
        - gammaln(freedom / 2)
        - size / 2 * np.log(freedom * np.pi)
        - np.log(np.diag(factor)).sum()
        - (freedom + size) / 2 * np.log1p(square / freedom)
    )
    single = gammaln((freedom + 1) / 2) - gammaln(freedom / 2) - 0.5 * np.log(freedom * np.pi)
    margins = count * size * single - (freedom + 1) / 2 * np.log1p(scores**2 / freedom).sum()
    return float(joint.sum() - margins)


def _middle_ranks(measures: Floats) -> Floats:
    """(P, M) the middle rank of each value, 0 to 1; equal values share theirs."""
    levels = np.empty_like(measures)
    for k, column in enumerate(measures.T):
        _, each = np.unique(column, return_inverse=True)
        share = np.bincount(each) / len(column)
        levels[:, k] = (np.cumsum(share) - share / 2)[each]
    return levels


def _men(people: Population) -> float:
    return float(people.sex[0] == SEXES.index("male"))


def _recorded(measures: Floats, names: Sequence[str]) -> Floats:
    """Measures (P, M) [m; kg] rounded as the survey records them."""
    steps = np.array([STEPS.get(name, 0.001) for name in names])
    return np.asarray(np.round(np.rint(measures / steps) * steps, 9))


@dataclass(frozen=True)
class HeldOut:
    """Errors of a way of drawing people that was fitted to one half of a survey, against the other.

    All (R,) by rule, in points of percent. mean: over the splits, and error: its standard error;
    rms: of a single split; halves: rms difference of the halves themselves, the sampling alone.
    """

    mean: Floats
    error: Floats
    rms: Floats
    halves: Floats


def held_out(
    survey: Population, rules: Sequence[Rule], draw: Draw, *, splits: int, count: int, seed: int
) -> HeldOut:
    """Split people of one sex at random into halves, learn from either, try on the other."""
    chance = np.random.default_rng(seed)
    off, halves = [], []
    for split in range(splits):
        order = chance.permutation(len(survey))
        parts = [survey.rows(np.sort(order[k::2])) for k in (0, 1)]
        shares = [joint_shares(part, survey, rules) for part in parts]
        halves.append(shares[0] - shares[1])
        for k in (0, 1):
            drawn = draw(parts[k], count, 1000 * seed + 2 * split + k)
            off.append(joint_shares(drawn, survey, rules) - shares[1 - k])
    mean = np.mean(off, axis=0)
    rms = np.sqrt(np.mean(np.square(off), axis=0))
    pairs = (np.array(off[::2]) + np.array(off[1::2])) / 2
    error = (
        pairs.std(axis=0, ddof=1) / np.sqrt(splits) if splits > 1 else np.full(len(rules), np.nan)
    )
    return HeldOut(mean, error, rms, np.sqrt(np.mean(np.square(halves), axis=0)))
