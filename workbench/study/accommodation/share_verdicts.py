"""The verdicts of a population: whether the share that meets some criteria is large enough.

The estimate of the spheres decides. Where the true surface of the body, within its fit error, could
decide otherwise, the verdict says so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.model.accommodation import SHARE_TOLERANCE, GroupShare, certainty_of
from workbench.model.arrays import Bools
from workbench.model.criterion import Criterion
from workbench.model.population_found import PopulationFound
from workbench.model.result import Finding, Verdict
from workbench.study.accommodation.shares import group_shares

__all__ = ["share_verdicts"]


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
