"""Unite the solids of a part: the depth of a point counts only faces of their union's surface.

A face of one solid that lies inside another bounds nothing, but would be nearest to a point beside
it: in a block modelled as two boxes that overlap, a point 166 mm deep would read 28 mm.
"""

from __future__ import annotations

from collections.abc import Iterator

import manifold3d
import numpy as np

from workbench.files.meshes.parts import RawPart, weld
from workbench.files.meshes.shells import OrientedShells
from workbench.geometry.components import component_labels
from workbench.model.arrays import Floats, Ints

__all__ = ["united"]

_BLOCK = 1_000
"""Boxes of solids that are compared with all others at a time."""
_GRID = 2.0**-34
"""Spacing [m] of the grid onto which corners of united solids are rounded, 0.06 nm: walls that touch
but for rounding shall leave no gap."""
_NEAR = 1e-9
"""Gap of two boxes, as a share of the part's size, up to which their solids may touch."""


def united(part: RawPart, shells: OrientedShells) -> tuple[RawPart, int]:
    """Replace solids of a part that overlap, touch or lie in each other by their union.

    Solids that are apart keep their faces. So do those whose own shells cross, since a union takes
    solids that don't.

    Parameters
    ----------
    part
        Closed, with its shells outward and its cavities inward.
    shells
        Which solid each face bounds.

    Returns
    -------
    tuple[RawPart, int]
        The part, and the number of solids that could not be united.
    """
    number, body = np.unique(shells.body, return_inverse=True)
    body = body.reshape(-1)
    left_out = shells.tangled[number].copy()
    faces = [part.faces]
    vertices = [part.vertices]
    gone = np.zeros(len(number), dtype=np.bool_)
    rounded = RawPart(part.name, np.round(part.vertices / _GRID) * _GRID, part.faces)
    of_solid = np.split(np.argsort(body, kind="stable"), np.cumsum(np.bincount(body))[:-1])
    for cluster in _clusters(part, body, len(number)):
        made = {k: _solid(rounded, of_solid[k]) for k in cluster[~left_out[cluster]]}
        sound = [k for k, one in made.items() if one.status() == manifold3d.Error.NoError]
        left_out[np.setdiff1d(cluster, sound)] = True
        whole = manifold3d.Manifold.batch_boolean([made[k] for k in sound], manifold3d.OpType.Add)
        if sum(one.volume() > 0 for one in whole.decompose()) == len(sound):
            continue  # all of them are apart
        mesh = whole.to_mesh64()
        faces.append(np.asarray(mesh.tri_verts, dtype=np.int64) + sum(map(len, vertices)))
        vertices.append(np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3])
        gone[sound] = True
    if not gone.any():
        return part, int(left_out.sum())
    faces[0] = part.faces[~gone[body]]
    mended = RawPart(part.name, *weld(np.concatenate(vertices), np.concatenate(faces)))
    return mended, int(left_out.sum())


def _solid(part: RawPart, chosen: Ints) -> manifold3d.Manifold:
    """The solid that some faces of a part bound."""
    points, corners = weld(part.vertices, part.faces[chosen])
    return manifold3d.Manifold(manifold3d.Mesh64(points, corners.astype(np.uint64)))


def _clusters(part: RawPart, body: Ints, count: int) -> Iterator[Ints]:
    """The solids of each group whose boxes touch, where it has more than one; body (T,): the solid
    of each face, from 0. Solids that are flat enclose nothing and belong to none."""
    if count < 2:
        return
    corner = part.vertices[part.faces]
    low = _by_solid(np.minimum, corner.min(axis=1), body)
    high = _by_solid(np.maximum, corner.max(axis=1), body)
    thick = np.flatnonzero((high > low).all(axis=1))
    slack = _NEAR * float((high - low).max())
    pairs = []
    for first in range(0, len(thick), _BLOCK):
        some = thick[first : first + _BLOCK]
        near = (low[some, None] <= high[thick] + slack) & (high[some, None] >= low[thick] - slack)
        pairs.append(np.argwhere(near.all(axis=2)) + np.array([first, 0]))
    one, other = np.concatenate([np.zeros((0, 2), dtype=np.int64), *pairs]).T
    label = component_labels(one, other, len(thick))
    order = np.argsort(label, kind="stable")
    for members in np.split(thick[order], np.flatnonzero(np.diff(label[order])) + 1):
        if len(members) > 1:
            yield members


def _by_solid(which: np.ufunc, rows: Floats, body: Ints) -> Floats:
    """The least or greatest (M, 3) of the rows (T, 3) of each solid."""
    order = np.argsort(body, kind="stable")
    start = np.flatnonzero(np.diff(body[order], prepend=-1))
    found: Floats = which.reduceat(rows[order], start, axis=0)
    return found
