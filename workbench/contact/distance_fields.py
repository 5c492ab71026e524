"""An environment packed for the kernels: polygons with a tree a part, and grids of distances to
groups of parts.

The nodes of grids packed by cell: the eight corners of each side by side, 16 bits a corner; and
the solids that may hold points of each cell.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.index_cache import cached
from workbench.contact.kernels.bounding_cylinders import heads_of
from workbench.contact.kernels.distance_field import DistanceField, fill_rows
from workbench.contact.kernels.point_in_solid import SolidMeshes, is_closed
from workbench.contact.kernels.search import Parts, Trees
from workbench.contact.kernels.solid_cells import mark_solid
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT, collapse_bvh
from workbench.geometry.bvh import build_sah_bvh
from workbench.geometry.polygon import EDGES, RECORD, Faces
from workbench.geometry.simd4 import FOUR
from workbench.geometry.simd8 import LANES
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.content import content_key
from workbench.model.environment import Environment
from workbench.threads import run_in_threads

__all__ = [
    "STRAIGHT",
    "Groups",
    "build_distance_field",
    "pack_cells",
    "packed_faces",
    "packed_parts",
    "packed_shells",
    "scale_of",
    "straightened",
    "with_solids",
]

Single = NDArray[np.float32]
MANTISSA = 11
"""Bits of a code's mantissa: what it stands for is less than it should be by a 2,048th at most, and
d by half that."""

BESIDE = 2
"""Cells beside the box of a solid that are looked at too: more than its surface is widened by."""


def scale_of(square: Single) -> float:
    """The power of two that codes are to be multiplied by so that the greatest of squares (.,) has
    one."""
    return float(np.ldexp(1.0, int(np.frexp(square.max(initial=0.0))[1]) + 95))


def with_solids(field: DistanceField, faces: Faces, shells: SolidMeshes) -> DistanceField:
    """A field with the sets of solids that may hold points of its cells."""
    held = np.zeros(len(field.near), dtype=np.int32)
    sets: dict[tuple[tuple[int, int], ...], int] = {(): 0}
    found: list[tuple[tuple[int, int], ...]] = [()]
    for g in range(len(field.trees.root)):
        nx, ny, nz, first = field.shape[g].tolist()
        cells = held[first : first + nx * ny * nz].reshape(nx, ny, nz)
        for s in range(field.solid_start[g], field.solid_start[g + 1]):
            for sure, at in enumerate(_marked(field, faces, shells, g, s)):
                before, which = np.unique(cells[at], return_inverse=True)
                after = []
                for number in before.tolist():
                    one = (*found[number], (s, sure))
                    if one not in sets:
                        sets[one] = len(found)
                        found.append(one)
                    after.append(sets[one])
                cells[at] = np.array(after, dtype=np.int32)[which.reshape(-1)]
    members = np.array([pair for one in found for pair in one], dtype=np.int64).reshape(-1, 2)
    return field._replace(
        held=held,
        set_start=np.cumsum([0, *map(len, found)]),
        set_solid=np.ascontiguousarray(members[:, 0]),
        set_sure=np.ascontiguousarray(members[:, 1]),
    )


def _marked(
    field: DistanceField, faces: Faces, shells: SolidMeshes, g: int, s: int
) -> Iterator[tuple[Ints, ...]]:
    """The cells of a group that the surface of a solid may run through, then those inside it: their
    indices along x, y, z."""
    per = field.grid[g, 4]
    whole = field.shape[g, :3] - 1
    span = (field.solid_span[s].reshape(2, 3) - field.grid[g, :3]) * per
    low = np.clip(np.floor(span[0]).astype(np.int64) - BESIDE, 0, whole)
    high = np.clip(np.ceil(span[1]).astype(np.int64) + BESIDE, 0, whole)
    touched, inside = (np.zeros(tuple(np.maximum(high - low, 0)), dtype=np.bool_) for _ in range(2))
    stack = np.empty(64, dtype=np.int64)
    mark_solid(touched, inside, low, faces, shells, field, g, s, stack)
    for marked in (touched, inside):
        yield tuple(at + start for at, start in zip(np.nonzero(marked), low, strict=True))


def pack_cells(field: DistanceField, square: Single) -> None:
    """Fill field.scale and field.cell by the squares of the nodes, and have the slack hold
    what that adds."""
    for g, (nx, ny, nz, first) in enumerate(field.shape.tolist()):
        some = slice(first, first + nx * ny * nz)
        nodes = square[some].reshape(nx, ny, nz)
        cells = field.cell.reshape(-1, LANES)[some].reshape(nx, ny, nz, LANES)
        scale = scale_of(nodes)
        field.scale[g] = scale
        # a corner's lowest bit may stand for 2^-137 where it should be nothing
        field.grid[g, 5] += 1e-6 * field.grid[g, 3] ** 2 + np.ldexp(scale, -137)
        code = _codes(nodes, scale)
        for k, corner in enumerate(_corner_codes(code)):
            cells[:-1, :-1, :-1, k] = corner
        _mark_unsure(cells[..., 0], field.held[some].reshape(nx, ny, nz) > 0)


def _codes(nodes: Single, scale: float) -> NDArray[np.uint32]:
    """Squares of distances as codes of 16 bits: five of exponent, MANTISSA below."""
    code = (nodes * np.float32(1.0 / scale)).view(np.uint32) >> np.uint32(12)
    code[code < 1 << MANTISSA] = 0  # too small for the exponent
    return code


def _corner_codes(nodes: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Of each cell between nodes (nx, ny, nz) the values at its eight corners, corner by corner, z
    changing first."""
    nx, ny, nz = nodes.shape
    for k in range(LANES):
        i = k >> 2
        j = k >> 1 & 1
        m = k & 1
        yield nodes[i : nx - 1 + i, j : ny - 1 + j, m : nz - 1 + m]


def _mark_unsure(corner: NDArray[np.uint16], unsure: Bools) -> None:
    """Set the lowest bit of a corner's codes where a solid may be in the cell, rounding down: the
    greatest odd number that is no more than the code, else the greatest even one."""
    odd = np.maximum(corner, 1) - 1 | 1
    np.copyto(corner, np.where(unsure, odd, corner & 0xFFFE), casting="unsafe")


CELL = 0.02
"""Edge of a cell [m]: at 1 cm the bounds are four times as tight, and the nodes no longer stay in
the cache."""
WIDE_CELL = 0.10
"""Edge of a cell [m] of the grids that answer for single parts from far off."""
MOST_NODES = 2_000_000
"""Nodes of all grids of a field, 8 bytes each; cells of larger environments grow to keep to it."""
WORTH_KEEPING = 1_000
"""Polygons from which on an index is kept on disk: smaller ones are made in no time."""
Groups = tuple[tuple[int, ...], ...]


def packed_faces(environment: Environment) -> Faces:
    """The polygons and a tree of boxes a part, once an environment (nouns are frozen and compare by
    identity)."""
    return _faces(_shape(environment))


@lru_cache(maxsize=16)
def _faces(environment: Environment) -> Faces:
    box, link, item, root = _tree(environment)
    record, begin = _records(environment, item)
    rank = np.empty(len(item), dtype=np.int64)
    rank[item] = np.arange(len(item))
    return Faces(
        record=record,
        begin=begin,
        rank=rank,
        low=box[:, :3].copy(),
        high=box[:, 3:].copy(),
        child=link[:, 0].copy(),
        first=link[:, 1].copy(),
        last=link[:, 2].copy(),
        item=item,
        root=root,
        solid=environment.solid.astype(np.int64),
        corners=np.ascontiguousarray(environment.vertices[environment.triangles]).reshape(-1, 3, 3),
        corner_start=environment.triangle_start[environment.part_start],
    )


@lru_cache(maxsize=16)
def _tree(environment: Environment) -> tuple[Floats, Ints, Ints, Ints]:
    """A tree over the polygons of each part, as `build_sah_bvh` gives it."""
    return build_sah_bvh(np.concatenate(_boxes(environment), axis=1), environment.part_start)


def _records(environment: Environment, order: Ints) -> tuple[Floats, Ints]:
    """The polygons as records in an order, and where each begins (F + 1,)."""
    off, radius = _thickness(environment)
    ends, start = straightened(environment)
    count = np.diff(start)[order]
    fours = -(-count // FOUR)
    begin = np.concatenate([[0], np.cumsum(RECORD + EDGES * fours)])
    record = np.empty(int(begin[-1]))
    head = [
        *environment.normal[order].T,
        *environment.circle_centre[order].T,
        radius[order],
        np.argmax(np.abs(environment.normal[order]), axis=1).reshape(-1),
        order,
        off[order],
    ]
    for column, values in enumerate(head):
        record[begin[:-1] + column] = values
    within = np.arange(FOUR * fours.sum()) - np.repeat(
        FOUR * (np.cumsum(fours) - fours), FOUR * fours
    )
    sides = np.repeat(count, FOUR * fours)
    edge = np.repeat(start[order], FOUR * fours) + np.where(within < sides, within, 0)
    place = np.repeat(begin[:-1] + RECORD, FOUR * fours) + EDGES * (within // FOUR)
    place += within % FOUR
    for axis in range(3):
        record[place + FOUR * axis] = ends[edge, 0, axis]
        record[place + FOUR * (axis + 3)] = ends[edge, (within < sides).astype(int), axis]
    return record, begin


def packed_shells(environment: Environment) -> SolidMeshes:
    """The triangles of each polygon, and which solids are closed."""
    return _shells(_shape(environment))


@lru_cache(maxsize=16)
def _shells(environment: Environment) -> SolidMeshes:
    ends = environment.triangle_start[environment.part_start]
    closed = [
        bool(solid) and is_closed(environment.triangles[a:b])
        for solid, a, b in zip(environment.solid, ends[:-1], ends[1:], strict=True)
    ]
    return SolidMeshes(environment.triangle_start, np.array(closed, dtype=np.int64))


def packed_parts(environment: Environment) -> Parts:
    """The parts, hidden ones too, with a tree over the polygons of each, and its vertices."""
    return _parts(_shape(environment))


@lru_cache(maxsize=16)
def _parts(environment: Environment) -> Parts:
    faces = _faces(environment)
    box, link, item, roots = _tree(environment)
    span = np.where(roots[:, None] >= 0, box[roots] if len(box) else np.zeros((len(roots), 6)), 0.0)
    boxes, child, many, bases = collapse_bvh(box, link, faces.rank[item], roots)
    reach = float(np.abs(environment.vertices).max(initial=0.0))
    corner, first = _corners(environment, 0.5 * (span[:, :3] + span[:, 3:]))
    heads = heads_of(child, many, faces.record, faces.begin, reach)
    trees = Trees(faces.record, faces.begin, boxes, child, many, heads, bases, span)
    return Parts(faces, _shells(environment), trees, corner, first)


def _corners(environment: Environment, middle: Floats) -> tuple[NDArray[np.float32], Ints]:
    """The vertices of each part in blocks of eight, seen from middle (K, 3) [m], and where the
    blocks of each begin (K + 1,). The last block of a part is filled up with one of its
    vertices."""
    ends = environment.edge_start[environment.part_start]
    blocks: list[Floats] = []
    for k, (a, b) in enumerate(pairwise(ends)):
        own = np.unique(environment.edges[a:b, 0])
        filled = np.pad(own, (0, -len(own) % EIGHT), mode="edge") if len(own) else own
        points = environment.vertices[filled] - middle[k]
        blocks.append(points.reshape(-1, EIGHT, 3).transpose(0, 2, 1))
    first = np.cumsum([0, *map(len, blocks)])
    return np.concatenate([np.zeros(0), *map(np.ravel, blocks)]).astype(np.float32), first


def build_distance_field(environment: Environment, groups: Groups) -> DistanceField:
    """Make grids and trees of groups of parts, on all cores.

    They are kept for the next batch, large ones also on disk.

    Parameters
    ----------
    environment : Environment
    groups : tuple of tuples of int
        Parts of each group.
    """
    return _field_of(_shape(environment), groups)


@lru_cache(maxsize=32)
def _field_of(shape: Environment, groups: Groups) -> DistanceField:
    """The same of a shape."""
    faces = _faces(shape)

    def make() -> dict[str, NDArray[Any]]:
        made = _made(shape, groups)
        arrays = {**made.trees._asdict(), **made._asdict()}
        return {name: arrays[name] for name in arrays if name not in ("trees", "record", "begin")}

    large = len(faces.begin) >= WORTH_KEEPING
    known = cached(content_key("contact index", shape, groups), make) if large else make()
    trees = {name: known[name] for name in Trees._fields if name in known}
    grids = {name: known[name] for name in known if name not in trees}
    return DistanceField(Trees(faces.record, faces.begin, **trees), **grids)


@lru_cache(maxsize=32)
def _shape(environment: Environment) -> Environment:
    """The polygons and parts of an environment, without its seats, points, controls,
    adjustments, instruments, mirrors, rules and words.

    An index is made from this alone: so it stays the same where only a control or a rule is another
    one, and whatever is hidden, of which groups hold nothing. It is the same object for all environments of which it is the same.
    """
    shape = replace(
        environment,
        name="",
        description="",
        hidden=np.zeros_like(environment.hidden),
        allowances=(),
        seats=(),
        points={},
        controls=(),
        adjustments=(),
        instruments=(),
        mirrors=(),
        quality=(),
        warnings=(),
    )
    return _first_alike(_Shape(content_key("contact shape", shape), shape)).shape


@dataclass(frozen=True)
class _Shape:
    """A shape by the key of its content."""

    key: bytes
    shape: Environment = field(compare=False)


@lru_cache(maxsize=32)
def _first_alike(shape: _Shape) -> _Shape:
    """The first of shapes that are equal."""
    return shape


@dataclass(frozen=True, eq=False)
class _Solids:
    """The solid parts of each group, in order."""

    start: Ints
    """(G + 1,) where those of each group begin."""
    part: Ints
    """(.,) parts."""
    ranks: Ints
    """(., 2) first and last rank of each part's polygons."""


def _solids_of(environment: Environment, groups: Groups) -> _Solids:
    root = _faces(environment).root
    solids = [[k for k in group if environment.solid[k] and root[k] >= 0] for group in groups]
    part = np.array([k for group in solids for k in group], dtype=np.int64)
    ends = environment.part_start
    return _Solids(
        np.cumsum([0, *map(len, solids)]), part, np.stack([ends[part], ends[part + 1]], axis=1)
    )


def _polygons_of(environment: Environment, parts: Iterable[int]) -> Ints:
    """The polygons of some parts, part by part."""
    spans = [np.arange(*environment.part_start[[k, k + 1]]) for k in parts]
    return np.concatenate([np.zeros(0, dtype=np.int64), *spans])


def _made(environment: Environment, groups: Groups) -> DistanceField:
    """Trees and grids of groups of parts, made anew."""
    faces = _faces(environment)
    solids = _solids_of(environment, groups)
    count = len(groups)
    members = [_polygons_of(environment, group) for group in groups]
    members += [_polygons_of(environment, [k]) for k in solids.part]
    polygons = np.concatenate([np.zeros(0, dtype=np.int64), *members])
    box, link, item, roots = build_sah_bvh(
        np.concatenate(_boxes(environment), axis=1)[polygons], np.cumsum([0, *map(len, members)])
    )
    span = np.where(roots[:, None] >= 0, box[roots] if len(box) else np.zeros((len(roots), 6)), 0.0)
    boxes, child, many, bases = collapse_bvh(box, link, faces.rank[polygons][item], roots)
    grid, shape, wide = _grids(span[:count], environment)
    nodes = int(shape[:, :3].prod(axis=1).sum())
    reach = float(np.abs(environment.vertices).max(initial=0.0))
    heads = heads_of(child, many, faces.record, faces.begin, reach)
    field = DistanceField(
        trees=Trees(
            faces.record, faces.begin, boxes, child, many, heads, bases[:count], span[:count]
        ),
        wide=wide,
        grid=grid,
        shape=shape,
        scale=np.ones(len(grid), dtype=np.float32),
        cell=np.zeros(nodes * EIGHT, dtype=np.uint16),
        near=np.full(nodes, -1, dtype=np.int32),
        solid_start=solids.start,
        solid_part=solids.part,
        solid_root=bases[count:],
        solid_span=span[count:],
        solid_rank=solids.ranks,
        held=np.zeros(0, dtype=np.int32),
        set_start=np.zeros(2, dtype=np.int64),
        set_solid=np.zeros(0, dtype=np.int64),
        set_sure=np.zeros(0, dtype=np.int64),
    )
    field = with_solids(field, faces, _shells(environment))
    _fill(field)
    return field


def _fill(field: DistanceField) -> None:
    """Fill the nodes and cells of all grids, on all cores."""
    square = np.zeros(len(field.near), dtype=np.float32)
    for g in range(len(field.grid)):
        group = g % len(field.trees.root)

        def work(begin: int, end: int, g: int = g, group: int = group) -> None:
            stack = np.empty(DEEP, dtype=np.int64)
            gaps = np.empty(DEEP + EIGHT, dtype=np.float32)
            fill_rows(field, square, g, group, stack, gaps, begin, end)

        if field.trees.root[group] >= 0:
            rows = int(field.shape[g, 0] * field.shape[g, 1])
            run_in_threads(work, rows, max(rows // 32, 64))
    pack_cells(field, square)


def _rounding(environment: Environment) -> float:
    """More than the rounding of a point on a polygon, of its heights and of its distances to the
    polygon [m]."""
    return (
        16.0
        * float(np.finfo(np.float64).eps)
        * float(np.abs(environment.vertices).max(initial=0.0))
    )


def _thickness(environment: Environment) -> tuple[Floats, Floats]:
    """How far the corners of each polygon lie off its plane (F,), and from its circle's centre in
    it (F,) [m].

    Widened by rounding, so that what a kernel gives up by them is farther also as it would have
    been computed.
    """
    start = environment.edge_start
    if len(start) == 1:
        return np.zeros(0), np.zeros(0)
    polygon = np.repeat(np.arange(len(start) - 1), np.diff(start))
    normal = environment.normal[polygon]
    arm = environment.vertices[environment.edges[:, 0]] - environment.circle_centre[polygon]
    height = np.einsum("ec,ec->e", arm, normal)
    arm -= height[:, None] * normal
    far = np.sqrt(np.einsum("ec,ec->e", arm, arm))
    off, radius = (np.maximum.reduceat(values, start[:-1]) for values in (np.abs(height), far))
    spare = _rounding(environment)
    return off * (1.0 + 1e-12) + spare, radius * (1.0 + 1e-12) + spare


def _boxes(environment: Environment) -> tuple[Floats, Floats]:
    """Boxes (F, 3) around the polygons, widened by rounding."""
    heads = environment.vertices[environment.edges[:, 0]]
    start = environment.edge_start[:-1]
    if not len(start):
        return np.zeros((0, 3)), np.zeros((0, 3))
    spare = _rounding(environment)
    return np.minimum.reduceat(heads, start, axis=0) - spare, np.maximum.reduceat(
        heads, start, axis=0
    ) + spare


def _grids(own: Floats, environment: Environment) -> tuple[Floats, Ints, Ints]:
    """Grids (G + W, 7), shapes (G + W, 4) and wide (G,) for groups with boxes own (G, 6); wide ones
    where G > 1."""
    grid, shape = _cells(own, CELL)
    wide = np.full(len(own), -1, dtype=np.int64)
    if len(own) > 1:
        coarse, counts = _cells(
            np.repeat(environment.bounds.reshape(1, 6), len(own), axis=0), WIDE_CELL
        )
        wide += np.arange(1, len(own) + 1) + len(own)
        grid = np.concatenate([grid, coarse])
        shape = np.concatenate([shape, counts])
    shape[1:, 3] = np.cumsum(shape[:-1, :3].prod(axis=1))
    reach = np.abs(environment.vertices).max(initial=0.0) + 1.0
    grid[:, 5] = 1e-9 * grid[:, 3] ** 2 + 1e-14 * reach * grid[:, 3] * shape[:, :3].max(
        axis=1, initial=2
    )
    grid[:, 6] = _thickness(environment)[0].max(initial=0.0)
    return grid, shape, wide


def _cells(boxes: Floats, cell: float) -> tuple[Floats, Ints]:
    """Grids and shapes around boxes (G, 6), slack and first nodes left open; all cells grow alike
    until they fit."""
    while True:
        # a hair wider than the box, and centred: nothing of the group lies beyond the last node
        sides = (boxes[:, 3:] - boxes[:, :3]) + 2e-3 * cell
        shape = np.maximum(np.ceil(sides / cell), 1.0) + 1.0
        if shape.prod(axis=1).sum() <= MOST_NODES or cell > 1e9:
            break
        cell *= 1.2
    whole: Ints = np.zeros((len(boxes), 4), dtype=np.int64)
    whole[:, :3] = shape
    grid = np.zeros((len(boxes), 7))
    grid[:, :3] = 0.5 * (boxes[:, :3] + boxes[:, 3:]) - 0.5 * cell * (shape - 1.0)
    grid[:, 3] = cell
    grid[:, 4] = 1.0 / cell
    return grid, whole


# Borders of polygons with as few edges as they have sides.
#
# Triangles that lie in one plane are merged into polygons, whose borders keep every vertex of the
# mesh: a flat wall of a finely cut model has hundreds along each side. A search measures each edge.

STRAIGHT = 1e-12
"""How far [m] a vertex that is left out may lie off the side that it is on: less than distances
are computed to."""


def straightened(environment: Environment) -> tuple[Floats, Ints]:
    """Join the edges of each polygon that lie in one line.

    Parameters
    ----------
    environment
        Its F polygons.

    Returns
    -------
    tuple
        Ends (E, 2, 3) [m] of the sides, tail and head, polygon by polygon; and where those of each
        polygon begin (F + 1,).
    """
    ends = environment.vertices[environment.edges]
    polygon = np.repeat(np.arange(len(environment.edge_start) - 1), np.diff(environment.edge_start))
    after = _edge_after(environment.edges, polygon)
    goes_on = _in_line(ends, after)
    while True:
        first, last, run = _runs(after, goes_on)
        bent = _off(ends, first, last, run) > STRAIGHT
        if not np.any(bent & goes_on):
            break
        goes_on &= ~np.isin(run, np.unique(run[bent & goes_on]))
    sides = np.stack([ends[first, 0], ends[last, 1]], axis=1)
    count = np.bincount(polygon[first], minlength=len(environment.edge_start) - 1)
    return sides, np.concatenate([[0], np.cumsum(count)])


def _edge_after(edges: Ints, polygon: Ints) -> Ints:
    """(E,) the edge of the same polygon that begins where each edge ends; -1 where not one does."""
    most = int(edges.max(initial=0)) + 1
    tail = polygon * most + edges[:, 0]
    order = np.argsort(tail, kind="stable")
    head = polygon * most + edges[:, 1]
    low, high = (np.searchsorted(tail[order], head, side=side) for side in ("left", "right"))
    return np.where(high - low == 1, order[np.minimum(low, len(order) - 1)], -1)


def _in_line(ends: Floats, after: Ints) -> Bools:
    """(E,) whether each edge and the one after it point the same way."""
    way = ends[:, 1] - ends[:, 0]
    on = way[after]
    both = np.linalg.norm(way + on, axis=1)
    aside = np.linalg.norm(np.cross(way, on), axis=1)
    straight = aside <= STRAIGHT * np.maximum(both, 1e-300)
    return np.asarray((after >= 0) & straight & (np.einsum("ec,ec->e", way, on) > 0.0))


def _runs(after: Ints, goes_on: Bools) -> tuple[Ints, Ints, Ints]:
    """The first and the last edge (R,) of each run of edges in one line, and the run (E,) of each
    edge. No run goes all around: a polygon has corners."""
    begins = np.ones(len(after), dtype=np.bool_)
    begins[after[goes_on]] = False
    first = np.flatnonzero(begins)
    run = np.full(len(after), -1)
    run[first] = np.arange(len(first))
    last = first.copy()
    on = np.flatnonzero(goes_on[last])
    while len(on):
        last[on] = after[last[on]]
        run[last[on]] = on
        on = on[goes_on[last[on]]]
    return first, last, run


def _off(ends: Floats, first: Ints, last: Ints, run: Ints) -> Floats:
    """(E,) [m] how far the head of each edge lies off the line from the tail of its run's first edge
    to the head of its last."""
    start = ends[first, 0][run]
    way = ends[last, 1][run] - start
    arm = ends[:, 1] - start
    long = np.maximum(np.linalg.norm(way, axis=1), 1e-300)
    return np.linalg.norm(np.cross(way, arm), axis=1) / long
