"""People who stand, and step within an area."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import BOX, BOX_FACES
from tests.crowds import crowd_of
from workbench.errors import InputError
from workbench.model.workplace import Stand
from workbench.report.population.sentences import population_headline
from workbench.study.checks.table import margins_of, most_of, same_everywhere
from workbench.study.positions import comfortable_situations, in_positions

DESK = {
    "floor": ((-1.5, -1.5, -0.1), (1.5, 1.5, 0)),
    "top": ((0.35, -0.8, 0.87), (1.05, 0.8, 0.9)),
}
ENVIRONMENT = """environment: desk
length: mm
meshes:
  - {file: desk.obj, length: m, up: z, forward: x}
parts:
  floor: {allow: [{segments: all, depth: 5}]}
controls:
  right: {at: [500, -250, 920], grip: push, zone: 1, part: top}
  left: {at: [500, 250, 920], grip: push, zone: 1, part: top}
  aside: {at: [500, -700, 920], grip: push, zone: 1, part: top}
  far: {at: [1000, 0, 920], grip: push, zone: 1, part: top}
"""
BENT = """study: bending
length: mm
environment: environment.yaml
people:
  worker: {body: adult_male, stand: {on: [0, 0, 0]AREA}PEOPLE}
cases:
  - {name: at work, people: {worker: {predicted: {hands: {left: far}}}}}
criteria:
  - {name: joints, check: stops, at_least: 0}
"""
STUDY = """study: at_the_desk
length: mm
environment: environment.yaml
people:
  worker: {body: adult_male, stand: {on: [100, 0, 0]AREA}PEOPLE}
cases:
  - {name: standing, people: {worker: {posture: standing}}}
criteria:
  - {name: reaches, check: reach, controls: [CONTROLS]}
"""


@pytest.fixture
def desk(tmp_path):
    lines = []
    for k, (name, (low, high)) in enumerate(DESK.items()):
        size = np.subtract(high, low)
        lines += [f"o {name}", *("v {} {} {}".format(*(low + size * c)) for c in BOX)]
        lines += ["f " + " ".join(str(8 * k + 1 + v) for v in face) for face in BOX_FACES]
    (tmp_path / "desk.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "environment.yaml").write_text(ENVIRONMENT)
    return tmp_path


def answered(desk, *, controls="right", area="", people="", more=""):
    area = f", area: {area}" if area else ""
    text = STUDY.replace("AREA", area).replace("PEOPLE", people).replace("CONTROLS", controls)
    (desk / "study.yaml").write_text(text + more)
    return wb.run(wb.load_study(desk / "study.yaml"))


def stands_at(result):
    (found,) = result.postures
    placed = found.people[0].placed
    return 1000 * placed.world_from_segment[0, placed.body.segment("LT"), :2, 3]


def test_who_reaches_everything_does_not_step(desk):
    area = "{forward: [-100, 200], left: [-500, 500]}"
    assert stands_at(answered(desk, area=area)) == pytest.approx([100, 0], abs=1e-6)


def test_who_misses_a_control_steps_to_it_and_the_result_says_how_far(desk):
    stays = answered(desk, controls="aside")
    assert not stays.passed
    steps = answered(desk, controls="aside", area="{left: [-600, 600]}")
    assert steps.passed
    ahead, aside = stands_at(steps)
    assert ahead == pytest.approx(100) and -600 <= aside < -100
    (line,) = [line for line in steps.warnings if "the person stands" in line]
    assert f"{-aside:.0f} mm to the right of the stated place" in line


def test_a_mirrored_area_is_stepped_in_to_the_other_side(desk):
    right = stands_at(answered(desk, controls="right, aside", area="{left: [-600, 0]}"))
    text = (desk / "environment.yaml").read_text()
    mirrored = text.replace("-250", "+").replace(" 250", " -250").replace("+", "250")
    (desk / "environment.yaml").write_text(mirrored.replace("-700", "700"))
    left = stands_at(answered(desk, controls="right, aside", area="{left: [0, 600]}"))
    assert left == pytest.approx(right * [1, -1], abs=1e-3)


def test_who_misses_what_is_the_same_everywhere_still_stands_where_the_rest_is_met(desk):
    joints = "  - {name: joints, check: stops, at_least: 100}\n"
    found = answered(desk, controls="aside", area="{left: [-600, 600]}", more=joints)
    assert [verdict.passed for verdict in found.verdicts] == [True, False]
    assert any(
        "every requirement that depends on where the person stands is met" in line
        for line in found.warnings
    )


def test_nobody_has_more_to_spare_than_the_length_of_the_arms_allows(desk):
    answered(desk, people=", population: {source: ansur2, people: 2, seed: 1}")
    joints = "  - {name: joints, check: stops, at_least: 0}\n"
    text = (desk / "study.yaml").read_text().replace("right]", "right, left, aside, far]")
    (desk / "study.yaml").write_text(text + joints)
    crowd = crowd_of(desk / "study.yaml")
    rows = np.repeat([0, 1], 30)
    place, asked = crowd.question.place, crowd.question.asked
    who = crowd.occupants(crowd.bodies[rows], rows)
    spots = np.random.default_rng(0).uniform([-1.0, -1.0], [0.2, 1.0], (60, 2))
    there = in_positions(place, who, spots, comfortable_situations(place, who))
    found = margins_of(there, asked).margin
    most = most_of(there, asked)
    assert (found <= most + 1e-9).all() and (most[:, :4] < 0).mean() > 0.3
    np.testing.assert_allclose(found[:, 4], found[rows * 30, 4], atol=1e-9)
    assert [same_everywhere(place, one) for one in asked] == [False] * 4 + [True]


def test_left_and_ahead_are_those_of_the_heading():
    stand = Stand((1.0, 2.0, 0.5), np.radians(90), (0, 1), (0, 1))
    floor = stand.floor(np.array([[0.3, 0.0], [0.0, 0.2]]))
    np.testing.assert_allclose(floor, [[1.0, 2.3, 0.5], [0.8, 2.0, 0.5]], atol=1e-12)


def test_more_of_a_population_fit_where_they_may_step(desk):
    people = ", population: {source: ansur2, people: 5, seed: 1}"
    stays = answered(desk, controls="left, far", people=people)
    steps = answered(desk, controls="far", people=people, area="{forward: [0, 400]}")
    assert not stays.population.served.any() and steps.population.served.all()
    assert (steps.population.seat[:, 0] >= 0.1).all()
    assert (steps.population.seat[:, 1] == 0).all()


def test_a_move_is_proposed_that_lets_people_stand_where_they_gave_way_to_another_control(desk):
    text = (desk / "environment.yaml").read_text().replace("[500, 250, 920]", "[400, 550, 920]")
    (desk / "environment.yaml").write_text(text)
    found = answered(
        desk,
        controls="aside, left",
        people=", population: {source: ansur2, people: 2, seed: 1}",
        area="{left: [-200, 0]}",
    ).population
    # between the two everybody lacks some 12 mm to either: nothing is gained there by one of them
    assert not found.served.any() and (found.margin < -0.005).all()
    assert any(" and " not in one.words and one.joint_after > 0.4 for one in found.gains)
    assert not set(found.limiting) & {"hand_length", "acromial_height_sitting"}


ENDS = [
    ("far", ("{{forward: [-100, {}]}}", 280), 1, "front", "forward"),
    ("aside", ("{{left: [{}, 300]}}", -60), -1, "right", "to the right"),
]


@pytest.mark.parametrize(("control", "area", "way", "end", "word"), ENDS)
def test_an_end_of_the_area_that_keeps_people_out_is_named_and_its_going_on_proposed(
    desk, control, area, way, end, word
):
    people = ", population: {source: ansur2, people: 3, seed: 1}"
    text, at = area
    found = answered(desk, controls=control, area=text.format(at), people=people).population
    assert not found.served.any()
    named = f"all of them stand at the {end} end of the area in which they may step"
    assert named in population_headline(found)
    gain = next(one for one in found.gains if f"mm farther {word}" in one.words)
    assert gain.words == f"letting people step {1000 * gain.move:.0f} mm farther {word}"
    longer = text.format(at + way * round(1000 * gain.move))
    again = answered(desk, controls=control, area=longer, people=people).population
    assert 0 < gain.joint_after == pytest.approx(again.shares[0].share)


def test_maps_and_envelopes_need_no_seat(desk):
    more = "reach_envelopes: [{people: worker, hand: right}]\n"
    (found,) = answered(desk, more=more).postures
    (envelope,) = found.envelopes
    assert envelope.origin_name == "shoulder" and 0.3 < envelope.volume < 1.5
    people = ", population: {source: ansur2, people: 3, seed: 1}"
    more = "reach_maps: [{people: worker, part: top, points: 60}]\n"
    (reached,) = answered(desk, people=people, more=more).population.maps
    near = reached.points[:, 0] < 0.5
    assert reached.share[near].mean() > 0.4 > reached.share[~near].mean()


def zone_three(desk, *, on="-250, 0, 0", area="", wall=None):
    """Whether the far control is reached in zone 3 by who stands so far away, and the row of it."""
    text = (desk / "environment.yaml").read_text()
    text = text.replace(
        "far: {at: [1000, 0, 920], grip: push, zone: 1",
        "far: {at: [1000, 0, 920], grip: push, zone: 3",
    )
    (desk / "environment.yaml").write_text(text)
    if wall is not None:
        low, size = np.array(wall[0]), np.subtract(wall[1], wall[0])
        lines = ["o wall", *("v {} {} {}".format(*(low + size * c)) for c in BOX)]
        lines += ["f " + " ".join(str(17 + v) for v in face) for face in BOX_FACES]
        with (desk / "desk.obj").open("a") as mesh:
            mesh.write("\n".join(lines) + "\n")
    area = f", area: {area}" if area else ""
    study = STUDY.replace("AREA", area).replace("PEOPLE", "").replace("CONTROLS", "far")
    (desk / "study.yaml").write_text(study.replace("100, 0, 0", on))
    (found,) = wb.run(wb.load_study(desk / "study.yaml")).postures
    return found, {row.zone: row for row in found.reaches}


def test_in_zone_3_who_stands_bends_over_still_feet(desk):
    found, rows = zone_three(desk)
    assert not rows[1].reached and not rows[2].reached and rows[3].reached
    assert rows[2].miss > 0.4  # far beyond what the trunk gives over a still pelvis
    assert found.verdicts[-1].passed and not found.people[0].forward
    assert not zone_three(desk, on="-700, 0, 0")[1][3].reached


def test_in_zone_3_who_stands_steps_within_the_area_for_a_control(desk):
    found, rows = zone_three(desk, on="-700, 0, 0", area="{forward: [0, 600]}")
    assert rows[3].reached and rows[2].miss > 0.8
    assert not found.people[0].forward  # for one control, and back


def test_who_bends_stays_out_of_parts_with_trunk_and_legs(desk):
    low, high = (0.3, -0.8, 0.9), (0.34, 0.8, 1.25)  # before the belly, the arm goes over it
    _, rows = zone_three(desk, on="-100, 0, 0")
    assert rows[3].reached
    _, rows = zone_three(desk, on="-100, 0, 0", wall=(low, high))
    assert not rows[3].reached and rows[3].limit.part in ("wall", "top")


def bent(desk, *, area="", people="", text=BENT):
    area = f", area: {area}" if area else ""
    (desk / "study.yaml").write_text(text.replace("AREA", area).replace("PEOPLE", people))
    return wb.run(wb.load_study(desk / "study.yaml"))


def fingertip_to(placed, target):
    arm = wb.limb(placed.body, "left hand", grip="push")
    hand = placed.world_from_segment[0, arm.end]
    return np.linalg.norm(hand[:, :3] @ arm.tip[0] + hand[:, 3] - target)


def test_a_predicted_stander_bends_to_the_control_in_balance_with_flat_feet(desk):
    (found,) = bent(desk).postures
    placed = found.people[0].placed
    assert fingertip_to(placed, (1.0, 0.0, 0.92)) < 1e-4
    assert wb.balance(placed).margin[0] > 0.005
    feet = placed.world_from_segment[0, [placed.body.segment(name) for name in ("LF", "RF")]]
    np.testing.assert_allclose(feet[:, :, :3], np.tile(np.eye(3), (2, 1, 1)), atol=2e-3)
    assert found.people[0].margin.min() > -1e-6
    assert not any("stays" in line for line in found.warnings)


def test_a_predicted_stander_steps_to_where_it_is_comfortable(desk):
    (stays,) = bent(desk).postures
    (steps,) = bent(desk, area="{forward: [0, 300]}").postures
    assert 0.1 < steps.people[0].forward <= 0.3 and steps.people[0].up == 0
    hips = [
        abs(wb.model.joint_angles.angles_of(p.placed.body, p.poses)[0]).max()
        for p in (stays.people[0], steps.people[0])
    ]
    assert hips[1] < hips[0]
    assert fingertip_to(steps.people[0].placed, (1.0, 0.0, 0.92)) < 1e-4


def test_everybody_of_a_population_bends_to_the_control(desk):
    # upright the crown of the head is 650 mm and more over the desk, and 300 mm before it
    people = ", population: {source: ansur2, people: 4, seed: 1}"
    clearance = "check: clearance, segments: [H], parts: [top], at_least: "
    upright = BENT.replace("predicted: {hands: {left: far}}", "posture: standing")
    near, far = (
        bent(desk, people=people, text=text.replace("check: stops, at_least: 0", clearance + "300"))
        for text in (BENT, upright)
    )
    assert (near.population.margin < far.population.margin - 0.05).all()
    assert near.population.served.all()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("hands: {left: far}", "hands: {left: far}, eyes: e", "leave 'eyes' out"),
        ("hands: {left: far}", "like: standing", "where they go; give 'hands'"),
        ("stand: {on: [0, 0, 0]AREA}", "at: {segment: LT, position: [0, 0, 900]}", "or who stands"),
    ],
)
def test_what_is_not_predicted_of_a_stander_says_what_is(desk, old, new, words):
    with pytest.raises(InputError, match=words):
        bent(desk, text=BENT.replace(old, new))


@pytest.mark.parametrize(
    ("area", "words"),
    [
        ("{forward: [100, 300]}", "0 or negative, to how far"),
        ("{left: [-1500, 1500]}", "2 m wide at most"),
        ("{up: [0, 100]}", "up"),
    ],
)
def test_an_area_that_is_none_says_what_one_is(desk, area, words):
    with pytest.raises(InputError, match=words):
        answered(desk, area=area)
