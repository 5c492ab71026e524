"""The three kinds of continuous contact: a moving body against an environment, another body, or
itself; and which of its spheres may touch what, the broad phase."""

from __future__ import annotations

import numpy as np

from workbench.contact.advance import SLACK, Chase
from workbench.contact.collide import allowed_depth
from workbench.contact.fields import packed_parts
from workbench.contact.kernels.advance import near_pairs, near_parts
from workbench.contact.moving import Mover, jumps, ways
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment

__all__ = ["Rule", "body_chase", "candidates", "environment_chase", "self_chase"]

Swept = tuple[Floats, Floats, Floats]
Rule = tuple[Chase, Ints, Floats]
"""Who is after what; the parts (K,) that take part as 1, or the pairs of segments (Q, 2); depth
that is no contact."""


def environment_chase(mover: Mover, environment: Environment, tolerance: float) -> Rule:
    """A body against the parts of an environment: hidden ones take no part, the others as deep as
    they allow."""
    checked = (~environment.hidden).astype(np.int64)
    allowed = allowed_depth(mover.body, environment) + tolerance
    return Chase(mover, packed_parts(environment)), checked, allowed


def self_chase(mover: Mover, tolerance: float) -> Rule:
    """The non-adjacent segments of one body, as deep in each other as its soft flesh allows."""
    body = mover.body
    shown = mover.placed.window
    pairs = np.argwhere(np.triu(~body.adjacent) & np.outer(shown, shown))
    return Chase(mover, mover), pairs, body.allowance[0] + tolerance


def body_chase(one: Mover, other: Mover, tolerance: float) -> Rule:
    """All segments of one body against all of another."""
    pairs = np.argwhere(np.outer(one.placed.window, other.placed.window))
    return (
        Chase(one, other),
        pairs,
        np.full((len(one.body.segments), len(other.body.segments)), tolerance),
    )


def candidates(
    chase: Chase, checked: Ints, allowed: Floats, begin: int, end: int
) -> tuple[Ints, Floats]:
    """Who (M, 3) may touch in the pose pairs begin..end, and the level (M,) [m] of each.

    checked: 1 for the parts (K,) that take part, or the pairs of segments (Q, 2). allowed (N, K) or
    (N, N') [m]: depth that is no contact.
    """
    one = _swept(chase.mover, begin, end)
    segment = chase.mover.levers.segment
    radius = chase.mover.body.radius[0]
    if isinstance(chase.against, Mover):
        other = chase.against
        who = near_pairs(one, _swept(other, begin, end), checked, allowed, SLACK)
        level = radius[who[:, 1]] + other.body.radius[0][who[:, 2]]
        level = level - allowed[segment[who[:, 1]], other.levers.segment[who[:, 2]]]
        keep = level > 0
    else:
        parts = chase.against
        who = near_parts(*one, parts, allowed, checked, SLACK)
        level = radius[who[:, 1]] - allowed[segment[who[:, 1]], who[:, 2]]
        # a surface cannot be deeper than the radius
        keep = (level > 0) | (parts.faces.solid[who[:, 2]] > 0)
    who[:, 0] += begin
    return who[keep], level[keep]


def _swept(mover: Mover, begin: int, end: int) -> tuple[Swept, Swept, Ints]:
    """Enclosing spheres and spheres in pairs begin..end: where they begin and end, and how far
    their surfaces may be from the chord; and the spheres of each segment."""
    body = mover.body
    world = mover.placed.world_from_segment
    first = mover.first[begin:end]
    second = mover.second[begin:end]
    bound = mover.turns.bound[begin:end]
    around = []
    for frames in (first, second):
        turned = np.einsum("pnij,nj->pni", world[frames][..., :3], body.enclosing_centre[0])
        around.append(np.ascontiguousarray(turned + world[frames][..., 3]))
    entry = np.zeros((len(body.segments), 3))
    entry[mover.chain.to] = mover.chain.at_to
    arm = np.linalg.norm(body.enclosing_centre[0] - entry, axis=1)
    size = body.enclosing_radius[0] + 0.125 * (
        bound[..., 1] + (bound[..., 2] ** 2 + bound[..., 3]) * arm
    )
    size[:, ~mover.placed.window] = np.nan
    pairs = end - begin
    spheres = len(body.sphere_names)
    pair = np.repeat(np.arange(begin, end), spheres)
    sphere = np.tile(np.arange(spheres), pairs)
    way = ways(mover, pair, sphere, np.zeros(len(pair)), np.ones(len(pair)))
    way[jumps(mover, pair, sphere) <= 1.0] = np.inf
    reach = way.reshape(pairs, spheres) + body.radius[0]
    moved = mover.placed.centres[first], mover.placed.centres[second]
    return (around[0], around[1], size * (1 + 1e-12) + 1e-9), (*moved, reach), body.start
