"""The kernels that Warp compiles; it wants a file of its own whose annotations are real types.

Both ask about a ball around each segment first: its middle sphere's centre, as far as the outermost
sphere reaches. The distance found there bounds that of every other sphere, since a distance changes
by no more than the way moved (Lipschitz), and the point found is compared with every sphere before
any is asked about by itself.
"""

import warp as wp

__all__ = ["segment_gaps", "touching"]


@wp.func
def reach_of(
    centres: wp.array(dtype=wp.vec3),
    radius: wp.array(dtype=float),
    first: int,
    hub: wp.vec3,
    begin: int,
    end: int,
) -> float:
    """How far the spheres begin..end reach from a hub [m]."""
    reach = float(0.0)  # noqa: UP018, a variable that changes
    for s in range(begin, end):
        reach = wp.max(reach, wp.length(centres[first + s] - hub) + radius[s])
    return reach


@wp.kernel
def segment_gaps(
    mesh: wp.uint64,
    centres: wp.array(dtype=wp.vec3),
    radius: wp.array(dtype=float),
    start: wp.array(dtype=int),
    middle: wp.array(dtype=int),
    gaps: wp.array(dtype=float),
):
    """Clearance of each segment of each pose from the mesh: no sphere looks farther than the
    nearest before it, and none is asked about that the nearest distance so far rules out."""
    i = wp.tid()
    segments = start.shape[0] - 1
    first = (i / segments) * radius.shape[0]
    segment = i % segments
    begin = start[segment]
    end = start[segment + 1]
    least = float(1.0e9)  # noqa: UP018, a variable that changes
    if begin < end:
        hub = centres[first + middle[segment]]
        free = float(0.0)  # noqa: UP018, a variable that changes
        found = wp.mesh_query_point_no_sign(mesh, hub, 1.0e9)
        if found.result:
            point = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
            free = wp.length(hub - point)
            for s in range(begin, end):
                least = wp.min(least, wp.length(centres[first + s] - point) - radius[s])
        for s in range(begin, end):
            centre = centres[first + s]
            reach = least + radius[s]
            if reach > 0.0 and free - wp.length(centre - hub) < reach:
                hub = centre
                free = reach
                found = wp.mesh_query_point_no_sign(mesh, centre, reach)
                if found.result:
                    point = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
                    free = wp.length(centre - point)
                    least = wp.min(least, free - radius[s])
    gaps[i] = least


@wp.kernel
def touching(
    mesh: wp.uint64,
    centres: wp.array(dtype=wp.vec3),
    radius: wp.array(dtype=float),
    start: wp.array(dtype=int),
    middle: wp.array(dtype=int),
    hit: wp.array(dtype=int),
):
    """Whether each pose touches the mesh: a segment whose ball holds no surface is passed over, and
    nothing is asked after the first sphere that touches."""
    p = wp.tid()
    first = p * radius.shape[0]
    touches = int(0)  # noqa: UP018, RUF046, a variable that changes
    for segment in range(start.shape[0] - 1):
        begin = start[segment]
        end = start[segment + 1]
        if touches == 0 and begin < end:
            hub = centres[first + middle[segment]]
            reach = reach_of(centres, radius, first, hub, begin, end)
            found = wp.mesh_query_point_no_sign(mesh, hub, reach)
            if found.result:
                point = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
                free = wp.length(hub - point)
                for s in range(begin, end):
                    if wp.length(centres[first + s] - point) < radius[s]:
                        touches = 1
                for s in range(begin, end):
                    centre = centres[first + s]
                    if touches == 0 and free - wp.length(centre - hub) < radius[s]:
                        # as far as twice the sphere: what is free there rules out its neighbours
                        free = 2.0 * radius[s]
                        hub = centre
                        one = wp.mesh_query_point_no_sign(mesh, centre, free)
                        if one.result:
                            point = wp.mesh_eval_position(mesh, one.face, one.u, one.v)
                            free = wp.length(centre - point)
                            if free < radius[s]:
                                touches = 1
    hit[p] = touches
