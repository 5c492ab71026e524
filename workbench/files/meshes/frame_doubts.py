"""What is odd about how mesh files stand in the world, each and to one another: a file with another
axis up, in another unit, or elsewhere, and names of parts that say another axis.

Nothing of it is sure. What is said gives what was seen, and the key that would mend it.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.taken_frame import (
    ABOVE,
    AHEAD,
    ALIKE,
    BEHIND,
    BELOW,
    LEFT,
    RIGHT,
    SYMMETRIC,
    named_way,
    surface_points,
    symmetries,
)
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats
from workbench.model.environment import Doubt

__all__ = ["PlacedMesh", "frame_doubts"]

CUSHIONS = frozenset(["cushion", "pan", "squab", "seatpan"])
BACKS = frozenset(["back", "backrest", "seatback", "headrest"])
"""Words of names of what is sat on, and of what is behind it."""
APART = 0.3
"""A file that is farther [m] from the box of all others is elsewhere."""
SMALL = 0.05
"""A file of a smaller share of the size of all others may be in another unit, where nothing of them is
near it."""
WITHIN = 0.9
"""Share of a file's box along each axis that lies in that of the others, where it belongs there."""
_SIGNS = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class PlacedMesh:
    """A mesh file in the world.

    Parameters
    ----------
    file
        As it is called.
    parts
        Its parts in the world [m].
    metres, rotation, move
        Of `MeshFrame`.
    """

    file: str
    parts: tuple[RawPart, ...]
    metres: float
    rotation: Floats
    move: Floats

    def axis(self, way: Floats) -> str:
        """The axis of the file that points this way (3,) in the world."""
        own = way @ self.rotation
        k = int(np.abs(own).argmax())
        return ("-" if own[k] < 0.0 else "") + _SIGNS[k]


def frame_doubts(meshes: Sequence[PlacedMesh], *, doubted: Container[str] = ()) -> Iterator[Doubt]:
    """Return what is odd about how mesh files stand.

    Parameters
    ----------
    meshes
        All that stand together.
    doubted
        Files whose unit the sizes of their own parts speak against: no other file is held against
        these.
    """
    yield from _names_say(meshes)
    meshes = [one for one in meshes if one.file not in doubted]
    if len(meshes) < 2:
        return
    points = [surface_points(one.parts) for one in meshes]
    for k in np.argsort([np.ptp(some, axis=0).max() for some in points])[:-1].tolist():
        others = np.concatenate([some for row, some in enumerate(points) if row != k])
        words = _elsewhere(meshes[k], points[k], others) or _other_up(meshes[k], points[k], others)
        if words:
            yield Doubt(f"frame of {meshes[k].file}", f"{meshes[k].file} {words}")


def _names_say(meshes: Sequence[PlacedMesh]) -> Iterator[Doubt]:
    """Names of parts that say another axis than the one that is taken."""
    parts = [part for one in meshes for part in one.parts]
    size = np.ptp(np.concatenate([part.vertices for part in parts]), axis=0)
    asked = (
        ("up", 2, ABOVE, BELOW, (True, True, True)),
        ("forward", 0, AHEAD, BEHIND, (True, True, False)),
        ("forward", 0, CUSHIONS, BACKS, (True, True, False)),
        ("left", 1, LEFT, RIGHT, (True, True, False)),
    )
    for what, axis, those, others, allowed in asked:
        told = named_way(parts, size, those, others, np.array(allowed))
        if told is None or told.way[axis] > 0.5:
            continue
        way = np.cross(told.way, [0.0, 0.0, 1.0]) if what == "left" else told.way
        key = "up" if what == "up" else "forward"
        files = ", ".join(f"{one.file} {key}: {one.axis(way)}" for one in meshes)
        yield Doubt(
            f"{key} by names", f"{told.why}, {what} is another way than it is taken: {files}?"
        )
        return


def _elsewhere(mesh: PlacedMesh, points: Floats, others: Floats) -> str:
    """That a file is away from all others, or small among them, with what would mend it; "" where it
    is not."""
    box = np.array([others.min(axis=0), others.max(axis=0)])
    own = np.array([points.min(axis=0), points.max(axis=0)])
    gap = float(np.linalg.norm(np.maximum(np.maximum(box[0] - own[1], own[0] - box[1]), 0.0)))
    size = float(np.ptp(own, axis=0).max())
    middle = own.mean(axis=0)
    near = np.linalg.norm(others - middle, axis=1).min()
    small = size < SMALL * float(np.ptp(box, axis=0).max())
    away = gap > APART or (small and near > max(2.0 * size, 0.1))
    # read in too small a unit a mesh is away, or lies about the origin, which may be on the floor
    shrunk = small and not mesh.move.any() and np.linalg.norm(middle) < size
    if not away and not shrunk:
        return ""
    lead = f"is {size:.3g} m large, and its middle {near:.2g} m from the surface of any other file"
    from_file = (own - mesh.move) / mesh.metres
    for unit, metres in sorted(metres_in.items(), key=lambda row: -row[1]):
        right = from_file * metres + mesh.move
        if metres > mesh.metres * 1.001 and (_is_within(right, box) or _is_within(box, right)):
            return f"{lead}: it would be among them if its unit were {unit} (length: {unit})"
    return f"{lead}: are its unit and place right (length, move)?" if away else ""


def _is_within(own: Floats, box: Floats) -> bool:
    """Whether a box (2, 3) lies in another one, as far as `WITHIN` says."""
    shared = np.minimum(own[1], box[1]) - np.maximum(own[0], box[0])
    return bool((shared >= WITHIN * np.ptp(own, axis=0)).all())


def _other_up(mesh: PlacedMesh, points: Floats, others: Floats) -> str:
    """That a file is alike above and below where all others are alike on the left and right; "" where
    it is not."""
    own, rest = symmetries(points), symmetries(others)
    if rest[1] < rest[2] + SYMMETRIC or own[2] < own[1] + SYMMETRIC or own[2] < ALIKE:
        return ""
    axis = mesh.axis(np.array([0.0, 1.0, 0.0])).lstrip("-")
    return (
        f"is alike above and below, all other files on the left and right: "
        f"is another of its axes up, up: {axis}?"
    )
