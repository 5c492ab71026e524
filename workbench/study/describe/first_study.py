"""Write a first study of an environment: somebody in each seat, with what is asked of any cockpit.

It is a beginning to be edited. Each seat has a role. Hands and feet of a sitter take the
likeliest controls on their own side; a control belongs to the seat that is nearest to it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from workbench.files.yaml_changes import flow_text
from workbench.model.environment import Control, Environment, Seat
from workbench.study.describe.people import PERSON

__all__ = ["first_study"]

STANDS_BEHIND = 0.5
"""How far [m] behind an environment without seats somebody stands, looking forward."""
BEFORE = (0.45, 0.30)
"""How far [m] ahead of and above the seat reference point hands are at work, about."""
FEET = "foot"
HANDS = ("push", "pinch", "grasp")


def first_study(environment: Environment, source: str) -> str:
    """Return the text of a study that runs as it is.

    Parameters
    ----------
    environment
        The environment.
    source
        How the study is to name it: a name of the catalogue, or a path from the study's file.
    """
    lines = [
        "# A first study, made by `workbench new`. docs/studies.md has all that can be said here.",
        f"study: {_plain_name(environment.name)}",
        "length: mm",
        f"environment: {flow_text(source)}",
        "people:                       # who is present at once; other people: size, population",
    ]
    if not environment.seats:
        return "\n".join([*lines, *_standing(environment)]) + "\n"
    roles = _roles(environment)
    for role, seat in roles.items():
        who = {"body": PERSON, "seat": seat.name}
        lines.append(f"  {flow_text(role)}: {flow_text(who)}")
    lines += ["cases:", "  - name: at the controls", "    people:"]
    for role, seat in roles.items():
        lines.append(f"      {flow_text(role)}: {flow_text(_action(environment, seat))}")
    return "\n".join([*lines, *_criteria(environment, roles)]) + "\n"


def _plain_name(words: str) -> str:
    """A name of a study: letters, digits and underscores."""
    return "_".join(re.findall(r"[a-z0-9]+", words.lower())) or "study"


def _standing(environment: Environment) -> list[str]:
    """The rest of a study of an environment that nobody sits in."""
    corners = environment.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    at = [low[0] - STANDS_BEHIND, 0.5 * (low[1] + high[1]), max(float(low[2]), 0.0)]
    who = {"body": PERSON, "stand": {"on": [round(1e3 * float(value)) for value in at]}}
    lines = [
        f"  person: {flow_text(who)}",
        "cases:",
        "  - {name: standing, people: {person: {posture: standing}}}",
    ]
    return [*lines, *_criteria(environment, {})]


def _roles(environment: Environment) -> dict[str, Seat]:
    """A role for each seat, called as the seat."""
    return {seat.name: seat for seat in environment.seats}


def _criteria(environment: Environment, roles: Mapping[str, Seat]) -> list[str]:
    """What is asked: contact, reach of each seat's controls, room between people."""
    rows: list[dict[str, Any]] = [{"name": "nobody is in the structure", "check": "contact"}]
    owned = {role: _own_controls(environment, seat) for role, seat in roles.items()}
    for role, controls in owned.items():
        if controls:
            names = [control.name for control in controls]
            row: dict[str, Any] = {"name": f"{role} reaches the controls", "check": "reach"}
            if len(roles) > 1:
                row |= {"people": [role], "controls": names}
            rows.append(row)
    if not roles and environment.controls:
        rows.append({"name": "controls are reached", "check": "reach"})
    if len(roles) > 1:
        rows.append({"name": "room between people", "check": "between_people", "at_least": 0})
    return ["criteria:", *(f"  - {flow_text(row)}" for row in rows)]


def _own_controls(environment: Environment, seat: Seat) -> list[Control]:
    """The controls to which no other seat is nearer."""
    return [
        control
        for control in environment.controls
        if min(environment.seats, key=lambda one: math.dist(one.srp, control.at)) is seat
    ]


def _action(environment: Environment, seat: Seat) -> dict[str, Any]:
    """What somebody does in a seat: hands and feet on the likeliest controls of their side."""
    own = _own_controls(environment, seat)
    hands = _by_side(seat, [control for control in own if control.grip in HANDS])
    feet = _by_side(seat, [control for control in own if control.grip == FEET])
    if not hands and not feet:
        return {"posture": "hands_in_lap"}
    predicted: dict[str, Any] = {"hands": hands} if hands else {}
    if feet:
        predicted["feet"] = feet
    return {"predicted": predicted}


def _by_side(seat: Seat, controls: Iterable[Control]) -> dict[str, str]:
    """The control to the left and the one to the right of a seat's middle that hands and feet are
    likely on: of the least zone, and of these the nearest to where hands are at work."""
    ahead = np.array([math.cos(seat.yaw), math.sin(seat.yaw), 0.0])
    work = np.array(seat.srp) + BEFORE[0] * ahead + np.array([0.0, 0.0, BEFORE[1]])
    rows = sorted(
        controls, key=lambda control: (control.zone, math.dist(work, control.at), control.name)
    )
    found: dict[str, str] = {}
    for control in rows:
        side = "left" if _to_left(seat, control.at) > 0.0 else "right"
        found.setdefault(side, control.name)
    return {side: found[side] for side in ("left", "right") if side in found}


def _to_left(seat: Seat, at: Sequence[float]) -> float:
    """How far [m] a place is to the left of a seat's middle."""
    way = np.array([-math.sin(seat.yaw), math.cos(seat.yaw), 0.0])
    return float((np.array(at) - np.array(seat.srp)) @ way)
