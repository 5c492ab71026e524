"""Forces on controls: what a hand or foot exerts on the control that it is on, by a stated share of
such people at least.

Such people are those of the same sex and size in the same posture. Who does not get to the control
exerts nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion, Finding, Reason
from workbench.model.units import plain, unit_of
from workbench.strain.arm_strength import arms_of, hand_strength
from workbench.strain.leg_strength import foot_strength
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.checks.seat_travel import ON_PEDAL
from workbench.study.situation import Situation

__all__ = ["findings", "margins"]


@dataclass(frozen=True, eq=False)
class _Exerted:
    """What B people exert on a control.

    Parameters
    ----------
    limb
        "left hand", "right foot".
    force
        (B,) [N] by the stated share of such people at least, 0 of who does not get there.
    limits
        What gives way first, of each person: "arm", "knee extension".
    beyond
        (B,) True where the model was not measured there.
    source
        The model, and how sure its numbers are.
    """

    limb: str
    force: Floats
    limits: tuple[str, ...]
    beyond: Bools
    source: str


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How many newtons everybody exerts more than is needed."""
    found = no_margins(len(situation), asked)
    for r, one in enumerate(asked):
        criterion = one.criterion
        exerted = _exerted(situation, criterion, one.requirement.target)
        found.margin[:, r] = unit_of("force").counted(exerted.force - criterion.at_least)
        for b in np.flatnonzero(found.margin[:, r] < -MET).tolist():
            found.words[b, r] = Reason("words", f"the strength of the {exerted.limits[b]}")
    return found


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """What a person exerts on each control."""
    for name in criterion.controls:
        exerted = _exerted(situation, criterion, name)
        sex = "men" if situation.male[0] else "women"
        limit = f"the {exerted.limits[0]} gives way first"
        beyond = ", outside of what was measured" if exerted.beyond[0] else ""
        yield Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=f"{exerted.limb} on {plain(name)}",
            target=f"by {100 * criterion.capable:g} % of such {sex}, {limit}{beyond}",
            value=float(exerted.force[0]),
            limit=criterion.at_least,
            unit="N",
            source=exerted.source,
            about=name,
        )


def _exerted(situation: Situation, criterion: Criterion, name: str) -> _Exerted:
    """The force of the limb that is on a control."""
    limb = next(limb for limb, control in situation.work.held.items() if control == name)
    control = next(one for one in situation.environment.controls if one.name == name)
    at = situation.where([control])[:, 0]
    side = cast(Literal["left", "right"], limb.split()[0])
    placed = situation.placed
    rules = criterion.rule_set
    assert rules is not None
    if limb.endswith("hand"):
        arms = arms_of(placed, side, hand=at)
        arm = hand_strength(arms, criterion.direction, male=situation.male, rules=rules)
        force, limits, beyond = (
            arm.strength(criterion.capable),
            ("arm",) * len(placed),
            arm.extrapolated,
        )
        stays = situation.hand_miss.get(limb)
    else:
        leg = foot_strength(
            placed,
            side,
            criterion.direction,
            male=situation.male,
            stature=_statures(situation.body),
            ages=cast(Literal["18-25", "55-65", "65+"], criterion.ages),
            foot=at,
            lean=criterion.lean,
            rules=rules,
        )
        force, limits, beyond = leg.strength(criterion.capable), leg.limits, leg.beyond
        stays = situation.seated.miss.get(limb) if situation.seated is not None else None
    off = np.zeros(len(placed), dtype=np.bool_) if stays is None else stays > ON_PEDAL
    told = tuple("reach" if gone else what for gone, what in zip(off, limits, strict=True))
    return _Exerted(limb, np.where(off, 0.0, force), told, beyond, rules.description)


def _statures(body: Body) -> Floats:
    """(B,) [m] from the lowest to the highest of the own spheres, standing, without what is worn."""
    own = [k for k, name in enumerate(body.sphere_names) if not name.endswith(")")]
    heights = (body.zero_origins[:, body.sphere_segment] + body.centre)[:, own, 2]
    radius = body.radius[:, own]
    found: Floats = np.max(heights + radius, axis=1) - np.min(heights - radius, axis=1)
    return found
