"""What is said to be kept from a target by an obstacle is: an independent judge with 200 random
restarts finds a way for few of them. `python -m benchmarks.reach_truth` lists them."""

from __future__ import annotations

import pytest

from tests.conftest import real_input
from tests.reach_truth import HANDS, MESHES, REAL, SHIPPED, seats_of, study_of, tally_of

pytestmark = pytest.mark.nightly
DETAILS = ("coarse", "medium", "fine")
PEOPLE = {"controls": 42, "real": 10, "pockets": 8}
"""People of each place and level of detail: 252 in all at the controls of trainer and car."""
JUDGED = {"controls": 10_000, "real": 200, "pockets": 60}
"""Most that are judged of each place, level of detail and hand."""
DEEPER = {"pockets": 0.1}
"""[m] How far pockets lie behind controls."""
FALSE = {"controls": 0.02, "real": 0.02, "pockets": 0.1}
"""Most of those said to be kept that the judge may find a way for."""
FOUND = 0.99
"""Least share of what is reached that the judge finds a way for."""
ENOUGH = {"controls": 100, "real": 25, "pockets": 100}
"""Least that are judged of a group. In real cockpits few are kept: of 10 people and 840 reaches at
coarse detail 13."""
MISSED = pytest.mark.xfail(strict=False, reason="the search misses ways: docs/reliability.md")
"""Measured: about 8 in 100 in the trainer's pockets at medium and coarse detail, near the bound; at
fine detail it was not counted again."""
GROUPS = {
    "controls": ("controls", tuple(SHIPPED)),
    "real": ("real", tuple(REAL)),
    "trainer_pockets": ("pockets", ("trainer",)),
    "car_pockets": ("pockets", ("compact_car",)),
}
"""What is asked for, and where."""


@pytest.fixture(scope="module")
def tallies(tmp_path_factory):
    """The tallies of a group, made once: one for each place, level of detail and hand."""
    folder = tmp_path_factory.mktemp("places")
    made = {}

    def of(group):
        if group not in made:
            kind, places = GROUPS[group]
            for place in set(places) & set(MESHES):
                real_input(MESHES[place])
            every = [
                seats_of(place, study_of(place, folder), detail, PEOPLE[kind])
                for place in places
                for detail in DETAILS
            ]
            made[group] = [
                tally_of(seats, hand, deeper=DEEPER.get(kind, 0.0), most=JUDGED[kind])
                for seats in every
                for hand in HANDS
            ]
        return made[group]

    return of


@pytest.mark.parametrize("group", GROUPS)
def test_the_judge_finds_what_is_reached_and_has_enough_to_judge(tallies, group):
    rows = tallies(group)
    assert sum(tally.found for tally in rows) >= FOUND * sum(tally.tried for tally in rows)
    assert sum(tally.judged for tally in rows) >= ENOUGH[GROUPS[group][0]]


@pytest.mark.parametrize(
    "group",
    [pytest.param(group, marks=MISSED if group == "trainer_pockets" else ()) for group in GROUPS],
)
def test_few_of_those_said_to_be_kept_by_an_obstacle_have_a_way(tallies, group):
    rows = tallies(group)
    most = FALSE[GROUPS[group][0]] * sum(tally.judged for tally in rows)
    assert sum(tally.false for tally in rows) < most, "\n".join(map(str, rows))
