"""Simulated crashes against closed forms and laws. Needs MuJoCo (the extra `dynamics`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.rows import changed, rows_of

pytest.importorskip("mujoco")

from tests.conftest import ROOT
from tests.crash_pit import SIMULATION, pit
from workbench import InputError, Poses, place, stops
from workbench.cli import main
from workbench.contact.batches import touching
from workbench.crash.contacts import ContactMemory, contact_forces
from workbench.crash.mass_properties import composite_bodies, segment_inertia, segment_masses
from workbench.crash.simulated import STOP_SOFTNESS, simulate
from workbench.files.crash.simulations import load_simulation
from workbench.files.motions.tables import read_angle_table
from workbench.model.joint_angles import compose
from workbench.model.simulation import gained
from workbench.posture.kernels.limit_violation import past_stops
from workbench.posture.stops import packed_stops
from workbench.study.motion_cases import prepared

BELT = """belts:
  - name: strap
    route: [post, {segment: LT, at: [-1, 0, 0]}]
    stiffness: 50
    slack: 20
    returned: 0.5
"""


def made(tmp_path, **changes):
    text = SIMULATION + changes.pop("more", "")
    for old, new in changes.pop("swap", {}).items():
        text = text.replace(old, new)
    return replace(prepared(load_simulation(pit(tmp_path, text))), **changes)


def pelvis(result):
    return result.motion.world_from_reference[:, :, 3]


def test_a_free_body_falls_half_g_t_squared_and_keeps_its_posture(tmp_path):
    result = simulate(
        made(tmp_path, swap={"gravity: 0": "gravity: 9.80665", "peak: 20": "peak: 0"})
    )
    time = result.motion.clock
    assert len(time) == 101 and time[-1] == pytest.approx(0.1)
    fallen = pelvis(result)[0, 2] - pelvis(result)[:, 2]
    assert fallen == pytest.approx(
        0.5 * 9.80665 * time * (time + 2e-4), abs=1e-6
    )  # semi-implicit steps of 0.2 ms
    assert np.abs(result.motion.rotations - result.motion.rotations[0]).max() < 1e-9


@pytest.mark.parametrize(
    "pulse",
    [
        "{shape: half_sine, peak: 20, duration: 50}",
        "{shape: trapezoid, peak: 16, rise: 10, hold: 20, fall: 30, toward: [0, 1, 0]}",
    ],
)
def test_an_occupant_without_belts_moves_on_with_the_speed_the_vehicle_loses(tmp_path, pulse):
    simulation = made(tmp_path, swap={"{shape: half_sine, peak: 20, duration: 50}": pulse})
    result = simulate(simulation)
    along = pelvis(result) @ np.array(simulation.pulse.toward)
    speed = np.diff(along) / 0.001
    wanted = gained(simulation.pulse, result.motion.clock)
    assert speed[70:] == pytest.approx(wanted[-1], rel=2e-3)
    assert np.diff(wanted[70:]) == pytest.approx(0.0, abs=1e-9)
    assert result.work[-1] == pytest.approx(result.kinetic[-1], rel=5e-3)


def test_the_wall_stops_who_flies_at_it_and_gives_back_only_its_share(tmp_path):
    result = simulate(made(tmp_path, swap={"duration: 100": "duration: 260"}, step=5e-4))
    flying = result.kinetic[60]
    hit = next(k for k in range(60, 261) if result.kinetic[k] < 0.99 * flying)
    body = load_simulation(tmp_path / "studies/simulations/pit_crash.yaml").body
    reach = place(body, result.motion).centres[hit, :, 0] + body.radius[0]
    assert reach.max() == pytest.approx(1.5, abs=0.02)
    assert np.ptp(result.kinetic[55 : hit - 4]) < 1e-3 * flying
    assert result.kinetic[-1] < 0.6 * flying


def test_a_belt_pulls_only_when_its_slack_is_out_and_then_as_stiff_as_stated(tmp_path):
    result = simulate(made(tmp_path, more=BELT))
    longer = result.payout[:, 0]
    tension = result.tension[:, 0]
    assert np.all(tension[longer <= 0.02] == 0) and np.all(tension[longer > 0.0201] > 0)
    loading = np.flatnonzero(np.maximum.accumulate(longer) <= longer + 1e-12)
    loading = loading[longer[loading] > 0.02][
        :-1
    ]  # the last may lie behind a peak between two frames
    assert tension[loading] == pytest.approx(50e3 * (longer[loading] - 0.02), rel=1e-9)
    assert longer.max() > 0.05
    back = int(longer.argmax()) + 5
    assert tension[back] < 50e3 * (longer[back] - 0.02)


def test_the_same_simulation_gives_the_same_bytes_twice(tmp_path):
    path = pit(tmp_path, SIMULATION + BELT)
    out = [tmp_path / f"{name}.csv" for name in ("one", "two")]
    for file in out:
        assert (
            main(
                [
                    "motion",
                    "simulate",
                    str(path),
                    "-o",
                    str(file),
                    "--forces",
                    str(file) + ".forces.csv",
                ]
            )
            == 0
        )
    assert out[0].read_bytes() == out[1].read_bytes()
    head = out[0].read_text().splitlines()
    assert head[1].startswith("# made by: the simulation pit_crash, crude rigid-body dynamics")
    forces = (tmp_path / "one.csv.forces.csv").read_text().splitlines()
    assert forces[0] == "time [ms], strap tension [N], strap payout [mm]" and len(forces) == 102


def test_a_step_too_coarse_is_told_and_nothing_is_written(tmp_path, capsys):
    text = (SIMULATION + BELT).replace("stiffness: 50\n", "stiffness: 90000\n")
    path = pit(tmp_path, text + "step: 5\nframes: 5\n")
    assert main(["motion", "simulate", str(path), "-o", str(tmp_path / "out.csv")]) == 3
    assert "the step of 5 ms is too coarse" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.csv"))


def test_a_ball_has_the_inertia_of_a_ball_and_a_joint_carries_what_lies_beyond(bubbleman):
    n = bubbleman.segment("LHN")
    mass = segment_masses(bubbleman)
    some = np.arange(len(bubbleman.sphere_names))[bubbleman.spheres(n)]
    one = replace_spheres(bubbleman, n, some[:1])
    tensor = segment_inertia(one, mass)[n]
    radius = one.radius[0, one.spheres(n)][0]
    assert np.diag(tensor) == pytest.approx(0.4 * mass[n] * radius**2, rel=0.02)
    still = Poses(
        compose(bubbleman, np.zeros((1, len(bubbleman.joints), 3))), 0, np.eye(3, 4)[None]
    )
    carries = composite_bodies(place(bubbleman, still), mass, segment_inertia(bubbleman, mass))
    knee = bubbleman.joint("LK")
    below = mass[bubbleman.segment("LLL")] + mass[bubbleman.segment("LF")]
    assert carries.mass[knee] == pytest.approx(below)
    assert 0.15 < carries.lever[knee] < 0.35


def replace_spheres(body, segment, keep):
    """A body with only some spheres in a segment."""
    rows = np.concatenate(
        [
            np.arange(body.start[segment]),
            keep,
            np.arange(body.start[segment + 1], len(body.sphere_names)),
        ]
    )
    start = body.start.copy()
    start[segment + 1 :] -= int(body.start[segment + 1] - body.start[segment]) - len(keep)
    per_sphere = (
        "centre",
        "radius",
        "sphere_direction",
        "twist_share",
        "blend_joint",
        "blend_share",
    )
    return changed(
        body,
        start=start,
        sphere_names=tuple(body.sphere_names[r] for r in rows),
        **{name: rows_of(body, name)[rows] for name in per_sphere},
    )


def test_the_fast_stops_agree_with_the_exact_ones_on_who_is_past(bubbleman):
    rng = np.random.default_rng(5)
    angles = rng.uniform(-1.2, 1.2, (300, len(bubbleman.joints), 3))
    poses = Poses(compose(bubbleman, angles), 0, np.tile(np.eye(3, 4), (300, 1, 1)))
    exact = stops(bubbleman, poses)
    pack = packed_stops(bubbleman)
    past = np.empty((19, 3))
    room = (np.empty((19, 3)), np.empty((19, 3, 2)))
    for p in range(300):
        past_stops(poses.rotations[p], pack, *room, past)
        size = np.linalg.norm(past, axis=1)
        margin = exact.margin[p]
        assert np.all((size > 1e-7) == (margin < -1e-7))
        breached = margin < -1e-6
        assert np.all(size[breached] >= -margin[breached] - 1e-7)  # the nearest stop is no farther
        hinge = [bubbleman.joint(j) for j in ("LE", "RK") if breached[bubbleman.joint(j)]]
        assert np.all(size[hinge] < 6 * -margin[hinge] + 3.0)


def test_a_joint_past_its_stop_comes_back_and_goes_no_farther(tmp_path):
    simulation = made(tmp_path, swap={"peak: 20": "peak: 0"}, tone=0.0, duration=0.06)
    elbow = simulation.body.joint("LE")
    beyond = 0.04
    turns = simulation.poses.rotations.copy()
    axis = simulation.body.stops.axes[elbow, 0]
    turns[0, elbow] = np.concatenate([[np.cos(0.5 * beyond)], -np.sin(0.5 * beyond) * axis])
    result = simulate(replace(simulation, poses=replace(simulation.poses, rotations=turns)))
    margin = stops(simulation.body, result.motion).margin[:, elbow]
    assert margin[0] == pytest.approx(-beyond, abs=1e-9)
    assert margin.min() >= -beyond - 1e-6 and margin[-1] > -0.5 * beyond


def test_the_stored_crashes_exceed_no_stop_by_more_than_three_times_the_stated_softness():
    """But the wrists, which levers strike: five times."""
    for name in ("trainer_lap", "trainer_harness"):
        body = load_simulation(name).body
        motion = read_angle_table(ROOT / f"studies/motions/{name}.csv", body)[0]
        least = stops(body, motion).margin.min(axis=0)
        for joint, margin in zip(body.joints[1:], least[1:], strict=True):
            times = 5 if joint in ("LW", "RW") else 3
            assert margin > -times * STOP_SOFTNESS, (name, joint)


def test_the_pilot_is_at_rest_on_his_seat_before_the_crash(tmp_path):
    text = (ROOT / "studies/simulations/trainer_lap.yaml").read_text()
    later = text.replace("fall: 51}", "fall: 51, start: 30}")
    assert later != text
    later = later.replace("duration: 200", "duration: 20")
    path = tmp_path / "still.yaml"
    path.write_text(later)
    simulation = prepared(load_simulation(path))
    result = simulate(simulation)
    assert result.settled < 0.005 and result.warnings == ()
    assert np.linalg.norm(pelvis(result) - pelvis(result)[0], axis=1).max() < 1e-3
    moved = (
        pelvis(result)[0] - place(simulation.body, simulation.poses).world_from_segment[0, 1, :, 3]
    )
    assert np.linalg.norm(moved) < 0.01  # he settles near where the seat puts him
    assert result.tension.max() == 0.0


def test_forces_do_not_depend_on_the_order_in_which_contacts_were_found(monkeypatch):
    simulation = load_simulation("trainer_lap")
    motion = read_angle_table(ROOT / "studies/motions/trainer_lap.csv", simulation.body)[0]
    placed = place(simulation.body, motion.rows(slice(100, 101)))

    def forces():
        memory = ContactMemory.at_start(prepared(simulation), placed)
        return [(one.force, *one.point, *one.normal) for one in contact_forces(memory, placed)]

    straight = forces()
    monkeypatch.setattr(
        "workbench.crash.contacts.touching",
        lambda *asked: tuple(rows[::-1] for rows in touching(*asked)),
    )
    assert len(straight) > 5
    assert forces() == straight


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["trainer_lap", "trainer_harness"])
def test_the_stored_motions_are_made_again_by_their_simulations(name, tmp_path):
    out = tmp_path / "again.csv"
    assert (
        main(["motion", "simulate", str(ROOT / f"studies/simulations/{name}.yaml"), "-o", str(out)])
        == 0
    )
    body = load_simulation(name).body
    again, stored = (
        read_angle_table(file, body)[0] for file in (out, ROOT / f"studies/motions/{name}.csv")
    )
    apart = np.linalg.norm(origins_of(body, again) - origins_of(body, stored), axis=-1)
    trunk = [body.segment(name) for name in ("LT", "CT", "UT", "N", "H")]
    # another processor rounds differently. Starts 1e-12 rad apart: trunk and head 2 mm apart after
    # 100 ms, the pelvis 16 mm at the end, and struck hands and feet by centimetres
    assert apart[:30].max() < 3e-3
    assert apart[:100, trunk].max() < 6e-3
    assert apart[:, trunk[0]].max() < 0.03


def origins_of(body, poses):
    """(P, N, 3) [m] of the segments' frames."""
    return place(body, poses).world_from_segment[..., 3]


def test_faults_of_the_body_are_told(bubbleman):
    with pytest.raises(InputError, match="has no mass"):
        segment_masses(changed(bubbleman, mass=np.zeros(20)))
