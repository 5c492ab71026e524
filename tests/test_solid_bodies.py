"""Every body, at every level of detail, is one solid: nothing of it floats, and no air is enclosed
in it, standing and in any legal posture."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import workbench as wb
from workbench.body.scaling.scale import morph_to

FAMILY = ("adult_male", "adult_female", "child_6", "child_3")
BODIES = [
    *[(name, level) for name in FAMILY for level in ("coarse", "medium", "fine")],
    ("bubbleman", None),
    ("dog", None),
]
POSTURES = 60
CUBE = 0.004
KNOB = 0.003
"""Side [m] of the cubes in which enclosed air is looked for; the radius [m] of a ball that may not
stand in it."""


@pytest.fixture(scope="module", params=BODIES, ids=lambda one: "-".join(filter(None, one)))
def body(request):
    name, level = request.param
    return morph_to(wb.load_body(name), level)


def legal_poses(body, count, seed):
    """Poses (count,) at the legal rotations nearest to random ones, from the zero pose to the ends
    of the stops."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(count, len(body.joints), 4)) * [0.6, 1, 1, 1]
    turns[..., 0] = np.abs(turns[..., 0]) + rng.uniform(0, 3, (count, 1))
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    world = np.broadcast_to(np.eye(3, 4), (count, 3, 4))
    for _ in range(4):
        turns = wb.stops(body, wb.Poses(turns, 0, world)).nearest
    return wb.Poses(turns, 0, world)


def lone_spheres(centres, radius):
    """The spheres that do not hang together with most."""
    near = cKDTree(centres).query_pairs(2 * radius.max(), output_type="ndarray")
    far = np.linalg.norm(centres[near[:, 0]] - centres[near[:, 1]], axis=1)
    held = near[far < radius[near].sum(axis=1)]
    links = coo_matrix((np.ones(len(held)), held.T), (len(radius), len(radius)))
    piece = connected_components(links, directed=False)[1]
    return np.flatnonzero(piece != np.bincount(piece).argmax())


def named(body, spheres):
    return [f"{body.segments[body.sphere_segment[s]]} {s} {body.sphere_names[s]}" for s in spheres]


def test_it_is_one_piece_standing_and_in_any_legal_posture(body):
    poses = wb.join_poses([wb.pose(body, {}), legal_poses(body, POSTURES, seed=5)])
    placed = wb.place(body, poses)
    for row, centres in enumerate(placed.centres):
        lone = lone_spheres(centres, body.radius[0])
        assert not len(lone), (row, named(body, lone))


def test_seated_flesh_hangs_together_too(body):
    sitter = wb.seated(body)
    posture = {
        joint: {"flexion": 90.0} for joint in ("LH", "RH", "LK", "RK") if joint in body.joints
    }
    if not {"LUL", "LF"} <= set(body.segments) or body.name == "dog":
        posture = {}
    placed = wb.place(sitter, wb.pose(sitter, posture))
    lone = lone_spheres(placed.centres[0], sitter.radius[0])
    assert not len(lone), named(sitter, lone)


def enclosed_cubes(centres, radius):
    """Places (n, 3) of cubes of air that no way leads to from outside."""
    low = (centres - radius[:, None]).min(axis=0) - 2 * CUBE
    high = (centres + radius[:, None]).max(axis=0) + 2 * CUBE
    shape = np.ceil((high - low) / CUBE).astype(int)
    solid = np.zeros(shape, bool)
    axes = [low[k] + CUBE * np.arange(shape[k]) for k in range(3)]
    for centre, r in zip(centres, radius, strict=True):
        first = np.maximum(((centre - r - low) / CUBE).astype(int), 0)
        last = ((centre + r - low) / CUBE).astype(int) + 2
        box = tuple(slice(a, b) for a, b in zip(first, last, strict=True))
        away = [(axes[k][box[k]] - centre[k]) ** 2 for k in range(3)]
        solid[box] |= away[0][:, None, None] + away[1][None, :, None] + away[2] <= r * r
    air, _ = label(~solid)
    inside = np.argwhere((air > 0) & (air != air[0, 0, 0]))
    return low + CUBE * inside


def test_no_ball_of_three_millimetres_stands_in_air_inside_it(body):
    # limbs apart: between an arm and the trunk there may be air
    apart = {f"{side}S": {"abduction": 40.0} for side in "LR"}
    apart |= {f"{side}H": {"abduction": 15.0} for side in "LR"}
    centres = wb.place(body, wb.pose(body, {} if body.name == "dog" else apart)).centres[0]
    radius = body.radius[0]
    air = enclosed_cubes(centres, radius)
    # how large a ball stands in it
    room = (np.linalg.norm(air[:, None] - centres, axis=2) - radius).min(axis=1, initial=np.inf)
    assert not np.any(room > KNOB)


def test_a_hollow_and_a_lone_ball_are_found():
    # eight balls about an empty middle, and one apart
    corner = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]) * 0.03
    faces = np.concatenate([np.eye(3), -np.eye(3)]) * 0.055
    shell = np.concatenate([corner, faces])
    radius = np.full(len(shell), 0.034)
    assert len(enclosed_cubes(shell, radius))
    far = np.concatenate([shell, [[0.3, 0, 0]]])
    assert lone_spheres(far, np.append(radius, 0.01)).tolist() == [len(shell)]
