"""Ways of looking at an open study: motions, distances, reach envelopes and what somebody's eyes see;
the study as it was saved last; and what is chosen to be dragged.

A field of view says where eyes and head turn to and what hides how much of it from which eye, with a
picture.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from workbench.draw.envelopes import envelope_sections, outer_faces, section_lines
from workbench.draw.section_planes import SectionPlane
from workbench.draw.web.place_mesh import changed_parts
from workbench.draw.web.views import WebPlace
from workbench.draw.zones import OWN, Zones, spread, zones
from workbench.errors import InputError, WorkbenchError
from workbench.live.filming import FPS, Film, FilmView
from workbench.live.following import Following
from workbench.live.frames import move_row, part_shifts
from workbench.live.playing import WINDOW, Frames, Gaps, MotionScene, Near
from workbench.live.protocol import Job, Made, Question, Replies, packed
from workbench.model.arrays import Bools, Floats
from workbench.model.envelope import ReachTask
from workbench.model.environment import Environment
from workbench.model.surroundings import Move
from workbench.model.units import plain
from workbench.sight.obscuration import obscuration
from workbench.sight.panorama import look_out, lookout
from workbench.study.bench.answers import Answer
from workbench.study.bench.measuring import Thing, measured
from workbench.study.bench.motions import check_motion
from workbench.study.bench.placing import (
    FieldOfView,
    Placement,
    field_of,
    placed_environment,
    placed_people,
)
from workbench.study.bench.reaching import check_reach, reaching_situation
from workbench.study.bench.state import Arrangement, OpenStudy
from workbench.study.envelope.envelope import situation_envelope

__all__ = [
    "COARSE",
    "FINE",
    "WITHIN",
    "Colours",
    "FieldWork",
    "SavedState",
    "looking_verbs",
]

WITHIN = (30, 60, 90, 180)
"""How far [degrees] from the line of sight a field may go."""
COARSE = math.radians(0.5)
FINE = math.radians(0.1)
"""Width [rad] of the pixels that are counted while the eyes turn, and once they rest."""
_SHOWN = math.radians(1.0)
"""Width [rad] of what the picture looks at in one piece."""
_COLOURED = math.radians(3.0)
"""Width [rad] of the pixels by which colours are given."""
_SIZE = 180
"""Pixels of the picture along an edge."""
_MOST = 8
"""Items that are listed."""
Colours = dict[tuple[str, ...], Zones]


@dataclass(frozen=True, eq=False)
class FieldWork:
    """The field of view of a person of a state who looks in a direction (3,), within so many degrees
    of it."""

    opened: OpenStudy
    placement: Placement
    number: int
    person: str
    toward: tuple[float, float, float]
    within: int
    fine: bool
    known: Colours
    """The colours that items were given before, by the names of all, so that they stay."""
    kind: str = "field"
    generation: None = None
    """It is shown as that of the state `number` also once the state is another."""

    def made(self) -> Made:
        """Pack the figures and the picture; why there are none in words."""
        head: dict[str, Any] = {
            "kind": "field",
            "generation": self.number,
            "person": self.person,
            "within": self.within,
            "fine": self.fine,
            "words": "",
        }
        try:
            found = field_of(
                self.opened,
                self.placement,
                self.placement.arrangement.row(self.person),
                self.toward,
                within=math.radians(self.within),
                step=FINE if self.fine else COARSE,
            )
            names = found.hidden.names
            if names not in self.known:
                self.known[names] = _coloured(found)
            rows, picture = _shown(found, self.known[names])
        except WorkbenchError as error:
            return Made([packed(head | {"words": str(error)})])
        arrays = [("picture", picture), ("centres", found.placed.centres[0].astype(np.float32))]
        return Made([packed(head | _figures(found, rows), arrays)])


def _figures(found: FieldOfView, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How eyes and head are turned, and shares of the field in percent, from left, right, either and
    both eyes."""
    looks, hidden = found.gaze, found.hidden
    share = 100.0 / hidden.region.solid_angle
    return {
        "at": looks.eyes.middle[0].round(5).tolist(),
        "head": np.degrees(looks.head_turn[0]).round(1).tolist(),
        "eyes": np.degrees(looks.eye_turn[0]).round(1).tolist(),
        "trunk": round(math.degrees(float(looks.trunk_turn[0])), 1),
        "lack": round(math.degrees(float(looks.lack[0])), 1),
        "free": (share * hidden.free).round(2).tolist(),
        "error": round(share * hidden.free_error, 2),
        "rows": rows,
        "more": int((hidden.either > 0.0).sum()) - len(rows),
        "size": _SIZE,
    }


def _coloured(found: FieldOfView) -> Zones:
    """Colours of what bounds and hides all that somebody could see from there; the own body has one."""
    names = [OWN if name.startswith("own ") else name for name in found.hidden.names]
    around = obscuration(found.scenery, found.gaze.eyes, step=_COLOURED)
    return zones(names, around.both, around.either - around.both, float(around.free[3]))


def _shown(found: FieldOfView, coloured: Zones) -> tuple[list[dict[str, Any]], np.ndarray]:
    """The items that hide most, each with its colour, and the picture (H, W, 3) as 8 bits: what hides
    a direction from one eye only is pale."""
    hidden = found.hidden
    region = hidden.region
    share = 100.0 / region.solid_angle
    rows = []
    for k in np.argsort(-hidden.either, kind="stable")[:_MOST].tolist():
        if hidden.either[k] <= 0.0:
            break
        shares = [hidden.left[k], hidden.right[k], hidden.either[k], hidden.both[k]]
        rows.append(
            {
                "name": plain(hidden.names[k]),
                "colour": list(coloured.rows[int(coloured.row[k])].colour),
                "shares": [round(share * float(value), 2) for value in shares],
                "error": round(share * float(hidden.error[k]), 2),
            }
        )
    ways, inside = _disc(region.half_angle)
    view = lookout(ways @ region.axes, _SHOWN)
    eyes = found.gaze.eyes
    left, glass = look_out(found.scenery, eyes.left[0], view, through=True)
    right, _ = look_out(found.scenery, eyes.right[0], view)
    images = (spread(items, inside) for items in (left, right, glass))
    painted = coloured.paint(*images)
    painted[~inside] = 255
    return rows, painted


@lru_cache(maxsize=len(WITHIN))
def _disc(half_angle: float) -> tuple[Floats, Bools]:
    """Directions (K, 3) forward, left, up of the pixels of a disc that shows a cone about forward,
    equal areas for equal solid angles, r = 2 sin(off / 2); and which pixels (H, W) these are."""
    radius = 2.0 * math.sin(half_angle / 2.0)
    across = ((np.arange(_SIZE) + 0.5) * (2.0 / _SIZE) - 1.0) * radius
    right, down = np.meshgrid(across, across)
    square = right**2 + down**2
    inside = square <= radius**2
    k = np.sqrt(np.maximum(1.0 - square / 4.0, 0.0))
    ways = np.stack([1.0 - square / 2.0, -k * right, -k * down], axis=-1)
    return ways[inside], inside


Arrays = list[tuple[str, NDArray[Any]]]


@dataclass(frozen=True, eq=False)
class SavedState:
    """Where everybody and everything is in the saved study.

    Parameters
    ----------
    arrangement
        As it is saved, in the case that is looked at.
    shown
        The environment that the page has a picture of.
    """

    opened: OpenStudy
    arrangement: Arrangement
    shown: Environment
    kind: str = "ghost"
    generation: None = None

    def made(self) -> Made:
        """Pack the people, the displacements of parts, the places of controls, and the parts whose
        shape in the picture is another because something is adjusted."""
        cases = self.opened.cases
        placement = placed_people(self.opened, self.arrangement)
        arranged = placement.parts
        adjusted = None
        if arranged.environment is not self.shown:  # the same object where it is adjusted alike
            adjusted = changed_parts(arranged.environment, self.shown)
        controls = placed_environment(self.opened, placement).controls
        head = {
            "kind": self.kind,
            "case": cases[self.arrangement.case] if cases else "",
            "moves": [move_row(move) for move in self.arrangement.moves],
            "shifts": part_shifts(arranged),
            "controls": [[round(float(value), 6) for value in one.at] for one in controls],
            "adjusted": [] if adjusted is None else list(adjusted.names),
        }
        arrays = _people(placement)
        if adjusted is not None:
            arrays += _mesh(adjusted, placement)
        return Made([packed(head, arrays)])


def _people(placement: Placement) -> Arrays:
    """The spheres of everybody, with the segment of each."""
    arrays: Arrays = []
    for row, person in enumerate(placement.people):
        arrays += [
            (f"centres{row}", person.placed.centres[0].astype(np.float32)),
            (f"radius{row}", person.body.radius[0].astype(np.float32)),
            (f"segment{row}", person.body.sphere_segment.astype(np.uint16)),
        ]
    return arrays


def _mesh(place: WebPlace, placement: Placement) -> Arrays:
    """Parts where they stand [m]."""
    arranged = placement.parts
    rows = [arranged.environment.part_index(name) for name in place.names]
    shift = arranged.by_part[rows]
    vertices = place.vertices + shift[place.part]
    return [
        ("vertices", vertices.astype(np.float32)),
        ("triangles", place.triangles.ravel().astype(np.uint32)),
        ("edges", place.edges.ravel().astype(np.uint32)),
    ]


class LookedAt(Protocol):
    """What is looked at: an open study in its state, the state that is saved, the number of the
    state, and the population beside it."""

    opened: OpenStudy
    live: Arrangement
    saved: Arrangement
    generation: int
    following: Following


Verb = Callable[[Question], Replies]


def looking_verbs(desk: LookedAt, *, placement: Callable[[], Answer]) -> Mapping[str, Verb]:
    """The verbs by which a page looks at what a desk has.

    Parameters
    ----------
    placement
        Gives the answer to the state as it is.
    """

    def measure(question: Question) -> Replies:
        return _measure(desk, placement().placement, question)

    def ghost(question: Question) -> Replies:
        saved = replace(desk.saved, case=desk.live.case)
        shown = placement().placement.parts.environment
        return _later(question, SavedState(desk.opened, saved, shown))

    colours: Colours = {}

    def field(question: Question) -> Replies:
        given = question.given
        shown = placement().placement
        shown.arrangement.row(given["person"])  # a name that nobody has is refused at once
        toward = _point(given["toward"])
        number = desk.generation
        what = given["person"], toward, given["within"], given["fine"], colours
        return _later(question, FieldWork(desk.opened, shown, number, *what))

    def film(question: Question) -> Replies:
        return _film(desk, placement().placement, question)

    def bound(verb: Callable[[LookedAt, Question], Replies]) -> Verb:
        return lambda question: verb(desk, question)

    later = {
        "envelope": _envelope,
        "motion": _motion,
        "frames": _frames,
        "gaps": _gaps,
        "near": _near,
        "ready": _ready,
    }
    work = {name: bound(verb) for name, verb in later.items()}
    own = {"measure": measure, "ghost": ghost, "field": field, "film": film}
    return {**own, "film_end": _film_end, **work}


def _measure(desk: LookedAt, placement: Placement, question: Question) -> Replies:
    one = Thing(**question.given["of"])
    other = Thing(**question.given["to"])
    found = measured(desk.opened, placement, one, other)
    head = {
        "kind": "measured",
        "answers": question.number,
        "generation": desk.generation,
        "of": _name(one),
        "to": _name(other),
        "mm": 1e3 * found.distance,
        "points": [found.start.round(6).tolist(), found.end.round(6).tolist()],
    }
    return Replies(asker=[packed(head)])


def _name(thing: Thing) -> str:
    if thing.segment:
        return f"{thing.person}: {thing.segment}"
    return plain(thing.part or thing.control)


def _motion(desk: LookedAt, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    work = MotionScene(*_state(desk), question.given["case"])
    return _later(question, work, "the motion is being read")


def _frames(desk: LookedAt, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    begin = question.given["from"]
    end = question.given["to"]
    if not begin < end <= begin + WINDOW:
        raise InputError(
            f"frames: 1 to {WINDOW} of them, one after the other, can be had at a time"
        )
    work = Frames(*_state(desk), question.given["case"], begin, end)
    return _later(question, work)


def _gaps(desk: LookedAt, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    return _later(question, Gaps(*_state(desk), question.given["case"]))


def _near(desk: LookedAt, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    work = Near(*_state(desk), question.given["case"], question.given["frame"])
    return _later(question, work)


def _ready(desk: LookedAt, question: Question) -> Replies:
    given = question.given
    thing = Move(tuple(given["parts"]), tuple(given["controls"]), (0.0, 0.0, 0.0))
    return _later(question, Readiness(desk.following, desk.live, desk.generation, thing))


def _state(desk: LookedAt) -> tuple[OpenStudy, Arrangement, int]:
    return desk.opened, desk.live, desk.generation


def _film(desk: LookedAt, placement: Placement, question: Question) -> Replies:
    given = question.given
    motion = given["case"]
    if motion:
        check_motion(desk.opened, motion)
    elif not desk.opened.cases:
        raise InputError("there is no posture to go round: say which motion is filmed")
    section = None
    if given["section"] is not None:
        axis, side, at = given["section"]
        section = SectionPlane(int(axis), float(side), float(at), "section")
    view = FilmView(
        eye=_point(given["eye"]),
        at=_point(given["at"]),
        angle=float(given["angle"]),
        width=given["width"],
        height=given["height"],
        eyes=given["eyes"],
        hidden=tuple(given["hidden"]),
        without=tuple(given["without"]),
        section=section,
    )
    film = Film(desk.opened, placement, motion, view, FPS)
    head = {"kind": "busy", "answers": question.number, "what": "the film is being made"}
    return Replies(asker=[packed(head)], film=film)


def _film_end(question: Question) -> Replies:
    head = {"kind": "begun", "answers": question.number, "what": ""}
    return Replies(asker=[packed(head)], film_ends=True)


def _point(given: list[float]) -> tuple[float, float, float]:
    x, y, z = given
    return float(x), float(y), float(z)


def _envelope(desk: LookedAt, question: Question) -> Replies:
    given = question.given
    task = ReachTask(
        person=given["person"],
        limb=given["limb"],
        grip="",
        zone=given["zone"],
        obstacles=given["obstacles"],
        case=desk.live.case,
    )
    check_reach(desk.opened, desk.live, task)
    return _later(question, EnvelopeWork(*_state(desk), task), "the reach envelope is being made")


def _later(question: Question, work: Job, words: str = "") -> Replies:
    """That something is begun for who asked."""
    head = {"kind": "busy" if words else "begun", "answers": question.number, "what": words}
    return Replies(asker=[packed(head)], work=work)


@dataclass(frozen=True, eq=False)
class Readiness:
    """That a population is ready to be followed while a thing is dragged that was chosen."""

    following: Following
    arrangement: Arrangement
    generation: int
    thing: Move
    kind: str = "ready"

    def made(self) -> Made:
        """Make it ready; nothing is sent, also where it cannot be moved: a drag says that."""
        with suppress(InputError):
            self.following.ready(self.arrangement, self.thing)
        return Made([])


@dataclass(frozen=True, eq=False)
class EnvelopeWork:
    """The reach envelope of a hand, with its sections."""

    opened: OpenStudy
    arrangement: Arrangement
    generation: int
    task: ReachTask
    kind: str = "envelope"

    def made(self) -> Made:
        """Pack the outer boundary clear of obstacles, the lines of the sections, and their
        pictures."""
        task = self.task
        situation = reaching_situation(self.opened, self.arrangement, task)
        found = situation_envelope(situation, task)
        points, faces, short = outer_faces(found)
        lines = section_lines(found)
        sections = envelope_sections(found, environment=situation.environment)
        head: dict[str, Any] = {
            "kind": "envelope",
            "generation": self.generation,
            "person": task.person,
            "limb": task.limb,
            "litres": round(1e3 * found.volume),
            "lost": round(1e3 * found.lost) if found.obstacles else None,
            "sections": [[name, svg] for name, svg in sections],
        }
        arrays: list[tuple[str, NDArray[Any]]] = [
            ("points", points.astype(np.float32)),
            ("faces", faces.astype(np.uint32)),
            ("short", short.astype(np.uint8)),
            ("lines", lines.astype(np.float32)),
        ]
        return Made([packed(head, arrays)])
