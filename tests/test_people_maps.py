"""Reach maps of an accommodation study: the sides that face the sitter, the share of the people as
each reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.accommodations import smaller_study
from workbench import limb, load_study, reach
from workbench.model.accommodation import MapTask
from workbench.study.accommodation.chunks import seat_everybody
from workbench.study.accommodation.people_maps import people_maps
from workbench.study.accommodation.population_bodies import fit_population
from workbench.study.pipelines import population_study


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Two people of the trainer's study, the second counting three times, and a map of few points
    by either hand."""
    folder = tmp_path_factory.mktemp("study")
    study = population_study(load_study(smaller_study("trainer_accommodation", folder, people=30)))
    people = study.people.rows(np.array([0, len(study.people) - 1]))
    task = MapTask("instrument_panel", "push", 2, "either", 14)
    study = replace(study, people=replace(people, weight=np.array([1.0, 3.0])), maps=(task,))
    bodies = fit_population(study.body, study.people, study.wears)
    return study, bodies, next(people_maps(study, bodies, say=lambda text: None))


def test_points_lie_on_what_faces_the_sitter_about_as_many_as_asked_for(two):
    _, _, found = two
    assert 8 <= len(found.points) <= 20
    assert np.all(found.normals[:, 0] < 0)  # the sitter looks forward, along x
    away = found.points - found.points.mean(axis=0)
    flat = found.flat - found.flat.mean(axis=0)
    assert flat[:, 0] == pytest.approx(-away[:, 1], abs=0.02)  # to the right is -y
    assert np.corrcoef(flat[:, 1], away[:, 2])[0, 1] > 0.9


def test_shares_are_those_of_reaching_for_each_point_one_by_one(two):
    study, bodies, found = two
    ((seat, _),) = seat_everybody(study, bodies)
    reached = np.zeros((2, len(found.points)), dtype=bool)
    for hand in ("left hand", "right hand"):
        arm = limb(bodies[:], hand, grip="push", zone=2)
        reached |= reach(bodies[:], seat.poses, found.points, limb=arm).reached
    assert found.share == pytest.approx(np.array([0.25, 0.75]) @ reached, abs=1e-12)
