"""What a picture cuts off is said, and a wall before a finding is looked through."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.made_seat import corners, obj_text
from workbench.cli import main
from workbench.draw.camera import standard_view
from workbench.draw.hidden import cut_off_words, seen_through
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.views import framed_views

PARTS = {
    "knob": corners((0.0, -0.02, -0.02), (0.04, 0.02, 0.02)),
    "door": corners((-0.6, 0.5, -0.6), (0.6, 0.52, 0.6)),
    "outer_door": corners((-0.6, 0.6, -0.6), (0.6, 0.62, 0.6)),
    "roof": corners((-0.6, -0.6, 0.6), (0.6, 0.6, 0.62)),
}


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    path = tmp_path_factory.mktemp("box") / "box.obj"
    path.write_text(obj_text(PARTS))
    return wb.environment_from_mesh(path, up="z", forward="x", length="m")


def close(name):
    return standard_view(name, np.array([[-0.2] * 3, [0.2] * 3]), width=80, height=80, margin=0)


def test_walls_before_a_point_are_seen_through_one_behind_the_other(box):
    scene, through = seen_through(Scene((), box), close("left"), [np.zeros(3)], kept=["knob"])
    assert set(through) == {"door", "outer_door"}
    assert scene.environment.see_through.tolist() == [False, True, True, False]


def test_walls_on_the_other_side_and_the_part_that_it_is_about_stay(box):
    assert seen_through(Scene((), box), close("front"), [np.zeros(3)], kept=["knob"])[1] == ()
    doors = ["door", "outer_door"]
    assert seen_through(Scene((), box), close("left"), [np.zeros(3)], kept=doors)[1] == ()


def test_parts_outside_a_picture_and_cut_away_before_people_are_named(box):
    arm = wb.load_body("bubbleman")
    placed = wb.place(arm, wb.pose(arm, {}, reference="LT", position=(0.0, 0.0, 3.0)))
    scene = Scene((SceneBody(placed),), box)
    camera = dict(framed_views(scene, ["left"], width=100, height=100))["left"]
    said = cut_off_words(scene, camera)
    assert said[0].startswith("outside the picture, which is as large as the people: knob, door")
    assert said[-1] == "cut away before the people: door, outer_door"
    assert cut_off_words(Scene((), box), camera) == []


def test_a_drawn_study_says_what_is_cut_off(tmp_path, capsys):
    out = tmp_path / "a.png"
    arguments = ["render", "trainer_clearance", "--view", "left", "-o", str(out), "--size", "60"]
    assert main(arguments) == 0
    assert (
        "beyond the picture: the environment by itself shows all of it" in capsys.readouterr().err
    )
