"""People in postures: seat them, measure everything in all cases, judge the criteria."""

from __future__ import annotations

from itertools import combinations

from workbench.body.pieces import piece_warnings
from workbench.contact.collide import (
    body_clearance,
    body_contacts,
    contacts,
    nearest,
    self_clearance,
    self_contacts,
)
from workbench.model.environment import Environment
from workbench.model.poses import Placed, Poses
from workbench.model.posture_study import Person, PostureStudy
from workbench.model.result import PersonResult, PosturesFound
from workbench.posture.stops import stops
from workbench.study.criteria import Measured, verdict
from workbench.study.envelope.envelope import envelopes
from workbench.study.placement import adjusted_environment, place_person
from workbench.study.predicted import prepared
from workbench.study.reaches import buried_controls, control_reaches
from workbench.study.warnings import result_warnings, seat_verdicts

__all__ = ["clearance_study"]


def clearance_study(study: PostureStudy) -> PosturesFound:
    """Seat people who are present at once, measure them in all cases, and judge the criteria."""
    study, told = prepared(study)
    environment = adjusted_environment(study)
    placed = {person.name: place_person(person, environment) for person in study.people}
    people = {
        person.name: _measure(person, placed[person.name], environment) for person in study.people
    }
    pairs = list(combinations(placed, 2))
    reaches = tuple(control_reaches(study, placed, environment))
    measured = Measured(
        environment=environment,
        cases=study.cases,
        asked={person.name: person for person in study.people},
        people=people,
        own={name: self_clearance(body) for name, body in placed.items()},
        between={(a, b): body_clearance(placed[a], placed[b]) for a, b in pairs},
        reaches=reaches,
    )
    return PosturesFound(
        study=study,
        environment=environment,
        verdicts=(
            *seat_verdicts(environment, study, tuple(people.values())),
            *(verdict(criterion, measured) for criterion in study.criteria),
        ),
        people=tuple(people.values()),
        between={(a, b): body_contacts(placed[a], placed[b]) for a, b in pairs},
        warnings=(
            *told,
            *piece_warnings((person.name, person.body) for person in study.people),
            *(buried_controls(environment) if reaches else ()),
            *result_warnings(study, environment, tuple(people.values())),
            *study.warnings,
        ),
        reaches=reaches,
        envelopes=tuple(envelopes(study, placed, environment)),
    )


def _measure(person: Person, placed: Placed, environment: Environment) -> PersonResult:
    poses = Poses(
        person.poses.rotations,
        person.poses.reference,
        placed.world_from_segment[:, person.poses.reference],
    )
    margins = stops(person.body, poses)
    joints = range(len(person.body.joints))
    return PersonResult(
        name=person.name,
        placed=placed,
        contacts=contacts(placed, environment),
        self_contacts=self_contacts(placed),
        clearance=nearest(placed, environment),
        margin=margins.margin,
        margin_motion=tuple(
            tuple(margins.motion(p, j) for j in joints) for p in range(len(placed))
        ),
    )
