"""What a study's file says of parts and controls that stand elsewhere than the environment has
them."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.errors import one_of
from workbench.files.names import matches, matching
from workbench.files.study.schema import MovedFile
from workbench.files.study.work import Key, Work
from workbench.model.environment import Environment
from workbench.model.moves import Move

__all__ = ["move_faults", "moves_of", "riding_words"]


def moves_of(files: Sequence[MovedFile], room: Environment) -> tuple[Move, ...]:
    """The moves of a file without faults, in its order."""
    return tuple(
        Move(
            parts=matching(file.parts, room.parts) if file.parts else (),
            controls=tuple(file.controls or ()),
            by=file.by,
        )
        for file in files
    )


def move_faults(work: Work, room: Environment) -> None:
    """Report moves of what is not there, of what goes with a seat, and of what is moved twice."""
    controls = [control.name for control in room.controls]
    taken: dict[str, int] = {}
    for row, file in work.parts.moved:
        for place, name in enumerate(file.controls or ()):
            what = f"environment {room.name} has no control {name!r}"
            key = ("moved", row, "controls", place)
            if work.check_name(key, name, controls, what):
                _once(work, key, taken, f"control {name!r}", row)
        for place, pattern in enumerate(file.parts or ()):
            key = ("moved", row, "parts", place)
            names = [name for name in room.parts if matches(pattern, name)]
            if not names:
                what = f"environment {room.name} has no part {pattern!r}"
                work.fault(key, f"{what}; {one_of(pattern, room.parts)}")
            if what := riding_words(room, names):
                work.fault(key, what)
            for name in names:
                _once(work, key, taken, f"part {name!r}", row)
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


def _once(work: Work, key: Key, taken: dict[str, int], what: str, row: int) -> None:
    """Report something that an entry before has moved already."""
    if taken.setdefault(what, row) != row:
        work.fault(key, f"{what} is moved by entry {taken[what] + 1} already; move it once")
