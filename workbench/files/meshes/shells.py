"""Orient the closed shells of a part outward, and find those that lie inside others or cross.

Rays start from sample points spread over every shell, all along one fixed direction that is
parallel to nothing in particular. The signed crossings of a ray with a shell add up to the winding
number of that shell about the point [1]_. The winding numbers show

1. which shells a shell lies in: the smallest of these is its parent;
2. whether it lies partly in another one, or partly in itself: then it crosses.

A shell without a parent is turned so that its volume is positive. A shell wound opposite to its
parent is a cavity of it, or a solid in its cavity. One wound like a solid parent is a solid within
the solid, and what they enclose counts once.

References
----------
.. [1] A. Jacobson, L. Kavan, O. Sorkine-Hornung (2013), Robust inside-outside segmentation using
   generalized winding numbers, ACM Transactions on Graphics 32(4), 33.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.winding import HalfEdges
from workbench.geometry.box_pairs import in_ranges
from workbench.geometry.components import component_labels
from workbench.geometry.sampling import even_places
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["OrientedShells", "one_shell", "orient_shells", "shell_labels"]

_SAMPLES_ALONE = 200
"""Approximate number of sample points on a shell of few faces that is the only one of its part."""
_SAMPLES = 1_000
"""Approximate number of sample points in a part of several shells, or of many faces."""
_MIN_SAMPLES = 4
"""Least number of sample points on a shell, if it has as many faces."""
_MAX_REPEATS = 64
"""Largest number of sample points on one face."""
_MAX_CONVEX_FACES = 200
"""Number of faces up to which a shell is first tested for being convex."""
_STRIPS = 64
"""Strips of x into which sample points are sorted for the search of the faces above them."""
_TOLERANCE = 1e-9
"""Distance of a crossing from its ray's start or from an edge, as a share of the part's size, below
which it is uncertain. Its sample point is left out."""
_RAY = np.array([0.5377, 0.3183, 0.7807]) / np.linalg.norm([0.5377, 0.3183, 0.7807])
"""Direction of the rays."""
_MIN_DEPTH = 1e-3
"""Depth [m] up to which shells may cross without being reported: rounding and faces glued together
cause that."""


@dataclass(frozen=True, eq=False)
class OrientedShells:
    """The closed shells of a part, and how they are to be turned."""

    inward: Bools
    """(T,) True for the faces of shells that are wound inside out."""
    turned: int
    """Number of shells wound inside out."""
    cavities: int
    """Number of shells that bound a cavity of another."""
    nested: int
    """Number of shells that lie inside another and are wound like it."""
    crossing: int
    """Number of shells that cross another or themselves."""
    body: Ints
    """(T,) the solid that each face bounds: the number of its outer shell, which its cavities
    have too."""
    tangled: Bools
    """(M,) True for solids whose own shells cross themselves or each other."""


@dataclass(frozen=True, eq=False)
class _Samples:
    """Q sample points, from which rays start."""

    point: Floats
    """(Q, 3) in a frame whose z axis is the direction of the rays."""
    face: Ints
    """(Q,) the face that a point lies on, -1 beside the surface."""


@dataclass(frozen=True, eq=False)
class _Candidates:
    """N pairs of a sample point and a face that its ray may cross."""

    sample: Ints
    face: Ints


@dataclass(frozen=True, eq=False)
class _Crossings:
    """Crossings of rays with faces."""

    sample: Ints
    face: Ints
    sign: Ints
    """+1 if the ray leaves through the face, -1 if it enters, 0 if the crossing is uncertain."""


@dataclass(frozen=True, eq=False)
class _WindingNumbers:
    """Winding numbers of shells about sample points, those that are not zero."""

    key: Ints
    """Sample and shell as one number, ascending."""
    sample: Ints
    shell: Ints
    number: Ints
    certain: Bools
    """(Q,) False for samples with an uncertain crossing."""


@dataclass(frozen=True, eq=False)
class _Containment:
    """Pairs of shells of which one lies in the other, at least partly; M shells."""

    inner: Ints
    outer: Ints
    share: Floats
    """Share of the samples of the inner shell that lie in the outer one; above 0."""
    partly: Bools
    """Whether some samples lie in it, and some outside, by more than `_MIN_DEPTH`."""
    self_crossing: Bools
    """(M,) whether a shell lies partly in itself: near it its winding number is not only 0 and 1."""

    def crossing(self) -> Bools:
        """Return which shells (M,) cross themselves or another one."""
        crossing = self.self_crossing.copy()
        crossing[self.inner[self.partly]] = True
        crossing[self.outer[self.partly]] = True
        return crossing

    def tangled(self, body: Ints) -> Bools:
        """Return which solids (M,) have a shell that crosses itself or another of the solid's own;
        body (M,): the solid of each shell."""
        tangled = np.zeros(len(body), dtype=np.bool_)
        tangled[body[self.self_crossing]] = True
        own = self.partly & (body[self.inner] == body[self.outer])
        tangled[body[self.inner[own]]] = True
        return tangled


def shell_labels(halves: HalfEdges, patch: Ints, sense: Ints) -> Ints:
    """Join patches into shells, where one alone is not closed at an edge of more than two faces.

    Parameters
    ----------
    halves
        Half-edges of T faces.
    patch
        (T,) the patch of each face, connected through edges of two faces.
    sense
        (H,) of the half-edges after consistent winding.

    Returns
    -------
    Ints
        (T,) the shell of each face.
    """
    crowded = np.flatnonzero(halves.uses[halves.edge] > 2)
    patches = int(patch.max(initial=-1)) + 1
    edge_count = max(len(halves.uses), 1)
    key = patch[halves.face[crowded]] * len(halves.uses) + halves.edge[crowded]
    pair, inverse = np.unique(key, return_inverse=True)
    open_pair = pair[np.bincount(inverse.reshape(-1), sense[crowded], len(pair)) != 0]
    edges, node = np.unique(open_pair % edge_count, return_inverse=True)
    joined = component_labels(
        open_pair // edge_count, patches + node.reshape(-1), patches + len(edges)
    )
    shell = np.unique(joined[patch], return_inverse=True)[1].reshape(-1).astype(np.int64)
    return _divided(halves, shell, sense) if len(crowded) else shell


def _divided(halves: HalfEdges, shell: Ints, sense: Ints) -> Ints:
    """Divide shells (T,) at edges of more than two faces where the order of the faces tells them
    apart.

    A file lists one solid after the other. Every undirected edge has a random number, added for one
    sense and subtracted for the other: after the last face of a closed shell the sum is zero.
    """
    total = np.zeros(len(shell), dtype=np.uint64)
    number = np.random.default_rng(0).integers(2**64, size=len(halves.uses), dtype=np.uint64)
    signed = np.where(sense > 0, number[halves.edge], np.uint64(0) - number[halves.edge])
    np.add.at(total, halves.face, signed)
    run = np.cumsum(np.append(0, np.cumsum(total) == 0)[:-1])
    divided = np.unique(shell * len(shell) + run, return_inverse=True)[1].reshape(-1)
    # a run may hold half of a shell that another run completes
    pair = divided[halves.face] * len(halves.uses) + halves.edge
    one, inverse = np.unique(pair, return_inverse=True)
    closed = not np.bincount(inverse.reshape(-1), sense, len(one)).any()
    return divided.astype(np.int64) if closed else shell


def orient_shells(vertices: Floats, faces: Ints, shell: Ints) -> OrientedShells:
    """Find the shells to be turned, the cavities, and those that lie in others or cross.

    Parameters
    ----------
    vertices, faces
        A closed, consistently wound mesh: (V, 3) [m] and (T, 3).
    shell
        (T,) the shell of each face, from 0.
    """
    corner = vertices[faces] - vertices[faces].reshape(-1, 3).mean(axis=0)
    volume = _volumes(corner, shell)
    if len(volume) == 1 and _is_convex(corner):
        return one_shell(len(faces), inward=bool(volume[0] < 0))
    sign = np.where(volume < 0, -1, 1)
    seen = corner @ _ray_frame().T
    containment = _containment(seen, shell, _sample_points(seen, shell), sign)
    parent = _parents(containment, np.abs(volume))
    final = _final_signs(parent, sign, np.abs(volume))
    wrong = final != sign
    crossing = containment.crossing()
    nested = (parent >= 0) & (final > 0) & (final[parent] > 0) & ~crossing
    body = np.where(final > 0, np.arange(len(final)), parent)
    return OrientedShells(
        wrong[shell],
        turned=int(wrong.sum()),
        cavities=int((final < 0).sum()),
        nested=int(nested.sum()),
        crossing=int(crossing.sum()),
        body=body[shell],
        tangled=containment.tangled(body),
    )


def one_shell(faces: int, *, inward: bool) -> OrientedShells:
    """Return what is said of the single sound shell of so many faces."""
    return OrientedShells(
        np.full(faces, inward),
        turned=int(inward),
        cavities=0,
        nested=0,
        crossing=0,
        body=np.zeros(faces, dtype=np.int64),
        tangled=np.zeros(1, dtype=np.bool_),
    )


def _volumes(corner: Floats, shell: Ints) -> Floats:
    """Return the volume (M,) [m3] of each shell of faces (T, 3, 3), negative if wound inside out:
    the sum of its tetrahedra a . (b x c) / 6 about the origin."""
    tetrahedra = np.einsum("nc,nc->n", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6
    count = int(shell.max(initial=-1)) + 1
    return np.bincount(shell, tetrahedra, count).astype(np.float64)


def _parents(containment: _Containment, volume: Floats) -> Ints:
    """Return the parent (M,) of each shell, -1 for none: the smallest of the larger shells that
    hold most of it."""
    rank = np.empty(len(volume), dtype=np.int64)
    rank[np.argsort(-volume, kind="stable")] = np.arange(len(volume))
    holds = (containment.share > 0.5) & (rank[containment.outer] < rank[containment.inner])
    inner = containment.inner[holds]
    outer = containment.outer[holds]
    order = np.lexsort((rank[outer], inner))
    parent = np.full(len(volume), -1)
    parent[inner[order]] = outer[order]  # of a repeated index numpy keeps the last value
    return parent


def _final_signs(parent: Ints, sign: Ints, volume: Floats) -> Ints:
    """Return +1 (M,) for shells that bound a solid from outside, -1 for those that bound a cavity.

    sign (M,): of the volumes as wound.
    """
    final = np.ones(len(sign), dtype=np.int64)
    for shell in np.argsort(-volume, kind="stable"):  # a parent comes before what it holds
        if parent[shell] >= 0 and sign[shell] != sign[parent[shell]]:
            final[shell] = -final[parent[shell]]
    return final


def _is_convex(corner: Floats) -> bool:
    """Return whether no corner of few faces (T, 3, 3) lies on the outer side of any face.

    Such a shell cannot cross itself.
    """
    if len(corner) > _MAX_CONVEX_FACES:
        return False
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    points = corner.reshape(-1, 3)
    offset = np.einsum("tc,tc->t", normal, corner[:, 0])
    height = np.einsum("tc,nc->tn", normal, points) - offset[:, None]
    slack = _TOLERANCE * np.linalg.norm(normal, axis=1) * np.ptp(points, axis=0).max()
    return bool((height <= slack[:, None]).all() or (height >= -slack[:, None]).all())


def _ray_frame() -> Floats:
    """Return the rotation (3, 3) into a frame whose z axis is the direction of the rays."""
    x = np.cross(_RAY, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(_RAY, x), _RAY])


def _sample_points(corner: Floats, shell: Ints) -> _Samples:
    """Spread sample points over faces (T, 3, 3): several on each of few faces, or one on every n-th
    of many."""
    total = len(shell)
    order = np.argsort(shell, kind="stable")
    size = np.bincount(shell)
    rank, _ = in_ranges(np.zeros_like(size), size)  # within its shell
    wanted = np.clip(_SAMPLES * size // total, _MIN_SAMPLES, size)
    step = np.maximum(size // np.maximum(wanted, 1), 1)
    chosen = order[rank % np.repeat(step, size) == 0]
    least = _SAMPLES if len(size) > 1 else _SAMPLES_ALONE
    repeats = int(np.clip(least // len(chosen), 1, _MAX_REPEATS))
    face = np.repeat(chosen, repeats)
    weight = np.tile(_barycentric_sequence(repeats), (len(chosen), 1))
    return _Samples(np.einsum("nc,ncx->nx", weight, corner[face]), face)


def _barycentric_sequence(count: int) -> Floats:
    """Return barycentric coordinates (count, 3) spread evenly over a triangle, the centroid first."""
    u, v = even_places(count, 1.0 / 3.0)
    return np.stack([1.0 - u - v, u, v], axis=1)


def _containment(corner: Floats, shell: Ints, samples: _Samples, sign: Ints) -> _Containment:
    """Find which shells lie in which, and which in themselves.

    Parameters
    ----------
    corner, shell
        (T, 3, 3) faces in the frame of the rays, and the shell (T,) of each.
    samples
        Points on the faces.
    sign
        (M,) of the volume of each shell.
    """
    own = shell[samples.face]
    here = _winding_numbers(corner, shell, samples)
    outward, inward = (
        _winding_numbers(corner, shell, shifted)
        for shifted in _shifted_samples(corner[samples.face], samples, sign[own])
    )
    count = len(sign)
    in_other = own[here.sample] != here.shell
    pair, index, inside = np.unique(
        own[here.sample[in_other]] * count + here.shell[in_other],
        return_inverse=True,
        return_counts=True,
    )
    deep = np.bincount(index.reshape(-1), np.isin(here.key, outward.key)[in_other], len(pair))
    touched = inside + _shallow(here, inward, own, pair, count)
    total = np.bincount(own[here.certain], minlength=count)[pair // count]
    return _Containment(
        pair // count,
        pair % count,
        share=inside / total,
        partly=(deep > 0) & (touched < total),
        self_crossing=_self_crossing((outward, inward), own, sign),
    )


def _shallow(
    here: _WindingNumbers, inward: _WindingNumbers, own: Ints, pair: Ints, count: int
) -> Ints:
    """Count the samples (K,) of each pair of shells that come to lie in the other one only if they
    are shifted inward.

    Parameters
    ----------
    here, inward
        Winding numbers about the samples, and about the shifted samples.
    own
        (Q,) the shell of each sample.
    pair
        (K,) the pairs, each the inner shell times `count` plus the outer one, ascending.
    count
        The number of shells.
    """
    key = np.setdiff1d(inward.key[here.certain[inward.sample]], here.key)
    shallow = own[key // count] * count + key % count
    shallow = shallow[np.isin(shallow, pair)]
    return np.bincount(np.searchsorted(pair, shallow), minlength=len(pair))


def _shifted_samples(face: Floats, samples: _Samples, sign: Ints) -> tuple[_Samples, _Samples]:
    """Return the samples moved outward and inward by `_MIN_DEPTH`; face (Q, 3, 3): where they lie."""
    normal = np.cross(face[:, 1] - face[:, 0], face[:, 2] - face[:, 0]) * sign[:, None]
    shift = _MIN_DEPTH * normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    nowhere = np.full(len(sign), -1)
    return _Samples(samples.point + shift, nowhere), _Samples(samples.point - shift, nowhere)


def _self_crossing(beside: tuple[_WindingNumbers, ...], own: Ints, sign: Ints) -> Bools:
    """Return which shells (M,) have a winding number other than 0 and 1 beside their surface."""
    crossing = np.zeros(len(sign), dtype=np.bool_)
    for winding in beside:
        of_itself = own[winding.sample] == winding.shell
        shell = winding.shell[of_itself]
        crossing[shell[winding.number[of_itself] * sign[shell] != 1]] = True
    return crossing


def _winding_numbers(corner: Floats, shell: Ints, samples: _Samples) -> _WindingNumbers:
    """Return the winding numbers of shells about samples that are not zero; the face that a sample
    lies on does not count."""
    count = int(shell.max()) + 1
    crossings = _crossings(corner, samples.point, _ray_candidates(corner, samples))
    certain = np.ones(len(samples.face), dtype=np.bool_)
    certain[crossings.sample[crossings.sign == 0]] = False
    kept = certain[crossings.sample]
    key, inverse = np.unique(
        crossings.sample[kept] * count + shell[crossings.face[kept]], return_inverse=True
    )
    total = np.bincount(inverse.reshape(-1), crossings.sign[kept], len(key)).astype(np.int64)
    key = key[total != 0]
    return _WindingNumbers(key, key // count, key % count, total[total != 0], certain)


def _ray_candidates(corner: Floats, samples: _Samples) -> _Candidates:
    """Find the faces (T, 3, 3) whose bounding box the ray of a sample along +z meets, except its
    own.

    Samples are sorted by strips of x, and by y within a strip. The samples under a face are then
    one run in each of its strips.
    """
    point = samples.point
    low = corner.min(axis=1)
    high = corner.max(axis=1)
    strips = _strips_of(point[:, 0], low[:, 1].min(), high[:, 1].max())
    key = strips.key(strips.of(point[:, 0]), point[:, 1])
    order = np.argsort(key, kind="stable")
    strip, face = in_ranges(strips.of(low[:, 0]), strips.of(high[:, 0]) + 1)
    first = np.searchsorted(key[order], strips.key(strip, low[face, 1]))
    last = np.searchsorted(key[order], strips.key(strip, high[face, 1]), side="right")
    place, run = in_ranges(first, last)
    face = face[run]
    sample = order[place]
    x = point[sample, 0]
    meets = (x >= low[face, 0]) & (x <= high[face, 0])
    meets &= (point[sample, 2] <= high[face, 2]) & (face != samples.face[sample])
    return _Candidates(sample[meets], face[meets])


def _strips_of(x: Floats, bottom: float, top: float) -> _Strips:
    """Return strips that hold samples with these x (Q,), and y from bottom to top."""
    left = x.min()
    return _Strips(
        left=left,
        width=max((x.max() - left) / _STRIPS, 1e-300),
        bottom=bottom,
        height=2.0 * float(max(top - bottom, 1e-300)),
    )


@dataclass(frozen=True)
class _Strips:
    """Strips of x, `width` wide from `left`; y from `bottom`, less than `height` above it."""

    left: float
    width: float
    bottom: float
    height: float

    def of(self, x: Floats) -> Ints:
        """Return the strip (N,) of each x, the outermost ones for what lies outside."""
        return np.clip((x - self.left) / self.width, 0, _STRIPS - 1).astype(np.int64)

    def key(self, strip: Ints, y: Floats) -> Floats:
        """Return numbers (N,) that rise with the strip, and with y within a strip."""
        return strip * self.height + (y - self.bottom)


def _crossings(corner: Floats, point: Floats, candidates: _Candidates) -> _Crossings:
    """Return the candidates whose ray crosses the face, or may cross it.

    With corners a, b, c from the sample, the 2D cross products a x b, b x c, c x a are twice the
    areas that the ray's foot spans with each edge. The ray crosses if all have one sign; its
    height is the mean of the corners' z with these weights.

    Parameters
    ----------
    corner, point
        (T, 3, 3) faces and (Q, 3) samples.
    candidates
        Pairs of them.
    """
    slack = _TOLERANCE * float(np.ptp(corner.reshape(-1, 3), axis=0).max())
    a, b, c = (corner[candidates.face, k] - point[candidates.sample] for k in range(3))
    edges = ((a, b), (b, c), (c, a))
    side = np.stack([_cross_2d(start, end) for start, end in edges])
    near = slack * np.stack([_length_2d(start, end) for start, end in edges])
    kept = ~((side > near).any(axis=0) & (side < -near).any(axis=0))
    side = side[:, kept]
    area = side.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (side[0] * c[kept, 2] + side[1] * a[kept, 2] + side[2] * b[kept, 2]) / area
    uncertain = (np.abs(side) <= near[:, kept]).any(axis=0) | ~(np.abs(height) > slack)
    uncertain &= ~(height < -slack)
    sign = np.where(uncertain, 0, np.sign(area)).astype(np.int64)
    above = uncertain | (height > 0)
    rows = np.flatnonzero(kept)[above]
    return _Crossings(candidates.sample[rows], candidates.face[rows], sign[above])


def _cross_2d(a: Floats, b: Floats) -> Floats:
    """Return the z component (N,) of a x b."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _length_2d(a: Floats, b: Floats) -> Floats:
    """Return the length (N,) of the edge from a to b across the rays: `_cross_2d` divided by it is
    the distance of the edge from the ray."""
    return np.hypot(b[:, 0] - a[:, 0], b[:, 1] - a[:, 1])
