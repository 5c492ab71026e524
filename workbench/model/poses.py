"""Poses: a batch of joint rotations and placements. Placed: the same bodies in the world."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from dataclasses import dataclass, field

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arguments import above, check_fields, check_index, chosen_rows
from workbench.model.arrays import Bools, Floats, GrowingArray, Ints, pieces, read_only
from workbench.model.body import Body

__all__ = [
    "Placed",
    "Poses",
    "check_joints",
    "check_rows",
    "people_of",
    "rotation_fault",
    "row_for_each",
    "stacked",
]

_CHECKED = 65_536


@dataclass(frozen=True, eq=False, repr=False)
class Poses:
    """P poses of bodies with J joints.

    rotations (P, J, 4): unit quaternions w, x, y, z; distal segment relative to the proximal one.
    reference: index of the segment that is placed; world_from_reference (P, 3, 4) [m]. time (P,)
    [s] where it is a motion. person (P,): the row of the body that each pose is of. Where it is
    None, all are of a body of one row, or there is one pose for each row, in their order.
    """

    rotations: Floats
    reference: int
    world_from_reference: Floats
    time: Floats | None = None
    person: Ints | None = None

    def __repr__(self) -> str:
        return f"Poses({len(self)} poses of {self.rotations.shape[1]} joints)"

    def __post_init__(self) -> None:
        rotations = read_only(self.rotations, np.float64, (None, None, 4), "poses.rotations")
        poses, joints = rotations.shape[:2]
        if not isinstance(self.reference, (int, np.integer)) or isinstance(self.reference, bool):
            raise InputError(
                f"poses.reference: expected the index of a segment, got {self.reference!r}"
            )
        if not 0 <= self.reference <= joints:
            words = f"expected 0 to {joints}, the segments of a body of {joints} joints"
            raise InputError(f"poses.reference: {words}, got {self.reference}")
        place = read_only(
            self.world_from_reference, np.float64, (poses, 3, 4), "poses.world_from_reference"
        )
        for rows in pieces(poses, size=_CHECKED):
            _check(rotations[rows], place[rows], rows.start)
        object.__setattr__(self, "rotations", rotations)
        object.__setattr__(self, "world_from_reference", place)
        if self.time is not None:
            time = read_only(self.time, np.float64, (poses,), "poses.time")
            if not np.all(np.isfinite(time)):
                raise InputError("poses.time: expected finite times [s]")
            object.__setattr__(self, "time", time)
        if self.person is not None:
            object.__setattr__(self, "person", _rows(self.person, poses, "poses.person"))

    def __len__(self) -> int:
        return len(self.rotations)

    def rows(self, keep: slice | Ints) -> Poses:
        """Some of the poses; those of a slice without a copy."""
        keep = chosen_rows("keep", keep, len(self))
        found = copy(self)
        for name in ("rotations", "world_from_reference", "time", "person"):
            values = getattr(self, name)
            if values is not None:  # rows of what was checked need no check
                some = values[keep]
                some.flags.writeable = False
                object.__setattr__(found, name, some)
        return found

    @property
    def clock(self) -> Floats:
        """(P,) [s] the times of a motion; the frames' numbers where it has none."""
        return self.time if self.time is not None else np.arange(len(self), dtype=np.float64)


@dataclass(frozen=True, eq=False, repr=False)
class Placed:
    """P placed bodies: world_from_segment (P, N, 3, 4), sphere centres (P, S, 3) [m].

    window (N,): the segments that were placed; what is outside holds NaN and takes part in nothing.
    person (P,): the row of the body that each pose is of; its spheres have the radii
    `body.radius[person]`. The first row where None is given.
    """

    body: Body
    world_from_segment: Floats
    centres: Floats
    window: Bools
    person: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __repr__(self) -> str:
        return f"Placed({len(self)} poses of {self.body!r})"

    def _repr_html_(self) -> str | None:
        return above("draw.web.notebook", "notebook_html")(self)

    def __post_init__(self) -> None:
        check_fields(self)
        n = len(self.body.segments)
        s = len(self.body.sphere_names)
        world = read_only(
            self.world_from_segment, np.float64, (None, n, 3, 4), "placed.world_from_segment"
        )
        object.__setattr__(self, "world_from_segment", world)
        centres = read_only(self.centres, np.float64, (len(world), s, 3), "placed.centres")
        object.__setattr__(self, "centres", centres)
        object.__setattr__(self, "window", read_only(self.window, np.bool_, (n,), "placed.window"))
        person = self.person if np.size(self.person) else _first_rows(len(world))
        person = _rows(person, len(world), "placed.person")
        if len(self.body) > 1 or person.any():
            _check_people(self.body, person, "placed.person")
        object.__setattr__(self, "person", person)

    def __len__(self) -> int:
        return len(self.world_from_segment)

    def of_person(self, person: int, rows: Ints) -> Placed:
        """Some poses of one person, placed with this one row of the body."""
        person = check_index("person", person, len(self.body))
        rows = chosen_rows("rows", rows, len(self))
        world = self.world_from_segment[rows]
        return Placed(self.body[person], world, self.centres[rows], self.window)


def stacked(parts: Iterable[Poses]) -> Poses:
    """One motion of parts that follow each other, all with times and the same reference segment; a
    long one is kept in a file (`workbench.model.arrays`). InputError where there is none, or they
    name different reference segments."""
    kept: tuple[GrowingArray, GrowingArray, GrowingArray] | None = None
    reference = -1
    person: list[Ints] = []
    for part in parts:
        if kept is None:
            reference = part.reference
            kept = GrowingArray(part.rotations.shape[1], 4), GrowingArray(3, 4), GrowingArray()
        if part.reference != reference:
            raise InputError("poses with different reference segments cannot be one motion")
        for spool, rows in zip(
            kept, (part.rotations, part.world_from_reference, part.clock), strict=True
        ):
            spool.add(rows)
        if part.person is not None:
            person.append(part.person)
    if kept is None:
        raise InputError("no poses to stack")
    rotations, place, time = (spool.done() for spool in kept)
    people = np.concatenate(person) if person else None
    return Poses(rotations, reference, place, time, people)


def _first_rows(count: int) -> Ints:
    """(P,) the first row for each pose, read-only."""
    rows = np.zeros(count, dtype=np.int64)
    rows.flags.writeable = False
    return rows


def _rows(person: Ints, count: int, what: str) -> Ints:
    """Rows of a body (P,); InputError where they are no such numbers."""
    rows = read_only(person, np.int64, (count,), what)
    if rows.min(initial=0) < 0:
        raise InputError(f"{what}: expected numbers of rows from 0 on, got {rows.min()}")
    return rows


def _check_people(body: Body, person: Ints, what: str) -> None:
    """InputError where a body does not have such rows."""
    if person.max(initial=0) >= len(body):
        rows = f"{len(body)} row{'s' if len(body) > 1 else ''}"
        raise InputError(f"{what}: body {body.name} has {rows}, counted from 0, got {person.max()}")


def _check(rotations: Floats, place: Floats, first: int) -> None:
    """InputError where a row is no pose; first: the number of the first row."""
    square = np.einsum("pji,pji->pj", rotations, rotations)
    if not (np.abs(square - 1.0) < 2e-6).all():
        norm = np.sqrt(square)
        row, joint = np.argwhere(~(np.abs(norm - 1.0) < 1e-6))[0].tolist()
        got = f"one of length {norm[row, joint]:g} in row {first + row}, joint {joint}"
        raise InputError(
            f"poses.rotations: expected quaternions (w, x, y, z) of length 1, got {got}"
        )
    fault = rotation_fault(place[:, :, :3])
    if fault:
        raise InputError(f"poses.world_from_reference: {fault}")
    if not np.isfinite(place).all():
        raise InputError("poses.world_from_reference: expected finite positions [m]")


def check_joints(body: Body, poses: Poses) -> None:
    """InputError where poses are of another body: not of as many joints."""
    given = poses.rotations.shape[1]
    if given != len(body.joints):
        raise InputError(
            f"poses: expected {len(body.joints)} joints, those of body {body.name}, got {given}"
        )


def people_of(body: Body, poses: Poses) -> Ints:
    """(P,) the row of the body that each pose is of.

    InputError where the poses are of another body: of other joints, or of rows that it does not
    have. UsageError where they do not say which rows they are of and are not one for each.
    """
    check_joints(body, poses)
    if poses.person is not None:
        _check_people(body, poses.person, "poses.person")
        return poses.person
    if len(body) == 1:
        return _first_rows(len(poses))
    if len(poses) != len(body):
        raise UsageError(
            f"poses: expected {len(body)} rows for {len(body)} bodies, or `person`, the body's row of "
            f"each pose, got {len(poses)} rows"
        )
    return np.arange(len(poses))


def row_for_each(body: Body, poses: Poses) -> Body:
    """A body with one row for each pose, in their order. Raises as `people_of`."""
    person = people_of(body, poses)
    alike = len(body) == len(poses) and np.array_equal(person, np.arange(len(poses)))
    return body if alike else body[person]


def check_rows(poses: Poses, count: int, what: str) -> None:
    """UsageError where there is not a row of poses for each of so many things (at least one), in
    words `what`."""
    if not count:
        raise UsageError(f"{what}: expected one at least, got none")
    if len(poses) != count:
        raise UsageError(f"poses: expected {count} rows for {count} {what}, got {len(poses)}")


def rotation_fault(matrices: Floats) -> str:
    """What is wrong with rotations (P, 3, 3), in words; "" where nothing is. A mirror image is no
    rotation."""
    gram = matrices @ matrices.transpose(0, 2, 1)
    fits = np.abs(gram - np.eye(3)) <= 1e-6
    if not fits.all():
        row = int(np.argmin(fits.all(axis=(1, 2))))
        return f"expected rotations (3, 3), got a matrix in row {row} whose rows are not unit vectors at right angles"
    turned = np.linalg.det(matrices) < 0
    if turned.any():
        return f"expected rotations (3, 3), got a mirrored one (determinant -1) in row {int(np.argmax(turned))}"
    return ""
