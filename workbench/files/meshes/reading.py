"""Any mesh file as named parts in metres, x forward, y left, z up.

What the file holds is checked before anything is built from it: its size on disk against the memory
at hand, the files it refers to, its numbers, its unit, its extent.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.files.meshes.bounds import free_memory
from workbench.files.meshes.dae import read_dae
from workbench.files.meshes.gltf import read_glb, read_gltf
from workbench.files.meshes.obj import read_obj
from workbench.files.meshes.parts import RawMesh, RawPart, weld
from workbench.files.meshes.step import read_step
from workbench.files.meshes.stl import read_stl
from workbench.files.meshes.text import read_off, read_ply
from workbench.files.meshes.threemf import read_threemf
from workbench.files.names import unique_names
from workbench.files.opening import opened
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats

__all__ = [
    "FORMATS",
    "LARGEST",
    "SMALLEST",
    "axes_rotation",
    "extent",
    "implausible",
    "read_mesh",
    "stated_axes",
    "to_world",
]

SMALLEST = 0.3
LARGEST = 60.0
"""Extents [m] between which a cockpit, a room or a vehicle lies."""
_FARTHEST = 1e9
_Reader = Callable[[Path, bytes], RawMesh]
FORMATS: dict[str, tuple[_Reader, float]] = {
    ".obj": (read_obj, 28),
    ".stl": (read_stl, 23),
    ".ply": (read_ply, 60),
    ".off": (read_off, 60),
    ".glb": (read_glb, 65),
    ".gltf": (read_gltf, 65),
    ".dae": (read_dae, 40),
    ".3mf": (read_threemf, 240),
    ".step": (read_step, 60),
    ".stp": (read_step, 60),
}
"""Reader of each ending, and how many bytes of memory a byte of the file takes at most until it is
an environment (measured on meshes of a million faces, about 1.1 kB a face)."""
_DIRECTIONS = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
    "-x": (-1, 0, 0),
    "-y": (0, -1, 0),
    "-z": (0, 0, -1),
}


def read_mesh(path: str | Path) -> RawMesh:
    """Read a mesh file into named parts, in the file's own unit and axes.

    Corners of equal position are one vertex, names are unique, every number is finite. InputError,
    one line, where the file is missing, empty, broken, cut short, of an unknown kind, too large for
    the memory at hand, refers to files outside its folder, or holds no surface; MissingPartError
    where its kind needs a library that is not installed.
    """
    source = Path(path)
    if source.suffix.lower() not in FORMATS:
        raise InputError(
            f"{source}: {source.suffix or 'no ending'} is not a mesh format; {one_of('', FORMATS)}"
        )
    reader, factor = FORMATS[source.suffix.lower()]
    data = _bytes(source, factor)
    with np.errstate(
        all="ignore"
    ):  # what is not finite is reported below, with the name of its part
        raw = reader(source, data)
    if not raw.parts or not any(len(part.faces) for part in raw.parts):
        raise InputError(f"{source}: holds no surface (no faces)")
    names = unique_names((part.name for part in raw.parts), source.stem)
    for name, part in zip(names, raw.parts, strict=True):
        if not np.all(np.isfinite(part.vertices)):
            raise InputError(f"{source}: part {name!r}: has vertices that are not finite numbers")
        if np.any(np.abs(part.vertices) > _FARTHEST):
            raise InputError(
                f"{source}: part {name!r}: has vertices farther than {_FARTHEST:g} units: damaged?"
            )
    parts = tuple(
        RawPart(name, *weld(p.vertices, p.faces))
        for name, p in zip(names, raw.parts, strict=True)
        if len(p.faces)
    )
    empty = [name for name, part in zip(names, raw.parts, strict=True) if not len(part.faces)]
    notes = raw.notes + tuple(f"part {name!r} holds no faces and is left out" for name in empty)
    return replace(raw, parts=parts, notes=notes)


def _bytes(source: Path, factor: float) -> bytes:
    with opened(source, "a mesh file") as file:
        size = os.fstat(file.fileno()).st_size
        need = size * factor
        have = free_memory()
        if have is not None and need > have:
            raise InputError(
                f"{source}: {size / 2**20:.0f} MiB need up to {need / 2**30:.1f} GiB of memory to read, "
                f"{have / 2**30:.1f} GiB are free: simplify the mesh or split it"
            )
        data = file.read()
    if not data.strip():
        raise InputError(f"{source}: is empty")
    return data


def axes_rotation(up: str, forward: str) -> Floats:
    """(3, 3) rotation from the file's axes to x forward, y left, z up: `world = axes(...) @ file`.

    up, forward: x, y, z, -x, -y or -z of the file. Always right-handed, so it cannot mirror.
    UsageError where a direction is unknown or the two are not at right angles.
    """
    for name, given in (("up", up), ("forward", forward)):
        if given not in _DIRECTIONS:
            raise UsageError(f"{name}: {given!r} is not an axis; {one_of(given, _DIRECTIONS)}")
    if up[-1] == forward[-1]:
        raise UsageError(f"forward ({forward}) must be at right angles to up ({up})")
    x = np.array(_DIRECTIONS[forward], dtype=np.float64)
    z = np.array(_DIRECTIONS[up], dtype=np.float64)
    return np.array([x, np.cross(z, x), z])


def stated_axes(raw: RawMesh, up: str | None, forward: str | None) -> Floats:
    """(3, 3) rotation as `axes`, from the axes given or, where None, those the file or its format
    says.

    glTF says both (y and z), COLLADA says up. InputError where nobody says one, or the two are not
    at right angles.
    """
    for name, given, told in (("up", up, raw.up), ("forward", forward, raw.forward)):
        if given is None and told is None:
            raise InputError(
                f"{raw.file}: the file does not say its axis {name}: state it ({name}: {', '.join(_DIRECTIONS)})"
            )
    try:
        return axes_rotation(up or str(raw.up), forward or str(raw.forward))
    except UsageError as error:
        raise InputError(f"{raw.file}: {error}") from None


def to_world(
    raw: RawMesh, rotation: Floats, *, metres: float, move: Floats | None = None
) -> tuple[RawPart, ...]:
    """The parts turned by `rotation` (3, 3) after the unit `metres` is applied, then moved by
    `move` (3,) [m]."""
    shift = np.zeros(3) if move is None else move
    return tuple(
        RawPart(p.name, p.vertices * metres @ rotation.T + shift, p.faces) for p in raw.parts
    )


def extent(parts: tuple[RawPart, ...]) -> Floats:
    """(3,) size along each axis of all parts together."""
    low = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
    size: Floats = np.max([part.vertices.max(axis=0) for part in parts], axis=0) - low
    return size


def implausible(largest: float, metres: float | None, *, smallest: float = SMALLEST) -> str | None:
    """What to say about a mesh whose largest extent is `largest` file units of `metres` each; None
    where it is fine.

    metres None: no unit is known, which is said too.
    """
    if metres is not None and smallest <= largest * metres <= LARGEST:
        return None
    sizes = [f"{largest * size:.3g} m in {unit}" for unit, size in metres_in.items()]
    shown = "its largest extent would be " + ", ".join(sizes)
    if metres is None:
        return f"the file does not say its unit of length; {shown}: state the unit (length: {', '.join(metres_in)})"
    return (
        f"is {largest * metres:.3g} m large, and {smallest:g} to {LARGEST:g} m is plausible; {shown}: "
        "state the right unit of length"
    )
