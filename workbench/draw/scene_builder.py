"""Build the scene that shows a body, an environment, a mesh, a study or a result."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.source import (
    PEOPLE_COLOURS,
    Source,
    chosen_cases,
    people_source,
    split_names,
)
from workbench.errors import InputError, UsageError, one_of
from workbench.files.bare_mesh import read_bare
from workbench.files.body.bodies import load_body
from workbench.files.catalogue import find, is_file, is_there, names, roots
from workbench.files.environments import load_environment
from workbench.files.kinds import is_mesh, is_result, kind_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.results.motions import MotionRows
from workbench.files.results.population import PeopleRow, PopulationRows
from workbench.files.results.postures import PersonRow, PostureRow, PosturesRows
from workbench.files.results.result import FindingRow, ResultFile, load_result
from workbench.files.study.reader import load_study
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.joint_angles import join_poses, pose
from workbench.model.person import Person
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import matrices
from workbench.model.result import Illustration, PopulationFound, Result
from workbench.model.study import Study
from workbench.model.surroundings import adjusted
from workbench.model.units import tenths, unit_in
from workbench.posture.seating.seating import seat_at
from workbench.study.accommodation.accommodation import (
    body_of_person,
    person_again,
    person_shown,
)
from workbench.study.accommodation.worst_cases import Places
from workbench.study.motion_cases import motion_cases
from workbench.study.people import poses_of, present_people
from workbench.study.run import hashes
from workbench.study.workplaces import drawn_number, occupant

__all__ = [
    "Drawn",
    "build_source",
    "mesh_source",
    "result_source",
    "scene_of",
    "source_kind",
    "source_of",
    "study_source",
]

MOST_BODIES = 40
"""Poses of a placed body in one scene."""
_KINDS = {
    "body": "the file or name of a body",
    "environment": "an environment",
    "mesh": "a mesh",
    "placed": "a placed body",
    "study": "a study",
    "result": "a result",
    "scene": "a scene",
}
"""What can be drawn, in words."""


Drawn = str | Path | Environment | Placed | Study | Result | Scene
"""What can be drawn: a name of the catalogue, a path, or a noun."""


def scene_of(
    source: Drawn,
    *,
    posture: str | None = None,
    case: str | None = None,
    environment: Environment | None = None,
) -> Scene:
    """Build the scene of a body in a posture, of an environment, or of a case of a study or result.

    See `source_of` for the arguments.
    """
    return source_of(source, posture=posture, case=case, environment=environment).scene


def source_of(
    source: Drawn,
    *,
    posture: str | None = None,
    case: str | None = None,
    environment: Environment | None = None,
) -> Source:
    """Build what is to be drawn of a file, a name of the catalogue, or a noun.

    Parameters
    ----------
    source
        A name of the catalogue, the path of a body, an environment, a mesh, a study or a result; an
        environment, a placed body (each pose a body), a study, a result, or a scene, which stays as
        it is.
    posture
        Of a body's file or name: its postures, with commas between.
    case
        Of a study or result: its cases, with commas between.
    environment
        Around a placed body.

    Raises
    ------
    InputError
        If a file or a name does not exist or cannot be read, or there is nothing to draw.
    UsageError
        If a case or a posture does not exist, or an argument does not suit the source.
    """
    if isinstance(source, (str, Path)):
        kind = source_kind(str(source))
        found = build_source(str(source), poses=posture, case=case)
    else:
        kind = type(source).__name__.lower()
        found = _noun_source(source, case)
    for name, given, kinds in (
        ("posture", posture, ("body",)),
        ("case", case, ("study", "result")),
        ("environment", environment, ("placed",)),
    ):
        if given is not None and kind not in kinds:
            fit = " or ".join(_KINDS[each] for each in kinds)
            raise UsageError(f"{name}: belongs to {fit}, not to {_KINDS[kind]}")
    if environment is not None:
        return replace(found, scene=replace(found.scene, environment=environment))
    return found


def _noun_source(noun: Environment | Placed | Study | Result | Scene, case: str | None) -> Source:
    if isinstance(noun, Scene):
        return Source(noun)
    if isinstance(noun, Environment):
        return Source(Scene((), noun, (), noun.name, noun.description))
    if isinstance(noun, Placed):
        return Source(_placed_scene(noun))
    if isinstance(noun, Study):
        noun.check_derived()
        return _study_source(noun, noun.name, case)
    return _result_source(noun, case)


def _placed_scene(placed: Placed) -> Scene:
    """Everybody in one scene: each pose is somebody."""
    if len(placed) > MOST_BODIES:
        raise UsageError(f"source: {len(placed)} poses; a scene takes {MOST_BODIES} at most")
    colours = [PEOPLE_COLOURS[pose % len(PEOPLE_COLOURS)] for pose in range(len(placed))]
    bodies = tuple(SceneBody(placed, pose, colour) for pose, colour in enumerate(colours))
    return Scene(bodies, title=placed.body.name)


def _result_source(result: Result, case: str | None) -> Source:
    """People as they were found: in the first case that failed, or in those that are named."""
    if result.postures:
        found = result.postures[0]
        failed = [row.case for verdict in found.verdicts for row in verdict.breaches]
        first = next((name for name in found.cases if name in failed), found.cases[0])
        chosen = chosen_cases(found.study.name, found.cases, case or first)
        rows = np.array([found.cases.index(name) for name in chosen])
        persons = tuple(
            Person(person.name, person.body, person.poses.rows(rows)) for person in found.people
        )
        return people_source(found.study.title, found.environment, persons, chosen)
    if result.motions:
        return study_source(result.study, case)
    shown = None if result.population is None else _shown_of(result.population, case)
    if shown is None:
        raise UsageError("source: nothing is asked of anybody of this population: nobody is drawn")
    body = SceneBody(shown.placed, holds=shown.environment)
    return Source(Scene((body,), shown.environment, (), result.study.title))


def _shown_of(found: PopulationFound, name: str | None) -> Illustration | None:
    """A person of a population by the label, the one hardest to serve without one; None for whom nothing
    is asked."""
    if name is None:
        return next(iter(found.shown), None)
    labels = found.people.labels or tuple(str(row + 1) for row in range(len(found.people)))
    if name not in labels:
        raise UsageError(f"case: there is no person {name!r}; {one_of(name, labels)}")
    row = labels.index(name)
    held = next((one for one in found.shown if one.row == row), None)
    return held or person_shown(found, row, found.requirements[found.looked_at(row)].name)


def build_source(
    source: str, *, poses: str | None = None, case: str | None = None, study: str | None = None
) -> Source:
    """Build what is to be drawn of a body, an environment, a mesh, a study or a result.

    Parameters
    ----------
    source
        A path, or a name of the catalogue.
    poses
        Postures of a body, with commas between. If None: standing, or the body's first posture.
    case
        Cases of a study, with commas between. If None: the first case, or all cases of a study
        whose poses are a motion.
    study
        Of a result: the file of its study, or its name; sought by its content if None.

    Raises
    ------
    InputError
        If a file or a name does not exist or cannot be read.
    UsageError
        If a case or a posture does not exist, or does not suit the kind of source.
    """
    kind = source_kind(source)
    if kind == "mesh":
        return mesh_source((source,))
    _check_choice(source, kind, poses, case)
    if study is not None and kind != "result":
        raise UsageError(f"{source} is no result: --study names the study of a result")
    if kind == "result":
        return result_source(Path(source), case, study)
    if kind == "environment":
        environment = load_environment(source)
        return Source(Scene((), environment, (), environment.name, environment.description))
    if kind == "body":
        return _body_source(source, poses)
    return _study_source(load_study(source), source, case)


def _study_source(study: Study, called: str, case: str | None) -> Source:
    """The cases of a study, unless it is about many people."""
    if study.crowd is not None:
        raise InputError(
            f"{called} is about many people and has no case to draw; run it: its report shows the hardest"
        )
    return study_source(study, case)


def mesh_source(
    sources: Sequence[str],
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Source:
    """Build what is to be drawn of mesh files; what is assumed of them is noted. Arguments and
    errors as of `read_bare`."""
    bare = read_bare(sources, length=length, up=up, forward=forward)
    notes = [f"assumed: {words}" for words in bare.assumed]
    if bare.assumed:
        notes.append("state what is wrong by --units, --up and --forward")
    scene = Scene((), bare.environment, (), bare.environment.name)
    return Source(scene, notes=tuple(notes))


def _check_choice(source: str, kind: str, poses: str | None, case: str | None) -> None:
    """Refuse postures unless the source is a body, and cases unless it is a study or a result."""
    has_cases = kind in ("study", "result")
    article = "an" if kind[0] in "aeiou" else "a"
    if poses is not None and kind != "body":
        hint = ", --case for studies" if has_cases else ""
        raise UsageError(f"{source} is {article} {kind}: --pose is for bodies{hint}")
    if case is not None and not has_cases:
        hint = ", --pose for bodies" if kind == "body" else ""
        raise UsageError(f"{source} is {article} {kind}: --case is for studies{hint}")


def _body_source(source: str, poses: str | None) -> Source:
    """Build a body in postures; several are a motion with a second from each to the next."""
    body = load_body(source)
    path = posture_path(source)
    if path is None:
        raise InputError(f"body {body.name} names no postures file")
    file, _ = load_postures(path, body)
    default = "standing" if "standing" in file.postures else next(iter(file.postures))
    chosen = (default,) if poses is None else split_names(poses)
    joined = join_poses([posture_pose(body, file, name) for name in chosen])
    if len(chosen) > 1:
        joined = replace(joined, time=np.arange(len(chosen), dtype=np.float64))
    person = Person(body.name, body, joined)
    scene = Scene((SceneBody(place(body, joined), 0),), None, (), body.name, ", ".join(chosen))
    return Source(scene, chosen, (body.name,), (person,), len(chosen) > 1)


def source_kind(source: str) -> str:
    """Return body, environment, mesh, study or result for a path or a name of the catalogue.

    Raises
    ------
    InputError
        If it is anything else.
    """
    path = Path(source)
    if is_there(path):
        kind = "result" if is_result(path) else kind_of(path)
        if kind in ("body", "environment", "mesh", "study", "result"):
            return kind
        raise InputError(
            f"{source}: a body, an environment, a mesh, a study or a result is needed (got {kind})"
        )
    if is_mesh(source):
        return "mesh"
    catalogue = {
        "body": names("bodies"),
        "environment": names("environments", "environment.yaml"),
        "study": names("studies"),
    }
    for kind, listed in catalogue.items():
        if source in listed:
            return kind
    every = [name for listed in catalogue.values() for name in listed]
    raise InputError(f"nothing is called {source!r}; {one_of(source, every)}")


# Build the scene that shows a result: its people in the postures that it holds, with its findings.
#
# Nothing is computed again: what was checked is drawn.


def result_source(path: Path, case: str | None = None, study: str | None = None) -> Source:
    """Build what is to be drawn of a result: a case of its study, with its findings marked.

    Breaches are marked by number; otherwise the nearest distances are marked. A motion shows its
    contacts by number. A population shows one of its people.

    Parameters
    ----------
    path
        A result.json or the folder that holds it.
    case
        Name of the case, or of a person of a population. If None: the case that failed, or came
        nearest to failing; the person hardest to serve.
    study
        The file of the study, or its name. If None it is sought by its content: beside the result,
        in the folders above, where the program runs, and in the catalogue.

    Raises
    ------
    InputError
        If the study is not found, or one of its files has changed since.
    """
    result = load_result(path)
    made_from = result.provenance.get("inputs", {})
    loaded = load_study(_study_path(path, result, made_from.get("study", ""), study))
    now = hashes(loaded.inputs)
    for role, file in loaded.inputs.items():
        if made_from.get(role) != now[role]:
            raise InputError(
                f"{path}: {file} is not as it was when this result was made; run the study again"
            )
    motion = _shown_motion(result, case)
    if motion is not None:
        return _with_contacts(study_source(loaded, case or motion.case), motion)
    if result.postures:
        names = case or _worst_case(result)
        return _with_findings(_held_source(loaded, result.postures[0], names), result)
    if result.population is not None:
        return _population_source(path, loaded, result.population, case)
    raise InputError(f"{path}: this result holds nothing to draw; see its report")


def _study_path(path: Path, result: ResultFile, digest: str, given: str | None) -> Path:
    """The file of the study that a result was made from."""
    if given is not None:
        return find("studies", given)
    folders = list(_folders(path))
    for folder in folders:
        for file in sorted(folder.glob("*.yaml")):
            if _has_digest(file, digest):
                return file
    try:
        return find("studies", result.study)  # it has changed, which is reported of all its files
    except InputError:
        looked = ", ".join(str(folder) for folder in folders)
        raise InputError(
            f"{path}: the study {result.study!r} of this result is in none of {looked}; name its "
            f"file by --study"
        ) from None


def _has_digest(file: Path, digest: str) -> bool:
    """Whether a file has this SHA-256; False where it may not be read."""
    try:
        return is_file(file) and hashes({"study": file})["study"] == digest
    except OSError:
        return False


def _folders(path: Path) -> Iterator[Path]:
    """The folders that may hold the study of a result, each once."""
    home = (path if path.is_dir() else path.parent).resolve()
    places = [home, *list(home.parents)[:3], *roots()]
    for place_ in dict.fromkeys(places):
        for folder in (place_, place_ / "studies"):
            if folder.is_dir():
                yield folder


def _held_source(study: Study, rows: PosturesRows, case: str) -> Source:
    """Cases of people in the postures that a result holds."""
    _, single = study.by_size()[0]
    names = tuple(rows.cases)
    chosen = chosen_cases(single.name, names, case)
    at = [names.index(name) for name in chosen]
    environment = _with_settings(single.environment, rows.settings)
    persons = []
    for role in single.roles:
        held = next((row for row in rows.people if row.name == role.name), None)
        if held is not None:
            body = occupant(role, drawn_number(single.roles, role))[0].body
            persons.append(
                Person(role.name, body, join_poses([_posture(body, held.postures[p]) for p in at]))
            )
            environment = _with_seat(environment, held)
    return people_source(single.title, environment, tuple(persons), chosen)


def _population_source(path: Path, study: Study, rows: PopulationRows, name: str | None) -> Source:
    """One person of a population: the named one, or the first of those hardest to serve. These are as
    the result holds them, everybody else is found again where the result has the person."""
    people = rows.people
    held = {one.person: one for one in rows.hardest if one.posture is not None}
    if not held and name is None:
        raise InputError(f"{path}: this result shows nobody by itself; name a person by --case")
    label = next(iter(held)) if name is None else name
    if label not in people.label:
        raise InputError(f"{path}: has no person {label!r}; {one_of(label, people.label)}")
    hard = held.get(label)
    row = people.label.index(label) if hard is None else hard.row
    settings = {column: values[row] for column, values in people.settings.items()}
    margins = [math.inf if margin is None else margin for margin in people.margin_mm[row]]
    r = int(np.argmin(margins))
    if hard is not None and hard.posture is not None:
        r = [one.name for one in rows.requirements].index(hard.requirement)
        body = body_of_person(study, row)
        poses, case = _posture(body, hard.posture), hard.posture.case
        environment = _with_settings(study.environment, settings)
        if rows.seat is not None:
            forward, up = people.seat_mm[row]
            environment = seat_at(environment, rows.seat, forward / 1000.0, up / 1000.0)
    else:
        shown = person_again(study, row, _places(study.environment, people, row), r)
        body, poses, case = shown.placed.body, shown.poses, shown.case
        environment = shown.environment
    person = Person(rows.role, body, poses)
    source = people_source(f"{study.title}: person {label}", environment, (person,), (case,))
    asked = rows.requirements[r]
    unit = unit_in(asked.unit)
    margin = margins[r] / asked.unit_mm
    words = f"{tenths(abs(margin))}{unit.words} {'short' if margin < 0 else 'to spare'}"
    return replace(source, notes=(*source.notes, f"person {label}, {asked.name}: {words}"))


def _places(environment: Environment, people: PeopleRow, row: int) -> Places:
    """Where a result has one of its people."""
    units = {one.column: one.shown_unit for one in environment.adjustments}
    setting = [values[row] * units[column] for column, values in people.settings.items()]
    seat, comfortable = (
        np.array([place_mm[row]]) / 1000.0 for place_mm in (people.seat_mm, people.comfortable_mm)
    )
    return Places(seat, comfortable, np.array([setting]))


def _with_settings(environment: Environment, settings: Mapping[str, float]) -> Environment:
    """The surroundings with everything that can be adjusted as it was set, by column."""
    setting = {
        one.name: settings[one.column] * one.shown_unit
        for one in environment.adjustments
        if one.column in settings
    }
    return adjusted(environment, setting)


def _posture(body: Body, held: PostureRow) -> Poses:
    """A pose of a body as a result holds it."""
    return pose(
        body,
        held.angles_deg,
        reference=held.reference,
        position=tuple(value / 1000.0 for value in held.position_mm),
        attitude=matrices(_unit(held.rotation)),
    )


def _unit(rotation: tuple[float, float, float, float]) -> np.ndarray:
    """A quaternion (4,), of length 1 again after it was rounded."""
    turn = np.array(rotation)
    return np.asarray(turn / np.linalg.norm(turn))


def _with_seat(environment: Environment, person: PersonRow) -> Environment:
    """The surroundings with the seat of a person where it stood."""
    if person.seat is None or person.seat_mm is None:
        return environment
    forward, up = person.seat_mm
    return seat_at(environment, person.seat, forward / 1000.0, up / 1000.0)


def _shown_motion(result: ResultFile, case: str | None) -> MotionRows | None:
    """Return the first motion of the named cases; of a result of motions alone the first."""
    if case is None:
        return result.motions[0] if result.motions and not result.postures else None
    names = split_names(case)
    return next((motion for motion in result.motions if motion.case in names), None)


def _with_contacts(source: Source, motion: MotionRows) -> Source:
    """Mark the contacts of a motion that go deeper than allowed, by number."""
    contacts = [contact for contact in motion.contacts if contact.depth_mm > contact.allowed_mm]
    marks = [Mark(_metres(c.point_mm), str(n)) for n, c in enumerate(contacts, start=1)]
    notes = [f"{n}: {contact.sentence}" for n, contact in enumerate(contacts, start=1)]
    scene = replace(source.scene, marks=tuple(marks))
    return replace(source, scene=scene, notes=(*source.notes, *notes))


def _worst_case(result: ResultFile) -> str:
    """Return the case that failed, or came nearest to failing."""
    verdicts = sorted((v for v in result.verdicts if v.worst), key=lambda v: v.passed)
    return verdicts[0].worst.case if verdicts and verdicts[0].worst else result.cases[0]


def _with_findings(source: Source, result: ResultFile) -> Source:
    """Mark the breaches of the first case by number, and the nearest distances of what passed."""

    def in_case(finding: FindingRow) -> bool:
        return finding.case == source.names[0] and finding.point_mm is not None

    breaches = [f for verdict in result.verdicts for f in verdict.breaches if in_case(f)]
    passed = [verdict.worst for verdict in result.verdicts if verdict.passed and verdict.worst]
    labelled = [(finding, str(n), "contact") for n, finding in enumerate(breaches, start=1)]
    labelled += [
        (f, f"{tenths(f.value, f.limit)} {f.unit}", "clearance") for f in passed if in_case(f)
    ]
    marks = tuple(
        Mark(_metres(finding.point_mm), label, kind)
        for finding, label, kind in labelled
        if finding.point_mm
    )
    notes = tuple(f"{n}: {finding.sentence}" for n, finding in enumerate(breaches, start=1))
    return replace(source, scene=replace(source.scene, marks=marks), notes=notes)


def _metres(point: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = (value / 1000.0 for value in point)
    return x, y, z


def study_source(study: Study, case: str | None = None) -> Source:
    """Build what is to be drawn of a study's cases, as a run evaluates them. See `build_source`.

    Of several sizes the first is drawn; of postures and motions the postures, unless a motion is
    named.
    """
    _, single = study.by_size()[0]
    motions = {each.name for each in study.motions}
    named = case is not None and bool(motions & set(split_names(case)))
    if named or not study.postures:
        return _motion_source(single, case)
    return _posture_source(single, case)


def _posture_source(study: Study, case: str | None) -> Source:
    """Build cases of a study of people in postures: the first, or those that are named."""
    there = present_people(study)
    known = tuple(each.name for each in study.postures)
    chosen = chosen_cases(study.name, known, case)
    if case is None:
        chosen = chosen[:1]
    rows = np.array([known.index(name) for name in chosen])
    persons = tuple(
        Person(role.name, mine[0].body, poses_of(mine).rows(rows))
        for role, mine in zip(there.roles, there.situations, strict=True)
    )
    return people_source(study.title, there.environment, persons, chosen)


def _motion_source(study: Study, case: str | None) -> Source:
    """Build a motion in its environment, over the other motions of the cases."""
    chosen = chosen_cases(study.name, tuple(each.name for each in study.motions), case)
    motions = [motion for motion in motion_cases(study) if motion.case in chosen]
    first = motions[0]
    people = [first.person, *(motion.name for motion in motions[1:])]
    persons = tuple(
        Person(name, motion.body, motion.motion)
        for name, motion in zip(people, motions, strict=True)
    )
    coloured = [
        (motion, PEOPLE_COLOURS[row % len(PEOPLE_COLOURS)]) for row, motion in enumerate(motions)
    ]
    bodies = tuple(
        SceneBody(place(motion.body, motion.motion.rows(slice(1))), 0, colour)
        for motion, colour in coloured
    )
    key = tuple((motion.name, colour) for motion, colour in coloured)
    scene = Scene(
        bodies[:1],
        first.cabin,
        title=study.title,
        ghosts=bodies[1:],
        key=key if len(motions) > 1 else (),
    )
    return Source(scene, (), (first.person,), persons[:1], True, under=persons[1:])
