"""The line drawing of a case: outlines with dimension lines of the nearest clearances, from where
they show best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from markupsafe import Markup

from workbench.draw.camera import Camera, project
from workbench.draw.lines.outline import outline
from workbench.draw.lines.svg import compacted
from workbench.draw.marks.annotations import clearance_marks
from workbench.draw.scene import Mark, Scene
from workbench.draw.views import four_views
from workbench.model.result import PersonFound
from workbench.model.units import plain

__all__ = ["clearance_drawing"]

_EACH = 3  # dimension lines of one person


def clearance_drawing(
    scene: Scene, people: tuple[PersonFound, ...], case: int, *, within: float, size: int
) -> dict[str, object] | None:
    """The drawing of a case and the name of its view; None where nothing lies within `within` [m]
    without touching.

    One dimension line for each of the three parts nearest to each person. Of the four views the one
    in which these lines are longest together.
    """
    marks: tuple[Mark, ...] = ()
    for person in people:
        marks += clearance_marks(
            person.placed, person.clearance, case, most=_EACH, within=within, named=True
        )
    if not marks:
        return None
    views = four_views(scene, width=size, height=size)
    name, camera = views[int(np.argmax([_length(camera, marks) for _, camera in views]))]
    words = f"line drawing with the {len(marks)} nearest clearances in millimetres"
    drawing = outline(replace(scene, marks=marks, description=words), camera)
    return {"name": plain(name), "svg": Markup(compacted(drawing))}


def _length(camera: Camera, marks: tuple[Mark, ...]) -> float:
    """How long dimension lines are together in a picture [pixels]."""
    ends = project(camera, np.array([(mark.point, mark.to) for mark in marks]))
    ways = np.diff(ends[..., :2], axis=1)
    return float(np.linalg.norm(ways, axis=2).sum())
