"""Changes spliced into the text of a study: what is not changed keeps its bytes."""

from __future__ import annotations

import difflib

import pytest
import yaml

from tests.conftest import ROOT
from workbench.errors import InputError
from workbench.files.study.splice import (
    AxisAngle,
    JointChange,
    MovedChange,
    PostureChange,
    SeatChange,
    spliced,
)
from workbench.files.yaml_edits import SharedValueError
from workbench.files.yaml_marks import marked, walked
from workbench.files.yaml_text import parse_yaml
from workbench.model.moves import Move

STUDIES = sorted((ROOT / "studies").glob("*.yaml"))
BEND = AxisAngle(("flexion", "extension"), 70.0)
TURN = AxisAngle(("medial_rotation", "lateral_rotation"), -12.5)
ELBOW = JointChange(0, "a", "RE", (BEND,))

FLOW = """# a comment
length: mm
people: {a: {body: b, seat: left, position: reference}}   # who
cases:
  - {name: one, people: {a: {posture: flying}}}  # the first
  - name: two
    people:
      a:
        posture: flying   # as before
        angles:           # some
          LH RH: {flexion: 84, abduction: 2}   # hips
          RE: {extension: 5}   # straight
"""
SHARED = """length: mm
cases:
  - {name: one, people: {a: {posture: flying, angles: &bent {RE: {flexion: 75}}}}}
  - {name: two, people: {a: {posture: flying, angles: *bent}}}
  - {name: three, people: {a: {posture: flying, angles: *bent}}}
"""


def values(text):
    return parse_yaml(text, "made.yaml").value


def angles(text, case):
    return values(text)["cases"][case]["people"]["a"]["angles"]


def changed_lines(before, after):
    rows = difflib.ndiff(before.splitlines(), after.splitlines())
    return [row for row in rows if row[0] in "+-"]


def test_a_new_joint_makes_a_mapping_of_angles_in_the_case_alone():
    after = spliced(FLOW, [ELBOW])
    assert changed_lines(FLOW, after) == [
        "-   - {name: one, people: {a: {posture: flying}}}  # the first",
        "+   - {name: one, people: {a: {posture: flying, angles: {RE: {flexion: 70}}}}}  # the first",
    ]


def test_an_angle_of_the_other_sense_takes_the_motions_name_and_keeps_the_comment():
    after = spliced(FLOW, [JointChange(1, "a", "RE", (BEND,))])
    assert "          RE: {flexion: 70}   # straight\n" in after
    assert len(changed_lines(FLOW, after)) == 2


def test_a_key_of_two_joints_is_split_where_one_of_them_changes():
    hip = JointChange(1, "a", "LH", (AxisAngle(("flexion", "extension"), 80.0),))
    after = spliced(FLOW, [hip])
    assert angles(after, 1) == {
        "RH": {"flexion": 84, "abduction": 2},
        "LH": {"abduction": 2, "flexion": 80},
        "RE": {"extension": 5},
    }
    assert "# hips" in after and "# some" in after


def test_a_joint_that_is_not_there_gets_a_line_in_the_mappings_own_style():
    after = spliced(FLOW, [JointChange(1, "a", "LS", (TURN,))])
    assert changed_lines(FLOW, after) == ["+           LS: {lateral_rotation: 12.5}"]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("position: reference", "position: {forward: 12.5, up: 0}"),
        ("position: {up: 3, tilt: 2}", "position: {up: 0, tilt: 2, forward: 12.5}"),
        ('position: {forward: "1 cm"}', "position: {forward: 12.5, up: 0}"),
    ],
)
def test_a_seat_is_put_where_it_was_and_its_tilt_stays(before, after):
    text = FLOW.replace("position: reference", before)
    assert after in spliced(text, [SeatChange("a", 0.0125, 0.0)])


def test_a_seat_without_a_position_gets_one_in_the_files_unit():
    text = FLOW.replace(", position: reference", "").replace("length: mm", "length: in")
    after = spliced(text, [SeatChange("a", 0.0254, -0.0127)])
    assert "seat: left, position: {forward: 1, up: -0.5}}" in after


def test_a_predicted_posture_becomes_a_given_one_in_its_own_style():
    flow = FLOW.replace("{posture: flying}", "{predicted: {like: driving}}")
    change = PostureChange(0, "a", "driving", {"RE": (BEND,), "LS": (TURN,)})
    after = spliced(flow, [change])
    words = "{a: {posture: driving, angles: {RE: {flexion: 70}, LS: {lateral_rotation: 12.5}}}}"
    assert words in after
    block = "length: mm\ncases:\n  - people:\n      a:\n        predicted: {like: driving} # so\n"
    assert spliced(block, [change]).endswith(
        "        posture: driving\n"
        "        angles: {RE: {flexion: 70}, LS: {lateral_rotation: 12.5}} # so\n"
    )


def test_a_shared_value_is_asked_about():
    with pytest.raises(SharedValueError, match="shared by 3 places"):
        spliced(SHARED, [ELBOW])


def test_a_shared_value_is_changed_for_all():
    after = spliced(SHARED, [JointChange(1, "a", "RE", (BEND,))], sharing="all")
    assert [angles(after, case)["RE"]["flexion"] for case in range(3)] == [70, 70, 70]
    assert "&bent" in after and after.count("*bent") == 2


@pytest.mark.parametrize("case", [0, 1, 2])
def test_a_shared_value_is_changed_for_one_place_alone(case):
    after = spliced(SHARED, [JointChange(case, "a", "RE", (BEND,))], sharing="one")
    expected = [75, 75, 75]
    expected[case] = 70
    assert [angles(after, k)["RE"]["flexion"] for k in range(3)] == expected
    assert after.count("&bent") == 1 and after.count("*bent") == 1


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_byte_order_mark_stay(ends, mark):
    before = mark + FLOW.replace("\n", ends)
    after = spliced(before, [ELBOW, JointChange(1, "a", "LS", (TURN,))])
    assert after.startswith(mark) and after.count("\r") == after.count("\n") * (ends == "\r\n")
    assert angles(after.removeprefix(mark), 1)["LS"] == {"lateral_rotation": 12.5}


def test_what_is_not_there_cannot_be_changed():
    with pytest.raises(InputError, match="no mapping stands there"):
        spliced(FLOW, [JointChange(7, "a", "RE", (BEND,))])


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_every_study_of_the_catalogue_is_marked_where_its_values_stand(path):
    text = path.read_bytes().decode()
    for node in walked(marked(text)):
        if node.kind == "scalar" and not node.anchor:
            raw = text[node.start : node.end]
            assert node.text == raw or raw[0] in "\"'" or "\n" in raw


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_every_study_of_the_catalogue_takes_a_position_and_a_joint(path):
    text = path.read_bytes().decode()
    before = values(text)
    role = next(iter(before["people"]))
    action = before["cases"][0]["people"][role]
    changes = [SeatChange(role, 0.01, 0.0)]
    if "posture" in action:
        changes.append(JointChange(0, role, "RE", (BEND,)))
    else:
        changes.append(PostureChange(0, role, "driving", {"RE": (BEND,)}))
    after = values(spliced(text, changes))
    assert after["people"][role].pop("position") == {"forward": 10, "up": 0}
    assert after["cases"][0]["people"][role].pop("angles")["RE"]["flexion"] == 70
    before["people"][role].pop("position", None)
    for value in (before, after):
        value["cases"][0]["people"].pop(role)
    assert after == before


MOVED = """length: cm
environment: cab  # of steel
moved:  # by the bench
  - {parts: [a], by: [1, 0, 0]}  # first
  - controls: [b]
    by: [0, 2, 0]  # second
cases: []
"""


def test_a_displacement_is_changed_in_its_own_entry():
    before = (Move(("a",), (), (0.01, 0.0, 0.0)), Move((), ("b",), (0.0, 0.02, 0.0)))
    after = (before[0], Move((), ("b",), (0.0, 0.025, 0.0)), Move(("c d",), (), (0.0, 0.0, 0.1)))
    found = spliced(MOVED, [MovedChange(before, after)])
    assert found == MOVED.replace("by: [0, 2, 0]", "by: [0, 2.5, 0]").replace(
        "# second\n", '# second\n  - {parts: ["c d"], by: [0, 0, 10]}\n'
    )
    flow = "length: mm\nenvironment: cab\nmoved: [{parts: [a], by: [10, 0, 0]}]\n"
    found = spliced(flow, [MovedChange(before[:1], before)])
    assert (
        "moved: [{parts: [a], by: [10, 0, 0]}, {controls: [b], alone: true, by: [0, 20, 0]}]\n"
        in found
    )


def test_a_list_of_moves_is_made_or_made_anew():
    one = Move(("a",), (), (0.01, 0.0, 0.0))
    other = Move((), ("b",), (0.0, 0.02, 0.0))
    plain = "length: mm\r\nenvironment: cab  # of steel\r\ncases: []\r\n"
    found = spliced(plain, [MovedChange((), (one,))])
    line = "environment: cab  # of steel\r\nmoved: [{parts: [a], by: [10, 0, 0]}]\r\n"
    assert found == plain.replace("environment: cab  # of steel\r\n", line)
    found = spliced(MOVED, [MovedChange((one, other), (other,))])
    assert yaml.safe_load(found)["moved"] == [{"controls": ["b"], "alone": True, "by": [0, 2, 0]}]
    assert yaml.safe_load(spliced(MOVED, [MovedChange((one, other), ())]))["moved"] == []
