"""Dressed bodies: helmets, boots, gloves and vests as copies of the body's own spheres, grown and
shifted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body, stack_bodies
from workbench.model.encumbrance import Encumbrance, Layer
from workbench.model.settled import settled
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["wear"]


def wear(body: Body, items: Iterable[Encumbrance], *, like: Body | None = None) -> Body:
    """The body with what it wears: it stands on its soles, and its measures are taken over what it
    wears.

    A copy is called after its sphere and what it is of ("heel (boots)"). Allowances for soft flesh
    grow by what standing and sitting overlap more. The dressed body belongs to no family. like: a
    body of the same topology by whose first row the spheres are chosen that something covers, the
    body's own where None; rows chosen alike can be rows of one body. InputError where a layer finds
    no sphere.
    """
    chosen = list(items)
    if not chosen:
        return body
    shown = body[0] if like is None else like[0]
    before = [Manikin(one).overlaps() for one in body]
    for item in chosen:
        copies = _copies(shown, item)
        body = _dressed(body, item, copies)
        shown = _dressed(shown, item, copies)
    return stack_bodies([_standing(one, was) for one, was in zip(body, before, strict=True)])


def _standing(body: Body, before: Floats) -> Body:
    """One row, dressed, with its twist lines, enclosing spheres and soft flesh; before (N, N) [m]:
    what overlapped when it was bare."""
    body = settled(body)
    manikin = Manikin(body)
    in_parent = body.joint_in_parent.copy()
    in_parent[0, body.parent[1:] == 0, 2] -= manikin.lowest()
    more = np.where(body.adjacent, 0.0, np.maximum(manikin.overlaps() - before, 0.0))
    return replace(body, joint_in_parent=in_parent, allowance=body.allowance + more)


@dataclass(frozen=True, eq=False)
class _Copies:
    """The spheres (C,) that are copied, by how much each copy is shifted (C, 3) and thicker (C,)
    [m]."""

    sphere: Ints
    shift: Floats
    thickness: Floats


def _copies(body: Body, item: Encumbrance) -> _Copies:
    """What is copied to be one thing; layers that make the same copy make it once."""
    rows = {
        (int(s), layer.shift, layer.thickness): None
        for layer in item.layers
        for s in _covered(body, item, layer)
    }
    sphere, shift, thickness = zip(*rows, strict=True)
    return _Copies(np.array(sphere), np.array(shift, dtype=np.float64), np.array(thickness))


def _dressed(body: Body, item: Encumbrance, copies: _Copies) -> Body:
    """The rows of a body with one thing more; their twist lines and enclosing spheres are still to
    be settled."""
    names = tuple(
        f"{body.sphere_names[s]} ({item.name})" if body.sphere_names[s] else f"({item.name})"
        for s in copies.sphere
    )
    segment = body.sphere_segment
    source = np.concatenate([np.arange(len(segment)), copies.sphere])
    order = np.argsort(segment[source], kind="stable")
    source = source[order]
    label = [*body.sphere_names, *_numbered(names, segment[copies.sphere].tolist())]
    mass = body.mass.copy()
    for name, extra in item.mass:
        mass[:, body.segment(name)] += extra
    topology = replace(
        body.topology,
        start=np.searchsorted(segment[source], np.arange(len(body.segments) + 1)),
        sphere_names=tuple(label[i] for i in order),
        sphere_direction=body.sphere_direction[source],
        blend_joint=body.blend_joint[source],
        basis=None,
    )
    centre = body.centre[:, copies.sphere] + copies.shift
    radius = body.radius[:, copies.sphere] + copies.thickness
    return replace(
        body,
        topology=topology,
        centre=np.concatenate([body.centre, centre], axis=1)[:, order],
        radius=np.concatenate([body.radius, radius], axis=1)[:, order],
        twist_share=body.twist_share[:, source],
        blend_share=body.blend_share[:, source],
        mass=mass,
        basis_at=np.zeros((len(body), 0)),
    )


def _numbered(names: tuple[str, ...], segments: list[int]) -> list[str]:
    """Nameless copies are numbered, and a sphere that two layers copy: names differ within a
    segment."""
    taken: dict[tuple[int, str], int] = {}
    told = []
    for key in zip(segments, names, strict=True):
        taken[key] = taken.get(key, 0) + 1
        told.append(key[1] if taken[key] == 1 else f"{key[1][:-1]} {taken[key]})")
    return [name.strip() for name in told]


def _covered(body: Body, item: Encumbrance, layer: Layer) -> Ints:
    """The spheres of a body that a layer lies on."""
    found: list[Ints] = []
    for name in layer.segments:
        n = body.segment(name)
        rows = np.arange(body.start[n], body.start[n + 1])
        # what is worn already is not covered once more
        rows = rows[[not body.sphere_names[s].endswith(")") for s in rows]]
        if layer.subparts:
            rows = rows[[body.sphere_names[s] in layer.subparts for s in rows]]
        for direction, subpart, by in layer.beyond:
            named = [
                s
                for s in range(body.start[n], body.start[n + 1])
                if body.sphere_names[s] == subpart
            ]
            if not named:
                have = [label for label in body.sphere_names[body.spheres(n)] if label]
                raise InputError(
                    f"{item.name}: body {body.name}: segment {name} has no sphere named {subpart!r}; "
                    f"{one_of(subpart, have)}"
                )
            along = body.directions[n, DIRECTIONS.index(direction)]
            rows = rows[(body.centre[0, rows] - body.centre[0, named[0]]) @ along >= by]
        found.append(rows)
    rows = np.concatenate(found)
    if not len(rows):
        raise InputError(
            f"{item.name}: body {body.name} has no sphere where it is worn, on {', '.join(layer.segments)}"
        )
    return rows
