"""Boxes and heads of the trees' nodes: no bound is more than the distance, and none loses a polygon
that is near."""

from __future__ import annotations

import numpy as np
import pytest

from tests.lanes_compiled import node_bounds
from tests.test_fast import ZOO, moved
from workbench.contact.distance_fields import build_distance_field, packed_faces
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT
from workbench.geometry.polygon import point_polygon


def below(trees, c):
    """Ranks of the polygons under a child of a node."""
    if c < 0:
        return [-1 - c]
    return [f for k in range(trees.many[c]) for f in below(trees, trees.child[c, k])]


@pytest.mark.parametrize("kind", ZOO)
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_no_bound_of_a_box_or_head_is_more_than_the_distance(kind, far):
    environment = moved(ZOO[kind](4), [far, -far, far])
    trees = build_distance_field(environment, (tuple(range(len(environment.parts))),)).trees
    faces = packed_faces(environment)
    gaps = np.zeros(DEEP + EIGHT, dtype=np.float32)
    middle = environment.bounds.mean(axis=0)
    number = trees.record[trees.begin[:-1] + 8].astype(int)
    for x in np.random.default_rng(5).uniform(-1, 1, (12, 3)) + middle:
        for m in range(len(trees.many)):
            ranks = [below(trees, c) for c in trees.child[m, : trees.many[m]]]
            exact = [
                min(point_polygon(*x, faces, number[f], np.inf)[0] for f in some) for some in ranks
            ]
            for limit in (np.inf, *exact):
                bits = node_bounds(x, trees.box, trees.head, m, trees.many[m], limit, gaps)
                assert all(
                    gaps[DEEP + k] <= exact[k] * (1 + 1e-6) + 1e-30 for k in range(trees.many[m])
                )
                assert all(bits >> k & 1 for k in range(trees.many[m]) if exact[k] <= limit)
                assert bits >> trees.many[m] == 0


def test_the_head_of_a_slanting_square_is_flat_where_its_box_is_thick():
    # two triangles of a square that slants by 45 degrees: 1 m over its middle both are as far as
    # the middle is
    from tests.conftest import environment_of
    from workbench.files.meshes.parts import RawPart

    corners = np.array([[0, 0, 0], [1, 0, 1], [1, 1, 1.0001], [0, 1, 0]])
    environment = environment_of(RawPart("square", corners, np.array([[0, 1, 2], [0, 2, 3]])))
    trees = build_distance_field(environment, ((0,),)).trees
    gaps = np.zeros(DEEP + EIGHT, dtype=np.float32)
    x = np.array([0.5, 0.5, 0.5]) + np.array([-1, 0, 1]) / np.sqrt(2)
    node_bounds(x, trees.box, trees.head, trees.root[0], 2, np.inf, gaps)
    assert gaps[DEEP : DEEP + 2] == pytest.approx(1.0, abs=1e-3)
