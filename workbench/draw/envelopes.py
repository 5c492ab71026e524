"""Draw a reach envelope: as a see-through net over person and surroundings, and in sections."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from xml.sax.saxutils import escape

import numpy as np
from PIL import Image, ImageColor, ImageDraw

from workbench.draw.camera import Camera, facing, project, standard_view
from workbench.draw.disks import disks
from workbench.draw.marks.layout import FONT
from workbench.draw.scene import Colour, Scene
from workbench.draw.visibility import triangles_shown
from workbench.draw.web.place_mesh import environment_mesh
from workbench.draw.web.views import WebPlace, WebView, body_view
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.envelope import GRADES, Envelope, RayReach
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = [
    "LEGEND",
    "envelope_image",
    "envelope_sections",
    "outer_faces",
    "section_lines",
    "turnable_envelope",
]

_FREE_COLOUR = "#3f7fb8"
_STOPPED_COLOUR = "#d0453a"
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
        colour = ImageColor.getrgb(_STOPPED_COLOUR if stopped_short[face] else _FREE_COLOUR)
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


# Draw plane sections of a reach envelope as SVG.
#
# There are level sections, and two upright ones through the origin. Nested areas show
# where reach is easy, moderate and possible at all. Hatching shows what obstacles take away. The
# surroundings are drawn as the plane of the section cuts them.

_AREA_COLOURS = {"easy": "#7fbb9f", "moderate": "#c4e0d0", "at the limit": "#eceff3"}
_LOST_COLOUR = "#e0746a"
LEGEND = (*_AREA_COLOURS.items(), ("lost to obstacles", _LOST_COLOUR))
"""Name and colour of each area."""
_OUTER_COLOUR = "#143a7a"
_INNER_COLOUR = "#7a3a14"
_WALL_COLOUR = "#9aa5b1"
_BORDER = 0.1
"""Distance [m] from the envelope to the border of the picture."""
_RING_RADII = (0.5, 1.0, 1.5)
"""Radii [m] of the rings about the origin."""


@dataclass(frozen=True, eq=False)
class _Section:
    """A plane section: rays of an envelope that lie in one plane."""

    about: RayReach
    rays: Ints
    """(R,) indices of rays, in turn by their angle; the last is next to the first."""
    right: Floats
    """(3,) axis of the picture."""
    up: Floats
    """(3,) axis of the picture."""
    centre: Floats
    """(3,) point [m] where the rays begin."""
    middle: Floats
    """(3,) point [m] in the middle of the picture."""
    name: str

    @property
    def directions(self) -> Floats:
        """(R, 2) unit vectors of the rays in the picture."""
        direction = self.about.direction[self.rays]
        return np.stack([direction @ self.right, direction @ self.up], axis=1)

    def flat(self, points: Floats) -> Floats:
        """Return points (..., 3) [m] in the axes of the picture, (..., 2) [m] from its middle."""
        offset = points - self.middle
        return np.stack([offset @ self.right, offset @ self.up], axis=-1)


@dataclass(frozen=True)
class _Page:
    """A square picture."""

    size: int
    """[pixels]."""
    half: float
    """Distance [m] from the middle to each side."""
    slug: str
    """Name for identifiers inside the SVG."""

    @property
    def scale(self) -> float:
        """Pixels per metre."""
        return self.size / (2 * self.half)

    def pixels(self, flat: Floats) -> Floats:
        """Return the pixels (M, 2) of points (M, 2) [m] from the middle."""
        return self.size / 2 + flat * [1, -1] * self.scale


def envelope_sections(
    envelope: Envelope, *, environment: Environment | None = None, size: int = 420
) -> list[tuple[str, str]]:
    """Draw the sections of an envelope, all at one scale.

    Parameters
    ----------
    envelope
        The envelope.
    environment
        Drawn where the planes cut it.
    size
        Width and height of each picture [pixels].

    Returns
    -------
    list[tuple[str, str]]
        Name and SVG text: upright along, upright across, then level by level from below.
    """
    low, high = _envelope_bounds(envelope)
    half = 0.5 * float((high - low).max())
    middle = 0.5 * (low + high)
    forward, left, _ = np.eye(3)
    sections = [
        _upright_section(
            envelope,
            f"upright through the {envelope.origin_name}, forward is to the right",
            forward,
            across=1,
        ),
        _upright_section(
            envelope,
            f"upright through the {envelope.origin_name}, seen from behind",
            -left,
            across=0,
        ),
        *(_level_section(envelope, number) for number in range(len(envelope.heights))),
    ]
    slug = re.sub(r"[^a-z0-9]+", "-", f"{envelope.person}-{envelope.limb}-{envelope.zone}".lower())
    drawings = []
    for number, section in enumerate(sections):
        page = _Page(size, half, f"{slug}-{number}")
        svg = _section_svg(replace(section, middle=middle), environment, page)
        drawings.append((section.name, svg))
    return drawings


def section_lines(envelope: Envelope) -> Floats:
    """Find the outer boundary in the sections of an envelope, obstacles aside.

    Returns
    -------
    Floats
        (L, 2, 3) [m] the ends of its lines, from each ray to the next.
    """
    forward, left, _ = np.eye(3)
    sections = [
        _upright_section(envelope, "along", forward, across=1),
        _upright_section(envelope, "across", -left, across=0),
        *(_level_section(envelope, number) for number in range(len(envelope.heights))),
    ]
    lines = [np.zeros((0, 2, 3))]
    for section in sections:
        about = section.about
        ends = about.origin + about.outer[:, None] * about.direction
        pairs = _neighbours(about.reached[section.rays])
        lines += [ends[section.rays[list(pair)]][None] for pair in pairs]
    return np.concatenate(lines)


def _envelope_bounds(envelope: Envelope) -> tuple[Floats, Floats]:
    """Return the least and greatest corner (3,) [m] of envelope and origin, with a border."""
    points = [envelope.origin[None]]
    for about in (envelope.about, envelope.levels):
        points.append((about.origin + about.outer[:, None] * about.direction)[about.reached])
    every = np.concatenate(points)
    return every.min(axis=0) - _BORDER, every.max(axis=0) + _BORDER


def _upright_section(envelope: Envelope, name: str, right: Floats, *, across: int) -> _Section:
    """Collect the rays in the upright plane that is normal to axis `across`."""
    direction = envelope.about.direction
    up = np.array([0.0, 0.0, 1.0])
    rays = np.flatnonzero(np.abs(direction[:, across]) < 1e-9)
    order = np.argsort(np.arctan2(direction[rays] @ up, direction[rays] @ right), kind="stable")
    return _Section(envelope.about, rays[order], right, up, envelope.origin, envelope.origin, name)


def _level_section(envelope: Envelope, number: int) -> _Section:
    """Collect the rays of a level."""
    height = envelope.heights[number]
    count = round(2 * np.pi / envelope.step)
    forward, left, up = np.eye(3)
    name = f"level, {round(1000 * height):+d} mm, forward up the page".replace("+0 mm", "0 mm")
    centre = envelope.origin + height * up
    rays = count * number + np.arange(count)
    return _Section(envelope.levels, rays, -left, forward, centre, centre, name)


def _section_svg(section: _Section, environment: Environment | None, page: _Page) -> str:
    size = page.size
    about = section.about
    rays = section.rays
    outer = about.outer[rays]
    inner = about.inner[rays]
    reached = about.reached[rays]
    whole = _area_path(section, outer, inner, reached, page)
    areas = _area(whole, _AREA_COLOURS["at the limit"])
    for name, easy_outer, easy_inner in reversed(
        list(zip(GRADES, about.easy_outer[:, rays], about.easy_inner[:, rays], strict=True))
    ):
        path = _area_path(section, easy_outer, easy_inner, np.isfinite(easy_outer), page)
        areas += _area(path, _AREA_COLOURS[name])
    walls = _wall_lines(section, environment, page) if environment is not None else ""
    x, y = _ray_pixels(section, np.zeros((1, 2)), page)[0]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" width="{size}" role="img" '
        f'aria-label="{escape(section.name)}"><rect width="{size}" height="{size}" fill="#fff"/>'
        f"{areas}{_lost_areas(section, whole, page)}{_rings(x, y, page)}{walls}"
        f"{_boundary(section, outer, reached, page, _OUTER_COLOUR)}"
        f"{_boundary(section, inner, reached, page, _INNER_COLOUR, dashed=True)}"
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="#343c48"/></svg>'
    )


def _rings(x: float, y: float, page: _Page) -> str:
    """Draw rings about the origin at x, y [pixels], labelled with their radius in mm."""
    return "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r * page.scale:.1f}" fill="none" stroke="#b4bec9" '
        f'stroke-width="0.7"/><text x="{x + 3:.1f}" y="{y - r * page.scale - 3:.1f}" {FONT} font-size="10" '
        f'fill="#5c6b7a">{1000 * r:.0f}</text>'
        for r in _RING_RADII
    )


def _ray_pixels(section: _Section, flat: Floats, page: _Page) -> Floats:
    """Return the pixels (M, 2) of points (M, 2) [m] from the point where the rays begin."""
    return page.pixels(flat + section.flat(section.centre[None]))


def _points_text(points: Floats) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _neighbours(there: Bools) -> list[tuple[int, int]]:
    """Return the pairs of rays next to one another that are both `there` (R,)."""
    following = np.roll(np.arange(len(there)), -1)
    first = np.flatnonzero(there & there[following])
    return list(zip(first.tolist(), following[first].tolist(), strict=True))


def _area_path(section: _Section, outer: Floats, inner: Floats, there: Bools, page: _Page) -> str:
    """Write the area between two radii (R,) [m], from each ray to the next, as path commands."""
    direction = section.directions
    path = []
    for i, j in _neighbours(there):
        corners = np.array(
            [
                outer[i] * direction[i],
                outer[j] * direction[j],
                inner[j] * direction[j],
                inner[i] * direction[i],
            ]
        )
        path.append("M" + _points_text(_ray_pixels(section, corners, page)) + "Z")
    return "".join(path)


def _area(path: str, colour: str) -> str:
    if not path:
        return ""
    return f'<path d="{path}" fill="{colour}" stroke="{colour}" stroke-width="0.6"/>'


def _lost_areas(section: _Section, whole: str, page: _Page) -> str:
    """Hatch what obstacles take, half a step to either side of each ray, inside the whole area."""
    lost = section.about.lost
    index_of = {int(ray): k for k, ray in enumerate(section.rays)}
    path = []
    for k, ray in enumerate(lost.ray.tolist()):
        if ray in index_of:
            corners = _lost_corners(
                section.directions, index_of[ray], float(lost.begin[k]), float(lost.end[k])
            )
            path.append("M" + _points_text(_ray_pixels(section, corners, page)) + "Z")
    if not path:
        return ""
    hatch = (
        f'<defs><pattern id="lost-{page.slug}" width="5" height="5" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)">'
        f'<rect width="5" height="5" fill="{_LOST_COLOUR}" fill-opacity="0.28"/>'
        f'<path d="M0,0V5" stroke="{_LOST_COLOUR}" stroke-width="2.4"/></pattern>'
        f'<clipPath id="all-{page.slug}"><path d="{whole}"/></clipPath></defs>'
    )
    fill = f'fill="url(#lost-{page.slug})" clip-path="url(#all-{page.slug})"'
    return f'{hatch}<path d="{"".join(path)}" {fill}/>'


def _lost_corners(direction: Floats, i: int, begin: float, end: float) -> Floats:
    """Return the corners (6, 2) [m] of a sector about ray i, from radius `begin` to `end`."""
    sides = [direction[i] + direction[(i + turn) % len(direction)] for turn in (-1, 1)]
    before, after = (side / max(float(np.linalg.norm(side)), 1e-9) for side in sides)
    return np.array(
        [
            begin * before,
            end * before,
            end * direction[i],
            end * after,
            begin * after,
            begin * direction[i],
        ]
    )


def _boundary(
    section: _Section,
    radius: Floats,
    there: Bools,
    page: _Page,
    colour: str,
    *,
    dashed: bool = False,
) -> str:
    """Draw a line of radius (R,) [m] from each ray to the next where both have one."""
    direction = section.directions
    path = "".join(
        "M"
        + _points_text(
            _ray_pixels(section, np.array([radius[k] * direction[k] for k in pair]), page)
        )
        for pair in _neighbours(there)
    )
    dash = ' stroke-dasharray="5 3"' if dashed else ""
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.5" stroke-linecap="round"{dash}/>'


def _wall_lines(section: _Section, environment: Environment, page: _Page) -> str:
    """Draw the lines in which the plane of the section cuts the triangles of shown parts."""
    corners = environment.vertices[environment.triangles[triangles_shown(environment)]]
    flat = section.flat(_plane_crossings(corners, section))
    near = np.abs(flat).min(axis=1).max(axis=1) < page.half
    path = "".join("M" + _points_text(page.pixels(pair)) for pair in flat[near])
    if not path:
        return ""
    return f'<path d="{path}" fill="none" stroke="{_WALL_COLOUR}" stroke-width="1"/>'


def _plane_crossings(corners: Floats, section: _Section) -> Floats:
    """Return where the plane of a section cuts triangles (T, 3, 3): segments (K, 2, 3) [m]."""
    height = (corners - section.centre) @ np.cross(section.right, section.up)
    ends = []
    for one, two in ((0, 1), (1, 2), (2, 0)):
        a = height[:, one]
        b = height[:, two]
        crosses = (a < 0) != (b < 0)
        share = np.where(crosses, a / np.where(crosses, a - b, 1.0), np.nan)[:, None]
        ends.append(corners[:, one] + share * (corners[:, two] - corners[:, one]))
    points = np.stack(ends, axis=1)
    cut = points[np.isfinite(points[..., 0]).sum(axis=1) == 2]
    return cut[np.isfinite(cut[..., 0])].reshape(-1, 2, 3)
