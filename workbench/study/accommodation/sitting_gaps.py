"""Who comes too near to what, in words, and which way a part would have to go."""

from __future__ import annotations

import numpy as np

from workbench.contact.clearance_pairs import PairClearance
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["gap_toward", "gap_words"]


def gap_words(body: Body, environment: Environment, pair: tuple[int, int]) -> str:
    """ "right lower leg, instrument_panel": what comes too near to what, from a sphere and a
    polygon."""
    sphere, polygon = pair
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    name = body.sphere_names[sphere]
    part = environment.parts[int(environment.polygon_part[polygon])]
    return f"{segment} ({name}) at {part}" if name else f"{segment} at {part}"


def gap_toward(placed: Placed, found: PairClearance) -> Floats:
    """(B, Q, 3) the unit vectors from the nearest spheres to the nearest parts: where a part would
    have to go; NaN where nothing is there, or a centre is inside."""
    people = np.arange(len(placed.centres))[:, None]
    sphere = np.maximum(found.sphere, 0)
    way = found.point - placed.centres[people, sphere]
    far = np.linalg.norm(way, axis=2)
    radius = placed.body.radius[placed.person[:, None], sphere]
    seen = (found.sphere >= 0) & (far > 1e-9) & (found.distance > -radius)
    toward: Floats = np.where(seen[..., None], way / np.maximum(far, 1e-9)[..., None], np.nan)
    return toward
