"""What the bench sends of persons beside where they are: size, clothes, posture and harness zone."""

from __future__ import annotations

from functools import lru_cache
from typing import Any
from zlib import crc32

from workbench.model.measures import MASS
from workbench.model.person import Size
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.study.bench.answers import Answer
from workbench.study.bench.edits_people import percentile_of, reach_criteria, wearable
from workbench.study.bench.edits_postures import suggested
from workbench.study.bench.holding import troubles
from workbench.study.bench.state import Arrangement, OpenStudy

__all__ = ["person_offers", "person_state"]

MIXED = 0
"""The zone of a person whose criteria ask for different ones; -1 is that of each control."""


def person_offers(opened: OpenStudy, row: int) -> dict[str, Any]:
    """What a person may be given, as long as a study is open."""
    role = opened.study.roles[row]
    return {
        "many": row == opened.crowd,
        "stands": role.stand is not None,
        "wearable": wearable(role.body, opened.folder),
        "postures": list(role.library),
        "reaches": bool(reach_criteria(opened, role.name)),
    }


def person_state(opened: OpenStudy, found: Answer, row: int) -> dict[str, Any]:
    """Who a person is and what the person does in a state.

    `figure` is another number where the picture of the body must be fetched again.
    """
    placement = found.placement
    arrangement = placement.arrangement
    person = arrangement.people[row]
    action = person.actions[arrangement.case]
    predicts = isinstance(action, PredictedPosture)
    wanted = suggested(opened, placement, row, found.people[row].tips)
    size = person.figure.size
    trouble = troubles(opened, found, row)
    return {
        "figure": crc32(placement.people[row].body.radius.tobytes()),
        "size": None if size is None else _size(size),
        "clothes": [item.name for item in person.figure.clothes],
        "posture": "" if predicts else getattr(action, "name", ""),
        "predicted": predicts,
        "hands": dict(action.hands) if isinstance(action, GivenPosture) else {},
        "drives": isinstance(action, PredictedPosture) and action.aims.driving is not None,
        "prediction": {
            "like": wanted.like,
            "holds": dict(wanted.controls),
            "eyes": wanted.eyes,
            "heels": wanted.heels,
        },
        "trouble": list(trouble.words),
        "offer": trouble.offer,
        "zone": _zone(opened, arrangement, person.role),
    }


@lru_cache(maxsize=256)
def _size(size: Size) -> dict[str, Any]:
    """A size: of each measure what it is [m; mass in kg], and its percentile where it has one."""
    measures = {}
    for name, value in size.measures.items():
        percentile = percentile_of(size, name)
        digits = 3 if name == MASS else 5
        shown = None if percentile is None else round(percentile, 2)
        measures[name] = [round(value, digits), shown]
    return {"sex": size.sex, "age": size.age, "measures": measures}


def _zone(opened: OpenStudy, arrangement: Arrangement, person: str) -> int:
    """The harness zone that a person's reaches are judged in."""
    zones = {arrangement.zones[k] for k in reach_criteria(opened, person)}
    if len(zones) > 1:
        return MIXED
    zone = next(iter(zones), None)
    return -1 if zone is None else zone
