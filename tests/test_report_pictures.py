"""The report's line drawing of the nearest clearances, and sentences that name parts."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import made, trainer_people
from tests.one_arm_cab import write_cab
from tests.test_accommodation_page import FLAPS, page_of
from tests.test_draw import SVG
from workbench import load_body
from workbench.draw.scene import Scene, SceneBody
from workbench.report.joint_angles import angle_rows
from workbench.report.page import page
from workbench.report.postures.drawing import clearance_drawing
from workbench.report.result_rows import result_file
from workbench.report.sentences import proper_minus, without_polygons


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """The result of the small cab."""
    return wb.run(wb.load_study(write_cab(tmp_path_factory.mktemp("cab"))))


def test_the_drawing_states_the_least_clearance_of_the_case(result):
    found = result.postures[0]
    person = found.people[0]
    scene = Scene((SceneBody(person.placed, 0),), found.environment)
    drawing = clearance_drawing(scene, found.people, 0, within=9.0, size=200)
    texts = [item.text for item in ElementTree.fromstring(drawing["svg"]).iter(SVG + "text")]
    measured = {
        f"{part} {1000 * value:.1f} mm"
        for part, values in zip(
            found.environment.parts, person.clearance.distance[0].T.tolist(), strict=True
        )
        for value in values
    }
    assert len(set(texts) & measured) >= 2
    assert drawing["name"] in ("front", "left", "top", "corner")


def test_there_is_no_drawing_where_nothing_is_near(result):
    found = result.postures[0]
    scene = Scene((SceneBody(found.people[0].placed, 0),), found.environment)
    assert clearance_drawing(scene, (), 0, within=9.0, size=200) is None
    assert clearance_drawing(scene, found.people, 0, within=1e-9, size=200) is None


def test_sentences_of_the_page_name_parts_and_not_polygons_by_number(result, monkeypatch):
    monkeypatch.setattr("workbench.report.postures.section.NEAR", 9.0)
    text = page(result, result_file(result))
    assert 'class="drawing"' in text
    assert not re.search(r"polygon \d", text)
    assert without_polygons("head is 5 mm from canopy, polygon 429.") == "head is 5 mm from canopy."
    assert replace(result, warnings=()).passed == result.passed


def test_numbers_below_zero_have_a_minus_for_reading_and_names_keep_their_hyphens():
    said = proper_minus("knee-cap 3-5: from -25 to -.5 degrees (x -12)")
    assert said == "knee-cap 3-5: from −25 to −.5 degrees (x −12)"


def test_a_joint_that_turns_both_ways_has_one_row_and_one_that_rests_has_none():
    body = load_body("bubbleman")
    postures = [{"LS": {"flexion": 10.0}, "LE": {"flexion": 0.04}}, {"LS": {"extension": 4.0}}]
    assert angle_rows(body, postures) == [
        ("left shoulder", "flexion, − extension", ["10.0", "-4.0"])
    ]
    assert angle_rows(body, postures[1:]) == [("left shoulder", "extension", ["4.0"])]


CIRCLES = re.compile(
    r'<figure class="drawing">(<svg.*?</svg>)\s*<figcaption>([^<]*), corner view: each sphere',
    re.DOTALL,
)


def test_each_case_is_drawn_as_circles_too(result):
    found = result.postures[0]
    drawn = CIRCLES.findall(page(result, result_file(result)))
    assert [words for _, words in drawn] == list(found.cases)
    shapes = [
        one for one in ElementTree.fromstring(drawn[0][0]).iter() if one.tag.endswith("circle")
    ]
    assert len(shapes) == sum(len(person.body.sphere_names) for person in found.people)


def test_the_hardest_of_a_population_is_drawn_as_circles_too():
    found = made(trainer_people(4), [FLAPS], np.full((4, 1), -0.01), shown=True)
    assert len(CIRCLES.findall(page_of(found))) == 1
