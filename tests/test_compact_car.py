"""The compact car: its dimensions by SAE J1100, its mesh, and that its file says what its drawing
says."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.pedal_plane import heel_from_ball, pedal_plane_angle
from workbench import eyellipse, seat_curve
from workbench.posture.seating.seating import seat_planes
from workbench.study.warnings import controls_inside_solids

FOLDER = ROOT / "environments" / "compact_car"
SCRIPTS = ROOT / "tools" / "environments" / "compact_car"


@pytest.fixture(scope="module")
def car():
    return wb.load_environment("compact_car")


@pytest.fixture(scope="module")
def at(car):
    """A named point or control [mm]."""
    places = dict(car.points) | {control.name: control.at for control in car.controls}
    return {name: 1e3 * np.array(place) for name, place in places.items()}


def corners(car, part):
    polygons = car.polygons(car.part_index(part))
    first, last = car.triangle_start[[polygons.start, polygons.stop]]
    return 1e3 * car.vertices[car.triangles[first:last]]


def test_the_car_is_made_by_its_script_to_the_byte(tmp_path):
    subprocess.run(
        [sys.executable, ROOT / "tools" / "environments" / "compact_car" / "make.py", tmp_path],
        check=True,
        capture_output=True,
    )
    assert (tmp_path / "compact_car.obj").read_bytes() == (FOLDER / "compact_car.obj").read_bytes()


def test_all_parts_are_closed_solids_and_no_control_is_inside_another_part(car):
    assert len(car.parts) >= 60 and len(car.controls) >= 25
    assert car.solid.all() and not car.warnings
    assert controls_inside_solids(car) == []


def test_the_points_are_those_of_the_dimensions(at):
    sys.path.insert(0, str(SCRIPTS))
    try:
        import dimensions as d
    finally:
        sys.path.remove(str(SCRIPTS))
    for name, place in (
        ("accelerator_heel", d.HEEL),
        ("ball_of_foot", d.BALL),
        ("wheel_centre", d.WHEEL),
        ("headroom", d.ROOF),
        ("accelerator", d.BALL),
    ):
        assert at[name] == pytest.approx(np.array(place), abs=0.06), name
    assert at["driver_h_point"] == pytest.approx([0, d.W20, d.H30])


def test_heel_and_ball_lie_where_the_standards_curve_puts_them(at):
    h30 = (at["driver_h_point"] - at["accelerator_heel"])[2] / 1e3
    assert at["ball_of_foot"][0] == pytest.approx(1e3 * float(seat_curve(h30)), abs=0.1)
    assert at["ball_of_foot"][0] - at["accelerator_heel"][0] == pytest.approx(
        1e3 * float(heel_from_ball(h30)), abs=0.1
    )
    assert at["ball_of_foot"][2] == pytest.approx(
        203 * np.sin(float(pedal_plane_angle(h30))), abs=0.1
    )


def test_the_design_eye_is_the_centroid_of_the_eyellipse(at):
    found = eyellipse(
        at["ball_of_foot"] / 1e3, heel=0.0, side=0.35, wheel=0.56, height=0.25, clutch=True
    )
    assert at["design_eye"] == pytest.approx(1e3 * found.centroid, abs=0.5)


def test_the_headroom_is_975_mm_with_its_102_along_a_line_8_degrees_aft(car, at):
    line = at["headroom"] - at["driver_h_point"]
    assert np.linalg.norm(line) + 102 == pytest.approx(975, abs=0.1)
    assert np.degrees(np.arctan2(-line[0], line[2])) == pytest.approx(8, abs=0.01)
    lining = corners(car, "roof_lining").reshape(-1, 3)
    below = lining[np.abs(lining[:, 1] - 350) < 1]
    order = np.argsort(below[:, 0])
    low = [min(below[np.isclose(below[:, 0], x), 2]) for x in np.unique(below[order, 0])]
    assert np.interp(at["headroom"][0], np.unique(below[order, 0]), low) == pytest.approx(
        at["headroom"][2], abs=1
    )


def test_the_wheel_is_370_mm_across_in_a_plane_24_degrees_from_vertical(car, at):
    points = corners(car, "steering_wheel").reshape(-1, 3) - at["wheel_centre"]
    assert np.ptp(points[:, 1]) == pytest.approx(370, abs=1)
    up = np.array([np.sin(np.radians(24)), 0, np.cos(np.radians(24))])
    assert np.abs(points @ up).max() == pytest.approx(185, abs=1)


def test_over_rim_and_hood_the_design_eye_sees_seven_degrees_down(car, at):
    for part in ("steering_wheel", "instrument_panel", "instrument_cluster"):
        ahead = corners(car, part).reshape(-1, 3)
        ahead = ahead[np.abs(ahead[:, 1] - 350) < 60] - at["design_eye"]
        assert np.degrees(np.arctan2(-ahead[:, 2], ahead[:, 0])).min() >= 6.9, part


@pytest.mark.parametrize("name", ["driver", "passenger"])
def test_cushion_and_back_of_the_seats_lie_in_the_planes_they_are_said_to(car, name):
    seat = car.seat(name)
    cushion, back, _ = seat_planes(seat)
    for part, normal in ((seat.cushion.part, cushion), (seat.back.part, back)):
        polygons = car.polygons(car.part_index(part))
        facing = np.flatnonzero(car.normal[polygons] @ normal > 1 - 1e-4) + polygons.start
        gap = np.abs(car.normal[facing] @ np.array(seat.srp) - car.offset[facing])
        assert gap.min() < 1e-4, part
