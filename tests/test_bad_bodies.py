"""Bad body files: each fault is answered with its line, its key, what was given and what would be
right."""

from __future__ import annotations

import warnings

import pytest

import workbench as wb
from tests.conftest import ONE_ARM, ROOT
from tests.one_arm_cab import changed, line_with, lines_of, mutants
from workbench import InputError

BODY = ONE_ARM.lstrip()
POLYGON = """    stop: polygon
    polygon:
      frame: BASE
      centre: [0, 1, 0]
      clock_0: [0, 0, 1]
      clock_90: [1, 0, 0]
      limits: [[0, 100], [120, 90], [240, 80]]
"""
WITH_POLYGON = changed(BODY, "    stop: cone\n", POLYGON)


def problems(folder, text, mode="w"):
    path = folder / "body.yaml"
    path.write_bytes(text) if isinstance(text, bytes) else path.write_text(text)
    with pytest.raises(InputError) as caught:
        wb.load_body(path)
    return caught.value.problems


def check(folder, change, marked, words, text=BODY):
    """One change makes one fault, on the line where `marked` stands in the changed file, with these
    words in it."""
    broken = changed(text, *change)
    found = problems(folder, broken)
    assert lines_of(found) == [line_with(broken, marked)], found
    assert all(word in found[0] for word in words), found


def test_the_unchanged_bodies_load(tmp_path):
    for text in (BODY, WITH_POLYGON):
        (tmp_path / "body.yaml").write_text(text)
        assert wb.load_body(tmp_path / "body.yaml").segments == ("BASE", "UPPER", "LOWER", "HAND")


@pytest.mark.parametrize(
    ("old", "new", "marked", "words"),
    [
        ("body: one_arm", "body: 3", "body: 3", ["body: a text is needed (got 3)"]),
        ("body: one_arm", "body: ''", "body: ''", ["body: ", "at least 1 character"]),
        ("body: one_arm\n", "", "length", ["key 'body' is missing"]),
        (
            "body: one_arm",
            "bdy: one_arm\nbody: x",
            "bdy",
            ["unknown key 'bdy'; did you mean 'body'? valid: allowances"],
        ),
        (
            "length: mm",
            "length: mmm",
            "mmm",
            ["length: the unit of length is needed (got 'mmm'), one of mm, cm, m, in, ft"],
        ),
        ("length: mm", "length: [mm]", "[mm]", ["length: the unit", "(got ['mm'])"]),
        ("length: mm\n", "", "body:", ["length: the unit of length is needed (it is missing)"]),
        (
            "    mass: 2",
            "    mass: 2\n    mas: 2",
            "mas:",
            ["segments.UPPER.mas: unknown key 'mas'; did you mean 'mass'?"],
        ),
        (
            "    mass: 2",
            "    mass: two",
            "two",
            ["segments.UPPER.mass: a number is needed (got 'two')"],
        ),
        (
            "    mass: 2",
            "    mass: -2",
            "-2",
            ["segments.UPPER.mass", "greater than or equal to 0 (got -2)"],
        ),
        (
            "    mass: 2",
            "    mass: .nan",
            ".nan",
            ["segments.UPPER.mass", "finite number (got nan)"],
        ),
        ("    mass: 2", "    mass: 1e999", "1e999", ["finite number (got inf)"]),
        (
            "    mass: 2",
            "    mass: true",
            "true",
            ["segments.UPPER.mass: a number is needed (got True)"],
        ),
        (
            "    number: 2",
            "    number: 2.5",
            "2.5",
            ["segments.UPPER.number: a whole number is needed (got 2.5)"],
        ),
        ("    number: 2", "    number: 0", "number: 0", ["greater than or equal to 1 (got 0)"]),
        (
            "    number: 2\n    mass: 2",
            "    number: 3\n    mass: 2",
            "name: lower arm",
            ["segments.LOWER.number: number 3 is taken by 'UPPER'"],
        ),
        (
            "    number: 2\n    between",
            "    number: 1\n    between",
            "name: elbow",
            ["number 1 is taken by 'SHOULDER'"],
        ),
        (
            "segments:",
            "segments: {}\nsegment:",
            "segments: {}",
            ["segments: at least 1 are needed"],
        ),
        (
            "play: 2",
            "play: -2",
            "play",
            ["joints.ELBOW.play", "greater than or equal to 0 (got -2)"],
        ),
    ],
)
def test_a_wrong_key_or_value_is_told(tmp_path, old, new, marked, words):
    broken = changed(BODY, old, new)
    found = [p for p in problems(tmp_path, broken) if all(word in p for word in words)]
    assert len(found) == 1, problems(tmp_path, broken)
    if "is taken by" not in found[0]:
        assert lines_of(tuple(found)) == [line_with(broken, marked)]
    else:
        assert lines_of(tuple(found)) == [line_with(broken, marked) + 1]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        (
            "[0, 0, 0]",
            "a sphere is [x, y, z, radius], then optionally a name and a direction (got [0, 0, 0])",
        ),
        ("[0, 0, 0, 5, a, top, 7]", "a sphere is [x, y, z, radius]"),
        (
            "5",
            "spheres[0]: a sphere is [x, y, z, radius], then optionally a name and a direction (got 5)",
        ),
        ("[0, 0, 0, -5]", "spheres[0][3]: input should be greater than 0 (got -5)"),
        ("[0, 0, 0, 0]", "greater than 0 (got 0)"),
        ("[0, 0, 0, .nan]", "finite number (got nan)"),
        ("[0, .inf, 0, 5]", "spheres[0][1]: input should be a finite number (got inf)"),
        ("[0, 1e999, 0, 5]", "finite number"),
        ("[0, 0x" + "f" * 300 + ", 0, 5]", "finite number"),
        (
            "[0, 0, 0, 5 furlong]",
            "a length such as '450 mm' or '17.7 in' is needed; units: mm, cm, m, in, ft (got '5 fur",
        ),
        ("[0, 0, 0, 5mm3]", "a length such as '450 mm'"),
        ("[0, 0, true, 5]", "a number or a length such as '450 mm' is needed (got True)"),
        ("[0, 0, 11 000 m, 5]", "a length such as"),
        ("[0, 0, 11000 m, 5]", "11000 m is farther than 10000 m: a wrong unit? (got '11000 m')"),
        ("[0, 0, 0, 5, 7]", "spheres[0][4]: a text is needed (got 7)"),
        (
            "[0, 0, 0, 5, tip, up]",
            "spheres[0][5]: input should be 'front', 'back', 'left', 'right', 'top' or 'bottom'",
        ),
    ],
)
def test_a_wrong_sphere_is_one_fault_and_shows_the_row(tmp_path, row, words):
    check(tmp_path, ("spheres: [[0, 0, 0, 50]]", f"spheres: [{row}]"), "name: base", [words])


@pytest.mark.parametrize(
    ("old", "new", "marked", "words"),
    [
        (
            "between: [UPPER, LOWER]",
            "between: [UPPER, LOWRE]",
            "LOWRE",
            "unknown segment 'LOWRE'; did you mean 'LOWER'?",
        ),
        (
            "between: [UPPER, LOWER]",
            "between: [UPPER]",
            "between: [UPPER]",
            "value 2 of the list is missing",
        ),
        (
            "between: [UPPER, LOWER]",
            "between: [UPPER, LOWER, HAND]",
            "LOWER, HAND",
            "at most 2 are possible",
        ),
        (
            "between: [UPPER, LOWER]",
            "between: UPPER",
            "between: UPPER",
            "a list is needed (got 'UPPER')",
        ),
        (
            "at: {UPPER: [0, 0, -150], LOWER",
            "at: {UPER: [0, 0, -150], LOWER",
            "UPER",
            "coordinates are needed in exactly the two frames ['UPPER', 'LOWER'] (got ['UPER', 'LOWER'])",
        ),
        (
            "at: {UPPER: [0, 0, -150], LOWER: [0, 0, 100]}",
            "at: {UPPER: [0, 0, -150]}",
            "-150]}",
            "at least 2 are needed",
        ),
        (
            "at: {UPPER: [0, 0, -150]",
            "at: {UPPER: [0, 0]",
            "[0, 0],",
            "joints.ELBOW.at.UPPER: value 3 of the list is missing",
        ),
        (
            "at: {UPPER: [0, 0, -150], LOWER: [0, 0, 100]}",
            "at: {UPPER: [0, 0, -149], LOWER: [0, 0, 101]}",
            "-149",
            "joints.ELBOW.at: a sphere must sit exactly at the joint in UPPER or LOWER (the nearest is 1.0 mm away)",
        ),
        (
            "at: {LOWER: [0, 0, -100], HAND",
            "at: {LOWER: [0, 0, 100], HAND",
            "twist_along",
            "no line for the twist",
        ),
        (
            "twist_along: WRIST",
            "twist_along: WRISTS",
            "WRISTS",
            "not a distal joint of LOWER (got 'WRISTS'); did you mean",
        ),
        (
            "twist_along: WRIST",
            "twist_along: SHOULDER",
            "SHOULDER\n",
            "not a distal joint of LOWER",
        ),
        (
            "thumb tip]",
            "fingertip]",
            "-50, 20, fingertip",
            "segments.HAND.spheres: two spheres are named 'fingertip'",
        ),
        (
            "[BASE, LOWER], depth: 5",
            "[BASE, LOWR], depth: 5",
            "LOWR",
            "allowances[0].between[1]: unknown segment 'LOWR'",
        ),
        (
            "depth: 5",
            "depth: -5",
            "-5}",
            "allowances[0].depth: input should be greater than or equal to 0 (got -5)",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, top: -z}",
            "{back: -y, top: -z}",
            "at least 3 are needed",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, top: -z, right: y}",
            "right: y",
            "input should be '+x', '-x'",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, top: -z, left: +z}",
            "left: +z",
            "at right angles to one another",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, top: -z, left: [1, 1, 0]}",
            "[1, 1, 0]",
            "at right angles",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, front: +y, left: +x}",
            "front: +y",
            "three directions of different pairs",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, front: -y, left: +x, top: -z}",
            "front: -y",
            "must be opposite",
        ),
        (
            "{back: -y, top: -z, left: +x}",
            "{back: -y, top: -z, lft: +x}",
            "lft",
            "directions.lft: input should be 'front'",
        ),
    ],
)
def test_a_wrong_joint_or_table_is_told(tmp_path, old, new, marked, words):
    broken = changed(BODY, old, new)
    found = [p for p in problems(tmp_path, broken) if words in p]
    assert len(found) == 1, problems(tmp_path, broken)
    assert abs(lines_of(tuple(found))[0] - line_with(broken, marked.strip())) <= 1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "stop: hinge",
            "stop: hinged",
            "joints.ELBOW.stop: input should be 'free', 'cone', 'hinge' or 'polygon'",
        ),
        (
            "limits: [142, 0]",
            "limits: [-142, 0]",
            "swing[0].limits[0]: input should be greater than or equal to 0 (got -142)",
        ),
        ("limits: [142, 0]", "limits: [1142, 0]", "less than or equal to 720 (got 1142)"),
        ("limits: [142, 0]", "limits: 142", "swing[0].limits: a list is needed (got 142)"),
        (
            "limits: [142, 0]",
            "limits: ['142 deg', 0]",
            "limits[0]: a number is needed (got '142 deg')",
        ),
        (
            "axis: -y, limits: [142",
            "axis: -x, limits: [142",
            "the two swing axes and the twist axis must be at right angles",
        ),
        ("axis: -y, limits: [142", "axis: [0, 0, 0], limits: [142", "at right angles"),
        (
            "axis: -y, limits: [142",
            "axis: [0, 1], limits: [142",
            "swing[0].axis: value 3 of the list is missing",
        ),
        ("axis: -y, limits: [142", "axis: y, limits: [142", "swing[0].axis: input should be '+x'"),
        (
            "motion: [flexion, extension], axis: -y, limits: [142",
            "motion: [flexion, flexion], axis: -y, limits: [142",
            "motion names must differ",
        ),
        (
            "limit: medial_rotation",
            "limit: medial_rot",
            "unknown motion 'medial_rot' of ELBOW; did you mean 'medial_rotation'",
        ),
        (
            "driver: ELBOW.flexion",
            "driver: ELBOWS.flexion",
            "unknown joint 'ELBOWS'; did you mean 'ELBOW'",
        ),
        (
            "driver: ELBOW.flexion",
            "driver: ELBOW.flex",
            "unknown motion 'flex' of ELBOW; did you mean 'flexion'",
        ),
        (
            "driver: ELBOW.flexion",
            "driver: flexion",
            "couplings[0].driver: string should match pattern",
        ),
        ("from: [0, 90]", "from: [90, 90]", "couplings[0].from: the two driver angles must rise"),
        ("to: [0, 35]", "to: [0]", "couplings[0].to: value 2 of the list is missing"),
        (
            "stop: cone",
            "stop: polygon",
            "joints.SHOULDER: key 'polygon' is needed where stop is 'polygon', and only there",
        ),
    ],
)
def test_a_wrong_stop_is_told(tmp_path, old, new, words):
    broken = changed(BODY, old, new)
    found = problems(tmp_path, broken)
    assert len(found) == 1 and words in found[0], found
    marked = "name: shoulder" if "SHOULDER" in words else new
    assert abs(lines_of(found)[0] - line_with(broken, marked)) <= 4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "frame: BASE",
            "frame: HAND",
            "polygon.frame: no segment 'HAND' between the stage and joint SHOULDER; valid: BASE",
        ),
        (
            "clock_0: [0, 0, 1]",
            "clock_0: [0, 1, 1]",
            "polygon.centre: centre, clock_0 and clock_90 must be at right angles",
        ),
        ("centre: [0, 1, 0]", "centre: [0, 0, 0]", "must be at right angles"),
        (
            "[[0, 100], [120",
            "[[120, 100], [120",
            "polygon.limits: clock angles must rise from 0 to below 360",
        ),
        ("[240, 80]", "[360, 80]", "clock angles must rise"),
        (", [240, 80]", "", "polygon.limits: at least 3 are needed"),
        ("[240, 80]", "[240]", "limits[2]: value 2 of the list is missing"),
        (
            "centre: [0, 1, 0]",
            "center: [0, 1, 0]\n      centre: [0, 1, 0]",
            "unknown key 'center'; did you mean 'centre'",
        ),
    ],
)
def test_a_wrong_polygon_is_told(tmp_path, old, new, words):
    broken = changed(WITH_POLYGON, old, new)
    found = problems(tmp_path, broken)
    assert len(found) == 1 and words in found[0], found
    assert line_with(broken, "polygon:") < lines_of(found)[0] <= line_with(broken, "limits: [[")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            [
                ("[BASE, UPPER]", "[LOWER, UPPER]"),
                ("{BASE: [0, 0, 0], UPPER", "{LOWER: [0, 0, 0], UPPER"),
            ],
            "segments in a circle",
        ),
        (
            [("[LOWER, HAND]", "[LOWER, UPPER]")],
            "segment 'UPPER' is already the distal one of joint 'SHOULDER'",
        ),
        (
            [("[LOWER, HAND]", "[HAND, LOWER]")],
            "segment 'LOWER' is already the distal one of joint 'ELBOW'",
        ),
        ([("[LOWER, HAND]", "[HAND, HAND]")], "a joint joins two different segments"),
        (
            [(BODY[BODY.index("joints:") : BODY.index("allowances:")], "")],
            "one tree is needed, but 4 segments hang from nothing: BASE, UPPER, LOWER, HAND",
        ),
        (
            [
                ("[BASE, UPPER]", "[HAND, UPPER]"),
                ("{BASE: [0", "{HAND: [0"),
                (
                    "  BASE: {name: base, number: 1, mass: 1, dir"
                    "ections: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 50]]}\n",
                    "",
                ),
            ],
            "the joints form a circle: no segment",
        ),
        (
            [
                (
                    "segments:\n",
                    "segments:\n  LOOSE: {name: l, number: 9, mass: 1, directions: {front: +x, left: +y, top: +z}}\n",
                )
            ],
            "2 segments hang from nothing: LOOSE, BASE",
        ),
    ],
)
def test_what_is_not_one_tree_is_refused(tmp_path, changes, words):
    text = BODY
    for change in changes:
        text = changed(text, *change)
    found = problems(tmp_path, text)
    assert lines_of(found)
    assert any(words in line for line in found), found


def test_a_body_without_a_single_sphere_is_refused(tmp_path):
    table = "directions: {front: +x, left: +y, top: +z}"
    text = f"body: ghost\nlength: mm\nsegments:\n  A: {{name: a, number: 1, mass: 1, {table}}}\n"
    assert problems(tmp_path, text) == (
        f"{tmp_path}/body.yaml:3:1: segments: a body is made of spheres; none of its segments has one",
    )


def test_a_circle_with_a_polygon_ends(tmp_path):
    text = changed(
        changed(WITH_POLYGON, "[BASE, UPPER]", "[LOWER, UPPER]"), "{BASE: [0", "{LOWER: [0"
    )
    assert any("segments in a circle" in line for line in problems(tmp_path, text))


def test_faults_of_shape_are_told_all_at_once(tmp_path):
    text = BODY
    for old, new in (
        ("length: mm", "length: furlong"),
        ("mass: 2", "mass: two"),
        ("[[0, 0, 0, 50]]", "[[0, 0, 0, -50]]"),
        ("number: 3\n", "numbr: 3\n"),
        ("stop: hinge", "stop: hook"),
        ("depth: 5", "depth: x"),
    ):
        text = changed(text, old, new)
    found = problems(tmp_path, text)
    marked = {
        line_with(text, part)
        for part in ("furlong", "two", "-50]", "numbr", "  LOWER:", "hook", "depth: x")
    }
    assert marked == set(lines_of(found))


def test_faults_of_sense_are_told_all_at_once(tmp_path):
    text = BODY
    parts = (
        "[BASE, UPPR]",
        "left: +z",
        "WRISTS",
        "axis: -z, limits: [53",
        "ELBW",
        "[BASE, LOWR]",
        "mass: 0.5",
    )
    for old, new in (
        ("[BASE, UPPER]", parts[0]),
        ("left: +x", parts[1]),
        ("twist_along: WRIST", f"twist_along: {parts[2]}"),
        ("axis: -x, limits: [53", parts[3]),
        ("driver: ELBOW", "driver: ELBW"),
        ("[BASE, LOWER]", parts[5]),
        ("number: 4", "number: 3"),
    ):
        text = changed(text, old, new)
    found = problems(tmp_path, text)
    assert len(found) == 8
    assert {line_with(text, part) for part in parts[:1] + parts[2:3] + parts[4:6]} <= set(
        lines_of(found)
    )


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ":1:1: is empty"),
        (b"\x00\x01\x02", ":1:1: not YAML"),
        (b"\xff\xd8\xff\xe0JFIF", ":1:1: not a text file"),
        (b"just words", ":1:1: a mapping of keys is needed, got 'just words'"),
        (b"- body: x", ":1:1: a mapping of keys is needed, got [{'body': 'x'}]"),
        (b"5", ":1:1: a mapping of keys is needed, got 5"),
        (b"{}", "key 'body' is missing"),
    ],
)
def test_what_is_no_body_at_all_is_refused(tmp_path, data, words):
    assert any(words in line for line in problems(tmp_path, data))


@pytest.mark.parametrize("name", ["none.yaml", "no/such/body.yaml", "x" * 300 + ".yaml", ""])
def test_a_missing_file_is_told(name):
    with pytest.raises(InputError, match=r"no such file|valid: "):
        wb.load_body(name)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(
        InputError, match="no bodies entry named 'bubleman'; did you mean 'bubbleman'"
    ):
        wb.load_body("bubleman")


def test_a_huge_value_is_shown_short(tmp_path):
    text = changed(BODY, "    mass: 2", "    mass: [" + "[x, x, x, x, x], " * 5000 + "]")
    assert len(problems(tmp_path, text)[0]) < 300


def test_a_key_of_several_lines_is_shown_in_one(tmp_path):
    text = changed(BODY, "body: one_arm", 'body: one_arm\n"two\\nlines": 1')
    assert len(problems(tmp_path, text)) == 1
    assert "\n" not in problems(tmp_path, text)[0]


def test_a_body_cut_off_anywhere_is_bad_input(tmp_path):
    data = BODY.encode()
    for end in range(0, len(data) - 60, 47):
        lines_of(problems(tmp_path, data[:end]))


def test_sixty_mutants_of_a_body_are_bodies_or_bad_input(tmp_path):
    text = (ROOT / "bodies/bubbleman.yaml").read_text()
    path = tmp_path / "body.yaml"
    bad = 0
    for data in mutants(text, 60, seed=1):
        path.write_bytes(data)
        try:
            wb.load_body(path)
        except InputError as error:
            bad += 1
            lines_of(error.problems)
    assert bad > 20


def test_limits_in_degrees_are_radians_in_the_body_up_to_two_turns(tmp_path):
    (tmp_path / "body.yaml").write_text(changed(BODY, "limits: [142, 0]", "limits: [720, 0]"))
    with warnings.catch_warnings(action="error"):
        assert wb.load_body(tmp_path / "body.yaml").stops.limits.max() == pytest.approx(
            12.566370614
        )


def test_two_allowances_for_one_pair_are_refused_with_both_lines(tmp_path):
    twice = BODY.replace(
        "  - {between: [BASE, LOWER], depth: 5}",
        "  - {between: [BASE, LOWER], depth: 5}\n  - {between: [LOWER, BASE], depth: 7}",
    )
    first = 1 + BODY[: BODY.index("  - {between: [BASE, LOWER]")].count("\n")
    (told,) = problems(tmp_path, twice)
    assert f"body.yaml:{first + 1}:" in told
    assert f"LOWER and BASE have an allowance already, at {first}:" in told


def test_a_left_handed_table_of_directions_is_refused(tmp_path):
    (told,) = problems(
        tmp_path, changed(BODY, "{back: -y, top: -z, left: +x}", "{back: -y, top: -z, left: -x}")
    )
    assert "must be a right-handed set" in told
