"""Controls that nobody reaches because one part is in the way.

Such a reach tells more about how the place is described than about the people: the part may be the
control's own stalk, which a hand may enter as it enters the knob.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.files.environment_own import GRIPPABLE, Touching, part_meshes
from workbench.model.accommodation import Requirement, met_of
from workbench.model.arrays import Floats, Ints
from workbench.model.criterion import Criterion, Reason
from workbench.model.environment import Control, Environment
from workbench.model.result import ControlReach, PopulationFound

__all__ = ["KeptReach", "kept_by_parts", "kept_of_people", "kept_of_population", "kept_words"]

_ALMOST = 0.05
"""Where no more than this share of those whose limb is long enough reach a control, almost nobody
does."""
_MOSTLY = 0.5
"""One part is the reason where it keeps at least this share of all whom parts keep."""
_SOME = 0.1
"""And at least this share of all people: fewer are an accident."""


@dataclass(frozen=True)
class KeptReach:
    """A control that one part keeps everybody from, or almost everybody whose limb is long enough.

    Parameters
    ----------
    who
        Who does not reach it, with the verb: "nobody reaches".
    requirement
        The name of what is asked, "" of single people.
    control, part
        The control, and the part in the way.
    beside
        The part of the control that this one touches; "" where it touches none, or is too large to
        be a piece of a control.
    least, most
        [m] By how much it is in the way.
    """

    who: str
    requirement: str
    control: Control
    part: str
    beside: str
    least: float
    most: float


def kept_of_population(found: PopulationFound) -> list[KeptReach]:
    """Find the controls that one part keeps a whole population from."""
    return kept_by_parts(
        found.place.environment,
        found.requirements,
        margin=found.margin,
        reason=found.reason,
        reasons=found.reasons,
        weight=found.people.weight,
    )


def kept_by_parts(
    environment: Environment,
    requirements: Sequence[Requirement],
    *,
    margin: Floats,
    reason: Ints,
    reasons: Sequence[Reason],
    weight: Floats,
) -> list[KeptReach]:
    """Find the controls that one part keeps everybody from.

    Parameters
    ----------
    environment
        Where the P people are.
    requirements
        All R that are asked.
    margin, reason, reasons, weight
        As of `PopulationFound`; weight (P,) of its people.
    """
    controls = {control.name: control for control in environment.controls}
    touching = Touching(part_meshes(environment))
    found = []
    for r, one in enumerate(requirements):
        if one.check != "reach" or one.target not in controls:
            continue
        limits = np.array([reasons[code].part if code >= 0 else "" for code in reason[:, r]])
        missed = ~met_of(margin[:, r])
        kept = missed & np.isin(limits, environment.parts)
        counted = np.where(~np.isnan(margin[:, r]), weight, 0.0)
        by_part = {part: float(counted @ (kept & (limits == part))) for part in set(limits[kept])}
        if not by_part:
            continue
        part = min(by_part, key=lambda name: (-by_part[name], name))
        reached = float(counted @ ~missed)
        able = reached + float(counted @ kept)
        enough = max(_MOSTLY * float(counted @ kept), _SOME * float(counted.sum()))
        if reached > _ALMOST * able or by_part[part] < enough:
            continue
        short = -margin[kept & (limits == part), r]
        control = controls[one.target]
        who = _who(control, some=reached > 0.0, all_able=able >= float(counted.sum()) - 1e-9)
        beside = _touched(touching, control, part)
        found.append(
            KeptReach(who, one.name, control, part, beside, float(short.min()), float(short.max()))
        )
    return found


def _who(control: Control, *, some: bool, all_able: bool) -> str:
    """Who does not reach a control. some: a few do; all_able: nobody's limb is too short."""
    limb = "leg" if control.for_feet else "arm"
    able = "" if all_able else f" whose {limb} is long enough"
    return f"{'almost nobody' if some else 'nobody'}{able} reaches"


def kept_of_people(
    environment: Environment, criteria: Iterable[Criterion], reaches: Iterable[ControlReach]
) -> list[KeptReach]:
    """Find the controls that single people miss for a part that touches them, of the reaches that
    criteria ask for: by how much in the best and in the worst of these."""
    controls = {control.name: control for control in environment.controls}
    asked = [criterion for criterion in criteria if criterion.check == "reach"]
    touching = Touching(part_meshes(environment))
    kept: dict[tuple[str, str, str], KeptReach] = {}
    for row in reaches:
        wanted = any(_is_asked(criterion, row) for criterion in asked)
        if row.reached or not row.limit.part or not wanted:
            continue
        control = controls[row.control]
        beside = _touched(touching, control, row.limit.part)
        short = row.miss + row.overlap
        if beside:
            who = f"{row.person} does not reach"
            key = who, row.control, row.limit.part
            one = kept.get(key, KeptReach(who, "", control, row.limit.part, beside, short, short))
            # in another case, zone or with the other hand it is another distance
            kept[key] = replace(one, least=min(one.least, short), most=max(one.most, short))
    return list(kept.values())


def _is_asked(criterion: Criterion, row: ControlReach) -> bool:
    """Whether a criterion asks for a reach, in this zone and with this hand."""
    return (
        row.control in criterion.controls
        and row.person in criterion.people
        and row.hand == (criterion.hand or "")
        and row.zone == (criterion.zone or row.own_zone)
    )


def _touched(touching: Touching, control: Control, part: str) -> str:
    """The part of a control that another touches, with which it could be one thing; "" for none, and
    where it is the control's already."""
    if part in control.own_parts:
        return ""
    names = touching.meshes.names
    other = names.index(part)
    for name in control.own_parts:
        own = names.index(name)
        small = touching.extent([own, other]) <= GRIPPABLE
        if small and touching.touch(own, other):
            return name
    return ""


def kept_words(kept: Iterable[KeptReach]) -> Iterator[str]:
    """Say which controls are not reached for what, and what to do about it."""
    for one in kept:
        name = one.control.name
        ends = [f"{1000 * value:.1f}" for value in (one.least, one.most)]
        by = " to ".join(dict.fromkeys(ends))
        words = (
            f"{one.who} {name}: {one.part} is in the way, {one.control.limbs} stay {by} mm short"
        )
        if one.part in one.control.own_parts:
            words += f"; it is a piece of {name} itself: its point may lie too deep in it"
        if one.beside:
            own = ", ".join((*one.control.own_parts, one.part))
            words += (
                f"; it touches {one.beside}: is it the control's own stalk, base or screw? "
                f"If it is, 'part: [{own}]' of {name} says so"
            )
        yield words
