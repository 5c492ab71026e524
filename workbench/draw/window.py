"""Scenes in pyvista, for those who want its window, lights and exports: spheres, parts and marks as
named actors.

Without a working OpenGL, VTK ends the whole process: before anything is drawn here, a child process
tries it.
"""

from __future__ import annotations

import math
import subprocess
import sys
from functools import cache
from typing import Any

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera
from workbench.draw.colours import FAMILIES, MARKS
from workbench.draw.ghosts import ghost_strengths
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.visibility import projected_disks
from workbench.errors import MissingPartError, UsageError
from workbench.model.arrays import Floats
from workbench.model.environment import Environment

__all__ = ["PROBE", "drawing_fault", "to_pyvista", "window_image"]

PROBE = (
    "import pyvista; p = pyvista.Plotter(off_screen=True, window_size=(16, 16)); p.add_mesh(pyvista.Sphere()); "
    "p.show()"
)
_PATIENCE = 90.0  # [s]
_GREY = (0.74, 0.77, 0.80)
_GLASS = (0.6, 0.75, 0.8)


@cache
def drawing_fault(probe: str = PROBE) -> str:
    """Why pyvista cannot draw here, in words, "" where it can; tried once, in a child process."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", probe], capture_output=True, timeout=_PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return f"it did not start within {_PATIENCE:.0f} s"
    if done.returncode == 0:
        return ""
    said = done.stderr.decode("utf-8", "replace").strip().splitlines()
    if "No module named 'pyvista'" in (said[-1] if said else ""):
        return "pyvista is not installed: pip install pyvista"
    end = f"signal {-done.returncode}" if done.returncode < 0 else f"code {done.returncode}"
    return (
        f"VTK finds no OpenGL to draw with (a trial ended with {end}). Install the system's EGL and GL libraries: "
        "apt install libegl1 libgl1 on Debian and Ubuntu, mesa-libEGL mesa-libGL on Fedora"
    )


def to_pyvista(
    scene: Scene, *, off_screen: bool = False, cut: tuple[Floats, Floats] | None = None
) -> Any:
    """A pyvista Plotter that holds the scene; `.show()` opens its window, `.export_html(...)` and
    others write it.

    Every body, ghost, part and mark is an actor by its name; lengths are metres. cut: a point and a
    unit normal (3,); what of the environment is beyond this plane is cut away. MissingPartError
    where pyvista is not installed or cannot draw here; UsageError for a scene with nothing in it.
    """
    fault = drawing_fault()
    if fault:
        raise MissingPartError(f"the display pyvista does not work here: {fault}")
    import pyvista

    if not (scene.bodies or scene.environment is not None):
        raise UsageError("scene: nothing to show; give a body or an environment")
    plotter = pyvista.Plotter(off_screen=off_screen)
    plotter.set_background("white")
    strengths = [1.0] * len(scene.bodies) + ghost_strengths(scene).tolist()
    for number, (shown, opacity) in enumerate(
        zip((*scene.bodies, *scene.ghosts), strengths, strict=True)
    ):
        _add_body(pyvista, plotter, shown, (f"{shown.placed.body.name} {number}", opacity))
    if scene.environment is not None:
        _add_parts(pyvista, plotter, scene.environment, cut)
    _add_marks(pyvista, plotter, scene)
    return plotter


def _add_body(pyvista: Any, plotter: Any, shown: SceneBody, how: tuple[str, float]) -> None:
    """One actor of all spheres of a body."""
    spheres = Scene((shown,)).spheres
    if not len(spheres.radius):
        return
    cloud = pyvista.PolyData(spheres.centre)
    cloud["diameter"] = 2.0 * spheres.radius
    ball = pyvista.Sphere(radius=0.5, theta_resolution=32, phi_resolution=24)
    balls = cloud.glyph(geom=ball, scale="diameter", orient=False)
    colour = tuple(value / 255.0 for value in FAMILIES[shown.colour][1])
    plotter.add_mesh(balls, color=colour, name=how[0], opacity=how[1], smooth_shading=True)


def _add_parts(
    pyvista: Any, plotter: Any, environment: Environment, cut: tuple[Floats, Floats] | None
) -> None:
    """One actor a part that is not hidden; see-through parts let three quarters of the light
    through."""
    for part in np.flatnonzero(~environment.hidden):
        rows = environment.polygons(int(part))
        first, last = environment.triangle_start[[rows.start, rows.stop]]
        triangles = environment.triangles[first:last]
        if not len(triangles):
            continue
        used, corners = np.unique(triangles, return_inverse=True)
        faces = np.column_stack([np.full(len(triangles), 3), corners.reshape(-1, 3)])
        mesh = pyvista.PolyData(environment.vertices[used], faces.reshape(-1))
        if cut is not None:
            mesh = mesh.clip(normal=cut[1], origin=cut[0], invert=True)
        if mesh.n_cells:
            clear = bool(environment.see_through[part])
            plotter.add_mesh(
                mesh,
                color=_GLASS if clear else _GREY,
                opacity=0.25 if clear else 1.0,
                name=environment.parts[part],
            )


def _add_marks(pyvista: Any, plotter: Any, scene: Scene) -> None:
    """Points with labels, and lines of those that have two ends, a group for each kind."""
    for kind in dict.fromkeys(mark.kind for mark in scene.marks):
        marks = [mark for mark in scene.marks if mark.kind == kind]
        colour = tuple(value / 255.0 for value in MARKS[kind])
        plotter.add_point_labels(
            np.array([mark.point for mark in marks]),
            [mark.label or " " for mark in marks],
            text_color=colour,
            point_color=colour,
            point_size=10,
            font_size=14,
            shape=None,
            always_visible=True,
            name=f"marks {kind}",
        )
        lines = np.array([(mark.point, mark.to) for mark in marks if mark.to is not None]).reshape(
            -1, 3
        )
        if len(lines):
            cells = np.column_stack(
                [np.full(len(lines) // 2, 2), np.arange(len(lines)).reshape(-1, 2)]
            )
            plotter.add_mesh(
                pyvista.PolyData(lines, lines=cells.reshape(-1)),
                color=colour,
                line_width=3,
                name=f"lines {kind}",
            )


def window_image(scene: Scene, camera: Camera) -> Image.Image:
    """The scene drawn by pyvista off screen, seen through a camera; width x height of the camera.
    See to_pyvista.

    As in the other displays nothing of the environment is drawn that is nearer than every body.
    """
    fronts = projected_disks(scene, camera).front
    near = min(float(fronts.max(initial=-math.inf)) + 1e-3 if len(fronts) else math.inf, camera.cut)
    cut = (camera.centre + near * camera.toward, camera.toward) if math.isfinite(near) else None
    plotter = to_pyvista(scene, off_screen=True, cut=cut)
    try:
        plotter.window_size = (camera.width, camera.height)
        view = plotter.camera
        away = (
            camera.distance
            if math.isfinite(camera.distance)
            else 10.0 + float(np.ptp(scene.bounds, axis=0).max())
        )
        view.position = tuple(camera.centre + away * camera.toward)
        view.focal_point = tuple(camera.centre)
        view.up = tuple(camera.up)
        half = camera.height / (
            2.0 * camera.scale
        )  # [m] from the middle to the top, at the centre's depth
        if math.isinf(camera.distance):
            view.parallel_projection = True
            view.parallel_scale = half
        else:
            view.view_angle = math.degrees(2.0 * math.atan(half / camera.distance))
        plotter.renderer.reset_camera_clipping_range()
        plotter.enable_anti_aliasing("ssaa")
        return Image.fromarray(np.asarray(plotter.screenshot(return_img=True))[:, :, :3])
    finally:
        plotter.close()
