"""Controls that nobody grips because they are flat: a decal, a burner, a key of a keyboard.

A hand closes about a knob; of what lies flat on something it meets the thing behind. Where almost
nobody reaches such a control, people are asked whether they reach it by a push, or a pinch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.geometry.surfaces import come_near
from workbench.model.accommodation import met_of
from workbench.model.environment import Control, Environment
from workbench.model.result import GripFinding
from workbench.study.accommodation.checkpoints import Chunk, PopulationQuestion
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.checks.margins import Asked
from workbench.study.positions import comfortable_situations, tried
from workbench.study.situation import Occupants

__all__ = ["flat_thickness", "grip_findings", "grip_words"]

FLAT = 0.01
"""A control no thicker [m] than this is flat: fingers do not get behind it."""
WIDER = 3.0
"""If it is as many times wider, in its narrow direction."""
BEHIND = 0.015
"""And if there is something as near [m] as this behind it: a free sheet is grasped about its edge."""
ALMOST = 0.05
"""Where no more than this share reaches it, almost nobody does."""
MOST = 0.5
"""The share that must reach it with the other grip, for that to be said."""
PEOPLE = 64
"""How many people are asked about another grip, at most."""
OTHERS = {"grasp": ("push", "pinch"), "pinch": ("push",)}
"""The grips that are tried in the place of one."""
_WORDS = {"grasp": ("grasps", "grasp"), "pinch": ("pinches", "pinch"), "push": ("pushes", "push")}


def grip_findings(
    question: PopulationQuestion, bodies: PopulationBodies, found: Chunk
) -> Iterator[GripFinding]:
    """Find the flat controls that almost nobody reaches with the grip that is asked for, and that
    most reach with another one."""
    weight = question.people.weight
    place = question.place
    rows = np.unique(np.linspace(0, len(bodies) - 1, min(PEOPLE, len(bodies))).astype(int))
    for r, one in enumerate(question.asked):
        control = one.control
        if control is None or control.grip not in OTHERS:
            continue
        share = float(weight @ met_of(found.margin[:, r]) / weight.sum())
        if share > ALMOST or (thickness := flat_thickness(place.environment, control)) is None:
            continue
        asked = [replace(one, control=replace(control, grip=grip)) for grip in OTHERS[control.grip]]
        shares = _shares(question, bodies, rows, asked)
        best = int(np.argmax(shares))
        if shares[best] >= MOST:
            yield GripFinding(
                requirement=one.requirement.name,
                control=control.name,
                grip=control.grip,
                thickness=thickness,
                some=share > 0,
                other=OTHERS[control.grip][best],
                share=shares[best],
                people=len(rows),
            )


def _shares(
    question: PopulationQuestion, bodies: PopulationBodies, rows: np.ndarray, asked: Sequence[Asked]
) -> list[float]:
    """The share of people (rows) who meet each requirement where they sit most comfortably."""
    who = Occupants(bodies[rows], question.people, rows)
    margin = tried(comfortable_situations(question.place, who), asked).margin
    weight = question.people.weight[rows]
    return [float(weight @ met_of(column) / weight.sum()) for column in margin.T]


def flat_thickness(environment: Environment, control: Control) -> float | None:
    """How thick [m] a control is that lies flat on something, None of any other.

    Its own parts are measured along the axis that most of their area faces (the first eigenvector
    of the sum of n n' dA) and across it; what is behind them is looked for about the control's
    point.
    """
    own = [environment.part_index(name) for name in control.own_parts]
    if not own:
        return None
    corners = np.concatenate([environment.triangle_corners(part) for part in own])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    facing = np.linalg.eigh(np.einsum("t,ti,tj->ij", 1.0 / area, normal, normal))[1]
    one, other, thickness = np.ptp(corners.reshape(-1, 3) @ facing, axis=0).tolist()
    if thickness > FLAT or min(one, other) < WIDER * thickness:
        return None
    probe = np.array(control.at) + 1e-4 * np.eye(3)[None]
    others = [
        part
        for part in range(len(environment.parts))
        if part not in own and not environment.hidden[part]
    ]
    near = any(come_near(probe, environment.triangle_corners(part), BEHIND) for part in others)
    return float(thickness) if near else None


def grip_words(found: Sequence[GripFinding]) -> Iterator[str]:
    """Say that a grip cannot work, and which one does: "nobody grasps burner_a: it is flat, 1.3 mm
    thick; 100 % push it"."""
    for one in found:
        who = "almost nobody" if one.some else "nobody"
        yield (
            f"{who} {_WORDS[one.grip][0]} {one.control}: it is flat, {1000 * one.thickness:.1f} mm "
            f"thick; {100 * one.share:.0f} % {_WORDS[one.other][1]} it: `grip: {one.other}`"
        )
