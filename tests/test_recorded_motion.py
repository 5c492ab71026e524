"""A recorded motion against a reader of its own: a stack of 4 x 4 matrices, written for this test
alone."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import SHARED, real_input
from tests.whole_motions import read_bvh
from workbench.files.motions.number_rows import FrameRange
from workbench.motion.recorded.skeleton import bone_positions

JUMP = SHARED / "motion" / "bvh" / "01_01.bvh"


def turned(axis, degrees):
    matrix, (c, s) = np.eye(4), (np.cos(np.radians(degrees)), np.sin(np.radians(degrees)))
    i, j = [(1, 2), (2, 0), (0, 1)]["XYZ".index(axis)]
    matrix[i, i] = c
    matrix[i, j] = -s
    matrix[j, i] = s
    matrix[j, j] = c
    return matrix


def positions(text, frame):
    """Joint names and where they stand (B, 3) in one frame, word by word from the text."""
    head, rows = text.split("MOTION")
    numbers = iter(float(word) for word in rows.splitlines()[3 + frame].split())
    words = head.split()
    stack = [np.eye(4)]
    found = {}
    world = np.eye(4)
    name = ""
    ending = False
    while words:
        word = words.pop(0)
        if word in ("ROOT", "JOINT"):
            name = words.pop(0)
            ending = False
        elif word == "End":
            ending = True
        elif word == "{":
            stack.append(world)
        elif word == "}":
            world = stack.pop()
            ending = False
        elif word == "OFFSET":
            offset = np.array([float(words.pop(0)) for _ in range(3)])
            if not ending:
                world = stack[-1].copy()
                world[:3, 3] += world[:3, :3] @ offset
                found[name] = world[:3, 3].copy()
        elif word == "CHANNELS":
            channels = [words.pop(0) for _ in range(int(words.pop(0)))]
            step = np.eye(4)
            for channel in channels:
                if channel.endswith("position"):
                    step["XYZ".index(channel[0]), 3] += next(numbers)
                else:
                    step = step @ turned(channel[0], next(numbers))
            if any(channel.endswith("position") for channel in channels):
                world = stack[-1].copy()  # positions stand in place of the offset
            world = world @ step
            found[name] = world[:3, 3].copy()
    return tuple(found), np.array(list(found.values()))


@pytest.mark.parametrize("frame", [0, 700, 1500, 2751])
def test_joints_of_a_recorded_jump_are_where_another_reader_finds_them(frame):
    real_input(JUMP)
    bones = read_bvh(JUMP)
    names, wanted = positions(JUMP.read_text(), frame)
    assert names == bones.names
    np.testing.assert_allclose(bone_positions(bones)[frame], wanted, atol=1e-9)


def test_bones_of_a_recorded_jump_keep_their_lengths():
    real_input(JUMP)
    bones = read_bvh(JUMP, keep=FrameRange(every=25))
    at = bone_positions(bones)
    parent = np.asarray(bones.parent)
    child = np.flatnonzero(parent >= 0)
    lengths = np.linalg.norm(at[:, child] - at[:, parent[child]], axis=2)
    assert np.ptp(lengths, axis=0).max() < 1e-9
