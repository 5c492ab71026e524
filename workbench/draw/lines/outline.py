"""The paper's line drawing: the visible outline of the bodies as exact circular arcs, as a
self-contained SVG text.

Each rim is cut where other spheres hide it, in closed form (kernels.pictures.arcs); nothing is
traced. Between spheres of one segment or of segments that a joint joins only steps of depth above
JOINT_STEP, and above JOINT_SHARE of the rim's radius, are drawn: creases vanish and a limb fades
into the body at its joint, while an arm in front of the chest keeps its outline. Other bodies hide
without that allowance. Specks are left out: lines of a few pixels that connect nothing, and chinks
between fingers.

What stands between the viewer and a body must not hide it: arcs behind an opaque polygon are drawn
as a thin, pale line, or left out in the style hidden_line. Where they change is exact too (see
hiding). Ghosts lie under the bodies.
"""

from __future__ import annotations

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, PAPER, hexadecimal
from workbench.draw.ghosts import ghost_strengths
from workbench.draw.kernels.arcs import arc_chains, ends_met
from workbench.draw.lines.arcs import Arcs, arc_lengths, arc_points, outline_arcs
from workbench.draw.lines.hidden_lines import split_hidden_arcs, surroundings
from workbench.draw.lines.svg import environment_paths, number_rows, page, section_paths
from workbench.draw.scene import Scene
from workbench.draw.visibility import projected_disks
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["body_paths", "ghost_paths", "outline"]

_SPECK = 9.0  # [pixels] shorter lines that connect nothing are not drawn
_CHINK = 24.0  # [pixels] so is the rim of a smaller hole
_MEET = 0.5  # [pixels] a line that ends so near another one meets it
_TINY = 0.3  # [pixels] shorter arcs are run together
# [rad] longer arcs are drawn in pieces: rounded ends leave those near half a turn ill-determined
_WIDEST = 2.1
_PENS = (  # what is drawn first, and how: class, outer, veiled, stroke width and opacity
    ("veiled", False, True, 'stroke-width="0.6" stroke-opacity="0.4"'),
    ("veiled", True, True, 'stroke-width="0.8" stroke-opacity="0.5"'),
    ("inner", False, False, 'stroke-width="1.1"'),
    ("outer", True, False, 'stroke-width="1.8"'),
)


def outline(scene: Scene, camera: Camera, *, hidden: str = "veiled") -> str:
    """SVG text of width x height of the camera: environment's edges, then the bodies' outlines,
    then marks.

    hidden: veiled draws what is behind a wall as a thin, pale line; hidden_line leaves it out.
    Outer contours are heavier than those inside. No script, no reference to anything outside;
    labels are escaped.
    """
    arcs = outline_arcs(scene, camera)
    walls = surroundings(scene, camera, hidden)
    if walls is not None:
        arcs = split_hidden_arcs(arcs, walls.hiders)
        if hidden == "hidden_line":
            arcs = Arcs._make(column[~arcs.veiled] for column in arcs)
    parts = [*ghost_paths(scene, camera), *body_paths(scene, arcs)]
    if walls is not None:
        parts = [*environment_paths(walls.lines), *parts, *section_paths(walls.sections, hidden)]
    return page(scene, camera, "a line drawing of the outline", parts)


def ghost_paths(scene: Scene, camera: Camera) -> list[str]:
    """The outlines of a scene's ghosts, pale, and the bodies' disks in paper, which hide them."""
    if not scene.ghosts:
        return []
    parts = []
    for shown, strength in zip(scene.ghosts, ghost_strengths(scene).tolist(), strict=True):
        alone = Scene((shown,))
        parts += [
            f'<g class="ghost" stroke-opacity="{strength:.2f}">',
            *body_paths(alone, outline_arcs(alone, camera)),
        ]
        parts.append("</g>")
    flat = projected_disks(scene, camera)
    disks = number_rows('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}"/>', flat.disk[flat.order])
    return [*parts, f'<g class="cover" fill="{hexadecimal(PAPER)}">', *disks, "</g>"]


def _following(arcs: Arcs) -> Ints:
    """(A,) the arc that goes on where one ends, -1 for none: by the pair of spheres that meet
    there."""
    base = int(arcs.sphere.max(initial=0)) + 2
    kind = (arcs.veiled * 2 + arcs.outer) * base * base
    start = kind + (arcs.lead[:, 0] + 1) * base + arcs.sphere + 1
    end = kind + (arcs.sphere + 1) * base + arcs.lead[:, 1] + 1
    order = np.argsort(start, kind="stable")
    found = order[np.minimum(np.searchsorted(start[order], end), len(order) - 1)]
    return np.where((start[found] == end) & (arcs.lead[:, 1] >= 0), found, -1)


def body_paths(scene: Scene, arcs: Arcs) -> list[str]:
    """SVG elements of a scene's arcs: a path for each pen and body."""
    parts = ['<g class="bodies" fill="none" stroke-linecap="round" stroke-linejoin="round">']
    following = _following(arcs)
    order, start = arc_chains(following)
    last = np.append(start[1:], len(order))[: len(start)] - 1
    drawn = Arcs._make(column[order] for column in arcs)
    closed = following[order[last]] == order[start]
    texts = _chain_texts(drawn, start, closed, _wanted(drawn, start, last, closed))
    first = order[start]
    for name, outer, veiled, style in _PENS:
        for body, shown in enumerate(scene.bodies):
            mine = (
                (arcs.outer[first] == outer)
                & (arcs.veiled[first] == veiled)
                & (arcs.body[first] == body)
            )
            path = "".join(texts[chain] for chain in np.flatnonzero(mine))
            if path:
                ink = hexadecimal(INKS[shown.colour])
                parts.append(f'<path class="{name}" stroke="{ink}" {style} d="{path}"/>')
    return [*parts, "</g>"]


def _wanted(arcs: Arcs, start: Ints, last: Ints, closed: Bools) -> Bools:
    """(C,) the chain from arc start to arc last is no speck: it is long, or goes round a body, or
    is a bridge."""
    if not len(start):
        return closed
    each = np.arange(len(arcs.sphere))
    begin = arc_points(arcs, each, arcs.angle[:, 0])
    end = arc_points(arcs, each, arcs.angle[:, 1])
    length = np.add.reduceat(arc_lengths(arcs), start)
    turn = np.add.reduceat(begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0], start)
    hole = closed & (turn < 0.0)  # its chain runs round against its arcs
    least = np.where(hole, _CHINK, np.where(closed & arcs.outer[start], _TINY, _SPECK))
    wanted: Bools = length >= least
    short = np.flatnonzero(~wanted & (length >= _TINY) & ~closed)
    wanted[short] = _bridges(
        arcs, begin[start[short]], end[last[short]], short, wanted, last - start + 1
    )
    return wanted


def _bridges(
    arcs: Arcs, begin: Floats, end: Floats, short: Ints, long: Bools, count: Ints
) -> Bools:
    """Which of the `short` chains, from begin to end, meet another one at both ends, and a long one
    at least at one.

    long (C,), count (C,): of all chains, their arcs.
    """
    rims = np.column_stack([arcs.disk, arcs.squeeze])
    points = np.concatenate([begin, end])
    own = np.tile(short, 2)
    chain = np.repeat(np.arange(len(count)), count)
    met = ends_met(points, own, rims, arcs.angle, chain, long, _MEET).reshape(2, -1, 2)
    both: Bools = met[:, :, 0].all(axis=0) & met[:, :, 1].any(axis=0)
    return both


def _chain_texts(arcs: Arcs, start: Ints, closed: Bools, wanted: Bools) -> list[str]:
    """Path commands of each chain: of the arcs from its start (C,) to the next one's; "" where it
    is not wanted."""
    width = arcs.angle[:, 1] - arcs.angle[:, 0]
    length = arc_lengths(arcs)
    end = np.cumsum(length)
    chain = np.repeat(np.arange(len(start)), np.diff(start, append=len(width)))
    run = (
        end - (end - length)[start][chain]
    )  # [pixels] from the chain's beginning to each arc's end
    kept = np.floor(run / _TINY) > np.floor((run - length) / _TINY)
    pieces = np.where(kept, np.ceil(width / _WIDEST).astype(np.int64), 0)
    arc = np.repeat(np.arange(len(width)), pieces)
    number = np.arange(len(arc)) - np.repeat(np.cumsum(pieces) - pieces, pieces) + 1
    to = arc_points(arcs, arc, arcs.angle[arc, 0] + width[arc] * number / pieces[arc])
    drawn = _commands(arcs, arc, to)
    cut = np.searchsorted(chain[arc], np.arange(len(start) + 1)).tolist()
    begin = arc_points(arcs, start, arcs.angle[start, 0]).tolist()
    return [
        f"M{x:.2f} {y:.2f}{''.join(drawn[low:high])}{'Z' if whole else ''}"
        if here and high > low
        else ""
        for (x, y), low, high, whole, here in zip(
            begin, cut, cut[1:], closed.tolist(), wanted.tolist(), strict=False
        )
    ]


def _commands(arcs: Arcs, which: Ints, to: Floats) -> list[str]:
    """SVG's arc command for each piece of the arcs `which` (M,) that ends at `to` (M, 2)."""
    longer = arcs.disk[which, 2]
    if not arcs.tilt.any():
        return number_rows(
            "A{:.1f} {:.1f} 0 0 1 {:.2f} {:.2f}", np.column_stack([longer, longer, to])
        )
    shorter = longer * arcs.squeeze[which, 0]
    turn = np.degrees(arcs.squeeze[which, 1])
    return number_rows(
        "A{:.2f} {:.2f} {:.1f} 0 1 {:.2f} {:.2f}", np.column_stack([longer, shorter, turn, to])
    )
