"""What the benchmarks time is right: every case agrees with brute force, every other library with
this project, in tiny. Nothing is timed here."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from benchmarks import batches
from benchmarks.__main__ import PAGE
from benchmarks.cases import Case, in_cockpit, in_real_vehicle, opened, seated_in
from benchmarks.clearance import brute_force, by_segment, checked, segment_gap, winding
from benchmarks.commands import run_command
from benchmarks.peers import PEERS, asked_of_us
from benchmarks.people import bodies_of, everybody, margins_in_seat, share_of_fits, some_of
from benchmarks.table import GOALS, Row, Section, page, sections_of
from tests import oracles
from workbench.model.accommodation import met_of
from workbench.study.accommodation.accommodation import accommodation

MERGED = 1e-6
"""[m] Coplanar triangles are merged where they are flat within this."""


def test_brute_force_and_winding_are_those_of_the_oracle():
    rng = np.random.default_rng(1)
    corners = rng.normal(size=(7, 3, 3))
    corners[0, 2] = corners[0, 1]  # no area
    points = rng.normal(size=(9, 3))
    found = brute_force(points, corners)
    for k, point in enumerate(points):
        assert found[k] == pytest.approx(min(oracles.point_triangle(point, t) for t in corners))
        assert winding(point, corners) == pytest.approx(oracles.winding(point, corners))


def test_a_gap_by_brute_force_is_the_clearance_of_the_oracle():
    case = in_cockpit("flat", "2k", "399", 1)
    parts = tuple(
        k for k, name in enumerate(case.environment.parts) if name in ("seat_pan", "stick")
    )
    triangles = case.environment.triangle_start[case.environment.part_start]
    assert all(triangles[k + 1] - triangles[k] < 100 for k in parts)
    body = case.placed.body
    hand = body.segment("RHN")
    corners = case.environment.vertices[case.environment.triangles]
    least = np.inf
    for k in parts:
        part = corners[triangles[k] : triangles[k + 1]]
        for s in range(*body.spheres(hand).indices(len(body.sphere_names))):
            centre = case.placed.centres[0, s]
            gap = min(oracles.point_triangle(centre, t) for t in part)
            inside = abs(oracles.winding(centre, part)) > 0.5
            least = min(least, (-gap if inside else gap) - body.radius[0, s])
    assert segment_gap(case, 0, hand, parts) == pytest.approx(least, abs=1e-12)


@pytest.mark.parametrize(
    ("place", "spheres"), [("trainer", "399"), ("trainer", "1500"), ("compact_car", "957")]
)
def test_people_seated_in_the_products_places_agree_with_brute_force(place, spheres):
    case = seated_in(place, spheres, 3)
    assert len(case.placed.body.sphere_names) == pytest.approx(int(spheres), abs=2)
    assert case.environment.solid.any()
    assert by_segment(case)[:, case.placed.window].min() < -0.005  # on the seat, not over it
    assert checked(case, sample=4) < MERGED


@pytest.mark.parametrize("kind", ["curved", "flat"])
def test_made_cockpits_agree_with_brute_force(kind):
    case = in_cockpit(kind, "2k", "399", 64)
    triangles = len(case.environment.triangles)
    assert 1_500 < triangles < 3_000
    merged = triangles / len(case.environment.normal)
    assert merged > 4 if kind == "flat" else merged < 2
    assert checked(case, sample=6) < MERGED


def test_a_real_vehicle_agrees_with_brute_force():
    case = in_real_vehicle("957", 2)
    if case is None:
        pytest.skip("its mesh is not among the shared inputs")
    assert checked(case, sample=4) < MERGED


@pytest.fixture(scope="module")
def small() -> Case:
    return opened(in_cockpit("curved", "2k", "399", 3))


@pytest.mark.parametrize("name", PEERS)
def test_another_library_agrees(name, small):
    try:
        asked = PEERS[name](small.environment, small.placed)
    except ImportError as error:
        pytest.skip(f"{name} is not installed: {error}")
    rows = slice(0, 3)
    ours = asked_of_us(small)
    assert np.array_equal(asked["any"](rows)(), ours["any"](rows)())
    if "by segment" in asked:
        wanted = ours["by segment"](rows)()
        found = asked["by segment"](rows)()
        known = np.isfinite(wanted)
        assert known.any()
        assert found[known] == pytest.approx(wanted[known], abs=1e-6)


def test_a_large_batch_comes_out_as_its_poses():
    case = in_cockpit("curved", "2k", "399", 5)
    once = int(wb.collides(case.placed, case.environment).sum())
    first = int(wb.collides(case.few(slice(0, 2)).placed, case.environment).sum())
    assert batches.hits_of(case, 12) == 2 * once + first


def test_margins_of_the_people_are_those_of_the_study():
    study = some_of(everybody(), 3)
    found = accommodation(study)
    margin = margins_in_seat(study, bodies_of(study))
    assert np.array_equal(margin, found.margin, equal_nan=True)
    assert share_of_fits(margin) == met_of(found.margin).all(axis=1).mean()


@pytest.mark.parametrize("name", ["--help", "check"])
def test_a_command_is_run_in_a_process_of_its_own(name, tmp_path):
    cost = run_command(name, tmp_path, tmp_path / "caches")
    assert cost.code == 0
    assert cost.out
    assert cost.cpu > 0
    assert 0 < cost.memory < 2


def test_sections_of_a_page_are_read_back_so_that_others_stay_as_they_were_taken():
    rows = [
        Row("any", "a case", 1.25, "us a pose", "a note"),
        Row("any", "b", None, "", "none here"),
    ]
    first = Section("First", "Some words.", rows, "2026-01-02, a machine, load 0.1 at the end")
    second = Section("Second", "Others.", [Row("warm", "trainer_reach", 9.0, "s")])
    assert sections_of(page([first, second])) == [first, second]
    text = PAGE.read_text(encoding="utf-8")
    assert page(sections_of(text)) == text


def test_the_page_names_what_is_not_met():
    (figure, case), goal = next(iter(GOALS.items()))
    rows = [
        Row(figure, case, 2 * goal.value, "us a pose"),
        Row("any", "trainer, 957 spheres", 1.0, "us a pose"),
        Row("any", "a case without a goal", None, "us a pose", "not installed"),
    ]
    text = page([Section("A title", "Some words.", rows)], whole=False)
    assert "1 of 2 goals are met." in text
    assert f"- {figure}, {case}: {2 * goal.value:.3g} us a pose; at most {goal.value:g} was" in text
    assert text.count("/ missed") == 1
    assert text.count("/ met") == 1
    assert "No figure was taken for" not in text
    assert "No figure was taken for" in page([Section("A title", "Some words.", rows)])
