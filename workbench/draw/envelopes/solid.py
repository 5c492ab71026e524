"""A reach envelope in the round: its outer boundary as a see-through net over the person and the
surroundings."""

from __future__ import annotations

import base64
import io
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera, facing, project, standard_view
from workbench.draw.disks import disks
from workbench.draw.scene import Scene
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.envelope import Envelope

__all__ = ["VIEWS", "envelope_view"]

VIEWS = ("three_quarter", "left", "front", "top")
_WHOLE, _LOST = "#3f7fb8", "#d0453a"


def envelope_view(envelope: Envelope, scene: Scene, view: str, *, size: int = 520) -> str:
    """SVG text, `size` pixels square, of a standard view: the scene, and over it the outer
    boundary, blue where the limb comes clear of obstacles, red where they stop it short."""
    camera = _camera(envelope, scene, view, size)
    image = io.BytesIO()
    disks(scene, camera).save(image, "PNG", optimize=True)
    text = base64.b64encode(image.getvalue()).decode("ascii")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" width="{size}" role="img" '
        f'aria-label="{escape(scene.title)}: {view.replace("_", " ")}">'
        f'<image width="{size}" height="{size}" href="data:image/png;base64,{text}"/>{_net(envelope, camera)}</svg>'
    )


def _camera(envelope: Envelope, scene: Scene, view: str, size: int) -> Camera:
    """A view that holds the person and the envelope."""
    points, faces = envelope.surface()
    reach = points[np.unique(faces)] if len(faces) else points
    bounds = np.concatenate([scene.bounds, [reach.min(axis=0), reach.max(axis=0)]])
    return standard_view(
        view, np.array([bounds.min(axis=0), bounds.max(axis=0)]), width=size, height=size
    )


def _net(envelope: Envelope, camera: Camera) -> str:
    """The faces of the outer boundary from far to near."""
    points, faces, short = _faces(envelope)
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    toward = facing(camera, normal, np.einsum("fi,fi->f", normal, corners[:, 0])) > 0
    seen = project(camera, points)
    depth = seen[faces, 2].mean(axis=1)
    drawn = []
    for face in np.argsort(depth, kind="stable"):
        colour = _LOST if short[face] else _WHOLE
        fill, line = (0.16, 0.75) if toward[face] else (0.05, 0.22)
        drawn.append(
            f'<path d="M{" ".join(f"{x:.1f},{y:.1f}" for x, y in seen[faces[face], :2])}Z" fill="{colour}" '
            f'fill-opacity="{fill}" stroke="{colour}" stroke-opacity="{line}" stroke-width="0.7"/>'
        )
    return "".join(drawn)


def _faces(envelope: Envelope) -> tuple[Floats, Ints, Bools]:
    """Corners (V, 3) [m] and triangles (F, 3) of the outer boundary clear of obstacles, and whether
    (F,) obstacles stop it short of where it would be."""
    about = envelope.about
    triangles = envelope.triangles
    outer, _, reached = about.bounds(clear=envelope.obstacles)
    points = envelope.origin + outer[:, None] * about.direction
    short = np.asarray(about.reached & (~reached | (outer < about.outer - 0.01)))
    kept = triangles[reached[triangles].all(axis=1)]
    return points, kept, np.any(short[kept], axis=1)
