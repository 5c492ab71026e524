"""Find the connected pieces of a body's spheres in the zero pose.

A body that is meant to be one solid may fall into pieces at a low level of detail, most of all in
the hands. Something thin may then lie between two pieces without touching either, and a clearance
comes out too large.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.body.scaling.morph import morph
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body

__all__ = ["Pieces", "body_pieces", "piece_warnings"]

_NAMED = 4
"""Segments that a warning names before it stops."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pieces of a body, the one of most spheres first.

    piece (S,): the piece of each sphere, from 0; gap (count,) [m]: the distance from each piece to
    the nearest sphere of another, 0 for a body that is whole.
    """

    count: int
    piece: Ints
    gap: Floats


def body_pieces(body: Body) -> Pieces:
    """Find which spheres of a body hang together by touching one another in the zero pose.

    Parameters
    ----------
    body
        A body of S spheres.

    Returns
    -------
    Pieces
        Their number, and the piece of each sphere (S,).
    """
    centres = body.centre[0] + body.zero_origins[0, body.sphere_segment]
    found = np.full(len(centres), -1, dtype=np.int64)
    count = 0
    while (left := np.flatnonzero(found < 0)).size:
        _flood(centres, body.radius[0], found, first=int(left[0]), number=count)
        count += 1
    sizes = np.bincount(found, minlength=count)
    order = np.argsort(-sizes, kind="stable")
    piece = np.argsort(order)[found]
    gap = np.zeros(count)
    if count > 1:
        gap = np.array([_gap(centres, body.radius[0], piece == number) for number in range(count)])
    return Pieces(count, piece, gap)


def piece_warnings(bodies: Iterable[tuple[str, Body]]) -> list[str]:
    """Describe the bodies that are in pieces.

    Parameters
    ----------
    bodies
        Bodies, each with what it is called in the warning.

    Returns
    -------
    list[str]
        A sentence for each body in pieces, with all who have it, the widest gap, the segments, and
        the levels of detail of its family whose bodies are whole.
    """
    names_by_sentence: dict[str, list[str]] = {}
    for name, body in bodies:
        found = body_pieces(body)
        if found.count > 1:
            names_by_sentence.setdefault(_sentence(body, found), []).append(name)
    return [f"{', '.join(names)}: {sentence}" for sentence, names in names_by_sentence.items()]


def _flood(centres: Floats, radius: Floats, found: Ints, *, first: int, number: int) -> None:
    """Give one piece its number, from its first sphere on."""
    front = [first]
    found[first] = number
    while front:
        sphere = front.pop()
        left = np.flatnonzero(found < 0)
        apart = (
            np.linalg.norm(centres[left] - centres[sphere], axis=1) - radius[left] - radius[sphere]
        )
        touching = left[apart <= 0.0]
        found[touching] = number
        front.extend(touching.tolist())


def _gap(centres: Floats, radius: Floats, inside: np.ndarray) -> float:
    """The distance [m] from some spheres to the nearest of the others."""
    others = centres[~inside]
    other_radius = radius[~inside]
    return min(
        float(np.min(np.linalg.norm(others - centre, axis=1) - other_radius - own))
        for centre, own in zip(centres[inside], radius[inside], strict=True)
    )


def _sentence(body: Body, found: Pieces) -> str:
    level = f" at level of detail {body.detail}" if body.detail else ""
    segments = dict.fromkeys(body.segment_names[n] for n in body.sphere_segment[found.piece > 0])
    named = ", ".join(list(segments)[:_NAMED]) + (", ..." if len(segments) > _NAMED else "")
    warning = (
        f"the body{level} is in {found.count} pieces with gaps of up to {1000 * found.gap[1:].max():.2g} mm ({named}); "
        "thin parts between them touch nothing"
    )
    whole = _whole_levels(body)
    return warning + (f"; whole at: {', '.join(whole)}" if whole else "")


def _whole_levels(body: Body) -> list[str]:
    """The levels of detail of a body's family at which it is one piece."""
    if body.basis is None:
        return []
    return [
        level
        for level in body.basis.details
        if body_pieces(morph(body, body.basis_at[0], level)).count == 1
    ]
