"""Build an environment from parts: faults counted, windings mended, coplanar faces merged."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from workbench.files.meshes.parts import RawPart, welded
from workbench.files.meshes.polygons import merge_coplanar
from workbench.files.meshes.quality import Fault, Faults, examined
from workbench.files.meshes.winding import way_round
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment, Quality

__all__ = ["built"]

_NAMED = 3
"""Parts named in a warning that is about many."""


def built(
    name: str, parts: Iterable[RawPart], *, solid: Iterable[bool | str], notes: Iterable[str] = ()
) -> tuple[Environment, list[tuple[int, str]]]:
    """Build an environment from parts in the world's frame [m]: duplicates out, shells outward,
    coplanar faces merged.

    solid: for each part "auto" (closed ones are), True or False. Also returns faults: (part, what
    is wrong).
    """
    checked = [examined(part) for part in parts]
    wanted = list(solid)
    first = np.cumsum([0, *(len(part.vertices) for part, _ in checked)])
    vertices = np.concatenate([np.zeros((0, 3)), *(part.vertices for part, _ in checked)])
    shifted = [part.faces + start for (part, _), start in zip(checked, first, strict=False)]
    merged = merge_coplanar(vertices, np.concatenate([np.zeros((0, 3), dtype=np.int64), *shifted]))
    owner = (
        np.searchsorted(first, merged.triangles[merged.triangle_start[:-1], 0], side="right") - 1
    )
    part_start = np.searchsorted(owner, np.arange(len(checked) + 1))
    names = tuple(part.name for part, _ in checked)
    closed = [found.closed for _, found in checked]
    solids = np.array(
        [c if w == "auto" else bool(w) for c, w in zip(closed, wanted, strict=True)], dtype=np.bool_
    )
    faults = [
        (k, _open(*pair))
        for k, pair in enumerate(checked)
        if wanted[k] is True and not pair[1].closed
    ]
    none = np.zeros(len(checked), dtype=np.bool_)
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
        quality=tuple(
            _quality(part.name, found, int(n), declared=how != "auto")
            for (part, found), n, how in zip(checked, np.diff(part_start), wanted, strict=True)
        ),
        warnings=(*notes, *_grouped(checked), *_shared(names, vertices, shifted, solids)),
    )
    return environment, faults


def _open(part: RawPart, found: Faults) -> str:
    if found.open_edges:
        why = f"{found.open_edges} of its edges are open"
    elif found.one_sided:
        why = "it has one side only, as a Moebius strip has"
    else:
        why = "where more than two of its faces share an edge, its faces cannot be wound alike"
    return f"part {part.name!r} cannot be solid: {why}; mend the mesh, or say solid: false"


def _quality(name: str, found: Faults, polygons: int, *, declared: bool) -> Quality:
    return Quality(
        part=name,
        faces=found.faces,
        polygons=polygons,
        degenerate=found.degenerate,
        duplicate=found.duplicate,
        open_edges=found.open_edges,
        against=found.against,
        one_sided=found.one_sided,
        cavities=found.cavities,
        nested=found.nested,
        crossing=found.crossing,
        inverted=found.turned > 0,
        watertight=found.closed,
        declared=declared,
    )


def _grouped(checked: Sequence[tuple[RawPart, Faults]]) -> list[str]:
    """One line for each kind of fault: the parts that have it, those with the most first, and how
    often in all."""
    kinds: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for part, found in checked:
        for fault in found.found():
            kinds.setdefault((fault.what, fault.meaning), []).append((fault.count, part.name))
    lines = []
    for (what, meaning), rows in kinds.items():
        names = [name for _, name in sorted(rows, key=lambda row: -row[0])]
        shown = ", ".join(names[:_NAMED]) + (
            f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        )
        total = Fault(
            sum(count for count, _ in rows), what, (" in all" if len(names) > 1 else "") + meaning
        )
        lines.append(f"part{'s' if len(names) > 1 else ''} {shown}: {total.sentence()}")
    return lines


def _shared(
    names: tuple[str, ...], vertices: Floats, faces: Sequence[Ints], solid: Bools
) -> list[str]:
    """One line about the faces that lie exactly on faces of other parts, none where there are none.

    Where two solids touch, their faces lie on each other wound opposite ways; these are not copies
    and not counted.
    """
    if len(names) < 2:
        return []
    owner = np.repeat(np.arange(len(names)), [len(part) for part in faces])
    corners = welded(vertices, np.concatenate(faces))[1]
    place = np.sort(corners, axis=1)
    order = np.lexsort((owner, place[:, 2], place[:, 1], place[:, 0]))
    one = order[:-1]
    other = order[1:]
    copies = (place[one] == place[other]).all(axis=1) & (owner[one] != owner[other])
    copies &= (np.diff(place[one], axis=1) > 0).all(axis=1)
    one = one[copies]
    other = other[copies]
    touching = (
        solid[owner[one]]
        & solid[owner[other]]
        & (way_round(corners[one]) != way_round(corners[other]))
    )
    pair, count = np.unique(
        owner[one[~touching]] * len(names) + owner[other[~touching]], return_counts=True
    )
    if not len(pair):
        return []
    most = int(pair[np.argmax(count)])
    first = names[most // len(names)]
    second = names[most % len(names)]
    total = int(count.sum())
    where = (
        f"most of them ({count.max()}) in {first} and {second}"
        if len(pair) > 1
        else f"in {first} and {second}"
    )
    return [
        f"{total} face{'s lie' if total > 1 else ' lies'} exactly on faces of other parts, {where}: "
        "kept, since distances are the same"
    ]
