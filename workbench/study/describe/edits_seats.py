"""Edits of a description: seats, fitted to the faces that were picked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.names import good_name
from workbench.files.seat_doubts import SEAT_PART
from workbench.files.yaml_changes import Key
from workbench.study.describe.meshes import Ray
from workbench.study.describe.state import (
    FITTED,
    SURFACES,
    Description,
    Edit,
    OpenPlace,
    SeatPicks,
    Spot,
    check_there,
    figure_reasons,
    figure_values,
    figures_of,
    spot_of,
    spot_place,
    standing_of,
    with_value,
)

__all__ = ["carried", "faced", "with_picked", "with_seat_figures"]

CUSHION_DEPTH = 0.020
BACK_DEPTH = 0.015
"""How deep [m] a sitter sinks in, as in the trainer that comes with the workbench; assumed."""
ALLOWED = {
    "cushion": (("LT", "LUL", "RUL"), 0.045),
    "back": (("LT", "CT", "UT", "LSM", "RSM"), 0.035),
}
"""Who may enter the parts of a seat how deep [m], as in the trainer; assumed."""


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
    name = good_name(seat, "seat")
    picks = before.picks.get(name, SeatPicks())
    if ray is None:
        emptied = before.picks | {name: replace(picks, **{surface: ()})}
        return Edit(replace(before, picks=emptied), f"{name}: pick faces of the {surface}")
    hit = standing_of(opened, before).hit(ray)
    if picks.faces(surface) and hit.face in opened.meshes.grown(picks.faces(surface)):
        return Edit(before, f"{name}: this face is in the {surface} already")
    have: tuple[Spot, ...] = getattr(picks, surface)
    changed = replace(picks, **{surface: (*have, spot_of(opened, before, hit))})
    after = replace(before, picks=before.picks | {name: changed})
    opened.meshes.grown(changed.faces(surface))  # the face has an area
    if not (changed.cushion and changed.back):
        other = "back" if surface == "cushion" else "cushion"
        if name in (before.says.get("seats") or {}):
            return Edit(after, f"{name}: pick the {other} too, and the figures follow")
        across = _size_words(opened, after, changed.faces(surface))
        bare = "" if other == "cushion" else ", or write a stool, which has none, into the file"
        return Edit(after, f"{name}: a {surface} of {across}; now pick the {other}{bare}")
    more = []
    if name not in (before.says.get("seats") or {}):
        after = _new_seat(opened, after, name)
        more = _part_doubts(opened, after, name)
    stale = [("seats", name, key) for key in FITTED]
    why = {key: words for key, words in after.why.items() if key not in stale}
    after = with_picked(opened, replace(after, why=why), name)
    after = with_seat_figures(opened, after, name)
    return Edit(after, "; ".join([_seat_words(opened, after, name), *more]))


def _seat_words(opened: OpenPlace, description: Description, name: str) -> str:
    figures = figures_of(opened, description, name)
    told = (*figures.doubts, *figures.notes)
    return "; ".join([f"{name}: the figures are those of the planes", *told])


def _part_doubts(opened: OpenPlace, description: Description, name: str) -> list[str]:
    """Sentences about parts of a seat that are more than a seat."""
    stands = standing_of(opened, description)
    seat = description.says["seats"][name]
    parts = dict.fromkeys(seat[surface]["part"] for surface in SURFACES)
    size = np.ptp(stands.boxes, axis=1).max(axis=1)
    return [
        f"{part} is {size[stands.names.index(part)]:.2f} m large, and a sitter may enter all of it: "
        f"if it can be split, remove the seat, split the part and pick again"
        for part in parts
        if size[stands.names.index(part)] > SEAT_PART
    ]


def _size_words(opened: OpenPlace, description: Description, faces: tuple[int, ...]) -> str:
    """How large the surface is that was picked, by the two larger sides of its box."""
    corners = standing_of(opened, description).corners(opened.meshes.grown(faces))
    sides = np.sort(np.ptp(corners.reshape(-1, 3), axis=0))[1:]
    return f"{1e3 * sides[0]:.0f} x {1e3 * sides[1]:.0f} mm"


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
        "cushion": _main_part(opened, before, picks.faces("cushion")),
        "back": _main_part(opened, before, picks.faces("back")),
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
    says = with_value(before.says, ("seats", name), seat)
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
        says = with_value(says, ("parts", part), {"allow": [row]})
        why[("parts", part)] = "assumed: foam gives way"
    return replace(before, says=says, why=why)


def with_picked(opened: OpenPlace, before: Description, name: str) -> Description:
    """A description in which a seat says where it was picked. A surface of which nothing is picked
    at present keeps what the file says."""
    says = before.says
    for surface in SURFACES:
        spots: tuple[Spot, ...] = getattr(before.picks[name], surface)
        if spots:
            points = [before.point(spot_place(opened, before, spot)) for spot in spots]
            says = with_value(says, ("seats", name, surface, "picked"), points)
    return replace(before, says=says)


def with_seat_figures(opened: OpenPlace, before: Description, name: str) -> Description:
    """A description in which a seat has the figures of its planes, but for those that were typed;
    the same where one of its surfaces is not picked. InputError where the planes are no seat's."""
    picks = before.picks[name]
    if not (picks.cushion and picks.back):
        return before
    values = figure_values(before, figures_of(opened, before, name))
    reasons = figure_reasons(opened, before, name)
    says = before.says
    why = dict(before.why)
    for key, value in values.items():
        place: Key = ("seats", name, key)
        if why.get(place, "").startswith("typed"):
            continue
        says = with_value(says, place, value)
        why[place] = reasons[key]
    return replace(before, says=says, why=why)


def carried(opened: OpenPlace, before: Description, name: str, parts: Sequence[str]) -> Edit:
    """Say which parts go along with a seat. InputError where one is not there."""
    check_there(before, "seat", name)
    names = standing_of(opened, before).names
    for part in parts:
        if part not in names:
            raise InputError(f"there is no part {part!r}; {one_of(part, names)}")
    key: Key = ("seats", name, "moves")
    after = replace(before, says=with_value(before.says, key, list(dict.fromkeys(parts))))
    words = ", ".join(parts) if parts else "no part"
    return Edit(after, f"{name}: {words} goes along with the seat")
