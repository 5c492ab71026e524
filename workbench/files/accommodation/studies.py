"""Accommodation studies: everything they name is loaded and checked; people stay to be drawn by the
study."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from workbench.errors import InputError
from workbench.files.accommodation.faults import plan_faults, subparts_of
from workbench.files.accommodation.people import drawn_from, people_files, rows_of
from workbench.files.accommodation.schema import AccommodationFile, ChangeFile, DemandFile
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.encumbrances import worn
from workbench.files.catalogue import find
from workbench.files.environments import environment_files, load_environment
from workbench.files.postures import PosturesFile, load_postures, posture_path, posture_pose
from workbench.files.schema import fail, validate
from workbench.files.study_aims import driving_aims
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.accommodation import Change, MapTask
from workbench.model.body import Body
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.population import Population, PopulationModel
from workbench.model.poses import Poses
from workbench.model.study import Aims, Criterion

__all__ = ["AccommodationPlan", "load_accommodation"]


@dataclass(frozen=True, eq=False)
class AccommodationPlan:
    """An accommodation study as its file has it, all it names loaded.

    people: the rows of its files, or the model that people are to be drawn from; pose: the posture
    `like` of the body.
    """

    file: AccommodationFile
    environment: Environment
    body: Body
    pose: Poses
    wears: tuple[Encumbrance, ...]
    people: Population | PopulationModel
    aims: Aims
    criteria: tuple[Criterion, ...]
    maps: tuple[MapTask, ...]
    changes: tuple[Change, ...]
    inputs: dict[str, Path]


@dataclass
class _Work:
    """What is being loaded: the file's place, the files found so far by role, the faults found so
    far."""

    path: Path
    document: Document
    file: AccommodationFile
    inputs: dict[str, Path]
    faults: list[str]

    def fault(self, key: Iterable[str | int], error: InputError) -> None:
        """Faults of a file that is named at a key."""
        self.faults += [fail(self.document, key, problem) for problem in error.problems]


def load_accommodation(source: str | Path) -> AccommodationPlan:
    """Load an accommodation study by catalogue name or path. InputError lists every fault with its
    line."""
    path = find("studies", str(source))
    document = read_yaml(path)
    file = validate(document, AccommodationFile)
    work = _Work(path, document, file, {"study": path}, [])
    environment = _environment(work)
    body = _body(work)
    people = _people(work)
    wears = _wears(work, body[0]) if body is not None else ()
    work.faults += plan_faults(document, file, (environment, *(body or (None, None))))
    if work.faults or environment is None or body is None or people is None:
        raise InputError(work.faults)
    feet = file.posture.feet
    hands = file.posture.hands
    held = {
        "left foot": feet.left,
        "right foot": feet.right,
        "left hand": hands.left,
        "right hand": hands.right,
    }
    return AccommodationPlan(
        file=file,
        environment=environment,
        body=body[0],
        pose=posture_pose(*body, file.posture.like),
        wears=wears,
        people=people,
        aims=Aims(
            {limb: name for limb, name in held.items() if name},
            file.posture.eyes,
            file.posture.heels,
            driving_aims(file.posture.driver),
        ),
        criteria=tuple(_criterion(row, environment, body[0]) for row in file.criteria),
        maps=tuple(
            MapTask(row.part, row.grip, row.zone, row.hand, row.points) for row in file.maps
        ),
        changes=tuple(_change(row) for row in file.changes),
        inputs=work.inputs,
    )


def _environment(work: _Work) -> Environment | None:
    try:
        source = find(
            "environments", work.file.environment, "environment.yaml", near=work.path.parent
        )
    except InputError as error:
        work.fault(("environment",), error)
        return None
    try:
        environment = load_environment(source)
    except InputError as error:
        work.faults += error.problems
        return None
    work.inputs |= {
        f"environment: {p.relative_to(source.parent)}": p for p in environment_files(source)
    }
    return environment


def _body(work: _Work) -> tuple[Body, PosturesFile] | None:
    try:
        source = body_path(work.file.body, near=work.path.parent)
        body = load_body(source)
        postures = posture_path(source)
        if postures is None:
            raise InputError(
                f"body {body.name!r} names no postures file, so no posture can be named here"
            )
        loaded = body, load_postures(postures, body)[0]
    except InputError as error:
        work.fault(("body",), error)
        return None
    work.inputs |= {"body": source, "postures": postures}
    return loaded


def _people(work: _Work) -> Population | PopulationModel | None:
    file = work.file.population
    near = work.path.parent
    try:
        work.inputs |= people_files(file, near)
        return rows_of(file, near) if file.files is not None else drawn_from(file, near)
    except InputError as error:
        if file.files is not None:
            work.faults += error.problems
        else:
            work.fault(("population", "source"), error)
        return None


def _wears(work: _Work, body: Body) -> tuple[Encumbrance, ...]:
    wanted = work.file.encumbrance
    near = work.path.parent
    try:
        work.inputs |= {item: find("bodies/encumbrance", item, near=near) for item in wanted}
        return worn(wanted, body, near=near)
    except InputError as error:
        work.fault(("encumbrance",), error)
        return ()


def _criterion(row: DemandFile, environment: Environment, body: Body) -> Criterion:
    visible = [
        name
        for name, hidden in zip(environment.parts, environment.hidden, strict=True)
        if not hidden
    ]
    angle = math.radians(row.degrees or 0.0)
    return Criterion(
        name=row.name,
        check=row.check,
        people=(),
        segments=_matching(row.segments, body.segments),
        parts=_matching(row.parts, visible) if row.check != "vision" or row.parts else (),
        at_least=angle if row.check in ("stops", "vision") else row.at_least or 0.0,
        controls=_matching(row.controls, [control.name for control in environment.controls]),
        zone=row.zone,
        hand=row.hand,
        subparts=_matching(row.subparts, subparts_of(body)) if row.subparts else (),
        below=math.inf if row.at_most_below is None else row.at_most_below,
        above=math.inf if row.at_most_above is None else row.at_most_above,
    )


def _matching(patterns: list[str] | None, known: Iterable[str]) -> tuple[str, ...]:
    """The known names that match any pattern; all of them where none is given."""
    names = list(known)
    return tuple(
        n for n in names if patterns is None or any(fnmatchcase(n, pattern) for pattern in patterns)
    )


def _change(row: ChangeFile) -> Change:
    return Change(
        words=row.name,
        control=row.control or "",
        parts=tuple(row.parts or ()),
        move=row.move or (0.0, 0.0, 0.0),
        travel_forward=(-row.farther_back, row.farther_forward),
        travel_up=(-row.lower, row.higher),
    )
