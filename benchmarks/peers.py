"""Other libraries asked the same questions: each entry of PEERS prepares an environment and a body,
then answers.

A prepared peer is called with "any" or "by segment" and a pose, which is what is timed; what it
returns is called for the answer, which is not: a bool, or the clearance (N,) [m] of each segment.
Raises ImportError where the library is not installed. None of them knows solids: inside one they
give the way to its surface.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["PEERS", "NoAnswerError"]

Answer = Callable[[], bool | Floats]
Ask = Callable[[str, int], Answer]
FAR = 1e3


class NoAnswerError(Exception):
    """A library has no function for a question."""


def _told(placed: Placed, kind: str, gaps: Floats) -> bool | Floats:
    """The answer from the spheres' clearances (S,)."""
    if kind == "any":
        return bool(np.any(gaps < -1e-9))
    out = np.full(len(placed.window), np.inf)
    np.minimum.at(out, placed.body.sphere_segment, gaps)
    return out


def _spheres_one_by_one(
    library: Any, world: Any, placed: Placed, move: Callable[[Any, Floats], None]
) -> Ask:
    """The two questions of the libraries of FCL's kind: every sphere against one mesh; for
    distances a tiny sphere, the radius taken off, which is several times as fast as their managers
    and keeps the depth."""
    radius = placed.body.radius[0]
    balls = [library.CollisionObject(library.Sphere(r)) for r in radius]
    dot = library.CollisionObject(library.Sphere(1e-9))

    def ask(kind: str, pose: int) -> Answer:
        centres = placed.centres[pose]
        if kind == "any":
            hit = False
            for ball, centre in zip(balls, centres, strict=True):
                move(ball, centre)
                if library.collide(
                    ball, world, library.CollisionRequest(), library.CollisionResult()
                ):
                    hit = True
                    break
            return lambda: hit
        gaps = np.empty(len(radius))
        for s, centre in enumerate(centres):
            move(dot, centre)
            gaps[s] = library.distance(
                dot, world, library.DistanceRequest(), library.DistanceResult()
            )
        return lambda: _told(placed, kind, gaps - radius)

    return ask


def fcl_each(environment: Environment, placed: Placed) -> Ask:
    """python-fcl: one triangle tree."""
    import fcl  # type: ignore[import-not-found,unused-ignore]

    mesh = fcl.BVHModel()
    mesh.beginModel(len(environment.vertices), len(environment.triangles))
    mesh.addSubModel(environment.vertices, environment.triangles)
    mesh.endModel()
    return _spheres_one_by_one(
        fcl, fcl.CollisionObject(mesh), placed, lambda ball, at: ball.setTranslation(at)
    )


def coal_each(environment: Environment, placed: Placed) -> Ask:
    """coal, the successor of hpp-fcl: one tree of oriented boxes and swept spheres."""
    import coal  # type: ignore[import-not-found,unused-ignore]

    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(environment.triangles), len(environment.vertices))
    mesh.addVertices(environment.vertices)
    mesh.addTriangles(environment.triangles)
    mesh.endModel()
    return _spheres_one_by_one(
        coal, coal.CollisionObject(mesh), placed, lambda ball, at: ball.setTranslation(at)
    )


def warp_cpu(environment: Environment, placed: Placed) -> Ask:
    """NVIDIA Warp on the CPU: the nearest mesh point of every centre, within reach of what is
    asked."""
    import warp as wp  # type: ignore[import-not-found,unused-ignore]

    from benchmarks.warp_kernels import nearest_gaps

    wp.config.quiet = True
    wp.init()
    points = wp.array(environment.vertices.astype(np.float32), dtype=wp.vec3, device="cpu")
    corners = wp.array(environment.triangles.astype(np.int32).ravel(), dtype=wp.int32, device="cpu")
    mesh = wp.Mesh(points, corners)
    count = len(placed.body.sphere_names)
    radius = placed.body.radius[0]
    reach = {
        "any": wp.array(radius.astype(np.float32), dtype=wp.float32, device="cpu"),
        "by segment": wp.full(count, FAR, dtype=wp.float32, device="cpu"),
    }
    gaps = wp.zeros(count, dtype=wp.float32, device="cpu")

    def ask(kind: str, pose: int) -> Answer:
        centres = wp.array(placed.centres[pose].astype(np.float32), dtype=wp.vec3, device="cpu")
        wp.launch(
            nearest_gaps, dim=count, inputs=[mesh.id, centres, reach[kind], gaps], device="cpu"
        )
        return lambda: _told(placed, kind, gaps.numpy().astype(np.float64) - radius)

    return ask


def fcpw_batch(environment: Environment, placed: Placed) -> Ask:
    """fcpw: a vectorised tree, all centres of a pose in one call."""
    import fcpw  # type: ignore[import-not-found,unused-ignore]

    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(np.asfortranarray(environment.vertices, dtype=np.float32), 0)
    scene.set_object_triangles(np.asfortranarray(environment.triangles, dtype=np.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)
    radius = placed.body.radius[0]
    reach = {
        "any": (radius**2).astype(np.float32),
        "by segment": np.full(len(radius), FAR**2, dtype=np.float32),
    }

    def ask(kind: str, pose: int) -> Answer:
        found = fcpw.interaction_3D_list()
        centres = np.asfortranarray(placed.centres[pose], dtype=np.float32)
        scene.find_closest_points(centres, reach[kind], found)
        return lambda: _told(placed, kind, np.array([min(one.d, FAR) for one in found]) - radius)

    return ask


def libigl_tree(environment: Environment, placed: Placed) -> Ask:
    """libigl: its tree of boxes, all centres of a pose in one call; it has no limit to give for
    "any"."""
    import igl  # type: ignore[import-not-found,unused-ignore]

    points = environment.vertices.copy()
    faces = environment.triangles.copy()
    tree = igl.AABB()
    tree.init(points, faces)
    radius = placed.body.radius[0]

    def ask(kind: str, pose: int) -> Answer:
        square = tree.squared_distance(points, faces, placed.centres[pose].copy())[0]
        return lambda: _told(placed, kind, np.sqrt(square) - radius)

    return ask


def open3d_scene(environment: Environment, placed: Placed) -> Ask:
    """Open3D: Embree's point query; it has no limit to give for "any"."""
    import open3d as o3d  # type: ignore[import-not-found,unused-ignore]

    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(
        o3d.core.Tensor(environment.vertices.astype(np.float32)),
        o3d.core.Tensor(environment.triangles.astype(np.uint32)),
    )
    radius = placed.body.radius[0]

    def ask(kind: str, pose: int) -> Answer:
        found = scene.compute_distance(
            o3d.core.Tensor(placed.centres[pose].astype(np.float32)), nthreads=1
        )
        return lambda: _told(placed, kind, found.numpy().astype(np.float64) - radius)

    return ask


def mujoco_flex(environment: Environment, placed: Placed) -> Ask:
    """MuJoCo: every sphere a free body, the triangles one rigid flex, which it has contacts for and
    no distances."""
    import mujoco  # type: ignore[import-not-found,unused-ignore]

    balls = "".join(
        f'<body><freejoint/><geom type="sphere" size="{r:.17g}" contype="1" conaffinity="0"/></body>'
        for r in placed.body.radius[0]
    )
    points, corners = (
        " ".join(map(str, values.ravel().tolist()))
        for values in (environment.vertices, environment.triangles)
    )
    flex = f'<flex name="parts" dim="2" body="world" radius="1e-6" vertex="{points}" element="{corners}">'
    alone = '<contact contype="0" conaffinity="1" selfcollide="none"/></flex>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><size memory="400M"/><worldbody>{balls}</worldbody><deformable>{flex}{alone}</deformable></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def ask(kind: str, pose: int) -> Answer:
        if kind != "any":
            raise NoAnswerError("no distance to a flex")
        data.qpos.reshape(-1, 7)[:, :3] = placed.centres[pose]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        hit = bool(np.any(data.contact.dist[: data.ncon] < -1e-9))
        return lambda: hit

    return ask


def trimesh_managers(environment: Environment, placed: Placed) -> Ask:
    """trimesh's CollisionManager, one a segment: it knows meshes alone, so every sphere is one of
    320 triangles, and what only the sphere touches it does not see. Where meshes touch it has no
    depth."""
    import trimesh

    parts = trimesh.collision.CollisionManager()
    managers = []
    parts.add_object(
        "parts", trimesh.Trimesh(environment.vertices, environment.triangles, process=False)
    )
    body = placed.body
    for n in range(len(body.segments)):
        managers.append(trimesh.collision.CollisionManager())
        for s in range(body.start[n], body.start[n + 1]):
            managers[-1].add_object(
                str(s), trimesh.creation.icosphere(subdivisions=2, radius=body.radius[0, s])
            )

    def ask(kind: str, pose: int) -> Answer:
        turn = np.eye(4)
        gaps = np.full(len(managers), np.inf)
        for n, manager in enumerate(managers):
            for s in range(body.start[n], body.start[n + 1]):
                turn[:3, 3] = placed.centres[pose, s]
                manager.set_transform(str(s), turn)
            if (
                kind == "any"
                and body.start[n] < body.start[n + 1]
                and manager.in_collision_other(parts)
            ):
                return lambda: True
            if kind != "any" and body.start[n] < body.start[n + 1]:
                gaps[n] = manager.min_distance_other(parts)
        return lambda: gaps if kind != "any" else False

    return ask


PEERS: dict[str, Callable[[Environment, Placed], Ask]] = {
    "warp-lang": warp_cpu,
    "fcpw": fcpw_batch,
    "open3d": open3d_scene,
    "libigl": libigl_tree,
    "python-fcl": fcl_each,
    "coal": coal_each,
    "mujoco": mujoco_flex,
    "trimesh": trimesh_managers,
}
