"""From the name of a body, an environment, a study or a result to the scene that shows it."""

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
from workbench.files.crash.results import CrashResultFile
from workbench.files.environments import load_environment
from workbench.files.kinds import kind_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.results import ResultFile, load_result
from workbench.files.study.reader import load_study
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.moving import poses_at
from workbench.model.poses import Placed, Poses
from workbench.model.posing import join_poses
from workbench.model.posture_study import Person, PostureStudy
from workbench.model.study import Study
from workbench.study.pipelines import motion_study, posture_study
from workbench.study.placement import adjusted_environment, place_person
from workbench.study.predicted import prepared

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


@dataclass(frozen=True, eq=False)
class Source:
    """What is to be drawn. scene: its bodies hold P poses each and show the first.

    names: of the poses or cases, P of them, none for the frames of a recorded motion; people: of
    the bodies. persons: who moves and where, empty for an environment; a body by itself is a person
    in no seat. under: the same of the scene's ghosts. moving: those whose poses have times move,
    and `at` gives them at any time; a recorded motion's scene holds its first frame only. notes:
    what the numbers of marks mean, and what was assumed. kinds: of marks that are asked for, which
    move along (see marking); fixed: marks that do not.
    """

    scene: Scene
    names: tuple[str, ...] = ()
    people: tuple[str, ...] = ()
    persons: tuple[Person, ...] = ()
    moving: bool = False
    notes: tuple[str, ...] = ()
    under: tuple[Person, ...] = ()
    kinds: tuple[str, ...] = ()
    fixed: tuple[Mark, ...] = ()

    def at(self, times: Floats) -> Source:
        """Everybody who moves in F poses at times (F,) [s] of the motion; everybody else as they
        are."""
        rows = [
            [
                self._moved(shown, person, times)
                for shown, person in zip(bodies, persons, strict=True)
            ]
            for bodies, persons in (
                (self.scene.bodies, self.persons),
                (self.scene.ghosts, self.under),
            )
        ]
        scene = replace(
            self.scene, bodies=tuple(r[0] for r in rows[0]), ghosts=tuple(r[0] for r in rows[1])
        )
        return replace(
            self,
            scene=scene,
            persons=tuple(r[1] for r in rows[0]),
            under=tuple(r[1] for r in rows[1]),
        )

    def _moved(self, shown: SceneBody, person: Person, times: Floats) -> tuple[SceneBody, Person]:
        if person.poses.time is None:
            return shown, person
        moved = replace(person, poses=poses_at(person.poses, times))
        return replace(shown, placed=_placed(moved, self.scene.environment), pose=0), moved


def scene_of(source: str, *, posture: str | None = None, case: str | None = None) -> Scene:
    """The scene of a body in a posture, of an environment, or of a case of a study. See
    source_of."""
    return build_source(source, poses=posture, case=case).scene


def build_source(source: str, *, poses: str | None = None, case: str | None = None) -> Source:
    """A body in one posture or several ("standing,seated"), an environment, or one or several cases
    of a study.

    Where none is named: a body standing, or in the first posture it has; the first case of a study,
    or all of one whose poses are a motion. InputError for what is not there; UsageError for a case
    the study does not have, and for postures and cases where there are none.
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
    """UsageError for postures of what is no body and cases of what is no study."""
    cases = kind in ("study", "result")
    if poses is not None and kind != "body":
        raise UsageError(
            f"{source} is {_an(kind)}: --pose is for bodies{', --case for studies' if cases else ''}"
        )
    if case is not None and not cases:
        raise UsageError(
            f"{source} is {_an(kind)}: --case is for studies{', --pose for bodies' if kind == 'body' else ''}"
        )


def result_source(path: Path, case: str | None = None) -> Source:
    """A case of the study that a result was made from, with its findings marked: breaches by
    number, else distances.

    The case where something failed, or came nearest to it, if none is named; of a crash what was
    met by number. InputError where the study is not found by its name, or one of its files has
    changed since.
    """
    rows = load_result(path)
    study = load_study(find("studies", rows.study))
    made = rows.provenance.get("inputs", {})
    for role, file in study.inputs.items():
        if made.get(role) != hashlib.sha256(file.read_bytes()).hexdigest():
            raise InputError(
                f"{path}: {file} is not as it was when this result was made; run the study again"
            )
    if isinstance(rows, CrashResultFile):
        if not study.moves:
            raise InputError(
                f"{path}: the study {rows.study} is of another kind than this result; run it again"
            )
        source = study_source(study, case)
        faults = [meeting for meeting in rows.contacts if meeting.depth_mm > meeting.allowed_mm]
        marks = [
            Mark(_metres(m.point_mm), str(n), "contact") for n, m in enumerate(faults, start=1)
        ]
        notes = tuple(
            f"{number}: {meeting.sentence}" for number, meeting in enumerate(faults, start=1)
        )
        return replace(
            source, scene=replace(source.scene, marks=tuple(marks)), notes=source.notes + notes
        )
    if study.moves or study.crowd is not None:
        raise InputError(
            f"{path}: the study {rows.study} is of another kind than this result; run it again"
        )
    return _findings(study_source(study, case or _worst_case(rows)), rows)


def _worst_case(rows: ResultFile) -> str:
    """The case where something failed, or came nearest to it."""
    verdicts = sorted((v for v in rows.verdicts if v.worst), key=lambda v: v.passed)
    return verdicts[0].worst.case if verdicts and verdicts[0].worst else rows.cases[0]


def _findings(source: Source, rows: ResultFile) -> Source:
    """The source with the findings of a result that belong to its first case as marks, and in
    words."""
    breaches = [
        f for v in rows.verdicts for f in v.breaches if f.case == source.names[0] and f.point_mm
    ]
    nearest = [
        v.worst for v in rows.verdicts if v.passed and v.worst and v.worst.case == source.names[0]
    ]
    marks = [
        Mark(_metres(f.point_mm), str(n), "contact")
        for n, f in enumerate(breaches, start=1)
        if f.point_mm
    ]
    marks += [
        Mark(_metres(f.point_mm), f"{f.value:.1f} {f.unit}", "clearance")
        for f in nearest
        if f.point_mm
    ]
    notes = tuple(
        f"{number}: {finding.sentence}" for number, finding in enumerate(breaches, start=1)
    )
    return replace(source, scene=replace(source.scene, marks=tuple(marks)), notes=notes)


def _metres(point: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = (value / 1000.0 for value in point)
    return x, y, z


def study_source(study: Study, case: str | None = None) -> Source:
    """The cases of a study, by name with commas between, as a run measures them; see source_of."""
    if study.moves:
        return _motion_source(study, case)
    return _posture_source(posture_study(study), case)


def _posture_source(study: PostureStudy, case: str | None) -> Source:
    study, _ = prepared(study)
    timed = all(person.poses.time is not None for person in study.people)
    wanted = _cases(study.name, study.cases, case)
    if case is None and not timed:
        wanted = wanted[:1]
    rows = [study.cases.index(name) for name in wanted]
    persons = tuple(replace(person, poses=_chosen(person.poses, rows)) for person in study.people)
    environment = adjusted_environment(study)
    bodies = tuple(
        SceneBody(place_person(person, environment), 0, PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)])
        for i, person in enumerate(persons)
    )
    scene = Scene(
        bodies, environment, (), study.title, ", ".join(wanted) if len(wanted) < 9 else ""
    )
    return Source(
        scene, tuple(wanted), tuple(p.name for p in persons), persons, timed and len(rows) > 1
    )


def _cases(study: str, known: tuple[str, ...], case: str | None) -> tuple[str, ...]:
    """The cases that are named, all where none is; UsageError for one that is not there."""
    wanted = _listed(case) if case is not None else known
    for name in wanted:
        if name not in known:
            raise UsageError(f"study {study} has no case {name!r}; {one_of(name, known)}")
    return wanted


def _motion_source(study: Study, case: str | None) -> Source:
    """A motion in its environment, and a second one under it. See Source.at.

    UsageError for a case that is not there. InputError for a motion that cannot be read.
    """
    wanted = _cases(study.name, tuple(each.name for each in study.cases), case)
    first = motion_study(study)
    motions = [first] if first.held is None else [first, first.held]
    motions = [motion for motion in motions if motion.motion_name in wanted]
    shown = [Person(first.person, motions[0].body, motions[0].motion, ())]
    key: tuple[tuple[str, str], ...] = ()
    if len(motions) > 1:
        shown.append(Person(motions[1].motion_name, motions[1].body, motions[1].motion, ()))
        key = tuple(
            (motion.motion_name, colour)
            for motion, colour in zip(motions, PEOPLE_COLOURS, strict=False)
        )
    bodies = tuple(
        SceneBody(place(person.body, _chosen(person.poses, [0])), 0, colour)
        for person, colour in zip(shown, PEOPLE_COLOURS, strict=False)
    )
    scene = Scene(bodies[:1], motions[0].cabin, (), first.title, "", bodies[1:], key)
    persons = tuple(shown)
    return Source(scene, (), (first.person,), persons[:1], True, under=persons[1:])


def _chosen(poses: Poses, rows: list[int]) -> Poses:
    time = None if poses.time is None else poses.time[rows]
    return Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows], time)


def _placed(person: Person, environment: Environment | None) -> Placed:
    return (
        place(person.body, person.poses)
        if environment is None
        else place_person(person, environment)
    )


def _listed(text: str) -> tuple[str, ...]:
    """Names with commas between; UsageError where one is missing."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found):
        raise UsageError(f"names with commas between are needed, got {text!r}")
    return found


def _body_source(source: str, poses: str | None) -> Source:
    body = load_body(source)
    path = posture_path(source)
    if path is None:
        raise InputError(f"body {body.name} names no postures file")
    file, _ = load_postures(path, body)
    usual = "standing" if "standing" in file.postures else next(iter(file.postures))
    wanted = (usual,) if poses is None else _listed(poses)
    joined = join_poses([posture_pose(body, file, name) for name in wanted])
    if len(wanted) > 1:
        joined = replace(
            joined, time=np.arange(len(wanted), dtype=np.float64)
        )  # a second from each to the next
    person = Person(body.name, body, joined, wanted)
    scene = Scene((SceneBody(place(body, joined), 0),), None, (), body.name, ", ".join(wanted))
    return Source(scene, wanted, (body.name,), (person,), len(wanted) > 1)


def _an(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def source_kind(source: str) -> str:
    """body, environment, study or result, of a path or a catalogue name; InputError for anything
    else."""
    path = Path(source)
    if is_there(path):
        kind = (
            "result"
            if path.suffix == ".json" or (path / "result.json").is_file()
            else kind_of(path)
        )
        if kind in ("body", "environment", "study", "result"):
            return kind
        raise InputError(
            f"{source}: a body, an environment, a study or a result is needed (got {kind})"
        )
    known = {
        "body": names("bodies"),
        "environment": names("environments", "environment.yaml"),
        "study": names("studies"),
    }
    for kind, there in known.items():
        if source in there:
            return kind
    raise InputError(
        f"nothing is called {source!r}; {one_of(source, [n for row in known.values() for n in row])}"
    )
