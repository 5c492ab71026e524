"""Sides of polygons: edges in one line are one, and no answer changes."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests import oracles
from tests.conftest import environment_of
from workbench.contact.distance_fields import STRAIGHT, straightened
from workbench.files.meshes.parts import RawPart


def sheet(cut, bulge=0.0):
    """A square sheet of cut x cut quads; its far side bulges out in its plane."""
    u, v = np.meshgrid(np.linspace(0, 1, cut + 1), np.linspace(0, 1, cut + 1), indexing="ij")
    points = np.stack([u + bulge * u * v * (1 - v), v, 0 * u], axis=-1).reshape(-1, 3)
    at = np.arange((cut + 1) ** 2).reshape(cut + 1, cut + 1)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return environment_of(RawPart("sheet", points, faces))


@pytest.mark.parametrize("cut", [1, 2, 9])
def test_a_square_cut_finely_has_four_sides(cut):
    environment = sheet(cut)
    assert len(environment.normal) == 1 and len(environment.edges) == 4 * cut
    ends, start = straightened(environment)
    assert start.tolist() == [0, 4]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert np.allclose(lengths, 1.0, rtol=0, atol=1e-15)


def test_a_side_that_bends_keeps_its_vertices():
    ends, _ = straightened(sheet(9, bulge=1e-3))
    assert len(ends) == 3 + 9


def test_a_side_that_bends_by_less_than_distances_are_computed_to_is_straight():
    assert len(straightened(sheet(9, bulge=1e-13))[0]) == 4


def test_sides_lie_on_the_edges_that_they_stand_for():
    environment = sheet(9, bulge=3e-12)  # each corner nearly straight, the side as a whole is not
    ends, _ = straightened(environment)
    corners = environment.vertices[environment.edges[:, 0]]
    way = ends[:, 1] - ends[:, 0]
    arm = corners[:, None] - ends[:, 0]
    along = np.clip(np.einsum("vec,ec->ve", arm, way) / np.einsum("ec,ec->e", way, way), 0, 1)
    away = np.linalg.norm(arm - along[..., None] * way, axis=2).min(axis=1)
    assert away.max() <= STRAIGHT


def test_clearance_is_the_oracle_s_beside_finely_cut_sides(one_arm, random_arm):
    environment = sheet(9)
    placed = wb.place(one_arm, random_arm(24, 4))
    assert np.allclose(
        wb.clearance(placed, environment),
        oracles.clearance(placed, environment),
        rtol=0,
        atol=1e-9,
    )
