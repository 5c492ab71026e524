"""The messages of the bench: what a page may ask, checked by a table, and how answers are packed.

A question is a JSON object with a number `n`, a verb `do` and what the verb takes. An answer is laid
out as a block of pictures is (`draw.web.packing`): the length of its header (four bytes,
little-endian), the header as JSON, and the arrays that the header names, one after the other, of
each the low bytes of all numbers first. Numbers are not rounded and not written as differences.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError, one_of
from workbench.posture.reaching.limbs import FEET, GRIPS, HANDS, ZONES

__all__ = [
    "LONGEST",
    "SUBPROTOCOL",
    "VERBS",
    "Question",
    "Taken",
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
    """

    number: int
    verb: str
    given: Mapping[str, Any]

    @property
    def done(self) -> bool:
        """Whether it ends what it is about; one on the way of a drag does not."""
        return bool(self.given.get("done", True))

    @property
    def subject(self) -> tuple[Any, ...]:
        """What it is about: a newer question of the same subject replaces one that waits."""
        names = ("person", "joint", "axis", "limb", "parts", "controls")
        return (self.verb, *(self.given.get(name) for name in names))


def _text(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_TEXT


def _flag(value: Any) -> bool:
    return isinstance(value, bool)


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not _flag(value) and abs(value) < LARGEST


def _count(value: Any) -> bool:
    return isinstance(value, int) and not _flag(value) and 0 <= value < LARGEST


def _texts(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= MOST_NAMES and all(map(_text, value))


def _numbers(value: Any) -> bool:
    """Numbers by name."""
    return _named(value, _number)


def _names_by_limb(value: Any) -> bool:
    return _named(value, _text)


def _named(value: Any, check: Callable[[Any], bool]) -> bool:
    return (
        isinstance(value, dict)
        and len(value) <= MOST_NAMES
        and all(map(_text, value))
        and all(map(check, value.values()))
    )


def _point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_number, value))


def _thing(value: Any) -> bool:
    """Whether a value names a part, a control, or a segment of a person."""
    if not isinstance(value, dict) or not all(map(_text, value.values())):
        return False
    return set(value) in ({"part"}, {"control"}, {"person", "segment"})


def _any_of(*valid: object) -> Callable[[Any], bool]:
    def check(value: Any) -> bool:
        return not _flag(value) and isinstance(value, (str, int)) and value in valid

    return check


@dataclass(frozen=True)
class _Taken:
    """Something that a verb takes: what it must be, in words and as a check; and what holds where
    it is not given, `needed` where it must be."""

    words: str
    check: Callable[[Any], bool]
    default: Any = None
    needed: bool = True


# What the tables of other desks are made of.
Taken = _Taken
Verbs = Mapping[str, Mapping[str, Taken]]
is_flag = _flag
is_number = _number
is_point = _point
is_text = _text
is_texts = _texts
one_valid = _any_of

_PERSON = _Taken("the name of a person", _text)
_DONE = _Taken("true or false", _flag, True, needed=False)
_METRES = _Taken("a number of metres", _number)
_THING = _Taken("a part, a control, or a person and a segment", _thing)
_MOTION = _Taken("the name of a case that is a motion", _text)
_FRAME = _Taken("the number of a frame", _count)
_GRIPS = tuple(grip for grips in GRIPS.values() for grip in grips)

VERBS: Mapping[str, Mapping[str, _Taken]] = {
    "joint": {
        "person": _PERSON,
        "joint": _Taken("the mnemonic of a joint", _text),
        "axis": _Taken("0, 1 or 2", _any_of(0, 1, 2)),
        "degrees": _Taken("a number of degrees", _number),
        "done": _DONE,
    },
    "hand": {
        "person": _PERSON,
        "limb": _Taken("a hand or foot", _any_of(*HANDS, *FEET)),
        "target": _Taken("three numbers of metres", _point, needed=False),
        "control": _Taken("the name of a control", _text, "", needed=False),
        "grip": _Taken("a grip", _any_of(*_GRIPS), needed=False),
        "zone": _Taken("1, 2 or 3", _any_of(*ZONES), 1, needed=False),
        "obstacles": _Taken("true or false", _flag, False, needed=False),
        "done": _DONE,
    },
    "seat": {"person": _PERSON, "forward": _METRES, "up": _METRES, "done": _DONE},
    "move": {
        "parts": _Taken("a list of names of parts", _texts, [], needed=False),
        "controls": _Taken("a list of names of controls", _texts, [], needed=False),
        "by": _Taken("three numbers of metres", _point),
        "done": _DONE,
    },
    "adjust": {
        "name": _Taken("the name of an adjustment", _text),
        "value": _Taken("a number of metres, or of radians", _number),
    },
    "size": {
        "person": _PERSON,
        "sex": _Taken("male or female", _any_of("male", "female"), "", needed=False),
        "measures": _Taken("metres by the name of a measure", _numbers, {}, needed=False),
        "percentiles": _Taken("percentiles by the name of a measure", _numbers, {}, needed=False),
        "mass": _Taken("a number of kilograms", _number, needed=False),
        "age": _Taken("a number of years", _number, needed=False),
    },
    "clothes": {"person": _PERSON, "clothes": _Taken("a list of names of clothes", _texts)},
    "harness": {"person": _PERSON, "zone": _Taken("1, 2 or 3", _any_of(*ZONES), needed=False)},
    "posture": {"person": _PERSON, "name": _Taken("the name of a posture", _text)},
    "predict": {
        "person": _PERSON,
        "like": _Taken("the name of a posture", _text),
        "holds": _Taken("names of controls by limb", _names_by_limb, {}, needed=False),
        "eyes": _Taken("the name of a point", _text, "", needed=False),
        "heels": _Taken("the name of a point", _text, "", needed=False),
    },
    "free": {"person": _PERSON},
    "mirror": {"person": _PERSON},
    "case": {"name": _Taken("the name of a case", _text)},
    "criterion": {
        "person": _PERSON,
        "segment": _Taken("the name of a segment", _text),
        "part": _Taken("the name of a part", _text, "", needed=False),
        "other": _Taken("the name of a person", _text, "", needed=False),
        "other_segment": _Taken("the name of a segment", _text, "", needed=False),
        "at_least": _METRES,
        "name": _Taken("a name", _text, "", needed=False),
    },
    "measure": {"of": _THING, "to": _THING},
    "envelope": {
        "person": _PERSON,
        "limb": _Taken("a hand", _any_of(*HANDS)),
        "zone": _Taken("1, 2 or 3", _any_of(*ZONES), 1, needed=False),
        "obstacles": _Taken("true or false", _flag, True, needed=False),
    },
    "motion": {"case": _MOTION},
    "frames": {"case": _MOTION, "from": _FRAME, "to": _FRAME},
    "gaps": {"case": _MOTION},
    "near": {"case": _MOTION, "frame": _FRAME},
    "drop": {},
    "undo": {},
    "redo": {},
    "save": {
        "sharing": _Taken("ask, all or one", _any_of("ask", "all", "one"), "ask", needed=False),
        "over": _Taken("true or false", _flag, False, needed=False),
        "to": _Taken("the name of a file", _text, "", needed=False),
    },
    "reload": {},
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
    if not isinstance(number, int) or _flag(number) or not 0 <= number < LARGEST:
        raise InputError("n: a whole number from 0 on is needed")
    verb = message.pop("do", None)
    table = VERBS if verbs is None else verbs
    if not isinstance(verb, str) or verb not in table:
        raise InputError(f"do: nothing is called {str(verb)[:40]!r}; {one_of(str(verb), table)}")
    return Question(number, verb, _given(verb, table[verb], message))


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


def _given(verb: str, taken: Mapping[str, _Taken], message: Mapping[str, Any]) -> dict[str, Any]:
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
