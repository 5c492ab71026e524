"""A part of an environment with its mesh, and the names of all parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, SupportsIndex, overload

import numpy as np

from workbench.model.above import above
from workbench.model.arrays import ArrayKind, Floats, Ints, freeze_fields

__all__ = ["Part", "PartNames"]


@dataclass(frozen=True, eq=False, repr=False)
class Part:
    """A part of an environment with its mesh.

    Parameters
    ----------
    name
        As in the environment.
    vertices
        (V, 3) [m].
    faces
        (T, 3) triangles, indices into the vertices.
    solid, hidden, see_through
        As in the environment.
    controls
        The names of the controls on it.
    """

    name: str
    vertices: Floats
    faces: Ints
    solid: bool
    hidden: bool
    see_through: bool
    controls: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        arrays: dict[str, ArrayKind] = {
            "vertices": (np.float64, (None, 3)),
            "faces": (np.int64, (None, 3)),
        }
        freeze_fields(self, arrays, "part")

    def __repr__(self) -> str:
        size = " x ".join(f"{1e3 * length:.0f}" for length in np.ptp(self.bounds, axis=0))
        kind = "solid" if self.solid else "surface"
        return f"Part({self.name}: {kind} of {len(self.faces)} triangles, {size} mm)"

    @property
    def bounds(self) -> Floats:
        """(2, 3) least and greatest coordinates [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def area(self) -> float:
        """Of all triangles [m2]."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def to_trimesh(self) -> Any:
        """Return its mesh as a trimesh.Trimesh, in metres."""
        return above("files.meshes.scene", "part_mesh")(self)


class PartNames(tuple[str, ...]):
    """The names of the parts of an environment, in their order; by a name it gives the part."""

    _part: Callable[[str], Part] | None

    def __new__(cls, names: Iterable[str], part: Callable[[str], Part] | None = None) -> PartNames:
        """part: gives the part of a name."""
        made = super().__new__(cls, names)
        made._part = part
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        # the environment, which binds them again, is not to be pickled with its names
        return PartNames, (tuple(self),)

    @overload
    def __getitem__(self, key: SupportsIndex) -> str: ...
    @overload
    def __getitem__(self, key: slice) -> tuple[str, ...]: ...
    @overload
    def __getitem__(self, key: str) -> Part: ...
    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str) and self._part is not None:
            return self._part(key)
        return super().__getitem__(key)
