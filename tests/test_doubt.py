"""Verdicts and what the body's surface is known to: who could turn out otherwise says so."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from tests.made_studies import found_of
from tests.rows import changed
from tests.test_study import criterion, only, study
from workbench.model.criterion import Criterion
from workbench.report.result_rows import verdict_row
from workbench.report.sentences import verdict_sentence
from workbench.report.tables import verdict_tables

# the thumb tip stands 455 mm from the wall
SEGMENTS = ("BASE", "UPPER", "LOWER", "HAND")
ASKED = ("clearance", {"segments": ("HAND",), "parts": ("wall",)})


def outcome(one_arm, at_least, outside=np.nan, inside=np.nan):
    """The verdict on the hand's clearance to the wall, the surface of every segment known so
    well."""
    body = changed(one_arm, fit_error=np.tile([outside, inside], (4, 1)))
    return found_of(study(body, criterion(ASKED[0], at_least=at_least, **ASKED[1])))


def test_a_body_that_does_not_say_how_well_it_fits_leaves_no_doubt(one_arm):
    found = only(outcome(one_arm, 0.454))
    assert found.passed
    assert found.doubtful is None
    assert np.isnan(found.worst.surface_known_to)


def test_what_clears_by_less_than_the_surface_is_known_to_may_not_hold(one_arm):
    found = only(outcome(one_arm, 0.454, outside=0.0032, inside=0.001))
    assert found.passed
    assert found.doubtful == found.worst
    told = verdict_sentence(found)
    assert told.endswith(
        "1.0 mm more than the 454.0 mm asked for. Not certain: 1.0 mm to "
        "spare, and the body's surface is known to ± 3 mm there."
    )


def test_what_clears_by_more_is_in_no_doubt(one_arm):
    found = only(outcome(one_arm, 0.45, outside=0.0032))
    assert found.doubtful is None
    assert "known to" not in verdict_sentence(found)


def test_a_breach_that_the_surface_may_lie_inside_of_may_yet_hold(one_arm):
    # the end of the hand is as near as its thumb is not: only the thumb breaches
    found = only(outcome(one_arm, 0.456, outside=0.001, inside=0.002))
    assert not found.passed
    assert found.doubtful == found.breaches[0]
    told = verdict_sentence(found)
    assert told.endswith(
        "1.0 mm less than the 456.0 mm asked for. Not certain: 1.0 mm "
        "short, and the body's surface is known to ± 2 mm there."
    )
    assert only(outcome(one_arm, 0.458, inside=0.002)).doubtful is None


def test_one_breach_beyond_doubt_decides(one_arm):
    body = changed(one_arm, fit_error=np.array([[0.01, 0.6]] * 3 + [[0.01, 0.001]]))
    found = only(found_of(study(body, criterion("clearance", at_least=0.47, parts=("wall",)))))
    assert len(found.breaches) > 1
    assert found.doubtful is None


def test_of_two_people_both_surfaces_count(one_arm):
    body = changed(one_arm, fit_error=np.full((4, 2), 0.002))
    made = study(body, criterion("between_people", at_least=0.197), other=(0.3, 0.0, 0.0))
    found = only(found_of(made))
    assert found.worst.surface_known_to == pytest.approx(0.004)
    assert ("surface is known to ± 4 mm" in verdict_sentence(found)) == (
        abs(found.worst.value - 0.197) < 0.004
    )


def test_a_margin_of_a_joint_stop_has_no_surface(one_arm):
    body = changed(one_arm, fit_error=np.full((4, 2), 0.002))
    assert np.isnan(only(found_of(study(body, criterion("stops")))).worst.surface_known_to)


def test_the_doubt_stands_in_the_rows_and_tables(one_arm):
    row = verdict_row(only(outcome(one_arm, 0.454, outside=0.0032, inside=0.001)))
    assert row.doubtful
    assert row.worst.surface_known_to == pytest.approx(3.2)
    assert row.worst.margin == pytest.approx(1.0)
    (cells,) = csv.DictReader(io.StringIO(verdict_tables([row])["verdicts"].csv()))
    assert (cells["surface_known_to"], cells["margin"], cells["passed"]) == ("3.2", "1.0", "yes")


def test_the_farthest_of_an_excursion_is_known_as_well_as_its_surface(one_arm):
    # base and lower arm get 50 mm ahead, the hand 45
    body = changed(one_arm, fit_error=np.array([[0.002, 0.001]] * 3 + [[0.009, 0.001]]))
    ahead = {"origin": (0, 0, 0), "direction": (1.0, 0.0, 0.0)}
    asks = Criterion("ahead", "excursion", ("arm",), SEGMENTS, (), 0.0, at_most=0.053, **ahead)
    found = only(found_of(study(body, asks)))
    assert found.worst.surface_known_to == pytest.approx(0.004)
    assert found.doubtful == found.worst
    assert "Not certain: " in verdict_sentence(found)


def test_named_spheres_are_known_as_well_as_their_segment(one_arm):
    body = changed(one_arm, fit_error=np.array([[0.0, 0.0]] * 3 + [[0.003, 0.001]]))
    asks = Criterion(
        "thumb", "clearance", ("arm",), (), ("wall",), 0.454, subparts=("HAND/thumb tip",)
    )
    found = only(found_of(study(body, asks)))
    assert found.worst.surface_known_to == pytest.approx(0.003)
    assert found.doubtful == found.worst
    missed = only(found_of(study(body, replace(asks, at_least=0.4555))))
    assert missed.doubtful == missed.breaches[0]


def test_the_doubt_that_is_told_is_that_of_the_finding_nearest_to_its_limit(one_arm):
    # the thumb tip is 1 mm and the hand's middle 11 mm beyond what is asked; known to 20 mm
    made = outcome(one_arm, 0.454, outside=0.02, inside=0.02)
    found = only(made)
    assert found.doubtful == found.worst
    far = replace(found.worst, value=found.worst.limit + 0.011, surface_known_to=0.02)
    said = verdict_sentence(replace(found, doubtful=far))
    assert said.count("11.0 mm to spare") == 1 and "Not certain: hand" in said
