"""What a mesh or an environment holds, as data: sizes, units, counts of faults. Nothing is refused
for its size here, since finding the unit is what one looks for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_schema import unit_metres
from workbench.files.environments import load_environment
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.reading import axes_rotation, implausible, read_mesh, to_world
from workbench.files.meshes.sizes import implausible_sizes
from workbench.files.schema import metres_in
from workbench.model.environment import Environment

__all__ = ["Inspection", "PartSize", "inspect_environment", "inspect_mesh"]

Size = tuple[float, float, float]


@dataclass(frozen=True)
class PartSize:
    """One part: its faults, whether it counts as a solid, and its box (least and greatest corner)
    [m, or file units where no unit is known]."""

    name: str
    faces: int
    polygons: int
    low: Size
    high: Size
    open_edges: int
    degenerate: int
    duplicate: int
    against: int
    one_sided: int
    cavities: int
    nested: int
    crossing: int
    watertight: bool
    inverted: bool
    solid: bool

    @property
    def size(self) -> Size:
        """Extent along x, y, z."""
        return _three(np.subtract(self.high, self.low))


@dataclass(frozen=True)
class Inspection:
    """A file as found. metres_told: one file unit in metres as the file says, None where it does
    not; metres: what was used, None where none is known (lengths are then file units); size along
    x, y, z; largest_if: the largest extent [m] in each unit it could be in; problem: why it would
    be refused as an environment, None where it would not."""

    file: str
    format: str
    metres_told: float | None
    metres: float | None
    up: str
    forward: str
    parts: tuple[PartSize, ...]
    size: Size
    largest_if: dict[str, float]
    warnings: tuple[str, ...]
    problem: str | None


def inspect_mesh(
    path: str | Path,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Inspection:
    """Look through a mesh file. length: its unit, where it does not say it or is wrong; up,
    forward: its axes, where None those the file or its format says, else z and x.

    InputError where it cannot be read at all, UsageError for wrong axes.
    """
    raw = read_mesh(path)
    up = up or raw.up or "z"
    forward = forward or ("z" if up.lstrip("+-") == "y" else "x" if up.lstrip("+-") == "z" else "y")
    rotation = axes_rotation(up, forward)
    try:
        metres = raw.metres if length is None else unit_metres(length)
    except ValueError as error:
        raise InputError(f"{path}: length {length!r}: {error}") from None
    parts = to_world(raw, rotation, metres=metres or 1.0)
    doubts = () if metres is None else implausible_sizes(parts, metres, file=Path(path).stem)
    environment, _ = build_environment(
        Path(path).stem, parts, solid=["auto"] * len(parts), notes=(*doubts, *raw.notes)
    )
    size = _three(environment.bounds[1] - environment.bounds[0])
    units = max(size) / (metres or 1.0)
    return Inspection(
        str(path),
        raw.format,
        raw.metres,
        metres,
        up,
        forward,
        _parts(environment),
        size,
        {unit: units * one for unit, one in metres_in.items()},
        environment.warnings,
        implausible(units, metres),
    )


def inspect_environment(source: str | Path, *, near: Path | None = None) -> Inspection:
    """Look through a complete environment; InputError where it does not load."""
    environment = load_environment(source, near=near)
    size = _three(environment.bounds[1] - environment.bounds[0])
    return Inspection(
        str(source),
        "environment",
        1.0,
        1.0,
        "z",
        "x",
        _parts(environment),
        size,
        {"m": max(size)},
        environment.warnings,
        None,
    )


def _parts(environment: Environment) -> tuple[PartSize, ...]:
    parts = []
    for k, found in enumerate(environment.quality):
        polygons = environment.polygons(k)
        first, last = environment.triangle_start[[polygons.start, polygons.stop]]
        corners = environment.vertices[environment.triangles[first:last].ravel()]
        parts.append(
            PartSize(
                name=found.part,
                faces=found.faces,
                polygons=found.polygons,
                low=_three(corners.min(axis=0)),
                high=_three(corners.max(axis=0)),
                open_edges=found.open_edges,
                degenerate=found.degenerate,
                duplicate=found.duplicate,
                against=found.against,
                one_sided=found.one_sided,
                cavities=found.cavities,
                nested=found.nested,
                crossing=found.crossing,
                watertight=found.watertight,
                inverted=found.inverted,
                solid=bool(environment.solid[k]),
            )
        )
    return tuple(parts)


def _three(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Size:
    x, y, z = (float(value) for value in values)
    return x, y, z
