"""Changes of persons spliced into a study's text: size, clothes, prediction, what hands and feet
hold, and the harness zone that a criterion asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.files.yaml_edits import (
    Key,
    Sharing,
    exchanged,
    flow_text,
    length_text,
    mapping_at,
    node_at,
    node_text,
    own_copy,
    plain_name,
    unit_of,
    with_entry,
    without_entry,
)
from workbench.model.measures import MASS

_OTHER = {"left": "right", "right": "left"}

__all__ = [
    "AdjustChange",
    "ClothesChange",
    "HoldChange",
    "PredictionChange",
    "SizeChange",
    "StatedSize",
    "ZoneChange",
    "set_adjustment",
    "set_clothes",
    "set_hold",
    "set_prediction",
    "set_size",
    "set_zone",
]


@dataclass(frozen=True)
class StatedSize:
    """A size as a file states it: measures [m; mass in kg] and age [years]."""

    sex: str
    measures: Mapping[str, float] = field(default_factory=dict)
    age: float | None = None

    @property
    def lengths(self) -> dict[str, float]:
        """The measures but for the mass."""
        return {name: value for name, value in self.measures.items() if name != MASS}


@dataclass(frozen=True)
class SizeChange:
    """The size of a role, None where the body is as its file has it.

    Parameters
    ----------
    at
        Where it stands in the role: ("size",), or ("sizes", its name).
    """

    role: str
    at: tuple[str, ...]
    before: StatedSize | None
    after: StatedSize | None


@dataclass(frozen=True)
class ClothesChange:
    """What a role wears, by names: as the text has it, and as it is to be."""

    role: str
    before: tuple[str, ...]
    after: tuple[str, ...]


@dataclass(frozen=True)
class PredictionChange:
    """A prediction in the place of what a role does in a case: the posture of trunk and head, the
    controls that limbs hold, and the points of eyes and heels."""

    case: int
    role: str
    like: str
    controls: Mapping[str, str]
    eyes: str | None = None
    heels: str | None = None


@dataclass(frozen=True)
class AdjustChange:
    """Where an adjustment is set: in degrees of one that turns, else [m].

    Parameters
    ----------
    role
        In whose entry it stands where no other role's has it already.
    """

    role: str
    name: str
    value: float
    turns: bool


@dataclass(frozen=True)
class HoldChange:
    """The control that a hand or foot holds.

    Parameters
    ----------
    kind
        The key of the prediction, "predicted" or "driver"; "" of a given posture.
    control
        None where it holds none any longer.
    """

    case: int
    role: str
    kind: str
    limb: str
    control: str | None


@dataclass(frozen=True)
class ZoneChange:
    """The harness zone of a criterion, by its number in the file; None for that of each control."""

    criterion: int
    zone: int | None


def set_size(text: str, change: SizeChange, sharing: Sharing) -> str:
    """The text with another size of a role."""
    role: Key = ("people", change.role)
    key = (*role, *change.at)
    text = own_copy(text, key, sharing)
    node = node_at(text, key).node
    after = change.after
    if after is None:
        return text if node is None else without_entry(text, mapping_at(text, role), "size")
    scale = unit_of(text)
    whole = _size_text(after, scale)
    if node is None:
        return with_entry(text, mapping_at(text, role), "size", whole)
    before = change.before
    if node.kind != "mapping" or before is None:
        return exchanged(text, node, whole)
    if before.sex != after.sex:
        text = _set(text, key, "sex", after.sex)
    if (before.age is None) != (after.age is None):  # children have other populations
        text = _set(text, key, "population", None)
    if before.age != after.age:
        text = _set(text, key, "age", None if after.age is None else f"{after.age:g}")
    mass = after.measures.get(MASS)
    if before.measures.get(MASS) != mass:
        text = _set(text, key, "mass_kg", None if mass is None else length_text(mass))
    if before.lengths == after.lengths:
        return text
    inner = (*key, "measures")
    text = own_copy(text, inner, sharing)
    measures = node_at(text, inner).node
    if measures is None or not after.lengths or not set(before.lengths) & set(after.lengths):
        return _set(text, key, "measures", _measures_text(after, scale) or None)
    for name in before.lengths:
        if name not in after.lengths:
            text = _set(text, inner, name, None)
    for name, value in after.lengths.items():
        if before.lengths.get(name) != value:
            text = _set(text, inner, name, length_text(value / scale))
    return text


def _set(text: str, key: Key, name: str, value: str | None) -> str:
    """The text with an entry of a mapping: another value, a new one, or none."""
    mapping = mapping_at(text, key)
    item = mapping.item(name)
    if value is None:
        return text if item is None else without_entry(text, mapping, name)
    if item is None:
        return with_entry(text, mapping, name, value)
    return exchanged(text, item.value, value)


def _size_text(size: StatedSize, scale: float) -> str:
    """A size in flow style."""
    rows = [f"sex: {size.sex}"]
    if size.age is not None:
        rows.append(f"age: {size.age:g}")
    if size.lengths:
        rows.append(f"measures: {_measures_text(size, scale)}")
    if MASS in size.measures:
        rows.append(f"mass_kg: {length_text(size.measures[MASS])}")
    return "{" + ", ".join(rows) + "}"


def _measures_text(size: StatedSize, scale: float) -> str:
    """The lengths of a size in flow style, "" where there are none."""
    rows = [f"{name}: {length_text(value / scale)}" for name, value in size.lengths.items()]
    return "{" + ", ".join(rows) + "}" if rows else ""


def set_clothes(text: str, change: ClothesChange, sharing: Sharing) -> str:
    """The text with other clothes of a role; what stays keeps the words by which it is named."""
    role: Key = ("people", change.role)
    key = (*role, "clothes")
    text = own_copy(text, key, sharing)
    node = node_at(text, key).node
    known = {name: plain_name(name) for name in change.after}
    if node is not None and node.kind == "sequence":
        for name, item in zip(change.before, node.items, strict=False):
            known[name] = flow_text(text, item.value)
    whole = "[" + ", ".join(known[name] for name in change.after) + "]"
    if not change.after:
        return text if node is None else without_entry(text, mapping_at(text, role), "clothes")
    if node is None:
        return with_entry(text, mapping_at(text, role), "clothes", whole)
    return exchanged(text, node, whole)


def set_prediction(text: str, change: PredictionChange, sharing: Sharing) -> str:
    """The text with a prediction where something else was done."""
    key: Key = ("cases", change.case, "people", change.role)
    text = own_copy(text, key, sharing)
    action = mapping_at(text, key)
    if action.item("predicted") is not None:
        return _set_aims(text, (*key, "predicted"), change, sharing)
    rows = [f"like: {plain_name(change.like)}"]
    for kind, limb in (("hands", "hand"), ("feet", "foot")):
        held = [
            f"{side}: {plain_name(change.controls[f'{side} {limb}'])}"
            for side in ("left", "right")
            if f"{side} {limb}" in change.controls
        ]
        if held:
            rows.append(f"{kind}: {{{', '.join(held)}}}")
    rows += [
        f"{name}: {plain_name(point)}"
        for name, point in (("eyes", change.eyes), ("heels", change.heels))
        if point is not None
    ]
    first = action.items[0].key
    assert first is not None
    words = f"predicted: {{{', '.join(rows)}}}"
    return text[: first.start] + words + text[action.items[-1].value.end :]


def _set_aims(text: str, key: Key, change: PredictionChange, sharing: Sharing) -> str:
    """The text with other entries in a prediction that stands there."""
    text = own_copy(text, key, sharing)
    for name in ("like", "eyes", "heels"):
        value = getattr(change, name)
        if node_text(text, (*key, name)) != value:
            text = own_copy(text, (*key, name), sharing)
            text = _set(text, key, name, None if value is None else plain_name(value))
    for group, limb in (("hands", "hand"), ("feet", "foot")):
        for side in ("left", "right"):
            control = change.controls.get(f"{side} {limb}")
            if node_text(text, (*key, group, side)) != control:
                text = _set_side(text, key, (group, side), control, sharing)
    return text


def _set_side(
    text: str, key: Key, at: tuple[str, str], control: str | None, sharing: Sharing
) -> str:
    """The text with another control of one side, None for none; at: the group and the side."""
    group, side = at
    value = None if control is None else plain_name(control)
    text = own_copy(text, (*key, group), sharing)
    if node_at(text, (*key, group)).node is None:
        return _set(text, key, group, f"{{{side}: {value}}}")
    text = own_copy(text, (*key, group, side), sharing)
    return _set(text, (*key, group), side, value)


def set_hold(text: str, change: HoldChange, sharing: Sharing) -> str:
    """The text with another control that a limb holds."""
    side, limb = change.limb.split()
    group = "feet" if limb == "foot" else "hands"
    key: Key = ("cases", change.case, "people", change.role)
    if change.kind:
        key = (*key, change.kind)
    elif change.control is None and node_text(text, (*key, group, _OTHER[side])) is None:
        text = own_copy(text, key, sharing)
        return _set(text, key, group, None)
    else:
        text = own_copy(text, key, sharing)
    return _set_side(text, key, (group, side), change.control, sharing)


def set_adjustment(text: str, change: AdjustChange, sharing: Sharing) -> str:
    """The text with another setting of an adjustment."""
    people = mapping_at(text, ("people",))
    names = [item.key.text for item in people.items if item.key is not None]
    stated = [
        name
        for name in names
        if node_text(text, ("people", name, "adjust", change.name)) is not None
    ]
    role: Key = ("people", stated[0] if stated else change.role)
    value = (
        f"{round(change.value, 1):g}" if change.turns else length_text(change.value / unit_of(text))
    )
    text = own_copy(text, (*role, "adjust"), sharing)
    if node_at(text, (*role, "adjust")).node is None:
        return with_entry(text, mapping_at(text, role), "adjust", f"{{{change.name}: {value}}}")
    text = own_copy(text, (*role, "adjust", change.name), sharing)
    return _set(text, (*role, "adjust"), change.name, value)


def set_zone(text: str, change: ZoneChange, sharing: Sharing) -> str:
    """The text with another harness zone of a criterion."""
    key: Key = ("criteria", change.criterion)
    text = own_copy(text, (*key, "zone"), sharing)
    return _set(text, key, "zone", None if change.zone is None else str(change.zone))
