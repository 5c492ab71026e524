"""Show scenes with pyvista, for its window, lights and exports.

VTK ends the whole process if OpenGL does not work. So a child process tries it before anything is
drawn here.
"""

from __future__ import annotations

import math
import subprocess
import sys
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera
from workbench.draw.disks import ghost_strengths
from workbench.draw.scene import FAMILIES, MARKS, Colour, Scene, SceneBody
from workbench.draw.visibility import projected_disks
from workbench.errors import MissingPartError, UsageError
from workbench.model.arrays import Floats
from workbench.model.environment import Environment

__all__ = ["PROBE", "CutPlane", "drawing_fault", "to_pyvista", "window_image"]

PROBE = (
    "import pyvista; p = pyvista.Plotter(off_screen=True, window_size=(16, 16)); p.add_mesh(pyvista.Sphere()); "
    "p.show()"
)
"""Program of the child process that tries OpenGL."""
_PROBE_TIMEOUT = 90.0
"""Time [s] that the child process may take."""
_OPAQUE_COLOUR = (0.74, 0.77, 0.80)
_GLASS_COLOUR = (0.6, 0.75, 0.8)
_GLASS_OPACITY = 0.25
_CUT_MARGIN = 1e-3
"""Distance [m] of the cutting plane in front of the foremost body."""
_PARALLEL_DISTANCE = 10.0
"""Distance [m], beyond the size of the scene, of VTK's camera in a parallel view."""


class CutPlane(NamedTuple):
    """A plane; what of the environment is on the side of its normal is cut away."""

    point: Floats
    """(3,) [m]."""
    normal: Floats
    """(3,) unit vector."""


@cache
def drawing_fault(probe: str = PROBE) -> str:
    """Return the reason why pyvista cannot draw here, "" if it can. A child process tries it once.

    Parameters
    ----------
    probe
        Python program of the child process.
    """
    try:
        trial = subprocess.run(
            [sys.executable, "-c", probe], capture_output=True, timeout=_PROBE_TIMEOUT, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return f"it did not start within {_PROBE_TIMEOUT:.0f} s"
    if trial.returncode == 0:
        return ""
    errors = trial.stderr.decode("utf-8", "replace").strip().splitlines()
    if errors and "No module named 'pyvista'" in errors[-1]:
        return "pyvista is not installed: pip install pyvista"
    code = trial.returncode
    end = f"signal {-code}" if code < 0 else f"code {code}"
    return (
        f"VTK finds no OpenGL to draw with (a trial ended with {end}). Install the system's EGL and GL libraries: "
        "apt install libegl1 libgl1 on Debian and Ubuntu, mesa-libEGL mesa-libGL on Fedora"
    )


def to_pyvista(scene: Scene, *, off_screen: bool = False, cut: CutPlane | None = None) -> Any:
    """Build a pyvista Plotter of a scene; `.show()` opens its window, `.export_html(...)` writes it.

    Every body, ghost, part and mark is an actor with its name. Lengths are metres.

    Parameters
    ----------
    scene
        What is shown.
    off_screen
        Whether no window is opened.
    cut
        A plane that cuts the environment.

    Raises
    ------
    MissingPartError
        If pyvista is not installed or cannot draw here.
    UsageError
        If the scene is empty.
    """
    fault = drawing_fault()
    if fault:
        raise MissingPartError(f"the display pyvista does not work here: {fault}")
    import pyvista

    if not (scene.bodies or scene.environment is not None):
        raise UsageError("scene: nothing to show; give a body or an environment")
    plotter = pyvista.Plotter(off_screen=off_screen)
    plotter.set_background("white")
    opacities = [1.0] * len(scene.bodies) + ghost_strengths(scene).tolist()
    for number, shown in enumerate((*scene.bodies, *scene.ghosts)):
        name = f"{shown.placed.body.name} {number}"
        _add_body(pyvista, plotter, shown, name, opacities[number])
    if scene.environment is not None:
        _add_parts(pyvista, plotter, scene.environment, cut)
    _add_marks(pyvista, plotter, scene)
    return plotter


def _rgb(colour: Colour) -> tuple[float, ...]:
    return tuple(value / 255.0 for value in colour)


def _add_body(pyvista: Any, plotter: Any, shown: SceneBody, name: str, opacity: float) -> None:
    """Add all spheres of a body as one actor."""
    spheres = Scene((shown,)).spheres
    if not len(spheres.radius):
        return
    cloud = pyvista.PolyData(spheres.centre)
    cloud["diameter"] = 2.0 * spheres.radius
    unit_ball = pyvista.Sphere(radius=0.5, theta_resolution=32, phi_resolution=24)
    balls = cloud.glyph(geom=unit_ball, scale="diameter", orient=False)
    colour = _rgb(FAMILIES[shown.colour][1])
    plotter.add_mesh(balls, color=colour, name=name, opacity=opacity, smooth_shading=True)


def _add_parts(pyvista: Any, plotter: Any, environment: Environment, cut: CutPlane | None) -> None:
    """Add each part that is not hidden as an actor."""
    for part in np.flatnonzero(~environment.hidden):
        mesh = _part_mesh(pyvista, environment, int(part))
        if mesh is not None and cut is not None:
            mesh = mesh.clip(normal=cut.normal, origin=cut.point, invert=True)
        if mesh is not None and mesh.n_cells:
            see_through = bool(environment.see_through[part])
            plotter.add_mesh(
                mesh,
                color=_GLASS_COLOUR if see_through else _OPAQUE_COLOUR,
                opacity=_GLASS_OPACITY if see_through else 1.0,
                name=environment.parts[part],
            )


def _part_mesh(pyvista: Any, environment: Environment, part: int) -> Any:
    """Return the triangles of a part as a mesh, None if it has none."""
    polygons = environment.polygons(part)
    first, last = environment.triangle_start[[polygons.start, polygons.stop]]
    triangles = environment.triangles[first:last]
    if not len(triangles):
        return None
    used, corners = np.unique(triangles, return_inverse=True)
    faces = np.column_stack([np.full(len(triangles), 3), corners.reshape(-1, 3)])
    return pyvista.PolyData(environment.vertices[used], faces.reshape(-1))


def _add_marks(pyvista: Any, plotter: Any, scene: Scene) -> None:
    """Add points with labels, and lines of marks with two ends; one actor for each kind."""
    for kind in dict.fromkeys(mark.kind for mark in scene.marks):
        marks = [mark for mark in scene.marks if mark.kind == kind]
        colour = _rgb(MARKS[kind])
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
        ends = [end for mark in marks if mark.to is not None for end in (mark.point, mark.to)]
        if ends:
            lines = pyvista.line_segments_from_points(np.array(ends))
            plotter.add_mesh(lines, color=colour, line_width=3, name=f"lines {kind}")


def window_image(scene: Scene, camera: Camera) -> Image.Image:
    """Draw a scene with pyvista off screen, in the size of the camera. See `to_pyvista`.

    As in the other displays, the environment is cut at the foremost body.
    """
    foremost = float(projected_disks(scene, camera).front.max(initial=-math.inf))
    near = min(foremost + _CUT_MARGIN if math.isfinite(foremost) else math.inf, camera.cut)
    cut = None
    if math.isfinite(near):
        cut = CutPlane(camera.centre + near * camera.toward, camera.toward)
    plotter = to_pyvista(scene, off_screen=True, cut=cut)
    try:
        _set_camera(plotter, camera, scene)
        plotter.enable_anti_aliasing("ssaa")
        return Image.fromarray(np.asarray(plotter.screenshot(return_img=True))[:, :, :3])
    finally:
        plotter.close()


def _set_camera(plotter: Any, camera: Camera, scene: Scene) -> None:
    """Set size and camera of a plotter."""
    plotter.window_size = (camera.width, camera.height)
    distance = camera.distance
    if math.isinf(distance):
        distance = _PARALLEL_DISTANCE + float(np.ptp(scene.bounds, axis=0).max())
    view = plotter.camera
    view.position = tuple(camera.centre + distance * camera.toward)
    view.focal_point = tuple(camera.centre)
    view.up = tuple(camera.up)
    half_height = camera.height / (2.0 * camera.scale)  # [m] at depth 0
    if math.isinf(camera.distance):
        view.parallel_projection = True
        view.parallel_scale = half_height
    else:
        view.view_angle = math.degrees(2.0 * math.atan(half_height / camera.distance))
    plotter.renderer.reset_camera_clipping_range()
