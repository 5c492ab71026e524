"""Look at a motion that was read for signs that something in its file was taken wrongly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of
from workbench.model.poses import Poses

__all__ = ["motion_doubts"]

_FRAMES = 200
"""Frames at most that are looked at, spread over the motion."""
_BENT = np.radians(15.0)
"""Angle [rad] against its way beyond which a knee or an elbow is no overstretched one."""
_SLOW = 0.5
"""Time [s] between frames beyond which they are no recording of a movement."""
_FAST = 40.0
"""Speed [m/s] of a hand, a foot or the head against the pelvis that nobody reaches: a pitcher's hand
has some 25."""
_TRAVEL = 100.0
"""Speed [m/s] at which no person is recorded on his way."""
_ENDS = ("H", "LHN", "RHN", "LF", "RF")


def motion_doubts(body: Body, poses: Poses) -> tuple[str, ...]:
    """Tell what in a motion is as no person's, each with what may be wrong in its file.

    The head stands above the feet, knees and elbows bend one way, frames follow each other within
    half a second, hands, feet and head move as people's do, and the person neither jumps nor flies.
    Joints and segments that a body has not are not asked for.

    Parameters
    ----------
    body, poses
        The body, and the P frames of its motion.
    """
    some = poses.rows(slice(None, None, -(-len(poses) // _FRAMES)))
    return (*_lying(body, some), *_bent_back(body, some), *_odd_clock(body, poses))


def _lying(body: Body, some: Poses) -> Iterator[str]:
    feet = [body.segment(name) for name in ("LF", "RF") if name in body.segments]
    if "H" not in body.segments or not feet:
        return
    at = place(body, some).world_from_segment[..., 3]
    rise = at[:, body.segment("H")] - at[:, feet].mean(axis=1)
    above = rise[:, 2] >= 0.5 * np.linalg.norm(rise, axis=-1)
    if above.mean() < 0.5:
        yield (
            f"the head is above the feet in {100 * above.mean():.0f} % of the frames only: does the person "
            "lie, or is another axis up (up in a study, --up)?"
        )


def _bent_back(body: Body, some: Poses) -> Iterator[str]:
    angles = angles_of(body, some)
    for joint, name in (("K", "knee"), ("E", "elbow")):
        for side, word in (("L", "left"), ("R", "right")):
            if side + joint not in body.joints:
                continue
            flexion = angles[:, body.joint(side + joint), 0]
            wrong = flexion < -_BENT
            if wrong.sum() > (flexion > _BENT).sum():
                yield (
                    f"the {word} {name} bends the wrong way, by up to "
                    f"{np.degrees(-flexion.min()):.0f} degrees: has its angle the other sign, or are left "
                    "and right, or front and back, exchanged in the file?"
                )


def _odd_clock(body: Body, poses: Poses) -> Iterator[str]:
    time = poses.clock
    if len(time) < 2:
        return
    step = float(np.median(np.diff(time)))
    if step > _SLOW:
        yield (
            f"the frames are {step:g} s apart: if these are milliseconds, convert the file "
            "(workbench motion convert --speed 1000)"
        )
    way = np.diff(poses.world_from_reference[:, :, 3], axis=0) / np.diff(time)[:, None]
    speed = np.linalg.norm(way, axis=1)
    jump = np.linalg.norm(np.diff(way, axis=0), axis=1)
    if np.median(speed) > _TRAVEL:
        yield (
            f"the person travels at {np.median(speed):.0f} m/s: is the place in another unit than "
            "the file states (OpenSim: metres), or are the times too short (--speed 0.001)?"
        )
    elif jump.max(initial=0.0) > _FAST:
        frame = int(np.argmax(jump)) + 1
        yield (
            f"the person's speed changes by {jump.max():.0f} m/s between two frames at {time[frame]:g} s: "
            "does the place jump there? The frames without it: --end, --start (end, start in a study)"
        )
    first = np.unique(np.linspace(0, len(time) - 2, _FRAMES).astype(np.int64))
    speeds = _speeds(body, poses, first)
    pair = int(np.argmax(speeds))
    if speeds[pair] > _FAST:
        yield (
            f"a hand, a foot or the head moves at {speeds[pair]:.0f} m/s against the pelvis, at "
            f"{time[first[pair]]:g} s: are the times too short (workbench motion convert --speed 0.001), or "
            "do angles jump there?"
        )


def _speeds(body: Body, poses: Poses, first: Ints) -> Floats:
    """(K,) [m/s] of the fastest of hands, feet and head against the pelvis, from frames (K,) on."""
    ends = [body.segment(name) for name in _ENDS if name in body.segments]
    if not ends or "LT" not in body.segments:
        return np.zeros(len(first))
    at = place(
        body, replace(poses, time=None).rows(np.concatenate([first, first + 1]))
    ).world_from_segment[..., 3]
    before, after = (at[:, ends] - at[:, [body.segment("LT")]]).reshape(2, len(first), len(ends), 3)
    way = np.linalg.norm(after - before, axis=-1).max(axis=1)
    return np.asarray(way / (poses.clock[first + 1] - poses.clock[first]))
