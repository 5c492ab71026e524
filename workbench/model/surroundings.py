"""Environments with something elsewhere: parts moved, adjustments set, parts and controls that stand
elsewhere than the file has them, and parts displaced for an index that stays."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints, read_only, xyz
from workbench.model.environment import Adjustment, Environment, Instrument, Mirror, Seat
from workbench.model.joint_angles import attitude_matrix
from workbench.model.quaternions import exponential, matrices

__all__ = [
    "Move",
    "Surroundings",
    "adjusted",
    "carried_by",
    "control_moves",
    "displaced",
    "merge_environments",
    "move_parts",
    "moved_along",
    "moved_controls",
    "part_moves",
    "parts_along",
    "seat_tilt",
]


def move_parts(
    environment: Environment,
    parts: Iterable[str],
    shift: ArrayLike,
    *,
    rotation: Floats | None = None,
) -> Environment:
    """Move parts of an environment as rigid bodies, with the instruments and mirrors that they are.

    Seats, points and controls stay where they are: they are positions at rest.

    Parameters
    ----------
    parts
        Names of the parts that move.
    shift
        (3,) [m].
    rotation
        (3, 3) about the origin, which comes first; none if None.

    Raises
    ------
    InputError
        If a part is unknown.
    UsageError
        If the displacement is not three finite numbers.
    """
    by = np.asarray(shift, dtype=np.float64)
    if by.shape != (3,) or not np.all(np.isfinite(by)):
        raise UsageError(f"a shift is three finite numbers [m], got {shift!r}")
    chosen = np.zeros(len(environment.parts), dtype=np.bool_)
    chosen[[environment.part_index(name) for name in parts]] = True
    if not chosen.any() or (rotation is None and not by.any()):
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
        return xyz(np.array(direction(point)) + by)

    def goes(one: Instrument | Mirror) -> bool:
        return bool(chosen[environment.part_index(one.part)])

    normal = turned(environment.normal, polygon)
    centre = turned(environment.circle_centre, polygon)
    return replace(
        environment,
        vertices=turned(environment.vertices, vertex) + np.where(vertex[:, None], by, 0.0),
        normal=normal,
        offset=environment.offset + np.where(polygon, normal @ by, 0.0),
        circle_centre=centre + np.where(polygon[:, None], by, 0.0),
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

    moved = move_parts(environment, parts, shift, rotation=rotation)
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


@dataclass(frozen=True)
class Move:
    """Parts with the controls on them, or controls alone, that are displaced.

    Parameters
    ----------
    parts
        Names of parts; all controls on them go along.
    controls
        Names of controls that go without their parts.
    by
        (3,) [m] from where the environment's file has them.
    turn
        (3,) [rad] rotation vector about the middle of the box around each part, before that. Controls
        on the parts do not turn.
    """

    parts: tuple[str, ...]
    controls: tuple[str, ...]
    by: tuple[float, float, float]
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def times(self, amount: float) -> Move:
        """So many times the way, and the turn."""
        by, turn = (xyz(amount * np.array(way)) for way in (self.by, self.turn))
        return replace(self, by=by, turn=turn)


def parts_along(environment: Environment, controls: Collection[str]) -> tuple[str, ...]:
    """The parts that go along with controls: their own, without those of a control that stays."""
    return tuple(
        part
        for part in environment.parts
        if (on := [one.name for one in environment.controls if part in one.own_parts])
        and all(name in controls for name in on)
    )


def moved_controls(environment: Environment, moves: Sequence[Move]) -> tuple[str, ...]:
    """The controls that go with their parts, or by themselves."""
    return tuple(
        control.name
        for control in environment.controls
        if any(control.part in move.parts or control.name in move.controls for move in moves)
    )


def moved_along(environment: Environment, parts: Collection[str], by: ArrayLike) -> Environment:
    """Displace parts by (3,) [m] with the controls on them: a seat takes its footplates along."""
    return displaced(environment, [Move(tuple(parts), (), xyz(np.asarray(by)))])


def part_moves(environment: Environment, moves: Sequence[Move]) -> Floats:
    """(K, 3) [m] by how much each part is displaced."""
    found = np.zeros((len(environment.parts), 3))
    for move in moves:
        for name in move.parts:
            found[environment.part_index(name)] += move.by
    return found


def control_moves(environment: Environment, moves: Sequence[Move]) -> Floats:
    """(C, 3) [m] by how much each control is displaced, with its part and by itself."""
    found = np.zeros((len(environment.controls), 3))
    for row, control in enumerate(environment.controls):
        for move in moves:
            if control.part in move.parts or control.name in move.controls:
                found[row] += move.by
    return found


def displaced(
    environment: Environment, moves: Sequence[Move], before: Sequence[Move] = ()
) -> Environment:
    """Displace parts and controls of an environment.

    A control on a part goes along. So do the pivot and the points of an adjustment all of whose
    parts go the same way. Seats stay where they are.

    Parameters
    ----------
    moves
        Where parts and controls are to stand.
    before
        How the environment is displaced already.

    Returns
    -------
    Environment
        The same object where nothing is to be displaced.

    Raises
    ------
    InputError
        If a part is unknown.
    """
    parts = part_moves(environment, moves) - part_moves(environment, before)
    controls = control_moves(environment, moves) - control_moves(environment, before)
    turned = [(name, move.turn) for move in moves if any(move.turn) for name in move.parts]
    if not parts.any() and not controls.any() and not turned:
        return environment
    found = environment
    for name, turn in turned:
        corners = found.triangle_corners(found.part_index(name)).reshape(-1, 3)
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        rotation = matrices(exponential(np.array(turn)))
        found = move_parts(found, [name], middle - rotation @ middle, rotation=rotation)
    for by in np.unique(parts[parts.any(axis=1)], axis=0):
        mine = np.flatnonzero((parts == by).all(axis=1))
        found = move_parts(found, [environment.parts[k] for k in mine], by)
    points = dict(environment.points)
    adjustments = []
    for one in environment.adjustments:
        by = _together(environment, one, parts)
        points |= {name: xyz(np.array(points[name]) + by) for name in one.points if by.any()}
        pivot = one.pivot if one.pivot is None else xyz(np.array(one.pivot) + by)
        adjustments.append(replace(one, pivot=pivot) if by.any() else one)
    return replace(
        found,
        points=points,
        adjustments=tuple(adjustments),
        controls=tuple(
            replace(control, at=xyz(np.array(control.at) + by)) if by.any() else control
            for control, by in zip(environment.controls, controls, strict=True)
        ),
    )


def _together(environment: Environment, one: Adjustment, parts: Floats) -> Floats:
    """(3,) [m] by how much all parts of an adjustment are displaced; 0 where they part company."""
    own = parts[[environment.part_index(name) for name in one.parts]]
    same = len(own) > 0 and bool((own == own[0]).all())
    return own[0] if same else np.zeros(3)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """An environment with groups of parts displaced: seats along their rails, a lever.

    Parameters
    ----------
    environment
        With all parts at rest.
    movers
        M groups of parts, by index, that move together; no part is in two of them.
    displacement
        (M, 3) [m] of each.
    """

    environment: Environment
    movers: tuple[tuple[int, ...], ...]
    displacement: Floats

    def __post_init__(self) -> None:
        given = read_only(
            self.displacement, np.float64, (len(self.movers), 3), "surroundings.displacement"
        )
        object.__setattr__(self, "displacement", given)

    @property
    def by_part(self) -> Floats:
        """(K, 3) [m] the displacement of each part."""
        found = np.zeros((len(self.environment.parts), 3))
        for parts, shift in zip(self.movers, self.displacement, strict=True):
            found[list(parts)] = shift
        return found

    def moved(self) -> Environment:
        """Another environment with the parts there, which is indexed anew."""
        environment = self.environment
        for group, shift in zip(self.movers, self.displacement, strict=True):
            parts = [environment.parts[k] for k in group]
            environment = move_parts(environment, parts, shift)
        return environment


_STACKED = (
    "vertices",
    "normal",
    "offset",
    "circle_centre",
    "circle_radius",
    "solid",
    "hidden",
    "see_through",
)
"""Arrays of an environment whose rows follow one another."""


def merge_environments(environment: Environment, more: Environment) -> Environment:
    """The environment with the parts of another behind its own; seats, points and controls are its
    own.

    InputError where a part's name is in both.
    """
    twice = sorted(set(environment.parts) & set(more.parts))
    if twice:
        raise InputError(f"a part {twice[0]!r} is in environment {environment.name} already")
    behind = len(environment.parts)
    allowances = tuple(replace(rule, part=rule.part + behind) for rule in more.allowances)
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(environment, name), getattr(more, name)]) for name in _STACKED
    }
    for name in ("edges", "triangles"):
        behind_them = getattr(more, name) + len(environment.vertices)
        arrays[name] = np.concatenate([getattr(environment, name), behind_them])
    for name in ("part_start", "edge_start", "triangle_start"):
        arrays[name] = _continued(getattr(environment, name), getattr(more, name))
    return replace(
        environment,
        parts=(*environment.parts, *more.parts),
        allowances=(*environment.allowances, *allowances),
        quality=(*environment.quality, *more.quality),
        warnings=(*environment.warnings, *more.warnings),
        **arrays,
    )


def _continued(start: Ints, more: Ints) -> Ints:
    """Starts of groups, then those of others behind them."""
    return np.concatenate([start, more[1:] + start[-1]])
