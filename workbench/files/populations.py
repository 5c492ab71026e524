"""Growth charts, and population files: quantile tables and correlations of each sex, checked row by row, and the
measured people where a file names them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from workbench.errors import InputError, one_of
from workbench.files.ansur import BODY_MASS_INDEX, MEDIAN_INDEX, odd_masses, read_ansur
from workbench.files.catalogue import find, is_file
from workbench.files.schema import FileModel, LengthUnit, error_at, metres_in, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.person import Growth
from workbench.model.population import MASS, MEASURES, SEXES, WORDS, Population, PopulationModel

__all__ = ["GrowthFile", "PopulationFile", "load_growth", "load_population_model", "measured_file"]

Rows = Annotated[dict[str, list[float]], Field(min_length=1)]


class SexFile(FileModel):
    """One sex: a row of quantiles for each measure, and the lower triangle of the correlation of
    normal scores."""

    count: Annotated[int, Field(ge=2, le=10**9)]
    quantiles: Rows
    correlation: Rows


class PopulationFile(FileModel):
    """A population as figures: the measures of each sex at `percentiles`, in the file's unit of
    length, and kg.

    people: a CSV file of the people whose figures they are, beside this file or by its path, in
    the layout of the public ANSUR II files.
    """

    population: str
    description: str = ""
    source: str = ""
    licence: str = ""
    length: LengthUnit
    people: Annotated[str, Field(min_length=1)] | None = None
    percentiles: Annotated[list[float], Field(min_length=3)]
    male: SexFile | None = None
    female: SexFile | None = None

    def sexes(self) -> dict[str, SexFile]:
        """Those of the two sexes that the file has."""
        return {
            sex: part
            for sex, part in zip(SEXES, (self.male, self.female), strict=True)
            if part is not None
        }


def load_population_model(source: str | Path, *, people: bool = True) -> PopulationModel:
    """Read a population file, by path or by its name in bodies/populations.

    Parameters
    ----------
    source
        The path or the name.
    people
        Whether the measured people are read too, where the file names them.

    Raises
    ------
    InputError
        With all faults of the file.

    Examples
    --------
    >>> import workbench as wb
    >>> people = wb.load_population_model("ansur2")
    >>> len(wb.draw_people(people, 100, seed=1))
    100
    """
    document = read_yaml(find("bodies/populations", str(source)))
    file = validate(document, PopulationFile)
    faults = list(_level_faults(document, file))
    if not file.sexes():
        faults.append(error_at(document, (), f"one or both of {', '.join(SEXES)} are needed"))
    for sex in file.sexes():
        faults += _sex_faults(document, file, sex)
    if faults:
        raise InputError(faults)
    if file.people is None or not people:
        return _model(file, None)
    return _model(file, _measured(document, file, file.people))


def measured_file(source: str | Path) -> Path | None:
    """The file of the measured people that a population file names; None where it names none."""
    document = read_yaml(find("bodies/populations", str(source)))
    name = validate(document, PopulationFile).people
    return None if name is None else _beside(document, name)


def _beside(document: Document, name: str) -> Path:
    path = Path(document.file).parent / name
    if not is_file(path):
        raise InputError(error_at(document, ("people",), f"no such file {name!r} in {path.parent}"))
    return path


def _measured(document: Document, file: PopulationFile, name: str) -> Population:
    """The people that a file without other faults names."""
    path = _beside(document, name)
    measures = tuple(next(iter(file.sexes().values())).quantiles)
    people = read_ansur(path, measures=measures, unit=metres_in[file.length])
    faults = [
        error_at(
            document, (sex, "count"), f"{path} has {people.count(sex)} {sex} people (got {count})"
        )
        for sex in SEXES
        if people.count(sex) != (count := file.sexes()[sex].count if sex in file.sexes() else 0)
    ]
    if faults:
        raise InputError(faults)
    return replace(people, source=file.population)


def _model(file: PopulationFile, people: Population | None) -> PopulationModel:
    """The population of a file without faults, with its people."""
    sexes = file.sexes()
    parts = list(sexes.values())
    names = tuple(parts[0].quantiles)
    units = np.array([_unit(file, name) for name in names])[:, None]
    quantiles = [np.array([part.quantiles[name] for name in names]) * units for part in parts]
    return PopulationModel(
        name=file.population,
        description=file.description,
        source=file.source,
        names=names,
        sexes=tuple(sexes),
        count=np.array([part.count for part in parts]),
        levels=np.array(file.percentiles) / 100,
        quantiles=np.stack(quantiles),
        correlation=np.stack([_square(part) for part in parts]),
        people=people,
    )


def _unit(file: PopulationFile, name: str) -> float:
    return 1.0 if name == MASS else metres_in[file.length]


def _square(part: SexFile) -> Floats:
    """(M, M) from the rows of the lower triangle."""
    matrix = np.zeros((len(part.correlation), len(part.correlation)))
    for i, row in enumerate(part.correlation.values()):
        matrix[i, : i + 1] = row
    return np.asarray(np.tril(matrix, -1) + np.tril(matrix).T)


def _level_faults(document: Document, file: PopulationFile) -> Iterator[str]:
    """Faults of the percentiles: from 0 to 100, rising, and no finer than the people are many."""
    levels = file.percentiles
    if levels[0] != 0 or levels[-1] != 100:
        what = f"must go from 0 to 100 (got {levels[0]:g} to {levels[-1]:g})"
        yield error_at(document, ("percentiles",), what)
    for k, (low, high) in enumerate(pairwise(levels)):
        if high <= low:
            what = f"percentiles must rise (got {high:g} after {low:g})"
            yield error_at(document, ("percentiles", k + 1), what)
    edge = min(levels[1], 100 - levels[-2])
    for sex, part in file.sexes().items():
        if edge <= 50 / part.count:
            what = f"{part.count} people cannot tell the percentile next to 0 or 100 ({edge:g}): leave it out"
            yield error_at(document, (sex, "count"), what)


def _sex_faults(document: Document, file: PopulationFile, sex: str) -> list[str]:
    """Faults of the tables of one sex."""
    part = file.sexes()[sex]
    faults = []
    for name, row in part.quantiles.items():
        where = (sex, "quantiles", name)
        if name not in MEASURES:
            what = f"no such measure; {one_of(name, MEASURES, words=WORDS)}"
            faults.append(error_at(document, where, what))
        elif len(row) != len(file.percentiles):
            what = f"{len(file.percentiles)} values are needed, one a percentile (got {len(row)})"
            faults.append(error_at(document, where, what))
        else:
            faults += _row_faults(document, where, row, _unit(file, name))
    names = list(next(iter(file.sexes().values())).quantiles)
    for key, rows in (("quantiles", part.quantiles), ("correlation", part.correlation)):
        if list(rows) != names:
            faults.append(error_at(document, (sex, key), _other_measures(names, list(rows))))
    return faults or [*_mass_faults(document, file, sex), *_correlation_faults(document, sex, part)]


def _mass_faults(document: Document, file: PopulationFile, sex: str) -> Iterator[str]:
    """Faults of quantiles of mass that do not go with those of stature at the same percentile: masses
    in another unit."""
    rows = file.sexes()[sex].quantiles
    if not {MASS, "stature"} <= rows.keys():
        return
    mass, stature = (np.array(rows[name]) * _unit(file, name) for name in (MASS, "stature"))
    index = mass / stature**2
    levels = file.percentiles
    middle = float(np.interp(50.0, levels, index))
    odd = odd_masses(index, middle)
    if odd:
        low, high = BODY_MASS_INDEX
        least, most = MEDIAN_INDEX
        k = odd[0]
        more = f", and so at {len(odd) - 1} more percentiles" if len(odd) > 1 else ""
        yield error_at(
            document,
            (sex, "quantiles", MASS, k),
            f"{mass[k]:g} kg does not go with a stature of {1000 * stature[k]:g} mm, both at percentile "
            f"{levels[k]:g}{more}: mass / stature^2 is {index[k]:.1f} kg/m^2 where {low:g} to {high:g} is a "
            f"person's, {middle:.1f} in the middle where {least:g} to {most:g} is; masses are in "
            "kilograms here: convert pounds (0.4536 kg) or tenths of a kilogram",
        )


def _other_measures(names: list[str], rows: list[str]) -> str:
    """How the measures of a table differ from those of the first table."""
    differ = [f"{name} is missing" for name in names if name not in rows]
    differ += [f"{name} is not in the first table" for name in rows if name not in names]
    how = ", ".join(differ) or "another order"
    return f"all tables need the same measures in the same order ({how})"


def _row_faults(
    document: Document, where: tuple[str, str, str], row: list[float], unit: float
) -> Iterator[str]:
    low, high = (limit / unit for limit in MEASURES[where[2]])
    for k, value in enumerate(row):
        if not low <= value <= high:
            yield error_at(
                document,
                (*where, k),
                f"{value:g} is absurd for a person; {low:g} to {high:g} is plausible",
            )
        elif k and value <= row[k - 1]:
            yield error_at(
                document, (*where, k), f"quantiles must rise (got {value:g} after {row[k - 1]:g})"
            )


def _correlation_faults(document: Document, sex: str, part: SexFile) -> list[str]:
    """Faults of the correlations of one sex: the rows of a triangle, of a matrix that can be."""
    faults = []
    for i, (name, row) in enumerate(part.correlation.items()):
        where = (sex, "correlation", name)
        if len(row) != i + 1 or row[-1] != 1:
            got = f"got {len(row)}, the last {row[-1] if row else 'missing'}"
            what = f"a row has one value for each measure down to its own: {i + 1}, the last of them 1 ({got})"
            faults.append(error_at(document, where, what))
        faults += [
            error_at(document, (*where, k), f"a correlation lies between -1 and 1 (got {value:g})")
            for k, value in enumerate(row[:-1])
            if not -1 < value < 1
        ]
    if not faults and (least := float(np.linalg.eigvalsh(_square(part)).min())) <= 0:
        what = f"they contradict one another: an eigenvalue of their matrix is {least:.3g}, all must be positive"
        faults.append(error_at(document, (sex, "correlation"), what))
    return faults


Row = Annotated[tuple[float, float, float, float], Field(strict=False)]
Curve = Annotated[list[Row], Field(min_length=2)]


class CurvesFile(FileModel):
    """One sex: rows of age in months, L, M and S."""

    stature: Curve
    mass: Curve


class GrowthFile(FileModel):
    """Growth charts: stature in the file's unit of length, mass in kg."""

    growth: str
    description: str = ""
    source: str = ""
    licence: str = ""
    length: LengthUnit
    male: CurvesFile
    female: CurvesFile


def load_growth(source: str | Path = "cdc_growth") -> Growth:
    """Read a growth file, by path or by its name in bodies/populations; InputError lists all its
    faults."""
    document = read_yaml(find("bodies/populations", str(source)))
    file = validate(document, GrowthFile)
    names = tuple(CurvesFile.model_fields)
    tables = {(sex, name): getattr(getattr(file, sex), name) for sex in SEXES for name in names}
    ages = [row[0] for row in tables[SEXES[0], names[0]]]
    faults = [
        line for where, rows in tables.items() for line in _faults(document, where, rows, ages)
    ]
    if faults:
        raise InputError(faults)
    units = {name: 1.0 if name == MASS else metres_in[file.length] for name in names}
    lms = [
        [
            [
                [power, median * units[name], spread]
                for _, power, median, spread in tables[sex, name]
            ]
            for name in names
        ]
        for sex in SEXES
    ]
    return Growth(file.growth, file.source, names, np.array(ages), np.array(lms))


def _faults(
    document: Document, where: tuple[str, str], rows: list[tuple[float, ...]], ages: list[float]
) -> Iterator[str]:
    """Faults of a table: numbers that cannot be, and ages that do not rise or are not `ages`."""
    for k, row in enumerate(rows):
        if row[2] <= 0 or row[3] <= 0:
            what = f"L is any number, M and S are positive (got {list(row)})"
            yield error_at(document, (*where, k), what)
    own = [row[0] for row in rows]
    for k, (before, after) in enumerate(pairwise(own)):
        if after <= before:
            what = f"ages must rise (got {after:g} after {before:g})"
            yield error_at(document, (*where, k + 1), what)
    if own != ages:
        yield error_at(document, where, "all four tables need the same ages")
