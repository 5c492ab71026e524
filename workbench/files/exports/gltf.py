"""Posed and moving bodies as binary glTF 2.0: a tree of named nodes, one sphere mesh shared by all
spheres.

Nodes: each body, its segments joined as in the body (a segment hangs on its parent), a node a
sphere under its segment; beside them the parts of an environment, a mesh each. The file's y is up
and z forward, as glTF wants, by one turn at the top: below it everything is in the workbench's
metres and axes, x forward, y left, z up. A motion becomes one animation: the turn of every segment,
the way of the root, and the way of the spheres that do not keep still in their segment (those that
share a twist).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.quaternions import from_matrices

__all__ = ["Figure", "glb_bytes"]

_STILL = 1e-7  # [m] and of a quaternion: less is no motion
_UPRIGHT = (-0.5, -0.5, -0.5, 0.5)  # x, y, z, w: z up and x forward to y up and z forward
_FLOAT = 5126
_SHORT = 5123
_INT = 5125
_CORNERS = 34962
_INDICES = 34963
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class Figure(NamedTuple):
    """A body in the file: its name, where it is, and its colour (3,) 0 to 1, as light is
    (linear)."""

    name: str
    placed: Placed
    colour: tuple[float, float, float]


class _File:
    """The JSON of the file and its bytes as they grow."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.json: dict[str, list[dict[str, Any]]] = {
            "nodes": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        self.json[kind].append(entry)
        return len(self.json[kind]) - 1

    def accessor(self, values: NDArray[Any], *, bounds: bool = False, mesh: bool = False) -> int:
        """Put an array (M, 3), (M, 4) or (M,) into the file; 32-bit floats, indices of 16 or 32
        bits.

        bounds: state the least and greatest values; mesh: it is part of a mesh, corners or their
        numbers, for the graphics card.
        """
        whole = np.issubdtype(values.dtype, np.integer)
        kind = (_SHORT if values.max(initial=0) < 65535 else _INT) if whole else _FLOAT
        stored = values.astype({_FLOAT: "<f4", _SHORT: "<u2", _INT: "<u4"}[kind])
        target = {"target": _INDICES if whole else _CORNERS} if mesh else {}
        row: dict[str, Any] = {
            "bufferView": self._view(stored.tobytes(), target),
            "componentType": kind,
            "count": len(stored),
            "type": _TYPES[1 if stored.ndim == 1 else stored.shape[1]],
        }
        if bounds:
            low = np.atleast_1d(stored.min(axis=0))
            high = np.atleast_1d(stored.max(axis=0))
            row |= {"min": low.tolist(), "max": high.tolist()}
        return self.add("accessors", row)

    def _view(self, data: bytes, target: dict[str, int]) -> int:
        """Put bytes into the file, filled up to a multiple of four."""
        entry = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.data += data + b"\0" * (-len(data) % 4)
        return self.add("bufferViews", entry | target)


def glb_bytes(
    figures: Sequence[Figure],
    environment: Environment | None = None,
    *,
    pose: int = 0,
    times: Floats | None = None,
) -> bytes:
    """Make a .glb file of one pose of every figure, or of all poses as an animation.

    Parameters
    ----------
    figures
        The bodies; with times each has P poses.
    environment
        What stands around them.
    pose
        The index of the one pose.
    times
        (P,) [s], rising: those of the poses of an animation.

    Raises
    ------
    InputError
        For times that do not rise, or a pose that is not finite.
    """
    file = _File()
    channels = _Channels()
    moving = channels if times is not None else None
    top = [_figure(file, figure, pose, moving) for figure in figures]
    if environment is not None:
        top.append(_environment(file, environment))
    root = file.add("nodes", {"name": "workbench", "rotation": list(_UPRIGHT), "children": top})
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "bubbleman-workbench"},
        "scene": 0,
        "scenes": [{"nodes": [root]}],
    }
    if times is not None:
        animation = _animation(file, channels, _checked_times(figures, times))
        document |= {"animations": [animation]} if animation["channels"] else {}
    document |= {key: rows for key, rows in file.json.items() if rows}
    if file.data:
        document["buffers"] = [{"byteLength": len(file.data)}]
    return _container(document, bytes(file.data))


def _checked_times(figures: Sequence[Figure], times: Floats) -> Floats:
    """(P,) the times [s] since the first of them; InputError unless they rise, one a pose."""
    times = np.asarray(times, dtype=np.float64)
    whole = times.ndim == 1 and len(times) and np.all(np.isfinite(times))
    if not whole or np.any(np.diff(times) <= 0.0):
        raise InputError("glTF: the times of a motion must be finite and rise")
    for figure in figures:
        if len(figure.placed) != len(times):
            raise InputError(
                f"glTF: {figure.name} has {len(figure.placed)} poses, the motion {len(times)} times"
            )
    return times - times[0]


class _Channels(list[tuple[int, str, Floats]]):
    """What moves: node, "rotation" or "translation", values (P, 4) x, y, z, w or (P, 3)."""


def _figure(file: _File, figure: Figure, pose: int, moving: _Channels | None) -> int:
    """Nodes of a body; the number of its topmost one."""
    placed = figure.placed
    material = file.add("materials", _material(figure.name, (*figure.colour, 1.0)))
    ball = _ball(file, material)
    frames = slice(None) if moving is not None else slice(pose, pose + 1 or None)
    nodes: dict[int, int] = {}
    top: list[int] = []
    for n in np.flatnonzero(placed.window).tolist():
        parent = nodes.get(int(placed.body.parent[n]))
        nodes[n] = _segment(file, figure, n, frames, parent is not None, moving)
        (top if parent is None else file.json["nodes"][parent]["children"]).append(nodes[n])
        file.json["nodes"][nodes[n]]["children"] = _spheres(file, figure, frames, n, ball, moving)
    return file.add("nodes", {"name": figure.name, "children": top})


def _segment(
    file: _File, figure: Figure, n: int, frames: slice, hangs: bool, moving: _Channels | None
) -> int:
    """A node of segment n. hangs: whether it stands in the frame of its parent, else in the
    world's."""
    body = figure.placed.body
    world = figure.placed.world_from_segment[frames]
    own = world[:, n]
    if not np.all(np.isfinite(own)):
        raise InputError(
            f"glTF: {figure.name}: segment {body.segments[n]} is not at a finite place"
        )
    local = _relative(world[:, int(body.parent[n])], own) if hangs else own
    turns = _steady(from_matrices(local[:, :, :3])[:, [1, 2, 3, 0]])
    way = local[:, :, 3]
    entry = {
        "name": body.segment_names[n],
        "translation": way[0].tolist(),
        "rotation": turns[0].tolist(),
        "extras": {"segment": body.segments[n]},
        "children": [],
    }
    node = file.add("nodes", entry)
    if moving is not None:
        moving += [(node, "rotation", turns), (node, "translation", way)]
    return node


def _relative(parent: Floats, child: Floats) -> Floats:
    """(P, 3, 4) child's frames seen from the parent's."""
    back = parent[:, :, :3].transpose(0, 2, 1)
    turn = back @ child[:, :, :3]
    shift = np.einsum("pij,pj->pi", back, child[:, :, 3] - parent[:, :, 3])
    return np.concatenate([turn, shift[:, :, None]], axis=2)


def _steady(turns: Floats) -> Floats:
    """Quaternions (P, 4) of one sign from each to the next: a viewer interpolates on the shorter
    way."""
    flips = np.cumprod(np.where(np.sum(turns[1:] * turns[:-1], axis=1) < 0.0, -1.0, 1.0))
    return turns * np.concatenate([[1.0], flips])[:, None]


def _spheres(
    file: _File, figure: Figure, frames: slice, n: int, ball: int, moving: _Channels | None
) -> list[int]:
    """Nodes of the spheres of segment n, instances of one mesh."""
    body = figure.placed.body
    local = _seen(figure.placed, frames, n)
    radius = body.radius[figure.placed.person[frames][0]]
    found = []
    for k, sphere in enumerate(range(body.start[n], body.start[n + 1])):
        entry = {
            "name": body.sphere_names[sphere] or f"{body.segments[n]} {k}",
            "mesh": ball,
            "translation": local[0, k].tolist(),
            "scale": [float(radius[sphere])] * 3,
        }
        found.append(file.add("nodes", entry))
        if moving is not None:
            moving.append((found[-1], "translation", local[:, k]))
    return found


def _seen(placed: Placed, frames: slice, n: int) -> Floats:
    """(P, K, 3) the centres of the spheres of segment n as the segment sees them."""
    frame = placed.world_from_segment[frames, n]
    away = placed.centres[frames, placed.body.spheres(n)] - frame[:, None, :, 3]
    return np.einsum("pji,psj->psi", frame[:, :, :3], away)


def _animation(file: _File, moving: _Channels, times: Floats) -> dict[str, Any]:
    """Channels of what moves by more than _STILL."""
    clock = file.accessor(times, bounds=True)
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    for node, path, values in moving:
        if np.ptp(values, axis=0).max() > _STILL:
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
            samplers.append(
                {"input": clock, "output": file.accessor(values), "interpolation": "LINEAR"}
            )
    return {"name": "motion", "channels": channels, "samplers": samplers}


def _material(name: str, colour: tuple[float, float, float, float]) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": name,
        "doubleSided": colour[3] < 1.0,
        "pbrMetallicRoughness": {
            "baseColorFactor": list(colour),
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        },
    }
    return entry | ({"alphaMode": "BLEND"} if colour[3] < 1.0 else {})


def _ball(file: _File, material: int) -> int:
    """A sphere of radius 1 of 1,280 triangles: an icosahedron halved three times; normals are its
    corners."""
    corners, faces = _icosphere(3)
    points = file.accessor(corners, bounds=True, mesh=True)
    numbers = file.accessor(faces.reshape(-1), mesh=True)
    mesh = {
        "attributes": {"POSITION": points, "NORMAL": points},
        "indices": numbers,
        "material": material,
    }
    return file.add("meshes", {"name": "sphere", "primitives": [mesh]})


def _icosphere(halvings: int) -> tuple[Floats, NDArray[np.int64]]:
    """Corners (V, 3) and faces (F, 3) of an icosahedron whose edges are halved so many times, on
    the unit sphere."""
    points, faces = _icosahedron()
    for _ in range(halvings):
        points, faces = _halved(points, faces)
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


def _icosahedron() -> tuple[Floats, NDArray[np.int64]]:
    """Corners (12, 3) and faces (20, 3), outward: its edges are 2 long, and no other two corners
    are as near."""
    golden = (1.0 + 5.0**0.5) / 2.0
    signs = [(a, b * golden) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    points = np.array([p for a, b in signs for p in ((0.0, a, b), (a, b, 0.0), (b, 0.0, a))])
    near = np.abs(np.linalg.norm(points[:, None] - points[None], axis=2) - 2.0) < 1e-9
    triples = ((i, j, k) for i in range(12) for j in range(i) for k in range(j))
    faces = np.array([(i, j, k) for i, j, k in triples if near[i, j] and near[j, k] and near[i, k]])
    return points, _outward(points, faces)


def _outward(points: Floats, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Faces (F, 3) about the origin, turned where they look inward: where a . (b x c) < 0."""
    first, second, third = points[faces.T]
    turn = np.einsum("fi,fi->f", first, np.cross(second, third))
    return np.where(turn[:, None] < 0.0, faces[:, ::-1], faces)


def _halved(points: Floats, faces: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """Each triangle as four, with the middles of its edges as new corners."""
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = len(points) + which.reshape(3, -1)
    fourth = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return (
        np.concatenate([points, points[unique].mean(axis=1)]),
        np.concatenate([np.stack(corners, axis=1) for corners in fourth]),
    )


def _environment(file: _File, environment: Environment) -> int:
    """A node and mesh for every part that is not hidden, flat shaded by its polygons' normals."""
    grey = file.add("materials", _material("part", (0.62, 0.65, 0.69, 1.0)))
    glass = file.add("materials", _material("see-through part", (0.5, 0.7, 0.8, 0.25)))
    nodes = []
    for part in np.flatnonzero(~environment.hidden).tolist():
        primitive = _part(file, environment, part)
        if primitive:
            primitive["material"] = glass if environment.see_through[part] else grey
            name = environment.parts[part]
            mesh = file.add("meshes", {"name": name, "primitives": [primitive]})
            nodes.append(file.add("nodes", {"name": name, "mesh": mesh}))
    children = {"children": nodes} if nodes else {}
    return file.add("nodes", {"name": environment.name} | children)


def _part(file: _File, environment: Environment, part: int) -> dict[str, Any]:
    """The corners of a part's triangles and their normals; nothing where it has no triangles."""
    rows = environment.polygons(part)
    start = environment.triangle_start[rows.start : rows.stop + 1]
    first, last = start[[0, -1]]
    if first == last:
        return {}
    corners = environment.vertices[environment.triangles[first:last]].reshape(-1, 3)
    normals = np.repeat(environment.normal[rows], 3 * np.diff(start), axis=0)
    attributes = {
        "POSITION": file.accessor(corners, bounds=True, mesh=True),
        "NORMAL": file.accessor(normals, mesh=True),
    }
    return {"attributes": attributes}


def _container(document: dict[str, Any], data: bytes) -> bytes:
    """The binary container: header, JSON chunk, bytes chunk; each a multiple of four bytes."""
    _drop_empty(document)
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = [(b"JSON", text)] + ([(b"BIN\0", data)] if data else [])
    body = b"".join(len(chunk).to_bytes(4, "little") + kind + chunk for kind, chunk in chunks)
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body


def _drop_empty(document: dict[str, Any]) -> None:
    """glTF has no empty lists of children."""
    for node in document["nodes"]:
        if node.get("children") == []:
            del node["children"]
