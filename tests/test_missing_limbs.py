"""People with a limb missing, a prosthesis or joints that turn less: everything works without the limb."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.made_studies import found_of
from tests.toy_cockpit import write_toy
from workbench import InputError
from workbench.report.words import person_words

ROLE = "{body: adult_male, detail: coarse, seat: pilot, population: {people: PEOPLE, seed: 3}}"
ALONE = "{body: adult_male, seat: pilot, without: [LLL, LF]}"
KEPT = """
  - {name: nothing entered, check: contact}
  - {name: he himself, check: self_contact}
  - {name: stops, check: stops}
"""


def study_of(folder, role, changes=None):
    """The toy's study with another role and more criteria."""
    path = write_toy(
        folder, knob=450, people=4, swap={ROLE.replace("PEOPLE", "4"): role} | (changes or {})
    )
    path.write_text(path.read_text().rstrip() + KEPT)
    return wb.load_study(path)


@pytest.fixture(scope="module")
def sitter(tmp_path_factory):
    return found_of(study_of(tmp_path_factory.mktemp("limb"), ALONE))


def test_a_sitter_without_a_lower_leg_is_measured_and_told(sitter):
    whole = wb.load_body("adult_male")
    body = sitter.people[0].body
    assert not (body.has("LLL") or body.has("LF")) and body.has("RF")
    gone = [whole.segment(name) for name in ("LLL", "LF")]
    assert float(body.mass.sum()) == pytest.approx(
        float(whole.mass.sum() - whole.mass[0, gone].sum()), rel=0.01
    )
    touched = {finding.subject for verdict in sitter.verdicts for finding in verdict.breaches}
    assert not any("left foot" in subject or "left lower leg" in subject for subject in touched)
    assert len(sitter.verdicts) == 6 and all(verdict.worst for verdict in sitter.verdicts[:2])
    assert "no left lower leg, left foot" in person_words(sitter.people[0])


@pytest.mark.parametrize(
    ("role", "said"),
    [
        ("without: [LUL]", "people.pilot.without: without LUL nothing holds LLL: name it too"),
        ("without: [H]", "people.pilot.without: 'H' is no segment of a limb"),
        (
            "stops: {RK: {flexion: 170}}",
            "stops.RK: joint RK: flexion ends at 135 degrees; it can be",
        ),
        ("stops: {RK: {bending: 20}}", "stops.RK: joint RK: no motion 'bending'"),
        ("stops: {XX: 50 %}", "stops.XX: .*no joint 'XX'"),
        ("stops: {RK: half}", "stops.RK"),
    ],
)
def test_a_wrong_limb_or_stop_is_told_with_its_place(tmp_path, role, said):
    with pytest.raises(InputError, match=said):
        study_of(tmp_path, f"{{body: adult_male, seat: pilot, {role}}}")


def test_stops_are_stated_in_degrees_or_by_share_and_carry_the_limits_that_depend_on_others(
    tmp_path,
):
    role = "{body: adult_male, seat: pilot, stops: {RK: {flexion: 70}, LS RS: 50 %, LE: {flexion: 25 %}}}"
    made = study_of(tmp_path, role).roles[0].body
    whole = wb.load_body("adult_male")
    share = made.stops.limits / np.where(whole.stops.limits == 0, 1, whole.stops.limits)
    assert np.degrees(made.stops.limits[made.joint("RK"), 0, 0]) == pytest.approx(70)
    assert share[made.joint("RS")] == pytest.approx(np.full((3, 2), 0.5))
    assert share[made.joint("LE"), 0, 0] == pytest.approx(0.25)
    assert share[made.joint("LK")].max() == 1.0
    reach = [k.limit for k in made.stops.couplings if k.joint == made.joint("LS")]
    before = [k.limit for k in whole.stops.couplings if k.joint == made.joint("LS")]
    assert np.array(reach) == pytest.approx(0.5 * np.array(before))


def test_a_missing_hand_that_is_asked_for_is_named(tmp_path):
    role = "{body: adult_male, detail: coarse, seat: pilot, without: [RLA, RHN]}"
    with pytest.raises(InputError, match="has no right hand: it is missing"):
        found_of(study_of(tmp_path, role))
    either = {"controls: [knob, near], hand: right": "controls: [knob, near]"}
    found = found_of(study_of(tmp_path, role, either))
    assert "left hand" in found.verdicts[0].worst.subject


PROSTHESIS = """
encumbrance: below knee prosthesis
description: a tube and a foot in place of the lower leg
source: assumption
length: mm
without: [LLL, LF]
layers:
  - {segments: [LLL], thickness: -15}
  - {segments: [LF]}
mass: {LLL: 1.0, LF: 0.6}
"""


def test_a_prosthesis_is_a_limb_of_other_spheres_mass_and_stops(tmp_path):
    (tmp_path / "leg.yaml").write_text(PROSTHESIS)
    role = f"{{body: adult_male, seat: pilot, clothes: [{tmp_path}/leg.yaml], stops: {{LA: 20 %}}}}"
    study = study_of(tmp_path, role)
    made = found_of(study).people[0].body
    whole = wb.load_body("adult_male")
    n = whole.segment("LLL")
    assert made.radius[0, made.spheres(n)] == pytest.approx(
        whole.radius[0, whole.spheres(n)] - 0.015
    )
    assert made.mass[0, n] == pytest.approx(1.0)
    assert made.has("LF") and made.stops.limits[made.joint("LA")].max() < 0.3


@pytest.mark.nightly
def test_a_population_without_a_lower_leg_sits_and_is_judged(tmp_path):
    role = ROLE.replace("PEOPLE", "4").replace("seat:", "without: [LLL, LF], seat:")
    result = wb.run(study_of(tmp_path, role))
    assert all(verdict.share is not None or verdict.worst for verdict in result.verdicts[:3])
