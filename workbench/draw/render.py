"""A source and a look become a file: pictures, strips, films, models and solids, each by one row of
a table."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from workbench.body.solid import body_solid
from workbench.draw.camera import Camera, orbit, standard_view
from workbench.draw.colours import FAMILIES
from workbench.draw.disks import disks
from workbench.draw.display_options import DisplayOptions
from workbench.draw.eye_view import eye_view
from workbench.draw.films.film import film_frames, write_film
from workbench.draw.films.motion import every_pose, frame_times, scene_at
from workbench.draw.films.motion_clips import at_times, common_time_span, evenly_spaced_times
from workbench.draw.films.strip import strip_image, strip_svg
from workbench.draw.lines.circles import circles
from workbench.draw.lines.hidden_lines import HIDDEN
from workbench.draw.lines.outline import outline
from workbench.draw.marks.requested_marks import marks_for_scene
from workbench.draw.scanline import scanline
from workbench.draw.scene import Mark, Scene
from workbench.draw.scene_builder import Source
from workbench.draw.section_planes import apply_section
from workbench.draw.views import fitted_view, framed_views
from workbench.draw.visibility import foremost_depth, projected_disks
from workbench.draw.window import window_image
from workbench.errors import UsageError, one_of
from workbench.files.exports.gltf import Figure, glb_bytes
from workbench.files.exports.solids import stl_bytes, threemf_bytes
from workbench.files.output_file import write_file
from workbench.model.arrays import Floats
from workbench.model.poses import Placed

__all__ = ["camera_for_all_poses", "choose_camera", "drawing", "picture", "render"]

TURN = 6.0  # [s] a film of what does not move goes round it once in this time
Progress = Callable[[int, int], None]
_Painter = Callable[[Scene, Camera], Image.Image]
_Pen = Callable[[Scene, Camera], str]

_PAINTERS: dict[tuple[str, str], _Painter] = {
    ("disks", "flat"): disks,
    ("disks", "shaded"): partial(disks, mode="shaded"),
    ("disks", "hidden_line"): partial(disks, polygons="hidden_line"),
    ("disks", "depth"): partial(disks, mode="depth"),
    ("disks", "id"): partial(disks, mode="id"),
    ("scanline", "surface"): scanline,
    ("scanline", "front"): partial(scanline, rule="front"),
    ("pyvista", "pyvista"): window_image,
}
_PENS: dict[tuple[str, str], _Pen] = {
    (name, style): partial(pen, hidden=style)
    for name, pen in (("outline", outline), ("circles", circles))
    for style in HIDDEN
}


def render(
    source: Source, look: DisplayOptions, out: Path, *, progress: Progress | None = None
) -> None:
    """Write a source into the file `out`, which appears whole or not at all.

    Several poses or cases stand side by side in a picture, follow one another in a film and move in
    a .glb; a film of one pose goes round it. progress(done, all) after each frame of a film.
    UsageError where look and source do not go together; see write_film for films.
    """
    if look.holds == "film":
        _film(source, look, out, progress)
        return
    makers: dict[str, Callable[[Source, DisplayOptions], bytes]] = {
        "raster": _raster,
        "vector": _vector,
        "model": _model,
        "solid": _solid,
    }
    write_file(out, makers[look.holds](source, look))


def picture(scene: Scene, camera: Camera, look: DisplayOptions) -> Image.Image:
    """The scene in a raster display. UsageError where it shows bodies only and there is none."""
    if not scene.bodies and (look.display == "scanline" or look.style in ("id", "depth")):
        raise UsageError(
            f"{look.display} in the style {look.style} shows bodies only; there is none in {scene.title}"
        )
    return _PAINTERS[look.display, look.style](scene, camera)


def drawing(scene: Scene, camera: Camera, look: DisplayOptions) -> str:
    """The scene in a vector display, as SVG text."""
    return _PENS[look.display, look.style](scene, camera)


def choose_camera(scene: Scene, look: DisplayOptions, people: tuple[str, ...] = ()) -> Camera:
    """The camera of a look: a standard view that holds all bodies and ghosts, or what a body's eyes
    see."""
    if look.view.startswith("eye"):
        return _eye(scene, look, people)
    whole = replace(scene, bodies=scene.bodies + scene.ghosts, ghosts=())
    if look.angle:
        camera = standard_view(
            look.view, whole.bounds, width=look.width, height=look.height, field=look.angle
        )
        return fitted_view(whole, camera)
    return framed_views(whole, [look.view], width=look.width, height=look.height)[0][1]


def _eye(scene: Scene, look: DisplayOptions, people: tuple[str, ...]) -> Camera:
    _, _, name = look.view.partition(":")
    if not scene.bodies:
        raise UsageError(f"view {look.view}: there is no body here whose eyes could see")
    if name and name not in people:
        raise UsageError(f"view {look.view}: nobody is called {name!r}; {one_of(name, people)}")
    shown = scene.bodies[people.index(name) if name else 0]
    if look.angle:
        return eye_view(shown, width=look.width, height=look.height, field=look.angle)
    return eye_view(shown, width=look.width, height=look.height)


def _stills(source: Source, look: DisplayOptions) -> Source:
    """The source in the poses that are drawn side by side: of a motion at the moments asked for, or
    at four."""
    if look.at:
        return at_times(source, look.at)
    return (
        at_times(source, evenly_spaced_times(source))
        if source.moving and not source.names
        else source
    )


def _panels(source: Source, look: DisplayOptions) -> list[tuple[Scene, Camera]]:
    """The scene of each pose, and one camera for all; from its eyes each has its own."""
    count = max(len(source.names), 1)
    scenes = [scene_at(source.scene, k, trail=look.trail) for k in range(count)]
    own = look.view.startswith("eye")
    camera = (
        choose_camera(scenes[0], look, source.people)
        if own or count == 1
        else camera_for_all_poses(source, look)
    )
    scenes = _cut(scenes, camera, look, [marks_for_scene(source, scene) for scene in scenes])
    key = [scenes[0], *(replace(scene, key=()) for scene in scenes[1:])]
    return [(scene, choose_camera(scene, look, source.people) if own else camera) for scene in key]


def camera_for_all_poses(source: Source, look: DisplayOptions) -> Camera:
    """A camera that holds all poses and opens the environment in front of them all."""
    every = every_pose(source.scene)
    camera = choose_camera(every, look, source.people)
    return replace(camera, opened=foremost_depth(projected_disks(every, camera)))


def _cut(
    scenes: list[Scene], camera: Camera, look: DisplayOptions, marks: list[tuple[Mark, ...]]
) -> list[Scene]:
    """Scenes with their marks, and all with one environment, cut open as this camera sees it."""
    environment = (
        scenes[0].environment if look.cut is None else apply_section(scenes[0], camera, look.cut)
    )
    return [
        replace(scene, environment=environment, marks=own)
        for scene, own in zip(scenes, marks, strict=True)
    ]


def _raster(source: Source, look: DisplayOptions) -> bytes:
    source = _stills(source, look)
    pictures = [picture(scene, camera, look) for scene, camera in _panels(source, look)]
    image = pictures[0] if len(pictures) == 1 else strip_image(pictures, _captions(source))
    out = io.BytesIO()
    image.save(out, "PNG", optimize=True)
    return out.getvalue()


def _vector(source: Source, look: DisplayOptions) -> bytes:
    source = _stills(source, look)
    drawings = [drawing(scene, camera, look) for scene, camera in _panels(source, look)]
    if len(drawings) == 1:
        return drawings[0].encode()
    return strip_svg(drawings, _captions(source), title=source.scene.title).encode()


def _captions(source: Source) -> list[str]:
    return [name.replace("_", " ") for name in source.names]


def _film(source: Source, look: DisplayOptions, out: Path, progress: Progress | None) -> None:
    if source.moving:
        times = frame_times(*common_time_span(source), fps=look.fps, speed=look.speed)
        count = len(times)
        frames = _moving(source.at(times), look, times)
    elif len(source.names) > 1:
        raise UsageError(
            f"a film shows a motion, or goes round one case; got {len(source.names)} cases without times"
        )
    else:
        count = len(frame_times(0.0, TURN - 1e-6, fps=look.fps, speed=look.speed))
        frames = _round(source, look, count)
    write_film(out, frames, count, fps=look.fps, progress=progress)


def _moving(source: Source, look: DisplayOptions, times: Floats) -> Iterator[Image.Image]:
    """The pictures of a source in its poses at `times` (F,) [s]; ghosts of `look.trail` are a
    quarter of a second of film apart."""
    own = look.view.startswith("eye")
    camera = (
        choose_camera(source.scene, look, source.people)
        if own
        else camera_for_all_poses(source, look)
    )
    environment = (
        source.scene.environment
        if look.cut is None
        else apply_section(source.scene, camera, look.cut)
    )

    def painter(scene: Scene, camera: Camera) -> Image.Image:
        shown = replace(scene, environment=environment, marks=marks_for_scene(source, scene))
        return picture(shown, choose_camera(scene, look, source.people) if own else camera, look)

    every = max(round(look.fps / 4.0), 1)
    return film_frames(
        source.scene, camera, times, painter, stamp=_pace(look), trail=look.trail, every=every
    )


def _pace(look: DisplayOptions) -> str:
    """ "1/10 speed, 25 frames/s"."""
    slow = 1.0 / look.speed
    named = (
        "real time"
        if look.speed == 1.0
        else f"1/{slow:g} speed"
        if slow > 1.0
        else f"{look.speed:g} x speed"
    )
    return f"{named}, {look.fps:g} frames/s"


def _round(source: Source, look: DisplayOptions, count: int) -> Iterator[Image.Image]:
    """`count` pictures once round the scene about its upright axis; the whole of it is in all of
    them."""
    if look.view.startswith("eye"):
        raise UsageError(
            f"view {look.view}: nothing moves here, and what goes round a scene is not its eyes"
        )
    scene = source.scene
    low, high = scene.bounds
    reach = float(np.hypot(*(high - low)[:2])) / 2.0
    middle = (low + high) / 2.0
    half = np.array([reach, reach, (high - low)[2] / 2.0])
    box = np.array([middle - half, middle + half])
    camera = standard_view(look.view, box, width=look.width, height=look.height, field=look.angle)
    if look.cut is not None:
        scene = replace(scene, environment=apply_section(scene, camera, look.cut))
    for frame in range(count):
        yield picture(scene, orbit(camera, math.tau * frame / count), look)


def _model(source: Source, look: DisplayOptions) -> bytes:
    times = None
    if source.moving:
        start, end = common_time_span(source)
        clocks = [
            p.poses.time for p in (*source.persons, *source.under) if p.poses.time is not None
        ]
        times = np.unique(np.concatenate([np.array([start, end]), *clocks]))
        times = times[(times >= start) & (times <= end)]
        source = source.at(times)
    elif len(source.names) > 1:
        raise UsageError(
            f"a .glb file holds one case or a motion; got {len(source.names)} cases without times"
        )
    under = (
        tuple(f"{person.name} ({source.scene.key[1][0]})" for person in source.under)
        if source.scene.key
        else ()
    )
    shown = zip((*source.people, *under), (*source.scene.bodies, *source.scene.ghosts), strict=True)
    figures = [
        Figure(name, _as_long(body.placed, times), _linear(body.colour)) for name, body in shown
    ]
    return glb_bytes(figures, source.scene.environment, times=times)


def _as_long(placed: Placed, times: Floats | None) -> Placed:
    """The poses of a figure; who does not move has one for each time."""
    if times is None or len(placed) == len(times):
        return placed
    world, centres = (
        np.repeat(column[:1], len(times), axis=0)
        for column in (placed.world_from_segment, placed.centres)
    )
    return Placed(placed.body, world, centres, placed.window)


def _linear(family: str) -> tuple[float, float, float]:
    """A colour as glTF has it: linear light, by the transfer function of sRGB (IEC 61966-2-1)."""
    red, green, blue = (
        (share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4)
        for share in (value / 255.0 for value in FAMILIES[family][1])
    )
    return round(red, 6), round(green, 6), round(blue, 6)


def _solid(source: Source, look: DisplayOptions) -> bytes:
    source = at_times(source, look.at) if look.at else source
    if source.moving and not source.names:
        raise UsageError(
            f"a {look.ending} file holds one pose: say at which moment of the motion by --at"
        )
    if not source.scene.bodies:
        raise UsageError(
            f"a {look.ending} file holds the solid of a body; there is none in {source.scene.title}"
        )
    if len(source.names) > 1:
        raise UsageError(f"a {look.ending} file holds one pose; got {', '.join(source.names)}")
    surfaces = {
        name: body_solid(shown.placed, shown.pose)
        for name, shown in zip(source.people, source.scene.bodies, strict=True)
    }
    return stl_bytes(surfaces) if look.ending == ".stl" else threemf_bytes(surfaces)
