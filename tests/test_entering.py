"""Parts that are moved into others: how deep, by boxes and sheets that can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.conftest import box_part, environment_of
from workbench.geometry.entering import TOLERANCE, entered

QUAD = np.array([[0, 2, 6], [0, 6, 4]])
"""The two triangles of the bottom of a box."""
SIZES = st.floats(0.1, 0.4)


def room(*, seat, floor, sheet=False, turn=0.0):
    """A box over another one, or over its top alone, both turned about the upright."""
    parts = [box_part("seat", *seat), box_part("floor", *floor)]
    if sheet:
        thick = np.array([0, 0, floor[1][2] - floor[0][2]])
        parts[1] = replace(parts[1], vertices=parts[1].vertices + thick, faces=QUAD)
    cos, sin = np.cos(turn), np.sin(turn)
    spin = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    return environment_of(*(replace(one, vertices=one.vertices @ spin) for one in parts))


@given(SIZES, st.floats(-0.05, 0.08), st.floats(0.0, 0.2), st.booleans(), st.floats(-3, 3))
@example(0.25, -0.03125, 0.125, False, 0.0)
def test_a_box_that_goes_down_enters_a_floor_by_what_it_goes_beyond_it(size, gap, way, sheet, turn):
    """gap: under the box, negative where it stands in the floor already: then all of the way is more."""
    seat = ([0, 0, gap], [size, 0.3, gap + 0.5])
    made = room(seat=seat, floor=([-1, -1, -0.3], [1, 1, 0]), sheet=sheet, turn=turn)
    found = entered(made, ["seat"], (0, 0, -way))
    deep = way - max(gap, 0.0)
    if abs(deep - TOLERANCE) < 1e-3 or abs(gap) < 1e-3:
        return
    assert (found is not None) == (deep > TOLERANCE)
    if found is not None:
        assert (found.part, found.other) == ("seat", "floor")
        assert found.depth == pytest.approx(deep, abs=0.0101 if gap < 0 else 1e-6)
        assert found.touched == (gap < 1e-3)


@given(st.floats(-0.05, 0.05), st.floats(0.01, 0.3), st.booleans(), st.floats(-3, 3))
def test_what_goes_up_from_a_floor_or_out_of_it_or_along_it_enters_nothing(gap, way, sheet, turn):
    seat = ([0, 0, gap], [0.2, 0.3, gap + 0.5])
    made = room(seat=seat, floor=([-1, -1, -0.3], [1, 1, 0]), sheet=sheet, turn=turn)
    assert entered(made, ["seat"], (0, 0, way)) is None
    if gap > 0:
        assert entered(made, ["seat"], (way, 0, 0)) is None
    assert entered(made, ["seat"], (0, 0, 0)) is None


@pytest.mark.parametrize("thick", [0.003, 0.02, 0.2])
def test_a_box_that_goes_all_through_a_plate_is_in_it_by_the_whole_way_from_its_face(thick):
    made = room(seat=([0, 0, 0.05], [0.3, 0.3, 0.5]), floor=([-1, -1, -thick], [1, 1, 0]))
    assert entered(made, ["seat"], (0, 0, -0.08)).depth == pytest.approx(0.03)
    # and the plate that comes up to the box
    assert entered(made, ["floor"], (0, 0, 0.08)).depth == pytest.approx(0.03)


@pytest.mark.parametrize("wide", [0.008, 0.02])
def test_a_post_between_the_points_along_the_edges_of_a_box_is_met_by_its_face(wide):
    low, high = [0.141, 0.143, -1], [0.141 + wide, 0.143 + wide, 0]
    made = room(seat=([0, 0, 0.05], [0.3, 0.3, 0.5]), floor=(low, high))
    assert entered(made, ["seat"], (0, 0, -0.08)).depth == pytest.approx(0.03)


def test_what_stands_elsewhere_before_is_followed_from_there():
    made = room(seat=([0, 0, 0.05], [0.3, 0.3, 0.5]), floor=([0.5, -1, -1], [1, 1, 0]))
    assert entered(made, ["seat"], (0, 0, -0.08)) is None  # beside the floor
    found = entered(made, ["seat"], (0, 0, -0.08), start=(0.4, 0, 0))
    assert found.depth == pytest.approx(0.03) and not found.touched
    assert entered(made, ["seat"], (0, 0, -0.08), start=(0.4, 0, 0), others=[]) is None


def test_what_is_fixed_elsewhere_may_have_gone_through_a_plate_but_not_stay_in_it():
    """A knob of 30 mm, 10 mm under a plate that is 3 mm thick."""
    made = room(seat=([0, 0, -0.043], [0.03, 0.03, -0.013]), floor=([-1, -1, -0.003], [1, 1, 0]))
    for way, deep in ((0.03, 0.02), (0.06, None)):
        found = entered(made, ["seat"], (0, 0, way), way_counts=False)
        assert found is None if deep is None else found.depth == pytest.approx(deep)
        assert entered(made, ["seat"], (0, 0, way)) is not None


@pytest.mark.parametrize("sheet", [False, True])
def test_what_is_fixed_behind_a_surface_is_in_it(sheet):
    seat = ([0, 0, 0.01], [0.03, 0.03, 0.04])
    made = room(seat=seat, floor=([-1, -1, -0.3], [1, 1, 0]), sheet=sheet)
    found = entered(made, ["seat"], (0, 0, -0.09), way_counts=False)
    assert found.depth == pytest.approx(0.08)
