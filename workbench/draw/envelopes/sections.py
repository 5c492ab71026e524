"""Sections of a reach envelope as SVG: level ones, and the two upright ones through the seat
reference point.

Nested areas show how far reach is easy, moderate and possible at all, hatching what obstacles take;
the surroundings are drawn as the section's plane cuts them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from xml.sax.saxutils import escape

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.ray_reach import RayReach

__all__ = ["AREAS", "LEGEND", "envelope_sections"]

AREAS = {"easy": "#7fbb9f", "moderate": "#c4e0d0", "at the limit": "#eceff3"}
LEGEND = (*AREAS.items(), ("lost to obstacles", "#e0746a"))
_OUTER, _INNER, _WALL = "#143a7a", "#7a3a14", "#9aa5b1"
_FONT = 'font-family="Helvetica,Arial,sans-serif"'


@dataclass(frozen=True, eq=False)
class _Section:
    """Rays (R,) of a section in turn, the turn's last next to the first, as numbers of about's
    rays; right, up (3,): the axes of the picture; centre, middle (3,) [m]: where the rays begin,
    what stands in the picture's middle."""

    about: RayReach
    rays: Ints
    right: Floats
    up: Floats
    centre: Floats
    middle: Floats
    name: str

    def flat(self, points: Floats) -> Floats:
        """Points (M, 3) as (M, 2) [m] in the picture's axes."""
        off = points - self.middle
        return np.stack([off @ self.right, off @ self.up], axis=1)


@dataclass(frozen=True)
class _Page:
    """A picture `size` pixels square, of `half` [m] to each side of its middle; slug: a name of its
    own."""

    size: int
    half: float
    slug: str

    @property
    def scale(self) -> float:
        """Pixels a metre."""
        return self.size / (2 * self.half)


def envelope_sections(
    envelope: Envelope, *, environment: Environment | None = None, size: int = 420
) -> list[tuple[str, str]]:
    """Names and SVG texts, `size` pixels square and all of one scale: upright along and across,
    then level by level from below. environment: drawn where the planes cut it."""
    low, high = _box(envelope)
    half = 0.5 * float((high - low).max())
    middle = 0.5 * (low + high)
    x, y, z = np.eye(3)
    found = [
        _upright(envelope, ("upright, forward to the right", x, 1)),
        _upright(envelope, ("upright, seen from behind", -y, 0)),
    ]
    each = round(2 * np.pi / envelope.step)
    for number, height in enumerate(envelope.heights):
        name = f"level, {round(1000 * height):+d} mm, forward up the page".replace("+0 mm", "0 mm")
        point = envelope.origin + height * z
        found.append(
            _Section(envelope.levels, each * number + np.arange(each), -y, x, point, middle, name)
        )
    found = [replace(section, middle=middle) for section in found]
    slug = re.sub(r"[^a-z0-9]+", "-", f"{envelope.person}-{envelope.limb}-{envelope.zone}".lower())
    return [
        (section.name, _drawn(section, environment, _Page(size, half, f"{slug}-{number}")))
        for number, section in enumerate(found)
    ]


def _box(envelope: Envelope) -> tuple[Floats, Floats]:
    """Least and greatest corner (3,) [m] of what is reached and the origin, with a little room."""
    points = [envelope.origin[None]]
    for about in (envelope.about, envelope.levels):
        points.append((about.origin + about.outer[:, None] * about.direction)[about.reached])
    every = np.concatenate(points)
    return every.min(axis=0) - 0.1, every.max(axis=0) + 0.1


def _upright(envelope: Envelope, how: tuple[str, Floats, int]) -> _Section:
    """The section of the rays that lie in a plane through z, in turn by their angle."""
    name, right, axis = how
    direction = envelope.about.direction
    up = np.array([0.0, 0.0, 1.0])
    rays = np.flatnonzero(np.abs(direction[:, axis]) < 1e-9)
    order = np.argsort(np.arctan2(direction[rays] @ up, direction[rays] @ right), kind="stable")
    return _Section(envelope.about, rays[order], right, up, envelope.origin, envelope.origin, name)


def _drawn(section: _Section, environment: Environment | None, page: _Page) -> str:
    size = page.size
    about = section.about
    rays = section.rays
    outer = about.outer[rays]
    inner = about.inner[rays]
    reached = about.reached[rays]
    whole = _path(section, (outer, inner, reached), page)
    areas = [_area(whole, AREAS["at the limit"])]
    for grade in (1, 0):
        ends = about.easy_outer[grade, rays], about.easy_inner[grade, rays]
        areas.append(
            _area(
                _path(section, (*ends, np.isfinite(ends[0])), page),
                AREAS[("easy", "moderate")[grade]],
            )
        )
    walls = _walls(section, environment, page) if environment is not None else ""
    x, y = _pixels(section, np.zeros((1, 2)), page)[0]
    rings = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r * page.scale:.1f}" fill="none" stroke="#b4bec9" '
        f'stroke-width="0.7"/><text x="{x + 3:.1f}" y="{y - r * page.scale - 3:.1f}" {_FONT} font-size="10" '
        f'fill="#5c6b7a">{1000 * r:.0f}</text>'
        for r in (0.5, 1.0, 1.5)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" width="{size}" role="img" '
        f'aria-label="{escape(section.name)}"><rect width="{size}" height="{size}" fill="#fff"/>'
        f"{''.join(areas)}{_lost(section, whole, page)}{rings}{walls}"
        f"{_line(section, (outer, reached), _OUTER, page)}{_line(section, (inner, reached), _INNER, page)}"
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="#343c48"/></svg>'
    )


def _pixels(section: _Section, flat: Floats, page: _Page) -> Floats:
    """Pixels (M, 2) of points (M, 2) [m] that are told from where the rays begin."""
    pixels: Floats = (
        page.size / 2 + (flat + section.flat(section.centre[None])) * [1, -1] * page.scale
    )
    return pixels


def _text(points: Floats) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _ways(section: _Section) -> Floats:
    """(R, 2) the rays of a section in the picture."""
    direction = section.about.direction[section.rays]
    return np.stack([direction @ section.right, direction @ section.up], axis=1)


def _path(section: _Section, ends: tuple[Floats, Floats, Bools], page: _Page) -> str:
    """What lies between outer and inner ends, from each ray to the next where both have any."""
    outer, inner, there = ends
    way = _ways(section)
    after = np.roll(np.arange(len(outer)), -1)
    path = []
    for i in np.flatnonzero(there & there[after]):
        j = after[i]
        corners = np.array(
            [outer[i] * way[i], outer[j] * way[j], inner[j] * way[j], inner[i] * way[i]]
        )
        path.append("M" + _text(_pixels(section, corners, page)) + "Z")
    return "".join(path)


def _area(path: str, colour: str) -> str:
    return (
        f'<path d="{path}" fill="{colour}" stroke="{colour}" stroke-width="0.6"/>' if path else ""
    )


def _lost(section: _Section, whole: str, page: _Page) -> str:
    """What obstacles take, half a step to either side of each ray, hatched, within the path of the
    whole area."""
    lost = section.about.lost
    place = {int(ray): k for k, ray in enumerate(section.rays)}
    way = _ways(section)
    path = []
    for k, ray in enumerate(lost.ray.tolist()):
        if ray not in place:
            continue
        i = place[ray]
        sides = [way[i] + way[(i + turn) % len(way)] for turn in (-1, 1)]
        one, two = (side / max(float(np.linalg.norm(side)), 1e-9) for side in sides)
        corners = np.array(
            [
                lost.begin[k] * one,
                lost.end[k] * one,
                lost.end[k] * way[i],
                lost.end[k] * two,
                lost.begin[k] * two,
                lost.begin[k] * way[i],
            ]
        )
        path.append("M" + _text(_pixels(section, corners, page)) + "Z")
    if not path:
        return ""
    red = LEGEND[-1][1]
    hatch = (
        f'<defs><pattern id="lost-{page.slug}" width="5" height="5" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)">'
        f'<rect width="5" height="5" fill="{red}" fill-opacity="0.28"/>'
        f'<path d="M0,0V5" stroke="{red}" stroke-width="2.4"/></pattern>'
        f'<clipPath id="all-{page.slug}"><path d="{whole}"/></clipPath></defs>'
    )
    fill = f'fill="url(#lost-{page.slug})" clip-path="url(#all-{page.slug})"'
    return f'{hatch}<path d="{"".join(path)}" {fill}/>'


def _line(section: _Section, ends: tuple[Floats, Bools], colour: str, page: _Page) -> str:
    """A boundary from ray to ray where both have one; the inner one broken."""
    radius, there = ends
    way = _ways(section)
    after = np.roll(np.arange(len(radius)), -1)
    path = "".join(
        "M"
        + _text(
            _pixels(section, np.array([radius[i] * way[i], radius[after[i]] * way[after[i]]]), page)
        )
        for i in np.flatnonzero(there & there[after])
    )
    dash = ' stroke-dasharray="5 3"' if colour == _INNER else ""
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.5" stroke-linecap="round"{dash}/>'


def _walls(section: _Section, environment: Environment, page: _Page) -> str:
    """The lines in which the section's plane cuts the triangles of shown parts."""
    shown = np.concatenate(_shown_triangles(environment))
    corners = environment.vertices[environment.triangles[shown]]
    normal = np.cross(section.right, section.up)
    height = (corners - section.centre) @ normal
    ends = []
    for one, two in ((0, 1), (1, 2), (2, 0)):
        a = height[:, one]
        b = height[:, two]
        crosses = (a < 0) != (b < 0)
        share = np.where(crosses, a / np.where(crosses, a - b, 1.0), np.nan)[:, None]
        ends.append(corners[:, one] + share * (corners[:, two] - corners[:, one]))
    points = np.stack(ends, axis=1)
    cut = points[np.isfinite(points[..., 0]).sum(axis=1) == 2]
    pairs = cut[np.isfinite(cut[..., 0])].reshape(-1, 2, 3)
    flat = np.stack([section.flat(pairs[:, end]) for end in (0, 1)], axis=1)
    near = np.abs(flat).min(axis=1).max(axis=1) < page.half
    path = "".join("M" + _text(page.size / 2 + pair * [1, -1] * page.scale) for pair in flat[near])
    return f'<path d="{path}" fill="none" stroke="{_WALL}" stroke-width="1"/>' if path else ""


def _shown_triangles(environment: Environment) -> Sequence[Ints]:
    """The triangles of each part that is shown."""
    found = [np.zeros(0, dtype=np.int64)]
    for part in np.flatnonzero(~environment.hidden):
        first, last = (
            int(environment.triangle_start[environment.part_start[part + i]]) for i in (0, 1)
        )
        found.append(np.arange(first, last))
    return found
