"""Seeds: legal postures spread over the range of a limb, to begin again from where a target is missed."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.kept import kept_by_row, kept_with_topology
from workbench.posture.kernels.chain_kinematics import Linkage, new_state
from workbench.posture.kernels.inequality_constraints import ContactPlanes
from workbench.posture.kernels.inverse_kinematics import Seeds, place_chains
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between, linkage

__all__ = ["NO_PLANES", "chains_placed", "new_seeds", "packed_seeds", "seed_angles"]

SEEDS = 128
"""Number of seeds of a limb."""
NO_PLANES = ContactPlanes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def _seed_rows(seeds: Seeds, rows: Ints) -> Seeds:
    return seeds._replace(tips=seeds.tips[rows], placed=seeds.placed[rows])


@kept_by_row(_seed_rows)
def packed_seeds(body: Body, limb: Limb) -> Seeds:
    """Seeds of a limb for all rows of the body."""
    return new_seeds(seed_angles(body, limb.base, limb.end, limb.free), len(body))


def new_seeds(angles: Floats, rows: int) -> Seeds:
    """Seeds with these angles (M, K, 3), for a body of so many rows; the kernels place them."""
    tips = np.zeros((rows, len(angles), 6))
    return Seeds(angles, tips, np.zeros(rows, np.int64), np.eye(3, 4)[None].copy())


@kept_with_topology
def seed_angles(body: Body, base: int, end: int, free: tuple[int, ...]) -> Floats:
    """(M, K, 3) [rad] legal angles spread over the range of the chain from segment `base` to `end`.

    They depend on the joint stops alone, so all rows of a body and all bodies of a topology share them.
    """
    aside = np.zeros((1, 3))
    link = linkage(body[0], base, end, free, aside, aside)
    joints = joints_between(body, base, end)
    limits = body.stops.limits[joints]
    share = np.random.default_rng(1).uniform(size=(4 * SEEDS, len(joints), 3))
    angles = np.where(link.free_of >= 0, -limits[..., 1] + share * limits.sum(axis=-1), 0.0)
    swing = np.linalg.norm(angles[..., :2], axis=-1, keepdims=True)
    angles[..., :2] *= np.minimum(1.0, 3.0 / np.maximum(swing, 1e-9))
    nobody = np.zeros(len(angles), dtype=np.int64)
    origin = np.repeat(np.eye(3, 4)[None], len(angles), axis=0)
    _, breach = chains_placed(link, nobody, origin, angles, inside=True)
    # the legal ones first, then the least wrong: a start need not be legal
    order = np.argsort(breach, kind="stable")[:SEEDS]
    return np.ascontiguousarray(angles[order])


def chains_placed(
    link: Linkage, who: Ints, base: Floats, angles: Floats, *, inside: bool
) -> tuple[Floats, Floats]:
    """Tips (P, 6) of chains at angles (P, K, 3), and their greatest breaches (P,) [rad] of stops;
    inside: the angles are brought inside cones, hinges and twist limits first, in place."""
    tip = np.zeros((len(angles), 6))
    breach = np.zeros(len(angles))
    state = new_state(len(link.axes), len(link.mode), len(link.rows))
    place_chains(link, who, base, angles, inside, NO_PLANES, tip, breach, state)
    return tip, breach
