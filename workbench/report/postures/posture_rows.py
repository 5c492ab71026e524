"""The postures of a result: joint angles and placements, so that they can be drawn and taken on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from workbench.files.results.postures import PersonRow, PostureRow, PosturesRows
from workbench.model.posing import angles_of, named_angles
from workbench.model.quaternions import from_matrices
from workbench.model.result import PersonFound, PosturesFound
from workbench.report.tables import csv_text, micro

__all__ = ["posture_rows", "posture_tables", "seat_position"]

_TURN_PLACES = 9
"""Decimals of a quaternion: a millionth of a millimetre at the end of an arm."""


def posture_rows(result: PosturesFound, found: PersonFound) -> list[PostureRow]:
    """Return the posture of a person in each case: joint angles, and where the body is placed."""
    body = found.body
    angles = angles_of(body, found.poses)
    world = found.poses.world_from_reference
    turns = from_matrices(world[:, :, :3])
    return [
        PostureRow(
            case=case,
            name=found.postures[p],
            angles_deg={
                joint: {motion: micro(degrees) for motion, degrees in motions.items()}
                for joint, motions in named_angles(body, angles[p]).items()
            },
            reference=body.segments[found.poses.reference],
            position_mm=(
                micro(1e3 * world[p, 0, 3]),
                micro(1e3 * world[p, 1, 3]),
                micro(1e3 * world[p, 2, 3]),
            ),
            rotation=_rounded(turns[p].tolist()),
        )
        for p, case in enumerate(result.cases)
    ]


def _rounded(turn: Sequence[float]) -> tuple[float, float, float, float]:
    w, x, y, z = (round(value, _TURN_PLACES) + 0.0 for value in turn)
    return w, x, y, z


def seat_position(found: PersonFound) -> tuple[float, float] | None:
    """Return the position of the seat of a person, forward and up [mm]; None without a seat."""
    if found.role.seat is None:
        return None
    return micro(1e3 * found.forward), micro(1e3 * found.up)


def posture_tables(found: Sequence[PosturesRows]) -> dict[str, str]:
    """Return file name to CSV text: the joint angles, and the placements with the seats; with the
    size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    place = ["reference", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"]
    head = [*lead, "case", "person"]
    return {
        "postures.csv": csv_text([*head, "joint", "motion", "angle_deg"], _angles(found)),
        "placements.csv": csv_text(
            [*head, "posture", *place, "seat_forward_mm", "seat_up_mm"], _placements(found)
        ),
    }


def _each(
    found: Sequence[PosturesRows],
) -> Iterator[tuple[list[object], PersonRow, PostureRow]]:
    """Each posture of each person, after the size, case and person that lead its lines."""
    for rows in found:
        size = [rows.row] if rows.row else []
        for person in rows.people:
            for posture in person.postures:
                yield [*size, posture.case, person.name], person, posture


def _angles(found: Sequence[PosturesRows]) -> Iterator[list[object]]:
    for lead, _, posture in _each(found):
        for joint, motions in posture.angles_deg.items():
            for motion, degrees in motions.items():
                yield [*lead, joint, motion, degrees]


def _placements(found: Sequence[PosturesRows]) -> Iterator[list[object]]:
    for lead, person, posture in _each(found):
        seat = person.seat_mm or (None, None)
        yield [
            *lead,
            posture.name,
            posture.reference,
            *posture.position_mm,
            *posture.rotation,
            *seat,
        ]
