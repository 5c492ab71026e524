"""An environment packed for the kernels: polygons with a tree a part, and grids of distances to
groups of parts."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.cells import pack_cells
from workbench.contact.index_cache import kept
from workbench.contact.kernels.field import RECORD, Field, fill_rows
from workbench.contact.kernels.heads import heads_of
from workbench.contact.kernels.inside import Shells, is_closed
from workbench.contact.kernels.triangles import SPARE, rows_of
from workbench.contact.kernels.wide import DEEP, EIGHT, widened
from workbench.contact.patches import Patches, cell_lists, patches_of
from workbench.geometry.polygon import Faces
from workbench.geometry.split import split_tree
from workbench.geometry.tree import build_tree
from workbench.model.arrays import Floats, Ints
from workbench.model.content import content_key
from workbench.model.environment import Environment
from workbench.threads import in_pieces

__all__ = ["Groups", "field_of", "packed_faces", "packed_records", "packed_shells"]

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
    head = environment.vertices[environment.edges[:, 0]]
    tail = environment.vertices[environment.edges[:, 1]]
    low, high = _boxes(environment)
    off, radius = _thickness(environment)
    corners = environment.vertices[environment.triangles]
    return Faces(
        np.ascontiguousarray(head),
        np.ascontiguousarray(tail),
        environment.edge_start,
        environment.normal,
        np.argmax(np.abs(environment.normal), axis=1).reshape(-1),
        off,
        environment.circle_centre,
        radius,
        *build_tree(low, high, environment.part_start),
        environment.solid.astype(np.int64),
        np.ascontiguousarray(corners.reshape(-1, 3, 3)),
        environment.triangle_start[environment.part_start],
    )


def packed_shells(environment: Environment) -> Shells:
    """The triangles of each polygon, and which solids are closed."""
    return _shells(_shape(environment))


@lru_cache(maxsize=16)
def _shells(environment: Environment) -> Shells:
    ends = environment.triangle_start[environment.part_start]
    closed = [
        bool(solid) and is_closed(environment.triangles[a:b])
        for solid, a, b in zip(environment.solid, ends[:-1], ends[1:], strict=True)
    ]
    return Shells(environment.triangle_start, np.array(closed, dtype=np.int64))


def packed_records(environment: Environment) -> tuple[Floats, Ints, Ints]:
    """Polygons as records in the order of the trees' leaves: record, begin (F + 1,), rank (F,) of
    each polygon."""
    return _records(_shape(environment))


@lru_cache(maxsize=4)
def _records(environment: Environment) -> tuple[Floats, Ints, Ints]:
    faces = _faces(environment)
    order = faces.item
    count = np.diff(environment.edge_start)[faces.item]
    begin = np.concatenate([[0], np.cumsum(RECORD + 6 * count)])
    record = np.empty(int(begin[-1]))
    head = [
        *faces.normal[order].T,
        *faces.circle_centre[order].T,
        faces.circle_radius[order],
        faces.drop[order],
        order,
        faces.off[order],
    ]
    for column, values in enumerate(head):
        record[begin[:-1] + column] = values
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    edge = np.repeat(environment.edge_start[order], count) + within
    place = np.repeat(begin[:-1] + RECORD, count) + 6 * within
    for axis in range(3):
        record[place + axis] = faces.head[edge, axis]
        record[place + 3 + axis] = faces.tail[edge, axis]
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return record, begin, rank


@lru_cache(maxsize=4)
def field_of(environment: Environment, groups: Groups, lists: bool = True) -> Field:
    """Make grids and trees of groups of parts, on all cores.

    They are kept for the next batch, large ones also on disk.

    Parameters
    ----------
    environment : Environment
    groups : tuple of tuples of int
        Parts of each group.
    lists : bool
        With one group, also list the polygons near each cell. Only questions for distances read
        these lists; they take as long to make as all else.
    """
    shape = _shape(environment)
    record, begin, _ = _records(shape)

    def make() -> dict[str, NDArray[Any]]:
        made = _made(shape, groups, lists)._asdict()
        return {name: values for name, values in made.items() if name not in ("record", "begin")}

    if len(begin) < WORTH_KEEPING:
        return Field(record, begin, **make())
    listed = lists and len(groups) == 1
    return Field(record, begin, **kept(content_key("contact index", shape, groups, listed), make))


@lru_cache(maxsize=16)
def _shape(environment: Environment) -> Environment:
    """The polygons and parts of an environment, without its seats, points, controls, rules and
    words.

    An index is made from this alone: so it stays the same where only a control or a rule is another
    one.
    """
    return replace(
        environment,
        name="",
        description="",
        allowances=(),
        seats=(),
        points={},
        controls=(),
        quality=(),
        warnings=(),
    )


def _made(environment: Environment, groups: Groups, lists: bool) -> Field:
    faces = _faces(environment)
    shells = _shells(environment)
    record, begin, rank = _records(environment)
    none = np.zeros(0, dtype=np.int64)
    members = [
        np.concatenate([none, *(np.arange(*environment.part_start[[k, k + 1]]) for k in group)])
        for group in groups
    ]
    solids = [[k for k in group if environment.solid[k] and faces.root[k] >= 0] for group in groups]
    members += [np.arange(*environment.part_start[[k, k + 1]]) for group in solids for k in group]
    polygons = np.concatenate([none, *members])
    box, link, item, roots = split_tree(
        np.concatenate(_boxes(environment), axis=1)[polygons], np.cumsum([0, *map(len, members)])
    )
    span = np.where(roots[:, None] >= 0, box[roots] if len(box) else np.zeros((len(roots), 6)), 0.0)
    boxes, child, many, bases = widened(box, link, rank[polygons][item], roots)
    root = bases[: len(groups)]
    grid, shape, wide = _grids(span[: len(groups)], environment)
    nodes = int(shape[:, :3].prod(axis=1).sum())
    reach = float(np.abs(environment.vertices).max(initial=0.0))
    absent = np.zeros(0, dtype=np.int32)
    field = Field(
        record,
        begin,
        boxes,
        child,
        many,
        heads_of(child, many, record, begin, reach),
        root,
        span[: len(groups)],
        wide,
        grid,
        shape,
        scale=np.ones(len(grid), dtype=np.float32),
        cell=np.zeros(nodes * EIGHT, dtype=np.uint16),
        near=np.full(nodes, -1, dtype=np.int32),
        patch=absent,
        triangle=absent.astype(np.float32),
        listed=absent,
        list_start=absent,
        solid_start=np.cumsum([0, *map(len, solids)]),
        solid_part=np.array([k for group in solids for k in group], dtype=np.int64),
        solid_root=bases[len(groups) :],
        solid_span=span[len(groups) :],
        solid_rank=np.array(
            [environment.part_start[[k, k + 1]] for group in solids for k in group]
        ).reshape(-1, 2),
    )
    square = np.zeros(nodes, dtype=np.float32)
    for g in range(len(grid)):
        rows = int(shape[g, 0] * shape[g, 1])
        group = g % len(groups)
        if root[group] >= 0:
            in_pieces(
                partial(_fill, (faces, shells, field, square), (g, group)),
                rows,
                max(rows // 32, 64),
            )
    pack_cells(field, square, shells)
    if not lists or len(groups) != 1 or root[0] < 0:
        return field
    return _listed(
        faces,
        field,
        patches_of((box, link), rank[polygons][item][: len(members[0])], (record, begin), reach),
    )


def _listed(faces: Faces, field: Field, patches: Patches) -> Field:
    """The field with its only group's patches, and their lists for each cell."""
    listed, start = cell_lists(faces, field, patches)
    triangle, off = rows_of(patches[0], field.record, field.begin, field.grid[0, :3])
    field.grid[0, 7] = SPARE * field.grid[0, 3] * field.shape[0, :3].sum() + 2.0 * off
    patch = patches[0].reshape(-1)
    return field._replace(
        patch=patch, triangle=triangle.reshape(-1), listed=listed, list_start=start
    )


def _fill(
    index: tuple[Faces, Shells, Field, NDArray[np.float32]],
    which: tuple[int, int],
    begin: int,
    end: int,
) -> None:
    fill_rows(
        *index,
        *which,
        np.empty(DEEP, dtype=np.int64),
        np.empty(DEEP + EIGHT, dtype=np.float32),
        begin,
        end,
    )


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
    """Grids (G + W, 8), shapes (G + W, 4) and wide (G,) for groups with boxes own (G, 6); wide ones
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
    grid[:, 6] = _faces(environment).off.max(initial=0.0)
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
    grid = np.zeros((len(boxes), 8))
    grid[:, :3] = 0.5 * (boxes[:, :3] + boxes[:, 3:]) - 0.5 * cell * (shape - 1.0)
    grid[:, 3] = cell
    grid[:, 4] = 1.0 / cell
    return grid, whole
