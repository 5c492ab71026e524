"""The search of a seat position asks what is seen last and in few positions: what it finds is what
asking everything everywhere finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.test_rules_asked import HEAD, study_of
from workbench.sight.eyes import given_eyes
from workbench.sight.rules.cockpit_view import COARSE, clear_view, cockpit_outline
from workbench.sight.scenery import scenery_of
from workbench.study import positions
from workbench.study.checks.table import CHECKS

SEEN = HEAD.replace("like: driving", "like: driving, hands: {right: near}") + (
    "  - {name: lamp, check: sees, parts: [lamp, panel], at_least: 60}\n"
    "  - {name: nose, check: over_nose, down: 24, parts: [lamp]}\n"
)


def with_travel(folder, criterion):
    """The study with a seat that goes 30 mm forward and 60 mm up."""
    study_of(folder, criterion, head=SEEN)
    room = folder / "environments/toy/environment.yaml"
    fixed = "travel: {forward: [0, 0], up: [0, 0]}"
    assert fixed in room.read_text()
    room.write_text(room.read_text().replace(fixed, "travel: {forward: [0, 30], up: [0, 60]}"))
    study = folder / "studies/toy_crew.yaml"
    study.write_text(study.read_text().replace("people: 4,", "people: 2,"))
    return wb.load_study(study)


def full_way(patch):
    """Let everything be asked in every position as it is at last."""
    for name in ("sees", "reads", "outline", "mirror", "reflection"):
        patch.setitem(CHECKS, name, replace(CHECKS[name], most=None, spheres=None))
    patch.setattr(positions, "takes_looks", lambda *asked: False)


@pytest.mark.parametrize(
    "criterion",
    [
        "check: eye_height, below: 60, above: 60",
        pytest.param(
            "check: outline, rules: sight_ac_25_773_1, side: left, at_least: 97",
            marks=pytest.mark.nightly,
        ),
        pytest.param(
            "check: outline, rules: sight_ac_25_773_1, side: left, at_least: 85",
            marks=pytest.mark.nightly,
        ),
    ],
)
def test_what_is_asked_last_comes_to_the_same_as_all_asked_everywhere(
    tmp_path, criterion, monkeypatch
):
    study = with_travel(tmp_path, criterion)
    quick = wb.run(study).population
    full_way(monkeypatch)
    whole = wb.run(study).population
    assert (quick.margin < 0).any() and (quick.seat != quick.comfortable).any()
    for name in ("margin", "seat", "setting", "window", "sets"):
        assert np.array_equal(getattr(quick, name), getattr(whole, name), equal_nan=True), name
    assert np.array_equal(quick.reason, whole.reason) and quick.reasons == whole.reasons


def test_a_coarse_look_leaves_no_less_clear_than_a_fine_one_finds(tmp_path):
    """Of what the toy's pillar, lamp, glass and screen hide, from eyes that stand about."""
    study = study_of(tmp_path, "check: outline, rules: sight_ac_25_773_1, side: left, at_least: 97")
    (criterion,) = study.criteria
    region = cockpit_outline(criterion.rule_set, seat="left")
    scenery = scenery_of(study.environment)
    places = np.random.default_rng(5).uniform([-0.1, -0.3, 0.95], [0.4, 0.3, 1.2], (6, 3))
    eyes = given_eyes(places)
    for row in range(len(eyes)):
        fine = clear_view(scenery, eyes, region, row=row)
        coarse = clear_view(scenery, eyes, region, row=row, step=COARSE)
        assert coarse.most >= fine.clear and coarse.most - fine.clear < 0.12
