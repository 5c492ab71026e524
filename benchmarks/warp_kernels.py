"""The kernels that Warp compiles; it wants a file of its own whose annotations are real types."""

import warp as wp

__all__ = ["segment_gaps", "touching"]


@wp.kernel
def segment_gaps(
    mesh: wp.uint64,
    centres: wp.array(dtype=wp.vec3),
    radius: wp.array(dtype=float),
    start: wp.array(dtype=int),
    gaps: wp.array(dtype=float),
):
    """Clearance of each segment of each pose from the mesh: no sphere looks farther than the
    nearest before it."""
    i = wp.tid()
    segments = start.shape[0] - 1
    first = (i / segments) * radius.shape[0]
    segment = i % segments
    least = float(1.0e9)  # noqa: UP018, a variable that changes
    for s in range(start[segment], start[segment + 1]):
        reach = least + radius[s]
        if reach > 0.0:
            centre = centres[first + s]
            found = wp.mesh_query_point_no_sign(mesh, centre, reach)
            if found.result:
                point = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
                least = wp.min(least, wp.length(centre - point) - radius[s])
    gaps[i] = least


@wp.kernel
def touching(
    mesh: wp.uint64,
    centres: wp.array(dtype=wp.vec3),
    radius: wp.array(dtype=float),
    hit: wp.array(dtype=int),
):
    """Whether each pose touches the mesh: no sphere looks farther than its radius, none after the
    first that touches."""
    p = wp.tid()
    spheres = radius.shape[0]
    found = int(0)  # noqa: UP018, RUF046, a variable that changes
    for s in range(spheres):
        if found == 0:
            query = wp.mesh_query_point_no_sign(mesh, centres[p * spheres + s], radius[s])
            if query.result:
                found = 1
    hit[p] = found
