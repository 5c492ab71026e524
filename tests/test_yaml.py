"""The YAML reader: version 1.2, every value with its place, nothing that can grow, hide or run."""

from __future__ import annotations

import json
import math
import os
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench import InputError, load_environment, load_study, read_ansur
from workbench.errors import has_controls, printable
from workbench.files.kinds import check_file
from workbench.files.motions.number_rows import numbered_lines
from workbench.files.results.result import load_result
from workbench.files.yaml_text import MOST_DEPTH, parse_yaml, read_yaml


def value(text):
    return parse_yaml(text, "f.yaml").value


def problem(text):
    with pytest.raises(InputError) as caught:
        parse_yaml(text, "f.yaml")
    assert len(caught.value.problems) == 1
    return caught.value.problems[0]


def problem_of_bytes(folder, data):
    path = folder / "f.yaml"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_yaml(path)
    return caught.value.problems[0].removeprefix(f"{folder}/")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("no", "no"),
        ("yes", "yes"),
        ("on", "on"),
        ("off", "off"),
        ("y", "y"),
        ("No", "No"),
        ("true", True),
        ("False", False),
        ("TRUE", True),
        ("null", None),
        ("~", None),
        ("", None),
        ("Null", None),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("-7", -7),
        ("+7", 7),
        ("0", 0),
        ("0b11", "0b11"),
        ("1_000", "1_000"),
        ("1e3", 1000.0),
        ("1E-3", 0.001),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.5e1", -5.0),
        ("1e", "1e"),
        (".", "."),
        (".inf", math.inf),
        ("-.Inf", -math.inf),
        ("inf", "inf"),
        ("nan", "nan"),
        ("12:30", "12:30"),
        ("12:30:45", "12:30:45"),
        ("2026-07-12", "2026-07-12"),
        ("=", "="),
        ("<<", "<<"),
        ('"5"', "5"),
        ("'no'", "no"),
        ("'null'", "null"),
        ("! 5", "5"),
        ("!!str 5", "5"),
        ("١٢", "١٢"),
    ],
)
def test_a_plain_scalar_is_what_yaml_1_2_says(text, expected):
    found = value(f"a: {text}")["a"]
    assert found == expected
    assert type(found) is type(expected)


def test_nan_is_read_as_nan():
    assert math.isnan(value("[.nan]")[0])


@pytest.mark.parametrize(
    ("digits", "expected"),
    [
        ("9" * 39, int("9" * 39)),
        ("9" * 40, 1e40),
        ("9" * 400, math.inf),
        ("0x" + "f" * 50, float(16**50)),
        ("0x" + "f" * 9000, math.inf),
        ("0o" + "7" * 9000, math.inf),
        ("1e999", math.inf),
    ],
)
def test_a_number_too_long_for_any_use_becomes_a_float_not_a_crash(digits, expected):
    assert value(f"[{digits}]") == [expected]


@pytest.mark.parametrize(
    "text", ["{no: 1, 010: 2, ~: 3, 1e3: 4}", "{no: 1, '010': 2, '~': 3, '1e3': 4}"]
)
def test_keys_are_the_text_that_stands_there(text):
    assert value(text) == {"no": 1, "010": 2, "~": 3, "1e3": 4}


def test_a_line_separator_in_a_name_is_kept_and_named_where_it_breaks_the_file():
    assert value('a: "x\u2028y"') == {"a": "x\u2028y"}
    with pytest.raises(InputError, match=r"U\+2028 at f.yaml:2:4 ends a line"):
        parse_yaml('a: 1\n"na\u2028me": 1\n', "f.yaml")


def test_a_merge_key_is_only_a_name():
    assert value("a: &a {x: 1}\nb: {<<: *a, y: 2}")["b"] == {"<<": {"x": 1}, "y": 2}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: 1\nb: 2\na: 3", "f.yaml:3:1: key 'a' stands twice in one mapping"),
        ("x: {010: 1, '010': 2}", "f.yaml:1:13: key '010' stands twice"),
        ("a: 1\n--- \nb: 2", "f.yaml:2:1: a second document starts here"),
        (
            "a: !!python/object/apply:os.system [ls]",
            "f.yaml:1:4: tag tag:yaml.org,2002:python/object/apply:os.system",
        ),
        ("a: !mine 5", "f.yaml:1:4: tag !mine is not supported; remove it"),
        ("a: !!int '5'", "f.yaml:1:4: tag tag:yaml.org,2002:int is not supported"),
        ("a: *b", "f.yaml:1:4: alias *b has no finished anchor &b before it"),
        ("a: &a [1, *a]", "f.yaml:1:11: alias *a has no finished anchor"),
        ("? [1, 2]\n: 3", "f.yaml:1:3: a key must be a name"),
        ("a: &a [1]\n*a : 2", "f.yaml:2:1: a key must be a name"),
        ("a: [1, 2", "f.yaml:2:1: not YAML"),
        ("a:\n\t- 1", "f.yaml:2:1: not YAML: found character that cannot start any token"),
        ("a: 'x", "f.yaml:1:6: not YAML"),
        ("a: b: c", "f.yaml:1:5: not YAML: mapping values are not allowed"),
        ("a: 1\nb: 2\x00", "f.yaml:2:5: not YAML"),
        ("ä: 'ö'\nb: \x1b", "f.yaml:2:4: not YAML"),
        ("# only a comment", "f.yaml:1:1: holds no value"),
        ("%YAML 3.0\n--- 1", "f.yaml:1:1: not YAML"),
    ],
)
def test_what_is_not_yaml_is_answered_with_line_and_column(text, expected):
    assert problem(text).startswith(expected)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "f.yaml:1:1: is empty"),
        (b" \n\t\n", "f.yaml:1:1: is empty"),
        (b"\xef\xbb\xbf", "f.yaml:1:1: is empty"),
        (b"\x89PNG\r\n\x1a\n\x00", "f.yaml:1:1: not a text file in UTF-8 (byte 0 is 0x89)"),
        ("a: ä\nb: é".encode("latin-1"), "f.yaml:1:4: not a text file in UTF-8 (byte 3 is 0xe4)"),
        (
            b"a: \xc3\xa4\nb: \xc3\xa4 \xff",
            "f.yaml:2:6: not a text file in UTF-8 (byte 12 is 0xff)",
        ),
        ("a: 1".encode("utf-16"), "f.yaml:1:1: not a text file in UTF-8"),
        (b"a: 1\n\x00\x00\x00", "f.yaml:2:1: not YAML"),
    ],
)
def test_a_file_that_is_no_text_is_refused(tmp_path, data, expected):
    assert problem_of_bytes(tmp_path, data).startswith(expected)


def test_what_is_not_a_file_is_said_to_be_none(tmp_path):
    for path, words in (
        (tmp_path / "none.yaml", "no such file"),
        (tmp_path, "is a folder"),
        (tmp_path / ("x" * 300), "cannot be read (File name too long)"),
    ):
        with pytest.raises(InputError) as caught:
            read_yaml(path)
        assert words in str(caught.value)


def test_a_file_beyond_64_mib_is_not_parsed(tmp_path):
    assert "too many for a YAML file" in problem_of_bytes(tmp_path, b"#" * (64 * 2**20 + 1))


@pytest.mark.parametrize(
    "text", ["\ufeffa: 1\r\nb:\r\n  - x\r\n", "a: 1\rb:\r  - x\r", "a: 1\nb:\n  - x\n"]
)
def test_byte_order_mark_and_line_ends_make_no_difference(tmp_path, text):
    (tmp_path / "f.yaml").write_bytes(text.encode())
    document = read_yaml(tmp_path / "f.yaml")
    assert document.value == {"a": 1, "b": ["x"]}
    assert [document.positions[path] for path in (("a",), ("b",), ("b", 0))] == [
        (1, 1),
        (2, 1),
        (3, 5),
    ]


def test_every_value_knows_its_place_and_what_is_missing_that_of_its_parent():
    document = parse_yaml("a:\n  ä: {b: [10,\n    20]}\n", "f.yaml")
    assert document.where(("a", "ä", "b", 1)) == "f.yaml:3:5"
    assert document.where(("a", "ä", "b", 9, "x")) == "f.yaml:2:7"
    assert document.where(("none",)) == "f.yaml:1:1"


def test_an_alias_stands_for_its_anchor():
    assert value("a: &a {x: [1, 2]}\nb: *a\nc: [*a, *a]") == {
        "a": {"x": [1, 2]},
        "b": {"x": [1, 2]},
        "c": [{"x": [1, 2]}, {"x": [1, 2]}],
    }
    assert value("[&n 5, *n, &n 6, *n]") == [5, 5, 6, 6]


def test_a_bomb_of_aliases_is_counted_not_built():
    rows = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    rows += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 10)]
    assert "the file grows past 2000000 values" in problem("\n".join(rows))


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_nesting_beyond_64_levels_is_refused_before_it_recurses(opening):
    assert "nested deeper than 64 levels" in problem(opening * 100_000)


def test_aliases_cannot_nest_deeper_than_brackets():
    rows = ["a0: &a0 [x]"] + [f"a{n}: &a{n} [*a{n - 1}]" for n in range(1, 5000)]
    assert problem("\n".join(rows)).startswith(f"f.yaml:{MOST_DEPTH}:")
    assert value("\n".join(rows[: MOST_DEPTH - 1]))[f"a{MOST_DEPTH - 2}"]


def test_64_levels_are_read():
    assert json.dumps(value("[" * MOST_DEPTH + "]" * MOST_DEPTH)).count("[") == MOST_DEPTH


# the escape of a surrogate pair is the one piece of JSON that the parser does not take
ESCAPED = st.text(st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"]), max_size=12)
PRINTED = st.text(st.characters(categories=["L", "M", "N", "P", "S"]), max_size=12)
NUMBERS = st.none() | st.booleans() | st.integers(-(10**38), 10**38) | st.floats(allow_nan=False)


def values(texts):
    def longer(inner):
        return st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4)

    return st.recursive(NUMBERS | texts, longer, max_leaves=12)


def told(text):
    """JSON, which YAML 1.2 contains but for the names of the infinities."""
    return text.replace("-Infinity", "-.inf").replace("Infinity", ".inf")


@given(values(ESCAPED))
def test_json_is_yaml_and_comes_back_as_it_was(data):
    found = value(told(json.dumps(data)))
    assert found == data
    assert json.dumps(found) == json.dumps(data)


@given(values(PRINTED), st.sampled_from([None, 1, 3]))
def test_indented_json_with_its_own_letters_comes_back_too(data, indent):
    text = json.dumps(data, indent=indent, ensure_ascii=False)
    assert value(told(text)) == data


@given(st.text(alphabet="abn:-[]{}&*!|>'\"#%@ \n\t,?0.1e~", max_size=60))
def test_any_text_is_a_value_or_an_input_error(text):
    try:
        value(text)
    except InputError as error:
        assert error.problems[0].startswith("f.yaml:")


def test_a_control_character_in_a_text_is_refused_with_its_place(tmp_path):
    path = tmp_path / "worn.yaml"
    path.write_text('encumbrance: "hel\\e[2Jmet"\nlength: mm\nlayers: []\n')
    with pytest.raises(InputError) as caught:
        check_file(path)
    assert caught.value.problems[0].startswith(
        f"{path}:1:1: encumbrance: a text with control characters"
    )


@pytest.mark.parametrize(
    "read",
    [read_yaml, read_ansur, lambda path: list(numbered_lines(path)), load_result, load_study],
)
def test_pipes_and_devices_are_refused_by_every_reader_of_text(tmp_path, read):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(InputError, match="is a pipe, a device or a socket"):
            read(path)


def test_a_name_of_a_file_that_is_no_text_is_told_in_letters(tmp_path):
    for name, shown in (
        ("a\x1b[31m.yaml", "a\\u001b[31m.yaml"),
        (os.fsdecode(b"\xff.yaml"), "\\udcff.yaml"),
    ):
        with pytest.raises(InputError) as caught:
            read_yaml(tmp_path / name)
        assert str(caught.value) == f"{tmp_path}/{shown}: no such file"


@given(st.text(max_size=30))
def test_printable_text_stays_and_no_other_is_left(text):
    shown = printable(text)
    assert not has_controls(shown)
    assert shown.encode().decode() == shown
    assert has_controls(text) or shown == text
    assert json.loads(printable(json.dumps(text, ensure_ascii=False))) == text


FORMS = ("NFC", "NFD")


@pytest.mark.parametrize("asked", FORMS)
@pytest.mark.parametrize("there", FORMS)
def test_a_file_is_found_in_the_other_unicode_form_of_its_name(tmp_path, asked, there):
    """In the folders on its way too: a disk, an editor and an archive each have a form of their own."""
    folder = tmp_path / unicodedata.normalize(there, "Führerraum")
    folder.mkdir()
    mesh = folder / unicodedata.normalize(asked, "gewölbe.obj")
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    text = (
        "environment: raum\nlength: m\nmeshes:\n"
        f"  - {{file: {unicodedata.normalize(asked, 'Führerraum')}/"
        f"{unicodedata.normalize(there, 'gewölbe.obj')}, length: m, up: z, forward: x}}\n"
    )
    (tmp_path / "environment.yaml").write_text(text)
    found = load_environment(tmp_path / unicodedata.normalize(asked, "environment.yaml"))
    assert len(found.parts) == 1
    assert load_environment(f"{tmp_path}/environment.yaml").parts == found.parts
    assert parse_yaml(f"a: {unicodedata.normalize(asked, 'sitz é')}", "f.yaml").value == {
        "a": unicodedata.normalize("NFC", "sitz é")
    }
