"""Who is said to fit nowhere is asked for in every position of a lattice 5 mm apart, and at a grid of
settings twice as fine as that of the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.crowds import Crowd, crowd_of
from workbench.study.checks.table import CHECKS, margins_of, same_everywhere
from workbench.study.positions import comfortable_situations, fitted_positions, in_positions
from workbench.study.settings import at_setting, renewed, setting_axes

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


def every_position(seat, step=STEP) -> np.ndarray:
    """(M, 2) [m] positions over the whole travel, with its ends."""
    axes = [
        np.linspace(low, high, 1 + int(np.ceil((high - low) / step - 1e-9)))
        for low, high in (seat.travel_forward, seat.travel_up)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def where_fits(crowd: Crowd, row: int, comfortable, place, step=STEP, margins=None) -> np.ndarray:
    """(M, 2) the positions in which a person meets everything that depends on the position.
    comfortable: of this person alone; place: the workplace as it is set. The cheap questions come
    first, and of those as dear the ones that the person missed by most, by margins (R,): what
    hardly a position meets leaves few for what follows."""
    asked = renewed(place, crowd.question.asked)
    if margins is None:
        margins = np.zeros(len(asked))
    order = sorted(range(len(asked)), key=lambda r: (cost_of(asked[r]), margins[r]))
    left = every_position(crowd.seat, step)
    for one in (asked[r] for r in order if not same_everywhere(place, asked[r])):
        met = []
        for first in range(0, len(left), BATCH):
            some = left[first : first + BATCH]
            rows = np.full(len(some), row)
            wanted = [situation.rows(np.zeros_like(rows)) for situation in comfortable]
            who = crowd.occupants(crowd.bodies[rows], rows)
            there = in_positions(place, who, some, wanted)
            met.append(~(margins_of(there, [one]).margin < -MET).any(axis=1))
        if met:
            left = left[np.concatenate(met)]
    return left


def cost_of(one) -> int:
    return CHECKS[one.requirement.check].cost


def alone(situations, row: int):
    """One person of some situations."""
    return [situation.rows(np.array([row])) for situation in situations]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("study", "people", "seed"), [("trainer_accommodation", 200, 5), ("car_driver", 100, 5)]
)
def test_nobody_fits_in_a_dense_lattice_who_is_said_to_fit_nowhere(study, people, seed):
    crowd = drawn(study, people, seed)
    question = crowd.question
    place = replace(question.place, adjusts=())
    rows = np.arange(people)
    who = crowd.occupants(crowd.bodies[rows], rows)
    comfortable = comfortable_situations(place, who)
    no_sets = np.zeros((len(question.asked), 0), dtype=np.bool_)
    found = fitted_positions(place, question.asked, no_sets, who, comfortable)
    depends = [not same_everywhere(place, one) for one in question.asked]
    nowhere = np.flatnonzero((found.tried.margin[:, depends] < -MET).any(axis=1))
    assert len(nowhere) > 5
    refuted = {
        int(row): positions[0]
        for row in nowhere
        if len(
            positions := where_fits(
                crowd, int(row), alone(comfortable, row), place, margins=found.tried.margin[row]
            )
        )
    }
    assert len(refuted) <= MOST_REFUTED * len(nowhere), refuted


COARSE_STEP = 0.01
"""[m] between the positions that are tried at each of many settings."""


def finer_settings(place) -> np.ndarray:
    """(S, A) settings twice as many on each axis as the search tries, with its own."""
    axes = [
        np.unique(np.concatenate([axis, 0.5 * (axis[1:] + axis[:-1])]))
        for axis in setting_axes(place)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


@pytest.mark.nightly
def test_nobody_fits_at_a_finer_grid_of_settings_who_is_said_to_fit_at_none():
    crowd = drawn("car_driver", 100, 5)
    question = crowd.question
    rows = np.arange(len(crowd.people))
    who = crowd.occupants(crowd.bodies[rows], rows)
    comfortable = comfortable_situations(question.place, who)
    no_sets = np.zeros((len(question.asked), 0), dtype=np.bool_)
    found = fitted_positions(question.place, question.asked, no_sets, who, comfortable)
    nowhere = np.flatnonzero((found.tried.margin < -MET).any(axis=1))
    assert len(nowhere) > 5
    refuted = {}
    anywhere = [one for one in question.asked if same_everywhere(question.place, one)]
    for setting in finer_settings(question.place):
        place = at_setting(question.place, setting)
        left = np.array([row for row in nowhere.tolist() if row not in refuted])
        who = crowd.occupants(crowd.bodies[left], left)
        wanted = comfortable_situations(place, who)
        fits = ~(margins_of(wanted, anywhere).margin < -MET).any(axis=1)
        for k in np.flatnonzero(fits).tolist():
            one = alone(wanted, k)
            tried = found.tried.margin[left[k]]
            positions = where_fits(crowd, int(left[k]), one, place, COARSE_STEP, tried)
            if len(positions):
                refuted[int(left[k])] = (setting.tolist(), positions[0].tolist())
    assert len(refuted) <= MOST_REFUTED * len(nowhere), refuted
