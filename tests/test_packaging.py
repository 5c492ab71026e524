"""Vehicle packaging formulae against numbers worked by hand, and what a tangent cutoff means."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from workbench import eyellipse, seat_curve
from workbench.posture.seating.packaging import SEAT_CURVES, Eyellipse

HEIGHTS = np.array([0.150, 0.200, 0.250, 0.300, 0.350, 0.400])


def test_the_curve_of_the_seating_reference_point_at_six_heights():
    assert 1e3 * seat_curve(HEIGHTS) == pytest.approx(
        [970.6, 970.0, 959.6, 939.4, 909.5, 869.8], abs=0.05
    )


def test_the_fifth_percentile_sits_so_far_forward():
    found = 1e3 * seat_curve(HEIGHTS, percentile=5.0)
    assert found == pytest.approx([788.9, 798.4, 796.6, 783.4, 759.0, 723.2], abs=0.05)


@given(st.floats(0.127, 0.405))
def test_a_higher_percentile_sits_farther_back_at_every_height(height):
    places = [float(seat_curve(height, percentile=p)) for p in sorted(SEAT_CURVES)]
    assert places == sorted(places)


def test_what_is_remembered_and_not_read_is_marked():
    assert {p for p, curve in SEAT_CURVES.items() if curve.sure == "sourced"} == {50.0, 95.0}


@pytest.mark.parametrize("height", [0.1, 0.5])
def test_a_seat_too_low_or_too_high_for_a_car_is_refused(height):
    with pytest.raises(wb.InputError, match="127 to 405 mm above the heel"):
        seat_curve(height)


def test_a_seat_at_no_height_is_refused():
    with pytest.raises(wb.UsageError, match="height: expected finite numbers, got nan"):
        seat_curve(np.nan)


def test_a_percentile_without_a_curve_names_those_that_have_one():
    with pytest.raises(
        wb.InputError, match=r"no curve for 42 %; valid: 2\.5, 5, 10, 50, 90, 95, 97\.5"
    ):
        seat_curve(0.25, percentile=42.0)


def test_the_eyes_centroid_by_hand():
    found = eyellipse((0.96, 0.2, 0.18), heel=0.0, side=0.35, wheel=0.56, height=0.25, clutch=True)
    aft = 664 + 0.587 * 560 - 0.176 * 250 - 12.5
    assert 1e3 * found.centroid == pytest.approx([960 - aft, 350, 888])
    assert np.degrees(found.tilt) == pytest.approx(18.6)


def drawn_eyes(ellipse, count=200_000):
    """Normal eyes (N, 3) [m] of which 95 % lie before each tangent plane of the ellipse."""
    c = np.cos(ellipse.tilt)
    s = np.sin(ellipse.tilt)
    own = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    scores = np.random.default_rng(7).standard_normal((count, 3)) * 0.5 * ellipse.axes / 1.6448536
    return ellipse.centroid + scores @ own


@pytest.mark.parametrize(
    "direction", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0.6, 0, -0.8), (0.48, 0.6, 0.64)]
)
def test_of_the_eyes_95_percent_lie_before_any_tangent_plane(direction):
    ellipse = eyellipse(
        (0.96, 0.2, 0.18), heel=0.0, side=0.35, wheel=0.56, height=0.25, clutch=False
    )
    ahead = (drawn_eyes(ellipse) - ellipse.centroid) @ np.array(direction)
    assert np.mean(ahead <= ellipse.cutoff(direction)) == pytest.approx(0.95, abs=0.002)


def test_far_fewer_than_95_percent_of_the_eyes_lie_inside_the_eyellipse():
    """In three dimensions the ellipsoid of 1.645 standard deviations holds 56 % (chi squared with 3
    degrees)."""
    ellipse = eyellipse(
        (0.96, 0.2, 0.18), heel=0.0, side=0.35, wheel=0.56, height=0.25, clutch=False
    )
    c = np.cos(ellipse.tilt)
    s = np.sin(ellipse.tilt)
    own = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    local = (drawn_eyes(ellipse) - ellipse.centroid) @ own.T / (0.5 * ellipse.axes)
    assert np.mean(np.sum(local**2, axis=1) <= 1) == pytest.approx(0.561, abs=0.005)


def test_a_sphere_is_cut_off_at_its_radius_every_way():
    ball = Eyellipse(np.zeros(3), np.array([0.2, 0.2, 0.2]), 0.3)
    for direction in np.eye(3):
        assert ball.cutoff(direction) == pytest.approx(0.1)


def test_an_unknown_eyellipse_is_refused():
    with pytest.raises(wb.InputError, match="no eyellipse for 90 %; valid: 95, 99"):
        eyellipse(
            (0, 0, 0), heel=0.0, side=0.0, wheel=0.5, height=0.25, clutch=False, percentile=90.0
        )
