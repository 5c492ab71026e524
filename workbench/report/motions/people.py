"""The people of motions on a page: body, detail, mass, eyes, joint angles when something happens."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.forward import place
from workbench.draw.eye_view import eye_point
from workbench.draw.scene import SceneBody
from workbench.model.arrays import Floats
from workbench.model.joint_angles import angles_of, named_angles, poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.result import MotionFound
from workbench.model.units import plain
from workbench.report.joint_angles import angle_rows
from workbench.report.section import Section
from workbench.report.sentences import milliseconds
from workbench.report.templates import template
from workbench.sight.eyes import has_eyes

__all__ = ["moving_people"]


def moving_people(motions: Sequence[MotionFound], times: Floats) -> Section:
    """Return the section of who moves, and how at some times.

    times: (F,) [s].
    """
    people = [
        _person(motion.study, np.clip(times, *motion.study.motion.clock[[0, -1]]))
        for motion in motions
    ]
    clock = [milliseconds(time) for time in times.tolist()]
    html = template("motions/people.html.j2").render(people=people, clock=clock)
    return Section("people", "people", "People", Markup(html))


def _person(motion: MotionCase, times: Floats) -> dict[str, Any]:
    """Who moves in one motion, with the eyes [mm] and the joint angles [degrees] at some times."""
    body = motion.body
    poses = poses_at(motion.motion, times)
    placed = place(body, poses)
    eyes = []
    if has_eyes(body):
        points = [eye_point(SceneBody(placed, pose))[0] for pose in range(len(placed))]
        eyes = [", ".join(f"{round(1000 * c) + 0}" for c in point.tolist()) for point in points]
    found = [named_angles(body, angles) for angles in angles_of(body, poses)]
    detail = f" (level of detail {body.detail})" if body.detail else ""
    belts = ", ".join(plain(belt.name) for belt in motion.belts)
    return {
        "name": ", ".join(word for word in (motion.person, motion.name) if word),
        "words": f"{plain(body.name)}, {float(body.mass[0].sum()):.1f} kg; {len(body.sphere_names):,} spheres{detail}"
        + (f"; held by {belts}" if belts else ""),
        "eyes": eyes,
        "angles": angle_rows(body, found),
    }
