"""The verdicts of a population: whether the share that meets some criteria is large enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import Accommodation, ShareVerdict
from workbench.model.criterion import Criterion
from workbench.study.accommodation.shares import group_shares

__all__ = ["with_share_verdicts"]

_TOLERANCE = 1e-9
"""A share this much below the one asked for counts as it: less than one person in any sample."""


def with_share_verdicts(result: Accommodation, criteria: Sequence[Criterion]) -> Accommodation:
    """The result with a verdict for each criterion that asks for a share.

    The estimate decides; its interval stands beside it.
    """
    study = result.study
    verdicts = []
    for criterion in criteria:
        if criterion.check != "share":
            continue
        asked = [
            not criterion.of or requirement.criterion in criterion.of
            for requirement in result.requirements
        ]
        served = np.asarray(result.met[:, asked].all(axis=1), dtype=np.bool_)
        everybody = next(
            iter(
                group_shares(
                    served, study.people, {}, confidence=study.confidence, interval=study.interval
                )
            )
        )
        passed = bool(everybody.share >= criterion.at_least - _TOLERANCE)
        verdicts.append(ShareVerdict(criterion, passed, everybody))
    return replace(result, verdicts=tuple(verdicts))
