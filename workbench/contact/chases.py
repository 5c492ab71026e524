"""The three kinds of continuous contact: a moving body against an environment, another body, or
itself."""

from __future__ import annotations

import numpy as np

from workbench.contact.advance import Chase
from workbench.contact.collide import allowed_depth
from workbench.contact.fields import packed_parts
from workbench.contact.moving import Mover
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment

__all__ = ["Rule", "body_chase", "environment_chase", "self_chase"]

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
