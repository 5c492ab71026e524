"""What each verb of the bench does to a state: the edits, in a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from workbench.model.surroundings import Move
from workbench.study.bench.criteria import PairLimit, asked_for
from workbench.study.bench.edits import Edit, adjusted_to, seated, shifted
from workbench.study.bench.edits_joints import LimbTarget, mirrored, reached, turned
from workbench.study.bench.edits_people import SizeWanted, dressed, harnessed, sized
from workbench.study.bench.edits_postures import Prediction, freed, posed, predicted
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import OpenStudy

__all__ = ["EDITS", "EditVerb"]

Given = Mapping[str, Any]


@dataclass(frozen=True)
class EditVerb:
    """An edit that a page may ask for.

    Parameters
    ----------
    edit
        From an open study, a state with its people where they are, and what the verb takes, to the
        state after it.
    prepared
        What is said while another thread prepares it, "" where it takes no time.
    """

    edit: Callable[[OpenStudy, Placement, Given], Edit]
    prepared: str = ""


def _reach(opened: OpenStudy, placement: Placement, given: Given) -> Edit:
    target = given["target"]
    wanted = LimbTarget(
        limb=given["limb"],
        at=None if target is None else (target[0], target[1], target[2]),
        control=given["control"],
        grip=given["grip"],
        zone=given["zone"],
        obstacles=given["obstacles"],
    )
    return reached(opened, placement, given["person"], wanted)


def _sit(opened: OpenStudy, placement: Placement, given: Given) -> Edit:
    arrangement = placement.arrangement
    return seated(opened, arrangement, given["person"], given["forward"], given["up"])


def _shift(opened: OpenStudy, placement: Placement, given: Given) -> Edit:
    x, y, z = given["by"]
    move = Move(tuple(given["parts"]), tuple(given["controls"]), (x, y, z))
    return shifted(opened, placement.arrangement, move)


def _size(opened: OpenStudy, placement: Placement, given: Given) -> Edit:
    wanted = SizeWanted(
        sex=given["sex"],
        measures=given["measures"],
        percentiles=given["percentiles"],
        mass=given["mass"],
        age=given["age"],
    )
    return sized(opened, placement.arrangement, given["person"], wanted)


def _predict(opened: OpenStudy, placement: Placement, given: Given) -> Edit:
    wanted = Prediction(
        like=given["like"],
        controls=given["holds"],
        eyes=given["eyes"],
        heels=given["heels"],
        everywhere=given["everywhere"],
        free=given["free"],
    )
    return predicted(opened, placement, given["person"], wanted)


EDITS: Mapping[str, EditVerb] = {
    "joint": EditVerb(
        lambda opened, placement, given: turned(
            placement, given["person"], given["joint"], given["axis"], given["degrees"]
        )
    ),
    "hand": EditVerb(_reach),
    "seat": EditVerb(_sit),
    "move": EditVerb(_shift),
    "adjust": EditVerb(
        lambda opened, placement, given: adjusted_to(
            opened, placement.arrangement, given["name"], given["value"]
        ),
        "{name} is being set",
    ),
    "size": EditVerb(_size, "the body of {person} is being made"),
    "clothes": EditVerb(
        lambda opened, placement, given: dressed(
            opened, placement.arrangement, given["person"], given["clothes"]
        ),
        "{person} is being dressed",
    ),
    "harness": EditVerb(
        lambda opened, placement, given: harnessed(
            opened, placement.arrangement, given["person"], given["zone"]
        )
    ),
    "posture": EditVerb(
        lambda opened, placement, given: posed(opened, placement, given["person"], given["name"])
    ),
    "predict": EditVerb(_predict, "the posture of {person} is being predicted"),
    "free": EditVerb(
        lambda opened, placement, given: freed(opened, placement.arrangement, given["person"]),
        "the seat of {person} is being set",
    ),
    "mirror": EditVerb(lambda opened, placement, given: mirrored(placement, given["person"])),
    "criterion": EditVerb(
        lambda opened, placement, given: asked_for(
            opened, placement.arrangement, PairLimit(**given)
        )
    ),
}
"""The verbs that change a state."""
