"""Bodies in pieces: spheres that do not touch are counted and told, and the shipped studies have
none."""

from __future__ import annotations

import re

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import ACCOMMODATIONS
from tests.crowds import crowd_of
from tests.rows import changed
from tests.toy_cockpit import write_toy
from workbench.body.people.proportions import TENTHS_FROM
from workbench.body.pieces import body_pieces, piece_warnings
from workbench.body.scaling.scale import morph_to
from workbench.report.page import page
from workbench.report.result_rows import result_file
from workbench.study.accommodation.population_bodies import templates_by_sex


@pytest.fixture(scope="module")
def man():
    return wb.load_body("adult_male")


def test_two_balls_of_10_mm_at_100_mm_are_two_pieces_80_mm_apart(two_spheres):
    found = body_pieces(two_spheres)
    assert found.count == 2
    assert found.piece.tolist() == [0, 0, 1, 1]
    assert found.gap == pytest.approx([0.08, 0.08])


def test_balls_that_just_touch_are_one_piece(two_spheres):
    radius = two_spheres.radius[0].copy()
    radius[[0, 3]] = 0.05
    assert body_pieces(changed(two_spheres, radius=radius)).count == 1
    radius[0] -= 1e-9
    assert body_pieces(changed(two_spheres, radius=radius)).count == 2


def with_a_lone_fingertip(body):
    """The body with the tip of its left middle finger 30 mm farther out than it is."""
    sphere = next(
        s
        for s, name in enumerate(body.sphere_names)
        if name == "middle fingertip" and body.segments[body.sphere_segment[s]] == "LHN"
    )
    centre = body.centre[0].copy()
    centre[sphere, 2] -= 0.03
    return changed(body, centre=centre)


@pytest.mark.parametrize("level", ["coarse", "medium", "fine"])
def test_a_man_of_each_level_is_one_piece_and_two_with_a_fingertip_off(man, level):
    body = morph_to(man, level)
    assert body.detail == level
    assert body_pieces(body).count == 1
    found = body_pieces(with_a_lone_fingertip(body))
    assert found.count == 2 == len(np.unique(found.piece))
    assert 0.01 < found.gap[1] < 0.03
    assert np.all(np.diff(np.bincount(found.piece)) <= 0)


def test_a_warning_names_the_level_the_gap_and_where_the_body_is_whole(man):
    broken = with_a_lone_fingertip(morph_to(man, "coarse"))
    (told,) = piece_warnings([("anna", broken), ("bert", man), ("carl", broken)])
    assert told.startswith("anna, carl: the body at level of detail coarse is in 2 pieces with ")
    assert "left hand" in told and "; whole at: " in told


def test_the_page_says_the_level_and_the_spheres(tmp_path):
    result = wb.run(wb.load_study(write_toy(tmp_path, people=1)))
    html = page(result, result_file(result))
    text = re.sub(r"<style>.*?</style>|<[^>]+>", " ", html, flags=re.DOTALL)
    assert "pieces" not in text
    told = "own measures, from the family of bodies “human basis”: 273 spheres"
    assert f"Each person has a body of his or her {told} (level of detail coarse)." in text


@pytest.mark.parametrize("name", ACCOMMODATIONS)
def test_a_shipped_accommodation_study_has_whole_bodies_and_enough_people(name):
    study = crowd_of(name)
    assert [body_pieces(body).count for body in templates_by_sex(study.body).values()] == [1, 1]
    assert 200 <= len(study.people) < TENTHS_FROM
