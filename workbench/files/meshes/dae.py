"""COLLADA (DAE), by pycollada under our own walk of the scene.

trimesh reads it too, but leaves vertices in file units, splits each geometry by material, names parts by geometry
and not by node, skips broken and skinned geometry without a word, and hands the parser files that can grow without
bound. Pictures and materials are cut away first: they are never opened.
"""

from __future__ import annotations

import io
import struct
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.parts import RawMesh, RawPart, triangulated
from workbench.model.arrays import Floats, Ints

__all__ = ["read_dae"]

_UNUSED = frozenset([
    "library_images", "library_effects", "library_materials", "library_animations", "library_animation_clips",
    "library_cameras", "library_lights", "library_physics_scenes", "library_physics_models",
    "library_physics_materials", "library_controllers", "bind_material", "extra", "instance_camera", "instance_light",
    "instance_physics_scene",
])  # fmt: skip
_MOST_DEEP = 200


class _Plain(ElementTree.TreeBuilder):
    """Refuses a document type: it is how XML text grows without bound, and COLLADA has none."""

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise InputError("declares a document type (DOCTYPE), which is not allowed in COLLADA")


def read_dae(path: Path, data: bytes) -> RawMesh:
    """The parts of a DAE file, one for each node with geometry, with the unit the file tells. InputError where it is
    no COLLADA, refers to other files, is skinned, or is broken anywhere in its geometry."""
    import collada

    tree = _cleaned(path, data)
    lines = sum(1 for item in tree.iter() if _tag(item) in ("lines", "linestrips"))
    told = next((item for item in tree.iter() if _tag(item) == "unit"), None)
    problems = (collada.DaeError, collada.scene.DaeInstanceNotLoadedError, ValueError, KeyError, IndexError, TypeError,
                AttributeError, OverflowError, MemoryError, struct.error, DeprecationWarning)  # fmt: skip
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", DeprecationWarning)  # NumPy 2.5 and later warn of what the library does
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            document = collada.Collada(io.BytesIO(ElementTree.tostring(tree)), ignore=None)
            nodes = document.scene.nodes if document.scene else []
            parts = [part for node in nodes for part in _walk(collada, node, (np.eye(4), ""))]
    except problems as error:
        raise InputError(f"{path}: broken COLLADA: {_first_line(error)}") from None
    notes = (f"{lines} sets of lines are not surfaces and are left out",) if lines else ()
    metres = None if told is None else _unit(path, told)
    axis = next((item.text for item in tree.iter() if _tag(item) == "up_axis"), None)
    up = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}.get((axis or "Y_UP").strip(), "y")  # Y where it is silent
    return RawMesh(str(path), "DAE", tuple(parts), metres, up, notes)


def _cleaned(path: Path, data: bytes) -> ElementTree.Element:
    """The document without what is not geometry; InputError where it needs what cannot be had."""
    try:
        tree = ElementTree.XML(data, ElementTree.XMLParser(target=_Plain()))
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not XML: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, LookupError) as error:
        raise InputError(f"{path}: not XML that can be read: {error}") from None
    if _tag(tree) != "COLLADA":
        raise InputError(f"{path}: not COLLADA: its root is {_tag(tree)[:40]!r}")
    _refuse(path, tree)
    for item in list(tree.iter()):
        for child in [child for child in item if _tag(child) in _UNUSED]:
            item.remove(child)
    return tree


def _refuse(path: Path, tree: ElementTree.Element) -> None:
    for item in tree.iter():
        tag, url = _tag(item), item.get("url", "#")
        if tag == "instance_controller":
            raise InputError(f"{path}: {url.lstrip('#')}: is skinned or morphed; export it again as a plain mesh")
        if tag in ("instance_geometry", "instance_node", "instance_visual_scene") and not url.startswith("#"):
            raise InputError(f"{path}: refers to another file ({url}); put everything in one file")
        if tag in ("ph", "convex_mesh", "spline", "brep") or (tag == "float_array" and item.get("source")):
            raise InputError(f"{path}: holds <{tag}>, which is not read; export it again as triangles")


def _walk(collada: Any, top: Any, placed: tuple[Floats, str]) -> Iterator[RawPart]:
    """Parts below a node, depth first; `placed` is the parent's transform and name."""
    stack = [(top, *placed, 0)]
    while stack:
        node, matrix, name, depth = stack.pop()
        if depth > _MOST_DEEP:
            raise ValueError(f"nodes are nested deeper than {_MOST_DEEP}")
        if isinstance(node, collada.scene.GeometryNode):
            yield from _part(collada, node.geometry, (matrix, name))
        elif isinstance(node, collada.scene.Node):
            inner = node.node if isinstance(node, collada.scene.NodeNode) else node
            below = inner.name or inner.id or name
            world = matrix @ np.asarray(node.matrix, dtype=np.float64)
            stack += [(child, world, below, depth + 1) for child in reversed(node.children)]


def _part(collada: Any, geometry: Any, placed: tuple[Floats, str]) -> Iterator[RawPart]:
    """One part from all surfaces of a geometry, whatever their materials; none where it holds only lines."""
    matrix, name = placed
    vertices: list[Floats] = [np.zeros((0, 3))]
    faces: list[Ints] = []
    for primitive in geometry.primitives:
        if isinstance(primitive, collada.lineset.LineSet) or primitive.vertex is None:
            continue
        points = np.asarray(primitive.vertex, dtype=np.float64)
        corners = np.asarray(primitive.vertex_index, dtype=np.int64).ravel()
        triangles = isinstance(primitive, collada.triangleset.TriangleSet)
        counts = np.full(len(corners) // 3, 3) if triangles else np.asarray(primitive.vcounts, dtype=np.int64)
        if corners.min(initial=0) < 0 or counts.min(initial=3) < 3 or counts.sum() != len(corners):
            raise ValueError(f"geometry {geometry.id!r} has faces whose corners are not there")
        faces.append(triangulated(points, corners, counts) + sum(len(v) for v in vertices))
        vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
    if faces:
        together = np.concatenate(faces)
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        yield RawPart(name or geometry.name or geometry.id, np.concatenate(vertices),
                      together[:, ::-1] if mirrored else together)  # fmt: skip


def _unit(path: Path, told: ElementTree.Element) -> float:
    text = told.get("meter", "1")
    try:
        metres = float(text)
    except ValueError:
        metres = 0.0
    if not 1e-6 <= metres <= 1e3:
        raise InputError(f"{path}: unit: its length in metres is needed, got meter={text[:30]!r}")
    return metres


def _tag(item: ElementTree.Element) -> str:
    return item.tag.rpartition("}")[2] if isinstance(item.tag, str) else ""


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
