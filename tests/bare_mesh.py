"""An environment from a mesh file alone, without an environment file."""

from __future__ import annotations

from pathlib import Path

from workbench.errors import InputError
from workbench.files.environment_schema import unit_metres
from workbench.files.meshes.assembly import built
from workbench.files.meshes.reading import axes, extent, implausible, read_mesh, to_world
from workbench.files.meshes.sizes import doubtful_sizes
from workbench.model.environment import Environment


def environment_from_mesh(
    path: str | Path, *, up: str, forward: str, length: str | None = None, solid: bool | str = "auto"
) -> Environment:
    """An environment from one mesh, without rules, seats or points.

    length: the unit (mm, cm, m, in, ft, or one unit's length such as "150 mm") where the file does not say it, or is
    wrong; up, forward: axes of the file (x, y, z, -x, -y, -z); solid: "auto", True or False for every part.
    """
    rotation, source = axes(up, forward), Path(path)
    raw = read_mesh(source)
    metres = _stated(source, length) if length is not None else raw.metres
    wrong = implausible(float(extent(raw.parts).max()), metres)
    if wrong or metres is None:
        raise InputError(f"{source}: {wrong}")
    parts = to_world(raw, rotation, metres=metres)
    notes = (*doubtful_sizes(parts, metres, file=source.stem), *raw.notes)
    environment, faults = built(source.stem, parts, solid=[solid] * len(parts), notes=notes)
    if faults:
        raise InputError([f"{source}: {what}" for _, what in faults])
    return environment


def _stated(source: Path, length: str) -> float:
    try:
        return unit_metres(length)
    except ValueError as error:
        raise InputError(f"{source}: length {length!r}: {error}") from None
