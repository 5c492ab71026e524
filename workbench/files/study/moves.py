"""What a study's file says of controls and parts that stand elsewhere: in the whole study, and in
the changes of a population's workplace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from workbench.errors import one_of
from workbench.files.names import matching
from workbench.files.study.schema import ChangeFile, DisplacedFile, MovedFile
from workbench.files.study.work import Key, Work
from workbench.model.accommodation import Change
from workbench.model.environment import Environment
from workbench.model.surroundings import Move, parts_along

__all__ = ["change_of", "move_faults", "moves_of", "riding_words"]

_By = tuple[float, float, float]


def moves_of(files: Sequence[MovedFile], room: Environment) -> tuple[Move, ...]:
    """The moves of a file without faults, in its order."""
    return tuple(_move(file, file.by, room) for file in files)


def change_of(file: ChangeFile, room: Environment) -> Change:
    """A change of a file without faults."""
    direct = () if file.move is None else (_move(file, file.move, room),)
    return Change(
        words=file.name,
        moves=(*direct, *moves_of(file.moved or (), room)),
        travel_forward=(-file.farther_back, file.farther_forward),
        travel_up=(-file.lower, file.higher),
    )


def _move(file: DisplacedFile, by: _By, room: Environment) -> Move:
    """What is named, with the parts that controls take along: a control on one of these is not said
    again."""
    controls = _controls(file, room)
    parts = {*matching(file.parts or (), room.parts), *_along(file, room)}
    on = {control.name: control.part for control in room.controls}
    return Move(
        parts=tuple(name for name in room.parts if name in parts),
        controls=tuple(name for name in controls if on[name] not in parts),
        by=by,
    )


def _controls(file: DisplacedFile, room: Environment) -> tuple[str, ...]:
    """The controls that are named, in the environment's order."""
    names = [control.name for control in room.controls]
    found = {*matching(file.controls or (), names), file.control}
    return tuple(name for name in names if name in found)


@dataclass(frozen=True)
class _Entry:
    """An entry of a file that moves something: where it stands, and what a fault calls it."""

    key: Key
    words: str
    file: DisplacedFile


def move_faults(work: Work, room: Environment) -> None:
    """Report moves of what is not there, of what goes with a seat, and of what is moved twice: in
    the study, and in each of its changes."""
    study = [_Entry(("moved", row), f"entry {row + 1}", file) for row, file in work.parts.moved]
    _entry_faults(work, study, room)
    for entry in study:
        _riding_faults(work, entry, room)
    for row, change in work.parts.changes:
        key: Key = ("changes", row)
        more = [
            _Entry((*key, "moved", k), f"entry {k + 1} of 'moved'", file)
            for k, file in enumerate(change.moved or ())
        ]
        _entry_faults(work, [_Entry(key, "'move'", change), *more], room)
    if work.parts.moved and any(
        action is not None and action.simulated is not None
        for _, case in work.parts.cases
        for action in case.actions.values()
    ):
        what = "a simulated motion takes place in the environment of its simulation: leave 'moved'"
        work.fault(("moved",), f"{what} out, or the case")


def riding_words(room: Environment, names: Sequence[str]) -> str:
    """That the first of some parts that does goes with a seat, "" where none does."""
    riding = {name: seat.name for seat in room.seats for name in seat.moves}
    return next(
        (
            f"part {name!r} goes with seat {riding[name]!r}: give a role in it a 'position' instead"
            for name in names
            if name in riding
        ),
        "",
    )


def _entry_faults(work: Work, entries: Sequence[_Entry], room: Environment) -> None:
    """Report names of what is not there, and what is moved twice by entries made together."""
    taken: dict[str, _Entry] = {}
    controls = [control.name for control in room.controls]
    for entry in entries:
        for key, kind, pattern in _named(entry):
            names = room.parts if kind == "part" else controls
            found = [pattern] if key[-1] == "control" else matching((pattern,), names)
            if not any(name in names for name in found):
                what = f"environment {room.name} has no {kind} {pattern!r}"
                work.fault(key, f"{what}; {one_of(pattern, names)}")
            for name in found:
                _once(work, key, taken, f"{kind} {name!r}", entry)
        for part in _along(entry.file, room):
            riders = ", ".join(one.name for one in room.controls if one.part == part)
            goes = f", and goes along with {riders} here"
            _once(work, _controls_key(entry), taken, f"part {part!r}", entry, goes)


def _along(file: DisplacedFile, room: Environment) -> tuple[str, ...]:
    """The parts that the controls of an entry take along."""
    return () if file.alone else parts_along(room, _controls(file, room))


def _named(entry: _Entry) -> Iterator[tuple[Key, str, str]]:
    """Each name and pattern of an entry, with where it stands and whether it is of a "control" or a
    "part"."""
    if entry.file.control is not None:
        yield (*entry.key, "control"), "control", entry.file.control
    for place, name in enumerate(entry.file.controls or ()):
        yield (*entry.key, "controls", place), "control", name
    for place, name in enumerate(entry.file.parts or ()):
        yield (*entry.key, "parts", place), "part", name


def _controls_key(entry: _Entry) -> Key:
    """Where an entry names its controls."""
    return (*entry.key, "control" if entry.file.control is not None else "controls")


def _riding_faults(work: Work, entry: _Entry, room: Environment) -> None:
    """Report parts that go with a seat, the first of each name and of those taken along."""
    places: list[tuple[Key, Sequence[str]]] = [
        ((*entry.key, "parts", place), matching((pattern,), room.parts))
        for place, pattern in enumerate(entry.file.parts or ())
    ]
    for key, names in [*places, (_controls_key(entry), _along(entry.file, room))]:
        if what := riding_words(room, names):
            work.fault(key, what)


def _once(
    work: Work, key: Key, taken: dict[str, _Entry], what: str, entry: _Entry, goes: str = ""
) -> None:
    """Report something that another entry has moved already.

    goes: with what it goes along, where it is not named.
    """
    before = taken.setdefault(what, entry)
    if before is not entry:
        work.fault(key, f"{what} is moved by {before.words} already{goes}; move it once")
