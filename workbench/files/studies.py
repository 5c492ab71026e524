"""Study files: everything they name is loaded and checked, names become indices."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.encumbrances import worn
from workbench.files.catalogue import find
from workbench.files.environments import environment_files, load_environment
from workbench.files.growth import load_growth
from workbench.files.populations import load_population_model
from workbench.files.postures import (
    PosturesFile,
    flat_angles,
    load_postures,
    posture_path,
    posture_pose,
)
from workbench.files.schema import fail, validate
from workbench.files.study_aims import aim_faults, aims_of, envelopes_of
from workbench.files.study_schema import (
    DRIVING,
    PREDICTED,
    CriterionFile,
    PersonFile,
    SizeFile,
    StudyFile,
    population_name,
)
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body, segment_words
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.growth import Growth
from workbench.model.measures import MEASURES, ON_THE_BODY, WORDS
from workbench.model.population import PopulationModel
from workbench.model.poses import Poses
from workbench.model.posing import attitude_matrix, join_poses
from workbench.model.study import Criterion, Person, Size, Study

__all__ = ["load_study"]

Loaded = tuple[Body, PosturesFile]
Found = tuple[Environment | None, dict[str, Loaded]]
Inputs = dict[str, Path]


def load_study(source: str | Path) -> Study:
    """Load a study by catalogue name or path, with all it names.

    InputError lists every fault of the study file with its line, and the faults of the files it
    names.
    """
    path = find("studies", str(source))
    document = read_yaml(path)
    file = validate(document, StudyFile)
    environment, inputs, faults = _environment(document, file, path)
    bodies: dict[str, Loaded] = {}
    for name in file.people:
        body, files, problems = _body(document, file, (name, path))
        inputs |= files
        faults += [line for line in problems if line not in faults]
        if body is not None:
            bodies[name] = body
    dressed: dict[str, tuple[Encumbrance, ...]] = {}
    for name, loaded in bodies.items():
        dressed[name], files, problems = _dressed(document, file, (name, loaded[0], path))
        inputs |= files
        faults += problems
    faults += _people_faults(document, file, environment) + _case_faults(document, file, bodies)
    faults += aim_faults(document, file, environment) + _criteria_faults(
        document, file, (environment, bodies)
    )
    if faults or environment is None:
        raise InputError(faults)
    return Study(
        name=file.study,
        kind=file.kind,
        title=file.title or file.study,
        description=file.description,
        environment=environment,
        people=tuple(_person(file, name, (*bodies[name], dressed[name])) for name in file.people),
        cases=tuple(case.name for case in file.cases),
        criteria=tuple(_criterion(file, row, (environment, bodies)) for row in file.criteria),
        inputs=inputs,
        warnings=environment.warnings,
        envelopes=envelopes_of(file),
    )


def _environment(
    document: Document, file: StudyFile, path: Path
) -> tuple[Environment | None, Inputs, list[str]]:
    """The environment and the files it and the study are made of, or what is wrong."""
    inputs = {"study": path}
    try:
        source = find("environments", file.environment, "environment.yaml", near=path.parent)
    except InputError as error:
        return (
            None,
            inputs,
            [fail(document, ("environment",), problem) for problem in error.problems],
        )
    try:
        environment = load_environment(source)
        files = {
            f"environment: {p.relative_to(source.parent)}": p for p in environment_files(source)
        }
        return environment, inputs | files, []
    except InputError as error:
        return None, inputs, list(error.problems)


def _body(
    document: Document, file: StudyFile, who: tuple[str, Path]
) -> tuple[Loaded | None, Inputs, list[str]]:
    """One person's body and postures and their files, or what is wrong."""
    name, path = who
    key = ("people", name, "body")
    try:
        source = body_path(file.people[name].body, near=path.parent)
    except InputError as error:
        return None, {}, [fail(document, key, problem) for problem in error.problems]
    try:
        body = load_body(source)
        postures = posture_path(source)
        if postures is None:
            what = f"body {body.name!r} names no postures file, so no posture can be named here"
            return None, {}, [fail(document, key, what)]
        loaded = body, load_postures(postures, body)[0]
    except InputError as error:
        return None, {}, list(error.problems)
    files = {f"body of {name}": source, f"postures of {name}": postures}
    detail = file.people[name].detail
    if detail is not None and (body.basis is None or detail not in body.basis.details):
        levels = ", ".join(body.basis.details) if body.basis else "none"
        what = f"body {body.name} has no level of detail {detail!r}; valid: {levels}"
        return loaded, files, [fail(document, ("people", name, "detail"), what)]
    size = file.people[name].size
    try:
        if size is not None:
            source = find("bodies/populations", population_name(size), near=path.parent)
            files[f"population of {name}"] = source
            _population(size)
    except InputError as error:
        where = ("people", name, "size", "population")
        return None, {}, [fail(document, where, problem) for problem in error.problems]
    return loaded, files, _size_faults(document, file, name)


def _dressed(
    document: Document, file: StudyFile, who: tuple[str, Body, Path]
) -> tuple[tuple[Encumbrance, ...], Inputs, list[str]]:
    """What one person wears, and the files it is in, or what is wrong."""
    name, body, path = who
    wanted = file.people[name].encumbrance
    try:
        files = {
            f"{item} of {name}": find("bodies/encumbrance", item, near=path.parent)
            for item in wanted
        }
        return worn(wanted, body, near=path.parent), files, []
    except InputError as error:
        return (
            (),
            {},
            [
                fail(document, ("people", name, "encumbrance"), problem)
                for problem in error.problems
            ],
        )


def _size_faults(document: Document, file: StudyFile, name: str) -> list[str]:
    """Measures of a person's size that cannot be given, or that no person has."""
    size = file.people[name].size
    faults = []
    for measure, value in (size.measures if size else {}).items():
        where = ("people", name, "size", "measures", measure)
        if measure == "mass":
            faults.append(
                fail(
                    document,
                    where,
                    "a mass is no length; give it beside the measures, as mass_kg: 60",
                )
            )
        elif measure not in ON_THE_BODY:
            faults.append(
                fail(
                    document,
                    where,
                    f"no measure {measure!r}; {one_of(measure, ON_THE_BODY, words=WORDS)}",
                )
            )
        elif measure in MEASURES and not MEASURES[measure][0] <= value <= MEASURES[measure][1]:
            low, high = (1000 * limit for limit in MEASURES[measure])
            what = (
                f"{1000 * value:g} mm is not a person's ({low:g} to {high:g} mm is): a wrong unit?"
            )
            faults.append(fail(document, where, what))
    return faults


def _people_faults(
    document: Document, file: StudyFile, environment: Environment | None
) -> list[str]:
    faults = []
    taken: dict[str, str] = {}
    for name, person in file.people.items():
        key = ("people", name)
        if person.seat is None:
            continue
        if person.seat in taken:
            faults.append(
                fail(
                    document,
                    (*key, "seat"),
                    f"{taken[person.seat]!r} sits in {person.seat!r} already",
                )
            )
        taken.setdefault(person.seat, name)
        if environment is not None:
            faults += _seat_faults(document, (name, person), environment)
    return faults


def _seat_faults(
    document: Document, entry: tuple[str, PersonFile], environment: Environment
) -> list[str]:
    """The seat is there, and adjusted within its travel."""
    name, person = entry
    seats = {seat.name: seat for seat in environment.seats}
    if person.seat not in seats:
        what = f"environment {environment.name} has no seat {person.seat!r}; {one_of(str(person.seat), seats)}"
        return [fail(document, ("people", name, "seat"), what)]
    faults = []
    seat = seats[person.seat]
    for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
        value = getattr(person.adjust, way, 0.0)
        if not low - 1e-9 <= value <= high + 1e-9:
            travel = f"{1000 * low:g} to {1000 * high:g} mm"
            what = f"beyond the travel of seat {seat.name}, {travel} (got {1000 * value:g} mm)"
            faults.append(fail(document, ("people", name, "adjust", way), what))
    return faults


def _case_faults(document: Document, file: StudyFile, bodies: dict[str, Loaded]) -> list[str]:
    faults = []
    seen = set()
    for row, case in enumerate(file.cases):
        key = ("cases", row)
        if case.name in seen:
            faults.append(fail(document, (*key, "name"), f"two cases are named {case.name!r}"))
        seen.add(case.name)
        for name in file.people:
            if name not in case.people:
                faults.append(
                    fail(document, (*key, "people"), f"the posture of {name!r} is missing")
                )
        for name, entry in case.people.items():
            where = (*key, "people", name)
            if name not in file.people:
                faults.append(
                    fail(document, where, f"nobody is called {name!r}; {one_of(name, file.people)}")
                )
            if name not in bodies:
                continue
            body, postures = bodies[name]
            if entry.named not in postures.postures:
                what = f"no posture {entry.named!r}; {one_of(entry.named, [PREDICTED, DRIVING, *postures.postures])}"
                faults.append(
                    fail(
                        document,
                        (*where, "posture" if entry.named == entry.posture else "like"),
                        what,
                    )
                )
            problems = flat_angles(body, entry.angles)[1]
            faults += [fail(document, (*where, "angles", *path), what) for path, what in problems]
    for name, (body, _) in bodies.items():
        at = file.people[name].at
        if at and at.segment not in body.segments:
            what = f"unknown segment {at.segment!r}; {one_of(at.segment, body.segments, words=segment_words(body))}"
            faults.append(fail(document, ("people", name, "at", "segment"), what))
    return faults


def _criteria_faults(document: Document, file: StudyFile, loaded: Found) -> list[str]:
    """Names are of something that is there; what could not be loaded is not asked about."""
    environment, bodies = loaded
    hidden = set(environment.parts) - set(_visible(environment)) if environment else set()
    valid: dict[str, list[str]] = {"people": list(file.people)}
    if len(bodies) == len(file.people):
        valid["segments"] = list(
            dict.fromkeys(name for body, _ in bodies.values() for name in body.segments)
        )
    words = {
        word: name for body, _ in bodies.values() for word, name in segment_words(body).items()
    }
    if environment is not None:
        valid["parts"] = _visible(environment)
        valid["controls"] = [control.name for control in environment.controls]
    faults = []
    seen = set()
    for row, criterion in enumerate(file.criteria):
        key = ("criteria", row)
        if criterion.name in seen:
            faults.append(
                fail(document, (*key, "name"), f"two criteria are named {criterion.name!r}")
            )
        seen.add(criterion.name)
        for field, names in valid.items():
            for place, name in enumerate(getattr(criterion, field) or ()):
                if not any(fnmatchcase(known, name) for known in names):
                    what = (
                        f"part {name!r} is hidden, so it is not checked"
                        if name in hidden
                        else f"nothing is called {name!r}"
                    )
                    hint = one_of(name, names, words=words if field == "segments" else {})
                    faults.append(fail(document, (*key, field, place), f"{what}; {hint}"))
        if criterion.check == "between_people" and len(file.people) < 2:
            faults.append(
                fail(document, (*key, "check"), "between_people needs two people or more")
            )
    return faults


def _visible(environment: Environment) -> list[str]:
    """The parts that are checked: a hidden one is neither drawn nor measured."""
    return [
        name
        for name, hidden in zip(environment.parts, environment.hidden, strict=True)
        if not hidden
    ]


def _criterion(
    file: StudyFile, row: CriterionFile, loaded: tuple[Environment, dict[str, Loaded]]
) -> Criterion:
    environment, bodies = loaded
    segments = list(dict.fromkeys(name for body, _ in bodies.values() for name in body.segments))
    at_least = math.radians(row.degrees or 0.0) if row.check == "stops" else row.at_least or 0.0
    return Criterion(
        name=row.name,
        check=row.check,
        people=_matching(row.people, file.people),
        segments=_matching(row.segments, segments),
        parts=_matching(row.parts, _visible(environment)),
        at_least=at_least,
        controls=_matching(row.controls, [control.name for control in environment.controls]),
        zone=row.zone,
    )


def _matching(patterns: list[str] | None, known: Iterable[str]) -> tuple[str, ...]:
    """The known names that match any pattern; all of them where none is given."""
    names = list(known)
    return tuple(
        n for n in names if patterns is None or any(fnmatchcase(n, pattern) for pattern in patterns)
    )


def _person(
    file: StudyFile, name: str, loaded: tuple[Body, PosturesFile, tuple[Encumbrance, ...]]
) -> Person:
    body, postures, wears = loaded
    person = file.people[name]
    rows = [case.people[name] for case in file.cases]
    poses = join_poses(
        [
            posture_pose(
                body,
                postures,
                row.named,
                more=row.angles,
                attitude=person.at.attitude if person.at else None,
            )
            for row in rows
        ]
    )
    return Person(
        name=name,
        body=body,
        poses=_put(body, poses, person),
        postures=tuple(row.posture for row in rows),
        seat=person.seat,
        forward=person.adjust.forward if person.adjust else 0.0,
        up=person.adjust.up if person.adjust else 0.0,
        stand=person.stand.on if person.stand else None,
        size=_size(person.size) if person.size else None,
        detail=person.detail,
        wears=wears,
        aims=tuple(aims_of(row) for row in rows),
        free_seat=person.seat is not None and person.adjust is None,
    )


def _put(body: Body, poses: Poses, person: PersonFile) -> Poses:
    """The poses with the segment of `at` in its place, or turned to the heading of `stand`."""
    world = poses.world_from_reference.copy()
    if person.at:
        world[:, :, 3] = person.at.position
        return Poses(poses.rotations, body.segment(person.at.segment), world)
    if person.stand:
        world[:, :, :3] = np.einsum(
            "ij,pjk->pik", attitude_matrix(yaw=math.radians(person.stand.yaw)), world[:, :, :3]
        )
    return Poses(poses.rotations, poses.reference, world)


def _size(file: SizeFile) -> Size:
    mass = {} if file.mass_kg is None else {"mass": file.mass_kg}
    return Size(file.sex, file.measures | mass, _population(file), file.age)


def _population(file: SizeFile) -> PopulationModel | Growth:
    """The people a size is among: of a child those of its age."""
    name = population_name(file)
    return load_population_model(name) if file.age is None else load_growth(name)
