"""Growth files: LMS curves by age."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from workbench.errors import InputError
from workbench.files.catalogue import find
from workbench.files.schema import FileModel, LengthUnit, fail, metres_in, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.measures import MASS
from workbench.model.person import Growth
from workbench.model.population import SEXES

__all__ = ["GrowthFile", "load_growth"]

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
    lms = [[_lms(tables[sex, name], units[name]) for name in names] for sex in SEXES]
    return Growth(file.growth, file.source, names, np.array(ages), np.array(lms))


def _lms(rows: list[tuple[float, ...]], unit: float) -> list[list[float]]:
    """Power, median [m, kg] and spread at each age of a table in a unit."""
    return [[power, median * unit, spread] for _, power, median, spread in rows]


def _faults(
    document: Document, where: tuple[str, str], rows: list[tuple[float, ...]], ages: list[float]
) -> Iterator[str]:
    """Faults of a table: numbers that cannot be, and ages that do not rise or are not `ages`."""
    for k, row in enumerate(rows):
        if row[2] <= 0 or row[3] <= 0:
            what = f"L is any number, M and S are positive (got {list(row)})"
            yield fail(document, (*where, k), what)
    own = [row[0] for row in rows]
    for k, (before, after) in enumerate(pairwise(own)):
        if after <= before:
            what = f"ages must rise (got {after:g} after {before:g})"
            yield fail(document, (*where, k + 1), what)
    if own != ages:
        yield fail(document, where, "all four tables need the same ages")
