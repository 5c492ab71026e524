"""Build the scene that shows a result: its people in the postures that it holds, with its findings.

Nothing is computed again: what was checked is drawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.parts import moved
from workbench.draw.scene import Mark
from workbench.draw.source import Source, chosen_cases, people_source, split_names
from workbench.draw.study_scene import study_source
from workbench.errors import InputError, one_of
from workbench.files.catalogue import find, is_file, roots
from workbench.files.results.motions import MotionRows
from workbench.files.results.population import PopulationRows
from workbench.files.results.postures import PersonRow, PostureRow, PosturesRows
from workbench.files.results.result import FindingRow, ResultFile, load_result
from workbench.files.study.reader import load_study
from workbench.model.adjusting import adjusted
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.figures import tenths
from workbench.model.person import Person
from workbench.model.poses import Poses
from workbench.model.posing import join_poses, pose
from workbench.model.quaternions import matrices
from workbench.model.study import Study
from workbench.model.units import unit_in
from workbench.posture.seating.seating import seat_shift
from workbench.study.accommodation.accommodation import body_of_person
from workbench.study.provenance import hashes
from workbench.study.workplaces import drawn_number, occupant

__all__ = ["result_source"]


def result_source(path: Path, case: str | None = None, study: str | None = None) -> Source:
    """Build what is to be drawn of a result: a case of its study, with its findings marked.

    Breaches are marked by number; otherwise the nearest distances are marked. A motion shows its
    contacts by number. A population shows one of the people hardest to serve.

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
        return _hardest_source(path, loaded, result.population, case)
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
            persons.append(Person(role.name, body, join_poses([_pose(body, held, p) for p in at])))
            environment = _with_seat(environment, held)
    return people_source(single.title, environment, tuple(persons), chosen)


def _hardest_source(path: Path, study: Study, rows: PopulationRows, name: str | None) -> Source:
    """One of the people hardest to serve as the result holds them: the named one, or the first."""
    shown = {one.person: one for one in rows.hardest if one.posture is not None}
    if not shown:
        raise InputError(f"{path}: this result shows nobody; see its report")
    hard = shown[next(iter(shown))] if name is None else shown.get(name)
    if hard is None or hard.posture is None:
        raise InputError(f"{path}: shows no person {name!r}; {one_of(name or '', list(shown))}")
    body = body_of_person(study, hard.row)
    settings = {column: values[hard.row] for column, values in rows.people.settings.items()}
    environment = _with_settings(study.environment, settings)
    if rows.seat is not None:
        environment = _seat_at(environment, rows.seat, rows.people.seat_mm[hard.row])
    person = Person(rows.role, body, _posture(body, hard.posture))
    source = people_source(
        f"{study.title}: person {hard.person}", environment, (person,), (hard.posture.case,)
    )
    asked = next(one for one in rows.requirements if one.name == hard.requirement)
    unit = unit_in(asked.unit)
    margin = hard.margin_mm / asked.unit_mm
    words = f"{tenths(abs(margin))}{unit.words} {'short' if margin < 0 else 'to spare'}"
    lack = f"{hard.requirement}: {words}"
    return replace(source, notes=(*source.notes, f"person {hard.person}, {lack}"))


def _with_settings(environment: Environment, settings: Mapping[str, float]) -> Environment:
    """The surroundings with everything that can be adjusted as it was set, by column."""
    setting = {
        one.name: settings[one.column] * one.shown_unit
        for one in environment.adjustments
        if one.column in settings
    }
    return adjusted(environment, setting)


def _pose(body: Body, person: PersonRow, case: int) -> Poses:
    """The pose that a person holds in a case."""
    return _posture(body, person.postures[case])


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
    return _seat_at(environment, person.seat, person.seat_mm)


def _seat_at(environment: Environment, name: str, at_mm: tuple[float, float]) -> Environment:
    """The surroundings with a seat forward and up of where it stands at rest."""
    seat = environment.seat(name)
    forward, up = (value / 1000.0 for value in at_mm)
    return moved(environment, seat.moves, seat_shift(seat, forward, up))


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
