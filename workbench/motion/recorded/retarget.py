"""Transfer the motion of an unknown skeleton to a body.

Each segment turns as its bone does, from where the bone is when the skeleton stands
(`workbench.motion.recorded.skeleton`).

A skeleton may turn a limb in a joint where the body has a hinge, such as a forearm that twists in
the elbow. Such a turn is moved to the neighbouring ball joints (`_make_hinge`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError, one_of
from workbench.files.motions.bvh import own_poses
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import Bones, SegmentTrack
from workbench.model.poses import Poses
from workbench.model.quaternions import (
    conjugate,
    exponential,
    from_matrices,
    matrices,
    multiply,
    rotate,
    swing_twist,
)
from workbench.motion.recorded.skeleton import (
    AXIS_JOINTS,
    IDENTITY,
    Skeleton,
    body_lengths,
    bone_attitudes,
    bone_lengths,
    bone_positions,
    find_skeleton,
)

__all__ = ["poses_from_track", "retarget"]

_HINGES = (("LS", "LE", "LW"), ("RS", "RE", "RW"), ("LH", "LK", "LA"), ("RH", "RK", "RA"))
_STRAIGHT = np.radians(15.0)
"""Flexion [rad] of a hinge below which its plane says little about the turn of the limb above."""


def retarget(
    body: Body,
    bones: Bones,
    *,
    names: Mapping[str, str] | None = None,
    up: str | None = None,
    metres: float | None = None,
) -> tuple[Poses, tuple[str, ...]]:
    """Compute the motion of a skeleton as poses of a body.

    The lower torso is placed so that the middle of the hips is where it is in the file. Bones that
    were written of this body (`workbench.files.motions.bvh.own_poses`) are read as written.

    Parameters
    ----------
    body
        A body with the paper's joints.
    bones
        The skeleton and its motion in P frames.
    names
        Bones by segment, where the usual names do not apply.
    up
        The file's upward axis ("y", "-z"), found from the skeleton and its frames if None.
    metres
        One unit of the file [m]. If None, the skeleton's legs are taken to be as long as the body's.

    Returns
    -------
    tuple of Poses and str
        The poses, and what was assumed, in sentences.

    Raises
    ------
    InputError
        If bones are missing, or the body has other joints.
    """
    as_written = metres is None or abs(metres - 0.01) < 1e-9
    if as_written and up in (None, "y") and all(k == v for k, v in (names or {}).items()):
        own = own_poses(body, bones)
        if own is not None:
            said = (
                f"its bones are those of {body.name} as they are written here: y is up, and one unit is 10 mm",
            )
            return own, bones.notes if metres else bones.notes + said
    _require_joints(body)
    skeleton = find_skeleton(body, bones, names=names, up=up)
    notes = [*bones.notes, *skeleton.notes]
    unit = metres
    if unit is None:
        unit = _unit_by_legs(body, skeleton)
        notes.append(
            f"the file does not say its unit of length; one unit is taken as {1000 * unit:.4g} mm, which makes "
            f"its legs as long as those of {body.name}; if it is another, state it (unit in a study, --unit '1 cm')"
        )
    attitudes = _segment_attitudes(skeleton)
    rotations = _joint_rotations(body, attitudes, len(bones.time))
    pelvis = _pelvis_frames(body, skeleton, attitudes["LT"], unit)
    return Poses(rotations, body.segment("LT"), pelvis, bones.time), tuple(notes)


def _require_joints(body: Body) -> None:
    needed = ("LH", "RH", *(joint for pair in AXIS_JOINTS.values() for joint in pair))
    missing = [joint for joint in needed if joint not in body.joints]
    if missing:
        raise InputError(
            f"body {body.name}: a motion is mapped by the paper's joints, {', '.join(missing)} are missing"
        )


def _pelvis_frames(body: Body, skeleton: Skeleton, attitude: Floats, unit: float) -> Floats:
    """(P, 3, 4) world from pelvis, of attitudes (P, 4): the middle of the hips is as in the file."""
    hips = [skeleton.index(segment) for segment in ("LUL", "RUL")]
    middle = bone_positions(skeleton.bones)[:, hips].mean(axis=1)
    left = body.joint_in_parent[0, body.joint("LH")]
    right = body.joint_in_parent[0, body.joint("RH")]
    own_middle = np.broadcast_to(0.5 * (left + right), (len(attitude), 3))
    frames = np.zeros((len(attitude), 3, 4))
    frames[:, :, :3] = matrices(attitude)
    frames[:, :, 3] = middle @ skeleton.world_from_file.T * unit - rotate(attitude, own_middle)
    return frames


def _unit_by_legs(body: Body, skeleton: Skeleton) -> float:
    """The unit of the file [m] that makes the skeleton's legs as long as the body's."""
    lengths = bone_lengths(skeleton.bones, skeleton.bone)
    own = body_lengths(body)
    legs = [segment for segment in ("LUL", "RUL", "LLL", "RLL") if segment in lengths]
    total = sum(lengths[segment] for segment in legs)
    if not legs or total <= 0:
        raise InputError(
            f"{skeleton.bones.file}: the bones of the legs have no length, so the unit cannot be "
            "found; state it (unit in a study, --unit '1 cm')"
        )
    return sum(own[segment] for segment in legs) / total


def _segment_attitudes(skeleton: Skeleton) -> dict[str, Floats]:
    """(P, 4) world from segment of the segments that have a bone, by name."""
    basis = from_matrices(skeleton.world_from_file[None])[0]
    attitude = multiply(basis, bone_attitudes(skeleton.bones))
    return {
        segment: multiply(attitude[:, skeleton.index(segment)], turn)
        for segment, turn in skeleton.bone_from_segment.items()
    }


def _joint_rotations(body: Body, attitudes: Mapping[str, Floats], frames: int) -> Floats:
    """(P, J, 4) joint rotations of segments' attitudes (P, 4)."""
    full = _all_attitudes(body, attitudes, frames)
    rotations = np.tile(IDENTITY, (frames, len(body.joints), 1))
    for joint in range(len(body.joints)):
        child = body.segments[joint + 1]
        parent = body.segments[int(body.parent[joint + 1])]
        rotations[:, joint] = multiply(conjugate(full[parent]), full[child])
    rotations[:, body.joint("PV")] = full["LT"]
    for above, hinge, below in _HINGES:
        _make_hinge(rotations, _Hinge.of(body, above, hinge, below))
    return np.asarray(rotations / np.linalg.norm(rotations, axis=-1, keepdims=True))


def _all_attitudes(body: Body, attitudes: Mapping[str, Floats], frames: int) -> dict[str, Floats]:
    """(P, 4) of every segment. Those without a bone are half way between, or follow their parent."""
    still = np.tile(IDENTITY, (frames, 1))
    full = dict(attitudes)
    if "CT" not in full:
        full["CT"] = _halfway(full["LT"], full.get("UT", full["LT"]))
    full.setdefault("UT", full["CT"])
    if "H" in full and "N" not in full:
        full["N"] = _halfway(full["UT"], full["H"])
    for joint in range(len(body.joints)):
        child = body.segments[joint + 1]
        parent = body.segments[int(body.parent[joint + 1])]
        full.setdefault(child, full.get(parent, still))
        full.setdefault(parent, still)
    return full


@dataclass(frozen=True, eq=False)
class _Hinge:
    """A hinge between two ball joints, as indices, and the limb's lines in the zero pose."""

    above: int
    joint: int
    below: int
    axis: Floats
    """(3,) unit axis of the hinge."""
    upper: Floats
    """(3,) unit vector from the joint above to the hinge."""
    lower: Floats
    """(3,) unit vector from the hinge to the joint below."""

    @classmethod
    def of(cls, body: Body, above: str, hinge: str, below: str) -> _Hinge:
        """Find the lines between three joints of a limb."""
        first, middle, last = (body.joint(name) for name in (above, hinge, below))
        upper, lower = _line(body, first, middle), _line(body, middle, last)
        return cls(first, middle, last, body.stops.axes[middle, 0], upper, lower)


def _make_hinge(rotations: Floats, hinge: _Hinge) -> None:
    """Change joint rotations (P, J, 4) so that a hinge turns about its own axis only.

    The limb above is turned about its line until the hinge bends in its own plane. The twist of the
    limb below about its line moves to the joint below. All three joints stay where they are, since
    both turns are about lines between them.
    """
    swing, _ = swing_twist(rotations[:, hinge.joint], hinge.lower[None])
    # angle of the swing vector about the upper line, from the hinge's axis to it
    side = hinge.axis - hinge.upper * (hinge.upper @ hinge.axis)
    across = np.cross(hinge.upper, side)
    angle = np.arctan2(
        (swing * across).sum(axis=-1) / np.linalg.norm(across),
        (swing * side).sum(axis=-1) / np.linalg.norm(side),
    )
    # a limb that is nearly straight has no plane: the turn fades out as f^4 / (f^4 + f0^4)
    flexion = np.linalg.norm(swing, axis=-1)
    faded = angle * flexion**4 / (flexion**4 + _STRAIGHT**4)
    turn = exponential(faded[:, None] * hinge.upper)
    rotations[:, hinge.above] = multiply(rotations[:, hinge.above], turn)
    bend, twist = swing_twist(
        multiply(conjugate(turn), rotations[:, hinge.joint]), hinge.lower[None]
    )
    rotations[:, hinge.joint] = exponential(bend)
    passed_on = exponential(twist[:, None] * hinge.lower)
    rotations[:, hinge.below] = multiply(passed_on, rotations[:, hinge.below])


def _line(body: Body, upper: int, lower: int) -> Floats:
    """(3,) unit vector in the zero pose from one joint of a limb segment to the next one down."""
    line = body.joint_in_parent[0, lower] - body.joint_in_child[0, upper]
    return np.asarray(line / np.linalg.norm(line))


def _halfway(a: Floats, b: Floats) -> Floats:
    """(P, 4) the rotations half way between two, as the normalized mean of quaternions."""
    near = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -b, b)  # q and -q are one rotation
    middle = a + near
    return np.asarray(middle / np.linalg.norm(middle, axis=-1, keepdims=True))


def poses_from_track(body: Body, track: SegmentTrack) -> tuple[Poses, Floats]:
    """Compute poses of a body whose segments have the recorded attitudes.

    The first recorded segment in the body's order is placed. A segment without a record follows its
    parent, or the placed segment if it comes before that one.

    Parameters
    ----------
    track
        World from segment (P, K, 3, 4) of K recorded segments.

    Returns
    -------
    tuple of Poses and Floats
        The poses, and the distance (P, K) [m] of each recorded segment's origin from where the
        body's joints place it.

    Raises
    ------
    InputError
        If the body has no segment of a recorded name.
    """
    for name in track.segments:
        if name not in body.segments:
            raise InputError(
                f"{track.file}: body {body.name} has no segment {name!r}; {one_of(name, body.segments)}"
            )
    recorded = [body.segment(name) for name in track.segments]
    root = min(recorded)
    attitudes = _attitudes(body, track, recorded)
    rotations = np.stack(
        [
            multiply(conjugate(attitudes[int(body.parent[n])]), attitudes[n])
            for n in range(1, len(body.segments))
        ],
        axis=1,
    )
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    world = track.world_from_segment
    poses = Poses(rotations, root, world[:, recorded.index(root)], track.time)
    origins = place(body, poses).world_from_segment[:, recorded][..., 3]
    return poses, np.asarray(np.linalg.norm(origins - world[..., 3], axis=-1))


def _attitudes(body: Body, track: SegmentTrack, recorded: list[int]) -> dict[int, Floats]:
    """(P, 4) world from segment of every segment, by its index; recorded: indices (K,)."""
    attitudes = {
        segment: from_matrices(track.world_from_segment[:, k, :, :3])
        for k, segment in enumerate(recorded)
    }
    root = min(recorded)
    attitudes.setdefault(0, attitudes[root])
    for segment in range(1, len(body.segments)):
        carrier = root if segment < root else int(body.parent[segment])
        attitudes.setdefault(segment, attitudes[carrier])
    return attitudes
