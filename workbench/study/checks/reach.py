"""Reach: controls by the hands and feet, in the harness zone that is asked for.

The margin of a control that is reached is how much farther out from the shoulder or hip it could
be. The margin of one that is missed is what the limb stays short, and how deep obstacles are still
entered there. Where the case puts one limb on the control, that limb must reach it (`limbs_asked`).
Else the limb on the side of the control is asked first, the right one of a control in the middle, and
the other where that one misses. A foot that the case puts on a pedal has come there when its owner sat
down: that answers, here as for the criterion of pedals.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from workbench.body.forward import place, segment_frames
from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import NO_REASON, Criterion, Reason
from workbench.model.environment import Control, Environment
from workbench.model.poses import Poses
from workbench.model.reach import DOUBTS, MOST_SPARE, Reach
from workbench.model.result import ControlReach, Finding
from workbench.model.workplace import WorkCase, Workplace
from workbench.posture.balance import balance
from workbench.posture.kernels.clear_reach import KEPT
from workbench.posture.kernels.inverse_kinematics import NEARLY
from workbench.posture.reach_bound import reach_bound
from workbench.posture.reaching.again import KeptReaches, no_reaches, still_reached
from workbench.posture.reaching.history import Recall
from workbench.posture.reaching.limbs import ZONES, Limb, limb, limbs_there
from workbench.posture.reaching.obstacles import hands_without_room
from workbench.posture.reaching.reach import reach
from workbench.posture.seating.seating import leftward, middle
from workbench.study.checks.bending import bent_reaches
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.checks.seat_travel import ON_PEDAL, foot_on_pedal, foot_seated
from workbench.study.situation import Remembered, Situation, without_seat

__all__ = [
    "ReachMemory",
    "control_reaches",
    "findings",
    "limbs_asked",
    "margins",
    "margins_again",
    "most",
    "never_reached",
    "same_in_the_area",
]

LEAST_MISS = 1e-4
"""What is reached through an obstacle only is missed by this [m] at least."""
THERE = 1e-3
"""[m] A limb that is no farther from a control is on it: what lacks is that something is entered."""
MIDDLE = 1e-3
"""How far [m] from the middle plane of a person a control is on neither side: no rounding, as of a
cockpit that is turned, decides which hand is asked first."""
ALIKE = 1e-3
"""Two limbs that miss a control by as much, to this [m], are alike, and the first one is told: a
search knows to about a millimetre how near it can come."""


@dataclass(frozen=True)
class _Group:
    """Controls that are asked for together: in one way, from one side.

    Parameters
    ----------
    grip, zone
        Of all of them.
    limbs
        The limbs that may do it, in the order in which they are asked.
    spare
        [m] how far beyond a control it is asked whether the limb gets there too.
    seated
        Whether it is the foot that the case puts there: where its leg came to then, beside what
        stands around, answers for pedals and for reach alike.
    """

    grip: str
    zone: int
    limbs: tuple[str, ...]
    spare: float
    seated: bool = False


@dataclass(frozen=True, eq=False)
class _Reached:
    """How B people reach T controls, each by the limb that does it best.

    Parameters
    ----------
    margin
        (B, T) [m], NaN before any limb is asked.
    reached, miss, overlap, discomfort, doubt
        (B, T) as of `Reach`.
    limb, limit
        (B, T) which limb, and what limits it.
    toward
        (B, T, 3) from the control to the root of the limb.
    """

    margin: Floats
    reached: Bools
    miss: Floats
    overlap: Floats
    discomfort: Floats
    doubt: Ints
    limb: NDArray[np.object_]
    limit: NDArray[np.object_]
    toward: Floats

    @property
    def short(self) -> Bools:
        """(B, T) what is not reached yet."""
        return np.asarray(np.isnan(self.margin) | (self.margin < -MET))

    def take_better(self, who: Ints, at: Ints, other: _Reached) -> None:
        """Take from another limb of people (P,) for a control each (P,) what is better than before.

        other: (P, 1).
        """
        before = self.margin[who, at]
        nearer = other.reached[:, 0] | (other.margin[:, 0] > before + ALIKE)
        better = np.isnan(before) | (self.short[who, at] & nearer)
        for field in fields(self):
            taken = getattr(other, field.name)[better, 0]
            getattr(self, field.name)[who[better], at[better]] = taken

    def of(self, who: Ints, at: Ints) -> _Reached:
        """Of people (P,) for a control each (P,): (P, 1)."""
        return _Reached(**{f.name: getattr(self, f.name)[who, at][:, None] for f in fields(self)})


def _nothing_reached(people: int, controls: int) -> _Reached:
    """What is known before any limb is asked."""
    shape = (people, controls)
    return _Reached(
        margin=np.full(shape, np.nan),
        reached=np.zeros(shape, dtype=np.bool_),
        miss=np.full(shape, np.inf),
        overlap=np.zeros(shape),
        discomfort=np.zeros(shape),
        doubt=np.zeros(shape, dtype=np.int64),
        limb=np.full(shape, "", dtype=object),
        limit=np.full(shape, NO_REASON, dtype=object),
        toward=np.full((*shape, 3), np.nan),
    )


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What everybody has to spare in each control; controls of one grip, zone and side together."""
    found = no_margins(len(situation), asked)
    remembered = situation.remembered
    spare = 0.0 if remembered is not None and remembered.searching else MOST_SPARE
    for group, rows in _grouped(situation, asked, spare).items():
        controls = [control for r in rows if (control := asked[r].control) is not None]
        best = _reached_by(situation, group, controls)
        found.margin[:, rows] = best.margin
        found.words[:, rows] = best.limit
        found.toward[:, rows] = best.toward
    return found


def _grouped(situation: Situation, asked: Sequence[Asked], spare: float) -> dict[_Group, list[int]]:
    """The requirements of each group of controls, by number."""
    groups: dict[_Group, list[int]] = {}
    for r, one in enumerate(asked):
        assert one.control is not None
        group = _group(situation, one.control, one.requirement.zone, one.criterion, spare)
        groups.setdefault(group, []).append(r)
    return groups


def _group(
    situation: Situation, control: Control, zone: int, criterion: Criterion, spare: float
) -> _Group:
    names = limbs_there(
        situation.body, limbs_asked(situation.place, situation.work, control, criterion.hand)
    )
    return _Group(control.grip, zone, names, spare, foot_seated(situation, control, names))


def limbs_asked(
    place: Workplace, work: WorkCase, control: Control, hand: str | None
) -> tuple[str, ...]:
    """Return the limbs that a control is asked of, in the order in which they are asked.

    Parameters
    ----------
    place, work, control
        Where, in which of its cases, and for what.
    hand
        "left" or "right" where the criterion states it, else None.

    Returns
    -------
    tuple[str, ...]
        The limb on the side that is stated; else the one that the case puts on the control: whether
        another could get there too says nothing of the case. Of what both or none hold, the limb on its
        side of the seat, or of who has none of the posture, then the other; in the middle the right one
        first.
    """
    kind = "foot" if control.for_feet else "hand"
    held = [limb for limb, name in work.held.items() if name == control.name]
    if hand:
        return (f"{hand} {kind}",)
    if len(held) == 1:
        return (held[0],)
    away = float((np.array(control.at) - middle(place)) @ leftward(place))
    sides = ("left", "right") if away > MIDDLE else ("right", "left")
    return tuple(f"{side} {kind}" for side in sides)


def _reached_by(situation: Situation, group: _Group, controls: Sequence[Control]) -> _Reached:
    """How people reach the controls of a group: by the first limb, and who misses any by the
    other.

    Where what people reached elsewhere is remembered, either limb is tried from few starts before
    one is searched for whole: where the other reaches, nobody has to know whether the first would
    after a long search.
    """
    if group.seated:
        return _by_seated_foot(situation, group, controls)
    best = _nothing_reached(len(situation), len(controls))
    thorough = situation.remembered is None
    unsure = {}
    for name in group.limbs:
        who = np.flatnonzero(best.short.any(axis=1))
        if not len(who):
            break
        some = situation if len(who) == len(situation) else situation.rows(who)
        found = _reached_with(some, group, controls, name, few_starts=True, thorough=thorough)
        left = _to_be_searched(some, group, controls, name, found)
        # what few starts came to does not compete with the search that follows
        row, at = np.nonzero(~left)
        best.take_better(who[row], at, found.of(row, at))
        unsure[name] = np.zeros(best.margin.shape, dtype=np.bool_)
        unsure[name][who] = left
    for name, in_doubt in unsure.items():
        _search_whole(situation, group, controls, name, in_doubt, best)
    if _bends(situation.place, group.grip, group.zone):
        searching = situation.remembered is not None and situation.remembered.searching
        for name in () if searching else group.limbs:
            _bend(situation, group, controls, name, best)
    return best


def _by_seated_foot(situation: Situation, group: _Group, controls: Sequence[Control]) -> _Reached:
    """How people reach a pedal with the foot that their case puts there; how much farther it would
    go is asked of the leg alone."""
    (name,) = group.limbs
    foot = foot_on_pedal(situation, name)
    free = _reached_with(situation, group, controls, name, alone=True)
    on = foot.short <= ON_PEDAL
    limit = [NO_REASON if on[b] else one for b, one in enumerate(foot.limit)]

    asked = np.ones(len(controls))
    by_person = np.empty((len(limit), 1), dtype=object)
    by_person[:, 0] = limit
    return replace(
        free,
        margin=np.where(on[:, None], np.maximum(free.margin, 0.0), -np.outer(foot.short, asked)),
        reached=np.outer(on, asked) > 0.0,
        miss=np.outer(foot.miss, asked),
        overlap=np.outer(foot.overlap, asked),
        limit=np.repeat(by_person, len(controls), axis=1),
    )


def _bends(place: Workplace, grip: str, zone: int) -> bool:
    """Whether a control is reached by bending, and stepping, too: in zone 3 by the hands of who
    stands."""
    return place.stand is not None and grip != "foot" and zone == max(ZONES)


def most(situation: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, R) [m] what everybody has to spare in each control at most: less than nothing where it is
    beyond the length of all limbs that may do it, in every zone. Infinite elsewhere."""
    body = situation.body
    poses = situation.taken.poses
    found = np.full((len(situation), len(asked)), np.inf)
    for group, rows in _grouped(situation, asked, 0.0).items():
        zones = [replace(group, zone=zone) for zone in ZONES if zone <= group.zone]
        arms = [_limb(body, one, name) for one in zones for name in group.limbs]
        bounds = [reach_bound(body, poses, arm) for arm in arms]
        for r in rows if not _bends(situation.place, group.grip, group.zone) else ():
            control = asked[r].control
            assert control is not None
            at = situation.where([control])[:, 0]
            miss = np.min([one.misses(np.arange(len(at)), at) for one in bounds], axis=0)
            found[miss > 0.0, r] = -miss[miss > 0.0]
    return found


def same_in_the_area(place: Workplace, asked: Asked) -> bool:
    """Whether a requirement is the same wherever in the area somebody stands: what is stepped to is
    reached from anywhere."""
    control = asked.control
    return control is not None and _bends(place, control.grip, asked.requirement.zone)


def _bend(
    situation: Situation, group: _Group, controls: Sequence[Control], name: str, best: _Reached
) -> None:
    """Let people who stand bend for what they still miss."""
    who, at = np.nonzero(best.short)
    if not len(who):
        return
    some = [controls[k] for k in at.tolist()]
    bent = bent_reaches(situation, name, group.grip, some, who=who, spare=group.spare)
    way = _root(situation.body, situation.taken.poses, name)[who]
    way -= situation.where(some)[who, np.arange(len(some))]
    short = np.maximum(bent.miss + bent.overlap, LEAST_MISS)
    found = _Reached(
        margin=np.where(bent.reached, bent.spare, -short)[:, None],
        reached=bent.reached[:, None],
        miss=bent.miss[:, None],
        overlap=bent.overlap[:, None],
        discomfort=bent.discomfort[:, None],
        doubt=best.doubt[who, at][:, None],
        limb=np.full((len(who), 1), name, dtype=object),
        limit=bent.limit[:, None],
        toward=(way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9))[:, None],
    )
    best.take_better(who, at, found)


def _to_be_searched(
    situation: Situation, group: _Group, controls: Sequence[Control], name: str, found: _Reached
) -> Bools:
    """(B, T) what is searched for whole after few starts of a limb have left it in doubt: nothing
    where few starts are all that is asked for, and where once is enough not what was before."""
    recall = _recall(situation, controls)
    if recall is None or recall.few_starts:
        return np.zeros(found.doubt.shape, dtype=np.bool_)
    left: Bools = found.doubt >= KEPT
    if not recall.once:
        return left
    # what enters something is no posture: how far a limb stays is told of clear ones
    left |= ~found.reached & (found.overlap > 0.0)
    return left & ~recall.searched(_limb(situation.body, group, name))


def _search_whole(
    situation: Situation,
    group: _Group,
    controls: Sequence[Control],
    name: str,
    in_doubt: Bools,
    best: _Reached,
) -> None:
    """Search for whole what people still miss with a limb that few starts left in doubt (B, T), and
    ask again how near it comes. What is remembered of elsewhere does not bear on it, except where a
    reach is searched for whole once: then it is held that it was."""
    left = in_doubt & best.short
    remembered = situation.remembered
    if remembered is not None and not remembered.once:
        situation = replace(situation, remembered=None)
    for at in np.flatnonzero(left.any(axis=0)).tolist():
        who = np.flatnonzero(left[:, at])
        found = _reached_with(situation.rows(who), group, [controls[at]], name, thorough=True)
        best.take_better(who, np.full(len(who), at), found)


def _recall(situation: Situation, controls: Sequence[Control]) -> Recall | None:
    """What is remembered of people and controls; None where nothing is."""
    if situation.remembered is None:
        return None
    recall = situation.remembered.recall(situation.place, (situation.case,), controls)
    return replace(recall, skips_proved=situation.remembered.searching)


def _obstacles(situation: Situation, group: _Group) -> Environment:
    """What is in the way of a limb."""
    if group.grip == "foot" and situation.place.seat is not None:
        return without_seat(situation.place)
    return situation.environment


def _limb(body: Body, group: _Group, name: str) -> Limb:
    """A limb that asks for the controls of a group."""
    return limb(body, name, grip="ball" if group.grip == "foot" else group.grip, zone=group.zone)


def _reached_with(
    situation: Situation,
    group: _Group,
    controls: Sequence[Control],
    name: str,
    *,
    few_starts: bool = False,
    thorough: bool = False,
    alone: bool = False,
) -> _Reached:
    """How people reach controls with one limb; few_starts: as of `Recall`; thorough: as of
    `reach`; alone: whatever stands around."""
    body = situation.body
    recall = None if alone else _recall(situation, controls)
    targets = situation.where(controls)
    found = reach(
        body,
        situation.taken.poses,
        targets,
        limb=_limb(body, group, name),
        environment=None if alone else _obstacles(situation, group),
        moving_parts=situation.place.moving_parts,
        displacement=None if alone else situation.displacement,
        max_extension=group.spare,
        recall=replace(recall, few_starts=few_starts) if recall is not None else None,
        thorough=thorough,
    )
    short = np.maximum(found.miss + found.overlap, LEAST_MISS)
    limit = np.full(found.reached.shape, NO_REASON, dtype=object)
    for row, target in np.argwhere(~found.reached).tolist():
        why = found.reason(row, target)
        deep = found.miss[row, target] < min(found.overlap[row, target], THERE)
        if deep and why.kind in ("part", "own", "other"):
            why = replace(why, kind="deep", at="leg" if group.grip == "foot" else "arm")
        limit[row, target] = why
    reached = found.reached
    if _bends(situation.place, group.grip, group.zone):
        falls = _falls(found)
        reached = reached & (falls <= 0.0)
        short = np.where(falls > 0.0, np.maximum(falls, LEAST_MISS), short)
        limit[falls > 0.0] = Reason("words", "balance")
    way = _root(body, situation.taken.poses, name)[:, None] - targets
    return _Reached(
        margin=np.where(reached, found.extension, -short),
        reached=reached,
        miss=found.miss,
        overlap=found.overlap,
        discomfort=found.discomfort,
        doubt=found.doubt,
        limb=np.full(found.reached.shape, name, dtype=object),
        limit=limit,
        toward=way / np.maximum(np.linalg.norm(way, axis=2, keepdims=True), 1e-9),
    )


def _falls(found: Reach) -> Floats:
    """(B, T) [m] how far the centre of mass is outside the soles where a control is reached; 0 where
    it is inside, or nothing is reached."""
    out = np.zeros(found.reached.size)
    rows = np.flatnonzero(found.reached)
    if len(rows):
        out[rows] = np.maximum(-balance(place(found.body, found.poses.rows(rows))).margin, 0.0)
    return out.reshape(found.reached.shape)


ReachMemory = dict[tuple[object, ...], KeptReaches]
"""The reaches that people were found to have, by case, group of controls and limb."""


def margins_again(
    situation: Situation,
    asked: Sequence[Asked],
    memory: ReachMemory,
    before: Floats | None = None,
    *,
    search: bool,
) -> Floats:
    """What people have to spare in each control, as far as it is known at once.

    Who reached a control and still does next to the posture before is asked no further. Who stays
    away from it by more than obstacles could be blamed for misses it. The others are not known,
    unless they are searched for.

    Parameters
    ----------
    memory
        What the same people reached where they were before; it is made to be what they reach now.
        Without anything in it everybody is searched for.
    before
        (B, R) what is known already of where they are now, NaN where it is not; None for nothing.
    search
        Whether those are searched for who are not known.

    Returns
    -------
    (B, R) array
        0 where a control is reached; how far it is missed [m], negative; NaN where it is not known.
    """
    found = np.full((len(situation), len(asked)), np.nan)
    for group, rows in _grouped(situation, asked, 0.0).items():
        controls = tuple(control for r in rows if (control := asked[r].control) is not None)
        if group.seated or _bends(situation.place, group.grip, group.zone):
            if search or group.seated:
                found[:, rows] = np.minimum(_reached_by(situation, group, controls).margin, 0.0)
            continue
        some = None if before is None else before[:, rows]
        found[:, rows] = _Again(situation, group, controls, memory, some, search).margin()
    return found


@dataclass(frozen=True, eq=False)
class _Again:
    """Controls of a group that are asked for again; arguments as of `margins_again`."""

    situation: Situation
    group: _Group
    controls: tuple[Control, ...]
    memory: ReachMemory
    before: Floats | None
    search: bool

    def margin(self) -> Floats:
        """(B, T) [m] what is to spare, NaN where it is not known."""
        shape = len(self.situation), len(self.controls)
        margin = np.full(shape, -np.inf)
        known = np.ones(shape, dtype=np.bool_)
        sure = np.zeros(shape, dtype=np.bool_) if self.before is None else ~np.isnan(self.before)
        for name in self.group.limbs:
            if np.all((margin >= 0) | sure):
                break
            self._ask(name, margin, known, sure)
        found = np.where((margin >= 0) | known, margin, np.nan)
        return found if self.before is None else np.where(sure, self.before, found)

    def _ask(self, name: str, margin: Floats, known: Bools, sure: Bools) -> None:
        """Ask one limb for what is not reached yet, nor sure."""
        kept = self._kept(name)
        if kept.reached.any() and self.before is None:
            margin[self._still(name, kept)] = 0.0
        who, at = np.nonzero((margin < 0) & ~sure)
        if not len(who):
            return
        free = self._reach(name, who, at, None)
        short = np.where(free.reached[:, 0], LEAST_MISS, free.miss[:, 0])
        before = margin[who, at]
        margin[who, at] = np.maximum(before, -short)
        left = np.flatnonzero(free.reached[:, 0] | (free.miss[:, 0] <= NEARLY))
        who = who[left]
        at = at[left]
        if not self.search:
            known[who, at] = False
        elif len(left):
            found = self._reach(name, who, at, _obstacles(self.situation, self.group))
            got = found.reached[:, 0]
            less = np.maximum(found.miss + found.overlap, LEAST_MISS)[:, 0]
            lack = -np.maximum(short[left], less)
            margin[who, at] = np.where(got, 0.0, np.maximum(before[left], lack))
            kept.put(who[got], at[got], found.angles[got, 0])

    def _kept(self, name: str) -> KeptReaches:
        """What is known of a limb; nothing is reached yet where nothing is."""
        body = self.situation.body
        names = tuple(control.name for control in self.controls)
        key = self.situation.case, self.group, names, name
        if key not in self.memory:
            arm = _limb(body, self.group, name)
            shape = len(self.situation), len(self.controls)
            self.memory[key] = no_reaches(body, arm, shape)
        return self.memory[key]

    def _still(self, name: str, kept: KeptReaches) -> Bools:
        situation = self.situation
        return still_reached(
            situation.body,
            situation.taken.poses,
            situation.where(self.controls),
            limb=_limb(situation.body, self.group, name),
            kept=kept,
            environment=_obstacles(situation, self.group),
            moving_parts=situation.place.moving_parts,
            displacement=situation.displacement,
        )

    def _reach(self, name: str, who: Ints, at: Ints, environment: Environment | None) -> Reach:
        """Reaches of some people (P,) for a control (P,) each, in any posture."""
        situation = self.situation
        poses = situation.taken.poses
        targets = situation.where(self.controls)
        each = Poses(
            poses.rotations[who], poses.reference, poses.world_from_reference[who], person=who
        )
        return reach(
            situation.body,
            each,
            targets[who, at][:, None],
            limb=_limb(situation.body, self.group, name),
            environment=environment,
            moving_parts=situation.place.moving_parts,
            displacement=situation.displacement[who] if environment is not None else None,
            thorough=environment is not None,
        )


@lru_cache(maxsize=16)
def _root(body: Body, poses: Poses, limb: str) -> Floats:
    """(B, 3) [m] the shoulder or hip that a limb begins at, as people are."""
    joint = body.joint(limb[0].upper() + ("S" if limb.endswith("hand") else "H"))
    world = segment_frames(body, poses, joint + 1)
    below = body.joint_in_child[:, joint]
    return np.einsum("bij,bj->bi", world[:, :, :3], below) + world[:, :, 3]


def never_reached(situation: Situation, asked: Sequence[Asked]) -> Bools:
    """(B, R) which controls people are proved to be kept from wherever their seat stands: none of
    the limbs that may do it has room at the control. Asked are those that obstacles keep a limb from.
    """
    found = np.zeros((len(situation), len(asked)), dtype=np.bool_)
    remembered = situation.remembered
    if remembered is None:
        return found
    for group, rows in _grouped(situation, asked, 0.0).items():
        controls = [control for r in rows if (control := asked[r].control) is not None]
        recall = _recall(situation, controls)
        arms = [_limb(situation.body, group, name) for name in group.limbs]
        assert recall is not None
        kept = np.any([recall.kept(arm) for arm in arms], axis=0)
        for at in np.flatnonzero(kept.any(axis=0)).tolist():
            left = kept[:, at]
            for arm in arms:
                who = np.flatnonzero(left)
                left[who] = _no_room(situation, group, controls[at], arm, who)
                recall.prove(arm, np.flatnonzero(left), at)
            found[left, rows[at]] = True
    return found


def _no_room(situation: Situation, group: _Group, control: Control, arm: Limb, who: Ints) -> Bools:
    """(P,) whether the hand of some people (P,) is proved to have no room at a control."""
    if (
        not len(who) or control.part in situation.place.moving_parts
    ):  # it is elsewhere with the seat
        return np.zeros(len(who), dtype=np.bool_)
    return hands_without_room(
        situation.body[who],
        arm.rows(who),
        np.array([control.at]),
        _obstacles(situation, group),
        situation.place.moving_parts,
    )[:, 0]


def control_reaches(situation: Situation) -> Iterator[ControlReach]:
    """Every control that a criterion asks one person for in a case, in the zones 1 to 3.

    InputError where a body lacks the landmarks of a grip.
    """
    place = situation.place
    # what a tighter zone misses is tried again in each freer one, from few starts
    known = Remembered(len(situation), np.arange(len(situation)), {}, once=True)
    situation = replace(situation, remembered=known)
    by_hand: dict[str, list[Criterion]] = {}
    for criterion in place.criteria:
        if criterion.check == "reach" and criterion.asks(situation.work.name):
            by_hand.setdefault(criterion.hand or "", []).append(criterion)
    for criteria in by_hand.values():
        names = {name for criterion in criteria for name in criterion.controls}
        controls = [c for c in situation.environment.controls if c.name in names]
        for grip in dict.fromkeys(control.grip for control in controls):
            same = [control for control in controls if control.grip == grip]
            yield from _zones(situation, same, criteria)


def _zones(
    situation: Situation, controls: Sequence[Control], criteria: Sequence[Criterion]
) -> Iterator[ControlReach]:
    """How the controls of one grip are reached in all zones; criteria: that ask the same hand for
    them."""
    for zone in ZONES:
        rows = {row.control: row for row in _zone_reaches(situation, controls, zone, criteria)}
        yield from (rows[control.name] for control in controls)


def _zone_reaches(
    situation: Situation, controls: Sequence[Control], zone: int, criteria: Sequence[Criterion]
) -> Iterator[ControlReach]:
    """How one person reaches controls in one zone."""
    groups: dict[_Group, list[Control]] = {}
    for control in controls:
        asked = any(
            control.name in criterion.controls and zone == (criterion.zone or control.zone)
            for criterion in criteria
        )
        spare = MOST_SPARE if asked else 0.0
        group = _group(situation, control, zone, criteria[0], spare)
        groups.setdefault(group, []).append(control)
    for group, some in groups.items():
        best = _reached_by(situation, group, some)
        for t, control in enumerate(some):
            yield ControlReach(
                person=situation.place.role,
                control=control.name,
                zone=zone,
                own_zone=control.zone,
                limb=best.limb[0, t],
                reached=bool(best.reached[0, t]),
                miss=float(best.miss[0, t]),
                overlap=float(best.overlap[0, t]),
                limit=best.limit[0, t],
                spare=float(best.margin[0, t]) if group.spare and best.reached[0, t] else None,
                discomfort=float(best.discomfort[0, t]),
                doubt=DOUBTS[best.doubt[0, t]],
                case=situation.work.name,
                hand=criteria[0].hand or "",
            )


def findings(reaches: Iterable[ControlReach], criterion: Criterion) -> Iterator[Finding]:
    """Each control in the zone asked for, or its own: how much farther the limb could go, or how far
    it stays from the control, which must be nothing."""
    for row in reaches:
        wanted = (
            row.person in criterion.people
            and row.control in criterion.controls
            and row.hand == (criterion.hand or "")
        )
        if wanted and row.zone == (criterion.zone or row.own_zone):
            short = max(row.miss + row.overlap, LEAST_MISS)
            target = f"{row.control} in zone {row.zone}"
            yield Finding(
                case=row.case,
                person=row.person,
                other_person="",
                subject=f"the {row.limb}",
                target=target + row.limit.clause,
                value=(row.spare or 0.0) if row.reached else -short,
                limit=0.0,
                about=row.control,
            )
