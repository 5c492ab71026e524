"""Simulations: everything they name is loaded and checked; the occupant is placed by who runs
them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
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
from workbench.files.schema import fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body, segment_words
from workbench.model.environment import Allowance, Environment
from workbench.model.joined import joined
from workbench.model.poses import Poses
from workbench.model.pulse import Pulse
from workbench.model.simulation import Airbag, Belt, ContactRule, JointRule

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


def load_simulation(source: str | Path, *, near: Path | None = None) -> SimulationPlan:
    """Load a simulation by catalogue name or path. InputError lists every fault with its line."""
    path = simulation_path(source, near=near)
    document = read_yaml(path)
    file = validate(document, SimulationFile)
    inputs = {"simulation": path}
    faults = list[str]()
    environment, body = _loaded(document, file, (inputs, faults))
    pulse = _pulse(document, file, (inputs, faults))
    if environment is None or body is None:
        raise InputError(faults)
    faults += airbag_faults(document, file.airbags, environment.parts)
    anchors = {**environment.points, **file.anchors}
    parts = [*environment.parts, *(bag.name for bag in file.airbags)]
    faults += belt_faults(document, file.belts, (body, anchors, parts))
    laws = [(("contact", row), rule) for row, rule in enumerate(file.contact)]
    faults += contact_faults(document, laws, (body, parts))
    faults += _joint_faults(document, file, body) + _place_faults(
        document, file, (environment, body)
    )
    poses, more = _poses(document, file, (body, inputs))
    faults += more
    if faults or pulse is None or poses is None:
        raise InputError(faults)
    environment = with_airbags(environment, airbags_of(file.airbags))
    joints = tuple(
        JointRule(tuple(body.joint(j) for j in row.joints), row.stiffness, row.damping)
        for row in file.joints
    )
    return SimulationPlan(
        file,
        environment,
        body,
        poses,
        pulse,
        belts_of(file.belts, body, anchors),
        rules_of(file.contact, body, environment),
        joints,
        inputs,
    )


def with_airbags(environment: Environment, bags: Sequence[Airbag]) -> Environment:
    """The environment with its airbags as closed parts that every segment may go into."""
    if not bags:
        return environment
    made, _ = build_environment(
        "airbags", [airbag_part(bag) for bag in bags], solid=[True] * len(bags)
    )
    allowed = tuple(Allowance(k, ("all",), bag.allow) for k, bag in enumerate(bags))
    return joined(
        environment,
        replace(made, allowances=allowed, see_through=np.ones(len(bags), dtype=np.bool_)),
    )


Work = tuple[dict[str, Path], list[str]]


def _loaded(
    document: Document, file: SimulationFile, work: Work
) -> tuple[Environment | None, Body | None]:
    inputs, faults = work
    near = Path(document.file).parent
    near = (
        near.parent if near.name == _FOLDER else near
    )  # the catalogue is beside studies/, not beside this folder
    environment = body = None
    try:
        source = find("environments", file.environment, "environment.yaml", near=near)
        environment = load_environment(source)
        inputs |= {
            f"environment: {p.relative_to(source.parent)}": p for p in environment_files(source)
        }
    except InputError as error:
        faults += [fail(document, ("environment",), problem) for problem in error.problems]
    try:
        where = body_path(file.body, near=near)
        body = load_body(where)
        inputs["body"] = where
    except InputError as error:
        faults += [fail(document, ("body",), problem) for problem in error.problems]
    return environment, body


def _pulse(document: Document, file: SimulationFile, work: Work) -> Pulse | None:
    inputs, faults = work
    folder = Path(document.file).parent
    if file.pulse.file is not None:
        inputs["pulse"] = folder / file.pulse.file
    try:
        return pulse_of(file.pulse, folder)
    except InputError as error:
        faults += [fail(document, ("pulse",), problem) for problem in error.problems]
        return None


def _joint_faults(document: Document, file: SimulationFile, body: Body) -> list[str]:
    named = [
        (("joints", row, "joints", place), name)
        for row, rule in enumerate(file.joints)
        for place, name in enumerate(rule.joints)
    ]
    named += [(("relaxed", place), name) for place, name in enumerate(file.relaxed)]  # type: ignore[misc]
    return [
        fail(document, key, f"body {body.name} has no joint {name!r}; {one_of(name, body.joints)}")
        for key, name in named
        if name not in body.joints
    ]


def _place_faults(
    document: Document, file: SimulationFile, known: tuple[Environment, Body]
) -> list[str]:
    environment, body = known
    if file.at is not None and file.at.segment not in body.segments:
        hint = one_of(file.at.segment, body.segments, words=segment_words(body))
        return [fail(document, ("at", "segment"), f"unknown segment {file.at.segment!r}; {hint}")]
    if file.seat is None:
        return []
    seats = {seat.name: seat for seat in environment.seats}
    if file.seat not in seats:
        return [
            fail(
                document,
                ("seat",),
                f"environment {environment.name} has no seat {file.seat!r}; "
                f"{one_of(file.seat, seats)}",
            )
        ]
    faults = []
    seat = seats[file.seat]
    for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
        value = getattr(file.adjust, way, 0.0)
        if not low - 1e-9 <= value <= high + 1e-9:
            what = f"beyond the travel of seat {seat.name}, {1000 * low:g} to {1000 * high:g} mm"
            faults.append(fail(document, ("adjust", way), f"{what} (got {1000 * value:g} mm)"))
    return faults


def _poses(
    document: Document, file: SimulationFile, known: tuple[Body, dict[str, Path]]
) -> tuple[Poses | None, list[str]]:
    """The posture, at `at` where that is given, and what is wrong with it."""
    body, inputs = known
    path = posture_path(inputs["body"])
    if path is None:
        return None, [fail(document, ("posture",), f"body {body.name} names no postures file")]
    postures, _ = load_postures(path, body)
    inputs["postures"] = path
    faults = [
        fail(document, ("angles", *key), what) for key, what in flat_angles(body, file.angles)[1]
    ]
    if file.posture not in postures.postures:
        what = f"no posture {file.posture!r}; {one_of(file.posture, postures.postures)}"
        faults.append(fail(document, ("posture",), what))
    if faults:
        return None, faults
    attitude = file.at.attitude if file.at else None
    poses = posture_pose(body, postures, file.posture, more=file.angles, attitude=attitude)
    if file.at is None or file.at.segment not in body.segments:
        return poses, []
    world = poses.world_from_reference.copy()
    world[:, :, 3] = file.at.position
    return Poses(poses.rotations, body.segment(file.at.segment), world), []
