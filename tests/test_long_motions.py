"""Long motions: pieces give the bits that the whole gives, contacts go on from piece to piece,
memory stays bounded."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import workbench as wb
from tests.test_crash import BODY, drop, standing
from workbench.contact import episodes as solve_episodes
from workbench.files.motions import bvh, opensim, tables
from workbench.files.motions.bvh import bvh_text
from workbench.files.motions.tables import angle_table_text
from workbench.model import arrays
from workbench.model import poses as model_poses
from workbench.model.arrays import read_only
from workbench.model.joint_angles import motion_of
from workbench.report.motions import movement_summary
from workbench.report.motions import rows as motion_rows
from workbench.report.motions.rows import motion_tables
from workbench.report.result_rows import result_file
from workbench.study import motions
from workbench.study.crash import crash, frames
from workbench.study.motions import load_motion

__all__ = ["drop"]

CUT = [bvh, opensim, tables, model_poses, movement_summary, crash, motion_rows, frames, motions]


def bouncing(frames=700):
    """Arms that swing and a body that meets the plate six times, every 100 frames or so; elbows
    past their stops."""
    time = np.arange(frames) / 200
    angles = np.zeros((frames, len(BODY.joints), 3))
    for joint, size in (("RS", 60), ("LE", 75), ("LK", 40)):
        axis, sign = motion_of(BODY, BODY.joint(joint), "flexion")
        angles[:, BODY.joint(joint), axis] = sign * np.radians(size * (1 - np.cos(7 * time)))
    return standing(0.02 * np.sin(2 * np.pi * time / 0.55), time, angles=angles)


@pytest.fixture
def small_pieces(monkeypatch):
    """Make every piece `size` frames long, packed and spooled beyond a kilobyte."""

    def cut(size):
        def pieces(count, *, size=size):
            yield from (slice(k, min(k + size, count)) for k in range(0, count, size))

        for module in CUT:
            monkeypatch.setattr(module, "pieces", pieces)
        monkeypatch.setattr(frames, "BLOCK", size)
        monkeypatch.setattr(crash, "BLOCK", size)
        monkeypatch.setattr(arrays, "IN_MEMORY", 1024)
        monkeypatch.setattr(solve_episodes, "MOST_PACKED", solve_episodes.PIECE)

    return cut


def text_of(result):
    rows = result_file(result)
    return rows.model_dump_json() + "".join(
        "".join(table.csv_parts()) for table in motion_tables(result.motions, rows).values()
    )


def test_a_crash_study_in_pieces_is_the_whole_one_bit_for_bit(drop, small_pieces):
    """Frames, contacts, stops, signals and words; contacts and spells that go on across pieces
    too."""
    (drop.parent / "drop.csv").write_text("".join(angle_table_text(BODY, bouncing())))
    result = wb.run(wb.load_study(drop))
    whole = result.motions[0]
    text = text_of(result)
    assert len(whole.meetings) > 4 and len(whole.breaches) > 1
    held = [m for m in whole.meetings if int(m.enter * 200) // 128 != int(m.leave * 200) // 128]
    assert held
    small_pieces(37)
    again = wb.run(wb.load_study(drop))
    pieced = again.motions[0]
    assert np.array_equal(pieced.clearance, whole.clearance)
    assert pieced.meetings == whole.meetings and pieced.breaches == whole.breaches
    assert text_of(again) == text


@pytest.mark.parametrize("ending", ["csv", "bvh"])
def test_a_motion_read_in_pieces_has_the_bits_of_the_whole(tmp_path, ending, small_pieces):
    motion = bouncing(150)
    text = (
        angle_table_text(BODY, motion)
        if ending == "csv"
        else bvh_text(BODY, motion, [wb.place(BODY, motion)])
    )
    path = tmp_path / f"m.{ending}"
    path.write_text("".join(text))
    options = motions.MotionOptions(
        names={s: s for s in BODY.segments[1:]} if ending == "bvh" else None, yaw=0.3
    )
    whole, notes = load_motion(BODY, path, options=options)
    table = "".join(angle_table_text(BODY, whole))
    sentences = movement_summary.movement_sentences(BODY, whole)
    for size in (1, 64):
        small_pieces(size)
        found, said = load_motion(BODY, path, options=options)
        assert said == notes
        assert np.array_equal(found.time, whole.time)
        assert np.array_equal(found.rotations, whole.rotations)
        assert np.array_equal(found.world_from_reference, whole.world_from_reference)
        assert "".join(angle_table_text(BODY, found)) == table
        assert movement_summary.movement_sentences(BODY, found) == sentences


def test_rows_beyond_the_memory_allowed_are_in_a_file_and_stay_what_they_are(monkeypatch):
    monkeypatch.setattr(arrays, "IN_MEMORY", 100)
    rows = np.arange(60.0).reshape(20, 3)
    kept = arrays.GrowingArray(3)
    for first in range(0, 20, 6):
        kept.add(rows[first : first + 6])
    done = kept.done()
    assert np.array_equal(done, rows)
    assert not done.flags.writeable and not done.flags.owndata
    assert read_only(done, np.float64, (20, 3), "rows") is done
    assert arrays.GrowingArray(2).done().shape == (0, 2)


LONG = """
import resource, sys
from pathlib import Path
from workbench.cli import main
resource.setrlimit(resource.RLIMIT_DATA, (1_500_000_000,) * 2)
for command in {commands!r}:
    assert main(command) in (0, 1), command
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def long_table(path, frames):
    """A seated man who rocks, `frames` frames at 1 kHz."""
    text = "".join(angle_table_text(BODY, bouncing(700))).splitlines(keepends=True)
    head = next(k for k, line in enumerate(text) if line.startswith("time"))
    rows = [line.partition(", ")[2] for line in text[head + 1 :]]
    with path.open("w") as file:
        file.writelines(text[: head + 1])
        file.writelines(f"{k / 1000:.3f}, {rows[k % len(rows)]}" for k in range(frames))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("frames", "commands"),
    [
        (
            1_000_000,
            [["motion", "show", "long.csv"], ["motion", "convert", "long.csv", "-o", "out.bvh"]],
        ),
        (100_000, [["run", "study.yaml", "--out", "out"]]),
    ],
)
def test_memory_is_bounded_however_long_a_motion_is(drop, frames, commands):
    """Private memory is limited by the system: what does not fit into 1.5 GB ends the process."""
    folder = drop.parent
    long_table(folder / "long.csv", frames)
    drop.rename(folder / "study.yaml")
    (folder / "study.yaml").write_text(
        (folder / "study.yaml").read_text().replace("drop.csv", "long.csv")
    )
    done = subprocess.run(
        [sys.executable, "-c", LONG.format(commands=commands)],
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | {"TMPDIR": str(folder)},
    )
    assert done.returncode == 0, done.stderr[-2000:]
