"""Marks: what they are made from, how they are laid out, and that both displays draw the same."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import ImageFont

import workbench as wb
from tests.test_draw import SVG, crowd, front, spheres_body
from workbench import InputError, UsageError
from workbench.contact.collide import nearest
from workbench.draw.disks import disks
from workbench.draw.lines.circles import circles
from workbench.draw.lines.outline import outline
from workbench.draw.marks.annotations import (
    axes_marks,
    clearance_marks,
    contact_marks,
    control_marks,
    segment_marks,
    stop_marks,
)
from workbench.draw.marks.layout import TEXT_SIZE, layout_marks, mark_shapes
from workbench.draw.scene import MARKS, Mark, Scene


@pytest.fixture(scope="module")
def arm(one_arm):
    """The one arm hanging, 50 mm from the wall at x = 0.45 (the elbow sphere of 40 mm reaches x =
    0.04)."""
    return wb.place(one_arm, wb.pose(one_arm, {}))


def length(mark):
    return float(np.linalg.norm(np.subtract(mark.to, mark.point)))


def test_a_dimension_line_is_as_long_as_the_clearance_it_states(arm, box_cab):
    marks = clearance_marks(arm, nearest(arm, box_cab), most=3, within=9.0)
    assert len(marks) == 3
    for mark in marks:
        assert f"{1000 * length(mark):.1f} mm" == mark.label and mark.kind == "clearance"


def test_dimension_lines_run_from_the_body_to_the_nearest_parts_in_order(arm, box_cab):
    first, second = clearance_marks(arm, nearest(arm, box_cab), most=2, within=9.0)
    assert length(first) <= length(second)
    # base sphere of 50 mm at the origin, corner of the post at (-0.1, 0.15): the gap lies in that
    # plane
    gap = [length(m) for m in clearance_marks(arm, nearest(arm, box_cab), most=9, within=9.0)]
    assert min(gap) == pytest.approx(min(nearest(arm, box_cab).distance.min(axis=(0, 1))), abs=1e-9)


def test_what_may_touch_or_is_farther_than_asked_has_no_dimension_line(arm, box_cab):
    near = nearest(arm, box_cab)
    assert not clearance_marks(arm, near, within=0.001)
    hidden = replace(box_cab, hidden=np.ones(3, dtype=bool))
    assert not clearance_marks(arm, replace(near, other=hidden), within=9.0)


def test_contacts_beyond_what_is_allowed_are_labelled_with_the_excess(one_arm, unit_box):
    placed = wb.place(
        one_arm, wb.pose(one_arm, {}, position=(1.03, 0.5, 0.5))
    )  # base: 20 mm into the box's side
    marks = contact_marks(wb.contacts(placed, unit_box))
    assert {m.kind for m in marks} == {"contact"}
    assert "20.0 mm" in {m.label for m in marks}


def test_a_breached_stop_is_a_diamond_at_its_joint_with_the_angle(arm):
    marks = stop_marks(arm, np.radians([[5.0, -4.2, 0.0]]))
    assert [(m.label, m.kind) for m in marks] == [("elbow +4.2°", "stop")]
    assert marks[0].point == pytest.approx((0, 0, -0.3))


def test_segments_controls_and_axes_have_their_names(arm):
    assert [m.label for m in segment_marks(arm)] == ["BASE", "UPPER", "LOWER", "HAND"]
    assert [m.to for m in axes_marks((1.0, 0.0, 0.0), length=0.5)] == [
        (1.5, 0, 0),
        (1.0, 0.5, 0),
        (1.0, 0, 0.5),
    ]
    trainer = wb.load_environment("trainer")
    kinds = {m.label: m.kind for m in control_marks(trainer, {"throttle": False})}
    assert (
        kinds["throttle"] == "missed"
        and kinds["flaps"] == "reach"
        and len(kinds) == len(trainer.controls)
    )


def test_segments_outside_the_logical_window_have_no_label(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}), window=["UPPER"])
    assert [m.label for m in segment_marks(placed)] == ["BASE", "UPPER"]


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_labels_of_all_kinds_overlap_no_other_label(seed, count):
    random = np.random.default_rng(seed)
    kinds = [str(k) for k in random.choice([*MARKS], count)]
    points = random.normal(0.0, 0.3, (count, 2, 3))
    marks = tuple(
        Mark(
            tuple(a),
            f"part {i}",
            kind,
            tuple(b) if kind in ("clearance", "missed") or kind[:4] == "axis" else None,
        )
        for i, (kind, (a, b)) in enumerate(zip(kinds, points.tolist(), strict=True))
    )
    for a, b in combinations(layout_marks(Scene((), None, marks), front(800)), 2):
        apart = np.abs(np.subtract(a.label, b.label)) - np.add(a.half, b.half)
        assert apart.max() >= 0.0


@pytest.mark.parametrize(
    "text", ["56.1 mm", "right elbow +4.2°", "WWWW mmmm", "fuel selector", "l.i;|"]
)
def test_a_label_is_inside_its_plate(text):
    mark = layout_marks(Scene((), None, (Mark((0, 0, 0), text),)), front(640))[0]
    assert ImageFont.load_default(TEXT_SIZE).getlength(text) <= 2 * mark.half[0]


def test_a_short_dimension_has_its_arrows_outside_and_a_long_one_inside():
    for reach, outside in ((0.01, True), (0.5, False)):
        mark = layout_marks(
            Scene((), None, (Mark((0, 0, 0), "", "clearance", (0, reach, 0)),)), front(640)
        )[0]
        corners = np.array([corner for shape in mark_shapes(mark) for corner in shape.corners])
        assert (corners[:, 0].max() > mark.to[0] + 5.0) == outside


def every_mark():
    return tuple(
        Mark((0.0, 0.1 * i - 0.5, 0.2), kind, kind, (0.0, 0.1 * i - 0.45, 0.4) if i % 2 else None)
        for i, kind in enumerate(MARKS)
    )


@pytest.mark.parametrize("display", [circles, outline])
def test_both_vector_displays_draw_every_kind_and_label(display):
    root = ElementTree.fromstring(display(Scene((crowd(),), None, every_mark()), front(640)))
    group = next(item for item in root if item.get("class") == "marks")
    drawn = {item.get("class") for item in group.iter(SVG + "path")}
    assert set(MARKS) - {"segment"} <= drawn
    assert set(MARKS) <= {item.text for item in group.iter(SVG + "text")}


def test_the_raster_display_draws_every_kind_in_its_colour():
    picture = np.asarray(
        disks(Scene((spheres_body([0, 0, 0], 0.1),), None, every_mark()), front(640))
    ).reshape(-1, 3)
    colours = {tuple(colour) for colour in picture.tolist()}
    assert set(MARKS.values()) <= colours


@pytest.mark.parametrize("display", [circles, outline])
def test_names_are_text_whatever_they_hold(display):
    marks = (Mark((0, 0, 0), "<script>alert('&')</script>"), Mark((0, 0.1, 0), "bell \x07\x00"))
    root = ElementTree.fromstring(display(Scene((crowd(),), None, marks), front()))
    texts = [item.text for item in root.iter(SVG + "text")]
    assert "<script>alert('&')</script>" in texts and "bell ��" in texts
    assert not list(root.iter(SVG + "script"))


def test_what_no_mark_can_be_is_refused_in_words():
    with pytest.raises(InputError, match="finite point"):
        Mark((0.0, 0.0, 0.0), "x", "clearance", (np.nan, 0.0, 0.0))
    with pytest.raises(UsageError, match="no kind 'contct'; did you mean 'contact'"):
        Mark((0.0, 0.0, 0.0), "x", "contct")
    with pytest.raises(UsageError, match="above 0 m"):
        axes_marks(length=0.0)
