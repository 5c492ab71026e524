"""The actions of a study: what each role does in each case, from names to poses and files."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.catalogue import is_file
from workbench.files.crash.restraints import (
    airbag_faults,
    airbags_of,
    belt_faults,
    belts_of,
    pulse_of,
)
from workbench.files.crash.simulation_schema import PulseFile
from workbench.files.crash.simulations import SimulationPlan, load_simulation, simulation_path
from workbench.files.postures import (
    AnglesFile,
    PosturesFile,
    flat_angles,
    posture_pose,
    replaced_angles,
)
from workbench.files.study.roles import LoadedRole
from workbench.files.study.schema import (
    ActionFile,
    DriverFile,
    MotionFile,
    PredictedFile,
    RoleFile,
    SidesFile,
    StatedRestraintsFile,
    StudyPostureFile,
)
from workbench.files.study.work import Key, Work
from workbench.model.driving import DrivingAims
from workbench.model.environment import Environment
from workbench.model.joint_angles import attitude_matrix
from workbench.model.poses import Poses
from workbench.model.simulation import Pulse, Restraints
from workbench.model.study import (
    Action,
    GivenPosture,
    PredictedPosture,
    RecordedMotion,
    SimulatedMotion,
)
from workbench.model.workplace import PostureGoals

__all__ = ["CaseActions", "aims_of", "case_actions", "library_of", "load_actions", "with_postures"]

STANDS_LIKE = "standing"
"""The posture that the prediction of somebody who stands begins from, where none is stated."""

_HANDS = {"LHN": "left hand", "RHN": "right hand"}
_IN_LAP = "hands_in_lap"
"""The posture of a body whose hands rest on the thighs, where it has one."""

CaseActions = dict[tuple[int, str], Action]
"""The actions that could be loaded, by the row of their case and the role."""


@dataclass(frozen=True, eq=False)
class _Asked:
    """An action as the file has it: where it stands, whose it is."""

    key: Key
    name: str
    role: LoadedRole
    file: ActionFile


def with_postures(work: Work, roles: dict[str, LoadedRole]) -> dict[str, LoadedRole]:
    """The roles with the study's own postures beside those of their bodies."""
    used: dict[str, set[str]] = {}
    for _, case in work.parts.cases:
        for name, action in case.actions.items():
            if action is not None:
                used.setdefault(_posture_name(action), set()).add(name)
    found = dict(roles)
    for name, posture in work.parts.postures.items():
        if posture is None:
            continue
        # a posture that nobody uses is checked with the first body
        users = [role for role in roles if role in used.get(name, set())] or list(roles)[:1]
        for user in users:
            found[user] = _with_posture(work, found[user], name, posture)
    return found


def _with_posture(work: Work, role: LoadedRole, name: str, posture: StudyPostureFile) -> LoadedRole:
    """A role with a posture of the study beside those of its body; as it is where that has a
    fault."""
    base = role.postures
    if base is None or not _is_posture(work, role, base, name, posture):
        return role
    made = replaced_angles(role.body, base.postures[posture.like], posture.angles)
    postures = base.model_copy(update={"postures": {**base.postures, name: made}})
    return replace(role, postures=postures)


def _is_posture(
    work: Work, role: LoadedRole, base: PosturesFile, name: str, posture: StudyPostureFile
) -> bool:
    """Whether a posture of the study can be made from those of a body; reports why not."""
    key = ("postures", name)
    body = role.body
    if name in base.postures:
        what = f"body {body.name} has a posture {name!r} of its own; give it another name"
        work.fault(key, what)
        return False
    own = [known for known in base.postures if known not in work.parts.postures]
    what = f"body {body.name} has no posture {posture.like!r}"
    if not work.check_name((*key, "like"), posture.like, own, what):
        return False
    problems = flat_angles(body, posture.angles)[1]
    for path, what in problems:
        work.fault((*key, "angles", *path), what)
    return not problems


def _posture_name(action: ActionFile) -> str:
    """The posture that an action begins from, "" for a recorded motion."""
    if action.posture is not None:
        return action.posture
    if action.predicted is not None:
        return action.predicted.like
    if action.driver is not None:
        return action.driver.like
    return action.simulated.start if action.simulated is not None else ""


def case_actions(
    work: Work, roles: dict[str, LoadedRole]
) -> Iterator[tuple[int, str, ActionFile, Key]]:
    """The actions of roles that could be loaded, with the row of their case and their key."""
    for row, case in work.parts.cases:
        for name, action in case.actions.items():
            if action is not None and name in roles:
                yield row, name, action, ("cases", row, "people", name)


def load_actions(work: Work, roles: dict[str, LoadedRole], room: Environment | None) -> CaseActions:
    """The actions that have no fault; faults go to the work."""
    found: CaseActions = {}
    for row, name, file, key in case_actions(work, roles):
        asked = _Asked(key, name, roles[name], file)
        before = len(work.faults)
        action: Action | None
        if file.posture is not None:
            action = _given(work, asked, room)
        elif file.motion is not None:
            action = _recorded(work, asked, room)
        elif file.simulated is not None:
            action = _simulated(work, asked, room)
        else:
            action = _predicted(work, asked, room)
        if action is not None and len(work.faults) == before:
            found[row, name] = action
    return found


def _named(work: Work, asked: _Asked, at: Key, name: str) -> PosturesFile | None:
    """The postures of a role, among which there is one of this name."""
    postures = asked.role.postures
    if postures is None:
        body = asked.role.body.name
        what = f"body {body!r} names no postures file, so no posture can be named in this study"
        work.fault(("people", asked.name, "body"), what)
        return None
    if name not in postures.postures:
        if name in work.parts.postures or not postures.postures:
            return None  # reported where the posture stands, or where the postures' file is wrong
        what = f"no posture {name!r}; {one_of(name, postures.postures)}"
        work.fault((*asked.key, *at), what)
        return None
    return postures


def _pose(role: LoadedRole, postures: PosturesFile, name: str, more: AnglesFile) -> Poses:
    """One pose in a posture with some angles replaced, put where the role is at a place."""
    file = role.file
    body = role.body
    attitude = file.at.attitude if file.at else None
    poses = posture_pose(body, postures, name, more=more, attitude=attitude)
    world = poses.world_from_reference.copy()
    if file.at is not None and file.at.segment in body.segments:
        world[:, :, 3] = file.at.position
        return Poses(poses.rotations, body.segment(file.at.segment), world)
    if file.stand is not None:
        turn = attitude_matrix(yaw=math.radians(file.stand.yaw))
        world[:, :, :3] = np.einsum("ij,pjk->pik", turn, world[:, :, :3])
    return Poses(poses.rotations, poses.reference, world)


def library_of(work: Work, role: LoadedRole) -> dict[str, Poses]:
    """A pose in each posture that a role can be given: the body's, and those of the study that fit
    it."""
    postures = role.postures
    if postures is None:
        return {}
    for name, posture in work.parts.postures.items():
        known = postures.postures
        if posture is not None and name not in known and posture.like in known:
            if flat_angles(role.body, posture.angles)[1]:
                continue
            made = replaced_angles(role.body, known[posture.like], posture.angles)
            postures = postures.model_copy(update={"postures": {**known, name: made}})
    return {name: _pose(role, postures, name, {}) for name in postures.postures}


def _given(work: Work, asked: _Asked, room: Environment | None) -> GivenPosture | None:
    name = asked.file.posture or ""
    hands: dict[str, str] = {}
    if asked.file.hands is not None:
        for limb, control, place in _sides(asked.file.hands, "hands", "hand"):
            hands[limb] = control
            if room is not None:
                _control_fault(work, room, limb, control, (*asked.key, *place))
    postures = _named(work, asked, ("posture",), name)
    problems = flat_angles(asked.role.body, asked.file.angles or {})[1]
    for path, what in problems:
        work.fault((*asked.key, "angles", *path), what)
    if postures is None or problems:
        return None
    return GivenPosture(name, _pose(asked.role, postures, name, asked.file.angles or {}), hands)


def aims_of(file: PredictedFile | DriverFile) -> PostureGoals:
    """What a posture is predicted from."""
    held = {limb: control for limb, control, _ in _held(file)}
    driving = None
    if isinstance(file, DriverFile):
        driving = DrivingAims(file.sex or "", file.age, file.seed, file.wheel, file.h_point)
    return PostureGoals(held, file.eyes, file.heels, driving)


def _predicted(work: Work, asked: _Asked, room: Environment | None) -> PredictedPosture | None:
    """The posture that is predicted of a role, or of a driver; None where it cannot be."""
    file = asked.file.driver or asked.file.predicted
    assert file is not None
    key = (*asked.key, asked.file.kind)
    role = asked.role.file
    if role.at is not None:
        what = (
            "only the posture of somebody in a seat, or who stands, is predicted; give the role a "
            "'seat' or 'stand', or the case a 'posture'"
        )
        work.fault(key, what)
    if role.stand is not None:
        _standing_faults(work, key, file)
    if isinstance(file, DriverFile):
        _sex_faults(work, key, file, role)
    if room is not None:
        _aim_faults(work, file, key, room)
    stated = "like" in file.model_fields_set or role.stand is None
    like = file.like if stated else STANDS_LIKE
    postures = _named(work, asked, (asked.file.kind, "like"), like)
    if postures is None:
        return None
    if role.seat is not None and "like" not in file.model_fields_set:
        _idle_note(work, asked, file.hands, like, postures)
    return PredictedPosture(like, _pose(asked.role, postures, like, {}), aims_of(file))


def _idle_note(
    work: Work, asked: _Asked, hands: SidesFile, like: str, postures: PosturesFile
) -> None:
    """Say that a hand without a control stays where the posture that is taken has it."""
    gone = {_HANDS.get(name) for name in asked.role.file.without} | set(hands.held("hand"))
    idle = [limb for limb in _HANDS.values() if limb not in gone]
    if not idle:
        return
    case = next(case.name for row, case in work.parts.cases if row == asked.key[1])
    lap = "; 'like: hands_in_lap' lays them in the lap" if _IN_LAP in postures.postures else ""
    arms = "both arms stay" if len(idle) > 1 else "that arm stays"
    work.notes.append(
        f"{asked.name}, {case}: no control is stated for the {' and the '.join(idle)}, so {arms} "
        f"as in the posture {like!r}, whatever is in the way: 'hands' says what is held{lap}"
    )


def _standing_faults(work: Work, key: Key, file: PredictedFile | DriverFile) -> None:
    """Report what is not predicted of somebody who stands."""
    if isinstance(file, DriverFile):
        work.fault(key, "a driver sits; give the role a 'seat'")
        return
    for field in sorted(file.model_fields_set & {"feet", "eyes", "heels"}):
        what = (
            f"of somebody who stands the hands are predicted; the feet step within the 'area' of "
            f"'stand': leave {field!r} out"
        )
        work.fault((*key, field), what)
    if not file.hands.left and not file.hands.right:
        work.fault(key, "it says of nobody's hands where they go; give 'hands', or a 'posture'")


def _sex_faults(work: Work, key: Key, file: DriverFile, role: RoleFile) -> None:
    """Report a driver whose sex is stated twice, or not at all."""
    many = role.population is not None
    if many and file.sex is not None:
        what = "the sex of each driver is that of the person in the population; leave it out"
        work.fault((*key, "sex"), what)
    if not many and file.sex is None and role.size is None and role.sizes is None:
        what = "it is not stated whether a man or a woman drives: give 'sex', or the role a 'size'"
        work.fault(key, what)


def _aim_faults(work: Work, file: PredictedFile | DriverFile, key: Key, room: Environment) -> None:
    """Report controls and points that are not there, hands on pedals and feet on knobs."""
    for limb, control, place in _held(file):
        _control_fault(work, room, limb, control, (*key, *place))
    for field in ("eyes", "heels", "wheel", "h_point"):
        point = getattr(file, field, None)
        if point is not None:
            what = f"environment {room.name} has no point {point!r}"
            work.check_name((*key, field), point, room.points, what)


def _control_fault(work: Work, room: Environment, limb: str, control: str, where: Key) -> None:
    """Report a control that is not there, or is for feet where a hand is to hold it and the other
    way round."""
    controls = {one.name: one for one in room.controls}
    what = f"environment {room.name} has no control {control!r}"
    if work.check_name(where, control, controls, what):
        meant = controls[control].limbs
        if not controls[control].is_for(limb):
            work.fault(where, f"{control} is for {meant}; name it under '{meant}'")


def _held(file: PredictedFile | DriverFile) -> Iterator[tuple[str, str, tuple[str, str]]]:
    """Limb, control and where in the action it stands, feet first."""
    for field, kind in (("feet", "foot"), ("hands", "hand")):
        yield from _sides(getattr(file, field), field, kind)


def _sides(file: SidesFile, field: str, kind: str) -> Iterator[tuple[str, str, tuple[str, str]]]:
    """Limb, control and where it stands, the left one first."""
    for limb, control in file.held(kind).items():
        yield limb, control, (field, limb.split()[0])


def _recorded(work: Work, asked: _Asked, room: Environment | None) -> RecordedMotion | None:
    """The recorded motion of a role; None where the environment could not be loaded."""
    file = asked.file.motion
    assert file is not None
    path = _motion_path(work, asked, file)
    if file.start is not None and file.end is not None and file.start >= file.end:
        what = f"end {file.end:g} s must be after start {file.start:g} s"
        work.fault((*asked.key, "motion", "end"), what)
    if room is None:
        return None
    return RecordedMotion(
        file=path,
        begin=-math.inf if file.start is None else file.start,
        end=math.inf if file.end is None else file.end,
        every=file.every,
        names=file.map,
        up=file.up,
        metres=file.unit,
        gaps=file.gaps,
        as_read=file.frames == "as_read",
        move=file.move,
        yaw=file.yaw,
        subject=file.scale == "subject",
        restraints=_restraints(work, asked, file, room),
    )


def _motion_path(work: Work, asked: _Asked, file: MotionFile) -> Path:
    """The path of a motion file beside the study; reports one that is not there."""
    near = work.path.parent
    path = near / file.file
    if not is_file(path):
        what = f"no such file {file.file!r} in {near}; motions are looked for beside the study"
        work.fault((*asked.key, "motion", "file"), what)
    else:
        case = next(case.name for row, case in work.parts.cases if row == asked.key[1])
        work.inputs[f"motion of {asked.name}, {case}"] = path
    return path


def _restraints(work: Work, asked: _Asked, file: MotionFile, room: Environment) -> Restraints:
    key = (*asked.key, "motion", "restraints")
    if file.restraints is None:
        return Restraints()
    if isinstance(file.restraints, StatedRestraintsFile):
        return _stated(work, asked, file.restraints, room)
    plan = _plan(work, asked, key, file.restraints, room)
    return restraints_of_plan(plan) if plan is not None else Restraints()


def restraints_of_plan(plan: SimulationPlan) -> Restraints:
    """The restraints of a simulation, with its seat where its occupant has put it."""
    adjust = plan.file.adjust
    moved = adjust is not None and plan.file.seat is not None
    return Restraints(
        plan.pulse,
        plan.belts,
        airbags_of(plan.file.airbags),
        plan.file.seat or "" if moved else "",
        adjust.forward if adjust else 0.0,
        adjust.up if adjust else 0.0,
    )


def _plan(
    work: Work, asked: _Asked, key: Key, name: str, room: Environment
) -> SimulationPlan | None:
    """A simulation in the same environment and of the same body."""
    try:
        plan = load_simulation(name, near=work.path.parent, known=work.environments)
    except InputError as error:
        work.errors(key, error)
        return None
    wrong = [
        f"it is in {what} {theirs!r}, this study in {ours!r}; name a simulation of the same {what}"
        for what, theirs, ours in (
            ("environment", plan.environment.name, room.name),
            ("body", plan.body.name, asked.role.body.name),
        )
        if theirs != ours
    ]
    for what in wrong:
        work.fault(key, what)
    work.inputs |= {
        f"{role}: {name}": path
        for role, path in plan.inputs.items()
        if role in ("simulation", "pulse")
    }
    return None if wrong else plan


def _stated(work: Work, asked: _Asked, file: StatedRestraintsFile, room: Environment) -> Restraints:
    """The restraints that a motion states itself; none where they have a fault."""
    key = (*asked.key, "motion", "restraints")
    body = asked.role.body
    anchors = {**room.points, **file.anchors}
    taken = [*room.parts, *(bag.name for bag in file.airbags)]
    where = (*key, "belts")
    faults = airbag_faults(work.document, file.airbags, room.parts, (*key, "airbags"))
    faults += belt_faults(work.document, file.belts, body, anchors=anchors, taken=taken, key=where)
    work.add(faults)
    pulse = _pulse(work, (*key, "pulse"), file.pulse) if file.pulse is not None else None
    if faults:
        return Restraints()
    return Restraints(pulse, belts_of(file.belts, body, anchors), airbags_of(file.airbags))


def _pulse(work: Work, key: Key, file: PulseFile) -> Pulse | None:
    """The pulse that stands at a key; None, and its faults, where its table cannot be read."""
    folder = work.path.parent
    if file.file is not None:
        work.inputs[f"pulse: {file.file}"] = folder / file.file
    try:
        return pulse_of(file, folder)
    except InputError as error:
        work.errors(key, error)
        return None


def _simulated(work: Work, asked: _Asked, room: Environment | None) -> SimulatedMotion | None:
    file = asked.file.simulated
    assert file is not None
    key = (*asked.key, "simulated")
    postures = _named(work, asked, ("simulated", "start"), file.start)
    if room is None:
        return None
    plan = _plan(work, asked, (*key, "simulation"), file.simulation, room)
    if plan is None or postures is None:
        return None
    path = simulation_path(file.simulation, near=work.path.parent)
    return SimulatedMotion(
        Path(path),
        file.start,
        _pose(asked.role, postures, file.start, {}),
        restraints_of_plan(plan),
    )
