"""Where a control may be so that a share of a population reaches it: `workbench where`."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import workbench as wb
from tests.made_seat import corners, obj_text
from tests.toy_cockpit import STUDY, write_toy
from workbench.cli import main
from workbench.study.accommodation.control_regions import control_region

PEOPLE = 6


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    """The toy cockpit with a knob that some reach, and the places about it."""
    folder = tmp_path_factory.mktemp("region")
    path = write_toy(folder, knob=850, people=PEOPLE)
    study = wb.load_study(path)
    return path, study, control_region(study, "knob", share=0.9, within=0.12, spacing=0.06)


def test_the_nearest_place_is_one_that_a_run_with_the_control_there_confirms(toy, tmp_path):
    _, study, region = toy
    here = wb.run(study).population
    row = [one.name for one in here.requirements].index("reach knob by the right hand")
    assert here.single[row] == pytest.approx(region.known[region.today]) and here.single[row] < 0.9
    at = region.offset[region.nearest]
    assert 0 < np.linalg.norm(at) <= 0.12
    by = 1000 * (region.points[region.nearest] - region.control.at)
    moved = f"moved: [{{control: knob, alone: true, by: {[round(v, 4) for v in by.tolist()]}}}]"
    text = STUDY.replace("environment: toy\n", f"environment: toy\n{moved}\n")
    there = wb.run(wb.load_study(write_toy(tmp_path, knob=850, people=PEOPLE, study=text)))
    assert there.population.single[row] >= region.share[region.nearest] >= 0.9


def test_the_share_where_it_is_is_that_of_the_run_wherever_a_long_travel_lets_people_sit(tmp_path):
    """From the most comfortable position of the seat nobody reaches the knob, who goes forward for it."""
    path = write_toy(tmp_path, knob=900, people=4)
    room = tmp_path / "environments/toy/environment.yaml"
    text = room.read_text()
    room.write_text(
        text.replace("{forward: [0, 0], up: [0, 0]}", "{forward: [0, 80], up: [0, 60]}")
    )
    study = wb.load_study(path)
    found = wb.run(study).population
    row = [one.name for one in found.requirements].index("reach knob by the right hand")
    region = control_region(study, "knob", share=0.9, within=0.05, spacing=0.05)
    assert region.known[region.today] == region.together == pytest.approx(found.single[row])
    assert found.seat.any() and found.single[row] > 0


def test_places_nearer_to_the_shoulder_are_reached_by_no_fewer(toy):
    """On the line from the knob straight aft: the arm does not get longer."""
    region = toy[2]
    line = (np.abs(region.offset[:, 1:]) < 1e-9).all(axis=1) & region.on_lattice
    farther = region.enough[line][np.argsort(region.offset[line, 0])]
    assert farther.any() and not farther.all() and (np.diff(farther.astype(int)) <= 0).all()


def test_no_place_is_inside_a_solid_or_in_somebody_or_behind_the_backrest(tmp_path):
    swap = {"knob: {at: [850.0000, -180, 850]": "knob: {at: [60, 0, 500]"}
    path = write_toy(tmp_path, knob=850, people=2)
    room = tmp_path / "environments/toy/environment.yaml"
    text = room.read_text()
    ((old, new),) = swap.items()
    assert old in text
    room.write_text(text.replace(old, new))
    region = control_region(wb.load_study(path), "knob", share=0.5, within=0.2, spacing=0.05)
    inside = region.points[region.inside >= 0]
    assert len(inside) and not region.enough[region.inside >= 0].any()
    back = (region.points[:, 0] < -0.005) & (np.abs(region.points[:, 1]) < 0.25)
    assert back.any() and not region.enough[back].any()
    trunk = np.linalg.norm(region.points - np.array([0.11, 0.0, 0.45]), axis=1) < 0.06
    assert trunk.any() and not region.enough[trunk].any()


def test_obstacles_make_the_region_smaller(toy, tmp_path):
    _, _, region = toy
    path = write_toy(tmp_path, knob=850, people=PEOPLE)
    mesh = tmp_path / "environments/toy/toy.obj"
    text = mesh.read_text()
    assert "v 1500 -300 600" in text  # the panel comes to stand between the people and the knob
    mesh.write_text(text.replace("v 1500 ", "v 600 ").replace("v 1520 ", "v 620 "))
    walled = control_region(wb.load_study(path), "knob", share=0.9, within=0.12, spacing=0.06)
    assert region.enough.sum() > walled.enough[walled.on_lattice].sum()


def test_a_table_a_picture_and_sentences_are_written(toy, tmp_path, capsys):
    out = tmp_path / "out"
    command = ["where", str(toy[0]), "--control", "knob", "--share", "90", "--within", "120"]
    assert main([*command, "--spacing", "60", "-o", str(out)]) == 0
    said = capsys.readouterr().out
    assert "of 6 people reach knob where it is" in said and "the nearest place that 90 %" in said
    with (out / "region.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    enough = [row for row in rows if row["state"] == "enough reach it"]
    assert len(enough) == toy[2].enough.sum() > 0
    assert all(float(row["share"]) >= 0.9 for row in enough)
    assert all(float(row["share_at_most"]) < 0.9 for row in rows if row not in enough)
    assert "nearest place that will do" in (out / "region.svg").read_text()


def test_a_control_out_of_everybodys_reach_says_so_and_where_most_would_reach_it(tmp_path, capsys):
    path = write_toy(tmp_path, knob=4000, people=2)
    command = ["where", str(path), "--control", "knob", "--spacing", "150", "-o"]
    assert main([*command, str(tmp_path / "far")]) == 1
    assert "Nobody of 2 people reaches any place within 1,200 mm of knob" in capsys.readouterr().out
    path = write_toy(tmp_path / "less", knob=1700, people=2)
    command = ["where", str(path), "--control", "knob", "--spacing", "150", "--within", "600"]
    code = main([*command, "-o", str(tmp_path / "found")])
    said = capsys.readouterr().out
    assert (
        code == 0
        and "0 % of 2 people reach knob where it is, each from one position of the seat for everything; 100 % do"
        in said
    )


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--control", "knbo"], 3, "has no control 'knbo'; did you mean 'knob'?"),
        (["--control", "knob", "--share", "0"], 2, "share: expected above 0, up to 100 %"),
        (["--control", "knob", "--spacing", "0"], 2, "0 < spacing <= within <= 1200 mm"),
        (["--control", "knob", "--spacing", "1"], 2, "makes too many places within 300 mm"),
        (["--control", "knob", "--within", "3000"], 2, "within <= 1200 mm"),
    ],
)
def test_what_cannot_be_asked_is_refused_before_any_work(toy, capsys, arguments, code, words):
    assert main(["where", str(toy[0]), *arguments]) == code
    assert words in capsys.readouterr().err


def test_a_study_of_single_people_is_refused(capsys):
    assert main(["where", "trainer_clearance", "--control", "flaps"]) == 3
    assert "give a role a 'population'" in capsys.readouterr().err


SHELF = """study: shelf
length: mm
environment: shelf/environment.yaml
people:
  person: {body: adult_male, stand: {"on": [ON, 0, 0]AREA}, population: {source: ansur2, people: 3, seed: 1}}
cases: [{name: up, people: {person: {posture: standing}}}]
criteria: [{name: reach, check: reach, controls: [knob]}]
"""


def standing_at(folder, on, area="", more=None):
    """The region about a knob 900 mm ahead of the origin, of people who stand there."""
    folder.mkdir()
    (folder / "shelf").mkdir()
    parts = {"post": corners((0.9, -0.02, 0.0), (0.94, 0.02, 1.1)), **(more or {})}
    (folder / "shelf" / "post.obj").write_text(obj_text(parts))
    (folder / "shelf" / "environment.yaml").write_text(
        "environment: shelf\nlength: mm\nmeshes: [{file: post.obj, length: m, up: z, forward: x}]\n"
        "controls: {knob: {at: [900, 0, 1100], grip: push, zone: 2, part: post}}\n"
    )
    (folder / "study.yaml").write_text(SHELF.replace("ON", str(on)).replace("AREA", area))
    study = wb.load_study(folder / "study.yaml")
    return control_region(study, "knob", share=0.9, within=0.1, spacing=0.1)


def test_who_may_step_reaches_what_is_reached_from_the_ends_of_the_area(tmp_path):
    stays = standing_at(tmp_path / "stays", 0)
    steps = standing_at(tmp_path / "steps", 0, ", area: {forward: [0, 400], left: [0, 800]}")
    nearer = standing_at(tmp_path / "nearer", 400)
    assert stays.known[stays.today] == 0 and nearer.known[nearer.today] == 1
    assert steps.share[steps.today] == 1 and steps.enough[nearer.enough].all()
    assert steps.standing and steps.steps and not stays.steps
    assert steps.together == 1 and stays.together == stays.known[stays.today]


def test_who_steps_for_a_control_alone_and_who_does_everything_from_one_place_are_told_apart(
    tmp_path, capsys
):
    """Two knobs 1.6 m apart: each is reached from its own end of the area, both from nowhere."""
    study = SHELF.replace("controls: [knob]", "controls: [knob, other]").replace("ON", "400")
    study = study.replace("AREA", ", area: {left: [-800, 800]}")
    standing_at(tmp_path / "room", 400)
    place = tmp_path / "room" / "shelf" / "environment.yaml"
    knobs = "".join(
        f"{name}: {{at: [900, {y}, 1100], grip: push, zone: 2, part: post}}, "
        for name, y in (("knob", -800), ("other", 800))
    )
    place.write_text(place.read_text().split("controls:")[0] + f"controls: {{{knobs}}}\n")
    path = tmp_path / "room" / "study.yaml"
    path.write_text(study)
    found = wb.run(wb.load_study(path)).population
    row = [one.name for one in found.requirements].index("reach knob")
    command = ["where", str(path), "--control", "knob", "--spacing", "100", "--within", "100"]
    assert main([*command, "-o", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert found.single[row] < 1 and not found.served.any()
    assert said.startswith(
        "Knob may stay where each steps for it alone: 100 % of 3 people reach it there, and 95 % "
        f"must; {100 * found.single[row]:.0f} % do, each from one place to stand for everything."
    )
