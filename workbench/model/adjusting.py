"""Environments as they are set: parts slid and turned by their adjustments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.arrays import Floats, xyz
from workbench.model.environment import Adjustment, Environment, Instrument, Mirror, Seat
from workbench.model.posing import attitude_matrix
from workbench.model.quaternions import exponential, matrices

__all__ = ["adjusted", "carried_by", "move_parts", "seat_tilt"]


def move_parts(
    environment: Environment, parts: Iterable[str], rotation: Floats | None, shift: Floats
) -> Environment:
    """Move parts of an environment as rigid bodies, with the instruments and mirrors that they are.

    Seats, points and controls stay where they are.

    Parameters
    ----------
    parts
        Names of the parts that move.
    rotation
        (3, 3) about the origin, which comes first; none if None.
    shift
        (3,) [m].

    Raises
    ------
    InputError
        If a part is unknown.
    """
    chosen = np.zeros(len(environment.parts), dtype=np.bool_)
    chosen[[environment.part_index(name) for name in parts]] = True
    if not chosen.any() or (rotation is None and not shift.any()):
        return environment
    polygon = chosen[environment.polygon_part]
    triangle = np.repeat(polygon, np.diff(environment.triangle_start))
    vertex = np.zeros(len(environment.vertices), dtype=np.bool_)
    vertex[environment.triangles[triangle].ravel()] = True

    def turned(rows: Floats, mine: np.ndarray) -> Floats:
        return rows if rotation is None else np.where(mine[:, None], rows @ rotation.T, rows)

    def direction(vector: tuple[float, float, float]) -> tuple[float, float, float]:
        return vector if rotation is None else xyz(rotation @ np.array(vector))

    def placed(point: tuple[float, float, float]) -> tuple[float, float, float]:
        return xyz(np.array(direction(point)) + shift)

    def goes(one: Instrument | Mirror) -> bool:
        return bool(chosen[environment.part_index(one.part)])

    normal = turned(environment.normal, polygon)
    centre = turned(environment.circle_centre, polygon)
    return replace(
        environment,
        vertices=turned(environment.vertices, vertex) + np.where(vertex[:, None], shift, 0.0),
        normal=normal,
        offset=environment.offset + np.where(polygon, normal @ shift, 0.0),
        circle_centre=centre + np.where(polygon[:, None], shift, 0.0),
        instruments=tuple(
            replace(one, at=placed(one.at), face=direction(one.face)) if goes(one) else one
            for one in environment.instruments
        ),
        mirrors=tuple(
            replace(one, at=placed(one.at), normal=direction(one.normal)) if goes(one) else one
            for one in environment.mirrors
        ),
    )


def seat_tilt(seat: Seat, travel: tuple[float, float]) -> Adjustment:
    """The tilt of a whole seat, cushion and back, about the lateral axis through its SRP; positive
    with the front edge up.

    Parameters
    ----------
    travel
        (least, greatest) [rad].
    """
    right = attitude_matrix(yaw=seat.yaw) @ np.array([0.0, -1.0, 0.0])
    return Adjustment(
        name=f"{seat.name}_tilt",
        axis=xyz(right),
        pivot=seat.srp,
        travel=travel,
        parts=seat.moves,
        seat=seat.name,
        tilts=seat.name,
    )


def carried_by(adjustments: Sequence[Adjustment], name: str) -> list[Adjustment]:
    """The adjustments that are mounted on one, directly or on such a one, and it itself first."""
    found = [one for one in adjustments if one.name == name]
    for carrier in found:
        found += [one for one in adjustments if one.mounted_on == carrier.name]
    return found


def adjusted(environment: Environment, setting: Mapping[str, float]) -> Environment:
    """Set some adjustments of an environment; the others stay as they are set.

    Parts, points and the controls on the parts go along; so do adjustments that are mounted on one.

    Parameters
    ----------
    setting
        By the name of the adjustment where it is to be set [m or rad].

    Raises
    ------
    InputError
        If an adjustment is unknown.
    """
    for name, value in setting.items():
        one = environment.adjustment(name)
        if value != one.at:
            environment = _set(environment, one, value)
    return environment


def _set(environment: Environment, one: Adjustment, value: float) -> Environment:
    """An environment with one adjustment set to a value."""
    carried = carried_by(environment.adjustments, one.name)
    parts = {name for each in carried for name in each.parts}
    points = {name for each in carried for name in each.points}
    rotation, shift = _motion(one, value - one.at)

    def placed(point: tuple[float, float, float]) -> tuple[float, float, float]:
        return xyz((point if rotation is None else rotation @ np.array(point)) + shift)

    def taken_along(each: Adjustment) -> Adjustment:
        if each.name == one.name:
            return replace(each, at=value)
        if each.name not in {other.name for other in carried}:
            return each
        axis = each.axis if rotation is None else xyz(rotation @ np.array(each.axis))
        pivot = None if each.pivot is None else placed(each.pivot)
        return replace(each, axis=axis, pivot=pivot)

    moved = move_parts(environment, parts, rotation, shift)
    return replace(
        moved,
        points={name: placed(at) if name in points else at for name, at in moved.points.items()},
        controls=tuple(
            replace(control, at=placed(control.at)) if control.part in parts else control
            for control in moved.controls
        ),
        adjustments=tuple(taken_along(each) for each in moved.adjustments),
        seats=tuple(
            _tilted(seat, value - one.at) if seat.name == one.tilts else seat
            for seat in moved.seats
        ),
    )


def _motion(one: Adjustment, by: float) -> tuple[Floats | None, Floats]:
    """The rotation (3, 3) about the origin, None of a slide, and the shift (3,) [m] by which an
    adjustment moves what it carries, by so much [m or rad]."""
    axis = np.array(one.axis)
    if one.pivot is None:
        return None, by * axis
    rotation: Floats = matrices(exponential(by * axis))
    pivot = np.array(one.pivot)
    return rotation, pivot - rotation @ pivot


def _tilted(seat: Seat, by: float) -> Seat:
    """A seat whose cushion and back lean back by an angle [rad]."""
    return replace(seat, back_angle=seat.back_angle + by, cushion_angle=seat.cushion_angle + by)
