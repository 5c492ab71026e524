"""What people see of things, and whether they can read instruments: how much of a thing's surface no
part, no own limb and nobody else stands before, with eyes and head turned to it.

Head and eyes turn to each thing within their limits; what is beyond these is not seen at all. What is
seen is a share of the surface that is turned to the eyes. Reading has several limits, of the size of
characters, the angle to the face, the angle off the line of sight and the share that is seen; of a
population the least of them counts, each as a share of what is asked.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from workbench.model.accommodation import MET, Requirement
from workbench.model.arrays import Bools, Floats, xyz
from workbench.model.criterion import NO_REASON, Criterion, Reason, hider
from workbench.model.environment import Environment
from workbench.model.result import Finding
from workbench.model.rule_set import RuleSet
from workbench.model.units import UNITS
from workbench.posture.seating.seating import middle
from workbench.sight.eyes import Eyes, eyes_of, gaze, head_of
from workbench.sight.obscuration import (
    SEEN_BY,
    Target,
    seen_shares,
    target_of_disc,
    target_of_part,
    target_of_point,
)
from workbench.sight.rules.mirrors import looked_through
from workbench.sight.rules.reading import Reading, reading
from workbench.sight.scenery import Scenery
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = [
    "BEYOND",
    "FACE",
    "READ_BY",
    "findings",
    "limit_of_reading",
    "margins",
    "most",
    "shortfall_words",
    "spheres_asked",
    "targets_of",
]

ROUNDING = 1e-9
"""[m] More than rounding makes of the same sum of what is seen."""

BEYOND = (
    Reason("beyond", "beyond the turn of head and eyes"),
    Reason("beyond", "beyond the turn of trunk, head and eyes"),
)
"""What keeps something from being seen that nothing stands before, with the trunk still or turning."""
SIZE = "size of its characters"
LARGEST = "largest size of its characters"
FACE = "angle to its face"
SIDE = "angle to the side of the line of sight"
ABOVE = "angle above the line of sight"
BELOW = "angle below the line of sight"
"""What keeps an instrument from being read."""
_SHARE_OF = {
    "sees": " of its surface",
    "reads": " of its face",
    "outline": " of the outline",
    "mirror": " of its ground",
    "reflection": " of its face",
}
"""What a share that is lacking is of."""
READ_BY = ("character_least", "face_angle", "azimuth", "elevation", "line_down")
"""The values of a rule set that reading is judged by, beside `_MOST` where it has that."""
_MOST = "character_never_over"


def targets_of(criterion: Criterion) -> tuple[str, ...]:
    """The names of the things that a criterion asks to be seen or read."""
    return criterion.instruments or criterion.points or criterion.controls or criterion.parts


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """How much more of each thing than asked everybody sees, or how much better an instrument can be
    read."""
    found = no_margins(len(situation), asked)
    for r, margin, words in _spare(situation, asked):
        found.margin[:, r] = UNITS["share"].counted(margin)
        short = found.margin[:, r] < -MET
        found.words[short, r] = words[short]
    return found


def most(situation: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, Q) what everybody has to spare at most, wherever the hands are that hold something, and
    the legs: that before what these do not move. Infinite where they move the head."""
    found = np.full((len(situation), len(asked)), np.inf)
    scenery = situation.still_scenery
    if scenery is not None:
        for r, margin, _ in _spare(situation, asked, scenery):
            found[:, r] = UNITS["share"].counted(margin) + ROUNDING
    return found


def spheres_asked(situation: Situation, criterion: Criterion) -> Bools:
    """(S,) the spheres that a criterion depends on: of the size and angle of an instrument the head,
    of what is seen all that may stand before it."""
    head = situation.body.sphere_segment == head_of(situation.body)
    return np.asarray(head | _of_shares(criterion))


def _of_shares(criterion: Criterion) -> bool:
    """Whether a criterion asks for a share that is seen."""
    return criterion.check == "sees" or bool(criterion.visible)


def _spare(
    situation: Situation, asked: Sequence[Asked], scenery: Scenery | None = None
) -> Iterator[tuple[int, Floats, NDArray[np.object_]]]:
    """The number of each requirement, and (B,) what people have to spare of it, and what limits.

    scenery: what stands before the eyes, that of the situation if None.
    """
    of_shares = [r for r, one in enumerate(asked) if _of_shares(one.criterion)]
    things = [(asked[r].criterion, asked[r].requirement.target) for r in of_shares]
    seen = {}
    if things:
        before = situation.scenery if scenery is None else scenery
        seen = dict(zip(of_shares, _sees(situation, things, before), strict=True))
    eyes = eyes_of(situation.placed)
    for r, one in enumerate(asked):
        if one.requirement.check == "reads":
            read = _reading(situation.environment, one.criterion, one.requirement.target, eyes)
            yield r, *_reads(read, seen.get(r), one.criterion)
        else:
            yield r, seen[r].share - one.criterion.at_least, seen[r].why


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """Of each thing how much of it is seen, and what hides it; of an instrument that is read each
    limit."""
    names = targets_of(criterion)
    every = _sees(situation, [(criterion, name) for name in names], situation.scenery)
    for name, sees in zip(names, every, strict=True):
        about = Finding(
            case=situation.work.name,
            person=situation.place.role,
            other_person="",
            subject=name,
            target=sees.told(0).text,
            value=float(sees.share[0]),
            limit=criterion.at_least,
            point=xyz(sees.at[0]),
            unit="share",
        )
        if criterion.check == "sees":
            yield about
            continue
        if criterion.visible:
            yield replace(about, limit=criterion.visible)
        assert criterion.rule_set is not None
        source = criterion.rule_set.told(*READ_BY)
        read = _reading(situation.environment, criterion, name, eyes_of(situation.placed))
        for what, value in _measured(read, criterion.rule_set).items():
            if np.isfinite(value[0]):
                limit, unit = limit_of_reading(criterion, what)
                yield replace(
                    about,
                    target=what,
                    value=float(value[0]),
                    limit=limit,
                    unit=unit,
                    source=source,
                )


@dataclass(frozen=True, eq=False)
class _Sees:
    """How B people see one thing.

    share: (B,) that is seen; why: (B,) what hides most of the rest, and blocked (B,) how much that
    hides; at: (B, 3) [m] its middle.
    """

    share: Floats
    why: NDArray[np.object_]
    blocked: Floats
    at: Floats

    def told(self, row: int) -> Reason:
        """What hides most of what is not seen, and how much that is."""
        if self.share[row] >= 1.0 - MET:
            return NO_REASON
        why: Reason = self.why[row]
        return replace(why, share=round(float(self.blocked[row]), 2))


def _sees(
    situation: Situation, things: Sequence[tuple[Criterion, str]], scenery: Scenery
) -> Iterator[_Sees]:
    """How people see things that criteria name, with eyes and head turned to each."""
    environment = situation.environment
    eyes = eyes_of(situation.placed)
    origin = xyz(middle(situation.place))
    targets = [_target(environment, *thing, origin) for thing in things]
    middles = [_middle(situation, target) for target in targets]
    people = np.tile(np.arange(len(eyes)), len(targets))  # all turn to all at once
    trunk = np.repeat([criterion.trunk for criterion, _ in things], len(eyes))
    looks = gaze(eyes.rows(people), np.concatenate(middles), trunk=trunk)
    for k, ((criterion, name), target) in enumerate(zip(things, targets, strict=True)):
        rows = slice(k * len(eyes), (k + 1) * len(eyes))
        # a thing's own shape is no news: what else hides it is asked
        pieces = environment.control(name).pieces if criterion.controls else ()
        own = [target.item, *(environment.part_index(piece.part) for piece in pieces)]
        clear = looked_through(scenery, own) if max(own) >= 0 else scenery
        clear = clear.head_turned(eyes, looks.eyes.rows(rows))
        seen = seen_shares(clear, looks.eyes.rows(rows), [target], by=criterion.eyes)
        within = looks.within[rows]
        beyond = BEYOND[criterion.trunk > 0.0]
        why = [
            hider(str(blocker), environment.parts) if ok else beyond
            for blocker, ok in zip(seen.blocker[:, 0], within, strict=True)
        ]
        share = seen.share[:, 0, SEEN_BY.index(criterion.eyes)]
        yield _Sees(
            share=np.where(within, share, 0.0),
            why=np.array(why, dtype=object),
            blocked=np.where(within, seen.blocked[:, 0], 0.0),
            at=middles[k],
        )


def _reading(environment: Environment, criterion: Criterion, name: str, eyes: Eyes) -> Reading:
    """How an instrument is seen by eyes before they, and the head, turn to it."""
    assert criterion.rule_set is not None
    one = environment.instrument(name)
    return reading(eyes, one.at, one.face, one.characters, criterion.rule_set)


def _middle(situation: Situation, target: Target) -> Floats:
    """(B, 3) [m] the middle of a target, which goes along with the own seat where its part does."""
    at = np.broadcast_to(target.points.mean(axis=0), (len(situation), 3))
    names = situation.environment.parts
    goes = target.item >= 0 and names[target.item] in situation.place.moving_parts
    return np.asarray(at + situation.displacement if goes else at)


@lru_cache(maxsize=256)
def _target(
    environment: Environment, criterion: Criterion, name: str, origin: tuple[float, float, float]
) -> Target:
    """The surface of a thing that is to be seen; a disc faces the middle of the seat."""
    if criterion.points:
        point = environment.points[name]
        if not criterion.size:
            return target_of_point(name, point)
        toward = np.array(origin) - point
        disc = target_of_disc(name, point, criterion.size, normal=toward)
        return replace(disc, normals=None)
    if criterion.instruments:
        one = environment.instrument(name)
        return replace(target_of_part(environment, one.part, facing=one.face), name=name)
    if not criterion.controls:
        return target_of_part(environment, name)
    control = environment.control(name)
    shared = sum(other.part == control.part for other in environment.controls) > 1
    if not control.part or shared:
        item = environment.part_index(control.part) if control.part else -1
        return target_of_point(name, control.at, item=item)
    return replace(target_of_part(environment, control.part), name=name)


def limit_of_reading(criterion: Criterion, what: str) -> tuple[float, str]:
    """The limit [rad] of what is measured of reading, negative of what must not be more, and its
    unit."""
    rules = criterion.rule_set
    assert rules is not None
    if what == SIZE:
        return criterion.at_least or rules.number("character_least"), "arcmin"
    if what == LARGEST:
        return -rules.number(_MOST), "arcmin"
    if what == FACE:
        return rules.number("face_angle"), "rad"
    if what == SIDE:
        return -rules.number("azimuth"), "rad"
    low, high = rules["elevation"].tolist()
    return (-high if what == ABOVE else low), "rad"


def shortfall_words(
    requirement: Requirement,
    criterion: Criterion,
    size: float,
    reason: Reason,
    *,
    asked: bool = True,
) -> str:
    """How much of a requirement is lacking, by the size [m] that it counts: "41 mm", "38 % of its
    surface", of reading in the unit of what limits: "1.2 arc minutes (16.0 asked)", with what is asked
    for in brackets or without."""
    unit = requirement.unit
    if reason.kind == "reading":
        limit, key = limit_of_reading(criterion, reason.thing)
        own = UNITS[key]
        much = own.short(abs(limit) * own.counts * size / unit.counts)
        if not asked:
            return much
        stated = f"{own.scale * abs(limit):.{own.places}f}"
        return f"{much} ({stated} {'allowed' if limit < 0 else 'asked'})"
    return f"{unit.short(size)}{_SHARE_OF.get(requirement.check, '')}"


def _measured(read: Reading, rules: RuleSet) -> dict[str, Floats]:
    """(B,) [rad] what limits of reading are asked of, as `limit_of_reading` has them: NaN of what is
    above the line of sight where the instrument is below, and the other way."""
    found = {
        SIZE: read.character,
        FACE: read.face_angle,
        SIDE: -np.abs(read.azimuth),
        ABOVE: np.where(read.elevation > 0, -read.elevation, np.nan),
        BELOW: np.where(read.elevation > 0, np.nan, read.elevation),
    }
    return found | ({LARGEST: -read.character} if _MOST in rules.values else {})


def _reads(
    read: Reading, sees: _Sees | None, criterion: Criterion
) -> tuple[Floats, NDArray[np.object_]]:
    """(B,) the least of what is to spare of the limits of reading, as shares of the limits, and what
    it is."""
    assert criterion.rule_set is not None
    found = _measured(read, criterion.rule_set)
    limits = np.array([limit_of_reading(criterion, what)[0] for what in found])[:, None]
    spare = (np.stack([*found.values()]) - limits) / np.abs(limits)
    spare = np.where(np.isnan(spare), np.inf, spare)
    every = np.array([Reason("reading", what) for what in found], dtype=object)
    words = every[spare.argmin(axis=0)]
    least = spare.min(axis=0)
    if sees is not None:
        hidden = sees.share - criterion.visible
        words = np.where(hidden < least, sees.why, words)
        least = np.minimum(least, hidden)
    return least, words
