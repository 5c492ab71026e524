"""What the frames of a motion say, in one pass over pieces of it: clearance, paths of points,
excursions, coarseness, joints past their stops."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.body.forward import place
from workbench.contact.batches import Groups, pays
from workbench.contact.collide import (
    allowed_depth,
    allowed_groups,
    clearance_of_groups,
    clearance_of_rows,
    room,
)
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, GrowingArray, Ints, pieces
from workbench.model.body import Body
from workbench.model.criterion import Criterion, Limit
from workbench.model.environment import Environment
from workbench.model.motion_case import (
    ContactEvent,
    Excursion,
    ForceCurve,
    MotionCase,
    Signal,
    SignalPoint,
    StopBreach,
)
from workbench.model.poses import Placed, Poses
from workbench.model.simulation import (
    depth_offset,
    force_at,
    force_history,
    gained,
    level_at,
    ruled,
)
from workbench.motion.signals import (
    GRAVITY,
    acceleration,
    carries,
    cfc_filter,
    evenly,
    hic,
    sustained_level,
    velocity,
)
from workbench.posture.stops import stops

__all__ = [
    "BLOCK",
    "LONGEST_HIC",
    "Frames",
    "figure_of",
    "force_curves",
    "frames_of",
    "ruled_pairs",
    "signal_of",
    "stop_breaches",
    "with_forces",
]

BLOCK = 256
"""Frames that are placed at a time."""
_PAST = np.radians(0.1)


@dataclass(frozen=True, eq=False)
class Frames:
    """What the frames of a motion give.

    clearance (P, N) [m]: of each segment at each frame from all it meets, allowances given back;
    infinite where nothing is. gaps (P, Q) [m]: signed distance of the pairs that have a law of
    force, infinite where they are not pushed. paths: (P, 3) [m] of each of the study's points.
    excursions: by a criterion's name. coarse: a word where spheres move more than their radius
    between frames.
    """

    clearance: Floats
    paths: tuple[Floats, ...]
    excursions: dict[str, Excursion]
    gaps: Floats
    coarse: tuple[str, ...]


def frames_of(study: MotionCase) -> Frames:
    """One pass over the frames of a study's motion, BLOCK of them placed at a time."""
    body = study.body
    motion = study.motion
    environment = study.environment
    groups, allowed = allowed_groups(body, environment)
    clear = GrowingArray(len(body.segments))
    paths = [GrowingArray(3) for _ in study.points]
    laws = _Laws.of(study, groups)
    gaps = GrowingArray(len(laws.pairs) + 1)  # a spool of nothing is none
    grid = pays(motion)
    farthest: dict[str, Excursion] = {}
    steps = _Steps(body)
    for rows in pieces(len(motion), size=BLOCK):
        placed = place(body, motion.rows(rows))
        if len(laws.pairs):
            apart = clearance_of_groups(placed, environment, groups, grid=grid)
            clear.add((apart + allowed).min(axis=2, initial=np.inf))
            gaps.add(np.pad(laws.gaps(placed, environment, apart), ((0, 0), (0, 1))))
        else:
            clear.add(room(placed, environment, grid=grid))
            gaps.add(np.zeros((len(placed), 1)))
        for path, point in zip(paths, study.points, strict=True):
            world = placed.world_from_segment[:, point.segment]
            path.add(np.einsum("pij,j->pi", world[:, :, :3], np.array(point.at)) + world[:, :, 3])
        for criterion in study.criteria:
            if criterion.check == "excursion":
                found = _farthest(criterion, placed, rows.start)
                before = farthest.get(criterion.name)
                farthest[criterion.name] = (
                    found if before is None or found.value > before.value else before
                )
        steps.take(placed, rows.start)
    return Frames(
        clear.done(),
        tuple(path.done() for path in paths),
        farthest,
        gaps.done()[:, :-1],
        steps.warnings(motion.clock),
    )


@dataclass(frozen=True, eq=False)
class _Laws:
    """The pairs that have a law of force.

    pairs (Q, 2): segment, part. offset (Q,) [m]: the depth from which on each is pushed. group
    (Q,): the group of parts that the part is in, -1 for a hidden part.
    """

    pairs: Ints
    offset: Floats
    group: Ints

    @classmethod
    def of(cls, study: MotionCase, groups: Groups) -> _Laws:
        """The pairs of a study, its shown parts being in groups."""
        group = np.full(len(study.environment.parts), -1)
        for g, parts in enumerate(groups):
            group[list(parts)] = g
        pairs = ruled_pairs(study)
        offset = depth_offset(study.bears, allowed_depth(study.body, study.environment))
        return cls(pairs, offset[pairs[:, 0], pairs[:, 1]], group[pairs[:, 1]])

    def gaps(self, placed: Placed, environment: Environment, apart: Floats) -> Floats:
        """Signed distance (P, Q) [m] of the pairs that may be pushed, infinite for the others.

        apart (P, N, G) [m]: signed distance of the segments to the groups. A pair is never nearer
        than its segment is to the group. So where the group is not pushed the pair is not, and its
        distance is not computed.
        """
        found = np.full((len(placed), len(self.pairs)), np.inf)
        shown = self.group >= 0
        pushed = np.zeros(found.shape, dtype=np.bool_)
        pushed[:, shown] = apart[:, self.pairs[shown, 0], self.group[shown]] < -self.offset[shown]
        pose, pair = np.nonzero(pushed)
        found[pose, pair] = clearance_of_rows(
            placed, environment, np.column_stack([pose, self.pairs[pair]])
        )[0]
        return found


def stop_breaches(body: Body, motion: Poses) -> tuple[StopBreach, ...]:
    """Spells of each joint past its stop, at the frames, in the order of time."""
    time = motion.clock
    found_spells: list[list[_ContactInterval]] = [[] for _ in body.joints]
    for rows in pieces(len(motion)):
        margins = stops(body, motion.rows(rows))
        for j, spells in enumerate(found_spells):
            past = np.concatenate([[False], margins.margin[:, j] < -_PAST, [False]])
            edges = np.flatnonzero(past[1:] != past[:-1])
            for first, after in zip(edges[0::2].tolist(), edges[1::2].tolist(), strict=True):
                worst = int(first + np.argmin(margins.margin[first:after, j]))
                spell = _ContactInterval(
                    rows.start + first,
                    rows.start + after,
                    rows.start + worst,
                    float(margins.margin[worst, j]),
                    margins.motion(worst, j),
                )
                if spells and spells[-1].after == spell.first:
                    spells[-1].go_on(spell)
                else:
                    spells.append(spell)
    found = [
        StopBreach(
            joint,
            s.motion,
            float(time[s.first]),
            float(time[s.after - 1]),
            float(time[s.worst]),
            -s.margin,
        )
        for joint, spells in zip(body.joints, found_spells, strict=True)
        for s in spells
    ]
    return tuple(sorted(found, key=lambda breach: (breach.begin, breach.joint)))


@dataclass
class _ContactInterval:
    first: int
    after: int
    worst: int
    margin: float
    motion: str

    def go_on(self, more: _ContactInterval) -> None:
        """Join the spell that goes on in the next piece."""
        self.after = more.after
        if more.margin < self.margin:
            self.worst = more.worst
            self.margin = more.margin
            self.motion = more.motion


def _farthest(criterion: Criterion, placed: Placed, first: int) -> Excursion:
    body = placed.body
    about: Bools = np.isin(body.sphere_segment, [body.segment(s) for s in criterion.segments])
    gap = placed.centres[:, about] - np.array(criterion.origin)
    ahead = np.einsum("psi,i->ps", gap, np.array(criterion.direction)) + body.radius[0, about]
    frame, sphere = np.unravel_index(int(np.argmax(ahead)), ahead.shape)
    return Excursion(
        float(ahead[frame, sphere]), first + int(frame), int(np.flatnonzero(about)[sphere])
    )


@dataclass
class _Steps:
    """How far spheres move between frames, against their radii."""

    body: Body
    last: Floats | None = None
    many: int = 0
    frames: int = 0
    worst: tuple[float, int, int] = field(default=(0.0, 0, 0))

    def take(self, placed: Placed, first: int) -> None:
        """Take up the next frames, the number of the first of which is `first`."""
        held = self.last is not None
        centres = (
            np.concatenate([self.last, placed.centres]) if self.last is not None else placed.centres
        )
        step = np.linalg.norm(np.diff(centres, axis=0), axis=-1) / self.body.radius[0]
        self.last = np.array(placed.centres[-1:])
        if not step.size:
            return
        self.frames += len(step)
        self.many += int((step.max(axis=1) > 1.0).sum())
        frame, sphere = np.unravel_index(int(np.argmax(step)), step.shape)
        if step[frame, sphere] > self.worst[0]:
            self.worst = float(step[frame, sphere]), first - held + int(frame), int(sphere)

    def warnings(self, clock: Floats) -> tuple[str, ...]:
        """A word where true motion may differ much from the straight way between frames."""
        size, frame, sphere = self.worst
        if size <= 1.0:
            return ()
        name = self.body.segment_names[int(self.body.sphere_segment[sphere])]
        return (
            f"the motion is coarse: in {self.many} of {self.frames} steps between frames some sphere moves by more "
            f"than its own radius (the {name} by {size:.1f} radii at {1000 * clock[frame]:.1f} ms); between two frames "
            "each segment is taken to move the shortest way, so what it touches there is uncertain",
        )


def ruled_pairs(study: MotionCase) -> Ints:
    """(Q, 2) the segments and parts that have a law."""
    some: Bools = np.zeros((len(study.body.segments), len(study.environment.parts)), dtype=np.bool_)
    for rule in study.forces:
        some |= np.outer(rule.segments, rule.parts)
    return np.argwhere(some)


def force_curves(study: MotionCase, pairs: Ints, gap: Floats) -> tuple[ForceCurve, ...]:
    """The forces of pairs (Q, 2) over signed distances (P, Q) [m] at the frames, of those that are
    ever pushed.

    A distance may be infinite where a pair is not pushed.
    """
    offset = depth_offset(study.bears, allowed_depth(study.body, study.environment))
    curves = []
    for q, (n, k) in enumerate(pairs.tolist()):
        law = ruled(study.forces, n, k)
        depth = -gap[:, q] - offset[n, k]
        if law is not None and depth.max() > 0:
            curves.append(
                ForceCurve(
                    study.body.segments[n], study.environment.parts[k], force_history(law, depth)
                )
            )
    return tuple(curves)


def with_forces(study: MotionCase, meetings: Iterable[ContactEvent]) -> list[ContactEvent]:
    """Meetings with the force at their deepest, where a law gives it."""
    if not study.forces:
        return list(meetings)
    offset = depth_offset(study.bears, allowed_depth(study.body, study.environment))
    return [_with_force(study, meeting, offset) for meeting in meetings]


def _with_force(study: MotionCase, meeting: ContactEvent, offset: Floats) -> ContactEvent:
    if meeting.own:
        return meeting
    n = study.body.segment(meeting.segment)
    k = study.environment.part_index(meeting.other)
    law = ruled(study.forces, n, k)
    depth = meeting.depth - float(offset[n, k])
    return meeting if law is None else replace(meeting, force=force_at(law, depth, depth))


_J211 = {"UT": 180, "CT": 180}
"""Channel frequency classes of accelerations by SAE J211-1 (1995), table 1: of the thorax at the
spine. That of head, pelvis and limbs is 1000."""
_USUAL = {
    ("held", 0.003): "3 ms",
    ("hic", 0.015): "HIC15",
    ("hic", 0.036): "HIC36",
    ("hic", np.inf): "HIC",
}
"""Figures of every signal, HIC of the head only, by what they are and over how long [s]."""
LONGEST_HIC = 0.2
"""[s] Windows of a HIC without a stated one are searched up to here."""


def signal_of(clock: Floats, path: Floats, point: SignalPoint, study: MotionCase) -> Signal:
    """The signal of a point that is on a path (P, 3) [m] at times (P,) [s], with its figures.
    UsageError where the frames are too few for the filter."""
    time, position = clock, path
    second = acceleration(time, position)
    moved = velocity(time, position)
    if (
        study.pulse is not None
    ):  # what the vehicle does itself is added: signals are against the ground
        toward = np.array(study.pulse.toward)
        second = second - level_at(study.pulse, time)[:, None] * toward
        moved = moved - gained(study.pulse, time)[:, None] * toward
    cfc, note = _filter_class(point, study, (len(time) - 1) / (time[-1] - time[0]))
    if cfc is not None:
        time, values = evenly(clock, np.stack([position, moved, second], axis=1))
        position, moved, second = values.transpose(1, 0, 2)
        try:
            second = cfc_filter(time, second, cfc=cfc)
        except UsageError as error:
            raise UsageError(f"filter_class of {point.name}: {error}") from None
    bare = Signal(point, time, position, moved, second, cfc, {}, note)
    level = np.linalg.norm(second, axis=1)
    most = int(np.argmax(level))
    figures = {"peak": (float(level[most]) / GRAVITY, float(time[most]), float(time[most]))}
    figures["delta-v"] = _change(bare)
    for (figure, span), name in _USUAL.items():
        if figure == "hic" and study.body.segments[point.segment] != "H":
            continue
        if np.isinf(span) or time[-1] - time[0] >= span >= np.diff(time).max():
            figures[name] = figure_of(bare, Limit(figure, "", span, 0.0, ""))
    return replace(bare, figures=figures)


def _filter_class(point: SignalPoint, study: MotionCase, rate: float) -> tuple[int | None, str]:
    """The class that a point is filtered by, None for no filter, and how that differs from SAE
    J211-1. rate: samples a second."""
    usual = _J211.get(study.body.segments[point.segment], 1000)
    asked = point.filter_class
    if asked == "j211":
        if carries(rate, usual):
            return usual, ""
        return None, f"CFC {usual} of SAE J211-1 needs {5 * usual:,} samples a second or more"
    if asked is not None and asked < usual:
        return asked, f"SAE J211-1 has CFC {usual} for it: peaks and HIC come out too low"
    return asked, ""


def figure_of(signal: Signal, limit: Limit) -> tuple[float, float, float]:
    """A limit's figure of a signal (HIC without a unit, a held level in g), and from when to when
    [s] it is."""
    known = _USUAL.get((limit.figure, limit.span), "")
    if known in signal.figures:
        return signal.figures[known]
    level = np.linalg.norm(signal.acceleration, axis=1)
    if limit.figure == "hic":
        found = hic(signal.time, level, window=min(limit.span, LONGEST_HIC))
        return found.value, found.start, found.end
    most = float(signal.time[int(np.argmax(level))])
    return sustained_level(signal.time, level, hold=limit.span) / GRAVITY, most, most


def _change(signal: Signal) -> tuple[float, float, float]:
    """The largest change of velocity [m/s] from the first sample on, and when."""
    change = np.linalg.norm(signal.velocity - signal.velocity[0], axis=1)
    most = int(np.argmax(change))
    return float(change[most]), float(signal.time[0]), float(signal.time[most])
