"""Several mesh files put together by pointing, and what is offered and put away there."""

from __future__ import annotations

import pytest

from tests.made_seat import corners, obj_text, seat_parts
from workbench.errors import InputError
from workbench.files.environments import load_environment
from workbench.study.describe.edits_files import (
    added_file,
    files_beside,
    floored,
    framed,
    met_file,
    moved_file,
    removed_file,
)
from workbench.study.describe.edits_parts import joined, large_part, split_part
from workbench.study.describe.edits_things import accepted, placed_point
from workbench.study.describe.meshes import Ray
from workbench.study.describe.saving import save_description, save_first_study
from workbench.study.describe.state import open_place, open_sizes, standing_of

DOWN = (0.0, 0.0, -1.0)
METRES = {"length": "m", "up": "z", "forward": "x"}


def two_files(folder, other, name="panel.obj"):
    """A cab that is open, and a second file that was added to it."""
    (folder / "cab.obj").write_text(obj_text(seat_parts()))
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(obj_text(other))
    opened = open_place(folder / "cab.obj")
    sure = framed(opened, opened.start, 0, METRES).description
    return added_file(opened, sure, path)


KNOB = {"knob": corners((0.0, 0.0, 0.0), (0.02, 0.02, 0.02))}


def test_a_second_file_has_unit_axes_and_offset_of_the_first(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts()))
    (tmp_path / "panel.obj").write_text(obj_text(KNOB))
    opened = open_place(tmp_path / "cab.obj")
    turned = framed(opened, opened.start, 0, {**METRES, "forward": "-x"}).description
    up = moved_file(opened, turned, 0, [0.0, 0.0, 0.5]).description
    added = added_file(opened, up, tmp_path / "panel.obj")
    panel = added.edit.description.says["meshes"][1]
    assert panel == {"file": "panel.obj", **METRES, "forward": "-x", "move": [0, 0, 500]}
    stands = standing_of(added.opened, added.edit.description)
    box = stands.boxes[stands.names.index("knob")]
    assert box[:, 2] == pytest.approx([0.5, 0.52])
    assert added.edit.description.why[("meshes", 1, "forward")] == "guessed: as cab.obj"


def test_a_second_file_is_moved_by_numbers_and_by_two_points_and_saved(tmp_path):
    added = two_files(tmp_path, KNOB)
    opened = added.opened
    moved = moved_file(opened, added.edit.description, 1, [1.0, 0.0, 0.3]).description
    on_knob = Ray("knob", (1.01, 0.01, 3.0), DOWN, 2.68)
    on_lever = Ray("lever", (0.62, 0.02, 3.0), DOWN, 2.4)
    met = met_file(opened, moved, on_knob, on_lever)
    # its top, 320 mm high, comes onto the lever's, 600 mm high
    assert met.description.says["meshes"][1]["move"] == [610, 10, 580]
    assert met.words == "panel.obj is moved by -390, 10, 280 mm"
    save_description(opened, met.description, None)
    found = load_environment(tmp_path / "environment.yaml")
    assert found.parts == ("pan", "rest", "floor", "lever", "knob")
    with pytest.raises(InputError, match="both points are of one file"):
        met_file(opened, moved, on_lever, on_lever)


def test_what_was_picked_goes_along_with_its_file(tmp_path):
    added = two_files(tmp_path, KNOB)
    ray = Ray("knob", (0.01, 0.01, 3.0), DOWN, 2.98)
    given = {"grip": "pinch", "zone": 1}
    opened, before = added.opened, added.edit.description
    spot = placed_point(opened, before, "control", "dial", given, ray).description
    moved = moved_file(opened, spot, 1, [0.5, 0.0, 0.0]).description
    assert moved.says["controls"]["dial"]["at"] == [510, 10, 20]
    floor = floored(opened, moved, Ray("floor", (0.9, -0.4, 2.0), DOWN, 2.0)).description
    again = moved_file(opened, floor, 0, [0.0, 0.0, 0.7]).description
    assert again.says["meshes"][0]["move"] == [
        0,
        0,
        700,
    ]  # what is typed holds, the floor's pick not


def test_names_that_are_taken_get_the_name_of_the_file(tmp_path):
    added = two_files(
        tmp_path, {"lever": KNOB["knob"], "dial": corners((1, 0, 0), (1.1, 0.1, 0.1))}
    )
    stands = standing_of(added.opened, added.edit.description)
    assert stands.names == ("pan", "rest", "floor", "lever", "panel lever", "dial")
    twice = added_file(added.opened, added.edit.description, tmp_path / "panel.obj")
    names = standing_of(twice.opened, twice.edit.description).names
    assert names[6:] == ("panel lever_2", "panel dial")


def test_a_file_from_elsewhere_is_copied_and_another_one_of_its_name_refused(tmp_path):
    (tmp_path / "cab").mkdir()
    (tmp_path / "parts").mkdir()
    added = two_files(tmp_path / "cab", KNOB, "../parts/panel.obj")
    save_description(added.opened, added.edit.description, None)
    assert (tmp_path / "cab" / "panel.obj").read_bytes() == (tmp_path / "parts" / "panel.obj").read_bytes()  # fmt: skip
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "panel.obj").write_text(obj_text(KNOB))
    with pytest.raises(InputError, match=r"there is a mesh panel\.obj already"):
        added_file(added.opened, added.edit.description, tmp_path / "more" / "panel.obj")


def test_the_last_file_is_taken_away_unless_something_is_on_it(tmp_path):
    added = two_files(tmp_path, KNOB)
    opened, both = added.opened, added.edit.description
    assert files_beside(opened) == []
    with pytest.raises(InputError, match="that was added last"):
        removed_file(opened, both, 0)
    ray = Ray("knob", (0.01, 0.01, 3.0), DOWN, 2.98)
    picked = placed_point(opened, both, "point", "eye", {}, ray).description
    with pytest.raises(InputError, match=r"panel\.obj: something was picked on it"):
        removed_file(opened, picked, 1)
    one = removed_file(opened, both, 1).description
    assert standing_of(opened, one).names == ("pan", "rest", "floor", "lever")
    assert [row["file"] for row in one.says["meshes"]] == ["cab.obj"]


def test_pieces_are_called_anew_where_the_front_is_put_right(tmp_path):
    parts = {
        "a": corners((1.0, 0.7, 0.0), (2.0, 0.72, 1.0)),
        "b": corners((-2.0, -0.72, 0.0), (-1.0, -0.7, 1.0)),
        "c": corners((-2.0, -0.6, -0.1), (2.0, 0.6, 0.0)),
    }
    (tmp_path / "cab.obj").write_text(obj_text(parts, names=False))
    opened = open_place(tmp_path / "cab.obj")
    ahead = framed(opened, opened.start, 0, METRES).description
    mine = joined(opened, ahead, ["floor"], "deck").description
    names = standing_of(opened, mine).names
    assert names == ("left_front_side_plate", "right_rear_side_plate", "deck")
    round_ = framed(opened, mine, 0, {**METRES, "forward": "-x"}).description
    assert standing_of(opened, round_).names == (
        "right_rear_side_plate",
        "left_front_side_plate",
        "deck",
    )


def test_a_part_that_most_of_the_mesh_is_is_to_be_split_first(tmp_path):
    rows = [corners((k, 0, 0), (k + 0.5, 0.5, 0.5)) for k in range(4)]
    text = obj_text({"body": rows[0], "": rows[1], " ": rows[2], "wheel": rows[3]})
    (tmp_path / "cab.obj").write_text(text.replace("o \n", "").replace("o  \n", ""))
    opened = open_place(tmp_path / "cab.obj")
    found = large_part(opened, opened.start)
    assert (found.name, found.share, found.pieces) == ("body", 0.75, 3)
    split = split_part(opened, opened.start, "body").description
    assert large_part(opened, split) is None


def test_a_doubt_is_put_away_in_the_file(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text({"box": corners((0, 0, 0), (3, 2, 30.0))}))
    opened = open_place(tmp_path / "cab.obj")
    sure = framed(opened, opened.start, 0, METRES).description
    (doubt,) = open_sizes(opened, sure)
    away = accepted(sure, doubt.about).description
    assert open_sizes(opened, away) == []
    save_description(opened, away, None)
    assert "accepted:\n  - height\n" in (tmp_path / "environment.yaml").read_text()
    assert open_sizes(open_place(tmp_path / "environment.yaml"), away) == []


def test_a_click_on_a_part_that_was_renamed_meanwhile_is_not_lost(tmp_path):
    added = two_files(tmp_path, KNOB)
    renamed = joined(added.opened, added.edit.description, ["lever"], "gear").description
    ray = Ray("lever", (0.62, 0.02, 2.0), DOWN, 1.4)
    found = placed_point(added.opened, renamed, "point", "here", {}, ray)
    assert found.words == "here is on gear"
    with pytest.raises(InputError, match="there is no part 'lever' any more"):
        placed_point(added.opened, renamed, "point", "here", {}, Ray("lever", (0.62, 0.02, 2.0), DOWN, 1.0))  # fmt: skip


def test_a_first_study_is_written_once(tmp_path):
    added = two_files(tmp_path, KNOB)
    save_description(added.opened, added.edit.description, None)
    assert save_first_study(tmp_path / "environment.yaml", tmp_path / "study.yaml").warnings == ()
    with pytest.raises(InputError, match=r"study\.yaml is there already"):
        save_first_study(tmp_path / "environment.yaml", tmp_path / "study.yaml")
