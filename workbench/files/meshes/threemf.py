"""Read 3MF, a zip archive of XML, as a stream, so that the unpacked text is never held in memory.

Objects of the build are read with their transforms, components within components, and models in
other files of the archive (production extension). Materials, textures, slices and beams are
skipped.

References
----------
3MF Consortium (2021), 3D Manufacturing Format Core Specification 1.3: 3 (model), 4 (objects);
Production Extension.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, NamedTuple
from xml.parsers import expat

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.parts import MAX_INSTANCES, RawMesh, RawPart, check_faces, placed_part
from workbench.model.arrays import Floats, Ints

__all__ = ["read_threemf"]

_METRES = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 0.01,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
_MAX_UNPACKED = 2 * 2**30
"""Largest unpacked size [bytes]."""
_MAX_RATIO = 200
"""Largest compression ratio. Text of meshes reaches about 10, of equal lines about 100."""
_RATIO_FREE_SIZE = 16 * 2**20
"""Bytes of a file in the archive below which its ratio does not matter."""
_CHUNK = 2**20
"""Bytes that are parsed at once."""
_RELATIONS = "_rels/.rels"
_MODEL_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

_Start = Callable[[str, dict[str, str]], None]
_Key = tuple[str, str]
"""An object: the file of the archive it stands in, and its number there."""


@dataclass(frozen=True)
class _Placed:
    """An object where the build or another object places it."""

    key: _Key
    transform: Floats
    """(4, 4)."""
    name: str = ""


@dataclass
class _Object:
    """An object: its own vertices and triangles, or the objects that it is made of."""

    name: str
    vertices: array[float] = field(default_factory=lambda: array("d"))
    corners: array[int] = field(default_factory=lambda: array("q"))
    components: list[_Placed] = field(default_factory=list)


@dataclass
class _Model:
    """What all models of an archive hold."""

    objects: dict[_Key, _Object] = field(default_factory=dict)
    build: list[_Placed] = field(default_factory=list)
    units: dict[str, str] = field(default_factory=dict)
    """Unit of each file that is read."""


def read_threemf(path: Path, data: bytes) -> RawMesh:
    """Read the objects that a 3MF file builds, one part each, in the unit that it states.

    Raises
    ------
    InputError
        If it is no 3MF file, unpacks to too much, is broken, or names absent objects.
    """
    model = _Model()
    try:
        root = _read_archive(path, data, model)
        placed = list(_leaves(model))
        objects = [model.objects[one.key] for one in placed]
        faces = sum(len(each.corners) for each in objects) // 3
        corners = sum(len(each.vertices) for each in objects) // 3
        check_faces(path, faces, corners)
        parts = tuple(_part(model, one) for one in placed)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError) as error:
        raise InputError(f"{path}: not a 3MF file, or damaged: {str(error)[:200]}") from None
    except expat.ExpatError as error:
        raise InputError(f"{path}: broken 3MF: not XML: {error}") from None
    except (ValueError, KeyError, OverflowError, MemoryError) as error:
        reason = f"{error} is missing" if isinstance(error, KeyError) else str(error)[:200]
        raise InputError(f"{path}: broken 3MF: {reason or type(error).__name__}") from None
    built = {one.key for one in placed}
    left = sum(bool(item.corners) for key, item in model.objects.items() if key not in built)
    notes = (f"{left} objects are not part of the build and are left out",) if left else ()
    return RawMesh(str(path), "3MF", parts, _METRES[model.units[root]], notes=notes)


def _read_archive(path: Path, data: bytes, model: _Model) -> str:
    """Read all models of an archive that the build needs; returns the file of the root model."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        _check_sizes(path, archive)
        root = _root(archive)
        _parse(archive, root, model)
        _follow(archive, model)
    return root


def _check_sizes(path: Path, archive: zipfile.ZipFile) -> None:
    entries = archive.infolist()
    unpacked = sum(item.file_size for item in entries)
    if unpacked > _MAX_UNPACKED:
        raise InputError(
            f"{path}: unpacks to {unpacked / 2**30:.1f} GiB; at most {_MAX_UNPACKED >> 30} are read"
        )
    for item in entries:
        if item.file_size > max(_RATIO_FREE_SIZE, _MAX_RATIO * item.compress_size):
            raise InputError(
                f"{path}: {item.filename!r} unpacks to {item.file_size / 2**20:.0f} MiB from "
                f"{item.compress_size / 2**20:.1f} MiB: damaged, or made to fill the memory"
            )


def _root(archive: zipfile.ZipFile) -> str:
    """Return the file of the root model: the one that the relations name, else the usual one."""
    files = set(archive.namelist())
    related: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        if _local_name(tag) == "Relationship" and attributes.get("Type") == _MODEL_RELATION:
            related.append(attributes["Target"].lstrip("/"))

    if _RELATIONS in files:
        with archive.open(_RELATIONS) as stream:
            _run(stream, start)
    models = sorted(name for name in files if name.lower().endswith(".model"))
    usual = [name for name in models if name.lower() == "3d/3dmodel.model"]
    for name in (*related, *usual, *models):
        if name in files:
            return name
    raise ValueError("it holds no model")


def _run(stream: IO[bytes], start: _Start) -> None:
    """Feed XML to handlers of its elements. A document type is refused: it is how XML grows without
    bound."""
    parser = expat.ParserCreate()

    def refuse(*_: object) -> None:
        raise ValueError("declares a document type (DOCTYPE), which is not allowed in 3MF")

    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = start
    while piece := stream.read(_CHUNK):
        parser.Parse(piece, False)
    parser.Parse(b"", True)


def _parse(archive: zipfile.ZipFile, name: str, model: _Model) -> None:
    """Read one model of the archive."""
    reader = _Reader(name, model)
    with archive.open(name) as stream:
        _run(stream, reader.start)
    if name not in model.units:
        raise ValueError(f"{name!r} is no 3MF model")


def _follow(archive: zipfile.ZipFile, model: _Model) -> None:
    """Read the models in other files of the archive that components and the build name."""
    waiting = True
    while waiting:
        named = {one.key[0] for one in model.build}
        named |= {one.key[0] for item in model.objects.values() for one in item.components}
        waiting = bool(named - model.units.keys())
        for name in sorted(named - model.units.keys()):
            _parse(archive, name, model)


class _Reader:
    """Collects the objects and the build of one model file, element by element."""

    def __init__(self, file: str, model: _Model) -> None:
        self.file = file
        self.model = model
        self.object = _Object("")

    def start(self, tag: str, given: dict[str, str]) -> None:
        kind = _local_name(tag)
        if kind == "vertex":
            self.object.vertices.extend((float(given["x"]), float(given["y"]), float(given["z"])))
        elif kind == "triangle":
            self.object.corners.extend((int(given["v1"]), int(given["v2"]), int(given["v3"])))
        elif kind == "object":
            self.object = _Object(given.get("name", ""))
            self.model.objects[self.file, given["id"]] = self.object
        elif kind == "component":
            self.object.components.append(self._placed(given))
        elif kind == "item":
            self.model.build.append(self._placed(given))
        elif kind == "model":
            unit = given.get("unit", "millimeter")
            if unit not in _METRES:
                raise ValueError(f"unit {unit[:30]!r} is unknown; valid: {', '.join(_METRES)}")
            self.model.units[self.file] = unit

    def _placed(self, given: dict[str, str]) -> _Placed:
        file = next(
            (value.lstrip("/") for key, value in given.items() if _local_name(key) == "path"),
            self.file,
        )
        transform = np.eye(4)
        if "transform" in given:
            transform[:3] = np.array(given["transform"].split(), dtype=np.float64).reshape(4, 3).T
        return _Placed((file, given["objectid"]), transform, given.get("partnumber", ""))


def _local_name(tag: str) -> str:
    return tag.rpartition(":")[2]


class _Pending(NamedTuple):
    """An object that is to be placed."""

    placed: _Placed
    world: Floats
    """(4, 4) transform of the object around it."""
    name: str
    """Name of the object around it, or the part number of the build."""


def _leaves(model: _Model) -> Iterator[_Placed]:
    """Yield every object with triangles as often as the build places it, depth first.

    Transforms are in the world. An object without a name has that of the object around it, or the
    part number of the build.
    """
    count = 0
    stack = [_Pending(item, np.eye(4), item.name) for item in reversed(model.build)]
    units = set()
    while stack:
        placed, parent, name = stack.pop()
        count += 1
        if count > MAX_INSTANCES:
            raise ValueError(
                f"objects are placed more than {MAX_INSTANCES} times, or within themselves"
            )
        if placed.key not in model.objects:
            raise ValueError(f"object {placed.key[1]!r} is named and not there")
        units.add(_METRES[model.units[placed.key[0]]])
        if len(units) > 1:
            raise ValueError("its models are in different units")
        item = model.objects[placed.key]
        world = parent @ placed.transform
        name = item.name or name
        if item.corners:
            yield _Placed(placed.key, world, name)
        stack += [_Pending(child, world, name) for child in reversed(item.components)]


def _part(model: _Model, placed: _Placed) -> RawPart:
    item = model.objects[placed.key]
    vertices: Floats = np.frombuffer(item.vertices, dtype=np.float64).reshape(-1, 3)
    faces: Ints = np.frombuffer(item.corners, dtype=np.int64).reshape(-1, 3)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(
            f"object {placed.key[1]!r}: a triangle names vertex {faces.max()}, there are {len(vertices)}"
        )
    return placed_part(placed.name, vertices, faces, placed.transform)
