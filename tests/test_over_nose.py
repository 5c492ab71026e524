"""The angle below level that is seen straight ahead, on a cockpit of boxes whose edges are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.crowds import crowd_of
from tests.toy_cockpit import STUDY, write_toy
from workbench import load_study
from workbench.report.sentences import finding_words

PEOPLE = 8
HEAD = STUDY.split("criteria:")[0] + "criteria:\n"
PANEL = "  - {name: nose, check: over_nose, down: 9, parts: [panel]}\n"
PANEL_TOP = np.array([1.52, 0.9])
"""[m] x and z of the panel's rear upper edge, over which one looks."""


def asked(*criteria):
    return HEAD + "".join(f"  - {{{text}}}\n" for text in criteria)


def one_person(folder, text, *, room=lambda text: text):
    """The verdicts of an adult man in the toy cockpit."""
    study = text.replace(
        "{body: adult_male, detail: coarse, seat: pilot, population: {people: PEOPLE, seed: 3}}",
        "{body: adult_male, detail: coarse, seat: pilot}",
    )
    path = write_toy(folder, study=study)
    file = folder / "environments/toy/environment.yaml"
    file.write_text(room(file.read_text()))
    result = wb.run(load_study(path))
    return result.postures[0].verdicts


@pytest.fixture(scope="module")
def people(tmp_path_factory):
    """Where the eyes of some people are, and how far down they look over the panel [degrees]."""
    path = write_toy(tmp_path_factory.mktemp("toy"), people=PEOPLE, study=HEAD + PANEL)
    crowd = crowd_of(path)
    eyes = []
    for body in crowd.bodies[:]:
        placed = wb.place(body, crowd.seated(body, [0]).poses)
        pair = [placed.centres[0, body.sphere_names.index(f"{s} eye")] for s in ("left", "right")]
        eyes.append(np.mean(pair, axis=0))
    found = wb.run(crowd.study).population
    return np.array(eyes), np.degrees(found.margin[:, 0] / 0.2) + 9.0


def test_the_angle_is_that_of_the_line_from_the_eyes_to_the_rear_edge(people):
    eyes, down = people
    wanted = np.arctan2(eyes[:, 2] - PANEL_TOP[1], PANEL_TOP[0] - eyes[:, 0])
    assert np.allclose(down, np.degrees(wanted), atol=1e-6)


@settings(max_examples=6, deadline=None)
@given(st.floats(2.0, 15.0))
def test_who_looks_over_the_nose_is_high_enough_to_view_over_the_parts(tmp_path_factory, down):
    parts = f"down: {down:.6f}, parts: [panel, pan]"
    text = asked(f"name: a, check: over_nose, {parts}", f"name: b, check: view_over, {parts}")
    path = write_toy(tmp_path_factory.mktemp("law"), people=PEOPLE, study=text)
    found = wb.run(load_study(path)).population
    assert np.array_equal(found.met[:, 0], found.met[:, 1])
    assert np.array_equal(np.sign(found.margin[:, 0]), np.sign(found.margin[:, 1]))


def test_without_parts_whatever_is_opaque_counts_but_not_the_roof_above(tmp_path):
    every, panel = one_person(
        tmp_path,
        asked(
            "name: every, check: over_nose, down: 5",
            "name: panel, check: over_nose, down: 5, parts: [panel]",
        ),
    )
    assert every.worst.value == pytest.approx(panel.worst.value, abs=1e-12)
    assert every.worst.target == "panel" and every.worst.point == pytest.approx((1.52, 0, 0.9))


def test_through_glass_one_looks_on_to_the_seat_pan(tmp_path):
    def glass(text):
        return text.replace("parts:\n", "parts:\n  panel: {see_through: true}\n", 1)

    (verdict,) = one_person(tmp_path, asked("name: a, check: over_nose, down: 5"), room=glass)
    assert verdict.worst.target == "pan" and math.degrees(verdict.worst.value) > 45


def test_a_panel_higher_than_the_eyes_stands_above_level(tmp_path):
    def low(text):
        return text.replace("srp: [0, 0, 300]", "srp: [0, 0, -50]").replace("1050]", "700]")

    verdict = one_person(tmp_path, asked("name: a, check: over_nose, down: 5"), room=low)[-1]
    assert not verdict.passed and verdict.worst.value < 0
    words = finding_words("over_nose", verdict.worst)
    up = math.degrees(-verdict.worst.value)
    assert words == (
        f"panel stands before the eyes up to {up:.1f} degrees above level, {up + 5:.1f} degrees less "
        "than the 5.0 degrees asked for"
    )


def test_the_part_is_proposed_to_be_lowered_by_as_much_as_for_a_view_over_it(tmp_path):
    gains = []
    for check in ("over_nose", "view_over"):
        text = asked(f"name: nose, check: {check}, parts: [panel], down: 9")
        path = write_toy(tmp_path / check, people=PEOPLE, study=text)
        found = wb.run(load_study(path)).population
        gains.append(next(g for g in found.gains if g.words.startswith("moving panel")))
    assert gains[0].words == gains[1].words and gains[0].words.endswith("mm down")
    assert gains[0].before < 1.0 == gains[0].after == gains[1].after


@pytest.mark.parametrize(
    ("criterion", "said"),
    [
        ("name: a, check: over_nose", "check: over_nose needs 'down'"),
        ("name: a, check: over_nose, down: -5", "'down' of check: over_nose is 0 to 89 degrees"),
        ("name: a, check: over_nose, down: 5, parts: [nose]", "nothing is called 'nose'"),
        ("name: a, check: over_nose, down: 5, at_least: 5", "'at_least' does not belong"),
    ],
)
def test_wrong_keys_are_told(tmp_path, criterion, said):
    with pytest.raises(wb.InputError, match=said):
        load_study(write_toy(tmp_path, study=asked(criterion)))
