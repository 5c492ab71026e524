"""Spread the flesh of hips and thighs as a seat does.

A sitter's hips are broader than a standing person's and the thighs flatter: of the people of ANSUR
II by a tenth (men) and an eighth (women) of the hip breadth. The law is the same for everybody of a
body file, by its factors of breadth b and thickness t. It fades out toward the knee and toward the
waist by a weight w of each sphere, which is 1 at the hips.

- Outer sides move from the middle plane. A sphere of radius r at y beside it, of which the side s
  shows (-1 right to 1 left), moves by (b - 1) w (y + s r).
- The spheres of a thigh shrink by (1 - t) w r. Their outer sides stay where b puts them. The
  undersides rise, and the upper sides sink by a share of that (`_SINKS`): a seat presses from
  below.

All this is linear in coordinates and radii while weights and sides are held.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.body.scaling.rig import Shape
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import ROW_FIELDS, Body, body_of_rows

__all__ = ["SeatedFlesh", "seated", "seated_flesh"]

_THIGHS = {"LUL": ("LH", "LK"), "RUL": ("RH", "RK")}
"""Thighs with their hip and knee joints."""
_PELVIS = "LT"
_FADE = 0.75
"""Share of the thigh's length over which the spread fades out toward the knee."""
_LEVEL = (0.05, 0.35)
"""Heights over the hip joint, in thigh lengths, between which it fades out toward the waist."""
_SINKS = 0.4
"""How far the upper side of a thigh sinks, as a share of how far the underside rises."""


@dataclass(frozen=True, eq=False)
class SeatedFlesh:
    """What changes F spheres of a body from its standing to its seated shape."""

    sphere: Ints
    """(F,) their numbers."""
    hip: Ints
    """(F,) the hip joint of each."""
    thigh: Bools
    """(F,) True for spheres of a thigh, False for those of the pelvis."""
    broader: Floats
    """(..., F) the factor of breadth less 1, times the weight."""
    thinner: Floats
    """(..., F) 1 less the factor of thickness, times the weight; 0 for the pelvis."""
    side: Floats
    """(..., F) which side of the sphere shows: -1 right, 1 left."""

    def spread(self, shape: Shape) -> Shape:
        """Return the seated shape of a shape (...), or of what is added to one."""
        some = self.sphere
        moved: Floats = np.array(shape.centre)
        radii: Floats = np.array(shape.radius)
        own = shape.centre[..., some, :]
        radius = shape.radius[..., some]
        lost = self.thinner * radius
        beside = own[..., 1] - _middle(shape, self.hip, self.thigh)
        aside = self.broader * (beside + self.side * radius)
        moved[..., some, 1] += aside + self.side * lost
        # a thigh hangs in its own frame: its front comes to lie on top
        moved[..., some, 0] += (1.0 - _SINKS) / (1.0 + _SINKS) * lost
        radii[..., some] -= lost
        return replace(shape, centre=moved, radius=radii)


def _middle(shape: Shape, hip: Ints, thigh: Bools) -> Floats:
    """(..., F) [m] where the middle plane lies along y in the frames of pelvis and thighs."""
    place = shape.in_child[..., hip, 1] - shape.in_parent[..., hip, 1]
    return np.where(thigh, place, 0.0)


def seated_flesh(body: Body, shape: Shape) -> SeatedFlesh | None:
    """Return how the flesh of bodies of given shapes spreads; None where it does not.

    Parameters
    ----------
    body
        B bodies of one topology.
    shape
        Their shapes with a row for each, or the shape (...) of one.
    """
    known = {_PELVIS, *_THIGHS} <= set(body.segments)
    if not known or np.all(body.seated_factors == 1.0):
        return None
    parts = [_thigh_part(body, shape, name) for name in _THIGHS]
    parts.append(_pelvis_part(body, shape))
    sphere = np.concatenate([part.sphere for part in parts])
    hip = np.concatenate([np.full(len(part.sphere), part.hip) for part in parts])
    thigh = np.concatenate([np.full(len(part.sphere), part.thigh) for part in parts])
    weight = np.concatenate([part.weight for part in parts], axis=-1)
    aside = shape.centre[..., sphere, 1] - _middle(shape, hip, thigh)
    factors = body.seated_factors if shape.radius.ndim > 1 else body.seated_factors[0]
    return SeatedFlesh(
        sphere=sphere,
        hip=hip,
        thigh=thigh,
        broader=(factors[..., 0, None] - 1.0) * weight,
        thinner=(1.0 - factors[..., 1, None]) * weight * thigh,
        side=np.clip(2.0 * aside / shape.radius[..., sphere], -1.0, 1.0),
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """Spheres of a segment: their numbers (F,), hip joint, and weights (..., F)."""

    sphere: Ints
    hip: int
    thigh: bool
    weight: Floats


def _thigh_part(body: Body, shape: Shape, name: str) -> _Part:
    hip, knee = (body.joint(joint) for joint in _THIGHS[name])
    rows = np.arange(shape.radius.shape[-1])[body.spheres(body.segment(name))]
    top = shape.in_child[..., hip, 2, None]
    length = top - shape.in_parent[..., knee, 2, None]
    along = (top - shape.centre[..., rows, 2]) / length
    return _Part(rows, hip, True, np.clip((1.0 - along) / _FADE, 0.0, 1.0))


def _pelvis_part(body: Body, shape: Shape) -> _Part:
    hip, knee = (body.joint(joint) for joint in _THIGHS["LUL"])
    rows = np.arange(shape.radius.shape[-1])[body.spheres(body.segment(_PELVIS))]
    length = (shape.in_child[..., hip, 2] - shape.in_parent[..., knee, 2])[..., None]
    height = shape.centre[..., rows, 2] - shape.in_parent[..., hip, 2, None]
    low, high = _LEVEL
    weight = np.clip((high - height / length) / (high - low), 0.0, 1.0)
    return _Part(rows, hip, False, weight)


def seated(body: Body) -> Body:
    """Return bodies with their flesh as on a seat, which they keep in every posture.

    A body without factors, and one that has its flesh spread already, stays as it is.

    Parameters
    ----------
    body
        B bodies of one topology.
    """
    shape = Shape(body.centre, body.radius, body.joint_in_parent, body.joint_in_child)
    flesh = seated_flesh(body, shape)
    if flesh is None:
        return body
    spread = flesh.spread(shape)
    fields = {name: getattr(body, name) for name in ROW_FIELDS}
    fields["centre"] = spread.centre
    fields["radius"] = spread.radius
    fields["seated_factors"] = np.ones((len(body), 2))
    fields["enclosing_radius"] = _enclosing(body, spread, flesh)
    return body_of_rows(body, fields)


def _enclosing(body: Body, spread: Shape, flesh: SeatedFlesh) -> Floats:
    """(B, N) [m] radii of the enclosing spheres about their centres, with the moved spheres."""
    radius = body.enclosing_radius.copy()
    for n in np.unique(body.sphere_segment[flesh.sphere]).tolist():
        rows = body.spheres(n)
        away = np.linalg.norm(spread.centre[:, rows] - body.enclosing_centre[:, n, None], axis=2)
        farthest = (away + spread.radius[:, rows]).max(axis=1)
        radius[:, n] = np.maximum(radius[:, n], farthest)
    return radius
