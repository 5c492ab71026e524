"""What a notebook shows of an environment, a placed body and a result: turnable pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import singledispatch
from typing import Any

from workbench.draw.scene import Scene, SceneBody
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.web.case_view import case_view
from workbench.draw.web.motion_view import motion_view
from workbench.draw.web.snippet import frame_html
from workbench.draw.web.views import WebView, scene_view
from workbench.errors import UsageError
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.result import PopulationFound, PosturesFound, Result

__all__ = ["notebook_html", "notebook_views", "view"]

_MOST = 6
"""Pictures of a result below each other; those of failing cases come first."""
_NEAR = 0.12
"""Largest distance [m] that has a dimension line though no criterion fails there."""
_MOST_POSES = 8
"""Poses below each other."""
_MOST_CHOSEN = 100
"""Poses that a widget lets choose from."""


def view(
    thing: Environment | Placed | Result,
    *,
    people: Placed | Mapping[str, Placed] | None = None,
    height: int = 480,
) -> Any:
    """Show something in a notebook as a picture that can be turned and that Python can change.

    Nothing is fetched from anywhere: script and data go through the notebook's own connection.

    Parameters
    ----------
    thing
        An environment; a placed body, each pose a picture; a result, each case a picture.
    people
        Who stands in the environment: a placed body or several by their names, each pose a person.
    height
        Of the picture [pixels].

    Returns
    -------
    PictureWidget
        A widget with `people`, `hidden`, `selected`, `look_from`, `section`, `see_through_walls`,
        `picture` and `height`, all of which can be set. See `draw.web.widget.PictureWidget`.

    Raises
    ------
    MissingPartError
        If anywidget is not installed.
    UsageError
        If there is nothing to be drawn, or there are too many pictures to choose from.
    """
    from workbench.draw.web.widget import PictureWidget

    if isinstance(thing, Placed) and len(thing) > _MOST_CHOSEN:
        raise UsageError(
            f"thing: {len(thing)} poses; a view takes {_MOST_CHOSEN} at most: place fewer"
        )
    views = notebook_views(thing, None)
    if not views:
        raise UsageError(f"thing: nothing of {thing!r} can be drawn")
    fixed = (
        "those of a result are as they were measured; "
        "view its environment instead: wb.view(result.postures[0].environment, people=...)"
    )
    return PictureWidget(
        views, people=people, height=height, fixed=fixed if isinstance(thing, Result) else ""
    )


def notebook_html(noun: object) -> str | None:
    """Return what a notebook shows of a noun; None where there is nothing to be drawn."""
    views = notebook_views(noun, _MOST_POSES if isinstance(noun, Placed) else _MOST)
    return frame_html(*views) if views else None


@singledispatch
def notebook_views(noun: object, most: int | None) -> list[WebView]:
    """Return the turnable pictures of a noun, so many at most; none of one that has no picture."""
    return []


@notebook_views.register
def _environment_views(noun: Environment, most: int | None) -> list[WebView]:
    return [WebView(noun.name, environment=noun)] if not noun.hidden.all() else []


@notebook_views.register
def _placed_views(noun: Placed, most: int | None) -> list[WebView]:
    """Poses would stand in each other: each is a picture of its own."""
    bodies = [SceneBody(noun, pose) for pose in range(len(noun))[:most]]
    several = len(noun) > 1
    titles = [
        f"{noun.body.name}, pose {k + 1} of {len(noun)}" if several else noun.body.name
        for k in range(len(bodies))
    ]
    return [
        scene_view(Scene((body,), title=title))
        for body, title in zip(bodies, titles, strict=True)
        if noun.window.any()
    ]


@notebook_views.register
def _result_views(noun: Result, most: int | None) -> list[WebView]:
    views = [view for found in noun.postures for view in _cases(found)]
    views += [
        (motion.passed, motion_view(motion, PEOPLE_COLOURS[k % len(PEOPLE_COLOURS)]))
        for k, motion in enumerate(noun.motions)
    ]
    ordered = [view for _, view in sorted(views, key=lambda pair: pair[0])]
    if noun.population is not None:
        ordered += _hardest(noun.population)
    return ordered[:most]


def _cases(found: PosturesFound) -> list[tuple[bool, WebView]]:
    """Whether each case passed, and its picture."""
    views = []
    for case, name in enumerate(found.cases):
        breaches = [
            finding
            for verdict in found.verdicts
            for finding in verdict.breaches
            if finding.case == name
        ]
        placed = [finding for finding in breaches if finding.point is not None]
        views.append((not breaches, case_view(found, case, placed[:12], within=_NEAR)))
    return views


def _hardest(population: PopulationFound) -> list[WebView]:
    return [
        replace(
            scene_view(Scene((SceneBody(shown.placed),), shown.environment)),
            title=f"{population.requirements[shown.requirement].name} is not met",
        )
        for shown in population.shown
    ]
