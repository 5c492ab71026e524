"""Where the people of a population sit once their seats are held in a position.

The same people are seated in the same positions over and over: as the travel is searched, where the
search ends, and with each change of the design that leaves seat, pedals and view as they are. Who
sits where does not depend on the company, so everybody is seated once in each position.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.posture.seating.seat import Seated, join_seated

__all__ = ["SeatMemory"]


@dataclass(frozen=True, eq=False)
class SeatMemory:
    """Seated people, filled in place.

    Parameters
    ----------
    known
        By the key of what decides it, and by the number of a person and the position [m] forward
        and up: people who were seated together, and the row among them.
    """

    known: dict[bytes, dict[tuple[int, float, float], tuple[Seated, int]]] = field(
        default_factory=dict
    )

    def seated(
        self, key: bytes, numbers: Ints, positions: Floats, some: Callable[[Ints], Seated]
    ) -> Seated:
        """B people of these numbers (B,) in positions (B, 2) [m]; some: seats those at indices, who
        were not seated there before."""
        known = self.known.setdefault(key, {})
        at = list(zip(numbers.tolist(), *positions.T.tolist(), strict=True))
        new = np.array([row for row, one in enumerate(at) if one not in known], dtype=np.int64)
        if len(new):
            fresh = some(new)
            known.update((at[row], (fresh, k)) for k, row in enumerate(new.tolist()))
        together: dict[int, list[int]] = {}
        for row, one in enumerate(at):
            together.setdefault(id(known[one][0]), []).append(row)
        parts = []
        for rows in together.values():
            batch = known[at[rows[0]]][0]
            parts.append(batch.rows(np.array([known[at[row]][1] for row in rows])))
        return join_seated(parts).rows(np.argsort(np.concatenate(list(together.values()))))
