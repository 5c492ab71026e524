"""Pulses and force laws by hand; simulation files and what is wrong with them. Needs no MuJoCo."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import tracked
from tests.crash_pit import SIMULATION, pit
from workbench import InputError
from workbench.cli import main
from workbench.files.crash.restraints import read_pulse, surface_point
from workbench.files.crash.simulations import load_simulation
from workbench.files.kinds import check_file, kind_of
from workbench.model.simulation import (
    STANDARD_GRAVITY,
    ForceLaw,
    force_at,
    force_history,
    gained,
    half_sine,
    level_at,
    table_pulse,
    trapezoid,
)


def test_a_half_sine_of_16_g_and_90_ms_takes_2_at_over_pi_from_the_speed():
    pulse = half_sine(16 * STANDARD_GRAVITY, 0.09)
    assert gained(pulse, np.array([0.2]))[0] == pytest.approx(2 * 16 * 9.80665 * 0.09 / np.pi)
    assert gained(pulse, np.array([0.045]))[0] == pytest.approx(16 * 9.80665 * 0.09 / np.pi)
    assert level_at(pulse, np.array([-0.01, 0.045, 0.09, 1.0])).tolist() == [
        0,
        16 * STANDARD_GRAVITY,
        0,
        0,
    ]


def test_a_trapezoid_takes_its_area_from_the_speed():
    pulse = trapezoid(100.0, (0.02, 0.03, 0.01), start=0.1)
    assert gained(pulse, np.array([0.1, 0.12, 0.15, 1.0])) == pytest.approx([0, 1.0, 4.0, 4.5])
    assert level_at(pulse, np.array([0.05, 0.11, 0.13, 0.155, 0.2])) == pytest.approx(
        [0, 50, 100, 50, 0]
    )


@given(
    rise=st.floats(0, 0.1),
    hold=st.floats(0.001, 0.1),
    fall=st.floats(0, 0.1),
    peak=st.floats(-300, 300),
    at=st.floats(0, 0.4),
)
def test_the_speed_gained_is_the_integral_of_the_level(rise, hold, fall, peak, at):
    pulse = trapezoid(peak, (rise, hold, fall))
    fine = np.linspace(0, at, 4001)
    level = level_at(pulse, fine)
    area = float(np.sum(0.5 * (level[1:] + level[:-1])) * at / 4000)
    assert gained(pulse, np.array([at]))[0] == pytest.approx(
        area, abs=3e-4 * abs(peak) * max(at, 1e-3) + 1e-9
    )


def test_a_pulse_from_a_table_is_the_triangle_it_says(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text("# a triangle\ntime [ms], acceleration [g]\n0, 0\n90, 16\n180, 0\n")
    pulse = read_pulse(path)
    assert gained(pulse, np.array([1.0]))[0] / 0.3048 == pytest.approx(
        46.3, abs=0.05
    )  # 16 g, 180 ms: ft/s


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (
            "0, 0\n10, nan\n20, 0\n",
            "pulse.csv, line 3, column 2 (acceleration): 'nan' is not a finite number",
        ),
        ("0, 0\n10, 16\n20, 8\n", "line 4: the pulse does not end at 0: 8 g at 20 ms"),
        ("0, 4\n10, 16\n20, 0\n", "line 2: the pulse does not begin at 0"),
        ("0, 0\n10, 16\n10, 8\n20, 0\n", "line 4: time goes back or stands still"),
        ("0, 0\n10, 16, 3\n20, 0\n", "line 3: 3 values where 2 are needed"),
        ("0, 0\n", "needs 3 samples or more, got 1"),
    ],
)
def test_what_is_wrong_in_the_table_of_a_pulse_is_told_with_its_line(tmp_path, rows, told):
    path = tmp_path / "pulse.csv"
    path.write_text("time [ms], acceleration [g]\n" + rows)
    with pytest.raises(InputError) as caught:
        read_pulse(path)
    assert told in str(caught.value)


def test_a_table_without_units_is_refused(tmp_path):
    (tmp_path / "pulse.csv").write_text("time, acceleration [g]\n0, 0\n1, 1\n2, 0\n")
    with pytest.raises(
        InputError,
        match=r"line 1: the header needs a column 'time \[ms\]' or 'time \[s\]', got 'time'",
    ):
        read_pulse(tmp_path / "pulse.csv")


def test_loading_follows_the_power_and_unloading_gives_back_its_share():
    law = ForceLaw(4.0e5, 1.5, 0.25)
    depth = np.linspace(0, 0.04, 20001)
    way = np.concatenate([depth, depth[-2::-1]])
    force = force_history(law, way)
    loading = np.trapezoid(force[:20001], depth)
    assert force[20000] == pytest.approx(4.0e5 * 0.04**1.5)
    assert loading == pytest.approx(4.0e5 * 0.04**2.5 / 2.5, rel=1e-6)
    assert np.trapezoid(force[20000:][::-1], depth) == pytest.approx(0.25 * loading, rel=1e-6)


@given(depth=st.floats(1e-4, 0.1), more=st.floats(0, 0.1), returned=st.floats(0.05, 1.0))
def test_no_way_out_is_harder_than_the_way_in_and_apart_there_is_no_force(depth, more, returned):
    law = ForceLaw(1e5, 1.0, returned)
    assert 0 <= force_at(law, depth, depth + more) <= force_at(law, depth + more, 0.0)
    assert force_at(law, depth, depth) == pytest.approx(1e5 * depth)
    assert force_at(law, -depth, more) == 0.0


def test_a_contact_that_parts_begins_anew():
    law = ForceLaw(1e5, 1.0, 0.2)
    force = force_history(law, np.array([0.01, 0.02, 0.01, -0.001, 0.01]))
    assert force[0] == force[4] == pytest.approx(1000.0)
    assert force[2] < 100.0


def test_a_point_of_a_belt_lies_on_the_surface_of_its_segment(bubbleman):
    n = bubbleman.segment("LT")
    at = surface_point(bubbleman, n, np.array([1.0, 0.0, 0.0]))
    some = bubbleman.spheres(n)
    gap = np.linalg.norm(bubbleman.centre[0, some] - at, axis=1) - bubbleman.radius[0, some]
    assert gap.min() == pytest.approx(0.0, abs=1e-12)


def test_simulations_that_come_along_check_and_tell_their_kind():
    for path in tracked("studies/simulations/*.yaml"):
        assert kind_of(path) == "simulation"
        assert check_file(path).warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("duration: 50", "duration: -50", "pulse.duration"),
        ("duration: 50", "duration: 0.05", "the pulse lasts 0.05 ms, 1 to 10000 ms is a crash"),
        ("duration: 50", "duration: 50000", "the pulse lasts 50000 ms, 1 to 10000 ms is a crash"),
        ("duration: 50", "hold: 50", "'hold' does not belong to a half_sine pulse"),
        ("peak: 20, ", "", "'peak' is missing in a half_sine pulse"),
        (
            "{shape: half_sine, peak: 20, duration: 50}",
            "{shape: table, file: none.csv}",
            "none.csv: no such file",
        ),
        ("shape: half_sine", "toward: [0, 0, 0], shape: half_sine", "'toward' must not be zero"),
        (
            "gravity: 0",
            "belts: [{name: b, route: [pst, [0, 0, 0]], stiffness: 9}]",
            "no anchor 'pst'; did you mean 'post'",
        ),
        (
            "gravity: 0",
            "belts: [{name: b, route: [post, {segment: LX, at: [1, 0, 0]}], stiffness: 9}]",
            "no segment 'LX'",
        ),
        (
            "gravity: 0",
            "belts: [{name: wall, route: [post, [0, 0, 0]], stiffness: 9}]",
            "is named 'wall' already",
        ),
        (
            "gravity: 0",
            "belts: [{name: b, route: [post, [0, 0, 0]], stiffness: 9, slack: -1}]",
            "belts[0].slack",
        ),
        ("gravity: 0", "contact: [{parts: [panel], stiffness: 9}]", "nothing is called 'panel'"),
        ("gravity: 0", "joints: [{joints: [XX], stiffness: 9}]", "no joint 'XX'"),
        ("gravity: 0", "relaxed: [XX]", "no joint 'XX'"),
        ("gravity: 0", "seat: left", "exactly one of 'seat' and 'at'"),
        ("at: {segment: LT, position: [0, 0, 3000]}", "seat: left", "no seat 'left'"),
        ("posture: standing", "posture: asleep", "no posture 'asleep'"),
        ("duration: 100", "frames: 300", "nor 'frames' the 'duration'"),
        ("environment: pit", "environment: pot", "no environments entry named 'pot'"),
    ],
)
def test_what_is_wrong_in_a_simulation_is_told_with_its_place(tmp_path, old, new, told):
    path = pit(tmp_path, SIMULATION.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_simulation(path)
    assert told in str(caught.value)
    assert "pit_crash.yaml:" in str(caught.value)


def test_only_csv_is_written(tmp_path, capsys):
    path = pit(tmp_path)
    assert main(["motion", "simulate", str(path), "-o", str(tmp_path / "x.bvh")]) == 2
    assert "written as .csv" in capsys.readouterr().err


def test_a_table_of_two_samples_is_no_pulse():
    with pytest.raises(InputError, match="3 samples or more"):
        table_pulse(np.array([0.0, 1.0]), np.array([0.0, 0.0]))


def test_without_mujoco_the_missing_part_is_named_and_nothing_is_written(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    path = pit(tmp_path)
    assert main(["motion", "simulate", str(path), "-o", str(tmp_path / "x.csv")]) == 4
    assert "pip install 'bubbleman-workbench[dynamics]'" in capsys.readouterr().err
    assert not (tmp_path / "x.csv").exists()
