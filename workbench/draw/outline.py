"""The paper's line drawing: the visible outline of the bodies as exact circular arcs, as a self-contained SVG text.

Each rim is cut where other spheres hide it, in closed form (kernels.arcs); nothing is traced from pixels. Between
spheres of one segment or of segments that a joint joins only steps of depth above JOINT_STEP, and above JOINT_SHARE of
the rim's radius, are drawn: creases vanish and a limb fades into the body at its joint, while an arm in front of the
chest keeps its outline. Other bodies hide without that allowance. Specks are left out: lines of a few pixels that
connect nothing, and chinks between fingers.

What stands between the viewer and a body must not hide it: arcs behind an opaque polygon are drawn as a thin, pale
line. Where they change is found on the environment's depth buffer, at points one pixel apart or closer, and so is true
to within 2 pixels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, hexadecimal
from workbench.draw.edges import drawn_edges, visible_lines
from workbench.draw.scene import Scene
from workbench.draw.svg import environment_paths, page
from workbench.draw.visibility import Layers, projected_disks, visible_layers
from workbench.kernels.arcs import arc_chains, ends_met, rim_arcs
from workbench.kernels.rims import parallel_rims
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body

__all__ = ["JOINT_SHARE", "JOINT_STEP", "Arcs", "outline", "outline_arcs"]

JOINT_STEP = 0.013  # [m] with 12 to 15 mm ripples are gone and limbs still stand out
JOINT_SHARE = 0.4  # of the radius: rings of a thigh seen along its length are steps of up to about a third of it
_SPECK = 9.0  # [pixels] shorter lines that connect nothing are not drawn
_CHINK = 24.0  # [pixels] so is the rim of a smaller hole
_MEET = 0.5  # [pixels] a line that ends so near another one meets it
_TINY = 0.3  # [pixels] shorter arcs are run together
_WIDEST = 2.1  # [rad] longer arcs are drawn in pieces: rounded ends leave those near half a turn ill-determined
_STEP = 1.0  # [pixels] between points tested against the environment
_BIAS = 1e-3  # [m] a polygon that touches the rim does not hide it
_PENS = (  # what is drawn first, and how: class, outer, veiled, stroke width and opacity
    ("veiled", False, True, 'stroke-width="0.6" stroke-opacity="0.4"'),
    ("veiled", True, True, 'stroke-width="0.8" stroke-opacity="0.5"'),
    ("inner", False, False, 'stroke-width="1.1"'),
    ("outer", True, False, 'stroke-width="1.8"'),
)


class Arcs(NamedTuple):
    """Visible arcs of rims, angles from +x (right) to +y (down) of the picture.

    sphere (A,): of the scene's spheres; disk (A, 3): x, y, radius [pixels]; depth (A,) [m]; angle (A, 2) [rad] from
    and to; lead (A, 2): the spheres whose arcs lead into this one and go on after it, -1 for none, its own for a
    closed circle; outer (A,): against the background; veiled (A,): behind an opaque polygon; body (A,).
    """

    sphere: Ints
    disk: Floats
    depth: Floats
    angle: Floats
    lead: Ints
    outer: Bools
    veiled: Bools
    body: Ints


def outline(scene: Scene, camera: Camera) -> str:
    """SVG text of width x height of the camera: environment's edges, then the bodies' outlines, then marks.

    Outer contours are heavier than those inside. No script, no reference to anything outside; labels are escaped.
    """
    arcs, parts = outline_arcs(scene, camera), []
    if scene.environment is not None:
        layers = visible_layers(scene, camera)
        arcs = _veiled(arcs, layers)
        parts = environment_paths(visible_lines(*drawn_edges(scene.environment, camera, layers.cut), layers))
    return page(scene, camera, "a line drawing of the outline", [*parts, *_bodies(scene, arcs)])


def outline_arcs(scene: Scene, camera: Camera, *, step: float = JOINT_STEP, share: float = JOINT_SHARE) -> Arcs:
    """The visible arcs of a scene's bodies, whatever the environment.

    step [m], share: of depth between joined segments, see the module; 0 and 0: everything that shows.
    """
    flat, body = projected_disks(scene, camera), scene.spheres.body
    balls = np.column_stack([flat.disk[:, :2], flat.centre * camera.scale, flat.disk[:, 2]])
    segment, joined = _segments(scene)
    steps = camera.scale * np.maximum(step, share * flat.radius)
    angle, keys = rim_arcs(parallel_rims(balls, segment, body, joined, steps))
    sphere = keys[:, 0]
    veiled = np.zeros(len(angle), dtype=np.bool_)
    return Arcs(
        sphere, flat.disk[sphere], flat.centre[sphere], angle, keys[:, 1:3], keys[:, 3] == 1, veiled, body[sphere]
    )


def _segments(scene: Scene) -> tuple[Ints, Bools]:
    """(S,) the segment of each sphere, counted through all bodies, and (N, N) which of them are one or joined."""
    first = np.cumsum([0, *(len(shown.placed.body.segments) for shown in scene.bodies)])
    joined = np.zeros((first[-1], first[-1]), dtype=np.bool_)
    numbers = [np.empty(0, dtype=np.int64)]
    for shown, low, high in zip(scene.bodies, first[:-1], first[1:], strict=True):
        segment = shown.placed.body.sphere_segment
        numbers.append(low + segment[shown.placed.window[segment]])
        joined[low:high, low:high] = _joined(shown.placed.body)
    return np.concatenate(numbers), joined


def _joined(body: Body) -> Bools:
    """(N, N) a joint joins the two segments, or they are one."""
    child = np.arange(1, len(body.parent))
    joined = np.eye(len(body.parent), dtype=np.bool_)
    joined[child, body.parent[1:]] = joined[body.parent[1:], child] = True
    return joined


def _points(disk: Floats, angle: Floats) -> Floats:
    """(M, 2) [pixels] points of rims, disk (M, 3), at angles (M,)."""
    points: Floats = disk[:, :2] + disk[:, 2:] * np.column_stack([np.cos(angle), np.sin(angle)])
    return points


def _veiled(arcs: Arcs, layers: Layers) -> Arcs:
    """Cut arcs where an opaque polygon comes in front of them or goes."""
    width = arcs.angle[:, 1] - arcs.angle[:, 0]
    count = np.ceil(width * arcs.disk[:, 2] / _STEP).astype(np.int64) + 1
    arc = np.repeat(np.arange(len(count)), count)
    first = np.cumsum(count) - count
    number = np.arange(len(arc)) - first[arc]
    angle = arcs.angle[arc, 0] + width[arc] * (number + 0.5) / count[arc]  # middles of equal pieces
    x, y = np.floor(_points(arcs.disk[arc], angle)).astype(np.int64).T
    high, wide = layers.depth.shape
    inside = (x >= 0) & (x < wide) & (y >= 0) & (y < high)
    behind = np.zeros(len(arc), dtype=np.bool_)
    behind[inside] = layers.depth[y[inside], x[inside]] > arcs.depth[arc[inside]] + _BIAS
    start = np.flatnonzero((number == 0) | (np.diff(behind, prepend=False) != 0))
    last = np.append(start[1:], len(arc))[: len(start)] - 1
    of = arc[start]
    from_, to = number[start] / count[of], (number[last] + 1) / count[of]
    lead = arcs.lead[of].copy()
    lead[from_ > 0.0, 0] = lead[to < 1.0, 1] = -1
    cut = arcs.angle[of, :1] + width[of, None] * np.column_stack([from_, to])
    return Arcs(arcs.sphere[of], arcs.disk[of], arcs.depth[of], cut, lead, arcs.outer[of], behind[start], arcs.body[of])


def _following(arcs: Arcs) -> Ints:
    """(A,) the arc that goes on where one ends, -1 for none: by the pair of spheres that meet there."""
    base = int(arcs.sphere.max(initial=0)) + 2
    kind = (arcs.veiled * 2 + arcs.outer) * base * base
    start = kind + (arcs.lead[:, 0] + 1) * base + arcs.sphere + 1
    end = kind + (arcs.sphere + 1) * base + arcs.lead[:, 1] + 1
    order = np.argsort(start, kind="stable")
    found = order[np.minimum(np.searchsorted(start[order], end), len(order) - 1)]
    return np.where((start[found] == end) & (arcs.lead[:, 1] >= 0), found, -1)


def _bodies(scene: Scene, arcs: Arcs) -> list[str]:
    """A path for each pen and body."""
    parts = ['<g class="bodies" fill="none" stroke-linecap="round" stroke-linejoin="round">']
    following = _following(arcs)
    order, start = arc_chains(following)
    last = np.append(start[1:], len(order))[: len(start)] - 1
    drawn = Arcs(*(column[order] for column in arcs))
    closed = following[order[last]] == order[start]
    texts = _chain_texts(drawn, start, closed, _wanted(drawn, start, last, closed))
    first = order[start]
    for name, outer, veiled, style in _PENS:
        for body, shown in enumerate(scene.bodies):
            mine = (arcs.outer[first] == outer) & (arcs.veiled[first] == veiled) & (arcs.body[first] == body)
            path = "".join(texts[chain] for chain in np.flatnonzero(mine))
            if path:
                ink = hexadecimal(INKS[shown.colour])
                parts.append(f'<path class="{name}" stroke="{ink}" {style} d="{path}"/>')
    return [*parts, "</g>"]


def _wanted(arcs: Arcs, start: Ints, last: Ints, closed: Bools) -> Bools:
    """(C,) the chain from arc start to arc last is no speck: it is long, or goes round a body, or is a bridge."""
    if not len(start):
        return closed
    begin, end = _points(arcs.disk, arcs.angle[:, 0]), _points(arcs.disk, arcs.angle[:, 1])
    length = np.add.reduceat((arcs.angle[:, 1] - arcs.angle[:, 0]) * arcs.disk[:, 2], start)
    turn = np.add.reduceat(begin[:, 0] * end[:, 1] - begin[:, 1] * end[:, 0], start)
    hole = closed & (turn < 0.0)  # its chain runs round against its arcs
    least = np.where(hole, _CHINK, np.where(closed & arcs.outer[start], _TINY, _SPECK))
    wanted: Bools = length >= least
    short = np.flatnonzero(~wanted & (length >= _TINY) & ~closed)
    wanted[short] = _bridges(arcs, begin[start[short]], end[last[short]], short, wanted, last - start + 1)
    return wanted


def _bridges(arcs: Arcs, begin: Floats, end: Floats, short: Ints, long: Bools, count: Ints) -> Bools:
    """Which of the `short` chains, from begin to end, meet another one at both ends, and a long one at least at one.

    long (C,), count (C,): of all chains, their arcs.
    """
    points, own, chain = np.concatenate([begin, end]), np.tile(short, 2), np.repeat(np.arange(len(count)), count)
    met = [
        ends_met(points, own, arcs.disk[among], arcs.angle[among], chain[among], _MEET).reshape(2, -1)
        for among in (np.ones(len(chain), dtype=np.bool_), long[chain])
    ]
    both: Bools = met[0].all(axis=0) & met[1].any(axis=0)
    return both


def _chain_texts(arcs: Arcs, start: Ints, closed: Bools, wanted: Bools) -> list[str]:
    """Path commands of each chain: of the arcs from its start (C,) to the next one's; "" where it is not wanted."""
    width = arcs.angle[:, 1] - arcs.angle[:, 0]
    length = width * arcs.disk[:, 2]
    end = np.cumsum(length)
    chain = np.repeat(np.arange(len(start)), np.diff(start, append=len(width)))
    run = end - (end - length)[start][chain]  # [pixels] from the chain's beginning to each arc's end
    kept = np.floor(run / _TINY) > np.floor((run - length) / _TINY)
    pieces = np.where(kept, np.ceil(width / _WIDEST).astype(np.int64), 0)
    arc = np.repeat(np.arange(len(width)), pieces)
    number = np.arange(len(arc)) - np.repeat(np.cumsum(pieces) - pieces, pieces) + 1
    to = _points(arcs.disk[arc], arcs.angle[arc, 0] + width[arc] * number / pieces[arc])
    drawn = [
        f"A{radius:.1f} {radius:.1f} 0 0 1 {x:.2f} {y:.2f}"
        for radius, (x, y) in zip(arcs.disk[arc, 2].tolist(), to.tolist(), strict=True)
    ]
    cut = np.searchsorted(chain[arc], np.arange(len(start) + 1)).tolist()
    begin = _points(arcs.disk[start], arcs.angle[start, 0]).tolist()
    return [
        f"M{x:.2f} {y:.2f}{''.join(drawn[low:high])}{'Z' if whole else ''}" if here and high > low else ""
        for (x, y), low, high, whole, here in zip(begin, cut, cut[1:], closed.tolist(), wanted.tolist(), strict=False)
    ]
