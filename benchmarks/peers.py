"""Other libraries asked the same questions as somebody asks them who knows them.

Each entry of PEERS prepares an environment and a body and returns, by question, what asks it about
some poses (see `timing.Ask`): "any" for whether a pose touches, (P,), "by segment" for the
clearance (P, N) [m] of each segment. A library without a function for a question lacks the entry.
Raises ImportError where the library is not installed.

What takes many queries at once gets those of all poses; what takes a limit gets one: the radius for
"any", else the nearest sphere of the segment so far. None knows of solids among open parts, so
every part is open for them and, beside them, for this project.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.cases import Case, opened
from benchmarks.clearance import by_segment
from benchmarks.table import LIBRARIES, Row
from benchmarks.timing import Ask, Turn, in_turn
from workbench.contact.collide import collides
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["OURS", "PEERS", "asked_of_us", "peer_rows", "prepared"]

OURS = "this project"
QUESTIONS = ("any", "by segment")
TOUCH = -1e-9
FAR = 1e3
"""[m] As far as the libraries look where they have no limit."""
PIECES = 4
"""Into how many the poses are cut at most: engines take turns after each."""
SHORTEST = 64
"""Poses of a piece at least: with fewer this project makes no use of its grids."""


def _least(placed: Placed, gaps: Floats) -> Floats:
    """(P, N) [m] the least of the clearances (P, S) of the spheres of each segment."""
    start = placed.body.start
    out = np.full((len(gaps), len(start) - 1), np.inf)
    for n in range(len(start) - 1):
        out[:, n] = gaps[:, start[n] : start[n + 1]].min(axis=1, initial=np.inf)
    return out


def _all_gaps(placed: Placed, query: Callable[[Floats], Callable[[], Floats]]) -> dict[str, Ask]:
    """Both questions by the distances (n,) [m] of all centres (n, 3) in one query."""

    def ask(kind: str, rows: slice) -> Callable[[], Floats]:
        centres = placed.centres[rows]
        found = query(centres.reshape(-1, 3))

        def answer() -> Floats:
            gaps = found().reshape(centres.shape[:2]) - placed.body.radius[0]
            return (gaps < TOUCH).any(axis=1) if kind == "any" else _least(placed, gaps)

        return answer

    return {kind: partial(ask, kind) for kind in QUESTIONS}


def warp_cpu(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """NVIDIA Warp on the CPU: one launch for all poses, a thread a pose or a segment of a pose, a
    ball around each segment asked about before its spheres."""
    import warp as wp  # type: ignore[import-not-found,unused-ignore]

    wp.config.quiet = True
    wp.init()
    from benchmarks.warp_kernels import segment_gaps, touching

    to_array = partial(wp.array, device="cpu")
    points = to_array(environment.vertices.astype(np.float32), dtype=wp.vec3)
    corners = to_array(environment.triangles.astype(np.int32).ravel(), dtype=wp.int32)
    mesh = wp.Mesh(points, corners)
    radius = to_array(placed.body.radius[0].astype(np.float32), dtype=wp.float32)
    start = to_array(placed.body.start.astype(np.int32), dtype=wp.int32)
    middle = to_array(_middles(placed), dtype=wp.int32)
    spheres = radius, start, middle
    segments = len(placed.window)

    def centres(rows: slice) -> Any:
        some = placed.centres[rows].reshape(-1, 3).astype(np.float32)
        return to_array(some, dtype=wp.vec3)

    def touch(rows: slice) -> Callable[[], Floats]:
        count = rows.stop - rows.start
        hit = wp.zeros(count, dtype=wp.int32, device="cpu")
        wp.launch(touching, dim=count, inputs=[mesh.id, centres(rows), *spheres, hit], device="cpu")
        return lambda: hit.numpy().astype(np.bool_)

    def gap(rows: slice) -> Callable[[], Floats]:
        count = segments * (rows.stop - rows.start)
        gaps = wp.zeros(count, dtype=wp.float32, device="cpu")
        inputs = [mesh.id, centres(rows), *spheres, gaps]
        wp.launch(segment_gaps, dim=count, inputs=inputs, device="cpu")
        return lambda: _far(gaps.numpy().reshape(-1, segments).astype(np.float64))

    return {"any": touch, "by segment": gap}


def _middles(placed: Placed) -> Ints:
    """(N,) the sphere of each segment whose centre is nearest to the middle of them all, in the
    first pose; 0 where it has none."""
    start = placed.body.start
    centres = placed.centres[0]
    out = np.zeros(len(start) - 1, dtype=np.int32)
    for n in np.flatnonzero(np.diff(start) > 0):
        own = centres[start[n] : start[n + 1]]
        middle = 0.5 * (own.min(axis=0) + own.max(axis=0))
        out[n] = start[n] + np.argmin(np.linalg.norm(own - middle, axis=1))
    return out


def _far(gaps: Floats) -> Floats:
    """Gaps [m], infinite where nothing was found."""
    return np.where(gaps > 0.5 * FAR, np.inf, gaps)


def fcpw_batch(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """fcpw: a vectorised tree, all spheres of all poses in one call, each with its own limit. By
    segment in two calls: first its largest sphere, which limits how far the others look."""
    import fcpw  # type: ignore[import-not-found,unused-ignore]

    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(np.asfortranarray(environment.vertices, dtype=np.float32), 0)
    scene.set_object_triangles(np.asfortranarray(environment.triangles, dtype=np.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)
    radius = placed.body.radius[0]
    start = placed.body.start
    full = np.flatnonzero(np.diff(start) > 0)
    first = np.array([start[n] + np.argmax(radius[start[n] : start[n + 1]]) for n in full])
    owner = np.zeros(len(radius), dtype=np.int64)
    owner[:] = np.searchsorted(full, placed.body.sphere_segment)

    def within(centres: Floats, reach: Floats) -> Floats:
        found = fcpw.interaction_3D_list()
        square = (np.maximum(reach, 0.0) ** 2).ravel().astype(np.float32)
        flat = np.asfortranarray(centres.reshape(-1, 3), dtype=np.float32)
        scene.find_closest_points(flat, square, found)
        return np.array([min(one.d, FAR) for one in found]).reshape(reach.shape)

    def touch(rows: slice) -> Callable[[], Floats]:
        centres = placed.centres[rows]
        gaps = within(centres, np.broadcast_to(radius, centres.shape[:2])) - radius
        return lambda: (gaps < TOUCH).any(axis=1)

    def gap(rows: slice) -> Callable[[], Floats]:
        centres = placed.centres[rows]
        far = np.full((len(centres), len(first)), FAR)
        limit = within(centres[:, first], far) - radius[first]
        reach = limit[:, owner] + radius + 1e-6
        gaps = within(centres, reach) - radius
        gaps[:, first] = limit
        return lambda: _least(placed, gaps)

    return {"any": touch, "by segment": gap}


def libigl_tree(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """libigl: its tree of boxes, all centres in one call; it takes no limit."""
    import igl  # type: ignore[import-not-found,unused-ignore]

    points = environment.vertices.copy()
    faces = environment.triangles.copy()
    tree = igl.AABB()
    tree.init(points, faces)

    def query(centres: Floats) -> Callable[[], Floats]:
        square = tree.squared_distance(points, faces, centres.copy())[0]
        return lambda: np.sqrt(square)

    return _all_gaps(placed, query)


def open3d_scene(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """Open3D: Embree's point query, all centres in one call; it takes no limit."""
    import open3d as o3d  # type: ignore[import-not-found,unused-ignore]

    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(
        o3d.core.Tensor(environment.vertices.astype(np.float32)),
        o3d.core.Tensor(environment.triangles.astype(np.uint32)),
    )

    def query(centres: Floats) -> Callable[[], Floats]:
        found = scene.compute_distance(o3d.core.Tensor(centres.astype(np.float32)), nthreads=1)
        return lambda: found.numpy().astype(np.float64)

    return _all_gaps(placed, query)


def _pose_by_pose(placed: Placed, one: Callable[[Floats], Any]) -> Ask:
    """A question that is asked of one pose's centres (S, 3) at a time."""

    def ask(rows: slice) -> Callable[[], Floats]:
        found = [one(placed.centres[p]) for p in range(rows.start, rows.stop)]
        return lambda: np.array(found)

    return ask


def _mesh_of(environment: Environment, triangles: Ints) -> tuple[Floats, Ints]:
    """The vertices of some triangles, and the triangles by these: the libraries put boxes around
    all vertices that they are given."""
    used, index = np.unique(triangles, return_inverse=True)
    return environment.vertices[used], index.reshape(-1, 3)


def _part_triangles(environment: Environment) -> list[Ints]:
    """The triangles (T, 3) of each part that has any."""
    ends = environment.triangle_start[environment.part_start]
    return [environment.triangles[a:b] for a, b in itertools.pairwise(ends.tolist()) if b > a]


def fcl_managed(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """python-fcl: the spheres in one broad-phase manager, a triangle tree a part in another. For
    distances a tiny sphere, the radius taken off, one by one against one tree: the managers give no
    depth."""
    import fcl  # type: ignore[import-not-found,unused-ignore]

    def tree(triangles: Ints) -> Any:
        points, faces = _mesh_of(environment, triangles)
        mesh = fcl.BVHModel()
        mesh.beginModel(len(points), len(faces))
        mesh.addSubModel(points, faces)
        mesh.endModel()
        return fcl.CollisionObject(mesh)

    def managed(objects: list[Any]) -> Any:
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects(objects)
        manager.setup()
        return manager

    world = tree(environment.triangles)
    parts = managed([tree(triangles) for triangles in _part_triangles(environment)])
    radius = placed.body.radius[0]
    balls = [fcl.CollisionObject(fcl.Sphere(r)) for r in radius]
    manager = managed(balls)
    dot = fcl.CollisionObject(fcl.Sphere(1e-9))

    def touch(centres: Floats) -> bool:
        for ball, centre in zip(balls, centres, strict=True):
            ball.setTranslation(centre)
        manager.update()
        found = fcl.CollisionData()
        manager.collide(parts, found, fcl.defaultCollisionCallback)
        return bool(found.result.is_collision)

    def gap(centres: Floats) -> Floats:
        gaps = np.empty(len(radius))
        for s, centre in enumerate(centres):
            dot.setTranslation(centre)
            gaps[s] = fcl.distance(dot, world, fcl.DistanceRequest(), fcl.DistanceResult())
        return _least(placed, (gaps - radius)[None])[0]

    return {"any": _pose_by_pose(placed, touch), "by segment": _pose_by_pose(placed, gap)}


def coal_managed(environment: Environment, placed: Placed) -> dict[str, Ask]:
    """coal, the successor of hpp-fcl: the spheres in one broad-phase manager, a tree of oriented
    boxes and swept spheres a part in another. For distances a tiny sphere against one tree, limited
    by the segment's nearest so far."""
    import coal  # type: ignore[import-not-found,unused-ignore]

    def tree(triangles: Ints) -> Any:
        points, faces = _mesh_of(environment, triangles)
        mesh = coal.BVHModelOBBRSS()
        mesh.beginModel(len(faces), len(points))
        mesh.addVertices(points)
        mesh.addTriangles(faces)
        mesh.endModel()
        return coal.CollisionObject(mesh)

    def managed(objects: list[Any]) -> Any:
        manager = coal.DynamicAABBTreeCollisionManager()
        for one in objects:
            manager.registerObject(one)
        manager.setup()
        return manager

    world = tree(environment.triangles)
    trees = [tree(triangles) for triangles in _part_triangles(environment)]
    parts = managed(trees)
    radius = placed.body.radius[0]
    start = placed.body.start
    balls = [coal.CollisionObject(coal.Sphere(float(r))) for r in radius]
    manager = managed(balls)
    callback = coal.CollisionCallBackDefault()
    dot = coal.CollisionObject(coal.Sphere(1e-9))
    request = coal.DistanceRequest()

    def touch(centres: Floats) -> bool:
        for ball, centre in zip(balls, centres, strict=True):
            ball.setTranslation(centre)
            ball.computeAABB()
        manager.update()
        callback.data.clear()
        manager.collide(parts, callback)
        return bool(callback.data.result.isCollision())

    def gap(centres: Floats) -> Floats:
        gaps = np.full(len(start) - 1, np.inf)
        result = coal.DistanceResult()
        for n in range(len(gaps)):
            least = FAR
            for s in range(start[n], start[n + 1]):
                dot.setTranslation(centres[s])
                result.clear()
                result.min_distance = least + radius[s]
                least = min(least, coal.distance(dot, world, request, result) - radius[s])
            gaps[n] = least if least < FAR else np.inf
        return gaps

    return {"any": _pose_by_pose(placed, touch), "by segment": _pose_by_pose(placed, gap)}


def mujoco_flex(environment: Environment, placed: Placed) -> dict[str, Ask]:
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

    def touch(centres: Floats) -> bool:
        data.qpos.reshape(-1, 7)[:, :3] = centres
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        return bool(np.any(data.contact.dist[: data.ncon] < TOUCH))

    return {"any": _pose_by_pose(placed, touch)}


PEERS: dict[str, Callable[[Environment, Placed], dict[str, Ask]]] = dict(
    zip(
        LIBRARIES,
        (
            warp_cpu,
            fcpw_batch,
            open3d_scene,
            libigl_tree,
            fcl_managed,
            coal_managed,
            mujoco_flex,
        ),
        strict=True,
    )
)


def asked_of_us(case: Case) -> dict[str, Ask]:
    """This project, asked the same about a case whose parts are all open."""

    def touch(rows: slice) -> Callable[[], Floats]:
        found = collides(case.few(rows).placed, case.environment)
        return lambda: found

    def gap(rows: slice) -> Callable[[], Floats]:
        found = by_segment(case.few(rows))
        return lambda: found.min(axis=2)

    return {"any": touch, "by segment": gap}


def prepared(case: Case) -> tuple[dict[str, dict[str, Ask]], dict[str, str]]:
    """Prepare all engines for a case whose parts are open; which are not installed, and why."""
    engines = {OURS: asked_of_us(case)}
    missing = {}
    for name, prepare in PEERS.items():
        try:
            engines[name] = prepare(case.environment, case.placed)
        except ImportError as error:
            missing[name] = str(error)
    return engines, missing


def peer_rows(case: Case, kinds: Sequence[str] = QUESTIONS) -> Iterator[Row]:
    """Yield what this project and the others take for the same, in turn, and how many times ours
    that is."""
    case = opened(case)
    cuts = max(min(PIECES, len(case.placed) // SHORTEST), 1)
    name = f"{case.name}, all open"
    engines, missing = prepared(case)
    edges = np.linspace(0, len(case.placed), cuts + 1).astype(int).tolist()
    pieces = [slice(a, b) for a, b in itertools.pairwise(edges)]
    for kind in kinds:
        some = {engine: asks[kind] for engine, asks in engines.items() if kind in asks}
        turns = in_turn(some, pieces)
        ours = turns[OURS]
        for engine, turn in turns.items():
            words = "" if engine == OURS else _beside(kind, turn, ours)
            yield Row(f"{kind}, {engine}", name, turn.each, "us a pose", words)
        if "warp-lang" in turns:
            ratio = turns["warp-lang"].each / ours.each
            yield Row(f"{kind}, Warp against ours", case.name, ratio, "times", "every part open")
    for engine, why in missing.items():
        yield Row(engine, name, None, "us a pose", f"not installed ({why})")


def _beside(kind: str, turn: Turn, ours: Turn) -> str:
    """How many times as long as ours it takes, and how far its answers are ours."""
    told = turn.told
    wanted = ours.told[: len(told)]
    words = f"{turn.each / ours.each:.3g} times ours; "
    if kind == "any":
        return f"{words}{np.mean(told == wanted):.1%} of {len(told)} poses agree"
    known = np.isfinite(wanted)
    worst = np.abs(told[known] - wanted[known]).max(initial=0.0)
    return f"{words}at most {1e3 * worst:.0e} mm apart in {len(told)} poses"
