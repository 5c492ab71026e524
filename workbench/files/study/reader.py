"""Read a study file: everything it names is loaded and checked, and all its faults are reported at
once."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find
from workbench.files.crash.restraints import contact_faults, law_in_si
from workbench.files.environments import environment_files, load_environment
from workbench.files.names import matches, matching
from workbench.files.study.actions import (
    CaseActions,
    load_actions,
    with_postures,
)
from workbench.files.study.criteria import Known, criteria_of, visible_parts
from workbench.files.study.limits import limit_faults
from workbench.files.study.parts import read_parts
from workbench.files.study.roles import LoadedRole, load_roles, place_faults
from workbench.files.study.schema import ActionFile, ChangeFile, PositionFile, RoleFile, StudyFile
from workbench.files.study.work import Work
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.accommodation import Change, IntervalRule, MapTask
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
    Study,
)

__all__ = ["load_study"]

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
    """
    path = find("studies", str(source))
    document = read_yaml(path)
    if isinstance(document.value, dict) and "kind" in document.value:
        raise InputError(f"{document.where(('kind',))}: kind: {OLD_FILE}")
    parts, faults = read_parts(document)
    work = Work(path, document, parts, faults, {"study": path})
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
    return _study(work, parts.file, known, (actions, criteria))


def _sorted(document: Document, faults: list[str]) -> list[str]:
    """Faults of named files first, then those of the study in the order of its lines."""
    lead = f"{document.file}:"
    own = [line for line in faults if line.startswith(lead)]

    def place(line: str) -> tuple[int, ...]:
        words = line[len(lead) :].split(":", 2)
        return tuple(int(word) for word in words[:2] if word.isdigit())

    return [line for line in faults if line not in own] + sorted(own, key=place)


def _environment(work: Work) -> Environment | None:
    if work.parts.environment is None:
        return None
    near = work.path.parent
    try:
        source = find("environments", work.parts.environment, "environment.yaml", near=near)
    except InputError as error:
        work.errors(("environment",), error)
        return None
    try:
        room = load_environment(source)
    except InputError as error:
        work.add(error.problems)
        return None
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
    seen: set[str] = set()
    for row, case in work.parts.cases:
        if case.name in seen:
            what = f"two cases are named {case.name!r}; give each a name of its own"
            work.fault(("cases", row, "name"), what)
        seen.add(case.name)
        for name in work.parts.roles:
            if name not in case.actions and case.actions:
                what = f"the action of {name!r} is missing; every role acts in every case"
                work.fault(("cases", row, "people"), what)
        for name in case.actions if work.parts.roles else ():
            if name not in work.parts.roles:
                what = f"nobody is called {name!r}; {one_of(name, work.parts.roles)}"
                work.fault(("cases", row, "people", name), what)


def _other_faults(work: Work, known: Known) -> None:
    """Report names of nothing in what the study asks for beside its criteria."""
    cases = [case.name for _, case in work.parts.cases]
    postures: list[str | None] = (
        [None] if any(not case.moves for _, case in work.parts.cases) else []
    )
    postures += [case.name for _, case in work.parts.cases if not case.moves]
    for key, rows in (("reach_maps", work.parts.maps), ("reach_envelopes", work.parts.envelopes)):
        for row, task in rows:
            if task.people not in work.parts.roles:
                what = f"nobody is called {task.people!r}; {one_of(task.people, work.parts.roles)}"
                work.fault((key, row, "people"), what)
            else:
                role = work.parts.roles[task.people]
                if role is not None and role.seat is None:
                    what = f"{task.people!r} is in no seat, about which reaches are measured; "
                    work.fault((key, row, "people"), what + "give the role a 'seat'")
            if task.case is not None and task.case not in cases:
                what = f"no case is called {task.case!r}; {one_of(task.case, cases)}"
                work.fault((key, row, "case"), what)
            elif task.case not in postures:
                what = "reaches begin at a posture: "
                what += f"{task.case!r} is a motion" if task.case else "all cases are motions"
                work.fault((key, row, "case") if task.case else (key, row), what)
    for place, name in enumerate(work.parts.compare or ()):
        if name not in cases:
            what = f"no case is called {name!r}; {one_of(name, cases)}"
            work.fault(("compare", place), what)
    _named_twice(work)
    if known.room is not None:
        for row, map_file in work.parts.maps:
            if map_file.part not in known.room.parts:
                what = f"environment {known.room.name} has no part {map_file.part!r}; "
                work.fault(
                    ("reach_maps", row, "part"), what + one_of(map_file.part, known.room.parts)
                )
        for row, change in work.parts.changes:
            _change_faults(work, (row, change), known.room)
    if known.complete:
        body = next(iter(known.roles.values())).body
        for row, point in enumerate(work.parts.signals.points if work.parts.signals else ()):
            if point.segment not in body.segments:
                what = f"body {body.name} has no segment {point.segment!r}; "
                key_ = ("signals", "points", row, "segment")
                work.fault(key_, what + one_of(point.segment, body.segments))
        if known.room is not None:
            laws = [(("contact_forces", row), law) for row, law in work.parts.forces]
            work.add(contact_faults(work.document, laws, (body, known.parts)))


def _named_twice(work: Work) -> None:
    """Report changes and signal points of one name."""
    points = enumerate(work.parts.signals.points if work.parts.signals else ())
    rows: list[tuple[tuple[str | int, ...], str]] = [
        (("changes", row), change.name) for row, change in work.parts.changes
    ]
    rows += [(("signals", "points", row), point.name) for row, point in points]
    seen: set[tuple[str | int, str]] = set()
    for key, name in rows:
        if (key[0], name) in seen:
            what = f"two of {key[0]} are named {name!r}; give each a name of its own"
            work.fault((*key, "name"), what)
        seen.add((key[0], name))


def _change_faults(work: Work, entry: tuple[int, ChangeFile], room: Environment) -> None:
    row, change = entry
    controls = [control.name for control in room.controls]
    if change.control is not None and change.control not in controls:
        what = f"environment {room.name} has no control {change.control!r}; "
        work.fault(("changes", row, "control"), what + one_of(change.control, controls))
    seats = [seat.name for seat in room.seats]
    if change.seat is not None and change.seat not in seats:
        what = f"environment {room.name} has no seat {change.seat!r}; "
        work.fault(("changes", row, "seat"), what + one_of(change.seat, seats))
    for place, name in enumerate(change.parts or ()):
        if not any(matches(name, part) for part in room.parts):
            what = f"nothing is called {name!r}; {one_of(name, room.parts)}"
            work.fault(("changes", row, "parts", place), what)


def _actions(work: Work, name: str) -> list[ActionFile]:
    """What a role does, case by case."""
    found = (case.actions.get(name) for _, case in work.parts.cases)
    return [action for action in found if action is not None]


def _is_free(role: RoleFile, actions: list[ActionFile]) -> bool:
    """Whether the seat goes where the person wants it."""
    if role.position is None:
        return any(action.predicts for action in actions)
    return role.position == "free"


def _whole_faults(work: Work) -> None:
    """Report what the study as a whole lacks or has too much of."""
    for name, role in work.parts.roles.items():
        if role is not None:
            _role_faults(work, (name, role), _actions(work, name))
    document = work.document.value
    crowd = work.parts.roles[work.parts.crowd] if work.parts.crowd is not None else None
    for key in ("shares", "changes"):
        if document.get(key) and crowd is None:
            what = f"'{key}' are of a population; give a role a 'population', or leave them out"
            work.fault((key,), what)
    for key in ("signals", "contact_forces"):
        if document.get(key) and not work.parts.moves:
            work.fault((key,), f"'{key}' are of motions; give a case a 'motion', or leave them out")
    for row, change in work.parts.changes:
        if crowd is not None and change.seat is not None and change.seat != crowd.seat:
            what = "the population has no seat, so this changes nothing for it; move a part"
            if crowd.seat is not None:
                what = f"the population sits in {crowd.seat!r}, so this changes nothing for it; "
                what += f"valid: {crowd.seat}"
            work.fault(("changes", row, "seat"), what)
    _compare_faults(work)
    rows = document.get("criteria")
    whole = isinstance(rows, list) and 0 < len(rows) == len(work.parts.criteria_whole)
    if whole and not any(criterion.check != "share" for _, criterion in work.parts.criteria):
        what = "nothing is left to ask: a share is of those who meet other criteria; add one"
        work.fault(("criteria",), what)


def _role_faults(work: Work, entry: tuple[str, RoleFile], actions: list[ActionFile]) -> None:
    """Report a place that is missing, or that does not go with what the role does."""
    name, role = entry
    key = ("people", name)
    still = [action for action in actions if not action.moves]
    place = next((k for k in ("seat", "at", "stand") if getattr(role, k) is not None), None)
    if place is None and still:
        what = "'seat', 'at' or 'stand' must say where the role is; only motions say so themselves"
        work.fault(key, what)
    if place is not None and actions and not still:
        what = f"a motion says itself where the role is: leave {place!r} out"
        work.fault((*key, place), what)
    given = [action for action in actions if action.posture is not None]
    predicts = any(action.predicts for action in actions)
    free = _is_free(role, actions)
    if role.seat is not None and free and given:
        what = (
            "the seat is free and a case gives the posture, so hands and feet would not follow; "
            "give 'position: reference', or predict the posture of every case"
        )
        work.fault((*key, "position") if role.position is not None else (*key, "seat"), what)
    if role.position == "free" and not predicts and not given:
        work.fault((*key, "position"), "a free seat needs a case that predicts the posture")
    subjects = [
        row
        for row, case in work.parts.cases
        for action in [case.actions.get(name)]
        if action is not None and action.motion is not None and action.motion.scale == "subject"
    ]
    first = work.parts.cases[0][0] if work.parts.cases else 0
    for row in subjects:
        if row != first:
            what = "one body makes all motions: 'scale: subject' belongs to the first case"
            work.fault(("cases", row, "people", name, "motion", "scale"), what)
    simulated = any(action.simulated is not None for action in actions)
    if simulated and (role.size or role.sizes or role.clothes or role.detail):
        what = "the body of a simulated motion is that of the simulation; leave its changes out"
        given_keys = (k for k in ("size", "sizes", "clothes", "detail") if getattr(role, k))
        work.fault((*key, next(given_keys)), what)


def _compare_faults(work: Work) -> None:
    if work.parts.compare is None or len(work.parts.compare) != 2:
        return
    rows = {case.name: (row, case) for row, case in work.parts.cases}
    one, two = work.parts.compare
    if one == two and one in rows:
        what = f"{one!r} is named twice; two different cases are compared"
        work.fault(("compare", 1), what)
    for place, name in enumerate(work.parts.compare):
        actions = rows[name][1].actions.values() if name in rows else ()
        if any(action is not None and not action.moves for action in actions):
            what = f"case {name!r} is no motion; two motions of one role are compared"
            work.fault(("compare", place), what)


def _study(
    work: Work, file: StudyFile, known: Known, loaded: tuple[CaseActions, list[Criterion]]
) -> Study:
    actions, criteria = loaded
    room = known.room
    assert room is not None
    names = list(file.people)
    case_names = [case.name for case in file.cases]
    compare = file.compare
    return Study(
        name=file.study,
        title=file.title or file.study,
        description=file.description,
        environment=room,
        roles=tuple(_role(work, name, known.roles[name]) for name in names),
        cases=tuple(
            Case(case.name, tuple(actions[row, name] for name in names))
            for row, case in enumerate(file.cases)
        ),
        criteria=tuple(criteria),
        inputs=work.inputs,
        shares=_shares(file),
        reach_maps=tuple(
            MapTask(
                row.part, row.grip, row.zone, row.hand, row.points, _posture_case(work, row.case)
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
                _posture_case(work, row.case),
            )
            for row in file.reach_envelopes
        ),
        changes=tuple(_change(row, room) for row in file.changes),
        compare=(case_names.index(compare[0]), case_names.index(compare[1])) if compare else None,
        signals=_signals(file, known),
        contact_forces=_forces(file, known),
        warnings=room.warnings,
    )


def _posture_case(work: Work, name: str | None) -> int:
    """The index of a case by its name, of the first posture where it has none."""
    cases = [case for _, case in work.parts.cases]
    return next(
        row for row, case in enumerate(cases) if not case.moves and name in (None, case.name)
    )


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
        free=_is_free(file, _actions(work, name)),
        forward=place.forward if place else 0.0,
        up=place.up if place else 0.0,
        stand=file.stand.on if file.stand else None,
    )


def _shares(file: StudyFile) -> Shares:
    if file.shares is None:
        return Shares()
    rule = file.shares.interval
    return Shares(
        {name: women / 100 for name, women in file.shares.mixes.items()},
        file.shares.confidence / 100,
        IntervalRule(rule.method, rule.seed or 0, rule.draws),
    )


def _change(file: ChangeFile, room: Environment) -> Change:
    return Change(
        words=file.name,
        control=file.control or "",
        parts=matching(file.parts, room.parts) if file.parts else (),
        move=file.move or (0.0, 0.0, 0.0),
        travel_forward=(-file.farther_back, file.farther_forward),
        travel_up=(-file.lower, file.higher),
    )


def _signals(file: StudyFile, known: Known) -> Signals:
    if file.signals is None:
        return Signals()
    body = next(iter(known.roles.values())).body
    points = tuple(
        SignalPoint(point.name, body.segment(point.segment), point.at)
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
