"""A control that nobody reaches because of one part is told first, before the share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import BOX, BOX_FACES, box_part, environment_of
from tests.toy_cockpit import write_toy
from workbench.cli import main
from workbench.model.accommodation import Requirement
from workbench.model.criterion import TOO_SHORT, Criterion, Reason
from workbench.model.environment import Control, OwnPiece
from workbench.model.result import ControlReach
from workbench.model.units import UNITS
from workbench.report.population.sentences import spare_words
from workbench.study.kept_reaches import kept_by_parts, kept_of_people, kept_words

REASONS = (Reason("part", "stalk"), Reason("part", "wall"), TOO_SHORT)
STALK, WALL, SHORT, NOTHING = 0, 1, 2, -1


def room():
    """A knob on a stalk, with a wall behind them."""
    made = environment_of(
        box_part("knob", (0.5, 0.0, 0.8), (0.52, 0.02, 0.82)),
        box_part("stalk", (0.505, 0.005, 0.7), (0.515, 0.015, 0.799)),
        box_part("wall", (0.53, -1.0, 0.0), (0.6, 1.0, 2.0)),
    )
    return replace(made, controls=(Control("lever", (0.51, 0.01, 0.81), "grasp", 1, "knob"),))


def told(margins, reasons):
    """What is said of people with such margins [mm] at the lever, each for a reason."""
    kept = kept_by_parts(
        room(),
        [Requirement("reach lever", "levers", "reach", "lever", 1)],
        margin=np.array(margins, dtype=float)[:, None] / 1000,
        reason=np.array(reasons)[:, None],
        reasons=REASONS,
        weight=np.ones(len(margins)),
    )
    return list(kept_words(kept))


def test_a_part_that_touches_the_control_is_asked_about():
    assert told([-7.6, -7.6], [STALK, STALK]) == [
        "nobody reaches lever: stalk is in the way, hands stay 7.6 mm short; it touches knob: is it the control's "
        "own stalk, base or screw? If it is, 'part: [knob, stalk]' of lever says so"
    ]


def test_a_part_that_touches_nothing_of_it_is_in_the_way_and_no_more():
    assert told([-5.0, -9.0], [WALL, WALL]) == [
        "nobody reaches lever: wall is in the way, hands stay 5.0 to 9.0 mm short"
    ]


def test_a_person_who_is_asked_in_several_cases_is_told_the_best_and_the_worst():
    asked = Criterion("levers", "reach", ("driver",), (), (), 0.0, controls=("lever",))
    rows = [
        ControlReach(
            *(
                "driver",
                "lever",
                1,
                1,
                "right hand",
                False,
                miss,
                0.02,
                Reason("part", "stalk"),
                None,
                0.0,
                "",
                case,
            )
        )
        for case, miss in (("driving", 0.289), ("parking", 0.502), ("waiting", 0.401))
    ]
    (words,) = kept_words(kept_of_people(room(), [asked], rows))
    assert words.startswith(
        "driver does not reach lever: stalk is in the way, hands stay 309.0 to 522.0 mm short;"
    )


def test_people_whose_arm_is_too_short_are_not_counted():
    words = told([-7.6, -7.6, -80, -90], [STALK, STALK, SHORT, SHORT])
    assert words[0].startswith("nobody whose arm is long enough reaches lever: stalk")


@pytest.mark.parametrize("reached, said", [(1, True), (2, False)])
def test_one_in_twenty_is_almost_nobody(reached, said):
    words = told([20.0] * reached + [-7.6] * 19, [NOTHING] * reached + [STALK] * 19)
    assert [one[:28] for one in words] == (["almost nobody reaches lever:"] if said else [])


def test_what_keeps_less_than_half_or_a_tenth_is_not_the_reason():
    assert told([-5, -5, -5, -5], [STALK, WALL, STALK, WALL])  # half of them
    assert not told([-5] + [-80] * 10, [STALK] + [SHORT] * 10)  # one in eleven


def toy(folder, people, criteria):
    """A toy cockpit in which a knob in a block is asked for: nobody may be in the
    block."""
    path = write_toy(folder, people=people)
    place = folder / "environments" / "toy"
    block = np.array((420, -220, 780)) + BOX * (40, 40, 40)
    knob = np.array((438, -202, 798)) + BOX * (4, 4, 4)
    text = (place / "toy.obj").read_text()
    for k, (name, corners) in enumerate((("Cube_1", knob), ("Cube_2", block))):
        text += f"o {name}\n" + "".join("v {:g} {:g} {:g}\n".format(*one) for one in corners)
        text += "".join("f {} {} {}\n".format(*(face + 33 + 8 * k)) for face in BOX_FACES)
    (place / "toy.obj").write_text(text)
    yaml = (place / "environment.yaml").read_text()
    old = "near: {at: [450, -200, 800], grip: push, zone: 1, part: panel}"
    assert old in yaml
    new = "near: {at: [440, -200, 800], grip: grasp, zone: 1, part: [Cube_1]}"
    (place / "environment.yaml").write_text(yaml.replace(old, new))
    head = path.read_text().split("criteria:")[0]
    path.write_text(f"{head}criteria:\n  - {criteria}\n")
    return path


def test_a_share_of_nobody_for_a_part_in_the_way_does_not_open_the_page(tmp_path, capsys):
    study = toy(tmp_path, 4, "{name: knobs, check: reach, controls: [near], hand: right}")
    main(["run", str(study), "--out", str(tmp_path / "out")])
    told = capsys.readouterr()
    first = "nobody reaches near: Cube 2 is in the way, hands stay "
    warned = [line for line in told.err.splitlines() if line.startswith("warning: ")]
    assert warned[0].startswith(f"warning: {first}")
    assert "nobody meets" not in told.err
    page = (tmp_path / "out" / "report.html").read_text()
    lead = page.split('<p class="lead">')[1]
    assert lead.startswith("N" + first[1:])
    assert "With the environment as described, nobody fits" in lead
    assert "people fit</span>" not in page.split("</h1>")[0]


def test_a_page_on_which_everybody_fits_shows_whoever_is_nearest_to_overlapping(tmp_path):
    study = toy(tmp_path, 4, "{name: oneself, check: self_contact, segments: [RHN]}")
    assert main(["run", str(study), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    result = wb.run(wb.load_study(study)).population
    (tight,) = result.shown
    assert result.served.all()
    assert result.margin[tight.row, 0] == result.margin.min()
    body, placed = tight.placed.body, tight.placed
    away = np.linalg.norm(placed.centres[0] - tight.target, axis=1)
    assert np.abs(away - body.radius[placed.person[0]]).min() < 1e-6  # on somebody's surface
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<h2>The tightest case</h2>" in page
    left = spare_words(float(result.margin.min()), UNITS["m"])
    assert f"“oneself” is met with {left}" in page


def test_a_list_of_parts_answers_the_question(tmp_path):
    study = toy(tmp_path, 4, "{name: knobs, check: reach, controls: [near], hand: right}")
    place = tmp_path / "environments" / "toy" / "environment.yaml"
    place.write_text(place.read_text().replace("[Cube_1]", '["Cube_*"]'))
    found = wb.run(wb.load_study(study))
    assert found.population.single[0] == 1.0
    assert not [words for words in found.warnings if "in the way" in words]


def test_a_piece_that_is_the_controls_already_is_not_asked_about_again():
    made = room()
    (lever,) = made.controls
    taken = replace(made, controls=(replace(lever, pieces=(OwnPiece("stalk", ""),)),))
    asked = Criterion("levers", "reach", ("driver",), (), (), 0.0, controls=("lever",))
    row = ControlReach(
        "driver", "lever", 1, 1, "right hand", False, 0.0, 0.02, REASONS[STALK], None, 0.0, "", "x"
    )
    assert len(list(kept_words(kept_of_people(made, [asked], [row])))) == 1
    assert not kept_of_people(taken, [asked], [row])


@pytest.mark.parametrize("hand, share", [("left", 0.0), ("right", 1.0)])
def test_people_are_asked_for_a_control_by_the_hand_that_the_case_puts_there(tmp_path, hand, share):
    held = {
        "eyes: eye}": f"eyes: eye, hands: {{{hand}: near}}}}",
        ", hand: right": "",
        "knob, ": "",
    }
    path = write_toy(tmp_path, people=3, swap=held)
    file = tmp_path / "environments" / "toy" / "environment.yaml"
    text = file.read_text().replace(
        "[450, -200, 800]", "[300, -550, 800]"
    )  # the right hand's alone
    file.write_text(text)
    found = wb.run(wb.load_study(path)).population
    column = [one.name for one in found.requirements].index("reach near")
    assert found.single[column] == share
    shown = [one.limb for one in found.shown if one.requirement == column]
    assert set(shown) <= {f"{hand} hand"}
