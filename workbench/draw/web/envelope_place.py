"""The turnable picture of a reach envelope: its outer boundary as see-through parts of the place."""

from __future__ import annotations

import numpy as np

from workbench.draw.colours import Colour
from workbench.draw.envelopes.solid import outer_faces
from workbench.draw.web.place_mesh import environment_mesh
from workbench.draw.web.views import WebPlace, WebView, body_view
from workbench.model.arrays import Floats, Ints
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["turnable_envelope"]

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
