"""Make the picture of docs/labanotation.md: the score docs/examples/greeting.laban at each beat.
Run from anywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import workbench as wb
from workbench.draw.disks import disks
from workbench.draw.films.film import every_pose, scene_at
from workbench.draw.films.strip import strip_image
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.views import framed_views
from workbench.model.joint_angles import poses_at
from workbench.study.motions import load_motion

DOCS = Path(__file__).resolve().parent
BEATS = np.array([1.0, 3.0, 4.0, 5.0, 6.0, 7.0])


def greeting() -> None:
    """The body at the end of each movement, seen from the front and, turned a little, from its
    left."""
    body = wb.load_body("bubbleman")
    motion, _ = load_motion(body, DOCS / "examples" / "greeting.laban")
    placed = wb.place(body, poses_at(motion, BEATS - 1.0))
    shown = Scene((SceneBody(placed),), title="greeting")
    camera = framed_views(every_pose(shown), ["corner"], width=230, height=330)[0][1]
    pictures = [disks(scene_at(shown, k), camera) for k in range(len(BEATS))]
    strip_image(pictures, [f"beat {beat:g}" for beat in BEATS]).save(
        DOCS / "images" / "greeting.png", optimize=True
    )


if __name__ == "__main__":
    greeting()
