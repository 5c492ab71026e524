"""Edits of a description: pure functions from one description to the next.

What was pointed at goes along when a unit, an axis or the floor changes; what was typed stays.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.errors import InputError, has_controls, one_of
from workbench.files.yaml_edits import Key
from workbench.model.arrays import Floats
from workbench.study.describe.meshes import Ray
from workbench.study.describe.planes import fitted_plane
from workbench.study.describe.state import (
    Description,
    OpenPlace,
    SeatPicks,
    Spot,
    figures_of,
    standing_of,
    whole,
)

__all__ = [
    "AXES",
    "Edit",
    "faced",
    "floored",
    "framed",
    "placed_point",
    "pointed",
    "removed",
    "renamed",
    "ruled",
    "typed",
]

AXES = ("x", "y", "z", "-x", "-y", "-z")
SECTIONS = {"seat": "seats", "control": "controls", "point": "points"}
CUSHION_DEPTH = 0.020
BACK_DEPTH = 0.015
"""How deep [m] a sitter sinks in, as in the trainer that comes with the workbench; assumed."""
ALLOWED = {
    "cushion": (("LT", "LUL", "RUL"), 0.045),
    "back": (("LT", "CT", "UT", "LSM", "RSM"), 0.035),
}
"""Who may enter the parts of a seat how deep [m], as in the trainer; assumed."""
SEAT_PART = 1.5
"""A part that is larger [m] does not move with a seat."""
FITTED = ("srp", "cushion_angle", "back_angle", "yaw")
LONGEST_NAME = 80


@dataclass(frozen=True, eq=False)
class Edit:
    """A description, and what is to be said about it."""

    description: Description
    words: str = ""


def framed(
    opened: OpenPlace, before: Description, row: int, given: Mapping[str, str | None]
) -> Edit:
    """Give a mesh another unit or other axes.

    Parameters
    ----------
    row
        Of the mesh.
    given
        length, up and forward; what is None stays. An axis that is not at right angles to a new one
        gives way.

    Raises
    ------
    InputError
        If there is no such mesh, unit or axis.
    """
    meshes = before.says["meshes"]
    if not 0 <= row < len(meshes):
        raise InputError(f"there are {len(meshes)} meshes, and no mesh {row + 1}")
    raw = opened.meshes.raws[row]
    mesh = dict(meshes[row])
    wanted = {name: value for name, value in given.items() if value is not None}
    words = ""
    mesh |= wanted
    up = str(mesh.get("up") or raw.up)
    forward = str(mesh.get("forward") or raw.forward)
    if up[-1:] == forward[-1:]:
        free = next(axis for axis in ("x", "y", "z") if axis != up[-1:])
        mesh["forward" if "up" in wanted else "up"] = free
        wanted["forward" if "up" in wanted else "up"] = free
        words = (
            f"up and forward are at right angles: {'forward' if 'up' in given else 'up'} is {free}"
        )
    why = before.why | {("meshes", row, name): "chosen" for name in wanted}
    says = _with(before.says, ("meshes", row), mesh)
    return Edit(_refigured(opened, replace(before, says=says, why=why)), words)


def floored(opened: OpenPlace, before: Description, ray: Ray) -> Edit:
    """Put the height 0 at a face that was pointed at; everything goes along. InputError where
    nothing was."""
    stands = standing_of(opened, before)
    hit = stands.hit(ray)
    plane = fitted_plane(stands.corners(opened.meshes.grown([hit.face])))
    slope = math.degrees(math.acos(min(1.0, abs(float(plane.normal[2])))))
    if slope > 45.0:
        raise InputError(f"this face slopes {slope:.0f} degrees: a floor is level")
    by = -float(hit.point[2] if slope > 5.0 else plane.centre[2])
    says = before.says
    why = dict(before.why)
    file = before.file
    step = before.length(by)
    for row, mesh in enumerate(file.meshes):
        says = _with(says, ("meshes", row, "move"), _raised(before, mesh.move, by))
        why[("meshes", row, "move")] = f"picked: the height 0 is on {ray.part}"
    for name, seat in file.seats.items():
        says = _with(says, ("seats", name, "srp"), _raised(before, seat.srp, by))
    for name, control in file.controls.items():
        says = _with(says, ("controls", name, "at"), _raised(before, control.at, by))
    for name, point in file.points.items():
        says = _with(says, ("points", name), _raised(before, point, by))
    for name, one in file.adjustments.items():
        if one.about is not None:
            key: Key = ("adjustments", name, "about", "point")
            says = _with(says, key, _raised(before, one.about.point, by))
    words = f"the floor is at height 0: everything goes {step:g} {says['length']} up"
    if slope > 0.5:
        words += f"; this face slopes {slope:.1f} degrees, which is left as it is"
    return Edit(_refigured(opened, replace(before, says=says, why=why)), words)


def _raised(before: Description, point: Sequence[float], by: float) -> list[float]:
    return before.point([point[0], point[1], point[2] + by])


def faced(
    opened: OpenPlace,
    before: Description,
    seat: str,
    surface: str,
    ray: Ray | None,
) -> Edit:
    """Add a face to the cushion or back of a seat, or take all of them away.

    Once both are known, the seat is in the environment: its figures are those of the planes, but
    for those that were typed.

    Parameters
    ----------
    seat
        Its name; a new one where there is none.
    surface
        cushion or back.
    ray
        Where the picture was clicked; None to begin this surface anew. A face that is in the
        surface already takes no effect.

    Raises
    ------
    InputError
        If nothing was picked, or the two surfaces are no seat's.
    """
    name = _good_name(seat, "seat")
    picks = before.picks.get(name, SeatPicks())
    if ray is None:
        emptied = before.picks | {name: replace(picks, **{surface: ()})}
        return Edit(replace(before, picks=emptied), f"{name}: pick faces of the {surface}")
    hit = standing_of(opened, before).hit(ray)
    have: tuple[int, ...] = getattr(picks, surface)
    if have and hit.face in opened.meshes.grown(have):
        return Edit(before, f"{name}: this face is in the {surface} already")
    changed = replace(picks, **{surface: (*have, hit.face)})
    after = replace(before, picks=before.picks | {name: changed})
    opened.meshes.grown(getattr(changed, surface))  # the face has an area
    if not (changed.cushion and changed.back):
        other = "back" if surface == "cushion" else "cushion"
        if name in (before.says.get("seats") or {}):
            return Edit(after, f"{name}: pick the {other} too, and the figures follow")
        return Edit(after, f"{name}: now pick the {other}")
    if name not in (before.says.get("seats") or {}):
        after = _new_seat(opened, after, name)
    stale = [("seats", name, key) for key in FITTED]
    why = {key: words for key, words in after.why.items() if key not in stale}
    after = _seat_figures(opened, replace(after, why=why), name)
    return Edit(after, _seat_words(opened, after, name))


def _seat_words(opened: OpenPlace, description: Description, name: str) -> str:
    doubts = figures_of(opened, description, name).doubts
    return "; ".join([f"{name}: the figures are those of the planes", *doubts])


def _main_part(opened: OpenPlace, description: Description, faces: tuple[int, ...]) -> str:
    """The part that most of the area of a surface is on."""
    stands = standing_of(opened, description)
    region = opened.meshes.grown(faces)
    corners = stands.corners(region)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    part = stands.part[region]
    if not (part >= 0).any():
        raise InputError("the part that was picked has been left out: put it back")
    return stands.names[int(np.bincount(part[part >= 0], area[part >= 0]).argmax())]


def _new_seat(opened: OpenPlace, before: Description, name: str) -> Description:
    """A seat with what is assumed of it; its figures follow."""
    picks = before.picks[name]
    parts = {
        "cushion": _main_part(opened, before, picks.cushion),
        "back": _main_part(opened, before, picks.back),
    }
    seat: dict[str, Any] = dict.fromkeys(FITTED, 0)
    seat["srp"] = [0, 0, 0]
    seat["cushion"] = {
        "part": parts["cushion"],
        "segments": ["LT"],
        "depth": before.length(CUSHION_DEPTH),
    }
    seat["back"] = {
        "part": parts["back"],
        "segments": ["LT", "CT", "UT"],
        "depth": before.length(BACK_DEPTH),
    }
    stands = standing_of(opened, before)
    size = {
        part: float(np.ptp(stands.boxes[stands.names.index(part)], axis=0).max())
        for part in parts.values()
    }
    moves = [part for part in size if size[part] <= SEAT_PART]
    if moves:
        seat["moves"] = moves
    says = _with(before.says, ("seats", name), seat)
    why = dict(before.why)
    for surface in ("cushion", "back"):
        why[("seats", name, surface)] = "assumed: who rests on it, and how deep"
    rules = says.get("parts") or {}
    if parts["cushion"] == parts["back"]:
        segments = tuple(dict.fromkeys((*ALLOWED["cushion"][0], *ALLOWED["back"][0])))
        allowed = {parts["cushion"]: (segments, ALLOWED["cushion"][1])}
    else:
        allowed = {parts[surface]: ALLOWED[surface] for surface in ("cushion", "back")}
    for part, (segments, depth) in allowed.items():
        if part in rules:
            continue
        row = {"segments": list(segments), "depth": before.length(depth)}
        says = _with(says, ("parts", part), {"allow": [row]})
        why[("parts", part)] = "assumed: foam gives way"
    return replace(before, says=says, why=why)


def _seat_figures(opened: OpenPlace, before: Description, name: str) -> Description:
    """A seat with the figures of its planes, but for those that were typed."""
    found = figures_of(opened, before, name)
    picks = before.picks[name]
    degrees = {
        key: whole(round(math.degrees(getattr(found, key)), 1))
        for key in ("cushion_angle", "back_angle", "yaw")
    }
    values = {"srp": before.point(found.srp), **degrees}
    reasons = {
        "srp": "fitted: where the planes of cushion and back meet, in the middle of the cushion",
        "cushion_angle": _plane_words(opened, picks.cushion, found.cushion.off),
        "back_angle": _plane_words(opened, picks.back, found.back.off),
        "yaw": "fitted: square to the line in which the planes meet",
    }
    says = before.says
    why = dict(before.why)
    for key, value in values.items():
        place: Key = ("seats", name, key)
        if why.get(place, "").startswith("typed"):
            continue
        says = _with(says, place, value)
        why[place] = reasons[key]
    return replace(before, says=says, why=why)


def _plane_words(opened: OpenPlace, picks: tuple[int, ...], off: float) -> str:
    count = len(opened.meshes.grown(picks))
    faces = "1 face" if count == 1 else f"{count} faces"
    return f"fitted: plane of {faces}, {1e3 * off:.1f} mm off in the mean"


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
    named = _good_name(name or _free_name(part, have), kind)
    key: Key = (section, named)
    at = before.point(hit.point)
    if kind == "point":
        value: Any = at
    else:
        value = {**have.get(named, {}), "at": at, **given, "part": part}
    row = int(opened.meshes.mesh[hit.face])
    x, y, z = opened.meshes.in_file(before.file.meshes, row, hit.point).tolist()
    after = replace(
        before,
        says=_with(before.says, key, value),
        spots=before.spots | {key: Spot(row, (x, y, z))},
        why=before.why | {key: f"picked: on {part}"},
    )
    after.file  # noqa: B018 (faults of what was given)
    return Edit(after, f"{named} is on {part}")


def pointed(before: Description, name: str, at: Floats, how: str) -> Edit:
    """Put a point at a place (3,) [m] of the world that was found otherwise; how: in words."""
    named = _good_name(name, "point")
    key: Key = ("points", named)
    spots = {other: spot for other, spot in before.spots.items() if other != key}
    says = _with(before.says, key, before.point(at))
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


def typed(before: Description, kind: str, name: str, figure: str, value: Any) -> Edit:
    """Type a figure over.

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
    _there(before, kind, name)
    key: Key = (SECTIONS[kind], name, *inner)
    written = _written(before, sort, value, f"{name}: {figure}")
    noted = key[:2] if kind == "control" else key
    after = replace(
        before,
        says=_with(before.says, key, written),
        spots={other: spot for other, spot in before.spots.items() if other != noted}
        if figure == "at"
        else before.spots,
        why=before.why | {noted: "typed"} if figure in ("at", *FITTED) else before.why,
    )
    after.file  # noqa: B018 (faults of what was given)
    return Edit(after)


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
    if isinstance(value, (str, list)):
        raise InputError(f"{what}: a number is needed")
    if sort == "length":
        return before.length(value)
    return whole(round(float(value), 1))


def renamed(before: Description, kind: str, name: str, to: str) -> Edit:
    """Give a seat, a control or a point another name. InputError where it is taken."""
    _there(before, kind, name)
    section = SECTIONS[kind]
    new = _good_name(to, kind)
    if new == name:
        return Edit(before)
    if new in before.says[section] or (kind == "seat" and new in before.picks):
        raise InputError(f"there is a {kind} {new!r} already; take another name")
    rows = {new if key == name else key: value for key, value in before.says[section].items()}
    says: dict[str, Any] = {**before.says, section: rows}
    if kind == "seat":
        for key, one in (says.get("adjustments") or {}).items():
            if one.get("seat") == name:
                says = _with(says, ("adjustments", key, "seat"), new)
    elif kind == "point":
        for key, one in (says.get("adjustments") or {}).items():
            if name in one.get("points", ()):
                points = [new if point == name else point for point in one["points"]]
                says = _with(says, ("adjustments", key, "points"), points)

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
    _there(before, kind, name)
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
            _without(before.says, gone),
            picks,
            {key: spot for key, spot in before.spots.items() if key != gone},
            {key: words for key, words in before.why.items() if key[:2] != gone},
        )
    )


def ruled(opened: OpenPlace, before: Description, part: str, rule: str, value: bool | str) -> Edit:
    """Say of a part whether it is hidden, see-through or solid.

    Parameters
    ----------
    rule, value
        hidden or see_through, true or false; solid: auto, true or false.
    """
    _known_part(opened, before, part)
    own = dict((before.says.get("parts") or {}).get(part) or {})
    own.pop(rule, None)
    if value is not False or rule == "solid":
        own[rule] = value
    if own.get("solid") == "auto":
        del own["solid"]
    key: Key = ("parts", part)
    says = _with(before.says, key, own) if own else _without(before.says, key)
    after = replace(before, says=says)
    after.file  # noqa: B018 (faults of what was given)
    return Edit(after)


def _known_part(opened: OpenPlace, before: Description, part: str) -> None:
    names = standing_of(opened, before).names
    if part not in names:
        raise InputError(f"there is no part {part!r}; {one_of(part, names)}")


def _there(before: Description, kind: str, name: str) -> None:
    """InputError where a thing is not there."""
    have = before.says.get(SECTIONS[kind]) or {}
    if name not in have:
        raise InputError(f"there is no {kind} {name!r}; {one_of(name, have)}")


def _good_name(name: str, kind: str) -> str:
    """A name without spaces around. InputError where it is none."""
    found = " ".join(name.split())
    if not found or len(found) > LONGEST_NAME or has_controls(found):
        raise InputError(f"a {kind} needs a name of 1 to {LONGEST_NAME} characters")
    return found


def _free_name(wanted: str, taken: Mapping[str, Any]) -> str:
    """A name that is not taken: with the next number behind it where it is."""
    name = wanted
    count = 2
    while name in taken:
        name = f"{wanted}_{count}"
        count += 1
    return name


def _refigured(opened: OpenPlace, before: Description) -> Description:
    """A description in which what was pointed at has gone along with its mesh. A seat that is none
    with the new axes keeps its figures."""
    after = before
    for name, picks in before.picks.items():
        if picks.cushion and picks.back and name in (before.says.get("seats") or {}):
            try:
                after = _seat_figures(opened, after, name)
            except InputError:
                continue
    for key, spot in before.spots.items():
        at = opened.meshes.all_in_world(before.file.meshes, spot.mesh, np.array([spot.point]))[0]
        place = (*key, "at") if key[0] == "controls" else key
        after = replace(after, says=_with(after.says, place, after.point(at)))
    return after


def _with(says: Any, key: Key, value: Any) -> Any:
    """What a file says, with a value at a key; mappings on the way are made."""
    if not key:
        return value
    first = key[0]
    if isinstance(first, int):
        rows = list(says)
        rows[first] = _with(rows[first], key[1:], value)
        return rows
    inner = says.get(first) if says else None
    return {**(says or {}), first: _with({} if inner is None else inner, key[1:], value)}


def _without(says: Mapping[str, Any], key: Key) -> dict[str, Any]:
    """What a file says, without a value; a mapping that is empty then goes too."""
    rows = {name: value for name, value in says.items() if name != key[0]}
    if len(key) == 1:
        return rows
    inner = _without(says[str(key[0])], key[1:])
    return (
        {name: (inner if name == key[0] else value) for name, value in says.items()}
        if inner
        else rows
    )
