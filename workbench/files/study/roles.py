"""The roles of a study: their bodies, postures, clothes, sizes, populations and places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.errors import InputError, one_of
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.encumbrances import worn
from workbench.files.catalogue import find
from workbench.files.growth import load_growth
from workbench.files.populations import load_population_model
from workbench.files.postures import PosturesFile, load_postures, posture_path
from workbench.files.study.people import drawn_from, people_files, rows_of
from workbench.files.study.schema import PopulationFile, PositionFile, RoleFile, SizeFile
from workbench.files.study.work import Work
from workbench.model.body import Body, segment_words
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.growth import Growth
from workbench.model.measures import MEASURES, ON_THE_BODY, WORDS
from workbench.model.person import Size
from workbench.model.population import Population, PopulationModel
from workbench.model.study import PeopleDrawn

__all__ = ["LoadedRole", "load_roles", "place_faults"]


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
    clothes_key = ("people", name, "clothes")
    for row, item in enumerate(file.clothes):
        if item in file.clothes[:row]:
            work.fault((*clothes_key, row), f"{item!r} is worn already; name it once")
    size = _size(work, name, file.size) if file.size is not None else None
    population = _population(work, name, file.population) if file.population is not None else None
    sizes = {
        label: _size(work, name, each, ("sizes", label))
        for label, each in (file.sizes or {}).items()
    }
    body = _body(work, name, file)
    if body is None:
        return None
    postures = _postures(work, name, body)
    if file.detail is not None and (body.basis is None or file.detail not in body.basis.details):
        levels = ", ".join(body.basis.details) if body.basis else "none"
        what = f"body {body.name} has no level of detail {file.detail!r}; valid: {levels}"
        work.fault(("people", name, "detail"), what)
    return LoadedRole(
        file=file,
        body=body,
        postures=postures,
        clothes=_clothes(work, name, body),
        size=size,
        sizes={label: each for label, each in sizes.items() if each is not None},
        population=population,
    )


def _body(work: Work, name: str, file: RoleFile) -> Body | None:
    key = ("people", name, "body")
    try:
        source = body_path(file.body, near=work.path.parent)
    except InputError as error:
        work.errors(key, error)
        return None
    work.inputs[f"body of {name}"] = source
    try:
        return load_body(source)
    except InputError as error:
        work.add(error.problems)
        return None


def _postures(work: Work, name: str, body: Body) -> PosturesFile | None:
    try:
        path = posture_path(work.inputs[f"body of {name}"])
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
        found = worn(wanted, body, near=near)
        work.inputs |= {
            f"{item} of {name}": find("bodies/encumbrance", item, near=near) for item in wanted
        }
        return found
    except InputError as error:
        work.errors(("people", name, "clothes"), error)
        return ()


def _size(work: Work, name: str, file: SizeFile, at: tuple[str, ...] = ("size",)) -> Size | None:
    key = ("people", name, *at)
    faults = [(("measures", measure), what) for measure, what in _measure_faults(file)]
    for where, what in faults:
        work.fault((*key, *where), what)
    people: PopulationModel | Growth
    try:
        source = find("bodies/populations", file.source, near=work.path.parent)
        work.inputs[f"population of {' '.join((name, *at[1:]))}"] = source
        people = load_population_model(source) if file.age is None else load_growth(source)
    except InputError as error:
        work.errors((*key, "population"), error)
        return None
    mass = {} if file.mass_kg is None else {"mass": file.mass_kg}
    return Size(file.sex, file.measures | mass, people, file.age)


def _measure_faults(file: SizeFile) -> list[tuple[str, str]]:
    """Measures that cannot be given, or that no person has."""
    faults = []
    for measure, value in file.measures.items():
        if measure == "mass":
            what = "a mass is no length; give it beside the measures, as mass_kg: 60"
            faults.append((measure, what))
        elif measure not in ON_THE_BODY:
            what = f"no measure {measure!r}; {one_of(measure, ON_THE_BODY, words=WORDS)}"
            faults.append((measure, what))
        elif measure in MEASURES and not MEASURES[measure][0] <= value <= MEASURES[measure][1]:
            low, high = (1000 * limit for limit in MEASURES[measure])
            what = (
                f"{1000 * value:g} mm is not a person's ({low:g} to {high:g} mm is): a wrong unit?"
            )
            faults.append((measure, what))
    return faults


def _population(work: Work, name: str, file: PopulationFile) -> Population | PeopleDrawn | None:
    key = ("people", name, "population")
    for row, source in enumerate(file.files or ()):
        if source in (file.files or [])[:row]:
            what = f"{source!r} is named already, and its people would count twice; name it once"
            work.fault((*key, "files", row), what)
    near = work.path.parent
    try:
        work.inputs |= people_files(file, near)
        if file.files is not None:
            return rows_of(file, near)
        women = 0.5 if file.women is None else file.women / 100
        women = women if len(file.sexes) == 2 else float(file.sexes[0] == "female")
        return PeopleDrawn(drawn_from(file, near), file.people or 0, file.seed or 0, women)
    except InputError as error:
        work.errors((*key, "source" if file.files is None else "files"), error)
        return None


def place_faults(work: Work, roles: dict[str, LoadedRole], room: Environment | None) -> None:
    """Report places that are not there, or that two roles take, and several roles of many
    people."""
    taken: dict[str, str] = {}
    several = ""
    for name, file in work.parts.roles.items():
        if file is None:
            continue
        key = ("people", name)
        rows = "sizes" if file.sizes is not None else "population"
        if file.sizes is not None or file.population is not None:
            if several:
                what = (
                    f"{several!r} has several people already; one role of a study at most has "
                    "`sizes` or a `population`"
                )
                work.fault((*key, rows), what)
            several = several or name
        if file.seat is not None:
            if file.seat in taken:
                what = (
                    f"{taken[file.seat]!r} sits in {file.seat!r} already; for people who take a "
                    "seat one at a time use `sizes` of one role"
                )
                work.fault((*key, "seat"), what)
            taken.setdefault(file.seat, name)
            if room is not None:
                _seat_faults(work, (name, file), room)
        if file.at is not None and name in roles:
            body = roles[name].body
            if file.at.segment not in body.segments:
                hint = one_of(file.at.segment, body.segments, words=segment_words(body))
                what = f"unknown segment {file.at.segment!r}; {hint}"
                work.fault((*key, "at", "segment"), what)


def _seat_faults(work: Work, role: tuple[str, RoleFile], room: Environment) -> None:
    """The seat is there, and stands within its travel."""
    name, file = role
    seats = {seat.name: seat for seat in room.seats}
    if file.seat not in seats:
        what = f"environment {room.name} has no seat {file.seat!r}; "
        work.fault(("people", name, "seat"), what + one_of(str(file.seat), seats))
        return
    if not isinstance(file.position, PositionFile):
        return
    seat = seats[file.seat]
    for way, (low, high) in (("forward", seat.travel_forward), ("up", seat.travel_up)):
        value = getattr(file.position, way)
        if not low - 1e-9 <= value <= high + 1e-9:
            travel = f"{1000 * low:g} to {1000 * high:g} mm"
            what = f"beyond the travel of seat {seat.name}, {travel} (got {1000 * value:g} mm)"
            work.fault(("people", name, "position", way), what)
