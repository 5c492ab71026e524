"""The roles of a study: their bodies, postures, clothes, sizes, populations and places."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.ansur import measures_in, read_ansur
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.encumbrances import load_encumbrances, missing
from workbench.files.catalogue import find
from workbench.files.populations import load_population_model, measured_file
from workbench.files.postures import PosturesFile, load_postures, posture_path
from workbench.files.schema import metres_in
from workbench.files.study.schema import PopulationFile, PositionFile, RoleFile, SizeFile
from workbench.files.study.settings import setting_faults
from workbench.files.study.sizes import measure_fault, people_of_size
from workbench.files.study.work import Key, Work
from workbench.model.body import Body, segment_words
from workbench.model.environment import Environment, Seat
from workbench.model.joint_angles import motion_of
from workbench.model.person import Encumbrance, Size
from workbench.model.population import COCKPIT, SEXES, Population, PopulationModel
from workbench.model.stops import StopKind
from workbench.model.study import PeopleDrawn
from workbench.model.units import plain

__all__ = [
    "LoadedRole",
    "all_of",
    "drawn_of",
    "load_roles",
    "model_of",
    "people_files",
    "place_faults",
    "reduced",
]


@dataclass(frozen=True, eq=False)
class LoadedRole:
    """What a role's file names. postures: None where the body has none."""

    file: RoleFile
    body: Body
    postures: PosturesFile | None
    clothes: tuple[Encumbrance, ...] = ()
    size: Size | None = None
    sizes: Mapping[str, Size] = field(default_factory=dict)
    population: Population | PeopleDrawn | None = None


def load_roles(work: Work) -> dict[str, LoadedRole]:
    """The roles whose bodies can be loaded; faults go to the work."""
    found = {}
    for name, file in work.parts.roles.items():
        loaded = _load_role(work, name, file) if file is not None else None
        if loaded is not None:
            found[name] = loaded
    return found


def _load_role(work: Work, name: str, file: RoleFile) -> LoadedRole | None:
    """A role with what it names; None where its body cannot be loaded."""
    key = ("people", name)
    for row, item in enumerate(file.clothes):
        if item in file.clothes[:row]:
            work.fault((*key, "clothes", row), f"{item!r} is worn already; name it once")
    size = _size(work, name, file.size) if file.size is not None else None
    population = _population(work, name, file.population) if file.population is not None else None
    sizes = {
        label: found
        for label, each in (file.sizes or {}).items()
        if (found := _size(work, name, each, ("sizes", label))) is not None
    }
    body = _body(work, name, file)
    if body is None:
        return None
    body = _with_stops(work, name, file, body)
    postures = _postures(work, name, body)
    if file.detail is not None:
        _detail_faults(work, (*key, "detail"), body, file.detail)
    clothes = _clothes(work, name, body)
    return LoadedRole(file, body, postures, clothes, size, sizes, population)


def _detail_faults(work: Work, key: Key, body: Body, detail: str) -> None:
    """Report a level of detail that the body has not."""
    if body.basis is None or detail not in body.basis.details:
        valid = ", ".join(body.basis.details) if body.basis else "none"
        what = f"body {body.name} has no level of detail {detail!r}; valid: {valid}"
        work.fault(key, what)


def _body(work: Work, name: str, file: RoleFile) -> Body | None:
    key = ("people", name, "body")
    given: str | Body = file.body
    if isinstance(given, Body):
        if len(given) != 1:
            work.fault(key, f"one body is needed, got {len(given)} rows: choose one, as body[0]")
        return given
    try:
        source = body_path(given, near=work.path.parent)
    except InputError as error:
        work.errors(key, error)
        return None
    work.inputs[f"body of {name}"] = source
    try:
        return load_body(source)
    except InputError as error:
        work.add(error.problems)
        return None


def _own_file(work: Work, name: str, body: Body) -> Path | None:
    """The file of a body, of one that was made in Python that of its name; None where there is
    none."""
    if f"body of {name}" in work.inputs:
        return work.inputs[f"body of {name}"]
    try:
        return body_path(body.name, near=work.path.parent)
    except InputError:
        return None


def _postures(work: Work, name: str, body: Body) -> PosturesFile | None:
    try:
        own = _own_file(work, name, body)
        path = None if own is None else posture_path(own)
        if path is None:
            return None
        work.inputs[f"postures of {name}"] = path
        return load_postures(path, body)[0]
    except InputError as error:
        work.add(error.problems)
        return PosturesFile.model_construct(reference=body.segments[0], postures={})


def _clothes(work: Work, name: str, body: Body) -> tuple[Encumbrance, ...]:
    role = work.parts.roles[name]
    wanted = list(dict.fromkeys(role.clothes)) if role is not None else []
    near = work.path.parent
    try:
        found = load_encumbrances(wanted, body, near=near)
        work.inputs |= {
            f"{item} of {name}": find("bodies/encumbrance", item, near=near) for item in wanted
        }
    except InputError as error:
        work.errors(("people", name, "clothes"), error)
        return ()
    if role is None or not role.without:
        return found
    try:
        return (*found, missing(role.without, body))
    except InputError as error:
        work.errors(("people", name, "without"), error)
        return found


def _with_stops(work: Work, name: str, file: RoleFile, body: Body) -> Body:
    """The body with the range of motion that a role states."""
    for joints, given in file.stops.items():
        for joint in joints.split():
            try:
                pairs = body.stops.motions[body.joint(joint)]
                every = [motion for pair in pairs for motion in pair]
                motions = given if isinstance(given, dict) else dict.fromkeys(every, given)
                body = reduced(body, {(joint, m): _range(value) for m, value in motions.items()})
            except InputError as error:
                work.errors(("people", name, "stops", joints), error)
    return body


def _range(given: float | str) -> tuple[float, bool]:
    """How far a motion turns [rad], or the share of what it did, and whether it is a share."""
    if isinstance(given, str):
        return float(given.rstrip(" %")) / 100.0, True
    return math.radians(given), False


def _size(work: Work, name: str, file: SizeFile, at: tuple[str, ...] = ("size",)) -> Size | None:
    """The size that stands at a key of a role; None where its population cannot be loaded."""
    key = ("people", name, *at)
    for measure, value in file.measures.items():
        if what := measure_fault(measure, value):
            work.fault((*key, "measures", measure), what)
    try:
        source, people = people_of_size(file.source, file.age, work.path.parent)
    except InputError as error:
        work.errors((*key, "population"), error)
        return None
    work.inputs[f"population of {' '.join((name, *at[1:]))}"] = source
    mass = {} if file.mass_kg is None else {"mass": file.mass_kg}
    return Size(file.sex, file.measures | mass, people, file.age)


def _population(
    work: Work, name: str, file: PopulationFile | Population
) -> Population | PeopleDrawn | None:
    """The people of a role: those given, those of its files, or how they are drawn; None where none
    can be loaded."""
    key = ("people", name, "population")
    if isinstance(file, Population):
        missing = [measure for measure in COCKPIT if measure not in file.names]
        if missing or not len(file):
            lacking = f"the measures {', '.join(missing)}" if missing else "people"
            work.fault(key, f"{file!r} lacks {lacking}, without which nobody can be fitted")
        return file
    files = file.files or ()
    for row, source in enumerate(files):
        if source in files[:row]:
            what = f"{source!r} is named already, and its people would count twice; name it once"
            work.fault((*key, "files", row), what)
    near = work.path.parent
    try:
        work.inputs |= people_files(file, near)
        if file.files is not None:
            return _rows_of(work, file)
        model = model_of(file, near)
    except InputError as error:
        work.errors((*key, "source" if file.files is None else "files"), error)
        return None
    try:
        return all_of(model, file) if file.everybody else drawn_of(model, file)
    except InputError as error:
        work.errors((*key, "people"), error)
        return None


def place_faults(work: Work, roles: dict[str, LoadedRole], room: Environment | None) -> None:
    """Report places that are not there, or that two roles take, and several roles of many
    people."""
    files = {name: file for name, file in work.parts.roles.items() if file is not None}
    _several_faults(work, files)
    _taken_faults(work, files)
    for name, file in files.items():
        if file.seat is not None and room is not None:
            _seat_faults(work, name, file, room)
        if file.at is not None and name in roles:
            body = roles[name].body
            segment = file.at.segment
            key = ("people", name, "at", "segment")
            what = f"unknown segment {segment!r}"
            work.check_name(key, segment, body.segments, what, words=segment_words(body))
    if room is not None:
        setting_faults(work, files, room)


def _taken_faults(work: Work, files: dict[str, RoleFile]) -> None:
    """Report seats in which another role sits already."""
    taken: dict[str, str] = {}
    for name, file in files.items():
        if file.seat is not None:
            before = taken.setdefault(file.seat, name)
            if before != name:
                what = (
                    f"{before!r} sits in {file.seat!r} already; for people who take a "
                    "seat one at a time use `sizes` of one role"
                )
                work.fault(("people", name, "seat"), what)


def _several_faults(work: Work, files: dict[str, RoleFile]) -> None:
    """Report roles of several people after the first one."""
    several = [
        (name, "sizes" if file.sizes is not None else "population")
        for name, file in files.items()
        if file.sizes is not None or file.population is not None
    ]
    for name, key in several[1:]:
        what = (
            f"{several[0][0]!r} has several people already; one role of a study at most has "
            "`sizes` or a `population`"
        )
        work.fault(("people", name, key), what)


def _seat_faults(work: Work, name: str, file: RoleFile, room: Environment) -> None:
    """Report a seat that is not there, or that stands beyond its travel."""
    seats = {seat.name: seat for seat in room.seats}
    key = ("people", name)
    seat = str(file.seat)
    what = f"environment {room.name} has no seat {seat!r}"
    there = work.check_name((*key, "seat"), seat, seats, what)
    if there and isinstance(file.position, PositionFile):
        _travel_faults(work, (*key, "position"), file.position, seats[seat])


def _travel_faults(work: Work, key: Key, position: PositionFile, seat: Seat) -> None:
    """Report a position of a seat that is beyond its travel."""
    for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
        value = getattr(position, way)
        if not low - 1e-9 <= value <= high + 1e-9:
            travel = f"{1000 * low:g} to {1000 * high:g} mm"
            what = f"beyond the travel of seat {seat.name}, {travel} (got {1000 * value:g} mm)"
            work.fault((*key, way), what)


def people_files(file: PopulationFile, near: Path) -> dict[str, Path]:
    """The files that the people come from, by their role. InputError for a population that is not
    there."""
    if file.files is not None:
        return {f"people: {name}": near / name for name in file.files}
    source = find("bodies/populations", file.source or "ansur2", near=near)
    measured = measured_file(source)
    return {"population": source} | ({} if measured is None else {"people": measured})


def model_of(file: PopulationFile, near: Path) -> PopulationModel:
    """The population of a file. InputError where it lacks a sex that is asked for."""
    model = load_population_model(people_files(file, near)["population"])
    missing = [sex for sex in file.sexes if sex not in model.sexes]
    if missing:
        raise InputError(
            f"population {model.name} has nobody who is {missing[0]}; it has {', '.join(model.sexes)}"
        )
    return model


def all_of(model: PopulationModel, file: PopulationFile) -> Population:
    """All measured people of the sexes asked for. InputError where nobody of them is known."""
    if model.people is None:
        raise InputError(
            f"population {model.name} is figures without measured people: say how many 'people' "
            "are to be drawn, and a 'seed'"
        )
    return _of_sexes(model.people, file)


def drawn_of(model: PopulationModel, file: PopulationFile) -> PeopleDrawn:
    """How people are drawn. InputError where more are asked for than were measured."""
    count = file.people or 0
    drawn = PeopleDrawn(model, count, file.seed or 0, _share_of_women(file), file.synthetic)
    if model.people is not None and not file.synthetic:
        men = round(count * (1.0 - drawn.women))
        if short := model.people.lacking(men, count - men):
            raise InputError(
                f"{short}; ask for fewer, for another share of 'women', or write 'synthetic: true' "
                "for people like those measured"
            )
    return drawn


def _share_of_women(file: PopulationFile) -> float:
    """The share of women among the people drawn, from 0 to 1."""
    if len(file.sexes) == 1:
        return float(file.sexes[0] == "female")
    return 0.5 if file.women is None else file.women / 100


def _of_sexes(people: Population, file: PopulationFile) -> Population:
    return people.rows(np.isin(people.sex, [SEXES.index(sex) for sex in file.sexes]))


def _rows_of(work: Work, file: PopulationFile) -> Population:
    """The people of the CSV files, with all measures that the files have in common, those of the
    sexes asked for.

    InputError names line and column of what is missing or no person's, and the measures that a
    workplace cannot be fitted without.
    """
    paths = list(people_files(file, work.path.parent).values())
    measures = _common_measures(work, paths)
    unit = metres_in[file.unit]
    people = read_ansur(*paths, measures=measures, unit=unit, weights=file.weights)
    people = _of_sexes(people, file)
    if not len(people):
        raise InputError(f"{people.source}: nobody in it is {' or '.join(file.sexes)}")
    if file.people is not None and file.people < len(people):
        people = people.rows(np.arange(file.people) * len(people) // file.people)
    return people


def _common_measures(work: Work, paths: list[Path]) -> tuple[str, ...]:
    """The measures that all files have, and a note of those that only some have; InputError where
    one is missing that fitting needs."""
    found = measures_in(*paths)
    for path in paths if len(paths) > 1 else []:
        own = [name for name in measures_in(path) if name not in found]
        if own:
            work.notes.append(
                f"{path}: {plain(', '.join(own))}: not read, as not every file of these people has "
                f"{'it' if len(own) == 1 else 'them'}"
            )
    missing = [name for name in COCKPIT if name not in found]
    if missing:
        words = ", ".join(str(path) for path in paths)
        raise InputError(
            f"{words}: a column is needed for each of {', '.join(COCKPIT)} (missing: "
            f"{', '.join(missing)}), called as in ANSUR II or like this"
        )
    return found


def reduced(body: Body, changes: Mapping[tuple[str, str], tuple[float, bool]]) -> Body:
    """Return a body with other joint stops.

    A shoulder, whose stop is a spherical polygon, becomes a cone with the half-angles of its
    motions. Limits that depend on another motion are scaled by a share, and replaced by an angle.

    Parameters
    ----------
    body
        B bodies of one topology.
    changes
        By joint and motion how far it turns [rad], or as a share of what it did where the second is
        True.

    Raises
    ------
    InputError
        If there is no such joint or motion, or it would turn farther than before.
    """
    stops = body.stops
    limits = stops.limits.copy()
    kind = stops.kind.copy()
    couplings = list(stops.couplings)
    for (name, motion), (value, share) in changes.items():
        j = body.joint(name)
        axis, sign = motion_of(body, j, motion)
        side = 0 if sign > 0 else 1
        before = float(limits[j, axis, side])
        limits[j, axis, side] = value * before if share else value
        if limits[j, axis, side] > before + 1e-9:
            raise InputError(
                f"joint {name}: {motion} ends at {np.degrees(before):g} degrees; it can be reduced, "
                f"got {np.degrees(value):g}: a joint that turns farther is another body file's"
            )
        if kind[j] == StopKind.POLYGON:
            kind[j] = StopKind.CONE
        own = [k for k in couplings if (k.joint, k.axis, k.side) == (j, axis, side)]
        couplings = [k for k in couplings if k not in own]
        if share:
            couplings += [replace(k, limit=(value * k.limit[0], value * k.limit[1])) for k in own]
    other = replace(stops, kind=kind, limits=limits, couplings=tuple(couplings))
    return replace(body, topology=replace(body.topology, stops=other))
