"""Changes of a study spliced into its own text: whatever is not changed keeps its bytes.

A text is changed one value at a time, at the marks of the YAML parser. A value that is shared by an
anchor is changed for all who share it or for one place alone; whoever saves says which.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from workbench.errors import InputError
from workbench.files.schema import metres_in
from workbench.files.yaml_marks import Item, Node, marked, walked
from workbench.model.moves import Move

__all__ = [
    "AxisAngle",
    "Change",
    "JointChange",
    "MovedChange",
    "PostureChange",
    "SeatChange",
    "SharedValueError",
    "Sharing",
    "spliced",
]

Sharing = Literal["ask", "all", "one"]
"""What becomes of a value that several places share: it is asked about, changed in all of them, or
in one alone."""
Key = tuple[str | int, ...]
BOM = "\ufeff"
MOST_SHARED = 20
"""Anchors within anchors that are resolved for one change."""


class SharedValueError(InputError):
    """A value that is to be changed is shared with other places, and nobody said what becomes of
    these."""


@dataclass(frozen=True)
class AxisAngle:
    """An angle [degrees] about one axis of a joint, by its two motions: positive in the first."""

    motions: tuple[str, str]
    degrees: float

    @property
    def motion(self) -> str:
        """The motion that the angle is one of."""
        return self.motions[int(self.degrees < 0)]

    @property
    def text(self) -> str:
        """The angle as it stands in a file."""
        return f"{abs(round(self.degrees, 1)):g}"


@dataclass(frozen=True)
class JointChange:
    """Angles of a joint of one role in a case, by the number of the case in the file."""

    case: int
    role: str
    joint: str
    angles: tuple[AxisAngle, ...]


@dataclass(frozen=True)
class PostureChange:
    """A posture with angles in the place of what a role does in a case."""

    case: int
    role: str
    posture: str
    angles: Mapping[str, tuple[AxisAngle, ...]]


@dataclass(frozen=True)
class SeatChange:
    """The position [m] of the seat of a role."""

    role: str
    forward: float
    up: float


@dataclass(frozen=True)
class MovedChange:
    """What is moved of the environment: the moves as the text has them, and as they are to be."""

    before: tuple[Move, ...]
    after: tuple[Move, ...]


Change = JointChange | MovedChange | PostureChange | SeatChange


@dataclass(frozen=True)
class _Found:
    """The node at a key, and the nodes on the way to it that other places share."""

    node: Node | None
    shared: tuple[Node, ...]


def spliced(text: str, changes: Sequence[Change], *, sharing: Sharing = "ask") -> str:
    """Change some values in the text of a study.

    Parameters
    ----------
    text
        Of the file, with its byte order mark and its line ends as they are.
    changes
        One after the other.
    sharing
        What becomes of values that an anchor shares.

    Raises
    ------
    SharedValueError
        If a value is shared and `sharing` is "ask".
    InputError
        If the text does not have what is to be changed.
    """
    mark = BOM if text.startswith(BOM) else ""
    body = text[len(mark) :]
    for change in changes:
        if isinstance(change, JointChange):
            key: Key = ("cases", change.case, "people", change.role)
            body = _set_joint(_own(body, (*key, "angles"), sharing), key, change, sharing)
        elif isinstance(change, PostureChange):
            key = ("cases", change.case, "people", change.role)
            body = _set_posture(_own(body, key, sharing), key, change)
        elif isinstance(change, MovedChange):
            body = _set_moved(_own(body, ("moved",), sharing), change, sharing)
        else:
            key = ("people", change.role)
            body = _set_seat(_own(body, (*key, "position"), sharing), key, change)
    return mark + body


def _own(text: str, key: Key, sharing: Sharing) -> str:
    """The text with nothing shared on the way to a key, where one place alone is to change."""
    for _ in range(MOST_SHARED):
        shared = _at(text, key).shared
        if not shared or sharing == "all":
            return text
        if sharing == "ask":
            raise SharedValueError(_shared_words(text, key, shared[0]))
        text = _unshared(text, shared[0])
    raise InputError(f"{_name(key)}: anchors within anchors too deep to change one place alone")


def _shared_words(text: str, key: Key, node: Node) -> str:
    """That a value is shared, and where its anchor is."""
    every = [one for one in walked(marked(text)) if one.anchor == node.anchor]
    line = text.count("\n", 0, every[0].start) + 1
    return (
        f"{_name(key)} is shared by {len(every)} places (&{node.anchor} in line {line}): "
        "change all of them, or this one only?"
    )


def _name(key: Key) -> str:
    return " ".join(str(part + 1) if isinstance(part, int) else part for part in key)


def _at(text: str, key: Key) -> _Found:
    """The node at a key; aliases on the way are followed, and the shared nodes noted."""
    root = marked(text)
    anchors: dict[str, Node] = {}
    uses: dict[str, int] = {}
    for node in walked(root):
        if node.anchor:
            uses[node.anchor] = uses.get(node.anchor, 0) + 1
        if node.anchor and node.kind != "alias":
            anchors[node.anchor] = node
    shared: list[Node] = []
    here: Node | None = root
    for part in (None, *key):
        if part is not None and here is not None:
            here = _child(here, part)
        if here is None:
            break
        if here.anchor and uses[here.anchor] > 1:
            shared.append(here)
        if here.kind == "alias":
            here = anchors[here.anchor]
    return _Found(here, tuple(shared))


def _child(node: Node, part: str | int) -> Node | None:
    """The value of a mapping at a key, or of a sequence at a number."""
    if isinstance(part, int):
        rows = node.items if node.kind == "sequence" else []
        return rows[part].value if part < len(rows) else None
    item = node.item(part) if node.kind == "mapping" else None
    return None if item is None else item.value


def _unshared(text: str, node: Node) -> str:
    """The text with one place of a shared value written out; the anchor goes to the next place."""
    every = [one for one in walked(marked(text)) if one.anchor == node.anchor]
    anchored = next(one for one in every if one.kind != "alias")
    plain = _flow(text, anchored)
    if node.kind == "alias":
        return text[: node.start] + plain + text[node.end :]
    after = next(one for one in every if one.start > anchored.start)
    first = anchored.start
    begin = first + len(f"&{node.anchor}")
    while text[begin].isspace() and anchored.flow | (anchored.kind == "scalar"):
        begin += 1
    moved = f"&{node.anchor} {plain}"
    return text[:first] + text[begin : after.start] + moved + text[after.end :]


def _flow(text: str, node: Node) -> str:
    """A value in flow style, without anchors of its own."""
    if node.kind == "alias":
        return f"*{node.anchor}"
    if node.kind == "mapping":
        rows = [
            f"{_flow(text, item.key)}: {_flow(text, item.value)}"
            for item in node.items
            if item.key is not None
        ]
        return "{" + ", ".join(rows) + "}"
    if node.kind == "sequence":
        return "[" + ", ".join(_flow(text, item.value) for item in node.items) + "]"
    raw = text[node.start : node.end].strip()
    if node.anchor:
        raw = raw.removeprefix(f"&{node.anchor}").strip()
    quoted = raw[:1] in ("'", '"')
    safe = quoted or (not set(raw) & set(",[]{}\n#") and raw[:1] not in ("|", ">"))
    return raw if safe and raw else json.dumps(node.text, ensure_ascii=False)


def _set_joint(text: str, key: Key, change: JointChange, sharing: Sharing) -> str:
    """The text with angles of one joint of a posture."""
    found = _at(text, (*key, "angles")).node
    if found is None:
        action = _mapping(text, key)
        return _with_entry(text, action, "angles", f"{{{change.joint}: {_angles(change.angles)}}}")
    angles = _mapping(text, (*key, "angles"))
    named = [item for item in angles.items if change.joint in _joints(item.name)]
    if not named:
        return _with_entry(text, angles, change.joint, _angles(change.angles))
    last = named[-1]
    text = _own(text, (*key, "angles", last.name), sharing)
    if len(_joints(last.name)) == 1:
        return _set_axes(text, (*key, "angles", last.name), change.angles)
    return _split(text, key, last.name, change)


def _joints(key: str) -> list[str]:
    """The joints that a key of angles names."""
    return key.replace(",", " ").split()


def _mapping(text: str, key: Key) -> Node:
    """The mapping at a key."""
    node = _at(text, key).node
    if node is None or node.kind != "mapping":
        raise InputError(f"{_name(key)}: no mapping stands there to be changed")
    return node


def _set_axes(text: str, key: Key, angles: Sequence[AxisAngle]) -> str:
    """The text with some angles in the mapping of one joint."""
    for angle in angles:
        motions = _mapping(text, key)
        items = [item for item in motions.items if item.name in angle.motions]
        if not items:
            text = _with_entry(text, motions, angle.motion, angle.text)
            continue
        last = items[-1]
        assert last.key is not None
        text = _exchanged(text, last.value, angle.text)
        if last.name != angle.motion:
            text = _exchanged(text, last.key, angle.motion)
    return text


def _split(text: str, key: Key, name: str, change: JointChange) -> str:
    """The text with a joint taken out of a key that names several, in an entry of its own."""
    angles = _mapping(text, (*key, "angles"))
    item = angles.item(name)
    assert item is not None and item.key is not None
    motions = _mapping(text, (*key, "angles", name))
    kept = [
        f"{row.name}: {_flow(text, row.value)}"
        for row in motions.items
        if not any(row.name in angle.motions for angle in change.angles)
    ]
    kept += [f"{angle.motion}: {angle.text}" for angle in change.angles]
    others = " ".join(joint for joint in _joints(name) if joint != change.joint)
    own = angles.item(change.joint)
    if own is not None:  # an entry of its own before, which this one replaced
        text = _exchanged(text, own.value, "{" + ", ".join(kept) + "}")
        later = _mapping(text, (*key, "angles")).item(name)
        assert later is not None and later.key is not None
        return _exchanged(text, later.key, others)
    text = _with_entry(text, angles, change.joint, "{" + ", ".join(kept) + "}", after=item)
    return _exchanged(text, item.key, others)


def _set_posture(text: str, key: Key, change: PostureChange) -> str:
    """The text with a posture where something else was done."""
    action = _mapping(text, key)
    rows = ", ".join(f"{joint}: {_angles(angles)}" for joint, angles in change.angles.items())
    entries = {"posture": _plain(change.posture)}
    if rows:
        entries["angles"] = f"{{{rows}}}"
    first = action.items[0].key
    assert first is not None
    join = ", " if action.flow else _new_line(text) + " " * _column(text, first.start)
    words = join.join(f"{name}: {value}" for name, value in entries.items())
    return text[: first.start] + words + text[action.items[-1].value.end :]


def _set_seat(text: str, key: Key, change: SeatChange) -> str:
    """The text with the position of a seat."""
    scale = _unit(text)
    values = {way: _length(getattr(change, way) / scale) for way in ("forward", "up")}
    whole = f"{{forward: {values['forward']}, up: {values['up']}}}"
    place = _at(text, (*key, "position")).node
    if place is None:
        return _with_entry(text, _mapping(text, key), "position", whole)
    if place.kind != "mapping":
        return _exchanged(text, place, whole)
    for way, value in values.items():
        position = _mapping(text, (*key, "position"))
        item = position.item(way)
        if item is not None:
            text = _exchanged(text, item.value, value)
        else:
            text = _with_entry(text, position, way, value)
    return text


def _set_moved(text: str, change: MovedChange, sharing: Sharing) -> str:
    """The text with other moves: entries that move the same as before get another displacement,
    new ones follow, and only where one has gone or is of other parts is the list written anew."""
    node = _at(text, ("moved",)).node
    scale = _unit(text)
    rows = [_move_text(move, scale) for move in change.after]
    same = [(move.parts, move.controls) for move in change.before]
    listed = node is not None and node.kind == "sequence" and len(node.items) == len(same) > 0
    if not listed or [(m.parts, m.controls) for m in change.after[: len(same)]] != same:
        whole = "[" + ", ".join(rows) + "]"
        if node is not None:
            return _exchanged(text, node, whole)
        return _with_entry(
            text, marked(text), "moved", whole, after=marked(text).item("environment")
        )
    for row, (old, new) in enumerate(zip(change.before, change.after, strict=False)):
        if old.by != new.by:
            key = ("moved", row, "by")
            text = _own(text, key, sharing)
            place = _at(text, key).node
            assert place is not None
            text = _exchanged(text, place, _vector_text(new.by, scale))
    for entry in rows[len(same) :]:
        text = _with_row(text, _at(text, ("moved",)).node, entry)
    return text


def _unit(text: str) -> float:
    """The unit of length of a study [m]."""
    unit = _at(text, ("length",)).node
    return metres_in[unit.text] if unit is not None else 1.0


def _move_text(move: Move, scale: float) -> str:
    """A move as it stands in a file."""
    kind, names = ("parts", move.parts) if move.parts else ("controls", move.controls)
    return f"{{{kind}: [{', '.join(map(_plain, names))}], by: {_vector_text(move.by, scale)}}}"


def _vector_text(values: Sequence[float], scale: float) -> str:
    return "[" + ", ".join(_length(value / scale) for value in values) + "]"


def _with_row(text: str, sequence: Node | None, row: str) -> str:
    """The text with one entry more at the end of a sequence that has some, in its own style."""
    assert sequence is not None and sequence.items
    last = sequence.items[-1].value
    if sequence.flow:
        return f"{text[: last.end]}, {row}{text[last.end :]}"
    dash = text.rfind("-", 0, sequence.items[0].value.start)
    line = text.find("\n", last.end)
    line = len(text) if line < 0 else line
    if text[line - 1 : line] == "\r":
        line -= 1
    return f"{text[:line]}{_new_line(text)}{' ' * _column(text, dash)}- {row}{text[line:]}"


def _length(value: float) -> str:
    """A length as it stands in a file: to 1e-7 of the unit, without zeros at its end."""
    return f"{round(value, 7) + 0.0:.10g}"


def _angles(angles: Sequence[AxisAngle]) -> str:
    return "{" + ", ".join(f"{angle.motion}: {angle.text}" for angle in angles) + "}"


def _plain(name: str) -> str:
    """A name as it may stand in flow style."""
    safe = name.replace("_", "").isalnum() and not name[0].isdigit()
    return name if safe else json.dumps(name, ensure_ascii=False)


def _exchanged(text: str, node: Node, value: str) -> str:
    """The text with another value in the place of a node; its anchor stays."""
    anchor = f"&{node.anchor} " if node.anchor and node.kind != "alias" else ""
    return text[: node.start] + anchor + value + text[node.end :]


def _with_entry(text: str, mapping: Node, key: str, value: str, after: Item | None = None) -> str:
    """The text with one entry more in a mapping, behind one of its entries or the last, in the
    mapping's own style."""
    if not mapping.items:
        brace = text.index("{", mapping.start)
        return f"{text[: brace + 1]}{key}: {value}{text[brace + 1 :]}"
    item = after or mapping.items[-1]
    end = item.value.end
    if mapping.flow:
        return f"{text[:end]}, {key}: {value}{text[end:]}"
    first = mapping.items[0].key
    assert first is not None
    line = text.find("\n", end)
    line = len(text) if line < 0 else line
    if text[line - 1 : line] == "\r":
        line -= 1
    entry = f"{_new_line(text)}{' ' * _column(text, first.start)}{key}: {value}"
    return text[:line] + entry + text[line:]


def _column(text: str, at: int) -> int:
    """How many characters stand before one in its line."""
    return at - (text.rfind("\n", 0, at) + 1)


def _new_line(text: str) -> str:
    """How the lines of a text end."""
    return "\r\n" if "\r\n" in text else "\n"
