"""Read any mesh file as named parts, and bring it to metres with x forward, y left, z up.

The contents are checked before anything is built from them: the size on disk against the available
memory, the files that are referred to, the numbers, the unit, the extent.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.files.file_errors import opened
from workbench.files.meshes.dae import read_dae
from workbench.files.meshes.gltf import read_glb, read_gltf
from workbench.files.meshes.obj import read_obj
from workbench.files.meshes.parts import RawMesh, RawPart, free_memory, weld
from workbench.files.meshes.step import read_step
from workbench.files.meshes.stl import read_stl
from workbench.files.meshes.text import read_off, read_ply
from workbench.files.meshes.threemf import read_threemf
from workbench.files.names import unique_names
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats

__all__ = [
    "AXES",
    "FORMATS",
    "LARGEST",
    "SMALLEST",
    "SMALLEST_OF_SEVERAL",
    "axes_rotation",
    "extent",
    "implausible",
    "outsized",
    "outsized_words",
    "read_mesh",
    "stated_axes",
    "to_world",
]

_OUTSIZED = 5.0
"""A part that is so many times as large as all others together is none of a place."""
_FEW = 0.05
"""Share of the parts that are such, at most."""
SMALLEST = 0.3
LARGEST = 60.0
"""Extents [m] between which a cockpit, a room or a vehicle lies."""
SMALLEST_OF_SEVERAL = 0.005
"""Extent [m] that one of several meshes of an environment has at least."""
_MAX_COORDINATE = 1e9
"""Largest coordinate, in units of the file."""
_FAR = 20.0
"""Distance from the origin, in sizes of a mesh, from which on its numbers may be coarse."""
_COARSE = 1e-5
"""Step between the numbers of a mesh, as a share of its size, up to which nothing is said."""
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
"""Reader of each ending, and the memory [bytes] that a byte of the file takes at most until it is an
environment (measured on meshes of a million faces, about 1.1 kB per face)."""
_EXPORT = "export it from the program that made it as .step, .glb or .obj"
_OTHERS = {
    ".ac": "it is AC3D, of flight simulators: open it in AC3D, or in Blender with an importer for "
    "AC3D, and export it as .obj or .glb, where parts keep their names",
    ".blend": "open it in Blender and export it as .glb, where parts keep their names",
    ".fbx": "open it in Blender and export it as .glb, where parts keep their names",
    ".3ds": "open it in Blender with an importer for 3DS and export it as .glb",
    ".max": "open it in 3ds Max and export it as .obj or .glb",
    ".ma": "open it in Maya and export it as .obj",
    ".mb": "open it in Maya and export it as .obj",
    ".skp": "open it in SketchUp and export it as .glb or .dae",
    ".x3d": "open it in Blender or MeshLab and export it as .glb or .obj",
    ".wrl": "open it in Blender or MeshLab and export it as .glb or .obj",
    ".usd": "open it in Blender and export it as .glb, where parts keep their names",
    ".usdz": "open it in Blender and export it as .glb, where parts keep their names",
    ".dxf": "open it in a CAD program and export its surfaces as .stl or .obj",
    ".dwg": "open it in a CAD program and export its surfaces as .stl or .obj",
    ".iges": "open it in a CAD program, such as FreeCAD, and export it as .step",
    ".igs": "open it in a CAD program, such as FreeCAD, and export it as .step",
    ".sldprt": _EXPORT,
    ".sldasm": _EXPORT,
    ".catpart": _EXPORT,
    ".catproduct": _EXPORT,
    ".prt": _EXPORT,
    ".ipt": _EXPORT,
    ".iam": _EXPORT,
    ".f3d": _EXPORT,
    ".jt": _EXPORT,
    ".zip": "unpack it and name the mesh in it",
}
"""How files of other kinds become meshes that are read."""
AXES = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
    "-x": (-1, 0, 0),
    "-y": (0, -1, 0),
    "-z": (0, 0, -1),
}
"""What an axis of a mesh may be called, and where it points."""


def read_mesh(path: str | Path) -> RawMesh:
    """Read a mesh file into named parts, in the file's own unit and axes.

    Corners of equal position are one vertex, names are unique, every number is finite.

    Raises
    ------
    InputError
        If the file is missing, empty, broken, cut short, of an unknown kind or too large for the
        available memory, if it refers to files outside its folder, or if it holds no surface.
    MissingPartError
        If its kind needs a library that is not installed.
    """
    source = Path(path)
    ending = source.suffix.lower()
    if ending not in FORMATS:
        way_on = _OTHERS.get(ending)
        words = f"{way_on}; valid: {', '.join(FORMATS)}" if way_on else one_of("", FORMATS)
        raise InputError(f"{source}: {ending or 'no ending'} is not a mesh format; {words}")
    reader, memory_factor = FORMATS[ending]
    data = _read_bytes(source, memory_factor)
    with np.errstate(all="ignore"):  # what is not finite is refused below, with its part
        raw = reader(source, data)
    if not any(len(part.faces) for part in raw.parts):
        raise InputError(f"{source}: holds no surface (no faces)")
    names = unique_names((part.name for part in raw.parts), source.stem)
    named = [replace(part, name=name) for name, part in zip(names, raw.parts, strict=True)]
    for part in named:
        _check_vertices(source, part)
    parts = tuple(
        RawPart(part.name, *weld(part.vertices, part.faces)) for part in named if len(part.faces)
    )
    empty = (part.name for part in named if not len(part.faces))
    notes = tuple(f"part {name!r} holds no faces and is left out" for name in empty)
    notes += _coarse_notes(parts)
    return replace(raw, parts=parts, notes=raw.notes + notes)


def _coarse_notes(parts: tuple[RawPart, ...]) -> tuple[str, ...]:
    """A note on coordinates so far from the origin that the numbers of the file are too coarse.

    Single precision keeps 24 bits, texts of six digits 10^-5 of the largest number.
    """
    points = np.concatenate([part.vertices for part in parts])
    size = float(np.ptp(points, axis=0).max())
    far = float(np.abs(points).max())
    if far < _FAR * size or size == 0.0:
        return ()
    digits = 10.0 ** (np.floor(np.log10(far)) - 5)
    step = 0.0
    if np.all(np.abs(points / digits - np.round(points / digits)) < 1e-6):
        step = float(digits)
    elif np.all(points == points.astype(np.float32)):
        step = float(np.spacing(np.float32(far)))
    if step < _COARSE * size:
        return ()
    return (
        f"lies {far:.4g} units from the origin, where the numbers of the file are {step:.2g} apart, 1/"
        f"{size / step:.0f} of its size: move it to the origin and export it again",
    )


def _check_vertices(path: Path, part: RawPart) -> None:
    if not np.all(np.isfinite(part.vertices)):
        raise InputError(f"{path}: part {part.name!r}: has vertices that are not finite numbers")
    if np.any(np.abs(part.vertices) > _MAX_COORDINATE):
        raise InputError(
            f"{path}: part {part.name!r}: has vertices farther than {_MAX_COORDINATE:g} units: damaged?"
        )


def _read_bytes(source: Path, memory_factor: float) -> bytes:
    """Read a file; refuse one that needs more memory than is free."""
    with opened(source, "a mesh file") as file:
        size = os.fstat(file.fileno()).st_size
        needed = size * memory_factor
        free = free_memory()
        if free is not None and needed > free:
            raise InputError(
                f"{source}: {size / 2**20:.0f} MiB need up to {needed / 2**30:.1f} GiB of memory to read, "
                f"{free / 2**30:.1f} GiB are free: simplify the mesh or split it"
            )
        data = file.read()
    if not data.strip():
        raise InputError(f"{source}: is empty")
    return data


def axes_rotation(up: str, forward: str) -> Floats:
    """Return the rotation (3, 3) from the file's axes to x forward, y left, z up.

    It is always right-handed, so it cannot mirror.

    Parameters
    ----------
    up, forward
        Axes of the file: x, y, z, -x, -y or -z.

    Raises
    ------
    UsageError
        If an axis is unknown, or the two are not at right angles.
    """
    for name, given in (("up", up), ("forward", forward)):
        if given not in AXES:
            raise UsageError(f"{name}: {given!r} is not an axis; {one_of(given, AXES)}")
    if up[-1] == forward[-1]:
        raise UsageError(f"forward ({forward}) must be at right angles to up ({up})")
    x = np.array(AXES[forward], dtype=np.float64)
    z = np.array(AXES[up], dtype=np.float64)
    return np.array([x, np.cross(z, x), z])


def stated_axes(raw: RawMesh, up: str | None, forward: str | None) -> Floats:
    """Return the rotation of `axes_rotation` for axes that are given, or stated by the file.

    Parameters
    ----------
    raw
        The mesh. glTF states both axes (y and z), COLLADA the upward one.
    up, forward
        Axes that the user gives; None for those of the file.

    Raises
    ------
    InputError
        If an axis is neither given nor stated, or the two are not at right angles.
    """
    for name, given, stated in (("up", up, raw.up), ("forward", forward, raw.forward)):
        if given is None and stated is None:
            raise InputError(
                f"{raw.file}: the file does not say its axis {name}: state it ({name}: {', '.join(AXES)})"
            )
    try:
        return axes_rotation(up or str(raw.up), forward or str(raw.forward))
    except UsageError as error:
        raise InputError(f"{raw.file}: {error}") from None


def to_world(
    raw: RawMesh, rotation: Floats, *, metres: float, move: Floats | None = None
) -> tuple[RawPart, ...]:
    """Transform the parts of a mesh to the world.

    Parameters
    ----------
    raw
        The mesh.
    rotation
        (3, 3) see `axes_rotation`.
    metres
        Unit of the file [m].
    move
        (3,) translation [m] after that, None for none.
    """
    offset = np.zeros(3) if move is None else move
    return tuple(
        RawPart(part.name, part.vertices * metres @ rotation.T + offset, part.faces)
        for part in raw.parts
    )


def extent(parts: tuple[RawPart, ...]) -> Floats:
    """Return the size (3,) of all parts together along each axis."""
    low = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
    return np.max([part.vertices.max(axis=0) for part in parts], axis=0) - low


def outsized(parts: Sequence[RawPart]) -> tuple[RawPart, ...]:
    """Return the few parts that are each many times as large as all others together, such as cones of
    light: they say nothing about the unit and the axes of a place."""
    order = sorted(parts, key=lambda part: -float(np.ptp(part.vertices, axis=0).max()))
    for count in range(int(_FEW * len(order)), 0, -1):
        rest = float(extent(tuple(order[count:])).max())
        if float(np.ptp(order[count - 1].vertices, axis=0).max()) >= _OUTSIZED * rest:
            return tuple(order[:count])
    return ()


def outsized_words(parts: Sequence[RawPart]) -> str:
    """Return a sentence about the parts of `outsized`; "" where there are none."""
    aside = outsized(parts)
    if not aside:
        return ""
    others = tuple(part for part in parts if part not in aside)
    times = float(extent(aside).max() / extent(others).max())
    names = ", ".join(repr(part.name) for part in aside)
    return (
        f"{names}: {times:.0f} times as large as all other parts together, left aside for unit and "
        f"axes; drop what is no part of the place (drop: [{', '.join(p.name for p in aside)}])"
    )


def implausible(largest: float, metres: float | None, *, smallest: float = SMALLEST) -> str | None:
    """Return a message about a mesh of implausible size or of unknown unit, None if it is plausible.

    Parameters
    ----------
    largest
        Largest extent, in units of the file.
    metres
        Unit of the file [m], None if it is unknown.
    smallest
        Smallest plausible extent [m].
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
