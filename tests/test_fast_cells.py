"""Cells of 16 bits a corner, lists of patches and triangles in lanes: bounds that hold, and lists
that lose nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import box_part, environment_of
from tests.lanes_compiled import cell_mix, list_bounds
from tests.test_fast import ZOO, moved
from workbench.contact.batches import grouped_clearance, least_clearance
from workbench.contact.fields import field_of, packed_faces, packed_records, packed_shells
from workbench.contact.kernels.field import nearest_in, nearest_of, record_point, square_bound
from workbench.contact.kernels.inside import inside_part
from workbench.contact.kernels.triangles import ROWS
from workbench.contact.kernels.wide import DEEP, EIGHT
from workbench.geometry import lanes
from workbench.geometry.polygon import point_polygon

part = st.floats(0, 1, width=32)


def indexed(kind, seed, far=0.0):
    """An environment's field and faces, and 60 points, half of them in its box, the others about
    it."""
    environment = moved(ZOO[kind](seed), [far, -far, far])
    field = field_of(environment, (tuple(range(len(environment.parts))),))
    rng = np.random.default_rng(seed)
    box = environment.bounds
    points = np.concatenate(
        [rng.uniform(box[0], box[1], (30, 3)), rng.uniform(-1, 1, (30, 3)) + box.mean(axis=0)]
    )
    return environment, field, packed_faces(environment), points


@given(st.lists(st.integers(0, 65535), min_size=8, max_size=8), part, part, part)
def test_codes_and_corner_weights_are_compiled_as_defined(values, r, s, t):
    short = np.array(values, dtype=np.uint16)
    out = np.zeros(16, dtype=np.float32)
    mix = cell_mix(short, r, s, t, out)
    assert np.array_equal(out[:8], lanes.codes(short, 0))
    assert np.allclose(out[8:], lanes.corners(r, s, t), rtol=3e-7, atol=1e-12)
    assert out[8:].sum() == pytest.approx(1.0, abs=1e-6)
    assert mix == pytest.approx(
        float(np.dot(out[:8].astype(float), out[8:].astype(float))), rel=1e-6
    )


def test_a_code_is_a_number_of_five_bits_of_exponent_and_eleven_of_mantissa():
    # exponent 3 and mantissa 1 + 1024 / 2048: 1.5 * 2^(3 - 127)
    short = np.full(8, (3 << 11) | 1024, dtype=np.uint16)
    assert lanes.codes(short, 0)[0] == np.float32(1.5 * 2.0**-124)


@pytest.mark.parametrize("kind", ZOO)
def test_what_is_sure_to_be_outside_all_solids_is(kind):
    environment, field, faces, _ = indexed(kind, 8)
    shells = packed_shells(environment)
    stack = np.empty(64, dtype=np.int64)
    seen = 0
    for x in np.random.default_rng(1).uniform(-0.5, 0.5, (400, 3)):
        if any(inside_part(*x, faces, shells, k, stack) for k in range(len(environment.parts))):
            assert not square_bound(*x, field, 0)[1]
            seen += 1
    assert (seen > 0) == (kind in ("boxes", "needles", "pierced"))


@pytest.mark.parametrize("kind", ZOO)
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_the_list_of_a_cell_bounds_the_distance_from_both_sides(kind, far):
    environment, field, faces, points = indexed(kind, 3, far)
    gaps = np.empty(DEEP + EIGHT, dtype=np.float32)
    listed = 0
    for x in points:
        low, high, many = list_bounds(x, field, gaps)
        exact = (
            min(point_polygon(*x, faces, f, np.inf)[0] for f in range(len(environment.normal)))
            ** 0.5
        )
        assert low <= exact <= high
        listed += many > 0
    assert listed > (0 if far else 20)


@pytest.mark.parametrize("kind", ZOO)
def test_lists_and_tree_find_the_same_polygon(kind):
    _, field, _, points = indexed(kind, 5)
    stack = np.empty(DEEP, dtype=np.int64)
    gaps = np.empty(DEEP + EIGHT, dtype=np.float32)
    for x in points:
        wanted = nearest_in(*x, field, field.root[0], -1, np.inf, stack, gaps)
        assert nearest_of(*x, field, 0, np.inf, stack, gaps) == wanted
        assert nearest_of(*x, field, 0, 0.999 * wanted[0], stack, gaps)[1] == -1


@pytest.mark.parametrize("kind", ZOO)
def test_the_nearest_point_by_record_is_that_of_the_polygon(kind):
    environment, field, faces, points = indexed(kind, 6)
    rank = packed_records(environment)[2]
    for x in points[:20]:
        for f in range(len(environment.normal)):
            assert record_point(*x, field, rank[f]) == point_polygon(*x, faces, f, np.inf)[1:]


def test_squares_and_right_triangles_are_nearly_exact_in_lanes():
    # the six squares of a cube; 0.1 m over the middle of one, and 0.1 m off an edge along both axes
    cube = environment_of(
        box_part("cube", [0, 0, 0], [0.3, 0.3, 0.3]), box_part("far", [0.9, 0.9, 0.9], [1, 1, 1])
    )
    field = field_of(cube, ((0, 1),))
    gaps = np.empty(DEEP + EIGHT, dtype=np.float32)
    assert np.all(field.triangle.reshape(-1, ROWS, 8)[:, -1] == 0)
    for x, wanted in (
        ((0.15, 0.15, 0.4), 0.1),
        ((0.4, 0.15, 0.4), 0.02**0.5),
        ((0.1, 0.1, 0.05), 0.05),
    ):
        low, high, many = list_bounds(np.array(x), field, gaps)
        assert many > 0 and high - low < 1e-4
        assert low < wanted < high


def test_by_segment_is_grouped_clearance_of_one_group(one_arm, random_arm, box_cab):
    cab = replace(box_cab, solid=np.array([True, False, True]))
    placed = wb.place(one_arm, random_arm(200, 12))
    found = least_clearance(placed, cab, (0, 1, 2))
    wanted = grouped_clearance(placed, cab, ((0, 1, 2),))
    for one, other in zip(found[:3], wanted, strict=True):
        assert np.array_equal(one, other)
