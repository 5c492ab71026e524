"""Dressed bodies: helmets, boots, gloves and vests as copies of the body's own spheres, grown and
shifted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.encumbrance import Encumbrance, Layer
from workbench.model.settled import settled
from workbench.model.vocabulary import DIRECTIONS
from workbench.shape.scaling.manikin import Manikin

__all__ = ["wear"]


def wear(body: Body, items: Iterable[Encumbrance]) -> Body:
    """The body with what it wears: it stands on its soles, and its measures are taken over what it
    wears.

    A copy is called after its sphere and what it is of ("heel (boots)"). Allowances for soft flesh
    grow by what standing and sitting overlap more. The dressed body belongs to no family.
    InputError where a layer finds no sphere.
    """
    chosen = list(items)
    if not chosen:
        return body
    before = Manikin(body).overlaps()
    for item in chosen:
        body = _dressed(body, item)
    body = settled(body)
    manikin = Manikin(body)
    in_parent = body.joint_in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= manikin.lowest()
    more = np.where(body.adjacent, 0.0, np.maximum(manikin.overlaps() - before, 0.0))
    return replace(body, joint_in_parent=in_parent, allowance=body.allowance + more)


def _dressed(body: Body, item: Encumbrance) -> Body:
    """The body with one thing more; its twist lines and enclosing spheres are still to be
    settled."""
    rows: list[int] = []
    centre: list[Floats] = []
    radius: list[float] = []
    for layer in item.layers:
        for s in _covered(body, item, layer):
            rows.append(int(s))
            centre.append(body.centre[s] + np.array(layer.shift))
            radius.append(float(body.radius[s]) + layer.thickness)
    kept = _once(rows, centre, radius)
    rows, centre, radius = ([each[i] for i in kept] for each in (rows, centre, radius))  # type: ignore[assignment]
    names = tuple(
        f"{body.sphere_names[s]} ({item.name})" if body.sphere_names[s] else f"({item.name})"
        for s in rows
    )
    source = np.concatenate([np.arange(len(body.radius)), np.array(rows, dtype=np.int64)])
    order = np.argsort(body.sphere_segment[source], kind="stable")
    source = source[order]
    label = [*body.sphere_names, *_numbered(names, body.sphere_segment[rows].tolist())]
    mass = body.mass.copy()
    for segment, extra in item.mass:
        mass[body.segment(segment)] += extra
    return replace(
        body,
        centre=np.concatenate([body.centre, np.array(centre).reshape(-1, 3)])[order],
        radius=np.concatenate([body.radius, radius])[order],
        start=np.searchsorted(body.sphere_segment[source], np.arange(len(body.segments) + 1)),
        sphere_names=tuple(label[i] for i in order),
        sphere_direction=body.sphere_direction[source],
        twist_share=body.twist_share[source],
        blend_joint=body.blend_joint[source],
        blend_share=body.blend_share[source],
        mass=mass,
        basis=None,
        basis_at=np.zeros(0),
    )


def _once(rows: list[int], centre: list[Floats], radius: list[float]) -> list[int]:
    """The copies without those that two layers make alike."""
    first: dict[tuple[float, ...], int] = {}
    for i, (row, at, size) in enumerate(zip(rows, centre, radius, strict=True)):
        first.setdefault((row, *np.round(at, 9).tolist(), round(size, 9)), i)
    return list(first.values())


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
            rows = rows[(body.centre[rows] - body.centre[named[0]]) @ along >= by]
        found.append(rows)
    rows = np.concatenate(found)
    if not len(rows):
        raise InputError(
            f"{item.name}: body {body.name} has no sphere where it is worn, on {', '.join(layer.segments)}"
        )
    return rows
