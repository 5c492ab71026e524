"""Pictures and tables of two states, and line drawings written with fewer bytes."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import made, shown_of, trainer_people
from tests.one_arm_cab import STUDY, write_cab
from tests.test_accommodation_page import FLAPS
from workbench.draw.lines.svg import compacted
from workbench.draw.web.packing import Packing
from workbench.model.accommodation import DesignChange
from workbench.model.result import ChangedPerson, TriedChange
from workbench.report.page import page
from workbench.report.population.section import population_sections
from workbench.report.postures.moved import moved_sections
from workbench.report.result_rows import result_file
from workbench.report.section import Making
from workbench.report.turnable import PageViews

NUMBER = r"-?(?:\d+\.?\d*|\.\d+)"


def lines_of(path):
    """The lines of a path of relative moves, in tenths of a pixel."""
    found = set()
    at = np.zeros(2, dtype=int)
    for polyline in path.split("m")[1:]:
        ways = np.array([round(10 * float(n)) for n in re.findall(NUMBER, polyline)]).reshape(-1, 2)
        points = at + np.cumsum(ways, axis=0)
        at = points[-1]
        found |= {
            tuple(sorted(map(tuple, pair.tolist())))
            for pair in np.stack([points[:-1], points[1:]], 1)
        }
    return found


def test_lines_that_meet_are_one_polyline_and_go_straight_on():
    path = "M0.0 0.0L1.0 0.0M1.0 0.0L2.0 0.0M2.0 0.0L2.0 3.0M5.0 5.0L5.0 5.0M2.0 0.0L1.0 0.0"
    assert compacted(f'<path d="{path}"/>') == '<path d="m0 0 2 0 0 3"/>'


def test_every_line_is_where_it_was():
    rng = np.random.default_rng(3)
    ends = rng.integers(-40, 40, (60, 2, 2)) * 7 + rng.integers(0, 2, (60, 2, 2))
    path = "".join(
        f"M{a / 10:.1f} {b / 10:.1f}L{c / 10:.1f} {d / 10:.1f}" for (a, b), (c, d) in ends.tolist()
    )
    text = compacted(f'<path d="{path}"/>')
    expected = {tuple(sorted(map(tuple, pair))) for pair in ends.tolist() if pair[0] != pair[1]}
    assert lines_of(re.search('d="([^"]*)"', text)[1]) == expected


def test_curves_stay_as_they_are():
    svg = '<path d="M1.00 2.00A3.0 3.0 0 0 1 4.00 5.00"/>'
    assert compacted(svg) == svg


@pytest.fixture(scope="module")
def moved(tmp_path_factory):
    """The cab with its wall 300 mm nearer: nobody in it has the room that is asked for."""
    study = wb.load_study(write_cab(tmp_path_factory.mktemp("moved"), study=STUDY))
    return wb.run(study.with_(moved={study.environment.parts[0]: (-0.3, 0.0, 0.0)}))


def test_what_is_moved_is_shown_before_and_after_with_each_criterion(moved):
    html = page(moved, result_file(moved))
    assert html == page(moved, result_file(moved))
    section = re.search('<section id="moved".*?</section>', html, re.S)[0]
    assert '<th scope="col">before</th><th scope="col">after</th>' in section
    assert section.count("data:image/png") == 2
    for criterion in moved.study.criteria:
        assert f'<th scope="row">{criterion.name}</th>' in section


def test_where_nothing_is_moved_there_is_no_before(moved):
    still = replace(moved, study=replace(moved.study, moved=()))
    assert moved_sections(still, Making(PageViews())) == []


def test_a_change_that_was_tried_is_shown_before_and_after():
    people = trainer_people(10)
    flaps = np.linspace(-0.04, 0.05, 10)[:, None]
    gain = DesignChange("moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.6, 0.9, 0.4, 0.7)
    found = made(people, [FLAPS], flaps, gains=[gain])
    shown = shown_of(wb.load_body("bubbleman"), 0, 0, found.requirements)
    tried = TriedChange(gain, ChangedPerson(0, shown, shown), (-0.04, 0.012))
    packing = Packing()
    making = Making(PageViews(packing))
    sections = population_sections(replace(found, tried=(tried,)), making)
    html = next(section.html for section in sections if section.name == "changes")
    assert "misses “reach flaps” by 40 mm as it is, and has 12 mm to spare after moving" in html
    (view,) = packing.views
    assert view["states"] == ["as it is", "moving flaps 32 mm aft"]
