"""Choose the frames of a film, and the scene of each frame."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from workbench.draw.scene import Scene, SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats

__all__ = ["MAX_FRAMES", "every_pose", "frame_times", "scene_at"]

MAX_FRAMES = 36_000
"""Largest number of frames of a film: twenty minutes at 30 frames/s. More is a mistake in a unit."""
_ROUNDING_MARGIN = 1e-9
"""Share of a frame by which the last frame may be late."""


def frame_times(start: float, end: float, *, fps: float, speed: float = 1.0) -> Floats:
    """Return the time of the motion at each frame of a film.

    Parameters
    ----------
    start, end
        Time span [s] of the motion. The last frame is not after the end.
    fps
        Frames per second of the film.
    speed
        Seconds of the motion in a second of the film; 0.1 is ten times slow motion.

    Returns
    -------
    Floats
        (F,) times [s].

    Raises
    ------
    UsageError
        If rate or speed are out of range, or there would be more than `MAX_FRAMES`.
    """
    if not (math.isfinite(fps) and 0.1 <= fps <= 240.0):
        raise UsageError(f"film: 0.1 to 240 frames a second are possible, got {fps:g}")
    if not (math.isfinite(speed) and speed > 0.0):
        raise UsageError(
            f"film: a speed above 0 is needed (0.1 is ten times slow motion), got {speed:g}"
        )
    count = math.floor((end - start) * fps / speed + _ROUNDING_MARGIN) + 1
    if not 1 <= count <= MAX_FRAMES:
        raise UsageError(
            f"film: {end - start:g} s at {fps:g} frames/s and speed {speed:g} would be {count} frames; "
            f"1 to {MAX_FRAMES} are possible"
        )
    times: Floats = start + np.arange(count, dtype=np.float64) * (speed / fps)
    return times


def scene_at(scene: Scene, frame: int, *, trail: int = 0, every: int = 1) -> Scene:
    """Return a scene with every body in one of its poses.

    Bodies with a single pose stay as they are. Ghosts of the scene move along.

    Parameters
    ----------
    scene
        Bodies in all their poses.
    frame
        Index of the pose.
    trail, every
        Number of ghosts of earlier poses, and the frames from one to the next.
    """
    moving = [shown for shown in scene.bodies if len(shown.placed) > 1]
    earlier = [frame - k * every for k in range(trail, 0, -1) if frame - k * every >= 0]
    trails = tuple(replace(shown, pose=pose) for pose in earlier for shown in moving)
    bodies = tuple(_in_pose(shown, frame) for shown in scene.bodies)
    ghosts = tuple(_in_pose(shown, frame) for shown in scene.ghosts)
    return replace(scene, bodies=bodies, ghosts=trails + ghosts)


def _in_pose(shown: SceneBody, frame: int) -> SceneBody:
    return replace(shown, pose=frame) if len(shown.placed) > 1 else shown


def every_pose(scene: Scene, *, most: int = 60) -> Scene:
    """Return a scene that holds every body in all its poses, for the camera of a film.

    Parameters
    ----------
    scene
        Bodies in all their poses.
    most
        Approximate largest number of poses; more are thinned out evenly.
    """
    bodies = []
    for shown in (*scene.bodies, *scene.ghosts):
        count = len(shown.placed)
        frames = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
        bodies += [replace(shown, pose=int(k)) for k in frames] if count > 1 else [shown]
    return replace(scene, bodies=tuple(bodies), ghosts=())
