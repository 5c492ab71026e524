"""Build an environment from parts: defects counted, windings repaired, coplanar faces merged."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from workbench.files.meshes.mesh_validation import Defect, MeshDefects, validate_part
from workbench.files.meshes.parts import RawPart, weld
from workbench.files.meshes.polygons import Polygons, merge_coplanar
from workbench.files.meshes.winding import winding_sense
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import HARMLESS, Environment, Quality

__all__ = ["build_environment"]

_SOUP = 100
_LOOSE = 2.0
"""A part of so many triangles with more open edges each than this is a soup; loose ones have 3."""
_MAX_NAMES = 3
"""Number of parts that a warning about many parts names."""

_Checked = tuple[RawPart, MeshDefects]


def build_environment(
    name: str, parts: Iterable[RawPart], *, solid: Iterable[bool | str], notes: Iterable[str] = ()
) -> tuple[Environment, list[tuple[int, str]]]:
    """Build an environment: duplicates removed, shells outward, coplanar faces merged.

    Parameters
    ----------
    name
        Name of the environment.
    parts
        Parts in the world's frame [m].
    solid
        For each part "auto" (solid if it is closed), True or False.
    notes
        Warnings to begin with.

    Returns
    -------
    tuple[Environment, list[tuple[int, str]]]
        The environment, and for each part that cannot be solid its index and the reason.
    """
    declared = list(solid)
    checked = [
        validate_part(part, solid=bool(how)) for part, how in zip(parts, declared, strict=True)
    ]
    names = tuple(part.name for part, _ in checked)
    vertices, faces, first = _stacked([part for part, _ in checked])
    merged = merge_coplanar(vertices, np.concatenate([np.zeros((0, 3), dtype=np.int64), *faces]))
    part_start = _part_starts(merged, first)
    solids = _solids(checked, declared)
    none = np.zeros(len(checked), dtype=np.bool_)
    shared = _shared_face_warnings(names, vertices, faces, solids)
    environment = Environment(
        name=name,
        description="",
        parts=names,
        part_start=part_start,
        vertices=vertices,
        edges=merged.edges,
        edge_start=merged.edge_start,
        normal=merged.normal,
        offset=merged.offset,
        circle_centre=merged.circle_centre,
        circle_radius=merged.circle_radius,
        triangles=merged.triangles,
        triangle_start=merged.triangle_start,
        solid=solids,
        hidden=none,
        see_through=none,
        quality=_qualities(checked, np.diff(part_start), declared),
        warnings=(*notes, *_soup_warnings(checked), *_defect_warnings(checked), *shared),
    )
    return environment, [
        (k, _open_reason(part, defects))
        for k, (part, defects) in enumerate(checked)
        if declared[k] is True and not defects.closed
    ]


def _stacked(parts: Sequence[RawPart]) -> tuple[Floats, list[Ints], Ints]:
    """Return the vertices (V, 3) of K parts one after the other, the faces of each by these, and
    the first vertex (K + 1,) of each."""
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertices = np.concatenate([np.zeros((0, 3)), *(part.vertices for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, first, strict=False)]
    return vertices, faces, first


def _part_starts(merged: Polygons, first: Ints) -> Ints:
    """Return the first polygon (K + 1,) of each part from the first vertex (K + 1,) of each."""
    vertex = merged.triangles[merged.triangle_start[:-1], 0]
    owner = np.searchsorted(first, vertex, side="right") - 1
    return np.searchsorted(owner, np.arange(len(first)))


def _solids(checked: Sequence[_Checked], declared: Sequence[bool | str]) -> Bools:
    """Return whether each part is solid: as declared, or if it is closed."""
    solid = [
        defects.closed if how == "auto" else bool(how)
        for (_, defects), how in zip(checked, declared, strict=True)
    ]
    return np.array(solid, dtype=np.bool_)


def _open_reason(part: RawPart, defects: MeshDefects) -> str:
    if defects.open_edges:
        reason = f"{defects.open_edges} of its edges are open"
    elif defects.one_sided:
        reason = "it has one side only, as a Moebius strip has"
    else:
        reason = "where more than two of its faces share an edge, its faces cannot be wound alike"
    return f"part {part.name!r} cannot be solid: {reason}; mend the mesh, or say solid: false"


def _qualities(
    checked: Sequence[_Checked], polygons: Ints, declared: Sequence[bool | str]
) -> tuple[Quality, ...]:
    """Return the quality of the mesh of each part; polygons: their number in each."""
    return tuple(
        Quality(
            part=part.name,
            faces=defects.faces,
            polygons=count,
            degenerate=defects.degenerate,
            duplicate=defects.duplicate,
            open_edges=defects.open_edges,
            against=defects.against,
            one_sided=defects.one_sided,
            cavities=defects.cavities,
            nested=defects.nested,
            crossing=defects.crossing,
            tangled=defects.tangled,
            inverted=defects.turned > 0,
            watertight=defects.closed,
            declared=how != "auto",
        )
        for (part, defects), count, how in zip(checked, polygons.tolist(), declared, strict=True)
    )


def _soup_warnings(checked: Sequence[_Checked]) -> list[str]:
    """Return one sentence about parts whose triangles are hardly connected with each other."""
    soups = [
        part.name
        for part, defects in checked
        if len(part.faces) >= _SOUP and defects.open_edges > _LOOSE * len(part.faces)
    ]
    if not soups:
        return []
    shown = ", ".join(soups[:_MAX_NAMES])
    if len(soups) > _MAX_NAMES:
        shown += f" and {len(soups) - _MAX_NAMES} more"
    lead = f"parts {shown} are soups" if len(soups) > 1 else f"part {shown} is a soup"
    return [
        f"{lead} of loose triangles: distances hold, but nothing has an inside or falls into parts; "
        f"merge near corners in the program that made it (Blender: Merge by Distance)"
    ]


def _defect_warnings(checked: Sequence[_Checked]) -> list[str]:
    """Return one sentence for each kind of defect: how often it occurs, and the parts that have it,
    those with the most first."""
    kinds: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for part, defects in checked:
        for defect in defects.present():
            kinds.setdefault((defect.what, defect.meaning), []).append((defect.count, part.name))
    warnings = []
    for (what, meaning), rows in kinds.items():
        names = [name for _, name in sorted(rows, key=lambda row: -row[0])]
        shown = ", ".join(names[:_MAX_NAMES])
        if len(names) > _MAX_NAMES:
            shown += f" and {len(names) - _MAX_NAMES} more"
        some, all_ = ("parts", " in all") if len(names) > 1 else ("part", "")
        defect = Defect(sum(count for count, _ in rows), what, all_ + meaning)
        warnings.append(f"{some} {shown}: {defect.sentence()}")
    return warnings


def _shared_face_warnings(
    names: tuple[str, ...], vertices: Floats, faces: Sequence[Ints], solid: Bools
) -> list[str]:
    """Return one sentence about faces that lie exactly on faces of other parts, if there are any."""
    pair, count = _shared_faces(vertices, faces, solid)
    if not len(pair):
        return []
    first, second = (names[part] for part in pair[np.argmax(count)])
    total = int(count.sum())
    where = f"in {first} and {second}"
    if len(pair) > 1:
        where = f"most of them ({count.max()}) {where}"
    return [
        f"{total} face{'s lie' if total > 1 else ' lies'} exactly on faces of other parts, {where}: "
        f"kept, since distances are the same{HARMLESS}"
    ]


def _shared_faces(vertices: Floats, faces: Sequence[Ints], solid: Bools) -> tuple[Ints, Ints]:
    """Count the faces that lie exactly on faces of another part.

    Where two solids touch, their faces lie on each other wound opposite ways. These are not copies
    and are not counted.

    Returns
    -------
    tuple[Ints, Ints]
        Pairs (K, 2) of parts, and the number (K,) of faces that they share.
    """
    if len(faces) < 2:
        return np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
    owner = np.repeat(np.arange(len(faces)), [len(part) for part in faces])
    corners = weld(vertices, np.concatenate(faces))[1]
    one, other = _equal_faces(corners, owner)
    touching = solid[owner[one]] & solid[owner[other]]
    touching &= winding_sense(corners[one]) != winding_sense(corners[other])
    pairs = np.column_stack([owner[one[~touching]], owner[other[~touching]]])
    return np.unique(pairs, axis=0, return_counts=True)


def _equal_faces(corners: Ints, owner: Ints) -> tuple[Ints, Ints]:
    """Return pairs (N,), (N,) of faces (T, 3) of different parts that have the same three
    corners."""
    key = np.sort(corners, axis=1)
    order = np.lexsort((owner, key[:, 2], key[:, 1], key[:, 0]))
    one = order[:-1]
    other = order[1:]
    copies = (key[one] == key[other]).all(axis=1) & (owner[one] != owner[other])
    copies &= (np.diff(key[one], axis=1) > 0).all(axis=1)  # not collapsed
    return one[copies], other[copies]
