"""The parts of a control beside the one that it stands on: stated in the file, or taken along
because they touch it and belong to the same small thing."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from tests.conftest import BOX, BOX_FACES, SHARED, real_input
from workbench import InputError, load_environment
from workbench.geometry.surfaces import come_near

# name, least and greatest corner [mm]: two levers of knob and stalk in a base on a console
LEVERS = {
    "console": ((0, -500, 0), (1000, 500, 90)),
    "GateBase": ((400, -60, 90), (500, 60, 100)),
    "PropCap": ((440, 20, 200), (460, 40, 230)),
    "PropLever": ((447, 28, 100), (453, 32, 199)),
    "MixCap": ((440, -40, 200), (460, -20, 230)),
    "MixLever": ((447, -32, 100), (453, -28, 199)),
}
PROPELLER = {"propeller": ((450, 30, 215), "grasp", "PropCap")}
BOTH = PROPELLER | {"mixture": ((450, -30, 215), "grasp", "MixCap")}


def place(folder, boxes, controls, *, more="", unit="mm", scale=1.0, side=1.0):
    """An environment of boxes with controls: name, (at [mm], grip, part). The mesh in another unit
    and mirrored where that is asked."""
    lines = []
    for name, ends in boxes.items():
        corners = np.array(ends[0]) + BOX * np.subtract(ends[1], ends[0])
        corners = corners * scale * np.array([1.0, side, 1.0])
        faces = BOX_FACES if side > 0 else BOX_FACES[:, ::-1]
        lines.append(f"o {name}")
        lines += ["v {:.9g} {:.9g} {:.9g}".format(*corner) for corner in corners]
        first = 1 + 8 * list(boxes).index(name)
        lines += ["f {} {} {}".format(*(face + first)) for face in faces]
    (folder / "place.obj").write_text("\n".join(lines) + "\n")
    rows = [
        f"  {name}: {{at: [{x}, {side * y}, {z}], grip: {grip}, zone: 1, part: {part}}}"
        for name, ((x, y, z), grip, part) in controls.items()
    ]
    path = folder / "environment.yaml"
    path.write_text(
        "environment: place\nlength: mm\n"
        f"meshes: [{{file: place.obj, length: {unit}, up: z, forward: x}}]\n"
        + more
        + "\n".join(["controls:", *rows])
        + "\n"
    )
    return load_environment(path)


def pieces(environment):
    """The pieces of each control that has any."""
    return {
        control.name: [piece.part for piece in control.pieces]
        for control in environment.controls
        if control.pieces
    }


def depths(environment):
    """[mm] by part, how deep hands may be in it."""
    return {
        environment.parts[rule.part]: round(1000 * rule.depth) for rule in environment.allowances
    }


def test_a_knob_takes_its_stalk_along_to_the_depth_of_its_grip(tmp_path):
    environment = place(tmp_path, LEVERS, PROPELLER)
    assert pieces(environment) == {"propeller": ["PropLever"]}
    assert depths(environment) == {"PropCap": 30, "PropLever": 30}
    assert environment.assumed == (
        "control 'propeller': 'PropLever' counts as a piece of 'PropCap': it touches PropCap, and "
        "it is named like it (prop)",
    )


@pytest.mark.parametrize("gap, taken", [(1.9, {"propeller": ["PropLever"]}), (2.1, {})])
def test_a_piece_is_two_millimetres_away_at_most(tmp_path, gap, taken):
    stalk = {"PropLever": ((447, 28, 100), (453, 32, 200 - gap))}
    assert pieces(place(tmp_path, LEVERS | stalk, PROPELLER)) == taken


def test_a_piece_may_touch_a_piece_and_not_the_part_itself(tmp_path):
    boxes = LEVERS | {"PropBase": ((430, 10, 90), (470, 50, 101))}
    assert pieces(place(tmp_path, boxes, PROPELLER)) == {"propeller": ["PropLever", "PropBase"]}


def test_what_is_large_in_all_is_no_piece(tmp_path):
    boxes = LEVERS | {"PropLever": ((447, 28, -80), (453, 32, 199))}
    assert pieces(place(tmp_path, boxes, PROPELLER)) == {}
    shorter = LEVERS | {"PropLever": ((447, 28, -69), (453, 32, 199))}
    assert pieces(place(tmp_path, shorter, PROPELLER)) == {"propeller": ["PropLever"]}


def test_a_base_of_two_levers_is_neither_s_and_says_so(tmp_path):
    boxes = {("PropGateBase" if name == "GateBase" else name): one for name, one in LEVERS.items()}
    environment = place(tmp_path, boxes, BOTH)
    assert pieces(environment) == {"propeller": ["PropLever"], "mixture": ["MixLever"]}
    assert environment.assumed[-1].startswith(
        "part 'PropGateBase' touches 'PropLever', and could be a piece of mixture and propeller: "
        "it counts as a piece of none"
    )


def test_levers_that_touch_one_another_keep_their_own_stalks(tmp_path):
    beside = {
        "MixCap": ((440, 5, 191), (460, 17, 230)),
        "MixLever": ((447, 15, 100), (453, 27, 190)),
    }
    boxes = {name: one for name, one in (LEVERS | beside).items() if name != "GateBase"}
    environment = place(tmp_path, boxes, BOTH)
    assert pieces(environment) == {"propeller": ["PropLever"], "mixture": ["MixLever"]}


def test_a_part_of_another_control_is_never_a_piece(tmp_path):
    controls = PROPELLER | {"prop_button": ((450, 30, 150), "push", "PropLever")}
    assert pieces(place(tmp_path, LEVERS, controls)) == {}


def test_parts_of_a_kind_or_a_place_are_not_one_thing(tmp_path):
    boxes = {
        "left_switch": ((0, 0, 0), (10, 10, 10)),
        "right_switch": ((11, 0, 0), (21, 10, 10)),
        "switch_panel": ((0, 0, -5), (100, 100, -1)),
        "Object_4": ((0, 11, 0), (10, 21, 10)),
        "cab": ((-900, -900, -900), (900, 900, -800)),
    }
    controls = {"lights": ((5, 5, 5), "push", "left_switch")}
    assert pieces(place(tmp_path, boxes, controls)) == {}


def test_a_word_that_the_structure_around_has_too_tells_nothing(tmp_path):
    names = {"console": "Hybrid_hull", "PropCap": "Hybrid_red", "PropLever": "Hybrid_grey"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items()}
    controls = {"propeller": ((450, 30, 215), "grasp", "Hybrid_red")}
    assert pieces(place(tmp_path, boxes, controls)) == {"propeller": ["Hybrid_grey"]}
    boxes["Hybrid_hull"] = ((0, -500, 0), (1000, 500, 201))  # the cap stands in it
    assert pieces(place(tmp_path, boxes, controls)) == {}


def test_the_numbers_of_a_large_mesh_that_was_split_tell_nothing(tmp_path):
    names = {"console": "Burner_1", "PropCap": "Burner_2", "PropLever": "Burner_3"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items()}
    controls = {"propeller": ((450, 30, 215), "grasp", "Burner_2")}
    assert pieces(place(tmp_path, boxes, controls)) == {}
    boxes = {"cab" if name == "Burner_1" else name: one for name, one in boxes.items()}
    boxes["Burner_1"] = ((460, 25, 205), (470, 35, 210))  # now all of that name is a small thing
    assert pieces(place(tmp_path, boxes, controls)) == {"propeller": ["Burner_1", "Burner_3"]}


@pytest.mark.parametrize("name", ["lever", "Left_Gear_Lever", "console_lever"])
def test_names_that_begin_alike_and_go_on_with_pieces_are_one_thing(tmp_path, name):
    names = {"PropCap": f"{name}_knob", "PropLever": f"{name}_stalk", "MixLever": "lever_two"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items()}
    controls = {"propeller": ((450, 30, 215), "grasp", f"{name}_knob")}
    assert pieces(place(tmp_path, boxes, controls)) == {"propeller": [f"{name}_stalk"]}


def test_a_piece_may_be_named_like_the_control(tmp_path):
    names = {"PropCap": "Cube_7"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items()}
    controls = {"propeller": ((450, 30, 215), "grasp", "Cube_7")}
    assert pieces(place(tmp_path, boxes, controls)) == {"propeller": ["PropLever"]}


def test_the_pieces_of_a_burner_are_told_in_one_sentence(tmp_path):
    boxes = {"hob": ((0, -500, 0), (900, 500, 40))}
    boxes |= {f"Burner_{k}": ((100 + 2 * k, 0, 40), (101 + 2 * k, 9, 50)) for k in range(1, 46)}
    environment = place(tmp_path, boxes, {"heat": ((103, 5, 45), "push", "Burner_1")})
    assert len(pieces(environment)["heat"]) == 44
    assert len(environment.assumed) == 1
    assert environment.assumed[0].startswith(
        "control 'heat': 44 parts count as pieces of 'Burner_1' (Burner_2, Burner_3, "
    )


def test_what_lies_within_a_part_is_a_piece_of_it_whatever_its_name(tmp_path):
    boxes = LEVERS | {
        "Cube_8": ((445, 25, 228), (455, 35, 231)),
        "Cube_9": ((448, 27, 210), (452, 33, 213)),
    }
    assert pieces(place(tmp_path, boxes, PROPELLER)) == {
        "propeller": ["Cube_8", "Cube_9", "PropLever"]
    }


def test_a_stalk_that_is_the_only_small_part_there_is_a_piece_by_its_shape(tmp_path):
    names = {"PropCap": "Cube_7", "PropLever": "Cube_8"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items() if name != "GateBase"}
    boxes["console"] = ((0, -500, 0), (1000, 500, 100))
    controls = {"feather": ((450, 30, 215), "grasp", "Cube_7")}
    assert pieces(place(tmp_path, boxes, controls)) == {"feather": ["Cube_8"]}
    plate = boxes | {"Cube_8": ((370, -50, 195), (520, 101, 199))}  # wider than a hand closes about
    assert pieces(place(tmp_path, plate, controls)) == {}
    screw = boxes | {"Cube_9": ((445, 28, 150), (447, 32, 152))}
    assert pieces(place(tmp_path, screw, controls)) == {}


def test_what_an_adjustment_alone_moves_is_one_thing(tmp_path):
    names = {"PropCap": "Cube_7", "PropLever": "Cube_8"}
    boxes = {names.get(name, name): one for name, one in LEVERS.items()}
    controls = {"feather": ((450, 30, 215), "grasp", "Cube_7")}
    moves = "adjustments: {slide: {along: [1, 0, 0], travel: [-9, 9], parts: [PARTS]}}\n"
    both = place(tmp_path, boxes, controls, more=moves.replace("PARTS", "Cube_7, Cube_8"))
    assert pieces(both) == {"feather": ["Cube_8"]}
    console = place(tmp_path, boxes, controls, more=moves.replace("PARTS", "'C*', console"))
    assert pieces(console) == {}


def test_what_moves_otherwise_is_no_piece(tmp_path):
    moves = "adjustments: {slide: {along: [1, 0, 0], travel: [-9, 9], parts: [PropCap]}}\n"
    assert pieces(place(tmp_path, LEVERS, PROPELLER, more=moves)) == {}


def test_pieces_depend_on_no_order_unit_or_side(tmp_path):
    boxes = {("PropGateBase" if name == "GateBase" else name): one for name, one in LEVERS.items()}
    wanted = {"propeller": ["PropLever"], "mixture": ["MixLever"]}
    for names in itertools.islice(itertools.permutations(boxes), 0, 720, 90):
        turned = {name: boxes[name] for name in names}
        assert pieces(place(tmp_path, turned, dict(reversed(BOTH.items())))) == wanted
    assert pieces(place(tmp_path, boxes, BOTH, unit="m", scale=0.001)) == wanted
    assert pieces(place(tmp_path, boxes, BOTH, side=-1.0)) == wanted


def test_a_list_says_what_is_the_control_s_own_and_nothing_more_is_taken(tmp_path):
    controls = {"propeller": ((450, 30, 215), "pinch", "[PropCap, GateBase]")}
    environment = place(tmp_path, LEVERS, controls)
    assert pieces(environment) == {"propeller": ["GateBase"]}
    assert depths(environment) == {"PropCap": 15, "GateBase": 15}
    assert environment.assumed == ()
    alone = place(tmp_path, LEVERS, {"propeller": ((450, 30, 215), "grasp", "[PropCap]")})
    assert depths(alone) == {"PropCap": 30}


def test_a_pattern_is_a_list_and_the_control_stands_on_the_nearest_of_its_parts(tmp_path):
    for key in ("'Prop*'", "['Prop*']", "['Prop*', PropLever]"):
        environment = place(tmp_path, LEVERS, {"propeller": ((450, 30, 215), "grasp", key)})
        assert environment.controls[0].part == "PropCap"
        assert pieces(environment) == {"propeller": ["PropLever"]}


def test_a_rule_for_hands_holds_for_a_piece_too(tmp_path):
    more = "parts: {PropLever: {allow: [{segments: [RHN], depth: 5}]}}\n"
    environment = place(tmp_path, LEVERS, PROPELLER, more=more)
    assert depths(environment) == {"PropCap": 30, "PropLever": 5}


def test_a_listed_part_that_is_not_there_is_named_with_its_place(tmp_path):
    with pytest.raises(InputError, match=r"controls\.propeller\.part\[1\]: no part 'PropLevr'"):
        place(tmp_path, LEVERS, {"propeller": ((450, 30, 215), "grasp", "[PropCap, PropLevr]")})
    with pytest.raises(InputError, match=r"controls\.propeller\.part: at least 1"):
        place(tmp_path, LEVERS, {"propeller": ((450, 30, 215), "grasp", "[]")})
    with pytest.raises(InputError, match=r"controls\.propeller\.part: "):
        place(tmp_path, LEVERS, {"propeller": ((450, 30, 215), "grasp", "7")})


def test_the_levers_of_a_real_cockpit_take_their_stalks_along():
    environment = load_environment(
        real_input(SHARED.parent / "cases" / "grob" / "environment.yaml")
    )
    own = pieces(environment)
    assert own["propeller"] == ["PropLever"]
    assert own["throttle"] == ["ThrottleLever"]
    assert own["breaker_att"] == ["BAttIndic1S"]
    assert "ThrotCovPlate" not in itertools.chain(*own.values())


def _points(corners, count=40):
    """Points all over a triangle (3, 3), the edges with them."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
    u, v = (k[i + j <= count] / count for k in (i, j))
    return corners[0] + np.outer(u, corners[1] - corners[0]) + np.outer(v, corners[2] - corners[0])


def test_triangles_come_as_near_as_their_nearest_points():
    random = np.random.default_rng(7)
    for _ in range(100):
        one, other = random.normal(size=(2, 3, 3)) + random.normal(size=(2, 1, 3))
        gap = float(cKDTree(_points(one)).query(_points(other))[0].min())
        step = max(np.ptp(one, axis=0).max(), np.ptp(other, axis=0).max()) / 40
        assert come_near(one[None], other[None], gap + 1e-9)
        assert gap < 3 * step or not come_near(one[None], other[None], gap - 3 * step)


def test_an_edge_through_a_face_and_edges_that_pass_one_another_are_near():
    plate = np.array([[[-1.0, -1, 0], [1, -1, 0], [0, 2, 0]]])
    rod = np.array([[[0.0, 0, -5], [0, 0, 5], [0, 0, 5]]])
    assert come_near(plate, rod, 0.0)
    beside = np.array([[[-5.0, -1.001, -5], [5, -1.001, 5], [5, -1.001, 5]]])
    assert come_near(plate, beside, 0.0011)
    assert not come_near(plate, beside, 0.0009)
    assert not come_near(plate[:0], rod, 1.0)


def test_a_control_without_a_part_is_told_at_which_it_is(tmp_path):
    controls = {"propeller": ((450, 30, 215), "grasp", "''"), "free": ((0, 0, 999), "push", "''")}
    environment = place(tmp_path, LEVERS, controls)
    assert [words for words in environment.warnings if "names no part" in words] == [
        "control 'propeller' names no part and is at 'PropCap', which nobody may enter to use it: "
        "is that its 'part'? [part of control propeller]"
    ]
    assert depths(environment) == {}
    assert any(
        "control 'free' is in free air: the nearest part, 'MixCap', is 886 mm away, at (440, -20, 230)"
        in words
        for words in environment.warnings
    )
    assert environment.assumed[0].startswith(
        "controls 'propeller' (0 mm from 'PropCap'), 'free' (886 mm from 'MixCap'): no part is named"
    )


def test_a_pedal_without_a_part_is_in_free_air_nearer_than_a_knob_is(tmp_path):
    above = (440, -20, 380)
    controls = {"pedal": (above, "foot", "''"), "knob": (above, "push", "''")}
    told = [words for words in place(tmp_path, LEVERS, controls).warnings if "free air" in words]
    assert len(told) == 1 and told[0].startswith("control 'pedal' is in free air")


@settings(max_examples=20, deadline=None)
@given(at=st.tuples(*[st.integers(-900, 900)] * 3), swapped=st.booleans())
def test_a_control_away_from_its_part_is_told_the_nearest_part_and_point(
    tmp_path_factory, at, swapped
):
    """Of a box from 0 to 100 mm the nearest point is that of each coordinate clipped to it."""
    boxes = {"far": ((3000, 0, 0), (3100, 100, 100)), "near": ((0, 0, 0), (100, 100, 100))}
    named = "near" if swapped else "far"
    environment = place(tmp_path_factory.mktemp("cab"), boxes, {"knob": (at, "push", named)})
    nearest = np.clip(at, 0, 100)
    gap = float(np.linalg.norm(np.array(at) - nearest))
    said = [words for words in environment.warnings if "'knob' is" in words]
    if swapped and gap <= 60.0:
        assert said == []
        return
    point = f"({', '.join(map(str, nearest.tolist()))}) mm"
    inside = all(0 <= value <= 100 for value in at)
    words = (
        f"nearest at {point}" if swapped else f"the nearest part is 'near', {gap:.0f} mm away at "
    )
    assert words in said[0] and (swapped or inside or point in said[0])


def test_a_stalk_that_is_stated_of_two_levers_is_doubted_and_one_wheel_of_two_places_is_not(
    tmp_path,
):
    boxes = LEVERS | {"bridge": ((450, -35, 195), (452, 35, 199))}
    stated = {"propeller": "[PropCap, bridge]", "mixture": "[MixCap, bridge]"}
    joined = {name: (*BOTH[name][:2], part) for name, part in stated.items()}
    told = place(tmp_path, boxes, joined).warnings
    assert [words.split(":")[0] for words in told if "for their own" in words] == [
        "controls 'propeller' and 'mixture' stand on 'PropCap' and 'MixCap', and both have 'bridge' "
        "for their own"
    ]
    wheel = {name: (at, grip, "[PropCap, bridge]") for name, (at, grip, _) in BOTH.items()}
    assert not any("for their own" in words for words in place(tmp_path, boxes, wheel).warnings)


def test_a_grip_on_a_soup_is_told_and_takes_nothing_along(tmp_path):
    controls = {"propeller": ((450, 30, 215), "grasp", "console")}
    environment = place(tmp_path, LEVERS, controls)
    assert environment.warnings[-1].startswith(
        "control 'propeller' is gripped (grasp) on 'console', which is 1 m large and counts as a "
        "panel that no hand may enter: 'split'"
    )
    assert (pieces(environment), depths(environment)) == ({}, {})


@pytest.mark.parametrize(("across", "may"), [(30, True), (99, True), (101, False)])
def test_a_rail_is_gripped_however_long_it_is_and_a_plank_is_not(tmp_path, across, may):
    rail = {"rail": ((0, 0, 1800), (2000, across, 1810)), "floor": ((0, -500, -10), (2000, 500, 0))}
    environment = place(tmp_path, rail, {"rail": ((1000, 0, 1805), "grasp", "rail")})
    told = any("counts as a panel" in words for words in environment.warnings)
    assert (depths(environment), told) == (({"rail": 30}, False) if may else ({}, True))


def test_a_unit_explains_no_control_that_is_within_the_box_of_its_part(tmp_path):
    shell = {"cab": ((0, -1500, 0), (3000, 1500, 3000))}
    controls = {"lever": ((700, 0, 900), "push", "cab")}
    environment = place(tmp_path, shell, controls, more="parts: {cab: {solid: false}}\n")
    assert [words for words in environment.warnings if "lever" in words] == [
        "control 'lever' is 700 mm away from its part 'cab', which is nearest at (0, 0, 900) mm "
        "[place of control lever]"
    ]
