"""Binary STL, glTF and 3MF, by trimesh, with what it would pass over in silence turned into errors."""

from __future__ import annotations

import io
import json
import logging
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.text import read_text_stl
from workbench.model.arrays import Floats

__all__ = ["read_glb", "read_gltf", "read_stl", "read_threemf"]

_PROBLEMS = (ValueError, KeyError, IndexError, TypeError, AttributeError, OverflowError, MemoryError, RuntimeError,
             StopIteration, EOFError, ArithmeticError, AssertionError, OSError, SyntaxError, NameError, struct.error,
             zipfile.BadZipFile, zlib.error)  # fmt: skip
"""What trimesh and the parsers under it were seen to raise on broken files (SyntaxError: lxml's parse errors)."""
_LENGTHS = {"micron": 1e-6, "millimeter": 1e-3, "millimeters": 1e-3, "centimeter": 0.01, "centimeters": 0.01,
            "inch": 0.0254, "inches": 0.0254, "foot": 0.3048, "feet": 0.3048, "meter": 1.0, "meters": 1.0}  # fmt: skip
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
_MOST_UNPACKED = 2 * 2**30


def read_stl(path: Path, data: bytes) -> RawMesh:
    """The solids of an STL file: one part in a binary one."""
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        return RawMesh(str(path), "STL", tuple(_parts(path, data, "stl")))
    if data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:80].rstrip(b"\0 "):
        return read_text_stl(path, data)
    raise InputError(f"{path}: not an STL file, or cut short: {len(data)} bytes, {84 + 50 * count} are announced")


def read_threemf(path: Path, data: bytes) -> RawMesh:
    """The objects that a 3MF file builds."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            unpacked = sum(item.file_size for item in archive.infolist())
    except (zipfile.BadZipFile, ValueError, OSError, struct.error, NotImplementedError) as error:
        raise InputError(f"{path}: not a 3MF file: {error}") from None
    if unpacked > _MOST_UNPACKED:
        raise InputError(f"{path}: unpacks to {unpacked / 2**30:.1f} GiB; at most {_MOST_UNPACKED >> 30} are read")
    units: set[str] = set()
    parts = tuple(_parts(path, data, "3mf", units=units))
    metres = _LENGTHS.get(units.pop()) if len(units) == 1 else None
    return RawMesh(str(path), "3MF", parts, metres)


def read_glb(path: Path, data: bytes) -> RawMesh:
    """The meshes of a binary glTF file, in metres as glTF has them."""
    if len(data) < 20 or data[:4] != b"glTF" or int.from_bytes(data[8:12], "little") > len(data):
        raise InputError(f"{path}: not a binary glTF file, or cut short")
    length = int.from_bytes(data[12:16], "little")
    notes = _checked(path, data[20 : 20 + length])
    return RawMesh(str(path), "glTF", tuple(_parts(path, data, "glb")), 1.0, "y", notes, "z")


def read_gltf(path: Path, data: bytes) -> RawMesh:
    """The meshes of a glTF file and the buffers beside it."""
    notes = _checked(path, data)
    return RawMesh(str(path), "glTF", tuple(_parts(path, data, "gltf")), 1.0, "y", notes, "z")


def _checked(path: Path, text: bytes) -> tuple[str, ...]:
    """Look through the JSON of a glTF file for what trimesh would follow, skip or make up; notes about the rest."""
    try:
        tree = json.loads(text)
        uris = [str(item["uri"]) for kind in ("buffers", "images") for item in tree.get(kind, []) if "uri" in item]
        used = set(tree.get("extensionsUsed", [])) & set(_COMPRESSED)
        surfaces = [p for mesh in tree.get("meshes", []) for p in mesh["primitives"]]
        modes = [p.get("mode", 4) for p in surfaces]
        made_up = max([a["count"] for a in tree.get("accessors", []) if "bufferView" not in a], default=0)
        posed = bool(tree.get("skins")) or any("targets" in p for p in surfaces)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: broken glTF: {str(error)[:120] or type(error).__name__}") from None
    for uri in uris:
        if not uri.startswith("data:") and outside_folder(unquote(uri)):
            raise InputError(f"{path}: refers to a file outside its own folder ({uri[:80]})")
    if used:
        raise InputError(f"{path}: is compressed ({', '.join(sorted(used))}); export it again without compression")
    if 6 in modes:
        raise InputError(f"{path}: holds triangle fans, which are not read; export it again as triangles")
    if made_up > 1_000_000:
        raise InputError(f"{path}: announces {made_up} values that it does not hold")
    lines = sum(mode in (0, 1, 2, 3) for mode in modes)
    notes = [f"{lines} sets of points or lines are not surfaces and are left out"] if lines else []
    notes += ["is skinned or morphed: it is read as it stands in the file, before any pose"] if posed else []
    return tuple(notes)


def _parts(path: Path, data: bytes, kind: str, *, units: set[str] | None = None) -> Iterator[RawPart]:
    """Everything in the scene, transforms applied; the pieces of one glTF mesh are one part again."""
    scene = _scene(path, data, kind)
    try:
        parents, names = scene.graph.transforms.parents, list(scene.geometry)
        together: dict[str, list[tuple[int, str]]] = {}
        for node in scene.graph.nodes_geometry:
            name = scene.graph[node][1]
            geometry = scene.geometry[name]
            if not hasattr(geometry, "faces"):
                continue
            if units is not None:
                units.add(str(geometry.metadata.get("units")))
            owner = parents[node] if geometry.metadata.get("from_gltf_primitive") else node
            together.setdefault(str(owner), []).append((names.index(name), str(node)))
        for owner, members in sorted(together.items(), key=lambda item: (min(item[1])[0], len(item[0]), item[0])):
            label = names[min(members)[0]] if owner.isdigit() else owner  # a node without a name has its number
            yield _joined("" if kind == "stl" else label, [_placed(scene, node) for _, node in sorted(members)])
    except _PROBLEMS as error:
        raise InputError(f"{path}: broken {kind}: {_first_line(error)}") from None


def _placed(scene: Any, node: str) -> tuple[Floats, Any]:
    matrix, name = scene.graph[node]
    return matrix, scene.geometry[name]


def _joined(name: str, placed: list[tuple[Floats, Any]]) -> RawPart:
    vertices, faces, count = [], [], 0
    for matrix, geometry in placed:
        points = np.asarray(geometry.vertices, dtype=np.float64)
        triangles = np.asarray(geometry.faces, dtype=np.int64).reshape(-1, 3)
        if triangles.min(initial=0) < 0 or triangles.max(initial=-1) >= len(points):
            raise ValueError("a face names a vertex that is not there")
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        with np.errstate(all="ignore"):
            vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
        faces.append((triangles[:, ::-1] if mirrored else triangles) + count)
        count += len(points)
    return RawPart(name, np.concatenate(vertices), np.concatenate(faces))


def _scene(path: Path, data: bytes, kind: str) -> Any:
    import trimesh

    folder = trimesh.resolvers.FilePathResolver(str(path.resolve()))
    options = {"skip_materials": True} if kind in ("glb", "gltf") else {}
    with _no_quiet_warnings(path), np.errstate(all="ignore"):  # read_mesh tells what is not finite
        try:
            return trimesh.load_scene(io.BytesIO(data), file_type=kind, resolver=folder, process=False, **options)
        except (*_PROBLEMS, ImportError) as error:
            raise InputError(f"{path}: broken {kind}, or cut short: {_first_line(error)}") from None


@contextmanager
def _no_quiet_warnings(path: Path) -> Iterator[None]:
    """Turn what trimesh logs as a warning (values made up, parts not found) into an error."""
    said: list[str] = []

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.levelno >= logging.WARNING:
                said.append(record.getMessage())

    listener, log = Listener(), logging.getLogger("trimesh")
    log.addHandler(listener)
    try:
        yield
    finally:
        log.removeHandler(listener)
    if said:
        raise InputError(f"{path}: {said[0].splitlines()[0][:200]}")


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
