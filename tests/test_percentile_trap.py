"""A cockpit laid out for a small woman and a large man, each at a percentile in everything, leaves
out many others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from workbench import draw_people
from workbench.body.people.percentile import percentile_values
from workbench.model.population import SEXES, Population
from workbench.study.accommodation.accommodation import accommodation

BEARING = {
    "eyes at the height of the design eye": "eye height",
    "head to canopy": "sitting height",
    "belly to stick": "abdominal depth",
    "thighs to stick": "thigh clearance",
    "knees to panel": "buttock-knee length and knee height",
    "shins to panel": "knee height and popliteal height",
    "left leg to side wall": "hip breadth",
    "left shoulder to canopy": "shoulder breadth",
}


def both(model):
    """A woman at the 5th and a man at the 95th percentile of their sex in every measure."""
    rows = [percentile_values(model, sex, [p])[0] for sex, p in (("female", 5), ("male", 95))]
    sexes = np.array([SEXES.index("female"), SEXES.index("male")])
    return Population(model.names, sexes, np.ones(2), np.array(rows), "two percentiles")


def just_cleared(criterion, margin):
    """The criterion with its limits where the worse of the two people just meets it: margins (2,)
    [m]."""
    least = float(np.min(margin)) - 1e-5
    if criterion.check == "eye_height":
        return replace(criterion, below=criterion.below - least, above=criterion.above - least)
    return replace(criterion, at_least=criterion.at_least + least)


def still(plan):
    """The environment with the seat where it stands: its travel would make up for much."""
    seats = tuple(
        replace(seat, travel_forward=(0.0, 0.0), travel_up=(0.0, 0.0))
        for seat in plan.environment.seats
    )
    return replace(plan.environment, seats=seats)


@pytest.mark.parametrize("count", [36, pytest.param(400, marks=pytest.mark.nightly)])
def test_a_cockpit_without_travel_that_clears_both_percentiles_in_eight_dimensions_serves_far_fewer_than_nine_in_ten(
    count, tmp_path
):
    plan = crowd_of(smaller_study("trainer_accommodation", tmp_path, people=count))
    model = wb.load_population_model("ansur2")
    criteria = tuple(c for c in plan.study.criteria if c.name in BEARING)
    assert len(criteria) == 8
    still_room = {"reach_maps": (), "changes": (), "environment": still(plan)}
    few = plan.with_people(both(model), criteria=criteria, **still_room)
    two = accommodation(few.study)
    variant = tuple(just_cleared(c, two.margin[:, r]) for r, c in enumerate(criteria))
    few = plan.with_people(both(model), criteria=variant, **still_room)
    assert accommodation(few.study).served.all()
    many = draw_people(model, count, seed=4, men=0.5)
    everybody = accommodation(plan.with_people(many, criteria=variant, **still_room).study)
    share = everybody.shares[0]
    assert share.high < 0.9
