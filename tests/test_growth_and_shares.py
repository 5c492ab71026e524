"""Growth, shares and their intervals, and people on the command line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from workbench import InputError, load_population_model
from workbench.body.people.growth_charts import growth_people, growth_percentile, growth_values
from workbench.body.people.proportions import proportion_interval
from workbench.cli import main
from workbench.files.populations import load_growth
from workbench.model.population import MEASURES, SEXES

ANSUR2 = load_population_model("ansur2")
GROWTH = load_growth()
sexes = st.sampled_from(SEXES)
measures = st.sampled_from(sorted(MEASURES))


def test_growth_has_the_published_percentiles_of_the_cdc():
    """Stature of boys of 24.5 months at the 3rd, 5th, 50th, 95th, 97th percentile, and the median
    at 24.0 months."""
    want = [0.8026037, 0.8108869, 0.8686161, 0.9263177, 0.9345923]
    got = growth_values(GROWTH, "male", [3, 5, 50, 95, 97], age=24.5 / 12)[:, 0]
    assert got == pytest.approx(want, abs=1e-5)
    assert growth_values(GROWTH, "male", 50, age=2)[0, 0] == pytest.approx(0.8645220, abs=2e-4)
    assert growth_values(GROWTH, "female", 50, age=20)[0] == pytest.approx(
        [1.63338, 58.219], abs=1e-3
    )


@given(sexes, st.floats(2, 20), st.floats(0.1, 99.9))
def test_a_childs_percentile_is_the_one_it_was_made_for(sex, age, p):
    child = growth_people(GROWTH, sex, p, age=age)
    for name in child.names:
        assert growth_percentile(GROWTH, sex, name, child.column(name), age=age)[
            0
        ] == pytest.approx(p, abs=1e-6)


@given(sexes, st.floats(2, 19.5), st.floats(1, 99))
def test_children_grow(sex, age, p):
    now, later = (growth_values(GROWTH, sex, p, age=at)[0] for at in (age, age + 0.5))
    assert later[0] > now[0] - 1e-4


@pytest.mark.parametrize(
    ("p", "age"), [(50, 1.9), (50, 20.1), (0, 6), (100, 6), (float("nan"), 6), (50, float("nan"))]
)
def test_growth_outside_the_charts_is_refused(p, age):
    with pytest.raises(InputError, match="are known, got"):
        growth_values(GROWTH, "female", p, age=age)


@given(st.integers(1, 400), st.floats(0, 1), st.sampled_from([0.9, 0.95, 0.99]))
def test_confidence_intervals_are_those_of_scipy(people, part, confidence):
    inside = round(part * people)
    told = proportion_interval(np.arange(people) < inside, confidence=confidence)
    want = binomtest(inside, people).proportion_ci(confidence, method="wilson")
    assert (told.low, told.high) == pytest.approx((want.low, want.high), abs=1e-9)


def test_equal_weights_change_nothing_and_one_heavy_person_widens_the_interval():
    served = np.arange(100) < 72
    plain = proportion_interval(served)
    assert str(plain) == "72 % of 100 people (95 % confidence: 63 to 80 %)"
    assert proportion_interval(served, weight=np.full(100, 3.0)) == plain
    heavy = proportion_interval(served, weight=np.where(np.arange(100) == 0, 50.0, 1.0))
    assert heavy.high - heavy.low > plain.high - plain.low


@pytest.mark.parametrize("wrong", [{"confidence": 1.0}, {"weight": [1.0]}, {"weight": [1, 0]}])
def test_senseless_shares_are_refused(wrong):
    with pytest.raises(InputError):
        proportion_interval(np.array([True, False]), **wrong)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "people percentile --sex male --p 5 --measures stature,mass sitting-height",
            "stature          mm   1648.0",
        ),
        ("people boundary --sex female --share 90", "2  longest limbs"),
        ("people draw --count 40 --measures stature", "ansur2, drawn with seed 1, female"),
        (
            "people draw --count 2 --seed 3 --men 1 --measures mass --csv --synthetic",
            "label,sex,mass_kg\nmale 1,male,",
        ),
        ("people growth --age 6 --sex male --p 50", "stature   mm   1153.9"),
    ],
)
def test_the_command_line_shows_people_in_millimetres_and_kilograms(line, told, capsys):
    assert main(line.split()) == 0
    assert told in capsys.readouterr().out


def test_json_of_people_names_each_measure_with_its_unit(capsys):
    assert main(["people", "boundary", "--sex", "male", "--json"]) == 0
    people = json.loads(capsys.readouterr().out)["people"]
    assert len(people) == 8 and people[0]["label"] == "overall large"
    assert list(people[0]["measures"])[:2] == ["thumb_tip_reach_mm", "buttock_knee_length_mm"]


@pytest.mark.parametrize(
    ("line", "code", "told"),
    [
        ("people percentile --sex man", 2, "sex"),
        ("people percentile --sex male --p 101", 3, "a percentile lies between 0 and 100, got 101"),
        ("people percentile --sex male --measures height", 3, "no measure 'height'"),
        ("people percentile --sex male --population gone.csv", 3, "gone.csv: no such file"),
        ("people boundary --sex male --share 100", 3, "between 0 and 1"),
        ("people draw --count 10 --men 2", 2, "the share of men lies between 0 and 1"),
        ("people draw --count 1 --json --csv", 2, "not both"),
        ("people growth --sex male --age 30", 3, "ages from 2 to 20 years are known, got 30"),
    ],
)
def test_the_command_line_says_what_is_wrong_with_people(line, code, told, capsys):
    assert main(line.split()) == code
    assert told in capsys.readouterr().err
