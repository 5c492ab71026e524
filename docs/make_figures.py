"""Make the pictures of README.md and docs/: Figures 1, 2, 3, 5, 6 and 7 of the paper, done again.
Run from anywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import workbench as wb
from workbench.draw.camera import Camera
from workbench.draw.disks import disks
from workbench.draw.films.film import every_pose, film_frames, frame_times, scene_at, write_film
from workbench.draw.films.strip import strip_image
from workbench.draw.lines.circles import circles
from workbench.draw.lines.outline import outline
from workbench.draw.scanline import scanline
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.scene_builder import build_source, scene_of
from workbench.draw.sphere_raster import painter_item_buffer, project_disks
from workbench.draw.views import framed_views
from workbench.model.joint_angles import poses_at

IMAGES = Path(__file__).resolve().parent / "images"
TIMES = np.array([0.0, 0.06, 0.085, 0.1])  # [s]; the head is deepest in the coaming at the last


def grey_disks(scene: Scene, camera: Camera) -> Image.Image:
    """The paper's picture: one grey a sphere by the depth of its frontmost point, lighter the
    nearer, on white."""
    found = project_disks(scene.spheres, camera)
    sphere = painter_item_buffer(found, camera)
    far, near = found.front[found.order[[0, -1]]]
    grey = (40 + 195 * (np.maximum(found.front, far) - far) / (near - far)).astype(np.uint8)
    return Image.fromarray(np.where(sphere < 0, 255, grey[sphere]).astype(np.uint8))


def figures_1_and_2() -> None:
    """A standing man as circles, and as grey disks in the paper's 240 x 320; and by every third
    scan line."""
    scene = scene_of("bubbleman", posture="standing")
    (IMAGES / "figure_1_circles.svg").write_text(
        circles(scene, framed_views(scene, ["corner"], width=260, height=480)[0][1])
    )
    camera = framed_views(scene, ["corner"], width=240, height=320)[0][1]
    grey_disks(scene, camera).save(IMAGES / "figure_2_disks.png", optimize=True)
    scanline(scene, camera, spacing=3).save(IMAGES / "scanline.png", optimize=True)


def figures_3_and_5() -> None:
    """A seated man as a line drawing, and in light; his head, his hands and what joins them."""
    scene = scene_of("bubbleman", posture="seated")
    camera = framed_views(scene, ["corner"], width=420, height=440)[0][1]
    (IMAGES / "figure_3_outline.svg").write_text(outline(scene, camera))
    disks(scene, camera, mode="shaded").save(IMAGES / "shaded.png", optimize=True)
    person = build_source("bubbleman", poses="seated").persons[0]
    placed = wb.place(person.body, person.poses, window=("H", "LHN", "RHN"))
    part = Scene((SceneBody(placed, 0, "blue"),), title="head and hands")
    camera = framed_views(part, ["corner"], width=420, height=440)[0][1]
    disks(part, camera).save(IMAGES / "figure_5_window.png", optimize=True)


def trainer() -> None:
    """Two men in the trainer as disks, and in light."""
    scene = scene_of("trainer_clearance")
    for name, mode, width, height in (
        ("trainer", "flat", 760, 760),
        ("trainer_shaded", "shaded", 640, 480),
    ):
        camera = framed_views(scene, ["corner"], width=width, height=height)[0][1]
        picture = disks(scene, camera, mode=mode)
        picture.quantize(256, dither=Image.Dither.NONE).save(IMAGES / f"{name}.png", optimize=True)


def figure_6() -> None:
    """Two men in the trainer as a hidden-line drawing, cut open before the nearer one."""
    scene = scene_of("trainer_clearance")
    camera = framed_views(scene, ["corner"], width=720, height=620)[0][1]
    (IMAGES / "figure6.svg").write_text(outline(scene, camera, hidden="hidden_line"))


def crash() -> tuple[Scene, wb.Poses]:
    """The pilot of `trainer_crash` with his lap belt alone, at the times of the figure."""
    person = build_source("trainer_crash").persons[0]
    poses = poses_at(person.poses, TIMES)
    scene = Scene((SceneBody(wb.place(person.body, poses)),), title="a pilot in a crash of 26 g")
    return scene, person.poses


def figure_7() -> None:
    """Four positions side by side, each with ghosts of those before; and the same as a film ten
    times slower."""
    scene, poses = crash()
    shown = every_pose(scene)
    camera = framed_views(shown, ["right"], width=300, height=330)[0][1]
    pictures = [disks(scene_at(scene, k, trail=3), camera) for k in range(4)]
    captions = [f"{1000 * time:.0f} ms" for time in TIMES[:4]]
    strip_image(pictures, captions).save(IMAGES / "figure7.png", optimize=True)
    times = frame_times(0.0, 0.2, fps=10.0, speed=0.1)
    body = scene.bodies[0].placed.body
    moving = Scene((SceneBody(wb.place(body, poses_at(poses, times))),))
    frames = film_frames(moving, camera, times, disks, stamp="1/10 speed", trail=3, every=4)
    write_film(IMAGES / "figure7.webp", frames, len(times), fps=10.0)


if __name__ == "__main__":
    figures_1_and_2()
    figures_3_and_5()
    trainer()
    figure_6()
    figure_7()
