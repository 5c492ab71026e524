"""Posture files: named postures of a family of bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, Field

from workbench.errors import InputError, one_of
from workbench.files.body.bodies import body_path
from workbench.files.body.schema import BodyFile
from workbench.files.catalogue import find_beside
from workbench.files.schema import FileModel, Length, Vector, error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.joint_angles import attitude_matrix, motion_of, pose
from workbench.model.poses import Poses

__all__ = [
    "AdjustFile",
    "AnglesFile",
    "AreaFile",
    "AtFile",
    "AttitudeFile",
    "PostureFile",
    "PosturesFile",
    "StandFile",
    "Turns",
    "flat_angles",
    "load_postures",
    "posture_path",
    "posture_pose",
    "replaced_angles",
]

Angle = Annotated[float, Field(ge=-720, le=720)]
AnglesFile = dict[str, dict[str, Angle]]
Quaternion = Annotated[tuple[float, float, float, float], Field(strict=False)]
Turns = dict[str, dict[str, float]]


class AttitudeFile(FileModel):
    """Attitude of the reference segment in degrees; pitch + is nose down, yaw + to the left."""

    pitch: Angle = 0.0
    roll: Angle = 0.0
    yaw: Angle = 0.0

    def matrix(self) -> object:
        """(3, 3) world from segment."""
        pitch, roll, yaw = (math.radians(angle) for angle in (self.pitch, self.roll, self.yaw))
        return attitude_matrix(pitch=pitch, roll=roll, yaw=yaw)


class PostureFile(FileModel):
    """A named posture: attitude of the reference segment, joint angles, quaternions for what angles
    cannot say."""

    description: str = ""
    attitude: AttitudeFile = AttitudeFile()
    angles: AnglesFile = {}
    rotations: dict[str, Quaternion] = {}


class PosturesFile(FileModel):
    """A file of postures for bodies with the same joints; `reference` is the segment they are
    placed by."""

    reference: str
    postures: Annotated[dict[str, PostureFile], Field(min_length=1)]


def posture_path(body: str | Path, *, near: Path | None = None) -> Path | None:
    """The posture file that a body file names, or None.

    It lies beside the body, or in the catalogue of bodies. InputError where it is in neither.
    """
    path = body_path(body, near=near)
    document = read_yaml(path)
    named = validate(document, BodyFile).postures
    if named is None:
        return None
    return find_beside(document, ("postures",), named)


def load_postures(path: Path, body: Body) -> tuple[PosturesFile, Document]:
    """Read a posture file and check every joint and motion in it against a body; InputError lists
    all faults."""
    document = read_yaml(path)
    file = validate(document, PosturesFile)
    faults = []
    if file.reference not in body.segments:
        what = f"body {body.name} has no segment {file.reference!r}; {one_of(file.reference, body.segments)}"
        faults.append(error_at(document, ("reference",), what))
    for name, posture in file.postures.items():
        key = ("postures", name)
        problems = flat_angles(body, posture.angles)[1]
        faults += [error_at(document, (*key, "angles", *place), what) for place, what in problems]
        faults += [
            error_at(document, (*key, "rotations", joint), what)
            for joint, what in _rotation_problems(body, posture)
        ]
    if faults:
        raise InputError(faults)
    return file, document


def _rotation_problems(body: Body, posture: PostureFile) -> Iterator[tuple[str, str]]:
    """The joints of a posture whose rotation is wrong, and how."""
    for joint, quaternion in posture.rotations.items():
        if joint not in body.joints:
            what = f"body {body.name} has no joint {joint!r}; {one_of(joint, body.joints)}"
            yield joint, what
        if not 1e-9 <= math.hypot(*quaternion) < math.inf:
            what = f"a rotation w, x, y, z is needed, whose length is not zero (got {list(quaternion)})"
            yield joint, what


def flat_angles(body: Body, angles: AnglesFile) -> tuple[Turns, list[tuple[tuple[str, ...], str]]]:
    """Degrees by joint and motion from keys that may name several joints ("LH RH"); and what is
    wrong, with its key."""
    turns: Turns = {}
    faults: list[tuple[tuple[str, ...], str]] = []
    for key, motions in angles.items():
        joints = key.replace(",", " ").split()
        if not joints:
            faults.append(((key,), f"no joint is named here; {one_of(key, body.joints)}"))
        for joint in joints:
            if joint not in body.joints:
                what = f"body {body.name} has no joint {joint!r}; {one_of(joint, body.joints)}"
                faults.append(((key,), what))
                continue
            for motion, degrees in motions.items():
                try:
                    _turn(body, turns, joint, motion, degrees)
                except InputError as error:
                    faults.append(((key, motion), str(error)))
    return turns, faults


def _turn(body: Body, turns: Turns, joint: str, motion: str, degrees: float) -> None:
    """Turn a joint by a motion, in place of what turned it about the same axis before; InputError
    where it has no such motion."""
    j = body.joint(joint)
    axis, _ = motion_of(body, j, motion)
    known = turns.get(joint, {})
    kept = {old: angle for old, angle in known.items() if motion_of(body, j, old)[0] != axis}
    turns[joint] = kept | {motion: degrees}


def posture_pose(
    body: Body,
    file: PosturesFile,
    name: str,
    *,
    more: AnglesFile | None = None,
    attitude: AttitudeFile | None = None,
) -> Poses:
    """One pose of a body in a named posture, the reference segment at the world's origin.

    more: angles that replace the posture's, axis by axis. InputError for an unknown posture or
    joint.
    """
    if name not in file.postures:
        raise InputError(f"no posture {name!r}; {one_of(name, file.postures)}")
    posture = replaced_angles(body, file.postures[name], more or {})
    matrix = (attitude or posture.attitude).matrix()
    return pose(
        body,
        posture.angles,
        rotations=posture.rotations,
        reference=file.reference,
        attitude=matrix,  # type: ignore[arg-type]
    )


def replaced_angles(body: Body, posture: PostureFile, more: AnglesFile) -> PostureFile:
    """A posture with some angles replaced, axis by axis. InputError for an unknown joint."""
    turns, faults = flat_angles(body, posture.angles)
    extra, more_faults = flat_angles(body, more)
    if faults or more_faults:
        raise InputError([what for _, what in faults + more_faults])
    for joint, motions in extra.items():
        j = body.joint(joint)
        axes = {motion_of(body, j, motion)[0] for motion in motions}
        known = turns.get(joint, {}).items()
        kept = {motion: d for motion, d in known if motion_of(body, j, motion)[0] not in axes}
        turns[joint] = kept | motions
    rotations = {joint: q for joint, q in posture.rotations.items() if joint not in extra}
    return posture.model_copy(update={"angles": turns, "rotations": rotations})


WIDEST = 2.0
"""Width [m] of an area to step in, at most: the search of a position goes all over it."""


class AdjustFile(FileModel):
    """Where in its travel a seat stands."""

    forward: Length = 0.0
    up: Length = 0.0


class AtFile(FileModel):
    """A segment at a place."""

    segment: str
    position: Vector
    attitude: AttitudeFile = AttitudeFile()


def _rising(value: tuple[float, float]) -> tuple[float, float]:
    low, high = value
    if not low <= 0.0 <= high:
        raise ValueError(
            "it is from how far behind or to the right, 0 or negative, to how far "
            "ahead or to the left, 0 or positive: [-200, 300]"
        )
    if high - low > WIDEST:
        raise ValueError(f"an area is {WIDEST:g} m wide at most")
    return value


Steps = Annotated[tuple[Length, Length], Field(strict=False), AfterValidator(_rising)]


class AreaFile(FileModel):
    """The area within which the feet may be: how far from the point they may step, as the person
    faces, forward and to the left; negative to the rear and to the right."""

    forward: Steps = (0.0, 0.0)
    left: Steps = (0.0, 0.0)


class StandFile(FileModel):
    """A point that the lowest sphere stands on, the heading, and how far the person may step."""

    on: Vector
    yaw: Annotated[float, Field(ge=-360, le=360)] = 0.0
    area: AreaFile | None = None
