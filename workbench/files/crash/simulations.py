"""Simulations: everything they name is loaded and checked; the occupant is placed by who runs
them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.body.bodies import body_path, load_body
from workbench.files.catalogue import find
from workbench.files.crash.restraints import (
    airbag_faults,
    airbag_part,
    airbags_of,
    belt_faults,
    belts_of,
    contact_faults,
    pulse_of,
    rules_of,
)
from workbench.files.crash.simulation_schema import SimulationFile
from workbench.files.environments import environment_files, load_environment
from workbench.files.meshes.assembly import build_environment
from workbench.files.postures import flat_angles, load_postures, posture_path, posture_pose
from workbench.files.schema import error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body, segment_words
from workbench.model.environment import Allowance, Environment, Seat
from workbench.model.poses import Poses
from workbench.model.simulation import Airbag, Belt, ContactRule, JointRule, Pulse
from workbench.model.surroundings import merge_environments

__all__ = ["SimulationPlan", "load_simulation", "simulation_path", "with_airbags"]


_FOLDER = "simulations"


@dataclass(frozen=True, eq=False)
class SimulationPlan:
    """A simulation as its file has it, with what it names. environment: with its airbags; poses:
    not yet seated."""

    file: SimulationFile
    environment: Environment
    body: Body
    poses: Poses
    pulse: Pulse
    belts: tuple[Belt, ...]
    rules: tuple[ContactRule, ...]
    joints: tuple[JointRule, ...]
    inputs: dict[str, Path]


def simulation_path(source: str | Path, *, near: Path | None = None) -> Path:
    """The file of a simulation, by catalogue name (studies/simulations) or path."""
    return find(f"studies/{_FOLDER}", str(source), near=near)


def load_simulation(
    source: str | Path,
    *,
    near: Path | None = None,
    known: Mapping[Path, Environment] | None = None,
) -> SimulationPlan:
    """Load a simulation by catalogue name or path. InputError lists every fault with its line.

    known: environments that are loaded already, by their files.
    """
    path = simulation_path(source, near=near)
    document = read_yaml(path)
    work = _Work(document, validate(document, SimulationFile), {"simulation": path})
    environment = _environment(work, known or {})
    body = _body(work)
    pulse = _pulse(work)
    if environment is None or body is None:
        raise InputError(work.faults)
    anchors = {**environment.points, **work.file.anchors}
    _restraint_faults(work, environment, body, anchors)
    _joint_faults(work, body)
    _place_faults(work, environment, body)
    poses = _poses(work, body)
    if work.faults or pulse is None or poses is None:
        raise InputError(work.faults)
    return _plan(work, with_airbags(environment, airbags_of(work.file.airbags)), body, poses, pulse)


def with_airbags(environment: Environment, bags: Sequence[Airbag]) -> Environment:
    """The environment with its airbags as closed parts that every segment may go into."""
    if not bags:
        return environment
    made, _ = build_environment(
        "airbags", [airbag_part(bag) for bag in bags], solid=[True] * len(bags)
    )
    allowed = tuple(Allowance(k, ("all",), bag.allow) for k, bag in enumerate(bags))
    return merge_environments(
        environment,
        replace(made, allowances=allowed, see_through=np.ones(len(bags), dtype=np.bool_)),
    )


@dataclass(frozen=True)
class _Work:
    """A simulation file that is being read.

    inputs: the files it names, by role; faults: the lines of what is wrong so far.
    """

    document: Document
    file: SimulationFile
    inputs: dict[str, Path]
    faults: list[str] = field(default_factory=list)

    def fault(self, key: tuple[str | int, ...], what: str) -> None:
        """Report a fault of the value at a key."""
        self.faults.append(error_at(self.document, key, what))

    def errors(self, key: tuple[str | int, ...], error: InputError) -> None:
        """Report the faults of something that is named at a key."""
        for problem in error.problems:
            self.fault(key, problem)

    @property
    def near(self) -> Path:
        """The folder beside which the catalogue is: that of studies/, not of studies/simulations."""
        folder = Path(self.document.file).parent
        return folder.parent if folder.name == _FOLDER else folder


def _environment(work: _Work, known: Mapping[Path, Environment]) -> Environment | None:
    """The environment that the file names; None, and its faults, where it cannot be loaded."""
    name = work.file.environment
    try:
        source = find("environments", name, "environment.yaml", near=work.near)
        environment = known[source] if source in known else load_environment(source)
    except InputError as error:
        work.errors(("environment",), error)
        return None
    for path in environment_files(source):
        work.inputs[f"environment: {path.relative_to(source.parent)}"] = path
    return environment


def _body(work: _Work) -> Body | None:
    """The body that the file names; None, and its faults, where it cannot be loaded."""
    try:
        source = body_path(work.file.body, near=work.near)
        body = load_body(source)
    except InputError as error:
        work.errors(("body",), error)
        return None
    work.inputs["body"] = source
    return body


def _pulse(work: _Work) -> Pulse | None:
    """The pulse of the file; None, and its faults, where its table cannot be read."""
    file = work.file.pulse
    folder = Path(work.document.file).parent
    if file.file is not None:
        work.inputs["pulse"] = folder / file.file
    try:
        return pulse_of(file, folder)
    except InputError as error:
        work.errors(("pulse",), error)
        return None


def _restraint_faults(
    work: _Work, environment: Environment, body: Body, anchors: Iterable[str]
) -> None:
    """Report faults of airbags, belts and contact laws."""
    document = work.document
    file = work.file
    parts = [*environment.parts, *(bag.name for bag in file.airbags)]
    laws = [(("contact", row), rule) for row, rule in enumerate(file.contact)]
    work.faults.extend(airbag_faults(document, file.airbags, environment.parts))
    work.faults.extend(belt_faults(document, file.belts, body, anchors=anchors, taken=parts))
    work.faults.extend(contact_faults(document, laws, body, parts))


def _joint_faults(work: _Work, body: Body) -> None:
    """Report joints that the body has not."""
    named: list[tuple[tuple[str | int, ...], str]] = [
        (("joints", row, "joints", place), name)
        for row, rule in enumerate(work.file.joints)
        for place, name in enumerate(rule.joints)
    ]
    named += [(("relaxed", place), name) for place, name in enumerate(work.file.relaxed)]
    for key, name in named:
        if name not in body.joints:
            what = f"body {body.name} has no joint {name!r}; {one_of(name, body.joints)}"
            work.fault(key, what)


def _place_faults(work: _Work, environment: Environment, body: Body) -> None:
    """Report a segment or a seat that is not there, and a seat moved beyond its travel."""
    file = work.file
    if file.at is not None and file.at.segment not in body.segments:
        hint = one_of(file.at.segment, body.segments, words=segment_words(body))
        work.fault(("at", "segment"), f"unknown segment {file.at.segment!r}; {hint}")
    elif file.seat is not None:
        seats = {seat.name: seat for seat in environment.seats}
        if file.seat in seats:
            _travel_faults(work, seats[file.seat])
        else:
            what = f"environment {environment.name} has no seat {file.seat!r}; "
            work.fault(("seat",), what + one_of(file.seat, seats))


def _travel_faults(work: _Work, seat: Seat) -> None:
    """Report a seat that is moved beyond its travel."""
    for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
        value = getattr(work.file.adjust, way, 0.0)
        if not low - 1e-9 <= value <= high + 1e-9:
            what = f"beyond the travel of seat {seat.name}, {1000 * low:g} to {1000 * high:g} mm"
            work.fault(("adjust", way), f"{what} (got {1000 * value:g} mm)")


def _poses(work: _Work, body: Body) -> Poses | None:
    """The posture, at `at` where that is given; None, and its faults, where it has any."""
    file = work.file
    path = posture_path(work.inputs["body"])
    if path is None:
        work.fault(("posture",), f"body {body.name} names no postures file")
        return None
    postures, _ = load_postures(path, body)
    work.inputs["postures"] = path
    problems = flat_angles(body, file.angles)[1]
    for key, what in problems:
        work.fault(("angles", *key), what)
    known = file.posture in postures.postures
    if not known:
        what = f"no posture {file.posture!r}; {one_of(file.posture, postures.postures)}"
        work.fault(("posture",), what)
    if problems or not known:
        return None
    attitude = file.at.attitude if file.at else None
    poses = posture_pose(body, postures, file.posture, more=file.angles, attitude=attitude)
    return _placed(poses, file, body)


def _placed(poses: Poses, file: SimulationFile, body: Body) -> Poses:
    """The poses with the segment that the file names at its place."""
    if file.at is None or file.at.segment not in body.segments:
        return poses
    world = poses.world_from_reference.copy()
    world[:, :, 3] = file.at.position
    return Poses(poses.rotations, body.segment(file.at.segment), world)


def _plan(
    work: _Work, environment: Environment, body: Body, poses: Poses, pulse: Pulse
) -> SimulationPlan:
    """The simulation of a file without faults, in an environment that has its airbags."""
    file = work.file
    return SimulationPlan(
        file=file,
        environment=environment,
        body=body,
        poses=poses,
        pulse=pulse,
        belts=belts_of(file.belts, body, {**environment.points, **file.anchors}),
        rules=rules_of(file.contact, body, environment),
        joints=tuple(
            JointRule(tuple(body.joint(j) for j in row.joints), row.stiffness, row.damping)
            for row in file.joints
        ),
        inputs=work.inputs,
    )
