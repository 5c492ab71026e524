"""Compute the contact forces of one moment by penalty laws.

Each segment that touches a part of the surroundings, and each pair of segments that touch each
other, is one contact with one force. The force follows from the greatest depth of any sphere, by
the force law of the pair. It acts at the mean of the touched points, weighted by their depths.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from workbench.contact.batches import touching
from workbench.contact.collide import allowed_depth, clearance, self_clearance, self_contacts
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.poses import Placed
from workbench.model.simulation import ForceLaw, Simulation, depth_offset, force_at, law_of

__all__ = ["ContactMemory", "SegmentForce", "contact_forces"]

_FULL_FRICTION_SPEED = 0.2
"""Sliding speed [m/s] from which on friction is full. Below, it is proportional to the speed, so
that it does not jump where a contact sticks."""


@dataclass(frozen=True)
class SegmentForce:
    """The force of one contact on a segment; its opposite acts on the other segment, if any."""

    segment: int
    other: int
    """The other segment, -1 for the surroundings."""
    point: Floats
    """(3,) where the force acts [m]."""
    normal: Floats
    """(3,) unit vector in which the segment is pushed."""
    force: float
    """Force [N] along the normal."""
    friction: float
    """Coefficient of Coulomb friction."""

    def with_friction(self, velocity: Floats) -> Floats:
        """Compute the whole force on the segment, friction included.

        Parameters
        ----------
        velocity
            (3,) [m/s] of the segment against the other one, at the point.

        Returns
        -------
        Floats
            (3,) [N], F (n - mu v_t / max(|v_t|, v_0)) with the tangential velocity v_t.
        """
        tangential = velocity - (velocity @ self.normal) * self.normal
        speed = max(float(np.linalg.norm(tangential)), _FULL_FRICTION_SPEED)
        return np.asarray(self.force * (self.normal - self.friction * tangential / speed))


@dataclass
class _OpenContact:
    """A contact since it began."""

    max_depth: float
    """Greatest depth [m] so far, for the unloading branch of the force law."""
    normal: Floats
    """(3,) normal with which it began: the side from which the segment came."""


_PairKey = tuple[int, int, int]
"""A pair in contact: segment, other segment or -1, part or -1."""


@dataclass
class ContactMemory:
    """What contacts remember from step to step."""

    simulation: Simulation
    part_offset: Floats
    """(N, K) depth [m] from which on a segment in a part is pushed back."""
    self_offset: Floats
    """(N, N) depth [m] from which on two segments push each other."""
    open: dict[_PairKey, _OpenContact] = field(default_factory=dict)
    """The contacts of the last step."""

    @classmethod
    def at_start(cls, simulation: Simulation, placed: Placed) -> ContactMemory:
        """Begin with the contacts of the posture at the start.

        They do not push, except those with parts that bear the occupant.
        """
        part_depth = -clearance(placed, simulation.environment)[0]
        start = np.where(np.isfinite(part_depth), part_depth, 0.0)
        allowed = allowed_depth(simulation.body, simulation.environment)
        self_depth = -self_clearance(placed).distance[0]
        flesh = np.maximum(
            simulation.body.allowance[0], np.where(np.isfinite(self_depth), self_depth, 0.0)
        )
        return cls(
            simulation, depth_offset(simulation.bears, allowed, start), np.maximum(flesh, flesh.T)
        )

    def offset(self, pair: _PairKey) -> float:
        """Return the depth [m] from which on a pair is pushed apart."""
        segment, other, part = pair
        return float(
            self.self_offset[segment, other] if other >= 0 else self.part_offset[segment, part]
        )


@dataclass(frozen=True)
class _TouchingSpheres:
    """The C spheres of one segment that touch one part or one other segment."""

    depth: Floats
    """(C,) [m]."""
    radius: Floats
    """(C,) [m]."""
    point: Floats
    """(C, 3) touched points [m]."""
    normal: Floats
    """(C, 3) unit vectors in which the spheres are pushed."""
    inside: Bools
    """(C,) True where the centre is inside a solid."""


@dataclass(frozen=True)
class _TouchingPair:
    """A pair in contact, its spheres, and its force law."""

    key: _PairKey
    spheres: _TouchingSpheres
    law: ForceLaw


def contact_forces(memory: ContactMemory, placed: Placed) -> list[SegmentForce]:
    """Compute the forces of all contacts of one pose.

    Parameters
    ----------
    memory
        Contacts of the step before. It is updated; a contact that has ended is forgotten, and
        begins anew if it comes back.
    placed
        The body in one pose.

    Returns
    -------
    list of ContactForce
        Contacts deeper than their offset, those with parts before those between segments.
    """
    before = memory.open
    memory.open = {}
    forces = []
    for pair in (*_part_pairs(memory, placed), *_segment_pairs(memory, placed)):
        contact = before.get(pair.key) or _OpenContact(
            0.0, _mean_normal(pair.spheres.normal, np.maximum(pair.spheres.depth, 1e-9))
        )
        memory.open[pair.key] = contact
        force = _pair_force(pair, contact, memory.offset(pair.key))
        if force is not None:
            forces.append(force)
    return forces


def _pair_force(pair: _TouchingPair, contact: _OpenContact, offset: float) -> SegmentForce | None:
    """The force of one pair, None where it is not deeper than its offset [m]."""
    spheres = _push_to_entry_side(pair.spheres, contact.normal)
    excess = spheres.depth - offset
    depth = float(excess.max())
    if depth <= 0:
        return None
    force = force_at(pair.law, depth, contact.max_depth)
    contact.max_depth = max(contact.max_depth, depth)
    weight = np.maximum(excess, 0.0)
    segment, other, _ = pair.key
    return SegmentForce(
        segment,
        other,
        weight @ spheres.point / weight.sum(),
        _mean_normal(spheres.normal, weight),
        force,
        pair.law.friction,
    )


def _push_to_entry_side(spheres: _TouchingSpheres, entry_normal: Floats) -> _TouchingSpheres:
    """Push spheres back to the side from which the segment came, even if their centre is past it.

    The nearest way out of a thin part would be the far side. For a centre that has passed the
    surface by t = radius - depth, the depth toward the near side is radius + t.
    """
    passed = spheres.normal @ entry_normal < 0
    if not passed.any():
        return spheres
    return _TouchingSpheres(
        np.where(passed & ~spheres.inside, 2 * spheres.radius - spheres.depth, spheres.depth),
        spheres.radius,
        spheres.point,
        np.where(passed[:, None], -spheres.normal, spheres.normal),
        spheres.inside,
    )


def _part_pairs(memory: ContactMemory, placed: Placed) -> Iterator[_TouchingPair]:
    """Pairs of a segment and a part of the surroundings, in the order of their numbers."""
    body = placed.body
    parts = len(memory.simulation.environment.parts)
    rows, numbers = touching(placed, memory.simulation.environment, 0.0)
    # forces are sums: their last digits must not depend on the order in which polygons were found
    order = np.lexsort(rows.T[::-1])
    rows = rows[order]
    numbers = numbers[order]
    sphere = rows[:, 1]
    spheres = _TouchingSpheres(
        depth=-numbers[:, 0],
        radius=body.radius[0][sphere],
        point=numbers[:, 1:4],
        normal=_outward_normals(memory, placed, rows, numbers),
        inside=numbers[:, 4] > 0,
    )
    code = body.sphere_segment[sphere] * parts + rows[:, 2]
    for value in np.unique(code).tolist():
        segment, part = divmod(value, parts)
        law = law_of(memory.simulation, segment, part)
        yield _TouchingPair((segment, -1, part), _select(spheres, code == value), law)


def _outward_normals(memory: ContactMemory, placed: Placed, rows: Ints, numbers: Floats) -> Floats:
    """(C, 3) from the touched point to the centre, reversed inside solids.

    A centre on the surface takes the normal of the touched polygon.
    """
    inside = numbers[:, 4] > 0
    gap = placed.centres[0, rows[:, 1]] - numbers[:, 1:4]
    gap = gap * np.where(inside, -1.0, 1.0)[:, None]
    length = np.linalg.norm(gap, axis=1)
    polygon_normal = memory.simulation.environment.normal[rows[:, 3]]
    return np.where(
        (length > 1e-9)[:, None], gap / np.maximum(length, 1e-300)[:, None], polygon_normal
    )


def _select(spheres: _TouchingSpheres, chosen: Bools) -> _TouchingSpheres:
    return _TouchingSpheres(
        spheres.depth[chosen],
        spheres.radius[chosen],
        spheres.point[chosen],
        spheres.normal[chosen],
        spheres.inside[chosen],
    )


def _segment_pairs(memory: ContactMemory, placed: Placed) -> Iterator[_TouchingPair]:
    """Pairs of segments that press on each other, in the order of their numbers."""
    body = placed.body
    contacts = self_contacts(placed)
    code = contacts.segment * len(body.segments) + contacts.other_segment
    for value in np.unique(code).tolist():
        chosen = code == value
        segment, other = divmod(value, len(body.segments))
        depth = -contacts.distance[chosen]
        if depth.max() <= memory.self_offset[segment, other]:
            continue
        spheres = _TouchingSpheres(
            depth,
            body.radius[0][contacts.sphere[chosen]],
            contacts.point[chosen],
            contacts.normal[chosen],
            inside=np.zeros(len(depth), dtype=np.bool_),
        )
        yield _TouchingPair((segment, other, -1), spheres, memory.simulation.flesh)


def _mean_normal(normal: Floats, weight: Floats) -> Floats:
    """(3,) weighted mean of unit vectors (C, 3), normalized; the heaviest where they cancel."""
    mean = weight @ normal
    length = float(np.linalg.norm(mean))
    cancelled = length <= 1e-6 * weight.sum()
    return np.asarray(normal[np.argmax(weight)] if cancelled else mean / length)
