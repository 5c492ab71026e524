"""Reach maps of an accommodation study: the sides that face the sitter, the share of the people as
each reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from workbench import limb, reach
from workbench.model.accommodation import MapTask
from workbench.study.accommodation.chunks import taken_places
from workbench.study.accommodation.people_maps import people_maps


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Two people of the trainer's study, the second counting three times, and a map of few points
    by either hand."""
    folder = tmp_path_factory.mktemp("study")
    study = crowd_of(smaller_study("trainer_accommodation", folder, people=30))
    people = study.people.rows(np.array([1, len(study.people) - 1]))
    task = MapTask("instrument_panel", "push", 2, "either", 14)
    people = replace(people, weight=np.array([1.0, 3.0]))
    study = study.with_people(people, reach_maps=(task,))
    bodies = study.bodies
    maps = people_maps(study.question, study.study.reach_maps, bodies, say=lambda text: None)
    return study, bodies, next(maps)


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
    ((taken,),) = taken_places(study.question.place, study.people, bodies)
    reached = np.zeros((2, len(found.points)), dtype=bool)
    for hand in ("left hand", "right hand"):
        arm = limb(bodies[:], hand, grip="push", zone=2)
        reached |= reach(bodies[:], taken.poses, found.points, limb=arm).reached
    assert found.share == pytest.approx(np.array([0.25, 0.75]) @ reached, abs=1e-12)
