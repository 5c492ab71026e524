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
    be refused as an environment, None where it would not; assumed: sentences about what an
    environment leaves open and was taken to be so."""

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
    assumed: tuple[str, ...] = ()


def inspect_mesh(
    path: str | Path,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Inspection:
    """Look through a mesh file.

    Parameters
    ----------
    path
        The file.
    length
        Its unit, where it does not say it or is wrong.
    up, forward
        Its axes, where None those that the file or its format says, else z and x.

    Raises
    ------
    InputError
        Where it cannot be read at all. UsageError for wrong axes.
    """
    raw = read_mesh(path)
    name = Path(path).stem
    up = up or raw.up or "z"
    forward = forward or {"y": "z", "z": "x"}.get(up.lstrip("+-"), "y")
    rotation = axes_rotation(up, forward)
    try:
        metres = raw.metres if length is None else unit_metres(length)
    except ValueError as error:
        raise InputError(f"{path}: length {length!r}: {error}") from None
    parts = to_world(raw, rotation, metres=metres or 1.0)
    doubts = () if metres is None else implausible_sizes(parts, metres, file=name)
    notes = (*doubts, *raw.notes)
    environment, _ = build_environment(name, parts, solid=["auto"] * len(parts), notes=notes)
    size = _size(environment)
    units = max(size) / (metres or 1.0)
    return Inspection(
        file=str(path),
        format=raw.format,
        metres_told=raw.metres,
        metres=metres,
        up=up,
        forward=forward,
        parts=_parts(environment),
        size=size,
        largest_if={unit: units * one for unit, one in metres_in.items()},
        warnings=environment.warnings,
        problem=implausible(units, metres),
    )


def inspect_environment(source: str | Path, *, near: Path | None = None) -> Inspection:
    """Look through a complete environment; InputError where it does not load."""
    environment = load_environment(source, near=near)
    size = _size(environment)
    return Inspection(
        file=str(source),
        format="environment",
        metres_told=1.0,
        metres=1.0,
        up="z",
        forward="x",
        parts=_parts(environment),
        size=size,
        largest_if={"m": max(size)},
        warnings=environment.warnings,
        problem=None,
        assumed=environment.assumed,
    )


def _size(environment: Environment) -> Size:
    """The extents of an environment [m]."""
    return _three(environment.bounds[1] - environment.bounds[0])


def _parts(environment: Environment) -> tuple[PartSize, ...]:
    return tuple(_part(environment, k) for k in range(len(environment.quality)))


def _part(environment: Environment, k: int) -> PartSize:
    """The k-th part: its quality and where it is."""
    found = environment.quality[k]
    polygons = environment.polygons(k)
    first, last = environment.triangle_start[[polygons.start, polygons.stop]]
    corners = environment.vertices[environment.triangles[first:last].ravel()]
    return PartSize(
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


def _three(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Size:
    x, y, z = (float(value) for value in values)
    return x, y, z
