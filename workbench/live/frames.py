"""What the bench sends: a study as it is opened, the answer to a state, verdicts and where each finding
is, and of persons their size, clothes, posture and harness zone.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from workbench.draw.eye_view import FIELD
from workbench.live.protocol import packed
from workbench.model.accommodation import met_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Adjustment
from workbench.model.person import Size
from workbench.model.population import MASS, SEXES
from workbench.model.poses import Placed
from workbench.model.result import Finding, Verdict
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.model.surroundings import Move, Surroundings
from workbench.model.units import UNITS, plain
from workbench.posture.seating.seating import seat_shift
from workbench.sight.eyes import eyes_of as sight_of
from workbench.sight.eyes import has_eyes, head_of
from workbench.study.bench.answers import TOUCHES, Answer, BenchEvaluation, near_pairs
from workbench.study.bench.criteria import role_bodies
from workbench.study.bench.crowd import BenchPopulation, met_all
from workbench.study.bench.edits_people import percentile_of, reach_criteria, wearable
from workbench.study.bench.edits_postures import suggested
from workbench.study.bench.holding import troubles
from workbench.study.bench.motions import MotionsJudged, motion_names
from workbench.study.bench.near import NearPair
from workbench.study.bench.placing import placed_environment
from workbench.study.bench.state import Arrangement, OpenStudy
from workbench.study.checks.margins import Asked
from workbench.study.checks.view import THE_EYES, eyes_of
from workbench.study.people import Present
from workbench.study.situation import moved_by

__all__ = [
    "PeopleShown",
    "answer_frame",
    "hello_frame",
    "move_row",
    "near_row",
    "part_shifts",
    "people_frame",
    "person_offers",
    "person_state",
    "place_of_finding",
    "sight_frame",
    "verdict_frame",
    "waiting_frame",
]

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


def place_of_finding(finding: Finding, there: Present) -> tuple[float, float, float] | None:
    """Find the place [m] in the world that a finding about a posture is to be looked at.

    Findings of reach and of pedals are about a control, those of eye heights about a point; those of
    joint stops name the joint as their subject, those of a view over parts the eyes.

    Parameters
    ----------
    there
        The people of the state that was judged, and the environment with their seats.

    Returns
    -------
    tuple or None
        None where the finding is about no place, such as the travel of a seat.
    """
    if finding.point is not None:
        return finding.point
    for control in there.environment.controls:
        if control.name == finding.about:
            return _xyz(control.at)
    if finding.about in there.environment.points:
        return _xyz(there.environment.points[finding.about])
    for situation in (one for cases in there.situations for one in cases):
        body = situation.body
        asked = (situation.work.name, situation.place.role) == (finding.case, finding.person)
        if asked and finding.subject == THE_EYES:
            return _xyz(eyes_of(situation)[0])
        if asked and finding.subject in body.joint_names:
            joint = body.joint_names.index(finding.subject)
            child = situation.placed.world_from_segment[0, joint + 1]
            return _xyz(child[:, :3] @ body.joint_in_child[0, joint] + child[:, 3])
    return None


def _xyz(point: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(point, float).tolist()
    return x, y, z


NO_PART = 0xFFFF
MOST_CHANGED = 100
"""People who are listed because they fit now, or do no longer."""


def hello_frame(opened: OpenStudy, file: str, *, saves: bool) -> bytes:
    """Pack what stays as long as a study is open: people with their joints and seats, cases,
    controls, and the parts that can be moved."""
    study = opened.study
    people = [
        {
            "role": role.name,
            "seat": _seat(opened, row),
            **_body(
                opened.start.body(row),
                {
                    action.poses.reference
                    for action in opened.start.people[row].actions
                    if isinstance(action, GivenPosture | PredictedPosture)
                },
            ),
            **person_offers(opened, row),
        }
        for row, role in enumerate(study.roles)
    ]
    controls = [
        {"name": one.name, "grip": one.grip, "zone": one.zone, "part": one.part}
        for one in study.environment.controls
    ]
    riding = {name for seat in study.environment.seats for name in seat.moves}
    hidden = study.environment.hidden
    parts = [
        name for k, name in enumerate(study.environment.parts) if not (hidden[k] or name in riding)
    ]
    return packed(
        {
            "kind": "hello",
            "file": file,
            "title": study.title,
            "saves": saves,
            "notes": list(opened.notes),
            "field": round(FIELD, 6),
            "cases": list(opened.cases),
            "motions": list(motion_names(opened)),
            "people": people,
            "controls": controls,
            "parts": parts,
            "triangles": len(study.environment.triangles),
            "points": list(study.environment.points),
            "seats": sorted(riding),
            "roles": [
                {
                    "role": name,
                    "segments": [body.segment_names[n] for n in np.unique(body.sphere_segment)],
                }
                for name, body in role_bodies(opened).items()
            ],
        }
    )


def _seat(opened: OpenStudy, row: int) -> dict[str, Any] | None:
    """The seat of a role with its travel [m]."""
    seat = opened.seat(row)
    if seat is None:
        return None
    return {
        "name": seat.name,
        "forward": list(seat.travel_forward),
        "up": list(seat.travel_up),
        "ahead": _rounded(seat_shift(seat, 1.0, 0.0)),
        "parts": list(seat.moves),
    }


def _body(body: Body, stands_by: set[int]) -> dict[str, Any]:
    """The segments and joints of a body; axes that do not turn have no motions. Neither has a joint
    that bears the whole body of a person who is put into the world by what it bears."""
    stops = body.stops
    every = np.eye(len(body.joints), dtype=np.bool_)
    bears_all = [bool(moved_by(body, one).all()) and 0 not in stands_by for one in every]
    locked = stops.locked | np.array(bears_all)[:, None]
    joints = []
    for j, joint in enumerate(body.joints):
        axes = [
            None if locked[j, axis] else [plain(motion) for motion in stops.motions[j][axis]]
            for axis in range(3)
        ]
        joints.append({"joint": joint, "name": body.joint_names[j], "axes": axes})
    return {
        "body": body.name,
        "segments": list(body.segment_names),
        "spheres": len(body.sphere_names),
        "joints": joints,
    }


def answer_frame(found: Answer, opened: OpenStudy, head: Mapping[str, Any], begin: float) -> bytes:
    """Pack the answer to a state.

    Parameters
    ----------
    head
        What the desk says about it.
    begin
        When it was begun [s], by `time.perf_counter`.
    """
    part_of = opened.study.environment.polygon_part
    people = []
    arrays = []
    for row, one in enumerate(found.people):
        person = one.person
        people.append(
            {
                "role": person.state.role,
                "free": person.state.free,
                "forward": round(person.forward, 6),
                "up": round(person.up, 6),
                "angles": _degrees(one.angles),
                "limits": _degrees(one.limits),
                "tips": {name: _rounded(tip) for name, tip in one.tips.items()},
                **person_state(opened, found, row),
                "eyes": _eyes(person.placed),
            }
        )
        polygon = one.near.polygon[0]
        part = np.where(polygon >= 0, part_of[np.maximum(polygon, 0)], NO_PART)
        arrays += [
            (f"centres{row}", person.placed.centres[0].astype(np.float32)),
            (f"radius{row}", person.body.radius[0].astype(np.float32)),
            (f"room{row}", one.near.distance[0].astype(np.float32)),
            (f"sphere{row}", one.near.sphere[0].astype(np.int32)),
            (f"part{row}", part.astype(np.uint16)),
            (f"overlap{row}", np.array(sorted(found.overlaps[row]), dtype=np.int32)),
        ]
    moves = found.placement.arrangement.moves
    sent = {
        "kind": "answer",
        **head,
        "moves": [move_row(move) for move in moves],
        "shifts": part_shifts(found.placement.parts),
        "controls": [
            _rounded(one.at) for one in placed_environment(opened, found.placement).controls
        ],
        "adjustments": [
            _adjustment(one, found) for one in found.placement.parts.environment.adjustments
        ],
        "case": opened.cases[found.placement.arrangement.case] if opened.cases else "",
        "people": people,
        "near": [near_row(pair) for pair in near_pairs(found)],
        "ms": round(1e3 * (time.perf_counter() - begin), 1),
    }
    return packed(sent, arrays)


def _eyes(placed: Placed) -> dict[str, Any] | None:
    """From where somebody looks [m], the line of sight, which way is up for the head, and the index
    of its segment; None for a body without eyes."""
    if not has_eyes(placed.body):
        return None
    found = sight_of(placed)
    return {
        "at": _rounded(found.middle[0]),
        "sight": _rounded(found.line()[0]),
        "up": _rounded(found.axes[0, 2]),
        "head": head_of(placed.body),
    }


def _adjustment(one: Adjustment, found: Answer) -> dict[str, Any]:
    """An adjustment with where it is set and its travel [mm; degrees], and who has set it: "" where
    the study says it."""
    scale = float(np.degrees(1.0)) if one.turns else 1e3
    setters = [
        person.person.state.role
        for person in found.people
        if one.name in dict(person.person.settings)
    ]
    return {
        "name": one.name,
        "unit": "°" if one.turns else "mm",
        "scale": scale,
        "at": round(scale * one.at, 3),
        "travel": [round(scale * end, 3) for end in one.travel],
        "by": setters[0] if setters else "",
    }


def move_row(move: Move) -> dict[str, Any]:
    """By how much [m] which parts and controls stand elsewhere."""
    return {"parts": list(move.parts), "controls": list(move.controls), "by": _rounded(move.by)}


def part_shifts(arranged: Surroundings) -> dict[str, list[float]]:
    """By how much parts are displaced [m] from where their environment has them."""
    shifts = arranged.by_part
    moving = sorted(k for group in arranged.movers for k in group)
    return {arranged.environment.parts[k]: _rounded(shifts[k]) for k in moving}


def near_row(pair: NearPair) -> dict[str, Any]:
    """A near pair, its lengths in mm: the distance, the overlap that is allowed, and whether that is
    passed."""
    return {
        "mm": 1e3 * pair.distance,
        "allowed": 1e3 * pair.allowed,
        "deep": pair.room < -TOUCHES,
        "person": pair.person,
        "subject": pair.subject,
        "segment": pair.segment,
        "other_segment": pair.other_segment,
        "other": pair.other_person,
        "target": pair.target,
        "point": [round(value, 5) for value in pair.point],
    }


def verdict_frame(
    judged: BenchEvaluation | None,
    motions: MotionsJudged | None,
    generation: int,
    *,
    waits: bool = False,
) -> bytes:
    """Pack the verdicts of a state, the worst first.

    Parameters
    ----------
    judged
        What was found of postures, None where there are none.
    motions
        What was found of motions, None where nothing is known yet.
    waits
        Whether some motions are not judged yet.
    """
    found = judged.found.verdicts if judged is not None else ()
    warnings = list(judged.found.warnings) if judged is not None else []
    if motions is not None:
        found = (*found, *motions.verdicts)
        warnings += motions.warnings
    there = judged.there if judged is not None else None
    rows = [_verdict(one, there) for one in found]
    rows.sort(key=lambda row: (row["passed"], row["margin"] is not None, row["margin"] or 0.0))
    return packed(
        {
            "kind": "verdicts",
            "generation": generation,
            "passed": all(row["passed"] for row in rows),
            "waits": waits,
            "motions": [motions.done, motions.of] if motions is not None else None,
            "rows": rows,
            "warnings": warnings,
        }
    )


def sight_frame(verdict: Verdict, here: Present, generation: int) -> bytes:
    """Pack a verdict of what is seen from where the people of a state are now."""
    row = _verdict(verdict, here)
    return packed({"kind": "sight", "generation": generation, "row": row | {"now": True}})


def _verdict(verdict: Verdict, there: Present | None) -> dict[str, Any]:
    """A verdict in words, its margin in mm or degrees, and where to look at it."""
    worst = verdict.worst
    row: dict[str, Any] = {
        "name": verdict.criterion.name,
        "check": verdict.criterion.check,
        "passed": verdict.passed,
        "asked": worst is not None,
        "breaches": len(verdict.breaches),
        "margin": None,
        "unit": "",
        "words": verdict.words or "nothing was found to look at",
        "case": verdict.motion,
        "person": "",
        "point": None,
        "time": None,
        "now": False,
    }
    if worst is None:
        return row
    unit = UNITS[worst.unit]
    lead = worst.person + (f" and {worst.other_person}" if worst.other_person else "")
    margin = unit.scale * worst.margin
    timed = bool(np.isfinite(worst.time))
    point = worst.point if timed or there is None else place_of_finding(worst, there)
    return row | {
        "margin": margin if np.isfinite(margin) else None,
        "unit": unit.sign.strip(),
        "words": plain(f"{lead}: " + " – ".join(filter(None, (worst.subject, worst.target)))),
        "case": worst.case,
        "person": worst.person,
        "point": None if point is None else [round(value, 5) for value in point],
        "time": round(worst.time, 6) if timed else None,
    }


@dataclass(frozen=True, eq=False)
class PeopleShown:
    """What is known of some people of a population.

    Parameters
    ----------
    rows
        (B,) of the people.
    margin, before
        (B, R) [m] what they have to spare now, and in the study as it was opened.
    known
        (B, R) what is known now.
    settled
        (B,) whether a run finds the same now.
    new
        (R,) the requirements that are not in the study as it was opened.
    asked
        The R requirements.
    """

    rows: Ints
    margin: Floats
    known: Bools
    settled: Bools
    before: Floats
    new: Bools
    asked: Sequence[Asked]


def waiting_frame(words: str) -> bytes:
    """Pack why nothing is known of a population yet, or at all."""
    return packed({"kind": "people", "words": words})


def people_frame(crowd: BenchPopulation, shown: PeopleShown, generation: int) -> bytes:
    """Pack who of a population fits, reaches and clears, and whom a change has made to: shares from
    `share` to `most`, which differ where something is not known yet."""
    weight = crowd.people.weight[shown.rows]

    def share(met: Bools) -> float:
        return round(float(weight[met].sum() / weight.sum()), 6)

    checks = np.array([one.requirement.check for one in shown.asked])
    sets = {
        "fit": np.ones(len(checks), dtype=np.bool_),
        "reach": checks == "reach",
        "clear": np.isin(checks, ("clearance", "contact")),
    }
    now = met_of(shown.margin)
    before = met_of(shown.before)
    rows = [
        {
            "name": one.requirement.name,
            "share": share(now[:, r] & shown.known[:, r]),
            "most": share(now[:, r]),
            "was": None if shown.new[r] else share(before[:, r]),
        }
        for r, one in enumerate(shown.asked)
    ]
    rows.sort(key=lambda row: (row["share"], row["name"]))
    return packed(
        {
            "kind": "people",
            "words": "",
            "generation": generation,
            "of": len(crowd.order),
            "known": len(shown.rows),
            "settled": int(shown.settled.sum()),
            "asked": int((~shown.known).any(axis=1).sum()),
            "shares": [
                {
                    "name": name,
                    "share": share(met_all(shown.margin, some) & shown.known[:, some].all(axis=1)),
                    "most": share(met_all(shown.margin, some)),
                    "was": share(met_all(shown.before, some)),
                }
                for name, some in sets.items()
                if some.any()
            ],
            "rows": rows,
            "changed": _changed(crowd, shown),
        }
    )


def _changed(crowd: BenchPopulation, shown: PeopleShown) -> list[dict[str, Any]]:
    """The people who fit now and did not, or did and do no longer, with what is missed by most."""
    fits = met_all(shown.margin)
    sure = shown.known.all(axis=1) | ~fits
    rows = np.flatnonzero((fits != met_all(shown.before)) & sure)
    people = crowd.people
    stature = people.column("stature") if "stature" in people.names else None
    found = []
    for row in rows[np.argsort(shown.rows[rows])][:MOST_CHANGED].tolist():
        person = int(shown.rows[row])
        margin = np.nan_to_num((shown.before if fits[row] else shown.margin)[row], nan=np.inf)
        r = int(margin.argmin())
        unit = shown.asked[r].requirement.unit
        found.append(
            {
                "person": person + 1,
                "sex": SEXES[int(people.sex[person])],
                "stature": None if stature is None else round(1e3 * float(stature[person])),
                "fits": bool(fits[row]),
                "name": shown.asked[r].requirement.name,
                "margin": round(unit.shown(float(margin[r])), 1),
                "unit": unit.sign,
                "settled": bool(shown.settled[row]),
            }
        )
    return found


def _degrees(angles: Floats) -> Any:
    """Angles in degrees, to a hundredth; those without a stop half a turn."""
    shown = np.degrees(np.nan_to_num(angles, posinf=np.pi, neginf=-np.pi))
    return np.round(np.clip(shown, -360.0, 360.0), 2).tolist()


def _rounded(values: Floats | tuple[float, ...]) -> list[float]:
    return [round(float(value), 5) for value in values]
