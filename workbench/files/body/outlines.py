"""Read outlines: a text file that a person can digitise from drawings, scans or a ruler.

    outlines: forearm
    length: mm
    axis: z
    stations:
      - {at: 0, points: [[30, 0], [21, 21], [0, 30], [-21, 21], [-30, 0], [-21, -21], [0, -30], [21,
        -21]]}
      - {at: 200, points: [[22, 0], [0, 25], [-22, 0], [0, -25]]}

Two rows with the same `at` are two curves of one station.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from workbench.errors import InputError
from workbench.files.schema import FileModel, Length, LengthUnit, fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.outlines import Outlines, crossing

__all__ = ["OutlinesFile", "StationFile", "load_outlines"]

Point = Annotated[tuple[Length, Length], Field(strict=False)]


class StationFile(FileModel):
    """One closed curve across the axis at a station; its points in order, the last joins the
    first."""

    at: Length
    points: Annotated[list[Point], Field(min_length=3, max_length=5000)]


class OutlinesFile(FileModel):
    """An outlines file. axis x: points are [y, z]; axis y: [z, x]; axis z: [x, y]."""

    outlines: Annotated[str, Field(min_length=1, max_length=80)]
    description: str = ""
    source: str = ""
    length: LengthUnit
    axis: Literal["x", "y", "z"]
    stations: Annotated[list[StationFile], Field(min_length=2, max_length=2000)]


def load_outlines(path: str | Path) -> Outlines:
    """Read outlines from a YAML file, in metres. InputError with file, line and column for every
    fault."""
    document = read_yaml(path)
    file = validate(document, OutlinesFile)
    faults = _faults(document, file)
    if faults:
        raise InputError(faults)
    order = sorted(range(len(file.stations)), key=lambda k: file.stations[k].at)
    return Outlines(
        file.outlines,
        "xyz".index(file.axis),
        np.array([file.stations[k].at for k in order]),
        tuple(_loop(file.stations[k]) for k in order),
    )


def _loop(row: StationFile) -> Floats:
    """The points as (n, 2), without a last one that repeats the first."""
    points = np.array(row.points)
    return points[:-1] if len(points) > 3 and np.array_equal(points[0], points[-1]) else points


def _faults(document: Document, file: OutlinesFile) -> list[str]:
    """Curves that cross themselves or another of their station, and too few stations."""
    faults = []
    if len({row.at for row in file.stations}) < 2:
        faults.append(fail(document, ("stations",), "outlines at two stations or more are needed"))
    return faults + [
        line for k in range(len(file.stations)) for line in _crossings(document, file, k)
    ]


def _crossings(document: Document, file: OutlinesFile, k: int) -> list[str]:
    row = file.stations[k]
    faults = []
    for j in range(k + 1):
        if file.stations[j].at != row.at:
            continue
        found = crossing(_loop(file.stations[j]), _loop(row))
        if found is not None:
            other = "crosses itself here" if j == k else f"crosses the curve of stations[{j}] here"
            faults.append(fail(document, ("stations", k, "points", found[1]), f"the curve {other}"))
    return faults
