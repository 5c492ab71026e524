"""The people farthest from being served, posed at what they miss most, to be looked at."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.body.forward import place
from workbench.body.parts import moved
from workbench.contact.clearance_pairs import clearance_of_pairs
from workbench.model.accommodation import MET, AccommodationStudy, Shown
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.posture.reaching.limbs import FEET, HANDS, Limb, limb
from workbench.posture.reaching.reach import reach
from workbench.study.accommodation.chunks import Chunk
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.accommodation.requirements import Asked
from workbench.study.accommodation.sitters import (
    Sitters,
    seated,
    seated_at,
    with_hands,
    without_seat,
)
from workbench.study.pairs import pair_of

__all__ = ["hardest_rows", "in_position", "shown_people"]

MOST = 5


def hardest_rows(margin: Floats) -> tuple[int, ...]:
    """The rows of at most five people with the most negative margin (P, R), worst first, one a
    worst requirement as far as there are: the same trouble five times says less. Those that remain
    fill up."""
    known = np.nan_to_num(margin, nan=np.inf)
    worst = known.min(axis=1)
    at = known.argmin(axis=1)
    order = [int(row) for row in np.argsort(worst, kind="stable") if worst[row] < -MET]
    first = list({int(at[row]): row for row in reversed(order)}.values())
    chosen = sorted(first, key=order.index)[:MOST]
    chosen += [row for row in order if row not in chosen][: MOST - len(chosen)]
    return tuple(sorted(chosen, key=order.index))


def in_position(study: AccommodationStudy, body: Body, row: int, found: Chunk) -> Sitters:
    """A person in the position of the seat that the margins are of."""
    if np.array_equal(found.seat[row], found.comfortable[row]):
        return seated(study, body, [row])
    forward, up = found.seat[row].tolist()
    return seated_at(study, body, [row], (forward, up))


def shown_people(
    study: AccommodationStudy,
    asked: Sequence[Asked],
    bodies: PopulationBodies,
    found: Chunk,
    rows: Sequence[int],
) -> Iterator[Shown]:
    """Some people (rows) as found, in their position, at the requirement they miss by most."""
    for row in rows:
        body = bodies[row]
        r = int(np.nanargmin(found.margin[row]))
        sitters = in_position(study, body, row, found)
        seat = study.environment.seat(study.seat)
        environment = moved(study.environment, seat.moves, sitters.seat.shift[0])
        yield _shown(study, (asked[r], r), (row, body, environment, sitters))


def _shown(
    study: AccommodationStudy, what: tuple[Asked, int], who: tuple[int, Body, Environment, Sitters]
) -> Shown:
    (one, r), (row, body, environment, resting) = what, who
    if one.control is not None:
        return _reaching(study, what, who)
    sitters = with_hands(study, resting)
    placed = place(body, sitters.held)
    if one.requirement.check in ("clearance", "contact"):
        pairs = [pair_of(body, study.environment, one.criterion)]
        moves = study.environment.seat(study.seat).moves
        shift = sitters.seat.shift
        found = clearance_of_pairs(
            placed, study.environment, pairs=pairs, moving_parts=moves, displacement=shift
        )
        sphere = int(found.sphere[0, 0])
        if sphere >= 0:
            segment = body.segment_names[int(body.sphere_segment[sphere])]
            point = found.point[0, 0]
            centre = placed.centres[0, sphere]
            return Shown(row, r, placed, environment, segment, _xyz(point), _xyz(centre))
    if one.requirement.check in ("eye_height", "view_over") and study.aims.eyes is not None:
        eye = sitters.seat.eye[0]
        return Shown(
            row,
            r,
            placed,
            environment,
            "eyes",
            study.environment.points[study.aims.eyes],
            _xyz(eye),
        )
    if one.requirement.check in ("pedals", "preferred_seat") and sitters.seat.miss:
        foot = max(sitters.seat.miss, key=lambda name: float(sitters.seat.miss[name][0]))
        controls = {control.name: control for control in study.environment.controls}
        at = controls[study.aims.controls[foot]].at
        return Shown(
            row, r, placed, environment, foot, at, _xyz(_tip(placed, limb(body, foot, grip="ball")))
        )
    return Shown(row, r, placed, environment)


def _reaching(
    study: AccommodationStudy, what: tuple[Asked, int], who: tuple[int, Body, Environment, Sitters]
) -> Shown:
    """In the attempt: by whichever hand or foot comes nearest. The obstacles stand as in the study,
    those that go along with the seat aside by its travel: an environment of its own for each person
    would be indexed anew."""
    (one, r), (row, body, environment, sitters) = what, who
    assert one.control is not None
    foot = one.control.grip == "foot"
    seat = sitters.seat
    sides = [f"{one.criterion.hand} hand"] if one.criterion.hand else list(FEET if foot else HANDS)
    room = without_seat(study.environment, study.seat) if foot else study.environment
    grip, zone = ("ball", 1) if foot else (one.control.grip, one.requirement.zone)
    tries = []
    for name in sides:
        found = reach(
            body,
            seat.poses,
            [one.control.at],
            limb=limb(body, name, grip=grip, zone=zone),
            environment=room,
            moving_parts=study.environment.seat(study.seat).moves,
            displacement=seat.shift,
        )
        tries.append((float(found.miss[0, 0] + found.overlap[0, 0]), name, found))
    _, name, best = min(tries, key=lambda entry: entry[:2])
    placed = place(body, best.poses)
    tip = _tip(placed, limb(body, name, grip=grip, zone=zone))
    return Shown(row, r, placed, environment, name, one.control.at, _xyz(tip))


def _tip(placed: Placed, chain: Limb) -> Floats:
    """(3,) [m] where the end of a limb is."""
    world = placed.world_from_segment[0, chain.end]
    point: Floats = world[:, :3] @ chain.tip[0] + world[:, 3]
    return point


def _xyz(point: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in point)
    return x, y, z
