"""An environment that is described: what its file says, and what was pointed at."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_parts import MOST_PIECES, pieces
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh
from workbench.files.meshes.reading import axes_rotation, implausible, read_mesh, to_world
from workbench.files.meshes.sizes import implausible_sizes
from workbench.files.schema import metres_in, validate
from workbench.files.study.saving import StudyText, read_text
from workbench.files.yaml_edits import Key
from workbench.files.yaml_text import Document, parse_yaml
from workbench.model.arrays import Floats
from workbench.study.describe.meshes import Meshes, Standing
from workbench.study.describe.seats import SeatFigures, seat_figures

__all__ = [
    "Description",
    "OpenPlace",
    "SeatPicks",
    "Spot",
    "figures_of",
    "open_place",
    "standing_of",
    "valid_file",
    "whole",
]

INNER = "environment.yaml"
DECIMALS = {"mm": 1, "cm": 2, "m": 4, "in": 3, "ft": 4}
"""Decimals of lengths in a file, by its unit: a tenth of a millimetre or finer."""


@dataclass(frozen=True)
class SeatPicks:
    """The faces of a cushion and of a back that were pointed at, by their numbers."""

    cushion: tuple[int, ...] = ()
    back: tuple[int, ...] = ()


@dataclass(frozen=True)
class Spot:
    """A point of a mesh file that was pointed at: the mesh, and the point in its unit and axes."""

    mesh: int
    point: tuple[float, float, float]


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
        return json.dumps([self.says, [[name, *_faces(one)] for name, one in self.picks.items()]])

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


def _faces(picks: SeatPicks) -> list[list[int]]:
    return [list(picks.cushion), list(picks.back)]


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
        What was guessed, in words.
    """

    target: Path
    folder: Path
    meshes: Meshes
    start: Description
    text: StudyText | None
    notes: tuple[str, ...]


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
        says = parse_yaml(text.text.removeprefix("\ufeff"), str(path))
        file = validate(says, EnvironmentFile)
        for mesh in file.meshes:
            if outside_folder(mesh.file):
                raise InputError(
                    f"{path}: {mesh.file}: a mesh lies in the folder of its environment file, or "
                    f"below it"
                )
        meshes = Meshes.read(path.parent, [mesh.file for mesh in file.meshes])
        start = Description(says.value)
        meshes.standing(start.file.meshes)
        return OpenPlace(target or path, path.parent, meshes, start, text, ())
    raw = read_mesh(source)
    start, notes = _bare(source, raw)
    beside = target or source.parent / INNER
    return OpenPlace(beside, source.parent, Meshes([raw]), start, None, tuple(notes))


def _target(out: Path) -> Path:
    if out.suffix.lower() in (".yaml", ".yml"):
        return out
    return out / INNER


def _bare(source: Path, raw: RawMesh) -> tuple[Description, list[str]]:
    """A description of a bare mesh, and what was guessed for it."""
    why: dict[Key, str] = {}
    notes: list[str] = []
    up = raw.up or "z"
    forward = raw.forward or {"y": "z", "z": "x"}.get(up.lstrip("-"), "y")
    mesh: dict[str, Any] = {"file": source.name, "length": _unit(source, raw, up, forward)}
    mesh |= {"up": up, "forward": forward}
    guessed = {"length": raw.metres is None, "up": raw.up is None, "forward": raw.forward is None}
    if guessed["length"]:
        notes.append(f"the file does not say its unit: {mesh['length']} is a guess by its size")
        why[("meshes", 0, "length")] = "guessed by the size"
    if guessed["up"] or guessed["forward"]:
        notes.append("the file does not say its axes: compare with the person who stands beside it")
    for name in ("up", "forward"):
        if guessed[name]:
            why[("meshes", 0, name)] = "guessed"
    if len(raw.parts) == 1:
        count = int(pieces(raw.parts[0]).max()) + 1
        if 1 < count <= MOST_PIECES:
            mesh["split"] = [raw.parts[0].name]
            notes.append(f"the mesh has no names of parts: its {count} connected pieces are parts")
        elif count > MOST_PIECES:
            notes.append(f"the mesh is one part: it falls into {count} pieces, too many for parts")
    title = " ".join(source.stem.split()) or "environment"
    says = {"environment": title, "length": "mm", "meshes": [mesh]}
    return Description(says, why=why), notes


def _unit(source: Path, raw: RawMesh, up: str, forward: str) -> str:
    """The unit of a mesh: as the file says, else the first in which nothing has an odd size."""
    if raw.metres is not None:
        named = [unit for unit, metres in metres_in.items() if math.isclose(metres, raw.metres)]
        return named[0] if named else f"{1e3 * raw.metres:.9g} mm"
    corners = np.concatenate([part.vertices[part.faces.ravel()] for part in raw.parts])
    largest = float(np.ptp(corners, axis=0).max())
    rotation = axes_rotation(up, forward)
    best = "m"
    fewest = math.inf
    for unit in ("m", "mm", "cm", "in", "ft"):
        metres = metres_in[unit]
        odd = 100.0 if implausible(largest, metres, smallest=1.0) else 0.0
        if not odd:
            parts = to_world(raw, rotation, metres=metres)
            odd = float(len(implausible_sizes(parts, metres, file=source.stem)))
            odd += 0.5 * (largest * metres > 15.0)
        if odd < fewest:
            best = unit
            fewest = odd
    return best


def standing_of(opened: OpenPlace, description: Description) -> Standing:
    """Return the meshes as a description has them in the world."""
    return opened.meshes.standing(description.file.meshes)


def figures_of(opened: OpenPlace, description: Description, seat: str) -> SeatFigures:
    """Compute the figures of a seat from what was pointed at. InputError as of `seat_figures`."""
    picks = description.picks[seat]
    stands = standing_of(opened, description)
    key = picks.cushion, picks.back
    if key not in stands.figures:
        cushion = stands.corners(opened.meshes.grown(picks.cushion))
        back = stands.corners(opened.meshes.grown(picks.back))
        stands.figures[key] = seat_figures(cushion, back)
    return stands.figures[key]
