"""The dog: a body with a skeleton that is nobody's, made from outlines by its script."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from workbench.files.postures import load_postures, posture_path, posture_pose

FILE = ROOT / "bodies" / "dog.yaml"


@pytest.fixture(scope="module")
def dog():
    return wb.load_body(FILE)


@pytest.fixture(scope="module")
def postures(dog):
    return load_postures(posture_path(FILE), dog)[0]


def lowest(dog, placed, segment):
    """Height [mm] of the lowest place of a segment."""
    rows = dog.sphere_segment == dog.segment(segment)
    return 1e3 * float((placed.centres[0, rows, 2] - dog.radius[0, rows]).min())


def test_the_dog_has_segments_of_its_own_and_no_basis(dog):
    assert (
        len(dog.segments) == 21 and {"LSB", "LCR", "TT"} <= set(dog.segments) and dog.basis is None
    )
    assert 300 <= len(dog.sphere_names) <= 1000


def test_it_is_550_mm_at_the_withers_and_weighs_24_kg(dog, postures):
    placed = wb.place(dog, posture_pose(dog, postures, "standing"))
    ground = min(lowest(dog, placed, s) for s in dog.segments)
    at = dog.sphere_names.index("withers")
    assert 1e3 * (placed.centres[0, at, 2] + dog.radius[0, at]) - ground == pytest.approx(
        550, abs=12
    )
    assert dog.mass[0].sum() == pytest.approx(24, abs=0.05)


def test_left_and_right_limbs_mirror_each_other(dog):
    for name in (s for s in dog.segments if s[0] == "L" and s != "LO"):
        left, right = (dog.spheres(dog.segment(s)) for s in (name, "R" + name[1:]))
        assert np.allclose(dog.centre[0, left] * [1, -1, 1], dog.centre[0, right], atol=2e-5), name
        assert np.array_equal(dog.radius[0, left], dog.radius[0, right])


def test_its_subparts_have_names(dog):
    parts = {
        "nose",
        "chin",
        "crown",
        "left eye",
        "right ear tip",
        "withers",
        "tail tip",
        "left elbow point",
        "right hock point",
        "left forepaw toes",
        "right hindpaw pad",
        "left knee cap",
    }
    assert parts <= set(dog.sphere_names)
    assert dog.centre[0, dog.sphere_names.index("nose"), 0] > 0.1


def test_every_segment_tells_its_fit_error(dog):
    assert (dog.fit_error[0, :, 0] <= 3.2e-3).all() and (dog.fit_error[0, :, 1] <= 3.2e-3).all()


@pytest.mark.parametrize("posture", ["standing", "sitting", "lying", "galloping"])
def test_its_postures_are_legal_and_it_is_not_in_itself(dog, postures, posture):
    poses = posture_pose(dog, postures, posture)
    assert wb.stops(dog, poses).margin.min() >= -1e-9
    rows = wb.self_contacts(wb.place(dog, poses))
    assert (rows.distance >= -rows.allowed - 1e-9).all()


@pytest.mark.parametrize(
    "posture, on_the_ground",
    [
        ("standing", ["LFP", "RFP", "LHF", "RHF"]),
        ("sitting", ["LFP", "RFP", "LHF", "RHF", "TA", "TT"]),
        ("lying", ["LFP", "LFA", "LHF", "TH", "TT"]),
    ],
)
def test_it_stands_sits_and_lies_on_level_ground(dog, postures, posture, on_the_ground):
    placed = wb.place(dog, posture_pose(dog, postures, posture))
    heights = [lowest(dog, placed, s) for s in on_the_ground]
    every = [lowest(dog, placed, s) for s in dog.segments]
    assert np.ptp(heights) < 24 and min(every) > min(heights) - 4


@pytest.mark.nightly
def test_the_dog_is_made_by_its_script_to_the_byte(tmp_path):
    subprocess.run(
        [sys.executable, ROOT / "tools" / "bodies" / "make_dog.py", tmp_path],
        check=True,
        capture_output=True,
    )
    assert (tmp_path / "dog.yaml").read_bytes() == FILE.read_bytes()
