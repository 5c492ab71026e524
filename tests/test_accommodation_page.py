"""The page of an accommodation study: words, charts, maps, and odd results that must not break
it."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.accommodations import (
    few,
    made,
    panel_map,
    result_of,
    trainer,
    trainer_accommodation,
    trainer_people,
)
from workbench.body.people.proportions import percent, percent_number
from workbench.draw.contours import kernel_regression, level_loops, median_spacing
from workbench.draw.reach_map import LEVELS, map_controls, reach_map_svg
from workbench.model.accommodation import DesignChange, Requirement
from workbench.model.criterion import NO_REASON, TOO_SHORT, Reason
from workbench.model.units import UNITS
from workbench.report.page import page
from workbench.report.population.charts import (
    bar,
    margin_axis,
    margin_range,
    margin_strip,
    share_axis,
    whisker,
)
from workbench.report.population.rows import population_lines, population_rows
from workbench.report.population.sentences import (
    gain_sentence,
    limiting_words,
    person_sentence,
    population_headline,
    reason_words,
    requirement_sentence,
    spare_words,
)
from workbench.report.result_rows import result_file

FLAPS = Requirement("reach flaps", "engine and cabin", "reach", "flaps", 2)
KNEE = Requirement("right knee clear of the panel", "room", "clearance", "instrument_panel")


class Balanced(HTMLParser):
    """Fails where tags are not closed in order."""

    VOID = {"meta", "img", "br", "hr", "link", "input"}

    def __init__(self):
        super().__init__()
        self.open = []
        self.ids = []
        self.links = []

    def handle_starttag(self, tag, attrs):
        self.ids += [v for k, v in attrs if k == "id"]
        self.links += [v for k, v in attrs if k in ("href", "src")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.ids += [v for k, v in attrs if k == "id"]

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag


def parsed(html):
    read = Balanced()
    read.feed(html)
    assert read.open == []
    assert len(read.ids) == len(set(read.ids))
    assert all(link.startswith("data:image/png;base64,") or "/" not in link for link in read.links)
    return read


def text_of(html):
    return re.sub(r"\s+", " ", re.sub(r"<style>.*?</style>|<[^>]+>", " ", html, flags=re.DOTALL))


def page_of(found, *, files=()):
    """The page of a population that was made up."""
    result = result_of(found)
    return page(result, result_file(result), files=files)


@pytest.fixture(scope="module")
def usual():
    return trainer_accommodation(60)


@pytest.fixture(scope="module")
def ten():
    """Ten people, two requirements: flaps are missed by four, the knee by three, by one of them
    both."""
    people = trainer_people(10)
    flaps = np.array([-41, -20, -5, -1, 5, 10, 20, 30, 40, 50]) / 1000
    knee = np.array([-2, 1, 2, 3, -3, -12, 30, 40, 50, 60]) / 1000
    gain = DesignChange("moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.6, 0.9, 0.4, 0.7)
    return made(people, [FLAPS, KNEE], np.stack([flaps, knee], axis=1), gains=[gain], shown=True)


def test_the_terminal_says_once_that_no_single_requirement_lets_anybody_in():
    both = made(trainer_people(10), [FLAPS, KNEE], np.full((10, 2), -0.01))
    lines = population_lines(both)
    assert lines[:3] == [
        "    0 %  meet “reach flaps”",
        "    0 %  meet “right knee clear of the panel”",
        "Everybody who is left out misses two requirements or more: dropping a single requirement would gain nothing.",
    ]
    assert [line for line in lines if "%  " in line][2:] == [
        "    0 %  fit: everybody (95 % interval 0 to 28 %)"
    ]


def test_it_is_said_what_a_longer_move_would_enter_and_what_is_not_proposed_for_that():
    into = "letting the seat go 80 mm lower would put pan 18 mm into floor"
    words = "letting the seat go 62 mm lower"
    gain = DesignChange(words, "reach flaps", 0.062, 2.1, 0.6, 0.9, 0.4, 0.7, limit=into)
    found = made(trainer_people(10), [FLAPS], np.full((10, 1), -0.01), gains=[gain])
    found = replace(found, refused=("moving roof 9 mm up would put roof 9 mm into sky",))
    lines = population_lines(found)
    assert any(line.endswith(f" to 70 %. L{into[1:]}.") for line in lines)
    (refused,) = (line for line in lines if line.startswith("Not proposed: moving roof 9 mm up"))
    page = text_of(page_of(found))
    assert refused in page and f"L{into[1:]}." in page and "not looked at" not in page
    seats = tuple(replace(seat, moves=()) for seat in found.place.environment.seats)
    still = replace(found.place, environment=replace(found.place.environment, seats=seats))
    assert "was not looked at" in " ".join(population_lines(replace(found, place=still)))


def test_who_misses_more_in_one_position_may_fit_in_another_without_it():
    margin = np.full((10, 2), -0.01)
    margin[0] = 0.01
    found = made(trainer_people(10), [FLAPS, KNEE], margin)
    found = replace(found, without=np.array([1.0, 0.1]), only=np.zeros(2))
    said = population_headline(found)
    other = "but without it 100 % would fit in some other position of the seat)"
    assert f"(nobody misses only this, {other}" in said


def test_the_terminal_says_whom_one_requirement_alone_leaves_out(ten):
    lines = population_lines(ten)
    assert (
        lines[0] == "   60 %  meet “reach flaps” (30 % miss only this, without it 70 % would fit)"
    )
    assert lines[-1] == "   40 %  fit and overlap nothing by more than is allowed: everybody"


def test_the_headline_says_share_interval_and_what_leaves_out_most(ten):
    said = population_headline(ten)
    assert said == (
        "40 % of the population fits (95 % interval 17 to 69 %, 10 people); missed most often is "
        "“reach flaps”, by 40 % of the people (30 % miss only this). 40 % fit and overlap nothing by "
        "more than is allowed."
    )
    assert requirement_sentence(ten) == (
        "The requirement missed most often is “reach flaps”: by 40 % of the people. Dropping it would "
        "gain most: 70 % of the people meet all the others, 40 % meet all."
    )


@pytest.mark.parametrize(
    ("margins", "overlapping", "said"),
    [
        ((9, 9, 9, -9), (1, 3), "50 % fit and overlap nothing by more than is allowed."),
        ((9, 9, 9, 9), (1,), "75 % fit and overlap nothing by more than is allowed."),
        ((9, 9, 9, 9), (), "Nobody overlaps anything by more than is allowed."),
        ((9, 9, -9, -9), (0, 1), "All of them overlap something by more than is allowed."),
        ((9,), (0,), "The one person fits. The person overlaps something by more than is allowed."),
    ],
)
def test_the_headline_and_the_title_say_who_fits_and_is_clear(margins, overlapping, said):
    margin = np.array(margins)[:, None] / 1000
    found = made(trainer_people(len(margins)), [KNEE], margin, overlapping=overlapping)
    assert said in population_headline(found)
    clear = sum(m > 0 and p not in overlapping for p, m in enumerate(margins))
    assert sum(population_rows(found, "").people.clear) == clear
    fits = f"{sum(m > 0 for m in margins)} of {len(margins)} people fit"
    more = f", {clear} without overlap" if clear < sum(m > 0 for m in margins) else ""
    html = page_of(found)
    assert f": {fits}{more}</title>" in html
    assert f'data-label="without overlap">{percent(clear / len(margins), len(margins))}<' in html


def test_a_person_is_told_with_limb_millimetres_zone_limit_and_measure(ten):
    said = person_sentence(ten, 0)
    tall = 1000 * ten.people.column("stature")[0]
    assert said.startswith(
        f"A man of {tall:,.0f} mm (male 1): his right hand stays 41 mm short of flaps in zone 2, "
        "limited by the length of the arm. Of his measures that matter for this, the most unusual is "
        "thumb tip reach, "
    )
    assert said.endswith("1 more requirement is not met.")
    assert "the men here" not in said  # five men are too few to be compared with
    assert "women here have more" in person_sentence(trainer_accommodation(200, shown=False), 102)
    assert "right knee is 12 mm deep in instrument panel" in person_sentence(ten, 5)
    assert person_sentence(ten, 9).endswith("is met, “reach flaps” with 50 mm to spare.")


def test_the_five_hardest_stand_worst_first_and_each_has_a_picture(ten):
    html = page_of(ten)
    assert ten.hardest == (0, 1, 5, 2, 4)
    assert html.count('src="data:image/png') == 5
    assert "The five hardest cases" in html


@pytest.mark.parametrize(
    ("gain", "said"),
    [
        (
            DesignChange(
                "moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.881, 0.95, 0.813, 0.842
            ),
            "Moving flaps 32 mm aft takes “reach flaps” from 88.1 to 95.0 % and all requirements together from 81.3 to "
            "84.2 %.",
        ),
        (
            DesignChange(
                "moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.881, 0.95, 0.813, 0.813
            ),
            "Moving flaps 32 mm aft takes “reach flaps” from 88.1 to 95.0 % and leaves all requirements together at 81.3 %.",
        ),
        (
            DesignChange("x", "y", 0.01, 0.0, 0.5, 0.5, 0.25, 0.25),
            "X leaves “y” at 50.0 % and leaves all requirements together at 25.0 %.",
        ),
    ],
)
def test_a_gain_is_told_with_both_shares(gain, said):
    assert gain_sentence(gain, 500) == said


@pytest.mark.parametrize(
    ("share", "few", "many"),
    [
        (0.0, "0 %", "0.0 %"),
        (1.0, "100 %", "100.0 %"),
        (0.813, "81 %", "81.3 %"),
        (0.00001, "under 1 %", "under 0.1 %"),
        (0.99996, "over 99 %", "over 99.9 %"),
        (0.9996, "over 99 %", "over 99.9 %"),
        (1 - 1e-15, "100 %", "100.0 %"),
        (1e-16, "0 %", "0.0 %"),
        (0.9994, "over 99 %", "99.9 %"),
        (0.0006, "under 1 %", "0.1 %"),
        (-1e-17, "0 %", "0.0 %"),
        (0.005, "under 1 %", "0.5 %"),
        (0.995, "over 99 %", "99.5 %"),
        (0.0051, "1 %", "0.5 %"),
    ],
)
def test_a_share_is_never_rounded_to_all_or_nothing_and_has_tenths_from_500_people_on(
    share, few, many
):
    assert percent(share, 499) == few
    assert percent(share, 500) == many


@given(st.integers(0, 400), st.integers(1, 400))
def test_shares_of_who_is_in_and_who_is_out_read_as_100_together(out, more):
    count = out + more
    shares = out / count, 1 - out / count, sum([1 / count] * more)
    told_out, told_in, again = (int(percent_number(share, min(count, 499))) for share in shares)
    assert told_out + told_in == 100
    assert again == told_in


def test_a_difference_that_rounds_to_nothing_has_no_sign():
    assert [percent_number(share, 100) for share in (-0.004, 0.004, -0.016)] == ["0", "0", "-2"]


def test_the_limb_that_is_too_short_is_an_arm_or_a_leg():
    assert reason_words(TOO_SHORT, "right hand") == "the length of the arm"
    assert reason_words(TOO_SHORT, "left foot") == "the length of the leg"
    foot = replace(TOO_SHORT, foot="left foot")
    assert reason_words(foot) == "the left foot, the length of the leg"


@pytest.mark.parametrize(
    ("reason", "said"),
    [
        (Reason("part", "instrument_panel"), "instrument panel"),
        (Reason("words", "the seat's travel"), "the seat's travel"),
        (Reason("near", "left upper arm", at="left_sill"), "the left upper arm at left sill"),
        (Reason("words", "eyes too low"), "eyes too low"),
        (NO_REASON, ""),
        (Reason("part", "left_stick", share=0.304), "left stick hides 30.4 %"),
        (Reason("own", "own left hand"), "the body's own left hand"),
        (Reason("other", "pilot's left hand"), "pilot's left hand"),
        (Reason("outside", "outside the mirror", share=0.3), "30 % is outside the mirror"),
        (Reason("mirrored", "left_pane"), "mirrored by left pane"),
    ],
)
def test_each_kind_of_reason_has_its_words(reason, said):
    assert reason_words(reason) == said


@pytest.mark.parametrize(
    ("requirement", "reason", "said"),
    [
        (
            FLAPS,
            Reason("part", "instrument_panel"),
            "the reach stays 12 mm short of flaps in zone 2; instrument panel is in the way",
        ),
        (
            FLAPS,
            Reason("deep", "instrument_panel", at="arm"),
            "the reach stays 12 mm short of flaps in zone 2; on it the arm is that much too deep in "
            "instrument panel",
        ),
        (
            FLAPS,
            Reason("stop", "right elbow (flexion)"),
            "the reach stays 12 mm short of flaps in zone 2, limited by the right elbow (flexion)",
        ),
        (
            KNEE,
            Reason("near", "right lower leg (knee cap)", at="instrument_panel"),
            "her right lower leg (knee cap) is 12 mm deep in instrument panel",
        ),
        (KNEE, NO_REASON, "her body is 12 mm deep in instrument panel"),
        (
            Requirement("view over the nose", "v", "view_over", "coaming"),
            Reason("words", "eyes too low"),
            "her eyes are 12 mm too low for “view over the nose”",
        ),
        (
            Requirement("pedals", "s", "pedals", "left"),
            replace(TOO_SHORT, foot="left foot"),
            "her left foot stays 12 mm short of its pedal, limited by the length of the leg",
        ),
        (
            Requirement("pedals", "s", "pedals", "left"),
            Reason("words", "the seat stops too far back"),
            "“pedals” is missed by 12 mm (the seat stops too far back)",
        ),
        (
            Requirement("stops", "j", "stops", "joints"),
            Reason("stop", "neck pivot (flexion)"),
            "“stops” is missed by 3.4 degrees (the neck pivot (flexion))",
        ),
    ],
)
def test_each_kind_of_requirement_is_told_in_its_own_words(requirement, reason, said):
    result = made(
        trainer_people(1), [requirement], [[-0.012]], reason=np.array([[0 if reason else -1]])
    )
    assert f"): {said}. Of her " in person_sentence(replace(result, reasons=(reason,)), 0)


@pytest.mark.parametrize(
    ("short", "said"),
    [
        (-0.012, "her right knee is 12 mm too close to instrument panel"),
        (
            -0.064,
            "her right knee is 39 mm deep in instrument panel, 64 mm short of the clearance asked for",
        ),
    ],
)
def test_an_overlap_is_never_called_a_gap(short, said):
    # 25 mm are asked for: 12 mm less are 13 mm apart, 64 mm less are 39 mm deep
    made_up = made(trainer_people(1), [KNEE], [[short]], shown=True)
    asked = tuple(replace(c, at_least=0.025) for c in made_up.study.criteria)
    found = replace(made_up, study=replace(made_up.study, criteria=asked))
    assert said in person_sentence(found, 0)


def test_a_measure_that_half_of_the_people_have_is_not_called_unusual():
    people = trainer_people(200)
    women = np.flatnonzero(people.sex == 1)
    order = women[np.argsort(people.column("popliteal_height")[women])]
    found = made(people, [KNEE], np.full((200, 1), -0.01))
    found = replace(found, limiting=("popliteal_height",) * 200)
    assert limiting_words(found, order[len(order) // 2]) == ""
    told = limiting_words(found, order[0])
    assert "the most unusual is popliteal height" in told and "women here have more" in told


def test_the_page_is_whole_closed_and_the_same_each_time(usual):
    html = page_of(usual, files=["people.csv"])
    parsed(html)
    said = text_of(html)
    for part in (
        "Who fits",
        "What leaves people out",
        "Limiting dimensions",
        "Changes that would gain",
        "hardest cases",
        "Who reaches the instrument panel",
        "Margins",
        "All requirements",
        "Provenance",
        "Method and its limits",
    ):
        assert part in said
    assert '<a href="people.csv" download>' in html
    assert page_of(usual, files=["people.csv"]) == html
    assert not re.search(r"\b(nan|None|inf)\b", said)


def test_criteria_are_shares_of_people_who_meet_all_their_requirements(ten):
    html = page_of(replace(ten, shown=()))
    assert "engine and cabin: missed by 40 %, only this by 30 %" in html
    assert "room: missed by 30 %, only this by 20 %" in html


@pytest.mark.parametrize(
    ("margin", "said"),
    [
        (0.01, "Everybody fits (95 % interval 89 to 100 %, 30 people)."),
        (
            -0.01,
            "Nobody fits (95 % interval 0 to 11 %, 30 people). Nobody meets “reach flaps”: it is m",
        ),
    ],
)
def test_everybody_and_nobody(margin, said):
    result = made(trainer_people(30), [FLAPS], np.full((30, 1), margin))
    html = page_of(result)
    parsed(html)
    assert said in text_of(html)
    assert ("hardest case" in html) == (margin < 0)


def test_where_nobody_fits_the_headline_says_what_keeps_everybody_and_what_would_mend_it():
    flaps = -np.arange(11, 31) / 1000
    knee = np.repeat([-0.005, 0.02], [5, 15])
    people = trainer_people(20)
    gain = DesignChange("moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.0, 1.0, 0.0, 0.75)
    found = made(people, [FLAPS, KNEE], np.stack([flaps, knee], axis=1), gains=[gain])
    assert population_headline(found) == (
        "Nobody fits (95 % interval 0 to 16 %, 20 people). Nobody meets “reach flaps”: it is missed "
        "by 11 mm to 30 mm, limited most often by the length of the arm. Without “engine and cabin” "
        "75 % would fit. Moving flaps 32 mm aft takes "
        "“reach flaps” from 0 to 100 % and all requirements together from 0 to 75 %."
    )
    both = made(people, [FLAPS, KNEE], np.stack([flaps, flaps], axis=1))
    assert "who comes nearest to fitting misses “reach flaps” and “right" in (
        population_headline(both)
    )


def test_one_person_one_requirement_no_map_no_picture():
    result = made(trainer_people(1), [KNEE], [[-0.03]])
    html = page_of(result)
    parsed(html)
    assert "The one person does not fit; “right knee clear of the panel” is not met." in text_of(
        html
    )
    assert "The hardest case" in html
    assert "Who reaches" not in html
    assert "The one person fits." in text_of(page_of(made(trainer_people(1), [KNEE], [[0.0]])))


def test_margins_that_do_not_apply_are_no_misses():
    margin = np.full((8, 2), 0.02)
    margin[:, 1] = np.nan
    margin[0] = [-0.01, np.nan]
    html = page_of(made(trainer_people(8), [FLAPS, KNEE], margin))
    parsed(html)
    assert "applies to nobody" in html
    assert "88 % of the population fits" in text_of(html)


def test_names_are_text_and_never_markup():
    evil = Requirement("<script>alert(1)</script>", 'x" onload="y', "reach", "<b>&", 1)
    result = made(trainer_people(6), [evil], np.full((6, 1), -0.02), warnings=["<i>w"])
    strange = replace(
        result,
        reasons=(Reason("part", "<u>why"),) * 4,
        study=replace(result.study, title="<h1>t", description="a<b"),
    )
    html = page_of(strange, files=["a&b.csv"])
    parsed(html)
    for raw in ("<script>", 'onload="y', "<b>&", "<u>why", "<h1>t", "<i>w"):
        assert raw not in html
    assert "&lt;script&gt;" in html


def test_forty_requirements_and_a_name_of_two_hundred_letters():
    people = trainer_people(25)
    rng = np.random.default_rng(1)
    requirements = [
        Requirement(
            f"requirement {n} " + "long " * (40 if n == 3 else 0), f"c{n % 7}", "reach", f"t{n}", 1
        )
        for n in range(40)
    ]
    html = page_of(made(people, requirements, rng.normal(0.05, 0.04, (25, 40))))
    parsed(html)
    assert html.count("margins at 1, 5, 50, 95 and 99 %") == 40


def test_weights_count_in_every_share(ten):
    people = replace(ten.people, weight=np.array([7, 1, 1, 1, 1, 1, 1, 1, 1, 1.0]))
    result = made(people, ten.requirements, ten.margin)
    assert "room: missed by 56 %, only this by 12 %" in page_of(result)  # (7 + 1 + 1) / 16


def test_a_part_of_the_people_gives_a_page_too(usual):
    parsed(page_of(few(usual, [0, 3, 4])))


@given(st.lists(st.floats(-2, 2), min_size=5, max_size=5).map(sorted))
def test_a_strip_is_well_formed_and_inside_its_cell(values):
    spread_row = np.array(values)
    ends = margin_range(spread_row[None])
    assert ends[0] < 0 < ends[1]
    root = ElementTree.fromstring(margin_strip(spread_row, ends, said='a & "b"'))
    for shape in root.iter("rect"):
        left = float(shape.get("x").rstrip("%"))
        width = float(shape.get("width").rstrip("%"))
        assert left >= 0 and width >= 0 and left + width <= 100.16


def test_charts_of_nothing_are_empty_or_plain():
    assert margin_strip(np.full(5, np.nan), (-1, 1), said="") == ""
    assert margin_range(np.full((2, 5), np.nan)) == (-0.01, 0.01)
    for text in (
        bar(0, 0, most=0, said="x"),
        whisker(1, 1, 1, least=1, said="x"),
        share_axis(0.95),
        share_axis(0.0),
        margin_axis((-0.01, 0.01)),
    ):
        ElementTree.fromstring(text)


def test_a_bar_is_as_long_as_its_share():
    root = ElementTree.fromstring(bar(0.2, 0.05, most=0.4, said="x"))
    assert [r.get("width") for r in root.iter("rect")] == ["50.00%", "12.50%"]


def test_contours_of_a_cone_are_circles_and_of_a_full_field_its_border():
    row, column = np.mgrid[0:61, 0:81]
    loops = level_loops(-np.hypot(row - 30, column - 40.0), -20.0)
    assert len(loops) == 1
    assert np.hypot(*(loops[0] - [30, 40]).T) == pytest.approx(20, abs=0.01)
    border = level_loops(np.ones((3, 4)), 0.5)
    assert len(border) == 1
    assert border[0].min(axis=0).tolist() == [-0.5, -0.5]
    assert border[0].max(axis=0).tolist() == [2.5, 3.5]
    assert level_loops(np.zeros((3, 4)), 0.5) == []


def shoelace(loop):
    return 0.5 * float(
        np.sum(loop[:, 1] * np.roll(loop[:, 0], -1) - np.roll(loop[:, 1], -1) * loop[:, 0])
    )


@given(st.integers(0, 10_000), st.floats(0.1, 0.9))
def test_contours_hold_every_point_at_or_above_the_level_and_no_other(seed, level):
    field = np.random.default_rng(seed).random((7, 9))
    loops = level_loops(field, level)
    inside = sum(winding(loop, field.shape) for loop in loops) if loops else np.zeros(field.shape)
    assert np.array_equal(np.abs(inside) == 1, field >= level)
    assert np.all(np.abs(inside) <= 1)


def winding(loop, shape):
    """How often a loop goes round each grid point: even-odd by a ray just off the grid lines,
    signed by its area."""
    rows, columns = np.mgrid[0 : shape[0], 0 : shape[1]]
    out = np.zeros(shape)
    for (r0, c0), (r1, c1) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        crosses = (r0 > rows + 1e-7) != (r1 > rows + 1e-7)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = c0 + (rows + 1e-7 - r0) * (c1 - c0) / (r1 - r0)
        out += np.where(crosses & (at > columns), np.sign(r1 - r0), 0)
    return out


def test_spreading_keeps_constants_and_takes_the_nearest_far_out():
    points = np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]])
    places = np.array([[0.3, 0.6], [50, 50]])
    assert kernel_regression(points, np.full(4, 0.7), places, width=0.2) == pytest.approx(0.7)
    assert kernel_regression(points, np.arange(4.0), places, width=0.2)[1] == pytest.approx(3)
    assert median_spacing(points) == 1


def test_a_reach_map_shows_lines_with_their_shares_over_the_part():
    found = panel_map()
    svg = reach_map_svg(found, trainer())
    root = ElementTree.fromstring(svg)
    texts = ["".join(t.itertext()) for t in root.iter("{http://www.w3.org/2000/svg}text")]
    for level in LEVELS:
        assert f"{100 * level:.0f} %" in texts
    assert {c.name.replace("_", " ") for c in map_controls(found, trainer())} <= set(texts)
    assert len(map_controls(found, trainer())) > 20
    assert svg == reach_map_svg(found, trainer())


def test_a_map_measured_from_behind_is_seen_from_the_sitters_side():
    found = panel_map()
    sitter = trainer().seat("left").srp
    behind = replace(found, flat=found.flat * [-1, 1])
    assert reach_map_svg(behind, trainer(), sitter=sitter) == reach_map_svg(
        found, trainer(), sitter=sitter
    )
    assert reach_map_svg(behind, trainer()) != reach_map_svg(found, trainer())


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_map_of_one_share_has_one_colour_and_no_line_in_it(share):
    found = panel_map(count=200)
    flat = replace(found, share=np.full(len(found.share), share))
    root = ElementTree.fromstring(reach_map_svg(flat, trainer()))
    assert "50 %" not in [
        "".join(t.itertext()) for t in root.iter("{http://www.w3.org/2000/svg}text")
    ]


def test_a_map_of_a_single_point_is_drawn_too():
    found = panel_map()
    one = replace(
        found,
        points=found.points[:1],
        normals=found.normals[:1],
        flat=found.flat[:1],
        share=found.share[:1],
    )
    ElementTree.fromstring(reach_map_svg(one, trainer()))


def test_less_than_one_unit_to_spare_is_not_nothing():
    share = UNITS["share"]
    assert spare_words(0.002 * share.counts, share) == "0.2 % to spare"
    assert spare_words(0.0, share) == "nothing to spare"


@given(st.floats(0.0, 0.99))
def test_figures_on_the_axis_of_shares_stand_apart(least):
    # in print the column is 40 mm wide and "100 %" takes a quarter of that
    places = [float(x) for x in re.findall(r'<text x="([\d.]+)%"', share_axis(least))]
    assert 1 <= len(places) <= 4 and places[-1] == pytest.approx(96.0)
    assert all(b - a > 25 for a, b in itertools.pairwise(places))
