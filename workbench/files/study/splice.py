"""Changes of a study spliced into its own text: whatever is not changed keeps its bytes.

A text is changed one value at a time, at the marks of the YAML parser. A value that is shared by an
anchor is changed for all who share it or for one place alone; whoever saves says which.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from workbench.files.schema import metres_in
from workbench.files.yaml_marks import Node, marked
from workbench.files.yaml_splice import Key, SharedValueError, Sharing
from workbench.files.yaml_splice import at as _at
from workbench.files.yaml_splice import column as _column
from workbench.files.yaml_splice import exchanged as _exchanged
from workbench.files.yaml_splice import flow as _flow
from workbench.files.yaml_splice import mapping as _mapping
from workbench.files.yaml_splice import new_line as _new_line
from workbench.files.yaml_splice import own as _own
from workbench.files.yaml_splice import plain as _plain
from workbench.files.yaml_splice import with_entry as _with_entry
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

BOM = "\ufeff"


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
