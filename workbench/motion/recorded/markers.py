"""Solve poses of a body from the markers on a subject.

Joint angles are the weighted least-squares solution for the whole body in each frame [1]_. The
places of the markers on the body are estimated first, from a sample of the frames.

References
----------
.. [1] T.-W. Lu & J. J. O'Connor (1999), Bone position estimation from skin marker co-ordinates
   using global optimisation with joint constraints, Journal of Biomechanics 32, 129-134.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.motion import Markers
from workbench.model.poses import Poses
from workbench.model.quaternions import matrices, multiply
from workbench.motion.recorded.marker_names import USUAL_SPREAD, Site, named_sites
from workbench.motion.recorded.skeleton import IDENTITY
from workbench.motion.recorded.subject_scaling import marker_places
from workbench.posture.kernels.marker_tracking import MarkerChain, solve_markers
from workbench.posture.reaching.reach_solver import on_grid
from workbench.posture.stops import nearest_legal, packed_stops

__all__ = ["MarkerFit", "bridged", "poses_from_markers"]

_UNIT = 0.010
"""Distance [m] of a marker that costs as much as a joint at half its range."""
_ROUNDS = 6
"""Alternations between solving the sample and moving the markers on the body."""
_SAMPLE = 40
"""Frames from which the places of the markers are estimated."""
_PLACE_TRUST = 4.0
"""Weight of a marker's usual place, in observations, if its spread is _UNIT."""
_MAX_SHIFT = 2.0
"""Greatest shift of a marker from its usual place, in spreads."""
_MIN_HALF_RANGE = np.radians(2.0)
"""Least half range [rad] of a joint angle, for those that hardly move."""
_STOP_ROUNDS = 6
"""Times at most that all joints are turned back to their stops."""
_AT_STOP = 1e-12
"""Change of a quaternion below which a joint is at its stop."""
_MIN_MARKERS = 6
_MIN_OUTLIER = 0.05
"""Root mean square distance [m] up to which no marker is left out: those near joints of clothed people
reach 0.03."""
_OUTLIER_DEVIATIONS = 6.0
"""Standard deviations beyond the median at which a marker is left out."""
_MAX_LEFT_OUT = 0.25
"""Greatest share of the known markers that may be left out."""
_MAX_RMS = 0.08
"""Root mean square distance [m] of all markers beyond which a motion is refused: some five times that
of measured people."""
_NAMED = 5
"""Number of the worst markers that a refusal names."""


@dataclass(frozen=True, eq=False, repr=False)
class MarkerFit:
    """Poses that fit markers."""

    poses: Poses
    markers: tuple[str, ...]
    """The M markers used."""
    residual: Floats
    """(P, M) distance [m] of each marker from where the body carries it, NaN where it is hidden."""
    unused: tuple[str, ...]
    """Markers whose place on the body is unknown, that no frame shows, or that lie far off."""
    notes: tuple[str, ...]
    """What was assumed, in sentences."""


def bridged(markers: Markers, *, longest: float) -> Markers:
    """Fill short gaps in the paths of markers by linear interpolation.

    Parameters
    ----------
    longest
        Greatest time [s] between the frames on both sides of a gap. Longer gaps stay.

    Raises
    ------
    UsageError
        If `longest` is negative.
    """
    if not longest >= 0:
        raise UsageError(f"gaps can be bridged up to a length of 0 s or more, got {longest:g}")
    position = np.array(markers.position)
    for m in range(position.shape[1]):
        seen = np.flatnonzero(_visible(position[:, m]))
        for before, after in pairwise(seen):
            duration = markers.time[after] - markers.time[before]
            if after > before + 1 and duration <= longest:
                gap = slice(before + 1, after)
                share = (markers.time[gap] - markers.time[before]) / duration
                way = position[after, m] - position[before, m]
                position[gap, m] = position[before, m] + share[:, None] * way
    return Markers(markers.names, position, markers.time, markers.file, markers.notes)


def poses_from_markers(
    body: Body, markers: Markers, *, names: Mapping[str, str] | None = None
) -> MarkerFit:
    """Solve the poses of a body that carries markers where they were seen.

    1. Solve some 40 frames with the markers at their usual places on the body.
    2. Move each marker on the body toward where the frames show it, by no more than its spread
       allows. Repeat both steps.
    3. Solve every frame, starting from the one before. Joints are drawn to their mid-range by a
       weak quadratic cost, and back from beyond their stops by a stiff one.
    4. Turn joints that are still past a stop to it.
    5. Leave out the marker that lies farthest beyond the others, and repeat everything.

    Parameters
    ----------
    body
        A body with the paper's joints.
    markers
        Positions (P, M, 3) [m], NaN where a marker is hidden.
    names
        The usual name of markers with unusual ones ({"hip1": "LASI"}), "" to leave a marker out;
        "Bob:*" stands for all that begin so.

    Raises
    ------
    InputError
        If markers of several people are there, fewer than six markers are known by name, the first frame shows fewer than three of them,
        `names` has an unknown name, or the body cannot carry the markers to within 80 mm (root mean
        square).
    """
    sites, unused = _known_sites(markers, dict(names or {}))
    seen = markers.position[:, [markers.names.index(name) for name in sites]]
    mirrored = _is_mirrored(seen, list(sites.values()))
    if mirrored:
        seen = seen * np.array([1.0, -1.0, 1.0])
    fit = _solved_without_outliers(body, markers, sites, seen)
    if fit.rms > _MAX_RMS:  # a wrong marker of the pelvis may have exchanged the sides
        other = _solved_without_outliers(body, markers, sites, seen * np.array([1.0, -1.0, 1.0]))
        if other.rms < fit.rms:
            fit = other
            mirrored = not mirrored
    _require_small_residuals(markers, fit)
    notes = markers.notes
    if mirrored:
        notes += (
            "the file's axes are left-handed, or left and right are exchanged in it: mirrored (y)",
        )
    notes += _unused_notes(markers, unused)
    if fit.left_out:
        named = ", ".join(f"{name} ({1000 * rms:.0f} mm)" for name, rms in fit.left_out.items())
        notes += (f"markers left out, far from where the others put them: {named}",)
    return MarkerFit(
        poses=_poses(fit.layout, fit.solution, markers.time),
        markers=fit.names,
        residual=fit.residual,
        unused=unused + tuple(fit.left_out),
        notes=notes,
    )


@dataclass(frozen=True, eq=False)
class _Fitted:
    """A solution of all frames, with the M markers that it is made from."""

    layout: _MarkerLayout
    solution: _Solution
    names: tuple[str, ...]
    residual: Floats
    """(P, M) [m], NaN where a marker is hidden."""
    left_out: dict[str, float]
    """Markers that lie far off, with their root mean square distance [m] when they were left out."""

    @property
    def rms(self) -> float:
        """Root mean square distance [m] of all markers."""
        return float(np.sqrt(np.nanmean(self.residual**2)))


def _solved_without_outliers(
    body: Body, markers: Markers, sites: dict[str, Site], seen: Floats
) -> _Fitted:
    """Solve all frames; leave out the worst marker that lies far off, and repeat.

    All is solved in axes of the pelvis as it is guessed in the first frame, in points on a grid, so the
    last digits, which are others once a recording is turned or moved, choose no posture.

    Parameters
    ----------
    body, markers
        As in `poses_from_markers`.
    sites, seen
        The known markers, and their positions (P, M, 3) [m].
    """
    _require_visible(markers, seen)
    origin = _first_guess(_MarkerLayout.of(body, sites), seen[0])
    seen = on_grid((seen - origin.pelvis[:, 3]) @ origin.pelvis[:, :3])
    left_out: dict[str, float] = {}
    while True:
        kept = np.array([name not in left_out for name in sites], dtype=np.bool_)
        own = {name: site for name, site in sites.items() if name not in left_out}
        shown = np.ascontiguousarray(seen[:, kept])
        _require_visible(markers, shown)
        layout = _MarkerLayout.of(body, own)
        sample = _sample(shown)
        chain, start = _calibrated(layout, sample)
        may_leave_out = _may_leave_out(len(left_out), len(sites))
        residual = _distances(sample, _solve(sample, chain, start))
        worst = _outlier(residual) if may_leave_out else None
        if worst is None:
            solution = _within_stops(layout, chain, _solve(shown, chain, start))
            residual = _distances(shown, solution)
            worst = _outlier(residual) if may_leave_out else None
        if worst is None:
            solution = _in_world(solution, origin)
            return _Fitted(layout, solution, tuple(own), residual, left_out)
        left_out[tuple(own)[worst]] = float(_marker_rms(residual)[worst])


def _in_world(solution: _Solution, origin: _Start) -> _Solution:
    """A solution in axes of a pelvis, in the world in which that stands."""
    turn, at = origin.pelvis[:, :3], origin.pelvis[:, 3]
    pelvis = turn @ solution.pelvis
    pelvis[:, :, 3] += at
    return replace(
        solution,
        attitude=multiply(origin.attitude, solution.attitude),
        pelvis=pelvis,
        modelled=solution.modelled @ turn.T + at,
    )


def _distances(seen: Floats, solution: _Solution) -> Floats:
    """(P, M) [m] from the markers to where the body carries them."""
    return np.asarray(np.linalg.norm(seen - solution.modelled, axis=-1))


def _marker_rms(residual: Floats) -> Floats:
    """(M,) [m] root mean square of distances (P, M) over the frames, NaN where none is seen."""
    return np.asarray(np.sqrt(_seen_mean(residual**2, axis=0)))


def _outlier(residual: Floats) -> int | None:
    """Find the marker farthest beyond the others, None if none is far beyond them.

    Its root mean square distance exceeds both `_MIN_OUTLIER` and the median of all markers by
    `_OUTLIER_DEVIATIONS` standard deviations, which are estimated as 1.4826 times the median
    absolute deviation.
    """
    rms = _marker_rms(residual)
    median = np.nanmedian(rms)
    deviation = 1.4826 * np.nanmedian(np.abs(rms - median))
    worst = int(np.nanargmax(rms))
    far = rms[worst] > max(_MIN_OUTLIER, median + _OUTLIER_DEVIATIONS * deviation)
    return worst if far else None


def _may_leave_out(count: int, known: int) -> bool:
    """Return whether one marker more may be left out than `count` of `known`."""
    return count + 1 <= _MAX_LEFT_OUT * known and known - count - 1 >= _MIN_MARKERS


def _require_small_residuals(markers: Markers, fit: _Fitted) -> None:
    """Refuse a motion that the body cannot follow, and name the worst markers."""
    if fit.rms <= _MAX_RMS:
        return
    per_marker = np.nan_to_num(_marker_rms(fit.residual))
    worst = np.argsort(-per_marker)[:_NAMED]
    named = ", ".join(f"{fit.names[m]} {1000 * per_marker[m]:.0f} mm" for m in worst)
    out = f"; left out before: {', '.join(fit.left_out)}" if fit.left_out else ""
    raise InputError(
        f"{markers.file}: the markers are {1000 * fit.rms:.0f} mm (root mean square) from where a body can "
        f"carry them, {1000 * _MAX_RMS:.0f} mm at most are accepted; the worst: {named}{out}. Check "
        "names (map in a study, --names), the unit (unit, --unit), the upward axis (up, --up), and the size "
        "of the body (scale: subject, --scale subject)"
    )


@dataclass(frozen=True, eq=False)
class _MarkerLayout:
    """A body as a tree of K segments from the pelvis on, and the usual places of M markers on it."""

    body: Body
    order: list[int]
    """The body's indices of the segments, parents first."""
    parent: Ints
    """(K,) place of each segment's parent in `order`, 0 for the pelvis itself."""
    marker_segment: Ints
    """(M,) place of each marker's segment in `order`."""
    place: Floats
    """(M, 3) [m] usual place in the segment's frame."""
    spread: Floats
    """(M,) [m] standard distance of real markers from it."""

    @classmethod
    def of(cls, body: Body, sites: Mapping[str, Site]) -> _MarkerLayout:
        """Lay the markers of some sites out on a body."""
        pelvis = body.segment("LT")
        order = [pelvis]
        for segment in range(pelvis + 1, len(body.segments)):
            if int(body.parent[segment]) in order:
                order.append(segment)
        parent = [0, *(order.index(int(body.parent[segment])) for segment in order[1:])]
        marker_segment = [order.index(body.segment(site.segment)) for site in sites.values()]
        place, spread = marker_places(body, sites)
        return cls(
            body, order, np.array(parent, dtype=np.int64), np.array(marker_segment), place, spread
        )

    def chain(self) -> MarkerChain:
        """Pack the layout for the solver. Markers that sit loosely weigh less."""
        joints = [segment - 1 for segment in self.order]
        stops = self.body.stops
        half_range = np.maximum(0.5 * np.abs(stops.limits[joints]).sum(axis=-1), _MIN_HALF_RANGE)
        return MarkerChain(
            parent=self.parent,
            at_parent=self.body.joint_in_parent[0, joints],
            at_child=self.body.joint_in_child[0, joints],
            axes=stops.axes[joints].copy(),
            half=half_range,
            marker_segment=self.marker_segment,
            local=self.place,
            weight=1.0 / (_UNIT * np.clip(self.spread / USUAL_SPREAD, 0.7, 2.0)),
            joint=np.array(joints, dtype=np.int64),
            stops=packed_stops(self.body),
        )

    def zero_pose(self) -> Floats:
        """(M, 3) [m] the markers in the zero pose, from the pelvis."""
        origin = np.zeros((len(self.order), 3))
        for k, segment in enumerate(self.order[1:], start=1):
            joint = segment - 1
            above = origin[self.parent[k]] + self.body.joint_in_parent[0, joint]
            origin[k] = above - self.body.joint_in_child[0, joint]
        return np.asarray(origin[self.marker_segment] + self.place)


@dataclass(frozen=True, eq=False)
class _Start:
    """The pose from which the solver starts."""

    rotations: Floats
    """(K, 4) quaternions of the segments against their parents."""
    attitude: Floats
    """(4,) quaternion of the pelvis."""
    pelvis: Floats
    """(3, 4) world from pelvis."""


@dataclass(frozen=True, eq=False)
class _Solution:
    """The solved poses of P frames."""

    rotations: Floats
    """(P, K, 4) quaternions of the segments against their parents."""
    attitude: Floats
    """(P, 4) quaternion of the pelvis."""
    pelvis: Floats
    """(P, 3, 4) world from pelvis."""
    modelled: Floats
    """(P, M, 3) [m] the markers as the body carries them."""

    def first(self) -> _Start:
        """The first frame, to start another solution from."""
        return _Start(self.rotations[0], self.attitude[0], self.pelvis[0])


def _calibrated(layout: _MarkerLayout, sample: Floats) -> tuple[MarkerChain, _Start]:
    """Estimate the places of the markers on the body from a sample of frames (S, M, 3) [m]."""
    chain = layout.chain()
    start = _first_guess(layout, sample[0])
    for _ in range(_ROUNDS):
        solution = _solve(sample, chain, start)
        start = solution.first()
        chain = chain._replace(local=_improved_places(layout, chain, sample, solution))
    return chain, start


def _sample(seen: Floats) -> Floats:
    """Frames spread evenly over the motion."""
    rows = np.unique(np.linspace(0, len(seen) - 1, _SAMPLE).astype(np.int64))
    return np.asarray(seen[rows])


def _solve(seen: Floats, chain: MarkerChain, start: _Start) -> _Solution:
    """Solve every frame (P, M, 3) [m] from the one before it, the first from `start`."""
    frames = len(seen)
    rotations, attitude, pelvis = (
        np.repeat(value[None], frames, axis=0)
        for value in (start.rotations, start.attitude, start.pelvis)
    )
    modelled = np.empty((frames, seen.shape[1], 3))
    solve_markers(np.ascontiguousarray(seen), chain, rotations, attitude, pelvis, modelled)
    return _Solution(rotations, attitude, pelvis, modelled)


def _within_stops(layout: _MarkerLayout, chain: MarkerChain, solution: _Solution) -> _Solution:
    """Turn the joints that the penalty left a little past their stops back to the nearest stop.

    The limits of some joints follow the angles of others, so it is repeated.
    """
    body = layout.body
    joints = [segment - 1 for segment in layout.order[1:]]
    poses = _poses(layout, solution, np.arange(len(solution.pelvis), dtype=np.float64))
    for _ in range(_STOP_ROUNDS):
        legal_rotations = nearest_legal(body, poses)
        moved = float(np.abs(legal_rotations - poses.rotations).max())
        poses = replace(poses, rotations=legal_rotations)
        if moved < _AT_STOP:
            break
    rotations = solution.rotations.copy()
    rotations[:, 1:] = poses.rotations[:, joints]
    legal = replace(solution, rotations=rotations)
    world = _segment_frames(chain, legal)[:, chain.marker_segment]
    modelled = np.einsum("pmij,mj->pmi", world[..., :3], chain.local) + world[..., 3]
    return replace(legal, modelled=modelled)


def _poses(layout: _MarkerLayout, solution: _Solution, time: Floats) -> Poses:
    """The solution as poses of the body; joints above the pelvis stay at zero."""
    body = layout.body
    rotations = np.tile(IDENTITY, (len(time), len(body.joints), 1))
    for k, segment in enumerate(layout.order[1:], start=1):
        rotations[:, segment - 1] = solution.rotations[:, k]
    pelvis = layout.order[0]
    rotations[:, pelvis - 1] = solution.attitude
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    return Poses(rotations, pelvis, solution.pelvis, time)


def _known_sites(
    markers: Markers, names: dict[str, str]
) -> tuple[dict[str, Site], tuple[str, ...]]:
    """The site of each marker that has one and is seen, and the names of the others."""
    known = named_sites(markers, names)
    hidden: Bools = np.asarray(np.isnan(markers.position).any(axis=2).all(axis=0))
    sites = {name: site for name, site in known.items() if not hidden[markers.names.index(name)]}
    unused = [name for name in markers.names if name not in sites]
    if len(sites) < _MIN_MARKERS:
        raise InputError(
            f"{markers.file}: {len(sites)} markers are known by name, {_MIN_MARKERS} or more are "
            f"needed; name the others (map: {{{(unused or ['X'])[0]}: LASI}} in a study, or --names FILE with "
            f"lines such as '{(unused or ['X'])[0]}: LASI'): {', '.join(unused[:40])}"
        )
    return sites, tuple(unused)


def _unused_notes(markers: Markers, unused: tuple[str, ...]) -> tuple[str, ...]:
    """Name the markers that are not used, and why."""
    shown = np.asarray(np.isfinite(markers.position).any(axis=(0, 2)))
    hidden = [name for name in unused if not shown[markers.names.index(name)]]
    unplaced = [name for name in unused if name not in hidden]
    notes = []
    if unplaced:
        notes.append(f"markers without a known place are not used: {', '.join(unplaced)}")
    if hidden:
        notes.append(f"markers that no frame shows: {', '.join(hidden)}")
    return tuple(notes)


def _is_mirrored(seen: Floats, sites: list[Site]) -> bool:
    """True where left markers lie on the right.

    The front-back and right-left vectors of the pelvis, or else of the feet, turn the wrong way
    about the vertical in more than half of the frames.
    """
    for segments in (("LT",), ("LF", "RF")):
        rows = [m for m, site in enumerate(sites) if site.segment in segments]
        turn = _turn_of_sides(seen[:, rows], [sites[m] for m in rows])
        if np.isfinite(turn).any():
            return bool(np.nanmedian(turn) < 0)
    return False


def _turn_of_sides(seen: Floats, sites: list[Site]) -> Floats:
    """(P,) [m2] vertical part of (front - back) x (left - right), NaN where a group is unseen."""
    groups = (
        [site.side == "L" for site in sites],
        [site.side == "R" for site in sites],
        ["front" in site.toward for site in sites],
        ["back" in site.toward for site in sites],
    )
    left, right, front, back = (
        _seen_mean(seen[:, np.array(group, dtype=np.bool_)], axis=1) for group in groups
    )
    return np.asarray(np.cross(front - back, left - right)[:, 2])


def _require_visible(markers: Markers, seen: Floats) -> None:
    """Refuse a motion whose first frame shows fewer than three known markers."""
    visible = _visible(seen).sum(axis=1)
    if visible[0] >= 3:
        return
    first = np.flatnonzero(visible >= 3)
    hint = (
        f"begin at {markers.time[first[0]]:g} s (start in a study, --start)"
        if len(first)
        else "no frame shows three"
    )
    raise InputError(
        f"{markers.file}: the first frame shows {visible[0]} known markers, 3 are needed: {hint}"
    )


def _first_guess(layout: _MarkerLayout, frame: Floats) -> _Start:
    """Lay the upright zero pose over the markers of one frame (M, 3) [m].

    The rotation about the vertical that minimizes the sum of squared distances has
    tan angle = sum(a x b) / sum(a . b), a and b being the horizontal offsets from the means (the
    plane case of Kabsch 1976).
    """
    visible = _visible(frame)
    own = layout.zero_pose()[visible]
    seen = frame[visible]
    own_mean = own.mean(axis=0)
    seen_mean = seen.mean(axis=0)
    a = (own - own_mean)[:, :2]
    b = (seen - seen_mean)[:, :2]
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    cosine = np.cos(angle)
    sine = np.sin(angle)
    rotation = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    pelvis = np.concatenate([rotation, (seen_mean - rotation @ own_mean)[:, None]], axis=1)
    attitude = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
    return _Start(np.tile(IDENTITY, (len(layout.order), 1)), attitude, pelvis)


def _improved_places(
    layout: _MarkerLayout, chain: MarkerChain, seen: Floats, solution: _Solution
) -> Floats:
    """(M, 3) [m] places of the markers in their segments' frames, nearer to where they are seen.

    The place is a compromise between the usual one and the mean of n observations. The usual place
    counts as much as 4 (_UNIT / spread)^2 observations.
    """
    world = _segment_frames(chain, solution)[:, chain.marker_segment]
    local = np.einsum("pmji,pmj->pmi", world[..., :3], seen - world[..., 3])
    count = _visible(local).sum(axis=0)
    mean = np.where(count[:, None] > 0, _seen_mean(local, axis=0), layout.place)
    trust = count / (count + (_UNIT / layout.spread) ** 2 * _PLACE_TRUST)
    shift = trust[:, None] * (mean - layout.place)
    size = np.linalg.norm(shift, axis=1, keepdims=True)
    limit = _MAX_SHIFT * layout.spread[:, None]
    return np.asarray(layout.place + shift * np.minimum(1.0, limit / np.maximum(size, 1e-12)))


def _segment_frames(chain: MarkerChain, solution: _Solution) -> Floats:
    """(P, K, 3, 4) world from segment."""
    world = np.empty((len(solution.attitude), len(chain.parent), 3, 4))
    world[:, 0] = solution.pelvis
    for k in range(1, len(chain.parent)):
        above = world[:, chain.parent[k]]
        world[:, k, :, :3] = above[..., :3] @ matrices(solution.rotations[:, k])
        joint = above[..., 3] + above[..., :3] @ chain.at_parent[k]
        world[:, k, :, 3] = joint - world[:, k, :, :3] @ chain.at_child[k]
    return world


def _seen_mean(values: Floats, *, axis: int) -> Floats:
    """Mean along an axis of what is finite; NaN where nothing is."""
    count = np.isfinite(values).sum(axis=axis)
    total = np.nansum(values, axis=axis)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def _visible(position: Floats) -> Bools:
    """(...) True where a marker (..., 3) is seen."""
    return np.asarray(np.isfinite(position).all(axis=-1))
