"""Hands on their controls: brought there once, and not where it is known without them that a
position is no better."""

from __future__ import annotations

import numpy as np
import pytest

from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from workbench.contact.collide import contacts
from workbench.study.checks.table import margins_of, most_of, needs_hands
from workbench.study.positions import comfortable_situations, in_positions
from workbench.study.situation import with_hands

PEOPLE = 4


@pytest.fixture(scope="module")
def seated(tmp_path_factory):
    """The question of the trainer's study, and some people in two positions of the seat."""
    path = smaller_study("trainer_accommodation", tmp_path_factory.mktemp("few"), people=PEOPLE)
    crowd = crowd_of(path)
    rows = np.repeat(np.arange(PEOPLE), 2)
    who = crowd.occupants(crowd.bodies[rows], rows)
    wanted = comfortable_situations(crowd.question.place, who)
    low, high = np.array([crowd.seat.travel_forward, crowd.seat.travel_up]).T
    positions = np.tile(np.stack([low, high]), (PEOPLE, 1))
    return crowd.question, in_positions(crowd.question.place, who, positions, wanted)


def test_margins_with_the_hands_on_controls_are_at_most_what_was_said_before(seated):
    question, situations = seated
    held = [one for one in question.asked if needs_hands(situations[one.case], one)]
    most = most_of(situations, held)
    margin = margins_of(situations, held).margin
    assert held and np.isfinite(most).all()
    assert np.all(margin <= most) and np.any(margin > most - 1e-6)


def test_hands_of_some_people_are_where_they_are_with_everybody(seated):
    _, (situation,) = seated
    some = np.array([7, 2, 3])
    alone = with_hands(situation.rows(some))
    everybody = with_hands(situation)
    known = with_hands(situation.rows(some))
    for one in (alone, everybody.rows(some)):
        assert np.array_equal(known.poses.rotations, one.poses.rotations)
        assert known.hand_limit == one.hand_limit
    assert not np.array_equal(known.poses.rotations, situation.rows(some).poses.rotations)


def test_straight_fingers_are_kept_out_of_what_stands_beside_a_control(seated):
    """The search of a reach lets fingers bend out of the way; the body holds them straight. Before,
    of these hands on the throttle four were in the quadrant beside it, by up to 11 mm."""
    _, (situation,) = seated
    there = np.flatnonzero(with_hands(situation).hand_miss["right hand"] == 0.0)
    assert len(there) >= 5
    for row in there.tolist():
        posed = with_hands(situation.rows(np.array([row])))
        found = contacts(posed.placed, posed.environment_moved)
        quadrant = found.part == found.other.part_index("throttle_quadrant")
        hand = found.segment == posed.body.segment("RHN")
        assert not np.any(found.excess[quadrant & hand] > 1e-6)
