"""Pictures of what two eyes see: charts of directions, plans of the ground, and views from the eyes,
on rooms whose figures can be found by hand."""

from __future__ import annotations

import io
import itertools
import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench import InputError, UsageError
from workbench.cli import main
from workbench.draw.camera import project
from workbench.draw.chart import FINER, chart_svg
from workbench.draw.directions import PROJECTIONS, Outlook, direction_chart, hidden_zones
from workbench.draw.disks import disks
from workbench.draw.display_options import parse_display_options
from workbench.draw.eye_view import eyes_camera, outlook
from workbench.draw.ground_plan import blind_distances, ground_plan, mirror_plan
from workbench.draw.render import choose_camera, picture, render
from workbench.draw.scene import Mark, Scene
from workbench.draw.scene_builder import build_source
from workbench.draw.sheet import Sheet
from workbench.draw.two_eyes import both_eyes
from workbench.draw.zones import CLEAR
from workbench.model.criterion import Finding
from workbench.model.environment import Mirror
from workbench.report.sight import Beheld, Glimpse, sight_sections
from workbench.sight.eyes import eyes_of, gaze, given_eyes
from workbench.sight.regions import WHOLE, Region, cone, direction_of
from workbench.sight.scenery import scenery_of

WALL = {
    "above": ((0.7, -4, 0.25), (0.7005, 4, 4)),
    "below": ((0.7, -4, -4), (0.7005, 4, -0.25)),
    "left_jamb": ((0.7, 0.5, -0.25), (0.7005, 4, 0.25)),
    "right_jamb": ((0.7, -4, -0.25), (0.7005, -0.5, 0.25)),
}
"""A wall 700 mm ahead with a window of 1000 x 500 mm, as boxes from corner to corner [m]."""


def room(boxes, **points):
    """An environment of boxes with points where eyes are."""
    made = environment_of(*(box_part(n, low, high) for n, (low, high) in boxes.items()))
    return replace(made, points=points)


def seen(environment, at=(0.0, 0.0, 0.0), spacing=0.065, rule=None):
    """The outlook from eyes at a point, straight ahead."""
    scenery = scenery_of(environment)
    names = tuple(environment.parts)
    return Outlook("eyes", scenery, names, given_eyes(at, spacing=spacing), np.eye(3), rule)


def pixel(chart, sheet, point):
    """The colour at a point (2,) of a chart's map."""
    column, row = np.floor(FINER * sheet.pixels(np.array(point))).astype(int)
    return tuple(chart.colours[row, column].tolist())


def hammer(azimuth, elevation):
    """The textbook formula, azimuth to the right [rad]."""
    k = math.sqrt(1 + math.cos(elevation) * math.cos(azimuth / 2))
    x = 2 * math.sqrt(2) * math.cos(elevation) * math.sin(azimuth / 2) / k
    return x, math.sqrt(2) * math.sin(elevation) / k


ANGLES = st.tuples(st.floats(-179.0, 179.0), st.floats(-89.0, 89.0)).map(np.radians)


@given(ANGLES)
def test_the_equal_area_chart_is_hammers_with_the_right_on_the_right(angles):
    point = PROJECTIONS["equal_area"].flat(angles)
    assert point == pytest.approx(hammer(-angles[0], angles[1]), abs=1e-9)
    assert PROJECTIONS["equal_area"].angles(point) == pytest.approx(angles, abs=1e-6)


@given(ANGLES)
def test_the_polar_chart_has_what_is_125_degrees_from_ahead(angles):
    way = direction_of(*angles)
    off = math.atan2(math.hypot(way[1], way[2]), way[0])  # acos loses digits near ahead
    point = PROJECTIONS["polar"].flat(angles)
    if off > math.radians(125.001):
        assert np.isnan(point).all()
    elif off < math.radians(124.999):
        assert np.linalg.norm(point) == pytest.approx(2 * math.sin(off / 2), abs=1e-9)
        assert PROJECTIONS["polar"].angles(point) == pytest.approx(angles, abs=1e-6)


@pytest.mark.parametrize("style", PROJECTIONS)
def test_a_window_is_where_its_corners_are_and_as_large_as_its_solid_angle(style):
    chart = direction_chart(seen(room(WALL), spacing=0.0), style, width=500, height=400)
    projection = PROJECTIONS[style]
    sheet = Sheet(500, 400, projection.half)
    paper = (255, 255, 255)
    for y in (0.5, -0.5):  # half the width of the window at its middle: 35.54 degrees
        side = math.atan(y / 0.7)
        for share, shown in ((0.97, True), (1.03, False)):
            colour = pixel(chart, sheet, projection.flat(np.array([share * side, 0.0])))
            assert (colour == paper) == shown
    top = math.atan(0.25 / 0.7)  # 19.65 degrees
    assert pixel(chart, sheet, projection.flat(np.array([0.0, 0.95 * top]))) == paper
    assert pixel(chart, sheet, projection.flat(np.array([0.0, 1.05 * top]))) != paper
    # 0.78703 sr: its share of the map is that of 4 pi, or of the cone of 125 degrees
    angles = projection.angles(sheet.places())
    ahead = np.isfinite(angles[..., 0]) & (np.abs(angles[..., 0]) < 1.0)
    free = ahead & np.all(chart.colours == 255, axis=2) & (np.abs(angles[..., 1]) < 0.5)
    total = (
        4 * math.pi if style == "equal_area" else 2 * math.pi * (1 - math.cos(math.radians(125)))
    )
    share = free.sum() / np.isfinite(angles[..., 0]).sum()
    assert share == pytest.approx(0.78703 / total, rel=0.02)


@pytest.mark.parametrize(
    "within", [WHOLE, cone("ahead", (1, 0, 0), 0.9), Region("a box", np.eye(3), math.pi, np.array([(0.5, -0.3), (-0.9, -0.4), (-0.7, 0.3), (0.4, 0.5)]))]
)  # fmt: skip
def test_what_a_chart_says_of_solid_angles_adds_up_to_its_region(within):
    scene = seen(room({**WALL, "post": ((0.5, 0.1, -0.3), (0.52, 0.2, 0.3))}))
    found = hidden_zones(scene, *scene.look(), within)
    assert found.total == pytest.approx(within.solid_angle, rel=2e-3)
    assert {zone.name for zone in found.rows} == {
        *(name.replace("_", " ") for name in WALL),
        "post",
    }


@pytest.mark.parametrize(("width", "hidden"), [(0.05, 0.0), (0.09, 0.025)])
def test_a_post_narrower_than_the_eyes_are_apart_hides_nothing_from_both(width, hidden):
    """At 600 mm, from 1 m below to 1 m above: both eyes lose what a post narrower by the distance of
    the eyes takes from one eye."""
    post = room({"post": ((0.6, -width / 2, -1.0), (0.6005, width / 2, 1.0))})
    scene = seen(post)
    found = hidden_zones(scene, *scene.look(math.radians(0.1)), WHOLE)
    a, b = hidden / 1.2, 1.0 / 0.6
    exact = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
    (row,) = found.rows
    assert row.both == pytest.approx(exact, abs=4e-3)
    assert row.one > 0.1


def test_the_ground_is_seen_from_where_the_line_over_the_hood_meets_it():
    """Eyes 1.2 m up; a hood 0.8 m high to 1 m ahead: 1 x 1.2 / (1.2 - 0.8) = 3 m."""
    scene = seen(room({"hood": ((0.3, -2, 0.0), (1.0, 2, 0.8))}), at=(0, 0, 1.2))
    near = blind_distances(scene, scene.look(math.radians(0.1)), 0.0)
    assert len(near) == 360
    assert near[0] == near[-1] == pytest.approx(3.0, rel=0.02)
    assert near[45] == pytest.approx(3.0 / math.cos(math.radians(45.5)), rel=0.02)
    assert near[180] == pytest.approx(0.3)  # nothing behind
    # to the right the hood goes to 2 m: 2 x 1.2 / (1.2 - 0.8) = 6 m
    assert near[284] == pytest.approx(
        min(3.0 / math.cos(math.radians(75.5)), 6.0 / math.sin(math.radians(75.5))), rel=0.02
    )
    chart = ground_plan(scene, 0.0, width=600, height=600)
    sheet = Sheet(600, 600, (10.0, 10.0))
    assert pixel(chart, sheet, (0.0, 3.2)) == CLEAR
    assert pixel(chart, sheet, (0.0, 2.8)) != CLEAR
    assert pixel(chart, sheet, (0.0, -1.0)) == CLEAR
    assert "3.0 m" in {words.text for words in chart.words}


def test_the_far_border_of_what_is_hidden_is_a_straight_line_to_a_pixel():
    """A hood 1.12 m high, 1 m ahead of eyes 1.2 m up: 1 x 1.2 / 0.08 = 15 m, where 0.1 degrees are 0.33 m
    of ground and a pixel is 0.1 m."""
    scene = seen(room({"hood": ((0.3, -3, 0.0), (1.0, 3, 1.12))}), at=(0, 0, 1.2))
    chart = ground_plan(scene, 0.0, width=1200, height=1200)
    sheet = Sheet(1200, 1200, (40.0, 40.0))
    step = 2.0 / sheet.scale
    across = np.linspace(-25.0, 25.0, 101)
    near = {pixel(chart, sheet, (x, 15.0 - step)) == CLEAR for x in across}
    far = {pixel(chart, sheet, (x, 15.0 + step)) == CLEAR for x in across}
    assert (near, far) == ({False}, {True})


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 2), st.floats(0.3, 2.0))
@settings(max_examples=10)
def test_labels_of_a_plan_of_the_ground_never_stand_on_one_another(at, tall):
    """Mean letters are 0.55 of their height wide; each distance and ring keeps its own label."""
    scene = seen(room({"cab": ((-2, -1, 0.0), (2, 1, 0.2))}), at=(at[0] / 2, at[1] / 4, tall))
    chart = ground_plan(scene, 0.0, width=240, height=240)
    labels = [one for one in chart.words if re.fullmatch(r"[\d.]+ m", one.text)]
    assert len(labels) >= 4
    for one, other in itertools.combinations(labels, 2):
        across, along = np.abs(np.subtract(one.at, other.at))
        letters = 0.55 * one.size * (len(one.text) + len(other.text)) / 2
        assert across >= letters or along >= one.size, (one, other)


def test_a_road_is_the_ground_and_hides_none_of_it():
    road = room({"road": ((-90, -90, -0.1), (90, 90, 0.0))})
    scene = seen(road, at=(0, 0, 1.2))
    assert blind_distances(scene, scene.look(), 0.0) == pytest.approx(0.3)
    with pytest.raises(UsageError, match="not below the eyes"):
        ground_plan(scene, 2.0, width=200, height=200)


def test_ground_in_a_flat_mirror_begins_where_the_virtual_eye_sees_it_past_the_lower_edge():
    """Eyes 1.2 m up, a mirror 0.5 m ahead from 1.0 to 1.4 m: from the virtual eye 1 m ahead the edge is
    0.5 m away and 0.2 m lower, so the ground comes into sight 3 m away from it: 2 m behind the eyes."""
    made = room({"glass": ((0.5, -0.5, 1.0), (0.51, 0.5, 1.4))})
    glass = Mirror("glass", "glass", (0.5, 0.0, 1.2), (-1.0, 0.0, 0.0), field="I")
    scene = seen(replace(made, mirrors=(glass,)), at=(0, 0, 1.2))
    asked = np.array([[-2.5, 1.0, 0.0], [-2.5, -1.0, 0.0], [-10.0, -1.0, 0.0], [-10.0, 1.0, 0.0]])
    chart = mirror_plan(
        scene,
        replace(made, mirrors=(glass,)),
        0.0,
        required={"glass": asked},
        source="a rule",
        width=600,
        height=600,
    )
    # from 6 m ahead to 1.1 x 10 m behind the eyes, 12 m to each side
    sheet = Sheet(600, 600, (0.5 * 27.0, 0.5 * 17.0))
    before, behind, beside = (
        pixel(chart, sheet, (x, y + 2.5)) for x, y in ((0, -1.8), (0, -2.2), (6.0, -4.0))
    )
    assert behind != before == beside == CLEAR  # at 4 m behind it is 5 m to each side
    said = " ".join(words.text for words in chart.words)
    assert "glass, flat: 100 % of the ground of class I is seen by one eye at least, 100 %" in said
    with pytest.raises(UsageError, match="has no mirrors"):
        mirror_plan(scene, made, 0.0, required={}, width=99, height=99)


def bytes_of(tmp_path, source, name, **given):
    out = tmp_path / name
    render(source, parse_display_options(out, **given), out)
    return out.read_bytes()


@pytest.fixture(scope="module")
def trainer():
    """The two men in the trainer, in the first case."""
    return build_source("trainer_clearance", case="cruise")


def test_a_chart_is_the_same_bytes_twice_small_and_large_and_names_what_hides(trainer, tmp_path):
    for name, size in (("a.png", "90"), ("b.png", "90"), ("c.png", "200x150")):
        image = Image.open(
            io.BytesIO(bytes_of(tmp_path, trainer, name, display="directions", size=size))
        )
        width, _, height = size.partition("x")
        assert image.size == (int(width), int(height or width))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    look = {"display": "directions", "view": "eye:instructor", "size": "240x400"}
    svg = bytes_of(tmp_path, trainer, "x.svg", **look).decode()
    root = ElementTree.fromstring(svg)
    texts = {text.text for text in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"own body", "pilot", "seen by both eyes", "in all"} <= texts
    assert "script" not in svg and "http:" not in svg.replace("http://www.w3.org/2000/svg", "")


def test_a_rule_is_drawn_over_and_measures_its_own_region():
    rule = Region(
        "a field", np.eye(3), math.pi, np.radians([(30, -10), (-30, -10), (-30, 10), (30, 10)])
    )
    chart = direction_chart(seen(room(WALL), rule=rule), "polar", width=400, height=400)
    assert "in a field" in chart.description and rule.solid_angle == pytest.approx(
        0.363688, abs=1e-6
    )
    assert f"{rule.solid_angle:.3f}" in {words.text for words in chart.words}
    assert chart_svg(chart).count('stroke="#ffffff"') == 1


def wide(view, **given):
    return parse_display_options_png(view=view, size="400", **given)


def parse_display_options_png(**given):
    from pathlib import Path

    return parse_display_options(Path("x.png"), **given)


def test_two_eyes_see_past_a_narrow_post_and_not_past_a_wide_one():
    """f = 200 / tan(37.5 degrees) = 260.6 pixels: a post of 90 mm at 600 mm hides 25 mm from both,
    +- 5.4 pixels; from one eye what is up to 77.5 mm aside, 33.7 pixels."""
    f = 200 / math.tan(math.radians(37.5))
    for width, both in ((0.09, 5.4), (0.05, 0.0)):
        post = room({"post": ((0.6, -width / 2, -2.0), (0.6005, width / 2, 2.0))}, head=(0, 0, 0))
        options = wide("both_eyes:head", look_at=None)
        scene = Scene((), post)
        camera = choose_camera(scene, options)
        level = math.radians(10.0)  # the usual line of sight is so far down
        assert camera.toward == pytest.approx([-math.cos(level), 0, math.sin(level)])
        image = np.asarray(picture(scene, camera, options)).astype(float)
        middle = round(200 - f * math.tan(level))
        strip = image[middle - 10 : middle + 10].max(axis=0).min(axis=1)  # between the hatches
        edge = f * (width / 2 + 0.0325) / 0.6 / math.cos(level)
        assert strip[round(200 + edge) + 3 :].min() == strip[: round(200 - edge) - 3].min() == 255
        pale = strip[round(200 + edge) - 6]
        assert pale < 255 and strip[round(200 - edge) + 6] == pale
        assert strip[200] < pale if both else strip[200] == 255
        assert (image[middle - 10 : middle + 10, 200].min() < strip[200] - 20) == (both > 0.0)


@pytest.mark.parametrize("kind", ["eye", "left_eye", "right_eye"])
def test_what_is_looked_at_is_in_the_middle_and_the_head_has_turned(trainer, kind):
    options = wide(f"{kind}:pilot", look_at="altimeter")
    camera = choose_camera(trainer.scene, options, trainer.people)
    corners = trainer.scene.environment.part("altimeter").vertices
    assert project(camera, (corners.min(axis=0) + corners.max(axis=0)) / 2)[:2] == pytest.approx(
        [200, 200], abs=4
    )
    placed = trainer.scene.bodies[0].placed
    eyes = eyes_of(placed)
    found = gaze(eyes, corners.mean(axis=0)).eyes
    at = {"eye": found.middle, "left_eye": found.left, "right_eye": found.right}[kind][0]
    assert camera.centre + camera.distance * camera.toward == pytest.approx(at, abs=2e-3)


def test_eyes_see_what_is_nearer_than_the_own_hands(trainer):
    """Nothing is cut away before the foremost body, as in views from outside."""
    eyes = given_eyes((0, 0, 0))
    camera = eyes_camera(eyes, "eye", None, field=1.0, width=80, height=80)
    post = room({"post": ((0.15, -0.02, -1.0), (0.16, 0.02, 1.0))})
    body = trainer.scene.bodies[0]
    centre = body.placed.centres + np.array([0.5, 0, -0.5])
    far = replace(body, placed=replace(body.placed, centres=centre))
    for bodies in ((), (far,)):
        image = picture(Scene(bodies, post), camera, wide("eye"))
        assert np.asarray(image)[40, 40].max() < 250


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("x.png", {"display": "directions", "view": "left_eye"}, "what both eyes"),
        ("x.png", {"display": "ground", "angle": 40.0}, "no camera"),
        ("x.png", {"display": "directions", "ground": 0.0}, "for --display ground"),
        ("x.png", {"view": "left", "look_at": "altimeter"}, "take a view of eye"),
        ("x.svg", {"view": "both_eyes"}, "take .png, or left_eye or right_eye"),
        ("x.png", {"view": "third_eye"}, "no view 'third_eye'"),
        ("x.glb", {"look_at": "altimeter"}, "--look-at"),
        ("x.png", {"display": "directions", "style": "mercator"}, "no style 'mercator'"),
    ],
)
def test_options_that_do_not_go_together_are_refused(tmp_path, name, given, message):
    with pytest.raises(UsageError, match=message):
        parse_display_options(tmp_path / name, **given)


def test_who_or_what_is_not_there_is_refused(trainer, tmp_path):
    for look, message in (
        ({"view": "left_eye:nobody"}, "nobody is called 'nobody'; .*left_design_eye"),
        ({"view": "left_eye", "look_at": "altimetr"}, "did you mean 'altimeter'"),
    ):
        with pytest.raises(UsageError, match=message):
            bytes_of(tmp_path, trainer, "x.png", **look)
    blind = room({"block": ((-1, -1, -1), (1, 1, 1))}, inside=(0, 0, 0))
    with pytest.raises(InputError, match="inside 'block'"):
        outlook_of = outlook(Scene((), blind), (), "inside")
        direction_chart(outlook_of, "polar", width=100, height=100)
    with pytest.raises(
        UsageError, match="no body here whose eyes could see; place eyes at a point"
    ):
        outlook(Scene((), blind), (), "")


def test_the_command_and_python_draw_from_eyes_at_a_point(tmp_path, capsys):
    given = ["--display", "directions", "--view", "eye:design_eye", "--size", "200"]
    assert main(["render", "compact_car", "-o", str(tmp_path / "a.png"), *given]) == 0
    wb.render(
        "compact_car",
        tmp_path / "b.png",
        display="directions",
        view="eye:design_eye",
        size="200",
    )
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    plan = ["--display", "ground", "--ground", "-0.3", "--view", "eye:design_eye", "--size", "200"]
    assert main(["render", "compact_car", "-o", str(tmp_path / "c.png"), *plan]) == 0
    mirrors = [*plan, "--style", "mirrors", "--outline", "sight_un_r46"]
    assert main(["render", "compact_car", "-o", str(tmp_path / "m.png"), *mirrors]) == 0
    assert main(["render", "compact_car", "-o", str(tmp_path / "d.png"), *given[:2]]) == 2
    assert "design_eye" in capsys.readouterr().err


LITTLE = """\
study: little_view
length: mm
environment: trainer
people:
  pilot: {body: bubbleman, seat: left, position: reference}
cases:
  - {name: flying, people: {pilot: {posture: seated}}}
criteria:
"""


def test_a_page_has_the_charts_where_a_criterion_asks_what_people_see(tmp_path):
    """With the outline of a criterion, inside which both criterion and chart count the same."""
    path = tmp_path / "little_view.yaml"
    asked = "  - {name: clear view, check: outline, rules: sight_ac_25_773_1, side: left, eye_point: left_design_eye, at_least: 80}\n"
    path.write_text(LITTLE + asked)
    result = wb.run(wb.load_study(path))
    wb.write_report(result, tmp_path / "seen")
    text = (tmp_path / "seen" / "report.html").read_text()
    section = text[text.index('id="sight"') :]
    section = section[: section.index("</section>")]
    assert section.count("<svg") == 2 and "eyes at left design eye" in section
    said = "“clear view”, the same for everybody: from left design eye: "
    assert f"<figcaption>{said}96.2 % of the outline is clear, 16.2 points more than" in section
    assert "AC 25.773-1, pilot compartment view of transport category airplanes" in section
    lines = re.findall(r"<text[^>]*>([^<]*)</text>", section[: section.index("<figcaption>")])
    hidden = float(lines[len(lines) - 1 - lines[::-1].index("hidden") + 2])
    clear = result.verdict("clear view").worst.value
    assert 100 * (1 - clear) == pytest.approx(hidden, abs=0.15)


def glimpse(source, name, check, value, limit, **given):
    """What is measured of a criterion of trainer_view by the pilot of a scene."""
    asked = next(one for one in wb.load_study("trainer_view").criteria if one.check == check)
    beheld = Beheld(source.scene, source.people, "pilot", "the pilot, cruise", "left")
    found = Finding("cruise", "pilot", "", "heading_indicator", "", value, limit, **given)
    return Glimpse(replace(asked, name=name), found, beheld, source.scene.environment)


def test_what_is_nearest_to_its_limit_is_drawn_first_and_what_is_far_is_folded(trainer):
    """Of shares and angles 1 % counts as 1 mm and a degree as 3.5 mm: 5 %, 2 degrees, 10 %, 20 %."""
    dial = {"unit": "share", "point": trainer.scene.environment.instrument("heading_indicator").at}
    asked = [
        glimpse(trainer, "far", "sees", 1.0, 0.8, **dial),
        glimpse(trainer, "nose", "over_nose", math.radians(14), math.radians(12), unit="rad"),
        glimpse(trainer, "missed", "sees", 0.75, 0.8, **dial),
        glimpse(trainer, "clear", "outline", 1.0, 0.9, unit="share"),
    ]
    (section,) = sight_sections(asked, [])
    captions = re.findall("<figcaption>(.*?)</figcaption>", section.html)
    names = re.findall("“(.*?)”, (.*?): ", " ".join(captions))
    assert [name for name, _ in names] == ["missed", "nose", "clear", "far"]
    assert [way.split()[0] for _, way in names] == ["farthest", "nearest", "the", "nearest"]
    assert captions[0].startswith("“missed”, farthest from meeting it: the pilot, cruise: heading")
    assert captions[2].startswith("“clear”, the same for everybody: from left design eye: 100")
    assert captions[4] == "Every direction: the pilot, cruise."
    folded = section.html.index("<details><summary>2 more pictures of what is seen")
    assert section.html.count("<figure", 0, folded) == 3 and section.html.count("<figure") == 5


def test_a_thing_that_is_looked_at_is_marked_once_in_the_middle_of_the_picture(trainer):
    """The pictures of both eyes lie over one another where they look, and the mark is one."""
    point = trainer.scene.environment.instrument("heading_indicator").at
    eyes = eyes_of(trainer.scene.bodies[0].placed).rows(slice(0, 1))
    looks = gaze(eyes, point).eyes
    camera = eyes_camera(looks, "both_eyes", np.array(point), field=0.9, width=300, height=200)
    marked = replace(trainer.scene, marks=(Mark(point, "x"),))
    image, bare = (
        np.asarray(both_eyes(scene, camera, disks), dtype=int)
        for scene in (marked, replace(marked, marks=()))
    )
    rows, columns = np.nonzero((image != bare).any(axis=2))
    assert abs(rows - 100).max() < 25 and abs(columns - 150).max() < 60
    assert project(camera, np.array([point]))[0].ravel()[:2] == pytest.approx([150, 100], abs=0.5)


def test_a_pillar_and_the_forward_field_are_drawn_from_the_points_of_their_rule():
    """All of the field below level is drawn, 180 degrees wide and 4 degrees high or less: less than
    pi x 4 degrees; and a pillar that hides nothing from both eyes in 20 degrees about it."""
    study = wb.load_study("car_view")
    beheld = Beheld(Scene(), (), "nobody", "nobody", "driver")
    found = Finding("", "", "", "", "", 0.0, -0.1, unit="rad")
    asked = [one for one in study.criteria if one.name in ("right pillar", "forward field")]
    (section,) = sight_sections(
        [Glimpse(one, found, beheld, study.environment) for one in asked], []
    )
    said = section.html
    assert "solid angles in the field below level" in said and "from V2" in said
    assert "solid angles in 20 degrees about the pillar" in said
    assert ">0.379<" in said  # 2 pi (1 - cos 20 degrees)
    field = said[said.index("the field below level") :]
    whole = float(re.findall(r">in all</text>\s*<text[^>]*>([\d.]+)<", field)[0])
    assert 0.1 < whole < math.pi * math.radians(4)


def test_a_page_without_such_a_criterion_has_no_charts(trainer):
    beheld = Beheld(trainer.scene, trainer.people, "pilot", "pilot, cruise")
    assert sight_sections([], [beheld]) == []


def test_the_outline_of_a_rule_wants_its_seat(tmp_path):
    look = {"display": "directions", "outline": "sight_ac_25_773_1"}
    with pytest.raises(UsageError, match="a rule set and the seat are needed"):
        parse_display_options(tmp_path / "x.png", **look)
    with pytest.raises(UsageError, match="for --display directions"):
        parse_display_options(tmp_path / "x.png", outline="sight_ac_25_773_1:left")
    svg = bytes_of(
        tmp_path,
        build_source("trainer"),
        "x.svg",
        display="directions",
        view="eye:left_design_eye",
        outline="sight_ac_25_773_1:left",
    ).decode()
    assert "AC 25.773-1, pilot compartment view" in svg and ">1.995<" in svg
