"""Draw the paper's line drawing as SVG: the visible outline of the bodies as exact arcs.

Each rim is cut in closed form where other spheres hide it (see `lines.silhouettes`); nothing is traced.

- Between spheres of one segment, or of segments that a joint joins, only steps of depth above
  `JOINT_STEP` and above `JOINT_SHARE` of the rim's radius are drawn. Creases vanish and a limb
  fades into the body at its joint, while an arm in front of the chest keeps its outline. Other
  bodies hide without that allowance.
- Specks are left out: lines of a few pixels that connect nothing, and chinks between fingers.
- What stands between the viewer and a body must not hide it. Arcs behind an opaque polygon are thin
  and pale, or left out in the style hidden_line.
- Ghosts lie under the bodies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.disks import ghost_strengths
from workbench.draw.lines.arcs import Arcs, arc_lengths, arc_points, outline_arcs
from workbench.draw.lines.hidden_lines import split_hidden_arcs, surroundings
from workbench.draw.lines.svg import environment_paths, number_rows, page, section_paths
from workbench.draw.scene import INKS, PAPER, Scene, hexadecimal
from workbench.draw.visibility import projected_disks
from workbench.geometry.box_pairs import box_pairs, in_ranges
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["arc_chains", "body_paths", "ends_met", "ghost_paths", "outline"]

_MIN_LINE = 9.0
"""Length [pixels] below which a line that connects nothing is a speck."""
_MIN_HOLE = 24.0
"""Length [pixels] below which the rim of a hole is a speck."""
_MEETING_DISTANCE = 0.5
"""Distance [pixels] from the end of a line to another one within which they meet."""
_MIN_ARC = 0.3
"""Length [pixels] below which arcs of a chain are merged."""
_MAX_ARC_ANGLE = 2.1
"""Angle [rad] above which an arc is drawn in pieces: rounded ends determine an arc of nearly half a
turn badly."""


class _Pen(NamedTuple):
    """How some of the chains of arcs are drawn."""

    name: str
    outer: bool
    """For arcs against the background, or for those inside a body's outline."""
    veiled: bool
    """For arcs behind an opaque polygon."""
    style: str


_PENS = (
    _Pen("veiled", False, True, 'stroke-width="0.6" stroke-opacity="0.4"'),
    _Pen("veiled", True, True, 'stroke-width="0.8" stroke-opacity="0.5"'),
    _Pen("inner", False, False, 'stroke-width="1.1"'),
    _Pen("outer", True, False, 'stroke-width="1.8"'),
)
"""In the order in which they are drawn."""


class _Chains(NamedTuple):
    """Visible arcs that run into one another, in the order of the chains."""

    arcs: Arcs
    start: Ints
    """(C,) first arc of each chain."""
    last: Ints
    """(C,) last arc of each chain."""
    closed: Bools
    """(C,) whether the last arc runs into the first."""


def outline(scene: Scene, camera: Camera, *, hidden: str = "veiled") -> str:
    """Draw a scene: edges of the environment, then the outlines of bodies, then marks.

    Outer contours are heavier than those inside. The text holds no script and no reference to
    anything outside; labels are escaped.

    Parameters
    ----------
    scene, camera
        What is drawn, and from where.
    hidden
        veiled: what is behind a wall is thin and pale. hidden_line: it is left out.

    Returns
    -------
    str
        SVG text in the size of the camera.
    """
    arcs = outline_arcs(scene, camera)
    walls = surroundings(scene, camera, hidden)
    if walls is not None:
        arcs = split_hidden_arcs(arcs, walls.occluders)
        if hidden == "hidden_line":
            arcs = Arcs._make(column[~arcs.veiled] for column in arcs)
    parts = [*ghost_paths(scene, camera), *body_paths(scene, arcs)]
    if walls is not None:
        parts = [*environment_paths(walls.lines), *parts, *section_paths(walls.sections, hidden)]
    return page(scene, camera, "a line drawing of the outline", parts)


def ghost_paths(scene: Scene, camera: Camera) -> list[str]:
    """Return the pale outlines of a scene's ghosts, and the bodies' disks in paper, which hide
    them."""
    if not scene.ghosts:
        return []
    parts = []
    for shown, strength in zip(scene.ghosts, ghost_strengths(scene).tolist(), strict=True):
        alone = Scene((shown,))
        parts.append(f'<g class="ghost" stroke-opacity="{strength:.2f}">')
        parts += body_paths(alone, outline_arcs(alone, camera))
        parts.append("</g>")
    flat = projected_disks(scene, camera)
    disks = number_rows('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}"/>', flat.disk[flat.order])
    return [*parts, f'<g class="cover" fill="{hexadecimal(PAPER)}">', *disks, "</g>"]


def body_paths(scene: Scene, arcs: Arcs) -> list[str]:
    """Return SVG elements of a scene's arcs: a path for each pen and body."""
    parts = ['<g class="bodies" fill="none" stroke-linecap="round" stroke-linejoin="round">']
    chains = _chain_arcs(arcs)
    texts = _chain_texts(chains, _long_enough(chains))
    first = Arcs._make(column[chains.start] for column in chains.arcs)
    for pen in _PENS:
        of_pen = (first.outer == pen.outer) & (first.veiled == pen.veiled)
        for body, shown in enumerate(scene.bodies):
            own = np.flatnonzero(of_pen & (first.body == body))
            path = "".join(texts[chain] for chain in own)
            if path:
                ink = hexadecimal(INKS[shown.colour])
                parts.append(f'<path class="{pen.name}" stroke="{ink}" {pen.style} d="{path}"/>')
    return [*parts, "</g>"]


def _chain_arcs(arcs: Arcs) -> _Chains:
    """Sort arcs into chains that run into one another."""
    following = _following_arc(arcs)
    order, start = arc_chains(following)
    last = np.append(start[1:], len(order))[: len(start)] - 1
    closed = following[order[last]] == order[start]
    return _Chains(Arcs._make(column[order] for column in arcs), start, last, closed)


def _following_arc(arcs: Arcs) -> Ints:
    """Return the arc (A,) that goes on where one ends, by the two spheres that meet there; -1 for
    none."""
    base = int(arcs.sphere.max(initial=0)) + 2
    kind = (arcs.veiled * 2 + arcs.outer) * base * base
    start = kind + (arcs.lead[:, 0] + 1) * base + arcs.sphere + 1
    end = kind + (arcs.sphere + 1) * base + arcs.lead[:, 1] + 1
    order = np.argsort(start, kind="stable")
    candidate = order[np.minimum(np.searchsorted(start[order], end), len(order) - 1)]
    return np.where((start[candidate] == end) & (arcs.lead[:, 1] >= 0), candidate, -1)


def arc_chains(following: Ints) -> tuple[Ints, Ints]:
    """Chain arcs in the order in which a pen draws them.

    Parameters
    ----------
    following
        (A,) the arc that goes on where one ends, -1 for none. No two have the same.

    Returns
    -------
    tuple[Ints, Ints]
        The arcs (A,) in order, and where (C,) each chain starts in it. Chains with a beginning come
        first, closed ones after them, each by the number of its first arc.
    """
    after = following.tolist()
    begins = np.ones(len(after), dtype=np.bool_)
    begins[following[following >= 0]] = False
    is_drawn = [False] * len(after)
    order: list[int] = []
    start = []
    for first in np.concatenate([np.flatnonzero(begins), np.flatnonzero(~begins)]).tolist():
        arc = first
        if not is_drawn[arc]:
            start.append(len(order))
        while arc >= 0 and not is_drawn[arc]:
            order.append(arc)
            is_drawn[arc] = True
            arc = after[arc]
    return np.array(order, dtype=np.int64), np.array(start, dtype=np.int64)


def _long_enough(chains: _Chains) -> Bools:
    """Return which (C,) of the chains are no specks.

    A chain is drawn if it is long, if it is the outer contour of a body, or if it bridges others.
    """
    arcs, start, last, closed = chains
    if not len(start):
        return closed
    each = np.arange(len(arcs.sphere))
    begin = arc_points(arcs, each, arcs.angle[:, 0])
    end = arc_points(arcs, each, arcs.angle[:, 1])
    length = np.add.reduceat(arc_lengths(arcs), start)
    # twice the signed area of the polygon; a hole's chain runs round against its arcs
    area = np.add.reduceat(begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0], start)
    hole = closed & (area < 0.0)
    contour = closed & arcs.outer[start]
    least = np.where(hole, _MIN_HOLE, np.where(contour, _MIN_ARC, _MIN_LINE))
    drawn: Bools = length >= least
    short = np.flatnonzero(~drawn & (length >= _MIN_ARC) & ~closed)
    drawn[short] = _is_bridge(chains, short, begin[start[short]], end[last[short]], drawn)
    return drawn


def _is_bridge(chains: _Chains, short: Ints, begin: Floats, end: Floats, drawn: Bools) -> Bools:
    """Return which of some short chains meet others at both ends, at least one of them drawn.

    Parameters
    ----------
    chains
        All C chains.
    short
        (K,) the short chains.
    begin, end
        (K, 2) their ends [pixels].
    drawn
        (C,) whether a chain is drawn in any case.
    """
    arcs = chains.arcs
    rims = np.column_stack([arcs.disk, arcs.squeeze])
    count = chains.last - chains.start + 1
    chain = np.repeat(np.arange(len(count)), count)
    points = np.concatenate([begin, end])
    meets = ends_met(
        points, np.tile(short, 2), rims, arcs.angle, chain, drawn, _MEETING_DISTANCE
    ).reshape(2, -1, 2)
    return np.asarray(meets[:, :, 0].all(axis=0) & meets[:, :, 1].any(axis=0))


def ends_met(
    points: Floats,
    own: Ints,
    disk: Floats,
    angle: Floats,
    chain: Ints,
    is_long: Bools,
    distance: float,
) -> Bools:
    """Test whether ends of chains lie close to an arc of another chain.

    Parameters
    ----------
    points, own
        (M, 2) ends [pixels], and (M,) the chain of each.
    disk, angle, chain
        The arcs of ellipses. (A, 5) x, y, longer half axis, the shorter as a share of it, and the
        direction of the longer [rad]; (A, 2) angles from and to; (A,) the chain of each.
    is_long
        (C,) whether a chain is long.
    distance
        [pixels]. Distances from an ellipse are measured as if it were stretched to a circle.

    Returns
    -------
    Bools
        (M, 2) whether an end meets any other chain, and whether it meets a long one.
    """
    reach = disk[:, 2] + distance
    x, y = disk[:, :2].T
    boxes = np.column_stack([x - reach, y - reach, x + reach, y + reach])
    end, arc = box_pairs(np.tile(points, 2), boxes)
    apart = chain[arc] != own[end]
    end = end[apart]
    arc = arc[apart]
    meets = _are_on_arcs(points[end], disk[arc], angle[arc], distance)
    met = np.zeros((len(points), 2), dtype=np.bool_)
    met[end[meets], 0] = True
    met[end[meets & is_long[chain[arc]]], 1] = True
    return met


def _are_on_arcs(points: Floats, disk: Floats, angle: Floats, distance: float) -> Bools:
    """Return whether points (M, 2) lie within `distance` of arcs, of disk (M, 5), angle (M, 2)."""
    x, y, radius, ratio, turn = disk.T
    dx = points[:, 0] - x
    dy = points[:, 1] - y
    # turn the longer axis to x, and stretch the shorter one
    along = dx * np.cos(turn) + dy * np.sin(turn)
    across = (dy * np.cos(turn) - dx * np.sin(turn)) / ratio
    slack = distance / radius
    beyond = (np.arctan2(across, along) - angle[:, 0] + slack) % math.tau
    is_between = beyond <= angle[:, 1] - angle[:, 0] + 2.0 * slack
    is_on_rim = np.abs(np.hypot(along, across) - radius) <= distance
    return np.asarray(is_on_rim & is_between)


def _chain_texts(chains: _Chains, drawn: Bools) -> list[str]:
    """Return the path commands of each chain, "" for one that is not drawn."""
    arcs = chains.arcs
    arc, to = _pieces(chains)
    commands = _arc_commands(arcs, arc, to)
    chain = np.repeat(np.arange(len(chains.start)), chains.last - chains.start + 1)
    bounds = np.searchsorted(chain[arc], np.arange(len(chains.start) + 1)).tolist()
    begin = arc_points(arcs, chains.start, arcs.angle[chains.start, 0]).tolist()
    texts = []
    for k, (x, y) in enumerate(begin):
        path = "".join(commands[bounds[k] : bounds[k + 1]]) if drawn[k] else ""
        close = "Z" if chains.closed[k] else ""
        texts.append(f"M{x:.2f} {y:.2f}{path}{close}" if path else "")
    return texts


def _pieces(chains: _Chains) -> tuple[Ints, Floats]:
    """Divide long arcs into pieces, and merge arcs until they are `_MIN_ARC` long.

    Returns
    -------
    tuple[Ints, Floats]
        Of each piece its arc (M,) and its end (M, 2) [pixels].
    """
    arcs = chains.arcs
    width = arcs.angle[:, 1] - arcs.angle[:, 0]
    length = arc_lengths(arcs)
    end = np.cumsum(length)
    chain = np.repeat(np.arange(len(chains.start)), chains.last - chains.start + 1)
    run = end - (end - length)[chains.start][chain]  # from the beginning of the chain [pixels]
    kept = np.floor(run / _MIN_ARC) > np.floor((run - length) / _MIN_ARC)
    count = np.where(kept, np.ceil(width / _MAX_ARC_ANGLE).astype(np.int64), 0)
    number, arc = in_ranges(np.ones_like(count), count + 1)
    angle = arcs.angle[arc, 0] + width[arc] * number / count[arc]
    return arc, arc_points(arcs, arc, angle)


def _arc_commands(arcs: Arcs, arc: Ints, to: Floats) -> list[str]:
    """Write SVG's arc command for pieces of arcs (M,) that end at `to` (M, 2)."""
    longer = arcs.disk[arc, 2]
    if not arcs.tilt.any():  # circles
        return number_rows(
            "A{:.1f} {:.1f} 0 0 1 {:.2f} {:.2f}", np.column_stack([longer, longer, to])
        )
    shorter = longer * arcs.squeeze[arc, 0]
    turn = np.degrees(arcs.squeeze[arc, 1])
    return number_rows(
        "A{:.2f} {:.2f} {:.1f} 0 1 {:.2f} {:.2f}", np.column_stack([longer, shorter, turn, to])
    )
