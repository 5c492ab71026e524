"""Ways of looking at an open study: motions, distances and reach envelopes; and what is chosen to
be dragged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from workbench.draw.envelopes import envelope_sections, outer_faces, section_lines
from workbench.draw.section_planes import SectionPlane
from workbench.errors import InputError
from workbench.live.filming import FPS, Film, FilmView
from workbench.live.following import Following
from workbench.live.playing import WINDOW, Frames, Gaps, MotionScene, Near
from workbench.live.protocol import Question, packed
from workbench.live.replies import Made, Replies, Work
from workbench.live.saved_state import SavedState
from workbench.live.seeing import Colours, FieldWork
from workbench.model.envelope import ReachTask
from workbench.model.figures import plain
from workbench.model.surroundings import Move
from workbench.study.bench.answers import Answer
from workbench.study.bench.measuring import Thing, measured
from workbench.study.bench.motions import check_motion
from workbench.study.bench.placing import Placement
from workbench.study.bench.reaching import check_reach, reaching_situation
from workbench.study.bench.state import Arrangement, OpenStudy
from workbench.study.envelope.envelope import situation_envelope

__all__ = ["looking_verbs"]


class Desk(Protocol):
    """What is looked at: an open study in its state, the state that is saved, the number of the
    state, and the population beside it."""

    opened: OpenStudy
    live: Arrangement
    saved: Arrangement
    generation: int
    following: Following


Verb = Callable[[Question], Replies]


def looking_verbs(desk: Desk, *, placement: Callable[[], Answer]) -> Mapping[str, Verb]:
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

    def bound(verb: Callable[[Desk, Question], Replies]) -> Verb:
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


def _measure(desk: Desk, placement: Placement, question: Question) -> Replies:
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


def _motion(desk: Desk, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    work = MotionScene(*_state(desk), question.given["case"])
    return _later(question, work, "the motion is being read")


def _frames(desk: Desk, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    begin = question.given["from"]
    end = question.given["to"]
    if not begin < end <= begin + WINDOW:
        raise InputError(
            f"frames: 1 to {WINDOW} of them, one after the other, can be had at a time"
        )
    work = Frames(*_state(desk), question.given["case"], begin, end)
    return _later(question, work)


def _gaps(desk: Desk, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    return _later(question, Gaps(*_state(desk), question.given["case"]))


def _near(desk: Desk, question: Question) -> Replies:
    check_motion(desk.opened, question.given["case"])
    work = Near(*_state(desk), question.given["case"], question.given["frame"])
    return _later(question, work)


def _ready(desk: Desk, question: Question) -> Replies:
    given = question.given
    thing = Move(tuple(given["parts"]), tuple(given["controls"]), (0.0, 0.0, 0.0))
    return _later(question, Readiness(desk.following, desk.live, desk.generation, thing))


def _state(desk: Desk) -> tuple[OpenStudy, Arrangement, int]:
    return desk.opened, desk.live, desk.generation


def _film(desk: Desk, placement: Placement, question: Question) -> Replies:
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


def _envelope(desk: Desk, question: Question) -> Replies:
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


def _later(question: Question, work: Work, words: str = "") -> Replies:
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
