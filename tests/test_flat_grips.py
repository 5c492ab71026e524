"""A grip that cannot work is named: a hand does not close about what lies flat on something."""

from __future__ import annotations

from dataclasses import replace

import pytest

import workbench as wb
from tests.conftest import BOX, BOX_FACES, box_part, environment_of
from tests.toy_cockpit import write_toy
from workbench.cli import main
from workbench.model.environment import Control
from workbench.study.accommodation.grips import flat_thickness


def plate(thickness, *, width=0.06, behind=0.0):
    """A plate in front of a wall, and a control on its face."""
    made = environment_of(
        box_part("plate", (0.5 - thickness, 0.0, 0.8), (0.5, width, 0.86)),
        box_part("wall", (0.5 + behind, -1.0, 0.0), (0.6 + behind, 1.0, 2.0)),
    )
    control = Control("burner", (0.5 - thickness, width / 2, 0.83), "grasp", 1, "plate")
    return replace(made, controls=(control,)), control


@pytest.mark.parametrize(
    ("made", "thickness"),
    [
        (plate(0.0013), 0.0013),
        (plate(0.008), 0.008),
        (plate(0.03), None),  # a knob
        (plate(0.005, width=0.01), None),  # a toggle
        (plate(0.003, behind=0.05), None),  # a free sheet
    ],
)
def test_flat_is_what_is_thin_and_wide_and_lies_on_something(made, thickness):
    found = flat_thickness(*made)
    assert found == (None if thickness is None else pytest.approx(thickness, abs=1e-9))


@pytest.fixture(scope="module")
def stove(tmp_path_factory):
    """The toy cockpit with a plate of 1.3 mm on a block before the people, to be grasped."""
    folder = tmp_path_factory.mktemp("stove")
    path = write_toy(folder, people=4)
    place = folder / "environments" / "toy"
    text = place.joinpath("toy.obj").read_text()
    count = text.count("\nv ") + 1
    for name, low, size in (
        ("block", (420, -260, 600), (300, 160, 80)),
        ("burner", (430, -210, 680), (60, 60, 1.3)),
    ):
        corners = [[a + t * b for a, b, t in zip(low, size, row, strict=True)] for row in BOX]
        text += f"o {name}\n" + "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in corners)
        text += faces(count)
        count += 8
    place.joinpath("toy.obj").write_text(text)
    environment = place / "environment.yaml"
    row = "  burner: {at: [460, -180, 681.3], grip: grasp, zone: 1, part: burner}\n"
    environment.write_text(environment.read_text() + row)
    path.write_text(path.read_text().replace("[knob, near]", "[burner, near]"))
    return path


def faces(first):
    return "".join(f"f {a} {b} {c}\n" for a, b, c in (BOX_FACES + first).tolist())


def test_nobody_grasps_a_burner_and_everybody_pushes_it(stove, tmp_path, capsys):
    result = wb.run(wb.load_study(stove))
    (found,) = result.population.grips
    assert (found.control, found.grip, found.other, found.share) == ("burner", "grasp", "push", 1.0)
    said = "obody grasps burner: it is flat, 1.3 mm thick; 100 % push it: `grip: push`"
    assert result.population.warnings[0] == f"n{said}"
    assert "nobody meets 'reach burner" not in " ".join(result.warnings)
    assert main(["run", str(stove), "--out", str(tmp_path / "out")]) == 0
    assert f"N{said}. With the environment as described, nobody fits" in capsys.readouterr().out


def test_a_burner_that_is_pushed_is_not_named(stove):
    environment = stove.parents[1] / "environments" / "toy" / "environment.yaml"
    text = environment.read_text()
    environment.write_text(
        text.replace("grip: grasp, zone: 1, part: burner", "grip: push, zone: 1, part: burner")
    )
    result = wb.run(wb.load_study(stove))
    assert result.population.grips == ()
    environment.write_text(text)
