"""A symmetric body stays symmetric, whatever is done to it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.mirror_images import asymmetry
from workbench.body.wear import wear
from workbench.files.body.encumbrances import load_encumbrances

EXACT = 1e-9
"""What a symmetric body may be off its mirror image by [m] or [kg]."""


@cache
def bubbleman():
    return wb.load_body("bubbleman")


def test_bubbleman_is_his_own_mirror_image():
    assert asymmetry(bubbleman()) < EXACT


def test_a_small_woman_does_not_limp():
    body = wb.scale(bubbleman(), {"stature": 1.525, "sitting_height": 0.803})
    hips = [body.joint_in_parent[0, body.joint(name)] for name in ("LH", "RH")]
    shoulders = [body.joint_in_parent[0, body.joint(name)] for name in ("LS", "RS")]
    assert abs(hips[0][2] - hips[1][2]) < EXACT
    assert abs(shoulders[0][0] - shoulders[1][0]) < EXACT
    assert asymmetry(body) < EXACT


@settings(max_examples=15, deadline=None)
@given(
    st.floats(1.55, 1.85),
    st.floats(0.51, 0.535),
    st.sampled_from(
        [{}, {"hip_breadth_sitting": 0.38}, {"head_breadth": 0.16}, {"chest_depth": 0.26}]
    ),
    st.sampled_from([[], ["shoes"], ["helmet", "gloves"], ["vest"]]),
)
def test_scaled_dressed_and_seated_a_symmetric_body_is_symmetric(stature, share, more, clothes):
    sized = wb.scale(bubbleman(), {"stature": stature, "sitting_height": share * stature, **more})
    dressed = wear(sized, load_encumbrances(clothes, sized)) if clothes else sized
    for body in (sized, dressed, wb.seated(dressed)):
        assert asymmetry(body) < EXACT


@pytest.mark.parametrize("axis", [0, 2])
def test_a_taper_of_the_middle_runs_along_the_segment_not_across_it(axis):
    wide = wb.scale(bubbleman(), {"stature": 1.7, "hip_breadth_sitting": 0.40})
    ahead = [wide.joint_in_parent[0, wide.joint(name), axis] for name in ("LH", "RH")]
    assert np.ptp(ahead) < EXACT


def test_a_pose_alike_on_both_sides_places_a_symmetric_body_symmetrically():
    angles = {f"{s}{j}": {"flexion": 70.0} for s in "LR" for j in "HKE"}
    body = bubbleman()
    placed = wb.place(body, wb.pose(body, angles))
    rows = np.column_stack([placed.centres[0], body.radius[0]])
    gap = np.abs(rows[:, None] - (rows * [1, -1, 1, 1])[None]).max(axis=2).min(axis=1)
    assert gap.max() < EXACT
