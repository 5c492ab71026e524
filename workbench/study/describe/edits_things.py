"""Edits of a description: controls and points, and figures that are typed over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.environment_own import grippable
from workbench.files.environment_parts import matching_parts
from workbench.files.names import good_name
from workbench.files.yaml_changes import Key
from workbench.model.arrays import Floats
from workbench.study.describe.meshes import PlacedMeshes, Ray
from workbench.study.describe.state import (
    FITTED,
    SECTIONS,
    Description,
    Edit,
    OpenPlace,
    check_there,
    spot_of,
    standing_of,
    whole,
    with_value,
    without_value,
)

__all__ = ["accepted", "owned", "placed_point", "pointed", "removed", "renamed", "typed"]

BESIDE = 0.06
"""A control no farther [m] beside a part that a hand closes about, or a foot presses, is on it: a fist
is 0.1 m thick."""
ON = 0.01
"""A control no farther [m] from any other part is on it."""


def placed_point(
    opened: OpenPlace, before: Description, kind: str, name: str, given: Mapping[str, Any], ray: Ray
) -> Edit:
    """Put a control or a point where the picture was clicked.

    Parameters
    ----------
    kind
        control or point.
    name
        Of a new one, or of one that is there and is put elsewhere; "" for the name of the part.
    given
        grip and zone of a control.
    """
    stands = standing_of(opened, before)
    hit = stands.hit(ray)
    part = stands.names[int(stands.part[hit.face])]
    section = SECTIONS[kind]
    have = before.says.get(section) or {}
    named = good_name(name or _free_name(part, have), kind)
    key: Key = (section, named)
    at = before.point(hit.point)
    if kind == "point":
        value: Any = at
    else:
        stated = before.file.controls[named].part_keys if named in have else ()
        same = any(part in matching_parts(key, stands.names) for key in stated)
        own = have[named]["part"] if same else part
        value = {**have.get(named, {}), "at": at, **given, "part": own}
    after = replace(
        before,
        says=with_value(before.says, key, value),
        spots=before.spots | {key: spot_of(opened, before, hit)},
        why=before.why | {key: f"picked: on {part}"},
    )
    after.file  # noqa: B018 (faults of what was given)
    return Edit(after, f"{named} is on {part}")


def owned(opened: OpenPlace, before: Description, name: str, parts: Sequence[str]) -> Edit:
    """State which parts are a control's own.

    Parameters
    ----------
    name
        Of the control.
    parts
        The parts beside the one that it stands on, or with it; without any the other pieces are
        looked for.

    Raises
    ------
    InputError
        If there is no such control or part, or the control stands on no part.
    """
    check_there(before, "control", name)
    names = standing_of(opened, before).names
    keys = before.file.controls[name].part_keys
    if not keys:
        raise InputError(f"{name} stands on no part: put it on one first")
    for part in parts:
        if part not in names:
            raise InputError(f"there is no part {part!r}; {one_of(part, names)}")
    first = matching_parts(keys[0], names)[:1] or [keys[0]]
    own = list(dict.fromkeys([*first, *parts]))
    value: str | list[str] = own if parts else first[0]
    after = replace(before, says=with_value(before.says, ("controls", name, "part"), value))
    said = f"{name}: its own parts are {', '.join(own)}" if parts else ""
    return Edit(after, said or f"{name}: the pieces of {first[0]} are looked for")


def _free_name(wanted: str, taken: Mapping[str, Any]) -> str:
    """A name that is not taken: with the next number behind it where it is."""
    name = wanted
    count = 2
    while name in taken:
        name = f"{wanted}_{count}"
        count += 1
    return name


def pointed(before: Description, name: str, at: Floats, how: str) -> Edit:
    """Put a point at a place (3,) [m] of the world that was found otherwise; how: in words."""
    named = good_name(name, "point")
    key: Key = ("points", named)
    spots = {other: spot for other, spot in before.spots.items() if other != key}
    says = with_value(before.says, key, before.point(at))
    return Edit(
        replace(before, says=says, spots=spots, why=before.why | {key: how}), f"{named}: {how}"
    )


_FIGURES: Mapping[str, Mapping[str, tuple[tuple[str, ...], str]]] = {
    "seat": {
        "srp": (("srp",), "point"),
        "cushion_angle": (("cushion_angle",), "number"),
        "back_angle": (("back_angle",), "number"),
        "yaw": (("yaw",), "number"),
        "cushion_depth": (("cushion", "depth"), "length"),
        "back_depth": (("back", "depth"), "length"),
        "forward": (("travel", "forward"), "range"),
        "up": (("travel", "up"), "range"),
        "tilt": (("travel", "tilt"), "angles"),
    },
    "control": {
        "at": (("at",), "point"),
        "grip": (("grip",), "text"),
        "zone": (("zone",), "number"),
        "part": (("part",), "text"),
    },
    "point": {"at": ((), "point")},
}
"""Figures by what they are of: where they stand in the file, and of which kind they are."""


def typed(
    opened: OpenPlace, before: Description, kind: str, name: str, figure: str, value: Any
) -> Edit:
    """Type a figure over.

    A control whose place is typed is on the part that is there, and on none where none is: what was
    clicked before, perhaps the floor, is no longer its part.

    Parameters
    ----------
    kind, name
        seat, control or point, and its name.
    figure
        One of those of the kind.
    value
        Lengths in metres, angles in degrees, or a text.

    Raises
    ------
    InputError
        If there is no such thing, or it cannot have this value.
    """
    if figure not in _FIGURES[kind]:
        raise InputError(f"a {kind} has no {figure!r}; {one_of(figure, _FIGURES[kind])}")
    inner, sort = _FIGURES[kind][figure]
    check_there(before, kind, name)
    key: Key = (SECTIONS[kind], name, *inner)
    written = _written(before, sort, value, f"{name}: {figure}")
    noted = key[:2] if kind == "control" else key
    after = replace(
        before,
        says=with_value(before.says, key, written),
        spots={other: spot for other, spot in before.spots.items() if other != noted}
        if figure == "at"
        else before.spots,
        why=before.why | {noted: "typed"} if figure in ("at", *FITTED) else before.why,
    )
    after.file  # noqa: B018 (faults of what was given)
    if (kind, figure) == ("control", "at"):
        return _on_part(opened, after, name)
    return Edit(after)


def _on_part(opened: OpenPlace, before: Description, name: str) -> Edit:
    """A control on the part that is where it was typed: that of before where this is near enough,
    else the nearest, none where nothing is there."""
    control = before.file.controls[name]
    if not control.part_keys:
        return Edit(before)
    stands = standing_of(opened, before)
    at = np.array(control.at)
    own = [k for key in control.part_keys for k in _numbers(key, stands)]
    small = [k for k in own if grippable(stands.touching.triangles(k))]
    if stands.nearest(at, BESIDE, parts=small) or stands.nearest(at, ON, parts=own):
        return Edit(before)
    key: Key = ("controls", name, "part")
    hit = stands.nearest(at, ON)
    if hit is None:
        words = f"{name}: nothing is within {1e3 * ON:.0f} mm of there, so it is on no part"
        return Edit(replace(before, says=without_value(before.says, key)), words)
    part = stands.names[int(stands.part[hit.face])]
    return Edit(replace(before, says=with_value(before.says, key, part)), f"{name} is on {part}")


def _numbers(key: str, stands: PlacedMeshes) -> list[int]:
    """The parts that a name or a pattern of a control means, by number."""
    return [stands.names.index(part) for part in matching_parts(key, stands.names)]


def _written(before: Description, sort: str, value: Any, what: str) -> Any:
    """A value as it stands in the file."""
    if sort == "text":
        if not isinstance(value, str):
            raise InputError(f"{what}: a text is needed")
        return value
    if sort in ("point", "range"):
        count = 3 if sort == "point" else 2
        if not isinstance(value, list) or len(value) != count:
            raise InputError(f"{what}: {count} lengths are needed")
        return before.point(value)
    if sort == "angles":
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{what}: two angles are needed")
        return [whole(round(float(one), 1)) for one in value]
    if isinstance(value, (str, list)):
        raise InputError(f"{what}: a number is needed")
    if sort == "length":
        return before.length(value)
    return whole(round(float(value), 1))


def renamed(before: Description, kind: str, name: str, to: str) -> Edit:
    """Give a seat, a control or a point another name. InputError where it is taken."""
    check_there(before, kind, name)
    section = SECTIONS[kind]
    new = good_name(to, kind)
    if new == name:
        return Edit(before)
    if new in before.says[section] or (kind == "seat" and new in before.picks):
        raise InputError(f"there is a {kind} {new!r} already; take another name")
    rows = {new if key == name else key: value for key, value in before.says[section].items()}
    says: dict[str, Any] = {**before.says, section: rows}
    if kind == "seat":
        for key, one in (says.get("adjustments") or {}).items():
            if one.get("seat") == name:
                says = with_value(says, ("adjustments", key, "seat"), new)
    elif kind == "point":
        for key, one in (says.get("adjustments") or {}).items():
            if name in one.get("points", ()):
                points = [new if point == name else point for point in one["points"]]
                says = with_value(says, ("adjustments", key, "points"), points)

    def moved(key: Key) -> Key:
        return (section, new, *key[2:]) if key[:2] == (section, name) else key

    picks = before.picks
    if kind == "seat":
        picks = {new if key == name else key: one for key, one in picks.items()}
    return Edit(
        Description(
            says,
            picks,
            {moved(key): spot for key, spot in before.spots.items()},
            {moved(key): words for key, words in before.why.items()},
        )
    )


def removed(before: Description, kind: str, name: str) -> Edit:
    """Take a seat, a control or a point away. InputError where something depends on it."""
    section = SECTIONS[kind]
    picks = {key: one for key, one in before.picks.items() if kind != "seat" or key != name}
    if kind == "seat" and name in before.picks and name not in (before.says.get(section) or {}):
        return Edit(replace(before, picks=picks))
    check_there(before, kind, name)
    for key, one in (before.says.get("adjustments") or {}).items():
        if (kind == "seat" and one.get("seat") == name) or (
            kind == "point" and name in one.get("points", ())
        ):
            raise InputError(
                f"adjustment {key!r} names the {kind} {name!r}: change it in the file first"
            )
    gone = (section, name)
    return Edit(
        Description(
            without_value(before.says, gone),
            picks,
            {key: spot for key, spot in before.spots.items() if key != gone},
            {key: words for key, words in before.why.items() if key[:2] != gone},
        )
    )


def accepted(before: Description, about: str) -> Edit:
    """Put a doubt away, by what it is about."""
    have = before.says.get("accepted") or []
    if about in have:
        return Edit(before)
    says = with_value(before.says, ("accepted",), [*have, about])
    return Edit(replace(before, says=says), f"{about}: put away; the file says so under accepted")
