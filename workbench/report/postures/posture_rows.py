"""The postures of a result: joint angles and placements, so that they can be drawn and taken on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from workbench.files.results.postures import PostureRow, PosturesRows
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import angles_of, named_angles
from workbench.model.quaternions import from_matrices
from workbench.model.result import PersonFound, PosturesFound
from workbench.report.tables import Table, micro

__all__ = ["Held", "held_tables", "posture_row", "posture_rows", "posture_tables", "seat_position"]

_TURN_PLACES = 9
"""Decimals of a quaternion: a millionth of a millimetre at the end of an arm."""


def posture_rows(result: PosturesFound, found: PersonFound) -> list[PostureRow]:
    """Return the posture of a person in each case: joint angles, and where the body is placed."""
    return [
        posture_row(found.body, found.poses.rows(slice(p, p + 1)), case, found.postures[p])
        for p, case in enumerate(result.cases)
    ]


def posture_row(body: Body, poses: Poses, case: str, name: str) -> PostureRow:
    """Return one pose of a body in a case, as it is called there."""
    (angles,) = angles_of(body, poses)
    (world,) = poses.world_from_reference
    (turn,) = from_matrices(world[None, :, :3])
    return PostureRow(
        case=case,
        name=name,
        angles_deg={
            joint: {motion: micro(degrees) for motion, degrees in motions.items()}
            for joint, motions in named_angles(body, angles).items()
        },
        reference=body.segments[poses.reference],
        position_mm=(micro(1e3 * world[0, 3]), micro(1e3 * world[1, 3]), micro(1e3 * world[2, 3])),
        rotation=_rounded(turn.tolist()),
    )


def _rounded(turn: Sequence[float]) -> tuple[float, float, float, float]:
    w, x, y, z = (round(value, _TURN_PLACES) + 0.0 for value in turn)
    return w, x, y, z


def seat_position(found: PersonFound) -> tuple[float, float] | None:
    """Return the position of the seat of a person, forward and up [mm]; None without a seat."""
    if found.role.seat is None:
        return None
    return micro(1e3 * found.forward), micro(1e3 * found.up)


def posture_tables(found: Sequence[PosturesRows]) -> dict[str, Table]:
    """Return by name: the joint angles, and the placements with the seats; with the
    size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    held = [
        Held(
            [*([rows.row] if rows.row else []), posture.case, person.name], person.seat_mm, posture
        )
        for rows in found
        for person in rows.people
        for posture in person.postures
    ]
    return held_tables([*lead, "case", "person"], held)


@dataclass(frozen=True)
class Held:
    """A posture that somebody holds: what leads its lines in a table, the position of the seat
    [mm], None without one, and the posture."""

    lead: Sequence[object]
    seat_mm: tuple[float, float] | None
    posture: PostureRow


def held_tables(head: Sequence[str], held: Sequence[Held]) -> dict[str, Table]:
    """Return by name: joint angles, and placements with the seats.

    Parameters
    ----------
    head
        The names of what leads the lines.
    held
        The postures.
    """
    place = ["reference", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"]
    return {
        "postures": Table([*head, "joint", "motion", "angle_deg"], _angles(held)),
        "placements": Table(
            [*head, "posture", *place, "seat_forward_mm", "seat_up_mm"], _placements(held)
        ),
    }


def _angles(held: Sequence[Held]) -> Iterator[list[object]]:
    for one in held:
        for joint, motions in one.posture.angles_deg.items():
            for motion, degrees in motions.items():
                yield [*one.lead, joint, motion, degrees]


def _placements(held: Sequence[Held]) -> Iterator[list[object]]:
    for one in held:
        posture = one.posture
        yield [
            *one.lead,
            posture.name,
            posture.reference,
            *posture.position_mm,
            *posture.rotation,
            *(one.seat_mm or (None, None)),
        ]
