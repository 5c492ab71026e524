"""What is assumed of a motion file is checked by its own frames, and every refusal names the option
that goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.test_markers import FULL, marked, trc_text
from tests.whole_motions import read_bvh, read_coordinates
from workbench import InputError, Poses, UsageError, load_body, place
from workbench.cli import main
from workbench.files.motions.bvh import bvh_text
from workbench.files.motions.markers import read_trc
from workbench.files.motions.opensim import coordinate_poses
from workbench.model.joint_angles import angles_of, compose
from workbench.model.quaternions import conjugate, exponential, multiply, rotate, shortest
from workbench.motion.recorded.doubts import motion_doubts
from workbench.motion.recorded.retarget import retarget
from workbench.motion.recorded.skeleton import AXIS_JOINTS, body_lengths
from workbench.study.motions import MotionOptions, load_motion, subject_body

BODY = load_body("bubbleman")
FRAMES = 21
LIMBS = [BODY.segment(side + limb) for side in "LR" for limb in ("UA", "LA", "UL", "LL")]
USUAL = {"LT": "Hips", "CT": "Spine", "UT": "Chest", "N": "Neck", "H": "Head"} | {
    side + limb: word + name
    for side, word in (("L", "Left"), ("R", "Right"))
    for limb, name in (
        ("SM", "Shoulder"),
        ("UA", "Arm"),
        ("LA", "ForeArm"),
        ("HN", "Hand"),
        ("UL", "UpLeg"),
        ("LL", "Leg"),
        ("F", "Foot"),
    )
}
ASF = {"LT": "root", "CT": "lowerback", "UT": "thorax", "N": "lowerneck", "H": "head"} | {
    side.upper() + limb: side + name
    for side in "lr"
    for limb, name in (
        ("SM", "clavicle"),
        ("UA", "humerus"),
        ("LA", "radius"),
        ("HN", "hand"),
        ("UL", "femur"),
        ("LL", "tibia"),
        ("F", "foot"),
    )
}
SMPL = {"LT": "Pelvis", "CT": "Spine1", "UT": "Spine3", "N": "Neck", "H": "Head"} | {
    side + limb: f"{side}_{name}"
    for side in "LR"
    for limb, name in (
        ("SM", "Collar"),
        ("UA", "Shoulder"),
        ("LA", "Elbow"),
        ("HN", "Wrist"),
        ("UL", "Hip"),
        ("LL", "Knee"),
        ("F", "Ankle"),
    )
}


def walk():
    """A body that walks forward: hips -20 to 30 degrees, knees 10 to 70, elbows 20 to 80."""
    phase = np.linspace(0, 2 * np.pi, FRAMES)
    angles = np.zeros((FRAMES, len(BODY.joints), 3))
    for side, sign in (("L", 1.0), ("R", -1.0)):
        swing = sign * np.sin(phase)
        angles[:, BODY.joint(side + "H"), 0] = np.radians(5 + 25 * swing)
        angles[:, BODY.joint(side + "K"), 0] = np.radians(40 + 30 * swing)
        angles[:, BODY.joint(side + "S"), 0] = np.radians(-20 * swing)
        angles[:, BODY.joint(side + "E"), 0] = np.radians(50 - 30 * swing)
    world = np.repeat(np.eye(3, 4)[None], FRAMES, axis=0)
    world[:, 0, 3] = np.linspace(0, 0.5, FRAMES)
    world[:, 2, 3] = 1.0
    return Poses(compose(BODY, angles), BODY.segment("LT"), world, 0.05 * np.arange(FRAMES))


WALK = walk()


def walk_text(names=USUAL, prefix=""):
    """The walk as BVH with these names of bones."""
    text = "".join(bvh_text(BODY, WALK, [place(BODY, WALK)]))
    for segment, name in names.items():
        for word in ("ROOT", "JOINT"):
            text = text.replace(f"{word} {segment}\n", f"{word} {prefix}{name}\n")
    return text


def written(tmp_path, text, name="m.bvh"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.fixture
def bones(tmp_path):
    return read_bvh(written(tmp_path, walk_text()))


def line_errors(poses, wanted=WALK):
    """(degrees) greatest angle between the limbs of two motions."""
    found, true = (
        np.stack([_ends(p, BODY.segments[segment]) for segment in LIMBS]) for p in (poses, wanted)
    )
    cosine = (found * true).sum(axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1))).max()


def _ends(poses, segment):
    first, last = (BODY.joint(joint) for joint in AXIS_JOINTS[segment])
    axis = BODY.joint_in_parent[0, last] - BODY.joint_in_child[0, first]
    world = place(BODY, poses).world_from_segment[:, BODY.segment(segment), :, :3]
    return np.einsum("pij,j->pi", world, axis / np.linalg.norm(axis))


def turned_frames(bones, turns):
    """The same motion with other bone frames, turned by quaternions (B, 4): A' = A Q."""
    above = [turns[p] if p >= 0 else np.array([1.0, 0, 0, 0]) for p in bones.parent]
    back = conjugate(np.array(above))
    return replace(
        bones,
        offset=rotate(back, bones.offset),
        rotations=multiply(multiply(back, bones.rotations), turns),
        shift=rotate(back, bones.shift),
        ends={
            name: tuple(rotate(conjugate(turns[bones.names.index(name)]), np.array(end)).tolist())
            for name, end in bones.ends.items()
        },
        overview=None,
    )


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_whatever_the_frames_of_bones_are_the_limbs_point_where_the_frames_show(
    tmp_path_factory, seed
):
    bones = read_bvh(written(tmp_path_factory.mktemp("m"), walk_text()))
    vectors = np.random.default_rng(seed).normal(size=(len(bones.names), 3)) * 2
    poses, notes = retarget(BODY, turned_frames(bones, exponential(vectors)))
    assert line_errors(poses) < 0.1
    assert any("its zero pose does not stand" in note for note in notes)


def test_bones_all_along_x_at_rest_bring_the_whole_pose_back(bones):
    """Optical capture: every bone turned so that its child lies along x."""
    turns = np.tile([1.0, 0, 0, 0], (len(bones.names), 1))
    for b, name in enumerate(bones.names):
        children = np.flatnonzero(bones.parent == b)
        if name not in ("Hips", "Chest") and len(children):
            way = bones.offset[children[0]] / np.linalg.norm(bones.offset[children[0]])
            turns[b] = shortest(np.array([1.0, 0, 0]), way)
    poses, notes = retarget(BODY, turned_frames(bones, turns))
    straight, _ = retarget(BODY, bones)
    assert line_errors(poses, straight) < 0.1
    assert poses.world_from_reference[:, :, 3] == pytest.approx(
        straight.world_from_reference[:, :, 3], abs=5e-3
    )
    assert any("z is forward" in note for note in notes)


@pytest.mark.parametrize(("vector", "up"), [((np.pi / 2, 0, 0), "z"), ((0, 0, -np.pi / 2), "x")])
def test_up_is_where_the_frames_stand_though_the_rest_pose_stands_elsewhere(bones, vector, up):
    turn = exponential(np.array(vector))
    rotations = np.array(bones.rotations)
    rotations[:, 0] = multiply(turn, rotations[:, 0])
    shift = np.array(bones.shift)
    shift[:, 0] = rotate(turn, shift[:, 0])
    poses, notes = retarget(BODY, replace(bones, rotations=rotations, shift=shift, overview=None))
    wanted, said = retarget(BODY, bones)
    assert np.abs(place(BODY, poses).centres - place(BODY, wanted).centres).max() < 1e-9
    assert f"up is {up} of the file, as its frames stand; its zero pose stands along y" in notes[0]
    assert "100 % of the frames" in notes[0] and "100 % of the frames" in said[0]


def test_position_channels_beyond_the_offset_are_used_and_told(bones):
    arm = bones.names.index("LeftForeArm")
    shift = np.array(bones.shift)
    shift[:, arm] += [10.0, 0, 0]
    poses, notes = retarget(BODY, replace(bones, shift=shift, overview=None))
    assert "position channels put LeftForeArm 10 units from its OFFSET" in notes[0]
    assert line_errors(poses) > 15  # the upper arm points 10 cm further out


def test_left_and_right_exchanged_are_told_by_the_knees_and_turned_back(bones):
    other = {"Left": "Right", "Right": "Left"}
    names = [
        other.get(side := name[:4] if name.startswith("Left") else name[:5], side)
        + name.removeprefix(side)
        for name in bones.names
    ]
    poses, notes = retarget(BODY, replace(bones, names=tuple(names), ends={}, overview=None))
    assert any("left and right are exchanged" in note for note in notes)
    knees = np.degrees(angles_of(BODY, poses)[:, [BODY.joint("LK"), BODY.joint("RK")], 0])
    assert knees.min() > 5 and knees.max() < 75


def test_a_skeleton_in_left_handed_axes_is_turned_back(bones):
    """All of it seen in a mirror across x: places (-x, y, z), rotations about (x, -y, -z)."""
    place_ = np.array([-1.0, 1, 1])
    turned = replace(
        bones,
        offset=bones.offset * place_,
        shift=bones.shift * place_,
        rotations=bones.rotations * [1, 1, -1, -1],
        ends={name: tuple((np.array(end) * place_).tolist()) for name, end in bones.ends.items()},
        overview=None,
    )
    poses, notes = retarget(BODY, turned)
    assert any("its axes are left-handed" in note for note in notes)
    assert line_errors(poses) < 0.1


def test_arms_whose_sides_are_not_those_of_the_legs_are_remarked_on(bones):
    sides = {"LUA": "RightArm", "RUA": "LeftArm", "LLA": "RightForeArm", "RLA": "LeftForeArm"}
    _, notes = retarget(BODY, bones, names=sides | {"LHN": "RightHand", "RHN": "LeftHand"})
    assert notes[0].startswith("its arms have their left where its legs have their right")


def test_bones_without_length_are_refused_with_the_way_on(bones):
    still = np.zeros_like(bones.offset)
    with pytest.raises(InputError, match=r"have no length \(OFFSET 0 0 0\).*--names FILE"):
        retarget(BODY, replace(bones, offset=still, shift=bones.shift * 0, overview=None), metres=1)


@pytest.mark.parametrize(
    ("names", "prefix"),
    [
        (ASF, ""),
        (SMPL, ""),
        (SMPL, "m_avg_"),
        (USUAL, "Character1_"),
        (USUAL, "mixamorig1_"),
        (USUAL, "mixamorig12:"),
        ({}, ""),
    ],
)
def test_usual_names_are_read_whatever_stands_before_all_of_them(tmp_path, names, prefix):
    poses, _ = load_motion(BODY, written(tmp_path, walk_text(names, prefix)))
    assert line_errors(poses) < 0.1


def test_other_names_are_given_by_a_file_for_every_command(tmp_path, capsys):
    odd = {segment: f"bone{k}" for k, segment in enumerate(USUAL)}
    file = str(written(tmp_path, walk_text(odd)))
    assert main(["motion", "show", file]) == 3
    assert "--names FILE" in capsys.readouterr().err
    turned = str(written(tmp_path, "bone5: LSM\n", "turned.yaml"))
    assert main(["motion", "show", file, "--names", turned]) == 3
    assert "no segment 'bone5' (a line is 'SEGMENT: BONE')" in capsys.readouterr().err
    lines = "".join(f"{segment}: {bone}\n" for segment, bone in odd.items())
    names = ["--names", str(written(tmp_path, lines, "names.yaml"))]
    assert main(["motion", "show", file, *names]) == 0
    assert main(["motion", "convert", file, *names, "-o", str(tmp_path / "o.csv")]) == 0
    picture = ["-o", str(tmp_path / "o.svg"), "--at", "0"]
    assert main(["render", "bubbleman", "--motion", file, *names, *picture]) == 0


HEAD = "m\nversion=1\nnRows={}\nnColumns={}\ninDegrees={}\nendheader\n"


def opensim(tmp_path, labels, rows, degrees="yes"):
    head = HEAD.format(len(rows.splitlines()), len(labels.split()) + 1, degrees)
    return read_coordinates(written(tmp_path, f"{head}time {labels}\n{rows}", "m.sto"))


def test_labels_of_opensim_may_be_paths(tmp_path):
    labels = "/jointset/hip_r/hip_flexion_r/value /jointset/hip_r/hip_flexion_r/speed"
    poses, notes = coordinate_poses(BODY, opensim(tmp_path, labels, "0 0.5 9\n1 0.6 9\n", "no"))
    assert angles_of(BODY, poses)[:, BODY.joint("RH"), 0] == pytest.approx([0.5, 0.6])
    assert notes == ("not used: /jointset/hip_r/hip_flexion_r/speed",)


@pytest.mark.parametrize("column", ["force 816 816", "force nan 816", "force force 1 2 3 4"])
def test_a_column_that_is_not_used_refuses_no_file(tmp_path, column):
    words = column.split()
    labels = [word for word in words if word == "force"]
    first, second = np.array(words[len(labels) :]).reshape(2, -1).tolist()
    rows = f"0 30 {' '.join(first)}\n1 40 {' '.join(second)}\n"
    found = opensim(tmp_path, f"hip_flexion_r {' '.join(labels)}", rows)
    assert np.degrees(found.values[:, 0]) == pytest.approx([30, 40])


def test_what_a_used_column_may_not_be_is_told(tmp_path):
    with pytest.raises(InputError, match="columns 2 and 3 are both hip_flexion_r, and differ"):
        opensim(tmp_path, "hip_flexion_r /x/hip_flexion_r/value", "0 1 2\n1 1 3\n")
    with pytest.raises(InputError, match="line 9: hip_flexion_r has no number"):
        opensim(tmp_path, "hip_flexion_r", "0 1\n1 NaN\n")
    with pytest.raises(InputError, match=r"hip_flexion_r is 10 at 1 s, 1.6 whole turns"):
        opensim(tmp_path, "hip_flexion_r", "0 1\n1 10\n", "no")
    with pytest.raises(InputError, match=r"HipR; say which they are .*--names FILE"):
        opensim(tmp_path, "HipR", "0 1\n1 2\n")


def test_radians_called_degrees_are_suspected(tmp_path):
    found = opensim(tmp_path, "hip_flexion_r", "0 0.5\n1 1.2\n")
    assert "are these radians (inDegrees=no" in found.notes[0]


def test_the_last_row_may_repeat_its_time_and_no_other_row(tmp_path):
    found = opensim(tmp_path, "hip_flexion_r", "0 30\n1 40\n1 40\n")
    assert len(found.time) == 2
    assert found.notes == ("line 10, the last one, repeats the time of the line before: left out",)
    with pytest.raises(InputError, match="line 10: frames are out of order"):
        opensim(tmp_path, "hip_flexion_r", "0 30\n1 40\n1 40\n2 40\n")


def trc(rows, names="LASI\t\t\tRASI\t\t\tLHEE\t\t\tRHEE", units="mm", before=""):
    return (
        f"{before}PathFileType\t4\t(X/Y/Z)\tm.trc\n{before}DataRate\tNumFrames\tNumMarkers\tUnits\t\t\n"
        f"100\t{len(rows)}\t4\t{units}\t\t\nFrame#\tTime\t{names}\n\t\tX1\tY1\tZ1\n\n"
        + "".join(f"{k + 1}\t{k / 100}\t{row}\n" for k, row in enumerate(rows))
    )


ROW = "100\t1000\t{}\t-100\t1000\t20\t100\t0\t20\t-100\t0\t20"


def test_nan_in_a_trc_file_is_a_gap(tmp_path):
    rows = [ROW.format("20"), ROW.format("NaN"), ROW.format("")]
    position = read_trc(written(tmp_path, trc(rows), "m.trc")).position
    assert np.isnan(position[:, 0]).all(axis=-1).tolist() == [False, True, True]
    with pytest.raises(InputError, match="'inf' is not a finite number"):
        read_trc(written(tmp_path, trc([ROW.format("inf")]), "m.trc"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("PathFileType", "\n  PathFileType"),
        ("LASI\t\t\t", " LASI  \t  \t\t"),
        ("LASI\t\t\tRASI\t\t\t", "LASI\tLASI\tLASI\tRASI\tRASI\tRASI\t"),
        ("RHEE\n", "RHEE\t\t\t\t \t\n"),
        ("4\tmm", '4 \t"mm"'),
        ("\t", "   "),
    ],
)
def test_padded_headers_of_trc_are_read(tmp_path, old, new):
    text = trc([ROW.format("20")] * 2)
    if "LASI\tLASI" in new:
        text = text.replace("LHEE\t\t\tRHEE", "LHEE\tLHEE\tLHEE\tRHEE\tRHEE\tRHEE")
    found = read_trc(written(tmp_path, text.replace(old, new), "m.trc"))
    assert found.names == ("LASI", "RASI", "LHEE", "RHEE")
    assert found.position[0, 0] == pytest.approx([0.1, -0.02, 1.0])


def test_a_marker_file_without_a_unit_is_read_with_the_option_that_its_refusal_names(tmp_path):
    file = written(tmp_path, trc([ROW.format("20")], units="-"), "m.trc")
    with pytest.raises(InputError, match=r"Units is '-', no unit of length .*--unit '1 mm'"):
        read_trc(file)
    assert read_trc(file, metres=1e-3).position[0, 0, 2] == pytest.approx(1.0)


def test_options_that_a_format_has_no_use_for_are_refused(tmp_path):
    file = written(tmp_path, "time [s], LH.flexion [deg]\n0, 1\n1, 2\n", "m.csv")
    with pytest.raises(UsageError, match="up and unit are for BVH and marker files"):
        load_motion(BODY, file, options=MotionOptions(metres=0.01))
    with pytest.raises(UsageError, match="names are for bones, markers and coordinates"):
        load_motion(BODY, file, options=MotionOptions(names={"LUA": "x"}))


@pytest.mark.parametrize(
    ("form", "options"), [("csv", []), ("bvh", []), ("laban", ["--tempo", "60"])]
)
def test_every_form_that_is_written_is_read_back(tmp_path, capsys, form, options):
    source = written(tmp_path, walk_text())
    first, second = tmp_path / f"a.{form}", tmp_path / f"b.{form}"
    assert main(["motion", "convert", str(source), "-o", str(first), *options]) == 0
    assert main(["motion", "convert", str(first), "-o", str(second), *options]) == 0
    assert main(["motion", "show", str(second)]) == 0
    if form != "laban":
        once, _ = load_motion(BODY, first)
        twice, _ = load_motion(BODY, second)
        assert np.abs(place(BODY, once).centres - place(BODY, twice).centres).max() < 1e-4
        assert line_errors(twice) < 0.1


def test_a_person_on_the_head_and_knees_that_bend_back_are_remarked_on():
    angles = angles_of(BODY, WALK)
    angles[:, BODY.joint("LK"), 0] *= -1
    world = np.array(WALK.world_from_reference)
    world[:, :, :3] = np.diag([-1.0, 1.0, -1.0])
    odd = Poses(compose(BODY, angles), WALK.reference, world, WALK.time)
    assert motion_doubts(BODY, WALK) == ()
    lying, knee = motion_doubts(BODY, odd)
    assert lying.startswith("the head is above the feet in 0 % of the frames only")
    assert knee.startswith("the left knee bends the wrong way, by up to 70 degrees")


@pytest.mark.parametrize(
    ("frame", "way", "told"),
    [
        (slice(7, 8), 5.0, "changes by"),
        (slice(7, None), 5.0, "changes by"),
        (slice(None), 0.0, "travels at"),
    ],
)
def test_a_person_who_jumps_for_a_frame_or_flies_is_remarked_on(frame, way, told):
    """5 m within 0.05 s and back; or 100 m from frame to frame, as millimetres taken for metres."""
    world = np.array(WALK.world_from_reference)
    world[frame, 0, 3] += way
    if not way:
        world[:, 0, 3] = 100.0 * np.arange(len(world))
    odd = Poses(WALK.rotations, WALK.reference, world, WALK.time)
    (said,) = motion_doubts(BODY, odd)
    assert told in said and "m/s" in said


@pytest.mark.parametrize(
    ("factor", "told"),
    [
        (1000.0, "the frames are 50 s apart: if these are milliseconds"),
        (1e-3, "m/s against the pelvis"),
    ],
)
def test_times_in_another_unit_are_remarked_on_and_converted(tmp_path, factor, told, capsys):
    text = walk_text().replace("Frame Time: 0.05", f"Frame Time: {0.05 * factor:g}")
    file = str(written(tmp_path, text))
    assert main(["motion", "show", file]) == 0
    assert told in (said := capsys.readouterr().err)
    out = str(tmp_path / "o.bvh")
    assert f"--speed {factor:g}" in said
    assert main(["motion", "convert", file, "-o", out, "--speed", f"{factor:g}"]) == 0
    capsys.readouterr()
    assert main(["motion", "show", out]) == 0
    assert told not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("factor", "told"), [(60.0, "whole turns"), (np.pi / 180, "are these radians?")]
)
def test_angles_of_many_turns_or_in_radians_are_remarked_on(tmp_path, factor, told):
    """The pelvis turns by 30 degrees in each frame times the factor."""
    head, rows = walk_text().split("Frame Time: 0.05\n")
    table = np.array([row.split() for row in rows.splitlines()], dtype=float)
    table[:, 3:] *= np.pi / 180 if factor < 1 else 1.0
    table[:, 5] = np.linspace(0, 30 * factor, len(table))
    lines = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in table)
    bones = read_bvh(written(tmp_path, f"{head}Frame Time: 0.05\n{lines}\n"))
    assert told in bones.notes[0]


def two_people(tmp_path, second):
    """A file with all markers of a walk twice, `Bob:` and another beginning."""
    markers = marked(WALK, FULL)
    other = markers.position + np.array([0.0, 1.5, 0.0])
    names = [f"Bob:{name}" for name in FULL] + [f"{second}{name}" for name in FULL]
    position = np.concatenate([markers.position, other], axis=1)
    return written(tmp_path, trc_text(names, markers, position), "two.trc")


@pytest.mark.parametrize("second", ["Sue:", "Sue_", ""])
def test_the_markers_of_a_second_person_are_refused_with_the_way_to_leave_them_out(
    tmp_path, second
):
    file = two_people(tmp_path, second)
    with pytest.raises(InputError, match=r"markers of several people.*--names FILE"):
        load_motion(BODY, file)
    names = {"Bob:*": ""} if not second else {f"{second}*": ""}
    poses, _ = load_motion(BODY, file, options=MotionOptions(names=names))
    made, _ = subject_body(BODY, file, options=MotionOptions(names=names))
    assert body_lengths(made)["LLL"] == pytest.approx(body_lengths(BODY)["LLL"], rel=0.02)
    assert poses.world_from_reference[0, 1, 3] == pytest.approx(0 if second else 1.5, abs=0.02)


def test_a_skeleton_without_feet_and_hands_is_read_from_where_its_bones_end(bones):
    """The knees of a skeleton whose frames of bones are arbitrary, and whose shanks end at a site."""
    kept = [b for b, name in enumerate(bones.names) if not name.endswith(("Foot", "Hand"))]
    lost = [b for b in range(len(bones.names)) if b not in kept]
    short = replace(
        bones,
        names=tuple(bones.names[b] for b in kept),
        parent=[kept.index(p) if p >= 0 else -1 for p in bones.parent[kept].tolist()],
        offset=bones.offset[kept],
        rotations=bones.rotations[:, kept],
        shift=bones.shift[:, kept],
        ends={bones.names[bones.parent[b]]: tuple(bones.offset[b].tolist()) for b in lost},
        overview=None,
    )
    turns = exponential(np.random.default_rng(0).normal(size=(len(kept), 3)))
    poses, _ = retarget(BODY, turned_frames(short, turns))
    assert line_errors(poses) < 0.1
