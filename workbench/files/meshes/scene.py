"""Meshes of trimesh as parts: what a program has loaded, made or mended with that library becomes
an environment.

trimesh opens many kinds of files and makes shapes. It is asked for nothing else here: files of the
formats that the workbench names are read by its own readers, which keep names and concave faces
(see docs/design.md).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.files.meshes.parts import RawMesh, RawPart, weld
from workbench.files.names import unique_names
from workbench.files.schema import metres_in

if TYPE_CHECKING:
    import trimesh

__all__ = ["mesh_of_scene"]


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
        is known.

    Raises
    ------
    UsageError
        If it is neither a scene nor a mesh.
    InputError
        If it holds no surface, or vertices that are not finite.
    """
    import trimesh

    if isinstance(scene, trimesh.Trimesh):
        alone = trimesh.Scene()
        alone.add_geometry(scene, geom_name=name)
        scene = alone
    if not isinstance(scene, trimesh.Scene):
        raise UsageError(
            f"expected a path, a trimesh.Scene or a trimesh.Trimesh, got {type(scene).__name__}"
        )
    found: list[tuple[str, RawPart]] = []
    others = 0
    for node in scene.graph.nodes_geometry:
        world_from_node, geometry_name = scene.graph[node]
        geometry = scene.geometry[geometry_name]
        if not isinstance(geometry, trimesh.Trimesh):
            others += 1
            continue
        vertices = np.asarray(geometry.vertices, dtype=np.float64)
        if not np.all(np.isfinite(vertices)):
            raise InputError(
                f"{name}: part {geometry_name!r}: has vertices that are not finite numbers"
            )
        world = vertices @ world_from_node[:3, :3].T + world_from_node[:3, 3]
        faces = np.asarray(geometry.faces, dtype=np.int64)
        mirrored = np.linalg.det(world_from_node[:3, :3]) < 0
        placed = weld(world, faces[:, ::-1] if mirrored else faces)
        if len(faces):
            found.append((geometry_name, RawPart(geometry_name, *placed)))
    if not found:
        raise InputError(f"{name}: holds no surface (no faces)")
    names = unique_names((given for given, _ in found), name)
    parts = tuple(
        RawPart(own, part.vertices, part.faces) for own, (_, part) in zip(names, found, strict=True)
    )
    notes = (
        (f"{others} sets of points or lines are not surfaces and are left out",) if others else ()
    )
    return RawMesh(name, "trimesh", parts, metres_in.get(scene.units or ""), notes=notes)
