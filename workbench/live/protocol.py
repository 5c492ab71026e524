"""The messages of the bench: what a page may ask, checked by a table, and how answers are packed.

A question is a JSON object with a number `n`, a verb `do` and what the verb takes. An answer is laid
out as a block of pictures is (`draw.web.packing`): the length of its header (four bytes,
little-endian), the header as JSON, and the arrays that the header names, one after the other, of
each the low bytes of all numbers first. Numbers are not rounded and not written as differences. What
a question comes to are frames that are sent at once, and work that takes longer.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError, one_of
from workbench.live.filming import Film
from workbench.posture.reaching.limbs import FEET, GRIPS, HANDS, ZONES

__all__ = [
    "LONGEST",
    "SUBPROTOCOL",
    "VERBS",
    "Job",
    "Made",
    "Question",
    "Replies",
    "Run",
    "VerbArgument",
    "Verbs",
    "is_flag",
    "is_number",
    "is_point",
    "is_text",
    "is_texts",
    "one_valid",
    "packed",
    "parsed",
    "unpacked",
]

LONGEST = 65_536
"""Bytes of a question."""
SUBPROTOCOL = "workbench-1"
LONGEST_TEXT = 400
MOST_NAMES = 1000
LARGEST = 2**53
"""Whole numbers beyond are not the same in every language."""


@dataclass(frozen=True)
class Question:
    """A question that was checked.

    Parameters
    ----------
    number
        By which the answer names it.
    verb
        One of VERBS.
    given
        What the verb takes, and nothing else.
    again
        Whether it may have been asked already, over a connection that was lost.
    """

    number: int
    verb: str
    given: Mapping[str, Any]
    again: bool = False

    @property
    def done(self) -> bool:
        """Whether it ends what it is about; one on the way of a drag does not."""
        return bool(self.given.get("done", True))

    @property
    def subject(self) -> tuple[Any, ...]:
        """What it is about: a newer question of the same subject replaces one that waits."""
        names = ("person", "joint", "axis", "limb", "parts", "controls")
        return (self.verb, *(self.given.get(name) for name in names))


def is_text(value: Any) -> bool:
    """Whether a value is a text, not empty and not too long."""
    return isinstance(value, str) and 0 < len(value) <= LONGEST_TEXT


def is_flag(value: Any) -> bool:
    """Whether a value is true or false."""
    return isinstance(value, bool)


def is_number(value: Any) -> bool:
    """Whether a value is a number that is not too large."""
    return isinstance(value, (int, float)) and not is_flag(value) and abs(value) < LARGEST


def _count(value: Any) -> bool:
    return isinstance(value, int) and not is_flag(value) and 0 <= value < LARGEST


def _pixels(value: Any) -> bool:
    return _count(value) and value > 0


def is_texts(value: Any) -> bool:
    """Whether a value is a list of texts."""
    return isinstance(value, list) and len(value) <= MOST_NAMES and all(map(is_text, value))


def _numbers(value: Any) -> bool:
    """Numbers by name."""
    return _named(value, is_number)


def _named(value: Any, check: Callable[[Any], bool]) -> bool:
    return (
        isinstance(value, dict)
        and len(value) <= MOST_NAMES
        and all(map(is_text, value))
        and all(map(check, value.values()))
    )


def is_point(value: Any) -> bool:
    """Whether a value is a list of three numbers."""
    return isinstance(value, list) and len(value) == 3 and all(map(is_number, value))


def _thing(value: Any) -> bool:
    """Whether a value names a part, a control, or a segment of a person."""
    if not isinstance(value, dict) or not all(map(is_text, value.values())):
        return False
    return set(value) in ({"part"}, {"control"}, {"person", "segment"})


def one_valid(*valid: object) -> Callable[[Any], bool]:
    """Make the check that a value is one of some texts or whole numbers."""

    def check(value: Any) -> bool:
        return not is_flag(value) and isinstance(value, (str, int)) and value in valid

    return check


@dataclass(frozen=True)
class VerbArgument:
    """Something that a verb takes: what it must be, in words and as a check; and what holds where
    it is not given, `needed` where it must be."""

    words: str
    check: Callable[[Any], bool]
    default: Any = None
    needed: bool = True


Verbs = Mapping[str, Mapping[str, VerbArgument]]
"""What may be asked of a desk, and what each verb takes."""
_PERSON = VerbArgument("the name of a person", is_text)
_DONE = VerbArgument("true or false", is_flag, True, needed=False)
_METRES = VerbArgument("a number of metres", is_number)
_THING = VerbArgument("a part, a control, or a person and a segment", _thing)
_MOTION = VerbArgument("the name of a case that is a motion", is_text)
_FRAME = VerbArgument("the number of a frame", _count)
_GRIPS = tuple(grip for grips in GRIPS.values() for grip in grips)

VERBS: Verbs = {
    "joint": {
        "person": _PERSON,
        "joint": VerbArgument("the mnemonic of a joint", is_text),
        "axis": VerbArgument("0, 1 or 2", one_valid(0, 1, 2)),
        "degrees": VerbArgument("a number of degrees", is_number),
        "done": _DONE,
    },
    "hand": {
        "person": _PERSON,
        "limb": VerbArgument("a hand or foot", one_valid(*HANDS, *FEET)),
        "target": VerbArgument("three numbers of metres", is_point, needed=False),
        "control": VerbArgument("the name of a control", is_text, "", needed=False),
        "grip": VerbArgument("a grip", one_valid(*_GRIPS), needed=False),
        "zone": VerbArgument("1, 2 or 3", one_valid(*ZONES), 1, needed=False),
        "obstacles": VerbArgument("true or false", is_flag, False, needed=False),
        "done": _DONE,
    },
    "seat": {"person": _PERSON, "forward": _METRES, "up": _METRES, "done": _DONE},
    "move": {
        "parts": VerbArgument("a list of names of parts", is_texts, [], needed=False),
        "controls": VerbArgument("a list of names of controls", is_texts, [], needed=False),
        "by": VerbArgument("three numbers of metres", is_point),
        "done": _DONE,
    },
    "ready": {
        "parts": VerbArgument("a list of names of parts", is_texts, [], needed=False),
        "controls": VerbArgument("a list of names of controls", is_texts, [], needed=False),
    },
    "adjust": {
        "name": VerbArgument("the name of an adjustment", is_text),
        "value": VerbArgument("a number of metres, or of radians", is_number),
    },
    "size": {
        "person": _PERSON,
        "sex": VerbArgument("male or female", one_valid("male", "female"), "", needed=False),
        "measures": VerbArgument("metres by the name of a measure", _numbers, {}, needed=False),
        "percentiles": VerbArgument(
            "percentiles by the name of a measure", _numbers, {}, needed=False
        ),
        "mass": VerbArgument("a number of kilograms", is_number, needed=False),
        "age": VerbArgument("a number of years", is_number, needed=False),
    },
    "clothes": {"person": _PERSON, "clothes": VerbArgument("a list of names of clothes", is_texts)},
    "harness": {
        "person": _PERSON,
        "zone": VerbArgument("1, 2 or 3", one_valid(*ZONES), needed=False),
    },
    "posture": {"person": _PERSON, "name": VerbArgument("the name of a posture", is_text)},
    "predict": {
        "person": _PERSON,
        "like": VerbArgument("the name of a posture", is_text),
        "holds": VerbArgument(
            "names of controls by limb", lambda value: _named(value, is_text), {}, needed=False
        ),
        "eyes": VerbArgument("the name of a point", is_text, "", needed=False),
        "heels": VerbArgument("the name of a point", is_text, "", needed=False),
        "everywhere": VerbArgument("true or false", is_flag, False, needed=False),
        "free": VerbArgument("true or false", is_flag, False, needed=False),
    },
    "free": {"person": _PERSON},
    "mirror": {"person": _PERSON},
    "case": {"name": VerbArgument("the name of a case", is_text)},
    "criterion": {
        "person": _PERSON,
        "segment": VerbArgument("the name of a segment", is_text),
        "part": VerbArgument("the name of a part", is_text, "", needed=False),
        "other": VerbArgument("the name of a person", is_text, "", needed=False),
        "other_segment": VerbArgument("the name of a segment", is_text, "", needed=False),
        "at_least": _METRES,
        "name": VerbArgument("a name", is_text, "", needed=False),
    },
    "measure": {"of": _THING, "to": _THING},
    "ghost": {},
    "film": {
        "case": VerbArgument("the name of a case that is a motion", is_text, "", needed=False),
        "eye": VerbArgument("three numbers of metres", is_point),
        "at": VerbArgument("three numbers of metres", is_point),
        "angle": VerbArgument("a number of radians", is_number),
        "width": VerbArgument("a number of pixels from 1 on", _pixels),
        "height": VerbArgument("a number of pixels from 1 on", _pixels),
        "eyes": VerbArgument("the name of a person", is_text, "", needed=False),
        "hidden": VerbArgument("a list of names of parts", is_texts, [], needed=False),
        "without": VerbArgument("a list of names of people", is_texts, [], needed=False),
        "section": VerbArgument(
            "an axis, a side and a number of metres",
            lambda value: is_point(value) and value[0] in (0, 1, 2) and value[1] in (-1, 1),
            needed=False,
        ),
    },
    "film_end": {},
    "envelope": {
        "person": _PERSON,
        "limb": VerbArgument("a hand", one_valid(*HANDS)),
        "zone": VerbArgument("1, 2 or 3", one_valid(*ZONES), 1, needed=False),
        "obstacles": VerbArgument("true or false", is_flag, True, needed=False),
    },
    "field": {
        "person": _PERSON,
        "toward": VerbArgument("three numbers", is_point),
        "within": VerbArgument("30, 60, 90 or 180", one_valid(30, 60, 90, 180), 60, needed=False),
        "fine": VerbArgument("true or false", is_flag, False, needed=False),
    },
    "motion": {"case": _MOTION},
    "frames": {"case": _MOTION, "from": _FRAME, "to": _FRAME},
    "gaps": {"case": _MOTION},
    "near": {"case": _MOTION, "frame": _FRAME},
    "drop": {},
    "undo": {},
    "redo": {},
    "save": {
        "sharing": VerbArgument(
            "ask, all or one", one_valid("ask", "all", "one"), "ask", needed=False
        ),
        "over": VerbArgument("true or false", is_flag, False, needed=False),
        "to": VerbArgument("the name of a file", is_text, "", needed=False),
    },
    "reload": {},
    "report": {
        "people": VerbArgument("a number of people", _count, 0, needed=False),
        "how": VerbArgument(
            "ask, as it is or anew", one_valid("ask", "as it is", "anew"), "ask", needed=False
        ),
    },
    "report_end": {},
}
"""What a page may ask, and what each verb takes."""


def parsed(text: str | bytes, verbs: Verbs | None = None) -> Question:
    """Check a question.

    Parameters
    ----------
    verbs
        What may be asked; that of a study if None.

    Raises
    ------
    InputError
        If it is too long, no JSON object, asks for what is not there, lacks something or has too
        much, or if a value is not of its kind: no number is infinite or NaN.
    """
    data = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    if len(data) > LONGEST:
        raise InputError(f"a message has at most {LONGEST} bytes, got {len(data)}")
    message = _object(data)
    number = message.pop("n", 0)
    if not isinstance(number, int) or is_flag(number) or not 0 <= number < LARGEST:
        raise InputError("n: a whole number from 0 on is needed")
    again = message.pop("again", False)
    if not is_flag(again):
        raise InputError("again: true or false is needed")
    table = VERBS if verbs is None else verbs
    verb = message.pop("do", None)
    if verb is None:
        raise InputError(f"'do' is missing: expected one of {', '.join(table)}")
    if not isinstance(verb, str) or verb not in table:
        raise InputError(f"do: nothing is called {str(verb)[:40]!r}; {one_of(str(verb), table)}")
    return Question(number, verb, _given(verb, table[verb], message), again)


def _object(data: bytes) -> dict[str, Any]:
    """The JSON object that some bytes are."""
    try:
        message = json.loads(data, parse_constant=_no_number, parse_float=_finite)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a message is JSON: {str(error)[:200]}") from None
    if not isinstance(message, dict):
        raise InputError("a message is a JSON object")
    return message


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:40]} is too large")
    return value


def _given(
    verb: str, taken: Mapping[str, VerbArgument], message: Mapping[str, Any]
) -> dict[str, Any]:
    """What a verb takes, with what holds where something is not given."""
    for key in message:
        if key not in taken:
            raise InputError(f"{verb} takes no {key[:40]!r}; {one_of(key, taken)}")
    found = {}
    for key, row in taken.items():
        value = message.get(key)
        if value is None:
            if row.needed:
                raise InputError(f"{verb}: {key!r} is missing: expected {row.words}")
            found[key] = row.default
        elif not row.check(value):
            raise InputError(f"{verb}: {key}: expected {row.words}, got {str(value)[:40]!r}")
        else:
            found[key] = value
    return found


def packed(head: Mapping[str, Any], arrays: Sequence[tuple[str, NDArray[Any]]] = ()) -> bytes:
    """Pack an answer: a header that JSON can write, and named arrays."""
    entries = [
        {"name": name, "kind": values.dtype.str[1:], "count": int(values.size)}
        for name, values in arrays
    ]
    text = json.dumps({**head, "arrays": entries}, allow_nan=False, separators=(",", ":")).encode()
    planes = [
        np.ascontiguousarray(values).reshape(-1, 1).view(np.uint8).T.tobytes()
        for _, values in arrays
    ]
    return b"".join([struct.pack("<I", len(text)), text, *planes])


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Unpack an answer into its header and its arrays, each flat."""
    (length,) = struct.unpack_from("<I", data)
    head = json.loads(data[4 : 4 + length])
    at = 4 + length
    arrays = {}
    for entry in head.pop("arrays"):
        kind = np.dtype(f"<{entry['kind']}")
        count = entry["count"]
        planes = np.frombuffer(data, np.uint8, count * kind.itemsize, at)
        rows = np.ascontiguousarray(planes.reshape(kind.itemsize, count).T)
        arrays[entry["name"]] = rows.view(kind).ravel()
        at += count * kind.itemsize
    return head, arrays


@dataclass(frozen=True, eq=False)
class Made:
    """Frames for who asked, and the work that goes on from there; None where it is done."""

    frames: list[bytes]
    more: Job | None = None


class Job(Protocol):
    """Something that takes long, of a frozen state; it is done in a thread of its own.

    A newer one of the same kind that the same page asks for takes its place.
    """

    @property
    def kind(self) -> str:
        """What it is, as a verb of the protocol."""

    @property
    def generation(self) -> int | None:
        """The number of the state; what is left of it is dropped once the state is another. None
        where it is of no state that changes."""

    def made(self) -> Made:
        """Do it, or a piece of it."""


@dataclass(frozen=True)
class Run:
    """A study that is to be run, and its report written.

    Parameters
    ----------
    study
        Its file.
    environment
        The file of its environment.
    people
        So many people of a survey: the study is written first, as a first one of the environment. 0
        where it is there.
    """

    study: Path
    environment: Path
    people: int = 0


@dataclass
class Replies:
    """Frames for everybody, frames for who asked alone, whether the study is another now, what is to
    be done for who asked, a film that is to be made, or ended, the file of a study that is to be
    opened in the place of what is open, and a study that is to be run, or whose run is to end."""

    everybody: list[bytes] = field(default_factory=list)
    asker: list[bytes] = field(default_factory=list)
    changed: bool = False
    work: Job | None = None
    film: Film | None = None
    film_ends: bool = False
    study: Path | None = None
    run: Run | None = None
    run_ends: bool = False
