"""Draw where a control may be so that enough people reach it: from the left, from above and from the
front, with a person of middle stature in the seat.

In each picture the pale area is where the region lies anywhere along the line of sight, the dark one
its section through the nearest place that will do, or through the control's own where there is
none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera, fit_to_spheres, look_at, project, to_view
from workbench.draw.contours import level_loops
from workbench.draw.lines.outline import outline
from workbench.draw.lines.svg import closed_paths
from workbench.draw.marks.layout import FONT
from workbench.draw.marks.pictures import svg_marks
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.model.arrays import Floats, xyz
from workbench.model.control_region import ControlRegion
from workbench.model.units import plain

__all__ = ["control_region_svg"]

_SIZE = 560
"""Width and height [pixels] of each picture."""
_HEAD = 70
"""Height [pixels] of the text above."""
_CUT = 0.02
"""How far [m] before the person and the region everything is cut away."""
_PALE, _DARK, _LINE = "#b3d6bd", "#4f9f7d", "#1f5c46"
_WRAP = 190
"""Letters of a line of the text, about."""


@dataclass(frozen=True)
class _View:
    """A picture: its name; the axis of the region that points at the viewer, and which way; and the
    axes of rows and columns of a section."""

    name: str
    depth: int
    sign: int
    up: int

    @property
    def across(self) -> int:
        """The axis that is neither up nor at the viewer."""
        return 3 - self.depth - self.up


_VIEWS = (
    _View("from the left", depth=1, sign=1, up=2),
    _View("from above", depth=2, sign=1, up=0),
    _View("from the front", depth=0, sign=1, up=2),
)


def control_region_svg(region: ControlRegion, title: str) -> str:
    """Draw a region in three views.

    Parameters
    ----------
    region
        The places, and who is shown among them.
    title
        The sentence above.

    Returns
    -------
    str
        SVG text.
    """
    width = _SIZE * len(_VIEWS)
    height = _SIZE + _HEAD
    panels = [_panel(region, view, k) for k, view in enumerate(_VIEWS)]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" role="img"><title>{escape(title)}</title>',
            f'<rect width="{width}" height="{height}" fill="#fff"/>',
            *_text(title),
            *_legend(region),
            *panels,
            "</svg>",
            "",
        ]
    )


def _text(title: str) -> list[str]:
    """The sentence in lines."""
    lines = [""]
    for word in title.split():
        if len(lines[-1]) + len(word) > _WRAP:
            lines.append("")
        lines[-1] += f"{word} "
    return [
        f'<text x="16" y="{24 + 18 * k}" {FONT} font-size="15">{escape(line.strip())}</text>'
        for k, line in enumerate(lines)
    ]


def _legend(region: ControlRegion) -> list[str]:
    """What the two colours mean."""
    wanted = f"{100 * region.wanted:.0f} % reach it"
    through = "the nearest such place" if region.nearest is not None else "its place today"
    entries = (
        (_DARK, f"{wanted}, in a section through {through}"),
        (_PALE, f"{wanted}, somewhere along the line of sight"),
    )
    parts = []
    for k, (colour, text) in enumerate(entries):
        x = 16 + 420 * k
        parts.append(f'<rect x="{x}" y="48" width="16" height="12" fill="{colour}"/>')
        parts.append(f'<text x="{x + 24}" y="59" {FONT} font-size="13">{escape(text)}</text>')
    return parts


def _panel(region: ControlRegion, view: _View, number: int) -> str:
    """One picture, as an SVG element inside the whole."""
    body = SceneBody(region.placed)
    marks = _marks(region)
    scene = Scene((body,), region.environment, (), f"{region.control.name} {view.name}")
    camera = _camera(region, scene, view)
    drawn = outline(scene, camera, hidden="hidden_line")
    inner = drawn[drawn.index(">") + 1 : drawn.rindex("</svg>")]
    label = f'<text x="16" y="22" {FONT} font-size="14" font-weight="700">{view.name}</text>'
    return "\n".join(
        [
            f'<svg x="{_SIZE * number}" y="{_HEAD}" width="{_SIZE}" height="{_SIZE}">',
            inner,
            *_areas(region, view, camera),
            *svg_marks(replace(scene, marks=marks), camera),
            f'<rect width="{_SIZE}" height="{_SIZE}" fill="none" stroke="#c8ced6"/>',
            label,
            "</svg>",
        ]
    )


def _marks(region: ControlRegion) -> tuple[Mark, ...]:
    """Today's place and the nearest one that will do."""
    name = plain(region.control.name)
    today = Mark(region.control.at, f"{name} today", "missed")
    if region.nearest is None:
        return (today,)
    if region.nearest == region.today:
        return (replace(today, kind="reach"),)
    nearest = Mark(xyz(region.points[region.nearest]), "nearest place that will do", "reach")
    return today, nearest


def _camera(region: ControlRegion, scene: Scene, view: _View) -> Camera:
    """A parallel view along an axis of the region, that holds the person and the places that enough
    people reach."""
    toward = region.axes[view.depth] * view.sign
    spheres = scene.spheres
    places = region.points[region.enough]
    centre = np.concatenate([spheres.centre, places, [region.control.at]])
    radius = np.concatenate([spheres.radius, np.full(len(places) + 1, region.spacing)])
    middle = centre.mean(axis=0)
    camera = look_at(
        middle + toward, middle, up=region.axes[view.up], field=0.0, width=_SIZE, height=_SIZE
    )
    camera = fit_to_spheres(replace(camera, name="front"), centre, radius)
    front = (to_view(camera, centre)[:, 2] + radius).max()
    return replace(camera, cut=float(front) + _CUT)


def _areas(region: ControlRegion, view: _View, camera: Camera) -> list[str]:
    """The region along the line of sight, and its section."""
    lattice = region.offset[region.on_lattice]
    enough = region.enough[region.on_lattice]
    steps = np.round(lattice / region.spacing).astype(int)
    count = int(np.abs(steps).max()) + 1
    cube = np.zeros((2 * count + 1,) * 3)
    cube[tuple((steps + count).T)] = enough
    row = region.today if region.nearest is None else region.nearest
    depth = int(np.round(region.offset[row, view.depth] / region.spacing)) + count
    seen = np.moveaxis(cube, view.depth, 0)
    paths = []
    for field, colour, opacity in (
        (seen.max(axis=0), _PALE, 0.55),
        (seen[np.clip(depth, 0, 2 * count)], _DARK, 0.7),
    ):
        loops = [_projected(region, view, camera, loop - count) for loop in level_loops(field, 0.5)]
        if loops:
            paths.append(
                f'<path fill="{colour}" fill-opacity="{opacity}" fill-rule="evenodd" '
                f'stroke="{_LINE}" stroke-width="1" d="{closed_paths(loops)}"/>'
            )
    return paths


def _projected(region: ControlRegion, view: _View, camera: Camera, loop: Floats) -> Floats:
    """(K, 2) [pixels] a loop (K, 2) of steps along the two axes that are not the line of sight."""
    low, high = sorted((view.across, view.up))
    offset = np.zeros((len(loop), 3))
    offset[:, low] = loop[:, 0] * region.spacing
    offset[:, high] = loop[:, 1] * region.spacing
    return project(camera, np.array(region.control.at) + offset @ region.axes)[:, :2]
