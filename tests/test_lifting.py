"""The lifting equation: worked vectors, both forms, several tasks, and who it is not for.

Vectors are of a fact sheet on strain (sections niosh and niosh_cli), in cm and kg. The first example
of the manual is 44 lb at 23, 15 and 49 in with fair coupling.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from workbench.errors import InputError

POUND = 0.45359237
INCH = 0.0254


def lifts(h, v, d, a=0.0, f=0.2, **others):
    """Tasks in cm, degrees and lifts a minute."""
    return wb.Lifts(
        **{"load": 10.0, "hours": 1.0, "stance": "standing", "hands": 2, **others},
        horizontal=np.asarray(h) / 100.0,
        vertical=np.asarray(v) / 100.0,
        travel=np.asarray(d) / 100.0,
        asymmetry=np.radians(a),
        per_minute=f,
    )


@pytest.mark.parametrize(
    ("task", "hours", "coupling", "limit"),
    [
        ((25, 75, 25, 0, 0.2), 1, "good", 23.0),
        ((58.42, 38.1, 124.46, 0, 0.2), 1, "fair", 7.119),
        ((58.42, 162.56, 124.46, 0, 0.2), 1, "fair", 6.213),
        ((40, 30, 80, 45, 3), 1.5, "fair", 7.000),
        ((30, 60, 40, 0, 9), 8, "poor", 0.0),
        ((30, 90, 40, 0, 9), 8, "poor", 2.304),
        ((64, 75, 25, 0, 0.2), 1, "good", 0.0),
        ((63, 75, 25, 0, 0.2), 1, "good", 23 * 25 / 63),
        ((25, 176, 25, 0, 0.2), 1, "good", 0.0),
        ((25, 75, 176, 0, 0.2), 1, "good", 0.0),
        ((25, 75, 25, 136, 0.2), 1, "good", 0.0),
        ((25, 75, 25, 0, 15.1), 1, "good", 0.0),
        ((25, 74.9, 25, 0, 12), 1, "good", 23 * 0.37 * (1 - 0.0003)),
        ((25, 74.9, 25, 0, 12.1), 1, "good", 0.0),
        ((25, 75, 25, 0, 2.5), 2, "good", 23 * (0.84 + 0.79) / 2),
    ],
)
def test_the_metric_form_gives_the_limits_of_worked_vectors(task, hours, coupling, limit):
    found = wb.lifting(lifts(*task, hours=hours, coupling=coupling))
    assert found.limit == pytest.approx([limit], abs=6e-4)
    assert found.index == pytest.approx([10 / limit if limit else np.inf], rel=1e-3)


def test_the_inch_form_is_another_equation_than_the_metric_one():
    # 51 * 10/23 * (1 - 0.0075 * 15) * (0.82 + 1.8/49) * 0.95 = 16.0 lb; the metric form has 15.7 lb
    start = lifts(2.54 * 23, 2.54 * 15, 2.54 * 49, load=44 * POUND, coupling="fair")
    metric, inch = (wb.lifting(start, rules=f"strain_niosh_{form}") for form in ("metric", "inch"))
    exact = 51 * (10 / 23) * (1 - 0.0075 * 15) * (0.82 + 1.8 / 49) * 0.95
    assert inch.limit / POUND == pytest.approx([exact]) and exact == pytest.approx(16.0, abs=0.05)
    assert metric.limit / POUND == pytest.approx([15.7], abs=0.05)
    assert "metric form" in metric.version and "inch form" in inch.version
    assert "from memory" in inch.status and "load_constant" in inch.status


def three_tasks(order):
    rows = np.array(
        [(12, 35, 40, 60, 0, 1), (15, 45, 80, 30, 30, 2), (8, 30, 120, 40, 0, 4)], dtype=float
    )[order]
    coupling = tuple(np.array(["fair", "poor", "good"])[order].tolist())
    return lifts(*rows.T[1:], load=rows[:, 0], hours=8, coupling=coupling)


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1], [1, 2, 0]])
def test_several_tasks_of_a_job_have_a_composite_index_in_whatever_order(order):
    found = wb.lifting(three_tasks(order))
    np.testing.assert_allclose(found.index, np.array([1.2798, 2.3233, 1.1499])[order], atol=6e-5)
    assert found.composite == pytest.approx(2.3233 + 0.2685 + 1.4113, abs=2e-4)


def test_jobs_in_a_batch_have_the_figures_of_each_alone():
    tasks = three_tasks([0, 1, 2])
    heavier = np.stack([tasks.load, 2 * np.asarray(tasks.load)])
    found = wb.lifting(replace(tasks, load=heavier))
    assert found.index.shape == (2, 3) and found.composite.shape == (2,)
    assert found.composite[1] == pytest.approx(2 * found.composite[0])
    assert found.composite[0] == wb.lifting(tasks).composite


@given(
    h=st.floats(20, 63), v=st.floats(0, 175), d=st.floats(0, 175), a=st.floats(0, 135),
    f=st.floats(0, 15), hours=st.sampled_from([0.5, 1.0, 2.0, 8.0]),
)  # fmt: skip
def test_no_factor_is_beyond_0_to_1_and_one_task_is_its_own_composite(h, v, d, a, f, hours):
    found = wb.lifting(lifts(h, v, d, a, f, hours=hours))
    assert all(0.0 <= factor.item() <= 1.0 for factor in found.factors.values())
    assert found.composite == found.index[0]
    farther = wb.lifting(lifts(h + 0.1, v, d, a, f, hours=hours))
    assert farther.limit <= found.limit


def test_a_task_that_is_too_much_makes_the_whole_job_too_much():
    tasks = lifts([25, 64], [75, 75], [25, 25], load=[10.0, 10.0])
    assert wb.lifting(tasks).composite == np.inf
    hurried = lifts([25, 25], [75, 75], [25, 25], f=[10.0, 9.0])
    assert np.isfinite(wb.lifting(hurried).index).all() and wb.lifting(hurried).composite == np.inf
    assert wb.lifting(replace(hurried, load=[10.0, 0.0])).composite < np.inf


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"stance": "sitting"},
            "not for a person who is sitting .* stand and lift with both hands",
        ),
        ({"hands": 1}, "uses 1 hands; it holds for people who stand"),
        ({"hours": 9}, "up to 8 hours, got 9"),
        ({"hours": 0}, "up to 8 hours, got 0"),
        ({"load": -1}, "load: expected numbers of 0 or more, got -1"),
        (
            {"coupling": "loose"},
            "coupling: expected one of good, fair, poor for all or each task, got 'loose'",
        ),
        ({"load": [1.0, 2.0], "coupling": ("good",) * 3}, "arrays of one shape"),
    ],
)
def test_who_or_what_the_equation_is_not_for_is_refused_with_the_reason(given, message):
    with pytest.raises(InputError, match=message):
        lifts(25, 75, 25, **given)


def test_hands_are_measured_from_the_ankles_and_the_floor():
    body = wb.load_body("bubbleman")
    both = {joint: {"flexion": 90} for joint in ("LS", "RS")}
    turned = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    rows = [wb.pose(body, both), wb.pose(body, both, position=(3, 4, 0), attitude=turned)]
    rows.append(wb.pose(body, both | {"W": {"turn_left": 40}}))
    found = wb.grip_place(wb.place(body, wb.join_poses(rows)), floor=-0.1)
    level = wb.place(body, rows[0]).world_from_segment[0, body.segment("LHN"), 2, 3]
    assert found.vertical[:2] == pytest.approx(level + 0.1)
    assert found.horizontal[0] == pytest.approx(found.horizontal[1])
    assert np.degrees(found.asymmetry[:2]) == pytest.approx([0, 0], abs=1e-6)
    assert 35 < np.degrees(found.asymmetry[2]) < 45
