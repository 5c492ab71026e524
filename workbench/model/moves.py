"""Parts and controls of an environment that stand elsewhere than its file has them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.adjusting import move_parts
from workbench.model.arrays import Floats, xyz
from workbench.model.environment import Adjustment, Environment
from workbench.model.quaternions import exponential, matrices

__all__ = ["Move", "control_moves", "displaced", "moved_controls", "part_moves", "parts_along"]


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
        found = move_parts(found, [name], rotation, middle - rotation @ middle)
    for by in np.unique(parts[parts.any(axis=1)], axis=0):
        mine = np.flatnonzero((parts == by).all(axis=1))
        found = move_parts(found, [environment.parts[k] for k in mine], None, by)
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
    found: Floats = own[0] if same else np.zeros(3)
    return found
