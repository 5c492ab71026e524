"""Between which margins the true ones lie, the surface of a body being known so well; who fits for
certain, and who is undecided."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import made, trainer_people
from tests.conftest import box_part, environment_of
from tests.crowds import Crowd
from tests.rows import changed
from tests.test_study import criterion, study
from tests.toy_cockpit import write_toy
from workbench.cli import main
from workbench.model.accommodation import OF_SURFACE, GroupShare, Requirement, certainty_of
from workbench.model.criterion import Criterion
from workbench.model.environment import Allowance
from workbench.report.population.rows import population_rows
from workbench.report.population.sentences import certainty_words, population_headline
from workbench.report.sentences import share_sentence
from workbench.study import executors
from workbench.study.accommodation import population_bodies
from workbench.study.accommodation.checkpoints import joined_chunks, result_chunks
from workbench.study.checks.table import CHECKS, bounds_of, margins_of
from workbench.study.people import present_people
from workbench.study.positions import lattice
from workbench.study.requirements import asked_of

ALL = ("BASE", "UPPER", "LOWER", "HAND")


def errors(**own):
    """(4, 2) [m] the fit error of the arm's segments from mm: outside and inside."""
    return np.array([own.get(name, (0.0, 0.0)) for name in ALL]) / 1000


def situation_of(made, role=0):
    """A role of a study in its one case, with what is asked of it."""
    (there,) = present_people(made).situations[role]
    return there, asked_of(there.place)


def asked(body, *criteria, role=0, **options):
    """Margin, low and high [mm] of the first criterion, of somebody with this body."""
    there, requirements = situation_of(study(body, *criteria, **options), role)
    margin = margins_of([there], requirements).margin[0, 0]
    bounds = bounds_of([there], requirements)
    return 1000 * np.array([margin, bounds.low[0, 0], bounds.high[0, 0]])


def test_a_margin_is_lower_by_what_lies_outside_and_higher_by_what_lies_inside(one_arm):
    # the thumb tip stands 455 mm from the wall
    body = changed(one_arm, fit_error=errors(HAND=(3.2, 1.5)))
    to_wall = criterion("clearance", segments=("HAND",), parts=("wall",), at_least=0.454)
    assert asked(body, to_wall) == pytest.approx([1.0, -2.2, 2.5])


def test_the_segment_that_is_worst_known_decides_not_the_nearest(one_arm):
    # from the wall: base and lower arm 450 mm, hand 455, upper arm 460
    body = changed(
        one_arm, fit_error=errors(BASE=(1, 30), LOWER=(1, 30), UPPER=(1, 30), HAND=(10, 2))
    )
    to_wall = criterion("clearance", parts=("wall",), at_least=0.44)
    assert asked(body, to_wall) == pytest.approx([10.0, 5.0, 17.0])


def test_what_may_overlap_keeps_its_depth_in_the_bounds(one_arm):
    cab = environment_of(box_part("floor", [-1, -1, -0.1], [1, 1, 0]))
    cab = replace(cab, allowances=(Allowance(0, ("HAND",), 0.01),))
    body = changed(one_arm, fit_error=errors(HAND=(7, 2)))
    inside = criterion("contact", parts=("floor",))
    found = asked(body, inside, environment=cab, stand=(0, 0, -0.005))
    assert found == pytest.approx([5.0, -2.0, 7.0])
    free = criterion("clearance", segments=("HAND",), parts=("floor",))
    assert np.isnan(asked(body, free, environment=cab)).all()  # what may touch has no clearance


def test_bounds_hold_for_a_sphere_whose_centre_is_inside_a_solid(one_arm):
    # the fingertip of 20 mm, its centre 40 mm deep in a floor of 200 mm
    cab = environment_of(box_part("floor", [-1, -1, -0.2], [1, 1, 0]))
    body = changed(one_arm, fit_error=errors(HAND=(7, 25)))
    inside = criterion("contact", parts=("floor",), segments=("HAND",))
    found = asked(body, inside, environment=cab, stand=(0, 0, -0.06))
    assert found == pytest.approx([-60.0, -67.0, -35.0])


def test_both_segments_of_an_overlap_have_a_surface(one_arm):
    folded = {"ELBOW": {"flexion": 178}}
    plain = asked(one_arm, criterion("self_contact"), angles=folded)
    own = dict.fromkeys(ALL, (3.0, 1.0))
    body = changed(one_arm, fit_error=errors(**own))
    found = asked(body, criterion("self_contact"), angles=folded)
    assert found == pytest.approx([plain[0], plain[0] - 6, plain[0] + 2])


def test_both_of_two_people_have_a_surface(one_arm):
    body = changed(one_arm, fit_error=errors(**dict.fromkeys(ALL, (3.0, 1.0))))
    apart = criterion("between_people", at_least=0.19)
    found = asked(body, apart, other=(0.3, 0.0, 0.0), role=1)
    # two bases of 50 mm, 300 mm apart
    assert found == pytest.approx([10.0, 4.0, 12.0])


def test_the_farthest_surface_gets_farther_and_less_far(one_arm):
    ahead = {"origin": (0, 0, 0), "direction": (1.0, 0.0, 0.0)}
    asks = Criterion("excursion", "excursion", ("arm",), ALL, (), 0.0, at_most=0.06, **ahead)
    body = changed(one_arm, fit_error=errors(BASE=(4, 1), LOWER=(2, 9), HAND=(0, 1)))
    # base and lower arm get 50 mm ahead, the hand 45, the upper arm 40
    assert asked(body, asks) == pytest.approx([10.0, 6.0, 11.0])


def test_nothing_is_said_of_segments_whose_fit_error_is_unknown(one_arm):
    body = changed(one_arm, fit_error=np.array([[0.001, 0.002]] * 3 + [[np.nan, np.nan]]))
    every = criterion("clearance", parts=("wall",))
    assert np.isnan(asked(body, every)).tolist() == [False, True, True]
    known = criterion("clearance", parts=("wall",), segments=("BASE",))
    assert asked(body, known) == pytest.approx([450.0, 449.0, 452.0])
    for check in ("self_contact", "between_people"):
        found = asked(body, criterion(check), other=(0.3, 0.0, 0.0), role=1)
        assert np.isnan(found).tolist() == [False, True, True]


def test_the_checks_of_the_surface_are_those_with_bounds():
    assert {name for name, check in CHECKS.items() if check.bounds is not None} == set(OF_SURFACE)


def within(body, rng):
    """The spheres of an arm moved, grown and shrunk at random, all within its fit error."""
    outside, inside = body.fit_error[0, body.sphere_segment].T
    way = rng.normal(size=(len(outside), 3))
    room = np.minimum(outside, inside) * rng.random(len(outside))
    moved = way / np.linalg.norm(way, axis=1)[:, None] * room[:, None]
    growth = rng.uniform(room - inside, outside - room)
    return body.centre[0] + moved, body.radius[0] + growth


def test_bodies_with_their_surface_anywhere_within_the_bounds_have_margins_within_them(one_arm):
    # distances by hand: every sphere from the wall at x = 500 mm, hanging spheres from each other
    own = {"BASE": (9, 2), "UPPER": (1, 8), "LOWER": (6, 6), "HAND": (12, 3)}
    body = changed(one_arm, fit_error=errors(**own))
    there, _ = situation_of(study(body, criterion("clearance")))
    _, low, high = asked(body, criterion("clearance", parts=("wall",), at_least=0.44))
    offset = there.placed.centres[0] - body.centre[0]  # hanging: all frames are upright
    rng = np.random.default_rng(5)
    least = []
    for _ in range(300):
        centre, radius = within(body, rng)
        least.append(1000 * (0.5 - (centre + offset)[:, 0] - radius).min() - 440)
    assert low <= min(least) < low + 4
    assert high - 4 < max(least) <= high


HEAD_ROOM = 415
"""[mm] Half of the people miss this in the comfortable position."""
TRAVEL = ("travel: {forward: [0, 0], up: [0, 0]}", "travel: {forward: [-60, 40], up: [-30, 30]}")


def cockpit(folder, **swap):
    """The toy cockpit with a low roof and a seat with travel; returns the study's path."""
    text = {"at_least: 150": f"at_least: {HEAD_ROOM}"} | swap
    path = write_toy(folder, knob=850, people=16, swap=text)
    room = folder / "environments/toy/environment.yaml"
    assert TRAVEL[0] in room.read_text()
    room.write_text(room.read_text().replace(*TRAVEL))
    return path


@pytest.fixture(scope="module")
def crowd(tmp_path_factory):
    """The people of that cockpit."""
    return Crowd(wb.load_study(cockpit(tmp_path_factory.mktemp("toy"))))


def chunk_of(crowd, share=1.0):
    """What is found of the people, with the fit error of their bodies times a share."""
    family = crowd.bodies.family
    template = replace(family.template, fit_error=share * family.template.fit_error)
    bodies = replace(crowd.bodies, family=replace(family, template=template), seats={})
    return joined_chunks(
        result_chunks(crowd.question, bodies, keep=None, tell=lambda done, total: None)
    )


@pytest.fixture(scope="module")
def known(crowd):
    """What is found of them with fit errors from none to twice what the body states."""
    return {share: chunk_of(crowd, share) for share in (0.0, 0.25, 0.5, 1.0, 2.0)}


def sure(chunk):
    nowhere = np.zeros(len(chunk.margin), dtype=bool)
    return certainty_of(chunk.margin, chunk.low, chunk.high, nowhere)


def test_some_are_undecided_and_some_of_them_sit_elsewhere(known):
    found = known[1.0]
    undecided = sure(found).possible & ~sure(found).certain
    assert 0 < undecided.sum() < len(undecided)
    stays = (found.seat == found.comfortable).all(axis=1)
    assert stays[undecided].any() and not stays[undecided].all()


def test_with_a_surface_that_is_known_exactly_the_bounds_are_the_margins(known):
    np.testing.assert_allclose(known[0.0].low, known[0.0].margin, rtol=0, atol=1e-12)
    np.testing.assert_allclose(known[0.0].high, known[0.0].margin, rtol=0, atol=1e-12)


def test_a_smaller_fit_error_never_makes_more_people_undecided(known):
    chunks = list(known.values())
    for less, more in pairwise(chunks):
        np.testing.assert_array_equal(less.margin, more.margin)
        assert (less.low >= more.low).all() and (less.high <= more.high).all()
        assert (sure(less).certain >= sure(more).certain).all()
        assert (sure(less).possible <= sure(more).possible).all()


def test_who_fits_for_certain_fits_and_who_certainly_does_not_does_not(known):
    for chunk in known.values():
        served = (chunk.margin >= -1e-6).all(axis=1)
        assert (sure(chunk).certain <= served).all() and (served <= sure(chunk).possible).all()


def test_the_bounds_of_what_has_no_surface_are_its_margin(crowd, known):
    plain = [r for r, one in enumerate(crowd.question.asked) if not one.requirement.of_surface]
    assert len(plain) == 3  # two knobs and the view
    np.testing.assert_array_equal(known[1.0].low[:, plain], known[1.0].margin[:, plain])
    np.testing.assert_array_equal(known[1.0].high[:, plain], known[1.0].margin[:, plain])


def test_random_bodies_within_the_fit_error_never_leave_the_bounds_where_people_sit(crowd, known):
    found = known[1.0]
    rng = np.random.default_rng(11)
    columns = [r for r, one in enumerate(crowd.question.asked) if one.requirement.of_surface]
    some = [crowd.question.asked[r] for r in columns]
    for row in range(0, 16, 3):
        body = crowd.bodies[row]
        (there,) = crowd.situations(body, [row], found.seat[row])
        outside, inside = body.fit_error[0, body.sphere_segment].T
        for _ in range(5):
            radius = body.radius + rng.uniform(-inside, outside)
            other = replace(there, body=replace(body, radius=np.maximum(radius, 1e-4)))
            margin = margins_of([other], some).margin[0]
            assert (margin >= found.low[row, columns] - 1e-9).all()
            assert (margin <= found.high[row, columns] + 1e-9).all()


def certain_positions(crowd, chunk, row):
    """Of the positions of the lattice those in which all lower bounds of one person are met."""
    place = crowd.question.place
    surface = [one.requirement.of_surface for one in crowd.question.asked]
    for position in lattice(place.travel):
        there = crowd.situations(crowd.bodies[row], [row], position)
        low = margins_of(there, crowd.question.asked).margin[0]
        low[surface] = bounds_of(there, crowd.question.asked).low[0, surface]
        if (low >= -1e-6).all():
            yield position


def test_who_is_undecided_is_certain_where_another_position_is(crowd, known):
    found = known[1.0]
    undecided = np.flatnonzero(sure(found).possible & ~sure(found).certain)
    served = (found.margin >= -1e-6).all(axis=1)
    assert found.elsewhere.any() and not found.elsewhere.all()
    assert not found.elsewhere[sure(found).certain | ~served].any()
    for row in undecided[served[undecided]]:
        if any(True for _ in certain_positions(crowd, found, row)):
            assert found.elsewhere[row]
    nobody = known[0.0].elsewhere
    assert not nobody.any()  # with a surface that is known exactly nobody is undecided


def test_bounds_depend_neither_on_who_works_nor_on_who_is_asked_together(crowd, known, monkeypatch):
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 3)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    for cores in (1, 2):
        monkeypatch.setattr(executors, "available_cores", lambda cores=cores: cores)
        again = chunk_of(crowd)
        assert again.low.tobytes() == known[1.0].low.tobytes()
        assert again.high.tobytes() == known[1.0].high.tobytes()


def test_people_with_unknown_fit_error_are_as_before_and_nothing_is_known(crowd, known):
    found = chunk_of(crowd, np.nan)
    np.testing.assert_array_equal(found.margin, known[1.0].margin)
    np.testing.assert_array_equal(found.seat, known[1.0].seat)
    assert np.isnan(found.low[:, -1]).all() and np.isnan(found.high[:, -1]).all()
    assert sure(found) is None


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A run with a share that is undecided; its folder, and its result."""
    folder = tmp_path_factory.mktemp("run")
    share = f"{HEAD_ROOM}}}\n  - {{name: enough, check: share, at_least: 85, of: [head room]}}"
    path = cockpit(folder, **{"at_least: 150": "at_least: 150", "150}": share})
    main(["run", str(path), "--out", str(folder / "out")])
    return folder / "out", json.loads((folder / "out/result.json").read_text())


def test_the_tables_hold_who_is_certain_and_the_bounds(written):
    folder, result = written
    population = result["population"]
    people = list(csv.DictReader(io.StringIO((folder / "people.csv").read_text())))
    everybody = population["people"]
    assert [row["certain"] for row in people] == [
        "yes" if one else "no" for one in everybody["certain"]
    ]
    r = [row["name"] for row in population["requirements"]].index("head room")
    for p, row in enumerate(people):
        low, margin, high = (
            float(row[name])
            for name in ("head room: from [mm]", "head room [mm]", "head room: to [mm]")
        )
        assert low <= margin <= high
        assert (low, high) == (
            everybody["margin_from_mm"][p][r],
            everybody["margin_to_mm"][p][r],
        )
        assert everybody["margin_from_mm"][p][0] is None  # a reach has no surface


def test_a_share_between_the_certain_and_the_possible_one_is_undecided_and_says_so(written):
    (verdict,) = written[1]["verdicts"]
    assert not verdict["passed"] and verdict["doubtful"]
    assert verdict["sentence"].endswith(
        "85 % must. Within the error of the body model's surface the share is 75 % to 94 %, so the "
        "verdict is undecided."
    )


def test_the_page_says_who_is_undecided_and_by_how_much_surfaces_are_known(written):
    folder, result = written
    page = (folder / "report.html").read_text()
    assert result["headline"].startswith("81 % of the population fits (95 % interval 57 to 93 %,")
    undecided = (
        ". Allowing for the error of the body model's surface, 75 % fit, 6 % do not and 19 % are "
        "undecided."
    )
    assert undecided in result["headline"]
    (asked,) = result["verdicts"]
    assert asked["sentence"].removesuffix(".") in result["headline"]  # with its doubt
    everybody = result["population"]["shares"][0]
    assert (everybody["certain"], everybody["possible"]) == (0.75, 0.9375)
    assert "3 people (19" in page and "1 of them counts as fitting here" in page


def group(share, certain, possible, count=1000):
    return GroupShare("everybody", share, share, share, count, certain, possible)


def test_a_share_is_undecided_only_where_the_limit_lies_between():
    for wanted, open_ in ((0.79, False), (0.8, False), (0.81, True), (0.9, True), (0.91, False)):
        assert group(0.85, 0.8, 0.9).leaves_open(wanted) is open_
    assert not group(0.85, np.nan, np.nan).leaves_open(0.85)
    asks = replace(criterion("share", at_least=0.88), of=())
    assert share_sentence(asks, group(0.85, 0.8, 0.9)).endswith(
        "88 % must. Within the error of the body model's surface the share is 80.0 % to 90.0 %, so "
        "the verdict is undecided."
    )
    assert "undecided" not in share_sentence(asks, group(0.85, 0.8, 0.87))


def found_of_margins(*margins, less=0.004, more=0.002):
    """An accommodation of one clearance with these margins [mm]."""
    clear = Requirement("knees to panel", "knees", "clearance", "panel")
    margin = np.array(margins)[:, None] / 1000
    return made(trainer_people(len(margins)), [clear], margin, less=less, more=more)


def test_the_undecided_are_counted_in_words():
    found = found_of_margins(9, 9, 3, 1, -1, -3, 9, 9, 9, 9)
    assert population_headline(found).startswith("80 % of the population fits (")
    undecided = (
        ". Allowing for the error of the body model's surface, 60 % fit, 10 % do not and 30 % are "
        "undecided."
    )
    assert undecided in population_headline(found)
    assert certainty_words(found) == (
        "The body model's surface has a stated error: a true clearance may be up to 4 mm smaller or "
        "up to 2 mm larger than computed. Wherever it lies within that error, 60 % of the people fit and 10 % do not, "
        "in the position that was found for them; 3 people (30 %) are undecided. 2 of them count as "
        "fitting here; no other position of the seat was found in which they fit for certain. The requirement most often "
        "undecided is “knees to panel”: for 3 of 10 people."
    )


@pytest.mark.parametrize(
    ("margins", "said"),
    [
        ((9, 9, 3), "This person counts as fitting here; no other position"),
        ((9, 9, -1), "This person counts as not fitting here."),
        ((9, -1, -1), "None of them counts as fitting here."),
        ((9, 1, -1), "1 of them counts as fitting here; no other position"),
        ((9, 9, -9), "Wherever it lies within that error, the same people fit."),
    ],
)
def test_words_of_the_undecided_follow_their_number(margins, said):
    assert said in certainty_words(found_of_margins(*margins))


def test_nothing_is_said_of_certainty_where_no_margin_is_of_the_surface():
    reach = Requirement("reach knob", "knobs", "reach", "knob", 1)
    found = made(trainer_people(3), [reach], np.array([[0.1], [0.2], [-0.1]]))
    assert certainty_words(found) == ""
    assert "undecided" not in population_headline(found)


def test_an_unknown_fit_error_is_said_to_be_unknown():
    found = found_of_margins(9, 1, -9, less=np.nan, more=np.nan)
    assert "it is not known how certain" in certainty_words(found)
    assert "undecided" not in population_headline(found)
    rows = population_rows(found, "")
    assert rows.shares[0].certain is None and rows.requirements[0].possible is None
    assert rows.people.certain == [None, None, None]
