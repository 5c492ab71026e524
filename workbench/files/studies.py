"""Study files: everything they name is loaded and checked, names become indices."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.bodies import body_path, load_body
from workbench.files.catalogue import find
from workbench.files.environments import environment_files, load_environment
from workbench.files.postures import PosturesFile, flat_angles, load_postures, posture_path, posture_pose
from workbench.files.schema import fail, validate
from workbench.files.study_schema import CriterionFile, PersonFile, StudyFile
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.posing import attitude_matrix, join_poses
from workbench.model.study import Criterion, Person, Study

__all__ = ["load_study"]

Loaded = tuple[Body, PosturesFile]


def load_study(source: str | Path) -> Study:
    """Load a study by catalogue name or path, with all it names.

    InputError lists every fault of the study file with its line, or the faults of a file it names.
    """
    path = find("studies", str(source))
    document = read_yaml(path)
    file = validate(document, StudyFile)
    environment = load_environment(file.environment, near=path.parent)
    inputs = {"study": path}
    inputs |= {f"environment {p.name}": p for p in environment_files(file.environment, near=path.parent)}
    bodies: dict[str, Loaded] = {}
    for name, person in file.people.items():
        postures = posture_path(person.body, near=path.parent)
        if postures is None:
            what = f"body {person.body!r} names no postures file, so no posture can be named here"
            raise InputError(fail(document, ("people", name, "body"), what))
        body = load_body(person.body, near=path.parent)
        bodies[name] = (body, load_postures(postures, body)[0])
        inputs[f"body {body.name}"] = body_path(person.body, near=path.parent)
        inputs[f"postures {postures.name}"] = postures
    faults = _people_faults(document, file, environment) + _case_faults(document, file, bodies)
    faults += [line for row, criterion in enumerate(file.criteria)
               for line in _criterion_faults(document, (row, criterion), (environment, bodies))]  # fmt: skip
    if faults:
        raise InputError(faults)
    return Study(
        name=file.study,
        kind=file.kind,
        title=file.title or file.study,
        description=file.description,
        environment=environment,
        people=tuple(_person(file, name, bodies[name]) for name in file.people),
        cases=tuple(case.name for case in file.cases),
        criteria=tuple(_criterion(file, row, (environment, bodies)) for row in file.criteria),
        inputs=inputs,
        warnings=environment.warnings,
    )


def _people_faults(document: Document, file: StudyFile, environment: Environment) -> list[str]:
    faults = []
    seats = {seat.name: seat for seat in environment.seats}
    taken: dict[str, str] = {}
    for name, person in file.people.items():
        key = ("people", name)
        if person.seat is None:
            continue
        if person.seat not in seats:
            what = f"environment {environment.name} has no seat {person.seat!r}; {one_of(person.seat, seats)}"
            faults.append(fail(document, (*key, "seat"), what))
            continue
        if person.seat in taken:
            faults.append(fail(document, (*key, "seat"), f"{taken[person.seat]!r} sits in {person.seat!r} already"))
        taken[person.seat] = name
        if person.adjust:
            seat = seats[person.seat]
            for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
                value = getattr(person.adjust, way)
                if not low - 1e-9 <= value <= high + 1e-9:
                    what = (f"beyond the travel of seat {seat.name} ({1000 * low:g} to {1000 * high:g} mm, "
                            f"got {1000 * value:g})")  # fmt: skip
                    faults.append(fail(document, (*key, "adjust", way), what))
    return faults


def _case_faults(document: Document, file: StudyFile, bodies: dict[str, Loaded]) -> list[str]:
    faults, seen = [], set()
    for row, case in enumerate(file.cases):
        key = ("cases", row)
        if case.name in seen:
            faults.append(fail(document, (*key, "name"), f"two cases are named {case.name!r}"))
        seen.add(case.name)
        for name in file.people:
            if name not in case.people:
                faults.append(fail(document, (*key, "people"), f"the posture of {name!r} is missing"))
        for name, entry in case.people.items():
            where = (*key, "people", name)
            if name not in file.people:
                faults.append(fail(document, where, f"nobody is called {name!r}; {one_of(name, file.people)}"))
                continue
            body, postures = bodies[name]
            if entry.posture not in postures.postures:
                what = f"no posture {entry.posture!r}; {one_of(entry.posture, postures.postures)}"
                faults.append(fail(document, (*where, "posture"), what))
            problems = flat_angles(body, entry.angles)[1]
            faults += [fail(document, (*where, "angles", *path), what) for path, what in problems]
    for name, person in file.people.items():
        if person.at and person.at.segment not in bodies[name][0].segments:
            what = f"unknown segment {person.at.segment!r}; {one_of(person.at.segment, bodies[name][0].segments)}"
            faults.append(fail(document, ("people", name, "at", "segment"), what))
    return faults


def _criterion_faults(document: Document, entry: tuple[int, CriterionFile],
                      loaded: tuple[Environment, dict[str, Loaded]]) -> list[str]:  # fmt: skip
    row, criterion = entry
    environment, bodies = loaded
    faults = []
    segments = {name for body, _ in bodies.values() for name in body.segments}
    for field, valid in (("people", list(bodies)), ("segments", sorted(segments)), ("parts", environment.parts)):
        for place, name in enumerate(getattr(criterion, field) or ()):
            if not any(fnmatchcase(known, name) for known in valid):
                what = f"nothing is called {name!r}; {one_of(name, valid)}"
                faults.append(fail(document, ("criteria", row, field, place), what))
    if criterion.check == "between_people" and len(bodies) < 2:
        faults.append(fail(document, ("criteria", row, "check"), "between_people needs two people or more"))
    return faults


def _criterion(file: StudyFile, row: CriterionFile, loaded: tuple[Environment, dict[str, Loaded]]) -> Criterion:
    environment, bodies = loaded
    segments = list(dict.fromkeys(name for body, _ in bodies.values() for name in body.segments))
    seen = [name for name, hidden in zip(environment.parts, environment.hidden, strict=True) if not hidden]
    at_least = math.radians(row.degrees or 0.0) if row.check == "stops" else row.at_least or 0.0
    return Criterion(
        name=row.name,
        check=row.check,
        people=_matching(row.people, file.people),
        segments=_matching(row.segments, segments),
        parts=_matching(row.parts, seen),
        at_least=at_least,
    )


def _matching(patterns: list[str] | None, known: Iterable[str]) -> tuple[str, ...]:
    """The known names that match any pattern; all of them where none is given."""
    names = list(known)
    return tuple(n for n in names if patterns is None or any(fnmatchcase(n, pattern) for pattern in patterns))


def _person(file: StudyFile, name: str, loaded: Loaded) -> Person:
    body, postures = loaded
    person = file.people[name]
    rows = [case.people[name] for case in file.cases]
    poses = join_poses([
        posture_pose(body, postures, row.posture, more=row.angles, attitude=person.at.attitude if person.at else None)
        for row in rows
    ])  # fmt: skip
    return Person(
        name=name,
        body=body,
        poses=_put(body, poses, person),
        postures=tuple(row.posture for row in rows),
        seat=person.seat,
        forward=person.adjust.forward if person.adjust else 0.0,
        up=person.adjust.up if person.adjust else 0.0,
        stand=person.stand.on if person.stand else None,
    )


def _put(body: Body, poses: Poses, person: PersonFile) -> Poses:
    """The poses with the segment of `at` in its place, or turned to the heading of `stand`."""
    world = poses.world_from_reference.copy()
    if person.at:
        world[:, :, 3] = person.at.position
        return Poses(poses.rotations, body.segment(person.at.segment), world)
    if person.stand:
        world[:, :, :3] = np.einsum("ij,pjk->pik", attitude_matrix(yaw=math.radians(person.stand.yaw)), world[:, :, :3])
    return Poses(poses.rotations, poses.reference, world)
