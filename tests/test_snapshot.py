"""The snapshot of answers: two runs give the same bytes, and a comparison finds everything that is
not the same."""

from __future__ import annotations

import json

import pytest

from tests.conftest import ROOT
from tools.snapshot import (
    difference,
    differences,
    flat,
    main,
    read,
    read_explanations,
    text_of,
    write,
)
from tools.snapshot_answers import body_alone, body_in_seat, picture

OLD = {
    "reach/a woman/throttle": {"reached": True, "miss_mm": 0.25, "limit": ""},
    "clearance/a man/H": {"canopy": 56.1, "panel": None, "sill": 12},
    "share/women": [0.25, 0.5, 0.75],
    "contact/a man/LT/seat/pairs": ["1:4", "2:4"],
}


@pytest.fixture
def compared(tmp_path, capsys):
    """Compare OLD with OLD after changes; returns the exit code and what was printed."""

    def compare(changes, *, lines="", gone=()):
        new = {
            name: value for name, value in (dict(flat(OLD)) | changes).items() if name not in gone
        }
        old_file, new_file, accepted = (
            tmp_path / name for name in ("old.json", "new.json.gz", "accepted.txt")
        )
        write(old_file, {"all": OLD, "before": {"old/only": 1}})
        write(new_file, {"all": new})
        accepted.write_text(lines)
        code = main(["compare", str(old_file), str(new_file), "--explain", str(accepted)])
        return code, capsys.readouterr().out

    return compare


def test_what_did_not_change_has_no_differences(compared):
    code, said = compared({})
    assert code == 0
    assert said.splitlines()[-1] == "0 differences, 0 explained, 0 not"


@pytest.mark.parametrize(
    ("name", "value", "line"),
    [
        (
            "reach/a woman/throttle/reached",
            False,
            "flag: reach/a woman/throttle/reached: true -> false",
        ),
        ("clearance/a man/H/canopy", 56.1001, "number: clearance/a man/H/canopy: 56.1 -> 56.1001"),
        ("clearance/a man/H/panel", 3.0, "flag: clearance/a man/H/panel: null -> 3.0"),
        (
            "reach/a woman/throttle/limit",
            "panel",
            'text: reach/a woman/throttle/limit: "" -> "panel"',
        ),
        (
            "share/women",
            [0.25, 0.5, 0.76],
            "number: share/women: 1 of 3 entries, entry 2: 0.75 -> 0.76",
        ),
        (
            "share/women",
            [0.25, None, 0.76],
            "flag: share/women: 2 of 3 entries, entry 1: 0.5 -> null",
        ),
        (
            "contact/a man/LT/seat/pairs",
            ["2:4", "2:5"],
            'only in old: ["1:4"], only in new: ["2:5"]',
        ),
        ("contact/a man/LT/seat/pairs", ["2:4", "1:4"], "2 -> 2 entries, in another order"),
        ("clearance/a man/H/post", 1.5, "only in new: clearance/a man/H/post: 1.5"),
    ],
)
def test_a_comparison_names_what_changed_and_fails(compared, name, value, line):
    code, said = compared({name: value})
    assert code == 1
    assert line in said


def test_a_comparison_names_an_answer_that_is_missing(compared):
    code, said = compared({}, gone=["share/women", "clearance/a man/H/canopy"])
    assert code == 1
    assert "only in old: clearance/a man/H/canopy: 56.1" in said
    assert "only in old: share/women: [0.25, 0.5, 0.75]" in said


def test_a_section_that_one_file_does_not_have_is_named_and_not_compared(
    compared, tmp_path, capsys
):
    code, said = compared({})
    assert code == 0
    assert "not compared: the section before is in one file only" in said
    write(tmp_path / "other.json", {"other": {"share/women": 1}})
    assert main(["compare", str(tmp_path / "old.json"), str(tmp_path / "other.json")]) == 3
    assert "no section in common" in capsys.readouterr().err


def test_numbers_are_equal_to_a_billionth_of_the_larger():
    assert difference("x", 1000.0, 1000.0 + 9e-7, 1e-9) is None
    assert difference("x", 1000.0, 1000.0 + 2e-6, 1e-9).size == pytest.approx(2e-6)
    assert difference("x", 0.0, 2e-9, 1e-9).kind == "number"
    assert difference("x", True, 1, 1e-9).kind == "flag"


def test_iterations_may_differ_by_a_nanometre_and_a_ten_millionth_of_a_radian():
    """Two lengths of 1 m apart by 1e-9 m, which is 1e-6 mm; two angles by 6e-6 degrees."""
    old = {"a/far_mm": 1000.0, "a/turn_deg": 1.0}
    for name, step in (("a/far_mm", 0.9e-6), ("a/turn_deg", 5.7e-6)):
        near = old | {name: old[name] + step}
        assert not list(differences(old, near, solved=True))
        apart = old | {name: old[name] + 1.2 * step}
        assert [one.name for one in differences(old, apart, solved=True)] == [name]


def test_an_explained_difference_is_accepted_up_to_its_bound(compared):
    change = {"clearance/a man/H/canopy": 56.2}
    assert compared(change, lines="# why\nclearance/*/canopy | 0.2 | a truer canopy\n")[0] == 0
    assert compared(change, lines="clearance/*/canopy | 0.05 | a truer canopy\n")[0] == 1
    assert compared(change, lines="clearance/*/sill | any | a truer sill\n")[0] == 1


def test_only_any_accepts_a_flag_or_an_answer_that_is_gone(compared):
    flag = {"reach/a woman/throttle/reached": False}
    assert compared(flag, lines="reach/* | 1000 | another search\n")[0] == 1
    assert compared(flag, gone=["clearance/a man/H/sill"], lines="* | any | all is new\n")[0] == 0


def test_an_explanation_of_nothing_is_named(compared):
    assert "explains nothing: share/* (older)" in compared({}, lines="share/* | any | older\n")[1]


@pytest.mark.parametrize(
    "line", ["share/*: any", "share/* | 1", "share/* | much | x", "share/* | -1 | x", "| any | x"]
)
def test_a_wrong_line_of_explanations_is_refused_with_its_place(tmp_path, line):
    (tmp_path / "accepted.txt").write_text(f"# remark\n{line}\n")
    with pytest.raises(ValueError, match=r"accepted.txt:2: "):
        read_explanations(tmp_path / "accepted.txt")


def test_a_file_that_is_no_snapshot_is_refused(tmp_path, capsys):
    (tmp_path / "a.json").write_text(json.dumps({"share/women": 1}))
    assert main(["compare", str(tmp_path / "a.json"), str(tmp_path / "a.json")]) == 3
    assert "not a snapshot of format 1" in capsys.readouterr().err


def test_one_bodys_answers_are_the_same_bytes_twice(tmp_path):
    seated = ("bubbleman", "trainer", "left")
    first, second = (
        dict(body_alone("bubbleman")) | dict(body_in_seat(*seated, wanted=["driving"]))
        for _ in range(2)
    )
    assert text_of({"bodies": first}) == text_of({"bodies": second})
    write(tmp_path / "a.json.gz", {"bodies": first})
    kept = read(tmp_path / "a.json.gz")["bodies"]
    assert kept == dict(flat(first))
    assert kept["measure/bubbleman/stature"] == pytest.approx(1755, abs=3)
    assert kept[
        "contact/bubbleman/trainer/left/driving/LT/left_seat_pan/deepest_mm"
    ] == pytest.approx(20, abs=0.5)
    assert kept["clearance/bubbleman/trainer/left/driving/H/canopy"] > 0


def test_a_pictures_answers_tell_another_view_apart(tmp_path):
    front, left = (
        picture(tmp_path / f"{view}.png", f"bubbleman --view {view}") for view in ("front", "left")
    )
    assert front["pixels"] == left["pixels"] == [320, 240]
    assert difference("grey", front["grey"], left["grey"], 1e-9).size > 50
    again = picture(tmp_path / "again.png", "bubbleman --view front")
    assert again == front


def test_the_command_makes_a_file_and_compares_it(tmp_path, capsys, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    made = [str(tmp_path / name) for name in ("a.json", "b.json")]
    assert [main(["make", name, "--only", "signals"]) for name in made] == [0, 0]
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert main(["compare", *made]) == 0
    assert main(["make", made[0], "--only", "dreams"]) == 2
    assert "no questions are called dreams; there are bodies," in capsys.readouterr().err
