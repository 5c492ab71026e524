"""Parts become an environment: faults counted, duplicate faces out, shells outward, coplanar faces merged."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.polygons import merge_coplanar
from workbench.files.meshes.quality import Faults, examined
from workbench.model.environment import Environment, Quality

__all__ = ["built"]


def built(
    name: str, parts: Iterable[RawPart], *, solid: Iterable[bool | str], notes: Iterable[str] = ()
) -> tuple[Environment, list[tuple[int, str]]]:
    """An environment from parts in the world's frame [m]: duplicates out, shells outward, coplanar faces merged.

    solid: for each part "auto" (closed ones are), True or False. Also returns faults: (part, what is wrong).
    """
    checked = [examined(part) for part in parts]
    wanted = list(solid)
    counts = [len(part.vertices) for part, _ in checked]
    first = np.cumsum([0, *counts])
    vertices = np.concatenate([np.zeros((0, 3)), *(part.vertices for part, _ in checked)])
    shifted = [part.faces + start for (part, _), start in zip(checked, first, strict=False)]
    faces = np.concatenate([np.zeros((0, 3), dtype=np.int64), *shifted])
    merged = merge_coplanar(vertices, faces)
    owner = np.searchsorted(first, merged.triangles[merged.triangle_start[:-1], 0], side="right") - 1
    part_start = np.searchsorted(owner, np.arange(len(checked) + 1))
    polygons = np.diff(part_start)
    closed = [found.closed for _, found in checked]
    faults = [(k, _open(*pair)) for k, pair in enumerate(checked) if wanted[k] is True and not pair[1].closed]
    warnings = _grouped((part.name, said) for part, found in checked for said in found.sentences())
    none = np.zeros(len(checked), dtype=np.bool_)
    environment = Environment(
        name=name, description="", parts=tuple(part.name for part, _ in checked), part_start=part_start,
        vertices=vertices, edges=merged.edges, edge_start=merged.edge_start, normal=merged.normal,
        offset=merged.offset, circle_centre=merged.circle_centre, circle_radius=merged.circle_radius,
        triangles=merged.triangles, triangle_start=merged.triangle_start,
        solid=np.array([c if w == "auto" else bool(w) for c, w in zip(closed, wanted, strict=True)], dtype=np.bool_),
        hidden=none, see_through=none,
        quality=tuple(_quality(p.name, found, int(n)) for (p, found), n in zip(checked, polygons, strict=True)),
        warnings=(*notes, *warnings),
    )  # fmt: skip
    return environment, faults


def _open(part: RawPart, found: Faults) -> str:
    why = f"{found.open_edges} of its edges are open" if found.open_edges else "its faces are not wound alike"
    return f"part {part.name!r} cannot be solid: {why}; mend the mesh, or say solid: false"


def _quality(name: str, found: Faults, polygons: int) -> Quality:
    return Quality(part=name, faces=found.faces, polygons=polygons, degenerate=found.degenerate,
                   duplicate=found.duplicate, open_edges=found.open_edges, inverted=found.turned > 0,
                   watertight=found.closed)  # fmt: skip


def _grouped(said: Iterable[tuple[str, str]]) -> list[str]:
    """One line for each thing said, naming the parts it is said of; many alike are counted after the third."""
    parts: dict[str, list[str]] = {}
    for name, sentence in said:
        parts.setdefault(sentence, []).append(name)
    lines = []
    for sentence, names in parts.items():
        shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        lines.append(f"part{'s' if len(names) > 1 else ''} {shown}: {sentence}")
    return lines
