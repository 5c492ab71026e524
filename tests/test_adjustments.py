"""Adjustments of an environment: what moves with them, who fits by them, and what is said of it."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.crowds import Crowd
from tests.test_fits_somewhere import CHANGES, fit_with_a_change
from tests.toy_cockpit import BOXES, write_toy
from workbench import InputError, load_environment, load_study
from workbench.cli import main
from workbench.draw.scene_builder import build_source
from workbench.model.surroundings import adjusted
from workbench.study.settings import settings_of
from workbench.study.workplaces import workplace_of

KNOB = 900
"""[mm] Where the knob is reached by some only."""
TRAVEL = "travel: {forward: [0, 0], up: [0, 0]}"
ADJUSTMENTS = """
adjustments:
  panel_reach: {along: [-3, 0, 0], travel: [-20, "4 cm"], parts: [panel], points: [mark]}
"""
TWO = """
adjustments:
  column_tilt: {about: {point: [1000, 0, 500], axis: [0, 2, 0]}, travel: [-20, 30], parts: [roof]}
  reach: {along: [-1, 0, 0], travel: [-50, 50], parts: [panel], points: [mark],
    mounted_on: column_tilt}
"""


def toy(folder, adjustments="", *, travel=TRAVEL, people=8, swap=None, knob=KNOB):
    """The toy cockpit with a point on its panel and adjustments; returns the study's path."""
    path = write_toy(folder, knob=knob, people=people, swap=swap or {})
    room = folder / "environments/toy/environment.yaml"
    text = room.read_text().replace("controls:", "  mark: [1500, 0, 600]\ncontrols:")
    assert TRAVEL in text
    room.write_text(text.replace(TRAVEL, travel) + adjustments)
    return path


def room_of(folder, *arguments, **options):
    toy(folder, *arguments, **options)
    return load_environment(folder / "environments/toy")


def corners(environment, part):
    return environment.triangle_corners(environment.part_index(part)).reshape(-1, 3)


def control(environment, name):
    return np.array(next(one.at for one in environment.controls if one.name == name))


def about_y(degrees):
    """(3, 3) the turn about +y by the right hand: x goes to -z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def test_what_slides_takes_its_controls_and_points_along(tmp_path):
    room = room_of(tmp_path, ADJUSTMENTS)
    out = adjusted(room, {"panel_reach": 0.03})
    way = np.array([-0.03, 0.0, 0.0])
    for before, after in (
        (corners(room, "panel"), corners(out, "panel")),
        (control(room, "knob"), control(out, "knob")),
        (np.array(room.points["mark"]), np.array(out.points["mark"])),
    ):
        np.testing.assert_allclose(after - before, np.broadcast_to(way, before.shape), atol=1e-15)
    for part in ("pan", "back", "roof"):
        np.testing.assert_array_equal(corners(out, part), corners(room, part))
    assert out.points["eye"] == room.points["eye"]
    assert out.adjustment("panel_reach").at == 0.03
    assert room.adjustment("panel_reach").travel == pytest.approx((-0.02, 0.04))


def test_what_turns_goes_about_its_axis_and_takes_along_what_is_mounted_on_it(tmp_path):
    room = room_of(tmp_path, TWO)
    pivot = np.array([1.0, 0.0, 0.5])
    turn = about_y(20)

    def turned(points):
        return (points - pivot) @ turn.T + pivot

    out = adjusted(room, {"column_tilt": np.radians(20)})
    for part in ("roof", "panel"):
        np.testing.assert_allclose(corners(out, part), turned(corners(room, part)), atol=1e-12)
        polygon = room.polygons(room.part_index(part))
        np.testing.assert_allclose(out.normal[polygon], room.normal[polygon] @ turn.T, atol=1e-12)
    np.testing.assert_allclose(control(out, "near"), turned(control(room, "near")), atol=1e-12)
    np.testing.assert_array_equal(corners(out, "pan"), corners(room, "pan"))
    # every polygon still lies in its plane
    for part in ("roof", "panel"):
        polygon = room.polygons(room.part_index(part))
        np.testing.assert_allclose(
            np.einsum("fi,fi->f", out.normal[polygon], out.circle_centre[polygon]),
            out.offset[polygon],
            atol=1e-12,
        )
    # what slides on it goes along the turned axis, whichever is set first
    both = adjusted(out, {"reach": 0.05})
    way = turn @ np.array([-0.05, 0.0, 0.0])
    moved = corners(both, "panel") - corners(out, "panel")
    np.testing.assert_allclose(moved, np.broadcast_to(way, moved.shape), atol=1e-12)
    other = adjusted(adjusted(room, {"reach": 0.05}), {"column_tilt": np.radians(20)})
    np.testing.assert_allclose(corners(other, "panel"), corners(both, "panel"), atol=1e-12)
    np.testing.assert_allclose(other.points["mark"], both.points["mark"], atol=1e-12)
    np.testing.assert_array_equal(corners(both, "roof"), corners(out, "roof"))


def test_the_wheel_of_the_compact_car_rises_and_comes_nearer():
    room = load_environment("compact_car")
    before = np.array(room.points["wheel_centre"])
    up = adjusted(room, {"wheel_tilt": np.radians(4)})
    assert 1000 * (up.points["wheel_centre"][2] - before[2]) == pytest.approx(23.8, abs=0.2)
    near = adjusted(room, {"wheel_telescope": 0.025})
    way = np.array(near.points["wheel_centre"]) - before
    assert 1000 * np.linalg.norm(way) == pytest.approx(25) and way[0] < 0 < way[2]
    for name in ("wheel_ten", "horn", "turn_signal"):
        np.testing.assert_allclose(control(near, name) - control(room, name), way, atol=1e-12)
    np.testing.assert_array_equal(control(near, "light_switch"), control(room, "light_switch"))


TILT = "travel: {forward: [0, 0], up: [0, 0], tilt: [-3, 6]}"
ALONE = {"population: {people: 8, seed: 3}": "size: {sex: male, measures: {stature: 1750}}"}
TILTED = {**ALONE, "seat: pilot,": "seat: pilot, position: {tilt: 6},"}


def test_a_tilted_seat_turns_cushion_back_and_sitter_about_its_reference_point(tmp_path):
    level = load_study(toy(tmp_path / "level", travel=TILT, swap=ALONE))
    leaning = load_study(toy(tmp_path / "leaning", travel=TILT, swap=TILTED))
    (before,), (after,) = (wb.run(study).postures for study in (level, leaning))
    srp = np.array([0.0, 0.0, 0.3])
    turn = about_y(-6)  # the front edge goes up
    for part in ("pan", "back"):
        where = (corners(level.environment, part) - srp) @ turn.T + srp
        np.testing.assert_allclose(corners(leaning.environment, part), where, atol=1e-12)
    seat = leaning.environment.seat("pilot")
    assert np.degrees([seat.back_angle, seat.cushion_angle]) == pytest.approx([6, 6])
    for segment in ("LT", "CT", "UT", "H"):
        one, other = (
            found.people[0].placed.world_from_segment[
                0, found.people[0].body.segments.index(segment)
            ]
            for found in (before, after)
        )
        np.testing.assert_allclose(other[:, :3], turn @ one[:, :3], atol=1e-9)
        np.testing.assert_allclose(other[:, 3] - srp, turn @ (one[:, 3] - srp), atol=1e-9)


def by_hand(folder, tilt=6.0, reach=0.03):
    """The toy cockpit as if its panel and seat had been drawn where the adjustments put them."""
    path = toy(folder, swap={"seat: pilot,": "seat: pilot, position: reference,"})
    room = folder / "environments/toy/environment.yaml"
    mesh = room.with_name("toy.obj")
    lines = mesh.read_text().splitlines()
    part = ""
    srp = np.array([0.0, 0.0, 300.0])
    for number, line in enumerate(lines):
        kind, *words = line.split()
        if kind == "o":
            part = words[0]
        elif kind == "v":
            point = np.array([float(word) for word in words])
            if part == "panel":
                point = point - [1000 * reach, 0, 0]
            elif part in ("pan", "back"):
                point = about_y(-tilt) @ (point - srp) + srp
            lines[number] = "v " + " ".join(repr(float(value)) for value in point)
    mesh.write_text("\n".join(lines) + "\n")
    text = room.read_text()
    for old, new in (
        ("back_angle: 0", f"back_angle: {tilt}"),
        ("cushion_angle: 0", f"cushion_angle: {tilt}"),
        ("at: [900.0000, -180, 850]", f"at: [{900 - 1000 * reach}, -180, 850]"),
        ("at: [450, -200, 800]", f"at: [{450 - 1000 * reach}, -200, 800]"),
    ):
        assert old in text, old
        text = text.replace(old, new)
    room.write_text(text)
    return path


def test_a_setting_gives_what_an_environment_drawn_so_gives(tmp_path):
    assert set(BOXES) == {"pan", "back", "panel", "roof"}
    swap = {"seat: pilot,": "seat: pilot, position: {tilt: 6}, adjust: {panel_reach: 30 mm},"}
    study = load_study(toy(tmp_path / "set", ADJUSTMENTS, travel=TILT, swap=swap))
    assert study.roles[0].adjusts == ()
    found = wb.run(study).population
    drawn = wb.run(load_study(by_hand(tmp_path / "drawn"))).population
    assert found.setting.shape == (8, 0)
    np.testing.assert_allclose(found.margin, drawn.margin, atol=1e-9)
    np.testing.assert_array_equal(found.served, drawn.served)


FREE = "travel: {forward: [-30, 20], up: [-30, 30], tilt: [-3, 6]}"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What is found of the people of the toy cockpit without adjustments, and with them; and where
    the study with them is."""
    folder = tmp_path_factory.mktemp("toys")
    plain = toy(folder / "plain", travel=FREE.replace(", tilt: [-3, 6]", ""), people=16)
    path = toy(folder / "free", ADJUSTMENTS, travel=FREE, people=16)
    return wb.run(load_study(plain)).population, wb.run(load_study(path)).population, path


def test_adjustments_leave_nobody_out_and_those_who_fit_where_they_were(found):
    without, free, _ = found
    assert not (without.served & ~free.served).any()
    assert free.adjusted.any() and not without.served.all()
    same = without.served
    np.testing.assert_array_equal(free.margin[same], without.margin[same])
    np.testing.assert_array_equal(free.seat[same], without.seat[same])
    np.testing.assert_array_equal(free.window[same], without.window[same])
    assert not free.setting[same].any() and not (free.adjusted & same).any()
    assert (free.sets | ~without.sets).all()
    least, before = (np.nanmin(one.margin, axis=1) for one in (free, without))
    assert (least[~free.served] >= before[~free.served]).all()


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_is_asked_at_the_settings_where_it_may_let_somebody_fit(tmp_path, name):
    study = load_study(toy(tmp_path, ADJUSTMENTS, travel=FREE, people=16, knob=980))
    fits, before = fit_with_a_change(Crowd(study), CHANGES[name])
    assert (fits != before).any() and not fits.all()


def test_whoever_fits_by_a_setting_fits_in_an_environment_that_is_set_so(found):
    _, free, path = found
    row = int(np.flatnonzero(free.adjusted)[0])
    (role,) = load_study(path).roles
    assert role.adjusts == ("panel_reach", "pilot_tilt")
    place = workplace_of(load_study(path), 0, free.place.environment)
    settings = [tuple(setting) for setting in settings_of(place).tolist()]
    assert tuple(free.setting[row].tolist()) in settings
    # the nearest to the nominal one come first, and all ends are among them
    size = np.array([0.06, np.radians(9)])
    away = np.linalg.norm(np.array(settings) / size, axis=1)
    assert (np.diff(away) >= -1e-12).all() and away[0] > 0
    assert {setting[0] for setting in settings} == {-0.02, 0.0, 0.02, 0.04}
    reach, tilt = free.setting[row]
    forward, up = 1000 * free.seat[row]
    held = (
        f"seat: pilot, position: {{forward: {forward:.9f}, up: {up:.9f}, "
        f"tilt: {np.degrees(tilt):.9f}}}, adjust: {{panel_reach: {1000 * reach:.9f}}},"
    )
    text = path.read_text()
    assert "seat: pilot," in text
    there = path.with_name("held.yaml")
    there.write_text(text.replace("seat: pilot,", held))
    alone = wb.run(load_study(there)).population
    np.testing.assert_allclose(alone.margin[row], free.margin[row], atol=1e-9)
    assert alone.served[row]


def test_tables_and_page_say_who_needs_which_setting(found, tmp_path, capsys):
    _, free, path = found
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    capsys.readouterr()
    with (tmp_path / "out/people.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    reach = np.array([float(row["panel_reach_mm"]) for row in rows])
    tilt = np.array([float(row["pilot_tilt_deg"]) for row in rows])
    np.testing.assert_allclose(reach, 1000 * free.setting[:, 0], atol=1e-3)
    np.testing.assert_allclose(tilt, np.degrees(free.setting[:, 1]), atol=1e-3)
    people = json.loads((tmp_path / "out/result.json").read_text())["population"]["people"]
    assert people["settings"]["panel_reach_mm"] == reach.tolist()
    page = (tmp_path / "out/report.html").read_text()
    assert "only with panel reach or pilot tilt away from its nominal setting" in page
    outside = np.isfinite(free.window[:, 0]) & free.served
    assert int(free.moved.sum()) == int((outside & ~free.adjusted).sum())


def test_one_person_sets_what_fits_and_is_drawn_so(tmp_path, capsys):
    size = "size: {sex: male, measures: {stature: 1660}}"
    swap = {"population: {people: 8, seed: 3}": size}
    path = toy(tmp_path, ADJUSTMENTS, travel=TRAVEL, swap=swap)
    result = wb.run(load_study(path))
    (there,) = result.postures
    at = there.environment.adjustment("panel_reach").at
    assert at > 0 and result.passed
    assert any("panel reach at +" in line and "is met" in line for line in result.warnings)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    capsys.readouterr()
    kept = json.loads((tmp_path / "out/result.json").read_text())["postures"][0]
    assert kept["settings"] == {"panel_reach_mm": pytest.approx(1000 * at)}
    assert "set: panel reach at +" in (tmp_path / "out/report.html").read_text()
    drawn = build_source(str(tmp_path / "out")).scene.environment
    np.testing.assert_allclose(corners(drawn, "panel"), corners(there.environment, "panel"))
    # in a position that is stated nothing is set by itself
    fixed = path.with_name("fixed.yaml")
    fixed.write_text(path.read_text().replace("seat: pilot,", "seat: pilot, position: reference,"))
    (stays,) = wb.run(load_study(fixed)).postures
    assert stays.environment.adjustment("panel_reach").at == 0.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("parts: [panel]", "parts: [pannel]", "parts[0]: no part 'pannel'; did you mean 'panel'?"),
        ("points: [mark]", "points: [marc]", "points[0]: no point 'marc'; did you mean 'mark'?"),
        ("travel: [-20,", "travel: [5,", "the mesh shows the nominal setting"),
        ('[-20, "4 cm"]', "[0, 0]", "this one stays where it is"),
        ('[-20, "4 cm"]', '[-20, "4 rad"]', "units: mm, cm, m, in, ft"),
        ("along: [-3, 0, 0]", "along: [0, 0, 0]", "a direction needs a length"),
        ("along: [-3, 0, 0], ", "", "an adjustment slides or turns"),
        ("parts: [panel], points: [mark]", "parts: []", "it moves nothing"),
        ("parts: [panel]", "parts: [panel, pan]", "part 'pan' is moved by seat 'pilot' already"),
        (
            "parts: [panel]",
            "parts: [panel], seat: pillot",
            "no seat 'pillot'; did you mean 'pilot'",
        ),
        ("parts: [panel]", "parts: [panel], mounted_on: lid", "no adjustment 'lid'"),
        (
            "parts: [panel]",
            "parts: [panel], mounted_on: panel_reach",
            "it is mounted on itself",
        ),
        ("panel_reach:", "pilot_tilt:", "the tilt of seat 'pilot' has this name"),
        (
            "along: [-3, 0, 0]",
            "about: {point: [0, 0, 0], axis: [0, 0, 0]}",
            "a direction needs a length",
        ),
        (
            '  panel_reach: {along: [-3, 0, 0], travel: [-20, "4 cm"]',
            "  panel_reach: {about: {point: [0, 0, 0], axis: [0, 1, 0]}, travel: [-20, 60]",
            "-45 to 45 degrees are possible",
        ),
        (
            "  panel_reach:",
            "  other: {along: [0, 0, 1], travel: [0, 5], parts: [roof, panel]}\n  panel_reach:",
            "part 'panel' is moved by adjustment 'other' already",
        ),
        (
            "  panel_reach:",
            "".join(
                f"  a{k}: {{along: [0, 0, 1], travel: [0, 5], points: [p{k}]}}\n" for k in range(4)
            )
            + "  panel_reach:",
            "the occupant of seat 'pilot' has 6 adjustments",
        ),
    ],
)
def test_a_wrong_adjustment_is_named_with_its_place(tmp_path, old, new, words):
    assert old in ADJUSTMENTS
    path = toy(tmp_path, ADJUSTMENTS.replace(old, new), travel=TILT)
    room = path.parents[1] / "environments/toy/environment.yaml"
    points = "".join(f"  p{k}: [0, 0, 0]\n" for k in range(4))
    room.write_text(room.read_text().replace("  mark:", points + "  mark:"))
    with pytest.raises(InputError) as caught:
        load_environment(room)
    (problem,) = caught.value.problems
    assert words in problem and "environment.yaml:" in problem, problem


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("adjust: {panel_rich: 5}", "has no adjustment 'panel_rich'; did you mean 'panel_reach'?"),
        ("adjust: {panel_reach: 50}", "beyond the travel of panel_reach, -20 to 40 mm (got 50 mm)"),
        ("adjust: {pilot_tilt: 2 mm}", "'pilot_tilt' turns: a number of degrees is needed"),
        ("position: {tilt: 7}", "beyond the travel of pilot_tilt, -3 to 6 degrees (got 7 degrees)"),
        ("position: {tilt: 5}, adjust: {pilot_tilt: 5}", "sets 'pilot_tilt' already"),
        ("adjust: {panel_reach: [1]}", "a number or a length such as '450 mm' is needed"),
        ("adjust: {panel_reach: far}", "a length such as '450 mm' or '17.7 in' is needed"),
    ],
)
def test_a_wrong_setting_of_a_study_is_named_with_its_place(tmp_path, given, words):
    swap = {"seat: pilot,": f"seat: pilot, {given},"}
    path = toy(tmp_path, ADJUSTMENTS, travel=TILT, swap=swap)
    with pytest.raises(InputError) as caught:
        load_study(path)
    (problem,) = caught.value.problems
    assert words in problem, problem


def test_what_is_set_from_one_seat_is_not_set_from_another(tmp_path):
    text = (ROOT / "studies/car_driver.yaml").read_text()
    driver = "seat: driver, population: {source: ansur2, people: 200, seed: 1977}}"
    assert driver in text
    path = tmp_path / "studies" / "two.yaml"
    path.parent.mkdir()
    guest = (
        "  guest: {body: adult_male, seat: passenger, position: reference, adjust: {wheel_tilt: 2}}"
    )
    path.write_text(
        text.replace(driver, f"{driver}\n{guest}").replace(
            "      driver: {driver:", "      guest: {posture: hands_in_lap}\n      driver: {driver:"
        )
    )
    with pytest.raises(InputError, match="'wheel_tilt' is set from seat 'driver'"):
        load_study(path)
    path.write_text(path.read_text().replace(", adjust: {wheel_tilt: 2}", ""))
    guest, driver = sorted(load_study(path).roles, key=lambda role: role.name != "guest")
    assert guest.adjusts == () and driver.adjusts == ("wheel_tilt", "wheel_telescope")


def test_a_travel_in_the_wrong_unit_is_doubted(tmp_path):
    room = room_of(tmp_path, ADJUSTMENTS.replace('[-20, "4 cm"]', "[-0.02, 0.04]"))
    words = "adjustment 'panel_reach': its travel is 0.06 mm long: a wrong unit of length?"
    assert f"{words} [travel of adjustment panel_reach]" in room.warnings


PEDALS = """
adjustments:
  left_pedals:
    seat: left
    along: [-1, 0, 0]
    travel: [-50, 50]
    parts: [left_seat_left_pedal, left_seat_right_pedal, left_pedal_bar]
    points: [left_heel]
"""
FLYING = """study: flying
length: mm
environment: trainer
people:
  pilot: {body: adult_male, detail: coarse, seat: left, SET}
cases:
  - name: flying
    people:
      pilot: {predicted: {eyes: left_design_eye, heels: left_heel,
        feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}}}
criteria:
  - {name: pedals, check: pedals}
"""


def test_pedals_that_come_nearer_let_the_seat_go_back_as_far(tmp_path):
    home = tmp_path / "environments/trainer"
    home.mkdir(parents=True)
    (tmp_path / "studies").mkdir()
    for name in ("environment.yaml", "trainer.obj"):
        (home / name).write_bytes((ROOT / "environments/trainer" / name).read_bytes())
    with (home / "environment.yaml").open("a") as file:
        file.write(PEDALS)
    found = []
    for name, given in (("there", "clothes: []"), ("nearer", "adjust: {left_pedals: 30}")):
        path = tmp_path / "studies" / f"{name}.yaml"
        path.write_text(FLYING.replace("SET", given))
        result = wb.run(load_study(path))
        assert result.passed
        found.append(result.postures[0].people[0])
    there, nearer = found
    # the seat is tried in places 10 mm apart, so 30 mm are three of them
    assert 1000 * (nearer.forward - there.forward) == pytest.approx(-30, abs=1e-6)
    assert nearer.up == pytest.approx(there.up, abs=1e-9)
    way = nearer.placed.centres - there.placed.centres
    np.testing.assert_allclose(way, np.broadcast_to([-0.03, 0, 0], way.shape), atol=1e-6)
