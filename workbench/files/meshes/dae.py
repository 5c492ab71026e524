"""Read COLLADA (DAE) with pycollada and a traversal of the scene of our own.

trimesh reads it too, but leaves vertices in file units, splits each geometry by material, names
parts by geometry and not by node, skips broken and skinned geometry silently, and passes entity
declarations to the parser, which can grow without bound. Images and materials are removed first:
they are never opened.
"""

from __future__ import annotations

import io
import struct
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.parts import (
    MAX_INSTANCES,
    RawMesh,
    RawPart,
    check_corners,
    check_faces,
    placed_part,
    triangulate,
)
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
_MAX_DEPTH = 200
"""Largest depth of elements: pycollada calls itself for each level."""


class _Placed(NamedTuple):
    """A geometry where the scene places it."""

    geometry: Any
    """Of pycollada."""
    transform: Floats
    """(4, 4) in the world."""
    name: str
    """Name of its part."""


@dataclass(frozen=True, eq=False)
class _PendingNode:
    """A node that is still to be read, below its parent."""

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


class _SafeBuilder(ElementTree.TreeBuilder):
    """Refuses document types, with which XML can grow without bound, and elements nested too deep."""

    depth = 0

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise InputError(
                f"nests elements deeper than {_MAX_DEPTH} levels; export it again with fewer"
            )
        return super().start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        self.depth -= 1
        return super().end(tag)

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise InputError("declares a document type (DOCTYPE), which is not allowed in COLLADA")


def read_dae(path: Path, data: bytes) -> RawMesh:
    """Read the parts of a DAE file, one for each node with geometry, with the unit of the file.

    Raises
    ------
    InputError
        If it is no COLLADA, refers to other files, is skinned, or its geometry is broken.
    """
    import collada

    tree = _cleaned(path, data)
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
        parts = _read_parts(collada, path, tree)
    except problems as error:
        raise InputError(f"{path}: broken COLLADA: {_first_line(error)}") from None
    lines = sum(1 for item in tree.iter() if _tag(item) in ("lines", "linestrips"))
    notes = (f"{lines} sets of lines are not surfaces and are left out",) if lines else ()
    unit = next((item for item in tree.iter() if _tag(item) == "unit"), None)
    metres = None if unit is None else _unit(path, unit)
    axis = next((item.text for item in tree.iter() if _tag(item) == "up_axis"), None)
    known_axes = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}
    up = known_axes.get((axis or "Y_UP").strip().upper())  # the format's default is y
    if up is None:
        raise InputError(f"{path}: <up_axis> is {axis!r}; X_UP, Y_UP or Z_UP is needed")
    return RawMesh(str(path), "DAE", parts, metres, up, notes)


def _read_parts(collada: Any, path: Path, tree: ElementTree.Element) -> tuple[RawPart, ...]:
    """Read all surfaces of a document as often as its scene places them."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        # NumPy 2.5 and later warn about what pycollada does
        warnings.simplefilter("ignore", DeprecationWarning)
        warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
        document = collada.Collada(io.BytesIO(ElementTree.tostring(tree)), ignore=None)
        nodes = document.scene.nodes if document.scene else []
        placed = list(_walk(collada, nodes))
        sizes = [_size(collada, one.geometry) for one in placed]
        check_faces(path, sum(faces for faces, _ in sizes), sum(points for _, points in sizes))
        parts = (_part(collada, path, one) for one in placed)
        return tuple(part for part in parts if part is not None)


def _cleaned(path: Path, data: bytes) -> ElementTree.Element:
    """Parse a document and remove what is not geometry; refuse what cannot be read."""
    try:
        tree = ElementTree.XML(data, ElementTree.XMLParser(target=_SafeBuilder()))
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not XML: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, LookupError) as error:
        raise InputError(f"{path}: not XML that can be read: {error}") from None
    if _tag(tree) != "COLLADA":
        raise InputError(f"{path}: not COLLADA: its root is {_tag(tree)[:40]!r}")
    _refuse(path, tree)
    for item in tree.iter():
        if _tag(item) == "lookat":
            item.text = " ".join(f"{value:.17g}" for value in _look_at(path, item).ravel())
            item.tag = item.tag.removesuffix("lookat") + "matrix"
    for item in list(tree.iter()):
        for child in [child for child in item if _tag(child) in _UNUSED]:
            item.remove(child)
    return tree


def _refuse(path: Path, tree: ElementTree.Element) -> None:
    """Refuse skinned meshes, references to other files, and elements that are not read."""
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


def _look_at(path: Path, item: ElementTree.Element) -> Floats:
    """The transform (4, 4) of a <lookat>, which pycollada leaves out: eye, point of interest, up.

    The node stands at the eye; its -z points to the point of interest, its y is nearest to up.
    """
    try:
        eye, interest, up = np.array((item.text or "").split(), dtype=np.float64).reshape(3, 3)
    except ValueError:
        raise InputError(f"{path}: <lookat> needs nine numbers, got {item.text!r:.60}") from None
    z = eye - interest
    x = np.cross(up, z)
    if not np.linalg.norm(x) > 0:
        raise InputError(f"{path}: <lookat> looks along its own up direction: {item.text!r:.60}")
    placed = np.eye(4)
    placed[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    placed[:3, :3] /= np.linalg.norm(placed[:3, :3], axis=0)
    placed[:3, 3] = eye
    return placed


def _walk(collada: Any, nodes: list[Any]) -> Iterator[_Placed]:
    """Yield every geometry as often as the scene places it, depth first."""
    stack = [_PendingNode(node, np.eye(4)) for node in reversed(nodes)]
    count = 0
    while stack:
        one = stack.pop()
        count += 1
        if count > MAX_INSTANCES:
            raise ValueError(
                f"nodes are placed more than {MAX_INSTANCES} times, or within themselves"
            )
        if isinstance(one.node, collada.scene.GeometryNode):
            yield _Placed(one.node.geometry, one.world, one.name)
        elif isinstance(one.node, collada.scene.Node):
            world = one.world @ np.asarray(one.node.matrix, dtype=np.float64)
            name, prefix, named = _names(collada, one)
            for child in reversed(one.node.children):
                placing = name if named and isinstance(child, collada.scene.NodeNode) else ""
                stack.append(_PendingNode(child, world, name, placing, prefix))


def _names(collada: Any, one: _PendingNode) -> tuple[str, str, bool]:
    """Return the name of a node's parts, the prefix of names below it, and whether the node has a
    name (not only an id).

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
    """Return the numbers of triangles and of vertices of a geometry."""
    surfaces = list(_surfaces(collada, geometry))
    faces = sum(int(np.sum(_corner_counts(collada, surface) - 2)) for surface in surfaces)
    return faces, sum(len(surface.vertex) for surface in surfaces)


def _surfaces(collada: Any, geometry: Any) -> Iterator[Any]:
    """Yield the primitives of a geometry that are no lines."""
    for primitive in geometry.primitives:
        is_lines = isinstance(primitive, collada.lineset.LineSet)
        if not is_lines and primitive.vertex is not None:
            yield primitive


def _corner_counts(collada: Any, surface: Any) -> Ints:
    """Return the number of corners of each face."""
    if isinstance(surface, collada.triangleset.TriangleSet):
        return np.full(len(np.asarray(surface.vertex_index).ravel()) // 3, 3)
    return np.asarray(surface.vcounts, dtype=np.int64)


def _part(collada: Any, path: Path, placed: _Placed) -> RawPart | None:
    """Return one part from all surfaces of a geometry, whatever their materials; None if it holds
    only lines."""
    geometry = placed.geometry
    vertices: list[Floats] = []
    faces: list[Ints] = []
    count = 0
    for surface in _surfaces(collada, geometry):
        points = np.asarray(surface.vertex, dtype=np.float64)
        corners = np.asarray(surface.vertex_index, dtype=np.int64).ravel()
        counts = _corner_counts(collada, surface)
        check_corners(path, counts)
        if corners.min(initial=0) < 0 or counts.min(initial=3) < 3 or counts.sum() != len(corners):
            raise ValueError(f"geometry {geometry.id!r} has faces whose corners are not there")
        faces.append(triangulate(points, corners, counts) + count)
        vertices.append(points)
        count += len(points)
    if not faces:
        return None
    name = placed.name or geometry.name or geometry.id
    return placed_part(name, np.concatenate(vertices), np.concatenate(faces), placed.transform)


def _unit(path: Path, unit: ElementTree.Element) -> float:
    """Return the unit of a document [m]."""
    text = unit.get("meter", "1")
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
