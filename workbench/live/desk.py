"""The desk: one open study, what was done to it, and the answers to what is asked about it.

Everything but `judgement` is called by one thread alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain, count, cycle
from pathlib import Path

from workbench.draw.web.views import PEOPLE, WebView, body_view
from workbench.errors import InputError, WorkbenchError, printable
from workbench.files.catalogue import find
from workbench.files.study.reader import load_study
from workbench.files.study.saving import ChangedFileError, read_text
from workbench.files.yaml_changes import SharedValueError
from workbench.live.following import Following
from workbench.live.frames import (
    answer_frame,
    hello_frame,
    sight_frame,
    verdict_frame,
    waiting_frame,
)
from workbench.live.looking import looking_verbs
from workbench.live.protocol import VERBS, Job, Made, Question, Replies, Run, packed
from workbench.live.verbs import EDITS
from workbench.study.bench.answers import Answer, BenchEvaluation, answer, judged
from workbench.study.bench.edits import looking_at
from workbench.study.bench.edits_joints import given_since
from workbench.study.bench.history import Entry, History
from workbench.study.bench.motions import (
    MotionsJudged,
    motion_names,
    motion_state,
    motions_judged,
)
from workbench.study.bench.near import Tolerances
from workbench.study.bench.placing import Placement, people_here, placed_people, sight_verdicts
from workbench.study.bench.saving import save
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study, open_study
from workbench.study.describe.saving import people_study
from workbench.study.people import Present, present_people

__all__ = [
    "Desk",
    "Judgement",
    "Preparation",
    "SupersededError",
    "busy_frame",
    "fault_frame",
    "free_file",
    "kept_file",
    "new_file",
    "words_of",
    "work_made",
]

LONGEST_FILE = 255
"""Bytes of a file's name, at most."""
LONGEST_STEM = 200
"""Bytes of a name that another one is made of."""


class StudyThereError(InputError):
    """The study of many people that is asked for is there already."""


class SupersededError(Exception):
    """Another state is to be judged by now."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is to be judged: a state and its number, the population that is beside it, and what was
    found of the motions last."""

    opened: OpenStudy
    arrangement: Arrangement
    generation: int
    following: Following
    seat: tuple[float, float] | None = None
    """Where the seat of the one who stands for the population is, forward and up [m]."""
    motions_known: MotionsJudged | None = None
    placement: Placement | None = None
    """Where the people of the state are, where that is known."""

    def sights(self) -> Iterator[bytes]:
        """Judge what the people of the state see from where they are, in any thread: a frame for each
        criterion. What cannot be judged is reported once the state rests."""
        if self.placement is None or not self.opened.cases:
            return
        with suppress(WorkbenchError):
            here = people_here(self.opened, self.placement)
            for one in sight_verdicts(self.opened, self.arrangement, here):
                yield sight_frame(one, here, self.generation)

    def made(self) -> BenchEvaluation | str | None:
        """Judge the state, in any thread; why it cannot be judged, in words; None where the study
        has no posture."""
        if not self.opened.cases:
            return None
        try:
            return judged(self.opened, self.arrangement)
        except Exception as error:  # noqa: BLE001 (one state that fails must not end the bench)
            return words_of(error)

    def motions(self, go_on: Callable[[], None]) -> Iterator[MotionsJudged | str]:
        """Judge the motions of the state one after the other, in any thread; why that cannot be, in
        words. Nothing is judged again that was judged already, or once the state is another.

        Parameters
        ----------
        go_on
            Raises `SupersededError` once the state is another.
        """
        known = self.motions_known
        if known is not None and known.state == motion_state(self.arrangement):
            yield known
            return
        try:
            yield from motions_judged(self.opened, self.arrangement, go_on=go_on)
        except SupersededError:
            return
        except Exception as error:  # noqa: BLE001 (one state that fails must not end the bench)
            yield words_of(error)


@dataclass(frozen=True, eq=False)
class Preparation:
    """An edit that takes time: another thread does it once before the desk does, so that all that
    it needs is made already."""

    opened: OpenStudy
    placement: Placement
    question: Question

    @property
    def words(self) -> str:
        """What is being done."""
        return EDITS[self.question.verb].prepared.format(**self.question.given)

    def made(self) -> Present | str | None:
        """Do the edit and put its people where they are, in any thread; where people go whose seat
        is free, None where none is, or in words why it cannot be done."""
        try:
            edit = EDITS[self.question.verb].edit
            after = edit(self.opened, self.placement, self.question.given).arrangement
            free = any(person.free for person in after.people)
            there = None
            if free:
                there = present_people(arranged_study(self.opened, after), after.occupants)
            placed_people(self.opened, after, there=there, before=self.placement)
        except Exception as error:  # noqa: BLE001 (one edit that fails must not end the bench)
            return words_of(error)
        return there


@dataclass(frozen=True, eq=False)
class _Restorable:
    """What an edit changes of a desk; all of it is put back where the state after has no answer."""

    live: Arrangement
    generation: int
    verdicts: bytes | None
    history: History[Arrangement]


class Desk:
    """One open study.

    Parameters
    ----------
    source
        A study's file, or the name of one of the catalogue, which is not written.
    size
        Which of several sizes is shown, the first if "".
    read_only
        Whether nothing is saved.
    clock
        Time [s] that rises.
    """

    page = "index.html"
    verbs = VERBS
    judges = True

    def __init__(
        self,
        source: str,
        *,
        size: str = "",
        read_only: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.path = find("studies", source)
        self.catalogued = Path(source).suffix not in (".yaml", ".yml")
        self.read_only = read_only
        self.size = size
        self.clock = clock
        self.generation = 0
        self._verbs: Mapping[str, Callable[[Question], Replies]] = {
            "case": self._case,
            "drop": self._to_shown,
            "undo": self._undo,
            "redo": self._redo,
            "save": self._save,
            "reload": self._reload,
            "report": self._report,
            "report_end": lambda question: Replies(run_ends=True),
            **looking_verbs(self, placement=self._placement),
        }
        self.open()

    def open(self) -> None:
        """Read the study from its file; what was done to it before is forgotten."""
        text = read_text(self.path)
        opened = open_study(load_study(str(self.path)), self.size)
        self.text = text
        self.disk = text
        self.opened = opened
        self.live = opened.start
        self.saved = opened.start
        self.history: History[Arrangement] = History.of(opened.start)
        self.following = Following(opened)
        self.there: Present | None = None
        self.shown: Answer | None = None
        self.verdicts: bytes | None = None
        self.judged: BenchEvaluation | None = None
        self.motions_judged: MotionsJudged | None = None
        self.looked_at: bytes | None = text.data
        self.told_of: bytes | None = text.data
        self.generation += 1

    @property
    def may_save(self) -> bool:
        """Whether the study's own file may be written."""
        return not (self.read_only or self.catalogued)

    @property
    def unsaved(self) -> bool:
        """Whether the state differs from the file."""
        return self.live.content != self.saved.content

    @property
    def ready(self) -> bool:
        """Whether a first answer is there; it may take a minute on a machine that has none of the
        compiled code yet."""
        return self.shown is not None

    def greeting(self) -> list[bytes]:
        """What a page needs that was just opened, as far as it is known at once."""
        frames = [hello_frame(self.opened, printable(self.path.name), saves=self.may_save)]
        if not self.ready:
            frames.append(busy_frame(0, "the first answer is being made"))
        return frames

    def state(self) -> list[bytes]:
        """The answer to the state as it is, and the verdicts that are known of it."""
        try:
            frames = [self._answered(0, "")]
        except WorkbenchError as error:
            frames = [fault_frame(None, str(error))]
        if self.following.there:
            people = self.following.frames(self.generation)
            frames += people or [waiting_frame("the people are being put in their places")]
        return frames if self.verdicts is None else [*frames, self.verdicts]

    def scene(self) -> WebView:
        """The picture as it is now: the place, and the people."""
        shown = self._placement()
        bodies = tuple(
            body_view(one.person.placed, one.person.state.role, colour)
            for one, colour in zip(shown.people, cycle(PEOPLE), strict=False)
        )
        place = shown.placement.parts.environment
        return WebView(self.opened.study.title, bodies, place)

    def preparation(self, question: Question) -> Preparation | None:
        """What another thread is to do before `do`; None where nothing is."""
        verb = EDITS.get(question.verb)
        if verb is None or not verb.prepared:
            return None
        try:
            return Preparation(self.opened, self._placement().placement, question)
        except WorkbenchError:
            return None  # `do` reports it

    def prepared(self, preparation: Preparation, found: Present | str | None) -> Replies:
        """Do what was prepared, in the state as it is now; frames of why it cannot be done."""
        if isinstance(found, str):
            return Replies(asker=[fault_frame(preparation.question, found)])
        if found is not None and preparation.opened is self.opened:
            self.there = found
        return self.do(preparation.question)

    def do(self, question: Question) -> Replies:
        """Do what is asked. What cannot be done leaves everything as it was, and is reported to who
        asked."""
        try:
            if question.verb in EDITS:
                return self._edit(question)
            return self._verbs[question.verb](question)
        except SharedValueError as error:
            return Replies(asker=[fault_frame(question, str(error), ask="sharing")])
        except ChangedFileError as error:
            return Replies(asker=[fault_frame(question, str(error), ask="over")])
        except StudyThereError as error:
            return Replies(asker=[fault_frame(question, str(error), ask="people")])
        except Exception as error:  # noqa: BLE001 (one question that fails must not end the bench)
            return Replies(asker=[fault_frame(question, words_of(error))])

    def keep(self) -> str:
        """Keep what is not saved in a file of its own; where, in words, "" where nothing is."""
        if not self.unsaved or not self.may_save:
            return "what was changed was not saved under a name" if self.unsaved else ""
        to = kept_file(self.path)
        try:
            save(self.opened, self.text, self.live, disk=self.disk, sharing="all", over=True, to=to)
        except InputError as error:
            return f"what was not saved is lost: {error}"
        return f"what was not saved is in {to}"

    def judgement(self) -> Judgement:
        """What is to be judged now."""
        seat = None
        placement = self.shown.placement if self.shown is not None else None
        if placement is not None and placement.arrangement is not self.live:
            placement = None
        if self.opened.crowd is not None and self.shown is not None:
            person = self.shown.people[self.opened.crowd].person
            seat = person.forward, person.up
        return Judgement(
            opened=self.opened,
            arrangement=self.live,
            generation=self.generation,
            following=self.following,
            seat=seat,
            motions_known=self.motions_judged,
            placement=placement,
        )

    def take(self, judgement: Judgement, found: BenchEvaluation | str | None) -> list[bytes]:
        """Take what was judged; frames for everybody, none where the state is another by now."""
        if judgement.generation != self.generation:
            return []
        if isinstance(found, str):
            self.judged = None
            return [fault_frame(None, f"no verdicts: {found}")]
        if found is None:
            return []
        self.there = found.there
        self.judged = found
        waits = motion_names(self.opened) != ()
        self.verdicts = verdict_frame(found, None, self.generation, waits=waits)
        free = any(person.free for person in self.live.people)
        return [self._answered(0, ""), self.verdicts] if free else [self.verdicts]

    def take_motions(self, judgement: Judgement, found: MotionsJudged | str) -> list[bytes]:
        """Take the verdicts of motions as `take` does those of postures."""
        if judgement.generation != self.generation:
            return []
        if isinstance(found, str):
            return [fault_frame(None, f"no verdicts of motions: {found}")]
        waits = found.done < found.of
        if not waits:
            self.motions_judged = found
        self.verdicts = verdict_frame(self.judged, found, self.generation, waits=waits)
        return [self.verdicts]

    def watched(self) -> Replies:
        """Look whether the file has changed on the disk: then it is read again, unless something is
        not saved. What differs from one look to the next is still being written. Each change is told
        once; another one after it, also of a file that could not be read, is a change again."""
        now = self.disk.bytes_on_disk()
        rests = now == self.looked_at
        self.looked_at = now
        if not rests or now == self.told_of:
            return Replies()
        self.told_of = now
        if now == self.disk.data:
            return Replies()
        if not self.unsaved:
            try:
                return self._reloaded("the file has changed and was read again")
            except InputError as error:
                return Replies(everybody=[fault_frame(None, str(error))])
        words = f"{self.path.name} has changed on the disk: reload it, or save over it"
        return Replies(everybody=[fault_frame(None, words, ask="over")])

    def _answered(self, number: int, words: str) -> bytes:
        """The frame of the state as it is."""
        begin = time.perf_counter()
        before = self.shown
        placement = placed_people(
            self.opened,
            self.live,
            there=self.there,
            before=before.placement if before is not None else None,
        )
        criteria = (*self.opened.study.criteria, *self.live.added)
        case = self.opened.cases[self.live.case] if self.opened.cases else ""
        self.shown = answer(placement, before, Tolerances(criteria, case))
        head = {
            "answers": number,
            "generation": self.generation,
            "words": printable(words),
            "undo": self.history.can_undo,
            "redo": self.history.can_redo,
            "unsaved": self.unsaved,
        }
        return answer_frame(self.shown, self.opened, head, begin)

    def _edit(self, question: Question) -> Replies:
        """Change the state; it is as it was where the state after has no answer."""
        make = EDITS[question.verb].edit
        edit = make(self.opened, self._placement().placement, question.given)
        before = _Restorable(self.live, self.generation, self.verdicts, self.history)
        given = given_since(self.history.shown.arrangement, edit.arrangement)
        words = "; ".join(one for one in (edit.words, given) if one)
        same = edit.arrangement.content == self.live.content
        self.live = edit.arrangement
        if not same:
            self.generation += 1
            self.verdicts = None
        if question.done and self.live.content != self.history.shown.arrangement.content:
            dragged = "done" in question.given  # other edits are steps of their own
            subject = " ".join(str(part) for part in question.subject) if dragged else ""
            self.history = self.history.added(Entry(self.live, subject, self.clock()))
        try:
            return Replies([self._answered(question.number, words)], changed=not same)
        except Exception:
            self.live = before.live
            self.generation = before.generation
            self.verdicts = before.verdicts
            self.history = before.history
            raise

    def _case(self, question: Question) -> Replies:
        edit = looking_at(self.opened, self.live, question.given["name"])
        self.live = edit.arrangement
        return Replies([self._answered(question.number, "")])

    def _undo(self, question: Question) -> Replies:
        if self.live.content == self.history.shown.arrangement.content:
            self.history = self.history.undone()
        return self._to_shown(question)

    def _redo(self, question: Question) -> Replies:
        self.history = self.history.redone()
        return self._to_shown(question)

    def _to_shown(self, question: Question) -> Replies:
        """Show the state of the history again: a drag that has not ended is dropped."""
        self.live = self.history.shown.arrangement
        self.generation += 1
        self.verdicts = None
        return Replies([self._answered(question.number, "")], changed=True)

    def _save(self, question: Question) -> Replies:
        name = question.given["to"]
        if name and self.read_only:
            raise InputError("the bench was started to read only")
        to = new_file(Path.cwd(), name, like=self.path.stem) if name else None
        if to is None and not self.may_save:
            why = "a study of the catalogue" if self.catalogued else "opened to be read only"
            raise InputError(f"{self.path.name} is {why}: save it under another name")
        self.disk = save(
            self.opened,
            self.text,
            self.live,
            disk=self.disk,
            sharing=question.given["sharing"],
            over=question.given["over"],
            to=to,
        )
        if to is not None:
            self.path = self.disk.path
            self.catalogued = False
        self.saved = self.live
        self.looked_at = self.told_of = self.disk.data
        head = {"kind": "saved", "answers": question.number, "file": printable(self.path.name)}
        return Replies([packed(head), self._answered(0, f"saved {self.path.name}")])

    def _reload(self, question: Question) -> Replies:
        return self._reloaded("read again", question.number)

    def _report(self, question: Question) -> Replies:
        """Let the study be run, or one of so many people, which is written beside it, and the report
        be written. What is there already is not written over."""
        if self.read_only:
            raise InputError("the bench was started to read only")
        people = int(question.given["people"])
        path = self.path
        if not people and self.unsaved:
            raise InputError("save the study first: a report is of what its file says")
        if people:
            path = self._people_path(question.given["how"])
        made = people if not path.exists() else 0
        inputs = self.opened.study.inputs.items()
        place = next(file for role, file in inputs if role.startswith("environment: "))
        head = {"kind": "report", "answers": question.number, "study": printable(path.name)}
        begun = packed({**head, "words": "the report is asked for"})
        return Replies(asker=[begun], run=Run(path, place, made))

    def _people_path(self, how: str) -> Path:
        """The study of many people beside this one."""
        if self.opened.crowd is not None:
            raise InputError("this study asks many people already: make its report")
        if self.catalogued:
            raise InputError("save the study under a name first: it is one of the catalogue")
        path = people_study(self.path)
        if path.exists() and how == "ask":
            raise StudyThereError(
                f"{path.name} is there already: run it as it is, or write another one beside it"
            )
        return free_file(path) if how == "anew" else path

    def _reloaded(self, words: str, number: int = 0) -> Replies:
        self.open()
        return Replies([*self.greeting(), self._answered(number, words)], changed=True)

    def _placement(self) -> Answer:
        """The answer to the state as it is, made where it is not there yet."""
        if self.shown is None or self.shown.placement.arrangement is not self.live:
            self._answered(0, "")
        assert self.shown is not None
        return self.shown


def work_made(work: Job) -> Made:
    """Do a piece of work, in any thread; why it cannot be done, as a fault."""
    try:
        return work.made()
    except Exception as error:  # noqa: BLE001 (one work that fails must not end the bench)
        return Made([fault_frame(None, words_of(error))])


def kept_file(path: Path) -> Path:
    """The name of a new file for what is not saved of a file, of which it has the beginning."""
    begin = path.stem.encode()[:LONGEST_STEM].decode(errors="ignore")
    return free_file(path.with_stem(f"{begin}_unsaved"))


def free_file(path: Path) -> Path:
    """The path itself where nothing is there, else with a number: study_2.yaml."""
    numbered = (path.with_stem(f"{path.stem}_{number}") for number in count(2))
    return next(one for one in chain([path], numbered) if not one.exists())


def new_file(folder: Path, name: str, *, like: str) -> Path:
    """The file of a folder that a page names to save in.

    Parameters
    ----------
    like
        The name, without its ending, of the file that is saved; the message makes another of it.

    Raises
    ------
    InputError
        If the name is hidden, too long, has a folder, white space but single spaces or what cannot
        be printed in it, or does not end in .yaml.
    """
    hidden = name.startswith(".") or " ".join(printable(name).split()) != name
    if (
        hidden
        or len(name.encode()) > LONGEST_FILE
        or Path(name).name != name
        or "\\" in name
        or not name.endswith(".yaml")
    ):
        raise InputError(f"a name such as {like}_2.yaml is needed, got {name[:60]!r}")
    return folder / name


def words_of(error: Exception) -> str:
    """What is said of an error: its own words, or what it is where nobody expects it."""
    if isinstance(error, WorkbenchError):
        return str(error)
    return f"internal error: {type(error).__name__}: {error}"


def busy_frame(number: int, words: str) -> bytes:
    """The frame of what is being done, as it is said to who asked with a number, or to all with 0."""
    return packed({"kind": "busy", "answers": number, "what": printable(words)})


def fault_frame(question: Question | None, words: str, ask: str = "") -> bytes:
    """The frame of what could not be done.

    Parameters
    ----------
    question
        What was asked, None where it could not be read.
    words
        What is wrong.
    ask
        What the page is to ask its user: "sharing", "over" or "people".
    """
    number = question.number if question is not None else 0
    where = question.verb if question is not None else ""
    words = printable(words)
    return packed({"kind": "fault", "answers": number, "where": where, "words": words, "ask": ask})
