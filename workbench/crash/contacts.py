"""Contact forces of one moment: a force for each segment in a part, and for each pair of segments,
by their laws."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from workbench.contact.batches import touching
from workbench.contact.collide import allowed_depth, clearance, self_clearance, self_contacts
from workbench.model.arrays import Bools, Floats
from workbench.model.force import ForceLaw, force_at
from workbench.model.poses import Placed
from workbench.model.simulation import Simulation, depth_offset, law_of

__all__ = ["Push", "Touch", "contact_pushes"]

_CREEP = 0.2
"""[m/s] Friction has its whole size from this speed on and goes linearly through zero below it."""


@dataclass(frozen=True)
class Push:
    """A contact: segment, and the other segment (-1: the world); at `point` (3,) [m]; normal (3,):
    the way the segment is pushed; force [N] along it; friction: coefficient."""

    segment: int
    other: int
    point: Floats
    normal: Floats
    force: float
    friction: float

    def against(self, speed: Floats) -> Floats:
        """(3,) [N] on the segment, which slides at `speed` (3,) [m/s] against the other."""
        along = speed - (speed @ self.normal) * self.normal
        size = float(np.linalg.norm(along))
        return np.asarray(self.force * (self.normal - self.friction * along / max(size, _CREEP)))


@dataclass
class _Spell:
    """A contact since it began: the greatest depth [m], and the normal (3,) with which it began."""

    deepest: float
    normal: Floats


@dataclass
class Touch:
    """What contacts remember from step to step. offset (N, K), own (N, N) [m]: depths from which on
    they push."""

    simulation: Simulation
    offset: Floats
    own: Floats
    spells: dict[tuple[int, int, int], _Spell] = field(default_factory=dict)

    @classmethod
    def at_start(cls, simulation: Simulation, placed: Placed) -> Touch:
        """Contacts of the posture at the start, which do not push (but for what bears the
        sitter)."""
        deep = -clearance(placed, simulation.environment)[0]
        start = np.where(np.isfinite(deep), deep, 0.0)
        allowed = allowed_depth(simulation.body, simulation.environment)
        self_deep = -self_clearance(placed).distance[0]
        flesh = np.maximum(
            simulation.body.allowance[0], np.where(np.isfinite(self_deep), self_deep, 0.0)
        )
        return cls(
            simulation, depth_offset(simulation.bears, allowed, start), np.maximum(flesh, flesh.T)
        )


def contact_pushes(touch: Touch, placed: Placed) -> list[Push]:
    """All contacts of the one pose placed; what was touched and is no longer is forgotten."""
    before = touch.spells
    touch.spells = {}
    pushes = []
    for key, rows, law in (*_with_parts(touch, placed), *_with_itself(touch, placed)):
        spell = before.get(key) or _Spell(0.0, _mean(rows.normal, np.maximum(rows.depth, 1e-9)))
        touch.spells[key] = spell
        rows = _from_the_side_entered(rows, spell.normal)
        offset = touch.own[key[0], key[1]] if key[1] >= 0 else touch.offset[key[0], key[2]]
        deep = rows.depth - offset
        depth = float(deep.max())
        if depth <= 0:
            continue
        share = np.maximum(deep, 0.0)
        force = force_at(law, depth, spell.deepest)
        spell.deepest = max(spell.deepest, depth)
        pushes.append(
            Push(
                key[0],
                key[1],
                share @ rows.point / share.sum(),
                _mean(rows.normal, share),
                force,
                law.friction,
            )
        )
    return pushes


Key = tuple[int, int, int]
"""Segment, other segment or -1, part or -1."""


@dataclass(frozen=True)
class _Rows:
    """Spheres of one segment in one part or other segment: depth (C,), radius (C,) [m], point,
    normal (C, 3); within (C,): the centre is inside a solid."""

    depth: Floats
    radius: Floats
    point: Floats
    normal: Floats
    within: Bools


def _from_the_side_entered(rows: _Rows, entered: Floats) -> _Rows:
    """Spheres whose centre has gone through a thin part are pushed back, not on."""
    through = rows.normal @ entered < 0
    if not through.any():
        return rows
    deeper = np.where(through & ~rows.within, 2 * rows.radius - rows.depth, rows.depth)
    return _Rows(
        deeper,
        rows.radius,
        rows.point,
        np.where(through[:, None], -rows.normal, rows.normal),
        rows.within,
    )


def _with_parts(touch: Touch, placed: Placed) -> Iterator[tuple[Key, _Rows, ForceLaw]]:
    body = placed.body
    environment = touch.simulation.environment
    found, numbers = touching(placed, environment, 0.0, grid=True)
    if not len(found):
        return
    sphere = found[:, 1]
    part = found[:, 2]
    inside = numbers[:, 4] > 0
    apart = (placed.centres[0, sphere] - numbers[:, 1:4]) * np.where(inside, -1.0, 1.0)[:, None]
    length = np.linalg.norm(apart, axis=1)
    normal = np.where(
        (length > 1e-9)[:, None],
        apart / np.maximum(length, 1e-300)[:, None],
        environment.normal[found[:, 3]],
    )
    segment = body.sphere_segment[sphere]
    code = segment * len(environment.parts) + part
    for value in np.unique(code).tolist():
        at = code == value
        n, k = divmod(value, len(environment.parts))
        rows = _Rows(
            -numbers[at, 0], body.radius[0][sphere[at]], numbers[at, 1:4], normal[at], inside[at]
        )
        yield (n, -1, k), rows, law_of(touch.simulation, n, k)


def _with_itself(touch: Touch, placed: Placed) -> Iterator[tuple[Key, _Rows, ForceLaw]]:
    body = placed.body
    found = self_contacts(placed)
    one = found.segment
    other = found.other_segment
    code = one * len(body.segments) + other
    for value in np.unique(code).tolist():
        at = code == value
        n, m = divmod(value, len(body.segments))
        depth = -found.distance[at]
        if depth.max() <= touch.own[n, m]:
            continue
        none = np.zeros(len(depth), dtype=np.bool_)
        rows = _Rows(
            depth, body.radius[0][found.sphere[at]], found.point[at], found.normal[at], none
        )
        yield (n, m, -1), rows, touch.simulation.flesh


def _mean(normal: Floats, share: Floats) -> Floats:
    """The weighted mean of unit vectors, as one; the heaviest where they cancel."""
    mean = share @ normal
    length = float(np.linalg.norm(mean))
    return np.asarray(mean / length if length > 1e-6 * share.sum() else normal[np.argmax(share)])
