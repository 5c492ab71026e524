"""Figures of reports: none reads like its limit, parts of a whole add to 100, caps are no
measurements, and percentiles are those of one sex."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.accommodations import made, trainer_people
from tests.one_arm_cab import STUDY, changed, write_cab
from tests.test_accommodation_page import FLAPS, page_of, text_of
from tests.test_study import criterion
from workbench.body.people.proportions import percent_parts
from workbench.model.accommodation import Requirement
from workbench.model.result import Finding, Shortfall, Verdict
from workbench.report.criteria import (
    asked_words,
    measured_words,
    spare_words,
)
from workbench.report.page import page as report_page
from workbench.report.result_rows import result_file, verdict_row
from workbench.report.sentences import verdict_sentence

NUMBER = re.compile(r"\d+\.\d+")


@pytest.fixture(scope="module")
def cab(tmp_path_factory):
    """The result of two people in a cab."""
    return wb.run(wb.load_study(write_cab(tmp_path_factory.mktemp("cab"))))


def failed(check, value, limit, unit="m"):
    """A criterion that fails by one finding. value, limit [mm or degrees]."""
    factor = 0.001 if unit == "m" else float(np.radians(1.0))
    found = Finding(
        case="flying",
        person="pilot",
        other_person="",
        subject="head",
        target="canopy",
        value=factor * value,
        limit=factor * limit,
        unit=unit,
    )
    return Verdict(criterion(check), False, found, (found,))


@given(
    st.sampled_from(["contact", "clearance", "stops", "reach", "self_contact"]),
    st.integers(-300, 300),
    st.floats(2e-6, 0.2),
)
def test_no_figure_of_a_criterion_that_fails_reads_like_its_limit(check, limit, by):
    limit = {"contact": -abs(limit), "self_contact": -abs(limit), "reach": 0}.get(check, limit)
    verdict = failed(check, limit - by, limit, "rad" if check == "stops" else "m")
    row = verdict_row(verdict)
    (measured,) = NUMBER.findall(measured_words(row))
    assert float(measured) != abs(limit)
    assert float(NUMBER.findall(spare_words(row))[0]) == pytest.approx(by, abs=6e-2, rel=0.5)
    assert float(NUMBER.findall(spare_words(row))[0]) > 0
    said = float(NUMBER.findall(verdict_sentence(verdict))[0])
    assert said == pytest.approx(abs(limit - by), abs=0.051) and said != abs(limit)


@given(st.floats(1, 300), st.floats(2e-6, 0.2))
def test_what_is_measured_asked_and_lacking_agree_as_they_are_printed(limit, by):
    verdict = failed("clearance", limit - by, limit)
    figures = NUMBER.findall(verdict_sentence(verdict))
    measured, lacking, asked = map(float, figures)
    step = 10.0 ** -min(len(figure.split(".")[1]) for figure in figures)
    assert measured < asked and asked - measured == pytest.approx(lacking, abs=1.01 * step)
    row = verdict_row(verdict)
    assert asked_words(row) == f"at least {figures[2]}\u00a0mm"


def test_what_is_a_hair_beyond_its_limit_is_told_finely_and_all_else_to_a_tenth():
    row = verdict_row(failed("contact", -30.04, -30.0))
    assert (measured_words(row), asked_words(row)) == (
        "30.04\u00a0mm deep",
        "at most 30.00\u00a0mm deep",
    )
    assert spare_words(row) == "0.04\u00a0mm"
    assert "0.0001 degrees past its stop" in verdict_sentence(failed("stops", -6e-5, 0, "rad"))
    assert measured_words(verdict_row(failed("clearance", 12.34, 50))) == "12.3\u00a0mm"


@given(st.lists(st.integers(1, 400), min_size=2, max_size=6), st.sampled_from([1, 3, 200, 7000]))
def test_the_parts_of_a_whole_add_to_100(parts, count):
    shares = [part / sum(parts) for part in parts]
    words = percent_parts(shares, count)
    if not any(word.startswith(("under", "over")) for word in words):
        assert sum(float(word.removesuffix(" %")) for word in words) == pytest.approx(100)
    for share, word in zip(shares, words, strict=True):
        assert float(NUMBER.findall(word.replace(" %", ".0"))[0] if count < 500 else 0) == (
            pytest.approx(100 * share, abs=1.0) if count < 500 else 0
        )


def test_certain_undecided_and_out_add_to_100():
    assert percent_parts((0.79, 0.105, 0.105), 200) == ["79 %", "11 %", "10 %"]
    assert percent_parts((0.7867, 0.1067, 0.1066), 150) == ["79 %", "11 %", "10 %"]
    assert percent_parts((0.5, 0.5, 0.0), 10) == ["50 %", "50 %", "0 %"]


def test_margins_that_were_looked_for_no_farther_are_marked_and_measured_ones_are_not():
    knee = Requirement("knee to panel", "knee to panel", "clearance", "instrument_panel")
    pedals = Requirement("pedals", "pedals", "pedals", "")
    margin = np.array([[0.2, 0.2, 0.001]] * 10)
    found = made(trainer_people(10), [FLAPS, knee, pedals], margin)
    asks = tuple(
        replace(one, at_most=0.001) if one.check == "pedals" else one
        for one in found.study.criteria
    )
    html = page_of(replace(found, study=replace(found.study, criteria=asks)))
    rows = dict.fromkeys(("reach flaps", "knee to panel", "pedals"))
    table = html[html.index("Every requirement, with the criterion") :]
    for name in rows:
        cells = text_of(table[table.index(f'<th scope="row">{name}') :].split("</tr>")[0])
        rows[name] = cells.split()[-5:]
    assert rows["reach flaps"] == ["≥200"] * 5
    assert rows["knee to panel"] == ["200"] * 5
    assert rows["pedals"] == ["≥1"] * 5


def test_percentiles_of_people_are_those_of_women_and_of_men():
    people = trainer_people(60)
    found = made(people, [FLAPS], np.full((60, 1), 0.05))
    text = text_of(page_of(found))
    for code, whose in enumerate(("men", "women")):
        tall = 1000 * people.column("stature")[people.sex == code]
        wanted = " ".join(f"{value:,.0f}" for value in np.percentile(tall, (1, 5, 50, 95, 99)))
        assert f"stature {whose} mm {wanted}" in text


SHORT = (
    Shortfall(
        "anna", "down", "eyes", "the eyes stay 56 mm below left_design_eye", "why: so", 0.056
    ),
    Shortfall("bert: 2nd", "a: b", "seat", "the pedals are 80 mm too far", "", 0.08),
)


@given(st.lists(st.sampled_from(SHORT), max_size=5))
def test_the_headline_says_how_many_aims_are_missed_and_the_one_by_most(cab, short):
    """Whatever stands in the names of people and cases."""
    found = replace(cab.postures[0], short=tuple(short))
    said = result_file(replace(cab, postures=(found,))).headline
    first = said.split(" The tightest gap ")[0]
    assert first.startswith("2 people in 2 cases: all 5 criteria hold, ")
    count = (
        "one aim of the predicted postures is"
        if len(short) == 1
        else f"{len(short)} aims of the predicted postures are"
    )
    assert (f"hold, but {count} missed" in first) == bool(short) and "why" not in first
    if SHORT[1] in short:
        assert first.endswith(": the pedals are 80 mm too far (a: b, bert: 2nd).")
    elif short:
        assert first.endswith(": the eyes stay 56 mm below left design eye (down, anna).")


def test_a_headline_is_three_sentences_however_much_falls_short(cab):
    found = replace(cab.postures[0], short=SHORT * 20, warnings=("much is missing",) * 40)
    said = result_file(replace(cab, postures=(found,), warnings=found.warnings)).headline
    assert said.count(". ") <= 2 and len(said) < 500


def holds(check, value, limit=0.0):
    """A criterion that holds, with what is nearest to its limit [mm]."""
    return replace(failed(check, value, limit), passed=True, breaches=())


def named(verdict, name):
    return replace(verdict, criterion=replace(verdict.criterion, name=name))


def outcome(cab, *verdicts):
    """What the headline says of verdicts, before gaps and overlaps."""
    found = replace(cab.postures[0], verdicts=verdicts)
    said = result_file(replace(cab, postures=(found,), verdicts=verdicts)).headline
    return said.split(" The tightest gap ")[0].removeprefix("2 people in 2 cases: ")


def test_the_body_with_itself_decides_only_where_nothing_else_was_measured(cab):
    own, stop = holds("self_contact", 0.9), holds("stops", 0.5)
    assert outcome(cab, own, stop, holds("clearance", 3.7, 2.0)) == (
        "all 3 criteria hold, nearest to its limit, apart from allowed contacts and the body's own "
        "overlaps and joint stops, “clearance”: head is 3.7 mm from canopy, 1.7 mm more than the 2.0 "
        "mm asked for (flying, pilot)."
    )
    assert "hold, nearest to its limit “clearance”" in outcome(
        cab, holds("self_contact", 1.9), holds("clearance", 3.7, 2.0)
    )
    assert "“stops”" in outcome(cab, own, stop)
    grip = holds("contact", -29, -30)
    assert "joint stops, “clearance”" in outcome(cab, grip, holds("clearance", 30, 25))
    assert outcome(cab, grip).startswith("“contact” holds: head is 29.0 mm into canopy (30.0 mm")


def test_a_passed_verdict_that_the_surface_could_turn_is_told_with_it_and_not_green(cab):
    sure = holds("clearance", 30, 25)
    found = replace(sure.worst, surface_known_to=0.0062)
    open_ = replace(sure, worst=found, doubtful=found)
    assert "head is 30.0 ± 6 mm from canopy, 5.0 mm more than" in outcome(cab, open_)
    badges = []
    for verdicts in ((sure,), (sure, open_)):
        result = replace(cab, verdicts=verdicts, warnings=())
        html = report_page(result, result_file(result))
        badges.append(re.search(r'class="badge([^"]*)">([^<]*)<', html).groups())
    assert badges == [("", "PASSED"), (" warned", "PASSED, 1 in doubt")]


def test_the_headline_says_how_many_criteria_fail_and_the_number_that_decides(cab):
    knees = named(failed("clearance", 20, 25), "knees")
    head, belly = named(failed("contact", -12, 0), "head"), named(holds("contact", 30), "belly")
    far = "head is 12.0 mm into canopy (flying, pilot)."
    assert outcome(cab, belly, knees, head) == f"2 of 3 criteria fail, the worst “head”: {far}"
    assert outcome(cab, belly, head) == f"1 of 2 criteria fails, “head”: {far}"
    assert outcome(cab, head) == f"“head” fails: {far}"
    assert outcome(cab, belly) == "“belly” holds: head is 30.0 mm from canopy (flying, pilot)."
    assert outcome(cab) == "no criterion is asked."


def test_the_headline_names_parts_in_words(cab):
    result = cab
    (found,) = result.postures
    parts = tuple(f"the_{name}" for name in found.environment.parts)
    renamed = replace(found, environment=replace(found.environment, parts=parts))
    headline = result_file(replace(result, postures=(renamed,))).headline
    assert "The tightest gap is " in headline and " from the " in headline
    assert "_" not in headline and "polygon" not in headline


def test_a_posture_that_differs_from_the_first_case_is_told_by_its_joints(tmp_path):
    study = changed(
        STUDY,
        "      bert: {posture: bent}\ncriteria",
        "      bert: {posture: hanging, angles: {ELBOW: {flexion: 20}}}\ncriteria",
    )
    page = page_of_result(wb.run(wb.load_study(write_cab(tmp_path, study=study))))
    assert "with other angles at" in page and "otherwise" not in page


def page_of_result(result):
    return text_of(report_page(result, result_file(result)))


ADULT = """study: adult
title: An adult in the cab
length: mm
environment: cab
people:
  anna: {body: adult_female, detail: coarse, at: {segment: LT, position: [0, 0, 100]}}
cases: [{name: standing, people: {anna: {posture: standing}}}]
criteria: [{name: head to wall, check: clearance, segments: [H], parts: [wall], at_least: 10}]
"""


def test_how_well_a_surface_is_known_stands_with_the_person_the_figure_and_the_method(tmp_path):
    result = wb.run(wb.load_study(write_cab(tmp_path, study=ADULT)))
    body = result.postures[0].people[0].body
    worst = 1000 * np.nanmax(body.fit_error)
    text = page_of_result(result)
    assert f"kg, surface known to ± {worst:.0f} mm" in text
    assert "is stated for adult female" in text and "is not stated for" not in text
    assert re.search(r"\d ± \d+.mm", text)
    bare = text_of(page_of(made(trainer_people(2), [FLAPS], np.full((2, 1), 0.1))))
    assert "±" not in bare
