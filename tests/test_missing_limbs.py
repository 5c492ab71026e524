"""People with a limb missing, a prosthesis or joints that turn less: everything works without the limb."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

import workbench as wb
from tests.conftest import ROOT
from tests.made_studies import found_of
from tests.toy_cockpit import write_toy
from workbench import InputError
from workbench.report.joint_angles import angle_rows
from workbench.report.sentences import person_words

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


def test_joints_of_a_missing_limb_have_neither_stop_nor_angle(sitter):
    person = sitter.people[0]
    body = person.body
    gone = [body.joint(name) for name in ("LK", "LA")]
    assert np.isinf(person.margin[:, gone]).all()
    assert np.isfinite(person.margin[:, [body.joint("RK"), body.joint("LH")]]).all()
    bent = {name: {"flexion": 90.0} for name in ("LK", "RK", "LA")}
    assert [row[0] for row in angle_rows(body, [bent])] == ["right knee"]


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


def without_leg(folder, *, kept):
    """The median man's file without his left lower leg: kept as empty segments, or not at all."""
    file = yaml.safe_load((ROOT / "bodies" / "adult_male.yaml").read_text())
    for key in ("basis", "basis_at"):
        del file[key]
    for name in ("LLL", "LF"):
        rest = {"mass": 0.0, "spheres": []}
        own = {k: v for k, v in file["segments"][name].items() if k != "blend"} | rest
        file["segments"][name] = own
        if not kept:
            del file["segments"][name]
    if not kept:
        del file["joints"]["LK"], file["joints"]["LA"], file["segments"]["LUL"]["blend"]["LK"]
        file["allowances"] = []
    path = folder / "amputee.yaml"
    path.write_text(yaml.safe_dump(file, sort_keys=False))
    return path


def test_a_body_file_keeps_the_segments_of_a_missing_limb_without_spheres(tmp_path):
    body = wb.load_body(without_leg(tmp_path, kept=True))
    assert not body.has("LLL") and body.has("RLL") and "LK" in body.joints
    study = study_of(tmp_path, f"{{body: {tmp_path}/amputee.yaml, seat: pilot}}")
    assert found_of(study).verdicts[2].worst is not None


def test_a_body_file_with_a_limb_on_one_side_only_is_told_how_to_say_so(tmp_path):
    path = without_leg(tmp_path, kept=False)
    with pytest.raises(InputError, match=r"segments.RLL: a person has LLL too: .*'spheres: \[\]'"):
        wb.load_body(path)


def test_measures_of_a_body_without_a_foot_are_taken_over_the_other(tmp_path):
    body = wb.load_body(without_leg(tmp_path, kept=True))
    high = wb.measure(wb.load_body("adult_male"), ["stature"])["stature"]
    assert wb.measure(body, ["stature"])["stature"] == pytest.approx(high, abs=1e-6)
    assert wb.measure(body, ["foot_length"])["foot_length"] > 0.2  # of the right foot


DRIVER = """
study: driver
length: mm
environment: compact_car
people:
  driver: {body: adult_male, seat: driver, without: [LLL, LF]}
cases:
  - name: driving
    people:
      driver: {driver: {wheel: wheel_centre, h_point: driver_h_point, seed: 11, sex: male, eyes: low_eye,
        heels: accelerator_heel, hands: {left: wheel_ten, right: wheel_two}, feet: {right: accelerator}}}
criteria:
  - {name: feet, check: pedals}
  - {name: brake, check: reach, controls: [brake]}
"""


@pytest.mark.nightly
def test_a_driver_without_a_left_leg_drives_and_his_left_foot_cannot_be_asked(tmp_path):
    path = tmp_path / "driver.yaml"
    path.write_text(DRIVER)
    found = found_of(wb.load_study(path))
    assert [verdict.passed for verdict in found.verdicts] == [True, True]
    path.write_text(DRIVER.replace("feet: {right", "feet: {left: foot_rest, right"))
    with pytest.raises(InputError, match="no left foot: it is missing"):
        found_of(wb.load_study(path))


@pytest.mark.nightly
def test_a_population_without_a_lower_leg_sits_and_is_judged(tmp_path):
    role = ROLE.replace("PEOPLE", "4").replace("seat:", "without: [LLL, LF], seat:")
    result = wb.run(study_of(tmp_path, role))
    assert all(verdict.share is not None or verdict.worst for verdict in result.verdicts[:3])
