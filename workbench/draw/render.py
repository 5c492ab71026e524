"""Write a source into a file: a picture, a strip of pictures, a film, a model or a solid."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from workbench.body.surface import body_solid
from workbench.draw.camera import Camera, orbit, standard_view
from workbench.draw.chart import Chart, chart_image, chart_svg
from workbench.draw.directions import Outlook, direction_chart
from workbench.draw.disks import disks
from workbench.draw.display_options import DisplayOptions
from workbench.draw.eye_view import (
    FIELD,
    eyes_camera,
    looked_at,
    onlooker,
    outlook,
    ruled,
    without_head,
)
from workbench.draw.films.film import every_pose, film_frames, frame_times, scene_at, write_film
from workbench.draw.films.motion_clips import (
    at_times,
    clocks,
    common_time_span,
    evenly_spaced_times,
)
from workbench.draw.films.strip import strip_image, strip_svg
from workbench.draw.ground_plan import ground_level, ground_plan, mirror_plan
from workbench.draw.hidden import cut_off_words, seen_through
from workbench.draw.lines.circles import circles
from workbench.draw.lines.hidden_lines import HIDDEN
from workbench.draw.lines.outline import outline
from workbench.draw.logical_window import window_image
from workbench.draw.marks.annotations import marks_for_scene
from workbench.draw.scanline import scanline
from workbench.draw.scene import FAMILIES, Scene
from workbench.draw.section_planes import apply_section
from workbench.draw.source import Source
from workbench.draw.two_eyes import both_eyes
from workbench.draw.views import fitted_view, framed_views
from workbench.draw.visibility import foremost_depth, projected_disks
from workbench.errors import UsageError
from workbench.files.exports.gltf import Figure, glb_bytes
from workbench.files.exports.solids import stl_bytes, threemf_bytes
from workbench.files.output_file import write_file
from workbench.files.study.rules import load_rule_set
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.units import plain
from workbench.sight.eyes import gaze
from workbench.sight.rules.mirrors import mirror_ground

__all__ = [
    "TURN",
    "camera_for_all_poses",
    "choose_camera",
    "drawing",
    "left_out_words",
    "picture",
    "render",
]

TURN = 6.0
"""Time [s] in which a film of something at rest goes round it once."""
_TRAIL_SPACING = 0.25
"""Time [s] of film between the ghosts of a trail."""

Progress = Callable[[int, int], None]
"""Called with the number of frames that are done, and of all."""
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
    source: Source,
    options: DisplayOptions,
    out: Path,
    *,
    progress: Progress | None = None,
    camera: Camera | None = None,
) -> None:
    """Write a source into a file, which appears whole or not at all.

    Several poses or cases stand side by side in a picture, follow one another in a film and move in
    a .glb. A film of one pose goes round it.

    Parameters
    ----------
    source
        What is drawn.
    options
        How it is drawn, and what the file holds.
    out
        The file.
    progress
        Called after each frame of a film.
    camera
        From where a film is seen, of the size in the options; where it goes round something, it
        begins there. As the options say if None.

    Raises
    ------
    UsageError
        If options and source do not go together. See `write_film` for films.
    """
    if options.holds == "film":
        frames, count = _film(source, options, camera)
        write_film(out, frames, count, fps=options.fps, progress=progress)
        return
    makers: dict[str, Callable[[Source, DisplayOptions], bytes]] = {
        "raster": _raster,
        "vector": _vector,
        "model": _model,
        "solid": _solid,
    }
    write_file(out, makers[options.holds](source, options))


def picture(scene: Scene, camera: Camera, options: DisplayOptions) -> Image.Image:
    """Draw a scene with a raster display.

    Raises
    ------
    UsageError
        If the display shows bodies only and the scene has none.
    """
    bodies_only = options.display == "scanline" or options.style in ("id", "depth")
    if bodies_only and not scene.bodies:
        raise UsageError(
            f"{options.display} in the style {options.style} shows bodies only; there is none in "
            f"{scene.title}"
        )
    paint = _PAINTERS[options.display, options.style]
    return both_eyes(scene, camera, paint) if np.any(camera.aside) else paint(scene, camera)


def sight_chart(scene: Scene, options: DisplayOptions, people: tuple[str, ...]) -> Chart:
    """Chart what somebody sees, by the display of the options.

    Raises
    ------
    UsageError
        If there is nobody with eyes.
    InputError
        If an eye is inside something.
    """
    seen = outlook(scene, people, options.onlooker)
    if options.outline and options.display == "directions":
        rules, _, side = options.outline.partition(":")
        seen = ruled(seen, load_rule_set(rules), side)
    if options.display == "directions":
        return direction_chart(seen, options.style, width=options.width, height=options.height)
    ground = options.ground
    if ground is None:
        if scene.environment is None:
            raise UsageError("the display ground: there is no environment; say --ground HEIGHT")
        ground = ground_level(scene.environment)
    if options.style == "plan":
        return ground_plan(seen, ground, width=options.width, height=options.height)
    if scene.environment is None:
        raise UsageError("the style mirrors: there is no environment, so no mirror")
    return _mirrors(seen, scene.environment, ground, options)


def _mirrors(
    seen: Outlook, environment: Environment, ground: float, options: DisplayOptions
) -> Chart:
    """Chart the ground in the mirrors, with what a rule set asks for where one is named: of a vehicle
    that is as wide as all parts but the mirrors."""
    required = {}
    source = ""
    if options.outline:
        rules = load_rule_set(options.outline.partition(":")[0])
        glasses = {mirror.part for mirror in environment.mirrors}
        standing = [
            environment.triangle_corners(k)[..., 2].max(initial=-math.inf) > ground + 0.01
            for k in range(len(environment.parts))
        ]
        vehicle = [
            name
            for name, stands in zip(environment.parts, standing, strict=True)
            if stands and name not in glasses
        ]
        asked = [one for one in environment.mirrors if f"field_{one.field}" in rules.values]
        eye = seen.eyes.middle[0]
        required = {
            one.name: mirror_ground(
                environment, one, rules, eye=eye, vehicle=vehicle, ground=ground
            )
            for one in asked
        }
        source = rules.told(*dict.fromkeys(f"field_{one.field}" for one in asked))
    return mirror_plan(
        seen,
        environment,
        ground,
        required=required,
        source=source,
        width=options.width,
        height=options.height,
    )


def drawing(scene: Scene, camera: Camera, options: DisplayOptions) -> str:
    """Draw a scene with a vector display; returns SVG text."""
    return _PENS[options.display, options.style](scene, camera)


def choose_camera(scene: Scene, options: DisplayOptions, people: tuple[str, ...] = ()) -> Camera:
    """Return the camera of a picture: a standard view of all bodies and ghosts, or an eye view.

    Parameters
    ----------
    scene, options
        The scene and the options that name the view.
    people
        Names of the bodies, for the view from the eyes of one.
    """
    if options.of_eyes:
        return _eye_camera(scene, options, people)
    whole = replace(scene, bodies=scene.bodies + scene.ghosts, ghosts=())
    width = options.width
    height = options.height
    if not options.angle:
        return framed_views(whole, [options.view], width=width, height=height)[0][1]
    camera = standard_view(
        options.view, whole.bounds, width=width, height=height, field=options.angle
    )
    return fitted_view(whole, camera)


def _eye_camera(scene: Scene, options: DisplayOptions, people: tuple[str, ...]) -> Camera:
    eyes = onlooker(scene, people, options.onlooker).eyes
    target = None
    if options.look_at:
        target = looked_at(scene.environment, options.look_at)
        eyes = gaze(eyes, target).eyes
    kind = options.view.partition(":")[0]
    field = options.angle or FIELD
    return eyes_camera(eyes, kind, target, field=field, width=options.width, height=options.height)


def _with_head_turned(scene: Scene, options: DisplayOptions, people: tuple[str, ...]) -> Scene:
    """Return a scene without the head that turns to look at something: it is not seen by itself."""
    if not options.look_at:
        return scene
    return without_head(scene, onlooker(scene, people, options.onlooker).body)


def _stills(source: Source, options: DisplayOptions) -> Source:
    """Return the source in the poses that stand side by side: of a motion at the times asked for,
    or at four."""
    if options.at:
        return at_times(source, options.at)
    if source.moving and not source.names:
        return at_times(source, evenly_spaced_times(source))
    return source


def _panels(source: Source, options: DisplayOptions) -> list[tuple[Scene, Camera]]:
    """Return the scene of each pose with its camera: one camera for all, unless it is an eye view.

    Only the first panel has the legend.
    """
    count = max(len(source.names), 1)
    scenes = [scene_at(source.scene, k, trail=options.trail) for k in range(count)]
    if options.of_eyes or count == 1:
        camera = choose_camera(scenes[0], options, source.people)
    else:
        camera = camera_for_all_poses(source, options)
    environment = _cut_environment(scenes[0], camera, options)
    panels = []
    for number, scene in enumerate(scenes):
        shown = replace(
            scene,
            environment=environment,
            marks=marks_for_scene(source, scene),
            key=scene.key if number == 0 else (),
        )
        own = choose_camera(shown, options, source.people) if options.of_eyes else camera
        shown = _with_head_turned(shown, options, source.people)
        found = [np.array(mark.point) for mark in shown.marks if mark.kind == "contact"]
        panels.append((seen_through(shown, own, found)[0], own))
    return panels


def left_out_words(source: Source, options: DisplayOptions) -> list[str]:
    """Return what a picture leaves out or looks through, in words; nothing of other files, and of
    what is seen by somebody's eyes."""
    if options.holds not in ("raster", "vector") or options.of_eyes or options.is_chart:
        return []
    scene, camera = _panels(_stills(source, options), options)[0]
    words = cut_off_words(scene, camera)
    before = source.scene.environment
    if before is not None and scene.environment is not None and options.cut is None:
        through = scene.environment.see_through & ~before.see_through
        names = [name for name, one in zip(before.parts, through, strict=True) if one]
        if names:
            words.append(f"see-through, so that what was found is seen: {', '.join(names)}")
    return words


def camera_for_all_poses(source: Source, options: DisplayOptions) -> Camera:
    """Return a camera that holds all poses and cuts the environment in front of them all."""
    camera = choose_camera(every_pose(source.scene), options, source.people)
    return _opened_for_all_poses(source, camera)


def _opened_for_all_poses(source: Source, camera: Camera) -> Camera:
    """Return a camera that cuts the environment in front of all poses."""
    disks_seen = projected_disks(every_pose(source.scene), camera)
    return replace(camera, opened=foremost_depth(disks_seen))


def _cut_environment(scene: Scene, camera: Camera, options: DisplayOptions) -> Environment | None:
    """Return the environment of a scene, cut open if the options say so."""
    return scene.environment if options.cut is None else apply_section(scene, camera, options.cut)


def _raster(source: Source, options: DisplayOptions) -> bytes:
    source = _stills(source, options)
    if options.is_chart:
        pictures = [chart_image(chart) for chart in _charts(source, options)]
    else:
        pictures = [picture(scene, camera, options) for scene, camera in _panels(source, options)]
    image = pictures[0] if len(pictures) == 1 else strip_image(pictures, _captions(source))
    out = io.BytesIO()
    image.save(out, "PNG")
    return out.getvalue()


def _vector(source: Source, options: DisplayOptions) -> bytes:
    source = _stills(source, options)
    if options.is_chart:
        drawings = [chart_svg(chart) for chart in _charts(source, options)]
    else:
        drawings = [drawing(scene, camera, options) for scene, camera in _panels(source, options)]
    if len(drawings) == 1:
        return drawings[0].encode()
    return strip_svg(drawings, _captions(source), title=source.scene.title).encode()


def _charts(source: Source, options: DisplayOptions) -> list[Chart]:
    """Chart what somebody sees in each pose."""
    count = max(len(source.names), 1)
    return [sight_chart(scene_at(source.scene, k), options, source.people) for k in range(count)]


def _captions(source: Source) -> list[str]:
    return [plain(name) for name in source.names]


def _film(
    source: Source, options: DisplayOptions, camera: Camera | None
) -> tuple[Iterator[Image.Image], int]:
    """Return the frames of a film and their number."""
    if source.moving:
        times = frame_times(*common_time_span(source), fps=options.fps, speed=options.speed)
        return _motion_frames(source.at(times), options, times, camera), len(times)
    if len(source.names) > 1:
        raise UsageError(
            "a film shows a motion, or goes round one case; "
            f"got {len(source.names)} cases without times"
        )
    count = len(frame_times(0.0, TURN - 1e-6, fps=options.fps, speed=options.speed))
    return _orbit_frames(source, options, count, camera), count


def _motion_frames(
    source: Source, options: DisplayOptions, times: Floats, camera: Camera | None
) -> Iterator[Image.Image]:
    """Draw a source in its F poses at `times` (F,) [s]."""
    if camera is not None:
        camera = _opened_for_all_poses(source, camera)
    elif options.of_eyes:
        camera = choose_camera(source.scene, options, source.people)
    else:
        camera = camera_for_all_poses(source, options)
    environment = _cut_environment(source.scene, camera, options)

    def painter(scene: Scene, camera: Camera) -> Image.Image:
        shown = replace(scene, environment=environment, marks=marks_for_scene(source, scene))
        if options.is_chart:
            return chart_image(sight_chart(shown, options, source.people))
        if options.of_eyes:
            camera = choose_camera(scene, options, source.people)
            shown = _with_head_turned(shown, options, source.people)
        return picture(shown, camera, options)

    spacing = max(round(options.fps * _TRAIL_SPACING), 1)
    stamp = _speed_text(options)
    return film_frames(
        source.scene, camera, times, painter, stamp=stamp, trail=options.trail, every=spacing
    )


def _speed_text(options: DisplayOptions) -> str:
    """Write the speed of a film, such as "1/10 speed, 25 frames/s"."""
    if options.speed == 1.0:
        pace = "real time"
    elif options.speed < 1.0:
        pace = f"1/{1.0 / options.speed:g} speed"
    else:
        pace = f"{options.speed:g} x speed"
    return f"{pace}, {options.fps:g} frames/s"


def _orbit_frames(
    source: Source, options: DisplayOptions, count: int, camera: Camera | None
) -> Iterator[Image.Image]:
    """Draw `count` pictures once round the scene about its upright axis: all of it in each, or as a
    camera sees it first."""
    if options.of_eyes or options.is_chart:
        raise UsageError(
            f"view {options.view}: nothing moves here, and what goes round a scene is not its eyes"
        )
    scene = source.scene
    if camera is None:
        camera = _camera_around(scene, options)
    scene = replace(scene, environment=_cut_environment(scene, camera, options))
    for frame in range(count):
        yield picture(scene, orbit(camera, math.tau * frame / count), options)


def _camera_around(scene: Scene, options: DisplayOptions) -> Camera:
    """Return a camera that sees the whole scene from every direction about the upright axis."""
    low, high = scene.bounds
    radius = float(np.hypot(*(high - low)[:2])) / 2.0
    middle = (low + high) / 2.0
    half = np.array([radius, radius, (high - low)[2] / 2.0])
    return standard_view(
        options.view,
        np.array([middle - half, middle + half]),
        width=options.width,
        height=options.height,
        field=options.angle,
    )


def _model(source: Source, options: DisplayOptions) -> bytes:
    """Write a .glb model of the bodies and the environment, with the motion if there is one."""
    times = None
    if source.moving:
        times = _model_times(source)
        source = source.at(times)
    elif len(source.names) > 1:
        raise UsageError(
            f"a .glb file holds one case or a motion; got {len(source.names)} cases without times"
        )
    scene = source.scene
    behind: tuple[str, ...] = ()
    if scene.key:
        behind = tuple(f"{person.name} ({scene.key[1][0]})" for person in source.under)
    shown = zip((*source.people, *behind), (*scene.bodies, *scene.ghosts), strict=True)
    figures = [
        Figure(name, _repeat_pose(body.placed, times), _linear_rgb(body.colour))
        for name, body in shown
    ]
    return glb_bytes(figures, scene.environment, times=times)


def _model_times(source: Source) -> Floats:
    """Return the times (F,) [s] of all frames of all people in the time span they share."""
    start, end = common_time_span(source)
    times = np.unique(np.concatenate([np.array([start, end]), *clocks(source)]))
    return times[(times >= start) & (times <= end)]


def _repeat_pose(placed: Placed, times: Floats | None) -> Placed:
    """Return one pose for each time; somebody at rest has a single one, which is repeated."""
    if times is None or len(placed) == len(times):
        return placed
    world, centres = (
        np.repeat(column[:1], len(times), axis=0)
        for column in (placed.world_from_segment, placed.centres)
    )
    return Placed(placed.body, world, centres, placed.window)


def _linear_rgb(family: str) -> tuple[float, float, float]:
    """Return a colour in linear light, as glTF wants it, by the sRGB transfer function
    (IEC 61966-2-1)."""
    red, green, blue = (
        (share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4)
        for share in (value / 255.0 for value in FAMILIES[family][1])
    )
    return round(red, 6), round(green, 6), round(blue, 6)


def _solid(source: Source, options: DisplayOptions) -> bytes:
    """Write the surface of each body as one solid."""
    source = at_times(source, options.at) if options.at else source
    if source.moving and not source.names:
        raise UsageError(
            f"a {options.ending} file holds one pose: say at which moment of the motion by --at"
        )
    if not source.scene.bodies:
        raise UsageError(
            f"a {options.ending} file holds the solid of a body; there is none in "
            f"{source.scene.title}"
        )
    if len(source.names) > 1:
        raise UsageError(f"a {options.ending} file holds one pose; got {', '.join(source.names)}")
    surfaces = {
        name: body_solid(shown.placed, shown.pose)
        for name, shown in zip(source.people, source.scene.bodies, strict=True)
    }
    return stl_bytes(surfaces) if options.ending == ".stl" else threemf_bytes(surfaces)
