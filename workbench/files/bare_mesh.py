"""An environment of bare mesh files, to be looked at: one, or several that stand in one frame."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.files import environments
from workbench.files.catalogue import is_file
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.frame_doubts import PlacedMesh, frame_doubts
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import (
    FORMATS,
    LARGEST,
    SMALLEST,
    SMALLEST_OF_SEVERAL,
    extent,
    implausible,
    outsized_words,
    read_mesh,
    to_world,
)
from workbench.files.meshes.scene import mesh_of_scene
from workbench.files.meshes.sizes import implausible_sizes
from workbench.files.meshes.taken_frame import TakenFrame, taken_frame
from workbench.files.names import unique_names
from workbench.files.schema import to_metres
from workbench.model.arguments import caller_level
from workbench.model.environment import Environment

__all__ = [
    "BareMesh",
    "environment_of_scene",
    "is_place",
    "load_environment",
    "placed_file",
    "read_bare",
]

_NO_MOVE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class BareMesh:
    """Mesh files as they are looked at.

    Parameters
    ----------
    environment
        Their parts in the world, without rules, seats or points.
    raws
        As they were read.
    frames
        How each is taken.
    assumed
        Sentences about what was guessed, each once.
    problem
        Why they would be refused as an environment as they are; None where they would not.
    """

    environment: Environment
    raws: tuple[RawMesh, ...]
    frames: tuple[TakenFrame, ...]
    assumed: tuple[str, ...]
    problem: str | None


def read_bare(
    sources: Sequence[str | Path],
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> BareMesh:
    """Read mesh files to be looked at. What they do not say is guessed, and nothing is refused for
    its size.

    Files of which the same is known are guessed about together.

    Parameters
    ----------
    sources
        Each a file, or FILE@X,Y,Z: moved by so much forward, left and up, in metres or with units
        (`wheel.stl@400mm,0,250mm`).
    length, up, forward
        Of all, where the files do not say them or are wrong.

    Raises
    ------
    InputError
        If a file cannot be read, or a unit or a place is none. UsageError for wrong axes.
    """
    placed = [placed_file(source) for source in sources]
    raws = tuple(read_mesh(path) for path, _ in placed)
    frames = tuple(
        taken_frame(_alike(raw, raws), length=length, up=up, forward=forward) for raw in raws
    )
    alone = len(raws) == 1
    parts: list[RawPart] = []
    meshes: list[PlacedMesh] = []
    notes: list[str] = []
    problems: list[str] = []
    doubted: list[str] = []
    for raw, frame, (path, move) in zip(raws, frames, placed, strict=True):
        own = to_world(raw, frame.rotation, metres=frame.metres, move=np.array(move))
        meshes.append(PlacedMesh(path.name, own, frame.metres, frame.rotation, np.array(move)))
        taken = {part.name for part in parts}
        parts += [
            replace(part, name=f"{path.stem}_{part.name}") if part.name in taken else part
            for part in own
        ]
        lead = "" if alone else f"{path.name}: "
        sizes = implausible_sizes(own, frame.metres, file=path.stem)
        doubted += [path.name] if sizes else []
        said = filter(None, (outsized_words(raw.parts), *sizes, *raw.notes))
        notes += [f"{lead}{note}" for note in said]
        told = raw.metres if length is None else frame.metres
        smallest = SMALLEST if alone else SMALLEST_OF_SEVERAL
        wrong = implausible(float(extent(raw.parts).max()), told, smallest=smallest)
        problems += [f"{lead}{wrong}"] if wrong else []
    notes += [doubt.words for doubt in frame_doubts(meshes, doubted=doubted)]
    names = unique_names((part.name for part in parts), "part")
    named = [replace(part, name=name) for part, name in zip(parts, names, strict=True)]
    title = " and ".join(path.stem for path, _ in placed)
    environment, _ = build_environment(title, named, solid=["auto"] * len(named), notes=notes)
    assumed = dict.fromkeys(words for frame in frames for words in frame.assumed())
    if not alone and not any(any(move) for _, move in placed):
        assumed[_one_frame(meshes)] = None
    return BareMesh(environment, raws, frames, tuple(assumed), "; ".join(problems) or None)


def _one_frame(meshes: Sequence[PlacedMesh]) -> str:
    """That files stand where their own coordinates say, from where to where, and what moves one."""
    places = []
    for mesh in meshes:
        points = np.concatenate([part.vertices for part in mesh.parts])
        ends = np.round(1e3 * np.array([points.min(axis=0), points.max(axis=0)])).astype(int).T
        ranges = ", ".join(
            f"{axis} {low} to {high}"
            for axis, (low, high) in zip("xyz", ends.tolist(), strict=True)
        )
        places.append(f"{mesh.file} {ranges} mm")
    return (
        f"all files in one frame: {'; '.join(places)}; where one stands elsewhere, {meshes[-1].file}@X,Y,Z "
        "moves it (move: in an environment)"
    )


def _alike(raw: RawMesh, raws: Sequence[RawMesh]) -> RawMesh:
    """A mesh with the parts of all files of which the same is known."""
    known = (raw.metres, raw.up, raw.forward)
    alike = [one for one in raws if (one.metres, one.up, one.forward) == known]
    return replace(raw, parts=tuple(part for one in alike for part in one.parts))


def placed_file(source: str | Path) -> tuple[Path, tuple[float, float, float]]:
    """Return a file, and how far it is moved [m], of FILE or FILE@X,Y,Z. InputError for another
    place."""
    text = str(source)
    name, at, given = text.rpartition("@")
    if not at or is_file(Path(text)):
        return Path(text), _NO_MOVE
    lengths = given.split(",")
    try:
        if len(lengths) != 3:
            raise ValueError("three lengths are needed")
        x, y, z = (_length(one.strip()) for one in lengths)
    except ValueError as error:
        raise InputError(
            f"{text}: a place is written FILE@X,Y,Z, forward, left and up, such as "
            f"{name}@400mm,0,250mm: {error}"
        ) from None
    return Path(name), (x, y, z)


def _length(text: str) -> float:
    """A number of metres, or a length with its unit [m]; ValueError for anything else."""
    try:
        metres = float(text)
    except ValueError:
        metres = to_metres(text)
    if not abs(metres) <= LARGEST:
        raise ValueError(f"{text} is farther than {LARGEST:g} m: is a unit missing, {text}mm?")
    return metres


# Environments of bare meshes, as Python asks for them: what a mesh does not say is guessed and
# reported.


def is_place(source: str) -> bool:
    """Whether a text is the path of a mesh, by its ending, or of an environment's folder."""
    return _is_mesh(source) or _folder(source) is not None


def _is_mesh(source: str | Path) -> bool:
    return Path(source).suffix.lower() in FORMATS


def load_environment(
    source: str | Path,
    *,
    near: Path | None = None,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Environment:
    """Load an environment, or a bare mesh as one.

    Parameters
    ----------
    source
        A folder with `environment.yaml`, a name of the catalogue, a YAML file, or a mesh file. What
        neither the mesh nor the call says is guessed, as `workbench live` does it: a warning of
        Python tells what and why, and so do the environment's `warnings`.
    near
        The folder of the file that names it.
    length, up, forward
        Of a mesh: its unit (mm, cm, m, in, ft, or one unit's length such as "150 mm"), and its axes
        (x, y, z, -x, -y, -z) that point up and forward.

    Raises
    ------
    InputError
        With a line for each fault; those of a YAML file with file, line and column.
    UsageError
        If the axes are none, or what belongs to a mesh is given for something else.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> len(trainer.parts), trainer.seat("left").travel_forward  # [m]
    (85, (-0.09, 0.09))
    """
    if _is_mesh(source):
        path = Path(source) if near is None else near / source
        return _taken(read_mesh(path), path.stem, length=length, up=up, forward=forward)
    for name, given in (("length", length), ("up", up), ("forward", forward)):
        if given is not None:
            raise UsageError(
                f"{name}: belongs to a mesh file ({', '.join(FORMATS)}); {source} says it itself"
            )
    return environments.load_environment(_folder(source) or source, near=near)


def _folder(source: str | Path) -> Path | None:
    """The folder of an environment that lies where the program runs; None where there is none of
    this name."""
    return Path(source) if is_file(Path(source) / "environment.yaml") else None


def environment_of_scene(scene: Any) -> Environment:
    """Take a mesh or a scene of trimesh for an environment. See `load_environment`.

    Its unit is that of its `units`, its axes are those of its metadata ("up", "forward"): what is
    not there is guessed.
    """
    return _taken(mesh_of_scene(scene, "scene"), "scene")


def _taken(
    raw: RawMesh,
    name: str,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Environment:
    """A mesh with its unit and axes as they are stated, else guessed."""
    frame = taken_frame(raw, length=length, up=up, forward=forward)
    assumed = list(frame.assumed())
    if assumed:
        warnings.warn(
            f"{raw.file}: assumed, as nothing says it: {'; '.join(assumed)}. Where that is wrong, "
            "state length, up and forward (wb.load_environment, wb.environment_from_mesh)",
            stacklevel=caller_level(),
        )
    notes = [f"{raw.file}: assumed: {words}" for words in assumed]
    return environments.bare_environment(
        raw, name, metres=frame.metres, rotation=frame.rotation, notes=notes
    )
