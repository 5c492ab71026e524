"""What people who stand reach by leaning, bending and stepping: harness zone 3 without a harness.

The posture is that of `standing_posture`, then the arm is brought to the control clear of obstacles.
Who would be in a part with trunk or legs tries it from farther back, as far as the area goes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from workbench.body.forward import place
from workbench.contact.collide import contacts
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.criterion import NO_REASON, Reason
from workbench.model.environment import Control
from workbench.model.poses import Poses
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.reach import reach
from workbench.posture.standing import standing_posture
from workbench.study.situation import ARMS_ALONE, Situation

__all__ = ["Bent", "bent_reaches"]

BACK = 0.1
TRIES = 4
"""Who is in a part tries it from so much [m] farther back, so often."""
LEAST = 1e-3
"""A posture comes to a target that its hand misses by less [m]."""
DEEPER = 1e-3
"""Depth [m] by which trunk or legs may be deeper in a part than in the posture that bending begins
from."""


@dataclass(frozen=True, eq=False)
class Bent:
    """How P people who bend reach a control each."""

    reached: Bools
    """(P,)."""
    miss: Floats
    """(P,) [m]."""
    overlap: Floats
    """(P,) [m] how deep they are in a part that they may not be in."""
    spare: Floats
    """(P,) [m] how much farther the arm would reach from there."""
    discomfort: Floats
    """(P,) of the arm."""
    limit: NDArray[np.object_]
    """(P,) what limits it in words."""

    def better(self, rows: Ints, other: Bent) -> Bent:
        """The same with what comes nearer to the control in another try of some rows."""
        short = np.where(self.reached[rows], 0.0, self.miss[rows] + self.overlap[rows])
        again = np.where(other.reached, 0.0, other.miss + other.overlap)
        better = again < short
        taken = {}
        for each in fields(self):
            values = getattr(self, each.name).copy()
            values[rows[better]] = getattr(other, each.name)[better]
            taken[each.name] = values
        return Bent(**taken)


@dataclass(frozen=True, eq=False)
class _Question:
    """Who bends for what: P rows of a situation with a target (P, 3) [m] each, by a hand and grip;
    spare [m]: how much farther it is asked about."""

    situation: Situation
    who: Ints
    name: str
    grip: str
    targets: Floats
    spare: float

    def rows(self, keep: Ints) -> _Question:
        """Some of the rows."""
        return replace(self, who=self.who[keep], targets=self.targets[keep])

    @property
    def poses(self) -> Poses:
        """(P,) the postures that bending begins from."""
        poses = self.situation.taken.poses
        world = poses.world_from_reference[self.who]
        return Poses(poses.rotations[self.who], poses.reference, world, person=self.who)


def bent_reaches(
    situation: Situation,
    name: str,
    grip: str,
    controls: Sequence[Control],
    *,
    who: Ints,
    spare: float,
) -> Bent:
    """Let people who stand bend, and step within their area, for a control each.

    Parameters
    ----------
    situation
        People where they are, with the hands at rest.
    name, grip
        The hand, and how it takes the controls.
    controls
        Of each of P people the control.
    who
        (P,) the rows of these people in the situation.
    spare
        How much farther [m] it is asked whether they reach.
    """
    stand = situation.place.stand
    assert stand is not None
    area = np.array([stand.forward, stand.left]) - situation.taken.stepped[who][:, :, None]
    targets = np.array([control.at for control in controls])
    whole = _Question(situation, who, name, grip, targets, spare)
    found, stepped, came = _bent(whole, area)
    # who does not come to it from the whole area does not from a part of it
    rows = np.flatnonzero((found.overlap > 0.0) & came)
    for _ in range(TRIES):
        area[rows, 0, 1] = stepped[rows] - BACK
        rows = rows[area[rows, 0, 1] >= area[rows, 0, 0]]
        if not len(rows):
            break
        again, stepped[rows], came = _bent(whole.rows(rows), area[rows])
        found = found.better(rows, again)
        rows = rows[~again.reached & (again.overlap > 0.0) & came]
    return found


def _bent(question: _Question, area: Floats) -> tuple[Bent, Floats, Bools]:
    """How people reach who step within areas (P, 2, 2) [m], how far (P,) [m] they step forward, and
    whether (P,) their hands come to their targets where nothing is in the way."""
    situation = question.situation
    stand = situation.place.stand
    assert stand is not None
    body = situation.body
    asked = {question.name: (question.grip, question.targets)}
    posture = standing_posture(body, question.poses, asked, area=area, heading=stand.yaw)
    arm = limb(body, question.name, grip=question.grip, zone=ARMS_ALONE)
    found = reach(
        body,
        posture.poses,
        question.targets[:, None],
        limb=arm,
        environment=situation.environment,
        max_extension=question.spare,
        thorough=False,
    )
    depth, part = _in_parts(question, posture.poses, arm.moving)
    clear = depth <= 0.0
    reached = found.reached[:, 0] & clear & posture.stands
    limits = [found.reason(row, 0) for row in range(len(question.who))]
    names = situation.environment.parts
    why = [
        NO_REASON if there else limit if ok else Reason("part", names[k])
        for limit, ok, k, there in zip(limits, clear, part, reached, strict=True)
    ]
    bent = Bent(
        reached=reached,
        miss=found.miss[:, 0],
        overlap=np.where(reached, 0.0, np.maximum(found.overlap[:, 0], depth)),
        spare=found.extension[:, 0],
        discomfort=found.discomfort[:, 0],
        limit=np.array(why, dtype=object),
    )
    came = posture.miss[question.name] < LEAST
    return bent, posture.stepped[:, 0].copy(), came


def _in_parts(question: _Question, bent: Poses, arm: tuple[int, ...]) -> tuple[Floats, Ints]:
    """(P,) [m] how much deeper than allowed, and than before they bent, people are in a part with
    anything but the arm that reaches, and (P,) the part."""
    situation = question.situation
    environment = situation.environment
    shape = (len(question.who), len(environment.parts))
    deep = []
    for poses in (question.poses, bent):
        met = contacts(place(situation.body, poses), environment)
        some = ~np.isin(met.segment, arm)
        excess = np.zeros(shape)
        np.maximum.at(excess, (met.pose[some], met.part[some]), met.excess[some])
        deep.append(excess)
    more = np.where(deep[1] > deep[0] + DEEPER, deep[1], 0.0)
    return more.max(axis=1, initial=0.0), more.argmax(axis=1)
