"""Motion files as poses of a body: each format by its own way, moved and turned into the
environment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.files.motions.number_rows import ALL_FRAMES, FrameRange
from workbench.files.motions.opensim import Coordinates, coordinate_poses
from workbench.files.motions.reading import Recorded, read_motion
from workbench.model.body import Body
from workbench.model.laban import Score
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.model.poses import Poses, stacked
from workbench.model.posing import attitude_matrix
from workbench.model.spool import pieces
from workbench.motion.laban.laban import score_poses
from workbench.motion.recorded.doubts import motion_doubts
from workbench.motion.recorded.markers import bridged, poses_from_markers
from workbench.motion.recorded.retarget import poses_from_track, retarget

__all__ = ["MotionOptions", "load_motion"]

_LOOSE = 0.02


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
