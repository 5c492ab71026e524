"""What the page may ask that describes an environment."""

from __future__ import annotations

from typing import Any

from workbench.files.environment_parts import MOST_PIECES
from workbench.live.protocol import (
    VerbArgument,
    Verbs,
    is_flag,
    is_number,
    is_point,
    is_text,
    is_texts,
    one_valid,
)
from workbench.study.describe.edits_files import AXES

__all__ = ["DESCRIBE_VERBS", "GRIPS", "UNITS", "ZONES"]

UNITS = ("m", "mm", "cm", "in", "ft")
GRIPS = ("push", "pinch", "grasp", "foot")
ZONES = (1, 2, 3)
_KIND = VerbArgument("seat, control or point", one_valid("seat", "control", "point"))
_NAME = VerbArgument("a name", is_text)
_RAY = {
    "part": VerbArgument("the name of a part", is_text, needed=False),
    "start": VerbArgument("three numbers of metres", is_point, needed=False),
    "way": VerbArgument("three numbers", is_point, needed=False),
    "far": VerbArgument("a number of metres", is_number, 0.0, needed=False),
}
"""Where the picture was clicked; nothing of it where it was not on a part."""


def _is_value(value: Any) -> bool:
    """Whether a value is one that can be typed: a number, a text, or some numbers."""
    numbers = isinstance(value, list) and len(value) in (2, 3) and all(map(is_number, value))
    return is_number(value) or (isinstance(value, str) and len(value) <= MOST_PIECES) or numbers


_ROW = VerbArgument(
    "the number of a mesh from 0", lambda value: is_number(value) and value % 1 == 0
)
DESCRIBE_VERBS: Verbs = {
    "mesh": {
        "row": _ROW,
        "length": VerbArgument("a unit of length", is_text, needed=False),
        "up": VerbArgument("an axis", one_valid(*AXES), needed=False),
        "forward": VerbArgument("an axis", one_valid(*AXES), needed=False),
    },
    "long": {"row": _ROW, "size": VerbArgument("a number of metres", is_number)},
    "agree": {},
    "accept": {"about": VerbArgument("what is doubted", is_text)},
    "add": {"file": VerbArgument("the name of a mesh file", is_text)},
    "take": {"row": _ROW},
    "move": {"row": _ROW, "to": VerbArgument("three numbers of metres", is_point)},
    "meet": {**_RAY, **{f"to_{key}": taken for key, taken in _RAY.items()}},
    "floor": _RAY,
    "face": {
        "seat": _NAME,
        "surface": VerbArgument("cushion or back", one_valid("cushion", "back")),
        **_RAY,
    },
    "anew": {
        "seat": _NAME,
        "surface": VerbArgument("cushion or back", one_valid("cushion", "back")),
    },
    "carry": {"seat": _NAME, "parts": VerbArgument("a list of names of parts", is_texts)},
    "place": {
        "kind": VerbArgument("control or point", one_valid("control", "point")),
        "name": VerbArgument("a name", is_text, "", needed=False),
        "grip": VerbArgument("a grip", one_valid(*GRIPS), "grasp", needed=False),
        "zone": VerbArgument("1, 2 or 3", one_valid(*ZONES), 1, needed=False),
        **_RAY,
    },
    "eye": {"seat": _NAME},
    "figure": {
        "kind": _KIND,
        "name": _NAME,
        "figure": VerbArgument("the name of a figure", is_text),
        "value": VerbArgument("a number, a text, or two or three numbers", _is_value),
    },
    "rename": {"kind": _KIND, "name": _NAME, "to": _NAME},
    "remove": {"kind": _KIND, "name": _NAME},
    "own": {
        "control": _NAME,
        "parts": VerbArgument(
            "a list of names of parts", lambda value: value == [] or is_texts(value)
        ),
    },
    "join": {"parts": VerbArgument("a list of names of parts", is_texts), "to": _NAME},
    "leave": {"parts": VerbArgument("a list of names of parts", is_texts)},
    "back": {"row": _ROW, "name": _NAME},
    "split": {"part": _NAME},
    "rule": {
        "part": _NAME,
        "rule": VerbArgument(
            "hidden, see_through or solid", one_valid("hidden", "see_through", "solid")
        ),
        "value": VerbArgument(
            "true, false or auto", lambda value: is_flag(value) or value == "auto"
        ),
    },
    "sit": {"on": VerbArgument("true or false", is_flag)},
    "undo": {},
    "redo": {},
    "save": {
        "over": VerbArgument("true or false", is_flag, False, needed=False),
        "to": VerbArgument("the name of a file", is_text, "", needed=False),
    },
    "study": {"anew": VerbArgument("true or false", is_flag, False, needed=False)},
    "reload": {},
}
"""What a page may ask, and what each verb takes."""
