"""Meshes in frames that do not go together, and seats that look the wrong way, are suspected."""

from __future__ import annotations

import pytest

from tests.conftest import ROOT
from tests.made_seat import corners, obj_text, seat_parts
from workbench.errors import InputError
from workbench.files.bare_mesh import read_bare
from workbench.files.environments import load_environment

CAB = {
    "floor": corners((-0.6, -0.7, -0.05), (1.6, 0.7, 0.0)),
    "wall": corners((-0.6, -0.7, 0.0), (-0.55, 0.7, 1.1)),
    "roof": corners((-0.6, -0.7, 1.1), (0.6, 0.7, 1.15)),
}
PANEL = {
    "fascia": corners((0.75, -0.6, 0.4), (0.8, 0.6, 0.7)),
    "coaming": corners((0.6, -0.5, 0.7), (0.8, 0.5, 0.72)),
}


def cab(folder, panel, **mesh):
    """An environment of a cab and a panel, each in its own file; what it says of the panel."""
    (folder / "cab.obj").write_text(obj_text(CAB))
    (folder / "panel.obj").write_text(panel)
    rows = [{"file": "cab.obj"}, {"file": "panel.obj", **mesh}]
    frame = {"length": "m", "up": "z", "forward": "x"}
    lines = [f"  - {frame | row}".replace("'", "") for row in rows]
    text = "environment: cab\nlength: mm\nmeshes:\n" + "\n".join(lines) + "\n"
    (folder / "environment.yaml").write_text(text)
    return [line for line in load_environment(folder).warnings if "[frame of" in line]


def test_files_in_one_frame_and_small_ones_on_others_are_not_doubted(tmp_path):
    assert cab(tmp_path, obj_text(PANEL)) == []
    knob = {"knob": corners((-0.55, 0.1, 0.5), (-0.52, 0.13, 0.53))}
    assert cab(tmp_path, obj_text(knob)) == []


@pytest.mark.parametrize(
    ("right", "stated"), [("m", "cm"), ("m", "in"), ("ft", "cm"), ("ft", "mm"), ("in", "mm")]
)
def test_a_file_in_a_smaller_unit_than_its_own_is_told_with_the_right_one(tmp_path, right, stated):
    """The panel is 1.2 m wide: 12 mm, 30 mm, 39 mm, 4 mm and 47 mm as stated."""
    if (right, stated) == ("ft", "mm"):
        with pytest.raises(InputError, match=r"0\.00394 m large, and 0.005 to 60 m is plausible"):
            cab(tmp_path, obj_text(PANEL, right), length=stated)
        return
    (found,) = cab(tmp_path, obj_text(PANEL, right), length=stated)
    assert f"it would be among them if its unit were {right} (length: {right})" in found


@pytest.mark.parametrize(("right", "taken"), [("cm", "mm"), ("m", "cm"), ("ft", "in")])
def test_of_two_files_the_one_whose_named_parts_have_wrong_sizes_is_told_alone(
    tmp_path, right, taken
):
    """A seat of 0.9 m is 90, 9 or 75 mm large as it is taken; the panel of 1.2 m is right."""
    seat = {"driver_seat": corners((0.0, -0.25, 0.2), (0.5, 0.25, 1.1))}
    (tmp_path / "cab.obj").write_text(obj_text(CAB | seat, right))
    (tmp_path / "panel.obj").write_text(obj_text(PANEL, "m"))
    rows = [f"{{file: {name}.obj, length: {unit}, up: z, forward: x}}" for name, unit in (("cab", taken), ("panel", "m"))]  # fmt: skip
    text = f"environment: cab\nlength: mm\nmeshes: [{', '.join(rows)}]\n"
    (tmp_path / "environment.yaml").write_text(text)
    told = [line for line in load_environment(tmp_path).warnings if "[frame of" in line]
    sizes = [line for line in load_environment(tmp_path).warnings if "[sizes in cab.obj]" in line]
    assert told == [] and f"m in {right}" in sizes[0]


@pytest.mark.parametrize(("up", "forward"), [("y", "x"), ("y", "z")])
def test_a_file_with_another_axis_up_is_told_with_that_axis(tmp_path, up, forward):
    text = obj_text(PANEL, up=up, forward=forward)
    assert cab(tmp_path, text, up=up, forward=forward) == []
    wrong = {"up": "z", "forward": "x"} if forward == "x" else {"up": "x", "forward": "z"}
    (found,) = cab(tmp_path, text, **wrong)
    assert f"panel.obj is alike above and below, all other files on the left and right: is another of its axes up, up: {up}?" in found  # fmt: skip


def test_a_file_that_is_five_metres_aside_is_told_with_how_far(tmp_path):
    (found,) = cab(tmp_path, obj_text(PANEL), move=[0, 5000, 0])
    # its middle is 5 m aside, the cab's side 0.7 m
    assert "its middle 4.3 m from the surface of any other file" in found
    assert "are its unit and place right (length, move)?" in found


@pytest.mark.parametrize("forward", ["x", "-x"])
def test_names_that_say_another_axis_than_the_stated_one_are_told_with_it(tmp_path, forward):
    """Where nothing is stated the names give the axis, and nothing is doubted."""
    path = tmp_path / "cab.obj"
    parts = {"left_pedal": corners((0.7, 0.1, 0.1), (0.75, 0.2, 0.2))}
    parts |= {"rear_wall": CAB["wall"], "floor": CAB["floor"]}
    path.write_text(obj_text(parts))
    warnings = read_bare([path], length="m", up="z", forward=forward).environment.warnings
    told = [line for line in warnings if "forward is another way than it is taken" in line]
    assert len(told) == (forward == "-x")
    assert all("cab.obj forward: x?" in line for line in told)
    assert read_bare([path], length="m").frames[0].forward.value == "x"


def test_a_seat_that_looks_away_from_its_pedals_or_over_its_back_is_told(tmp_path):
    """The seat is made to look ahead, and stated to look back."""
    parts = seat_parts(0.0, 0.0) | {"pedal": corners((0.9, 0.15, 0.1), (0.95, 0.25, 0.2))}
    (tmp_path / "cab.obj").write_text(obj_text(parts))
    text = """environment: cab
length: mm
meshes: [{file: cab.obj, length: m, up: z, forward: x}]
seats:
  driver:
    srp: [100, 200, 300]
    cushion_angle: 0
    back_angle: 0
    yaw: YAW
    cushion: {part: pan, segments: [LT], depth: 20}
    back: {part: rest, segments: [LT], depth: 20}
controls: {brake: {at: [900, 200, 150], part: pedal, grip: foot, zone: 1}}
"""
    told = {}
    for yaw in (0, 180):
        (tmp_path / "environment.yaml").write_text(text.replace("YAW", str(yaw)))
        said = load_environment(tmp_path).warnings
        told[yaw] = [line for line in said if "[heading of seat driver]" in line]
    assert told[0] == []
    # the middle of the pan is 225 mm ahead of the seat reference point, that of the rest 40 mm behind
    assert (
        "all seats face backward, and the pedal 'brake' lies 800 mm behind its reference point, "
        "and its back lies 265 mm ahead of its cushion" in told[180][0]
    )


def test_the_environments_of_the_catalogue_are_not_suspected():
    for folder in sorted((ROOT / "environments").iterdir()):
        said = load_environment(folder).warnings
        assert not [line for line in said if "[frame of" in line or "[heading of" in line]
