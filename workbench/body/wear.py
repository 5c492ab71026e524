"""Dress bodies: helmets, boots, gloves and vests are copies of the body's own spheres.

The copies are shifted and thicker. Where a limb is missing its own spheres and mass are gone; its
joints stay, so that a body has the joints that postures name.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import DIRECTIONS, Body
from workbench.model.person import Encumbrance, Layer
from workbench.model.skinning import with_derived_fields

__all__ = ["wear"]


def wear(body: Body, items: Iterable[Encumbrance], *, like: Body | None = None) -> Body:
    """Return a body with what it wears.

    The body stands on its soles, and its measures are taken over what it wears. A copy has the name of
    its sphere and of the thing: "heel (boots)". Allowances for soft flesh grow by what standing and
    sitting overlap more. The dressed body belongs to no family.

    Parameters
    ----------
    body
        B bodies of one topology.
    items
        What they wear, from the inside to the outside.
    like
        A body of the same topology; its first row decides which spheres are covered. The body itself if
        None. Bodies dressed with the same choice have one topology.

    Raises
    ------
    InputError
        If a layer covers no sphere.
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
    body = with_derived_fields(body)
    after = [Manikin(one) for one in body]
    more = [np.maximum(one.overlaps() - was, 0.0) for one, was in zip(after, before, strict=True)]
    in_parent = body.joint_in_parent.copy()
    lowest = np.array([one.lowest() for one in after])
    in_parent[:, body.parent[1:] == 0, 2] -= lowest[:, None]
    allowance = body.allowance + np.where(body.adjacent, 0.0, more)
    return replace(body, joint_in_parent=in_parent, allowance=allowance)


@dataclass(frozen=True, eq=False)
class _Copies:
    """The C spheres that are copied."""

    sphere: Ints
    """(C,) index of the original."""
    shift: Floats
    """(C, 3) displacement [m]."""
    thickness: Floats
    """(C,) by how much the radius grows [m]."""


def _copies(body: Body, item: Encumbrance) -> _Copies:
    """The copies that make one thing. Layers that make the same copy make it once."""
    rows = {
        (int(s), layer.shift, layer.thickness): None
        for layer in item.layers
        for s in _covered(body, item, layer)
    }
    return _Copies(
        np.array([sphere for sphere, _, _ in rows], dtype=np.int64),
        np.array([shift for _, shift, _ in rows], dtype=np.float64).reshape(-1, 3),
        np.array([thickness for _, _, thickness in rows], dtype=np.float64),
    )


def _dressed(body: Body, item: Encumbrance, copies: _Copies) -> Body:
    """The rows of a body with one thing more; twist lines and enclosing spheres are still missing."""
    segment = body.sphere_segment
    source = np.concatenate([np.arange(len(segment)), copies.sphere])
    order = np.argsort(segment[source], kind="stable")
    gone = np.isin(segment, [body.segment(name) for name in item.without])
    order = order[~np.append(gone, np.zeros(len(copies.sphere), dtype=np.bool_))[order]]
    source = source[order]
    names = [*body.sphere_names, *_copy_names(body, item, copies)]
    topology = replace(
        body.topology,
        start=np.searchsorted(segment[source], np.arange(len(body.segments) + 1)),
        sphere_names=tuple(names[i] for i in order),
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
        mass=_dressed_mass(body, item),
        basis_at=np.zeros((len(body), 0)),
    )


def _dressed_mass(body: Body, item: Encumbrance) -> Floats:
    """(B, N) [kg] masses of the segments with the thing."""
    mass = body.mass.copy()
    mass[:, [body.segment(name) for name in item.without]] = 0.0
    for name, extra in item.mass:
        mass[:, body.segment(name)] += extra
    return mass


def _copy_names(body: Body, item: Encumbrance, copies: _Copies) -> list[str]:
    """Names of the copies (C,)."""
    names = tuple(
        f"{body.sphere_names[s]} ({item.name})" if body.sphere_names[s] else f"({item.name})"
        for s in copies.sphere
    )
    return _numbered(names, body.sphere_segment[copies.sphere].tolist())


def _numbered(names: tuple[str, ...], segments: list[int]) -> list[str]:
    """Names that differ within a segment: those that occur again get a number."""
    taken: dict[tuple[int, str], int] = {}
    numbered = []
    for key in zip(segments, names, strict=True):
        taken[key] = taken.get(key, 0) + 1
        numbered.append(key[1] if taken[key] == 1 else f"{key[1][:-1]} {taken[key]})")
    return [name.strip() for name in numbered]


def _covered(body: Body, item: Encumbrance, layer: Layer) -> Ints:
    """The spheres of a body that a layer covers. What is worn already is not covered again."""
    found: list[Ints] = []
    for name in layer.segments:
        segment = body.segment(name)
        rows = np.arange(body.start[segment], body.start[segment + 1])
        rows = rows[[not body.sphere_names[s].endswith(")") for s in rows]]
        if layer.subparts:
            rows = rows[[body.sphere_names[s] in layer.subparts for s in rows]]
        for direction, subpart, least in layer.beyond:
            reference = _named_sphere(body, item, segment, subpart)
            along = body.directions[segment, DIRECTIONS.index(direction)]
            distance = (body.centre[0, rows] - body.centre[0, reference]) @ along
            rows = rows[distance >= least]
        found.append(rows)
    rows = np.concatenate(found)
    if not len(rows):
        raise InputError(
            f"{item.name}: body {body.name} has no sphere where it is worn, on {', '.join(layer.segments)}"
        )
    return rows


def _named_sphere(body: Body, item: Encumbrance, segment: int, subpart: str) -> int:
    """The first sphere of a segment with a name."""
    spheres = body.spheres(segment)
    names = body.sphere_names[spheres]
    if subpart not in names:
        known = [name for name in names if name]
        raise InputError(
            f"{item.name}: body {body.name}: segment {body.segments[segment]} has no sphere named {subpart!r}; "
            f"{one_of(subpart, known)}"
        )
    return int(spheres.start) + names.index(subpart)
