"""Compute the moments of joint stops in a dynamic simulation.

A stop is a soft, progressive spring with dissipation. Its moment grows with the angle beyond the
stop, and it returns little of the energy that it takes.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.posture.kernels.past_stops import StopPack, past_stops

__all__ = ["STOP_SOFTNESS", "stop_moments"]

STOP_SOFTNESS = 0.1
"""Angle [rad] beyond its stop at which a joint meets its reference moment."""
_MAX_STEEPENING = 5.0
"""Angle beyond the stop, in units of STOP_SOFTNESS, from which on the stiffness grows no more."""
_DAMPING_RATE = 15.0
"""Rate [rad/s] at which dissipation doubles an outgoing joint's moment and cancels a returning
joint's one."""


def stop_moments(pack: StopPack, rotations: Floats, rates: Floats, moment: Floats) -> Floats:
    """Compute the moments that push joints back from beyond their stops.

    Parameters
    ----------
    pack
        Joint stops of the body, see `posture.packed_stops`.
    rotations
        (J, 4) joint rotations, unit quaternions.
    rates
        (J, 3) angular velocities [rad/s] of the distal segments, in their frames.
    moment
        (J,) reference moments [Nm], at an angle of STOP_SOFTNESS beyond the stop.

    Returns
    -------
    Floats
        (J, 3) [Nm] on the distal segments, in their frames.

    References
    ----------
    Hunt, K. H. & Crossley, F. R. E. (1975), Coefficient of restitution interpreted as damping in
    vibroimpact, Journal of Applied Mechanics 42, 440-445: damping in proportion to the elastic
    force.
    """
    joints = len(rotations)
    past = np.empty((joints, 3))  # rotation vector from the stop to the joint, zero within it
    past_stops(rotations, pack, np.empty((joints, 3)), np.empty((joints, 3, 2)), past)
    angle = np.linalg.norm(past, axis=1)
    outward_rate = np.sum(past * rates, axis=1) / np.maximum(angle, 1e-12)
    # elastic moment M(u) = M0 (u + u^3) / 2 with u = angle / STOP_SOFTNESS, here as stiffness M / angle
    u = np.minimum(angle / STOP_SOFTNESS, _MAX_STEEPENING)
    stiffness = moment * (1.0 + u**2) / (2.0 * STOP_SOFTNESS)
    # Hunt and Crossley: M (1 + rate / rate0), which neither pulls nor more than doubles
    dissipation = np.clip(1.0 + outward_rate / _DAMPING_RATE, 0.0, 2.0)
    return np.asarray(-(stiffness * dissipation)[:, None] * past)
