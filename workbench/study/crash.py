"""The crash study: a motion against an environment, in continuous time: what meets what, when, how fast, how deep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.files.crash_schema import MotionSource
from workbench.files.crash_studies import CrashPlan
from workbench.files.motions.lines import Pick
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.crash import Agreement, CrashResult, CrashStudy, StopBreach
from workbench.model.environment import Environment
from workbench.model.moving import poses_at
from workbench.model.poses import Placed, Poses
from workbench.solve.collide import allowed_depth, clearance
from workbench.solve.episodes import episodes, self_episodes
from workbench.solve.forward import place
from workbench.solve.stops import stops
from workbench.study.crash_signals import signal_of
from workbench.study.crash_verdicts import crash_verdict
from workbench.study.meetings import environment_meetings, own_meetings
from workbench.study.motions import MotionOptions, load_motion
from workbench.study.provenance import hashes, versions

__all__ = ["crash_ready", "crash_study"]

_PAST = np.radians(0.1)
_BLOCK = 256


def crash_study(plan: CrashPlan) -> CrashResult:
    """Run a crash study. InputError for motions that cannot be read, or that have no time in common."""
    study = crash_ready(plan)
    body, motion, environment = study.body, study.motion, study.environment
    found, own = episodes(body, motion, environment), self_episodes(body, motion)
    placed = place(body, motion)
    signals = tuple(signal_of(placed, motion, point, study) for point in study.points)
    result = CrashResult(
        study=study,
        episodes=found,
        meetings=tuple(sorted((*environment_meetings(study, found), *own_meetings(study, own)), key=lambda m: m.enter)),
        breaches=_breaches(body, motion),
        signals=signals,
        clearance=_clearance(placed, environment),
        agreements=_agreements(study),
        verdicts=(),
        provenance={"inputs": hashes(study.inputs), "versions": versions()},
        warnings=(*_coarse(placed, motion), *study.warnings),
    )
    return replace(result, verdicts=tuple(crash_verdict(c, result, placed) for c in study.criteria))


def crash_ready(plan: CrashPlan) -> CrashStudy:
    """The study of a plan, its motions read. InputError for a motion that cannot be read or is a single frame."""
    file = plan.file
    motion, notes = load_motion(plan.body, plan.motion[0], options=_options(plan.motion[1]))
    if len(motion) < 2:
        raise InputError(f"{plan.motion[0]}: one frame is a posture; a motion needs two or more")
    against, more = (None, ()) if plan.against is None else \
        load_motion(plan.body, plan.against[0], options=_options(plan.against[1]))  # fmt: skip
    return CrashStudy(
        name=file.study,
        kind=file.kind,
        title=file.title or file.study,
        description=file.description,
        environment=plan.environment,
        person=file.person,
        body=plan.body,
        motion=motion,
        against=against,
        against_name="" if plan.against is None else plan.against[1].name or plan.against[0].stem,
        points=plan.points,
        cfc=file.filter_class,
        rules=file.rules or "",
        limits=plan.limits,
        criteria=plan.criteria,
        inputs=plan.inputs,
        warnings=(*notes, *more, *plan.environment.warnings),
    )


def _options(source: MotionSource) -> MotionOptions:
    start = -np.inf if source.start is None else source.start
    keep = Pick(start, np.inf if source.end is None else source.end, source.every)
    return MotionOptions(source.map, source.up, source.unit, keep, source.gaps, source.move, source.yaw)


def _breaches(body: Body, motion: Poses) -> tuple[StopBreach, ...]:
    """Spells of each joint past its stop, at the frames."""
    margins = stops(body, motion)
    time = motion.clock
    told = []
    for j, joint in enumerate(body.joints):
        past = np.concatenate([[False], margins.margin[:, j] < -_PAST, [False]])
        edges = np.flatnonzero(past[1:] != past[:-1])
        for first, after in zip(edges[0::2], edges[1::2], strict=True):
            worst = int(first + np.argmin(margins.margin[first:after, j]))
            told.append(StopBreach(joint, margins.motion(worst, j), float(time[first]), float(time[after - 1]),
                                   float(time[worst]), float(-margins.margin[worst, j])))  # fmt: skip
    return tuple(sorted(told, key=lambda breach: (breach.begin, breach.joint)))


def _clearance(placed: Placed, environment: Environment) -> Floats:
    """(P, N) [m] of each segment at each frame, from all it meets, allowances given back; infinite where nothing is."""
    allowed = allowed_depth(placed.body, environment)
    rows = []
    for first in range(0, len(placed), _BLOCK):
        some = slice(first, first + _BLOCK)
        block = Placed(placed.body, placed.world_from_segment[some], placed.centres[some], placed.window)
        apart = clearance(block, environment) + allowed
        rows.append(apart.min(axis=2, initial=np.inf))
    return np.concatenate(rows)


def _coarse(placed: Placed, motion: Poses) -> tuple[str, ...]:
    """A word where spheres move more than their radius between frames: true motion may differ much from the straight
    way between."""
    step = np.linalg.norm(np.diff(placed.centres, axis=0), axis=-1) / placed.body.radius
    if not step.size or step.max() <= 1.0:
        return ()
    frame, sphere = np.unravel_index(int(np.argmax(step)), step.shape)
    name = placed.body.segment_names[int(placed.body.sphere_segment[sphere])]
    many = int((step.max(axis=1) > 1.0).sum())
    return (f"the motion is coarse: between {many} of {len(step)} pairs of frames some sphere moves more than its own "
            f"radius, a sphere of the {name} {step[frame, sphere]:.1f} radii at {motion.clock[frame]:g} s; what lies "
            "between is taken as the shortest way",)  # fmt: skip


def _agreements(study: CrashStudy) -> tuple[Agreement, ...]:
    """Each joint and segment of the motion against the other's, at the motion's frames within the time of both."""
    if study.against is None:
        return ()
    time, other = study.motion.clock, study.against.clock
    both = (time >= other[0]) & (time <= other[-1])
    if not both.any():
        raise InputError(f"the motions have no time in common: {time[0]:g} to {time[-1]:g} s and {other[0]:g} to "
                         f"{other[-1]:g} s")  # fmt: skip
    body, shared = study.body, time[both]
    pair = [place(body, poses_at(poses, shared)).world_from_segment for poses in (study.motion, study.against)]
    rows = []
    for n, name in enumerate(body.segment_names):
        rows.append(_agreement(name, [world[:, n, :, 3] for world in pair], shared))
    for j, name in enumerate(body.joint_names):
        at = [world[:, j + 1, :, :3] @ body.joint_in_child[j] + world[:, j + 1, :, 3] for world in pair]
        rows.append(_agreement(f"{name} joint", at, shared))
    return tuple(rows)


def _agreement(name: str, points: list[Floats], time: Floats) -> Agreement:
    apart = np.linalg.norm(points[0] - points[1], axis=1)
    worst = int(np.argmax(apart))
    return Agreement(name, float(np.sqrt(np.mean(apart**2))), float(apart[worst]), float(time[worst]))
