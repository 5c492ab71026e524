"""Shares of people: jointly, by group, and of each requirement who misses it only and who would meet
all without it; and how margins are spread."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from workbench.body.people.percentile import quantiles
from workbench.body.people.proportions import bootstrap_share, proportion_interval
from workbench.model.accommodation import (
    SHARE_TOLERANCE,
    Certainty,
    GroupShare,
    IntervalRule,
    certainty_of,
)
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.criterion import Criterion
from workbench.model.population import SEXES, Population
from workbench.model.result import Finding, PopulationFound, Verdict

__all__ = [
    "LEVELS",
    "group_shares",
    "missed_only",
    "mix_weights",
    "share_single",
    "share_verdicts",
    "share_without",
    "spread_of",
    "weighted_share",
]

LEVELS = (0.01, 0.05, 0.5, 0.95, 0.99)
"""The shares of people at which margins are reported."""
WILSON = IntervalRule()
_WORDS = {"male": "men", "female": "women"}


def group_shares(
    served: Bools,
    people: Population,
    mixes: Mapping[str, float],
    *,
    certainty: Certainty | None = None,
    overlapping: Bools | None = None,
    confidence: float = 0.95,
    interval: IntervalRule = WILSON,
) -> Iterator[GroupShare]:
    """The share served (P,) of everybody, of each sex, and of everybody weighted to each mix of the
    sexes.

    Wilson's interval, with weights of Kish's effective count; or that of the bootstrap, which draws
    from each sex as many as there are where the sexes are weighted to a mix.

    certainty: who of the P people is served wherever the true surface of the body lies, and who is
    if it lies where it suits. overlapping: who of them overlaps something by more than is allowed.
    Either is None where that is not known.
    """

    def share(group: str, rows: Bools, weight: Floats, strata: Ints | None = None) -> GroupShare:
        found = _share(group, served[rows], weight[rows], confidence, interval, strata)
        if overlapping is not None:
            clear = served[rows] & ~overlapping[rows]
            found = replace(found, clear=weighted_share(clear, weight[rows]))
        if certainty is None:
            return found
        return replace(
            found,
            certain=weighted_share(certainty.certain[rows], weight[rows]),
            possible=weighted_share(certainty.possible[rows], weight[rows]),
        )

    everybody = np.ones(len(people), dtype=np.bool_)
    yield share("everybody", everybody, people.weight)
    present = [sex for sex in SEXES if np.any(people.sex == SEXES.index(sex))]
    if len(present) < 2:
        return
    for sex in present:
        rows = people.sex == SEXES.index(sex)
        yield share(_WORDS[sex], rows, people.weight)
    for name, women in mixes.items():
        weight = mix_weights(people, women)
        rows = weight > 0
        yield share(name, rows, weight, people.sex[rows])


def _share(
    group: str,
    served: Bools,
    weight: Floats,
    confidence: float,
    rule: IntervalRule,
    strata: Ints | None = None,
) -> GroupShare:
    """The share of people (P,) who are served, with its interval."""
    if rule.method == "bootstrap":
        found = bootstrap_share(
            served,
            weight=weight,
            strata=strata,
            seed=rule.seed,
            draws=rule.draws,
            confidence=confidence,
        )
    else:
        found = proportion_interval(served, weight=weight, confidence=confidence)
    return GroupShare(group, found.share, found.low, found.high, found.count)


def mix_weights(people: Population, women: float) -> Floats:
    """(P,) weights under which so much of all weight, 0 to 1, is that of women; those within a sex
    stay in proportion."""
    weight = np.zeros(len(people))
    for sex, share in (("male", 1.0 - women), ("female", women)):
        rows = people.sex == SEXES.index(sex)
        if rows.any():
            weight[rows] = people.weight[rows] * (share / people.weight[rows].sum())
    return weight


def weighted_share(some: Bools, weight: Floats) -> float:
    """The share of the weight (P,) that some people (P,) have."""
    return float(weight[some].sum() / weight.sum())


def share_single(met: Bools, weight: Floats) -> Floats:
    """(R,) the share of weight (P,) that meets each requirement (P, R)."""
    share: Floats = weight @ met / weight.sum()
    return share


def share_without(others: Bools, weight: Floats) -> Floats:
    """(R,) the share that would fit if one requirement were dropped; others (P, R): whether a
    person meets all others in some position."""
    share: Floats = weight @ others / weight.sum()
    return share


def missed_only(met: Bools, weight: Floats) -> Floats:
    """(R,) the share that misses one requirement (P, R) and no other, each person in one position:
    no more than misses it, and no more than would fit without it beside those who fit."""
    missed = ~met
    only = missed & (missed.sum(axis=1) == 1)[:, None]
    share: Floats = weight @ only / weight.sum()
    return share


def spread_of(margin: Floats, weight: Floats) -> Floats:
    """(R, 5) [m] the margins (P, R) at 1, 5, 50, 95 and 99 % of the weight; NaN where a requirement
    applies to nobody."""
    spread = np.full((margin.shape[1], len(LEVELS)), np.nan)
    for r in range(margin.shape[1]):
        known = ~np.isnan(margin[:, r])
        if known.any():
            spread[r] = quantiles(margin[known, r], weight[known], np.array(LEVELS))
    return spread


# The verdicts of a population: whether the share that meets some criteria is large enough.
#
# The estimate of the spheres decides. Where the true surface of the body, within its fit error, could
# decide otherwise, the verdict says so.


def share_verdicts(found: PopulationFound) -> tuple[Verdict, ...]:
    """Judge each criterion that asks for a share of the population, which takes a role.

    The estimate decides; its interval stands beside it.
    """
    criteria = found.study.share_criteria
    served = found.sets[:, found.sets.shape[1] - len(criteria) :]
    return tuple(
        _share_verdict(criterion, _everybody(found, criterion, served[:, k]), found.place.role)
        for k, criterion in enumerate(criteria)
    )


def _everybody(found: PopulationFound, criterion: Criterion, served: Bools) -> GroupShare:
    """The share of all people who meet a criterion; served (P,): those who do by the spheres.

    Who does so in another position than that of the margins is not certain to.
    """
    names = np.array([requirement.criterion for requirement in found.requirements])
    mine = np.isin(names, criterion.of) if criterion.of else np.ones(len(names), dtype=np.bool_)
    certainty = certainty_of(
        found.margin[:, mine], found.low[:, mine], found.high[:, mine], found.elsewhere
    )
    if certainty is not None:
        certainty = replace(certainty, possible=served | certainty.possible)
    groups = group_shares(
        served,
        found.people,
        {},
        certainty=certainty,
        confidence=found.study.shares.confidence,
        interval=found.study.shares.interval,
    )
    return next(iter(groups))


def _share_verdict(criterion: Criterion, everybody: GroupShare, role: str) -> Verdict:
    """The verdict of a criterion that a share of all people meets."""
    finding = Finding(
        case="",
        person=role,
        other_person="",
        subject=everybody.group,
        target="",
        value=everybody.share,
        limit=criterion.at_least,
        unit="share",
    )
    passed = bool(finding.margin >= -SHARE_TOLERANCE)
    breaches = () if passed else (finding,)
    doubtful = finding if everybody.leaves_open(criterion.at_least) else None
    return Verdict(criterion, passed, finding, breaches, doubtful, share=everybody)
