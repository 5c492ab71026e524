"""Measured people and people like them: the survey's rows are the default population, and joint
shares of synthetic people are those of the rows."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ROOT, SHARED, real_input
from tests.population_shares import (
    RULES,
    chance_rules,
    held_out,
    joint_shares,
    likeliest_freedom,
    synthetic,
    t_copula,
)
from tests.toy_cockpit import write_toy
from workbench import InputError, UsageError, draw_people, load_population_model, load_study
from workbench import read_ansur as read_rows
from workbench.cli import main
from workbench.model.population import SEXES, Population

RAW = [
    SHARED / "anthropometry" / "ansur2" / f"ANSUR_II_{sex}_Public.csv" for sex in ("MALE", "FEMALE")
]
ANSUR2 = load_population_model("ansur2")
EVERYBODY = ANSUR2.people
COCKPIT_LIMITS = {
    "sittingheight": (860, 977),
    "eyeheightsitting": (750, 860),
    "buttockkneelength": (569, 669),
    "kneeheightsitting": (512, 602),
    "thumbtipreach": (742, 878),
    "thighclearance": (0, 205),
}
"""Limits [mm] in the columns of the public files: what a cockpit for most men asks."""
LATER = pytest.mark.nightly


def population_of(folder, people):
    """The population of the one role of a study, where this stands in its file."""
    study = load_study(write_toy(folder, swap={"people: 10, seed: 3": people}))
    return study.roles[0].population


def same_people(one, two):
    return one.labels == two.labels and np.array_equal(one.measures, two.measures)


def test_the_people_that_come_along_are_those_of_the_public_files_bit_by_bit():
    raw = read_rows(*map(real_input, RAW), measures=ANSUR2.names)
    assert len(EVERYBODY) == len(raw) == 6068
    assert same_people(EVERYBODY, raw) and np.array_equal(EVERYBODY.sex, raw.sex)


def test_the_table_that_comes_along_holds_the_cells_of_the_public_files():
    tables = [
        list(csv.DictReader(real_input(path).read_text(encoding="latin-1").splitlines()))
        for path in RAW
    ]
    want = [{name.lower(): cell for name, cell in row.items()} for rows in tables for row in rows]
    shipped = (ROOT / "bodies" / "populations" / "ansur2.csv").read_text().splitlines()
    found = list(csv.DictReader(shipped))
    assert len(found) == len(want) and len(found[0]) == 59
    assert all(
        row[name] == cell
        for row, mine in zip(want, found, strict=True)
        for name, cell in mine.items()
    )


def test_who_of_the_default_population_is_inside_limits_is_counted_in_the_public_files(tmp_path):
    inside = 0
    for path in RAW:
        for row in csv.DictReader(real_input(path).read_text(encoding="latin-1").splitlines()):
            inside += all(low <= int(row[k]) <= high for k, (low, high) in COCKPIT_LIMITS.items())
    people = population_of(tmp_path, "people: all")
    names = {name.replace("_", ""): name for name in people.names}
    columns = [1000 * people.column(names[k]) for k in COCKPIT_LIMITS]
    limits = COCKPIT_LIMITS.values()
    met = [
        (x > low - 0.5) & (x < high + 0.5) for x, (low, high) in zip(columns, limits, strict=True)
    ]
    assert np.all(met, axis=0).sum() == inside and 1000 < inside < 5000


def test_all_people_are_the_6068_measured_ones_and_all_women_1986(tmp_path):
    everybody = population_of(tmp_path, "people: all")
    assert same_people(everybody, EVERYBODY) and repr(everybody).startswith(
        "Population(ansur2: 4082 men"
    )
    women = population_of(tmp_path, "people: all, sexes: [female]")
    assert len(women) == 1986 and set(women.sex) == {1}


def test_people_who_are_drawn_were_measured_and_nobody_is_drawn_twice():
    drawn = draw_people(ANSUR2, 300, seed=5, men=0.4)
    assert (drawn.sex == 0).sum() == 120 and len(set(drawn.labels)) == 300
    rows = [EVERYBODY.labels.index(label) for label in drawn.labels]
    assert np.array_equal(EVERYBODY.measures[rows], drawn.measures)
    assert np.array_equal(EVERYBODY.sex[rows], drawn.sex)


def test_as_many_as_were_measured_are_everybody():
    drawn = draw_people(ANSUR2, 6068, seed=1, men=4082 / 6068)
    assert sorted(drawn.labels) == sorted(EVERYBODY.labels)


@pytest.mark.parametrize("options", [{}, {"synthetic": True}, {"given": {"stature": 1.6}}])
def test_the_same_seed_gives_the_same_people_and_more_of_them_begin_with_these(options):
    few, again, many = (draw_people(ANSUR2, n, seed=9, **options) for n in (6, 6, 60))
    assert same_people(few, again)
    women = many.of_sex("female").rows(np.arange(3)), few.of_sex("female")
    for more, less in ((many.rows(np.arange(3)), few.rows(np.arange(3))), women):
        assert np.allclose(more.measures, less.measures, rtol=0, atol=1e-12)
        assert more.labels == less.labels
    assert not np.array_equal(draw_people(ANSUR2, 6, seed=10, **options).measures, few.measures)


def test_who_is_drawn_is_a_fair_sample():
    """200 draws of 50 men: the share under the median of stature is one half within 3 errors."""
    men = EVERYBODY.of_sex("male")
    middle = np.median(men.column("stature"))
    below = np.mean(men.column("stature") < middle)
    shares = [
        np.mean(draw_people(men, 50, seed=seed, men=1.0).column("stature") < middle)
        for seed in range(200)
    ]
    assert np.mean(shares) == pytest.approx(below, abs=3 * 0.5 / np.sqrt(50 * 200))


@pytest.mark.parametrize(
    ("people", "told"),
    [
        (
            "people: 6068, seed: 1",
            "people: ansur2 has 1986 women (3034 are asked for); ask for fewer, for another share "
            "of 'women', or write 'synthetic: true'",
        ),
        (
            "people: 9000, seed: 1",
            "people: ansur2 has 4082 men (4500 are asked for) and 1986 women (4500 are asked for)",
        ),
        ("people: 2000, seed: 1, sexes: [female]", "ansur2 has 1986 women (2000 are asked for)"),
        ("people: all, seed: 1", "'seed', 'women' and 'synthetic' belong to people who are drawn"),
        ("people: all, women: 50", "mixes of the sexes are asked for under 'shares'"),
        ("people: all, synthetic: true", "'people: all' are the measured people as they are"),
        ("source: ansur2", "'people: all' are all who were measured"),
        ("people: 10", "need 'people', how many, and a 'seed'"),
        ("files: [a.csv], synthetic: true", "'files' have people of their own"),
    ],
)
def test_people_that_a_study_cannot_have_are_refused_with_what_to_write(tmp_path, people, told):
    with pytest.raises(InputError) as error:
        population_of(tmp_path, people)
    assert any(told in line for line in error.value.problems), error.value.problems


def test_as_many_synthetic_people_as_one_likes_may_be_asked_for(tmp_path):
    drawn = population_of(tmp_path, "people: 9000, seed: 1, synthetic: true")
    assert drawn.synthetic and drawn.people == 9000


def test_more_than_were_measured_are_refused_in_python_and_on_the_command_line(capsys):
    with pytest.raises(UsageError, match=r"1986 women \(3034 are asked for\).*synthetic people"):
        draw_people(ANSUR2, 6068, seed=1)
    assert main(["people", "draw", "--count", "6068"]) == 2
    assert "synthetic people" in capsys.readouterr().err
    line = ["people", "draw", "--count", "6068", "--synthetic", "--measures", "stature"]
    assert main(line) == 0
    assert "ansur2, synthetic, drawn with seed 1, female" in capsys.readouterr().out


@pytest.mark.parametrize("sex", SEXES)
def test_synthetic_people_have_the_recorded_values_each_as_often_as_measured(sex):
    survey = EVERYBODY.of_sex(sex)
    drawn = synthetic(survey, 20_000, 3)
    for name in survey.names:
        values = np.unique(survey.column(name))
        assert np.isin(drawn.column(name), values).all(), name
        at_most = [
            np.searchsorted(np.sort(people.column(name)), values, side="right") / len(people)
            for people in (survey, drawn)
        ]
        assert np.abs(at_most[0] - at_most[1]).max() < 0.02, name


def test_nobody_synthetic_is_a_measured_person_again():
    men = EVERYBODY.of_sex("male")
    drawn = synthetic(men, 500, 3)
    spread = men.measures.std(axis=0)
    apart = [np.abs((men.measures - row) / spread).max(axis=1).min() for row in drawn.measures]
    assert min(apart) > 0.2


@pytest.mark.parametrize("sex", SEXES)
def test_joint_shares_of_synthetic_people_are_the_surveys_within_a_point(sex):
    survey = EVERYBODY.of_sex(sex)
    drawn = synthetic(survey, 40_000, 1)
    off = joint_shares(drawn, survey, RULES) - joint_shares(survey, survey, RULES)
    assert np.abs(off).max() < 1, RULES[int(np.abs(off).argmax())].name


@LATER
@pytest.mark.parametrize("sex", SEXES)
def test_synthetic_people_of_one_half_of_the_survey_have_the_joint_shares_of_the_other(sex):
    """20 random halves, both ways round. The mean error of every rule is under a point, and that
    of a single split is no more than what parts the halves themselves."""
    survey = EVERYBODY.of_sex(sex)
    rules = (*RULES, *chance_rules(100, survey.names, 1))
    found = held_out(survey, rules, synthetic, splits=20, count=20_000, seed=1)
    assert np.abs(found.mean[: len(RULES)]).max() < 0.75
    assert np.abs(found.mean).max() < 1
    assert np.mean(found.rms / found.halves) < 1.1


@LATER
def test_the_likelihood_finds_the_degrees_of_freedom_that_people_were_drawn_with():
    men = EVERYBODY.of_sex("male").of(ANSUR2.names[:12])
    drawn = t_copula(men, 4000, 1, freedom=12)
    assert likeliest_freedom(drawn, (4, 6, 8, 12, 20, 40, 200)) == 12


@pytest.mark.parametrize(
    "given",
    [
        {"stature": 1.755},
        {"stature": 1.6, "mass": 95.0},
        {"stature": 1.9, "sitting_height": 0.96, "mass": 80.0},
        {name: float(row) for name, row in zip(ANSUR2.names, EVERYBODY.measures[17], strict=True)},
    ],
)
def test_what_is_given_is_what_everybody_has_to_the_last_bit(given):
    drawn = draw_people(ANSUR2, 50, seed=2, given=given)
    for name, value in given.items():
        assert (drawn.column(name) == value).all(), name
    assert len(np.unique(drawn.measures, axis=0)) > 1 or len(given) == len(ANSUR2.names)


@pytest.mark.parametrize("value", [1.60, 1.755, 1.88])
def test_people_of_a_given_stature_are_those_of_that_stature_among_all(value):
    """Of 200,000 synthetic men those within 3 mm, against 20,000 who are given the stature: means
    and spreads of other measures agree within 5 standard errors."""
    many = draw_people(ANSUR2, 200_000, seed=1, men=1.0, synthetic=True)
    found = many.rows(np.abs(many.column("stature") - value) < 0.0035)
    told = draw_people(ANSUR2, 20_000, seed=2, men=1.0, given={"stature": value})
    assert len(found) > 500
    for name in ("mass", "sitting_height", "thumb_tip_reach", "waist_circumference", "head_length"):
        one, two = found.column(name), told.column(name)
        error = one.std() / np.sqrt(len(one))
        assert one.mean() == pytest.approx(two.mean(), abs=5 * error), name
        assert one.std() == pytest.approx(two.std(), rel=5 / np.sqrt(2 * len(one))), name


def test_people_given_what_hardly_anybody_has_still_differ():
    """A man of 1.50 m and 110 kg is nobody's neighbour: the spread is that of others, not none."""
    odd = draw_people(ANSUR2, 2000, seed=1, men=1.0, given={"stature": 1.50, "mass": 110.0})
    usual = draw_people(ANSUR2, 2000, seed=1, men=1.0, given={"stature": 1.755, "mass": 85.0})
    for name in ("sitting_height", "thumb_tip_reach", "biacromial_breadth"):
        assert odd.column(name).std() > 0.5 * usual.column(name).std(), name


@pytest.mark.parametrize("given", [{"stature": 17.0}, {"height": 1.7}, {"stature": -1.0}])
def test_a_given_measure_that_nobody_has_is_refused(given):
    with pytest.raises(InputError):
        draw_people(ANSUR2, 3, seed=1, given=given)


def test_figures_without_people_are_drawn_from_but_have_nobody(tmp_path):
    text = (ROOT / "bodies" / "populations" / "ansur2.yaml").read_text()
    (tmp_path / "figures.yaml").write_text(text.replace("people: ansur2.csv\n", ""))
    figures = load_population_model(tmp_path / "figures.yaml")
    assert figures.people is None
    assert draw_people(figures, 4, seed=1).labels == ("male 1", "male 2", "female 1", "female 2")
    assert population_of(tmp_path, "source: ../figures.yaml, people: 9000, seed: 1").people == 9000
    with pytest.raises(InputError, match=r"figures without measured people: say how many 'people'"):
        population_of(tmp_path, "source: ../figures.yaml, people: all")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda rows: rows[:-1],
            r"ansur2.yaml:\d+:\d+: female.count: .*has 1985 female people \(got 1986\)",
        ),
        (
            lambda rows: [rows[0], rows[1].replace("1776", "17760"), *rows[2:]],
            "ansur2.csv:2: stature: 17760 mm is absurd",
        ),
        (
            lambda rows: [row.rpartition(",")[0] for row in rows],
            "missing columns: wristcircumference",
        ),
        (None, "people: no such file 'ansur2.csv'"),
    ],
)
def test_people_who_do_not_fit_their_figures_are_refused(tmp_path, change, told):
    home = ROOT / "bodies" / "populations"
    (tmp_path / "ansur2.yaml").write_text((home / "ansur2.yaml").read_text())
    if change is not None:
        rows = (home / "ansur2.csv").read_text().splitlines()
        (tmp_path / "ansur2.csv").write_text("\n".join(change(rows)) + "\n")
    with pytest.raises(InputError, match=told):
        load_population_model(tmp_path / "ansur2.yaml")
    assert load_population_model(tmp_path / "ansur2.yaml", people=False).people is None


def test_a_model_keeps_only_people_of_its_own_measures_and_numbers():
    with pytest.raises(InputError, match="same measures in the same order"):
        replace(ANSUR2, people=EVERYBODY.of(ANSUR2.names[1:]))
    with pytest.raises(InputError, match="4082 male people are counted, and 4081 are there"):
        replace(ANSUR2, people=EVERYBODY.rows(np.arange(1, 6068)))


def test_people_of_ones_own_are_drawn_from_as_they_are():
    five = Population(
        ("stature",), np.zeros(5), np.ones(5), np.arange(1.6, 1.85, 0.05)[:, None], "five"
    )
    drawn = draw_people(five, 3, seed=1, men=1.0)
    assert len(np.unique(drawn.measures)) == 3 and np.isin(drawn.measures, five.measures).all()
    assert drawn.source == "five, drawn with seed 1"
