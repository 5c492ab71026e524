"""Marker files and joint angles from markers: known motions come back, real recordings are
explained to millimetres."""

from __future__ import annotations

import numpy as np
import pytest

from tests.c3d_files import c3d_file
from tests.conftest import SHARED, real_input
from workbench import InputError, Poses, UsageError, load_body, place, stops
from workbench.files.motions.markers import read_c3d, read_trc
from workbench.files.motions.number_rows import ALL_FRAMES, FrameRange
from workbench.files.names import unique_names
from workbench.model.joint_angles import angles_of, compose, motion_of
from workbench.model.motion import Markers
from workbench.motion.recorded.marker_names import marker_site
from workbench.motion.recorded.markers import bridged, poses_from_markers
from workbench.motion.recorded.subject_scaling import marker_places
from workbench.study.motions import load_motion

BODY = load_body("bubbleman")
SIDED = [
    "FHD",
    "BHD",
    "SHO",
    "ELB",
    "IEL",
    "WRA",
    "WRB",
    "FIN",
    "ASI",
    "PSI",
    "THI",
    "KNE",
    "KNI",
    "TIB",
    "ANK",
    "HEE",
]
SIDED += ["TOE", "MT5"]
FULL = [side + name for side in "LR" for name in SIDED] + ["C7", "T10", "CLAV", "STRN", "SACR"]


def walk(frames=60):
    """Swinging legs and arms, forward 1 m/s."""
    time = np.arange(frames) / 60
    angles = np.zeros((frames, len(BODY.joints), 3))
    wave = np.sin(2 * np.pi * time)
    for joint, motion, degrees in (
        ("LH", "flexion", 25 * wave + 5),
        ("RH", "flexion", 5 - 25 * wave),
        ("LK", "flexion", 25 - 20 * wave),
        ("RK", "flexion", 25 + 20 * wave),
        ("LS", "flexion", -20 * wave),
        ("RS", "flexion", 20 * wave),
        ("LE", "flexion", 30 + 10 * wave),
        ("RE", "flexion", 30 - 10 * wave),
        ("W", "turn_left", 8 * wave),
    ):
        axis, sign = motion_of(BODY, BODY.joint(joint), motion)
        angles[:, BODY.joint(joint), axis] = sign * np.radians(degrees)
    world = np.tile(np.eye(3, 4), (frames, 1, 1))
    world[:, 0, 3] = time
    world[:, 2, 3] = 0.95
    return Poses(compose(BODY, angles), BODY.segment("LT"), world, time)


def marked(poses, names, shift=0.0):
    """Markers carried by a body, each `shift` [m] off its usual place."""
    sites = {name: marker_site(name) for name in names}
    local, _ = marker_places(BODY, sites)
    rng = np.random.default_rng(0)
    local = local + shift * rng.uniform(-1, 1, local.shape)
    world = place(BODY, poses).world_from_segment[
        :, [BODY.segment(s.segment) for s in sites.values()]
    ]
    position = np.einsum("pmij,mj->pmi", world[..., :3], local) + world[..., 3]
    return Markers(tuple(names), position, poses.time, "made")


def trc_text(names, markers, position=None):
    """A TRC file of markers with z up, in mm, empty where a marker is hidden."""
    points = 1000 * (markers.position if position is None else position)
    rows = [
        f"{p + 1}\t{markers.time[p]:.5f}\t"
        + "\t".join("" if np.isnan(v) else f"{v:.3f}" for v in frame.ravel())
        for p, frame in enumerate(points)
    ]
    return (
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
        f"60\t60\t{len(rows)}\t{len(names)}\tmm\nFrame#\tTime\t"
        + "\t\t\t".join(names)
        + "\n\t\t"
        + "\t".join(f"{a}{k + 1}" for k in range(len(names)) for a in "XYZ")
        + "\n\n"
        + "\n".join(rows)
        + "\n"
    )


def test_a_known_walk_comes_back_from_its_markers():
    poses = walk()
    fit = poses_from_markers(BODY, marked(poses, FULL))
    assert np.sqrt(np.mean(fit.residual**2)) < 0.001
    off = np.degrees(angles_of(BODY, fit.poses) - angles_of(BODY, poses))
    legs = [BODY.joint(j) for j in ("LH", "RH", "LK", "RK", "LE", "RE")]
    assert np.abs(off[:, legs, 0]).max() < 2.0


def test_markers_a_centimetre_off_their_places_are_found_there():
    fit = poses_from_markers(BODY, marked(walk(), FULL, shift=0.01))
    assert np.sqrt(np.mean(fit.residual**2)) < 0.003


@pytest.mark.parametrize(
    ("degrees", "shift"), [(37.0, (0, 0, 0)), (0.0, (10, -10, 0)), (200.0, (3, 4, 1))]
)
def test_a_recording_that_is_turned_and_moved_has_the_same_joint_angles(degrees, shift):
    made = marked(walk(30), FULL, shift=0.01)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    elsewhere = made.position @ turn.T + shift
    fit = poses_from_markers(BODY, made)
    other = poses_from_markers(BODY, Markers(made.names, elsewhere, made.time, "made"))
    joints = [j for j in range(len(BODY.joints)) if j + 1 != fit.poses.reference]
    np.testing.assert_allclose(
        other.poses.rotations[:, joints], fit.poses.rotations[:, joints], atol=1e-9
    )
    there, here = (one.poses.world_from_reference for one in (other, fit))
    np.testing.assert_allclose(there[:, :, 3], here[:, :, 3] @ turn.T + shift, atol=1e-9)
    np.testing.assert_allclose(there[:, :, :3], turn @ here[:, :, :3], atol=1e-9)


def test_joints_solved_from_markers_stay_within_their_stops():
    """Elbows that bend backward and a hand folded on its forearm are not followed past the stops."""
    poses = walk(20)
    angles = angles_of(BODY, poses)
    for joint, motion, degrees in (
        ("LE", "flexion", -20),
        ("RE", "flexion", -40),
        ("LK", "flexion", -15),
    ):
        axis, sign = motion_of(BODY, BODY.joint(joint), motion)
        angles[:, BODY.joint(joint), axis] = sign * np.radians(degrees)
    angles[:, BODY.joint("LW"), 0] = np.radians(np.linspace(80, 130, 20))
    odd = Poses(compose(BODY, angles), poses.reference, poses.world_from_reference, poses.time)
    assert stops(BODY, odd).margin.min() < np.radians(-39)
    fit = poses_from_markers(BODY, marked(odd, FULL))
    assert stops(BODY, fit.poses).margin.min() > -1e-9
    carried = marked(fit.poses, ["C7", "LASI", "RKNE"]).position
    seen = marked(odd, ["C7", "LASI", "RKNE"]).position
    assert np.abs(carried - seen).max() < 0.08  # the rest of the body stays with its markers


def test_a_marker_far_from_where_the_others_put_it_is_left_out_and_named():
    made = marked(walk(30), FULL)
    position = np.array(made.position)
    position[:, FULL.index("LKNE")] += [0.3, 0.2, 0.1]
    position[:, FULL.index("RFIN")] = made.position[:, FULL.index("LTOE")]
    fit = poses_from_markers(BODY, Markers(made.names, position, made.time, "made"))
    assert set(fit.unused) == {"LKNE", "RFIN"}
    assert set(FULL) - set(fit.markers) == {"LKNE", "RFIN"}
    assert np.nanmax(fit.residual) < 0.004
    [note] = [note for note in fit.notes if note.startswith("markers left out, far from where")]
    assert "LKNE (" in note and "RFIN (" in note and " mm)" in note


def test_a_wrong_marker_of_the_pelvis_does_not_exchange_left_and_right():
    names = [name for name in FULL if name not in ("LPSI", "RPSI")]
    made = marked(walk(30), names)
    position = np.array(made.position)
    position[:, names.index("LASI")] -= [0.0, 0.5, 0.0]
    fit = poses_from_markers(BODY, Markers(made.names, position, made.time, "made"))
    assert fit.unused == ("LASI",) and "mirrored" not in " ".join(fit.notes)
    assert np.nanmax(fit.residual) < 0.004


def test_no_marker_of_a_good_recording_is_left_out():
    assert poses_from_markers(BODY, marked(walk(), FULL, shift=0.02)).unused == ()


def test_markers_that_no_body_can_carry_are_refused_and_the_worst_are_named():
    made = marked(walk(20), FULL)
    order = np.random.default_rng(3).permutation(len(FULL))
    mixed = Markers(made.names, made.position[:, order], made.time, "mixed.trc")
    with pytest.raises(InputError, match=r"mixed.trc: the markers are \d+ mm") as caught:
        poses_from_markers(BODY, mixed)
    assert "80 mm at most are accepted; the worst: " in str(caught.value)
    assert sum(name in str(caught.value).split("the worst: ")[1] for name in FULL) >= 5


def test_markers_that_vanish_for_a_while_leave_the_others_to_carry_the_body():
    markers = marked(walk(), FULL)
    position = np.array(markers.position)
    position[20:40, [FULL.index("LKNE"), FULL.index("C7")]] = np.nan
    fit = poses_from_markers(BODY, Markers(markers.names, position, markers.time, "made"))
    assert np.isnan(fit.residual).sum() == 40
    assert np.nanmax(fit.residual) < 0.004


def test_a_mirrored_recording_is_told_and_turned_back():
    markers = marked(walk(), FULL)
    mirrored = Markers(markers.names, markers.position * [1, -1, 1], markers.time, "made")
    fit = poses_from_markers(BODY, mirrored)
    assert "left-handed" in fit.notes[0]
    assert np.sqrt(np.mean(fit.residual**2)) < 0.001


def test_unknown_markers_are_named_and_may_be_given_their_usual_name():
    markers = marked(walk(8), FULL)
    names = tuple("knob" if name == "LASI" else name for name in markers.names)
    odd = Markers(names, markers.position, markers.time, "made")
    assert poses_from_markers(BODY, odd).unused == ("knob",)
    assert poses_from_markers(BODY, odd, names={"knob": "LASI", "C7": ""}).unused == ("C7",)
    with pytest.raises(InputError, match="no marker 'nob'; did you mean 'knob'"):
        poses_from_markers(BODY, odd, names={"nob": "LASI"})
    with pytest.raises(InputError, match="marker 'knob': no usual marker is called 'left ear'"):
        poses_from_markers(BODY, odd, names={"knob": "left ear"})
    with pytest.raises(InputError, match=r"1 markers are known by name, 6 or more are needed"):
        poses_from_markers(BODY, Markers(("LASI", "x"), odd.position[:, :2], odd.time, "made"))


def test_short_gaps_are_bridged_and_long_ones_stay():
    position = np.zeros((10, 1, 3))
    position[:, 0, 0] = np.arange(10)
    position[2:4] = position[5:9] = np.nan
    filled = bridged(Markers(("m",), position, np.arange(10) / 10, "made"), longest=0.35)
    assert filled.position[:5, 0, 0] == pytest.approx([0, 1, 2, 3, 4])
    assert np.isnan(filled.position[5:9]).all()
    with pytest.raises(UsageError):
        bridged(filled, longest=-1)


@pytest.mark.parametrize(
    ("name", "segment"),
    [
        ("LASI", "LT"),
        ("R.ASIS", "LT"),
        ("subject:RFWT", "LT"),
        ("L.Knee.Medial", "LUL"),
        ("RKNE_2", "RUL"),
        ("C7", "UT"),
        ("R.Heel", "RF"),
        ("L.Acromium", "LSM"),
        ("R.Elbow.Lat", "RUA"),
    ],
)
def test_markers_are_known_by_the_names_of_several_sets(name, segment):
    assert marker_site(name).segment == segment


ONE_SIDE_GAIT = """
ASIS Thigh.Upper Thigh.Front Thigh.Rear Shank.Upper Shank.Front Shank.Rear Heel Midfoot.Sup
Midfoot.Lat Toe.Tip Toe.Lat Toe.Med Acromium Bicep Elbow Wrist.Med Wrist.Lat Temple Knee.Lat
Knee.Med Ankle.Lat Ankle.Med
"""
ONE_SIDE_RUNNING = """
ACR ASH PSH UA1 UA2 UA3 LEL MEL FAsuperior FAradius FAulna ASI PSI TH1 TH2 TH3 LFC MFC TB1 TB2 TB3
LMAL MMAL CAL TOE MT5
"""
MIDDLE = ["V.Sacral", "Sternum", "Top.Head", "C7", "CLAV"]
OPENSIM_GAIT = MIDDLE[:3] + [f"{s}.{name}" for s in "RL" for name in ONE_SIDE_GAIT.split()]
OPENSIM_RUNNING = MIDDLE[3:] + [s + name for s in "RL" for name in ONE_SIDE_RUNNING.split()]


@pytest.mark.parametrize("names", [OPENSIM_GAIT, OPENSIM_RUNNING], ids=["gait", "running"])
def test_every_marker_of_the_opensim_sets_has_a_place_on_its_own_side(names):
    sites = {name: marker_site(name) for name in names}
    assert [name for name, site in sites.items() if site is None] == []
    local, _ = marker_places(BODY, sites)
    origin = BODY.zero_origins[0]
    for (name, site), place_ in zip(sites.items(), local, strict=True):
        y = (origin[BODY.segment(site.segment)] + place_)[1]
        assert site.side == ("" if name in MIDDLE else name[0])
        assert name in MIDDLE or y * (1 if name[0] == "L" else -1) > 0.02


def test_medial_markers_of_wrists_are_on_the_ulna_and_lateral_ones_on_the_radius():
    assert marker_site("R.Wrist.Med") == marker_site("RFAulna")
    assert marker_site("R.Wrist.Lat") == marker_site("RFAradius")


def test_markers_without_a_known_place_are_listed_in_a_note(tmp_path):
    made = marked(walk(8), [*FULL, "L.Wrist.Med"])
    names = [name.replace("L.Wrist.Med", "L.Pen") for name in made.names]
    (tmp_path / "a.trc").write_text(trc_text(names, made))
    _, notes = load_motion(BODY, tmp_path / "a.trc")
    assert "a.trc: markers without a known place are not used: L.Pen" in notes


@pytest.mark.parametrize(
    ("file", "keep", "most"),
    [
        ("trc/bmc_walk1.trc", ALL_FRAMES, 7.0),
        ("c3d/bmc_Gait.c3d", FrameRange(1.33, 4.2), 6.0),
        ("c3d/dart_squat.c3d", FrameRange(every=6), 13.0),
    ],
)
def test_recorded_people_are_explained_to_millimetres(file, keep, most):
    """Root mean square residual [mm]; knees bend their own way, one foot at least near the
    floor."""
    path = real_input(SHARED / "motion" / file)
    markers = bridged(
        (read_c3d if file.endswith("c3d") else read_trc)(path, keep=keep), longest=0.2
    )
    fit = poses_from_markers(BODY, markers)
    assert 1000 * np.sqrt(np.nanmean(fit.residual**2)) < most
    shown = fit.residual[np.isfinite(fit.residual).any(axis=1)]
    assert 1000 * np.sqrt(np.nanmean(shown**2, axis=1)).max() < 2.5 * most
    assert stops(BODY, fit.poses).margin.min() > -1e-9
    knees = np.degrees(angles_of(BODY, fit.poses)[:, [BODY.joint("LK"), BODY.joint("RK")], 0])
    assert knees.min() > -8 and 50 < knees.max() < 120
    low = (place(BODY, fit.poses).centres[..., 2] - BODY.radius[0]).min(axis=1)
    assert np.ptp(low) < 0.09


TRC = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t2\t2\tmm\n"
    "Frame#\tTime\tR.Heel\t\t\tTop.Head\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
    "1\t0.00\t1\t2\t3\t10\t1700\t30\n2\t0.01\t1\t2\t3\t\t\t\n"
)


def test_a_marker_written_as_zeros_is_missing_there_and_named_with_its_frames(tmp_path):
    made = marked(walk(40), FULL)
    position = np.array(made.position)
    position[5:12, FULL.index("LKNE")] = 0.0
    position[:, FULL.index("RWRA")] = 0.0
    (tmp_path / "a.trc").write_text(trc_text(FULL, made, position))
    found = read_trc(tmp_path / "a.trc")
    gap = np.isnan(found.position).all(axis=-1)
    assert np.flatnonzero(gap[:, FULL.index("LKNE")]).tolist() == list(range(5, 12))
    assert gap.sum() == 7 + 40
    told = "markers written as 0, 0, 0 are missing there: LKNE (7 of 40 frames), RWRA (40 of 40 frames)"
    assert told in found.notes
    fit = poses_from_markers(BODY, found)
    assert np.nanmax(fit.residual) < 0.004 and fit.unused == ("RWRA",)


def test_a_marker_held_at_one_place_in_the_whole_file_is_missing_but_a_posture_is_not(tmp_path):
    made = marked(walk(40), FULL)
    position = np.array(made.position)
    position[:, FULL.index("LKNE")] = position[0, FULL.index("LKNE")]
    position[10:20, FULL.index("LKNE")] = np.nan
    (tmp_path / "a.trc").write_text(trc_text(FULL, made, position))
    found = read_trc(tmp_path / "a.trc")
    assert np.isnan(found.position[:, FULL.index("LKNE")]).all()
    assert np.isnan(found.position).all(axis=-1).sum() == 40
    assert "markers that never move are missing: LKNE (30 of 40 frames)" in found.notes
    position[:] = position[0]
    (tmp_path / "b.trc").write_text(trc_text(FULL, made, position))
    assert np.isfinite(read_trc(tmp_path / "b.trc").position).all()


def test_zeros_that_a_c3d_file_calls_seen_are_missing_too(tmp_path):
    points = np.ones((2, 2, 3)) * 500
    points[1, 1] = 0.0
    points[0, 1] = np.nan
    (tmp_path / "a.c3d").write_bytes(c3d_file(points))
    found = read_c3d(tmp_path / "a.c3d", up="z")
    assert np.isnan(found.position[:, 1]).all() and np.isfinite(found.position[:, 0]).all()
    told = "markers written as 0, 0, 0 are missing there: RASI (1 of 2 frames)"
    assert told in found.notes


@pytest.mark.parametrize("text", [TRC, TRC.replace("\t", ",")])
def test_a_trc_file_is_read_in_metres_with_z_up_and_gaps(tmp_path, text):
    (tmp_path / "a.trc").write_text(text)
    markers = read_trc(tmp_path / "a.trc")
    assert markers.names == ("R.Heel", "Top.Head")
    assert markers.position[0] == pytest.approx(
        np.array([[0.001, -0.003, 0.002], [0.01, -0.03, 1.7]])
    )
    assert np.isnan(markers.position[1, 1]).all()
    assert markers.notes == ("up is y of the file, as the markers lie",)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("PathFileType", "Path", "line 1: a TRC file begins with PathFileType"),
        ("\t2\t2\tmm", "\t3\t2\tmm", "line 3: says 3 frames, 2 are there"),
        ("\t2\t2\tmm", "\t2\t3\tmm", "line 3: says 3 markers, line 4 names 2"),
        ("\tmm", "\tfurlong", "line 3: Units is 'furlong', no unit of length"),
        ("0.01\t1\t2", "0.01\t1\tx", "line 8, column 4 (R.Heel Y): 'x' is not a finite number"),
        ("0.01\t1", "-0.01\t1", "frames are out of order"),
        ("Top.Head", "knob", "the upward axis cannot be told from the markers' names"),
    ],
)
def test_what_is_wrong_in_a_trc_file_is_told(tmp_path, old, new, told):
    (tmp_path / "a.trc").write_text(TRC.replace(old, new))
    with pytest.raises(InputError) as caught:
        read_trc(tmp_path / "a.trc")
    assert told in str(caught.value)


def test_a_wrong_number_of_frames_is_accepted_by_the_switch_that_the_refusal_names(tmp_path):
    (tmp_path / "a.trc").write_text(TRC.replace("\t2\t2\tmm", "\t3\t2\tmm"))
    with pytest.raises(InputError, match=r"says 3 frames, 2 are there; state frames: as_read"):
        read_trc(tmp_path / "a.trc")
    found = read_trc(tmp_path / "a.trc", keep=FrameRange(as_read=True))
    assert len(found.time) == 2
    assert found.notes[0] == "its header says 3 frames, 2 are there and are read"
    (tmp_path / "b.trc").write_text(TRC)
    assert "header" not in " ".join(
        read_trc(tmp_path / "b.trc", keep=FrameRange(as_read=True)).notes
    )


def test_a_c3d_file_with_fewer_frames_than_it_announces_is_read_with_the_switch(tmp_path):
    data = bytearray(c3d_file())
    data[8:10] = (9).to_bytes(2, "little")  # the number of the last frame
    (tmp_path / "a.c3d").write_bytes(bytes(data))
    with pytest.raises(InputError, match="announces 9 frames and holds 2; state frames: as_read"):
        read_c3d(tmp_path / "a.c3d", up="z")
    found = read_c3d(tmp_path / "a.c3d", up="z", keep=FrameRange(as_read=True))
    assert len(found.time) == 2 and np.isfinite(found.position[0]).all()
    assert found.notes[0] == "its header says 9 frames, 2 are there and are read"


def test_what_is_no_c3d_file_is_refused(tmp_path):
    (tmp_path / "a.c3d").write_bytes(b"solid cube")
    with pytest.raises(InputError, match="is not a C3D file"):
        read_c3d(tmp_path / "a.c3d")
    with pytest.raises(InputError, match="no such file"):
        read_c3d(tmp_path / "b.c3d")


@pytest.mark.parametrize("real", [True, False])
@pytest.mark.parametrize("processor", [84, 85, 86], ids=["Intel", "DEC", "MIPS"])
def test_c3d_files_of_all_processors_hold_the_same_points(tmp_path, processor, real):
    (tmp_path / "a.c3d").write_bytes(c3d_file(processor=processor, real=real))
    found = read_c3d(tmp_path / "a.c3d", up="z")
    assert found.names == ("LHEE", "RASI") and found.time.tolist() == [0.0, 0.01]
    assert found.position[0, 1] == pytest.approx([0.003, 0.9, 0.005])
    assert np.isnan(found.position[1, 1]).all() and np.isfinite(found.position[1, 0]).all()


def test_repeated_names_of_markers_are_numbered_as_those_of_parts(tmp_path):
    points = np.ones((1, 4, 3))
    (tmp_path / "a.c3d").write_bytes(c3d_file(points, labels=("A", "A", "A_2", "A\x1b")))
    found = read_c3d(tmp_path / "a.c3d", up="z")
    assert (
        found.names
        == tuple(unique_names(["A", "A", "A_2", "A\x1b"], ""))
        == ("A", "A_3", "A_2", "A\\u001b")
    )
    assert any("same name are numbered: A" in note for note in found.notes)


@pytest.mark.parametrize(
    ("at", "value", "told"),
    [
        (2, 65535, "cut short: it announces 2 frames and holds 0"),
        (8, 60000, "announces 60000 frames"),
        (4, 65535, "cut short"),
        (16, 60000, "cut short"),
        (515, 7, "kind of processor"),
        (16, 0, "header is senseless"),
    ],
)
def test_a_c3d_file_that_announces_more_than_it_holds_is_refused_before_memory_is_taken(
    tmp_path, at, value, told
):
    data = bytearray(c3d_file())
    data[at : at + (1 if at > 512 else 2)] = value.to_bytes(1 if at > 512 else 2, "little")
    (tmp_path / "a.c3d").write_bytes(bytes(data))
    with pytest.raises(InputError, match=told):
        read_c3d(tmp_path / "a.c3d", up="z")


def test_a_parameter_of_a_c3d_file_larger_than_its_section_is_refused(tmp_path):
    data = bytearray(c3d_file())
    at = data.index(b"LABELS") + len("LABELS") + 3  # its dimensions follow
    data[at : at + 2] = b"\x02\xff"
    (tmp_path / "a.c3d").write_bytes(bytes(data))
    with pytest.raises(InputError, match="'LABELS'"):
        read_c3d(tmp_path / "a.c3d", up="z")


def test_frames_that_a_c3d_file_holds_and_does_not_announce_are_told(tmp_path):
    (tmp_path / "a.c3d").write_bytes(c3d_file() + bytes(32 * 20 + 512))
    assert "holds 19 frames more than it announces" in " ".join(
        read_c3d(tmp_path / "a.c3d", up="z").notes
    )


def test_a_marker_without_one_of_its_coordinates_is_a_gap(tmp_path):
    (tmp_path / "a.trc").write_text(TRC)
    whole = read_trc(tmp_path / "a.trc", up="y")
    (tmp_path / "b.trc").write_text(TRC.replace("\t1\t2\t3\t10", "\t1\t\t3\t10"))
    part = read_trc(tmp_path / "b.trc", up="y")
    assert np.isfinite(whole.position[0]).all()
    assert np.isnan(part.position[0, 0]).all() and np.isfinite(part.position[0, 1]).all()
