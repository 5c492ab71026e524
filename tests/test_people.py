"""People: draws, percentiles, boundary cases and conditional means, against the survey and known
laws."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import REFERENCE, SHARED, real_input
from tests.percentile_trap import inside_limits, inside_own_percentiles
from workbench import (
    InputError,
    UsageError,
    boundary_cases,
    draw_people,
    load_population_model,
    read_ansur,
)
from workbench.body.people.conditional import (
    conditional_distribution,
    mahalanobis_distance,
    scores_of,
)
from workbench.body.people.percentile import percentile_people, percentile_values
from workbench.files.populations import load_growth
from workbench.model.population import COCKPIT, MEASURES, SEXES, Population

RAW = [
    SHARED / "anthropometry" / "ansur2" / f"ANSUR_II_{sex}_Public.csv" for sex in ("MALE", "FEMALE")
]
BOUNDARY_CASES = "boundary_cases_ansur2_95.csv"
THREE = ("sitting_height", "buttock_knee_length", "thumb_tip_reach")
ANSUR2 = load_population_model("ansur2")
GROWTH = load_growth()
sexes = st.sampled_from(SEXES)
measures = st.sampled_from(sorted(MEASURES))


@pytest.fixture(scope="module")
def raw():
    return read_ansur(*map(real_input, RAW))


@pytest.fixture(scope="module")
def drawn():
    """20000 men and 20000 women like those measured."""
    return draw_people(ANSUR2, 40000, seed=1, synthetic=True)


def five(values, sex):
    """Population of one measure, five people."""
    return Population(
        ("stature",), np.full(5, SEXES.index(sex)), np.ones(5), np.array(values)[:, None], "five"
    )


@pytest.mark.parametrize("sex", SEXES)
def test_draws_have_the_surveys_quantiles_within_3_mm(raw, sex):
    """60000 of each sex: of 20000, chance alone moves the 95th percentile of the largest measures
    by up to 3 mm."""
    levels = [5, 50, 95]
    many = draw_people(ANSUR2, 60000, seed=1, men=float(sex == "male"), synthetic=True)
    off = percentile_values(many, sex, levels) - percentile_values(raw, sex, levels)
    assert np.abs(off[:, np.array(raw.names) != "mass"]).max() < 0.003
    assert np.abs(off[:, raw.names.index("mass")]).max() < 0.5


@pytest.mark.parametrize(("sex", "six", "three"), [("male", 71.8, 78.0), ("female", 69.1, 76.4)])
def test_as_many_synthetic_people_as_real_ones_are_inside_their_own_5_to_95_on_all_cockpit_measures(
    drawn, sex, six, three
):
    people = drawn.of_sex(sex)
    assert 100 * inside_own_percentiles(people).mean() == pytest.approx(six, abs=1)
    assert 100 * inside_own_percentiles(people, measures=THREE).mean() == pytest.approx(
        three, abs=1
    )


@pytest.mark.parametrize(("sex", "six", "three"), [("male", 71.8, 78.0), ("female", 69.1, 76.4)])
def test_the_percentile_trap_of_the_survey(raw, sex, six, three):
    people = raw.of_sex(sex)
    assert 100 * inside_own_percentiles(people).mean() == pytest.approx(six, abs=0.05)
    assert 100 * inside_own_percentiles(people, measures=THREE).mean() == pytest.approx(
        three, abs=0.05
    )


def test_a_box_from_5th_percentile_woman_to_95th_percentile_man_holds_85_and_82_per_cent(raw):
    six = raw.of(COCKPIT)
    low = percentile_values(six, "female", 5)[0]
    high = percentile_values(six, "male", 95)[0]
    inside = inside_limits(six, low, high)
    assert [100 * inside[six.sex == k].mean() for k in (0, 1)] == pytest.approx(
        [85.2, 82.5], abs=0.15
    )


def test_draws_keep_the_surveys_correlations(raw, drawn):
    for sex in SEXES:
        r, s = (np.corrcoef(people.of_sex(sex).measures.T) for people in (raw, drawn))
        assert np.abs(r - s).max() < 0.03


@given(st.integers(0, 2**63), st.integers(0, 60), st.floats(0, 1))
def test_the_same_seed_draws_the_same_people_and_as_many_men_as_asked(seed, count, men):
    one, two = (draw_people(ANSUR2, count, seed=seed, men=men) for _ in range(2))
    assert np.array_equal(one.measures, two.measures) and one.labels == two.labels
    assert (one.sex == 0).sum() == round(count * men) and len(one) == count


def test_more_draws_of_a_seed_begin_with_the_same_people():
    few, many = (draw_people(ANSUR2, count, seed=7, men=1) for count in (3, 30))
    assert np.allclose(few.measures, many.measures[:3], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "wrong", [{"count": -1}, {"count": 10**9}, {"men": 1.1}, {"men": float("nan")}, {"seed": -1}]
)
def test_senseless_draws_are_refused(wrong):
    options = {"count": 1, "seed": 1, "men": 0.5} | wrong
    with pytest.raises(UsageError):
        draw_people(ANSUR2, options.pop("count"), **options)


def test_percentiles_of_real_people_are_numpys_and_weights_count():
    people = five([1.5, 1.6, 1.7, 1.8, 1.9], "male")
    assert percentile_values(people, "male", [0, 10, 25, 100])[:, 0] == pytest.approx(
        [1.5, 1.54, 1.6, 1.9]
    )
    heavy = replace(people, weight=[1, 1, 1, 1, 100])
    assert percentile_values(heavy, "male", 50)[0, 0] > 1.8


@pytest.mark.parametrize("p", [-1, 101, float("nan")])
def test_a_percentile_outside_0_to_100_is_refused(p):
    with pytest.raises(InputError, match="between 0 and 100"):
        percentile_people(ANSUR2, "male", [50, p])


@pytest.mark.parametrize("sex", SEXES)
def test_boundary_cases_of_the_survey_are_those_of_the_reference_within_a_millimetre(raw, sex):
    table = csv.DictReader(real_input(REFERENCE / BOUNDARY_CASES).read_text().splitlines())
    rows = [r for r in table if r["sex"] == sex[0].upper()]
    people = boundary_cases(raw, sex).people
    names = {name.replace("_", ""): name for name in people.names}
    for column in [name for name in rows[0] if name in names]:
        want = np.array([float(row[column]) for row in rows]) / 1000
        assert people.column(names[column]) == pytest.approx(want, abs=0.001), column
    assert people.column("mass") == pytest.approx([float(row["kg"]) for row in rows], abs=0.1)


@pytest.mark.parametrize(("sex", "radius"), [("male", 2.50), ("female", 2.41)])
def test_the_surveys_ellipse_has_the_known_radius_and_two_axes_explain_89_per_cent(
    raw, sex, radius
):
    boundary = boundary_cases(raw, sex)
    assert boundary.radius == pytest.approx(radius, abs=0.005)
    assert boundary.explained.sum() == pytest.approx(0.889, abs=0.002)


@pytest.mark.parametrize("sex", SEXES)
def test_boundary_cases_of_the_model_are_near_those_of_the_survey(raw, sex):
    real, model = (
        boundary_cases(source, sex).people.of(COCKPIT).measures for source in (raw, ANSUR2)
    )
    assert np.abs(real - model).max() < 0.008


@given(
    sexes,
    st.lists(measures, min_size=2, max_size=8, unique=True),
    st.sampled_from([0.9, 0.95, 0.98]),
)
def test_boundary_cases_lie_on_their_ellipse(sex, chosen, share):
    boundary = boundary_cases(ANSUR2, sex, share=share, measures=chosen)
    scores = scores_of(ANSUR2, sex)
    people = boundary.people.of(chosen)
    columns = scores.columns(chosen)
    z = scores.to_scores(people.measures, columns)
    variance = np.linalg.eigvalsh(scores.correlation[np.ix_(columns, columns)])[::-1][:2]
    far = np.hypot(*(z @ boundary.axes.T / np.sqrt(variance)).T)
    assert far == pytest.approx(np.full(8, boundary.radius), abs=1e-6)


def test_boundary_cases_of_nonsense_are_refused():
    for wrong in (
        {"share": 1},
        {"share": 0},
        {"measures": ["stature"]},
        {"measures": ["stature", "height"]},
    ):
        with pytest.raises(InputError):
            boundary_cases(ANSUR2, "male", **wrong)


@given(sexes, st.integers(0, 99))
def test_the_conditional_mean_given_everything_is_itself(sex, seed):
    person = draw_people(ANSUR2, 1, seed=seed, men=float(sex == "male"))
    whole = dict(zip(person.names, person.measures.T, strict=True))
    told = conditional_distribution(scores_of(ANSUR2, sex), whole)
    assert np.array_equal(told.values, person.measures)
    assert np.all(told.covariance == 0) and np.abs(told.spread).max() < 1e-12


@given(sexes, st.lists(measures, max_size=10, unique=True), st.floats(1, 99))
def test_a_conditional_covariance_is_symmetric_and_positive_semidefinite(sex, chosen, p):
    row = percentile_values(ANSUR2, sex, p)[0]
    told = conditional_distribution(
        scores_of(ANSUR2, sex), {name: row[ANSUR2.names.index(name)] for name in chosen}
    )
    assert np.array_equal(told.covariance, told.covariance.T)
    assert np.linalg.eigvalsh(told.covariance).min() > -1e-9
    assert np.diag(told.covariance).max() <= 1 + 1e-12


def test_given_nothing_everybody_is_at_the_median():
    told = conditional_distribution(scores_of(ANSUR2, "female"), {})
    assert told.values == pytest.approx(percentile_values(ANSUR2, "female", 50))


def test_a_conditional_mean_of_real_people_is_the_surveys_regression(raw):
    """Buttock-knee length = 161.4 + .4839 stature - .5016 sitting height + .7876 kg, residual 11.4
    mm."""
    told = conditional_distribution(
        scores_of(raw, "male"), {"stature": [1.8, 1.7], "sitting_height": 0.92, "mass": 90}
    )
    knee = raw.names.index("buttock_knee_length")
    want = 161.4 + 0.4839 * np.array([1800, 1700]) - 0.5016 * 920 + 0.7876 * 90
    assert told.values[:, knee] * 1000 == pytest.approx(want, abs=0.3)
    assert told.spread[0, knee] * 1000 == pytest.approx(11.4, abs=0.1)


def test_a_contradiction_is_named_by_its_measure():
    mix = {"stature": 1.755, "eye_height_sitting": 0.804, "sitting_height": 0.804}
    told = mahalanobis_distance(scores_of(ANSUR2, "male"), mix)
    assert told.worst()[0] == "sitting_height" and told.worst()[1] < -9
    assert abs(told.z[0]).argmax() == 2 and told.rarer[0] < 1e-9


def test_improbability_of_one_measure_is_its_score():
    told = mahalanobis_distance(
        scores_of(ANSUR2, "male"), {"stature": percentile_values(ANSUR2, "male", [50, 95])[:, 0]}
    )
    assert told.z[:, 0] == pytest.approx([0, 1.644854], abs=1e-6)
    assert np.allclose(told.surprise, told.z) and np.allclose(told.distance, np.abs(told.z[:, 0]))
    assert told.rarer == pytest.approx([1, 0.1])


@pytest.mark.parametrize(
    "wrong", [{"height": 1.8}, {"stature": -1.8}, {"stature": [1.7, 1.8], "span": [1, 2, 3]}]
)
def test_given_measures_that_make_no_sense_are_refused(wrong):
    with pytest.raises(InputError):
        conditional_distribution(scores_of(ANSUR2, "male"), wrong)
