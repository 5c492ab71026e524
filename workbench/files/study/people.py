"""The population of a role: that of a population file, or read from CSV files row by row."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.ansur import measures_in, read_ansur
from workbench.files.catalogue import find
from workbench.files.populations import load_population_model, measured_file
from workbench.files.schema import metres_in
from workbench.files.study.schema import PopulationFile
from workbench.model.measures import COCKPIT
from workbench.model.population import SEXES, Population, PopulationModel
from workbench.model.study import PeopleDrawn

__all__ = ["all_of", "drawn_of", "model_of", "people_files", "rows_of"]


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


def rows_of(file: PopulationFile, near: Path) -> Population:
    """The people of the CSV files, with all measures that the files have in common, those of the
    sexes asked for.

    InputError names line and column of what is missing or no person's, and the measures that a
    workplace cannot be fitted without.
    """
    paths = list(people_files(file, near).values())
    measures = _common_measures(paths)
    unit = metres_in[file.unit]
    people = read_ansur(*paths, measures=measures, unit=unit, weights=file.weights)
    people = _of_sexes(people, file)
    if not len(people):
        raise InputError(f"{people.source}: nobody in it is {' or '.join(file.sexes)}")
    if file.people is not None and file.people < len(people):
        people = people.rows(np.arange(file.people) * len(people) // file.people)
    return people


def _common_measures(paths: list[Path]) -> tuple[str, ...]:
    """The measures that all files have; InputError where one is missing that fitting needs."""
    found = measures_in(*paths)
    missing = [name for name in COCKPIT if name not in found]
    if missing:
        words = ", ".join(str(path) for path in paths)
        raise InputError(
            f"{words}: a column is needed for each of {', '.join(COCKPIT)} (missing: "
            f"{', '.join(missing)}), called as in ANSUR II or like this"
        )
    return found
