"""A wrong unit of length is told by what the parts are named after, by the seats, and by the size
of a body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT, SHARED, box_part, real_input
from tests.test_real_inputs import FILES
from workbench import environment_from_mesh, load_environment
from workbench.cli import main
from workbench.files.mesh_report import inspect_mesh
from workbench.files.meshes.reading import extent, implausible, read_mesh, to_world
from workbench.files.meshes.sizes import SIZE_RANGES, implausible_sizes, person_size
from workbench.files.meshes.taken_frame import taken_frame
from workbench.files.schema import metres_in
from workbench.study.describe.state import open_place
from workbench.study.fit_body import read_surface

ENVIRONMENTS = SHARED / "environments"
BODIES = SHARED / "bodies" / "makehuman_derived"
CAB = """environment: cab
length: mm
meshes: [{file: cab.obj, length: UNIT, up: z, forward: x}]
seats:
  left:
    srp: [200, 0, 450]
    back_angle: 10
    cushion_angle: 5
    cushion: {part: cushion, segments: [LT], depth: 20}
    back: {part: backrest, segments: [LT], depth: 15}
    travel: {forward: [0, 0], up: [0, 0]}
    moves: [cushion]
"""


def sized(name, size):
    return box_part(name, [0, 0, 0], size)


def written(folder, *parts):
    path = folder / "cab.obj"
    lines = []
    count = 1
    for part in parts:
        lines += [f"o {part.name}", *("v {:.9g} {:.9g} {:.9g}".format(*v) for v in part.vertices)]
        lines += ["f {} {} {}".format(*(face + count)) for face in part.faces]
        count += len(part.vertices)
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("name", "size", "metres", "words"),
    [
        (
            "Wheel_Left",
            (2.1, 0.6, 2.1),
            1.0,
            "'Wheel_Left' is 2.1 m large, and 0.1 to 1.7 m is plausible for 'wheel'",
        ),
        ("seat", (1.5, 0.5, 1.2), 0.0254, "seat would be 0.591 m in cm"),
        ("SteeringWheel", (0.9, 0.9, 0.1), 0.0254, "SteeringWheel would be 0.354 m in cm"),
        ("left_door_handle", (0.01, 0.002, 0.002), 0.001, "handle would be 0.1 m in cm"),
        ("mirror.001", (20, 5, 5), 1.0, "mirror.001 would be 0.2 m in cm"),
        ("pedal_gas", (3.3, 1, 1), 0.3048, "pedal_gas would be 0.108 m in cm, 0.275 m in in"),
        ("canopy", (0.04, 0.03, 0.02), 0.0254, "canopy would be 1.57 m in m"),
        ("seat_rails", (8, 1, 1), 0.01, "at most 1.45 m is plausible for 'piece of seat'"),
        ("HumanMale", (0.5, 0.3, 6.0), 1.0, "HumanMale would be 1.83 m in ft"),
    ],
)
def test_a_part_of_another_size_than_its_name_says_is_named_with_the_unit_that_fits(
    name, size, metres, words
):
    (said,) = implausible_sizes([sized(name, size)], metres)
    assert words in said


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("Front_Wheel_Left", (0.65, 0.28, 0.65)),
        ("Wheels", (0.85, 2.1, 0.85)),
        ("Wheel_Rear", (0.93, 2.3, 0.93)),
        ("trim_wheel", (0.13, 0.02, 0.13)),
        ("seat_bolt", (0.02, 0.01, 0.01)),
        ("wheel_nut", (0.02, 0.02, 0.02)),
        ("door_lock", (0.02, 0.02, 0.02)),
        ("window_switches", (0.06, 0.04, 0.01)),
        ("child_male", (0.5, 0.3, 0.9)),
        ("bench_seat", (0.6, 1.4, 0.9)),
        ("part_17", (900, 1, 1)),
        ("cartridge", (40, 1, 1)),
        ("", (5, 5, 5)),
    ],
)
def test_a_part_of_a_plausible_size_and_one_named_after_nothing_known_are_not_told(name, size):
    assert implausible_sizes([sized(name, size)], 1.0) == ()


def test_an_electrical_bus_on_a_panel_is_no_coach_and_a_bus_by_itself_is_one():
    panel = sized("Panel", (1.4, 0.1, 0.7))
    assert implausible_sizes([panel, sized("BMainBus", (0.01, 0.01, 0.003))], 1.0) == ()
    assert implausible_sizes([panel, sized("Bus", (0.01, 0.01, 0.003))], 1.0) == ()
    assert implausible_sizes([panel, sized("headset_pilot", (0.2, 0.1, 0.2))], 1.0) == ()
    (said,) = implausible_sizes([sized("Bus", (0.3, 0.07, 0.1))], 0.0254)
    assert "Bus would be 11.8 m in m" in said


def test_a_doubt_that_is_accepted_is_not_told_and_one_that_nobody_has_is(tmp_path):
    written(tmp_path, sized("body", (2.0, 1.0, 1.0)), sized("Wheel_FL", (2.0, 0.5, 2.0)))
    path = tmp_path / "environment.yaml"
    bare = CAB.split("seats:")[0].replace("UNIT", "m")
    path.write_text(bare)
    assert [line.rpartition(" [")[2] for line in load_environment(path).warnings] == [
        "sizes in cab.obj]"
    ]
    path.write_text(bare + 'accepted: ["sizes in *.obj"]\n')
    assert load_environment(path).warnings == ()
    path.write_text(bare + "accepted: [sizes in cab.obj, sizes in cap.obj]\n")
    (said,) = load_environment(path).warnings
    assert said.startswith("accepted: nothing is doubted about 'sizes in cap.obj'")


def test_the_unit_that_fits_all_parts_is_told_once_for_the_mesh():
    parts = [
        sized("wheel", (0.065, 0.02, 0.065)),
        sized("seat", (0.05, 0.05, 0.1)),
        sized("pedal", (0.01, 0.01, 0.02)),
    ]
    (said,) = implausible_sizes([*parts, sized("door", (0.12, 0.01, 0.1))], 0.001)
    assert said.endswith(
        "1 more named parts too: a wrong unit of length? wheel would be 0.65 m in cm, which fits all named parts"
    )


def test_a_file_named_after_a_car_is_as_large_as_one():
    parts = [sized("body", (21.0, 8.0, 6.0)), sized("glass", (6.0, 7.0, 2.0))]
    (said,) = implausible_sizes(parts, 1.0, file="my_car")
    assert "'my_car' is 21 m large, and 1.8 to 7 m is plausible for 'car'" in said
    assert implausible_sizes(parts, 1.0, file="hall") == ()


def test_every_thing_has_a_range():
    assert all(0 < thing.least < thing.greatest for thing in SIZE_RANGES.values())
    assert all(word == word.lower() for name in SIZE_RANGES for word in name)


@pytest.mark.parametrize("name", ["trainer", "compact_car"])
def test_the_shipped_environments_are_not_told_to_have_a_wrong_unit_and_are_in_feet(name):
    assert load_environment(name).warnings == ()
    path = ROOT / "environments" / name / f"{name}.obj"
    parts = read_mesh(path).parts
    assert implausible_sizes(to_world(read_mesh(path), np.eye(3), metres=1.0), 1.0, file=name) == ()
    feet = to_world(read_mesh(path), np.eye(3), metres=0.3048)
    assert implausible(float(extent(parts).max()), 0.3048) is None
    assert implausible_sizes(feet, 0.3048, file=name)


REAL = {name: (ENVIRONMENTS / file.path, file.metres) for name, file in FILES.items()}
REAL |= {
    name: (BODIES / f"{name}.obj", 1.0) for name in ("adult_male", "adult_female", "child_male")
}


@pytest.mark.parametrize("name", REAL)
def test_a_real_mesh_in_its_right_unit_is_not_told_to_have_another(name):
    path, metres = REAL[name]
    real_input(path)
    assert (
        implausible_sizes(
            to_world(read_mesh(path), np.eye(3), metres=metres), metres, file=path.stem
        )
        == ()
    )


def test_most_real_meshes_in_a_wrong_unit_are_refused_or_told():
    """Of 59 pairs of a file and a wrong unit; what is left has no part named after anything
    known."""
    real_input(ENVIRONMENTS)
    caught = 0
    missed = []
    for name, (path, right) in REAL.items():
        raw = read_mesh(path)
        for unit, metres in metres_in.items():
            if abs(metres / right - 1) < 1e-9:
                continue
            refused = implausible(float(extent(raw.parts).max()), metres)
            told = implausible_sizes(
                to_world(raw, np.eye(3), metres=metres), metres, file=path.stem
            )
            if refused or told:
                caught += 1
            else:
                missed.append((name, unit))
    assert sorted(missed) == [("bench", "ft"), ("child_male", "ft"), ("space_module", "ft")]
    assert caught == 56


def test_a_mesh_of_the_wrong_unit_is_told_by_inspect_check_and_the_environment(tmp_path, capsys):
    path = written(tmp_path, sized("body", (2.0, 1.0, 1.0)), sized("Wheel_FL", (2.0, 0.5, 2.0)))
    assert any(
        "'Wheel_FL' is 2 m large" in line for line in inspect_mesh(path, length="m").warnings
    )
    assert any(
        "'Wheel_FL' is 2 m large" in line
        for line in environment_from_mesh(path, up="z", forward="x", length="m").warnings
    )
    (tmp_path / "environment.yaml").write_text(CAB.split("seats:")[0].replace("UNIT", "m"))
    assert main(["check", str(tmp_path / "environment.yaml")]) == 0
    assert "warning: cab.obj: 'Wheel_FL' is 2 m large" in capsys.readouterr().err
    guessed = inspect_mesh(path)
    assert (
        guessed.assumed[0] == "unit m (not sure): by its size, 2 m long; it would be 0.61 m in ft"
    )
    assert guessed.problem.startswith("the file does not say its unit of length")


THINGS = {
    "left_seat": (0.5, 0.5, 1.0),
    "steering_wheel": (0.05, 0.38, 0.38),
    "front_door": (1.0, 0.05, 1.1),
    "gear_lever": (0.05, 0.05, 0.4),
    "dashboard": (0.3, 1.4, 0.4),
}
"""Parts that are as large as their names say [m]."""


@given(
    long=st.floats(1.0, 15.0),
    unit=st.sampled_from(sorted(metres_in)),
    names=st.sets(st.sampled_from(sorted(THINGS))),
    odd=st.booleans(),
)
def test_no_unit_of_a_place_for_people_is_guessed_as_sure_and_is_another(
    tmp_path, long, unit, names, odd
):
    parts = {"shell": (long, min(long, 1.6), min(long, 1.2))}
    parts |= {name: THINGS[name] for name in names}
    parts |= {"Bus": (0.01, 0.005, 0.001)} if odd else {}  # an electrical one
    per_metre = 1.0 / metres_in[unit]
    path = written(
        tmp_path, *(sized(name, np.array(size) * per_metre) for name, size in parts.items())
    )
    (said,) = [words for words in inspect_mesh(path).assumed if words.startswith("unit ")]
    assert "(not sure)" in said or said.startswith(f"unit {unit}: ")


@settings(max_examples=20)
@given(
    name=st.sampled_from(sorted(THINGS)),
    scale=st.floats(0.8, 1.2),
    unit=st.sampled_from(sorted(metres_in)),
    knob=st.booleans(),
)
def test_a_thing_alone_is_taken_in_a_unit_in_which_it_is_one_by_inspect_and_live(
    tmp_path, name, scale, unit, knob
):
    """No warning says that it would be one in another unit than the one that is guessed."""
    size = np.array(THINGS[name]) * scale / metres_in[unit]
    parts = [sized(name, size)] + ([sized("knob", 0.05 * size)] if knob else [])
    path = written(tmp_path, *parts)
    found = inspect_mesh(path)
    assert not [line for line in found.warnings if "wrong unit" in line and name in line]
    opened = open_place(path)
    assert metres_in[opened.start.says["meshes"][0]["length"]] == found.metres


def test_a_unit_that_one_name_speaks_against_is_not_sure(tmp_path):
    wheels = [sized(f"wheel_{k}", (0.3, 10.0, 10.0)) for k in range(4)]  # 0.6 m in units of 60 mm
    path = written(tmp_path, *wheels, sized("body", (83.0, 30.0, 20.0)))
    suv = path.rename(tmp_path / "suv.obj")
    said = inspect_mesh(suv).assumed[0]
    assert said.startswith("unit in (not sure): by its size, 2.11 m long")


@pytest.mark.nightly
@pytest.mark.parametrize("name", FILES)
def test_a_real_mesh_without_its_unit_is_not_taken_for_another_one_as_sure(name):
    file = FILES[name]
    raw = replace(read_mesh(real_input(ENVIRONMENTS / file.path)), metres=None)
    unit = taken_frame(raw).length
    assert not unit.sure or metres_in[unit.value] == pytest.approx(file.metres)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ((), "unit cm (not sure): by its size, 4 m long; it would be 10.2 m in in"),
        (tuple(THINGS), "unit cm: by its size, 4 m long"),
    ],
)
def test_names_of_many_parts_settle_what_the_size_of_the_whole_leaves_open(tmp_path, names, said):
    parts = {"shell": (4.0, 1.6, 1.2), **{name: THINGS[name] for name in names}}
    path = written(tmp_path, *(sized(name, 100.0 * np.array(size)) for name, size in parts.items()))
    assert inspect_mesh(path).assumed[0] == said


@pytest.mark.parametrize(
    ("unit", "words"),
    [
        ("m", None),
        ("ft", "if its unit were m where ft is taken"),
    ],
)
def test_a_seat_whose_reference_point_is_away_from_its_cushion_is_told_with_the_unit(
    tmp_path, unit, words
):
    parts = [
        box_part("floor", [-1, -1, -0.1], [3, 1, 0]),
        box_part("cushion", [0.2, -0.25, 0.3], [0.7, 0.25, 0.45]),
        box_part("backrest", [0.05, -0.25, 0.45], [0.2, 0.25, 1.1]),
    ]
    written(tmp_path, *parts)
    (tmp_path / "environment.yaml").write_text(CAB.replace("UNIT", unit))
    said = [
        line
        for line in load_environment(tmp_path / "environment.yaml").warnings
        if line.startswith("seat")
    ]
    assert (said == []) is (words is None)
    assert words is None or (words in said[0] and "is 0.3" in said[0])


def test_a_human_of_six_metres_is_told_by_body_fit(tmp_path):
    man = trimesh.creation.capsule(height=5.4, radius=0.3, count=[8, 8])
    path = tmp_path / "figure.obj"
    man.export(path)
    (said,) = read_surface(path, length="m").notes
    assert said.startswith(
        "is 6 m large, and a person is up to 2.5 m: a wrong unit of length? it would be"
    )
    assert "1.83 m in ft" in said
    man.export(tmp_path / "human.obj")
    (said,) = read_surface(tmp_path / "human.obj", length="m").notes
    assert "'human' is 6 m large" in said and "1.83 m in ft" in said
    assert read_surface(tmp_path / "human.obj", length="ft").notes == ()


def test_a_person_is_not_told_to_be_one_of_another_size():
    assert person_size(1.9, 1.0) == ()
    assert "no unit makes it one" in person_size(9.9, 1.0)[0]
