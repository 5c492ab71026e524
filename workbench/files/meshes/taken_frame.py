"""The unit and the axes with which a mesh is taken: as stated, as its file says, else guessed with the
reason in words.

Describing, inspecting and drawing a bare mesh take the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_schema import unit_metres
from workbench.files.meshes.axes import guessed_axes
from workbench.files.meshes.parts import RawMesh
from workbench.files.meshes.reading import axes_rotation, implausible, to_world
from workbench.files.meshes.sizes import named_fits
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats

__all__ = ["Taken", "TakenFrame", "taken_frame"]

_LIKELY = 1.0
"""A mesh that is smaller [m] is no likely cockpit."""
_LONG = 15.0
"""A mesh that is larger [m] is a less likely one."""
_NAMES = 2.0
_FEW = 2.0
"""What odd names weigh at most, and how many names weigh half of that."""
_NO_COCKPIT = 1.0
_HALL = 0.5
"""What it weighs that a mesh is smaller or larger than likely."""
_PLAIN = 0.75
"""A unit against which not so much more speaks than against another one is possible too."""
_ODD = 0.5
"""A unit that is plain has no more than this against it."""


@dataclass(frozen=True)
class Taken:
    """A unit or an axis.

    Parameters
    ----------
    value
        As in the file of an environment.
    why
        How it was guessed, in words; "" where it was stated, or the mesh file says it.
    sure
        Whether that tells plainly.
    """

    value: str
    why: str = ""
    sure: bool = True


@dataclass(frozen=True)
class TakenFrame:
    """How a mesh is taken: its unit, the axis that is up and the one that is forward."""

    length: Taken
    up: Taken
    forward: Taken

    @property
    def metres(self) -> float:
        """One unit of the file [m]."""
        return unit_metres(self.length.value)

    @property
    def rotation(self) -> Floats:
        """(3, 3) from the axes of the file to x forward, y left, z up."""
        return axes_rotation(self.up.value, self.forward.value)

    def assumed(self) -> Iterator[str]:
        """Sentences about what was guessed."""
        for what, one in (("unit", self.length), ("up", self.up), ("forward", self.forward)):
            if one.why:
                doubt = "" if one.sure else " (not sure)"
                yield f"{what} {one.value}{doubt}: {one.why}"


def taken_frame(
    raw: RawMesh, *, length: str | None = None, up: str | None = None, forward: str | None = None
) -> TakenFrame:
    """Find the unit and the axes of a mesh.

    Parameters
    ----------
    raw
        As in its file.
    length, up, forward
        As stated; None for what the file says, or a guess.

    Raises
    ------
    InputError
        If the unit is none. UsageError if the axes are none, or not at right angles.
    """
    said = replace(raw, up=up or raw.up, forward=forward or raw.forward)
    if forward is None and said.up and said.forward and said.up[-1] == said.forward[-1]:
        said = replace(said, forward=None)
    if said.up and said.forward:
        axes_rotation(said.up, said.forward)
    elif said.up or said.forward:
        given = str(said.up or said.forward)
        axes_rotation(given, "x" if given[-1:] != "x" else "y")
    found = guessed_axes(said)
    turned = _turned(said, found.up, found.forward)
    unit = _unit(said, turned) if length is None else Taken(_checked(raw.file, length))
    ahead = Taken(found.forward, found.why_forward, found.sure_forward)
    if said.forward == found.forward:
        ahead = Taken(found.forward, *(_doubt(said) if forward is None else ()))
    return TakenFrame(
        unit,
        Taken(found.up) if said.up else Taken(found.up, found.why_up, found.sure_up),
        ahead,
    )


def _doubt(said: RawMesh) -> tuple[str, bool] | tuple[()]:
    """Why the forward axis that a mesh's format states may be wrong: its left and right are alike along
    that axis, or names of parts say another one."""
    shape = guessed_axes(replace(said, forward=None))
    named = shape.sure_forward and shape.why_forward.startswith("by the names")
    along = shape.why_forward.startswith("left and right are alike")
    level = str(said.forward)[-1] != shape.forward[-1]
    if (named and shape.forward != said.forward) or (along and level):
        why = shape.why_forward.partition(";")[0]
        return f"its format says so, but {why}: forward may be {shape.forward}", False
    return ()


def _checked(file: str, length: str) -> str:
    try:
        unit_metres(length)
    except ValueError as error:
        raise InputError(f"{file}: length {length!r}: {error}") from None
    return length


def _turned(raw: RawMesh, up: str, forward: str) -> RawMesh:
    """A mesh in x forward, y left, z up, in its own unit."""
    return replace(raw, parts=to_world(raw, axes_rotation(up, forward), metres=1.0))


def _unit(raw: RawMesh, turned: RawMesh) -> Taken:
    """The unit of a mesh: as the file says, else the one that least speaks against.

    The size of the whole is weighed against those of parts that are named after things: n of N that
    are odd weigh 2 n / (N + 2), so that one name alone decides nothing.
    """
    if raw.metres is not None:
        named = [unit for unit, metres in metres_in.items() if math.isclose(metres, raw.metres)]
        return Taken(named[0] if named else f"{1e3 * raw.metres:.9g} mm")
    corners = np.concatenate([part.vertices[part.faces.ravel()] for part in raw.parts])
    largest = float(np.ptp(corners, axis=0).max())
    against: dict[str, float] = {}
    fitting: dict[str, int] = {}
    for unit in ("m", "mm", "cm", "in", "ft"):
        metres = metres_in[unit]
        if implausible(largest, metres):
            continue
        parts = to_world(turned, np.eye(3), metres=metres)
        fits, of = named_fits(parts, metres, file=Path(raw.file).stem)
        fitting[unit] = fits
        against[unit] = _NAMES * (of - fits) / (of + _FEW)
        against[unit] += _NO_COCKPIT * (largest * metres < _LIKELY)
        against[unit] += _HALL * (largest * metres > _LONG)
    if not against:
        return Taken("m", "no unit makes it as large as a cockpit or a vehicle", False)
    best = min(against, key=lambda unit: against[unit])
    near = [unit for unit in against if against[unit] < against[best] + _PLAIN and unit != best]
    others = [f"{largest * metres_in[unit]:.3g} m in {unit}" for unit in near]
    also = f"; it would be {' or '.join(others)}" if others else ""
    usual = best in ("m", "mm") or fitting[best] > 0
    sure = not others and usual and against[best] < _ODD
    return Taken(best, f"by its size, {largest * metres_in[best]:.3g} m long{also}", sure)
