"""Who was seated in a position is not seated there again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.crowds import crowd_of
from tests.toy_cockpit import write_toy
from workbench.posture.seating.seat import SeatMemory
from workbench.study import situation
from workbench.study.situation import Occupants, seating_of, take_places

PLACES = np.array([[0.0, 0.01], [0.02, 0.0], [-0.01, 0.03], [0.0, 0.01]])


def test_people_sit_in_known_positions_to_the_last_bit_and_are_not_seated_again(
    tmp_path, monkeypatch
):
    crowd = crowd_of(write_toy(tmp_path, people=4))
    seating = seating_of(crowd.question.place, 0)
    who = Occupants(crowd.bodies[:], crowd.people, np.arange(4), seats=SeatMemory())
    alone = take_places(seating, replace(who, seats=None), PLACES).seated
    order = np.array([2, 0, 3, 1])
    for some in (np.array([1, 2]), np.array([0, 1, 3])):  # some of them, in any company
        take_places(seating, who.rows(some), PLACES[some])
    monkeypatch.setattr(situation, "seat", lambda *_, **__: pytest.fail("seated again"))
    longer = replace(seating, seat=replace(seating.seat, travel_up=(0.0, 0.5)))
    found = take_places(longer, who.rows(order), PLACES[order]).seated
    assert np.array_equal(found.poses.rotations, alone.poses.rotations[order])
    world = found.poses.world_from_reference
    assert np.array_equal(world, alone.poses.world_from_reference[order])
    assert np.array_equal(found.up, PLACES[order, 1])
