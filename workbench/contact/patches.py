"""Patches of neighbouring polygons, and which of them hold all that may be nearest in each cell of
a grid."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from workbench.contact.kernels.field import Field
from workbench.contact.kernels.heads import heads_of
from workbench.contact.kernels.patches import fill_lists, nearest_points
from workbench.geometry.lanes import LANES
from workbench.geometry.polygon import Faces
from workbench.model.arrays import Floats, Ints
from workbench.threads import in_pieces

__all__ = ["Patches", "cell_lists", "patches_of"]

Patches = tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]
"""Ranks (B, LANES), box (B, 6) and head (B, LANES) of all of a patch."""


def patches_of(
    tree: tuple[Floats, Ints], ranks: Ints, record: tuple[Floats, Ints], reach: float
) -> Patches:
    """The patches of the first of the trees of `split_tree`, (box, link): its largest subtrees of
    up to eight leaves.

    ranks: of the first tree's polygons, in the order of its leaves; reach [m]: the greatest
    coordinate of all.
    """
    box, link = tree
    size = np.where(link[:, 2] <= len(ranks), link[:, 2] - link[:, 1], 0)
    inner = np.flatnonzero((link[:, 0] >= 0) & (size > LANES))
    tops = (
        np.concatenate([link[inner, 0], link[inner, 0] + 1])
        if len(inner)
        else np.flatnonzero(size)[:1]
    )
    tops = np.sort(tops[(size[tops] > 0) & (size[tops] <= LANES)])
    many = size[tops]
    lane = np.minimum(np.arange(LANES), many[:, None] - 1)
    patch = ranks[link[tops, 1][:, None] + lane].astype(np.int32)
    whole = np.arange(len(tops))
    over = np.resize(whole, (-(-len(tops) // LANES), LANES)).astype(np.int32)
    child = np.concatenate([-1 - patch, over])
    heads = heads_of(child, np.concatenate([many, np.full(len(over), LANES)]), *record, reach)
    of_all = heads[len(tops) :].transpose(0, 2, 1).reshape(-1, LANES)[: len(tops)]
    return patch, box[tops].astype(np.float32), np.ascontiguousarray(of_all)


def cell_lists(
    faces: Faces, field: Field, patches: Patches
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Field.listed and Field.list_start of the only group, made on all cores."""
    nodes = int(field.shape[0, :3].prod())
    points = np.empty((nodes, 3))
    in_pieces(partial(nearest_points, faces, field, 0, points), nodes, max(nodes // 16, 1024))
    start = np.full(nodes, -1, dtype=np.int32)
    across = (field.shape[0, :3] + 14) // 16
    found: dict[int, NDArray[np.int32]] = {}

    def work(begin: int, end: int) -> None:
        mine = np.full(nodes, -1, dtype=np.int32)
        found[begin] = fill_lists(field, 0, points, patches[1:], mine, begin, end)
        got[begin] = mine

    got: dict[int, NDArray[np.int32]] = {}
    blocks = int(across.prod())
    in_pieces(work, blocks, max(-(-blocks // 8), 1))
    first = 0
    for begin in sorted(found):
        mine = got[begin]
        np.copyto(start, mine + first, where=mine >= 0)
        first += len(found[begin])
    return np.concatenate([found[begin] for begin in sorted(found)]), start
