"""Pictures of motions: rows of positions with the belts where they run, and a film."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.body.forward import place
from workbench.draw.camera import Camera, standard_view
from workbench.draw.disks import disks
from workbench.draw.films.film import frame_times, stamp_text, write_film
from workbench.draw.films.strip import strip_image
from workbench.draw.lines.outline import outline
from workbench.draw.lines.svg import compacted
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.section_planes import cut_away
from workbench.errors import MissingPartError
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.report.sentences import milliseconds
from workbench.study.crash.belts import with_belts

__all__ = ["FILM_CAPTION", "motion_film", "motion_positions", "motion_scene"]

FILM_CAPTION = "The motion in slow time."
_SIZE = 420
_FILM = (620, 500)
_FPS = 12.5
_SECONDS = 5.0
_COLOURS = ("warm", "blue")


def motion_scene(motion: MotionCase, time: float, colour: str) -> Scene:
    """Return a motion at a time [s] with its belts, in a family of colours."""
    poses = poses_at(motion.motion, np.clip([time], *motion.motion.clock[[0, -1]]))
    placed = place(motion.body, poses)
    return Scene(
        (SceneBody(placed, 0, colour),),
        with_belts(motion.cabin, motion.belts, placed, pose=0),
        title=f"{motion.person} {motion.name}".strip(),
    )


def motion_positions(motions: Sequence[MotionCase], times: Floats) -> list[tuple[list[str], str]]:
    """SVG of a row of positions for each motion, and from where they are seen: the side that shows
    most of the way.

    Parameters
    ----------
    motions
        The motions.
    times
        (F,) [s].
    """
    shown = _shown(motions, times)
    camera = _camera(shown, (_SIZE, _SIZE))
    rows = []
    for row, (who, placed) in enumerate(shown):
        near = _opened(who.cabin, placed, camera)
        scenes = [
            replace(scene, title=f"{scene.title} at {milliseconds(time)}")
            for k, time in enumerate(times.tolist())
            for scene in [_scene(who, placed, k, near, row)]
        ]
        rows.append(([compacted(outline(scene, camera)) for scene in scenes], camera.name))
    return rows


def motion_film(
    motions: Sequence[MotionCase], *, progress: Callable[[str], None] | None = None
) -> tuple[str, bytes]:
    """Name and bytes of a film of motions side by side: MP4 where its encoder is there, else
    GIF."""
    start, end = motions[0].motion.clock[[0, -1]]
    times = frame_times(start, end, fps=_FPS, speed=max(float(end - start), 1e-3) / _SECONDS)
    with tempfile.TemporaryDirectory() as folder:
        for name in ("motion.mp4", "motion.gif"):
            path = Path(folder) / name
            frames = _film_frames(motions, times, progress or (lambda words: None))
            try:
                write_film(path, frames, len(times), fps=_FPS)
            except MissingPartError:
                continue
            break
        return path.name, path.read_bytes()


def _film_frames(
    motions: Sequence[MotionCase], times: Floats, progress: Callable[[str], None]
) -> Iterator[Any]:
    """Images of the motions side by side at times (F,) [s]; progress is called after each."""
    shown = _shown(motions, times)
    camera = _camera(shown, _FILM)
    near = [_opened(who.cabin, placed, camera) for who, placed in shown]
    names = [who.name for who in motions]
    for k, time in enumerate(times.tolist()):
        panels = [
            disks(_scene(who, placed, k, near[n], n), camera)
            for n, (who, placed) in enumerate(shown)
        ]
        yield stamp_text(strip_image(panels, names), milliseconds(time))
        progress(f"frame {k + 1} of {len(times)} of the film")


def _shown(motions: Sequence[MotionCase], times: Floats) -> list[tuple[MotionCase, Placed]]:
    """Each motion and its body at times (F,), held at its ends beyond them."""
    return [
        (who, place(who.body, poses_at(who.motion, np.clip(times, *who.motion.clock[[0, -1]]))))
        for who in motions
    ]


def _camera(shown: list[tuple[MotionCase, Placed]], size: tuple[int, int]) -> Camera:
    """What holds all bodies and the anchors of their belts. size: of the picture [pixels]."""
    ends = []
    for who, placed in shown:
        radius = placed.body.radius[0, :, None]
        ends.append((placed.centres - radius).min(axis=(0, 1)))
        ends.append((placed.centres + radius).max(axis=(0, 1)))
        points = (point for belt in who.belts for point in belt.points)
        ends += [np.array(point.at) for point in points if point.segment < 0]
    low = np.min(ends, axis=0)
    high = np.max(ends, axis=0)
    view = "left" if high[0] - low[0] >= high[1] - low[1] else "front"
    return standard_view(view, np.array([low - 0.1, high + 0.1]), width=size[0], height=size[1])


def _opened(cabin: Environment, placed: Placed, camera: Camera) -> Environment:
    """The cabin without its half on the viewer's side of the body's middle, so that no wall comes
    and goes."""
    axis = np.eye(3)[1 if camera.name == "left" else 0]
    middle = placed.centres[0].mean(axis=0)
    reach = cabin.vertices @ axis
    return cut_away(cabin, middle, axis) if reach.min() < middle @ axis < reach.max() else cabin


def _scene(study: MotionCase, placed: Placed, pose: int, cabin: Environment, row: int) -> Scene:
    """The body in one pose with its belts. row: that of the motion, which gives the colour."""
    return Scene(
        (SceneBody(placed, pose, _COLOURS[row % len(_COLOURS)]),),
        with_belts(cabin, study.belts, placed, pose=pose),
        title=f"{study.person} {study.name}".strip(),
    )
