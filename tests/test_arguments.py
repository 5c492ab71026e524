"""Public functions with hostile arguments: the package's own errors, which name the argument, and
nothing else."""

from __future__ import annotations

import inspect
import pickle
import re
from dataclasses import fields, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from tests.conftest import environment_of
from tests.test_fast import soup
from workbench import Driver, Package
from workbench.body.scaling.scale import morph_to
from workbench.draw.scene import Scene
from workbench.model.environment import Rest, Seat
from workbench.posture.seating.posture import Pedals

NAN = float("nan")
INF = float("inf")
ODD = [
    None,
    object(),
    "no such name",
    "",
    b"bytes",
    -1,
    0,
    7,
    3.5,
    -0.5,
    NAN,
    INF,
    10**30,
    True,
    [],
    {},
    [[1], [1, 2]],
    "x" * 10_000,
    np.zeros((2, 7, 3)),
    np.full(3, NAN),
    np.full((1, 3), INF),
    np.zeros(0),
    ["no such name"],
    [NAN],
    {"no such name": 1.0},
    {"stature": NAN},
    {1: 2},
    ("a", "b"),
    np.array(["a"]),
    1j,
    lambda: 0,
]
"""What is put in the place of every argument."""


def block():
    """The corners and faces of a cube of 100 mm."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.1
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
                      [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip
    return cube, faces


def fitting_cases():
    """The functions that fit spheres to a surface."""
    surface = wb.sealed(*block())
    bones = wb.Bones(
        ("A", "B"),
        np.array([[0.02, 0.05, 0.05], [0.05, 0.05, 0.05]]),
        np.array([[0.05] * 3, [0.08] + [0.05] * 2]),
    )
    radii = {"least_radius": 0.01, "greatest_radius": 0.05}
    return {
        "decompose": {
            "mesh": surface,
            "outward": 0.02,
            "inward": 0.02,
            **radii,
            "joints": [[0.05, 0.05, 0.05]],
            "seed": 1,
        },
        "fit_segments": {
            "surface": surface,
            "bones": bones,
            "outward": 0.02,
            "inward": 0.02,
            **radii,
            "border": 0.08,
            "seed": 0,
            "count": 6,
            "joint_radius": [0.02],
        },
    }


def arm_cases(one_arm):
    """The functions that a small body will do for, with arguments that are right."""
    room = environment_of(soup(1, 12))
    rest = wb.pose(one_arm, {})
    bent = wb.pose(one_arm, {"ELBOW": {"flexion": 40}}, position=(0.1, 0.0, 0.0))
    motion = replace(wb.join_poses([rest, bent]), time=np.array([0.0, 1.0]))
    placed = wb.place(one_arm, rest)
    cube, faces = block()
    return {
        "between": (rest, bent, 0.5),
        "body_clearance": (placed, placed),
        "body_contacts": {"one": placed, "other": placed, "margin": 0.1, "tolerance": 1e-6},
        "body_episodes": {
            "one": (one_arm, motion),
            "other": (one_arm, motion),
            "by": "segment",
            "tolerance": 1e-6,
            "threads": 1,
        },
        "body_sweep": {
            "one": (one_arm, rest, bent),
            "other": (one_arm, rest, bent),
            "by": "segment",
            "tolerance": 1e-6,
            "threads": 1,
        },
        "clearance": {"placed": placed, "environment": room},
        "room": {"placed": placed, "environment": room, "grid": True},
        "room_of_poses": {"body": one_arm, "poses": rest, "environment": room},
        "stack_bodies": ([one_arm, one_arm],),
        "collides": {
            "placed": placed,
            "environment": room,
            "tolerance": 1e-6,
            "threads": 1,
        },
        "contacts": {"placed": placed, "environment": room, "margin": 0.1, "tolerance": 1e-6},
        "episodes": {
            "body": one_arm,
            "motion": motion,
            "environment": room,
            "by": "segment",
            "window": ["HAND"],
            "tolerance": 1e-6,
            "threads": 1,
        },
        "join_poses": {"rows": [rest, bent]},
        "place": {"body": one_arm, "poses": rest, "window": ["HAND"], "reference": "BASE"},
        "pose": {
            "body": one_arm,
            "angles": {"ELBOW": {"flexion": 40}},
            "rotations": {"WRIST": [1, 0, 0, 0]},
            "reference": "BASE",
            "position": (0, 0, 0),
            "attitude": np.eye(3),
        },
        "rereference": {"placed": placed, "segment": "HAND"},
        "sealed": {"vertices": cube, "faces": faces, "what": "block"},
        "self_contacts": {"placed": placed, "margin": 0.1, "tolerance": 1e-6},
        "self_episodes": {
            "body": one_arm,
            "motion": motion,
            "by": "segment",
            "window": ["HAND"],
            "tolerance": 1e-6,
            "threads": 1,
        },
        "self_sweep": {
            "body": one_arm,
            "way": (rest, bent),
            "by": "segment",
            "window": ["HAND"],
            "tolerance": 1e-6,
            "threads": 1,
        },
        "balance": {"placed": wb.place(man(), wb.pose(man(), {}))},
        "standing_posture": {
            "body": man(),
            "poses": wb.pose(man(), {}),
            "hands": {"right hand": ("push", (0.5, -0.2, 1.0))},
            "area": ((0.0, 0.1), (0.0, 0.0)),
            "heading": 0.0,
            "margin": 0.01,
            "threads": 1,
        },
        "stops": {"body": one_arm, "poses": rest},
        "sweep": {
            "body": one_arm,
            "way": (rest, bent),
            "environment": room,
            "by": "segment",
            "window": ["HAND"],
            "tolerance": 1e-6,
            "threads": 1,
        },
        "update": {"placed": placed, "poses": rest, "first_changed": "ELBOW"},
    }


def slow_cases():
    """What takes seconds for all that is put in: spheres fitted, envelopes searched, bodies
    scaled."""
    upright = wb.pose(man(), {}, reference="LT", position=(0.1, 0.0, 0.35))
    hand = {"name": "right hand", "grip": "push", "zone": 1}
    return {
        **fitting_cases(),
        "reach_envelope": {
            "body": man(),
            "poses": upright,
            "origin": (0, 0, 0.3),
            "step": 45,
            "levels": True,
            "person": "",
            "environment": None,
            **hand,
        },
        "scale": {
            "body": man(),
            "measures": {"stature": 1.7},
            "others": {"sitting_height": 0.9},
            "detail": "coarse",
        },
    }


@cache
def man():
    return morph_to(wb.load_body("adult_male"), "coarse")


def sight_cases():
    """The functions that are about what people see."""
    room = wb.load_environment("compact_car")
    placed = wb.place(man(), wb.pose(man(), {}, reference="LT", position=(0.0, 0.0, 3.0)))
    eyes = wb.given_eyes((0.02, 0.35, 0.89))
    scenery = wb.scenery_of(room)
    mirror = room.mirror("left_mirror")
    glass = wb.glass_of(room, mirror, eye=eyes.middle[0])
    ground = np.array([[-10.0, 1.5, -0.28], [-12.0, 2.0, -0.28]])
    part = room.part_index(mirror.part)
    return {
        "eyes_of": {"placed": placed},
        "gaze": {"eyes": eyes, "target": [1.0, 0.0, 0.9]},
        "given_eyes": {"middle": [0.0, 0.3, 0.9], "ahead": (1.0, 0.0, 0.0), "spacing": 0.065},
        "glass_of": {"environment": room, "mirror": mirror, "eye": [0.02, 0.35, 0.89]},
        "mirror_field": {
            "scenery": scenery,
            "eyes": eyes,
            "glass": glass,
            "points": ground,
            "item": part,
            "row": 0,
        },
        "obscuration": {"scenery": scenery, "eyes": eyes, "row": 0, "within": None, "step": 0.05},
        "scenery_of": {
            "environment": room,
            "placed": placed,
            "others": {"guest": placed},
            "moving": ("bonnet",),
            "displacement": np.zeros((1, 3)),
        },
    }


def strain_cases():
    """The functions that are about what a posture costs."""
    placed = wb.place(man(), wb.pose(man(), {"RS": {"flexion": 60}}))
    return {
        **{
            method: {"placed": placed, "work": wb.Work(load=1.0), "rules": f"strain_{method}"}
            for method in ("rula", "reba", "owas")
        },
        "working_angles": {"placed": placed},
        "grip_place": {"placed": placed, "floor": 0.0},
        "lifting": {"lifts": a_lift(), "rules": "strain_niosh_metric"},
        "supports_of": {"placed": placed, "segments": ["LF", "RF"], "toward": (0.0, 0.0, -1.0)},
        "static_load": {
            "placed": placed,
            "supports": wb.supports_of(placed, ["LF", "RF"]),
            "pushes": [wb.Push("RHN", (1.0, 0.0, 0.0))],
            "held": {"RHN": 1.0},
        },
        "arms_of": {"placed": placed, "side": "left", "hand": [0.4, 0.2, 1.2]},
        "hand_strength": {
            "arms": wb.arms_of(placed, "right"),
            "direction": [1.0, 0.0, 0.0],
            "male": True,
            "rules": "strain_arm_force_field",
        },
        "foot_strength": {
            "placed": placed,
            "side": "left",
            "direction": [1.0, 0.0, 0.0],
            "male": True,
            "stature": 1.7,
            "ages": "18-25",
            "foot": [0.4, 0.1, 0.1],
            "rules": "strain_leg_strength",
        },
        "grip_strength": {"age": 30.0, "male": True, "rules": "strain_grip"},
    }


def a_lift():
    """A task for the lifting equation."""
    return wb.Lifts(
        load=[10.0],
        horizontal=0.4,
        vertical=0.5,
        travel=0.5,
        asymmetry=0.0,
        per_minute=1.0,
        hours=1.0,
        stance="standing",
        hands=2,
    )


def human_cases(tmp_path):
    """The functions that are about people."""
    body = man()
    model = wb.load_population_model("ansur2")
    upright = wb.pose(body, {}, reference="LT", position=(0.1, 0.0, 0.35))
    room = environment_of(soup(1, 12))
    seat = Seat(
        "driver",
        (0.0, 0.0, 0.3),
        0.4,
        0.2,
        0.0,
        Rest("pan", ("LT",), 0.01),
        Rest("back", ("UT",), 0.01),
        (-0.1, 0.1),
        (0.0, 0.05),
        (),
    )
    driver = Driver("male", 1.75, 0.92, 25.0)
    package = Package((0.8, 0.0, 0.0), (0.9, 0.0, 0.2), (0.4, 0.0, 0.7), (0.0, 0.0, 0.3))
    feet = {"left foot": (0.85, 0.1, 0.15), "right foot": (0.85, -0.1, 0.15)}
    hand = {"name": "right hand", "grip": "push", "zone": 1}
    arm = wb.limb(body, "right hand")
    beside = wb.place(body, wb.pose(body, {}, reference="LT", position=(0.1, -0.6, 0.35)))
    rows = tmp_path / "rows.csv"
    rows.write_text("subjectid,Gender,stature\n1,Male,1750\n2,Female,1640\n")
    return {
        "boundary_cases": {
            "source": model,
            "sex": "female",
            "share": 0.95,
            "measures": ("stature", "sitting_height"),
        },
        "draw_people": {
            "source": model,
            "count": 3,
            "seed": 1,
            "men": 0.5,
            "synthetic": True,
            "given": {"stature": 1.7},
        },
        "driving_angles": {"driver": driver, "package": package},
        "driving_posture": {
            "body": body,
            "poses": upright,
            "seat": seat,
            "drivers": [driver],
            "package": package,
            "feet": feet,
            "eye": 1.1,
            "seed": 1,
            "numbers": [0],
        },
        "eyellipse": {
            "ball": (0.9, 0, 0),
            "heel": 0.0,
            "side": 0.3,
            "wheel": 0.5,
            "height": 0.25,
            "clutch": True,
            "rise": 0.0,
            "percentile": 95.0,
        },
        "limb": {"body": body, "name": "right hand", "grip": "push", "zone": 1},
        "measure": {"body": body, "names": ["stature"]},
        "seated": {"body": body},
        "people_envelope": {
            "body": body,
            "poses": upright,
            "origins": (0, 0, 0.3),
            "percentile": 5.0,
            "step": 45,
            **hand,
        },
        "person_body": {
            "body": body,
            "people": model,
            "sex": "male",
            "measures": {"stature": 1.7},
            "age": None,
            "detail": "coarse",
        },
        "reach": {
            "body": body,
            "poses": upright,
            "targets": [[0.4, -0.2, 0.8]],
            "limb": arm,
            "direction": [1.0, 0, 0],
            "environment": room,
            "moving_parts": (),
            "displacement": np.zeros((1, 3)),
            "bystanders": [wb.Bystander("other", beside, np.ones(len(body.sphere_names), bool))],
            "initial": upright,
            "restarts": 1,
            "max_extension": 0.0,
            "tighter_zones": True,
            "brief": False,
            "threads": 1,
        },
        "reach_map": {
            "body": body,
            "poses": upright,
            "environment": room,
            "part": "soup",
            "points": 5,
            "grip": "push",
            "zone": 1,
            "hand": "right",
            "weights": [1.0],
            "threads": 1,
        },
        "read_ansur": {"paths": rows, "measures": ("stature",), "unit": 0.001, "weights": None},
        "seat_curve": {"height": 0.25, "percentile": 95.0},
        "seat": {
            "body": body,
            "poses": upright,
            "seat": seat,
            "eye": 1.1,
            "pedals": Pedals(feet, 0.0),
            "every": False,
            "threads": 1,
        },
    }


FILES = [
    "load_body",
    "load_environment",
    "load_population_model",
    "load_study",
    "scene_of",
]
"""Functions of one name or path; run, compare, to_pyvista and view take what these and
others give."""


def called(name, arguments):
    """A public function with arguments; what is not an error of the package is told with what it
    was called with."""
    try:
        if name == "read_ansur":
            arguments = dict(arguments)
            paths = arguments.pop("paths")
            return wb.read_ansur(paths, **arguments)
        function = getattr(wb, name)
        return function(*arguments) if isinstance(arguments, tuple) else function(**arguments)
    except wb.WorkbenchError as error:
        return error


def hostile(value):
    """What is put in place of an argument: ODD things, and the argument itself with something wrong
    in it."""
    yield from ODD
    if isinstance(value, wb.Poses):
        joints = value.rotations.shape[1]
        unit = np.tile([1.0, 0, 0, 0], (len(value), joints + 1, 1))
        yield wb.Poses(unit, 0, value.world_from_reference)
        yield wb.Poses(value.rotations[:0], value.reference, value.world_from_reference[:0])
        yield wb.join_poses([replace(value, time=None)] * 3)
    elif isinstance(value, (np.ndarray, list, tuple)):
        yield list(value) * 2
        yield list(value)[:1]
        yield [value]
        for item in ODD:
            yield [item, *list(value)[1:]]
    elif isinstance(value, dict):
        for key in value:
            for item in ODD:
                yield {**value, key: item}


def failures(cases):
    """Every call that ended in something else than an answer or an error of the package."""
    found = []
    for name, right in cases.items():
        good = called(name, right)
        assert not isinstance(good, wb.WorkbenchError), f"{name}: {good}"
        given = dict(enumerate(right)) if isinstance(right, tuple) else right
        for argument, value in given.items():
            for bad in hostile(value):
                wrong = {**given, argument: bad}
                try:
                    called(name, tuple(wrong.values()) if isinstance(right, tuple) else wrong)
                except Exception as error:  # noqa: BLE001
                    found.append(
                        f"{name}({argument}={argument_words(bad)}): {type(error).__name__}: {error}"[
                            :300
                        ]
                    )
    return found


def argument_words(value):
    return f"array {value.shape}" if isinstance(value, np.ndarray) else repr(value)[:60]


def test_hostile_arguments_about_bodies_and_contacts_are_refused_in_our_own_words(one_arm):
    assert failures(arm_cases(one_arm)) == []


def test_hostile_arguments_about_people_are_refused_in_our_own_words(tmp_path):
    assert failures(human_cases(tmp_path)) == []


@pytest.mark.nightly
def test_hostile_arguments_of_slow_functions_are_refused_in_our_own_words():
    assert failures(slow_cases()) == []


def test_hostile_arguments_about_sight_are_refused_in_our_own_words():
    assert failures(sight_cases()) == []


def test_hostile_arguments_about_strain_are_refused_in_our_own_words():
    assert failures(strain_cases()) == []


def made_by_hand(one_arm):
    """The nouns that people make themselves."""
    poses = wb.pose(one_arm, {})
    corners = np.array([[0.02, 0.05, 0.05], [0.05, 0.05, 0.05]])
    return [
        one_arm,
        environment_of(soup(1, 12)),
        replace(poses, time=np.zeros(1)),
        wb.place(one_arm, poses),
        wb.Bones(("A", "B"), corners, corners + 0.01),
        wb.Driver("male", 1.75, 0.92, 25.0),
        wb.Package((0.8, 0.0, 0.0), (0.9, 0.0, 0.2), (0.4, 0.0, 0.7), (0.0, 0.0, 0.3)),
        wb.Work(load=1.0),
        a_lift(),
        wb.arms_of(wb.place(man(), wb.pose(man(), {})), "right"),
        wb.Push("RHN", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        wb.supports_of(wb.place(man(), wb.pose(man(), {})), ["LF", "RF"]),
    ]


def test_nouns_made_of_hostile_values_are_refused_in_our_own_words(one_arm):
    found = []
    for noun in made_by_hand(one_arm):
        for field in fields(noun):
            for bad in hostile(getattr(noun, field.name)):
                try:
                    replace(noun, **{field.name: bad})
                except wb.InputError:
                    continue
                except Exception as error:  # noqa: BLE001
                    found.append(
                        f"{type(noun).__name__}.{field.name}={argument_words(bad)}: {error!r}"[:300]
                    )
    assert found == []


def methods(noun):
    """The public methods of a noun that take arguments, and the names of these."""
    for name, method in inspect.getmembers(type(noun), inspect.isfunction):
        taken = [each for each in inspect.signature(method).parameters if each != "self"]
        if taken and not name.startswith("_"):
            yield getattr(noun, name), taken


def test_methods_of_nouns_refuse_hostile_arguments_in_our_own_words(one_arm):
    room = environment_of(soup(1, 12))
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    people = wb.draw_people(wb.load_population_model("ansur2"), 3, seed=1)
    episodes = wb.episodes(**arm_cases(one_arm)["episodes"])
    found = []
    tried = 0
    nouns = [one_arm, room, wb.pose(one_arm, {}), placed, people, episodes]
    nouns += [wb.contacts(placed, room, margin=0.5), wb.body_clearance(placed, placed)]
    for noun in nouns:
        for method, taken in methods(noun):
            for argument in taken:
                for bad in [*ODD, noun, 1.5, [7], np.ones(5, dtype=bool), (0, 0, 9), slice(None)]:
                    tried += 1
                    try:
                        method(**(dict.fromkeys(taken, 0) | {argument: bad}))
                    except wb.WorkbenchError:
                        continue
                    except Exception as error:  # noqa: BLE001
                        found.append(f"{method}({argument}={argument_words(bad)}): {error!r}"[:300])
    assert found == [] and tried > 500


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: wb.contacts(), "contacts(...): missing a required argument: 'placed'; it takes "),
        (
            lambda: wb.load_body("bubbleman", detial="fine"),
            "load_body(...): got an unexpected keyword argument 'detial'",
        ),
        (lambda: wb.load_body("a", "b", "c", "d"), "load_body(...): too many positional arguments"),
    ],
)
def test_arguments_that_are_missing_or_unknown_are_told(call, message):
    with pytest.raises(wb.UsageError, match=re.escape(message)):
        call()


PLACE = np.eye(3, 4)[None]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"world_from_reference": PLACE * [[-1], [1], [1]]},
            "mirrored one (determinant -1) in row 0",
        ),
        ({"world_from_reference": PLACE * 2}, "whose rows are not unit vectors at right angles"),
        ({"world_from_reference": PLACE[0]}, "expected an array of shape (1, 3, 4), got (3, 4)"),
        (
            {"world_from_reference": PLACE * NAN},
            "poses.world_from_reference: expected rotations (3, 3)",
        ),
        (
            {"reference": 4},
            "poses.reference: expected 0 to 3, the segments of a body of 3 joints, got 4",
        ),
        ({"reference": -1}, "poses.reference: expected 0 to 3"),
        ({"reference": 1.0}, "poses.reference: expected the index of a segment, got 1.0"),
        (
            {"rotations": np.full((1, 3, 4), NAN)},
            "poses.rotations: expected quaternions (w, x, y, z) of length 1",
        ),
        (
            {"rotations": np.zeros((1, 3, 3))},
            "poses.rotations: expected an array of shape (any, any, 4)",
        ),
        ({"time": [NAN]}, "poses.time: expected finite times"),
    ],
)
def test_poses_that_are_none_say_what_is_wrong_with_them(one_arm, change, message):
    with pytest.raises(wb.InputError, match=re.escape(message)):
        replace(wb.pose(one_arm, {}), **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": [1, 2]}, "position: expected x, y, z [m], got [1, 2]"),
        ({"position": [0, 0, NAN]}, "position: expected finite numbers, got nan at (2,)"),
        ({"position": 1.0}, "position: expected a sequence of which each is a number, got 1.0"),
        ({"attitude": np.eye(4)}, "attitude: expected a rotation (3, 3), got an array (4, 4)"),
        (
            {"attitude": np.diag([1, 1, -1])},
            "attitude: expected rotations (3, 3), got a mirrored one",
        ),
        ({"attitude": [[1, 0], [0]]}, "attitude: expected numbers in rows of equal length"),
        (
            {"angles": {"ELBOW": 40}},
            "angles['ELBOW']: expected a mapping of a text to a number, got 40",
        ),
        (
            {"angles": {"ELBOW": {"flexion": NAN}}},
            "angles['ELBOW']['flexion']: expected a finite number, got nan",
        ),
        (
            {"rotations": {"WRIST": [1, 0, 0]}},
            "rotations: joint WRIST: expected a quaternion w, x, y, z",
        ),
        ({"body": "one_arm"}, "body: expected a Body, got 'one_arm'"),
        ({"reference": 3}, "reference: expected a text or None, got 3"),
    ],
)
def test_a_pose_that_is_none_says_what_is_wrong_with_it(one_arm, change, message):
    with pytest.raises(wb.WorkbenchError, match=re.escape(message)):
        wb.pose(**{"body": one_arm, "angles": {}, **change})


@pytest.mark.parametrize("metres", [3.0, 0.3, 1750.0, -1.7, NAN, 10**30])
def test_a_stature_that_nobody_has_is_refused_by_every_way_to_a_body(metres):
    model = wb.load_population_model("ansur2")
    ways = [
        lambda: wb.scale(man(), {"stature": metres}),
        lambda: wb.person_body(man(), model, sex="male", measures={"stature": metres}),
    ]
    for way in ways:
        with pytest.raises(wb.WorkbenchError, match=r"stature|measures\['stature'\]"):
            way()


def test_a_whole_number_is_as_good_as_one_with_a_fraction(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}, position=[0, 0, 1]))
    room = environment_of(soup(1, 12))
    assert (
        len(wb.contacts(placed, room, margin=1).distance)
        == len(wb.contacts(placed, room, margin=1.0).distance)
        > 0
    )


@pytest.mark.parametrize("name", [*FILES, "run", "compare", "to_pyvista", "view"])
def test_hostile_names_and_paths_are_refused_in_our_own_words(name, tmp_path):
    more = ["\0", "a\nb", "../" * 300, Path("/"), Path(tmp_path), "/dev/null", "*"]
    rest = (Scene(()),) if name == "to_pyvista" else (None,) if name == "compare" else ()
    for bad in [*ODD, *more]:
        function = getattr(wb, name)
        with pytest.raises(wb.WorkbenchError):
            function(bad, *rest[:1] if name == "compare" else ())


def test_hostile_pictures_are_refused_in_our_own_words(one_arm, tmp_path):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    right = {"source": placed, "out": tmp_path / "a.svg", "environment": None, "posture": None}
    right |= dict.fromkeys(("case", "view", "size", "display", "style", "cut", "angle"))
    right |= dict.fromkeys(("look_at", "ground", "outline"))
    assert failures({"render": right}) == []


def test_a_hostile_mesh_is_refused_in_our_own_words(tmp_path):
    for bad in [*ODD, "\0", "nowhere.obj", Path(tmp_path), "/dev/null"]:
        with pytest.raises(wb.WorkbenchError):
            wb.environment_from_mesh(bad, up="z", forward="x", length="m")


def test_every_public_function_is_tried(one_arm, tmp_path):
    functions = {name for name in wb.__all__ if inspect.isfunction(getattr(wb, name))}
    tried = {
        *arm_cases(one_arm),
        *human_cases(tmp_path),
        *slow_cases(),
        *strain_cases(),
        *sight_cases(),
        *FILES,
        "run",
        "compare",
        "render",
        "write_report",
        "to_pyvista",
        "view",
        "environment_from_mesh",
    }
    assert functions == tried


def test_every_public_function_is_found_by_pickle_and_keeps_its_name():
    for name in wb.__all__:
        function = getattr(wb, name)
        if inspect.isfunction(function):
            assert pickle.loads(pickle.dumps(function)) is function
            assert function.__name__ == name and function.__doc__
