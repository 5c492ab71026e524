"""Edits of a description: pure functions from one description to the next.

What was pointed at goes along when a unit, an axis or the floor changes; what was typed stays.
`edits_frame` has units, axes and the floor, `edits_seats` seats, `edits_things` controls, points and
figures that are typed, `edits_parts` parts. Here is what they share.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workbench.errors import InputError, one_of
from workbench.files.yaml_changes import Key
from workbench.study.describe.state import Description

__all__ = [
    "SECTIONS",
    "Edit",
    "check_there",
    "with_value",
    "without_value",
]

SECTIONS = {"seat": "seats", "control": "controls", "point": "points"}
"""Sections of the file by the kinds of what is in them."""


@dataclass(frozen=True, eq=False)
class Edit:
    """A description, and what is to be said about it."""

    description: Description
    words: str = ""


def check_there(before: Description, kind: str, name: str) -> None:
    """InputError where a thing is not there."""
    have = before.says.get(SECTIONS[kind]) or {}
    if name not in have:
        raise InputError(f"there is no {kind} {name!r}; {one_of(name, have)}")


def with_value(says: Any, key: Key, value: Any) -> Any:
    """What a file says, with a value at a key; mappings on the way are made."""
    if not key:
        return value
    first = key[0]
    if isinstance(first, int):
        rows = list(says)
        rows[first] = with_value(rows[first], key[1:], value)
        return rows
    inner = says.get(first) if says else None
    return {**(says or {}), first: with_value({} if inner is None else inner, key[1:], value)}


def without_value(says: Mapping[str, Any], key: Key) -> dict[str, Any]:
    """What a file says, without a value; a mapping that is empty then goes too."""
    rows = {name: value for name, value in says.items() if name != key[0]}
    if len(key) == 1:
        return rows
    inner = without_value(says[str(key[0])], key[1:])
    return (
        {name: (inner if name == key[0] else value) for name, value in says.items()}
        if inner
        else rows
    )
