"""Clearances that an accommodation study asks for: which spheres of which parts, and who comes too near in words."""

from __future__ import annotations

import numpy as np

from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.study import Criterion
from workbench.solve.people_gaps import Gap

__all__ = ["gap_of", "gap_words"]


def gap_of(body: Body, environment: Environment, criterion: Criterion) -> Gap:
    """The spheres and parts that a clearance or contact criterion is about."""
    segment = body.sphere_segment
    if criterion.subparts:
        labels = [f"{body.segments[n]}/{name}" for n, name in zip(segment, body.sphere_names, strict=True)]
        spheres = np.isin(labels, criterion.subparts)
    else:
        spheres = np.isin(segment, [n for n, name in enumerate(body.segments) if name in criterion.segments])
    return Gap(spheres, np.isin(environment.parts, criterion.parts), criterion.check == "contact")


def gap_words(body: Body, environment: Environment, pair: tuple[int, int]) -> str:
    """ "right lower leg, instrument_panel": what comes too near to what, from a sphere and a polygon."""
    sphere, polygon = pair
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    name = body.sphere_names[sphere]
    part = environment.parts[int(environment.polygon_part[polygon])]
    return f"{segment} ({name}), {part}" if name else f"{segment}, {part}"
