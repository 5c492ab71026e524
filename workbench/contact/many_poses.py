"""Questions of any number of poses: they are placed and asked block by block, so that memory holds
the answers and one block."""

from __future__ import annotations

import numpy as np

from workbench.body.forward import place
from workbench.contact.batches import pays
from workbench.contact.collide import room
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.spool import pieces

__all__ = ["BLOCK", "room_of_poses"]

BLOCK = 4096
"""Poses that are placed at a time."""


def room_of_poses(body: Body, poses: Poses, environment: Environment) -> Floats:
    """Compute the `room` of any number of poses, a million and more.

    Parameters
    ----------
    body
        The body.
    poses
        P poses.
    environment
        The environment.

    Returns
    -------
    Floats
        (P, N) [m], as `room` gives it for poses that are placed. Beside poses and answers it takes
        memory for 4,096 poses.
    """
    found = np.empty((len(poses), len(body.segments)))
    grid = pays(poses)
    for rows in pieces(len(poses), size=BLOCK):
        found[rows] = room(place(body, poses.rows(rows)), environment, grid=grid)
    return found
