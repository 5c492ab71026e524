"""Markers on a subject to poses of a body: joint angles by least squares on the whole chain, with
the residuals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.motion import Markers
from workbench.model.poses import Poses
from workbench.model.quaternions import matrices
from workbench.motion.recorded.marker_names import Site, marker_site
from workbench.motion.recorded.marker_places import marker_places
from workbench.posture.kernels.markers import MarkerChain, solve_markers

__all__ = ["MarkerFit", "bridged", "poses_from_markers"]

_UNIT = 0.010
"""[m] What a marker's distance is measured in: a joint at half its range costs as much as one
marker this far off."""
_NEAR = 0.025
_ROUNDS = 6
_SAMPLE = 40
_LEAST_HALF = np.radians(2.0)
_LEAST_MARKERS = 6


@dataclass(frozen=True, eq=False, repr=False)
class MarkerFit:
    """Poses that fit markers. markers: those used; residual (P, M) [m]: how far each lies from
    where the body carries it, NaN where it was not seen; unused: markers whose place on the body is
    not known; notes: what was assumed."""

    poses: Poses
    markers: tuple[str, ...]
    residual: Floats
    unused: tuple[str, ...]
    notes: tuple[str, ...]


def bridged(markers: Markers, *, longest: float) -> Markers:
    """The markers with gaps of at most `longest` [s] filled by straight lines; longer ones stay
    gaps.

    A gap's length is the time between the frames on both sides of it. UsageError for a negative
    length.
    """
    if not longest >= 0:
        raise UsageError(f"gaps can be bridged up to a length of 0 s or more, got {longest:g}")
    position = np.array(markers.position)
    time = markers.time
    for m in range(position.shape[1]):
        seen = np.flatnonzero(np.isfinite(position[:, m]).all(axis=1))
        for before, after in pairwise(seen):
            if after > before + 1 and time[after] - time[before] <= longest:
                share = (time[before + 1 : after] - time[before]) / (time[after] - time[before])
                ends = position[before, m], position[after, m]
                position[before + 1 : after, m] = ends[0] + share[:, None] * (ends[1] - ends[0])
    return Markers(markers.names, position, time, markers.file, markers.notes)


def poses_from_markers(
    body: Body, markers: Markers, *, names: Mapping[str, str] | None = None
) -> MarkerFit:
    """Poses of a body with the paper's joints that carry markers where they were seen.

    names: for markers of unusual names the usual one ({"hip1": "LASI"}), "" to leave one out. First
    the places of the markers on the body are found from some 40 frames, each allowed to lie as far
    from where its name says as such markers do; then every frame is solved, from the one before.
    Weighted least squares on the whole chain (Lu & O'Connor 1999), joints held softly within their
    range. InputError where fewer than six markers are known, or the pelvis has fewer than three in
    any frame.
    """
    sites, unused = _known(markers, dict(names or {}))
    columns = [markers.names.index(name) for name in sites]
    mirror = _mirrored(markers.position[:, columns], list(sites.values()))
    seen = markers.position[:, columns] * np.array([1.0, -1.0 if mirror else 1.0, 1.0])
    order, parent = _order(body)
    segment = np.array([order.index(body.segment(site.segment)) for site in sites.values()])
    local, spread = marker_places(body, sites)
    chain = _chain(body, (order, parent), segment, (local, spread))
    _refuse(markers, seen)
    sample = seen[np.unique(np.linspace(0, len(seen) - 1, _SAMPLE).astype(np.int64))]
    begin = _begun(body, (order, segment), local, sample)
    for _ in range(_ROUNDS):
        solved = _solved(sample, chain, begin)
        begin = solved.rotations[0], solved.turns[0], solved.places[0]
        chain = chain._replace(local=_moved(sample, chain, solved, (local, spread)))
    whole = _solved(seen, chain, begin)
    residual = np.linalg.norm(seen - whole.modelled, axis=-1)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(seen), len(body.joints), 1))
    for k, n in enumerate(order[1:], start=1):
        rotations[:, n - 1] = whole.rotations[:, k]
    rotations[:, order[0] - 1] = whole.turns
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    poses = Poses(rotations, order[0], whole.places, markers.time)
    notes = (
        ("the file's axes are left-handed, or left and right are exchanged in it: mirrored (y)",)
        if mirror
        else ()
    )
    return MarkerFit(poses, tuple(sites), residual, unused, markers.notes + notes)


@dataclass(frozen=True, eq=False)
class _Solved:
    rotations: Floats
    turns: Floats
    places: Floats
    modelled: Floats


def _solved(seen: Floats, chain: MarkerChain, begin: tuple[Floats, Floats, Floats]) -> _Solved:
    """Every frame solved, the first from `begin`: rotations (K, 4), turn (4,) and place (3, 4) of
    the pelvis."""
    frames = len(seen)
    arrays = [np.repeat(start[None], frames, axis=0) for start in begin]
    modelled = np.empty((frames, seen.shape[1], 3))
    solve_markers(np.ascontiguousarray(seen), chain, *arrays, modelled)
    return _Solved(arrays[0], arrays[1], arrays[2], modelled)


def _known(markers: Markers, names: dict[str, str]) -> tuple[dict[str, Site], tuple[str, ...]]:
    """The site of each marker that has one, and the others; each site once."""
    for name in names:
        if name not in markers.names:
            raise InputError(f"{markers.file}: no marker {name!r}; {one_of(name, markers.names)}")
    sites: dict[str, Site] = {}
    unused = []
    for m, name in enumerate(markers.names):
        usual = names.get(name, name)
        site = marker_site(usual) if usual else None
        if name in names and usual and site is None:
            raise InputError(
                f"{markers.file}: marker {name!r}: no usual marker is called {usual!r} (LASI, RKNE, C7, ...)"
            )
        if site is None or not np.isfinite(markers.position[:, m]).any():
            unused.append(name)
        else:
            sites[name] = site
    if len(sites) < _LEAST_MARKERS:
        raise InputError(
            f"{markers.file}: {len(sites)} markers are known by name, {_LEAST_MARKERS} or more are "
            f"needed; name the others (map: {{{(unused or ['X'])[0]}: LASI}}): "
            f"{', '.join(unused[:40])}"
        )
    return sites, tuple(unused)


def _mirrored(seen: Floats, sites: list[Site]) -> bool:
    """True where left markers lie on the right: seen from behind, by the pelvis, else by the
    feet."""
    for segments in (("LT",), ("LF", "RF")):
        groups = [
            [m for m, site in enumerate(sites) if site.segment in segments and test(site)]
            for test in (
                lambda s: s.side == "L",
                lambda s: s.side == "R",
                lambda s: "front" in s.toward,
                lambda s: "back" in s.toward,
            )
        ]
        if all(groups):
            left, right, front, back = (_mean(seen[:, group], 1) for group in groups)
            turn = np.cross(front - back, left - right)[:, 2]
            if np.isfinite(turn).any():
                return bool(np.nanmedian(turn) < 0)
    return False


def _refuse(markers: Markers, seen: Floats) -> None:
    visible = np.isfinite(seen).all(axis=-1).sum(axis=1)
    if visible[0] < 3:
        first = np.flatnonzero(visible >= 3)
        hint = f"begin at {markers.time[first[0]]:g} s" if len(first) else "no frame shows three"
        raise InputError(
            f"{markers.file}: the first frame shows {visible[0]} known markers, 3 are needed: {hint}"
        )


def _order(body: Body) -> tuple[list[int], Ints]:
    """The segments from the pelvis on, as indices of the body, and the place of each one's parent
    in that list."""
    pelvis = body.segment("LT")
    order = [pelvis]
    for n in range(pelvis + 1, len(body.segments)):
        if int(body.parent[n]) in order:
            order.append(n)
    return order, np.array(
        [0, *(order.index(int(body.parent[n])) for n in order[1:])], dtype=np.int64
    )


def _chain(
    body: Body, tree: tuple[list[int], Ints], segment: Ints, usual: tuple[Floats, Floats]
) -> MarkerChain:
    """The pelvis and all below it as a chain; markers that sit loosely count less."""
    (order, parent), (local, spread) = tree, usual
    joints = [n - 1 for n in order]
    limits = body.stops.limits[joints]
    half = np.maximum(0.5 * np.abs(limits).sum(axis=-1), _LEAST_HALF)
    weight = 1.0 / (_UNIT * np.clip(spread / _NEAR, 0.7, 2.0))
    ends = body.joint_in_parent[0, joints], body.joint_in_child[0, joints]
    return MarkerChain(parent, *ends, body.stops.axes[joints].copy(), half, segment, local, weight)


def _begun(
    body: Body, tree: tuple[list[int], Ints], local: Floats, seen: Floats
) -> tuple[Floats, Floats, Floats]:
    """A first guess: the zero pose laid over the markers that are seen, upright (Kabsch 1976, about
    the vertical)."""
    order, segment = tree
    at = np.zeros((len(order), 3))
    for k, n in enumerate(order[1:], start=1):
        parent = order.index(int(body.parent[n]))
        at[k] = at[parent] + body.joint_in_parent[0, n - 1] - body.joint_in_child[0, n - 1]
    own = at[segment] + local
    visible = _visible(seen[0])
    a = own[visible]
    b = seen[0][visible]
    a0 = a.mean(axis=0)
    b0 = b.mean(axis=0)
    one = (a - a0)[:, :2]
    two = (b - b0)[:, :2]
    angle = np.arctan2(np.sum(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]), np.sum(one * two))
    c = np.cos(angle)
    s = np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    place = np.concatenate([turn, (b0 - turn @ a0)[:, None]], axis=1)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(order), 1))
    return rotations, np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]), place


def _mean(values: Floats, axis: int) -> Floats:
    """Mean along an axis of what was seen; NaN where nothing was."""
    count = np.isfinite(values).sum(axis=axis)
    return np.asarray(
        np.where(count > 0, np.nansum(values, axis=axis) / np.maximum(count, 1), np.nan)
    )


def _visible(frame: Floats) -> Bools:
    return np.asarray(np.isfinite(frame).all(axis=-1))


def _moved(
    seen: Floats, chain: MarkerChain, solved: _Solved, usual: tuple[Floats, Floats]
) -> Floats:
    """(M, 3) better places of the markers in their segments: between the usual one and the mean of
    those seen."""
    local, spread = usual
    world = _frames(chain, solved)[:, chain.marker_segment]
    own = np.einsum("pmji,pmj->pmi", world[..., :3], seen - world[..., 3])
    count = _visible(own).sum(axis=0)
    mean = np.where(count[:, None] > 0, _mean(own, 0), local)
    trust = (count / (count + (_UNIT / spread) ** 2 * 4.0))[:, None]
    shift = trust * (mean - local)
    size = np.linalg.norm(shift, axis=1, keepdims=True)
    return np.asarray(
        local + shift * np.minimum(1.0, 2.0 * spread[:, None] / np.maximum(size, 1e-12))
    )


def _frames(chain: MarkerChain, solved: _Solved) -> Floats:
    """(P, K, 3, 4) world from segment."""
    world = np.empty((len(solved.turns), len(chain.parent), 3, 4))
    world[:, 0] = solved.places
    for k in range(1, len(chain.parent)):
        above = world[:, chain.parent[k]]
        world[:, k, :, :3] = above[..., :3] @ matrices(solved.rotations[:, k])
        joint = above[..., 3] + above[..., :3] @ chain.at_parent[k]
        world[:, k, :, 3] = joint - world[:, k, :, :3] @ chain.at_child[k]
    return world
