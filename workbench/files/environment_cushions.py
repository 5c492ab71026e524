"""The front of a cushion, as thighs lie on it: a section of its part, from half its length to its
front edge."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Allowance, CushionFront, Environment, Seat
from workbench.model.posing import attitude_matrix

__all__ = ["cushion_front"]

_THIGHS = {"LUL", "RUL", "all"}
_ASIDE = 0.1
"""How far [m] beside the middle of the seat the section is taken, on both sides: under the thighs,
inside of side bolsters."""
_FROM = 0.5
"""Where the front begins, as a share of the cushion's length."""
_FLAT = 1e-9


def cushion_front(
    environment: Environment, seat: Seat, allowances: Iterable[Allowance]
) -> CushionFront | None:
    """Return what thighs rest on in a seat: the convex upper side of the front of its cushion.

    It gives as much as the cushion's part allows thighs to enter, and at least as much as hips sink
    into it. None where the part does not reach under the thighs.

    Parameters
    ----------
    environment
        The parts.
    seat
        The seat where it stands at rest.
    allowances
        What is allowed to enter parts.
    """
    points = _section(environment, seat)
    length = points[..., 0].max(initial=0.0)
    chain = _upper_chain(_beyond(points, _FROM * length))
    if len(chain) < 2:
        return None
    along, above = (chain[1:] - chain[:-1]).T
    normal = np.stack([-above, along], axis=1)
    normal = normal[along > _FLAT] / np.hypot(along, above)[along > _FLAT, None]
    offset = np.sum(normal * chain[:-1][along > _FLAT], axis=1)
    faces = [*np.column_stack([normal, offset]).tolist(), [1.0, 0.0, float(length)]]
    part = environment.part_index(seat.cushion.part)
    allowed = [a.depth for a in allowances if a.part == part and _THIGHS & set(a.segments)]
    gives = max([seat.cushion.depth, *allowed])
    return CushionFront(tuple((a, b, c) for a, b, c in faces), gives)


def _section(environment: Environment, seat: Seat) -> Floats:
    """(L, 2, 2) [m] lines in which upright planes under the thighs cut the cushion: end, along and
    above from the seat reference point."""
    heading = attitude_matrix(yaw=seat.yaw)
    c = np.cos(seat.cushion_angle)
    s = np.sin(seat.cushion_angle)
    axes = heading @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    part = environment.part_index(seat.cushion.part)
    corners = (environment.triangle_corners(part) - np.array(seat.srp)) @ axes
    lines = []
    for aside in (-_ASIDE, _ASIDE):
        side = corners[..., 1] - aside
        cut = (side < 0.0) != (np.roll(side, -1, axis=1) < 0.0)
        crossing = cut.any(axis=1)
        share = side[crossing] / np.where(
            cut[crossing], side[crossing] - np.roll(side[crossing], -1, axis=1), 1.0
        )
        first = corners[crossing]
        met = first + share[..., None] * (np.roll(first, -1, axis=1) - first)
        lines.append(met[cut[crossing]].reshape(-1, 2, 3)[..., [0, 2]])
    return np.concatenate(lines)


def _beyond(lines: Floats, least: float) -> Floats:
    """(P, 2) ends of lines (L, 2, 2), of which all before `least` along is cut off."""
    kept = lines[lines[..., 0].max(axis=1) > least]
    way = kept[:, ::-1] - kept
    short = kept[..., 0] < least
    share = np.where(short, (least - kept[..., 0]) / np.where(short, way[..., 0], 1.0), 0.0)
    met: Floats = kept + share[..., None] * way
    return met.reshape(-1, 2)


def _upper_chain(points: Floats) -> Floats:
    """(C, 2) the upper side of the convex hull of points, from rear to front (Andrew's monotone
    chain)."""
    chain: list[Floats] = []
    for point in points[np.lexsort((points[:, 1], points[:, 0]))]:
        while len(chain) > 1 and _left_turn(chain[-2], chain[-1], point):
            chain.pop()
        chain.append(point)
    return np.array(chain).reshape(-1, 2)


def _left_turn(a: Floats, b: Floats, c: Floats) -> bool:
    """Whether the way over three points turns left, or goes straight on."""
    ahead = b - a
    beyond = c - b
    return bool(ahead[0] * beyond[1] - ahead[1] * beyond[0] >= -_FLAT * _FLAT)
