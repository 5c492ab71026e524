"""An environment that is described: what its file says, and what was pointed at."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.environment_parts import MOST_PIECES, pieces
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.environments import unknown_names
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh
from workbench.files.meshes.reading import outsized_words, read_mesh
from workbench.files.meshes.taken_frame import taken_frame
from workbench.files.schema import metres_in, validate
from workbench.files.seat_doubts import another_seats, floor_doubts, rest_doubts
from workbench.files.seat_figures import SeatFigures, seat_figures
from workbench.files.study.saving import StudyText, read_text
from workbench.files.yaml_changes import Key
from workbench.files.yaml_text import Document, parse_yaml
from workbench.model.arrays import Floats
from workbench.model.environment import Doubt, Rest, Seat, open_doubts
from workbench.study.describe.meshes import Hit, Meshes, PlacedMeshes
from workbench.study.describe.piece_names import named_pieces

__all__ = [
    "FITTED",
    "FLOOR",
    "INNER",
    "SECTIONS",
    "SURFACES",
    "UNSURE",
    "Description",
    "Edit",
    "OpenPlace",
    "SeatPicks",
    "Spot",
    "bare_mesh",
    "check_there",
    "figure_reasons",
    "figure_values",
    "figures_of",
    "file_stamp",
    "fitted_seat",
    "open_place",
    "open_sizes",
    "spot_of",
    "spot_place",
    "standing_of",
    "valid_file",
    "whole",
    "with_value",
    "without_value",
]

INNER = "environment.yaml"
SURFACES = ("cushion", "back")
FLOOR: Key = ("floor",)
"""Key of the spot that was picked of the floor."""
UNSURE = "guessed, not sure"
"""How a figure was got that is asked about."""
FITTED = ("srp", "cushion_angle", "back_angle", "yaw")
"""Figures of a seat that are those of its planes."""
ON_MESH = 0.002
"""A point that was picked is on the mesh still where this is at most so far [m] from it."""
DECIMALS = {"mm": 1, "cm": 2, "m": 4, "in": 3, "ft": 4}
"""Decimals of lengths in a file, by its unit: a tenth of a millimetre or finer."""


@dataclass(frozen=True)
class Spot:
    """A point of a mesh file that was pointed at: the mesh, the point in its unit and axes, and the
    number of its face."""

    mesh: int
    point: tuple[float, float, float]
    face: int


@dataclass(frozen=True)
class SeatPicks:
    """Where a cushion and a back were pointed at."""

    cushion: tuple[Spot, ...] = ()
    back: tuple[Spot, ...] = ()

    def faces(self, surface: str) -> tuple[int, ...]:
        """The faces of cushion or back that were pointed at."""
        spots: tuple[Spot, ...] = getattr(self, surface)
        return tuple(spot.face for spot in spots)

    @property
    def lacks(self) -> tuple[str, ...]:
        """The surfaces of which nothing was picked."""
        return tuple(surface for surface in SURFACES if not self.faces(surface))


@dataclass(frozen=True, eq=False)
class Description:
    """An environment as it is described.

    Parameters
    ----------
    says
        What its file is to say, as plain values in the file's own unit. It is never changed.
    picks
        What was pointed at of seats, by their names; a seat that is not in `says` lacks one of both
        surfaces.
    spots
        What was pointed at of controls and points, by their keys.
    why
        How figures were got, by their keys: the comments of the file.
    """

    says: dict[str, Any]
    picks: dict[str, SeatPicks] = field(default_factory=dict)
    spots: dict[Key, Spot] = field(default_factory=dict)
    why: dict[Key, str] = field(default_factory=dict)

    @cached_property
    def file(self) -> EnvironmentFile:
        """What the file says, checked, in metres and radians. InputError for its faults."""
        return valid_file(self.says)

    @cached_property
    def content(self) -> str:
        """A text that is the same for descriptions that say the same."""
        faces = [[name, *map(one.faces, SURFACES)] for name, one in self.picks.items()]
        guesses = [words for words in self.why.values() if words.startswith("guessed")]
        return json.dumps([self.says, faces, guesses])

    def length(self, metres: float) -> float:
        """A length [m] as it stands in the file, rounded; a whole number without a point."""
        unit = str(self.says["length"])
        return whole(round(metres / metres_in[unit], DECIMALS[unit]))

    def point(self, metres: Floats | Sequence[float]) -> list[float]:
        """A point (3,) [m] as it stands in the file, rounded."""
        return [self.length(float(value)) for value in metres]


def whole(value: float) -> float:
    """A number as a file has it: without a point where it is whole."""
    return int(value) if value.is_integer() else value


def valid_file(says: Mapping[str, Any]) -> EnvironmentFile:
    """Check what an environment's file is to say. InputError carries a line for every fault."""
    name = "environment"
    try:
        return validate(Document(name, dict(says), {}), EnvironmentFile)
    except InputError as error:
        lines = [problem.removeprefix(f"{name}:1:1: ") for problem in error.problems]
        raise InputError(lines) from None


@dataclass(frozen=True, eq=False)
class OpenPlace:
    """An environment that is open to be described.

    Parameters
    ----------
    target
        Where it is saved.
    folder
        Where its meshes lie.
    meshes
        As they are in their files.
    start
        The description as it was opened.
    text
        The file that it was opened from, None for a bare mesh.
    notes
        What was guessed, or is wrong, in words.
    stamps
        Size and time of each mesh file as it was read.
    """

    target: Path
    folder: Path
    meshes: Meshes
    start: Description
    text: StudyText | None
    notes: tuple[str, ...]
    stamps: tuple[tuple[int, int], ...]

    def changed_meshes(self, count: int) -> list[str]:
        """The first so many mesh files that are others now than those that were read, or are
        gone."""
        paths = [Path(raw.file) for raw in self.meshes.raws[:count]]
        found = zip(paths, self.stamps, map(file_stamp, paths), strict=False)
        return [path.name for path, before, now in found if before != now]


def file_stamp(path: Path) -> tuple[int, int]:
    """Return size and time of a file, -1 where it is not there."""
    try:
        stat = path.stat()
    except OSError:
        return -1, -1
    return stat.st_size, stat.st_mtime_ns


def open_place(source: Path, out: Path | None = None) -> OpenPlace:
    """Open a mesh, or an environment's file or folder, to be described.

    Parameters
    ----------
    source
        A mesh file, a YAML file, or a folder with `environment.yaml`.
    out
        The file or folder to save in; beside the mesh, or the file itself, if None.

    Raises
    ------
    InputError
        If it cannot be read, is no mesh, holds no surface, or has too many triangles.
    """
    target = None if out is None else _target(out)
    if source.is_dir() or source.suffix.lower() in (".yaml", ".yml"):
        path = source / INNER if source.is_dir() else source
        text = read_text(path)
        says = parse_yaml(text.text, str(path))
        file = validate(says, EnvironmentFile)
        for mesh in file.meshes:
            if outside_folder(mesh.file):
                raise InputError(
                    f"{path}: {mesh.file}: a mesh lies in the folder of its environment file, or "
                    f"below it"
                )
        files = [mesh.file for mesh in file.meshes]
        stamps = tuple(file_stamp(path.parent / name) for name in files)
        try:
            meshes = Meshes.read(path.parent, files)
        except InputError as error:
            raise InputError([f"{path}: meshes: {words}" for words in error.problems]) from None
        start = Description(says.value)
        names = meshes.standing(start.file.meshes).names
        opened = OpenPlace(target or path, path.parent, meshes, start, text, (), stamps)
        start, notes = _picked_before(opened)
        notes += unknown_names(says, names)
        notes += [
            f"{mesh.file}: the file does not say its unit: choose it"
            for raw, mesh in zip(meshes.raws, file.meshes, strict=True)
            if raw.metres is None and mesh.length is None
        ]
        return replace(opened, start=start, notes=tuple(notes))
    stamp = file_stamp(source)
    raw = read_mesh(source)
    start, notes = _bare(source, raw)
    beside = target or source.parent / INNER
    if beside.is_file():
        notes.append(f"{beside.name} is there already: open it instead to go on with it")
    meshes = Meshes([raw])
    start = _with_piece_names(meshes, start)
    return OpenPlace(beside, source.parent, meshes, start, None, tuple(notes), (stamp,))


def _with_piece_names(meshes: Meshes, start: Description) -> Description:
    """A description of a bare mesh, its pieces called by where they are where it is in pieces."""
    (mesh,) = start.says["meshes"]
    if "split" not in mesh:
        return start
    stands = meshes.standing(start.file.meshes)
    named = {**mesh, "join": named_pieces(stands, stands.names)}
    return replace(start, says={**start.says, "meshes": [named]})


def _target(out: Path) -> Path:
    if out.suffix.lower() in (".yaml", ".yml"):
        return out
    return out / INNER


def bare_mesh(raw: RawMesh) -> tuple[dict[str, Any], dict[Key, str]]:
    """Guess the unit and the axes of a bare mesh; one without parts is split into its pieces.

    Returns
    -------
    tuple
        What an environment's file says of it, and how that was got, by the keys of a first mesh.
    """
    why: dict[Key, str] = {}
    taken = taken_frame(raw)
    frame = {"length": taken.length, "up": taken.up, "forward": taken.forward}
    mesh: dict[str, Any] = {key: one.value for key, one in frame.items()}
    for key, one in frame.items():
        if one.why:
            why[("meshes", 0, key)] = f"{'guessed' if one.sure else UNSURE}: {one.why}"
    if len(raw.parts) == 1 and 0 < int(pieces(raw.parts[0]).max()) < MOST_PIECES:
        mesh["split"] = [raw.parts[0].name]
    return mesh, why


def _bare(source: Path, raw: RawMesh) -> tuple[Description, list[str]]:
    """A description of a bare mesh, and what was guessed for it."""
    notes = list(filter(None, [outsized_words(raw.parts)]))
    guessed, why = bare_mesh(raw)
    mesh: dict[str, Any] = {"file": source.name, **guessed}
    if raw.metres is None:
        notes.append(f"the file does not say its unit: {mesh['length']} is a guess by its size")
    if raw.up is None or raw.forward is None:
        what = "axes" if raw.up is None else "forward axis"
        notes.append(
            f"the file does not say its {what}: look at the arrow and the person beside it"
        )
    if len(raw.parts) == 1:
        count = int(pieces(raw.parts[0]).max()) + 1
        if 1 < count <= MOST_PIECES:
            notes.append(
                f"the mesh has no names of parts: its {count} connected pieces are parts, called by "
                f"where they are"
            )
        elif count > MOST_PIECES:
            notes.append(f"the mesh is one part: it falls into {count} pieces, too many for parts")
    title = " ".join(source.stem.split()) or "environment"
    says = {"environment": title, "length": "mm", "meshes": [mesh]}
    return Description(says, why=why), notes


def open_sizes(opened: OpenPlace, description: Description) -> list[Doubt]:
    """Return what is doubted of the sizes of the meshes, and not accepted."""
    file = description.file
    return open_doubts(opened.meshes.size_doubts(file.meshes), file.accepted)


def standing_of(opened: OpenPlace, description: Description) -> PlacedMeshes:
    """Return the meshes as a description has them in the world."""
    return opened.meshes.standing(description.file.meshes)


def spot_of(opened: OpenPlace, description: Description, hit: Hit) -> Spot:
    """A point that was met, as a point of its mesh file."""
    row = int(opened.meshes.mesh[hit.face])
    x, y, z = opened.meshes.in_file(description.file.meshes, row, hit.point).tolist()
    return Spot(row, (x, y, z), hit.face)


def spot_place(opened: OpenPlace, description: Description, spot: Spot) -> Floats:
    """(3,) [m] where a point of a mesh file stands."""
    points = np.array([spot.point])
    return opened.meshes.all_in_world(description.file.meshes, spot.mesh, points)[0]


def figures_of(opened: OpenPlace, description: Description, seat: str) -> SeatFigures:
    """Compute the figures of a seat from what was pointed at. InputError as of `seat_figures`."""
    picks = description.picks[seat]
    stands = standing_of(opened, description)
    if picks not in stands.figures:
        regions = [opened.meshes.grown(picks.faces(surface)) for surface in SURFACES]
        cushion, back = (stands.corners(region) for region in regions)
        lap, lean = (
            stands.corners(np.flatnonzero(np.isin(stands.part, stands.part[region])))
            for region in regions
        )
        places = [spot_place(opened, description, spot) for spot in picks.cushion]
        figures = seat_figures(cushion, back, np.array(places), cushion_part=lap, back_part=lean)
        fitted = fitted_seat(seat, figures)
        another = another_seats(fitted, back)
        if another:
            raise InputError(f"{seat}: {another}")
        doubts = (*rest_doubts(fitted, cushion, back), *floor_doubts(fitted, stands.ground))
        words = tuple(doubt.words.removeprefix(f"seat {seat!r}: ") for doubt in doubts)
        stands.figures[picks] = replace(figures, doubts=(*figures.doubts, *words))
    return stands.figures[picks]


def fitted_seat(name: str, figures: SeatFigures) -> Seat:
    """Return a seat with the figures of its planes, to be held against the mesh."""
    x, y, z = figures.srp.tolist()
    cushion, back = (Rest(surface, (), 0.0) for surface in SURFACES)
    angles = (figures.back_angle, figures.cushion_angle, figures.yaw)
    still = (0.0, 0.0)
    return Seat(name, (x, y, z), *angles, cushion, back, still, still, ())


def figure_values(description: Description, figures: SeatFigures) -> dict[str, Any]:
    """Figures of a seat as they stand in the file, by their keys."""
    degrees = {
        key: whole(round(math.degrees(getattr(figures, key)), 1))
        for key in ("cushion_angle", "back_angle", "yaw")
    }
    return {"srp": description.point(figures.srp), **degrees}


def figure_reasons(opened: OpenPlace, description: Description, seat: str) -> dict[str, str]:
    """How the figures of a seat were got, by their keys."""
    found = figures_of(opened, description, seat)
    picks = description.picks[seat]
    return {
        "srp": f"fitted: where the planes of cushion and back meet, {found.across}",
        "cushion_angle": _plane_words(opened, picks.faces("cushion"), found.cushion.off),
        "back_angle": _plane_words(opened, picks.faces("back"), found.back.off),
        "yaw": "fitted: square to the line in which the planes meet",
    }


def _plane_words(opened: OpenPlace, picks: tuple[int, ...], off: float) -> str:
    count = len(opened.meshes.grown(picks))
    faces = "1 face" if count == 1 else f"{count} faces"
    return f"fitted: plane of {faces}, {1e3 * off:.1f} mm off in the mean"


def _picked_before(opened: OpenPlace) -> tuple[Description, list[str]]:
    """The description as opened, with the picks that its file keeps, and what is wrong with them.

    A figure that is not the one of the planes was typed.
    """
    description = opened.start
    notes: list[str] = []
    for name, seat in description.file.seats.items():
        spots: dict[str, tuple[Spot, ...]] = {}
        for surface in SURFACES:
            rest = getattr(seat, surface)
            found = [_spot_at(opened, description, point) for point in rest.picked]
            spots[surface] = tuple(spot for spot in found if spot is not None)
            if None in found:
                notes.append(
                    f"{name}: what was picked of the {surface} is not on the mesh any more: pick "
                    f"it again"
                )
                spots[surface] = ()
        if not any(spots.values()):
            continue
        picks = description.picks | {name: SeatPicks(**spots)}
        description = replace(description, picks=picks)
        if picks[name].lacks:
            continue
        try:
            values = figure_values(description, figures_of(opened, description, name))
            reasons = figure_reasons(opened, description, name)
        except InputError as error:
            notes.append(f"{name}: {error}")
            continue
        says = description.says["seats"][name]
        why = {
            ("seats", name, key): reasons[key] if says.get(key, 0) == value else "typed"
            for key, value in values.items()
        }
        description = replace(description, why=description.why | why)
    return description, notes


def _spot_at(opened: OpenPlace, description: Description, point: Sequence[float]) -> Spot | None:
    hit = standing_of(opened, description).nearest(np.array(point), ON_MESH)
    return None if hit is None else spot_of(opened, description, hit)


# Edits of a description: pure functions from one description to the next.
#
# What was pointed at goes along when a unit, an axis or the floor changes; what was typed stays.
# `edits_files` has files, units, axes and the floor, `edits_seats` seats, `edits_things` controls, points and
# figures that are typed, `edits_parts` parts. Here is what they share.

SECTIONS = {"seat": "seats", "control": "controls", "point": "points"}
"""Sections of the file by the kinds of what is in them."""


@dataclass(frozen=True, eq=False)
class Edit:
    """A description, and what is to be said about it."""

    description: Description
    words: str = ""


def check_there(before: Description, kind: str, name: str) -> None:
    """InputError where a thing is not there."""
    have = before.says.get(SECTIONS[kind]) or {}
    if name not in have:
        raise InputError(f"there is no {kind} {name!r}; {one_of(name, have)}")


def with_value(says: Any, key: Key, value: Any) -> Any:
    """What a file says, with a value at a key; mappings on the way are made."""
    if not key:
        return value
    first = key[0]
    if isinstance(first, int):
        rows = list(says)
        rows[first] = with_value(rows[first], key[1:], value)
        return rows
    inner = says.get(first) if says else None
    return {**(says or {}), first: with_value({} if inner is None else inner, key[1:], value)}


def without_value(says: Mapping[str, Any], key: Key) -> dict[str, Any]:
    """What a file says, without a value; a mapping that is empty then goes too."""
    rows = {name: value for name, value in says.items() if name != key[0]}
    if len(key) == 1:
        return rows
    inner = without_value(says[str(key[0])], key[1:])
    return (
        {name: (inner if name == key[0] else value) for name, value in says.items()}
        if inner
        else rows
    )
