"""How fast the displays are, beside others in the same run: python benchmarks/displays.py [seconds
a row]

CPU seconds of this process, the best of several; the goals stand beside the figures. The bodies are
the median man with spheres added half-way between neighbours, 1,000 or 700 in all. Others are timed
where they are installed: Pillow, OpenCV (pip install opencv-python-headless), VTK by pyvista, off
screen in software.
"""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable
from contextlib import redirect_stderr
from dataclasses import replace
from time import process_time

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import workbench as wb
from workbench.draw.camera import Camera, standard_view
from workbench.draw.disks import disks
from workbench.draw.lines.circles import circles
from workbench.draw.lines.outline import outline
from workbench.draw.scene import Scene, SceneBody, Spheres
from workbench.draw.scene_builder import scene_of
from workbench.draw.sphere_raster import (
    cast_rays,
    painter_item_buffer,
    project_disks,
    shade_surfaces,
)
from workbench.draw.views import fitted_view
from workbench.model.arrays import Ints
from workbench.model.environment import Environment

WALK = {
    "LH": ("flexion", 25.0, 0.0),
    "RH": ("flexion", 25.0, math.pi),
    "LK": ("flexion", 35.0, 0.7),
    "RK": ("flexion", 35.0, 0.7 + math.pi),
    "LS": ("flexion", 25.0, math.pi),
    "RS": ("flexion", 25.0, 0.0),
}


def dense(count: int) -> Scene:
    """The median man, upright, with `count` spheres: neighbours of a segment have others half-way
    between them."""
    body = wb.load_body("bubbleman")
    centre = body.centre[0]
    segment = body.sphere_segment
    apart = np.linalg.norm(centre[:, None] - centre[None], axis=2)
    near = np.argsort(
        apart + 9.0 * (np.eye(len(centre)) + (segment[:, None] != segment[None])), axis=1
    )
    rows = [(centre, body.radius[0])]
    rows += [
        ((centre + centre[near[:, k]]) / 2, (body.radius[0] + body.radius[0][near[:, k]]) / 2)
        for k in range(3)
    ]
    owner = np.tile(segment, 4)[:count]
    order = np.argsort(owner, kind="stable")
    made_centre = np.concatenate([row[0] for row in rows])[:count][order]
    start = np.searchsorted(owner[order], np.arange(len(body.segments) + 1))
    radius = np.concatenate([row[1] for row in rows])[:count][order]
    topology = replace(
        body.topology,
        start=start,
        sphere_names=("",) * count,
        sphere_direction=np.full(count, -1),
        blend_joint=np.full(count, -1),
    )
    made = replace(
        body,
        topology=topology,
        centre=made_centre[None],
        radius=radius[None],
        twist_share=np.zeros((1, count)),
        blend_share=np.zeros((1, count)),
    )
    return Scene((SceneBody(wb.place(made, wb.pose(made, {}, position=(0.0, 0.0, 0.95)))),))


def triangles(count: int) -> Environment:
    """The trainer with its polygons cut into about `count` triangles, each a polygon."""
    trainer = wb.load_environment("trainer")
    corners = trainer.vertices[trainer.triangles]
    polygon = np.repeat(np.arange(len(trainer.normal)), np.diff(trainer.triangle_start))
    while len(corners) < count:
        middles = (corners + np.roll(corners, -1, axis=1)) / 2.0
        one = [
            np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)
        ]
        corners = np.concatenate([*one, middles])
        polygon = np.tile(polygon, 4)
    order = np.argsort(polygon, kind="stable")
    corners = corners[order]
    polygon = polygon[order]
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    centre = corners.mean(axis=1)
    return replace(
        trainer,
        vertices=corners.reshape(-1, 3),
        triangles=faces,
        triangle_start=np.arange(len(faces) + 1),
        edges=np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2),
        edge_start=3 * np.arange(len(faces) + 1),
        normal=trainer.normal[polygon],
        offset=trainer.offset[polygon],
        circle_centre=centre,
        circle_radius=np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1),
        part_start=np.searchsorted(
            trainer.polygon_part[polygon], np.arange(len(trainer.parts) + 1)
        ),
    )


def walking(scene: Scene, frames: int) -> list[Spheres]:
    """Spheres of one second of walking, 30 frames a second, two steps."""
    body = scene.bodies[0].placed.body
    found = []
    for frame in range(frames):
        turn = math.tau * frame / 30.0
        angles = {
            joint: {motion: size * max(math.sin(turn + at), -0.3)}
            for joint, (motion, size, at) in WALK.items()
        }
        placed = wb.place(body, wb.pose(body, angles, position=(1.4 * frame / 30.0, 0.0, 0.95)))
        found.append(Scene((SceneBody(placed),)).spheres)
    return found


def best(work: Callable[[], object], seconds: float) -> float:
    """[s] the least CPU time of a call, after one to warm up."""
    work()
    least = math.inf
    began = process_time()
    while process_time() - began < seconds:
        start = process_time()
        work()
        least = min(least, process_time() - start)
    return least


def pillow(disk: np.ndarray, order: np.ndarray, size: tuple[int, int]) -> Image.Image:
    """The same disks by Pillow's ellipses."""
    image = Image.new("L", size, 255)
    draw = ImageDraw.Draw(image)
    for grey, (x, y, r) in enumerate(disk[order].tolist()):
        draw.ellipse((x - r, y - r, x + r, y + r), fill=grey % 250)
    return image


def opencv(disk: np.ndarray, order: np.ndarray, size: tuple[int, int]) -> object:
    """The same disks by OpenCV's circles, with four bits behind the point."""
    import cv2

    picture = np.full((size[1], size[0]), 255, dtype=np.uint8)
    rows = np.round((disk[order] - [0.5, 0.5, 0.0]) * 16).astype(int).tolist()
    for grey, (x, y, r) in enumerate(rows):
        cv2.circle(picture, (x, y), r, grey % 250, -1, cv2.LINE_8, 4)
    return picture


def vtk_frames(spheres: Spheres, size: tuple[int, int], seconds: float) -> dict[str, float]:
    """[s] a frame by VTK: ray-cast sphere impostors and 8 x 8 sphere glyphs; empty where it cannot
    draw."""
    from pyvista import Plotter, PolyData, Sphere

    found = {}
    for kind in ("impostors", "glyphs"):
        plotter = Plotter(off_screen=True, window_size=list(size))
        plotter.disable_anti_aliasing()
        points = PolyData(spheres.centre.astype(np.float32))
        points["r"] = spheres.radius.astype(np.float32)
        if kind == "impostors":
            from vtkmodules.vtkRenderingCore import vtkActor
            from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLSphereMapper

            mapper = vtkOpenGLSphereMapper()
            mapper.SetInputData(points)
            mapper.SetScaleArray("r")
            actor = vtkActor()
            actor.SetMapper(mapper)
            plotter.add_actor(actor)
        else:
            ball = Sphere(radius=1.0, theta_resolution=8, phi_resolution=8)
            plotter.add_mesh(points.glyph(scale="r", geom=ball, orient=False))
        plotter.show(auto_close=False)

        def frame(shown: Plotter = plotter) -> object:
            shown.camera.azimuth += 1.0
            shown.render()
            return shown.screenshot(return_img=True)

        found[kind] = best(frame, seconds)
        plotter.close()
    return found


def row(what: str, figure: str, goal: str) -> None:
    """One line of the table."""
    print(f"{what:<58}{figure:>22}   {goal}", flush=True)


def lit(spheres: Spheres, camera: Camera, order: Ints) -> NDArray[np.uint8]:
    """A shaded picture, sorted from an order."""
    found = project_disks(spheres, camera, last=order)
    return shade_surfaces(
        found,
        cast_rays(found, camera),
        camera,
        np.tile([250.0, 238.0, 220.0], (len(found.front), 1)),
    )


def rasters(scene: Scene, seconds: float) -> None:
    """Flat and shaded frames beside the others'."""
    spheres = scene.spheres
    for size, goal, times in (((320, 240), 4000, (4.0, 4.0)), ((1920, 1080), 500, (1.7, 2.0))):
        camera = standard_view("front", scene.bounds, width=size[0], height=size[1], margin=0.03)
        flat = project_disks(spheres, camera)
        ours = best(
            lambda c=camera, last=flat.all: painter_item_buffer(
                project_disks(spheres, c, last=last), c
            ),
            seconds,
        )
        row(f"disks flat, {size[0]} x {size[1]}", f"{1 / ours:.0f} frames/s", f"goal {goal}")
        for name, other, share in (("Pillow", pillow, times[0]), ("OpenCV", opencv, times[1])):
            try:
                theirs = best(lambda o=other, f=flat, s=size: o(f.disk, f.order, s), seconds)
                row(
                    f"    {name}",
                    f"{1 / theirs:.0f} frames/s",
                    f"ours {theirs / ours:.1f} times, goal {share}",
                )
            except ImportError:
                row(f"    {name}", "not installed", "")
    for size in ((320, 240), (1920, 1080)):
        camera = standard_view("front", scene.bounds, width=size[0], height=size[1], margin=0.03)
        order = project_disks(spheres, camera).all
        ours = best(lambda c=camera, o=order: lit(spheres, c, o), seconds)
        goal_text = "goal 60" if size[0] == 1920 else ""
        row(
            f"disks shaded with depth buffer, {size[0]} x {size[1]}",
            f"{1 / ours:.0f} frames/s",
            goal_text,
        )
        try:
            with redirect_stderr(io.StringIO()):
                found = vtk_frames(spheres, size, seconds)
        except (ImportError, RuntimeError, OSError):
            found = {}
        for kind, theirs in found.items():
            row(
                f"    VTK {kind} in software",
                f"{1 / theirs:.1f} frames/s",
                f"ours {theirs / ours:.1f} times, goal 6",
            )


def moves(scene: Scene) -> None:
    """How much a frame of walking changes the order: most where limbs swing along the view, nothing
    across it."""
    spheres = walking(scene, 31)
    for view in ("left", "top", "corner", "front"):
        camera = standard_view(view, scene.bounds, width=320, height=240)
        last = project_disks(spheres[0], camera)
        counted = []
        for frame in spheres[1:]:
            last = project_disks(frame, camera, last=last.all)
            counted.append(last.moves / len(frame.radius))
        figure = f"{np.mean(counted):.2f} n moves"
        row(
            f"re-sort, walking, 30 frames a second, {view}",
            figure,
            f"goal 3 n; most {max(counted):.2f} n",
        )


def vectors(seconds: float) -> None:
    """SVG texts."""
    scene = dense(1000)
    camera = standard_view("front", scene.bounds, width=800, height=800)
    row(
        "circles as SVG, 1,000 spheres",
        f"{1e3 * best(lambda: circles(scene, camera), seconds):.2f} ms",
        "goal 3",
    )
    body = dense(700)
    views: list[tuple[str, Camera, int]] = []
    for view in ("front", "corner"):
        flat = standard_view(view, body.bounds, width=800, height=800)
        wide = standard_view(view, body.bounds, width=800, height=800, field=math.radians(40))
        views += [
            (f"{view}, parallel", flat, 3),
            (f"{view}, perspective", fitted_view(body, wide), 10),
        ]
    for name, seen, goal in views:
        taken = best(lambda c=seen: outline(body, c), seconds)
        row(f"outline as SVG, 700 spheres, {name}", f"{1e3 * taken:.2f} ms", f"goal {goal}")


def cockpit(seconds: float) -> None:
    """A body among 50,000 triangles."""
    scene = replace(scene_of("trainer_clearance"), environment=triangles(50_000))
    camera = fitted_view(scene, standard_view("corner", scene.bounds, width=1280, height=720))
    count = len(scene.environment.triangles) if scene.environment else 0
    for mode in ("flat", "shaded"):
        taken = best(lambda m=mode: disks(scene, camera, mode=m, supersample=1), seconds)
        row(
            f"cockpit, {count:,} triangles, {mode}, 1280 x 720",
            f"{1 / taken:.1f} frames/s",
            "goal 10",
        )


def main(seconds: float) -> None:
    """Print the table."""
    scene = dense(1000)
    rasters(scene, seconds)
    moves(scene)
    vectors(seconds)
    cockpit(seconds)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1.0)
