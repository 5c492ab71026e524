"""Find markers that a file holds though no camera saw them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["without_missing"]

_MIN_HELD_FRAMES = 20
"""Least number of frames in which a measured marker does not repeat one number exactly."""


def without_missing(names: Sequence[str], position: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Replace the positions of missing markers by gaps.

    Some programs write 0, 0, 0 for a marker that was not seen. Others write one constant position
    in all frames; it counts as missing if the marker has 20 frames or more, and another one moves.

    Parameters
    ----------
    names
        M markers.
    position
        (P, M, 3) in the file's own axes, NaN in gaps.

    Returns
    -------
    tuple
        Positions (P, M, 3), and notes that name the missing markers with their frames.
    """
    at_origin = np.all(position == 0.0, axis=-1)
    cleaned = np.where(at_origin[..., None], np.nan, position)
    zeros = at_origin.sum(axis=0)
    seen = np.isfinite(cleaned).all(axis=-1).sum(axis=0)
    with np.errstate(invalid="ignore"):
        first = np.fmin.reduce(cleaned, axis=0)
        last = np.fmax.reduce(cleaned, axis=0)
        still = np.all(first == last, axis=-1)
    held = still & (seen >= _MIN_HELD_FRAMES)
    if not np.any(~still & (seen > 1)):
        held[:] = False  # nobody moves: a posture
    cleaned[:, held] = np.nan
    found = (
        ("markers written as 0, 0, 0 are missing there", zeros),
        ("markers that never move are missing", np.where(held, seen, 0)),
    )
    return cleaned, tuple(
        f"{what}: {_counted(names, frames, len(position))}" for what, frames in found if any(frames)
    )


def _counted(names: Sequence[str], frames: Ints, total: int) -> str:
    """Name the markers with any frames, and how many they are."""
    pairs = zip(names, frames.tolist(), strict=True)
    return ", ".join(f"{name} ({count} of {total} frames)" for name, count in pairs if count)
