"""A picture of two states with a slider that wipes from the one to the other: two motions, two
cases, before and after a change."""

from __future__ import annotations

from dataclasses import dataclass, replace

from markupsafe import Markup

from workbench.draw.scene import Scene
from workbench.draw.views import four_views
from workbench.draw.web.case_view import compared_view
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import STILL, pair_html
from workbench.draw.web.views import WebView
from workbench.report.turnable import still_picture

__all__ = ["TwoStates", "two_states"]


@dataclass(frozen=True, eq=False)
class TwoStates:
    """Two states of the same people or place.

    Parameters
    ----------
    views
        Either state as it is turned.
    scenes
        Either state as it is drawn where nothing can be turned.
    names
        What the states are called.
    title
        What both show.
    said
        The still pictures in words.
    caption
        What stands below them.
    side
        The view that the pictures begin with: left, right, front, back, top or corner.
    """

    views: tuple[WebView, WebView]
    scenes: tuple[Scene, Scene]
    names: tuple[str, str]
    title: str
    said: str
    caption: str
    side: str = "left"


def two_states(shown: TwoStates, packing: Packing) -> Markup:
    """Return the place of a picture of two states.

    packing: the pictures of the page; one is added.
    """
    one, two = shown.views
    view = compared_view(one, two, names=shown.names, title=shown.title)
    index = packing.add(replace(view, look_from=shown.side))
    first, second = shown.scenes
    every = replace(first, bodies=first.bodies + second.bodies)
    camera = dict(four_views(every, width=STILL, height=STILL))[shown.side]
    stills = (still_picture(first, camera), still_picture(second, camera))
    return Markup(
        pair_html(index, stills=stills, names=shown.names, alt=shown.said, caption=shown.caption)
    )
