"""Belts and airbags as parts of a crash study, the vehicle's pulse in its signals, forces by stated
laws, films."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import workbench as wb
from tests.crash_pit import SIMULATION, pit
from tests.test_crash import BODY, standing
from workbench import Poses, load_study, place
from workbench.cli import main
from workbench.files.motions.tables import angle_table_text
from workbench.report.motions.sentences import pulse_words
from workbench.study.crash.belts import with_belts
from workbench.study.crash.crash import motion_found
from workbench.study.motion_cases import motion_cases

STUDY = """study: fall
length: mm
environment: pit
people: {occupant: {body: bubbleman}}
cases:
  - name: the one
    people:
      occupant:
        motion:
          file: fall.csv
signals: {points: [{name: head, segment: H}]}
criteria:
  - {name: nothing is hit, check: contact, at_most: 10}
"""
BELTS = """belts:
  - name: strap
    route: [post, {segment: LT, at: [1, 0, 0]}, {segment: LT, at: [0, 1, 0]}, [-500, 0, 900]]
    stiffness: 50
    width: 50
    allow: 30
"""
FORCES = "contact_forces: [{parts: [floor], stiffness: 100, returned: 0.5}]\n"


def indented(text, by):
    """Lines moved to the right."""
    return "".join(f"{' ' * by}{line}\n" for line in text.splitlines())


@pytest.fixture
def fall(tmp_path):
    """Writes a study of a man who falls 100 mm at 2 m/s onto the floor, sinks 40 mm in, and comes
    out again."""
    pit(tmp_path)
    time = np.array([0, 0.05, 0.07, 0.09, 0.2])
    height = np.array([0.1, 0.0, -0.04, 0.0, 0.2])
    (tmp_path / "studies/fall.csv").write_text(
        "".join(angle_table_text(BODY, standing(height, time)))
    )

    def write(more="", *, restraints="", other=""):
        path = tmp_path / "studies/fall.yaml"
        text = STUDY
        if restraints:
            stated = indented(f"restraints:\n{indented(restraints, 2)}", 10)
            text = text.replace("signals:", f"{stated}signals:")
        if other:
            motion = f"{{motion: {{file: fall.csv, {other}}}}}"
            case = f"  - {{name: the other, people: {{occupant: {motion}}}}}\n"
            text = text.replace("signals:", f"{case}signals:")
            more += "compare: [the one, the other]\n"
        path.write_text(text + more)
        return path

    return write


def test_a_law_gives_the_force_of_the_depth_and_without_one_there_is_none(fall, tmp_path):
    bare = wb.run(wb.load_study(fall())).motions[0]
    assert bare.forces == () and all(m.force is None for m in bare.meetings)
    ruled = wb.run(wb.load_study(fall(FORCES))).motions[0]
    feet = [m for m in ruled.meetings if m.segment in ("LF", "RF")]
    assert feet and all(m.force == pytest.approx(1e5 * m.depth) for m in feet)
    curve = next(f for f in ruled.forces if f.segment == "LF")
    assert curve.force == pytest.approx([0, 0, 4000, 0, 0], abs=0.1)


def test_forces_come_into_words_tables_and_the_page(fall, tmp_path, capsys):
    assert main(["run", str(fall(FORCES)), "--out", str(tmp_path / "out")]) == 1
    rows = json.loads((tmp_path / "out/result.json").read_text())
    foot = next(c for c in rows["motions"][0]["contacts"] if c["segment"] == "LF")
    assert foot["force_n"] == pytest.approx(4000, abs=1)
    assert (
        "is 40.0 mm deep at 70.0 ms, pushed back with 4.0 kN; they part at 90.0 ms."
        in foot["sentence"]
    )
    table = list(csv.DictReader((tmp_path / "out/forces.csv").read_text().splitlines()))
    assert float(table[2]["LF floor [N]"]) == pytest.approx(4000, abs=1)
    page = (tmp_path / "out/report.html").read_text()
    assert (
        "Forces over time" in page
        and "Forces are those of the force laws and belts that the study states" in page
    )
    capsys.readouterr()


def test_the_vehicles_pulse_is_added_to_what_is_measured_in_it(tmp_path, fall):
    """Who stands still in the vehicle is decelerated as it is: 16 g, and 9 m/s in all."""
    time = np.arange(0, 0.2, 0.0005)
    still = standing(np.zeros(len(time)), time)
    world = np.array(still.world_from_reference)
    world[:, 2, 3] += 1.0
    still = Poses(still.rotations, 0, world, time)
    study = fall(restraints="pulse: {shape: half_sine, peak: 16, duration: 90, start: 20}\n")
    (tmp_path / "studies/fall.csv").write_text("".join(angle_table_text(BODY, still)))
    result = wb.run(wb.load_study(study)).motions[0]
    figures = result.signals[0].figures
    assert figures["peak"][0] == pytest.approx(16.0, rel=1e-3)
    assert figures["peak"][1] == pytest.approx(0.065, abs=1e-3)
    assert figures["delta-v"][0] == pytest.approx(2 * 16 * 9.80665 * 0.09 / np.pi, rel=1e-6)
    assert pulse_words(result.study.pulse) == (
        "half-sine of 16.0 g over 90 ms, which changes the vehicle's velocity by 9.0 m/s"
    )
    assert wb.run(wb.load_study(fall())).motions[0].signals[0].figures["peak"][0] < 1e-6


def test_a_belt_is_a_part_over_the_body_with_its_width_and_allowance(fall):
    study = motion_cases(load_study(fall(restraints=BELTS)))[0]
    assert study.environment.parts == ("floor", "wall", "strap") and study.cabin.parts == (
        "floor",
        "wall",
    )
    part = study.environment.part_index("strap")
    assert not study.environment.solid[part]
    assert [rule.depth for rule in study.environment.allowances if rule.part == part] == [
        pytest.approx(0.03)
    ]
    ends = study.environment.vertices[-2 * 7 :].reshape(2, 7, 3)
    assert np.linalg.norm(ends[0] - ends[1], axis=1) == pytest.approx(0.05)
    middle = ends.mean(axis=0)
    assert middle[0] == pytest.approx([-0.5, 0, 3.0]) and middle[-1] == pytest.approx(
        [-0.5, 0, 0.9]
    )
    placed = place(BODY, study.motion)
    some = BODY.spheres(BODY.segment("LT"))
    gap = (
        np.linalg.norm(placed.centres[0, some][None] - middle[1:-1, None], axis=-1)
        - BODY.radius[0, some]
    )
    assert gap.min(axis=1) == pytest.approx(0.004, abs=2e-3)  # it lies on the pelvis


def test_a_belt_goes_along_with_the_body(fall):
    study = motion_cases(load_study(fall(restraints=BELTS)))[0]
    placed = place(BODY, study.motion)
    ends = [
        with_belts(study.cabin, study.belts, placed, pose=k).vertices[-14:].reshape(2, 7, 3)
        for k in (0, 2)
    ]
    moved = (ends[1] - ends[0]).mean(axis=0)
    assert moved[1:-1] == pytest.approx(np.tile([0, 0, -0.14], (5, 1)), abs=1e-9)
    assert moved[[0, -1]] == pytest.approx(0, abs=1e-9)


def test_a_belts_tension_is_that_of_its_way_and_its_law(fall):
    result = wb.run(
        wb.load_study(fall("contact_forces: [{parts: ['*'], stiffness: 100}]\n", restraints=BELTS))
    ).motions[0]
    assert {f.part for f in result.forces} == {
        "strap",
        "floor",
    }  # no law makes a force of where a belt once was
    tension = next(f for f in result.forces if f.part == "strap")
    placed = place(BODY, result.study.motion).world_from_segment[:, BODY.segment("LT")]
    front, side = (
        placed[:, :, :3] @ np.array(p.at) + placed[:, :, 3]
        for p in result.study.belts[0].points[1:3]
    )
    way = np.linalg.norm(front - [-0.5, 0, 3.0], axis=1) + np.linalg.norm(
        side - [-0.5, 0, 0.9], axis=1
    )
    assert tension.segment == "" and tension.force == pytest.approx(
        50e3 * np.maximum(way - way[0], 0), abs=1e-6
    )


def test_an_airbag_is_a_part_that_may_be_entered_and_pushes_back_from_its_surface(fall):
    bag = "airbags: [{name: bag, centre: [0, 0, 0], half_axes: [400, 400, 20], allow: 30}]\n"
    law = "contact_forces: [{parts: [bag], stiffness: 10}]\n"
    study = motion_cases(load_study(fall(law, restraints=bag)))[0]
    result = motion_found(study)
    met = [m for m in result.meetings if m.other == "bag" and m.segment == "LF"]
    assert met and all(m.allowed == pytest.approx(0.03) for m in met)
    assert met[0].force == pytest.approx(1e4 * met[0].depth)


def test_both_motions_of_a_comparison_are_judged(fall, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("workbench.report.motions.pictures._SECONDS", 0.5)
    path = fall(other="move: [0, 0, 35]")
    result = wb.run(wb.load_study(path))
    assert [(v.motion, v.passed) for v in result.verdicts] == [
        ("the one", False),
        ("the other", True),
    ]
    assert [[v.passed for v in motion.verdicts] for motion in result.motions] == [[False], [True]]
    assert result.motions[1].verdicts[0].worst.value == pytest.approx(-0.005, abs=5e-5)
    main(["run", str(path), "--out", str(tmp_path / "out"), "--film"])
    rows = json.loads((tmp_path / "out/result.json").read_text())
    assert [(v["motion"], v["passed"]) for v in rows["verdicts"]] == [
        ("the one", False),
        ("the other", True),
    ]
    page = (tmp_path / "out/report.html").read_text()
    for name in ("the one", "the other"):
        assert f"What happens: {name}" in page
    assert page.count("Seen from the ") == 2
    film = next(p.name for p in (tmp_path / "out").glob("motion.*"))
    assert f'src="{film}"' in page and (tmp_path / "out" / film).stat().st_size > 10_000
    capsys.readouterr()


def simulated(fall):
    """The study with the restraints of the simulation in the pit."""
    path = fall()
    text = path.read_text()
    path.write_text(text.replace("fall.csv\n", "fall.csv\n          restraints: pit_crash\n"))
    return path


def test_a_motion_brings_the_belts_and_the_pulse_of_its_simulation(fall, tmp_path):
    belted = (
        SIMULATION + BELTS + "airbags: [{name: bag, centre: [0, 0, 5000], half_axes: [9, 9, 9]}]\n"
    )
    (tmp_path / "studies/simulations/pit_crash.yaml").write_text(belted)
    asked = load_study(simulated(fall))
    study = motion_cases(asked)[0]
    assert study.environment.parts == ("floor", "wall", "bag", "strap")
    assert study.pulse.peak == pytest.approx(20 * 9.80665)
    assert {"simulation: pit_crash"} <= asked.inputs.keys()


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (
            {"more": "contact_forces: [{parts: [flor], stiffness: 1}]"},
            "nothing is called 'flor'; did you mean 'floor'",
        ),
        (
            {"more": "contact_forces: [{parts: [floor], stiffness: -1}]"},
            "contact_forces[0].stiffness",
        ),
        ({"restraints": "pulse: {shape: table, file: p.csv}"}, "p.csv: no such file"),
        (
            {"restraints": "belts: [{name: strap, route: [pole, post], stiffness: 1}]"},
            "no anchor 'pole'",
        ),
        (
            {"restraints": "belts: [{name: floor, route: [post, post], stiffness: 1}]"},
            "something is named 'floor' already",
        ),
        (
            {"restraints": "airbags: [{name: wall, centre: [0, 0, 0], half_axes: [1, 1, 1]}]"},
            "a part is named 'wall' already",
        ),
        (
            {"restraints": "airbags: [{name: bag, centre: [0, 0, 0], half_axes: [1, 0, 1]}]"},
            "restraints.airbags[0].half_axes[1]",
        ),
        ({"other": "restraints: none"}, "no studies/simulations entry named 'none'"),
        (
            {"other": "restraints: trainer_lap"},
            "it is in environment 'trainer', this study in 'pit'",
        ),
        ({"restraints": "belt: []"}, "unknown key 'belt'; did you mean 'belts'?"),
    ],
)
def test_what_is_wrong_with_restraints_is_told(fall, more, told, capsys, tmp_path):
    assert main(["run", str(fall(**more)), "--out", str(tmp_path / "out")]) == 3
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_film_is_for_motions(capsys):
    assert main(["run", "trainer_clearance", "--film"]) == 2
    assert "--film is for studies of a motion" in capsys.readouterr().err


def test_a_motion_is_simulated_when_the_study_runs(fall, tmp_path):
    """Without weight or belts the man stays where he is while the vehicle is stopped: he goes on at
    the speed that the pulse takes from it."""
    pytest.importorskip("mujoco")
    path = fall()
    text = path.read_text()
    start = text.index("        motion:")
    end = text.index("signals:")
    action = "        simulated: {start: standing, simulation: pit_crash}\n"
    path.write_text(text[:start] + action + text[end:])
    study = motion_cases(load_study(path))[0]
    placed = place(BODY, study.motion).world_from_segment[:, BODY.segment("LT"), :, 3]
    assert placed[0] == pytest.approx([0, 0, 3.0], abs=1e-3)
    assert study.pulse.peak == pytest.approx(20 * 9.80665)
    assert placed[-1, 0] > 0.3 and study.name == "the one"


@pytest.mark.parametrize(
    ("action", "told"),
    [
        ("{start: stand, simulation: pit_crash}", "no posture 'stand'; did you mean 'standing'?"),
        ("{start: standing, simulation: pit}", "no studies/simulations entry named 'pit'"),
        ("{start: standing, simulation: trainer_lap}", "it is in environment 'trainer', this"),
        ("{simulation: pit_crash}", "simulated: key 'start' is missing"),
    ],
)
def test_what_is_wrong_with_a_simulated_motion_is_told(fall, action, told):
    path = fall()
    text = path.read_text()
    path.write_text(
        text[: text.index("        motion:")]
        + f"        simulated: {action}\n"
        + text[text.index("signals:") :]
    )
    with pytest.raises(wb.InputError) as caught:
        load_study(path)
    assert told in str(caught.value)
