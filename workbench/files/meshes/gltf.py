"""Read glTF 2.0, as JSON with buffers beside it or inside, and as one binary file (GLB).

Read are nodes with meshes, copies by EXT_mesh_gpu_instancing, sparse and normalized accessors
(quantised positions, KHR_mesh_quantization), triangles, strips and fans. Materials, images, lights
and cameras are never opened. A file that requires another extension is refused by the name of it,
except those that change no surface.

References
----------
Khronos Group (2021), glTF 2.0 Specification: 3.6.2 accessors, 3.5.3 transformations, 4 GLB; the
extensions in its registry.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

from workbench.errors import InputError
from workbench.files.file_errors import read_whole
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh, RawPart, check_faces, placed_part
from workbench.model.arrays import Floats, Ints
from workbench.model.quaternions import matrices

__all__ = ["read_glb", "read_gltf"]

_UNNAMED = re.compile("")
_BROKEN = (
    KeyError,
    IndexError,
    TypeError,
    ValueError,
    AttributeError,
    OverflowError,
    MemoryError,
    RecursionError,
)
"""Exceptions that a file raises here if its JSON has another form than glTF."""
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
_READ = ("KHR_mesh_quantization", "EXT_mesh_gpu_instancing")
_HARMLESS = (
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "MSFT_packing_",
    "ADOBE_materials_",
    "KHR_techniques_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "KHR_animation_",
)
"""Beginnings of the names of extensions that change no surface."""
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_MAX_UNBACKED_ROWS = 1_000_000
"""Largest number of rows of an accessor without a buffer, which are zeros but for sparse ones."""
_TRIANGLES = 4
_FAN = 6
_JSON = b"JSON"
_BINARY = b"BIN\0"


@dataclass
class _File:
    """A glTF file."""

    path: Path
    tree: dict[str, Any]
    """Its JSON."""
    chunk: bytes | None
    """Binary chunk of a GLB."""
    buffers: dict[int, bytes] = field(default_factory=dict)
    """Those read so far."""


@dataclass(frozen=True, eq=False)
class _Placement:
    """A mesh where a node places it."""

    name: str
    mesh: int
    copies: Floats
    """(n, 4, 4) world-from-mesh transforms of its copies."""


def read_glb(path: Path, data: bytes, *, unnamed: re.Pattern[str] = _UNNAMED) -> RawMesh:
    """Read the meshes of a binary glTF file, in metres.

    Parameters
    ----------
    path, data
        The file and its bytes.
    unnamed
        What a node without a name of its own is called: it takes that of its mesh.

    Raises
    ------
    InputError
        If it is cut short, or as `read_gltf`.
    """
    if len(data) < 20 or data[:4] != b"glTF" or int.from_bytes(data[8:12], "little") > len(data):
        raise InputError(f"{path}: not a binary glTF file, or cut short")
    if (version := int.from_bytes(data[4:8], "little")) != 2:
        raise InputError(f"{path}: is glTF {version}.0, only 2.0 is read: export it again")
    chunks = _chunks(path, data)
    if _JSON not in chunks:
        raise InputError(f"{path}: not a binary glTF file: it holds no JSON")
    return _read(path, chunks[_JSON], chunks.get(_BINARY), unnamed)


def _chunks(path: Path, data: bytes) -> dict[bytes, bytes]:
    """Return the first chunk of each type of a binary glTF file."""
    chunks: dict[bytes, bytes] = {}
    start = 12
    while start + 8 <= len(data):
        body = start + 8
        end = body + int.from_bytes(data[start : start + 4], "little")
        if end > len(data):
            raise InputError(f"{path}: not a binary glTF file, or cut short")
        chunks.setdefault(data[start + 4 : body], data[body:end])
        start = end
    return chunks


def read_gltf(path: Path, data: bytes) -> RawMesh:
    """Read the meshes of a glTF file and the buffers beside it, in metres.

    Raises
    ------
    InputError
        If it is broken, is not glTF 2.0, is compressed, requires an extension that is not read, or
        if a buffer is missing, too short or outside the folder of the file.
    """
    return _read(path, data, None, _UNNAMED)


def _read(path: Path, text: bytes, chunk: bytes | None, unnamed: re.Pattern[str]) -> RawMesh:
    try:
        tree = json.loads(text)
        file = _File(path, tree, chunk)
        _check_version(path, tree)
        _check_extensions(path, tree)
        for buffer in tree.get("buffers", []):
            _check_beside(path, buffer.get("uri"))
        placements, notes = _placements(file, unnamed)
        _check_size(file, placements)
        parts = tuple(_parts(file, placements))
    except _BROKEN as error:
        lacks = f"{error} is missing" if isinstance(error, KeyError) else str(error)[:200]
        raise InputError(f"{path}: broken glTF: {lacks or type(error).__name__}") from None
    return RawMesh(str(path), "glTF", parts, 1.0, "y", (*notes, *_notes(tree)), "z")


def _check_version(path: Path, tree: dict[str, Any]) -> None:
    version = str(tree["asset"]["version"])
    if version.partition(".")[0] != "2":
        raise InputError(f"{path}: is glTF {version[:20]}, only 2.0 is read: export it again")


def _check_extensions(path: Path, tree: dict[str, Any]) -> None:
    required = [str(name) for name in tree.get("extensionsRequired", [])]
    compressed = sorted({*required, *map(str, tree.get("extensionsUsed", []))} & set(_COMPRESSED))
    if compressed:
        raise InputError(
            f"{path}: is compressed ({', '.join(compressed)}); export it again without compression"
        )
    unknown = [name for name in required if name not in _READ and not name.startswith(_HARMLESS)]
    if unknown:
        raise InputError(
            f"{path}: requires {', '.join(unknown)[:200]}, which is not read; export it again without it"
        )


def _notes(tree: dict[str, Any]) -> Iterator[str]:
    primitives = [primitive for mesh in tree.get("meshes", []) for primitive in mesh["primitives"]]
    lines = sum(primitive.get("mode", _TRIANGLES) < _TRIANGLES for primitive in primitives)
    if lines:
        yield f"{lines} sets of points or lines are not surfaces and are left out"
    if tree.get("skins") or any("targets" in primitive for primitive in primitives):
        yield "is skinned or morphed: it is read as it stands in the file, before any pose"


def _placements(file: _File, unnamed: re.Pattern[str]) -> tuple[list[_Placement], list[str]]:
    """Return every mesh of the scene with its transforms, depth first, and notes about meshes
    outside of it."""
    tree = file.tree
    nodes = tree.get("nodes", [])
    if not nodes:  # a library of meshes
        meshes = tree.get("meshes", [])
        return [_Placement(_name(mesh), k, np.eye(4)[None]) for k, mesh in enumerate(meshes)], []
    placements: list[_Placement] = []
    visited: set[int] = set()
    transforms = _transforms(nodes)
    stack = [(int(root), np.eye(4)) for root in reversed(_roots(tree))]
    while stack:
        k, parent = stack.pop()
        if k < 0 or k in visited:
            raise ValueError(f"node {k} stands in two places")
        visited.add(k)
        node = nodes[k]
        world = parent @ transforms[k]
        if "mesh" in node:
            name = _name(node)
            if unnamed.fullmatch(name):
                name = _name(tree["meshes"][node["mesh"]]) or name
            placements.append(_Placement(name, int(node["mesh"]), world @ _copies(file, node)))
        stack += [(int(child), world) for child in reversed(node.get("children", []))]
    left = sum("mesh" in node for k, node in enumerate(nodes) if k not in visited)
    note = f"{left} nodes with meshes stand in no scene that is shown and are left out"
    return placements, [note] if left else []


def _roots(tree: dict[str, Any]) -> list[Any]:
    """Return the root nodes of the scene; of a file without scenes all nodes without a parent."""
    scenes = tree.get("scenes", [])
    if scenes:
        return scenes[tree.get("scene", 0)].get("nodes", [])
    nodes = tree["nodes"]
    children = {int(child) for node in nodes for child in node.get("children", [])}
    return [k for k in range(len(nodes)) if k not in children]


def _name(item: dict[str, Any]) -> str:
    name = item.get("name", "")
    return name if isinstance(name, str) else ""


def _transforms(nodes: list[dict[str, Any]]) -> Floats:
    """Return the parent-from-node transforms (N, 4, 4) of all nodes."""

    def rows(key: str, default: tuple[int, ...]) -> Floats:
        values = [node.get(key, default) for node in nodes]
        return np.array(values, dtype=np.float64).reshape(len(nodes), len(default))

    transforms = _compose_transforms(
        rows("translation", (0, 0, 0)), rows("rotation", (0, 0, 0, 1)), rows("scale", (1, 1, 1))
    )
    for k, node in enumerate(nodes):
        if "matrix" in node:  # column by column
            transforms[k] = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    wrong = np.flatnonzero(~np.isfinite(transforms).all(axis=(1, 2)))
    if len(wrong):
        raise ValueError(f"node {wrong[0]} has no transform of finite numbers")
    return transforms


def _compose_transforms(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """Return transforms (n, 4, 4) from translations (n, 3), quaternions (n, 4) in the order x, y,
    z, w, and scales (n, 3)."""
    turn = np.roll(rotation, 1, axis=1)
    made = np.zeros((len(translation), 4, 4))
    made[:, :3, :3] = matrices(turn / np.linalg.norm(turn, axis=1)[:, None]) * scale[:, None, :]
    made[:, :3, 3] = translation
    made[:, 3, 3] = 1.0
    return made


def _copies(file: _File, node: dict[str, Any]) -> Floats:
    """Return the transforms (n, 4, 4) of the copies of a node's mesh (EXT_mesh_gpu_instancing); the
    identity for a single one."""
    instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if instancing is None:
        return np.eye(4)[None]
    given = instancing["attributes"]
    rows = {
        key: _accessor(file, given[key])
        for key in ("TRANSLATION", "ROTATION", "SCALE")
        if key in given
    }
    counts = {len(values) for values in rows.values()}
    if len(counts) != 1:
        raise ValueError("EXT_mesh_gpu_instancing needs attributes of one count")
    count = counts.pop()
    return _compose_transforms(
        rows.get("TRANSLATION", np.zeros((count, 3))),
        rows.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))),
        rows.get("SCALE", np.ones((count, 3))),
    )


def _check_size(file: _File, placements: list[_Placement]) -> None:
    """Refuse a file whose meshes and copies, by the counts that they state, exceed the memory."""
    faces = corners = 0
    for one in placements:
        for primitive in file.tree["meshes"][one.mesh]["primitives"]:
            mode = primitive.get("mode", _TRIANGLES)
            positions = primitive["attributes"]["POSITION"]
            count = _count(file, primitive.get("indices", positions))
            faces += len(one.copies) * (count // 3 if mode == _TRIANGLES else count)
            corners += len(one.copies) * _count(file, positions)
    check_faces(file.path, faces, corners)


def _count(file: _File, number: int) -> int:
    """Return the number of rows of an accessor; refuse more than it can hold."""
    accessor = file.tree["accessors"][number]
    count = int(accessor["count"])
    view = file.tree["bufferViews"][accessor["bufferView"]] if "bufferView" in accessor else {}
    if not 0 <= count <= max(_MAX_UNBACKED_ROWS, int(view.get("byteLength", 0))):
        raise ValueError(f"accessor {number}: announces {count} rows that it does not hold")
    return count


def _parts(file: _File, placements: list[_Placement]) -> Iterator[RawPart]:
    """Yield the surfaces of all meshes, as often as nodes place them."""
    meshes: dict[int, tuple[Floats, Ints] | None] = {}
    for placement in placements:
        if placement.mesh not in meshes:
            meshes[placement.mesh] = _surface(file, placement.mesh)
        surface = meshes[placement.mesh]
        if surface is not None:
            for transform in placement.copies:
                yield placed_part(placement.name, *surface, transform)


def _surface(file: _File, mesh: int) -> tuple[Floats, Ints] | None:
    """Return points (V, 3) and triangles (T, 3) of all surfaces of a mesh; None if it has only
    points and lines."""
    points: list[Floats] = []
    faces: list[Ints] = []
    count = 0
    for primitive in file.tree["meshes"][mesh]["primitives"]:
        mode = primitive.get("mode", _TRIANGLES)
        if mode < _TRIANGLES:
            continue
        if mode > _FAN:
            raise ValueError(f"mesh {mesh}: mode {mode} is unknown")
        corners, triangles = _primitive(file, mesh, primitive, mode)
        points.append(corners)
        faces.append(triangles + count)
        count += len(corners)
    return (np.concatenate(points), np.concatenate(faces)) if points else None


def _primitive(file: _File, mesh: int, primitive: dict[str, Any], mode: int) -> tuple[Floats, Ints]:
    """Return points (V, 3) and triangles (T, 3) of one primitive."""
    points = _accessor(file, primitive["attributes"]["POSITION"])
    if points.shape[1] != 3:
        raise ValueError(
            f"mesh {mesh}: positions are rows of {points.shape[1]} numbers, 3 are needed"
        )
    indices = np.arange(len(points))
    if "indices" in primitive:
        indices = _indices(file, primitive["indices"])
    if indices.max(initial=-1) >= len(points):
        raise ValueError(
            f"mesh {mesh}: a face names vertex {indices.max()}, and there are {len(points)}"
        )
    return points, _triangles(indices, mode)


def _triangles(indices: Ints, mode: int) -> Ints:
    """Return the triangles (T, 3) of a list, a strip or a fan of indices."""
    if mode == _TRIANGLES:
        if len(indices) % 3:
            raise ValueError(f"{len(indices)} indices do not make triangles")
        return indices.reshape(-1, 3)
    if len(indices) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.column_stack([np.full(len(indices) - 2, indices[0]), indices[1:-1], indices[2:]])
    strip = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
    strip[1::2] = strip[1::2, [1, 0, 2]]  # every second triangle of a strip runs the other way
    return strip


def _indices(file: _File, number: int) -> Ints:
    accessor = file.tree["accessors"][number]
    if accessor["componentType"] not in (5121, 5123, 5125) or accessor["type"] != "SCALAR":
        raise ValueError(f"accessor {number}: indices are unsigned whole numbers")
    return _accessor(file, number)[:, 0].astype(np.int64)


def _accessor(file: _File, number: int) -> Floats:
    """Return the numbers (count, width) of an accessor, with sparse values put in; normalized
    integers become fractions of 1."""
    accessor = file.tree["accessors"][number]
    dtype = np.dtype(_COMPONENTS[accessor["componentType"]])
    shape = (_count(file, number), _WIDTHS[accessor["type"]])
    if "bufferView" in accessor:
        rows = _view(file, accessor, dtype, shape)
    elif "sparse" in accessor:
        rows = np.zeros(shape, dtype=dtype)
    else:
        raise ValueError(f"accessor {number}: holds no data")
    if "sparse" in accessor:
        rows = _with_sparse_values(file, number, rows)
    values: Floats = rows.astype(np.float64)
    if accessor.get("normalized", False) and dtype.kind in "iu":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values


def _with_sparse_values(
    file: _File, number: int, rows: np.ndarray[Any, Any]
) -> np.ndarray[Any, Any]:
    """Return the rows of an accessor with its sparse values put in."""
    sparse = file.tree["accessors"][number]["sparse"]
    count = int(sparse["count"])
    indices = sparse["indices"]
    dtype = np.dtype(_COMPONENTS[indices["componentType"]])
    places = _view(file, indices, dtype, (count, 1))[:, 0]
    if places.dtype.kind != "u":
        raise ValueError(f"accessor {number}: sparse indices are unsigned whole numbers")
    rows = rows.copy()
    rows[places] = _view(file, sparse["values"], rows.dtype, (count, rows.shape[1]))
    return rows


def _view(
    file: _File, reference: dict[str, Any], dtype: np.dtype[Any], shape: tuple[int, int]
) -> np.ndarray[Any, Any]:
    """Return rows (count, width) of a buffer view; refuse more than it holds.

    Parameters
    ----------
    file
        The file.
    reference
        Names the buffer view, and the byte in it where the rows begin.
    dtype, shape
        Of the rows.
    """
    view = file.tree["bufferViews"][reference["bufferView"]]
    buffer = _buffer(file, int(view["buffer"]))
    start = int(view.get("byteOffset", 0))
    length = int(view["byteLength"])
    row = dtype.itemsize * shape[1]
    stride = int(view.get("byteStride", 0)) or row
    offset = int(reference.get("byteOffset", 0))
    end = offset + stride * (shape[0] - 1) + row
    negative = min(start, offset, shape[0]) < 0
    too_long = start + length > len(buffer) or (shape[0] and end > length)
    if negative or stride < row or too_long:
        raise ValueError(
            f"bufferView {reference['bufferView']} does not hold {shape[0]} rows of {row} bytes"
        )
    return np.ndarray(shape, dtype, buffer, start + offset, (stride, dtype.itemsize))


def _buffer(file: _File, number: int) -> bytes:
    if number not in file.buffers:
        entry = file.tree["buffers"][number]
        data = _resource(file, number, entry.get("uri"))
        length = entry["byteLength"]
        if len(data) < int(length):
            where = f" ({str(entry['uri'])[:80]})" if "uri" in entry else ""
            raise ValueError(
                f"buffer {number}{where} is cut short: {len(data)} bytes, {length} announced"
            )
        file.buffers[number] = data
    return file.buffers[number]


def _check_beside(path: Path, uri: str | None) -> None:
    """Refuse a buffer in a file of its own that is missing, or outside the folder of the mesh."""
    if uri is None or uri.startswith("data:"):
        return
    name = unquote(uri)
    if outside_folder(name):
        raise InputError(f"{path}: refers to a file outside its own folder ({uri[:80]})")
    if not (path.parent / name).exists():
        raise InputError(
            f"{path}: its buffer {name[:80]!r} is missing: it belongs beside it, in {path.parent}"
        )


def _resource(file: _File, number: int, uri: str | None) -> bytes:
    """Return the bytes of a buffer: of the binary file, of a data URI, or of a file beside it."""
    if uri is None:
        if number or file.chunk is None:
            raise ValueError(f"buffer {number} has no data")
        return file.chunk
    if uri.startswith("data:"):
        head, _, body = uri.partition(",")
        try:
            return (
                base64.b64decode(body, validate=True)
                if head.endswith(";base64")
                else unquote_to_bytes(body)
            )
        except binascii.Error as error:
            raise ValueError(f"buffer {number}: not base64 ({error})") from None
    return read_whole(file.path.parent / unquote(uri), "a buffer of a glTF file")
