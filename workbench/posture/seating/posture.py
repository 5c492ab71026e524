"""What a sitter's posture is asked for: pedals with the floor below them, places along a seat's
travel, the eyes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.kept import kept_by_row
from workbench.posture.reaching.limbs import Limb, limb

__all__ = ["DECIMALS", "SEAT_SPACING", "Pedals", "pointed_foot", "positions"]

SEAT_SPACING = 0.01
"""Spacing [m] of the seat positions that are tried."""
DECIMALS = 9
"""Of positions [m], so that one that is reached by steps is the one that is stated."""


@dataclass(frozen=True)
class Pedals:
    """Where the balls of the feet go [m], by "left foot" and "right foot", the height [m] of the
    floor that the heels stand on, None where they stand on nothing, and the feet whose pedals move
    with the seat, as footplates do: these are where they stand with the seat not moved, and so is
    the floor of their heels."""

    at: Mapping[str, tuple[float, float, float]]
    floor: float | None = None
    along: tuple[str, ...] = ()


def positions(travel: tuple[float, float]) -> Floats:
    """Positions from the rear to the front of a travel, its ends and zero among them."""
    low, high = travel
    grid = np.arange(np.ceil(low / SEAT_SPACING), np.floor(high / SEAT_SPACING) + 1) * SEAT_SPACING
    ends = [low, min(max(0.0, low), high), high]
    return np.unique(np.round(np.concatenate([ends, grid]), DECIMALS))


@kept_by_row(Limb.rows)
def pointed_foot(body: Body, name: str) -> Limb:
    """The foot that arrives by its ball, pointing from the heel to the ball."""
    ball = limb(body, name, grip="ball")
    heel = limb(body, name, grip="heel")
    sole = ball.tip - heel.tip
    return replace(ball, pointing=sole / np.linalg.norm(sole, axis=1, keepdims=True))
