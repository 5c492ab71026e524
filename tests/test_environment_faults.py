"""All that is wrong in an environment's file and can be told on its own is told at once."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.made_seat import obj_text, seat_parts
from workbench.errors import InputError
from workbench.files.environments import load_environment

CAB = """environment: cab
length: mm
meshes: [{file: cab.obj, length: m, up: z, forward: x}]
parts: {lever: {see_through: false}}
seats:
  driver:
    srp: [100, 200, 300]
    cushion_angle: 10
    back_angle: 20
    cushion: {part: pan, segments: [LT], depth: 20}
    back: {part: rest, segments: [LT], depth: 20}
    moves: [pan, rest]
controls:
  brake: {at: [620, 20, 500], part: lever, grip: grasp, zone: 1}
adjustments:
  wheel: {parts: [lever], along: [1, 0, 0], travel: [0, 50]}
"""
FAULTS = {
    "parts: {lever": ("parts: {levr", "parts.levr: no part 'levr'; did you mean 'lever'"),
    "moves: [pan": ("moves: [pane", "seats.driver.moves[0]: no part 'pane'"),
    "{part: rest": ("{part: rast", "seats.driver.back.part: no part 'rast'"),
    ", part: lever": (", part: [lever, leever]", "controls.brake.part[1]: no part 'leever'"),
    "zone: 1}": ("zone: 9}", "controls.brake.zone: input should be less than or equal to 3"),
    "grip: grasp": ("grib: grasp", "controls.brake.grib: unknown key 'grib'; did you mean 'grip'"),
    "back_angle: 20": ("back_angel: 20", "seats.driver.back_angel: unknown key"),
    "parts: [lever]": ("parts: [lefer]", "adjustments.wheel.parts[0]: no part 'lefer'"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    home = tmp_path_factory.mktemp("cab")
    (home / "cab.obj").write_text(obj_text(seat_parts()))
    return home


@settings(max_examples=30)
@given(wrong=st.sets(st.sampled_from(sorted(FAULTS)), min_size=1))
def test_every_fault_is_told_whatever_else_is_wrong(folder, wrong):
    text = CAB
    for old in wrong:
        text = text.replace(old, FAULTS[old][0], 1)
    (folder / "environment.yaml").write_text(text)
    with pytest.raises(InputError) as raised:
        load_environment(folder)
    said = raised.value.problems
    for old in wrong:
        new, words = FAULTS[old]
        (line,) = [one for one in said if words in one]
        row = text[: text.index(new)].count("\n") + 1
        assert re.match(rf".*environment\.yaml:{row}:\d+: ", line)
    # a key that is misspelt is missing too; nothing else is told
    assert len(said) == len(wrong) + len(wrong & {"grip: grasp", "back_angle: 20"})


def test_a_mesh_that_is_not_there_is_told_beside_a_wrong_key(folder):
    text = CAB.replace("file: cab.obj", "file: cub.obj").replace("zone: 1", "zone: 9")
    (folder / "environment.yaml").write_text(text)
    with pytest.raises(InputError) as raised:
        load_environment(folder)
    zone, mesh = raised.value.problems
    assert "zone" in zone
    assert "environment.yaml:3:11: meshes[0].file" in mesh
