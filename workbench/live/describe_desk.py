"""The desk of an environment that is described: what each verb does to a description, what was done to
it, and the answers.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import cached_property
from itertools import cycle
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from workbench.draw.web.place_mesh import ThinMesh, thinned
from workbench.draw.web.views import PEOPLE, WebView, body_view
from workbench.errors import InputError, WorkbenchError, printable
from workbench.geometry.components import component_labels
from workbench.live.describe_frames import describe_hello, description_frame, drawn_place
from workbench.live.describe_protocol import DESCRIBE_VERBS
from workbench.live.desk import (
    busy_frame,
    fault_frame,
    free_file,
    kept_file,
    new_file,
    words_of,
)
from workbench.live.protocol import Question, Replies, packed
from workbench.model.arrays import Ints
from workbench.model.units import plain
from workbench.study.bench.history import Entry, History
from workbench.study.describe.edits_files import (
    added_file,
    agreed,
    files_beside,
    floored,
    framed,
    met_file,
    moved_file,
    removed_file,
    scaled,
)
from workbench.study.describe.edits_parts import dropped, joined, put_back, ruled, split_part
from workbench.study.describe.edits_seats import carried, faced
from workbench.study.describe.edits_things import (
    accepted,
    owned,
    placed_point,
    pointed,
    removed,
    renamed,
    typed,
)
from workbench.study.describe.meshes import Meshes, Ray
from workbench.study.describe.people import (
    PERSON,
    SeatedWords,
    person_words,
    seated_eye,
    seated_person,
    seated_words,
    standing_person,
)
from workbench.study.describe.saving import (
    ForeignFileError,
    SavedPlace,
    next_commands,
    save_description,
    save_first_study,
    unfinished,
)
from workbench.study.describe.state import (
    Description,
    Edit,
    OpenPlace,
    open_place,
    open_sizes,
    standing_of,
)

__all__ = [
    "DESCRIBE_EDITS",
    "DescribeDesk",
]

Given = Mapping[str, Any]
DescribeEdit = Callable[[OpenPlace, Description, Given], Edit]


def _ray(given: Given, before: str = "") -> Ray:
    """Where a picture was clicked; before: what stands before the keys. InputError where it was not
    on a part."""
    part, start, way, far = (given[before + key] for key in ("part", "start", "way", "far"))
    if not part or start is None or way is None:
        raise InputError("nothing was picked: click on a part in the picture")
    a, b, c = start
    x, y, z = way
    return Ray(part, (a, b, c), (x, y, z), far)


def _mesh(opened: OpenPlace, before: Description, given: Given) -> Edit:
    wanted = {name: given[name] for name in ("length", "up", "forward")}
    return framed(opened, before, int(given["row"]), wanted)


def _place(opened: OpenPlace, before: Description, given: Given) -> Edit:
    kind = given["kind"]
    more = {"grip": given["grip"], "zone": given["zone"]} if kind == "control" else {}
    return placed_point(opened, before, kind, given["name"], more, _ray(given))


def _eye(opened: OpenPlace, before: Description, given: Given) -> Edit:
    name = given["seat"]
    if name not in before.file.seats:
        raise InputError(f"there is no seat {name!r} yet: pick its cushion and back")
    eye = seated_eye(before.file, name)
    how = f"assumed: the eyes of the {plain(PERSON)} seated in {name}, looking ahead"
    return pointed(before, f"{name}_design_eye", eye, how)


DESCRIBE_EDITS: Mapping[str, DescribeEdit] = {
    "mesh": _mesh,
    "long": lambda opened, before, given: scaled(opened, before, int(given["row"]), given["size"]),
    "move": lambda opened, before, given: moved_file(
        opened, before, int(given["row"]), given["to"]
    ),
    "meet": lambda opened, before, given: met_file(opened, before, _ray(given), _ray(given, "to_")),
    "take": lambda opened, before, given: removed_file(opened, before, int(given["row"])),
    "accept": lambda opened, before, given: accepted(before, given["about"]),
    "agree": lambda opened, before, given: agreed(before),
    "floor": lambda opened, before, given: floored(opened, before, _ray(given)),
    "face": lambda opened, before, given: faced(
        opened, before, given["seat"], given["surface"], _ray(given)
    ),
    "anew": lambda opened, before, given: faced(
        opened, before, given["seat"], given["surface"], None
    ),
    "carry": lambda opened, before, given: carried(opened, before, given["seat"], given["parts"]),
    "place": _place,
    "eye": _eye,
    "figure": lambda opened, before, given: typed(
        opened, before, given["kind"], given["name"], given["figure"], given["value"]
    ),
    "rename": lambda opened, before, given: renamed(
        before, given["kind"], given["name"], given["to"]
    ),
    "remove": lambda opened, before, given: removed(before, given["kind"], given["name"]),
    "own": lambda opened, before, given: owned(opened, before, given["control"], given["parts"]),
    "join": lambda opened, before, given: joined(opened, before, given["parts"], given["to"]),
    "leave": lambda opened, before, given: dropped(opened, before, given["parts"]),
    "back": lambda opened, before, given: put_back(
        opened, before, int(given["row"]), given["name"]
    ),
    "split": lambda opened, before, given: split_part(opened, before, given["part"]),
    "rule": lambda opened, before, given: ruled(
        opened, before, given["part"], given["rule"], given["value"]
    ),
}
"""The verbs that change a description: from an open environment, its description and what the verb
takes, to the description after it."""

LOOSE = 20
"""A mesh of more pieces than one for so many triangles is thinned over them."""
FARTHEST = 2e5
"""A mesh that is larger [m] is not drawn: its picture could not be sent."""


class DescribeDesk:
    """One open environment.

    Parameters
    ----------
    source
        A mesh, or an environment's file or folder.
    more
        Meshes that are added to it.
    out
        The file or folder to save in, None for beside the mesh, or the file itself.
    read_only
        Whether nothing is saved.
    clock
        Time [s] that rises.
    """

    page = "describe.html"
    verbs = DESCRIBE_VERBS
    judges = False

    def __init__(
        self,
        source: str,
        *more: str,
        out: str = "",
        read_only: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.source = Path(source)
        self.more = tuple(Path(path) for path in more)
        self.out = Path(out) if out else None
        self.read_only = read_only
        self.clock = clock
        self.sitting = False
        self._seated: tuple[Description, dict[str, SeatedWords]] | None = None
        self._others: Mapping[str, Callable[[Question], Replies]] = {
            "sit": self._sit,
            "add": self._add,
            "study": self._study,
            "undo": self._undo,
            "redo": self._redo,
            "save": self._save,
            "reload": self._reload,
        }
        self.open()

    def open(self) -> None:
        """Read the environment from its file; what was done to it before is forgotten."""
        opened = open_place(self.source, self.out)
        for path in self.more:
            found = added_file(opened, opened.start, path)
            start = found.edit.description
            notes = (*opened.notes, found.edit.words)
            opened = replace(found.opened, start=start, notes=notes)
        self.opened = opened
        self.disk: SavedPlace | None = None
        if opened.text is not None:
            self.disk = SavedPlace(opened.text, opened.start.says)
        self.saved_content = opened.start.content if opened.text is not None else ""
        self.target = opened.target
        self.history: History[Description] = History.of(opened.start)
        self.warnings: tuple[str, ...] = ()
        self.__dict__.pop("_thin", None)

    @property
    def live(self) -> Description:
        """The description as it is."""
        return self.history.shown.arrangement

    @property
    def unsaved(self) -> bool:
        """Whether it differs from the file."""
        return self.live.content != self.saved_content

    @cached_property
    def _thin(self) -> ThinMesh:
        """All meshes as they are drawn, in the units and axes of their files."""
        meshes = self.opened.meshes
        return thinned(meshes.vertices, meshes.faces, _groups(meshes))

    def greeting(self) -> list[bytes]:
        """What a page needs that was just opened."""
        busy = busy_frame(0, "the picture is being made")
        return [describe_hello(self.opened, person_words(), saves=not self.read_only), busy]

    def state(self) -> list[bytes]:
        """The description as it is."""
        return [self._answered(0, "; ".join(self.opened.notes))]

    def scene(self) -> WebView:
        """The picture as it is now: the meshes, the person beside them, and who is seated."""
        description = self.live
        bounds = standing_of(self.opened, description).bounds
        if float(np.abs(bounds).max()) > FARTHEST:
            raise InputError("the mesh is too large to be drawn: choose a smaller unit")
        file = description.file
        bodies = [body_view(standing_person(bounds), "person for scale", "grey")]
        if self.sitting:
            for name, colour in zip(file.seats, cycle(PEOPLE), strict=False):
                bodies.append(body_view(seated_person(file, name), name, colour))
        place = drawn_place(self.opened, description, self._thin)
        return WebView(str(description.says["environment"]), tuple(bodies), place)

    def preparation(self, question: Question) -> None:
        """Say that nothing is to be done before `do`: None."""

    def do(self, question: Question) -> Replies:
        """Do what is asked. What cannot be done leaves everything as it was, and is reported to who
        asked."""
        try:
            if question.verb in self._others:
                return self._others[question.verb](question)
            return self._edited(question)
        except ForeignFileError as error:
            return Replies(asker=[fault_frame(question, str(error), ask="over")])
        except Exception as error:  # noqa: BLE001 (one question that fails must not end the bench)
            return Replies(asker=[fault_frame(question, words_of(error))])

    def keep(self) -> str:
        """Keep what is not saved in a file of its own; where, in words, "" where nothing is."""
        if self.read_only or not self.unsaved or not (self.history.can_undo or self.disk):
            return ""
        to = kept_file(self.target)
        try:
            save_description(self.opened, self.live, self.disk, to=to, over=True)
        except InputError as error:
            return f"what was not saved is lost: {error}"
        return f"what was not saved is in {to}: workbench live {to} goes on with it"

    def _answered(self, number: int, words: str) -> bytes:
        """The frame of the description as it is."""
        description = self.live
        meshes = self.opened.meshes
        head = {
            "answers": number,
            "words": printable(words),
            "undo": self.history.can_undo,
            "redo": self.history.can_redo,
            "unsaved": self.unsaved,
            "file": printable(self.target.name),
            "saved": self.disk is not None,
            "study": self._study_path.name if self._study_path.exists() else "",
            "others": files_beside(self.opened),
            "warnings": [_put_away(words) for words in self.warnings],
            "unfinished": unfinished(self.opened, description),
            "next": [] if self.disk is None else next_commands(self.target),
            "drawn": len(self._thin.faces),
            "of": len(meshes.faces),
            "sitting": self.sitting,
            "seated": {name: asdict(one) for name, one in self._seated_words().items()},
            "scene": self._scene_key(description),
        }
        return description_frame(self.opened, description, head)

    def _scene_key(self, description: Description) -> str:
        """A text that is another one where the picture is."""
        file = description.file
        seats = [seat.model_dump_json() for seat in file.seats.values()] if self.sitting else []
        looks = [
            *(mesh.model_dump_json() for mesh in file.meshes),
            *(f"{name} {rule.see_through}" for name, rule in file.parts.items()),
            *(seat.cushion.part + seat.back.part for seat in file.seats.values()),
            *(key for control in file.controls.values() for key in control.part_keys),
        ]
        return str(crc32(repr((*seats, self.sitting, *looks)).encode()))

    def _edited(self, question: Question) -> Replies:
        """Do an edit. A description that cannot be answered is not taken."""
        edit = DESCRIBE_EDITS[question.verb](self.opened, self.live, question.given)
        before = self.history
        if edit.description.content != self.live.content:
            self.history = before.added(Entry(edit.description, time=self.clock()))
        try:
            return Replies([self._answered(question.number, edit.words)])
        except WorkbenchError:
            self.history = before
            raise

    def _sit(self, question: Question) -> Replies:
        on = bool(question.given["on"])
        if on and not self.live.file.seats:
            raise InputError("there is no seat yet: pick a cushion and a back")
        self.sitting = on
        seated = self._seated_words().values()
        words = [words for one in seated for words in (*one.doubts, *one.notes)]
        return Replies([self._answered(question.number, "; ".join(words))])

    def _seated_words(self) -> dict[str, SeatedWords]:
        """By its seat, what is said of the person in it as the description is."""
        if not self.sitting:
            return {}
        description = self.live
        if self._seated is None or self._seated[0] is not description:
            ground = standing_of(self.opened, description).ground
            file = description.file
            found = {name: seated_words(file, name, ground) for name in file.seats}
            self._seated = (description, found)
        return self._seated[1]

    def _add(self, question: Question) -> Replies:
        """Add a mesh file, named from the folder of the meshes or by its whole path."""
        path = self.opened.folder / Path(question.given["file"]).expanduser()
        found = added_file(self.opened, self.live, path)
        before = self.opened, self.history
        self.opened = found.opened
        self.__dict__.pop("_thin", None)
        self.history = self.history.added(Entry(found.edit.description, time=self.clock()))
        try:
            return Replies([self._answered(question.number, found.edit.words)])
        except WorkbenchError:
            self.opened, self.history = before
            self.__dict__.pop("_thin", None)
            raise

    @property
    def _study_path(self) -> Path:
        """The study that `workbench new` makes of the environment."""
        return self.target.with_name("study.yaml")

    def _study(self, question: Question) -> Replies:
        """Open the study beside the environment, or a first one that is made."""
        if self.disk is None or self.unsaved:
            raise InputError("save the environment first: a study is of what its file says")
        path = self._study_path
        if path.exists() and question.given["anew"]:
            path = free_file(path)
        if not path.exists():
            if self.read_only:
                raise InputError("the bench was started to read only")
            save_first_study(self.target, path)
        return Replies(
            [packed({"kind": "busy", "answers": question.number, "what": f"opening {path.name}"})],
            study=path,
        )

    def _undo(self, question: Question) -> Replies:
        self.history = self.history.undone()
        return Replies([self._answered(question.number, "")])

    def _redo(self, question: Question) -> Replies:
        self.history = self.history.redone()
        return Replies([self._answered(question.number, "")])

    def _save(self, question: Question) -> Replies:
        if self.read_only:
            raise InputError("the bench was started to read only")
        name = question.given["to"]
        to = new_file(self.target.parent, name, like=self.target.stem) if name else None
        self.disk = save_description(
            self.opened, self.live, self.disk, to=to or self.target, over=question.given["over"]
        )
        self.target = self.disk.text.path
        self.source = self.target
        self.more = ()
        sizes = [doubt.said for doubt in open_sizes(self.opened, self.live)]
        self.warnings = tuple(words for words in self.disk.warnings if words not in sizes)
        self.saved_content = self.live.content
        head = {"kind": "saved", "answers": question.number, "file": printable(self.target.name)}
        words = f"saved {self.target.name}; it loads without a fault"
        if self.warnings:
            many = len(self.warnings)
            words += f", with {many} warning{'s' if many > 1 else ''}"
        lead = f"next: {next_commands(self.target)[0]}"
        words = "; ".join([words, *unfinished(self.opened, self.live), lead])
        return Replies([packed(head), self._answered(0, words)])

    def _reload(self, question: Question) -> Replies:
        self.open()
        return Replies([*self.greeting(), self._answered(question.number, "read again")])


def _put_away(words: str) -> dict[str, str]:
    """A warning, and what it is about where it can be put away."""
    found = re.fullmatch(r"(.*) \[([^\[\]]+)\]", words, re.DOTALL)
    return (
        {"words": words, "about": ""} if found is None else {"words": found[1], "about": found[2]}
    )


def _groups(meshes: Meshes) -> Ints:
    """(V,) the connected piece of each vertex, or its part where the pieces are tiny."""
    a, b, c = meshes.faces.T
    found = component_labels(np.concatenate([a, b]), np.concatenate([b, c]), len(meshes.vertices))
    if int(found.max(initial=0)) * LOOSE < len(meshes.faces):
        return found
    part = np.zeros(len(meshes.vertices), dtype=np.int64)
    part[meshes.faces] = meshes.owner[:, None]
    return part
