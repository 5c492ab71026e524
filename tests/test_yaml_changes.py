"""Changes of the text of a study: what is not changed keeps its bytes."""

from __future__ import annotations

import difflib
import json

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT
from workbench.files.yaml_changes import SharedValueError, changed_text, marked, walked
from workbench.files.yaml_text import parse_yaml
from workbench.model.surroundings import Move
from workbench.study.bench.saving import with_joint, with_moves, with_position

STUDIES = sorted((ROOT / "studies").glob("*.yaml"))
BEND = {("flexion", "extension"): 70.0}
TURN = {("medial_rotation", "lateral_rotation"): -12.5}

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


def bent(text, case, joint, angle, *, role="a", sharing="ask"):
    """The text with angles of one joint in a case."""
    says = values(json.dumps(values(text)))
    with_joint(says["cases"][case]["people"][role], joint, angle)
    return changed_text(text, says, sharing=sharing)


def seated(text, role, position, scale):
    says = values(text)
    with_position(says["people"][role], position, scale)
    return changed_text(text, says)


def moved(text, before, after):
    return changed_text(text, with_moves(values(text), before, after))


def angles(text, case):
    return values(text)["cases"][case]["people"]["a"]["angles"]


def plain(value):
    """Values as they come back from a text."""
    return values(json.dumps(value))


def changed_lines(before, after):
    rows = difflib.ndiff(before.splitlines(), after.splitlines())
    return [row for row in rows if row[0] in "+-"]


def test_a_new_joint_makes_a_mapping_of_angles_in_the_case_alone():
    after = bent(FLOW, 0, "RE", BEND)
    assert changed_lines(FLOW, after) == [
        "-   - {name: one, people: {a: {posture: flying}}}  # the first",
        "+   - {name: one, people: {a: {posture: flying, angles: {RE: {flexion: 70}}}}}  # the first",
    ]


def test_an_angle_of_the_other_sense_takes_the_motions_name_and_keeps_the_comment():
    after = bent(FLOW, 1, "RE", BEND)
    assert "          RE: {flexion: 70}   # straight\n" in after
    assert len(changed_lines(FLOW, after)) == 2


def test_a_key_of_two_joints_is_split_where_one_of_them_changes():
    after = bent(FLOW, 1, "LH", {("flexion", "extension"): 80.0})
    assert angles(after, 1) == {
        "RH": {"flexion": 84, "abduction": 2},
        "LH": {"abduction": 2, "flexion": 80},
        "RE": {"extension": 5},
    }
    assert "# hips" in after and "# some" in after


def test_a_joint_that_is_not_there_gets_a_line_in_the_mappings_own_style():
    after = bent(FLOW, 1, "LS", TURN)
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
    assert after in seated(text, "a", (0.0125, 0.0), 0.001)


def test_a_seat_without_a_position_gets_one_in_the_files_unit():
    text = FLOW.replace(", position: reference", "").replace("length: mm", "length: in")
    after = seated(text, "a", (0.0254, -0.0127), 0.0254)
    assert "seat: left, position: {forward: 1, up: -0.5}}" in after


def test_a_predicted_posture_becomes_a_given_one_in_its_own_style():
    flow = FLOW.replace("{posture: flying}", "{predicted: {like: driving}}")
    driving = {
        "posture": "driving",
        "angles": {"RE": {"flexion": 70}, "LS": {"lateral_rotation": 12.5}},
    }

    def driven(text):
        says = values(text)
        says["cases"][0]["people"]["a"] = driving
        return changed_text(text, says)

    after = driven(flow)
    words = "{a: {posture: driving, angles: {RE: {flexion: 70}, LS: {lateral_rotation: 12.5}}}}"
    assert words in after
    block = "length: mm\ncases:\n  - people:\n      a:\n        predicted: {like: driving} # so\n"
    assert driven(block).endswith(
        "        posture: driving\n"
        "        angles: {RE: {flexion: 70}, LS: {lateral_rotation: 12.5}} # so\n"
    )


def test_a_shared_value_is_asked_about():
    with pytest.raises(SharedValueError, match="shared by 3 places"):
        bent(SHARED, 0, "RE", BEND)


def test_a_shared_value_is_changed_for_all():
    after = bent(SHARED, 1, "RE", BEND, sharing="all")
    assert [angles(after, case)["RE"]["flexion"] for case in range(3)] == [70, 70, 70]
    assert "&bent" in after and after.count("*bent") == 2


@pytest.mark.parametrize("case", [0, 1, 2])
def test_a_shared_value_is_changed_for_one_place_alone(case):
    after = bent(SHARED, case, "RE", BEND, sharing="one")
    expected = [75, 75, 75]
    expected[case] = 70
    assert [angles(after, k)["RE"]["flexion"] for k in range(3)] == expected
    assert after.count("&bent") == 1 and after.count("*bent") == 1


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_byte_order_mark_stay(ends, mark):
    before = mark + FLOW.replace("\n", ends)
    after = bent(bent(before, 0, "RE", BEND), 1, "LS", TURN)
    assert after.startswith(mark) and after.count("\r") == after.count("\n") * (ends == "\r\n")
    assert angles(after.removeprefix(mark), 1)["LS"] == {"lateral_rotation": 12.5}


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
    says = values(json.dumps(before))
    with_position(says["people"][role], (0.01, 0.0), 0.001)
    if "posture" not in action:
        says["cases"][0]["people"][role] = {"posture": "driving"}
    with_joint(says["cases"][0]["people"][role], "RE", BEND)
    after = values(changed_text(text, says))
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
    found = moved(MOVED, before, after)
    assert found == MOVED.replace("by: [0, 2, 0]", "by: [0, 2.5, 0]").replace(
        "# second\n", '# second\n  - {parts: ["c d"], by: [0, 0, 10]}\n'
    )
    flow = "length: mm\nenvironment: cab\nmoved: [{parts: [a], by: [10, 0, 0]}]\n"
    found = moved(flow, before[:1], before)
    assert (
        "moved: [{parts: [a], by: [10, 0, 0]}, {controls: [b], alone: true, by: [0, 20, 0]}]\n"
        in found
    )


def test_a_list_of_moves_is_made_or_made_anew():
    one = Move(("a",), (), (0.01, 0.0, 0.0))
    other = Move((), ("b",), (0.0, 0.02, 0.0))
    plain = "length: mm\r\nenvironment: cab  # of steel\r\ncases: []\r\n"
    found = moved(plain, (), (one,))
    line = "environment: cab  # of steel\r\nmoved: [{parts: [a], by: [10, 0, 0]}]\r\n"
    assert found == plain.replace("environment: cab  # of steel\r\n", line)
    found = moved(MOVED, (one, other), (other,))
    assert yaml.safe_load(found)["moved"] == [{"controls": ["b"], "alone": True, "by": [0, 2, 0]}]
    assert yaml.safe_load(moved(MOVED, (one, other), ()))["moved"] == []


# --- laws ---------------------------------------------------------------------------------------

SCALARS = st.one_of(
    st.integers(-9, 9),
    st.booleans(),
    st.none(),
    st.sampled_from(["a", "no", "1 cm", "x: y", "# z", "", "a, b"]),
    st.floats(0.01, 0.99, allow_subnormal=False),
)
TREES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.sampled_from(["p", "q", "r", "s", "t"]), inner, max_size=4),
    ),
    max_leaves=12,
)
FILES = st.dictionaries(st.sampled_from(["one", "two", "three", "four"]), TREES, min_size=1)


def styled(value, draw, key=(), *, flow=False):
    """The lines of a value as somebody writes them: in either style, with comments and blank lines."""
    if not value or not isinstance(value, (dict, list)):
        return [json.dumps(value)]
    rows = value.items() if isinstance(value, dict) else enumerate(value)
    if flow or (key and draw(st.booleans())):
        inner = [
            (f"{name}: " if isinstance(value, dict) else "")
            + styled(one, draw, (*key, name), flow=True)[0]
            for name, one in rows
        ]
        between = draw(st.sampled_from([", ", ",", " , "]))
        words = between.join(inner) + draw(st.sampled_from(["", " ", ","]))
        return [f"{{{words}}}" if isinstance(value, dict) else f"[{words}]"]
    lines = []
    for name, one in rows:
        inside = (*key, name)
        below = styled(one, draw, inside)
        comment = draw(st.sampled_from(["", "  # of " + ".".join(map(str, inside))]))
        lead = f"{name}:" if isinstance(value, dict) else "-"
        block = isinstance(one, (dict, list)) and one and not below[0].startswith(("{", "["))
        if draw(st.integers(0, 3)) == 0:
            lines += ["", f"# before {'.'.join(map(str, inside))}"]
        if not block:
            lines.append(f"{lead} {below[0]}{comment}")
        elif lead == "-" and not below[0].startswith(("#", "-")) and below[0]:
            lines += [f"- {below[0]}", *(f"  {line}" for line in below[1:])]
        else:
            lines += [lead + comment, *(f"  {line}" for line in below)]
    return lines


def edited(value, draw):
    """A tree after some edits."""
    if not value or not isinstance(value, (dict, list)) or draw(st.integers(0, 5)) == 0:
        return draw(TREES)
    rows = list(value.items() if isinstance(value, dict) else enumerate(value))
    number = draw(st.integers(0, len(rows) - 1))
    name, one = rows[number]
    kind = draw(st.sampled_from(["inner", "remove", "add", "rename", "both"]))
    if kind in ("inner", "both"):
        rows[number] = (name, edited(one, draw))
    if kind in ("remove", "both"):
        del rows[draw(st.integers(0, len(rows) - 1))]
    if kind == "add":
        rows.insert(draw(st.integers(0, len(rows))), ("new", draw(TREES)))
    if kind == "rename":
        rows[number] = ("other", one)
    return dict(rows) if isinstance(value, dict) else [row[1] for row in rows]


def untouched(before, after, key=()):
    """The keys of mappings whose value is the same in both."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name, value in before.items():
            if name in after:
                if json.dumps(value) == json.dumps(after[name]):
                    yield (*key, name)
                yield from untouched(value, after[name], (*key, name))


@settings(max_examples=150)
@given(FILES, st.data(), st.sampled_from(["\n", "\r\n"]))
def test_a_changed_text_says_the_new_values_and_keeps_the_comments_of_others(before, data, ends):
    text = ends.join(styled(before, data.draw)) + ends
    assert values(text) == before
    assert changed_text(text, before) == text
    after = before
    for _ in range(data.draw(st.integers(1, 3))):
        after = edited(after, data.draw)
        if not after or not isinstance(after, dict):
            return
    found = changed_text(text, after)
    assert json.dumps(values(found), sort_keys=True) == json.dumps(plain(after), sort_keys=True)
    for key in untouched(before, after):
        comment = "# of " + ".".join(map(str, key))
        assert found.count(comment + ends) == text.count(comment + ends), comment
    assert found.count("\r") == found.count("\n") * (ends == "\r\n")


@settings(max_examples=100)
@given(TREES, TREES, st.data())
def test_a_shared_value_is_changed_where_it_is_asked_for_alone(shared, other, data):
    words = json.dumps(shared)
    text = f"a: &x {words}\nb: {{c: *x, d: [*x, 1]}}  # b\ne: *x\n"
    says = json.loads(json.dumps(values(text)))
    place = data.draw(st.sampled_from(["a", "b", "c", "d", "e"]))
    (says["b"] if place in "cd" else says)[place] = other
    found = values(changed_text(text, says))
    assert json.dumps(found, sort_keys=True) == json.dumps(plain(says), sort_keys=True)
