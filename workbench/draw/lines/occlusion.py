"""Find what triangles and balls hide of arcs and straight lines, exactly."""

from __future__ import annotations

import math

import numpy as np

from workbench.draw.kernels.occlusion import Occluders, hidden_spans
from workbench.draw.lines.silhouettes import ball_extent, gaps_along
from workbench.geometry.box_pairs import box_pairs, in_ranges
from workbench.model.arrays import Bools, Floats, Ints
from workbench.sight.kernels.rasterization import MIN_AREA

__all__ = [
    "Occluders",
    "build_grid",
    "hidden_arcs",
    "hidden_lines",
    "lines_among_balls",
    "occluder_planes",
]

_CELL_SIZE = 8.0
"""Width [pixels] of the cells of the grid in which occluders are found."""
_LONGEST = 32.0
"""Length [pixels] above which a line is sought in pieces, whose boxes meet fewer cells."""
_MOST_PIECES = 256
"""Of one line, which may reach far beside the picture."""
_WIDEST = math.pi / 2.0
"""Angle [rad] above which an arc is sought in pieces."""
_LINES_AT_ONCE = 2_000_000
"""Pairs of lines and balls that are sought at a time, at most."""


# ------------------------------------------------------------------------------- triangles


def occluder_planes(corners: Floats, bias: float) -> Floats:
    """Compute the four functions that are at least 0 where a triangle hides a point.

    Parameters
    ----------
    corners
        (T, 3, 3) corners in picture space, see `kernels.occlusion`.
    bias
        Projective depth by which a point must lie behind the plane to be hidden.

    Returns
    -------
    Floats
        (T, 4, 4) coefficients a, b, c, d of the plane and of the three sides: depth [m], and
        distance [pixels] from each side. A triangle seen edge-on hides nothing: its first function
        is -1 everywhere.
    """
    one = corners[:, 1] - corners[:, 0]
    two = corners[:, 2] - corners[:, 0]
    area = one[:, 0] * two[:, 1] - two[:, 0] * one[:, 1]
    flat = np.abs(area) < MIN_AREA
    divisor = np.where(flat, 1.0, area)
    # change of depth per pixel to the right and down, by Cramer's rule
    right = (one[:, 2] * two[:, 1] - two[:, 2] * one[:, 1]) / divisor
    down = (two[:, 2] * one[:, 0] - one[:, 2] * two[:, 0]) / divisor
    x, y, depth = corners[:, 0].T
    planes = np.zeros((len(corners), 4, 4))
    planes[:, 0] = np.column_stack(
        [right, down, np.full(len(corners), -1.0), depth - right * x - down * y - bias]
    )
    planes[flat, 0] = [0.0, 0.0, 0.0, -1.0]
    along = np.roll(corners, -1, axis=1)[:, :, :2] - corners[:, :, :2]
    length = np.maximum(np.hypot(along[:, :, 0], along[:, :, 1]), MIN_AREA)
    dx, dy = np.moveaxis(along * (np.sign(area)[:, None] / length)[:, :, None], 2, 0)
    planes[:, 1:, 0] = -dy
    planes[:, 1:, 1] = dx
    planes[:, 1:, 3] = dy * corners[:, :, 0] - dx * corners[:, :, 1]
    return planes


def build_grid(planes: Floats, boxes: Floats, width: int, height: int) -> Occluders:
    """Sort triangles into the cells of a picture.

    Parameters
    ----------
    planes
        (T, 4, 4) as of `occluder_planes`, in the order in which they are to be asked.
    boxes
        (T, 4) least x, y and greatest x, y [pixels], none beside the picture.
    width, height
        Of the picture [pixels].
    """
    columns = math.ceil(width / _CELL_SIZE)
    rows = math.ceil(height / _CELL_SIZE)
    most = np.array([columns - 1, rows - 1])
    first = np.clip(np.floor(boxes[:, :2] / _CELL_SIZE).astype(np.int64), 0, most)
    last = np.clip(np.floor(boxes[:, 2:] / _CELL_SIZE).astype(np.int64), 0, most)
    row, box = in_ranges(first[:, 1], last[:, 1] + 1)
    cell, strip = in_ranges(row * columns + first[box, 0], row * columns + last[box, 0] + 1)
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(columns * rows + 1))
    return Occluders(planes, _CELL_SIZE, columns, rows, start, box[strip][order])


# --------------------------------------------------------------------------------- curves


def _hidden_parts(control: Floats, occluders: Occluders) -> tuple[Ints, Floats]:
    """Find what is hidden of curves (K, 3, 4), see `hidden_spans`.

    Returns
    -------
    tuple[Ints, Floats]
        The curve (R,), and s (R, 2) from and to.
    """
    points = control[:, :, :2] / control[:, :, 3:]
    boxes = np.column_stack([points.min(axis=1), points.max(axis=1)])
    spans = hidden_spans(control, boxes, occluders)
    return spans[:, 0].astype(np.int64), spans[:, 1:]


def _pieces(item: Ints, start: Floats, end: Floats, length: Floats) -> tuple[Ints, Floats, Bools]:
    """Cut lines of lengths (M,) where hidden intervals (R,) of them begin or end.

    Returns
    -------
    tuple[Ints, Floats, Bools]
        The line (K,) of each piece, in turn; where it begins and ends (K, 2); whether it is hidden.
    """
    seen = gaps_along(item, start, end, length)
    rest = gaps_along(seen.item, seen.low, seen.high, length)
    of = np.concatenate([seen.item, rest.item])
    low = np.concatenate([seen.low, rest.low])
    high = np.concatenate([seen.high, rest.high])
    order = np.lexsort((low, of))
    return of[order], np.column_stack([low, high])[order], order >= len(seen.item)


def hidden_arcs(rims: Floats, angle: Floats, occluders: Occluders) -> tuple[Ints, Floats, Bools]:
    """Cut arcs of ellipses where triangles start or end to hide them.

    Parameters
    ----------
    rims
        (A, 3, 3) middle m and half axes u, v of ellipses m + cos(t) u + sin(t) v in picture space.
    angle
        (A, 2) angles t [rad] from and to, at most a turn apart.
    occluders
        The triangles that hide.

    Returns
    -------
    tuple[Ints, Floats, Bools]
        The arc (K,) of each piece, in turn; its angles (K, 2); and whether it is hidden.
    """
    width = angle[:, 1] - angle[:, 0]
    count = np.maximum(np.ceil(width / _WIDEST), 1.0).astype(np.int64)
    number, arc = in_ranges(np.zeros_like(count), count)
    half = (0.5 * width / count)[arc]
    middle = (2 * number + 1) * half
    frames = np.concatenate([rims, np.zeros((len(rims), 3, 1))], axis=2)[arc]
    frames[:, 0, 3] = 1.0
    # with half the angle h the control point between is m + e(t) / cos(h), and its weight cos(h)
    turns = angle[arc, 0] + middle
    rows = [
        np.column_stack([weight, np.cos(turn), np.sin(turn)])
        for weight, turn in (
            (np.ones(len(arc)), turns - half),
            (np.cos(half), turns),
            (np.ones(len(arc)), turns + half),
        )
    ]
    part, s = _hidden_parts(np.stack(rows, axis=1) @ frames, occluders)
    bow = half[part, None]
    across = (2.0 * s - 1.0) * np.sin(bow)
    along = ((1.0 - s) ** 2 + s**2) * np.cos(bow) + 2.0 * s * (1.0 - s)
    start, end = (middle[part, None] + np.arctan2(across, along)).T
    of, turned, hidden = _pieces(arc[part], start, end, width)
    to = np.where(turned[:, 1] == width[of], angle[of, 1], angle[of, 0] + turned[:, 1])
    return of, np.column_stack([angle[of, 0] + turned[:, 0], to]), hidden


def hidden_lines(ends: Floats, occluders: Occluders) -> tuple[Ints, Floats, Bools]:
    """Cut straight lines where triangles start or end to hide them.

    Parameters
    ----------
    ends
        (M, 2, 3) ends of the lines in picture space.
    occluders
        The triangles that hide.

    Returns
    -------
    tuple[Ints, Floats, Bools]
        The line (K,) of each piece, in turn; shares (K, 2) of its length, from and to; and whether
        it is hidden.
    """
    extent = np.abs(ends[:, 1, :2] - ends[:, 0, :2]).max(axis=1)
    count = np.clip(np.ceil(extent / _LONGEST), 1, _MOST_PIECES).astype(np.int64)
    number, line = in_ranges(np.zeros_like(count), count)
    parts = count[line]
    share = np.column_stack([number, number + 0.5, number + 1]) / parts[:, None]
    points = np.concatenate([ends, np.ones((len(ends), 2, 1))], axis=2)[line]
    # in this form a coordinate that is the same at both ends stays exactly as it is
    control = points[:, :1] + (points[:, 1:] - points[:, :1]) * share[:, :, None]
    part, s = _hidden_parts(control, occluders)
    start, end = ((number[part, None] + s) / parts[part, None]).T
    return _pieces(line[part], start, end, np.ones(len(ends)))


# -------------------------------------------------------------------------- lines and balls


def lines_among_balls(ends: Floats, balls: Floats, distance: float) -> tuple[Ints, Floats, Bools]:
    """Find the pieces of straight lines that no ball hides.

    Parameters
    ----------
    ends
        (M, 2, 3) ends of the lines, view coordinates [m].
    balls
        (S, 4) view coordinates of the centres, and radii [m].
    distance
        Depth [m] of the eye; infinite in a parallel view.

    Returns
    -------
    tuple[Ints, Floats, Bools]
        The line (K,) of each piece, in turn; shares (K, 2) of its length, from and to; and whether
        a ball is behind it.
    """
    size = max(_LINES_AT_ONCE // max(len(balls), 1), 1)
    found = [
        _among_balls(ends[first : first + size], balls, distance)
        for first in range(0, max(len(ends), 1), size)
    ]
    line = [part[0] + size * k for k, part in enumerate(found)]
    shares = np.concatenate([part[1] for part in found])
    return np.concatenate(line), shares, np.concatenate([part[2] for part in found])


def _among_balls(ends: Floats, balls: Floats, distance: float) -> tuple[Ints, Floats, Bools]:
    """As `lines_among_balls`."""
    line, ball = box_pairs(*_seen_boxes(ends, balls, distance))
    p = ends[line, 0]
    d = ends[line, 1] - p
    off = p - balls[ball, :3]
    square = balls[ball, 3] ** 2
    if math.isinf(distance):
        # over the outline |(x, y)| < r, and behind the rim where z < 0
        flat = np.array([1.0, 1.0, 0.0])
        over = _negative(_dot(d, flat * d), _dot(off, flat * d), _dot(off, flat * off) - square)
        level = -off[:, 2]
        slope = -d[:, 2]
    else:
        # The outline is the cone (u . X)^2 = (u . u - r^2) X . X around the axis u, and the rim
        # lies in the plane u . X = u . u - r^2.
        eye = np.array([0.0, 0.0, distance])
        u = balls[ball, :3] - eye
        x = p - eye
        inner = _dot(u, u) - square
        level = _dot(u, x)
        slope = _dot(u, d)
        over = _negative(
            inner * _dot(d, d) - slope**2,
            inner * _dot(x, d) - level * slope,
            inner * _dot(x, x) - level**2,
            slope,
        )
        over = _within(over, _positive(level, slope))
        over[inner <= 0.0] = [0.0, -1.0]  # a ball that holds the eye is not drawn
        level = level - inner
    behind = _within(over, _positive(level, slope))
    inside = _within(_negative(_dot(d, d), _dot(off, d), _dot(off, off) - square), over)
    length = np.ones(len(ends))
    hiding = np.concatenate([behind, inside])
    is_real = hiding[:, 1] > hiding[:, 0]
    hidden = np.concatenate([line, line])[is_real]
    hiding = hiding[is_real]
    is_over = over[:, 1] > over[:, 0]
    covered = np.concatenate([hiding, over[is_over]])
    plain = gaps_along(
        np.concatenate([hidden, line[is_over]]), covered[:, 0], covered[:, 1], length
    )
    # what is neither hidden nor plain is before a ball
    rest = np.concatenate([hiding, np.column_stack([plain.low, plain.high])])
    before = gaps_along(np.concatenate([hidden, plain.item]), rest[:, 0], rest[:, 1], length)
    of = np.concatenate([plain.item, before.item])
    share = np.column_stack(
        [np.concatenate([plain.low, before.low]), np.concatenate([plain.high, before.high])]
    )
    order = np.lexsort((share[:, 0], of))
    return of[order], share[order], order >= len(plain.item)


def _seen_boxes(ends: Floats, balls: Floats, distance: float) -> tuple[Floats, Floats]:
    """Return boxes (M, 4) of lines and (S, 4) of balls in the picture, in any unit."""
    x, y, z, radius = balls.T
    points = ends[:, :, :2]
    if math.isinf(distance):
        sides = [x - radius, y - radius, x + radius, y + radius]
    else:
        points = points / (distance - ends[:, :, 2:])
        left, right = ball_extent(x, distance - z, radius)
        top, bottom = ball_extent(y, distance - z, radius)
        sides = [left, top, right, bottom]
    boxes = np.column_stack([points.min(axis=1), points.max(axis=1)])
    return boxes, np.column_stack(sides)


def _dot(a: Floats, b: Floats) -> Floats:
    """Return the products (K,) of vectors (K, 3)."""
    return np.einsum("ij,ij->i", a, b)


def _within(one: Floats, other: Floats) -> Floats:
    """Return what lies in both of intervals (K, 2); an end before its start means nothing."""
    return np.column_stack([np.maximum(one[:, 0], other[:, 0]), np.minimum(one[:, 1], other[:, 1])])


def _positive(level: Floats, slope: Floats) -> Floats:
    """Return where (K, 2) level + slope t > 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = np.where(slope == 0.0, np.where(level > 0.0, -np.inf, np.inf), -level / slope)
    return np.column_stack(
        [np.where(slope >= 0.0, zero, -np.inf), np.where(slope < 0.0, zero, np.inf)]
    )


def _negative(a: Floats, b: Floats, c: Floats, slope: Floats | None = None) -> Floats:
    """Return where (K, 2) a t^2 + 2 b t + c < 0 within 0 to 1.

    slope: where a < 0, the outer part on this side, (K,): the line also crosses the mirrored cone
    behind the eye there.
    """
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        one = (-b - root) / a
        two = (-b + root) / a
    low = np.where(a > 0.0, one, np.where(c < 0.0, 0.0, 1.0))
    high = np.where(a > 0.0, two, np.where(c < 0.0, 1.0, 0.0))
    if slope is not None:
        low = np.where(a < 0.0, np.where(slope > 0.0, np.maximum(one, two), -np.inf), low)
        high = np.where(a < 0.0, np.where(slope > 0.0, np.inf, np.minimum(one, two)), high)
    return np.column_stack([np.maximum(low, 0.0), np.minimum(high, 1.0)])
