"""What a change of the design would gain: looked for in the margins, confirmed by a run with the change made.

Moving a control toward a person's shoulder lets the margin grow as much as the way gets shorter; so do a part that is
moved away from the sphere it is nearest to, and a seat's end for who sits at it. From that the least move along an axis
that would do is read off the margins; what it really gains is what a run with it says.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from workbench.model.accommodation import MET, AccommodationStudy, Change, Gain
from workbench.model.arrays import Bools, Floats
from workbench.solve.seating import seat_planes
from workbench.study.accommodation.changes import borne_by, changed
from workbench.study.accommodation.chunks import Chunk, Workers, gathered, result_chunks
from workbench.study.accommodation.crew import Crew
from workbench.study.accommodation.requirements import Asked
from workbench.study.accommodation.shares import share_single
from workbench.study.accommodation.views import TOO_LOW

__all__ = ["MOST_GAINS", "found_changes", "gains_of"]

MOST_GAINS = 3
"""Requirements that a change is looked for."""
MOST_MOVE = 0.1
"""The longest move [m] that is looked at."""
STEP = 1e-3
NEAR = 5e-3
"""Half the move [m] over which the rate of a gain is taken."""
WANTED = (0.95, 0.99)
"""The shares that a change is to bring: the first of them that is above what there is."""
Run = Callable[[AccommodationStudy, Sequence[Asked]], Chunk]


def gains_of(
    study: AccommodationStudy, asked: Sequence[Asked], crew: Crew, found: Chunk, *, keep: Path | None,
    say: Callable[[str], None], workers: Workers | None = None,
) -> Iterator[Gain]:  # fmt: skip
    """The gains of the study's own changes, or of those found for the requirements that leave out most people."""
    changes: list[tuple[Change, int | None]] = [(change, None) for change in study.changes]
    changes += [] if study.changes else found_changes(study, asked, found)

    def run(other: AccommodationStudy, some: Sequence[Asked]) -> Chunk:
        return gathered(result_chunks(other, some, crew, keep=keep, say=say, workers=workers))[0]

    for change, at in changes:
        say(f"trying: {change.words}")
        yield _gain(study, asked, (found, run), (change, at))


def _gain(
    study: AccommodationStudy, asked: Sequence[Asked], runs: tuple[Chunk, Run], what: tuple[Change, int | None]
) -> Gain:
    (found, run), (change, at) = runs, what
    rows = borne_by(study, asked, change)
    other = changed(study, change)
    margin = found.margin.copy()
    margin[:, rows] = run(other, [_renewed(other, asked[r]) for r in rows]).margin
    before, after, weight = _met(found.margin), _met(margin), study.people.weight
    single, then = share_single(before, weight), share_single(after, weight)
    r = at if at is not None else rows[int(np.argmax(np.abs(then - single)[rows]))]
    size = max(np.linalg.norm(change.move), *np.abs(change.travel_forward), *np.abs(change.travel_up))
    move = float(size)
    axis = np.array(change.move) / move if any(change.move) else None
    return Gain(
        words=change.words,
        requirement=asked[r].requirement.name,
        move=move,
        rate=_rate(found, r, axis, weight),
        before=float(single[r]),
        after=float(then[r]),
        joint_before=_joint(before, weight),
        joint_after=_joint(after, weight),
    )


def _renewed(study: AccommodationStudy, one: Asked) -> Asked:
    """The requirement with its control where the changed environment has it."""
    if one.control is None:
        return one
    now = next(control for control in study.environment.controls if control.name == one.control.name)
    return Asked(one.requirement, one.criterion, now)


def _met(margin: Floats) -> Bools:
    return np.asarray(np.isnan(margin) | (margin >= -MET))


def _joint(met: Bools, weight: Floats) -> float:
    return float(weight[np.flatnonzero(np.all(met, axis=1))].sum() / weight.sum())


def _rate(found: Chunk, r: int, axis: Floats | None, weight: Floats) -> float:
    """Share gained by a metre along an axis, (3,), None where the margin itself is moved (a seat's end)."""
    steps = _along(found, r, axis)
    low, high = (share_single(_met(found.margin[:, r] + way * steps)[:, None], weight)[0] for way in (-NEAR, NEAR))
    return float(high - low) / (2 * NEAR)


def _along(found: Chunk, r: int, axis: Floats | None) -> Floats:
    """(P,) by how much each margin grows with a move of 1 along an axis."""
    if axis is None:
        return np.ones(len(found.margin))
    return np.nan_to_num(found.toward[:, r] @ axis)


def found_changes(study: AccommodationStudy, asked: Sequence[Asked], found: Chunk) -> Iterator[tuple[Change, int]]:
    """A change for each of the requirements that leave out most people, with the number of the requirement."""
    weight = study.people.weight
    single = share_single(_met(found.margin), weight)
    tried: set[str] = set()
    for r in np.argsort(single, kind="stable"):
        if single[r] >= 1.0 or len(tried) == MOST_GAINS:
            return
        target = asked[r].requirement.target
        if target in tried:
            continue
        change = _change(study, asked[r], (found, int(r), float(single[r])))
        if change is not None:
            tried.add(target)
            yield change, int(r)


def _change(study: AccommodationStudy, one: Asked, what: tuple[Chunk, int, float]) -> Change | None:
    found, r, share = what
    check = one.requirement.check
    if check in ("vision", "seat"):
        return _travel(study, (found, r, share), seat=check == "seat")
    if check not in ("reach", "clearance"):
        return None
    side = seat_planes(study.environment.seat(study.seat))[2]
    ahead = np.array([side[1], -side[0], 0.0])
    up = np.array([0.0, 0.0, 1.0])
    best: tuple[float, float, str, Floats] | None = None
    for word, axis in (("aft", -ahead), ("forward", ahead), ("up", up), ("down", -up), ("left", side),
                       ("right", -side)):  # fmt: skip
        move, reached = _least_move(found.margin[:, r], _along(found, r, axis), (study.people.weight, share))
        if reached > share + 1e-9 and (best is None or (-reached, move) < best[:2]):
            best = -reached, move, word, axis
    if best is None:
        return None
    _, move, word, axis = best
    x, y, z = (float(v) for v in move * axis)
    parts = one.criterion.parts if one.control is None else ()
    name = one.control.name if one.control is not None else one.requirement.target
    way = f"to the {word}" if word in ("left", "right") else word
    return Change(
        f"moving {name} {1000 * move:.0f} mm {way}", one.control.name if one.control else "", parts, (x, y, z)
    )


def _least_move(margin: Floats, along: Floats, how: tuple[Floats, float]) -> tuple[float, float]:
    """The least move [m] that brings the share wanted, or else the most share within MOST_MOVE; and that share, no
    more than what is wanted, so that of moves that bring it the shortest is taken."""
    weight, share = how
    goal = next((wanted for wanted in WANTED if share < wanted), 1.0)
    moves = np.arange(1, round(MOST_MOVE / STEP) + 1) * STEP
    shares = [float(share_single(_met(margin + move * along)[:, None], weight)[0]) for move in moves]
    best = int(np.argmax(np.minimum(shares, goal)))
    return float(moves[best]), min(shares[best], goal)


def _travel(study: AccommodationStudy, what: tuple[Chunk, int, float], *, seat: bool) -> Change | None:
    """The end of the seat's travel, at which those sit who miss the view or the pedals, moved outward."""
    found, r, share = what
    missed = np.flatnonzero(~_met(found.margin[:, r]))
    own = study.environment.seat(study.seat)
    column, ends = (0, own.travel_forward) if seat else (1, own.travel_up)
    if seat:  # short legs stop short of pedals: who sits at neither end is helped by neither
        beyond = np.mean(found.seat[missed, 0] - ends[0] >= ends[1] - found.seat[missed, 0]) >= 0.5
    else:
        beyond = np.mean([found.words[k] == TOO_LOW for k in found.reason[missed, r]]) >= 0.5
    at_end = np.abs(found.seat[:, column] - ends[int(beyond)]) < STEP
    if not at_end[missed].any():
        return None
    helped = (at_end & ~_met(found.margin[:, r])).astype(np.float64)
    move, reached = _least_move(found.margin[:, r], helped, (study.people.weight, share))
    if reached <= share:
        return None
    words = ("farther forward" if beyond else "farther back") if seat else ("higher" if beyond else "lower")
    moved = (0.0, move) if beyond else (-move, 0.0)
    told = f"letting the seat go {1000 * move:.0f} mm {words}"
    return Change(told, travel_forward=moved) if seat else Change(told, travel_up=moved)
