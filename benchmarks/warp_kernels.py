"""The kernel that Warp compiles; it wants a file of its own whose annotations are real types."""

import warp as wp

__all__ = ["nearest_gaps"]


@wp.kernel
def nearest_gaps(
    mesh: wp.uint64,
    centres: wp.array(dtype=wp.vec3),
    reach: wp.array(dtype=float),
    gaps: wp.array(dtype=float),
):
    """Distance of each centre to the mesh, 1e9 where it is beyond reach."""
    i = wp.tid()
    found = wp.mesh_query_point_no_sign(mesh, centres[i], reach[i])
    gaps[i] = 1.0e9
    if found.result:
        gaps[i] = wp.length(centres[i] - wp.mesh_eval_position(mesh, found.face, found.u, found.v))
