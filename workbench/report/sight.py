"""The section of a page on what people see: what every direction shows them, and the ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from markupsafe import Markup

from workbench.draw.chart import Chart, chart_svg
from workbench.draw.directions import Outlook, direction_chart
from workbench.draw.eye_view import outlook, ruled
from workbench.draw.ground_plan import ground_level, ground_plan
from workbench.draw.mirror_plan import mirror_plan
from workbench.draw.scene import Scene
from workbench.errors import InputError, UsageError
from workbench.model.criterion import Criterion
from workbench.model.figures import plain
from workbench.report.section import Section
from workbench.report.templates import template
from workbench.study.checks.sight_rules import asked_ground

__all__ = ["Beheld", "sight_sections"]

_CHECKS = frozenset(
    {
        "sees",
        "reads",
        "over_nose",
        "outline",
        "pillar",
        "forward_field",
        "mirror",
        "reflection",
    }
)
"""Checks of what people see, whose results have this section."""
_MOST = 2
"""People in cases that are drawn."""
_WIDTH = 900
_HEIGHT = 760
"""Size of a chart [pixels]."""


class Beheld(NamedTuple):
    """Somebody in a scene: whose eyes they are, the people of the scene, and in words which case."""

    scene: Scene
    people: tuple[str, ...]
    name: str
    words: str


def sight_sections(
    criteria: Sequence[Criterion], beheld: Sequence[Beheld], *, end: str = ""
) -> list[Section]:
    """The charts of what people see, where a criterion asks about it; nothing else.

    Parameters
    ----------
    criteria
        Of the study.
    beheld
        Who sees what. Some are drawn, the others are counted.
    end
        The end of the anchor.
    """
    asked = [one for one in criteria if one.check in _CHECKS]
    # what is asked from a point is the same whoever sits there: once
    own = [one for one in asked if not one.eye_point]
    figures = [
        figure
        for k, one in enumerate(beheld[: _MOST if asked else 0])
        for figure in _figures(one, own if k else asked)
    ]
    if not figures:
        return []
    html = template("sight.html.j2").render(figures=figures, more=max(len(beheld) - _MOST, 0))
    return [Section("questions", f"sight{end}", "What is seen", Markup(html))]


def _figures(one: Beheld, asked: Sequence[Criterion]) -> Iterator[dict[str, object]]:
    """The charts of one person; in words what cannot be drawn."""
    try:
        seen = outlook(one.scene, one.people, one.name)
        yield _figure(one.words, direction_chart(seen, "equal_area", width=_WIDTH, height=_HEIGHT))
        for criterion in asked:
            if criterion.check == "outline":
                yield _figure(_about(one, criterion), _outline(one, seen, criterion))
        environment = one.scene.environment
        if environment is not None and "ground" in environment.points:
            plan = ground_plan(seen, ground_level(environment), width=_WIDTH, height=_HEIGHT)
            yield _figure(one.words, plan)
        for criterion in asked:
            if criterion.check == "mirror" and environment is not None:
                yield _figure(_about(one, criterion), _mirrors(one, seen, criterion))
    except (InputError, UsageError) as error:
        yield {"svg": "", "caption": f"{one.words}: {error}"}


def _about(one: Beheld, criterion: Criterion) -> str:
    """From where a criterion is drawn, and its name: "pilot, flying: outline"."""
    lead = f"from {plain(criterion.eye_point)}" if criterion.eye_point else one.words
    return f"{lead}: {criterion.name}"


def _mirrors(one: Beheld, seen: Outlook, criterion: Criterion) -> Chart:
    """The ground in the mirrors of a criterion, from the eyes that it is about."""
    environment = one.scene.environment
    assert environment is not None
    assert criterion.rule_set is not None
    if criterion.eye_point:
        seen = outlook(Scene((), environment), (), criterion.eye_point)
    eye = seen.eyes.middle[0]
    mirrors = [environment.mirror(name) for name in criterion.mirrors]
    return mirror_plan(
        seen,
        environment,
        environment.points[criterion.ground][2],
        required={
            mirror.name: asked_ground(environment, criterion, mirror, eye) for mirror in mirrors
        },
        source=criterion.rule_set.told(
            *dict.fromkeys(f"field_{mirror.field}" for mirror in mirrors)
        ),
        width=_WIDTH,
        height=_HEIGHT,
    )


def _outline(one: Beheld, seen: Outlook, criterion: Criterion) -> Chart:
    """The outline of a criterion over what is seen from the eyes that it is about."""
    if criterion.eye_point:
        seen = outlook(Scene((), one.scene.environment), (), criterion.eye_point)
    assert criterion.rule_set is not None
    over = ruled(seen, criterion.rule_set, criterion.side)
    return direction_chart(over, "polar", width=_WIDTH, height=_HEIGHT)


def _figure(words: str, chart: Chart) -> dict[str, object]:
    return {"svg": Markup(chart_svg(chart)), "caption": words}
