"""A seat whose cushion and back are named has the figures that clicks on them give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT
from tests.made_seat import BOX, SRP, corners, obj_text, seat_parts
from workbench.cli import main
from workbench.errors import InputError
from workbench.files.environments import load_environment
from workbench.files.seat_doubts import rest_doubts
from workbench.files.seat_search import PartFaces, found_seat
from workbench.files.yaml_text import parse_yaml
from workbench.study.describe.named_seat import named_seat


def said(lines):
    """The one seat of the lines, as they stand."""
    (seat,) = parse_yaml(lines, "lines").value["seats"].values()
    return seat


def made(folder, text, cushion="pan", back="rest", **frame):
    path = folder / "cab.obj"
    path.write_text(text)
    return named_seat([path], cushion, back, **frame)


@settings(max_examples=8)
@given(
    cushion=st.floats(-5.0, 30.0),
    back=st.floats(-5.0, 50.0),
    yaw=st.floats(-180.0, 180.0),
    axes=st.sampled_from([("z", "x"), ("y", "-z"), ("-x", "y")]),
    unit=st.sampled_from(["m", "mm", "in"]),
)
def test_a_named_seat_has_the_figures_it_was_made_to(
    tmp_path_factory, cushion, back, yaw, axes, unit
):
    up, forward = axes
    text = obj_text(seat_parts(cushion, back, yaw), unit, up, forward)
    found = made(tmp_path_factory.mktemp("cab"), text, length=unit, up=up, forward=forward)
    seat = said(found.lines)
    assert seat["cushion_angle"] == pytest.approx(cushion, abs=0.06)
    assert seat["back_angle"] == pytest.approx(back, abs=0.06)
    turned = (seat["yaw"] - yaw + 180.0) % 360.0 - 180.0
    assert abs(turned) < 2.01  # what is turned less is taken as straight
    # the figures are those of the planes where the seat is straight: 2 degrees over 0.25 m
    assert np.allclose(seat["srp"], np.array(SRP) * 1e3, atol=9.0 if turned else 0.2)


@pytest.mark.parametrize(
    ("name", "seat", "parts"),
    [
        ("trainer", "right", ("right_seat_pan", "right_seat_back")),
        ("compact_car", "driver", ("driver_seat_pan", "driver_seat_back")),
    ],
)
def test_the_seats_of_the_catalogue_are_found_again_from_their_parts(name, seat, parts):
    made_to = load_environment(ROOT / "environments" / name).seat(seat)
    found = said(named_seat([name], *parts).lines)
    assert np.allclose(found["srp"], 1e3 * np.array(made_to.srp), atol=0.1)
    assert np.allclose(np.radians(found["back_angle"]), made_to.back_angle, atol=1e-3)
    assert np.allclose(np.radians(found["cushion_angle"]), made_to.cushion_angle, atol=1e-3)


def test_cushion_and_back_may_be_one_part_and_its_front_is_leaned_against(tmp_path):
    """The rest is 80 mm thick: its rear side would give a seat that looks the same way."""
    boxes = seat_parts()
    lines = ["o seat"]
    for k, name in enumerate(("pan", "rest")):
        lines += [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in boxes.pop(name)]
        lines += [f"f {a + 8 * k + 1} {b + 8 * k + 1} {c + 8 * k + 1}" for a, b, c in BOX]
    rest = obj_text(boxes).splitlines()
    moved = [
        " ".join(["f", *(str(int(n) + 16) for n in line.split()[1:])]) if line[0] == "f" else line
        for line in rest
    ]
    text = "\n".join([*lines, *moved]) + "\n"
    found = said(made(tmp_path, text, "seat", "seat", length="m", up="z", forward="x").lines)
    assert np.allclose(found["srp"], 1e3 * np.array(SRP), atol=0.2)
    assert (found["cushion_angle"], found["back_angle"]) == (10, 20)


def bucket(diagonals, bolster):
    """Faces of a seat in one part, level and upright, symmetric about y = 0: its cushion begins at
    (0, 0, 0), its back has a rear side 140 mm behind its front, and both are dished, with bolsters.
    diagonals: for each of the quads, which way it is cut."""
    y = np.array([-0.28, -0.22, -0.15, 0.0, 0.15, 0.22, 0.28])
    rise = np.array([bolster, 0.6 * bolster, 0.004, 0.0, 0.004, 0.6 * bolster, bolster])
    along = np.linspace(0.0, 0.5, 4)
    quads = []
    for row in range(3):
        for k in range(6):
            ends = [(row, k), (row + 1, k), (row + 1, k + 1), (row, k + 1)]
            dish = [1.0 + 2.0 * along[i] for i, _ in ends]
            quads.append(
                [(along[i], y[j], rise[j] * f) for (i, j), f in zip(ends, dish, strict=True)]
            )
            quads.append([(rise[j] * f, y[j], 1.4 * along[i] + 0.02) for (i, j), f in zip(ends, dish, strict=True)])  # fmt: skip
            quads.append([(-0.14, y[j], 1.4 * along[i] - 0.1) for i, j in ends])
    cuts = ([[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]])
    return np.concatenate(
        [np.array(q)[cuts[int(d)]] for q, d in zip(quads, diagonals, strict=True)]
    )


@settings(max_examples=8, phases=[Phase.explicit, Phase.generate])
@given(
    diagonals=st.lists(st.booleans(), min_size=54, max_size=54),
    bolster=st.sampled_from([0.0, 0.02, 0.035, 0.0625, 0.08, 0.1]),
    aside=st.floats(-1.0, 1.0),
)
def test_a_symmetric_seat_is_found_in_its_middle_however_it_is_cut_into_triangles(
    diagonals, bolster, aside
):
    faces = bucket(diagonals, bolster) + np.array([0.0, aside, 0.0])
    x, y, z = found_seat(*[PartFaces("seat", faces)] * 2).figures.srp
    assert y == pytest.approx(aside, abs=5e-3)  # quads of bolsters are warped
    assert abs(x) < 0.03 and abs(z) < 0.03  # before the back, and not behind its rear side
    mirrored = faces[:, ::-1] * np.array([1.0, -1.0, 1.0])
    other = found_seat(*[PartFaces("seat", mirrored)] * 2).figures.srp
    assert np.allclose(other, [x, -y, z], atol=8e-3)


@pytest.mark.parametrize("name", ["trainer", "compact_car"])
def test_check_sends_a_seat_that_is_moved_to_where_it_is_found_by_its_parts(name):
    environment = load_environment(ROOT / "environments" / name)
    for seat in environment.seats:
        faces = [environment.triangle_corners(environment.part_index(part)) for part in seat.parts]
        x, y, z = seat.srp
        (doubt, *_) = rest_doubts(replace(seat, srp=(x + 0.05, y, z + 0.12)), *faces)
        right = found_seat(*map(PartFaces, seat.parts, faces)).figures.srp
        at = ", ".join(str(round(1e3 * value)) for value in right)
        assert f"at ({at}) mm it would be where the planes of both meet" in doubt.words
        assert np.allclose(right, seat.srp, atol=1e-4)


def test_what_was_measured_is_said_and_the_lines_are_an_environment(tmp_path, capsys):
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts()))
    frame = ["--units", "m", "--up", "z", "--forward", "x"]
    source = str(tmp_path / "cab.obj")
    assert main(["inspect", source, *frame, "--seat", "pan", "rest"]) == 0
    out, err = capsys.readouterr()
    assert "the cushion is 500 mm wide, the back 440 mm, and 440 mm of it are behind" in err
    assert "cushion and back open by 100 degrees; 80 to 160 are plausible" in err
    assert "is 300 mm above 'floor', the floor before it" in err
    (tmp_path / "environment.yaml").write_text(out)
    assert np.allclose(load_environment(tmp_path).seat("seat").srp, SRP, atol=1e-4)


def test_parts_of_no_seat_are_refused_with_what_is_wrong(tmp_path):
    two = seat_parts(0.0, 0.0) | {
        "other": corners((0.02, -0.72, 0.35), (0.1, -0.28, 0.9)),
        "tray": corners((0.7, 0.0, 0.05), (1.1, 0.4, 0.1)),
    }
    frame = {"length": "m", "up": "z", "forward": "x"}
    for cushion, back, words in (
        ("pan", "other", "700 mm to the right of its middle"),
        ("pan", "tray", "'tray' does not rise above the cushion"),
        ("pam", "rest", "there is no part 'pam'.*pan"),
    ):
        with pytest.raises(InputError, match=words):
            made(tmp_path, obj_text(two), cushion, back, **frame)


def test_a_folder_that_lies_here_is_an_environment_by_its_name_alone(tmp_path, monkeypatch, capsys):
    (tmp_path / "cab").mkdir()
    text = obj_text(seat_parts())
    (tmp_path / "cab" / "cab.obj").write_text(text)
    mesh = "{file: cab.obj, length: m, up: z, forward: x}"
    (tmp_path / "cab" / "environment.yaml").write_text(
        f"environment: cab\nlength: mm\nmeshes: [{mesh}]\n"
    )
    monkeypatch.chdir(tmp_path)
    assert main(["inspect", "cab"]) == 0
    assert "rest" in capsys.readouterr().out
    assert main(["inspect", "cub"]) == 3
