"""Draw a reach envelope in three dimensions, as a see-through net over person and surroundings."""

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

__all__ = ["VIEWS", "envelope_view", "outer_faces"]

VIEWS = ("three_quarter", "left", "front", "top")
"""The standard views of a report."""
_FREE_COLOUR = "#3f7fb8"
_LOST_COLOUR = "#d0453a"
_MIN_LOSS = 0.01
"""Loss of radius [m] from which a face counts as stopped short by obstacles."""
_FRONT_OPACITY = (0.16, 0.75)
_BACK_OPACITY = (0.05, 0.22)
"""Opacity of the fill and of the lines of faces that face the viewer, and of the others."""


def envelope_view(envelope: Envelope, scene: Scene, view: str, *, size: int = 520) -> str:
    """Draw a scene with the outer boundary of an envelope over it.

    The boundary is blue where the limb comes clear of obstacles, and red where they stop it short.

    Parameters
    ----------
    envelope, scene
        The envelope, and the person in the surroundings.
    view
        Name of a standard view.
    size
        Width and height of the picture [pixels].

    Returns
    -------
    str
        SVG text.
    """
    camera = _camera(envelope, scene, view, size)
    image = io.BytesIO()
    disks(scene, camera).save(image, "PNG")
    text = base64.b64encode(image.getvalue()).decode("ascii")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" width="{size}" role="img" '
        f'aria-label="{escape(scene.title)}: {view.replace("_", " ")}">'
        f'<image width="{size}" height="{size}" href="data:image/png;base64,{text}"/>{_net(envelope, camera)}</svg>'
    )


def _camera(envelope: Envelope, scene: Scene, view: str, size: int) -> Camera:
    """Return a standard view that holds the person and the envelope."""
    points, faces = envelope.surface()
    used = points[np.unique(faces)] if len(faces) else points
    every = np.concatenate([scene.bounds, used])
    bounds = np.array([every.min(axis=0), every.max(axis=0)])
    return standard_view(view, bounds, width=size, height=size)


def _net(envelope: Envelope, camera: Camera) -> str:
    """Draw the faces of the outer boundary from far to near."""
    points, faces, stopped_short = outer_faces(envelope)
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = facing(camera, normal, np.einsum("fi,fi->f", normal, corners[:, 0])) > 0
    pixels = project(camera, points)
    depth = pixels[faces, 2].mean(axis=1)
    paths = []
    for face in np.argsort(depth, kind="stable"):
        colour = _LOST_COLOUR if stopped_short[face] else _FREE_COLOUR
        fill, line = _FRONT_OPACITY if front[face] else _BACK_OPACITY
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in pixels[faces[face], :2])
        paths.append(
            f'<path d="M{text}Z" fill="{colour}" '
            f'fill-opacity="{fill}" stroke="{colour}" stroke-opacity="{line}" stroke-width="0.7"/>'
        )
    return "".join(paths)


def outer_faces(envelope: Envelope) -> tuple[Floats, Ints, Bools]:
    """Find the outer boundary clear of obstacles.

    Returns
    -------
    tuple[Floats, Ints, Bools]
        Corners (V, 3) [m], triangles (F, 3), and whether (F,) obstacles stop it short.
    """
    about = envelope.about
    outer, _, reached = about.bounds(clear=envelope.obstacles)
    points = envelope.origin + outer[:, None] * about.direction
    short = np.asarray(about.reached & (~reached | (outer < about.outer - _MIN_LOSS)))
    kept = envelope.triangles[reached[envelope.triangles].all(axis=1)]
    return points, kept, np.any(short[kept], axis=1)
