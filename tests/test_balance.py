"""Balance: the centre of mass over the soles."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from workbench.errors import InputError


def stands(body, angles, **place):
    return wb.balance(wb.place(body, wb.pose(body, angles, **place)))


def test_the_man_of_the_paper_stands_28_9_mm_before_the_edge_of_his_heels(bubbleman):
    # the rearmost spheres of the soles have their centres at x = -32 mm, the centre of mass -3.1 mm
    found = stands(bubbleman, {})
    assert found.support[0][:, 0].min() == pytest.approx(-0.032)
    assert found.centre[0, 0] == pytest.approx(-0.00308, abs=1e-5)
    assert found.margin == pytest.approx([0.0289], abs=1e-4)


def test_arms_raised_forward_carry_the_centre_of_mass_by_their_share(bubbleman):
    arms = [bubbleman.segment(name) for name in ("LUA", "LLA", "LHN", "RUA", "RLA", "RHN")]
    raised = wb.pose(bubbleman, {"LS": {"flexion": 90}, "RS": {"flexion": 90}})
    down = wb.place(bubbleman, wb.pose(bubbleman, {}))
    up = wb.place(bubbleman, raised)
    way = (up.world_from_segment - down.world_from_segment)[0, arms, 0, 3]
    share = bubbleman.mass[0, arms] / bubbleman.mass[0].sum()
    moved = wb.balance(up).centre - wb.balance(down).centre
    assert moved[0, 0] == pytest.approx(float(share @ way)) and 0.029 < moved[0, 0] < 0.031


def test_balance_goes_along_with_the_body_and_is_lost_by_leaning(bubbleman):
    turned = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    there = stands(bubbleman, {}, position=(3, 4, 5), attitude=turned)
    assert there.margin == pytest.approx(stands(bubbleman, {}).margin)
    # bent at the hips over stiff legs with the arms ahead, nothing drawn back: beyond the toes
    bent = {joint: {"flexion": 80} for joint in ("LH", "RH")}
    bent |= {joint: {"flexion": 150} for joint in ("LS", "RS")}
    found = stands(bubbleman, bent, reference="RF")
    assert found.margin[0] < -0.02 and found.centre[0, 0] > found.support[0][:, 0].max()


def test_on_one_leg_the_other_foot_bears_nothing(bubbleman):
    found = stands(bubbleman, {"LK": {"flexion": 60}})
    right = found.support[0]
    assert right[:, 1].max() < 0.0
    share = np.linspace(0, 1, 2001)[:, None, None]
    edges = right + share * (np.roll(right, -1, axis=0) - right)
    nearest = np.linalg.norm(edges - found.centre[0, :2], axis=2).min()
    assert found.margin[0] == pytest.approx(-nearest, abs=1e-5) and nearest > 0.05


def test_mirrored_postures_have_the_same_margin(bubbleman):
    one = stands(bubbleman, {"W": {"bend_left": 15}, "LS": {"abduction": 60}})
    other = stands(bubbleman, {"W": {"bend_right": 15}, "RS": {"abduction": 60}})
    np.testing.assert_allclose(one.margin, other.margin, atol=1e-9)
    np.testing.assert_allclose(one.centre, other.centre * [1, -1, 1], atol=1e-9)


def test_who_has_no_feet_has_no_balance(one_arm):
    with pytest.raises(InputError, match="no feet"):
        wb.balance(wb.place(one_arm, wb.pose(one_arm, {})))
