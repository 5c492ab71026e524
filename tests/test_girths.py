"""Measures that no single length of a standing body gives: tapes around it, and what a seat changes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import workbench as wb
from tests.conftest import ROOT
from tests.rows import changed
from workbench import load_population_model, measure, scale
from workbench.body.people.percentile import percentile_values
from workbench.body.scaling.manikin import LEFT, UP, Length, Manikin
from workbench.files.body.writer import body_text
from workbench.study.accommodation.population_bodies import (
    EXACT_MEASURES,
    fit_chunk,
    templates_by_sex,
)

GIRTHS = {
    "chest_circumference": (0.04, 0.04),
    "waist_circumference": (0.02, 0.05),
    "buttock_circumference": (0.05, 0.06),
    "thigh_circumference": (0.10, 0.10),
    "calf_circumference": (0.09, 0.10),
    # the survey's is taken over a tensed muscle
    "biceps_circumference_flexed": (0.19, 0.16),
}
"""How far the median man's and woman's bodies are off the survey's medians, as shares: spheres lie
some millimetres under the skin."""


@pytest.fixture(scope="module", params=["adult_male", "adult_female"])
def adult(request):
    return wb.load_body(request.param)


def lower_leg(body, places, radius):
    """The body whose right lower leg is one or two balls, by turns, at places (.., 3) off its origin."""
    rows = np.arange(*body.spheres(body.segment("RLL")).indices(len(body.sphere_names)))
    centre = body.centre[0].copy()
    centre[rows] = np.resize(places, (len(rows), 3))
    size = body.radius[0].copy()
    size[rows] = radius
    return changed(body, centre=centre, radius=size)


def tape(body, up):
    """The tape [m] around the right lower leg so far over the lowest of its sphere centres."""
    manikin = Manikin(body)
    rows = body.spheres(body.segment("RLL"))
    low = float(manikin.centres("standing")[rows, 2].min())
    return manikin.value(manikin.tape(Length((), low + up), ["RLL"]))


def test_a_tape_around_a_ball_is_the_circle_at_its_level(bubbleman):
    ball = lower_leg(bubbleman, [[0, 0, 0]], 0.05)
    assert tape(ball, 0.0) == pytest.approx(2 * np.pi * 0.05, rel=1e-9)
    assert tape(ball, 0.03) == pytest.approx(2 * np.pi * 0.04, rel=1e-9)
    with pytest.raises(wb.InputError, match="no spheres for a tape"):
        tape(ball, 0.06)


def test_a_tape_around_two_balls_runs_straight_between_them(bubbleman):
    apart = lower_leg(bubbleman, [[0.06, 0, 0], [-0.04, 0, 0]], 0.05)
    assert tape(apart, 0.0) == pytest.approx(2 * np.pi * 0.05 + 2 * 0.10, rel=1e-3)


def test_a_tape_is_the_hull_of_the_circles_at_its_level(adult):
    manikin = Manikin(adult)
    level = manikin.middle("standing", UP, "UT/right breast")
    rows = adult.spheres(adult.segment("UT"))
    centre = manikin.centres("standing")[rows]
    off = centre[:, 2] - manikin.value(level)
    shown = np.sqrt(np.maximum(adult.radius[0, rows] ** 2 - off**2, 0.0))
    angle = np.linspace(0, 2 * np.pi, 720)
    rim = centre[:, None, :2] + shown[:, None, None] * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    )
    hull = ConvexHull(rim[shown > 0].reshape(-1, 2))
    # the "area" of a hull in the plane is its perimeter
    assert manikin.value(manikin.tape(level, ["UT"])) == pytest.approx(hull.area, rel=2e-3)


@pytest.mark.parametrize("name", GIRTHS)
def test_a_girth_that_is_given_is_shown(adult, name):
    own = measure(adult, ["stature", name])
    wanted = {"stature": own["stature"], name: 1.06 * own[name]}
    shown = measure(scale(adult, wanted), ["stature", name])
    assert shown == pytest.approx(wanted, abs=1e-4)


def test_typical_girths_are_those_of_the_survey_by_the_stated_shares(adult):
    sex = adult.name.removeprefix("adult_")
    model = load_population_model("ansur2")
    median = dict(zip(model.names, percentile_values(model, sex, [50.0])[0].tolist(), strict=True))
    found = measure(adult, GIRTHS)
    for name, most in GIRTHS.items():
        assert abs(found[name] / median[name] - 1) < most[sex == "female"], name


# -------------------------------------------------------------------------------------------------
# on a seat


def test_hip_breadths_standing_and_sitting_are_both_shown(adult, tmp_path):
    wanted = {"stature": 1.70, "hip_breadth": 0.35, "hip_breadth_sitting": 0.41}
    person = scale(adult, wanted)
    assert measure(person, wanted) == pytest.approx(wanted, abs=1e-4)
    sitter = Manikin(wb.seated(person))
    length = sitter.farthest("sitting", LEFT, ["LT", "LUL", "RUL"])
    assert 2 * sitter.value(length) == pytest.approx(0.41, abs=1e-3)
    path = tmp_path / "person.yaml"
    origin = ROOT / f"bodies/{adult.name}.yaml"
    path.write_text(body_text(person, origin, name="p", description="p", folder=tmp_path))
    assert measure(wb.load_body(path), wanted) == pytest.approx(wanted, abs=2e-4)


def test_hips_that_no_seat_spreads_so_far_are_refused(adult):
    with pytest.raises(wb.InputError, match=r"1\.71 times the breadth standing; 0\.7 to 1\.4"):
        scale(adult, {"hip_breadth": 0.35, "hip_breadth_sitting": 0.60})


def test_elbow_rest_height_is_shown_with_either_height_or_length_of_the_shoulder(adult):
    own = measure(adult)
    for other in ("acromial_height_sitting", "shoulder_elbow_length"):
        wanted = {"stature": own["stature"], "elbow_rest_height": own["elbow_rest_height"] + 0.02}
        wanted[other] = own[other]
        assert measure(scale(adult, wanted), wanted) == pytest.approx(wanted, abs=1e-4)
    with pytest.raises(wb.InputError, match="give two of the three"):
        scale(adult, wanted | {"acromial_height_sitting": own["acromial_height_sitting"]})


def test_people_of_the_survey_show_what_a_seat_is_made_for(adult):
    people = load_population_model("ansur2").people
    some = people.rows(np.array([3, 700, 4500, 5900]))
    templates = templates_by_sex(wb.load_body("adult_male"))
    chunk = fit_chunk(templates, some)
    assert chunk.notes == [""] * 4
    shown = ["hip_breadth", "hip_breadth_sitting", "elbow_rest_height", "acromial_height_sitting"]
    assert set(shown) <= set(EXACT_MEASURES)
    for row, (sex, values) in enumerate(zip(some.sex, some.measures, strict=True)):
        fields = {name: rows[row] for name, rows in chunk.fields.items()}
        body = changed(templates[("male", "female")[sex]], **fields)
        known = dict(zip(some.names, values.tolist(), strict=True))
        assert measure(body, shown) == pytest.approx({n: known[n] for n in shown}, abs=2e-4)
