"""What each verb of describing does to a description: the edits, in a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from workbench.errors import InputError
from workbench.model.figures import plain
from workbench.study.describe.edits_files import met_file, moved_file, removed_file
from workbench.study.describe.edits_frame import agreed, floored, framed, scaled
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
from workbench.study.describe.meshes import Ray
from workbench.study.describe.people import PERSON, seated_eye
from workbench.study.describe.state import Description, Edit, OpenPlace

__all__ = ["DESCRIBE_EDITS"]

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


def _long(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return scaled(opened, before, int(given["row"]), given["size"])


def _move(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return moved_file(opened, before, int(given["row"]), given["to"])


def _meet(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return met_file(opened, before, _ray(given), _ray(given, "to_"))


def _take(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return removed_file(opened, before, int(given["row"]))


def _accept(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return accepted(before, given["about"])


def _agree(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return agreed(before)


def _floor(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return floored(opened, before, _ray(given))


def _face(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return faced(opened, before, given["seat"], given["surface"], _ray(given))


def _anew(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return faced(opened, before, given["seat"], given["surface"], None)


def _carry(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return carried(opened, before, given["seat"], given["parts"])


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


def _figure(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return typed(opened, before, given["kind"], given["name"], given["figure"], given["value"])


def _rename(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return renamed(before, given["kind"], given["name"], given["to"])


def _remove(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return removed(before, given["kind"], given["name"])


def _own(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return owned(opened, before, given["control"], given["parts"])


def _join(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return joined(opened, before, given["parts"], given["to"])


def _leave(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return dropped(opened, before, given["parts"])


def _back(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return put_back(opened, before, int(given["row"]), given["name"])


def _split(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return split_part(opened, before, given["part"])


def _rule(opened: OpenPlace, before: Description, given: Given) -> Edit:
    return ruled(opened, before, given["part"], given["rule"], given["value"])


DESCRIBE_EDITS: Mapping[str, DescribeEdit] = {
    "mesh": _mesh,
    "long": _long,
    "move": _move,
    "meet": _meet,
    "take": _take,
    "accept": _accept,
    "agree": _agree,
    "floor": _floor,
    "face": _face,
    "anew": _anew,
    "carry": _carry,
    "place": _place,
    "eye": _eye,
    "figure": _figure,
    "rename": _rename,
    "remove": _remove,
    "own": _own,
    "join": _join,
    "leave": _leave,
    "back": _back,
    "split": _split,
    "rule": _rule,
}
"""The verbs that change a description: from an open environment, its description and what the verb
takes, to the description after it."""
