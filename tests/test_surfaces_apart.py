"""The distance between two triangle meshes, against points strewn all over them."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.geometry.surfaces import surface_gap


def test_cubes_are_apart_by_the_gap_between_their_faces():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    one = square[[[0, 1, 2], [0, 2, 3]]]
    gap = surface_gap(one, one + np.array([0.25, 0.25, 0.125]))
    assert gap.distance == 0.125
    aside = surface_gap(one, one + np.array([1.3, 0.0, 0.4]))
    assert aside.distance == pytest.approx(0.5)
    assert np.linalg.norm(aside.end - aside.start) == pytest.approx(0.5)


def test_meshes_that_cross_are_not_apart():
    floor = np.array([[[-1, -1, 0], [1, -1, 0], [0, 2, 0]]], dtype=float)
    spike = np.array([[[0, 0, -1], [0.1, 0, 1], [0, 0.1, 1]]], dtype=float)
    for pair in ((floor, spike), (spike, floor)):
        gap = surface_gap(*pair)
        assert gap.distance == 0.0 and gap.start[2] == 0.0


@pytest.mark.parametrize("seed", range(12))
def test_no_points_of_two_meshes_are_nearer(seed):
    rng = np.random.default_rng(seed)
    one = rng.normal(size=(6, 3, 3))
    other = rng.normal(size=(5, 3, 3)) + 2 * rng.normal(size=3)
    gap = surface_gap(one, other)
    share = np.concatenate([np.eye(3), rng.dirichlet(0.4 * np.ones(3), size=100)])
    mine, yours = ((share @ mesh).reshape(-1, 3) for mesh in (one, other))
    least = np.linalg.norm(mine[:, None] - yours[None], axis=2).min()
    assert gap.distance <= least + 1e-12 and gap.distance > least - 0.15
    back = surface_gap(other, one)
    assert back.distance == pytest.approx(gap.distance, abs=1e-12)
