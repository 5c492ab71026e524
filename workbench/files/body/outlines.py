"""Read outlines: a text file that a person can digitise from drawings, scans or a ruler.

    outlines: forearm
    length: mm
    axis: z
    stations:
      - {at: 0, points: [[30, 0], [21, 21], [0, 30], [-21, 21], [-30, 0], [-21, -21], [0, -30], [21,
        -21]]}
      - {at: 200, points: [[22, 0], [0, 25], [-22, 0], [0, -25]]}

Two rows with the same `at` are two curves of one station. One section is enough for a slab, with
`thickness: 40` about its station, and for a body of rotation: `lathe: [[0, 30], [200, 22]]` in place
of stations has places along the axis and the radius at each.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from workbench.errors import InputError
from workbench.files.schema import FileModel, Length, LengthUnit, error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.outlines import Outlines, crossing

__all__ = ["OutlinesFile", "StationFile", "load_outlines"]

_SIDES = 64
"""Sides of a circle of a body of rotation: 0.12 % of the radius off at most."""
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
    stations: Annotated[list[StationFile], Field(max_length=2000)] = []
    thickness: Length | None = None
    lathe: Annotated[list[Point], Field(max_length=2000)] = []


def load_outlines(path: str | Path) -> Outlines:
    """Read outlines from a YAML file, in metres. InputError with file, line and column for every
    fault."""
    document = read_yaml(path)
    file = validate(document, OutlinesFile)
    faults = _faults(document, file)
    if faults:
        raise InputError(faults)
    sections = _sections(file)
    order = sorted(range(len(sections)), key=lambda k: sections[k][0])
    return Outlines(
        file.outlines,
        "xyz".index(file.axis),
        np.array([sections[k][0] for k in order]),
        tuple(sections[k][1] for k in order),
    )


def _sections(file: OutlinesFile) -> list[tuple[float, Floats]]:
    """The place [m] along the axis and the points (n, 2) [m] of each curve: those of a slab twice,
    those of a body of rotation as circles."""
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    half = 0.5 * (file.thickness or 0.0)
    return [
        *((row.at + side, _loop(row)) for row in file.stations for side in {-half, half}),
        *((at, radius * circle) for at, radius in file.lathe),
    ]


def _loop(row: StationFile) -> Floats:
    """The points as (n, 2), without a last one that repeats the first."""
    points = np.array(row.points)
    return points[:-1] if len(points) > 3 and np.array_equal(points[0], points[-1]) else points


def _faults(document: Document, file: OutlinesFile) -> list[str]:
    """Curves that cross themselves or another of their station, and too few stations."""
    faults = []
    stations = {row.at for row in file.stations}
    if file.lathe:
        if stations or file.thickness is not None:
            faults.append(
                error_at(document, ("lathe",), "a lathe has no stations and no thickness")
            )
        places = [at for at, _ in file.lathe]
        if len(places) < 2 or np.any(np.diff(places) <= 0) or min(r for _, r in file.lathe) <= 0:
            what = "two rows [place along the axis, radius] or more are needed, places rising, radii above 0"
            faults.append(error_at(document, ("lathe",), what))
    elif file.thickness is not None:
        if len(stations) != 1 or file.thickness <= 0:
            what = "a slab has one station, and a thickness above 0"
            faults.append(error_at(document, ("thickness",), what))
    elif len(stations) < 2:
        what = (
            "outlines at two stations or more are needed; one is enough for a slab (thickness: ...)"
        )
        what += ", none for a body of rotation (lathe: [[place along the axis, radius], ...])"
        faults.append(error_at(document, ("stations",) if file.stations else (), what))
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
            faults.append(
                error_at(document, ("stations", k, "points", found[1]), f"the curve {other}")
            )
    return faults
