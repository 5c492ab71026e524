"""The verdicts of a population: whether the share that meets some criteria is large enough."""

from __future__ import annotations

from workbench.model.arrays import Bools
from workbench.model.criterion import Criterion
from workbench.model.population_found import PopulationFound
from workbench.model.result import Finding, Verdict
from workbench.study.accommodation.shares import group_shares

__all__ = ["share_verdicts"]

_TOLERANCE = 1e-9
"""A share this much below the one asked for counts as it: less than one person in any sample."""


def share_verdicts(found: PopulationFound) -> tuple[Verdict, ...]:
    """Judge each criterion that asks for a share of the population, which takes a role.

    The estimate decides; its interval stands beside it.
    """
    criteria = found.study.share_criteria
    served = found.sets[:, found.sets.shape[1] - len(criteria) :]
    return tuple(
        _share_verdict(found, criterion, served[:, k]) for k, criterion in enumerate(criteria)
    )


def _share_verdict(found: PopulationFound, criterion: Criterion, served: Bools) -> Verdict:
    """The verdict of a criterion that so many people (P,) meet."""
    groups = group_shares(
        served,
        found.people,
        {},
        confidence=found.study.shares.confidence,
        interval=found.study.shares.interval,
    )
    everybody = next(iter(groups))
    finding = Finding(
        case="",
        person=found.place.role,
        other_person="",
        subject=everybody.group,
        target="",
        value=everybody.share,
        limit=criterion.at_least,
        unit="share",
    )
    passed = bool(finding.margin >= -_TOLERANCE)
    breaches = () if passed else (finding,)
    return Verdict(criterion, passed, finding, breaches, share=everybody)
