"""Joint angles of successive frames without jumps by whole turns."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["ContinuousAngles"]

_TURN = 2.0 * np.pi
_NO_SWING = 1e-9
"""Length [rad] of a swing vector below which it has no direction."""


class ContinuousAngles:
    """Choose among equal joint angles those nearest to the frame before, batch by batch.

    A twist may change by whole turns. A swing vector may grow or shrink by whole turns along its own
    direction: its two components change together, so that the angles still compose to the rotation.
    """

    def __init__(self) -> None:
        self._last: Floats | None = None

    def take(self, angles: Floats) -> Floats:
        """Continue the angles of the batch before.

        Parameters
        ----------
        angles
            (P, J, 3) [rad] two swing components and the twist of J joints, as `angles_of` returns.

        Returns
        -------
        Floats
            (P, J, 3) [rad] angles of the same rotations.
        """
        result = np.array(angles)
        if not len(result):
            return result
        last = result[0] if self._last is None else self._last
        before = np.concatenate([last[None], result[:-1]])
        # a joint without a step of half a turn, from the first frame on, needs nothing
        steps = np.abs(result - before).max(axis=(0, 2), initial=0.0)
        for j in np.flatnonzero(steps > np.pi):
            _continue(last[j], result[:, j])
        self._last = result[-1].copy()
        return result


def _continue(last: Floats, angles: Floats) -> None:
    """Continue the angles (P, 3) of a joint from those before (3,), in place."""
    for row in angles:
        row[2] += _TURN * np.rint((last[2] - row[2]) / _TURN)
        row[:2] = _nearest_swing(last[:2], row[:2])
        last = row


def _nearest_swing(last: Floats, swing: Floats) -> Floats:
    """(2,) the swing vector of the same rotation that is nearest to the one before."""
    size = np.hypot(swing[0], swing[1])
    direction = swing / size if size > _NO_SWING else last / max(np.hypot(*last), _NO_SWING)
    turns = np.rint((last @ direction - size) / _TURN)
    return np.asarray(swing + _TURN * turns * direction)
