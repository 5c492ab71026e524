"""Margins that are no lengths are compared as lengths and read in their own unit, everywhere."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import workbench as wb
from tests.toy_cockpit import STUDY, write_toy
from workbench import load_study
from workbench.model.units import UNITS
from workbench.report.folder import write_report
from workbench.report.population.sentences import spare_words

ASKED = """
  - {name: joints, check: stops, segments: [LUA, LLA], at_least: AT_LEAST}
"""
STOPS = STUDY.split("criteria:")[0] + "criteria:" + ASKED


def stops_study(folder, at_least):
    return load_study(write_toy(folder, people=6, study=STOPS.replace("AT_LEAST", str(at_least))))


def rows_of(path):
    return list(csv.DictReader(path.read_text().splitlines()))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """People who lack some degrees in their elbows or shoulders, and the folder of their report."""
    folder = tmp_path_factory.mktemp("stops")
    result = wb.run(stops_study(folder, 120))
    write_report(result, folder / "out")
    return result.population, folder / "out"


def test_ten_degrees_more_asked_for_are_ten_degrees_less_in_the_table(found, tmp_path):
    population, folder = found
    more = wb.run(stops_study(tmp_path, 130)).population
    write_report(wb.run(stops_study(tmp_path, 130)), tmp_path / "out")
    tables = [rows_of(f / "people.csv") for f in (folder, tmp_path / "out")]
    before, after = (np.array([float(row["joints [deg]"]) for row in rows]) for rows in tables)
    assert np.allclose(before - after, 10.0, atol=2e-3)
    assert np.allclose(population.margin - more.margin, np.radians(10) * 0.2)


def test_sentences_page_and_files_say_degrees(found):
    population, folder = found
    short = -float(np.degrees(population.margin.min() / 0.2))
    assert short > 1
    page = (folder / "report.html").read_text()
    assert f"{short:.1f} degrees" in page and f"{short:,.0f} mm" not in page
    asked = json.loads((folder / "result.json").read_text())["population"]["requirements"][0]
    assert (asked["unit"], asked["unit_mm"]) == ("deg", pytest.approx(3.491, abs=1e-3))
    row = rows_of(folder / "requirements.csv")[0]
    assert row["unit"] == "deg"
    median = np.degrees(np.percentile(population.margin[:, 0], 50) / 0.2)
    assert float(row["margin_50_percent"]) == pytest.approx(median, abs=30)


@pytest.mark.parametrize(
    ("unit", "margin", "said"),
    [
        ("m", 0.0412, "41 mm"),
        ("m", 0.0003, "0.3 mm"),
        ("rad", 0.2 * np.radians(3.24), "3.2 degrees"),
        ("rad", 0.2 * np.radians(0.04), "0.04 degrees"),
        ("arcmin", 3.6 * np.radians(4.1 / 60), "4.1 arc minutes"),
        ("share", 0.1 * 0.08, "8 %"),
        ("share", 0.1 * 0.002, "0.2 %"),
        ("points", 0.01, "1 point"),
        ("points", 0.02, "2 points"),
    ],
)
def test_an_amount_is_written_in_its_unit_and_never_as_nothing(unit, margin, said):
    assert UNITS[unit].short(margin) == said


def test_only_a_reach_of_200_mm_is_at_least_what_is_to_spare():
    assert spare_words(0.2, UNITS["m"]) == "at least 200 mm to spare"
    assert spare_words(0.2, UNITS["rad"]) == "57.3 degrees to spare"
