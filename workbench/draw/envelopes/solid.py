"""Draw a reach envelope in three dimensions, as a see-through net over person and surroundings."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageColor, ImageDraw

from workbench.draw.camera import Camera, facing, project, standard_view
from workbench.draw.colours import Colour
from workbench.draw.disks import disks
from workbench.draw.scene import Scene
from workbench.draw.web.place_mesh import environment_mesh
from workbench.draw.web.views import WebPlace, WebView, body_view
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["envelope_image", "outer_faces", "turnable_envelope"]

_FREE_COLOUR = "#3f7fb8"
_LOST_COLOUR = "#d0453a"
_MIN_LOSS = 0.01
"""Loss of radius [m] from which a face counts as stopped short by obstacles."""
_FRONT_OPACITY = (0.10, 0.55)
_BACK_OPACITY = (0.03, 0.14)
"""Opacity of the fill and of the lines of faces that face the viewer, and of the others."""
_FINER = 2
"""How many times finer the net is drawn, for smooth edges."""


def envelope_image(envelope: Envelope, scene: Scene, view: str, *, size: int = 520) -> Image.Image:
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

    """
    camera = _camera(envelope, scene, view, size)
    picture = disks(scene, camera).convert("RGB")
    fine = picture.resize((_FINER * size, _FINER * size), Image.Resampling.NEAREST)
    _draw_net(ImageDraw.Draw(fine, "RGBA"), envelope, camera)
    return fine.reduce(_FINER)


def _camera(envelope: Envelope, scene: Scene, view: str, size: int) -> Camera:
    """Return a standard view that holds the person and the envelope."""
    points, faces = envelope.surface()
    used = points[np.unique(faces)] if len(faces) else points
    every = np.concatenate([scene.bounds, used])
    bounds = np.array([every.min(axis=0), every.max(axis=0)])
    return standard_view(view, bounds, width=size, height=size)


def _draw_net(pen: ImageDraw.ImageDraw, envelope: Envelope, camera: Camera) -> None:
    """Draw the faces of the outer boundary from far to near over a finer picture."""
    points, faces, stopped_short = outer_faces(envelope)
    corners = points[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = facing(camera, normal, np.einsum("fi,fi->f", normal, corners[:, 0])) > 0
    pixels = project(camera, points)
    depth = pixels[faces, 2].mean(axis=1)
    for face in np.argsort(depth, kind="stable"):
        colour = ImageColor.getrgb(_LOST_COLOUR if stopped_short[face] else _FREE_COLOUR)
        fill, line = (round(255 * a) for a in (_FRONT_OPACITY if front[face] else _BACK_OPACITY))
        ends = [(x, y) for x, y in (_FINER * pixels[faces[face], :2]).tolist()]
        pen.polygon(ends, fill=(*colour, fill), outline=(*colour, line))


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


_CLEAR: Colour = (63, 127, 184)
_STOPPED: Colour = (208, 69, 58)


def turnable_envelope(
    envelope: Envelope, placed: Placed, environment: Environment, *, name: str
) -> WebView:
    """Return the picture of a person and the outer boundary of what a limb reaches.

    The boundary is two parts of the place, which can be hidden by their names: where the limb comes
    clear of obstacles, and where these stop it short.

    Parameters
    ----------
    envelope
        The envelope.
    placed
        The person in one pose or several, of which the first is shown.
    environment
        The surroundings.
    name
        What the person is called.
    """
    points, faces, stopped = outer_faces(envelope)
    place = environment_mesh(environment)
    for words, colour, rows in (
        ("reach: clear of obstacles", _CLEAR, ~stopped),
        ("reach: stopped short by obstacles", _STOPPED, stopped),
    ):
        if rows.any():
            place = _with_part(place, points, faces[rows], words, colour)
    title = f"Reach envelope of {name}, {envelope.limb}"
    return WebView(title, (body_view(placed, name, "warm"),), place)


def _with_part(place: WebPlace, points: Floats, faces: Ints, name: str, colour: Colour) -> WebPlace:
    """A place with one see-through part more, all edges of which are drawn."""
    used, index = np.unique(faces, return_inverse=True)
    own = index.reshape(-1, 3) + len(place.vertices)
    ends = np.sort(np.concatenate([own[:, [0, 1]], own[:, [1, 2]], own[:, [2, 0]]]), axis=1)
    return WebPlace(
        np.concatenate([place.vertices, points[used]]),
        np.concatenate([place.part, np.full(len(used), len(place.names))]),
        np.concatenate([place.triangles, own]),
        np.concatenate([place.edges, np.unique(ends, axis=0)]),
        (*place.names, name),
        (*place.colours, colour),
        (*place.glass, True),
    )
