"""People as a folder of body files, and a table of who they are: complete or not there at all."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.body.scaling.scale import morph_to
from workbench.body.wear import wear
from workbench.errors import InputError
from workbench.files.body.bodies import body_path, load_body
from workbench.files.body.encumbrances import load_encumbrances
from workbench.files.body.writer import body_text
from workbench.files.output_file import Content
from workbench.files.output_folder import check_folder, write_folder
from workbench.model.body import Body
from workbench.model.population import MASS, SEXES, Population
from workbench.report.tables import csv_text
from workbench.study.persons import SizedBody
from workbench.study.population_files import file_names, people_bodies

__all__ = ["TABLE", "write_people"]

TABLE = "people.csv"


def write_people(
    folder: Path,
    people: Population,
    sources: Mapping[str, str],
    *,
    shown: Sequence[str],
    detail: str | None = None,
    wears: Sequence[str] = (),
) -> list[str]:
    """Write the bodies of people and people.csv into a folder.

    Parameters
    ----------
    folder
        Where they are written.
    people
        Who they are.
    sources
        The body that men ("male") and women ("female") are made from.
    shown
        The measures that each body shows exactly.
    detail
        The level of detail of their family.
    wears
        What they are dressed in.

    Returns
    -------
    list
        A line for each thing that is improbable about them, and for each file that is kept, see
        write_folder.

    Raises
    ------
    InputError
        Where there is no such person or the folder holds something else; nothing is written.
    """
    check_folder(folder, holds="people")  # before the work, not after it
    loaded = {name: morph_to(load_body(name), detail) for name in dict.fromkeys(sources.values())}
    dressing = {name: load_encumbrances(list(wears), body) for name, body in loaded.items()}
    bodies = {sex: loaded[name] for sex, name in sources.items()}
    files: dict[str, Content] = {}
    warnings: list[str] = []
    rows = []
    clothes = f", with {', '.join(wears)}" if wears else ""
    for person in _made(people, bodies, shown):
        source = sources[person.sex]
        files[person.file] = body_text(
            wear(person.made.body, dressing[source]),
            body_path(source),
            name=Path(person.file).stem,
            description=f"{people.source}: {person.sex}, {person.label}; made from {source}{clothes}",
            folder=folder,
        )
        warnings += [f"{person.file}: {warning}" for warning in person.made.warnings]
        measures = (_rounded(name, person.made.measures[name]) for name in people.names)
        rows.append([person.file, person.sex, person.label, *measures])
    if not rows:
        raise InputError(f"{people.source}: there is nobody to make bodies of")
    units = [f"{name}_{'kg' if name == MASS else 'mm'}" for name in people.names]
    files = {TABLE: csv_text(["file", "sex", "label", *units], rows), **files}
    write_folder(folder, files, holds="people", tell=warnings.append)
    return warnings


@dataclass(frozen=True, eq=False)
class _Person:
    """Somebody of a folder: the file of the body, who it is, and the body."""

    file: str
    sex: str
    label: str
    made: SizedBody


def _made(
    people: Population, bodies: Mapping[str, Body], shown: Sequence[str]
) -> Iterator[_Person]:
    """The people one by one. bodies: by sex; shown: the measures that each shows exactly."""
    names = file_names(people)
    made = people_bodies(bodies, people, shown)
    for name, one, code, label in zip(names, made, people.sex, people.labels, strict=True):
        yield _Person(name, SEXES[int(code)], label, one)


def _rounded(name: str, value: float) -> float:
    """A measure as the table has it [mm], a mass [kg]."""
    return round(value, 2) if name == MASS else round(1000 * value, 1)
