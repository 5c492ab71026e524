"""Results in Python: tables as arrays and data frames, short words in a line, a page in a notebook."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from html.parser import HTMLParser

import numpy as np
import pytest

import workbench as wb
from tests.one_arm_cab import write_cab
from tests.toy_cockpit import write_toy
from workbench.report.folder import write_report

LONGEST = 400
"""Characters of a noun in a line."""


@pytest.fixture(scope="module")
def postures(tmp_path_factory):
    study = wb.load_study(write_cab(tmp_path_factory.mktemp("cab")))
    return wb.run(study.with_(criteria={"room for the hand": {"at_least": 1.0}}))


@pytest.fixture(scope="module")
def population(tmp_path_factory):
    return wb.run(wb.load_study(write_toy(tmp_path_factory.mktemp("toy"), people=4)))


@pytest.fixture(params=["postures", "population"])
def result(request):
    return request.getfixturevalue(request.param)


def cell(value):
    """A cell of CSV as it was before it was written."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    return str(value)


def test_tables_are_those_of_the_folder_with_numbers_as_numbers(result, tmp_path):
    write_report(result, tmp_path / "out")
    tables = result.tables()
    written = {path.stem: path for path in (tmp_path / "out").glob("*.csv")}
    assert tables.keys() == written.keys()
    for name, path in written.items():
        header, *rows = csv.reader(io.StringIO(path.read_text()))
        assert list(tables[name]) == header
        columns = (column.tolist() for column in tables[name].values())
        for row, line in zip(zip(*columns, strict=True), rows, strict=True):
            for value, text in zip(row, line, strict=True):
                same = cell(value) == text
                assert same or float(value) == float(text), (name, value, text)


def test_margins_of_people_are_columns_of_numbers(population):
    found = population.population
    people = population.tables()["people"]
    for r, requirement in enumerate(found.requirements):
        margin = people[f"{requirement.name} [mm]"]
        assert margin.dtype == np.float64
        np.testing.assert_allclose(margin, 1000 * found.margin[:, r], atol=5e-4)
    assert people["served"].dtype == np.bool_
    np.testing.assert_array_equal(people["served"], found.served)


def test_a_data_frame_holds_the_columns_of_a_table(result, population):
    pandas = pytest.importorskip("pandas")
    frame = result.to_dataframe()
    name = "people" if result is population else "verdicts"
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == list(result.tables()[name])
    with pytest.raises(wb.UsageError, match=r"table: this result has no table 'breeches'"):
        result.to_dataframe("breeches")


def test_without_pandas_the_error_says_what_to_do(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(wb.MissingPartError, match=r"pip install pandas .*result\.tables\(\)"):
        result.to_dataframe()


def nouns(value, depth=0):
    """Dataclasses in a value, and in these."""
    if is_dataclass(value) and not isinstance(value, type):
        yield value
        items = [getattr(value, field.name) for field in fields(value)] if depth < 5 else []
    elif isinstance(value, Mapping):
        items = list(value.values())[:3]
    else:
        items = value[:3] if isinstance(value, (tuple, list)) else []
    for item in items:
        yield from nouns(item, depth + 1)


def test_every_noun_of_a_result_is_a_line(result):
    count = 0
    for noun in nouns(result):
        text = repr(noun)
        assert len(text) <= LONGEST and "\n" not in text, text[:1000]
        count += 1
    assert count > 50


def test_a_line_says_what_came_out(postures, population):
    assert repr(postures) == "Result(cab_study: 4 of 5 criteria hold)"
    served = int(population.population.served.sum())
    assert repr(population) == f"Result(toy_crew: {served} of 4 people fit)"
    failed = postures.verdict("room for the hand")
    assert not failed.passed
    with pytest.raises(wb.InputError, match="did you mean 'room for the hand'"):
        postures.verdict("room for hands")
    assert repr(failed).startswith("Verdict(room for the hand: FAILED, margin -0.")


class Words(HTMLParser):
    """The texts of a page, those of its frames aside."""

    def __init__(self, page):
        super().__init__()
        self.texts = []
        self.feed(page)

    def handle_data(self, data):
        self.texts.append(data)


def test_a_notebook_shows_verdicts_shares_and_pictures(postures, population):
    words = Words(postures._repr_html_()).texts
    assert words.index("room for the hand") < words.index("FAILED") < words.index("passed")
    assert "<iframe" in postures._repr_html_()
    words = Words(population._repr_html_()).texts
    found = population.population
    missed = [
        one.name for one, share in zip(found.requirements, found.single, strict=True) if share < 1
    ]
    assert missed and set(missed) <= set(words)
    rest = len(found.requirements) - len(missed)
    assert f"{rest} of {len(found.requirements)} requirements are met by everybody." in words
    unsafe = replace(postures, study=replace(postures.study, title="<script>"))
    assert "<script>" in Words(unsafe._repr_html_()).texts


def test_nouns_are_drawn_as_their_files_are(postures, tmp_path):
    shown = wb.scene_of(postures)
    assert shown.environment is postures.postures[0].environment
    assert [body.placed.body.name for body in shown.bodies] == ["one_arm", "one_arm"]
    failed = wb.scene_of(postures, case="forward").bodies[0].placed
    found = postures.postures[0].people[0].placed
    np.testing.assert_allclose(failed.centres[0], found.centres[1], atol=1e-12)
    (whole,) = wb.scene_of(found.of_person(0, np.array([1])), environment=shown.environment).bodies
    np.testing.assert_array_equal(whole.placed.centres[0], found.centres[1])
    wb.render(postures, tmp_path / "one.svg", case="forward", view="left")
    wb.render(postures.study, str(tmp_path / "two.svg"), case="forward", view="left")
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"case": "down"}, "case: belongs to a study or a result, not to a placed body"),
        ({"posture": "bent"}, "posture: belongs to the file or name of a body, not to a placed"),
    ],
)
def test_what_does_not_suit_a_noun_is_refused(postures, options, message):
    with pytest.raises(wb.UsageError, match=message):
        wb.scene_of(postures.postures[0].people[0].placed, **options)


def test_the_person_hardest_to_serve_is_drawn_of_a_population(population):
    (shown,) = wb.scene_of(population).bodies
    assert shown.placed is population.population.shown[0].placed
    found = population.population
    last = len(found.people) - 1
    label = found.people.labels[last] if found.people.labels else str(last + 1)
    (other,) = wb.scene_of(population, case=label).bodies
    assert len(other.placed.centres) == 1
    with pytest.raises(wb.UsageError, match="no person 'sitting'; valid: "):
        wb.scene_of(population, case="sitting")
