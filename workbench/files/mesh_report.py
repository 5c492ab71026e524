"""What a mesh or an environment holds, as data: sizes, units, counts of faults. Nothing is refused
for its size here, since finding the unit is what one looks for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.files.bare_mesh import read_bare
from workbench.files.environment_doubts import near_part
from workbench.files.environments import load_environment
from workbench.files.schema import metres_in
from workbench.model.arrays import xyz
from workbench.model.environment import Environment

__all__ = ["Described", "Inspection", "PartSize", "inspect_environment", "inspect_mesh"]

Size = tuple[float, float, float]


@dataclass(frozen=True)
class PartSize:
    """One part: its faults, whether it counts as a solid, and its box (least and greatest corner)
    [m]."""

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
        return xyz(np.subtract(self.high, self.low))


@dataclass(frozen=True)
class Described:
    """What an environment's file describes: a seat, a control, an instrument, a mirror or a point, and
    its place [m]. part: that it names, or the nearest one where it names none; gap: how far [m] the
    part is from the place, None where the environment has no part."""

    kind: str
    name: str
    at: Size
    part: str
    named: bool
    gap: float | None


@dataclass(frozen=True)
class Inspection:
    """A file as found. metres_told: one file unit in metres as the file says, None where it does
    not; metres: what was used; assumed: sentences about what was guessed of unit and axes, and of
    what an environment leaves open; size along x, y, z; largest_if: the largest extent [m] in each
    unit it could be in; problem: why it would be refused as an environment, None where it would
    not; described: what an environment has beside its parts."""

    file: str
    format: str
    metres_told: float | None
    metres: float
    up: str
    forward: str
    assumed: tuple[str, ...]
    parts: tuple[PartSize, ...]
    size: Size
    largest_if: dict[str, float]
    warnings: tuple[str, ...]
    problem: str | None
    described: tuple[Described, ...] = ()


def inspect_mesh(
    *sources: str | Path,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Inspection:
    """Look through a mesh file, or several that stand in one frame.

    Parameters
    ----------
    sources, length, up, forward
        As of `read_bare`.

    Raises
    ------
    InputError
        Where one cannot be read at all. UsageError for wrong axes.
    """
    bare = read_bare(sources, length=length, up=up, forward=forward)
    frame = bare.frames[0]
    size = _size(bare.environment)
    told = {raw.metres for raw in bare.raws}
    return Inspection(
        file=" + ".join(str(source) for source in sources),
        format=" + ".join(dict.fromkeys(raw.format for raw in bare.raws)),
        metres_told=told.pop() if len(told) == 1 else None,
        metres=frame.metres,
        up=frame.up.value,
        forward=frame.forward.value,
        assumed=bare.assumed,
        parts=_parts(bare.environment),
        size=size,
        largest_if={unit: max(size) / frame.metres * one for unit, one in metres_in.items()},
        warnings=bare.environment.warnings,
        problem=bare.problem,
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
        assumed=environment.assumed,
        parts=_parts(environment),
        size=size,
        largest_if={"m": max(size)},
        warnings=environment.warnings,
        problem=None,
        described=tuple(_described(environment)),
    )


def _described(environment: Environment) -> Iterator[Described]:
    """What an environment describes beside its parts, each with its part or the nearest one."""
    shown = [name for k, name in enumerate(environment.parts) if not environment.hidden[k]]
    things = [
        *(("seat", one.name, one.srp, (one.cushion.part,)) for one in environment.seats),
        *(("control", one.name, one.at, one.own_parts) for one in environment.controls),
        *(("instrument", one.name, one.at, (one.part,)) for one in environment.instruments),
        *(("mirror", one.name, one.at, (one.part,)) for one in environment.mirrors),
        *(("point", name, at, ()) for name, at in environment.points.items()),
    ]
    for kind, name, at, parts in things:
        near = near_part(environment, at, parts or shown)
        own, gap = (near.name, near.gap) if near else ("", None)
        yield Described(kind, name, at, own, bool(parts), gap)


def _size(environment: Environment) -> Size:
    """The extents of an environment [m]."""
    return xyz(environment.bounds[1] - environment.bounds[0])


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
        low=xyz(corners.min(axis=0)),
        high=xyz(corners.max(axis=0)),
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
