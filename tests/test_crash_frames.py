"""What the frames of a crash give equals what every segment against every part gives, to the last
bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.test_crash import BODY, PLATE, STUDY, standing
from workbench import episodes, load_study
from workbench.contact import batches
from workbench.contact.collide import allowed_depth, allowed_groups, nearest
from workbench.files.motions.tables import angle_table_text
from workbench.model.joint_angles import poses_at
from workbench.study.crash.crash import environment_meetings
from workbench.study.crash.frames import force_curves, frames_of, ruled_pairs
from workbench.study.motion_cases import motion_cases

PIT = """environment: pit
length: mm
meshes: [{file: pit.obj, length: m, up: z, forward: x}]
parts:
  ghost: {hidden: true}
  soft: {allow: [{segments: all, depth: 15}]}
  step: {allow: [{segments: all, depth: 15}]}
"""
FORCES = """contact_forces:
  - {parts: ["*"], stiffness: 20}
  - {parts: [step], segments: [LF], stiffness: 5, returned: 0.5}
criteria:
"""


def box(name, low, high, first):
    """A box as text of an OBJ file, its vertices numbered from `first`."""
    (a, b, c), (x, y, z) = low, high
    corners = [
        (a, b, z),
        (x, b, z),
        (x, y, z),
        (a, y, z),
        (a, b, c),
        (x, b, c),
        (x, y, c),
        (a, y, c),
    ]
    faces = [
        [int(v) + first - 1 for v in line.split()[1:]]
        for line in PLATE.splitlines()
        if line.startswith("f ")
    ]
    lines = [
        f"o {name}",
        *(f"v {p} {q} {r}" for p, q, r in corners),
        *(f"f {' '.join(map(str, f))}" for f in faces),
    ]
    return "\n".join(lines) + "\n"


@pytest.fixture(params=[20, 150], ids=["few frames", "many frames"])
def study(tmp_path, request):
    """A man sinks into two plates and a step that bears; two of them allow him 15 mm."""
    time = np.linspace(0, 0.2, request.param)
    (tmp_path / "environments/pit").mkdir(parents=True)
    (tmp_path / "environments/pit/pit.obj").write_text(
        box("hard", (-2, 0, -1), (2, 2, 0), 1)
        + box("soft", (-2, -2, -1), (2, 0, 0), 9)
        + box("step", (0.1, -1, -0.5), (0.6, 1, 0.02), 17)
        + box("ghost", (-1, -1, -0.5), (1, 1, 0.3), 25)
        + box("wall", (-1, -1, 3), (1, 1, 3.1), 33)
    )
    (tmp_path / "environments/pit/environment.yaml").write_text(PIT)
    (tmp_path / "studies").mkdir()
    moving = standing(0.1 - 0.14 * np.sin(np.linspace(0, np.pi, request.param)), time)
    (tmp_path / "studies/drop.csv").write_text("".join(angle_table_text(BODY, moving)))
    path = tmp_path / "studies/drop.yaml"
    path.write_text(STUDY.replace("criteria:\n", FORCES))
    ready = motion_cases(load_study(path))[0]
    return replace(ready, bears=np.array([part == "step" for part in ready.environment.parts]))


def test_grouped_frames_equal_every_segment_against_every_part_to_the_last_bit(study):
    frames = frames_of(study)
    pairs = ruled_pairs(study)
    apart = wb.clearance(wb.place(study.body, study.motion), study.environment)
    allowed = allowed_depth(study.body, study.environment)
    assert frames.clearance.tobytes() == (apart + allowed).min(axis=2).tobytes()
    wanted = force_curves(study, pairs, apart[:, pairs[:, 0], pairs[:, 1]])
    found = force_curves(study, pairs, frames.gaps)
    assert {curve.part for curve in wanted} == {"hard", "soft", "step"}
    assert [(c.segment, c.part, c.force.tobytes()) for c in found] == [
        (c.segment, c.part, c.force.tobytes()) for c in wanted
    ]
    asked = np.isfinite(frames.gaps)
    assert np.array_equal(frames.gaps[asked], apart[:, pairs[:, 0], pairs[:, 1]][asked])
    assert 0 < asked.mean() < 0.5


def test_meetings_are_those_of_the_whole_environment(study):
    found = episodes(study.body, study.motion, study.environment)
    assert len(found) > 3
    for row, meeting in enumerate(environment_meetings(study, found)):
        at = poses_at(study.motion, [float(found.deepest[row])])
        whole = nearest(wb.place(study.body, at), study.environment)
        where = (0, int(found.segment[row]), int(found.part[row]))
        assert meeting.point == tuple(whole.point[where].tolist())
        assert meeting.began or meeting.who


def test_a_crash_makes_one_index_of_as_many_groups_as_there_are_allowances(study, monkeypatch):
    asked = []
    made = batches.build_distance_field

    def counted(environment, groups, **options):
        asked.append(groups)
        return made(environment, groups, **options)

    monkeypatch.setattr(batches, "build_distance_field", counted)
    found = episodes(study.body, study.motion, study.environment)
    frames_of(study)
    list(environment_meetings(study, found))
    groups = allowed_groups(study.body, study.environment)[0]
    assert len(groups) == 2
    assert set(asked) == ({groups} if batches.pays(study.motion) else set())
