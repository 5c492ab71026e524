"""The population beside the bench: settled as a run does it, followed while something is moved."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from workbench.errors import InputError
from workbench.files.study.saving import read_text
from workbench.live.following import COARSE, Following
from workbench.live.protocol import parsed, unpacked
from workbench.model.accommodation import met_of
from workbench.model.surroundings import Move
from workbench.study.bench.criteria import PairLimit, asked_for
from workbench.study.bench.crowd import crowd_question, met_all, open_crowd, settled
from workbench.study.bench.crowd_followed import followed
from workbench.study.bench.edits import seated, shifted
from workbench.study.bench.saving import save
from workbench.study.bench.state import open_study

TEXT = (ROOT / "studies" / "trainer_accommodation.yaml").read_text()
FEW = 6


def few_people(folder, *, but=("shares:", "reach_maps:")):
    """The study of the catalogue with few people and controls, without the lines that begin so."""
    path = folder / "few.yaml"
    text = re.sub(r"  - {name: switches and radios.*?}\n", "", TEXT, flags=re.DOTALL)
    lines = [line for line in text.split("\n") if not line.startswith(but)]
    text = "\n".join(lines).replace("people: 200, seed: 1", f"people: {FEW}, seed: 5")
    assert f"people: {FEW}" in text
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return few_people(tmp_path_factory.mktemp("people"))


@pytest.fixture(scope="module")
def opened(path):
    return open_study(wb.load_study(path))


@pytest.fixture(scope="module")
def crowd(opened):
    return open_crowd(opened)


@pytest.fixture(scope="module")
def start(opened, crowd):
    question = crowd_question(opened, crowd, opened.start)
    return settled(crowd, question, opened.start, np.sort(crowd.order))


def moved(opened, parts, controls, by):
    return shifted(opened, opened.start, Move(parts, controls, by)).arrangement


def asked_of_everybody(opened):
    """A clearance made of a pair at the bench."""
    limit = PairLimit("pilot", "RUL", part="instrument_panel", at_least=0.03)
    return asked_for(opened, opened.start, limit).arrangement


STATES = {
    "a criterion": asked_of_everybody,
    "a control": lambda opened: moved(opened, (), ("flaps",), (-0.35, 0.1, 0.0)),
    "a part": lambda opened: moved(opened, ("canopy", "canopy_frame"), (), (0.0, 0.0, -0.04)),
    "a lever": lambda opened: moved(opened, ("throttle_lever",), (), (0.08, 0.0, 0.0)),
    "the seat": lambda opened: seated(opened, opened.start, "pilot", 0.02, 0.01).arrangement,
}


@pytest.mark.parametrize("what", STATES)
def test_people_who_are_settled_are_those_of_a_run_of_the_saved_study(
    opened, crowd, start, path, what
):
    arrangement = STATES[what](opened)
    found = settled(
        crowd, crowd_question(opened, crowd, arrangement), arrangement, start.rows, start
    )
    before = path.read_bytes()
    try:
        save(opened, read_text(path), arrangement)
        run = wb.run(wb.load_study(path)).population
    finally:
        path.write_bytes(before)
    assert np.array_equal(found.rows, np.arange(FEW))
    met = run.margin >= -1e-6
    assert np.array_equal(met_all(found.margin), (met | np.isnan(run.margin)).all(axis=1))
    names = [one.requirement.name for one in found.question.asked]
    assert names == [one.name for one in run.requirements]
    assert np.nanmax(np.abs(found.margin - run.margin)) < 1e-9
    assert not np.array_equal(found.margin, start.margin)


def test_a_criterion_made_of_a_pair_is_asked_of_everybody_where_they_sit(opened, crowd, start):
    arrangement = asked_of_everybody(opened)
    question = crowd_question(opened, crowd, arrangement)
    found = followed(opened, crowd, start, question, arrangement)
    exact = settled(crowd, question, arrangement, start.rows)
    assert found.margin.shape == (FEW, start.margin.shape[1] + 1) and found.known.all()
    assert np.array_equal(found.margin[:, :-1], start.margin, equal_nan=True)
    stays = (exact.fitted.tried.seat == start.fitted.tried.seat).all(axis=1)
    assert stays.any() and found.margin[stays, -1] == pytest.approx(exact.margin[stays, -1])
    following = Following(opened)
    following.begin()
    following.settle(0, opened.start, 1)
    assert following.follow(0, arrangement, 2)
    head, _ = unpacked(following.frame(2))
    new = [row for row in head["rows"] if row["was"] is None]
    assert [row["name"] for row in new] == [arrangement.added[0].name]


VIEW = """
  - {name: over the nose, check: over_nose, down: 12}
  - {name: fuel selector in sight, check: sees, controls: [fuel_selector], at_least: 50}
  - {name: tachometer in sight, check: sees, instruments: [tachometer], at_least: 80}
"""


@pytest.fixture(scope="module")
def view(tmp_path_factory):
    """Three people who are asked what they see, settled; the fuel selector is a point."""
    path = tmp_path_factory.mktemp("view") / "view.yaml"
    text = (ROOT / "studies" / "trainer_view.yaml").read_text()
    path.write_text(
        text.split("criteria:")[0].replace("people: 200", "people: 3") + "criteria:" + VIEW
    )
    study = wb.load_study(path)
    controls = study.environment.controls
    points = [replace(one, part="") if one.name == "fuel_selector" else one for one in controls]
    opened = open_study(
        replace(study, environment=replace(study.environment, controls=tuple(points)))
    )
    crowd = open_crowd(opened)
    question = crowd_question(opened, crowd, opened.start)
    return opened, crowd, settled(crowd, question, opened.start, np.sort(crowd.order))


@pytest.mark.parametrize(
    ("parts", "controls", "by", "changed"),
    [
        ((), ("fuel_selector",), (0.0, 0.0, 0.05), ["see fuel_selector"]),  # off its own lever
        (("coaming",), (), (-0.1, 0.0, 0.15), ["over the nose"]),
    ],
)
def test_what_people_see_while_a_part_or_control_is_dragged_is_what_they_see_where_it_rests(
    view, parts, controls, by, changed
):
    opened, crowd, start = view
    arrangement = moved(opened, parts, controls, by)
    question = crowd_question(opened, crowd, arrangement)
    names = [one.requirement.name for one in question.asked]
    found = followed(opened, crowd, start, question, arrangement)
    exact = settled(crowd, question, arrangement, start.rows)
    stays = (exact.fitted.tried.seat == start.fitted.tried.seat).all(axis=1)
    assert found.known.all() and stays.any()
    assert found.margin[stays] == pytest.approx(exact.margin[stays], abs=1e-9)
    differs = np.abs(found.margin - start.margin).max(axis=0) > 1e-6
    assert [name for name, one in zip(names, differs, strict=True) if one] == changed


def test_nobody_is_asked_again_where_nothing_has_moved(opened, crowd, start):
    question = crowd_question(opened, crowd, opened.start)
    found = followed(opened, crowd, start, question, opened.start)
    assert found.known.all()
    assert np.array_equal(found.margin, start.margin, equal_nan=True)


def test_a_moved_part_bears_on_what_is_about_it_alone(opened, crowd, start):
    arrangement = STATES["a part"](opened)
    question = crowd_question(opened, crowd, arrangement)
    found = followed(opened, crowd, start, question, arrangement).margin
    asked = question.asked
    other = np.array([not {"canopy", "canopy_frame"} & set(one.criterion.parts) for one in asked])
    assert np.array_equal(found[:, other], start.margin[:, other], equal_nan=True)
    exact = settled(crowd, question, arrangement, start.rows)
    same = (exact.fitted.tried.seat == start.fitted.tried.seat).all(axis=1)
    head = [one.requirement.name for one in asked].index("head to canopy")
    assert same.any()
    assert found[same, head] == pytest.approx(exact.margin[same, head], abs=1e-9)
    assert np.abs(found[:, head] - start.margin[:, head]).max() > 0.01


@settings(max_examples=3)
@given(
    st.sampled_from(["flaps", "propeller", "canopy_handle", "mixture"]),
    st.tuples(*[st.floats(-0.08, 0.08)] * 3),
)
def test_who_fits_while_a_control_is_dragged_fits_at_rest(opened, crowd, start, control, by):
    arrangement = moved(opened, (), (control,), by)
    question = crowd_question(opened, crowd, arrangement)
    quick = followed(opened, crowd, start, question, arrangement).margin
    exact = settled(crowd, question, arrangement, start.rows, start)
    assert not np.any(met_all(quick) & ~met_all(exact.margin))
    stays = (exact.fitted.tried.seat == start.fitted.tried.seat).all(axis=1)
    assert np.allclose(quick[stays], exact.margin[stays], atol=1e-9, equal_nan=True)


def at(opened, forward, up, control, by):
    """The seat held in a position, and a control moved."""
    held = seated(opened, opened.start, "pilot", forward, up).arrangement
    return shifted(opened, held, Move((), (control,), by)).arrangement


TRAVEL = st.tuples(st.floats(-0.1, 0.1), st.floats(-0.06, 0.06))


@settings(max_examples=2)
@given(
    st.lists(TRAVEL, min_size=2, max_size=2),
    st.sampled_from(["flaps", "throttle", "left_stick", "left_seat_left_pedal"]),
    st.tuples(*[st.floats(-0.08, 0.08)] * 3),
)
def test_who_fits_while_the_seat_is_dragged_is_who_does_in_a_run(
    opened, crowd, start, places, control, by
):
    held = seated(opened, opened.start, "pilot", 0.0, 0.0).arrangement
    followed(opened, crowd, start, crowd_question(opened, crowd, held), held)
    for forward, up in places:  # each follows from where the people were last
        arrangement = at(opened, *within(opened, forward, up), control, by)
        question = crowd_question(opened, crowd, arrangement)
        quick = followed(opened, crowd, start, question, arrangement, search=False)
        found = followed(opened, crowd, start, question, arrangement)
        exact = settled(crowd, question, arrangement, start.rows)
        assert found.known.all()
        assert np.array_equal(met_of(found.margin), met_of(exact.margin))
        assert np.array_equal(met_of(quick.margin)[quick.known], met_of(exact.margin)[quick.known])
        reach = np.array([one.control is not None for one in question.asked])
        assert np.allclose(
            found.margin[:, ~reach], exact.margin[:, ~reach], atol=1e-9, equal_nan=True
        )
        assert np.all(found.margin[:, reach] <= np.maximum(exact.margin[:, reach], 0.0) + 1e-9)


def within(opened, forward, up):
    """A position within the travel of the seat."""
    seat = opened.seat(opened.crowd)
    return np.clip(forward, *seat.travel_forward), np.clip(up, *seat.travel_up)


@pytest.mark.parametrize("control", ["throttle", "left_stick"])
def test_a_control_that_a_hand_holds_is_followed_with_that_hand(opened, crowd, start, control):
    arrangement = moved(opened, (), (control,), (0.03, 0.02, 0.02))
    question = crowd_question(opened, crowd, arrangement)
    found = followed(opened, crowd, start, question, arrangement).margin
    exact = settled(crowd, question, arrangement, start.rows)
    stays = (exact.fitted.tried.seat == start.fitted.tried.seat).all(axis=1)
    assert stays.any()
    assert np.allclose(found[stays], exact.margin[stays], atol=1e-9, equal_nan=True)
    shoulder = [one.requirement.name for one in question.asked].index("left shoulder to canopy")
    assert np.array_equal(found[:, shoulder], start.margin[:, shoulder]) == (control == "throttle")


def test_people_are_settled_piece_by_piece_and_followed_from_there(opened):
    following = Following(opened)
    assert following.frame(1) is None and following.at_hand == 0
    assert not following.follow(0, opened.start, 1)
    assert following.begin() is None and following.at_hand == 1
    assert not following.follow(0, opened.start, 1)
    assert following.settle(0, opened.start, 1) is None
    head, _ = unpacked(following.frame(1))
    assert (head["known"], head["settled"], head["of"]) == (FEW, FEW, FEW)
    assert head["changed"] == [] and len(head["rows"]) == 33
    assert following.frame(2) is None
    far = moved(opened, (), ("flaps",), (-0.9, 0.0, 0.0))
    assert following.follow(0, far, 2)
    head, _ = unpacked(following.frame(2))
    assert head["settled"] == 0 and head["shares"][0]["share"] == 0.0
    was = head["shares"][0]["was"]
    assert was > 0.5 and len(head["changed"]) == round(was * FEW)
    first = head["changed"][0]
    assert first["name"] == "reach flaps" and not first["fits"] and first["margin"] < 0
    assert following.settle(0, far, 2, superseded=lambda: True) is None
    assert unpacked(following.frame(2))[0]["settled"] == 0
    assert following.settle(0, far, 2) is None
    assert unpacked(following.frame(2))[0]["settled"] == FEW
    assert following.follow(0, opened.start, 3)
    head, _ = unpacked(following.frame(3))
    assert head["settled"] == FEW and head["changed"] == []


def map_of(frames):
    """The head of the one reach map among frames."""
    (head,) = [head for head, _ in map(unpacked, frames) if head["kind"] == "reach_map"]
    return head


def test_the_reach_map_beside_the_bench_is_that_of_a_run_of_the_saved_study(tmp_path):
    path = few_people(tmp_path, but=("shares:",))
    opened = open_study(wb.load_study(path))
    following = Following(opened)
    following.begin()
    following.settle(0, opened.start, 1)
    following.map(0, opened.start, 1, whole=True)
    first = map_of(following.frames(1))
    arrangement = seated(opened, opened.start, "pilot", -0.05, 0.0).arrangement
    panel = Move(("instrument_panel",), (), (0.05, 0.0, 0.02))
    arrangement = shifted(opened, arrangement, panel).arrangement
    assert following.follow(0, arrangement, 2)
    following.map(0, arrangement, 2, whole=False)
    coarse = map_of(following.frames(2))
    following.map(0, arrangement, 2, whole=True)
    whole = map_of(following.frames(2))
    save(opened, read_text(path), arrangement)
    (run,) = wb.run(wb.load_study(path)).population.maps
    assert first["whole"] and whole["whole"] and not coarse["whole"]
    wanted = dict(zip(map(tuple, np.round(1e3 * run.flat, 1).tolist()), run.share, strict=True))
    got = dict(zip(map(tuple, whole["points"]), whole["share"], strict=True))
    assert got == pytest.approx(wanted, abs=1e-4)
    assert len(coarse["points"]) == COARSE and coarse["people"] == FEW
    assert coarse["share"] == whole["share"][:COARSE]
    assert whole["share"] != first["share"]
    assert "nav_com_radio" in {name for name, *_ in whole["controls"]}


def test_a_population_of_which_nothing_is_asked_says_so(tmp_path):
    path = few_people(tmp_path)
    lines = path.read_text().split("\n")
    first = lines.index("criteria:")
    text = "\n".join(lines[: first + 1])
    path.write_text(f"{text}\n  - {{name: joints, check: stops, people: [guest]}}\n")
    text = path.read_text().replace(
        "people:\n  pilot:", "people:\n  guest: {body: adult_male, seat: right}\n  pilot:", 1
    )
    path.write_text(
        text.replace(
            "    people:\n      pilot:",
            "    people:\n      guest: {posture: driving}\n      pilot:",
        )
    )
    following = Following(open_study(wb.load_study(path)))
    frame, _ = unpacked(following.begin())
    assert "no criterion asks for anything" in frame["words"]
    assert unpacked(following.frame(1))[0]["words"] == frame["words"]


def test_a_study_without_a_population_has_nobody_to_follow():
    following = Following(open_study(wb.load_study("trainer_clearance")))
    assert not following.there and following.begin() is None and following.frame(1) is None


def test_the_page_gets_the_people_and_follows_a_move(path):
    pytest.importorskip("starlette", reason="the extra `live` is not installed")
    pytest.importorskip("httpx2", reason="Starlette's test client needs httpx2")
    from tests.test_live import client_of, entered, page_of
    from workbench.live.desk import Desk

    def people_until(page, fits):
        for _ in range(60):
            head, _ = unpacked(page.receive_bytes())
            if head["kind"] == "people" and not head["words"] and fits(head):
                return head
        raise AssertionError("no such frame")

    desk = Desk(str(path))
    with client_of(desk) as client, page_of(entered(client)) as page:
        first = people_until(page, lambda head: head["settled"] == FEW)
        question = {"n": 1, "do": "move", "controls": ["flaps"], "by": [0, 0, 0.03]}
        assert parsed(json.dumps(question)).done
        page.send_text(json.dumps(question))
        quick = people_until(page, lambda head: head["generation"] > first["generation"])
        assert quick["shares"][0]["was"] == first["shares"][0]["share"]
        last = people_until(page, lambda head: head["settled"] == FEW)
        assert last["generation"] == desk.generation and last["changed"] == []


def test_what_is_dragged_is_indexed_when_it_is_chosen(opened, tmp_path, monkeypatch):
    following = Following(opened)
    trim = Move(("trim_wheel",), (), (0.0, 0.0, 0.0))
    following.ready(opened.start, trim)  # no people yet
    following.begin()
    following.settle(0, opened.start, 1)
    before = following.frame(1)
    with pytest.raises(InputError, match="no part 'trimwheel'"):
        following.ready(opened.start, Move(("trimwheel",), (), (0.0, 0.0, 0.0)))
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path))
    following.ready(opened.start, trim)
    assert following.frame(1) == before
    indexed = sorted(tmp_path.iterdir())
    assert indexed
    assert following.follow(0, moved(opened, ("trim_wheel",), (), (0.0, 0.0, 0.02)), 2)
    assert sorted(tmp_path.iterdir()) == indexed


def test_people_who_were_made_ready_for_a_drag_of_the_seat_are_followed_as_others(opened, crowd):
    arrangement = seated(opened, opened.start, "pilot", 0.02, 0.0).arrangement
    frames = []
    for remembered in (True, False):
        following = Following(opened)
        following.begin()
        following.settle(0, opened.start, 1)
        if remembered:
            following.remember(0, (0.0, 0.0))
        assert following.follow(0, arrangement, 2)
        frames.append(following.frame(2))
    assert frames[0] == frames[1]
