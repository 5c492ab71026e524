"""Read a study file: everything it names is loaded and checked, and all its faults are reported at
once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from workbench.errors import InputError
from workbench.files.catalogue import find, is_file
from workbench.files.crash.restraints import contact_faults, law_in_si
from workbench.files.environments import environment_files, load_environment
from workbench.files.meshes.reading import FORMATS
from workbench.files.names import matching
from workbench.files.postures import AreaFile, StandFile
from workbench.files.study.actions import (
    CaseActions,
    library_of,
    load_actions,
    with_postures,
)
from workbench.files.study.criteria import Known, criteria_of, visible_parts
from workbench.files.study.doubts import length_doubts, study_doubts
from workbench.files.study.moves import change_of, move_faults, moves_of
from workbench.files.study.parts import read_parts
from workbench.files.study.roles import LoadedRole, load_roles, place_faults
from workbench.files.study.schema import ActionFile, PositionFile, RoleFile, StudyFile
from workbench.files.study.settings import SeatedRole, adjusts_of, stated_settings
from workbench.files.study.work import Key, Work
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.accommodation import IntervalRule, MapTask
from workbench.model.criterion import Criterion
from workbench.model.envelope import ReachTask
from workbench.model.environment import Environment
from workbench.model.motion_case import SignalPoint
from workbench.model.study import (
    Case,
    ContactForce,
    RecordedMotion,
    Role,
    Shares,
    Signals,
    SimulatedMotion,
    Statement,
    Study,
    sealed,
)
from workbench.model.surroundings import adjusted, displaced
from workbench.model.workplace import Stand

__all__ = ["limit_faults", "load_study", "read_study"]

OLD_FILE = (
    "a study has no kind now. `kind: accommodation` becomes `people` with a `population`, "
    "`kind: crash` a case with a `motion`, `vision` becomes `eye_height` or `view_over`; "
    "docs/studies.md shows all"
)


def load_study(source: str | Path) -> Study:
    """Load a study by catalogue name or path, with all it names.

    Parameters
    ----------
    source
        The name of a study of the catalogue, or the path of a file.

    Returns
    -------
    Study
        The study with its environment, bodies, postures and populations; names are resolved,
        lengths in metres, angles in radians.

    Raises
    ------
    InputError
        With a line for each fault of the file, and for those of the files that it names.

    Examples
    --------
    >>> import workbench as wb
    >>> study = wb.load_study("trainer_clearance")
    >>> [criterion.name for criterion in study.criteria][:2]
    ['nobody is in the structure', 'head to canopy']
    """
    _check_study(Path(source))
    path = find("studies", str(source))
    document = read_yaml(path)
    if isinstance(document.value, dict) and not {"study", "kind"} & set(document.value):
        _check_no_place(path, set(document.value))
    if isinstance(document.value, dict) and "kind" in document.value:
        raise InputError(f"{document.where(('kind',))}: kind: {OLD_FILE}")
    return read_study(document, path, {"study": path})


def read_study(
    document: Document,
    path: Path,
    inputs: Mapping[str, Path],
    loaded: Mapping[Path, Environment] = MappingProxyType({}),
) -> Study:
    """Make the study that a document states, with all it names.

    Parameters
    ----------
    document
        Of a file, or of a call in Python.
    path
        A file in the folder from which names are looked for.
    inputs
        The files that the document itself is, by role.
    loaded
        Environments that are there already, by their files.

    Raises
    ------
    InputError
        With a line for each fault of the document, and for those of the files that it names.
    """
    parts, faults = read_parts(document)
    work = Work(path, document, parts, faults, dict(inputs), dict(loaded))
    room = _environment(work)
    roles = load_roles(work)
    place_faults(work, roles, room)
    roles = with_postures(work, roles)
    actions = load_actions(work, roles, room)
    known = _known(work, room, roles, actions)
    criteria = criteria_of(work, known)
    _case_faults(work)
    _other_faults(work, known)
    if parts.people_whole:
        _whole_faults(work)
        limit_faults(work)
    if work.faults or room is None or parts.file is None:
        raise InputError(_sorted(document, work.faults))
    return _study(work, parts.file, known, actions, criteria)


def _sorted(document: Document, faults: list[str]) -> list[str]:
    """Faults of named files first, then those of the study in the order of its lines."""
    lead = f"{document.file}:"
    own = [line for line in faults if line.startswith(lead)]

    def place(line: str) -> tuple[int, ...]:
        words = line[len(lead) :].split(":", 2)
        return tuple(int(word) for word in words[:2] if word.isdigit())

    return [line for line in faults if line not in own] + sorted(own, key=place)


def _check_study(path: Path) -> None:
    """InputError with the way on where a path is that of a mesh or an environment's folder."""
    if path.suffix.lower() in FORMATS:
        raise InputError(
            f"{path}: is a mesh, and a study is needed: 'workbench live {path}' makes an "
            f"environment of it by pointing, 'workbench new' then a first study"
        )
    if is_file(path / "environment.yaml"):
        _check_no_place(path, {"environment", "meshes"})


def _check_no_place(path: Path, keys: set[Any]) -> None:
    """InputError with the way on where a file with these keys is that of an environment."""
    if {"environment", "meshes"} <= keys:
        raise InputError(
            f"{path}: is an environment, and a study is needed: 'workbench new {path}' writes a "
            f"first study of it"
        )


def _environment(work: Work) -> Environment | None:
    if work.parts.environment is None or isinstance(work.parts.environment, Environment):
        return work.parts.environment
    near = work.path.parent
    if Path(work.parts.environment).suffix.lower() in FORMATS:
        name = work.parts.environment
        what = f"{name} is a bare mesh; `workbench live {name}` makes its environment.yaml"
        work.fault(("environment",), what)
        return None
    try:
        source = find("environments", work.parts.environment, "environment.yaml", near=near)
    except InputError as error:
        work.errors(("environment",), error)
        return None
    try:
        room = work.environments.get(source) or load_environment(source)
    except InputError as error:
        work.add(error.problems)
        return None
    work.environments[source] = room
    work.inputs |= {
        f"environment: {p.relative_to(source.parent)}": p for p in environment_files(source)
    }
    return room


def _known(
    work: Work, room: Environment | None, roles: dict[str, LoadedRole], actions: CaseActions
) -> Known:
    """The names that the study may use: parts with the belts and airbags of its motions."""
    parts = list(visible_parts(room)) if room is not None else []
    for action in actions.values():
        if isinstance(action, (RecordedMotion, SimulatedMotion)):
            parts += action.restraints.names
    hidden = set(room.parts) - set(parts) if room is not None else set()
    complete = len(roles) == len(work.parts.roles) and bool(roles)
    return Known(room, roles, tuple(dict.fromkeys(parts)), frozenset(hidden), complete)


def _case_faults(work: Work) -> None:
    """Report cases of one name, roles that are missing, and actions of nobody."""
    _report_repeated(
        work,
        [(("cases", row, "name"), case.name) for row, case in work.parts.cases],
        "two cases are named {name!r}; give each a name of its own",
    )
    roles = work.parts.roles
    for row, case in work.parts.cases:
        key = ("cases", row, "people")
        for name in roles if case.actions else ():
            if name not in case.actions:
                what = f"the action of {name!r} is missing; every role acts in every case"
                work.fault(key, what)
        for name in case.actions if roles else ():
            work.check_name((*key, name), name, roles, f"nobody is called {name!r}")


def _report_repeated(work: Work, named: list[tuple[Key, str]], what: str) -> None:
    """Report the names that stand a second time. what: the message, with {name!r} in it."""
    seen: set[str] = set()
    for key, name in named:
        if name in seen:
            work.fault(key, what.format(name=name))
        seen.add(name)


def _other_faults(work: Work, known: Known) -> None:
    """Report names of nothing in what the study asks for beside its criteria."""
    parts = work.parts
    for kind, tasks in (("reach_maps", parts.maps), ("reach_envelopes", parts.envelopes)):
        for row, task in tasks:
            _reach_person_faults(work, (kind, row), task.people)
            _reach_case_faults(work, (kind, row), task.case)
    for place, name in enumerate(parts.compare or ()):
        what = f"no case is called {name!r}"
        work.check_name(("compare", place), name, parts.case_names, what)
    _named_twice(work)
    if known.room is not None:
        _room_faults(work, known.room)
        move_faults(work, known.room)
    if known.complete:
        _body_faults(work, known)


def _named_twice(work: Work) -> None:
    """Report changes and signal points of one name."""
    changes: list[tuple[Key, str]] = [
        (("changes", row, "name"), change.name) for row, change in work.parts.changes
    ]
    points = work.parts.signals.points if work.parts.signals else ()
    signals: list[tuple[Key, str]] = [
        (("signals", "points", i, "name"), point.name) for i, point in enumerate(points)
    ]
    for kind, named in (("changes", changes), ("signals", signals)):
        what = f"two of {kind} are named {{name!r}}; give each a name of its own"
        _report_repeated(work, named, what)


def _reach_person_faults(work: Work, key: Key, name: str) -> None:
    """Report a reach of nobody, or of somebody who neither sits nor stands."""
    key = (*key, "people")
    if not work.check_name(key, name, work.parts.roles, f"nobody is called {name!r}"):
        return
    role = work.parts.roles[name]
    if role is not None and role.seat is None and role.stand is None:
        what = (
            f"{name!r} neither sits nor stands, so nothing says which way is ahead; "
            "give the role a 'seat' or 'stand'"
        )
        work.fault(key, what)


def _reach_case_faults(work: Work, key: Key, name: str | None) -> None:
    """Report a reach that begins at no case, or at a motion."""
    if name is not None:
        what = f"no case is called {name!r}"
        if not work.check_name((*key, "case"), name, work.parts.case_names, what):
            return
    if not _posture_cases(work, name):
        which = f"{name!r} is a motion" if name else "all cases are motions"
        work.fault((*key, "case") if name else key, f"reaches begin at a posture: {which}")


def _posture_cases(work: Work, name: str | None) -> list[int]:
    """The indices of the cases that are postures; of those of a name where one is given."""
    return [
        index
        for index, (_, case) in enumerate(work.parts.cases)
        if not case.moves and name in (None, case.name)
    ]


def _room_faults(work: Work, room: Environment) -> None:
    """Report the parts of maps and the seats of changes that the environment has not."""
    for row, task in work.parts.maps:
        what = f"environment {room.name} has no part {task.part!r}"
        work.check_name(("reach_maps", row, "part"), task.part, room.parts, what)
    seats = [seat.name for seat in room.seats]
    for row, change in work.parts.changes:
        if change.seat is not None:
            what = f"environment {room.name} has no seat {change.seat!r}"
            work.check_name(("changes", row, "seat"), change.seat, seats, what)


def _body_faults(work: Work, known: Known) -> None:
    """Report what signals and contact forces name that the body or the environment has not."""
    body = next(iter(known.roles.values())).body
    for row, point in enumerate(work.parts.signals.points if work.parts.signals else ()):
        what = f"body {body.name} has no segment {point.segment!r}"
        key = ("signals", "points", row, "segment")
        work.check_name(key, point.segment, body.segments, what)
    if known.room is not None:
        laws = [(("contact_forces", row), law) for row, law in work.parts.forces]
        work.add(contact_faults(work.document, laws, body, known.parts))


@dataclass(frozen=True)
class _ActingRole:
    """A role of the file, with what it does in the cases that can be read."""

    name: str
    file: RoleFile
    actions: list[ActionFile]

    @property
    def key(self) -> Key:
        """Where the role stands in the file."""
        return ("people", self.name)

    @property
    def predicts(self) -> bool:
        """Whether a posture is predicted in any case."""
        return any(action.predicts for action in self.actions)

    @property
    def free(self) -> bool:
        """Whether the seat goes where the person wants it, or the person steps."""
        if self.file.stand is not None:
            return self.file.stand.area is not None
        return self.predicts if self.file.position is None else self.file.position == "free"


def _acting(work: Work, name: str, file: RoleFile) -> _ActingRole:
    """A role with its actions, case by case."""
    found = (case.actions.get(name) for _, case in work.parts.cases)
    return _ActingRole(name, file, [action for action in found if action is not None])


def _whole_faults(work: Work) -> None:
    """Report what the study as a whole lacks or has too much of."""
    for name, file in work.parts.roles.items():
        if file is not None:
            role = _acting(work, name, file)
            _place_faults(work, role)
            _free_seat_faults(work, role)
            _subject_faults(work, name)
            _simulated_faults(work, role)
    _pointless_faults(work)
    _moved_seat_faults(work)
    _compare_faults(work)
    rows = work.document.value.get("criteria")
    whole = isinstance(rows, list) and 0 < len(rows) == len(work.parts.criteria_whole)
    if whole and not any(criterion.check != "share" for _, criterion in work.parts.criteria):
        what = "nothing is left to ask: a share is of those who meet other criteria; add one"
        work.fault(("criteria",), what)


def _pointless_faults(work: Work) -> None:
    """Report what is asked of a population or of motions where the study has none."""
    people = "are of a population; give a role a 'population', or leave them out"
    motions = "are of motions; give a case a 'motion', or leave them out"
    for key, there, what in (
        ("shares", work.parts.crowd is not None, people),
        ("changes", work.parts.crowd is not None, people),
        ("signals", work.parts.moves, motions),
        ("contact_forces", work.parts.moves, motions),
    ):
        if work.document.value.get(key) and not there:
            work.fault((key,), f"'{key}' {what}")


def _moved_seat_faults(work: Work) -> None:
    """Report changes of a seat in which the population does not sit."""
    crowd = work.parts.roles[work.parts.crowd] if work.parts.crowd is not None else None
    if crowd is None:
        return
    what = "the population has no seat, so this changes nothing for it; move a part"
    if crowd.seat is not None:
        what = f"the population sits in {crowd.seat!r}, so this changes nothing for it; "
        what += f"valid: {crowd.seat}"
    for row, change in work.parts.changes:
        if change.seat is not None and change.seat != crowd.seat:
            work.fault(("changes", row, "seat"), what)


def _place_faults(work: Work, role: _ActingRole) -> None:
    """Report a place that is missing, or that a motion states already."""
    still = any(not action.moves for action in role.actions)
    place = next((k for k in ("seat", "at", "stand") if getattr(role.file, k) is not None), None)
    if place is None and still:
        what = "'seat', 'at' or 'stand' must say where the role is; only motions say so themselves"
        work.fault(role.key, what)
    if place is not None and role.actions and not still:
        what = f"a motion says itself where the role is: leave {place!r} out"
        work.fault((*role.key, place), what)


def _free_seat_faults(work: Work, role: _ActingRole) -> None:
    """Report a free seat beside a given posture, or that no case can set."""
    file = role.file
    given = any(action.posture is not None for action in role.actions)
    if file.seat is not None and role.free and given:
        what = (
            "the seat is free and a case gives the posture, so hands and feet would not follow; "
            "give 'position: reference', or predict the posture of every case"
        )
        work.fault((*role.key, "position" if file.position is not None else "seat"), what)
    if file.position == "free" and not role.predicts and not given:
        what = "a free seat needs a case that predicts the posture"
        work.fault((*role.key, "position"), what)


def _subject_faults(work: Work, name: str) -> None:
    """Report motions after the first case that make the body of a role from their subject."""
    for row, case in work.parts.cases[1:]:
        action = case.actions.get(name)
        if action is not None and action.motion is not None and action.motion.scale == "subject":
            what = "one body makes all motions: 'scale: subject' belongs to the first case"
            work.fault(("cases", row, "people", name, "motion", "scale"), what)


def _simulated_faults(work: Work, role: _ActingRole) -> None:
    """Report a body that is changed although a simulation brings its own."""
    keys = ("size", "sizes", "clothes", "without", "stops", "detail")
    changed = [k for k in keys if getattr(role.file, k)]
    if changed and any(action.simulated is not None for action in role.actions):
        what = "the body of a simulated motion is that of the simulation; leave its changes out"
        work.fault((*role.key, changed[0]), what)


def _compare_faults(work: Work) -> None:
    """Report a comparison of a case with itself, or of one that is no motion."""
    if work.parts.compare is None or len(work.parts.compare) != 2:
        return
    cases = {case.name: case for _, case in work.parts.cases}
    one, two = work.parts.compare
    if one == two and one in cases:
        what = f"{one!r} is named twice; two different cases are compared"
        work.fault(("compare", 1), what)
    for place, name in enumerate(work.parts.compare):
        actions = cases[name].actions.values() if name in cases else ()
        if any(action is not None and not action.moves for action in actions):
            what = f"case {name!r} is no motion; two motions of one role are compared"
            work.fault(("compare", place), what)


def _study(
    work: Work, file: StudyFile, known: Known, actions: CaseActions, criteria: list[Criterion]
) -> Study:
    """The study of a file that has no fault."""
    room = known.room
    assert room is not None
    moved = moves_of(file.moved, room)
    stood = room
    room = displaced(stood, moved)
    stated = stated_settings(file.people, room)
    adjusts = adjusts_of(_sitters(work, file), room, stated)
    study = Study(
        name=file.study,
        title=file.title or file.study,
        description=file.description,
        environment=adjusted(room, stated),
        roles=tuple(
            replace(_role(work, name, known.roles[name]), adjusts=adjusts.get(name, ()))
            for name in file.people
        ),
        cases=tuple(
            Case(case.name, tuple(actions[row, name] for name in file.people))
            for row, case in enumerate(file.cases)
        ),
        criteria=tuple(criteria),
        inputs=work.inputs,
        settings=stated,
        moved=moved,
        shares=_shares(file),
        reach_maps=tuple(
            MapTask(
                part=row.part,
                grip=row.grip,
                zone=row.zone,
                hand=row.hand,
                points=row.points,
                case=_posture_cases(work, row.case)[0],
                sees=row.sees,
            )
            for row in file.reach_maps
        ),
        reach_envelopes=tuple(
            ReachTask(
                row.people,
                f"{row.hand} hand",
                row.grip,
                row.zone,
                row.obstacles,
                _posture_cases(work, row.case)[0],
            )
            for row in file.reach_envelopes
        ),
        changes=tuple(change_of(row, room) for row in file.changes),
        compare=_compared(work, file),
        signals=_signals(file, known),
        contact_forces=_forces(file, known),
        warnings=(
            *room.warnings,
            *work.notes,
            *study_doubts(room, known.roles, actions, criteria),
            *length_doubts(stood, file),
        ),
    )
    return sealed(study, Statement(work.document.value, work.path))


def _sitters(work: Work, file: StudyFile) -> list[SeatedRole]:
    """The roles that act on controls from a seat, in the order in which they take it: a population
    comes last."""
    found = []
    for name in sorted(file.people, key=lambda name: file.people[name].population is not None):
        role = _acting(work, name, file.people[name])
        if role.file.seat is not None and role.predicts:
            driver = any(action.driver is not None for action in role.actions)
            found.append(SeatedRole(name, role.file.seat, role.free, driver))
    return found


def _compared(work: Work, file: StudyFile) -> tuple[int, int] | None:
    """The indices of the two cases that are compared."""
    if not file.compare:
        return None
    one, two = (work.parts.case_names.index(name) for name in file.compare)
    return one, two


def _role(work: Work, name: str, loaded: LoadedRole) -> Role:
    file = loaded.file
    place = file.position if isinstance(file.position, PositionFile) else None
    return Role(
        name=name,
        body=loaded.body,
        detail=file.detail,
        clothes=loaded.clothes,
        size=loaded.size,
        sizes=loaded.sizes,
        population=loaded.population,
        seat=file.seat,
        free=_acting(work, name, file).free,
        forward=place.forward if place else 0.0,
        up=place.up if place else 0.0,
        stand=_stand(file.stand),
        library=library_of(work, loaded),
    )


def _stand(file: StandFile | None) -> Stand | None:
    """Where a role stands, and how far it may step."""
    if file is None:
        return None
    area = file.area or AreaFile()
    return Stand(file.on, math.radians(file.yaw), area.forward, area.left)


def _shares(file: StudyFile) -> Shares:
    if file.shares is None:
        return Shares()
    rule = file.shares.interval
    return Shares(
        {name: women / 100 for name, women in file.shares.mixes.items()},
        file.shares.confidence / 100,
        IntervalRule(rule.method, rule.seed or 0, rule.draws),
    )


def _signals(file: StudyFile, known: Known) -> Signals:
    if file.signals is None:
        return Signals()
    body = next(iter(known.roles.values())).body
    points = tuple(
        SignalPoint(
            point.name,
            body.segment(point.segment),
            point.at,
            point.filter_class or file.signals.filter_class,
        )
        for point in file.signals.points
    )
    return Signals(points, file.signals.filter_class)


def _forces(file: StudyFile, known: Known) -> tuple[ContactForce, ...]:
    parts: Iterable[str] = known.parts
    return tuple(
        ContactForce(
            matching(row.segments, known.segments), matching(row.parts, parts), law_in_si(row)
        )
        for row in file.contact_forces
    )


def limit_faults(work: Work) -> None:
    """Report what cannot be run yet, and what can be asked instead."""
    roles = {name: role for name, role in work.parts.roles.items() if role is not None}
    crowd = work.parts.crowd
    if crowd is not None:
        _crowd_faults(work, crowd)
    if work.parts.moves:
        _motion_faults(work)
    for row, task in work.parts.maps:
        if task.people in roles and task.people != crowd:
            what = "a reach map is of a population; ask for 'reach_envelopes' of one person"
            work.fault(("reach_maps", row, "people"), what)


def _crowd_faults(work: Work, name: str) -> None:
    """A population takes a role in postures, and its answers are shares."""
    if work.parts.moves:
        what = "a population does not move yet: give one 'size' for a motion"
        work.fault(("people", name, "population"), what)
    for row, task in work.parts.envelopes:
        if task.people == name:
            what = "an envelope is of one person; ask for 'reach_maps' of a population"
            work.fault(("reach_envelopes", row, "people"), what)


def _motion_faults(work: Work) -> None:
    """In one case all roles move, or none does."""
    for row, case in work.parts.cases:
        moving = {name for name, action in case.actions.items() if action and action.moves}
        for name, action in case.actions.items():
            if moving and action is not None and not action.moves:
                what = (
                    f"{sorted(moving)[0]!r} moves in this case, so this role needs a motion too; "
                    "postures stand in cases of their own"
                )
                work.fault(("cases", row, "people", name), what)
