"""The size of one person: which measures may be stated, and whose people it is taken from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find
from workbench.files.populations import load_growth, load_population_model
from workbench.model.person import Growth, Size
from workbench.model.population import (
    MASS,
    MEASURES,
    ON_THE_BODY,
    WORDS,
    PopulationModel,
    sex_index,
)

__all__ = ["ADULTS", "CHILDREN", "measure_fault", "people_of_size", "size_of"]

ADULTS = "ansur2"
CHILDREN = "cdc_growth"
"""The populations of sizes that name none."""
OLDEST = 120.0
"""[years]"""


def measure_fault(measure: str, value: float) -> str:
    """Why a measure [m] cannot be given, or is no person's; "" where it can."""
    if measure == MASS:
        return "a mass is no length; give it beside the measures, as mass_kg: 60"
    if measure not in ON_THE_BODY:
        return f"no measure {measure!r}; {one_of(measure, ON_THE_BODY, words=WORDS)}"
    if measure in MEASURES and not MEASURES[measure][0] <= value <= MEASURES[measure][1]:
        low, high = (1000 * limit for limit in MEASURES[measure])
        return f"{1000 * value:g} mm is not a person's ({low:g} to {high:g} mm is): a wrong unit?"
    return ""


def people_of_size(
    source: str, age: float | None, near: Path
) -> tuple[Path, PopulationModel | Growth]:
    """The population, or the growth charts of a child, that a size names, and its file. InputError
    where it cannot be loaded."""
    path = find("bodies/populations", source, near=near)
    return path, load_population_model(path, people=False) if age is None else load_growth(path)


def size_of(
    sex: str,
    measures: Mapping[str, float],
    *,
    mass: float | None = None,
    age: float | None = None,
    people: PopulationModel | Growth,
) -> Size:
    """The size of a person, as a study's file may state it.

    Parameters
    ----------
    sex
        "male" or "female".
    measures
        By name [m].
    mass
        [kg].
    age
        [years] of a child.
    people
        Whose other measures are taken.

    Raises
    ------
    InputError
        With all that a study's file may not say.
    """
    faults = [
        f"{name}: {what}"
        for name, value in measures.items()
        if (what := measure_fault(name, value))
    ]
    sex_index(sex)
    low, high = MEASURES[MASS]
    if mass is not None and not low <= mass <= high:
        faults.append(f"mass {mass:g} kg is not a person's ({low:g} to {high:g} kg is)")
    if age is None and not measures:
        faults.append("a size is one measure or more, or the age of a child")
    if age is not None and not 0 < age <= OLDEST:
        faults.append(f"an age of up to {OLDEST:g} years is possible, got {age:g}")
    if faults:
        raise InputError(faults)
    more = {} if mass is None else {MASS: mass}
    return Size(sex, {**measures, **more}, people, age)
