"""From a study to what its run needs: people in postures, a population in a seat, or a motion.

Which of the three it is follows from what the study states; what none of them can answer is refused
when the file is read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.body.parts import moved
from workbench.body.people.draw import draw_people
from workbench.body.scaling.scale import morph_to
from workbench.body.wear import wear
from workbench.errors import InputError, UsageError
from workbench.files.crash.simulations import load_simulation, with_airbags
from workbench.files.motions.number_rows import FrameRange
from workbench.model.accommodation import AccommodationStudy
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.motion_case import MotionCase, SignalPoint
from workbench.model.moving import poses_at
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.model.posture_study import Aims, Person, PostureStudy
from workbench.model.simulation import ContactRule, Restraints
from workbench.model.study import (
    Action,
    Case,
    GivenPosture,
    PeopleDrawn,
    PredictedPosture,
    RecordedMotion,
    Role,
    SimulatedMotion,
    Study,
)
from workbench.study.crash.belts import with_belts
from workbench.study.motions import MotionOptions, load_motion
from workbench.study.persons import sized_body
from workbench.study.placement import seat_point
from workbench.study.simulation import bearing, run_simulation
from workbench.study.subject import subject_body

__all__ = ["by_size", "motion_cases", "population_study", "posture_study"]


def by_size(study: Study) -> list[tuple[str, Study]]:
    """A study for each of the sizes that take a role one at a time, by their names; the study
    itself where there are none."""
    several = next((row for row, role in enumerate(study.roles) if role.sizes), None)
    if several is None:
        return [("", study)]
    found = []
    for name, size in study.roles[several].sizes.items():
        roles = list(study.roles)
        roles[several] = replace(roles[several], size=size, sizes={})
        found.append((name, replace(study, roles=tuple(roles))))
    return found


def posture_study(study: Study) -> PostureStudy:
    """The people of a study in their postures.

    Raises
    ------
    UsageError
        For a study of a population, of several sizes, or without postures.
    """
    cases = study.postures
    if study.crowd is not None or any(role.sizes for role in study.roles) or not cases:
        raise UsageError(f"study {study.name} is not of single people in postures")
    names = [case.name for case in study.cases]
    rows = {names.index(case.name): row for row, case in enumerate(cases)}
    return PostureStudy(
        name=study.name,
        title=study.title,
        description=study.description,
        environment=study.environment,
        people=tuple(_person(cases, row, role) for row, role in enumerate(study.roles)),
        cases=tuple(case.name for case in cases),
        criteria=tuple(
            criterion
            for criterion in study.criteria
            if criterion.check not in ("share", "injury")
            and any(criterion.asks(case.name) for case in cases)
        ),
        inputs=study.inputs,
        envelopes=tuple(replace(task, case=rows[task.case]) for task in study.reach_envelopes),
    )


def _person(cases: Sequence[Case], row: int, role: Role) -> Person:
    actions = [case.actions[row] for case in cases]
    return Person(
        name=role.name,
        body=role.body,
        poses=join_poses([_pose(action) for action in actions]),
        postures=tuple(_posture_words(action) for action in actions),
        seat=role.seat,
        forward=role.forward,
        up=role.up,
        stand=role.stand,
        size=role.size,
        detail=role.detail,
        wears=role.clothes,
        aims=tuple(
            action.aims if isinstance(action, PredictedPosture) else None for action in actions
        ),
        free_seat=role.seat is not None and role.free,
    )


def _pose(action: Action) -> Poses:
    assert isinstance(action, (GivenPosture, PredictedPosture))
    return action.poses


def _posture_words(action: Action) -> str:
    if isinstance(action, GivenPosture):
        return action.name
    driver = isinstance(action, PredictedPosture) and action.aims.driving is not None
    return "driver" if driver else "predicted"


def population_study(study: Study) -> AccommodationStudy:
    """The population of a study in its seat, its people drawn and its body at the level of detail
    that is checked.

    Raises
    ------
    UsageError
        For a study without a population.
    """
    role = study.crowd
    if role is None or role.seat is None:
        raise UsageError(f"study {study.name} is not of a population in a seat")
    action = study.cases[0].actions[0]
    assert isinstance(action, (GivenPosture, PredictedPosture))
    people = role.population
    seed = None
    if isinstance(people, PeopleDrawn):
        seed = people.seed
        people = draw_people(people.model, people.people, seed=seed, men=1.0 - people.women)
    assert people is not None
    return AccommodationStudy(
        name=study.name,
        title=study.title,
        description=study.description,
        environment=_room(study.environment, role),
        body=morph_to(role.body, role.detail),
        wears=role.clothes,
        people=people,
        seat=role.seat,
        aims=Aims({}) if isinstance(action, GivenPosture) else action.aims,
        like=action.name if isinstance(action, GivenPosture) else action.like,
        criteria=tuple(c for c in study.criteria if c.check != "share"),
        mixes=study.shares.mixes,
        confidence=study.shares.confidence,
        maps=study.reach_maps,
        inputs=study.inputs,
        seed=seed,
        warnings=study.warnings,
        changes=study.changes,
        pose=action.poses,
        interval=study.shares.interval,
        share_criteria=tuple(c for c in study.criteria if c.check == "share"),
        role=role.name,
    )


def _room(environment: Environment, role: Role) -> Environment:
    """The environment, with the role's seat where the role has it and without travel unless it is
    free."""
    if role.free or role.seat is None:
        return environment
    return environment.with_seat(environment.seat(role.seat).held(role.forward, role.up))


def motion_cases(study: Study) -> tuple[MotionCase, ...]:
    """The motions of a study, read or simulated, with their restraints: role by role, each in the
    order of the cases.

    Raises
    ------
    InputError
        For a motion that cannot be read, or is a single frame.
    UsageError
        For a study without motions.
    """
    if not study.motions:
        raise UsageError(f"study {study.name} has no motion")
    found: list[MotionCase] = []
    for row, role in enumerate(study.roles):
        for size, single in by_size(study) if role.sizes else [("", study)]:
            found += _role_motions(single, row, size)
    return tuple(found)


def _role_motions(study: Study, row: int, size: str) -> list[MotionCase]:
    """The motions of one role of a study, which is of this size where there are several."""
    role = study.roles[row]
    body, notes = sized_body(role.body, role.size, role.detail)
    body = wear(body, role.clothes)
    notes = tuple(f"{role.name}: {note}" for note in notes)
    subject = study.motions[0].actions[row]
    if isinstance(subject, RecordedMotion) and subject.subject:
        body, lengths = subject_body(body, subject.file, options=_options(subject))
        notes += lengths
    found = []
    for case in study.motions:
        several = (role.name if len(study.roles) > 1 else "", size)
        name = ", ".join([case.name, *filter(None, several)])
        found.append(_motion_case(study, case, (row, body), name))
    return [replace(found[0], warnings=(*notes, *found[0].warnings)), *found[1:]]


def _motion_case(study: Study, case: Case, who: tuple[int, Body], name: str) -> MotionCase:
    """The motion of one role in one case by itself, with a name of its own."""
    row, body = who
    role = study.roles[row]
    action = case.actions[row]
    assert isinstance(action, (RecordedMotion, SimulatedMotion))
    if isinstance(action, RecordedMotion):
        motion, notes = load_motion(body, action.file, options=_options(action))
        if len(motion) < 2:
            raise InputError(f"{action.file}: one frame is a posture; a motion needs two or more")
    else:
        motion, notes = _simulated(action)
    restraints = action.restraints
    cabin = _cabin(study.environment, restraints, (body, motion))
    first = place(body, poses_at(motion, motion.clock[:1]))
    environment = with_belts(cabin, restraints.belts, first)
    return MotionCase(
        case=case.name,
        name=name,
        person=role.name,
        body=body,
        motion=motion,
        environment=environment,
        cabin=cabin,
        points=_points(study, body),
        filter_class=study.signals.filter_class,
        criteria=_motion_criteria(study, case, role),
        belts=restraints.belts,
        pulse=restraints.pulse,
        forces=_forces(study, body, environment, len(cabin.parts)),
        bears=bearing(environment, restraints.names),
        warnings=notes,
    )


def _motion_criteria(study: Study, case: Case, role: Role) -> tuple[Criterion, ...]:
    """The criteria that are asked of a role in a case, those between people aside."""
    return tuple(
        criterion
        for criterion in study.criteria
        if criterion.check != "between_people"
        and criterion.asks(case.name)
        and role.name in criterion.people
    )


def _options(action: RecordedMotion) -> MotionOptions:
    keep = FrameRange(action.begin, action.end, action.every)
    return MotionOptions(
        action.names, action.up, action.metres, keep, action.gaps, action.move, action.yaw
    )


def _simulated(action: SimulatedMotion) -> tuple[Poses, tuple[str, ...]]:
    """The motion of a simulation that starts from a posture of the study."""
    plan = load_simulation(action.simulation)
    poses = action.poses
    at = plan.file.at
    if at is not None:
        world = np.column_stack([np.asarray(at.attitude.matrix()), at.position])
        poses = Poses(poses.rotations, plan.body.segment(at.segment), world[None])
    made = run_simulation(replace(plan, poses=poses))
    return made.motion, made.warnings


def _cabin(
    environment: Environment, restraints: Restraints, who: tuple[Body, Poses]
) -> Environment:
    """The environment with the seat where its occupant has put it, and with airbags."""
    body, motion = who
    if restraints.seat:
        seat = environment.seat(restraints.seat)
        sitter = Person(
            "occupant",
            body,
            motion,
            (),
            seat=restraints.seat,
            forward=restraints.forward,
            up=restraints.up,
        )
        shift = seat_point(sitter, environment) - np.array(seat.srp)
        environment = moved(environment, seat.moves, shift)
    return with_airbags(environment, restraints.airbags)


def _points(study: Study, body: Body) -> tuple[SignalPoint, ...]:
    """The points of the signals, and the origins of the segments that only rules are about."""
    points = study.signals.points
    known = {body.segments[point.segment] for point in points}
    limited = (limit.segment for criterion in study.criteria for limit in criterion.limits)
    return points + tuple(
        SignalPoint(body.segment_names[body.segment(s)], body.segment(s), (0.0, 0.0, 0.0))
        for s in dict.fromkeys(limited)
        if s not in known
    )


def _forces(
    study: Study, body: Body, environment: Environment, still: int
) -> tuple[ContactRule, ...]:
    """The laws of contact with the first `still` parts, which stand still: of belts the tension is
    reported, not the depth in where they were."""
    stands = np.arange(len(environment.parts)) < still
    return tuple(
        ContactRule(
            np.isin(body.segments, law.segments),
            np.isin(environment.parts, law.parts) & stands,
            law.law,
        )
        for law in study.contact_forces
    )
