"""The crash study: a motion against an environment, in continuous time: what meets what, when, how
fast, how deep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.files.crash.crash_restraints import Restraints
from workbench.files.crash.restraints import rules_of
from workbench.files.crash.schema import CrashFile, MotionSource
from workbench.files.crash.simulations import with_airbags
from workbench.files.crash.studies import CrashPlan
from workbench.files.motions.lines import Pick
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.crash import Agreement, CrashResult, CrashStudy
from workbench.model.moving import poses_at
from workbench.model.poses import Poses
from workbench.model.simulation import ContactRule
from workbench.model.spool import pieces
from workbench.shape.pieces import piece_warnings
from workbench.solve.contact.episodes import episodes, self_episodes
from workbench.solve.forward import place
from workbench.study.crash.belts import belt_tensions, with_belts
from workbench.study.crash.forces import force_curves, ruled_pairs, with_forces
from workbench.study.crash.frames import BLOCK, frames_of, stop_breaches
from workbench.study.crash.meetings import environment_meetings, own_meetings
from workbench.study.crash.signals import signal_of
from workbench.study.crash.verdicts import crash_verdict
from workbench.study.motions import MotionOptions, load_motion
from workbench.study.provenance import hashes, versions
from workbench.study.simulation import bearing, seated_environment
from workbench.study.subject import subject_body
from workbench.study.warnings import enclosure_warnings

__all__ = ["crash_ready", "crash_study"]

_LOOKS = 16
"""Frames in which the surroundings are searched for open parts that enclose the person."""


def crash_study(plan: CrashPlan) -> CrashResult:
    """Run a crash study. InputError for motions that cannot be read, or that have no time in
    common."""
    study = crash_ready(plan)
    found = _found(study)
    other = _found(study.held) if study.held is not None else None
    return replace(found, agreements=_agreements(study), other=other)


def _found(study: CrashStudy) -> CrashResult:
    """What is found of the study's own motion."""
    body = study.body
    motion = study.motion
    environment = study.environment
    found = episodes(body, motion, environment)
    own = self_episodes(body, motion)
    frames = frames_of(study)
    pairs = ruled_pairs(study)
    signals = tuple(
        signal_of(motion.clock, path, point, study)
        for path, point in zip(frames.paths, study.points, strict=True)
    )
    meetings = (*with_forces(study, environment_meetings(study, found)), *own_meetings(study, own))
    result = CrashResult(
        study=study,
        episodes=found,
        meetings=tuple(sorted(meetings, key=lambda m: m.enter)),
        breaches=stop_breaches(body, motion),
        signals=signals,
        clearance=frames.clearance,
        agreements=(),
        verdicts=(),
        provenance={"inputs": hashes(study.inputs), "versions": versions()},
        warnings=(
            *frames.coarse,
            *piece_warnings([(study.person, body)]),
            *_enclosed(study),
            *study.warnings,
        ),
        forces=(*belt_tensions(study), *force_curves(study, pairs, frames.gaps)),
    )
    return replace(
        result, verdicts=tuple(crash_verdict(c, result, frames.excursions) for c in study.criteria)
    )


def _enclosed(study: CrashStudy) -> tuple[str, ...]:
    """Open parts that enclose the person in any of a few frames, spread over the motion."""
    if not study.environment.undecided:
        return ()
    times = study.motion.clock[:: max(len(study.motion) // _LOOKS, 1)]
    placed = place(study.body, poses_at(study.motion, times))
    return tuple(enclosure_warnings(study.person, placed, study.environment))


def crash_ready(plan: CrashPlan) -> CrashStudy:
    """The study of a plan, its motions read. InputError for a motion that cannot be read or is a
    single frame."""
    file = plan.file
    how = _options(plan.motion[1])
    body, sized = (
        subject_body(plan.body, plan.motion[0], options=how)
        if plan.motion[1].scale == "subject"
        else (plan.body, ())
    )
    motion, notes = load_motion(body, plan.motion[0], options=how)
    if len(motion) < 2:
        raise InputError(f"{plan.motion[0]}: one frame is a posture; a motion needs two or more")
    study = CrashStudy(
        name=file.study,
        kind=file.kind,
        title=file.title or file.study,
        description=file.description,
        environment=plan.environment,
        cabin=plan.environment,
        person=file.person,
        body=body,
        motion=motion,
        against=None,
        against_name="",
        points=plan.points,
        cfc=file.filter_class,
        rules=file.rules or "",
        limits=plan.limits,
        criteria=plan.criteria,
        inputs=plan.inputs,
        film=file.film,
        motion_name=plan.motion[1].name,
        warnings=(*sized, *notes, *plan.environment.warnings),
    )
    if plan.against is None:
        return _restrained(study, plan.restraints, file)
    against, more = load_motion(body, plan.against[0], options=_options(plan.against[1]))
    name = plan.against[1].name or plan.against[0].stem
    other = _restrained(replace(study, motion=against, warnings=more), plan.other_restraints, file)
    known = tuple(note for note in more if note not in study.warnings)
    study = replace(
        study, against=against, against_name=name, held=other, warnings=(*study.warnings, *known)
    )
    return _restrained(study, plan.restraints, file)


def _restrained(study: CrashStudy, restraints: Restraints, file: CrashFile) -> CrashStudy:
    """The study with its seat adjusted, airbags and belts as parts, and the laws of contact."""
    plan = restraints.simulation
    cabin = study.cabin if plan is None else seated_environment(plan, study.cabin)
    cabin = with_airbags(cabin, list(restraints.airbags))
    first = place(study.body, poses_at(study.motion, study.motion.clock[:1]))
    environment = with_belts(cabin, restraints.belts, first)
    return replace(
        study,
        cabin=cabin,
        environment=environment,
        belts=restraints.belts,
        pulse=restraints.pulse,
        forces=_without_belts(rules_of(file.forces, study.body, environment), len(cabin.parts)),
        bears=bearing(environment, restraints.names),
    )


def _without_belts(rules: tuple[ContactRule, ...], parts: int) -> tuple[ContactRule, ...]:
    """Laws of contact hold for what stands still: of a belt its tension is told, not the depth in
    where it was."""
    return tuple(
        replace(rule, parts=rule.parts & (np.arange(len(rule.parts)) < parts)) for rule in rules
    )


def _options(source: MotionSource) -> MotionOptions:
    start = -np.inf if source.start is None else source.start
    keep = Pick(start, np.inf if source.end is None else source.end, source.every)
    return MotionOptions(
        source.map, source.up, source.unit, keep, source.gaps, source.move, source.yaw
    )


def _agreements(study: CrashStudy) -> tuple[Agreement, ...]:
    """Each joint and segment of the motion against the other's, at the motion's frames within the
    time of both."""
    if study.against is None:
        return ()
    time = study.motion.clock
    other = study.against.clock
    both = (time >= other[0]) & (time <= other[-1])
    if not both.any():
        raise InputError(
            f"the motions have no time in common: {time[0]:g} to {time[-1]:g} s and {other[0]:g} to "
            f"{other[-1]:g} s"
        )
    body = study.body
    shared = time[both]
    names = (*body.segment_names, *(f"{name} joint" for name in body.joint_names))
    squares = np.zeros(len(names))
    peak = np.full(len(names), -1.0)
    at = np.zeros(len(names))
    for rows in pieces(len(shared), size=BLOCK):
        one, two = (
            _points(body, poses_at(poses, shared[rows])) for poses in (study.motion, study.against)
        )
        apart = np.linalg.norm(one - two, axis=2)
        squares += (apart**2).sum(axis=0)
        worst = np.argmax(apart, axis=0)
        here = np.take_along_axis(apart, worst[None], axis=0)[0]
        more = here > peak
        peak[more] = here[more]
        at[more] = shared[rows][worst[more]]
    rms = np.sqrt(squares / len(shared))
    return tuple(
        Agreement(*row) for row in zip(names, rms.tolist(), peak.tolist(), at.tolist(), strict=True)
    )


def _points(body: Body, poses: Poses) -> Floats:
    """(P, N + J, 3) [m] centres of gravity of the segments, then the joints."""
    world = place(body, poses).world_from_segment
    joints = (
        np.einsum("pjik,jk->pji", world[:, 1:, :, :3], body.joint_in_child[0]) + world[:, 1:, :, 3]
    )
    return np.concatenate([world[..., 3], joints], axis=1)
