"""Turn the closed shells of a part outward, and find those that lie inside others or cross.

Places spread over every shell look along one fixed direction that is parallel to nothing in
particular. The signed crossings with a shell add up to the winding number of that shell about the
place [1]_. They say

1. which shells a shell lies in: the smallest of these is its parent;
2. whether it lies partly in another one, or partly in itself: then it crosses.

A shell in none is turned so that its volume is positive. A shell wound opposite to its parent is a
cavity of it, or a solid in its cavity; one wound like a solid parent is a solid within the solid,
and what they enclose counts once.

References
---------- .. [1] A. Jacobson, L. Kavan, O. Sorkine-Hornung (2013), Robust inside-outside
segmentation using generalized winding
   numbers, ACM Transactions on Graphics 32(4), 33.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.winding import HalfEdges, component_labels
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Shells", "shell_labels", "sorted_shells"]

_PLACES_ALONE = 200
"""About so many places are looked at on a shell of few faces that is the only one of its part."""
_PLACES = 1_000
"""About so many places are looked at in a part of several shells, or of many faces."""
_FEW = 200
"""Faces up to which a shell is first tried for being convex."""
_LEAST_PLACES = 4
"""Places looked at on the smallest shell."""
_COLUMNS = 64
"""Strips into which places are sorted for the search of the faces above them."""
_NEAR = 1e-9
"""A crossing nearer to the place or to an edge than this share of the part's size is in doubt: the
place is left out."""
_ALONG = np.array([0.5377, 0.3183, 0.7807]) / np.linalg.norm([0.5377, 0.3183, 0.7807])
"""The direction looked along."""
_SHALLOW = 1e-3
"""Shells that cross no deeper than this [m] do not count as crossing: rounding and faces glued
together do that."""


@dataclass(frozen=True, eq=False)
class Shells:
    """The closed shells of a part, and what is to be done about them."""

    inward: Bools
    """(T,) True for the faces of shells that are wound inside out."""
    turned: int
    """Shells wound inside out."""
    cavities: int
    """Shells that bound a cavity of another."""
    nested: int
    """Shells that lie inside another and are wound like it."""
    crossing: int
    """Shells that cross another or themselves."""


@dataclass(frozen=True, eq=False)
class _Places:
    """Q places on faces."""

    point: Floats
    """(Q, 3) in a frame whose z axis is the direction looked along."""
    face: Ints
    """(Q,) the face a place lies on, -1 beside the surface."""


@dataclass(frozen=True, eq=False)
class _Hits:
    """Crossings of the lines of sight with faces."""

    place: Ints
    face: Ints
    sign: Ints
    """+1 where the line leaves through the face, -1 where it enters, 0 where the crossing is in
    doubt."""


@dataclass(frozen=True, eq=False)
class _Turns:
    """Winding numbers of shells about places, those that are not zero."""

    key: Ints
    """Place and shell as one number, ascending."""
    place: Ints
    shell: Ints
    number: Ints
    sure: Bools
    """(Q,) False for places with a crossing in doubt."""


@dataclass(frozen=True, eq=False)
class _Containment:
    """Pairs of shells of which one lies in the other, at least partly; M shells."""

    inner: Ints
    outer: Ints
    share: Floats
    """Of the places looked at on the inner shell, the share that lies in the outer one; above 0."""
    partly: Bools
    """True where some places lie in it, and some outside, by more than `_SHALLOW`."""
    itself: Bools
    """(M,) shells that lie partly in themselves: near them their winding number is not only 0 and
    1."""


def shell_labels(halves: HalfEdges, patch: Ints, sense: Ints) -> Ints:
    """(T,) the shell of each face: patches, joined where one alone is not closed at an edge of more
    than two faces.

    patch (T,): connected through edges of two faces; sense (H,): of the half-edges after consistent
    winding.
    """
    crowded = np.flatnonzero(halves.uses[halves.edge] > 2)
    patches = int(patch.max(initial=-1)) + 1
    key = patch[halves.face[crowded]] * len(halves.uses) + halves.edge[crowded]
    pair, inverse = np.unique(key, return_inverse=True)
    open_pair = pair[np.bincount(inverse.reshape(-1), sense[crowded], len(pair)) != 0]
    edges, node = np.unique(open_pair % max(len(halves.uses), 1), return_inverse=True)
    joined = component_labels(
        open_pair // max(len(halves.uses), 1), patches + node.reshape(-1), patches + len(edges)
    )
    return np.unique(joined[patch], return_inverse=True)[1].reshape(-1).astype(np.int64)


def sorted_shells(vertices: Floats, faces: Ints, shell: Ints) -> Shells:
    """Find the shells to be turned, the cavities, and those that lie in others or cross.

    Parameters
    ----------
    vertices, faces
        A closed, consistently wound mesh: (V, 3) and (T, 3).
    shell
        (T,) the shell of each face, from 0.
    """
    count = int(shell.max(initial=-1)) + 1
    corner = vertices[faces] - vertices[faces].reshape(-1, 3).mean(axis=0)
    volume = np.bincount(
        shell, np.einsum("nc,nc->n", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6, count
    )
    sign = np.where(volume < 0, -1, 1)
    if count == 1 and _convex(corner):
        turned = bool(volume[0] < 0)
        return Shells(np.full(len(faces), turned), int(turned), 0, 0, 0)
    seen = corner @ _frame().T
    found = _containment(seen, shell, _spread(seen, shell), sign)
    parent = _parents(found, np.abs(volume))
    final = _final_signs(parent, sign, np.abs(volume))
    wrong = final != sign
    crossing = found.itself.copy()
    crossing[found.inner[found.partly]] = True
    crossing[found.outer[found.partly]] = True
    nested = (parent >= 0) & (final > 0) & (final[parent] > 0) & ~crossing
    return Shells(
        wrong[shell],
        int(wrong.sum()),
        int((final < 0).sum()),
        int(nested.sum()),
        int(crossing.sum()),
    )


def _parents(found: _Containment, size: Floats) -> Ints:
    """(M,) the smallest of the larger shells that hold most of a shell, -1 for none; size (M,): of
    the volumes."""
    rank = np.empty(len(size), dtype=np.int64)
    rank[np.argsort(-size, kind="stable")] = np.arange(len(size))
    holds = (found.share > 0.5) & (rank[found.outer] < rank[found.inner])
    inner = found.inner[holds]
    outer = found.outer[holds]
    order = np.lexsort((rank[outer], inner))
    parent = np.full(len(size), -1)
    parent[inner[order]] = outer[
        order
    ]  # the last one stays: of a repeated index numpy keeps the last value
    return parent


def _final_signs(parent: Ints, sign: Ints, size: Floats) -> Ints:
    """(M,) +1 for shells that bound a solid from outside, -1 for those that bound a cavity; sign
    (M,): as wound."""
    final = np.ones(len(sign), dtype=np.int64)
    for one in np.argsort(-size, kind="stable"):  # a parent comes before what it holds
        if parent[one] >= 0 and sign[one] != sign[parent[one]]:
            final[one] = -final[parent[one]]
    return final


def _convex(corner: Floats) -> bool:
    """True where no corner of few faces lies on the outer side of any: such a shell cannot cross
    itself."""
    if len(corner) > _FEW:
        return False
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    height = (
        np.einsum("tc,nc->tn", normal, corner.reshape(-1, 3))
        - np.einsum("tc,tc->t", normal, corner[:, 0])[:, None]
    )
    slack = _NEAR * np.linalg.norm(normal, axis=1) * np.ptp(corner.reshape(-1, 3), axis=0).max()
    return bool((height <= slack[:, None]).all() or (height >= -slack[:, None]).all())


def _frame() -> Floats:
    """(3, 3) rotation into a frame whose z axis is the direction looked along."""
    x = np.cross(_ALONG, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(_ALONG, x), _ALONG])


def _spread(corner: Floats, shell: Ints) -> _Places:
    """Places on faces: several on each of few, on every n-th of many."""
    total = len(shell)
    order = np.argsort(shell, kind="stable")
    size = np.bincount(shell)
    rank = np.arange(total) - np.repeat(np.cumsum(size) - size, size)
    wanted = np.clip(_PLACES * size // total, _LEAST_PLACES, size)
    step = np.maximum(size // np.maximum(wanted, 1), 1)
    chosen = order[rank % np.repeat(step, size) == 0]
    few = _PLACES if len(size) > 1 else _PLACES_ALONE
    repeats = int(np.clip(few // len(chosen), 1, 64))
    face = np.repeat(chosen, repeats)
    u, v = _plastic(repeats)
    weight = np.stack([1.0 - u - v, u, v], axis=1)
    point = np.einsum("nc,ncx->nx", np.tile(weight, (len(chosen), 1)), corner[face])
    return _Places(point, face)


def _plastic(count: int) -> tuple[Floats, Floats]:
    """Barycentric coordinates spread evenly over a triangle (Roberts's R2 sequence, folded), the
    centroid first."""
    n = np.arange(count)
    u = (1.0 / 3.0 + n * 0.7548776662466927) % 1.0
    v = (1.0 / 3.0 + n * 0.5698402909980532) % 1.0
    over = u + v > 1.0
    return np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)


def _containment(corner: Floats, shell: Ints, places: _Places, sign: Ints) -> _Containment:
    """Which shells lie in which, and in themselves; corner (T, 3, 3) as seen, sign (M,) of the
    shells' volumes."""
    count = len(sign)
    own = shell[places.face]
    edge = corner[places.face]
    normal = np.cross(edge[:, 1] - edge[:, 0], edge[:, 2] - edge[:, 0]) * sign[own, None]
    shift = _SHALLOW * normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    nowhere = np.full(len(own), -1)
    there = _turns(corner, shell, places)
    outward = _turns(corner, shell, _Places(places.point + shift, nowhere))
    inward = _turns(corner, shell, _Places(places.point - shift, nowhere))
    sure = there.sure
    in_other = own[there.place] != there.shell
    pair, index, many = np.unique(
        own[there.place[in_other]] * count + there.shell[in_other],
        return_inverse=True,
        return_counts=True,
    )
    deep = np.bincount(index.reshape(-1), np.isin(there.key, outward.key)[in_other], len(pair))
    near = np.setdiff1d(inward.key[sure[inward.place]], there.key)
    missed = np.isin(own[near // count] * count + near % count, pair)
    close = own[near[missed] // count] * count + near[missed] % count
    touched = many + np.bincount(np.searchsorted(pair, close), minlength=len(pair))
    looked = np.bincount(own[sure], minlength=count)[pair // count]
    itself = np.zeros(count, dtype=np.bool_)
    for turns in (outward, inward):
        mine = turns.shell[own[turns.place] == turns.shell]
        number = turns.number[own[turns.place] == turns.shell]
        itself[mine[number * sign[mine] != 1]] = True
    return _Containment(
        pair // count, pair % count, many / looked, (deep > 0) & (touched < looked), itself
    )


def _turns(corner: Floats, shell: Ints, places: _Places) -> _Turns:
    """The winding numbers of shells about places that are not zero; the face that a place lies on
    is left out."""
    count = int(shell.max()) + 1
    hits = _hits(corner, places)
    sure = np.ones(len(places.face), dtype=np.bool_)
    sure[hits.place[hits.sign == 0]] = False
    kept = sure[hits.place]
    key, inverse = np.unique(hits.place[kept] * count + shell[hits.face[kept]], return_inverse=True)
    number = np.bincount(inverse.reshape(-1), hits.sign[kept], len(key)).astype(np.int64)
    some = number != 0
    return _Turns(key[some], key[some] // count, key[some] % count, number[some], sure)


def _hits(corner: Floats, places: _Places) -> _Hits:
    """Crossings of the lines from the places along +z with all faces but their own.

    Places are sorted by strips of x, and by y within a strip; the places under a face are then runs
    in its strips.
    """
    x = places.point[:, 0]
    y = places.point[:, 1]
    left = x.min()
    right = x.max()
    width = max((right - left) / _COLUMNS, 1e-300)
    low = corner.min(axis=1)
    high = corner.max(axis=1)
    tall = 2.0 * float(max(high[:, 1].max() - low[:, 1].min(), 1e-300))
    base = low[:, 1].min()

    def column(values: Floats) -> Ints:
        strip: Ints = np.clip((values - left) / width, 0, _COLUMNS - 1).astype(np.int64)
        return strip

    key = column(x) * tall + (y - base)
    order = np.argsort(key, kind="stable")
    begin = column(low[:, 0])
    end = column(high[:, 0])
    strips = end - begin + 1
    face = np.repeat(np.arange(len(corner)), strips)
    strip = begin[face] + np.arange(len(face)) - np.repeat(np.cumsum(strips) - strips, strips)
    first = np.searchsorted(key[order], strip * tall + (low[face, 1] - base))
    last = np.searchsorted(key[order], strip * tall + (high[face, 1] - base), side="right")
    many = last - first
    face = np.repeat(face, many)
    place = order[
        np.repeat(first, many) + np.arange(len(face)) - np.repeat(np.cumsum(many) - many, many)
    ]
    box = (
        (x[place] >= low[face, 0])
        & (x[place] <= high[face, 0])
        & (places.point[place, 2] <= high[face, 2])
    )
    some = box & (face != places.face[place])
    return _crossed(corner, places.point, place[some], face[some])


def _crossed(corner: Floats, point: Floats, place: Ints, face: Ints) -> _Hits:
    """Those of the candidate pairs (place, face) that cross, or may."""
    size = float(np.ptp(corner.reshape(-1, 3), axis=0).max())
    a, b, c = (corner[face, k] - point[place] for k in range(3))
    side = np.stack([_turn(a, b), _turn(b, c), _turn(c, a)])
    reach = np.stack([_far(a, b), _far(b, c), _far(c, a)])
    near = _NEAR * size * reach
    out = (side > near).any(axis=0) & (side < -near).any(axis=0)
    place = place[~out]
    face = face[~out]
    side = side[:, ~out]
    near = near[:, ~out]
    area = side.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (side[0] * c[~out, 2] + side[1] * a[~out, 2] + side[2] * b[~out, 2]) / area
    doubt = (np.abs(side) <= near).any(axis=0) | ~(np.abs(height) > _NEAR * size)
    doubt &= ~(height < -_NEAR * size)
    above = doubt | (height > 0)
    sign = np.where(doubt, 0, np.sign(area)).astype(np.int64)
    return _Hits(place[above], face[above], sign[above])


def _turn(a: Floats, b: Floats) -> Floats:
    turn: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return turn


def _far(a: Floats, b: Floats) -> Floats:
    """The length of the edge from a to b as seen: its distance from the place is turn / length."""
    far: Floats = np.hypot(b[:, 0] - a[:, 0], b[:, 1] - a[:, 1])
    return far
