"""The saved state that the live bench shows see-through beside what is."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from workbench.errors import InputError
from workbench.live.desk import Desk
from workbench.live.looking import SavedState
from workbench.live.protocol import parsed, unpacked
from workbench.model.surroundings import Move, displaced
from workbench.study.bench.edits import shifted

ROLES = ("pilot", "instructor")


@pytest.fixture
def desk(tmp_path):
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    return Desk(str(path))


def done(desk, verb, **given):
    """Do what is asked, and take the answer to it."""
    replies = desk.do(parsed(json.dumps({"n": 3, "do": verb, **given})))
    head, arrays = unpacked((replies.everybody or replies.asker)[-1])
    assert head["kind"] != "fault", head["words"]
    return head, arrays


def ghost_of(desk):
    work = desk.do(parsed('{"n": 3, "do": "ghost"}')).work
    assert work.generation is None  # it is made however often the state is another meanwhile
    (frame,) = work.made().frames
    return unpacked(frame)


def bent(desk, degrees, **more):
    return done(desk, "joint", person="pilot", joint="RE", axis=0, degrees=degrees, **more)


def test_the_ghost_is_where_a_run_of_the_saved_study_puts_everybody(desk):
    bent(desk, 40.0)
    done(desk, "seat", person="pilot", forward=0.03, up=0.0)
    done(desk, "size", person="instructor", sex="female", percentiles={"stature": 5})
    done(desk, "save")
    bent(desk, 90.0)
    done(desk, "size", person="instructor", sex="male", percentiles={"stature": 50})
    done(desk, "seat", person="pilot", forward=0.0, up=0.0)
    (found,) = wb.run(wb.load_study(str(desk.path))).postures
    for case, name in enumerate(desk.opened.cases):
        done(desk, "case", name=name)
        head, arrays = ghost_of(desk)
        assert head["case"] == name
        for row, person in enumerate(found.people):
            centres = person.placed.centres[case]
            assert arrays[f"centres{row}"] == pytest.approx(centres.ravel(), abs=1e-6)
            radius = person.placed.body.radius[0]
            assert arrays[f"radius{row}"] == pytest.approx(radius, abs=1e-7)
    seat = {name: by for name, by in head["shifts"].items() if name.startswith("left_seat")}
    assert seat and all(np.linalg.norm(by) == pytest.approx(0.03, abs=1e-3) for by in seat.values())


def alike(desk):
    """Whether the ghost is the present, as an answer has it."""
    _, ghost = ghost_of(desk)
    head, present = done(desk, "case", name=desk.opened.cases[desk.live.case])
    there = ghost_of(desk)[0]
    same = [there[name] == head[name] for name in ("shifts", "moves", "controls")]
    for row in range(len(ROLES)):
        off = np.abs(ghost[f"centres{row}"] - present[f"centres{row}"]).max()
        same.append(off < 1e-5 and np.array_equal(ghost[f"radius{row}"], present[f"radius{row}"]))
    return all(same)


def test_once_all_is_undone_or_saved_the_ghost_is_the_present(desk):
    assert alike(desk)
    bent(desk, 40.0)
    done(desk, "seat", person="pilot", forward=0.03, up=0.0)
    done(desk, "move", parts=["throttle_lever"], by=[0.02, 0.0, 0.0])
    done(desk, "move", controls=["flaps"], by=[0.0, 0.0, 0.01])
    assert not alike(desk)
    for _ in range(4):
        done(desk, "undo")
    assert alike(desk)
    for _ in range(4):
        done(desk, "redo")
    assert not alike(desk)
    done(desk, "save")
    assert alike(desk)
    done(desk, "undo")
    assert not alike(desk)


def test_a_drag_does_not_change_the_ghost(desk):
    before = ghost_of(desk)
    bent(desk, 40.0, done=False)
    after = ghost_of(desk)
    assert before[0] == after[0]
    for name, values in before[1].items():
        assert np.array_equal(values, after[1][name])


def corners_of(environment, name):
    """(V, 3) the corners of a part."""
    mine = environment.polygon_part == environment.part_index(name)
    rows = environment.triangles[np.repeat(mine, np.diff(environment.triangle_start))]
    return environment.vertices[np.unique(rows)]


def test_a_part_of_another_shape_in_the_picture_comes_with_its_own(desk):
    opened = desk.opened
    environment = opened.study.environment
    lever = ("throttle_lever",)
    shown = displaced(environment, (Move(lever, (), (0.02, 0.0, 0.0)),), ())  # as if adjusted
    moved = shifted(opened, opened.start, Move(lever, (), (0.0, 0.0, 0.03))).arrangement
    for saved, by in ((opened.start, 0.0), (moved, 0.03)):
        (frame,) = SavedState(opened, saved, shown).made().frames
        head, arrays = unpacked(frame)
        assert head["adjusted"] == [*lever]
        corners = arrays["vertices"].reshape(-1, 3)
        own = corners_of(environment, *lever) + np.array([0.0, 0.0, by])
        assert np.ptp(corners, axis=0) == pytest.approx(np.ptp(own, axis=0), abs=1e-6)
        assert corners.min(axis=0) == pytest.approx(own.min(axis=0), abs=1e-6)
        assert max(arrays["triangles"].max(), arrays["edges"].max()) < len(corners)


def test_of_motions_alone_the_ghost_is_what_was_moved():
    desk = Desk("trainer_crash")
    head, arrays = ghost_of(desk)
    assert (head["case"], head["moves"], list(arrays)) == ("", [], [])


def test_the_ghost_takes_nothing_that_could_be_wrong():
    with pytest.raises(InputError, match="ghost takes no 'case'"):
        parsed('{"do": "ghost", "case": "cruise"}')
