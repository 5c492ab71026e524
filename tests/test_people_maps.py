"""Reach maps of an accommodation study: the sides that face the sitter, the share of the people as
each reaches."""

from __future__ import annotations

from dataclasses import replace
from fnmatch import fnmatch

import numpy as np
import pytest

from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from workbench import InputError, limb, load_study, reach
from workbench.model.accommodation import MapTask
from workbench.sight.eyes import eyes_of
from workbench.sight.obscuration import Target, seen_shares
from workbench.sight.scenery import scenery_of
from workbench.study.accommodation.checkpoints import taken_places
from workbench.study.accommodation.reach_maps import people_maps
from workbench.study.passes import Passes
from workbench.study.situation import Occupants, in_place


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
    maps = people_maps(study.question, study.study.reach_maps, bodies, passes=Passes(print, []))
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


def test_who_sees_a_point_is_who_has_a_line_to_it_from_either_eye(two):
    """Each point by itself, as a target with its normal; what stands out of the panel by less than
    60 mm hides nothing of it."""
    study, bodies, _ = two
    task = MapTask("instrument_panel", "push", 1, "either", 60, sees=True)
    (found,) = people_maps(study.question, (task,), bodies, passes=Passes(print, []))
    ((taken,),) = taken_places(study.question.place, study.people, bodies)
    who = Occupants(bodies[:], study.people, np.arange(2))
    situation = in_place(study.question.place, 0, who, taken).held
    environment = situation.environment
    on_panel = [
        f"*_{end}" for end in ("indicator", "gauge", "coordinator", "switch", "vent", "key")
    ]
    on_panel += ["altimeter", "tachometer", "voltmeter", "*_knob", "starter_button", "switch_panel"]
    on_panel += ["glove_box", "circuit_breakers", "grab_handle"]
    mounted = [any(fnmatch(name, one) for one in on_panel) for name in environment.parts]
    bare = replace(environment, hidden=environment.hidden | np.array(mounted))
    scenery = scenery_of(
        bare,
        situation.placed,
        moving=situation.place.moving_parts,
        displacement=situation.displacement,
    )
    item = environment.part_index("instrument_panel")
    targets = [
        Target(str(k), point[None], normal[None], item)
        for k, (point, normal) in enumerate(zip(found.points, found.normals, strict=True))
    ]
    seen = seen_shares(scenery, eyes_of(situation.placed), targets)
    either = seen.share[:, :, 2] > 0.5
    assert found.share == pytest.approx(np.array([0.25, 0.75]) @ either, abs=1e-12)
    hidden = {name for row, names in zip(either, seen.blocker, strict=True) for name in names[~row]}
    assert hidden and 0.5 < found.share.mean() < 1.0


def test_a_map_of_who_sees_takes_no_hand(tmp_path):
    path = smaller_study("trainer_accommodation", tmp_path, people=30)
    text = path.read_text()
    asked = (
        "reach_maps: [{people: pilot, part: instrument_panel, sees: true, hand: left, points: 60}]"
    )
    path.write_text(text[: text.index("reach_maps:")] + asked + "\n")
    with pytest.raises(InputError, match="is of eyes: leave out hand"):
        load_study(path)
