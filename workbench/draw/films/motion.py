"""Motions in pictures: poses between given ones, the times of a film's frames, scenes that move."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from workbench.draw.scene import Scene, SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats

__all__ = ["MAX_FRAMES", "every_pose", "frame_times", "scene_at"]

MAX_FRAMES = 36_000  # twenty minutes at 30 frames a second: more is a mistake in a unit


def frame_times(start: float, end: float, *, fps: float, speed: float = 1.0) -> Floats:
    """(F,) [s] the motion's time at each frame of a film of `fps` frames a second, from start to
    end [s].

    speed: seconds of the motion in a second of the film; 0.1 is ten times slow motion. The last
    frame is the last one that is not after the end. UsageError for a rate or speed that cannot be,
    and beyond MOST_FRAMES.
    """
    if not (math.isfinite(fps) and 0.1 <= fps <= 240.0):
        raise UsageError(f"film: 0.1 to 240 frames a second are possible, got {fps:g}")
    if not (math.isfinite(speed) and speed > 0.0):
        raise UsageError(
            f"film: a speed above 0 is needed (0.1 is ten times slow motion), got {speed:g}"
        )
    count = math.floor((end - start) * fps / speed + 1e-9) + 1
    if not 1 <= count <= MAX_FRAMES:
        raise UsageError(
            f"film: {end - start:g} s at {fps:g} frames/s and speed {speed:g} would be {count} frames; "
            f"1 to {MAX_FRAMES} are possible"
        )
    times: Floats = start + np.arange(count, dtype=np.float64) * (speed / fps)
    return times


def scene_at(scene: Scene, frame: int, *, trail: int = 0, every: int = 1) -> Scene:
    """The scene with every body in its pose `frame`; `trail` ghosts of it `every` frames apart
    before that.

    Bodies of one pose stay as they are. Ghosts that the scene has already move along.
    """
    moving = [shown for shown in scene.bodies if len(shown.placed) > 1]
    earlier = [frame - k * every for k in range(trail, 0, -1) if frame - k * every >= 0]
    ghosts = tuple(replace(shown, pose=at) for at in earlier for shown in moving)
    bodies = tuple(_posed(shown, frame) for shown in scene.bodies)
    along = tuple(_posed(shown, frame) for shown in scene.ghosts)
    return replace(scene, bodies=bodies, ghosts=ghosts + along)


def _posed(shown: SceneBody, frame: int) -> SceneBody:
    return replace(shown, pose=frame) if len(shown.placed) > 1 else shown


def every_pose(scene: Scene, *, most: int = 60) -> Scene:
    """A scene that holds every body in all its poses (at most about `most` of them): what a film's
    camera must hold."""
    bodies = []
    for shown in (*scene.bodies, *scene.ghosts):
        count = len(shown.placed)
        frames = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
        bodies += [replace(shown, pose=int(k)) for k in frames] if count > 1 else [shown]
    return replace(scene, bodies=tuple(bodies), ghosts=())
