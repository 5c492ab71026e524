"""Edits of the parts of a description: split, left out, put back, joined and renamed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.environment_parts import pieces
from workbench.files.names import good_name, unique_names
from workbench.files.yaml_changes import Key
from workbench.study.describe.piece_names import named_pieces
from workbench.study.describe.state import (
    Description,
    Edit,
    OpenPlace,
    standing_of,
    with_value,
    without_value,
)

__all__ = [
    "LargePart",
    "dropped",
    "joined",
    "large_part",
    "left_out",
    "put_back",
    "ruled",
    "split_part",
    "with_pieces_named",
]

MOSTLY = 0.5
"""A part of a larger share of all triangles is what is split first."""


def joined(opened: OpenPlace, before: Description, parts: Sequence[str], to: str) -> Edit:
    """Join parts to one, or give one part another name.

    Seats, controls, rules and adjustments that name a part name the new one.

    Parameters
    ----------
    parts
        Of one mesh.
    to
        The name of the whole.

    Raises
    ------
    InputError
        If a part is not there, the name is taken, or the parts are of several meshes.
    """
    stands = standing_of(opened, before)
    wanted = list(dict.fromkeys(parts))
    if not wanted:
        raise InputError("no part is chosen")
    for part in wanted:
        if part not in stands.names:
            raise InputError(f"there is no part {part!r}; {one_of(part, stands.names)}")
    new = good_name(to, "part")
    if new in stands.names and new not in wanted:
        raise InputError(f"there is a part {new!r} already; take another name")
    rows = {_mesh_of(opened, before, part) for part in wanted}
    if len(rows) > 1:
        raise InputError("parts of different meshes cannot be joined")
    row = rows.pop()
    mesh = dict(before.says["meshes"][row])
    join = dict(mesh.get("join") or {})
    members = [name for part in wanted for name in join.pop(part, [part])]
    if members != [new]:
        join[new] = members
    says = _with_mesh(before.says, row, mesh, "join", join)
    after = replace(before, says=_named(says, wanted, new), why=_why(before.why, wanted, new))
    standing_of(opened, after)
    words = f"{wanted[0]} is {new}" if len(wanted) == 1 else f"{len(wanted)} parts are {new}"
    return Edit(after, words)


def dropped(opened: OpenPlace, before: Description, parts: Sequence[str]) -> Edit:
    """Leave parts out of the environment. InputError where one is used, or nothing would be left."""
    stands = standing_of(opened, before)
    if not parts:
        raise InputError("no part is chosen")
    says = before.says
    for part in parts:
        if part not in stands.names:
            raise InputError(f"there is no part {part!r}; {one_of(part, stands.names)}")
        _unused(says, part)
        row = _mesh_of(opened, before, part)
        mesh = dict(says["meshes"][row])
        join = dict(mesh.get("join") or {})
        gone = [*(mesh.get("drop") or []), *join.pop(part, [part])]
        mesh = {key: value for key, value in mesh.items() if key != "join"}
        if join:
            mesh["join"] = join
        says = _with_mesh(says, row, mesh, "drop", gone)
        says = _forgotten(says, part)
    after = replace(before, says=says)
    standing_of(opened, after)
    after.file  # noqa: B018 (its faults)
    words = f"{parts[0]} is left out" if len(parts) == 1 else f"{len(parts)} parts are left out"
    return Edit(after, words)


def left_out(description: Description) -> list[tuple[int, str]]:
    """The parts that are left out, each with its mesh."""
    return [
        (row, name)
        for row, mesh in enumerate(description.says["meshes"])
        for name in mesh.get("drop") or []
    ]


def put_back(opened: OpenPlace, before: Description, row: int, name: str) -> Edit:
    """Put a part back that was left out. InputError where it was not."""
    if (row, name) not in left_out(before):
        raise InputError(f"no part {name!r} was left out")
    mesh = dict(before.says["meshes"][row])
    rest = [one for one in mesh["drop"] if one != name]
    after = replace(before, says=_with_mesh(before.says, row, mesh, "drop", rest))
    standing_of(opened, after)
    return Edit(after, f"{name} is there again")


def split_part(opened: OpenPlace, before: Description, part: str) -> Edit:
    """Split a part into its connected pieces, called by where they are. InputError where it is one
    piece, has another name than in the file, or is used."""
    row = _mesh_of(opened, before, part)
    found = next((one for one in opened.meshes.raws[row].parts if one.name == part), None)
    if found is None or part in (before.says["meshes"][row].get("join") or {}):
        raise InputError(f"{part!r} is no part of the mesh file as it is there; undo what made it")
    _unused(before.says, part)
    if not pieces(found).any():
        raise InputError(f"{part!r} hangs together: it is one piece")
    mesh = dict(before.says["meshes"][row])
    split = [*(mesh.get("split") or []), part]
    says = _forgotten(_with_mesh(before.says, row, mesh, "split", split), part)
    stands = standing_of(opened, replace(before, says=says))
    had = standing_of(opened, before).names
    found_pieces = [name for name in stands.names if name not in had]
    mesh = dict(says["meshes"][row])
    lead = f"{part}_" if len(had) > 1 else ""
    join = {**(mesh.get("join") or {}), **named_pieces(stands, found_pieces, lead=lead)}
    after = replace(before, says=_with_mesh(says, row, mesh, "join", join))
    standing_of(opened, after)
    words = f"{part} is {len(found_pieces)} parts, called by where they are"
    return Edit(after, words)


def with_pieces_named(
    opened: OpenPlace, before: Description, after: Description, row: int
) -> Description:
    """Return a description whose pieces of a mesh are called by where they are now, as far as they
    were called by where they were: left is right once the mesh is turned round."""
    join = after.says["meshes"][row].get("join") or {}
    split = after.says["meshes"][row].get("split") or []
    stood = standing_of(opened, before)
    stands = standing_of(opened, after)
    names = dict.fromkeys(join)
    for part in split:
        lead = f"{part}_" if any(name.startswith(f"{part}_") for name in join) else ""
        own = [new for new, some in join.items() if len(some) == 1 and _is_piece(some[0], part)]
        was = named_pieces(stood, own, lead=lead)
        now = {old: new for new, (old,) in named_pieces(stands, own, lead=lead).items()}
        names |= {old: now[old] for new, (old,) in was.items() if _plain(new) == _plain(old)}
    changed = {old: new for old, new in names.items() if new and new != old}
    if not changed:
        return after
    kept = {*stands.names} - {*changed}
    new_names = unique_names([*kept, *changed.values()], "piece")[len(kept) :]
    called = dict(zip(changed, new_names, strict=True))
    mesh = dict(after.says["meshes"][row])
    moved = {called.get(name, name): some for name, some in join.items()}
    says = _with_mesh(after.says, row, mesh, "join", moved)
    for number, old in enumerate(called):  # two names may be exchanged: by way of others
        says = _named(says, [old], f"\0{number}")
    for number, new in enumerate(called.values()):
        says = _named(says, [f"\0{number}"], new)
    why = {
        ("parts", called.get(str(key[1]), key[1]), *key[2:]) if key[:1] == ("parts",) else key: one
        for key, one in after.why.items()
    }
    return replace(after, says=says, why=why)


def _plain(name: str) -> str:
    """A name without the number behind it."""
    return name.rstrip("0123456789").rstrip("_")


def _is_piece(name: str, part: str) -> bool:
    """Whether a name is that of a piece that a part was split into."""
    return name.startswith(f"{part}_") and name[len(part) + 1 :].isdigit()


@dataclass(frozen=True)
class LargePart:
    """A part that most of the triangles are of: its share of them, and its connected pieces."""

    name: str
    share: float
    pieces: int


def large_part(opened: OpenPlace, description: Description) -> LargePart | None:
    """Return the part that most of the triangles are of and that falls into pieces, None where there
    is none."""
    stands = standing_of(opened, description)
    meshes = opened.meshes
    kept = stands.part >= 0
    count = np.bincount(stands.part[kept], minlength=len(stands.names))
    most = int(count.argmax())
    name = stands.names[most]
    share = float(count[most] / count.sum())
    row = _mesh_of(opened, description, name)
    if share < MOSTLY or not any(part.name == name for part in meshes.raws[row].parts):
        return None
    if name in (description.says["meshes"][row].get("join") or {}):
        return None
    found = meshes.piece_count(int(meshes.owner[int((stands.part == most).argmax())]))
    return LargePart(name, share, found) if found > 1 else None


def ruled(opened: OpenPlace, before: Description, part: str, rule: str, value: bool | str) -> Edit:
    """Say of a part whether it is hidden, see-through or solid.

    Parameters
    ----------
    rule, value
        hidden or see_through, true or false; solid: auto, true or false.
    """
    names = standing_of(opened, before).names
    if part not in names:
        raise InputError(f"there is no part {part!r}; {one_of(part, names)}")
    own = dict((before.says.get("parts") or {}).get(part) or {})
    own.pop(rule, None)
    if value is not False or rule == "solid":
        own[rule] = value
    if own.get("solid") == "auto":
        del own["solid"]
    key: Key = ("parts", part)
    says = with_value(before.says, key, own) if own else without_value(before.says, key)
    after = replace(before, says=says)
    after.file  # noqa: B018 (faults of what was given)
    return Edit(after)


def _mesh_of(opened: OpenPlace, before: Description, part: str) -> int:
    """The mesh that a part is of."""
    stands = standing_of(opened, before)
    if part not in stands.names:
        raise InputError(f"there is no part {part!r}; {one_of(part, stands.names)}")
    face = int((stands.part == stands.names.index(part)).argmax())
    return int(opened.meshes.mesh[face])


def _with_mesh(
    says: Mapping[str, Any], row: int, mesh: dict[str, Any], key: str, value: Any
) -> dict[str, Any]:
    """What a file says, with another value at a key of a mesh, none where it is empty."""
    changed = {name: one for name, one in mesh.items() if name != key}
    if value:
        changed = {**mesh, key: value}
    rows = [changed if k == row else one for k, one in enumerate(says["meshes"])]
    return {**says, "meshes": rows}


def _unused(says: Mapping[str, Any], part: str) -> None:
    """InputError where a seat, a control, an adjustment, an instrument or a mirror names a part."""
    for name, seat in (says.get("seats") or {}).items():
        for surface in ("cushion", "back"):
            if seat[surface]["part"] == part:
                raise InputError(
                    f"{part!r} is the {surface} of seat {name!r}: remove the seat first"
                )
    for name, control in (says.get("controls") or {}).items():
        if part in _listed(control.get("part")):
            raise InputError(
                f"control {name!r} is on {part!r}: remove it, or put it elsewhere first"
            )
    for name, one in (says.get("adjustments") or {}).items():
        if part in one.get("parts", ()):
            raise InputError(f"adjustment {name!r} moves {part!r}: change it in the file first")
    for kind in ("instrument", "mirror"):
        for name, one in (says.get(f"{kind}s") or {}).items():
            if one.get("part") == part:
                raise InputError(f"{kind} {name!r} is {part!r}: change it in the file first")


def _listed(given: str | list[str] | None) -> Sequence[str]:
    """What a control says of its parts, as a list."""
    return [given] if isinstance(given, str) else given or []


def _forgotten(says: Mapping[str, Any], part: str) -> dict[str, Any]:
    """What a file says, without the rule of a part and without it in what seats move."""
    found = dict(says)
    rules = {name: rule for name, rule in (says.get("parts") or {}).items() if name != part}
    if "parts" in found and part in (says.get("parts") or {}):
        if rules:
            found["parts"] = rules
        else:
            del found["parts"]
    seats = {}
    for name, seat in (says.get("seats") or {}).items():
        moves = [one for one in seat.get("moves") or [] if one != part]
        same = moves == (seat.get("moves") or [])
        seats[name] = seat if same else {**seat, "moves": moves}
    if seats:
        found["seats"] = seats
    return found


def _named(says: Mapping[str, Any], parts: Sequence[str], new: str) -> dict[str, Any]:
    """What a file says, with a new name in the place of some parts'."""

    def name(part: str) -> str:
        return new if part in parts else part

    def names(rows: Sequence[str]) -> list[str]:
        return list(dict.fromkeys(name(part) for part in rows))

    found = dict(says)
    if says.get("parts"):
        rules: dict[str, Any] = {}
        for part, rule in says["parts"].items():
            rules.setdefault(name(part), rule)
        found["parts"] = rules
    if says.get("seats"):
        found["seats"] = {
            key: _seat_named(seat, name, names) for key, seat in says["seats"].items()
        }
    if says.get("controls"):
        found["controls"] = {
            key: _control_named(one, name, names) for key, one in says["controls"].items()
        }
    if says.get("adjustments"):
        found["adjustments"] = {
            key: {**one, "parts": names(one["parts"])} if one.get("parts") else one
            for key, one in says["adjustments"].items()
        }
    for section in ("instruments", "mirrors"):
        if says.get(section):
            found[section] = {
                key: _control_named(one, name, names) for key, one in says[section].items()
            }
    return found


def _seat_named(seat: Mapping[str, Any], name: Any, names: Any) -> dict[str, Any]:
    """A seat with new names of its parts."""
    found = dict(seat)
    for surface in ("cushion", "back"):
        found[surface] = {**seat[surface], "part": name(seat[surface]["part"])}
    if seat.get("moves"):
        found["moves"] = names(seat["moves"])
    return found


def _control_named(control: Mapping[str, Any], name: Any, names: Any) -> dict[str, Any]:
    """A control, an instrument or a mirror with new names of its parts."""
    own = control.get("part")
    if not own:
        return dict(control)
    return {**control, "part": name(own) if isinstance(own, str) else names(own)}


def _why(why: Mapping[Key, str], parts: Sequence[str], new: str) -> dict[Key, str]:
    """The reasons, those of the rules of parts under their new name."""
    return {
        ("parts", new, *key[2:]) if key[:1] == ("parts",) and key[1] in parts else key: words
        for key, words in why.items()
    }
