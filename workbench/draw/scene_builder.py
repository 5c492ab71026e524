"""Build the scene that shows a body, an environment, a study or a result."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.errors import InputError, UsageError, one_of
from workbench.files.body.bodies import load_body
from workbench.files.catalogue import find, is_there, names
from workbench.files.environments import load_environment
from workbench.files.kinds import kind_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.results.motions import MotionRows
from workbench.files.results.result import FindingRow, ResultFile, load_result
from workbench.files.study.reader import load_study
from workbench.model.arrays import Floats
from workbench.model.moving import poses_at
from workbench.model.person import Person
from workbench.model.posing import join_poses
from workbench.model.study import Study
from workbench.study.motion_cases import motion_cases
from workbench.study.people import poses_of, present_people

__all__ = [
    "PEOPLE_COLOURS",
    "Source",
    "build_source",
    "result_source",
    "scene_of",
    "source_kind",
    "study_source",
]

PEOPLE_COLOURS = ("warm", "blue", "green", "rose", "grey")
"""Colour families of the people of a study, in turn."""


@dataclass(frozen=True, eq=False)
class Source:
    """What is to be drawn: a scene, and what is needed to show it at other times."""

    scene: Scene
    """Its bodies hold P poses each and show the first. Of a recorded motion it holds the first
    frame only."""
    names: tuple[str, ...] = ()
    """Names of the P poses or cases; empty for a recorded motion."""
    people: tuple[str, ...] = ()
    """Names of the bodies."""
    persons: tuple[Person, ...] = ()
    """Body and poses of each person."""
    moving: bool = False
    """Whether `at` can give the poses at any time."""
    notes: tuple[str, ...] = ()
    """What the numbers of marks mean, and what was assumed."""
    under: tuple[Person, ...] = ()
    """The persons of the scene's ghosts."""
    kinds: tuple[str, ...] = ()
    """Kinds of marks that follow the poses, see `requested_marks.with_marks`."""
    fixed: tuple[Mark, ...] = ()
    """Marks that do not."""

    def at(self, times: Floats) -> Source:
        """Return the source with everybody who moves in F poses, at times (F,) [s]."""
        persons = tuple(_at_times(person, times) for person in self.persons)
        under = tuple(_at_times(person, times) for person in self.under)
        bodies = self._placed(self.scene.bodies, self.persons, persons)
        ghosts = self._placed(self.scene.ghosts, self.under, under)
        scene = replace(self.scene, bodies=bodies, ghosts=ghosts)
        return replace(self, scene=scene, persons=persons, under=under)

    def _placed(
        self, shown: tuple[SceneBody, ...], before: tuple[Person, ...], after: tuple[Person, ...]
    ) -> tuple[SceneBody, ...]:
        """Place the persons whose poses have changed."""
        return tuple(
            body if new is old else replace(body, placed=place(new.body, new.poses), pose=0)
            for body, old, new in zip(shown, before, after, strict=True)
        )


def _at_times(person: Person, times: Floats) -> Person:
    """Return a person in poses at times (F,) [s]; the same person if the poses have no times."""
    if person.poses.time is None:
        return person
    return replace(person, poses=poses_at(person.poses, times))


def scene_of(source: str, *, posture: str | None = None, case: str | None = None) -> Scene:
    """Build the scene of a body in a posture, of an environment, or of a case of a study.

    See `build_source` for the arguments.
    """
    return build_source(source, poses=posture, case=case).scene


def build_source(source: str, *, poses: str | None = None, case: str | None = None) -> Source:
    """Build what is to be drawn of a body, an environment, a study or a result.

    Parameters
    ----------
    source
        A path, or a name of the catalogue.
    poses
        Postures of a body, with commas between. If None: standing, or the body's first posture.
    case
        Cases of a study, with commas between. If None: the first case, or all cases of a study
        whose poses are a motion.

    Raises
    ------
    InputError
        If a file or a name does not exist or cannot be read.
    UsageError
        If a case or a posture does not exist, or does not suit the kind of source.
    """
    kind = source_kind(source)
    _check_choice(source, kind, poses, case)
    if kind == "result":
        return result_source(Path(source), case)
    if kind == "environment":
        environment = load_environment(source)
        return Source(Scene((), environment, (), environment.name, environment.description))
    if kind == "body":
        return _body_source(source, poses)
    study = load_study(source)
    if study.crowd is not None:
        raise InputError(
            f"{source} is about many people and has no case to draw; run it: its report shows the hardest"
        )
    return study_source(study, case)


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


def result_source(path: Path, case: str | None = None) -> Source:
    """Build what is to be drawn of a result: a case of its study, with its findings marked.

    Breaches are marked by number; otherwise the nearest distances are marked. A motion shows its
    contacts by number.

    Parameters
    ----------
    path
        A result.json or the folder that holds it.
    case
        Name of the case. If None: the case that failed, or came nearest to failing.

    Raises
    ------
    InputError
        If the study does not exist, or one of its files has changed since.
    """
    result = load_result(path)
    study = load_study(find("studies", result.study))
    made_from = result.provenance.get("inputs", {})
    for role, file in study.inputs.items():
        if made_from.get(role) != hashlib.sha256(file.read_bytes()).hexdigest():
            raise InputError(
                f"{path}: {file} is not as it was when this result was made; run the study again"
            )
    motion = _shown_motion(result, case)
    if motion is not None:
        return _with_contacts(study_source(study, case or motion.case), motion)
    if result.postures:
        return _with_findings(study_source(study, case or _worst_case(result)), result)
    raise InputError(f"{path}: a result of a population has no case to draw; see its report")


def _shown_motion(result: ResultFile, case: str | None) -> MotionRows | None:
    """Return the first motion of the named cases; of a result of motions alone the first."""
    if case is None:
        return result.motions[0] if result.motions and not result.postures else None
    names = _split_names(case)
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
    labelled += [(f, f"{f.value:.1f} {f.unit}", "clearance") for f in passed if in_case(f)]
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
    named = case is not None and bool(motions & set(_split_names(case)))
    if named or not study.postures:
        return _motion_source(single, case)
    return _posture_source(single, case)


def _posture_source(study: Study, case: str | None) -> Source:
    """Build cases of a study of people in postures: the first, or those that are named."""
    there = present_people(study)
    known = tuple(each.name for each in study.postures)
    chosen = _chosen_cases(study.name, known, case)
    if case is None:
        chosen = chosen[:1]
    rows = np.array([known.index(name) for name in chosen])
    persons = tuple(
        Person(role.name, mine[0].body, poses_of(mine).rows(rows))
        for role, mine in zip(there.roles, there.situations, strict=True)
    )
    bodies = tuple(
        SceneBody(place(person.body, person.poses), 0, PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)])
        for i, person in enumerate(persons)
    )
    description = ", ".join(chosen) if len(chosen) < 9 else ""
    scene = Scene(bodies, there.environment, (), study.title, description)
    people = tuple(person.name for person in persons)
    return Source(scene, chosen, people, persons)


def _chosen_cases(study: str, known: tuple[str, ...], case: str | None) -> tuple[str, ...]:
    """Return the named cases, all if None."""
    chosen = _split_names(case) if case is not None else known
    for name in chosen:
        if name not in known:
            raise UsageError(f"study {study} has no case {name!r}; {one_of(name, known)}")
    return chosen


def _motion_source(study: Study, case: str | None) -> Source:
    """Build a motion in its environment, over the other motions of the cases."""
    chosen = _chosen_cases(study.name, tuple(each.name for each in study.motions), case)
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


def _split_names(text: str) -> tuple[str, ...]:
    """Return the names of a list with commas between."""
    listed = tuple(name.strip() for name in text.split(","))
    if not all(listed):
        raise UsageError(f"names with commas between are needed, got {text!r}")
    return listed


def _body_source(source: str, poses: str | None) -> Source:
    """Build a body in postures; several are a motion with a second from each to the next."""
    body = load_body(source)
    path = posture_path(source)
    if path is None:
        raise InputError(f"body {body.name} names no postures file")
    file, _ = load_postures(path, body)
    default = "standing" if "standing" in file.postures else next(iter(file.postures))
    chosen = (default,) if poses is None else _split_names(poses)
    joined = join_poses([posture_pose(body, file, name) for name in chosen])
    if len(chosen) > 1:
        joined = replace(joined, time=np.arange(len(chosen), dtype=np.float64))
    person = Person(body.name, body, joined)
    scene = Scene((SceneBody(place(body, joined), 0),), None, (), body.name, ", ".join(chosen))
    return Source(scene, chosen, (body.name,), (person,), len(chosen) > 1)


def source_kind(source: str) -> str:
    """Return body, environment, study or result for a path or a name of the catalogue.

    Raises
    ------
    InputError
        If it is anything else.
    """
    path = Path(source)
    if is_there(path):
        is_result = path.suffix == ".json" or (path / "result.json").is_file()
        kind = "result" if is_result else kind_of(path)
        if kind in ("body", "environment", "study", "result"):
            return kind
        raise InputError(
            f"{source}: a body, an environment, a study or a result is needed (got {kind})"
        )
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
