"""The population of a role: drawn from a population file, or read from CSV files row by row."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.ansur import measures_in, read_ansur
from workbench.files.catalogue import find
from workbench.files.populations import load_population_model
from workbench.files.schema import metres_in
from workbench.files.study.schema import PopulationFile
from workbench.model.measures import COCKPIT
from workbench.model.population import SEXES, Population, PopulationModel

__all__ = ["drawn_from", "people_files", "rows_of"]


def people_files(file: PopulationFile, near: Path) -> dict[str, Path]:
    """The files that the people come from, by their role. InputError for a population that is not
    there."""
    if file.files is not None:
        return {f"people: {name}": near / name for name in file.files}
    return {"population": find("bodies/populations", file.source or "ansur2", near=near)}


def drawn_from(file: PopulationFile, near: Path) -> PopulationModel:
    """The model that people are drawn from. InputError where it lacks a sex that is asked for."""
    model = load_population_model(people_files(file, near)["population"])
    missing = [sex for sex in file.sexes if sex not in model.sexes]
    if missing:
        raise InputError(
            f"population {model.name} has nobody who is {missing[0]}; it has {', '.join(model.sexes)}"
        )
    return model


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
    people = people.rows(np.isin(people.sex, [SEXES.index(sex) for sex in file.sexes]))
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
