"""Edits of a description: mesh files that are added, put to their places, and taken away again; units,
axes and the floor. What was pointed at goes along.

A face keeps its number: a file is added behind the others, and a description that has fewer files
leaves the last ones out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_parts import face_parts
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.meshes.parts import RawMesh
from workbench.files.meshes.reading import FORMATS, SMALLEST_OF_SEVERAL, implausible, read_mesh
from workbench.files.names import unique_names
from workbench.files.schema import metres_in
from workbench.files.surface_planes import fitted_plane
from workbench.files.yaml_changes import Key
from workbench.model.arrays import Floats
from workbench.study.describe.edits_parts import with_pieces_named
from workbench.study.describe.edits_seats import with_picked, with_seat_figures
from workbench.study.describe.meshes import Meshes, Ray
from workbench.study.describe.piece_names import named_pieces
from workbench.study.describe.state import (
    FLOOR,
    Description,
    Edit,
    OpenPlace,
    bare_mesh,
    file_stamp,
    spot_of,
    spot_place,
    standing_of,
    with_value,
)

__all__ = [
    "AXES",
    "AddedFile",
    "added_file",
    "agreed",
    "check_row",
    "files_beside",
    "floored",
    "framed",
    "met_file",
    "moved_file",
    "on_meshes",
    "removed_file",
    "scaled",
]

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


MOST_FILES = 200
"""Mesh files of a folder that are offered to be added."""


@dataclass(frozen=True, eq=False)
class AddedFile:
    """A place with one more mesh file, and the description that has it."""

    opened: OpenPlace
    edit: Edit


def added_file(opened: OpenPlace, before: Description, path: Path) -> AddedFile:
    """Add a mesh file to a description.

    Unit, axes and offset that the file does not say are those of the first file: two files of one
    place were mostly made in one frame. Parts whose names are taken get the file's name before
    theirs.

    Parameters
    ----------
    path
        The file. It is copied beside the environment when that is saved, unless it lies there.

    Raises
    ------
    InputError
        If it cannot be read as a mesh, another mesh has its name, or there would be too many
        triangles.
    """
    raw = read_mesh(path)
    name = _name_beside(opened, path)
    rows = len(before.says["meshes"])
    for row, other in enumerate(before.says["meshes"]):
        same = Path(opened.meshes.raws[row].file).resolve() == path.resolve()
        if other["file"] == name and not same:
            raise InputError(f"there is a mesh {name} already: give one of the files another name")
    mesh, why = _as_the_first(opened, before, raw)
    own = face_parts(raw, mesh.get("split", ()), (), {}).names
    called = _free_names(own, taken=standing_of(opened, before).names, stem=path.stem)
    if called:
        mesh["join"] = {new: [old] for old, new in called.items()}
    mesh = {"file": name, **mesh}
    meshes = Meshes([*opened.meshes.raws[:rows], raw])
    stamps = (*opened.stamps[:rows], file_stamp(path))
    after = replace(
        before,
        says={**before.says, "meshes": [*before.says["meshes"], mesh]},
        why=before.why | {("meshes", rows, key): words for key, words in why.items()},
    )
    place = replace(opened, meshes=meshes, stamps=stamps)
    stands = standing_of(place, after)
    if "split" in mesh:
        piece = {called.get(one, one): one for one in own}
        named = named_pieces(stands, list(piece), lead=f"{path.stem}_")
        join = {new: [piece[old] for old in some] for new, some in named.items()}
        after = replace(after, says=with_value(after.says, ("meshes", rows, "join"), join))
        called = {}
    count = f"{len(own)} part{'s' if len(own) > 1 else ''}"
    words = f"{name}: {count}, placed as the first file"
    if called:
        old, new = next(iter(called.items()))
        words += f"; names that are taken have the file's before theirs, {old} is {new!r}"
    return AddedFile(place, Edit(after, words))


def _name_beside(opened: OpenPlace, path: Path) -> str:
    """The name of a mesh as the environment has it: from its folder, or of the copy there."""
    try:
        return path.resolve().relative_to(opened.folder.resolve()).as_posix()
    except ValueError:
        return path.name


def _as_the_first(
    opened: OpenPlace, before: Description, raw: RawMesh
) -> tuple[dict[str, Any], dict[str, str]]:
    """Unit, axes and offset of a file that is added, and how they were got."""
    first = before.says["meshes"][0]
    stated = opened.meshes.raws[0]
    like = f"guessed: as {first['file']}"
    guessed, why = bare_mesh(raw)
    axes = {"up": first.get("up") or stated.up, "forward": first.get("forward") or stated.forward}
    mesh: dict[str, Any] = dict(guessed)
    reasons = {str(key[-1]): words for key, words in why.items()}
    if raw.up is None and raw.forward is None and all(axes.values()):
        mesh |= axes
        reasons |= dict.fromkeys(axes, like)
    corners = np.concatenate([part.vertices for part in raw.parts])
    largest = float(np.ptp(corners, axis=0).max())
    metres = opened.meshes.frame(before.file.meshes, 0).metres
    if raw.metres is None and not implausible(largest, metres, smallest=SMALLEST_OF_SEVERAL):
        mesh["length"] = first.get("length") or _unit_of(metres)
        reasons["length"] = like
    for key in ("move", "turn"):
        if first.get(key):
            mesh[key] = first[key]
            reasons[key] = like
    return mesh, reasons


def _unit_of(metres: float | None) -> str:
    named = [unit for unit, size in metres_in.items() if size == metres]
    return named[0] if named else f"{1e3 * (metres or 1.0):.9g} mm"


def _free_names(own: Sequence[str], *, taken: Sequence[str], stem: str) -> dict[str, str]:
    """By their names, new names of the parts of a mesh that have a name that is taken."""
    first = " ".join(stem.split())
    clash = [name for name in own if name in taken]
    others = [*taken, *(name for name in own if name not in clash)]
    found = unique_names([*others, *(f"{first} {name}" for name in clash)], first)[len(others) :]
    return dict(zip(clash, found, strict=True))


def removed_file(opened: OpenPlace, before: Description, row: int) -> Edit:
    """Take the file that was added last away again. InputError for another one, and where something
    was pointed at on it."""
    check_row(before, row)
    rows = before.says["meshes"]
    if row == 0 or row != len(rows) - 1:
        raise InputError(
            "the file that was added last is the one that can be taken away: leave parts of the "
            "others out instead"
        )
    stands = standing_of(opened, before)
    own = {stands.names[k] for k in np.unique(stands.part[opened.meshes.mesh == row]) if k >= 0}
    picked = [
        spot
        for picks in before.picks.values()
        for spot in (*picks.cushion, *picks.back)
        if spot.mesh == row
    ]
    used = picked or [spot for spot in before.spots.values() if spot.mesh == row]
    if used or own & _named_parts(before.file):
        raise InputError(
            f"{rows[row]['file']}: something was picked on it: remove that seat, control or point "
            f"first"
        )
    says = {**before.says, "meshes": rows[:-1]}
    why = {key: words for key, words in before.why.items() if key[:2] != ("meshes", row)}
    return Edit(replace(before, says=says, why=why), f"{rows[row]['file']} is not in it any more")


def _named_parts(file: EnvironmentFile) -> set[str]:
    """The parts that seats, controls, adjustments, instruments and mirrors name."""
    seats = [
        name
        for seat in file.seats.values()
        for name in (seat.cushion.part, seat.back.part, *seat.moves)
    ]
    moved = [name for one in file.adjustments.values() for name in one.parts]
    controls = [key for control in file.controls.values() for key in control.part_keys]
    instruments = [one.part for one in file.instruments.values()]
    mirrors = [one.part for one in file.mirrors.values()]
    return {*seats, *moved, *controls, *instruments, *mirrors}


def moved_file(opened: OpenPlace, before: Description, row: int, to: Sequence[float]) -> Edit:
    """Put a mesh elsewhere: its offset (3,) [m] is another one. What was pointed at goes along."""
    check_row(before, row)
    key: Key = ("meshes", row, "move")
    spots = before.spots
    if FLOOR in spots and spots[FLOOR].mesh == row:
        spots = {name: spot for name, spot in spots.items() if name != FLOOR}
    says = with_value(before.says, key, before.point(to))
    after = replace(before, says=says, spots=spots, why=before.why | {key: "typed"})
    return Edit(on_meshes(opened, after))


def met_file(opened: OpenPlace, before: Description, point: Ray, target: Ray) -> Edit:
    """Put a file so that one point of it is at a point of another file.

    Parameters
    ----------
    point
        Where the file that moves was clicked.
    target
        Where it was clicked where that point is to be.

    Raises
    ------
    InputError
        If nothing was met, or both are of one file.
    """
    stands = standing_of(opened, before)
    one = stands.hit(point)
    other = stands.hit(target)
    row = int(opened.meshes.mesh[one.face])
    if row == int(opened.meshes.mesh[other.face]):
        raise InputError("both points are of one file: click the second on another file")
    by: Floats = other.point - one.point
    to = np.array(before.file.meshes[row].move) + by
    edit = moved_file(opened, before, row, to.tolist())
    name = before.says["meshes"][row]["file"]
    millimetres = ", ".join(f"{1e3 * value:.0f}" for value in by)
    why = edit.description.why | {("meshes", row, "move"): "picked: two points brought together"}
    return Edit(replace(edit.description, why=why), f"{name} is moved by {millimetres} mm")


def files_beside(opened: OpenPlace) -> list[str]:
    """The mesh files in the folder of a place that it does not have, in the order of their names."""
    have = {Path(raw.file).name for raw in opened.meshes.raws}
    names = (
        path.name for path in sorted(opened.folder.iterdir()) if path.suffix.lower() in FORMATS
    )
    return [name for name in names if name not in have][:MOST_FILES]
