"""What a notebook shows of an environment, a placed body and a result: turnable pictures."""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch

from workbench.draw.scene import Scene, SceneBody
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.web.case_view import case_view
from workbench.draw.web.motion_view import motion_view
from workbench.draw.web.snippet import frame_html
from workbench.draw.web.views import WebView, scene_view
from workbench.model.environment import Environment
from workbench.model.population_found import PopulationFound
from workbench.model.poses import Placed
from workbench.model.result import PosturesFound, Result

__all__ = ["notebook_html", "notebook_views"]

_MOST = 6
"""Pictures of a result; those of failing cases come first."""
_NEAR = 0.12
"""Largest distance [m] that has a dimension line though no criterion fails there."""
_MOST_POSES = 8


def notebook_html(noun: object) -> str | None:
    """Return what a notebook shows of a noun; None where there is nothing to be drawn."""
    views = notebook_views(noun)
    return frame_html(*views) if views else None


@singledispatch
def notebook_views(noun: object) -> list[WebView]:
    """Return the turnable pictures of a noun; none of one that has no picture."""
    return []


@notebook_views.register
def _environment_views(noun: Environment) -> list[WebView]:
    return [WebView(noun.name, environment=noun)] if not noun.hidden.all() else []


@notebook_views.register
def _placed_views(noun: Placed) -> list[WebView]:
    """The first poses side by side would stand in each other: each is a picture of its own."""
    bodies = [SceneBody(noun, pose) for pose in range(min(len(noun), _MOST_POSES))]
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
def _result_views(noun: Result) -> list[WebView]:
    views = [view for found in noun.postures for view in _cases(found)]
    views += [
        (motion.passed, motion_view(motion, PEOPLE_COLOURS[k % len(PEOPLE_COLOURS)]))
        for k, motion in enumerate(noun.motions)
    ]
    ordered = [view for _, view in sorted(views, key=lambda pair: pair[0])]
    if noun.population is not None:
        ordered += _hardest(noun.population)
    return ordered[:_MOST]


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
