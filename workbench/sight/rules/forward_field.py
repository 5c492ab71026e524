"""The forward field of 180 degrees of the UN R125 family.

Nothing but what is exempt may stand ahead of the V points between a level plane through V1 and three
planes through V2 that fall 4 degrees: ahead, to the left and to the right. A place is above the three
where it is above one of them, z >= z(V2) - tan(4 degrees) max(x ahead, |y aside|): each plane counts
on its own side. Parts are cut by the planes, so the figures are exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.geometry.clipping import clip_triangles
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.rule_set import RuleSet
from workbench.sight.rays import first_hits
from workbench.sight.regions import azimuth_elevation, direction_of, solid_angle_of_triangles
from workbench.sight.rules.eye_points import SIGN, EyePoints

__all__ = [
    "Blocked",
    "ForwardField",
    "datum_points",
    "forward_field",
    "masked_length",
    "wheel_fall",
]

_SEEN = 1e-9
"""Solid angle [sr] from which on something stands in the field; less is a part that touches it."""
_AHEAD = 1e-3
"""Least distance [m] ahead of V2 of what is looked at over the wheel."""
_LONGEST = 100.0
"""How far [m] from the V points a windscreen may be."""


@dataclass(frozen=True)
class Blocked:
    """What a part covers of the field, seen from V2: how wide its azimuths are in all, and where it
    ends to the left, to the right and upward; [rad], azimuths positive to the left."""

    width: float
    left: float
    right: float
    top: float


@dataclass(frozen=True, eq=False)
class ForwardField:
    """What stands in the forward field.

    blocked: by the name of each part. width [rad]: of all azimuths that are covered. wheel_fall
    [rad]: how far the plane from V2 over the top of the wheel falls; None without a wheel.
    wheel_allowed: whether that is enough for wheel and instruments inside it to be exempt.
    """

    blocked: dict[str, Blocked]
    width: float
    wheel_fall: float | None
    wheel_allowed: bool
    status: str


def forward_field(
    environment: Environment,
    points: EyePoints,
    rules: RuleSet,
    *,
    exempt: Sequence[str] = (),
    wheel: Sequence[str] = (),
    inside_wheel: Sequence[str] = (),
) -> ForwardField:
    """Find what stands in the forward field.

    Parameters
    ----------
    environment
        Its see-through and hidden parts do not count.
    points
        Of `car_eye_points`.
    exempt
        Parts that the rule allows: A-pillars, quarter-light bars, mirrors, wipers, aerials.
    wheel, inside_wheel
        The parts of the steering wheel, and those of the instrument panel that are seen inside its
        rim: exempt where the plane from V2 over the top of the wheel falls by a degree or more.

    Raises
    ------
    InputError
        If a part has no such name, or nothing of the wheel is ahead of V2.
    """
    fall = wheel_fall(environment, points, wheel) if wheel else None
    allowed = fall is not None and fall >= rules.number("wheel_fall")
    left_out = {*exempt, *(wheel if allowed else ()), *(inside_wheel if allowed else ())}
    for name in (*left_out, *inside_wheel):
        environment.part_index(name)
    found: dict[str, Blocked] = {}
    spans = [np.zeros((0, 2))]
    for part, name in enumerate(environment.parts):
        if name in left_out or environment.hidden[part] or environment.see_through[part]:
            continue
        pieces = _in_field(environment.triangle_corners(part), points, rules.number("field_fall"))
        pieces = pieces[np.abs(solid_angle_of_triangles(pieces, points["v2"])) > _SEEN]
        if not len(pieces):
            continue
        # cut at x of V2, so what is less than that is rounding
        angles = azimuth_elevation(np.maximum(pieces - points["v2"], [0.0, -np.inf, -np.inf]))
        span = np.stack([angles[..., 0].min(axis=1), angles[..., 0].max(axis=1)], axis=1)
        low, high = float(span.min()), float(span.max())
        found[name] = Blocked(_covered(span), high, low, float(angles[..., 1].max()))
        spans.append(span)
    names = ("field_fall", "wheel_fall") if wheel else ("field_fall",)
    status = f"{points.status}; {rules.status(*names)}"
    return ForwardField(found, _covered(np.concatenate(spans)), fall, allowed, status)


def wheel_fall(environment: Environment, points: EyePoints, wheel: Sequence[str]) -> float:
    """Angle [rad] by which the plane from V2 that touches the top of the wheel falls ahead, negative
    where it rises; InputError where nothing of the wheel is ahead of V2."""
    parts = [environment.triangle_corners(environment.part_index(name)) for name in wheel]
    away = np.concatenate(parts).reshape(-1, 3) - points["v2"]
    away = away[away[:, 0] > _AHEAD]
    if not len(away):
        raise InputError(f"wheel: nothing of {', '.join(wheel)} is ahead of V2")
    return float(-np.arctan(np.max(away[:, 2] / away[:, 0])))


def datum_points(
    environment: Environment, points: EyePoints, rules: RuleSet, windscreen: Sequence[str]
) -> dict[str, Floats | None]:
    """Find where the lines of the datum points meet the windscreen: from V1 17 degrees to the
    driver's side, from V1 7 degrees up, from V2 5 degrees down; (3,) [m], None where they miss it.

    The area that the rule wants transparent includes these points and the first one's mirror image.
    """
    side = SIGN[points.driver] * rules.number("datum_left")
    angles = {
        f"from V1, {points.driver}": ("v1", side, 0.0),
        "from V1, up": ("v1", 0.0, rules.number("datum_up")),
        "from V2, down": ("v2", 0.0, -rules.number("datum_down")),
    }
    among = np.zeros(len(environment.parts), dtype=np.bool_)
    among[[environment.part_index(name) for name in windscreen]] = True
    origins = np.stack([points[start] for start, _, _ in angles.values()])
    ways = np.stack([direction_of(azimuth, above) for _, azimuth, above in angles.values()])
    far = first_hits(environment, origins, ways, length=_LONGEST, among=among).distance
    met = [
        origin + distance * way if np.isfinite(distance) else None
        for origin, distance, way in zip(origins, far, ways, strict=True)
    ]
    return dict(zip(angles, met, strict=True))


def masked_length(width: float, distance: float, rules: RuleSet) -> float:
    """Length [m] that a part of a tractor hides on the half circle of 12 m.

    x = (b - 65 mm) / a * 12 m + 65 mm of a part b wide, a [m] from the eyes; less than 0 of one that
    hides nothing there.
    """
    apart = rules.number("eyes_apart")
    return (width - apart) / distance * rules.number("circle") + apart


def _in_field(corners: Floats, points: EyePoints, fall: float) -> Floats:
    """(K, 3, 3) [m] what of triangles is in the field; where two planes fall below it, twice."""
    v1, v2 = points["v1"], points["v2"]
    ahead, _ = clip_triangles(corners, np.array([-1.0, 0.0, 0.0]), -float(v2[0]))
    below, _ = clip_triangles(ahead, np.array([0.0, 0.0, 1.0]), float(v1[2]))
    slope = np.tan(fall)
    planes = [np.array([-slope, 0, -1]), np.array([0, -slope, -1]), np.array([0, slope, -1])]
    return np.concatenate([clip_triangles(below, n, float(n @ v2))[0] for n in planes])


def _covered(spans: Floats) -> float:
    """Length [rad] of the union of spans (M, 2)."""
    begin, end = spans[np.argsort(spans[:, 0])].T
    before = np.roll(np.maximum.accumulate(end), 1)
    before[:1] = -np.inf
    return float(np.sum(np.maximum(end - np.maximum(begin, before), 0.0)))
