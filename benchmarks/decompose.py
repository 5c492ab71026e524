"""Spheres fitted to a body and its parts: figures beside their goals. `python
benchmarks/decompose.py [BODY.obj]`.

The body is scaled to 1756 mm; forearm and hand are cut from it by planes and closed flat. CPU
seconds include the search for the tolerance that gives the wanted number, not the measuring of the
result. No sphere fitter that takes a closed mesh is on PyPI to run beside it (`morphit` there is a
data parser, not the sphere optimiser of that name).
"""

from __future__ import annotations

import sys
from pathlib import Path

import manifold3d
import numpy as np
import trimesh

from workbench.body.fitting.candidates import FitBounds
from workbench.body.fitting.decompose import decompose, fewest_spheres
from workbench.body.fitting.fit_quality import fit_quality
from workbench.body.fitting.problem import Joints
from workbench.body.fitting.regions import Regions
from workbench.body.outlines import outline_surface
from workbench.body.surface import Surface, sealed
from workbench.files.meshes.reading import read_mesh
from workbench.model.arrays import Floats
from workbench.model.outlines import Outlines

BODY = (
    Path(__file__).resolve().parents[2]
    / "shared"
    / "data"
    / "bodies"
    / "makehuman_derived"
    / "adult_male.obj"
)
NO_JOINTS = Joints(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))
RADII = {"least_radius": 0.002, "greatest_radius": 0.2}
# spheres, goals: mean [mm], 95th percentile [mm], IoU, CPU seconds
GOALS = {
    ("whole adult", 400): (1.7, 4.5, 0.955, 5.0),
    ("whole adult", 1000): (0.85, None, 0.975, 12.0),
    ("forearm", 16): (1.8, None, None, 1.0),
    ("hand", 64): (0.85, None, None, None),
}


def body(path: Path) -> Surface:
    """The whole body, x forward, y left, z up, 1756 mm tall."""
    part = read_mesh(path).parts[0]
    vertices = part.vertices[:, [2, 0, 1]] * (1.756 / np.ptp(part.vertices[:, 1]))
    return sealed(vertices, part.faces, what=path.name)


def part_between(surface: Surface, first: Floats, last: Floats | None) -> Surface:
    """The piece about the line from first to last (to the end where None), cut square and closed
    flat."""
    along = (last if last is not None else first + (first - ELBOW)) - first
    unit = along / np.linalg.norm(along)
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(surface.vertices.copy(), surface.faces.astype(np.uint64))
    )
    solid = solid.trim_by_plane(tuple(unit), float(unit @ first))
    if last is not None:
        solid = solid.trim_by_plane(tuple(-unit), float(-unit @ last))
    near = min(solid.decompose(), key=lambda p: np.linalg.norm(middle(p) - (first + 0.5 * along)))
    mesh = near.to_mesh64()
    return sealed(
        np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    )


def middle(solid: manifold3d.Manifold) -> Floats:
    """(3,) the middle of the box about a solid."""
    box = np.array(solid.bounding_box())
    return 0.5 * (box[:3] + box[3:])


# joint centres of the left arm in the pose of the file [m], on a body of 1756 mm
ELBOW = np.array([0.035, 0.350, 0.384])
WRIST = np.array([0.195, 0.470, 0.250])


def main() -> None:
    """Print the table."""
    whole = body(Path(sys.argv[1]) if len(sys.argv) > 1 else BODY)
    parts = {
        "whole adult": whole,
        "forearm": part_between(whole, ELBOW, WRIST),
        "hand": part_between(whole, WRIST, None),
    }
    decompose(parts["forearm"], count=8, **RADII)  # the compiler's time is not the fit's
    print(
        f"{'':12} {'spheres':>7} {'mean':>14} {'95 %':>13} {'largest':>8} {'IoU':>14} {'CPU s':>13}   (goals; mm)"
    )
    for (name, count), (mean, p95, iou, seconds) in GOALS.items():
        q = decompose(parts[name], count=count, **RADII).quality
        told = [
            (q.mean * 1e3, mean, 2),
            (q.p95 * 1e3, p95, 1),
            (q.iou, iou, 3),
            (q.seconds, seconds, 1),
        ]
        a, b, c, d = (f"{v:.{n}f} " + (f"({g:g})" if g is not None else "") for v, g, n in told)
        print(f"{name:12} {q.spheres:7} {a:>14} {b:>13} {q.largest * 1e3:8.1f} {c:>14} {d:>13}")
    q = decompose(whole, outward=0.004, inward=0.004, **RADII).quality
    print(
        f"whole adult, proved to 4 mm both ways: {q.spheres} spheres, mean {q.mean * 1e3:.2f} mm, IoU {q.iou:.3f}, "
        f"{q.seconds:.1f} CPU s"
    )
    limits = FitBounds(0.002, 0.2, 0.004, 0.004)
    for name in ("forearm", "hand"):
        fit = decompose(parts[name], outward=0.004, inward=0.004, **RADII)
        fewest = fewest_spheres(parts[name], limits, NO_JOINTS, Regions())
        print(
            f"{name}, proved to 4 mm both ways: {len(fit.radius)} spheres, of these candidates no fewer than {fewest}"
        )
    drawn = outline_surface(sliced(whole, 0.02), pitch=0.005)
    fit = decompose(drawn, count=650, **RADII)
    q = fit_quality(whole, fit.centre, fit.radius)
    print(
        f"whole adult from outlines every 20 mm: 650 spheres, mean {q.mean * 1e3:.2f} (1.7) mm, IoU {q.iou:.3f}, "
        f"{fit.quality.seconds:.1f} CPU s"
    )


def sliced(surface: Surface, step: float) -> Outlines:
    """Outlines of a body every `step` [m] from its soles up."""
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    low = surface.vertices[:, 2].min()
    high = surface.vertices[:, 2].max()
    heights = []
    loops = []
    for z in np.concatenate([[low + 5e-4], np.arange(low + step, high, step), [high - 5e-4]]):
        rings = [np.asarray(ring)[:-1, :2] for ring in mesh.section([0, 0, 1], [0, 0, z]).discrete]
        loops += rings
        heights += [z] * len(rings)
    return Outlines("body", 2, np.array(heights), tuple(loops))


if __name__ == "__main__":
    main()
