"""Changes of a study spliced into its own text: whatever is not changed keeps its bytes.

Here are joints, seats and what is moved; `splice_people` has what concerns persons.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from workbench.files.study.splice_people import (
    AdjustChange,
    ClothesChange,
    HoldChange,
    PredictionChange,
    SizeChange,
    ZoneChange,
    set_adjustment,
    set_clothes,
    set_hold,
    set_prediction,
    set_size,
    set_zone,
)
from workbench.files.yaml_edits import (
    Key,
    Sharing,
    column_of,
    exchanged,
    flow_text,
    length_text,
    mapping_at,
    new_line,
    node_at,
    own_copy,
    plain_name,
    unit_of,
    with_entry,
    with_row,
)
from workbench.files.yaml_marks import marked
from workbench.model.criterion import Criterion
from workbench.model.moves import Move

__all__ = [
    "AxisAngle",
    "Change",
    "CriteriaChange",
    "JointChange",
    "MovedChange",
    "PostureChange",
    "SeatChange",
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
    """The position [m] of the seat of a role, or that it is free."""

    role: str
    forward: float
    up: float
    free: bool = False


@dataclass(frozen=True)
class MovedChange:
    """What is moved of the environment: the moves as the text has them, and as they are to be."""

    before: tuple[Move, ...]
    after: tuple[Move, ...]


@dataclass(frozen=True)
class CriteriaChange:
    """Criteria about the distance of a pair that follow those of the text."""

    added: tuple[Criterion, ...]


Change = (
    AdjustChange
    | ClothesChange
    | CriteriaChange
    | HoldChange
    | JointChange
    | MovedChange
    | PostureChange
    | PredictionChange
    | SeatChange
    | SizeChange
    | ZoneChange
)


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
        body = _SPLICES[type(change)](body, change, sharing)
    return mark + body


def _set_joint(text: str, change: JointChange, sharing: Sharing) -> str:
    """The text with angles of one joint of a posture."""
    key: Key = ("cases", change.case, "people", change.role)
    text = own_copy(text, (*key, "angles"), sharing)
    found = node_at(text, (*key, "angles")).node
    if found is None:
        action = mapping_at(text, key)
        return with_entry(text, action, "angles", f"{{{change.joint}: {_angles(change.angles)}}}")
    angles = mapping_at(text, (*key, "angles"))
    named = [item for item in angles.items if change.joint in _joints(item.name)]
    if not named:
        return with_entry(text, angles, change.joint, _angles(change.angles))
    last = named[-1]
    text = own_copy(text, (*key, "angles", last.name), sharing)
    if len(_joints(last.name)) == 1:
        return _set_axes(text, (*key, "angles", last.name), change.angles)
    return _split(text, key, last.name, change)


def _joints(key: str) -> list[str]:
    """The joints that a key of angles names."""
    return key.replace(",", " ").split()


def _set_axes(text: str, key: Key, angles: Sequence[AxisAngle]) -> str:
    """The text with some angles in the mapping of one joint."""
    for angle in angles:
        motions = mapping_at(text, key)
        items = [item for item in motions.items if item.name in angle.motions]
        if not items:
            text = with_entry(text, motions, angle.motion, angle.text)
            continue
        last = items[-1]
        assert last.key is not None
        text = exchanged(text, last.value, angle.text)
        if last.name != angle.motion:
            text = exchanged(text, last.key, angle.motion)
    return text


def _split(text: str, key: Key, name: str, change: JointChange) -> str:
    """The text with a joint taken out of a key that names several, in an entry of its own."""
    angles = mapping_at(text, (*key, "angles"))
    item = angles.item(name)
    assert item is not None and item.key is not None
    motions = mapping_at(text, (*key, "angles", name))
    kept = [
        f"{row.name}: {flow_text(text, row.value)}"
        for row in motions.items
        if not any(row.name in angle.motions for angle in change.angles)
    ]
    kept += [f"{angle.motion}: {angle.text}" for angle in change.angles]
    others = " ".join(joint for joint in _joints(name) if joint != change.joint)
    own = angles.item(change.joint)
    if own is not None:  # an entry of its own before, which this one replaced
        text = exchanged(text, own.value, "{" + ", ".join(kept) + "}")
        later = mapping_at(text, (*key, "angles")).item(name)
        assert later is not None and later.key is not None
        return exchanged(text, later.key, others)
    text = with_entry(text, angles, change.joint, "{" + ", ".join(kept) + "}", after=item)
    return exchanged(text, item.key, others)


def _set_posture(text: str, change: PostureChange, sharing: Sharing) -> str:
    """The text with a posture where something else was done."""
    key: Key = ("cases", change.case, "people", change.role)
    text = own_copy(text, key, sharing)
    action = mapping_at(text, key)
    rows = ", ".join(f"{joint}: {_angles(angles)}" for joint, angles in change.angles.items())
    entries = {"posture": plain_name(change.posture)}
    if rows:
        entries["angles"] = f"{{{rows}}}"
    first = action.items[0].key
    assert first is not None
    join = ", " if action.flow else new_line(text) + " " * column_of(text, first.start)
    words = join.join(f"{name}: {value}" for name, value in entries.items())
    return text[: first.start] + words + text[action.items[-1].value.end :]


def _set_seat(text: str, change: SeatChange, sharing: Sharing) -> str:
    """The text with the position of a seat."""
    key: Key = ("people", change.role)
    text = own_copy(text, (*key, "position"), sharing)
    scale = unit_of(text)
    values = {way: length_text(getattr(change, way) / scale) for way in ("forward", "up")}
    whole = f"{{forward: {values['forward']}, up: {values['up']}}}"
    if change.free:
        whole = "free"
    place = node_at(text, (*key, "position")).node
    if place is None:
        return with_entry(text, mapping_at(text, key), "position", whole)
    if place.text == "reference" and not (change.free or change.forward or change.up):
        return text
    if place.kind != "mapping" or change.free:
        return exchanged(text, place, whole)
    for way, value in values.items():
        position = mapping_at(text, (*key, "position"))
        item = position.item(way)
        if item is not None:
            text = exchanged(text, item.value, value)
        else:
            text = with_entry(text, position, way, value)
    return text


def _set_moved(text: str, change: MovedChange, sharing: Sharing) -> str:
    """The text with other moves: entries that move the same as before get another displacement,
    new ones follow, and only where one has gone or is of other parts is the list written anew."""
    text = own_copy(text, ("moved",), sharing)
    node = node_at(text, ("moved",)).node
    scale = unit_of(text)
    rows = [_move_text(move, scale) for move in change.after]
    same = [(move.parts, move.controls) for move in change.before]
    listed = node is not None and node.kind == "sequence" and len(node.items) == len(same) > 0
    if not listed or [(m.parts, m.controls) for m in change.after[: len(same)]] != same:
        whole = "[" + ", ".join(rows) + "]"
        if node is not None:
            return exchanged(text, node, whole)
        return with_entry(
            text, marked(text), "moved", whole, after=marked(text).item("environment")
        )
    for row, (old, new) in enumerate(zip(change.before, change.after, strict=False)):
        if old.by != new.by:
            key = ("moved", row, "by")
            text = own_copy(text, key, sharing)
            place = node_at(text, key).node
            assert place is not None
            text = exchanged(text, place, _vector_text(new.by, scale))
    for entry in rows[len(same) :]:
        text = with_row(text, node_at(text, ("moved",)).node, entry)
    return text


def _add_criteria(text: str, change: CriteriaChange, sharing: Sharing) -> str:
    """The text with more criteria behind those that it has, each in a line of its own where these
    are."""
    text = own_copy(text, ("criteria",), sharing)
    scale = unit_of(text)
    for criterion in change.added:
        row = _criterion_text(criterion, scale)
        node = node_at(text, ("criteria",)).node
        if node is not None and node.kind == "sequence" and node.items:
            text = with_row(text, node, row)
        elif node is not None:
            text = exchanged(text, node, f"[{row}]")
        else:
            text = with_entry(text, marked(text), "criteria", f"[{row}]")
    return text


def _criterion_text(criterion: Criterion, scale: float) -> str:
    """A criterion about the distance of a pair as it stands in a file."""
    entries = {
        "name": plain_name(criterion.name),
        "check": criterion.check,
        "people": _names_text(criterion.people),
        "segments": _names_text(criterion.segments),
    }
    if criterion.check == "clearance":
        entries["parts"] = _names_text(criterion.parts)
    entries["at_least"] = length_text(criterion.at_least / scale)
    return "{" + ", ".join(f"{key}: {value}" for key, value in entries.items()) + "}"


def _names_text(names: Sequence[str]) -> str:
    return f"[{', '.join(map(plain_name, names))}]"


def _move_text(move: Move, scale: float) -> str:
    """A move as it stands in a file: parts by name, so that controls take none along."""
    entry = [f"parts: {_names_text(move.parts)}"] if move.parts else []
    entry += [f"controls: {_names_text(move.controls)}", "alone: true"] if move.controls else []
    return f"{{{', '.join(entry)}, by: {_vector_text(move.by, scale)}}}"


def _vector_text(values: Sequence[float], scale: float) -> str:
    return "[" + ", ".join(length_text(value / scale) for value in values) + "]"


def _angles(angles: Sequence[AxisAngle]) -> str:
    return "{" + ", ".join(f"{angle.motion}: {angle.text}" for angle in angles) + "}"


_SPLICES: Mapping[type, Callable[[str, Any, Sharing], str]] = {
    AdjustChange: set_adjustment,
    ClothesChange: set_clothes,
    CriteriaChange: _add_criteria,
    HoldChange: set_hold,
    JointChange: _set_joint,
    MovedChange: _set_moved,
    PostureChange: _set_posture,
    PredictionChange: set_prediction,
    SeatChange: _set_seat,
    SizeChange: set_size,
    ZoneChange: set_zone,
}
"""How each kind of change comes into a text."""
