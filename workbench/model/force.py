"""Forces of contact as functions of depth: loading along a power of the depth, unloading along a
steeper one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["ForceLaw", "force_at", "force_history", "tension_history"]


@dataclass(frozen=True)
class ForceLaw:
    """F = stiffness depth^exponent while the depth grows; stiffness [N/m^exponent].

    returned: the share of the work of loading that comes back, above 0, at most 1. On the way out
    and back in again, below the greatest depth D so far, F = F(D) (depth / D)^m with m = (exponent
    + 1) / returned - 1: both curves meet at D, and the areas under them stand as 1 to `returned`.
    friction: Coulomb's coefficient.
    """

    stiffness: float
    exponent: float = 1.0
    returned: float = 1.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        fine = (
            self.stiffness >= 0
            and self.exponent >= 1
            and 0 < self.returned <= 1
            and self.friction >= 0
        )
        if not (fine and np.isfinite([self.stiffness, self.exponent, self.friction]).all()):
            raise InputError(
                "a force law needs stiffness >= 0, exponent >= 1, returned above 0 and at most 1, and "
                f"friction >= 0, got {self}"
            )

    @property
    def unloading(self) -> float:
        """The exponent m of the way out."""
        return (self.exponent + 1.0) / self.returned - 1.0


def force_at(law: ForceLaw, depth: float, deepest: float) -> float:
    """[N] at a depth [m], the deepest [m] so far being `deepest`; 0 where there is no contact."""
    if depth <= 0:
        return 0.0
    most = max(depth, deepest)
    return float(law.stiffness * most**law.exponent * (depth / most) ** law.unloading)


def force_history(law: ForceLaw, depth: Floats) -> Floats:
    """(P,) [N] over depths (P,) [m] in the order of time, negative where apart. A contact that
    parts begins anew."""
    force = np.zeros(len(depth))
    deepest = 0.0
    for p, now in enumerate(depth.tolist()):
        deepest = max(deepest, now) if now > 0 else 0.0
        force[p] = force_at(law, now, deepest)
    return force


def tension_history(law: ForceLaw, longer: Floats) -> Floats:
    """(P,) [N] over elongations (P,) [m] in the order of time. Webbing that was stretched stays as
    it has become: it pulls again along the same way back."""
    deepest = np.maximum.accumulate(np.maximum(longer, 0.0))
    return np.array(
        [
            force_at(law, now, most)
            for now, most in zip(longer.tolist(), deepest.tolist(), strict=True)
        ]
    )
