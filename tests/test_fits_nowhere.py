"""Who is said to fit nowhere is asked for in every position of a lattice 5 mm apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.crowds import Crowd, crowd_of
from workbench.study.checks.table import CHECKS, SAME_EVERYWHERE, margins_of
from workbench.study.positions import comfortable_situations, fitted_positions, in_positions

MET = 1e-6
STEP = 0.005
BATCH = 256
MOST_REFUTED = 1 / 20
"""The share of those who are said to fit nowhere that the lattice may refute. The aim is 1 in 200;
some 40 people who fit nowhere are too few to tell that from none."""


def drawn(study: str, people: int, seed: int) -> Crowd:
    crowd = crowd_of(ROOT / "studies" / f"{study}.yaml")
    (role,) = crowd.study.roles
    role = replace(role, population=replace(role.population, people=people, seed=seed))
    return Crowd(replace(crowd.study, roles=(role,)))


def every_position(seat) -> np.ndarray:
    """(M, 2) [m] positions over the whole travel, with its ends."""
    axes = [
        np.linspace(low, high, 1 + int(np.ceil((high - low) / STEP - 1e-9)))
        for low, high in (seat.travel_forward, seat.travel_up)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def where_fits(crowd: Crowd, row: int, comfortable) -> np.ndarray:
    """(M, 2) the positions in which a person meets everything that depends on the position, the
    cheap questions first."""
    question = crowd.question
    left = every_position(crowd.seat)
    for cost in sorted({check.cost for check in CHECKS.values()}):
        asked = [
            one
            for one in question.asked
            if CHECKS[one.requirement.check].cost == cost
            and one.requirement.check not in SAME_EVERYWHERE
        ]
        met = []
        for first in range(0, len(left) if asked else 0, BATCH):
            some = left[first : first + BATCH]
            rows = np.full(len(some), row)
            wanted = [situation.rows(rows) for situation in comfortable]
            who = crowd.occupants(crowd.bodies[rows], rows)
            there = in_positions(question.place, who, some, wanted)
            met.append(~(margins_of(there, asked).margin < -MET).any(axis=1))
        if met:
            left = left[np.concatenate(met)]
    return left


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("study", "people", "seed"), [("trainer_accommodation", 200, 5), ("car_driver", 100, 5)]
)
def test_nobody_fits_in_a_dense_lattice_who_is_said_to_fit_nowhere(study, people, seed):
    crowd = drawn(study, people, seed)
    question = crowd.question
    rows = np.arange(people)
    who = crowd.occupants(crowd.bodies[rows], rows)
    comfortable = comfortable_situations(question.place, who)
    no_sets = np.zeros((len(question.asked), 0), dtype=np.bool_)
    found = fitted_positions(question.place, question.asked, no_sets, who, comfortable)
    depends = [one.requirement.check not in SAME_EVERYWHERE for one in question.asked]
    nowhere = np.flatnonzero((found.tried.margin[:, depends] < -MET).any(axis=1))
    assert len(nowhere) > 5
    refuted = {
        int(row): positions[0]
        for row in nowhere
        if len(positions := where_fits(crowd, int(row), comfortable))
    }
    assert len(refuted) <= MOST_REFUTED * len(nowhere), refuted
