"""The motions of a study: read or simulated, each in its cabin with its restraints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.crash.simulated import simulate
from workbench.errors import InputError, UsageError
from workbench.files.crash.restraints import law_in_si
from workbench.files.crash.simulations import SimulationPlan, load_simulation, with_airbags
from workbench.files.motions.number_rows import FrameRange
from workbench.model.arrays import Bools
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase, SignalPoint
from workbench.model.poses import Poses
from workbench.model.simulation import ContactRule, Restraints, Simulated, Simulation
from workbench.model.study import Case, RecordedMotion, Role, SimulatedMotion, Study
from workbench.posture.seating.seat import seat
from workbench.posture.seating.seating import seat_at
from workbench.study.crash.belts import with_belts
from workbench.study.motions import MotionOptions, load_motion, subject_body
from workbench.study.persons import role_body

__all__ = ["bearing", "motion_cases", "moved_case", "prepared", "run_simulation"]


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
        for size, single in study.by_size() if role.sizes else [("", study)]:
            found += _role_motions(single, row, size)
    return tuple(found)


def _role_motions(study: Study, row: int, size: str) -> list[MotionCase]:
    """The motions of one role of a study, which is of this size where there are several."""
    role = study.roles[row]
    body, notes = role_body(role)
    subject = study.motions[0].actions[row]
    if isinstance(subject, RecordedMotion) and subject.subject:
        body, lengths = subject_body(body, subject.file, options=_options(subject))
        notes += lengths
    found = []
    for case in study.motions:
        several = (role.name if len(study.roles) > 1 else "", size)
        name = ", ".join([case.name, *filter(None, several)])
        found.append(_motion_case(study, case, row, body, name))
    return [replace(found[0], warnings=(*notes, *found[0].warnings)), *found[1:]]


def _motion_case(study: Study, case: Case, row: int, body: Body, name: str) -> MotionCase:
    """The motion of one role (row) in one case by itself, with a name of its own."""
    role = study.roles[row]
    action = case.actions[row]
    assert isinstance(action, (RecordedMotion, SimulatedMotion))
    if isinstance(action, RecordedMotion):
        motion, notes = load_motion(body, action.file, options=_options(action))
        if len(motion) < 2:
            raise InputError(f"{action.file}: one frame is a posture; a motion needs two or more")
    else:
        motion, notes = _simulated(action)
    return _in_place(
        study,
        case,
        row,
        MotionCase(
            case=case.name,
            name=name,
            person=role.name,
            body=body,
            motion=motion,
            environment=study.environment,
            cabin=study.environment,
            points=_points(study, body),
            belts=action.restraints.belts,
            pulse=action.restraints.pulse,
            warnings=notes,
        ),
    )


def moved_case(study: Study, motion: MotionCase) -> MotionCase:
    """Put a motion into another state of its study: other criteria, and parts that stand elsewhere.

    Parameters
    ----------
    study
        With the same roles and cases as the study that the motion was read of.
    motion
        One of its `motion_cases`.
    """
    case = next(one for one in study.motions if one.name == motion.case)
    row = [role.name for role in study.roles].index(motion.person)
    return _in_place(study, case, row, motion)


def _in_place(study: Study, case: Case, row: int, motion: MotionCase) -> MotionCase:
    """A motion with its surroundings, what is asked of it there, and its laws of contact."""
    action = case.actions[row]
    assert isinstance(action, (RecordedMotion, SimulatedMotion))
    restraints = action.restraints
    cabin = _cabin(study.environment, restraints)
    first = place(motion.body, poses_at(motion.motion, motion.motion.clock[:1]))
    environment = with_belts(cabin, restraints.belts, first)
    return replace(
        motion,
        environment=environment,
        cabin=cabin,
        criteria=_motion_criteria(study, case, study.roles[row]),
        forces=_forces(study, motion.body, environment, len(cabin.parts)),
        bears=bearing(environment, restraints.names),
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
    keep = FrameRange(action.begin, action.end, action.every, action.as_read)
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


def _cabin(environment: Environment, restraints: Restraints) -> Environment:
    """The environment with the seat where its occupant has put it, and with airbags."""
    if restraints.seat:
        environment = seat_at(environment, restraints.seat, restraints.forward, restraints.up)
    return with_airbags(environment, restraints.airbags)


def _points(study: Study, body: Body) -> tuple[SignalPoint, ...]:
    """The points of the signals, and the origins of the segments that only rules are about."""
    points = study.signals.points
    known = {body.segments[point.segment] for point in points}
    limited = (limit.segment for criterion in study.criteria for limit in criterion.limits)
    return points + tuple(
        SignalPoint(
            body.segment_names[body.segment(s)],
            body.segment(s),
            (0.0, 0.0, 0.0),
            study.signals.filter_class,
        )
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


def run_simulation(source: str | Path | SimulationPlan) -> Simulated:
    """Simulate the crash of a file, by path or catalogue name.

    InputError for faults of the file and for a step that is too coarse; MissingPartError without
    MuJoCo.
    """
    plan = source if isinstance(source, SimulationPlan) else load_simulation(source)
    return simulate(prepared(plan))


def prepared(plan: SimulationPlan) -> Simulation:
    """The plan with its occupant in the seat, and the seat where the occupant has put it."""
    file = plan.file
    poses = plan.poses
    environment = plan.environment
    if file.seat is not None:
        at = file.adjust
        forward, up = (at.forward, at.up) if at is not None else (0.0, 0.0)
        held = environment.seat(file.seat).held(forward, up)
        poses = seat(plan.body, poses, held).poses
        environment = seat_at(environment, file.seat, forward, up)
    return Simulation(
        name=file.simulation,
        body=plan.body,
        environment=environment,
        poses=poses,
        pulse=plan.pulse,
        belts=plan.belts,
        rules=plan.rules,
        other=law_in_si(file.others),
        flesh=law_in_si(file.flesh),
        joints=plan.joints,
        relaxed=tuple(plan.body.joint(name) for name in file.relaxed),
        bears=bearing(environment, [bag.name for bag in file.airbags]),
        tone=file.tone,
        gravity=file.gravity,
        duration=file.duration / 1000,
        frame=file.frames / 1000,
        step=file.step / 1000,
        settle=file.settle / 1000,
        inputs=plan.inputs,
    )


def bearing(environment: Environment, more: Iterable[str] = ()) -> Bools:
    """(K,) the cushions and backs of seats, and the parts named: what pushes back from its surface
    on."""
    names = {part for seat in environment.seats for part in seat.parts} | set(more)
    return np.array([part in names for part in environment.parts], dtype=np.bool_)
