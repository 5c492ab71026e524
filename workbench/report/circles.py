"""The vector display of the paper: a circle for each sphere."""

from __future__ import annotations

from dataclasses import replace

from markupsafe import Markup

from workbench.draw.lines.circles import circles
from workbench.draw.lines.svg import compacted
from workbench.draw.scene import Scene
from workbench.draw.views import four_views

__all__ = ["circle_figure"]

_SIZE = 520
"""[pixels] Width and height."""


def circle_figure(scene: Scene, words: str) -> Markup:
    """Return the people of a scene from the corner as a figure, each sphere as its circle, stronger the
    nearer.

    words: what is shown, before "corner view".
    """
    people = replace(
        scene,
        environment=None,
        marks=(),
        description="a circle for each sphere, stronger the nearer",
    )
    camera = dict(four_views(people, width=_SIZE, height=_SIZE))["corner"]
    return Markup(
        '<figure class="drawing">{}<figcaption>{}, corner view: each sphere as its circle, stronger '
        "the nearer, as in the vector display of Badler, O’Rourke and Toltzis</figcaption></figure>"
    ).format(Markup(compacted(circles(people, camera))), words)
