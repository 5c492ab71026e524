"""Convert meshes of trimesh to parts and back, so that what a program loads or makes with it can be
used.

The workbench reads the formats that it names with its own readers, which keep names and concave
faces (see docs/design.md).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.files.meshes.parts import RawMesh, RawPart, placed_part, weld
from workbench.files.meshes.reading import AXES
from workbench.files.names import unique_names
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats
from workbench.model.environment import Environment, Part

if TYPE_CHECKING:
    import trimesh

_FRAME = {"up": "z", "forward": "x"}
"""Axes of all that goes out, for whoever reads them."""

__all__ = ["environment_scene", "is_scene", "mesh_of_scene", "part_mesh"]


def is_scene(value: object) -> bool:
    """Whether something is a mesh or a scene of trimesh; loads trimesh only where it may be."""
    if not type(value).__module__.startswith("trimesh"):
        return False
    import trimesh

    return isinstance(value, (trimesh.Trimesh, trimesh.Scene))


def mesh_of_scene(scene: trimesh.Scene | trimesh.Trimesh, name: str) -> RawMesh:
    """List the surfaces of a trimesh scene as named parts, transforms applied.

    Parameters
    ----------
    scene
        A scene, in which each node with a surface is a part named after the node's geometry, or one
        mesh. Points and lines are not surfaces; they are counted in the notes.
    name
        Name of the whole, and of parts without one.

    Returns
    -------
    RawMesh
        Parts in the units and axes of the scene. `metres` is set where the scene states a unit that
        is known, `up` and `forward` where its metadata have axes under these names.

    Raises
    ------
    UsageError
        If it is neither a scene nor a mesh.
    InputError
        If it holds no surface, or vertices that are not finite.
    """
    import trimesh

    if isinstance(scene, trimesh.Trimesh):
        alone = trimesh.Scene(metadata=scene.metadata)
        alone.add_geometry(scene, geom_name=name)
        scene = alone
    if not isinstance(scene, trimesh.Scene):
        raise UsageError(
            f"expected a path, a trimesh.Scene or a trimesh.Trimesh, got {type(scene).__name__}"
        )
    parts = []
    others = 0
    for node in scene.graph.nodes_geometry:
        world_from_node, geometry_name = scene.graph[node]
        geometry = scene.geometry[geometry_name]
        if not isinstance(geometry, trimesh.Trimesh):
            others += 1
        elif len(geometry.faces) or not np.all(np.isfinite(geometry.vertices)):
            parts.append(_node_part(name, geometry_name, geometry, world_from_node))
    if not parts:
        raise InputError(f"{name}: holds no surface (no faces)")
    names = unique_names((part.name for part in parts), name)
    named = tuple(replace(part, name=own) for own, part in zip(names, parts, strict=True))
    notes: tuple[str, ...] = ()
    if others:
        notes = (f"{others} sets of points or lines are not surfaces and are left out",)
    up, forward = (_axis(scene, key) for key in ("up", "forward"))
    metres = metres_in.get(scene.units or "")
    return RawMesh(name, "trimesh", named, metres, up, notes, forward)


def _axis(scene: trimesh.Scene, key: str) -> str | None:
    """An axis that the metadata of a scene state; None where they do not."""
    axis = scene.metadata.get(key)
    return axis if isinstance(axis, str) and axis in AXES else None


def _node_part(file: str, name: str, mesh: trimesh.Trimesh, world_from_node: Floats) -> RawPart:
    """Return the mesh of a node in the world."""
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    if not np.all(np.isfinite(vertices)):
        raise InputError(f"{file}: part {name!r}: has vertices that are not finite numbers")
    faces = np.asarray(mesh.faces, dtype=np.int64)
    placed = placed_part(name, vertices, faces, np.asarray(world_from_node))
    return RawPart(name, *weld(placed.vertices, placed.faces))


def part_mesh(part: Part) -> trimesh.Trimesh:
    """Return the mesh of a part, as it is: no vertex is merged and no face left out."""
    import trimesh

    about = {"solid": part.solid, "hidden": part.hidden, "see_through": part.see_through}
    mesh = trimesh.Trimesh(
        part.vertices.copy(),
        part.faces.copy(),
        process=False,
        metadata={"name": part.name, **about},
    )
    mesh.units = "m"
    mesh.metadata |= _FRAME
    return mesh


def environment_scene(environment: Environment) -> trimesh.Scene:
    """Return the parts of an environment as a scene, each a geometry of its name."""
    import trimesh

    scene = trimesh.Scene(metadata=dict(_FRAME))
    for name in environment.parts:
        scene.add_geometry(part_mesh(environment.part(name)), geom_name=name, node_name=name)
    scene.units = "m"
    return scene
