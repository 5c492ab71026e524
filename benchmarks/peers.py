"""Other libraries asked the same questions: each entry of PEERS prepares an environment and a body, then answers.

A prepared peer is called with "any" or "by segment" and a pose; it answers a bool, or the clearance (N,) [m] of each
segment. Raises ImportError where the library is not installed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["PEERS"]

Ask = Callable[[str, int], bool | Floats]


def _least(placed: Placed, gaps: Floats) -> Floats:
    """(N,) the least of the spheres' clearances (S,) by segment; infinite where a segment has none."""
    out = np.full(len(placed.window), np.inf)
    np.minimum.at(out, placed.body.sphere_segment, gaps)
    return out


def fcl_each(environment: Environment, placed: Placed) -> Ask:
    """python-fcl: every sphere against one triangle tree; for distances a tiny sphere, the radius taken off."""
    import fcl  # type: ignore[import-not-found,unused-ignore]

    mesh = fcl.BVHModel()
    mesh.beginModel(len(environment.vertices), len(environment.triangles))
    mesh.addSubModel(environment.vertices, environment.triangles)
    mesh.endModel()
    world, radius = fcl.CollisionObject(mesh), placed.body.radius
    balls = [fcl.CollisionObject(fcl.Sphere(r)) for r in radius]
    dot = fcl.CollisionObject(fcl.Sphere(1e-9))

    def ask(kind: str, pose: int) -> bool | Floats:
        centres = placed.centres[pose]
        if kind == "any":
            for ball, centre in zip(balls, centres, strict=True):
                ball.setTranslation(centre)
                if fcl.collide(ball, world, fcl.CollisionRequest(), fcl.CollisionResult()):
                    return True
            return False
        gaps = np.empty(len(radius))
        for s, centre in enumerate(centres):
            dot.setTranslation(centre)
            gaps[s] = fcl.distance(dot, world, fcl.DistanceRequest(), fcl.DistanceResult())
        return _least(placed, gaps - radius)

    return ask


def warp_cpu(environment: Environment, placed: Placed) -> Ask:
    """NVIDIA Warp on the CPU: the nearest mesh point of every centre, within reach of what is asked."""
    import warp as wp  # type: ignore[import-not-found,unused-ignore]

    from benchmarks.warp_kernels import nearest_gaps

    wp.config.quiet = True
    wp.init()
    points = wp.array(environment.vertices.astype(np.float32), dtype=wp.vec3, device="cpu")
    corners = wp.array(environment.triangles.astype(np.int32).ravel(), dtype=wp.int32, device="cpu")
    mesh = wp.Mesh(points, corners)
    count, radius = len(placed.body.radius), placed.body.radius
    reach = {"any": wp.array(radius.astype(np.float32), dtype=wp.float32, device="cpu"),
             "by segment": wp.full(count, 10.0, dtype=wp.float32, device="cpu")}  # fmt: skip
    gaps = wp.zeros(count, dtype=wp.float32, device="cpu")

    def ask(kind: str, pose: int) -> bool | Floats:
        centres = wp.array(placed.centres[pose].astype(np.float32), dtype=wp.vec3, device="cpu")
        wp.launch(nearest_gaps, dim=count, inputs=[mesh.id, centres, reach[kind], gaps], device="cpu")
        found = gaps.numpy().astype(np.float64)
        return bool(np.any(found < radius)) if kind == "any" else _least(placed, found - radius)

    return ask


PEERS: dict[str, Callable[[Environment, Placed], Ask]] = {"python-fcl": fcl_each, "warp": warp_cpu}
