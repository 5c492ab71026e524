"""Edits of a description: units, axes and the floor. What was pointed at goes along."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.files.surface_planes import fitted_plane
from workbench.files.yaml_changes import Key
from workbench.study.describe.edits_parts import with_pieces_named
from workbench.study.describe.edits_seats import with_picked, with_seat_figures
from workbench.study.describe.meshes import Ray
from workbench.study.describe.state import (
    FLOOR,
    Description,
    Edit,
    OpenPlace,
    spot_of,
    spot_place,
    standing_of,
    with_value,
)

__all__ = ["AXES", "agreed", "check_row", "floored", "framed", "on_meshes", "scaled"]

AXES = ("x", "y", "z", "-x", "-y", "-z")
SMALLEST = 0.01
LARGEST = 1000.0
"""Sizes [m] that can be typed of a mesh."""
DEEP = 0.5
"""A floor under which more [m] of a mesh is, is doubted."""


def framed(
    opened: OpenPlace, before: Description, row: int, given: Mapping[str, str | None]
) -> Edit:
    """Give a mesh another unit or other axes.

    Parameters
    ----------
    row
        Of the mesh.
    given
        length, up and forward; what is None stays. An axis that is not at right angles to a new one
        gives way.

    Raises
    ------
    InputError
        If there is no such mesh, unit or axis.
    """
    check_row(before, row)
    raw = opened.meshes.raws[row]
    mesh = dict(before.says["meshes"][row])
    wanted = {name: value for name, value in given.items() if value is not None}
    words = ""
    mesh |= wanted
    up = str(mesh.get("up") or raw.up)
    forward = str(mesh.get("forward") or raw.forward)
    if up[-1:] == forward[-1:]:
        free = next(axis for axis in ("x", "y", "z") if axis != up[-1:])
        gives_way = "forward" if "up" in wanted else "up"
        mesh[gives_way] = free
        wanted[gives_way] = free
        words = f"up and forward are at right angles: {gives_way} is {free}"
    why = before.why | {("meshes", row, name): "chosen" for name in wanted}
    says = with_value(before.says, ("meshes", row), mesh)
    after = on_meshes(opened, replace(before, says=says, why=why))
    return Edit(with_pieces_named(opened, before, after, row), words)


def scaled(opened: OpenPlace, before: Description, row: int, size: float) -> Edit:
    """Give a mesh the unit in which it is so long.

    Parameters
    ----------
    row
        Of the mesh.
    size
        Its extent along x [m] as it is in truth.

    Raises
    ------
    InputError
        If there is no such mesh, it is flat along x, or the size is none of anything.
    """
    check_row(before, row)
    if not SMALLEST <= size <= LARGEST:
        raise InputError(f"a length from {SMALLEST:g} to {LARGEST:g} m is needed, got {size:g} m")
    stands = standing_of(opened, before)
    own = stands.vertices[stands.faces[(opened.meshes.mesh == row) & (stands.part >= 0)].ravel()]
    now = float(np.ptp(own[:, 0]))
    if not now > 0.0:
        raise InputError("the mesh has no length: choose its unit from the list")
    metres = opened.meshes.frame(before.file.meshes, row).metres or 1.0
    unit = f"{1e3 * metres * size / now:.6g} mm"
    edit = framed(opened, before, row, {"length": unit})
    return Edit(edit.description, f"one unit of the file is {unit}")


def agreed(before: Description) -> Edit:
    """Say that the units and axes are right that were guessed."""
    why = {
        key: "chosen" if key[0] == "meshes" and words.startswith("guessed") else words
        for key, words in before.why.items()
    }
    return Edit(replace(before, why=why), "unit and axes are right")


def check_row(before: Description, row: int) -> None:
    """InputError where there is no mesh of this number."""
    count = len(before.says["meshes"])
    if not 0 <= row < count:
        raise InputError(f"there are {count} meshes, and no mesh {row + 1}")


def floored(opened: OpenPlace, before: Description, ray: Ray) -> Edit:
    """Put the height 0 at a face that was pointed at; everything goes along. InputError where
    nothing was."""
    stands = standing_of(opened, before)
    hit = stands.hit(ray)
    plane = fitted_plane(stands.corners(opened.meshes.grown([hit.face])))
    slope = math.degrees(math.acos(min(1.0, abs(float(plane.normal[2])))))
    if slope > 45.0:
        raise InputError(f"this face slopes {slope:.0f} degrees: a floor is level")
    height = float(hit.point[2] if slope > 5.0 else plane.centre[2])
    spot = spot_of(opened, before, replace(hit, point=np.array([*hit.point[:2], height])))
    by = -height
    says = before.says
    why = dict(before.why)
    file = before.file
    step = before.length(by)
    for row, mesh in enumerate(file.meshes):
        says = with_value(says, ("meshes", row, "move"), _raised(before, mesh.move, by))
        why[("meshes", row, "move")] = f"picked: the height 0 is on {ray.part}"
    for name, seat in file.seats.items():
        says = with_value(says, ("seats", name, "srp"), _raised(before, seat.srp, by))
    for name, control in file.controls.items():
        says = with_value(says, ("controls", name, "at"), _raised(before, control.at, by))
    for name, point in file.points.items():
        says = with_value(says, ("points", name), _raised(before, point, by))
    for name, one in file.adjustments.items():
        if one.about is not None:
            key: Key = ("adjustments", name, "about", "point")
            says = with_value(says, key, _raised(before, one.about.point, by))
    for name, mirror in file.mirrors.items():
        if mirror.aims is not None:
            says = with_value(says, ("mirrors", name, "aims"), _raised(before, mirror.aims, by))
    way = "up" if step > 0.0 else "down"
    words = "the floor is at height 0"
    if step:
        words += f": everything goes {abs(step):g} {says['length']} {way}"
    if slope > 0.5:
        words += f"; this face slopes {slope:.1f} degrees, which is left as it is"
    deep = height - float(stands.bounds[0, 2])
    if deep > DEEP:
        words += f"; {deep:.2f} m of the mesh are below it: is it the floor?"
    spots = before.spots | {FLOOR: spot}
    return Edit(on_meshes(opened, replace(before, says=says, why=why, spots=spots)), words)


def _raised(before: Description, point: Sequence[float], by: float) -> list[float]:
    return before.point([point[0], point[1], point[2] + by])


def on_meshes(opened: OpenPlace, before: Description) -> Description:
    """Return a description in which what was pointed at has gone along with its mesh. A seat that
    is none with the new axes keeps its figures."""
    after = _on_floor(opened, before)
    for name in before.picks:
        if name in (before.says.get("seats") or {}):
            after = with_picked(opened, after, name)
            try:
                after = with_seat_figures(opened, after, name)
            except InputError:
                continue
    for key, spot in after.spots.items():
        if key == FLOOR:
            continue
        at = spot_place(opened, after, spot)
        place = (*key, "at") if key[0] == "controls" else key
        after = replace(after, says=with_value(after.says, place, after.point(at)))
    return after


def _on_floor(opened: OpenPlace, before: Description) -> Description:
    """A description in which the floor that was picked is at height 0 again."""
    if FLOOR not in before.spots:
        return before
    by = -float(spot_place(opened, before, before.spots[FLOOR])[2])
    if before.length(by) == 0.0:
        return before
    says = before.says
    for row, mesh in enumerate(before.file.meshes):
        says = with_value(says, ("meshes", row, "move"), _raised(before, mesh.move, by))
    return replace(before, says=says)
