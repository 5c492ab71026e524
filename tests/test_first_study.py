"""First studies: who does what, what is asked, where people stand, and that it runs and makes sense."""

from __future__ import annotations

import math
import re

import pytest
import yaml

import workbench as wb
from tests.made_seat import corners, obj_text, seat_parts
from workbench.cli import main

SEAT = "{srp: SRP, back_angle: 20, cushion_angle: 10, yaw: 0, cushion: {part: pan, segments: [LT], depth: 10}, back: {part: rest, segments: [LT, UT], depth: 10}}"  # fmt: skip
DRIVER = SEAT.replace("SRP", "[100, 200, 300]")


def write_cab(folder, *, parts=None, seats=(("driver", DRIVER),), controls="{}", points="{}"):
    """Write an environment; returns the path of its file."""
    folder.mkdir(exist_ok=True)
    (folder / "cab.obj").write_text(obj_text(parts or seat_parts()))
    rows = "".join(f"  {name}: {seat}\n" for name, seat in seats)
    (folder / "environment.yaml").write_text(
        "environment: cab\nlength: mm\nmeshes: [{file: cab.obj, length: m, up: z, forward: x}]\n"
        + (f"seats:\n{rows}" if rows else "")
        + f"controls: {controls}\npoints: {points}\n"
    )
    return folder / "environment.yaml"


def first(place, *options):
    """The first study of an environment, as data."""
    assert main(["new", str(place), *options]) == 0
    return yaml.safe_load((place.parent / "study.yaml").read_text())


def control(at, grip="grasp", zone=1, part="lever"):
    return f"{{at: {list(at)}, grip: {grip}, zone: {zone}, part: {part}}}"


def predicted(study, role="driver"):
    return study["cases"][0]["people"][role]["predicted"]


def asked(study, check):
    return [row for row in study["criteria"] if row["check"] == check]


@pytest.fixture(scope="module", params=["trainer", "compact_car"])
def shipped(request, tmp_path_factory):
    path = tmp_path_factory.mktemp(request.param) / "study.yaml"
    assert main(["new", request.param, "-o", str(path)]) == 0
    return path


def test_the_first_study_of_each_shipped_environment_holds(shipped):
    result = wb.run(wb.load_study(shipped))
    # a hand on the throttle may touch the quadrant within the error of the body's surface
    assert [v.criterion.name for v in result.verdicts if not (v.passed or v.doubtful)] == []
    assert not [line for line in result.warnings if "no criterion asks" in line]


def test_hands_are_on_stick_and_throttle_and_never_on_a_latch(shipped):
    study = yaml.safe_load(shipped.read_text())
    held = {name for person in study["cases"][0]["people"].values() for name in person.get("predicted", {}).get("hands", {}).values()}  # fmt: skip
    if study["environment"] == "trainer":
        assert held == {"left_stick", "throttle", "right_stick"}
        assert predicted(study, "left")["hands"] == {"left": "left_stick", "right": "throttle"}
        assert predicted(study, "left")["eyes"] == "left_design_eye"
        assert predicted(study, "right")["heels"] == "right_heel"
    else:
        assert held == {"wheel_nine", "wheel_three"}
        assert predicted(study)["feet"] == {"left": "foot_rest", "right": "accelerator"}
        assert predicted(study)["eyes"] == "design_eye"
        assert study["cases"][0]["people"]["passenger"] == {"posture": "passenger at rest"}


FEET = [
    ({"gas": 100, "brake": 250}, {"left": "brake", "right": "gas"}),
    ({"accelerator": 100, "brake": 200, "clutch": 300}, {"left": "clutch", "right": "accelerator"}),
    ({"rudder_a": 300, "rudder_b": 100}, {"left": "rudder_a", "right": "rudder_b"}),
    ({"treadle": 180}, {"right": "treadle"}),
    ({"Gaspedal": 100, "Bremse": 200, "parking_brake": 320}, {"left": "Bremse", "right": "Gaspedal"}),
]  # fmt: skip


@pytest.mark.parametrize(("pedals", "feet"), FEET)
def test_feet_are_on_pedals_by_name_and_never_both_on_one(tmp_path, pedals, feet):
    rows = ", ".join(f"{name}: {control((850, y, 120), 'foot')}" for name, y in pedals.items())
    assert predicted(first(write_cab(tmp_path, controls=f"{{{rows}}}")))["feet"] == feet


HANDS = [
    ({"yoke_l": (500, 350), "yoke_r": (500, 50)}, {"left": "yoke_l", "right": "yoke_r"}),
    ({"stick": (450, 200), "power_lever": (450, -50)}, {"left": "stick", "right": "power_lever"}),
    ({"stick": (450, 200), "throttle": (450, 450)}, {"left": "throttle", "right": "stick"}),
    ({"SteuerKnüppel": (450, 200), "door_latch": (400, 0), "park_brake": (400, 450)}, {"right": "SteuerKnüppel"}),
    ({"control column": (450, 200), "trim_wheel": (400, 400)}, {"right": "control column"}),
    ({"steering_wheel": (500, 200), "gear_selector": (450, 0)}, {"left": "steering_wheel", "right": "gear_selector"}),
]  # fmt: skip


@pytest.mark.parametrize(("controls", "hands"), HANDS)
def test_hands_are_on_the_wheel_or_stick_and_on_what_is_nearest(tmp_path, controls, hands):
    rows = ", ".join(f'"{name}": {control((*at, 600))}' for name, at in controls.items())
    assert predicted(first(write_cab(tmp_path, controls=f"{{{rows}}}")))["hands"] == hands


def test_a_throttle_that_is_pushed_is_held_by_the_hand_of_its_side_all_the_same(tmp_path):
    yoke = control((450, 200, 600))
    knob = control((450, 0, 500), "push")
    study = first(write_cab(tmp_path, controls=f"{{yoke: {yoke}, throttle: {knob}}}"))
    assert predicted(study)["hands"] == {"left": "yoke", "right": "throttle"}


def test_footplates_that_go_along_are_no_pedals_and_hands_are_on_what_is_nearest(tmp_path):
    path = tmp_path / "study.yaml"
    assert main(["new", "counter", "-o", str(path)]) == 0
    study = yaml.safe_load(path.read_text())
    hands = {"left": "bell", "right": "card_terminal"}
    assert predicted(study, "wheelchair")["hands"] == hands
    assert asked(study, "preferred_seat") == []


def test_a_sitter_with_switches_alone_rests_and_is_asked_to_reach_them(tmp_path):
    rows = f"{{start_button: {control((600, 100, 500), 'push')}}}"
    study = first(write_cab(tmp_path, controls=rows))
    assert study["cases"][0]["people"]["driver"] == {"posture": "at rest"}
    assert asked(study, "reach")[0]["controls"] == ["start_button"]


def test_what_was_guessed_stands_on_the_screen_and_in_the_study(tmp_path, capsys):
    place = write_cab(tmp_path, controls=f"{{stick: {control((450, 200, 600))}}}")
    first(place)
    told = capsys.readouterr().out
    line = "driver: right hand on stick: by its name, 'stick'"
    assert f"guessed: {line}" in told and f"#   {line}" in (tmp_path / "study.yaml").read_text()


def test_limits_that_are_assumed_say_so(shipped):
    lines = shipped.read_text().splitlines()
    rows = [k for k, line in enumerate(lines) if re.search("at_least: [1-9]|below: ", line)]
    assert rows and all("# assumed" in lines[k - 1] for k in rows)


def test_head_room_is_asked_from_what_is_above_and_knee_room_from_what_is_before(tmp_path):
    parts = seat_parts() | {
        "roof": corners((-0.4, -0.4, 1.45), (0.6, 0.8, 1.5)),
        "shelf": corners((0.9, -0.3, 0.4), (0.95, 0.7, 0.7)),
        "aft_wall": corners((-0.9, -0.4, 0.0), (-0.85, 0.8, 1.5)),
    }
    rows = {row["name"]: row for row in asked(first(write_cab(tmp_path, parts=parts)), "clearance")}
    assert rows["head room"]["parts"] == ["roof"] and rows["head room"]["segments"] == ["H"]
    assert rows["knee room"]["parts"] == ["lever", "shelf"]


def test_people_are_drawn_into_the_seat_that_operates(tmp_path):
    place = write_cab(tmp_path, controls=f"{{stick: {control((450, 200, 600))}}}")
    assert first(place, "--people", "7")["people"]["driver"] == {"body": "adult_male", "seat": "driver"}  # fmt: skip
    study = wb.load_study(tmp_path / "study_people.yaml")
    assert len(study.roles) == 1 and study.roles[0].population is not None
    assert [c.at_least for c in study.criteria if c.check == "share"] == [0.9]
    assert main(["new", str(place), "-o", str(tmp_path / "other.yaml"), "--people", "-1"]) == 2


def test_people_are_written_beside_a_study_that_stays_as_it_is(tmp_path, capsys):
    place = write_cab(tmp_path, controls=f"{{stick: {control((450, 200, 600))}}}")
    mine = tmp_path / "study.yaml"
    mine.write_text("# my own\n")
    assert main(["new", str(place), "--people", "7"]) == 0
    assert mine.read_text() == "# my own\n" and (tmp_path / "study_people.yaml").exists()
    assert "study.yaml: is there already and stays as it is" in capsys.readouterr().err
    assert main(["new", str(place), "--people", "7"]) == 3
    assert (
        "study_people.yaml: is there already: name another file with -o" in capsys.readouterr().err
    )


DESK = {
    "floor": corners((-3, -3, -0.02), (3, 3, 0)),
    "desk": corners((0, -0.6, 0), (0.5, 0.6, 1.0)),
}


def test_somebody_stands_at_the_controls_on_the_floor_and_faces_them(tmp_path, capsys):
    at = {"a": (0, 150, 900), "b": (0, -150, 900)}
    rows = ", ".join(f"{name}: {control(p, 'push', 1, 'desk')}" for name, p in at.items())
    study = first(write_cab(tmp_path, parts=DESK, seats=(), controls=f"{{{rows}}}"))
    stand = study["people"]["person"]["stand"]
    assert -600 <= stand["on"][0] <= -250 and abs(stand["on"][1]) < 200 and stand["on"][2] == 0
    assert abs(stand["yaw"]) <= 15 or abs(stand["yaw"] - 360) <= 15
    low, high = stand["area"]["forward"]
    assert low == -300 and high <= 200
    # toes of the smallest are in the desk at the next step, and in it by what gives way at most here
    said = next(line for line in capsys.readouterr().out.splitlines() if "no more than" in line)
    assert f"no more than {high} mm ahead: farther on, even a small woman has the" in said
    assert said.endswith("in desk")
    toes = stand["on"][0] + high + 200
    assert -60 <= toes <= 60
    result = wb.run(wb.load_study(tmp_path / "study.yaml"))
    assert result.passed, [v.criterion.name for v in result.verdicts if not v.passed]


@pytest.mark.parametrize("floor", [True, False])
def test_nobody_stands_at_the_height_of_a_board_in_the_air(tmp_path, capsys, floor):
    """A board 40 mm thick, its upper side at 1,000 mm, over a floor at 0 or over nothing: then the floor
    is a metre under the control."""
    board = {"board": corners((-0.2, -0.8, 0.96), (0.1, 0.8, 1.0))}
    parts = board | ({"floor": DESK["floor"]} if floor else {})
    rows = f"{{a: {control((0, 0, 1000.4), 'push', 1, 'board')}}}"
    study = first(write_cab(tmp_path, parts=parts, seats=(), controls=rows))
    height = 0 if floor else 1
    assert study["people"]["person"]["stand"]["on"][2] == height
    said = capsys.readouterr().out
    assert (f"the floor is taken at {height} mm" in said) != floor
    assert ("on the floor below" in said) == floor
    assert ("no part 600 mm broad faces up there" in said) != floor


def test_nobody_is_to_step_into_a_ledge_in_the_floor(tmp_path):
    """A mat 10 mm high begins 0.45 m to the left of the middle."""
    rows = f"{{a: {control((0, 0, 900), 'push', 1, 'desk')}}}"
    free = first(write_cab(tmp_path / "free", parts=DESK, seats=(), controls=rows))
    mat = {"mat": corners((-3.0, 0.45, 0.0), (3.0, 3.0, 0.01))}
    kept = first(write_cab(tmp_path / "mat", parts=DESK | mat, seats=(), controls=rows))
    stands = [study["people"]["person"]["stand"] for study in (free, kept)]
    assert stands[0]["on"] == stands[1]["on"]
    assert stands[0]["area"]["left"] == [-500, 500] and stands[1]["area"]["left"] == [-500, 320]


def test_controls_far_apart_have_somebody_each(tmp_path):
    parts = DESK | {"rack": corners((0, 2.0, 0), (0.5, 2.6, 1.6))}
    rows = f"{{a: {control((0, 0, 950), 'push', 1, 'desk')}, b: {control((0, 2300, 1200), 'push', 1, 'rack')}}}"  # fmt: skip
    study = first(write_cab(tmp_path, parts=parts, seats=(), controls=rows))
    assert list(study["people"]) == ["at a", "at b"]
    a, b = (who["stand"]["on"] for who in study["people"].values())
    assert math.dist(a[:2], b[:2]) > 1500


def test_without_seats_and_controls_somebody_stands_clear_near_the_middle(tmp_path):
    study = first(write_cab(tmp_path, parts=DESK, seats=()))
    x, y, z = study["people"]["person"]["stand"]["on"]
    assert study["cases"][0]["name"] == "standing"
    assert z == 0 and math.hypot(x, y) < 1000
    assert wb.run(wb.load_study(tmp_path / "study.yaml")).passed


def test_a_seat_in_another_one_is_left_empty_and_said(tmp_path, capsys):
    twin = SEAT.replace("SRP", "[100, 210, 300]")
    study = first(write_cab(tmp_path, seats=(("left", DRIVER), ("left_again", twin))))
    assert list(study["people"]) == ["left"]
    assert "seat left_again: left empty, for it is 10 mm from seat left" in capsys.readouterr().out


def test_a_bench_without_a_back_seats_a_population_on_its_level(tmp_path):
    stool = DRIVER.replace(", back: {part: rest, segments: [LT, UT], depth: 10}", "")
    stool = stool.replace("cushion_angle: 10", "cushion_angle: 0").replace(
        "back_angle: 20", "back_angle: 5"
    )
    parts = {"pan": corners((0.0, -0.8, 0.25), (0.35, 0.8, 0.3)), "floor": corners((-1, -1, -0.1), (2, 1, 0))}  # fmt: skip
    place = write_cab(tmp_path, parts=parts, seats=(("waiting", stool),))
    study = first(place, "--people", "5")
    assert study["cases"][0]["name"] == "seated"
    environment = wb.load_environment(place)
    assert environment.seats[0].back.part == "" and environment.warnings == ()
    man = wb.run(wb.load_study(tmp_path / "study.yaml"))
    (person,) = man.postures[0].people
    torso = person.clearance.distance[0, person.placed.body.segment("LT")]
    assert torso[environment.part_index("pan")] == pytest.approx(-0.01, abs=1e-4)  # [m]
    result = wb.run(wb.load_study(tmp_path / "study_people.yaml"))
    assert (result.population.margin[:, 0] > -0.03).all()  # thighs over its edge at most


def test_a_control_in_nobodys_reach_fails_by_how_far_it_is(tmp_path):
    place = write_cab(tmp_path, controls=f"{{far_button: {control((3000, 200, 900), 'push')}}}")
    first(place)
    result = wb.run(wb.load_study(tmp_path / "study.yaml"))
    (missed,) = [v for v in result.verdicts if v.criterion.check == "reach"]
    assert not missed.passed and missed.breaches[0].value < -1.5  # [m]


def pedals_moved(folder, by):
    """The warnings of a man in a cab whose pedals are so much [mm] farther ahead than 850."""
    rows = ", ".join(f"{name}: {control((850 + by, y, 120), 'foot')}" for name, y in (("a", 300), ("b", 100)))  # fmt: skip
    seat = DRIVER.replace("yaw: 0", "yaw: 0, travel: {forward: [-20, 20], up: [0, 0]}")
    first(write_cab(folder, controls=f"{{{rows}}}", seats=(("driver", seat),)))
    found = wb.run(wb.load_study(folder / "study.yaml")).warnings
    return [re.search(r"(?:pedals|these) are (\d+) mm too (near|far) for legs at ease: the seat would have to go \1 mm farther (back|forward)", line) for line in found]  # fmt: skip


def test_pedals_too_near_or_too_far_say_by_how_much(tmp_path):
    near, nearer, far = (
        next(filter(None, pedals_moved(tmp_path / str(by), by))).groups() for by in (-50, -150, 250)
    )
    assert near[1:] == nearer[1:] == ("near", "back") and far[1:] == ("far", "forward")
    assert int(nearer[0]) - int(near[0]) == pytest.approx(100, abs=10)
