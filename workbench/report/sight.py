"""The section of a page on what people see: each criterion of sight as whoever comes nearest to missing
it sees it, then what every direction shows, and the ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from workbench.draw.chart import Chart, chart_svg
from workbench.draw.directions import Outlook, direction_chart
from workbench.draw.disks import disks
from workbench.draw.eye_view import eyes_camera, onlooker, outlook, ruled, without_head
from workbench.draw.ground_plan import ground_level, ground_plan, mirror_plan
from workbench.draw.scene import Mark, Scene
from workbench.draw.two_eyes import both_eyes
from workbench.draw.web.snippet import picture_address
from workbench.errors import InputError, UsageError
from workbench.model.criterion import Criterion, Finding
from workbench.model.environment import Environment
from workbench.model.units import UNITS, plain
from workbench.report.section import Section
from workbench.report.sentences import finding_words
from workbench.report.templates import template
from workbench.sight.eyes import Eyes, gaze, given_eyes
from workbench.sight.regions import Region, azimuth_elevation, cone
from workbench.sight.rules.mirrors import looked_through
from workbench.sight.scenery import scenery_of
from workbench.study.checks.sight_rules import (
    asked_ground,
    eye_points_of,
    field_of,
    pillar_of,
    rules_of,
    source_of,
)

__all__ = ["Beheld", "Glimpse", "sight_sections"]

_OF_SEATS = ("pillar", "forward_field")
"""Checks that are asked from points of a rule, whoever sits there."""
_LOOKED = ("sees", "reads")
"""Checks of things that eyes and head turn to."""
_MOST = 2
"""People in cases who are drawn beside what is asked."""
_OPEN = 3
"""Pictures that are open; the others are folded."""
_WIDTH = 720
_HEIGHT = 600
"""Size of a chart [pixels]."""
_FIELD = math.radians(50.0)
"""Angle of view [rad] of a picture of what is looked at."""
_STRIP = math.radians(4.0)
"""Half the width [rad] of the strip that shows how far down the view ahead is asked for."""
_FINE = 181
"""Points of the lower end of the forward field."""


class Beheld(NamedTuple):
    """Somebody in a scene: whose eyes they are, the people of the scene, in words which case, and the
    seat."""

    scene: Scene
    people: tuple[str, ...]
    name: str
    words: str
    seat: str = ""


class Glimpse(NamedTuple):
    """What is measured of a criterion of sight where it comes nearest to being missed, by whom, and the
    environment with its seats in their reference positions, which points of it look at."""

    criterion: Criterion
    finding: Finding
    beheld: Beheld
    environment: Environment

    @property
    def spare(self) -> float:
        """What is to spare, as it counts beside lengths [m]."""
        return UNITS[self.finding.unit].counts * self.finding.margin

    @property
    def looks(self) -> Beheld:
        """Who looks: the person, or a point that is asked instead."""
        point = self.criterion.eye_point
        if not point:
            return self.beheld
        seat = self.beheld.seat
        return Beheld(Scene((), self.environment), (), point, f"from {plain(point)}", seat)

    @property
    def caption(self) -> str:
        """ "“outline, own eyes”, nearest to missing it: a woman of 1,512 mm (female 31), flying: 95.3 % of
        the outline is clear, ..."."""
        way = "nearest to missing it" if self.finding.margin >= 0.0 else "farthest from meeting it"
        if self.criterion.eye_point or self.criterion.check in _OF_SEATS:
            way = "the same for everybody"
        who = "" if self.criterion.check in _OF_SEATS else f" {self.looks.words}:"
        words = finding_words(self.criterion.check, self.finding)
        both = (
            "; the pictures of both eyes are drawn over one another"
            if self.criterion.check in _LOOKED
            else ""
        )
        return f"“{plain(self.criterion.name)}”, {way}:{who} {words}{both}."


def sight_sections(
    glimpses: Sequence[Glimpse], beheld: Sequence[Beheld], *, end: str = ""
) -> list[Section]:
    """The pictures of what people see, where a criterion asks about it; nothing else.

    Parameters
    ----------
    glimpses
        Of each criterion of sight. What is nearest to its limit comes first; all but a few are folded.
    beheld
        Who else sees what. Some are drawn, the others are counted.
    end
        The end of the anchor.
    """
    if not glimpses:
        return []
    drawn = beheld or [one.beheld for one in glimpses[:1]]
    figures = [_figure(one) for one in sorted(glimpses, key=lambda one: one.spare)]
    figures += [figure for one in drawn[:_MOST] for figure in _around(one)]
    html = template("sight.html.j2").render(
        figures=figures, open=_OPEN, more=max(len(drawn) - _MOST, 0)
    )
    return [Section("questions", f"sight{end}", "What is seen", Markup(html))]


def _figure(one: Glimpse) -> dict[str, Any]:
    """The picture of a criterion; in words what cannot be drawn."""
    try:
        return {"svg": _PICTURES[one.criterion.check](one), "caption": one.caption}
    except (InputError, UsageError) as error:
        return {"svg": "", "caption": f"{one.caption} It cannot be drawn: {error}"}


def _around(one: Beheld) -> Iterator[dict[str, Any]]:
    """What every direction shows one person, and the ground where its height is known."""
    try:
        seen = outlook(one.scene, one.people, one.name)
        every = direction_chart(seen, "equal_area", width=_WIDTH, height=_HEIGHT)
        yield {"svg": _svg(every), "caption": f"Every direction: {one.words}."}
        environment = one.scene.environment
        if environment is not None and "ground" in environment.points:
            plan = ground_plan(seen, ground_level(environment), width=_WIDTH, height=_HEIGHT)
            yield {"svg": _svg(plan), "caption": f"The ground: {one.words}."}
    except (InputError, UsageError) as error:
        yield {"svg": "", "caption": f"{one.words}: {error}"}


def _svg(chart: Chart) -> Markup:
    return Markup(chart_svg(chart))


def _polar(seen: Outlook) -> Markup:
    return _svg(direction_chart(seen, "polar", width=_WIDTH, height=_HEIGHT))


def _seen(one: Glimpse) -> Outlook:
    """What is seen by the eyes that a criterion is about."""
    return outlook(one.looks.scene, one.looks.people, one.looks.name)


def _outline(one: Glimpse) -> Markup:
    """The outline of a criterion over what is seen."""
    return _polar(ruled(_seen(one), rules_of(one.criterion), one.criterion.side))


def _nose(one: Glimpse) -> Markup:
    """A strip from level down as far as is asked over what is seen."""
    seen = _seen(one)
    down = max(one.criterion.down, math.radians(1.0))
    corners = np.array([[1, 0], [-1, 0], [-1, -down / _STRIP], [1, -down / _STRIP]]) * _STRIP
    name = f"the strip from level {math.degrees(down):g} degrees down"
    return _polar(replace(seen, rule=Region(name, seen.axes, corners=corners)))


def _thing(one: Glimpse) -> Markup:
    """What is looked at, by both eyes, with the head turned to it."""
    scene, point = one.looks.scene, one.finding.point
    assert point is not None
    who = onlooker(scene, one.looks.people, one.looks.name)
    eyes = gaze(who.eyes, point, trunk=one.criterion.trunk).eyes
    target = np.array(point)
    camera = eyes_camera(eyes, "both_eyes", target, field=_FIELD, width=_WIDTH, height=_HEIGHT)
    shown = replace(without_head(scene, who.body), marks=(Mark(point, plain(one.finding.subject)),))
    image = both_eyes(shown, camera, partial(disks, mode="shaded", veil=1.0))
    return Markup('<img alt="{}" src="{}">').format(one.caption, picture_address(image))


def _from_points(
    one: Glimpse, eyes: Eyes, name: str, rule: Region, exempt: Sequence[str]
) -> Markup:
    """What eyes that a rule gives see, without the parts that it exempts."""
    items = [one.environment.part_index(part) for part in exempt]
    scenery = looked_through(scenery_of(one.environment), items)
    return _polar(Outlook(name, scenery, tuple(one.environment.parts), eyes, np.eye(3), rule))


def _pillar(one: Glimpse) -> Markup:
    """The angle of a pillar from the eyes that the rule turns to it."""
    found = pillar_of(one.environment, one.criterion, one.beheld.seat)
    ends = azimuth_elevation(np.stack([found.outer, found.inner]) - found.eyes)
    corners = np.stack([ends[[0, 1, 1, 0], 0], ends[[0, 0, 1, 1], 1]], axis=1)
    eyes = given_eyes(
        found.eyes.mean(axis=0),
        ahead=(math.cos(found.turn), math.sin(found.turn), 0.0),
        spacing=float(np.linalg.norm(found.eyes[0] - found.eyes[1])),
    )
    around = cone("20 degrees about the pillar", found.outer - found.eyes[0], math.radians(20.0))
    rule = Region("the angle that is measured", corners=corners) if found.angle else around
    return _from_points(one, eyes, "the eyes that the rule turns to the pillar", rule, ())


def _field(one: Glimpse) -> Markup:
    """The forward field from V2."""
    criterion = one.criterion
    points = eye_points_of(one.environment, criterion, one.beheld.seat)
    found = field_of(one.environment, criterion, one.beheld.seat)
    side = np.linspace(-math.pi / 2.0, math.pi / 2.0, _FINE)
    along = np.maximum(np.cos(side), np.abs(np.sin(side)))
    fall = -np.arctan(np.tan(rules_of(criterion).number("field_fall")) * along)
    below = np.append(np.stack([side, fall], axis=1), [[side[-1], 0.0], [side[0], 0.0]], axis=0)
    exempt = (criterion.wheel + criterion.inside_wheel) * found.wheel_allowed + criterion.parts
    rule = Region("the field below level", corners=below)
    return _from_points(one, given_eyes(points["v2"], spacing=0.0), "V2", rule, exempt)


def _mirrors(one: Glimpse) -> Markup:
    """The ground in the mirrors of a criterion."""
    criterion, seen = one.criterion, _seen(one)
    eye = seen.eyes.middle[0]
    mirrors = [one.environment.mirror(name) for name in criterion.mirrors]
    fields = dict.fromkeys(f"field_{mirror.field}" for mirror in mirrors)
    plan = mirror_plan(
        seen,
        one.environment,
        one.environment.points[criterion.ground][2],
        required={
            mirror.name: asked_ground(one.environment, criterion, mirror, eye) for mirror in mirrors
        },
        source=source_of(criterion, *fields),
        width=_WIDTH,
        height=_HEIGHT,
    )
    return _svg(plan)


_PICTURES: dict[str, Callable[[Glimpse], Markup]] = {
    "sees": _thing,
    "reads": _thing,
    "over_nose": _nose,
    "outline": _outline,
    "reflection": _outline,
    "pillar": _pillar,
    "forward_field": _field,
    "mirror": _mirrors,
}
"""How the criteria of sight are drawn, by their checks."""
