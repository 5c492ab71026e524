"""The own body as an obstacle of an arm: trunk, head and legs, which stand still while it reaches.

What counts is deeper than the own body allows, see `allowed_in_oneself`. The other arm gives way, but
for one whose hand holds something.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import allowed_in_oneself
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.contacts import Clearance
from workbench.model.kept import kept_by_row
from workbench.model.poses import Placed, Poses
from workbench.posture.reaching.limbs import Limb

__all__ = ["ARM", "OwnBody", "in_own_legs", "own_arms", "own_body", "own_names"]

ARM = ("UA", "LA", "HN")
LEG = ("UL", "LL", "F")
"""The segments of an arm and of a leg, without their side."""


@dataclass(frozen=True, eq=False)
class OwnBody:
    """The segments of people that stand still while an arm of theirs reaches.

    Parameters
    ----------
    placed
        (Q,) the people.
    allowed
        (Q, N, G) [m] how deep each segment of the arm may be in each of the body that has spheres;
        infinite where it does not matter.
    """

    placed: Placed
    allowed: Floats


def own_names(body: Body) -> tuple[str, ...]:
    """What the segments that have spheres are called: "own left upper leg"."""
    return tuple(f"own {body.segment_names[n]}" for n in np.flatnonzero(np.diff(body.start)))


def own_body(
    body: Body, poses: Poses, arm: Limb, *, other_arm: bool, flesh_alone: bool = False
) -> OwnBody:
    """The own body of people who reach with an arm that moves nothing of the trunk.

    Parameters
    ----------
    poses
        (Q,) from which they reach.
    other_arm
        Whether the other arm stays where it is.
    flesh_alone
        Whether no more is allowed than soft flesh gives, wherever the true surfaces are.
    """
    placed = place(body, poses)
    allowed = _allowed(body, arm.name[0].upper(), arm.moving, other_arm, flesh_alone)
    return OwnBody(placed, allowed[placed.person])


def own_arms(body: Body, poses: Poses) -> OwnBody:
    """The arms of people in Q poses, which stand still while a leg gives way to them; no more is
    allowed than soft flesh gives."""
    allowed = allowed_in_oneself(body, flesh_alone=True)
    allowed[:, :, [name[1:] not in ARM for name in body.segments]] = np.inf
    placed = place(body, poses)
    some = np.diff(body.start) > 0
    return OwnBody(placed, np.ascontiguousarray(allowed[placed.person][:, :, some]))


def in_own_legs(body: Body, own: Clearance) -> Floats:
    """How much deeper (B,) [m] arms are in legs of the same body than flesh gives, below 0 where they
    are not. own: as of `self_clearance`, of B poses of B rows."""
    arm, leg = (np.isin([name[1:] for name in body.segments], limb) for limb in (ARM, LEG))
    pairs = np.outer(arm, leg) | np.outer(leg, arm)
    deep: Floats = np.where(pairs, -own.distance - body.allowance, -np.inf).max(axis=(1, 2))
    return deep


def _some(allowed: Floats, rows: Ints) -> Floats:
    return allowed[rows]


@kept_by_row(_some)
def _allowed(
    body: Body, side: str, moving: tuple[int, ...], other_arm: bool, flesh_alone: bool
) -> Floats:
    """(B, N, G) of the arm of a side, as of `OwnBody`."""
    mine = [side + name for name in ARM]
    other = [("L" if side == "R" else "R") + name for name in ARM]
    allowed = allowed_in_oneself(body, flesh_alone=flesh_alone)
    allowed[:, ~np.isin(body.segments, mine)] = np.inf
    allowed[:, :, list(moving)] = np.inf
    gone = np.isin(body.segments, other[-1:] if other_arm else other)
    allowed[:, :, gone] = np.inf  # one hand may lie on the other
    return np.ascontiguousarray(allowed[:, :, np.diff(body.start) > 0])
