"""A body scaled to the subject of a motion file: known lengths come back, recorded people are
fitted better."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import SHARED, real_input
from tests.test_crash import drop
from tests.test_markers import BODY, FULL, marked, walk
from workbench import InputError, load_study, place
from workbench.body.scaling.morph import lengthened
from workbench.cli import main
from workbench.files.motions.bvh import bvh_text
from workbench.files.motions.number_rows import FrameRange
from workbench.model.joint_angles import compose
from workbench.model.motion import Markers, SegmentTrack
from workbench.motion.recorded.marker_names import marker_site
from workbench.motion.recorded.skeleton import body_lengths
from workbench.motion.recorded.subject_scaling import (
    factors_from_markers,
    factors_from_track,
    marker_places,
)
from workbench.study.motion_cases import motion_cases
from workbench.study.motions import MotionOptions, load_motion, subject_body

__all__ = ["drop"]

GROWN = {
    s: f
    for side in "LR"
    for s, f in ((f"{side}UL", 1.1), (f"{side}LL", 1.08), (f"{side}UA", 0.95), (f"{side}LA", 0.9))
} | {"CT": 1.05, "UT": 1.05}
TALL = lengthened(BODY, GROWN)


def test_a_lengthened_body_stands_on_the_floor_with_its_limbs_that_much_longer():
    before = body_lengths(BODY)
    after = body_lengths(TALL)
    assert {s: after[s] / before[s] for s in before} == pytest.approx(
        {s: GROWN[s] for s in before}, rel=2e-3
    )
    assert BODY.radius[0].tolist() == TALL.radius[0].tolist()
    soles = [
        (b.zero_origins[0, b.sphere_segment, 2] + b.centre[0, :, 2] - b.radius[0]).min()
        for b in (BODY, TALL)
    ]
    assert soles[0] == pytest.approx(soles[1])
    with pytest.raises(
        InputError, match=r"LUL of bubbleman would be 3.00 times as long; 0.4 to 2 are possible"
    ):
        lengthened(BODY, {"LUL": 3.0})


def test_a_skeleton_with_its_unit_tells_every_length(tmp_path):
    path = tmp_path / "tall.bvh"
    path.write_text("".join(bvh_text(TALL, walk(8), [place(TALL, walk(8))])))
    options = MotionOptions(names={s: s for s in BODY.segments[1:]}, metres=0.01)
    made, notes = subject_body(BODY, path, options=options)
    want = body_lengths(TALL)
    assert {s: body_lengths(made)[s] for s in want} == pytest.approx(want, rel=2e-3)
    assert made.zero_origins[0, BODY.segment("H"), 2] == pytest.approx(
        TALL.zero_origins[0, BODY.segment("H"), 2], abs=0.006
    )
    assert (
        "scaled to the subject: upper arms -5 %, lower arms -10 %, upper legs +10 %, lower legs +8 %"
        in notes[0]
    )
    assert "1755 mm tall before" in notes[0]
    with pytest.raises(InputError, match="needs the file's unit of length"):
        subject_body(BODY, path, options=MotionOptions(names=options.names))


def test_markers_tell_limbs():
    sites = {name: marker_site(name) for name in [*FULL, "LGTR", "RGTR"]}
    local, _ = marker_places(TALL, sites)
    world = place(TALL, walk()).world_from_segment[
        :, [BODY.segment(s.segment) for s in sites.values()]
    ]
    position = np.einsum("pmij,mj->pmi", world[..., :3], local) + world[..., 3]
    found = factors_from_markers(BODY, Markers(tuple(sites), position, walk().time, "made"), None)
    limbs = {s: f for s, f in GROWN.items() if s not in ("CT", "UT")}
    assert found == pytest.approx(limbs, rel=0.03)
    assert factors_from_markers(BODY, marked(walk(4), ["C7", "LASI"]), None) == {}


def test_segments_told_one_by_one_tell_the_joints_they_turn_about():
    rng = np.random.default_rng(2)
    motion = walk(40)
    angles = rng.normal(0, 0.4, (40, len(BODY.joints), 3))
    turned = type(motion)(
        compose(BODY, angles), motion.reference, motion.world_from_reference, motion.time
    )
    world = place(TALL, turned).world_from_segment
    found = factors_from_track(BODY, SegmentTrack(BODY.segments, world, motion.time, "made"))
    assert found == pytest.approx(GROWN, rel=3e-3)
    still = np.repeat(world[:1], 40, axis=0)
    assert factors_from_track(BODY, SegmentTrack(BODY.segments, still, motion.time, "made")) == {}


@pytest.mark.parametrize(
    ("file", "keep", "legs"),
    [
        ("trc/bmc_walk1.trc", FrameRange(every=4), 1.07),
        ("c3d/bmc_Gait.c3d", FrameRange(1.33, 4.2, every=4), 0.94),
        ("c3d/dart_squat.c3d", FrameRange(every=40), 0.90),
    ],
)
def test_recorded_people_are_fitted_better_by_a_body_of_their_lengths(file, keep, legs):
    """Root mean square residual of the markers before and after; how much longer the lower legs
    are."""
    path = real_input(SHARED / "motion" / file)
    options = MotionOptions(keep=keep)
    made, notes = subject_body(BODY, path, options=options)
    assert body_lengths(made)["LLL"] / body_lengths(BODY)["LLL"] == pytest.approx(legs, abs=0.01)
    assert "scaled to the subject: lower legs" in notes[0]
    before, after = (_carried(load_motion(body, path, options=options)[1]) for body in (BODY, made))
    assert after < before


def _carried(notes):
    told = next(note for note in notes if "markers are carried to" in note)
    return float(told.split("carried to ")[1].split(" mm")[0])


def test_a_recorded_skeleton_has_its_own_lengths():
    """CMU subject 1 in units of 56.44 mm (1 / 0.45 inch)."""
    path = real_input(SHARED / "motion" / "bvh" / "01_01.bvh")
    made, notes = subject_body(BODY, path, options=MotionOptions(metres=0.0254 / 0.45))
    assert "upper legs +1 %, lower legs +1 %" in notes[0]
    assert body_lengths(made)["LLL"] == pytest.approx(body_lengths(BODY)["LLL"], rel=0.02)


def test_a_crash_study_and_the_command_line_scale_to_the_subject(drop, capsys):
    bvh = drop.parent / "tall.bvh"
    motion = walk(8)
    bvh.write_text("".join(bvh_text(TALL, motion, [place(TALL, motion)])))
    names = "{" + ", ".join(f"{s}: {s}" for s in BODY.segments[1:]) + "}"
    source = f"{{file: tall.bvh, unit: 1 cm, scale: subject, map: {names}}}"
    drop.write_text(drop.read_text().replace("{file: drop.csv}", source))
    study = motion_cases(load_study(drop))[0]
    assert body_lengths(study.body)["LUL"] == pytest.approx(body_lengths(TALL)["LUL"], rel=1e-3)
    assert "scaled to the subject" in study.warnings[0]
    assert main(["motion", "show", str(drop.parent / "drop.csv"), "--scale", "subject"]) == 3
    assert "states no length of the subject's limbs" in capsys.readouterr().err
    again = "  - {name: again, people: {occupant: {motion: {file: tall.bvh, scale: subject}}}}\n"
    drop.write_text(drop.read_text().replace("signals:", again + "signals:"))
    with pytest.raises(InputError, match="'scale: subject' belongs to the first case"):
        motion_cases(load_study(drop))
