"""Motion files: BVH, the project's own tables, OpenSim; each read to the number, each fault with
its line."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import SHARED, real_input
from tests.whole_motions import read_bvh, read_coordinates, read_segment_table
from workbench import InputError, Poses, UsageError, load_body, place
from workbench.cli import main
from workbench.files.motions.bvh import bvh_text
from workbench.files.motions.number_rows import FrameRange
from workbench.files.motions.opensim import coordinate_poses
from workbench.files.motions.tables import angle_table_text, read_angle_table, table_kind
from workbench.model.joint_angles import ContinuousAngles, angles_of, compose
from workbench.model.quaternions import matrices
from workbench.motion.recorded.retarget import retarget
from workbench.motion.recorded.skeleton import bone_positions
from workbench.study.motions import load_motion, written_loss

JUMP = SHARED / "motion" / "bvh" / "01_01.bvh"
BODY = load_body("bubbleman")
TWO = """HIERARCHY
ROOT base
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT tip
  {
    OFFSET 0 2 0
    CHANNELS 3 Yrotation Zrotation Xrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.1
0 0 0 0 0 0 0 0 0
1 2 3 90 0 0 0 0 0
"""


def written(tmp_path, text, name="m.bvh"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_a_bone_turned_90_degrees_about_z_points_to_minus_x(tmp_path):
    bones = read_bvh(written(tmp_path, TWO))
    assert bone_positions(bones)[0].tolist() == [[0, 0, 0], [0, 2, 0]]
    assert bone_positions(bones)[1] == pytest.approx(np.array([[1, 2, 3], [-1, 2, 3]]))
    assert bones.time.tolist() == [0, 0.1]
    assert bones.ends == {"tip": (0, 1, 0)}


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_channels_in_any_order_turn_as_matrices_multiplied_in_that_order(tmp_path, order):
    text = TWO.replace(
        "Zrotation Xrotation Yrotation", " ".join(f"{axis}rotation" for axis in order)
    )
    bones = read_bvh(written(tmp_path, text.replace("1 2 3 90 0 0", "0 0 0 30 50 70")))
    turn = np.eye(3)
    for axis, angle in zip(order, np.radians([30, 50, 70]), strict=True):
        c = np.cos(angle)
        s = np.sin(angle)
        k = "XYZ".index(axis)
        one = np.eye(3)
        i = (k + 1) % 3
        j = (k + 2) % 3
        one[i, i] = c
        one[i, j] = -s
        one[j, i] = s
        one[j, j] = c
        turn = turn @ one
    assert bone_positions(bones)[1, 1] == pytest.approx(turn @ [0, 2, 0])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("Frames: 2", "Frames: 3", "line 17: says 3 frames, 2 are there"),
        ("1 2 3 90 0 0 0 0 0", "1 2 3 90 0 0 0 0", "line 20: 8 values where 9 are needed"),
        (
            "1 2 3 90",
            "1 2 nan 90",
            "line 20, column 3 (base Zposition): 'nan' is not a finite number",
        ),
        ("CHANNELS 3 Yrotation", "CHANNELS 4 Yrotation", "line 9: CHANNELS says 4, 3 are named"),
        ("Yrotation Zrotation", "Wrotation Zrotation", "line 9: no channel 'Wrotation'"),
        ("OFFSET 0 2 0", "OFFSET 0 x 0", "line 8: OFFSET needs three numbers"),
        ("JOINT tip", "JOINT base", "line 6: a second bone 'base'"),
        ("MOTION", "MOTTION", "line 16: 'MOTTION' is not expected here"),
        ("Frame Time: 0.1", "Frame Time: 0", "both must be positive"),
        ("HIERARCHY", "solid cube", "line 1: 'solid cube' is not expected here"),
        ("Frames: 2\nFrame Time: 0.1\n0 0 0 0 0 0 0 0 0\n1 2 3 90 0 0 0 0 0\n", "", "cut short"),
    ],
)
def test_what_is_wrong_in_a_bvh_is_told_with_its_line(tmp_path, old, new, told):
    with pytest.raises(InputError) as caught:
        read_bvh(written(tmp_path, TWO.replace(old, new)))
    assert told in str(caught.value)


def test_a_wrong_number_of_frames_is_accepted_by_the_option_of_the_command(tmp_path, capsys):
    text = (NEW + ROWS).replace("nRows=2", "nRows=3")
    for source in (
        written(tmp_path, TWO.replace("Frames: 2", "Frames: 3")),
        written(tmp_path, text, "m.mot"),
    ):
        assert main(["motion", "show", str(source), "--frames", "as_stated"]) == 3
        assert "--frames as_read of workbench motion" in capsys.readouterr().err
    assert main(["motion", "show", str(source), "--frames", "as_read"]) == 0
    shown = capsys.readouterr()
    assert "2 frames from 0 to 1 s" in shown.out
    assert "its header says 3 frames, 2 are there and are read" in shown.err
    bones = read_bvh(tmp_path / "m.bvh", keep=FrameRange(as_read=True))
    assert len(bones.time) == 2
    assert bones.notes == ("its header says 3 frames, 2 are there and are read",)


def turning(frames=60):
    """The whole body turns three times; an arm swings through 180 degrees and on to 260."""
    time = np.arange(frames) / 50
    share = np.linspace(0, 1, frames)
    angles = np.zeros((frames, len(BODY.joints), 3))
    angles[:, BODY.joint("PV"), 2] = np.radians(1080) * share
    swing = np.radians(260) * share
    angles[:, BODY.joint("LS"), 0] = 0.8 * swing
    angles[:, BODY.joint("LS"), 1] = 0.6 * swing
    angles[:, BODY.joint("LS"), 2] = np.radians(10) * share
    world = np.tile(np.eye(3, 4), (frames, 1, 1))
    return Poses(compose(BODY, angles), 0, world, time), angles


def test_a_table_of_angles_goes_on_where_a_joint_turns_past_half_a_turn(tmp_path):
    motion, angles = turning()
    assert np.abs(np.diff(angles_of(BODY, motion), axis=0)).max() > 5  # rad: principal values jump
    path = written(tmp_path, "".join(angle_table_text(BODY, motion)), "m.csv")
    table = np.genfromtxt(path, delimiter=",", comments="#", skip_header=4)[:, 8:]
    assert table == pytest.approx(np.degrees(angles).reshape(len(angles), -1), abs=1e-3)
    again, _ = read_angle_table(path, BODY)
    assert np.abs(np.sum(again.rotations * motion.rotations, axis=-1)).min() > 1 - 1e-10


def test_angles_go_on_across_batches_and_compose_to_the_same_rotations():
    motion, angles = turning()
    continuous = ContinuousAngles()
    principal = angles_of(BODY, motion)
    parts = [continuous.take(principal[a:b]) for a, b in ((0, 1), (1, 41), (41, 41), (41, 60))]
    assert np.concatenate(parts) == pytest.approx(angles, abs=1e-6)
    rotations = compose(BODY, np.concatenate(parts))
    assert np.abs(np.sum(rotations * motion.rotations, axis=-1)).min() > 1 - 1e-12


def test_the_ranges_of_a_motion_that_turns_round_are_those_of_the_turn(tmp_path, capsys):
    motion, _ = turning()
    path = written(tmp_path, "".join(angle_table_text(BODY, motion)), "m.csv")
    assert main(["motion", "show", str(path), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    low, high = shown["angles_deg"]["LS"]["flexion"]
    assert (low, high) == (0.0, 208.0)


def test_a_part_of_a_motion_keeps_the_files_clock():
    real_input(JUMP)
    bones = read_bvh(JUMP, keep=FrameRange(1.0, 2.0, every=10))
    whole = read_bvh(JUMP)
    rows = np.flatnonzero((whole.time >= 1.0) & (whole.time <= 2.0))[::10]
    assert bones.time == pytest.approx(whole.time[rows])
    assert np.array_equal(bones.rotations, whole.rotations[rows])


def test_a_recorded_jump_is_mapped_to_the_body():
    """CMU subject 1: legs of the unit's length, feet that come back to one floor, elbows that bend
    their own way."""
    real_input(JUMP)
    poses, notes = retarget(BODY, read_bvh(JUMP, keep=FrameRange(every=8)))
    assert "one unit is taken as 55.96 mm" in " ".join(notes)
    low = (place(BODY, poses).centres[..., 2] - BODY.radius[0]).min(axis=1)
    assert np.percentile(low, 50) == pytest.approx(0.0, abs=0.02)
    assert low.min() > -0.05
    assert 0.1 < low.max() < 0.5
    angles = np.degrees(angles_of(BODY, poses))
    for joint in ("LE", "RE", "LK", "RK"):
        bend, aside, turn = np.abs(angles[:, BODY.joint(joint)]).max(axis=0)
        assert 60 < bend < 150
        assert max(aside, turn) < 12


def test_a_skeleton_made_from_the_body_brings_its_pose_back():
    """The zero pose of the body as bones with identity turns: every joint stays at zero."""
    names = {"LT": "Hips", "CT": "Spine", "UT": "Chest", "N": "Neck", "H": "Head"}
    for side, word in (("L", "Left"), ("R", "Right")):
        names |= {
            side + "SM": f"{word}Collar",
            side + "UA": f"{word}Arm",
            side + "LA": f"{word}ForeArm",
            side + "HN": f"{word}Hand",
            side + "UL": f"{word}UpLeg",
            side + "LL": f"{word}Leg",
            side + "F": f"{word}Foot",
        }
    from workbench.model.motion import Bones

    order = [s for s in BODY.segments if s != "STG"]
    at = {s: _proximal(s) for s in order}
    parent = np.array(
        [
            -1 if s == "LT" else order.index(BODY.segments[BODY.parent[BODY.segments.index(s)]])
            for s in order
        ]
    )
    offset = np.array([at[s] - (at[order[parent[k]]] if k else 0) for k, s in enumerate(order)])
    still = np.tile([1.0, 0, 0, 0], (3, len(order), 1))
    bones = Bones(
        tuple(names[s] for s in order),
        parent,
        offset,
        still,
        np.repeat(offset[None], 3, axis=0),
        [0, 1, 2],
        {},
        "own",
    )
    poses, _ = retarget(BODY, bones, metres=1.0)
    hands = [BODY.joint(j) for j in ("LW", "RW")]
    others = [j for j in range(len(BODY.joints)) if j not in hands]
    assert np.abs(poses.rotations[:, others] - [1, 0, 0, 0]).max() < 1e-9
    assert (
        np.degrees(np.abs(angles_of(BODY, poses)[:, hands])).max() < 8
    )  # a hand is laid along its forearm


def _proximal(segment):
    world = place(
        BODY, Poses(np.tile([1.0, 0, 0, 0], (1, len(BODY.joints), 1)), 0, np.eye(3, 4)[None])
    ).world_from_segment
    n = BODY.segments.index(segment)
    return world[0, n, :, 3] + BODY.joint_in_child[0, n - 1]


def test_a_skeleton_without_legs_is_refused_with_its_bones(tmp_path):
    with pytest.raises(
        InputError, match=r"no bone is known for segment LT, LUA.*the bones are base, tip"
    ):
        retarget(BODY, read_bvh(written(tmp_path, TWO)))


@pytest.fixture
def motion():
    rng = np.random.default_rng(2)
    angles = rng.uniform(-0.6, 0.6, (7, len(BODY.joints), 3))
    place = np.tile(np.eye(3, 4), (7, 1, 1))
    place[:, :, 3] = rng.normal(size=(7, 3))
    return Poses(compose(BODY, angles), BODY.segment("LT"), place, np.arange(7) * 0.02)


def test_the_projects_own_table_gives_the_motion_back(tmp_path, motion):
    path = written(tmp_path, "".join(angle_table_text(BODY, motion)), "m.csv")
    again, notes = read_angle_table(path, BODY)
    assert table_kind(path) == "angles"
    assert notes == ()
    assert np.abs(np.degrees(angles_of(BODY, again) - angles_of(BODY, motion))).max() < 1e-4
    assert np.abs(again.world_from_reference - motion.world_from_reference).max() < 1e-8
    assert "".join(angle_table_text(BODY, again)) == path.read_text()


ANGLES = "# reference: LT\ntime [ms], z [mm], LK.flexion [deg], LH.extension [deg]\n0, 900, 10, 5\n20, 900, 20, 5\n"


def test_angles_are_read_by_the_names_of_their_motions(tmp_path):
    poses, _ = read_angle_table(written(tmp_path, ANGLES, "m.csv"), BODY)
    angles = np.degrees(angles_of(BODY, poses))
    assert angles[:, BODY.joint("LK"), 0] == pytest.approx([10, 20])
    assert angles[:, BODY.joint("LH"), 0] == pytest.approx([-5, -5])
    assert poses.time.tolist() == [0, 0.02]
    assert poses.world_from_reference[1, :, 3].tolist() == [0, 0, 0.9]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("time [ms]", "time", "line 2: time needs its unit"),
        ("LK.flexion [deg]", "LK.flexion", "column LK.flexion needs its unit, [deg] or [rad]"),
        (
            "LK.flexion [deg]",
            "LK.bending [deg]",
            "line 2, LK.bending: joint LK: no motion 'bending'",
        ),
        ("LK.flexion", "XK.flexion", "line 2: body bubbleman: no joint 'XK'"),
        ("z [mm]", "z [deg]", "column z needs its unit"),
        ("z [mm]", "height [mm]", "no column 'height'"),
        ("LH.extension", "LK.flexion", "column LK.flexion is there twice"),
        (
            "20, 900, 20, 5",
            "-1, 900, 20, 5",
            "frames are out of order: frame 2 is at -0.001 s, after frame 1 at 0 s",
        ),
        (
            "20, 900, 20, 5",
            "20, 900, , 5",
            "line 4, column 3 (LK.flexion): '' is not a finite number",
        ),
        (
            "LK.flexion [deg]",
            "LK.flexion [rad]",
            "20 rad at 0.02 s, 3 whole turns: is this column in degrees?",
        ),
        ("reference: LT", "reference: pelvis", "no segment 'pelvis'"),
    ],
)
def test_what_is_wrong_in_a_table_is_told(tmp_path, old, new, told):
    with pytest.raises(InputError) as caught:
        read_angle_table(written(tmp_path, ANGLES.replace(old, new), "m.csv"), BODY)
    assert told in str(caught.value)


def test_angles_that_never_exceed_3_degrees_are_suspected_to_be_radians(tmp_path):
    _, notes = read_angle_table(
        written(tmp_path, ANGLES.replace(" 10, 5", " 1, 0").replace("20, 5", "2, 0"), "m.csv"), BODY
    )
    assert notes == ("no joint angle exceeds 3.2 degrees: are these radians?",)


def test_segments_told_one_by_one_are_placed(tmp_path):
    text = "time [s], H.x [mm], H.y [mm], H.z [mm], H.roll [deg], H.pitch [deg], H.yaw [deg]\n0, 100, 0, 1600, 0, 0, 90\n"
    path = written(tmp_path, text, "s.csv")
    track = read_segment_table(path)
    assert table_kind(path) == "segments"
    assert track.segments == ("H",)
    assert track.world_from_segment[0, 0] @ [1, 0, 0, 1] == pytest.approx([0.1, 1.0, 1.6])
    with pytest.raises(InputError, match="segment H needs columns"):
        read_segment_table(written(tmp_path, text.replace("H.yaw [deg]", "H.qw"), "t.csv"))


NEW = "squat\nversion=1\nnRows=2\nnColumns=5\ninDegrees=yes\nendheader\n"
OLD = "name squat\ndatacolumns 5\ndatarows 2\nrange 0 1\nendheader\n"
ROWS = "time\tpelvis_ty\thip_flexion_r\tknee_angle_r\tlumbar_extension\n0\t0.95\t30\t-60\t-20\n1\t0.9\t40\t-80\t-20\n"


@pytest.mark.parametrize("head", [NEW, OLD])
def test_both_headers_of_opensim_are_read(tmp_path, head):
    poses, notes = coordinate_poses(BODY, read_coordinates(written(tmp_path, head + ROWS, "m.mot")))
    angles = np.degrees(angles_of(BODY, poses))
    assert angles[:, BODY.joint("RH"), 0] == pytest.approx([30, 40])
    assert angles[:, BODY.joint("RK"), 0] == pytest.approx([60, 80])
    assert angles[0, [BODY.joint("W"), BODY.joint("SP")], 0] == pytest.approx([10, 10])
    assert poses.world_from_reference[:, 2, 3] == pytest.approx([0.95, 0.9])
    assert notes == ("knee_angle_r is negative in flexion, as in the gait2392 model",)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "inDegrees=yes",
            "inDegrees=no",
            "6.4 whole turns: the header says radians; are these degrees",
        ),
        ("nRows=2", "nRows=3", "header: says 3 frames, 2 are there"),
        ("inDegrees=yes\n", "", "does not say whether angles are degrees"),
        ("\t-80\t-20", "\t-80", "line 9: 4 values where 5 are needed"),
        ("time\t", "zeit\t", "the column 'time' must come first, got 'zeit'"),
        ("time\t", "time=\t", "the first column is 'time', got 'time='"),
    ],
)
def test_what_is_wrong_in_an_opensim_file_is_told(tmp_path, old, new, told):
    with pytest.raises(InputError) as caught:
        read_coordinates(written(tmp_path, (NEW + ROWS).replace(old, new), "m.mot"))
    assert told in str(caught.value)


def test_left_and_right_limbs_of_opensim_mirror_each_other(tmp_path):
    names = "hip_flexion_r hip_adduction_r hip_adduction_l hip_rotation_r hip_rotation_l arm_add_r arm_add_l"
    text = f"m\ndatacolumns 8\ndatarows 1\nendheader\ntime {names}\n0 0 -20 -20 10 10 -30 -30\n"
    poses, _ = coordinate_poses(BODY, read_coordinates(written(tmp_path, text, "m.sto")))
    angles = np.degrees(angles_of(BODY, poses))[0]
    assert angles[BODY.joint("LH")] == pytest.approx(angles[BODY.joint("RH")], abs=1e-9)
    assert angles[BODY.joint("LS")] == pytest.approx(angles[BODY.joint("RS")], abs=1e-9)
    assert angles[BODY.joint("RH"), 1] > 15


@pytest.mark.parametrize("wrong", [{"every": 0}, {"start": 2.0, "end": 1.0}])
def test_a_senseless_pick_of_frames_is_refused(wrong):
    with pytest.raises(UsageError):
        FrameRange(**wrong)


def test_missing_and_empty_files_are_told(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_bvh(tmp_path / "none.bvh")
    with pytest.raises(InputError, match="is empty"):
        read_bvh(written(tmp_path, "\n"))


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), right_angles=st.booleans(), reference=st.integers(0, 18))
def test_every_motion_comes_back_from_every_form_of_frames(seed, right_angles, reference):
    random = np.random.default_rng(seed)
    turns = random.normal(size=(5, 20, 4))
    if right_angles:  # quarter and half turns, and a little
        turns = np.sign(turns) * (np.abs(turns) > 0.7) + 1e-8
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    world = np.concatenate([matrices(turns[:, 19]), 9 * random.normal(size=(5, 3, 1))], axis=-1)
    motion = Poses(turns[:, :19], reference, world, 0.01 * np.arange(5))
    with TemporaryDirectory() as folder:
        for name, text in (
            ("m.csv", angle_table_text(BODY, motion)),
            ("m.bvh", bvh_text(BODY, motion, [place(BODY, motion)])),
        ):
            path = written(Path(folder), "".join(text), name)
            assert written_loss(BODY, motion, path) == ""
            was, now = (joints_of(poses) for poses in (motion, load_motion(BODY, path)[0]))
            assert np.abs(was - now).max() < 1e-6


def test_a_knee_that_twists_and_a_person_who_lies_are_read_as_written(tmp_path, capsys):
    turned = "time [s], pitch [deg], LK.flexion [deg], LK.medial_rotation [deg]\n0, -90, 5, 12\n1, -90, 6, 13\n"
    source = written(tmp_path, turned, "m.csv")
    assert main(["motion", "convert", str(source), "-o", str(tmp_path / "m.bvh")]) == 0
    assert "does not hold" not in capsys.readouterr().err
    poses, _ = load_motion(BODY, tmp_path / "m.bvh")
    knee = np.degrees(angles_of(BODY, poses)[:, BODY.joint("LK")])
    assert np.abs(knee[:, 2]) == pytest.approx([12, 13])
    lower_torso = place(BODY, poses).world_from_segment[:, BODY.segment("LT")]
    assert lower_torso[0, :, 2] == pytest.approx([-1, 0, 0], abs=1e-9)  # on the back


def test_what_a_form_does_not_hold_is_measured_and_told(tmp_path, capsys):
    uneven = "time [s], RE.flexion [deg]\n2, 0\n2.1, 10\n2.4, 40\n"
    source = written(tmp_path, uneven, "m.csv")
    assert main(["motion", "convert", str(source), "-o", str(tmp_path / "m.bvh")]) == 0
    told = capsys.readouterr().err
    assert "frames up to 100 ms off, which are evenly spaced there" in told  # 2, 2.2, 2.4
    assert "the first frame at 0 s, not 2" in told
    score = ["-o", str(tmp_path / "m.laban"), "--tempo", "60"]
    assert main(["motion", "convert", str(source), *score]) == 0
    assert "this form does not hold the whole motion; read back it has joints up to" in (
        capsys.readouterr().err
    )


def joints_of(poses):
    world = place(BODY, poses).world_from_segment[:, 2:]
    return np.einsum("pnij,nj->pni", world[..., :3], BODY.joint_in_child[0, 1:]) + world[..., 3]


@pytest.mark.parametrize("ending", ["csv", "bvh", "glb"])
def test_the_command_line_converts_a_motion(tmp_path, motion, ending, capsys):
    source = written(tmp_path, "".join(angle_table_text(BODY, motion)), "m.csv")
    out = tmp_path / f"out.{ending}"
    assert (
        main(
            ["motion", "convert", str(source), "--out", str(out), "--rate", "100", "--speed", "0.5"]
        )
        == 0
    )
    assert capsys.readouterr().out == f"{out}: 25 frames\n"
    if ending == "csv":
        poses, _ = read_angle_table(out, BODY)
        assert poses.time[[0, -1]] == pytest.approx([0, 0.24])


def test_the_command_line_shows_a_motion_in_numbers_and_words(tmp_path, motion, capsys):
    source = written(tmp_path, "".join(angle_table_text(BODY, motion)), "m.csv")
    assert main(["motion", "show", str(source)]) == 0
    assert "7 frames from 0 to 0.12 s, told of bubbleman" in capsys.readouterr().out
    assert main(["motion", "convert", str(source), "--out", str(tmp_path / "m.fbx")]) == 2
    assert ".fbx is no form of motion to write" in capsys.readouterr().err
    assert main(["motion", "show", str(tmp_path / "none.bvh")]) == 3


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("Frames: 2", "Frames: inf", "both must be positive"),
        ("Frames: 2", "Frames: nan", "both must be positive"),
        ("CHANNELS 3 ", "CHANNELS " + "9" * 5000 + " ", "3 are named"),
        ("CHANNELS 3 ", "CHANNELS \u00b2 ", "3 are named"),
    ],
)
def test_counts_of_a_bvh_that_are_no_numbers_are_told(tmp_path, old, new, told):
    with pytest.raises(InputError, match=told):
        read_bvh(written(tmp_path, TWO.replace(old, new)))


def test_names_in_motions_hold_no_control_characters(tmp_path):
    bones = read_bvh(written(tmp_path, TWO.replace("JOINT tip", "JOINT tip\x1b[2J")))
    assert bones.names == ("base", "tip\\u001b[2J")


def test_a_table_of_many_columns_is_looked_through_at_once(tmp_path):
    names = ", ".join(f"J{k}.flexion [deg]" for k in range(60_000))
    start = process_time()
    table_kind(written(tmp_path, f"time [s], {names}\n", "a.csv"))
    assert process_time() - start < 5


def test_a_number_too_large_to_reckon_with_is_told(tmp_path):
    with pytest.raises(
        InputError, match=r"line 20, column 4 \(base Zrotation\): '1e308' is too large"
    ):
        read_bvh(written(tmp_path, TWO.replace("1 2 3 90", "1 2 3 1e308")))
