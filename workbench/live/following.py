"""The population beside the bench: settled while the study rests, followed while it is changed.

Several threads are at work on it: `follow` is called by some, each with another piece of people,
`begin` and `settle` by one other. Each takes people piece by piece, can be left off between two
pieces, and puts a whole value in the place of another.

Its reach maps are asked on few of their points while something is dragged, on all of them at rest.
People stand for the others as they do for the shares: those who are known of a state are counted.
What they reach is asked anew only where they sit otherwise, or the part has moved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

import numpy as np

from workbench.draw.contours import median_spacing
from workbench.draw.reach_map import LEVELS, map_controls
from workbench.errors import InputError
from workbench.live.frames import PeopleShown, people_frame, waiting_frame
from workbench.live.protocol import packed
from workbench.model.accommodation import MapTask, ReachMap
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.surroundings import Move
from workbench.model.workplace import Workplace
from workbench.study.accommodation.checkpoints import PopulationQuestion
from workbench.study.accommodation.reach_maps import map_plane, map_points, reached_points
from workbench.study.bench.crowd import (
    BenchPopulation,
    Settled,
    crowd_question,
    in_columns,
    open_crowd,
    same_columns,
    settled,
)
from workbench.study.bench.crowd_followed import followed, poses_there
from workbench.study.bench.edits import seated, shifted
from workbench.study.bench.state import Arrangement, OpenStudy
from workbench.study.checks.margins import Asked
from workbench.study.reach_map import farthest_point_order
from workbench.threads import available_cores, one_thread

__all__ = [
    "COARSE",
    "Following",
    "ReachMaps",
]

COARSE = 16
"""Points of a map that are asked about while something is dragged."""


@dataclass(frozen=True, eq=False)
class _Reached:
    """Which points (M, 3) [m] of a map, from coarse to fine, some people reach (B, C) in their poses:
    C of them are known."""

    generation: int
    poses: Poses
    points: Floats
    reached: Bools

    def serves(self, poses: Poses, points: Floats, count: int) -> bool:
        """Whether this answers for people in poses, of so many points."""
        enough = self.reached.shape[1] >= count
        return enough and self.poses is poses and np.array_equal(self.points, points)


@dataclass(frozen=True, eq=False)
class _Surface:
    """A map's points (M, 3) [m] from coarse to fine, and the workplace that they are of."""

    place: Workplace
    points: Floats
    normals: Floats


class ReachMaps:
    """The maps that a study asks of its population.

    Parameters
    ----------
    tasks
        What is asked.
    pieces
        The rows of people who are asked together.
    """

    def __init__(self, tasks: Sequence[MapTask], pieces: Sequence[Ints]) -> None:
        self.tasks = tuple(tasks)
        self.pieces = pieces
        self._found: list[list[_Reached | None]] = [[None] * len(pieces) for _ in self.tasks]
        self._surfaces: list[_Surface | None] = [None] * len(self.tasks)

    def ask(
        self,
        number: int,
        body: Body,
        poses: Sequence[Poses],
        place: Workplace,
        generation: int,
        *,
        whole: bool,
    ) -> None:
        """Find what a piece of people reaches.

        Parameters
        ----------
        body, poses
            (B,) the people, and their postures in each case.
        place
            Where they are.
        whole
            Whether all points are asked about, or few.
        """
        for k, task in enumerate(self.tasks):
            surface = self._surface(k, place)
            mine = poses[task.case]
            count = len(surface.points) if whole else min(COARSE, len(surface.points))
            known = self._found[k][number]
            if known is not None and known.serves(mine, surface.points, count):
                found = known.reached
            else:
                found = reached_points(body, mine, surface.points[:count], task)
            self._found[k][number] = _Reached(generation, mine, surface.points, found)

    def _surface(self, k: int, place: Workplace) -> _Surface:
        """The points of a map in a workplace."""
        known = self._surfaces[k]
        if known is None or known.place is not place:
            points, normals = map_points(place, self.tasks[k])
            order, _ = farthest_point_order(points)
            known = _Surface(place, points[order], normals[order])
            self._surfaces[k] = known
        return known

    def frames(self, weight: Floats, generation: int) -> list[bytes]:
        """Pack what is known of each map in a state.

        Parameters
        ----------
        weight
            (P,) of everybody.
        """
        frames = []
        for k, (task, surface) in enumerate(zip(self.tasks, self._surfaces, strict=True)):
            known = [
                (weight[rows], found.reached)
                for rows, found in zip(self.pieces, self._found[k], strict=True)
                if found is not None and found.generation == generation
            ]
            if known and surface is not None:
                head = _head(task, surface, known)
                frames.append(
                    packed({"kind": "reach_map", "map": k, "generation": generation, **head})
                )
        return frames


def _head(task: MapTask, surface: _Surface, known: list[tuple[Floats, Bools]]) -> dict[str, Any]:
    """A map as the page draws it: lengths in mm."""
    count = min(reached.shape[1] for _, reached in known)
    total = sum(float(weight.sum()) for weight, _ in known)
    reached = np.sum([weight @ some[:, :count] for weight, some in known], axis=0)
    share = np.clip(reached / total, 0.0, 1.0)
    plane = map_plane(surface.place, surface.points)
    flat = plane.flat(surface.points)
    whole = ReachMap(task, surface.points, surface.normals, flat, np.zeros(len(flat)))
    controls = map_controls(whole, surface.place.environment)
    marks = plane.flat(np.array([control.at for control in controls]).reshape(-1, 3))
    return {
        "part": task.part,
        "hand": "either hand" if task.hand == "either" else f"the {task.hand} hand",
        "grip": task.grip,
        "zone": task.zone,
        "people": sum(len(weight) for weight, _ in known),
        "whole": count == len(flat),
        "levels": list(LEVELS),
        "spacing": round(1e3 * float(median_spacing(flat[:count])), 1) if count > 1 else 50.0,
        "points": np.round(1e3 * flat[:count], 1).tolist(),
        "share": np.round(share, 4).tolist(),
        "controls": [
            [control.name, *np.round(1e3 * at, 1).tolist()]
            for control, at in zip(controls, marks, strict=True)
        ],
    }


FIRST_PIECE = 16
PIECE = 64
MOST_FOLLOWED = 128
"""People who are worked on without a break: few at first, so that something is shown soon; of those
who are followed at most so many, for a piece takes 25 ms whoever is in it."""

STEP = 1e-3
"""[m] A first step of what is dragged."""


@dataclass(frozen=True, eq=False)
class _Margins:
    """What people have to spare (B, R) [m] in R requirements of a state, what is known (B, R) of
    that, and whether they were settled in it."""

    generation: int
    asked: Sequence[Asked]
    margin: Floats
    known: Bools
    settled: bool


class _SupersededError(Exception):
    """The state in which people are settled is another by now."""


class Following:
    """The population of an open study; nothing where there is none."""

    def __init__(self, opened: OpenStudy) -> None:
        self.opened = opened
        self.crowd: BenchPopulation | None = None
        self.words = ""
        self.pieces: list[Ints] = []
        self._first: list[Settled | None] = []
        self._last: list[Settled | None] = []
        self._shown: list[_Margins | None] = []
        self._questions: list[tuple[tuple[object, ...], PopulationQuestion]] = []
        self._asking = Lock()
        self._maps = ReachMaps(opened.maps, ())

    @property
    def there(self) -> bool:
        """Whether a population takes a role."""
        return self.opened.crowd is not None

    @property
    def at_hand(self) -> int:
        """How many pieces are followed."""
        if self.crowd is None:
            return 0
        sizes = np.cumsum([len(rows) for rows in self.pieces])
        return int(np.searchsorted(sizes, self.crowd.at_hand)) + 1

    @property
    def turns(self) -> list[range]:
        """The pieces that are followed, those together that are at once: the first alone, since what
        is indexed for it serves the others."""
        first = min(1, self.at_hand)
        rest = range(first, self.at_hand)
        some = [rest[k : k + available_cores()] for k in range(0, len(rest), available_cores())]
        return [range(first), *some] if first else []

    def begin(self) -> bytes | None:
        """Make the bodies, where they are not made yet; a frame where that cannot be."""
        if self.crowd is not None or not self.there or self.words:
            return None
        try:
            crowd = open_crowd(self.opened)
            assert crowd is not None
            crowd_question(self.opened, crowd, self.opened.start)
        except InputError as error:
            self.words = str(error)
            return waiting_frame(self.words)
        self.pieces = _in_pieces(crowd)
        self._first = [None] * len(self.pieces)
        self._last = [None] * len(self.pieces)
        self._shown = [None] * len(self.pieces)
        self._maps = ReachMaps(self.opened.maps, self.pieces)
        self.crowd = crowd
        return None

    def follow(
        self, number: int, arrangement: Arrangement, generation: int, *, search: bool = True
    ) -> bool:
        """Ask a piece of people what a change touches, where they were settled; whether anything is
        known of them then.

        Parameters
        ----------
        search
            Whether what is not known at once is searched for.
        """
        crowd = self.crowd
        if crowd is None or len(arrangement.people) > 1:
            return False
        shown = self._shown[number]
        same = shown is not None and shown.generation == generation
        if same and shown is not None and (shown.known.all() or not search):
            return True
        known = self._nearest(number, crowd, arrangement)
        if known is None:
            return False
        try:
            question = self._question(crowd, arrangement)
            # the first piece is alone at work, and indexes what has moved
            with nullcontext() if number == 0 else one_thread():
                found = followed(self.opened, crowd, known, question, arrangement, search=search)
        except InputError:
            return False  # settling reports it
        exact = known.arrangement.content == arrangement.content
        self._shown[number] = _Margins(generation, question.asked, found.margin, found.known, exact)
        return True

    def map(self, number: int, arrangement: Arrangement, generation: int, *, whole: bool) -> None:
        """Find what a piece of people reaches of the maps that the study asks for.

        Parameters
        ----------
        whole
            Whether all points are asked about, or few.
        """
        crowd = self.crowd
        if crowd is None or not self.opened.maps or len(arrangement.people) > 1:
            return
        known = self._nearest(number, crowd, arrangement)
        if known is None:
            return
        body = crowd.bodies[self.pieces[number]] if known.who is None else known.who.body
        cases = range(len(known.comfortable))
        poses = [poses_there(known, arrangement, case) for case in cases]
        place = self._question(crowd, arrangement).place
        with one_thread():
            self._maps.ask(number, body, poses, place, generation, whole=whole)

    def ready(self, arrangement: Arrangement, thing: Move) -> None:
        """Index what stays where it is while a thing is dragged, before it is.

        Parameters
        ----------
        thing
            Names the parts or controls; by how much they are moved means nothing.

        Raises
        ------
        InputError
            If they cannot be moved.
        """
        moved = shifted(self.opened, arrangement, replace(thing, by=(0.0, 0.0, STEP))).arrangement
        crowd = self.crowd
        known = None if crowd is None else self._nearest(0, crowd, arrangement)
        if crowd is None or known is None or len(arrangement.people) > 1:
            return
        with suppress(InputError):  # settling reports it
            question = self._question(crowd, moved)
            followed(self.opened, crowd, known, question, moved, search=False)

    def remember(self, number: int, seat: tuple[float, float]) -> None:
        """Make a piece of people who are settled ready to be followed while their seat is dragged.

        Parameters
        ----------
        seat
            [m] forward and up, where the seat stands that will be dragged: a drag puts it there for
            everybody.
        """
        crowd = self.crowd
        known = [one for one in (self._last[number], self._first[number]) if one is not None]
        if crowd is None or not known or known[0].who is None or known[0].trail.reaches:
            return
        travel = self.opened.seat(crowd.row)
        if travel is None or len(known[0].arrangement.people) > 1:
            return
        low, high = travel.travel_forward
        forward, up = seat
        beside = forward + STEP if forward + STEP <= high else max(forward - STEP, low)
        before = known[0].arrangement
        role = before.people[crowd.row].role
        with suppress(InputError):  # settling reports it
            for place, search in ((forward, True), (beside, False)):
                held = seated(self.opened, before, role, place, up).arrangement
                question = self._question(crowd, held)
                followed(self.opened, crowd, known[0], question, held, search=search)

    def _nearest(
        self, number: int, crowd: BenchPopulation, arrangement: Arrangement
    ) -> Settled | None:
        """What is known of a piece in the state that is the most like another."""
        known = [one for one in (self._last[number], self._first[number]) if one is not None]
        person = arrangement.people[crowd.row]
        for one in known:
            if one.arrangement.content == arrangement.content:
                return one
        alike = [one for one in known if one.arrangement.people[crowd.row] is person]
        return next(iter(alike or known), None)

    def settle(
        self,
        number: int,
        arrangement: Arrangement,
        generation: int,
        superseded: Callable[[], bool] = lambda: False,
    ) -> bytes | None:
        """Settle a piece of people in a state, in the state as opened too where they are not yet; a
        frame where that cannot be.

        Parameters
        ----------
        superseded
            Whether the state is another by now: then the people are left as they are.
        """
        crowd = self.crowd
        assert crowd is not None
        rows = self.pieces[number]

        def proceed() -> None:
            if superseded():
                raise _SupersededError

        try:
            first = self._first[number]
            if first is None:
                start = self.opened.start
                question = self._question(crowd, start)
                first = self._kept(number, settled(crowd, question, start, rows, proceed=proceed))
                self._first[number] = first
            known = self._nearest(number, crowd, arrangement) or first
            if known.arrangement.content != arrangement.content:
                question = self._question(crowd, arrangement)
                found = settled(crowd, question, arrangement, rows, known, proceed=proceed)
                known = self._kept(number, found)
                self._last[number] = known
        except _SupersededError:
            return None
        except InputError as error:
            return waiting_frame(str(error))
        everything = np.ones(known.margin.shape, dtype=np.bool_)
        self._shown[number] = _Margins(
            generation, known.question.asked, known.margin, everything, True
        )
        return None

    def _kept(self, number: int, found: Settled) -> Settled:
        """What is kept of people: where they are, of those at hand alone."""
        return found if number < self.at_hand else replace(found, places=(), who=None)

    def _question(self, crowd: BenchPopulation, arrangement: Arrangement) -> PopulationQuestion:
        """The same question for the same state, so that what is indexed for it serves again."""
        with self._asking:
            for content, question in self._questions:
                if content == arrangement.content:
                    return question
            question = crowd_question(self.opened, crowd, arrangement)
            first = self._questions[:1]  # the state as opened stays
            self._questions = [*first, *self._questions[1:][-2:], (arrangement.content, question)]
            return question

    def frames(self, generation: int) -> list[bytes]:
        """Pack what is known of the people in a state, and the maps of what they reach."""
        frame = self.frame(generation)
        if frame is None:
            return []
        if self.crowd is None:
            return [frame]
        return [frame, *self._maps.frames(self.crowd.people.weight, generation)]

    def frame(self, generation: int) -> bytes | None:
        """Pack what is known of the people in a state; None where nothing is."""
        crowd = self.crowd
        if crowd is None:
            return waiting_frame(self.words) if self.words else None
        known = [
            (rows, shown, first)
            for rows, shown, first in zip(self.pieces, self._shown, self._first, strict=True)
            if shown is not None and first is not None and shown.generation == generation
        ]
        if not known:
            return None
        counts = [len(rows) for rows, _, _ in known]
        asked = known[0][1].asked
        same = same_columns(known[0][2].question.asked, asked)
        return people_frame(
            crowd,
            PeopleShown(
                rows=np.concatenate([rows for rows, _, _ in known]),
                margin=np.concatenate([shown.margin for _, shown, _ in known]),
                known=np.concatenate([shown.known for _, shown, _ in known]),
                settled=np.repeat([shown.settled for _, shown, _ in known], counts),
                before=in_columns(np.concatenate([first.margin for _, _, first in known]), same),
                new=same < 0,
                asked=asked,
            ),
            generation,
        )


def _in_pieces(crowd: BenchPopulation) -> list[Ints]:
    """The people of a crowd in pieces: of those at hand but the first as many as keep all cores
    busy, dealt out so that like people, who cost alike, are in different ones."""
    at_hand = crowd.at_hand
    first = min(FIRST_PIECE, at_hand)
    turns = -(-(at_hand - first) // (available_cores() * MOST_FOLLOWED))
    beginning = np.linspace(0, at_hand - 1, first).round().astype(np.int64)
    others = np.setdiff1d(np.arange(at_hand), beginning)
    dealt = [others[k :: turns * available_cores()] for k in range(turns * available_cores())]
    far = np.arange(at_hand, len(crowd.order))
    rest = np.split(far, np.arange(PIECE, len(far), PIECE))
    return [crowd.order[some] for some in (beginning, *dealt, *rest) if len(some)]
