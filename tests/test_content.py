"""Keys of kept work: everything that a study holds reaches them, field by field, and so does the
program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.crowds import crowd_of
from tests.toy_cockpit import STUDY, write_toy
from workbench import load_study
from workbench.model.content import content_key, program_hash
from workbench.model.stops import StopKind
from workbench.study.accommodation import population_bodies
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.checkpoints import result_chunks
from workbench.study.accommodation.population_bodies import FittedChunk
from workbench.study.situation import seating_of

FULL = (
    STUDY.replace("length: mm", "title: a toy\ndescription: of boxes\nlength: mm")
    .replace(
        "criteria:",
        """shares: {mixes: {half: 50}}
reach_maps: [{people: pilot, part: panel, hand: right, grip: push, zone: 1, points: 30}]
changes: [{name: knob aft, control: knob, move: [-10, 0, 0]}]
criteria:""",
    )
    .replace("detail: coarse", "detail: coarse, clothes: [helmet, shoes]")
)
"""The toy study with something in every list that a study file may have."""


def key(value):
    return content_key("test", value)


def other(value, folder):
    """Copies of a value, each with one thing changed somewhere in it, and where that is."""
    if isinstance(value, Enum):
        yield "", next(one for one in type(value) if one is not value)
    elif isinstance(value, np.ndarray):
        yield from other_arrays(value)
    elif isinstance(value, bool):
        yield "", not value
    elif isinstance(value, (int, float)):
        yield "", value + 1 if np.isfinite(value) else 0.0
        yield " as a text", str(value)
    elif isinstance(value, str):
        yield "", value + "x"
    elif value is None:
        yield "", 0
    elif isinstance(value, Path):
        copy = folder / value.name
        copy.write_bytes(value.read_bytes() + b" ")
        yield "", copy
    elif is_dataclass(value):
        for field in fields(value):
            for where, changed in other(getattr(value, field.name), folder):
                yield f".{field.name}{where}", with_field(value, field.name, changed)
    elif isinstance(value, Mapping):
        for name, item in value.items():
            for where, changed in other(item, folder):
                yield f"[{name}]{where}", {**value, name: changed}
        yield " with one more", {**value, "one more": 1}
    else:
        assert isinstance(value, (tuple, list)), type(value)
        remade = type(value)
        for at in sorted({0, len(value) // 2, len(value) - 1}) if value else ():
            for where, changed in other(value[at], folder):
                yield f"[{at}]{where}", remade([*value[:at], changed, *value[at + 1 :]])
        yield " with one more", remade([*value, "one more"])


def other_arrays(array):
    """An array with its first and its last byte changed, of another type, of another shape."""
    for at in (0, -1) if array.size else ():
        data = bytearray(array.tobytes())
        data[at] ^= 1
        yield f" byte {at}", np.frombuffer(bytes(data), dtype=array.dtype).reshape(array.shape)
    yield (
        " as integers of another size",
        array.astype(np.float32 if array.dtype.kind == "f" else np.int32),
    )
    yield " with one axis more", array[None]


def with_field(noun, name, value):
    """A frozen noun with another field, unchecked."""
    changed = object.__new__(type(noun))
    changed.__dict__.update(noun.__dict__)
    changed.__dict__[name] = value
    return changed


def nouns(value):
    """All dataclasses that a value holds, one of each type, itself first."""
    found = {}

    def walk(at):
        if is_dataclass(at):
            found.setdefault(type(at), at)
            for field in fields(at):
                walk(getattr(at, field.name))
        elif isinstance(at, (tuple, list)):
            for item in at:
                walk(item)
        elif isinstance(at, Mapping):
            for item in at.values():
                walk(item)

    walk(value)
    return list(found.values())


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = write_toy(tmp_path_factory.mktemp("toy"), people=3, study=FULL)
    return load_study(path)


def test_a_study_holds_every_noun_that_its_numbers_rest_on(study):
    names = {type(noun).__name__ for noun in nouns(study)}
    assert names >= {
        "Allowance",
        "Body",
        "Change",
        "Control",
        "Coupling",
        "Criterion",
        "Detail",
        "Encumbrance",
        "Environment",
        "IntervalRule",
        "Layer",
        "MapTask",
        "PeopleDrawn",
        "Poses",
        "PostureGoals",
        "Rest",
        "Seat",
        "ShapeBasis",
        "Stops",
        "Study",
    }


def test_any_field_of_any_noun_changes_the_key(study, tmp_path):
    tried = set()
    for noun in nouns(study):
        before = key(noun)
        seen = {before}
        held = dict.fromkeys(field.name for field in fields(noun))
        for where, changed in ((w, c) for name in held for w, c in shallow(noun, name, tmp_path)):
            tried.add(f"{type(noun).__name__}{where}")
            now = key(changed)
            assert now not in seen, f"{type(noun).__name__}{where}"
            seen.add(now)
        assert key(with_field(noun, next(iter(held)), getattr(noun, next(iter(held))))) == before
    assert {"Stops.polygon[0] with one axis more", "Stops.play byte 0"} <= tried
    assert {
        "Coupling.limit[1]",
        "Coupling.driver_angle[0]",
        "Study.inputs[body of pilot]",
    } <= tried


def shallow(noun, name, folder):
    """Changes of one field; of a noun in it the first alone, since every type of noun has its own
    turn."""
    value = getattr(noun, name)
    found = other(value, folder)
    items = (
        value.values() if isinstance(value, Mapping) else value if isinstance(value, tuple) else ()
    )
    if any(is_dataclass(item) for item in (value, *items)):
        found = [next(found)]
    return [(f".{name}{where}", with_field(noun, name, changed)) for where, changed in found]


def test_values_that_only_look_alike_have_different_keys():
    values = [
        None,
        "",
        b"",
        (),
        [],
        {},
        0,
        0.0,
        False,
        "0",
        b"0",
        (0,),
        [0],
        ("0",),
        ((),),
        -0.0,
        {"a": 0},
        {"a": "0"},
        ("a", 0),
        ("ab", "c"),
        ("a", "bc"),
        ("abc",),
        np.zeros(0),
        np.zeros((0, 3)),
        np.zeros(1),
        np.int64(0),
        np.float64(0),
        np.zeros(1, dtype=">f8"),
        np.zeros(1, dtype=np.int64),
        StopKind.FREE,
        StopKind.CONE,
        frozenset(),
        frozenset({0}),
        {"a": 0, "b": 1},
        {"b": 1, "a": 0},
        np.zeros((1, 1)),
        float("nan"),
        FittedChunk({}, []),
        FittedChunk({"a": np.zeros(1)}, []),
    ]
    assert len({key(value) for value in values}) == len(values)
    assert (
        len(
            {
                content_key("one"),
                content_key("two"),
                content_key("one", None),
                content_key("one", None, None),
            }
        )
        == 4
    )


def test_equal_values_have_equal_keys_whatever_memory_they_lie_in():
    array = np.arange(12.0).reshape(3, 4)
    assert key(array) == key(np.asfortranarray(array)) == key(np.repeat(array, 2, axis=1)[:, ::2])
    assert key(frozenset({"a", "b", "c"})) == key(frozenset({"c", "b", "a"}))


@dataclass(frozen=True)
class Odd:
    value: object


@pytest.mark.parametrize(
    "value", [object(), lambda: 0, 1j, slice(1), np.array([object()]), range(3), dict, Odd(object)]
)
def test_what_is_not_known_is_an_error_and_not_left_out(value):
    with pytest.raises(TypeError, match="no key can be made from"):
        key((1, {"a": Odd(value)}))


def test_a_file_counts_by_its_bytes_and_not_by_its_name(tmp_path):
    for name, text in (("a", "one"), ("b", "one"), ("c", "two")):
        (tmp_path / name).write_text(text)
    assert key(tmp_path / "a") == key(tmp_path / "b") != key(tmp_path / "c")
    with pytest.raises(wb.InputError, match=r"gone: cannot be read \(No such file"):
        key(tmp_path / "gone")


def test_any_change_of_the_program_is_another_program(tmp_path):
    folder = tmp_path / "package"
    (folder / "inner" / "__pycache__").mkdir(parents=True)
    (folder / "__init__.py").write_text("one = 1\n")
    (folder / "inner" / "table.csv").write_text("1, 2\n")
    found = [program_hash(folder)]
    for change in (
        lambda: (folder / "__init__.py").write_text("one = 2\n"),
        lambda: (folder / "inner" / "table.csv").write_text("1, 3\n"),
        lambda: (folder / "inner" / "new.py").write_text(""),
        lambda: (folder / "inner" / "new.py").rename(folder / "new.py"),
        lambda: (folder / "inner" / "__pycache__" / "new.pyc").write_text("compiled"),
    ):
        change()
        program_hash.cache_clear()
        found.append(program_hash(folder))
    assert len(set(found[:-1])) == len(found) - 1 and found[-1] == found[-2]


def test_versions_of_libraries_belong_to_the_program(tmp_path, monkeypatch):
    found = set()
    for number in ("1.0", "1.1"):
        monkeypatch.setattr("workbench.model.content.version", lambda name, number=number: number)
        program_hash.cache_clear()
        found.add(program_hash(tmp_path))
    program_hash.cache_clear()
    assert len(found) == 2


def test_where_people_sit_is_a_matter_of_seat_pedals_points_and_people_alone(study):
    place = population_question(study).place

    def seating(room):
        return key(seating_of(replace(place, environment=room), 0))

    room = place.environment
    base = seating(room)
    same = [
        replace(room, controls=()),
        replace(room, vertices=room.vertices + 0.1),
        replace(room, allowances=()),
    ]
    assert all(seating(one) == base for one in same)
    seat = replace(room.seats[0], travel_up=(0.0, 0.03))
    assert seating(replace(room, seats=(seat,))) != base
    assert seating(replace(room, points={"eye": (0.1, 0.0, 1.06)})) != base


STOPS = """
study: toy_crew
length: mm
environment: toy
people:
  pilot: {body: edited, detail: coarse, seat: pilot, population: {people: PEOPLE, seed: 3}}
cases:
  - {name: sitting, people: {pilot: {predicted: {eyes: eye, hands: {right: knob}}}}}
criteria:
  - {name: elbow room, check: clearance, segments: [RUA, RLA], parts: [roof], at_least: 0}
  - {name: joints, check: stops}
"""
EDITS = {
    "polygon": (
        "[[0, 105], [15, 108], [45, 100], [90, 90], [112, 105], [135, 118], [160, 110], [180, 100]",
        "[[0, 45], [15, 48], [45, 40], [90, 40], [112, 45], [135, 48], [160, 50], [180, 40]",
    ),
    "coupling": (
        "{limit: medial_rotation, driver: RS.abduction, from: [0, 90], to: [97, 70]}",
        "{limit: medial_rotation, driver: RS.abduction, from: [0, 90], to: [1, 2]}",
    ),
    "play": ("play: 2", "play: 2.5"),
}


def margins(path, keep):
    """The numbers of all chunks, and how many people had to be worked on."""
    crowd = crowd_of(path)
    said = []
    chunks = result_chunks(
        crowd.question, crowd.bodies, keep=keep, tell=lambda *done: said.append(done)
    )
    names = ("margin", "reason", "toward", "seat")
    return [[getattr(c, n).tobytes() for n in names] + [c.words] for c in chunks], said[0]


LATER = pytest.mark.nightly


@pytest.mark.parametrize(
    "edit", ["polygon", pytest.param("coupling", marks=LATER), pytest.param("play", marks=LATER)]
)
def test_a_run_that_goes_on_after_the_joint_stops_were_edited_equals_a_fresh_one(
    tmp_path, monkeypatch, edit
):
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 1)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    path = write_toy(tmp_path, people=2, study=STOPS, knob=200)
    body, postures = (tmp_path / "bodies" / name for name in ("edited.yaml", "human_postures.yaml"))
    body.parent.mkdir()
    straight = "LE RE: {flexion: 65}"
    crooked = "LE RE: {flexion: 65, abduction: 3}"
    postures.write_text((ROOT / "bodies" / postures.name).read_text().replace(straight, crooked))
    text = (ROOT / "bodies" / "adult_male.yaml").read_text()
    body.write_text(text)
    keep = tmp_path / "keep"
    before, _ = margins(path, keep)
    sorted(keep.glob("*.chunk"))[1].unlink()  # cut off after the first chunk
    assert margins(path, keep) == (before, (0, 1))
    old, new = EDITS[edit]
    assert old in text
    body.write_text(text.replace(old, new))
    resumed, said = margins(path, keep)
    assert said == (0, 2)
    assert resumed == margins(path, None)[0] != before
