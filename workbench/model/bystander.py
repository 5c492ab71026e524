"""People who stand still while the limbs of others reach."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from workbench.errors import UsageError
from workbench.model.arguments import check_fields
from workbench.model.arrays import Bools, Ints, read_only
from workbench.model.poses import Placed

__all__ = ["Bystander"]


@dataclass(frozen=True, eq=False, repr=False)
class Bystander:
    """Somebody whom the limbs of others keep clear of.

    Parameters
    ----------
    name
        What the person is called.
    placed
        The body where it is (P = 1).
    solid
        (S,) the spheres that are kept clear of; those of segments outside the window never are.
    kept_off
        [m] by how much.

    Raises
    ------
    UsageError
        If there is not one pose, or `solid` is not of the body's spheres.
    """

    name: str
    placed: Placed
    solid: Bools
    kept_off: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self)
        if len(self.placed) != 1:
            raise UsageError(f"bystander {self.name}: expected one pose, got {len(self.placed)}")
        count = len(self.placed.body.sphere_names)
        object.__setattr__(
            self, "solid", read_only(self.solid, np.bool_, (count,), "bystander.solid")
        )

    def __repr__(self) -> str:
        return f"Bystander({self.name!r}, {self.placed.body!r})"

    @cached_property
    def _shown(self) -> list[tuple[int, Ints]]:
        """The segments that have spheres to keep clear of, each with these."""
        body = self.placed.body
        kept = self.solid & self.placed.window[body.sphere_segment]
        starts = pairwise(body.start.tolist())
        rows = [first + np.flatnonzero(kept[first:end]) for first, end in starts]
        return [(n, some) for n, some in enumerate(rows) if len(some)]

    @property
    def spheres(self) -> list[Ints]:
        """Of each segment that has any, the spheres to keep clear of."""
        return [rows for _, rows in self._shown]

    @property
    def segment_names(self) -> list[str]:
        """Whose and which these segments are: "pilot's right lower arm"."""
        names = self.placed.body.segment_names
        return [f"{self.name}'s {names[n]}" for n, _ in self._shown]
