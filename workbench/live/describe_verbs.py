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
