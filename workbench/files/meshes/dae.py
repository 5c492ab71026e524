"""COLLADA (DAE), by pycollada under our own walk of the scene.

trimesh reads it too, but leaves vertices in file units, splits each geometry by material, names
parts by geometry and not by node, skips broken and skinned geometry without a word, and hands the
parser files that can grow without bound. Pictures and materials are cut away first: they are never
opened.
"""

from __future__ import annotations

import io
import struct
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.bounds import MAX_INSTANCES, check_corners, check_faces
from workbench.files.meshes.parts import RawMesh, RawPart, triangulate
from workbench.model.arrays import Floats, Ints

__all__ = ["read_dae"]

_UNUSED = frozenset(
    [
        "library_images",
        "library_effects",
        "library_materials",
        "library_animations",
        "library_animation_clips",
        "library_cameras",
        "library_lights",
        "library_physics_scenes",
        "library_physics_models",
        "library_physics_materials",
        "library_controllers",
        "bind_material",
        "extra",
        "instance_camera",
        "instance_light",
        "instance_physics_scene",
    ]
)
_Placed = tuple[Any, Floats, str]
"""A geometry of pycollada, its transform (4, 4) in the world, and the name of its part."""
_MOST_DEEP = 200
"""Elements within elements at most: what reads them calls itself for each level."""


@dataclass(frozen=True, eq=False)
class _Below:
    """A node still to be read, below its parent."""

    node: Any
    world: Floats
    """(4, 4) transform of the parent."""
    name: str = ""
    """Name of the parent, for a node without one."""
    placing: str = ""
    """Name that a node placed by another takes from the one that places it, empty if that has
    none."""
    prefix: str = ""
    """What names within an instance begin with."""


class _Plain(ElementTree.TreeBuilder):
    """Refuses a document type, which is how XML text grows without bound, and elements nested too
    deep."""

    depth = 0

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        self.depth += 1
        if self.depth > _MOST_DEEP:
            raise InputError(
                f"nests elements deeper than {_MOST_DEEP} levels; export it again with fewer"
            )
        return super().start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        self.depth -= 1
        return super().end(tag)

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise InputError("declares a document type (DOCTYPE), which is not allowed in COLLADA")


def read_dae(path: Path, data: bytes) -> RawMesh:
    """The parts of a DAE file, one for each node with geometry, with the unit the file tells.
    InputError where it is no COLLADA, refers to other files, is skinned, or is broken anywhere in
    its geometry."""
    import collada

    tree = _cleaned(path, data)
    lines = sum(1 for item in tree.iter() if _tag(item) in ("lines", "linestrips"))
    told = next((item for item in tree.iter() if _tag(item) == "unit"), None)
    problems = (
        collada.DaeError,
        collada.scene.DaeInstanceNotLoadedError,
        ValueError,
        LookupError,
        TypeError,
        AttributeError,
        ArithmeticError,
        MemoryError,
        RuntimeError,
        struct.error,
        DeprecationWarning,
    )
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter(
                "ignore", DeprecationWarning
            )  # NumPy 2.5 and later warn of what the library does
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            document = collada.Collada(io.BytesIO(ElementTree.tostring(tree)), ignore=None)
            nodes = document.scene.nodes if document.scene else []
            placed = list(_walk(collada, nodes))
            sizes = [_size(collada, geometry) for geometry, _, _ in placed]
            check_faces(
                path, sum(faces for faces, _ in sizes), sum(corners for _, corners in sizes)
            )
            parts = [part for one in placed for part in _part(collada, path, one)]
    except problems as error:
        raise InputError(f"{path}: broken COLLADA: {_first_line(error)}") from None
    notes = (f"{lines} sets of lines are not surfaces and are left out",) if lines else ()
    metres = None if told is None else _unit(path, told)
    axis = next((item.text for item in tree.iter() if _tag(item) == "up_axis"), None)
    up = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}.get(
        (axis or "Y_UP").strip(), "y"
    )  # Y where it is silent
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
            raise InputError(
                f"{path}: {url.lstrip('#')}: is skinned or morphed; export it again as a plain mesh"
            )
        if tag in (
            "instance_geometry",
            "instance_node",
            "instance_visual_scene",
        ) and not url.startswith("#"):
            raise InputError(f"{path}: refers to another file ({url}); put everything in one file")
        if tag in ("ph", "convex_mesh", "spline", "brep", "skew") or (
            tag == "float_array" and item.get("source")
        ):
            instead = "a matrix" if tag == "skew" else "triangles"
            raise InputError(
                f"{path}: holds <{tag}>, which is not read; export it again as {instead}"
            )


def _walk(collada: Any, nodes: list[Any]) -> Iterator[_Placed]:
    """Every geometry as often as the scene places it, depth first."""
    stack = [_Below(node, np.eye(4)) for node in reversed(nodes)]
    count = 0
    while stack:
        one = stack.pop()
        count += 1
        if count > MAX_INSTANCES:
            raise ValueError(
                f"nodes are placed more than {MAX_INSTANCES} times, or within themselves"
            )
        if isinstance(one.node, collada.scene.GeometryNode):
            yield one.node.geometry, one.world, one.name
        elif isinstance(one.node, collada.scene.Node):
            world = one.world @ np.asarray(one.node.matrix, dtype=np.float64)
            name, prefix, named = _names(collada, one)
            for child in reversed(one.node.children):
                placing = name if named and isinstance(child, collada.scene.NodeNode) else ""
                stack.append(_Below(child, world, name, placing, prefix))


def _names(collada: Any, one: _Below) -> tuple[str, str, bool]:
    """Name of the parts of a node, what names below it begin with, and whether it was given a name
    (not only an id).

    A node that others place (`instance_node`) is named as the node that places it, and nodes within
    it begin with that name: two doors made of one are `left_door`, `left_door_handle`,
    `right_door`, `right_door_handle`.
    """
    if one.placing:
        return one.placing, one.placing, True
    node = one.node.node if isinstance(one.node, collada.scene.NodeNode) else one.node
    own = node.name or node.id
    if not own:
        return one.name, one.prefix, False
    return (f"{one.prefix}_{own}" if one.prefix else own), one.prefix, bool(node.name)


def _size(collada: Any, geometry: Any) -> tuple[int, int]:
    """Triangles that the surfaces of a geometry make, and corners that they hold."""
    faces = corners = 0
    for primitive in geometry.primitives:
        if isinstance(primitive, collada.lineset.LineSet) or primitive.vertex is None:
            continue
        triangles = isinstance(primitive, collada.triangleset.TriangleSet)
        faces += (
            len(primitive)
            if triangles
            else int(np.sum(np.asarray(primitive.vcounts, dtype=np.int64) - 2))
        )
        corners += len(primitive.vertex)
    return faces, corners


def _part(collada: Any, path: Path, placed: _Placed) -> Iterator[RawPart]:
    """One part from all surfaces of a geometry, whatever their materials; none where it holds only
    lines."""
    geometry, matrix, name = placed
    vertices: list[Floats] = [np.zeros((0, 3))]
    faces: list[Ints] = []
    for primitive in geometry.primitives:
        if isinstance(primitive, collada.lineset.LineSet) or primitive.vertex is None:
            continue
        points = np.asarray(primitive.vertex, dtype=np.float64)
        corners = np.asarray(primitive.vertex_index, dtype=np.int64).ravel()
        triangles = isinstance(primitive, collada.triangleset.TriangleSet)
        counts = (
            np.full(len(corners) // 3, 3)
            if triangles
            else np.asarray(primitive.vcounts, dtype=np.int64)
        )
        check_corners(path, counts)
        if corners.min(initial=0) < 0 or counts.min(initial=3) < 3 or counts.sum() != len(corners):
            raise ValueError(f"geometry {geometry.id!r} has faces whose corners are not there")
        faces.append(triangulate(points, corners, counts) + sum(len(v) for v in vertices))
        vertices.append(points @ matrix[:3, :3].T + matrix[:3, 3])
    if faces:
        together = np.concatenate(faces)
        mirrored = np.linalg.det(matrix[:3, :3]) < 0
        yield RawPart(
            name or geometry.name or geometry.id,
            np.concatenate(vertices),
            together[:, ::-1] if mirrored else together,
        )


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
