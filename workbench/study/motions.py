"""Motion files as poses of a body: each format by its own way, moved and turned into the
environment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.body.scaling.morph import lengthened
from workbench.contact.clearance_pairs import clearance_of_pairs, room_of_segments, rooms_by_mover
from workbench.contact.kernels.search import Nearest
from workbench.errors import InputError
from workbench.files.motions.number_rows import ALL_FRAMES, FrameRange
from workbench.files.motions.opensim import Coordinates, coordinate_poses
from workbench.files.motions.reading import Recorded, read_motion
from workbench.model.arrays import Floats, pieces
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.joint_angles import attitude_matrix, poses_at
from workbench.model.laban import Score
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed, Poses, stacked
from workbench.model.surroundings import Surroundings
from workbench.motion.laban.laban import score_poses
from workbench.motion.recorded.doubts import motion_doubts
from workbench.motion.recorded.markers import bridged, poses_from_markers
from workbench.motion.recorded.retarget import poses_from_track, retarget
from workbench.motion.recorded.subject_scaling import (
    factors_from_bones,
    factors_from_markers,
    factors_from_track,
    height_of,
)
from workbench.study.checks.parts import asked_pair, limit_of

__all__ = [
    "AskedGap",
    "MotionOptions",
    "asked_gaps",
    "distance_criteria",
    "frame_rooms",
    "load_motion",
    "nearest_criterion",
    "subject_body",
    "written_loss",
]

_LOOSE = 0.02
_SAME = 1e-6
"""Change of a place [m], an angle [rad] or a time [s] of a file that is read back up to which it is the
same."""


@dataclass(frozen=True)
class MotionOptions:
    """How a motion file is read. names: bones by segment, or usual marker names by the file's; up:
    its upward axis; metres: one unit of a BVH or marker file [m]; keep: the frames wanted; gaps: the longest
    [s] that is bridged; move (3,) [m] and yaw [rad]: where it is put, turned about the vertical
    first."""

    names: Mapping[str, str] | None = None
    up: str | None = None
    metres: float | None = None
    keep: FrameRange = ALL_FRAMES
    gaps: float = 0.1
    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0


def load_motion(
    body: Body, path: str | Path, *, options: MotionOptions | None = None
) -> tuple[Poses, tuple[str, ...]]:
    """A motion file of any known format as poses of a body with their times, and what was assumed
    or is odd, in sentences. InputError with file and line for every fault."""
    given = options or MotionOptions()
    loading = _Loading(body, given)
    turn = attitude_matrix(yaw=given.yaw)

    def parts() -> Iterator[Poses]:
        for found in read_motion(
            path, body, up=given.up, metres=given.metres, names=given.names, keep=given.keep
        ):
            poses = loading.poses(found)
            for rows in pieces(len(poses)):
                some = poses.rows(rows)
                world = np.einsum("ij,pjk->pik", turn, some.world_from_reference)
                world[:, :, 3] += given.move
                yield replace(some, world_from_reference=world)

    whole = stacked(parts())
    notes = loading.notes() if loading.scored else (*loading.notes(), *motion_doubts(body, whole))
    return whole, tuple(f"{Path(path).name}: {note}" for note in notes)


class _Loading:
    """What a file holds, piece by piece, as poses of a body; and what was assumed, once."""

    def __init__(self, body: Body, given: MotionOptions) -> None:
        self._body = body
        self._given = given
        self._notes: dict[str, None] = {}
        self._loosest = (_LOOSE, "")
        self.scored = False
        """Whether the motion was written by hand, as a score: nothing in it was recorded."""

    def poses(self, found: Recorded) -> Poses:
        """A piece as poses."""
        body = self._body
        given = self._given
        notes: tuple[str, ...] = ()
        if isinstance(found, Bones):
            poses, notes = retarget(
                body, found, names=given.names, up=given.up, metres=given.metres
            )
        elif isinstance(found, Markers):
            poses, notes = _from_markers(body, found, given)
        elif isinstance(found, Coordinates):
            poses, notes = coordinate_poses(body, found)
        elif isinstance(found, SegmentTrack):
            poses, apart = poses_from_track(body, found)
            worst = int(np.argmax(apart.max(axis=0)))
            self._loosest = max(self._loosest, (float(apart.max()), found.segments[worst]))
            notes = found.notes
        elif isinstance(found, Score):
            poses, notes = score_poses(body, found)
            self.scored = True
        else:
            poses, notes = found
        self._notes |= dict.fromkeys(notes)
        return poses

    def notes(self) -> tuple[str, ...]:
        """What was assumed, or is odd."""
        apart, segment = self._loosest
        loose = (
            f"segment {segment} is up to {1000 * apart:.0f} mm from where the joints of {self._body.name} put it: "
            "another size of body?"
        )
        return (*self._notes, loose) if segment else tuple(self._notes)


def written_loss(body: Body, poses: Poses, path: str | Path) -> str:
    """Measure what a motion lost in a file, by reading it back.

    Parameters
    ----------
    body, poses
        The body, and the P frames of the motion that was written.
    path
        The file.

    Returns
    -------
    str
        A sentence with the largest changes of the joints' places, the segments' attitudes (without
        the stage, which is no part of the body) and the times; "" where none exceeds 1e-6 m, rad or s.
    """
    try:
        again, _ = load_motion(body, path)
    except InputError as error:
        return f"this file cannot be read back: {error}"
    shift = poses.clock[0] - again.clock[0]
    same_frames = len(again) == len(poses)
    moved = turned = 0.0
    for rows in pieces(len(poses)):
        some = poses.rows(rows)
        # a form without frames, such as a score, is asked at the times of the motion
        found = again.rows(rows) if same_frames else poses_at(again, some.clock - shift)
        was, now = (place(body, one).world_from_segment[:, 1:] for one in (some, found))
        offset = body.joint_in_child[0]
        apart = np.einsum("pnij,nj->pni", (now - was)[..., :3], offset) + (now - was)[..., 3]
        moved = max(moved, float(np.linalg.norm(apart, axis=-1).max()))
        # |R - S| = 2 sqrt(2) sin(angle / 2) of two rotations (Frobenius norm)
        chord = np.linalg.norm((now - was)[..., :3], axis=(-2, -1)).max() / np.sqrt(8.0)
        turned = max(turned, float(2.0 * np.arcsin(min(chord, 1.0))))
    uneven = float(np.abs(again.clock + shift - poses.clock).max()) if same_frames else 0.0
    losses = [
        (moved, f"joints up to {1000 * moved:.3g} mm off"),
        (turned, f"segments turned by up to {np.degrees(turned):.3g} degrees"),
        (uneven, f"frames up to {1000 * uneven:.3g} ms off, which are evenly spaced there"),
        (abs(shift), f"the first frame at {again.clock[0]:g} s, not {poses.clock[0]:g}"),
    ]
    said = [words for size, words in losses if size > _SAME]
    return (
        f"this form does not hold the whole motion; read back it has {', '.join(said)}"
        if said
        else ""
    )


def _from_markers(
    body: Body, markers: Markers, given: MotionOptions
) -> tuple[Poses, tuple[str, ...]]:
    fit = poses_from_markers(body, bridged(markers, longest=given.gaps), names=given.names)
    rms = np.sqrt(np.nanmean(fit.residual**2))
    per = np.sqrt(
        np.nansum(fit.residual**2, axis=0) / np.maximum(np.isfinite(fit.residual).sum(axis=0), 1)
    )
    worst = int(np.argmax(per))
    said = (
        f"{len(fit.markers)} markers are carried to {1000 * rms:.1f} mm (root mean square), the worst is "
        f"{fit.markers[worst]} with {1000 * per[worst]:.1f} mm"
    )
    return fit.poses, (*fit.notes, said)


@dataclass(frozen=True, eq=False)
class AskedGap:
    """What a criterion about distances finds at each frame.

    Parameters
    ----------
    criterion
        A clearance or a contact.
    distance
        (P,) [m] with the overlap that a part allows given back to a contact; infinite where nothing
        is near.
    limit
        [m] The distance that may not be fallen short of.
    """

    criterion: Criterion
    distance: Floats
    limit: float

    @property
    def least(self) -> float:
        """The least that is left [m] of what is asked for, infinite where nothing is near."""
        return float((self.distance - self.limit).min(initial=np.inf))


def distance_criteria(motion: MotionCase) -> tuple[Criterion, ...]:
    """The criteria of a motion that are about distances from parts."""
    return tuple(one for one in motion.criteria if one.check in ("clearance", "contact"))


def frame_rooms(motion: MotionCase, placed: Placed) -> Nearest:
    """Find what comes nearest to each segment at P frames, with the overlap that parts allow added.

    Parameters
    ----------
    placed
        The body of the motion in P of its frames.
    """
    still = Surroundings(motion.environment, (), np.zeros((0, 3)))
    return room_of_segments(rooms_by_mover(placed, still))


def asked_gaps(
    motion: MotionCase, placed: Placed, criteria: Sequence[Criterion]
) -> tuple[AskedGap, ...]:
    """Find what criteria about distances find at P frames.

    Parameters
    ----------
    placed
        The body of the motion in P of its frames.
    criteria
        Some of `distance_criteria`.
    """
    if not criteria:
        return ()
    pairs = [asked_pair(motion.body, motion.environment, one) for one in criteria]
    found = clearance_of_pairs(placed, motion.environment, pairs=pairs).distance
    return tuple(AskedGap(one, found[:, q], limit_of(one) + 0.0) for q, one in enumerate(criteria))


def nearest_criterion(gaps: Sequence[AskedGap]) -> AskedGap | None:
    """The gap of the criterion that is nearest to failing, None where there is none."""
    return min(gaps, key=lambda one: one.least, default=None)


# The body of a recorded subject: the study's body with the lengths that the motion file itself
# says.

_TOLD = 0.005


def subject_body(
    body: Body, path: str | Path, *, options: MotionOptions | None = None
) -> tuple[Body, tuple[str, ...]]:
    """The body with its limbs and trunk as long as the file says, and what was changed by how
    much, in sentences.

    BVH: the bones at rest (the unit must be stated: the unit that is guessed makes the legs as long
    as the body's). Markers: medians of distances that hardly depend on the pose. Single segments:
    the joints about which they turn. What the file does not say stays as it is. InputError where
    it states no length.
    """
    given = options or MotionOptions()
    found = next(
        read_motion(
            path, body, up=given.up, metres=given.metres, names=given.names, keep=given.keep
        )
    )
    factors: dict[str, float] = {}
    if isinstance(found, Bones):
        if given.metres is None:
            raise InputError(
                f"{path}: a body scaled to the subject needs the file's unit of length: state it (unit: 1 cm in a study, --unit '1 cm')"
            )
        factors = factors_from_bones(body, found, given.names, given.metres)
    elif isinstance(found, Markers):
        factors = factors_from_markers(body, found, given.names)
    elif isinstance(found, SegmentTrack):
        factors = factors_from_track(body, found)
    if not factors:
        raise InputError(
            f"{path}: states no length of the subject's limbs: bones do, markers at knees and ankles or at "
            "elbows and wrists, or segments that turn against each other"
        )
    try:
        made = lengthened(body, factors)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return made, tuple(_changes(body, made, factors, Path(path).name))


def _changes(body: Body, made: Body, factors: dict[str, float], file: str) -> list[str]:
    """One sentence: each pair of twins once."""
    parts: dict[str, float] = {}
    for segment, factor in factors.items():
        name = body.segment_names[body.segment(segment)]
        twin = name.removeprefix("left ").removeprefix("right ")
        same = [k for k in factors if body.segment_names[body.segment(k)].endswith(twin)]
        alike = len(same) == 2 and abs(factors[same[0]] - factors[same[1]]) < _TOLD
        parts[f"{twin}s" if alike else name] = factor
    said = ", ".join(f"{name} {100 * (f - 1):+.0f} %" for name, f in parts.items())
    tall = f"{1000 * height_of(body):.0f} mm tall before, {1000 * height_of(made):.0f} mm now"
    return [f"{file}: the lengths of {body.name} are scaled to the subject: {said}; {tall}"]
