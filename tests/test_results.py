"""What a study leaves behind: result.json, the CSV tables and the page say the same thing, and need
nothing else."""

from __future__ import annotations

import base64
import csv
import io
import json
import re
import warnings
from html.parser import HTMLParser
from xml.etree import ElementTree

import jsonschema
import numpy as np
import PIL.Image
import pytest

import workbench as wb
from tests.one_arm_cab import ENVIRONMENT, STUDY, changed, write_cab
from workbench.files.kinds import json_schemas
from workbench.files.results.result import ResultFile, dump_json
from workbench.report.folder import write_report
from workbench.report.sentences import without_polygons
from workbench.report.tables import csv_text

# Bert stands in the wall, Anna's elbow is past its stop, and there is less room than is asked for.
BROKEN = STUDY
for _old, _new in (
    ("[0, 600, 900]", "[620, 600, 0]"),
    ("SHOULDER: {flexion: 80}", "ELBOW: {flexion: 150}"),
    ("at_least: 100", "at_least: 700"),
    ("title: One arm", 'title: "One <b>&amp;</b> arm"#'),
    ("name: down", "name: '=down \"&\" <script>'"),
):
    BROKEN = changed(BROKEN, _old, _new)
VOID = {
    "area",
    "base",
    "br",
    "col",
    "embed",
    "hr",
    "img",
    "input",
    "link",
    "meta",
    "source",
    "track",
    "wbr",
}


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return wb.run(wb.load_study(write_cab(tmp_path_factory.mktemp("cab"), study=BROKEN)))


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    place = tmp_path_factory.mktemp("result") / "out"
    write_report(result, place)
    return place


@pytest.fixture(scope="module")
def data(folder):
    return json.loads((folder / "result.json").read_text())


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text()


def table(folder, name):
    return list(csv.DictReader(io.StringIO((folder / name).read_text())))


def cell(value):
    """A value as a spreadsheet gets it: no formulas."""
    text = "" if value is None else str(value)
    return "'" + text if isinstance(value, str) and text.startswith(("=", "+", "-", "@")) else text


class Page(HTMLParser):
    """Follows the tags of a page: what is open, which texts and attributes there are; unbalanced
    tags are faults."""

    def __init__(self, text):
        super().__init__()
        self.open = []
        self.faults = []
        self.tags = []
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append((tag, self.getpos()))

    def handle_data(self, data):
        self.text += data


def test_a_result_is_nine_files_and_a_manifest(folder):
    assert sorted(path.name for path in folder.iterdir()) == [
        "breaches.csv",
        "clearance.csv",
        "contacts.csv",
        "manifest.json",
        "placements.csv",
        "postures.csv",
        "report.html",
        "result.json",
        "stops.csv",
        "verdicts.csv",
    ]


def test_result_json_is_valid_and_comes_back_as_it_was(folder, data):
    jsonschema.validate(data, json_schemas()["result"], cls=jsonschema.Draft202012Validator)
    text = (folder / "result.json").read_text()
    assert dump_json(ResultFile.model_validate_json(text)) == text
    assert "NaN" not in text and "Infinity" not in text


def test_the_schema_refuses_what_is_not_a_result(data):
    for change in ({"extra": 1}, {"passed": "yes"}, {"motions": None}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(data | change, json_schemas()["result"])


def test_three_criteria_fail_and_the_rest_hold(data):
    assert [verdict["passed"] for verdict in data["verdicts"]] == [False, False, True, True, False]
    assert not data["passed"]
    assert all(bool(verdict["breaches"]) != verdict["passed"] for verdict in data["verdicts"])


def test_a_breach_is_a_value_below_its_limit_and_the_worst_comes_first(data):
    for verdict in data["verdicts"]:
        gaps = [breach["value"] - breach["limit"] for breach in verdict["breaches"]]
        assert gaps == pytest.approx([breach["margin"] for breach in verdict["breaches"]], abs=2e-6)
        assert all(gap < 0 for gap in gaps)
        assert gaps == sorted(gaps)
        if gaps:
            assert verdict["worst"] == verdict["breaches"][0]


def test_the_wall_of_50_mm_holds_half_of_bert(data):
    worst = data["verdicts"][0]["worst"]
    assert (worst["person"], worst["unit"]) == ("bert", "mm")
    assert worst["value"] == pytest.approx(
        -70, abs=1e-6
    )  # centre 20 mm inside the face at 600, and the radius of 50


def test_clearance_matrices_have_a_row_a_segment_and_a_column_a_part(data):
    parts = data["postures"][0]["parts"]
    for person in data["postures"][0]["people"]:
        shape = np.array(person["clearance_mm"], dtype=object).shape
        assert shape == (len(data["cases"]), len(person["segments"]), len(parts))
        assert all(
            row[parts.index("secret")] is None for case in person["clearance_mm"] for row in case
        )


def test_contacts_are_the_deepest_of_their_pair_with_unit_normals(data):
    fields = ("case", "person", "other_person", "kind", "segment", "part", "other_segment")
    keys = [
        tuple(contact[field] for field in fields) for contact in data["postures"][0]["contacts"]
    ]
    assert len(set(keys)) == len(keys) > 0
    for contact in data["postures"][0]["contacts"]:
        assert np.linalg.norm(contact["normal"]) == pytest.approx(1, abs=1e-5)
        assert contact["excess_mm"] == pytest.approx(
            -contact["distance_mm"] - contact["allowed_mm"], abs=2e-6
        )


def test_provenance_hashes_every_file_that_was_read(data):
    files = {"study", "environment: environment.yaml", "environment: cab.obj"}
    files |= {f"{what} of {name}" for what in ("body", "postures") for name in ("anna", "bert")}
    assert set(data["provenance"]["inputs"]) == files
    assert all(
        re.fullmatch(r"[0-9a-f]{64}", value) for value in data["provenance"]["inputs"].values()
    )


def test_breaches_csv_is_the_breaches_of_the_json(folder, data):
    fields = [
        "case",
        "person",
        "other_person",
        "subject",
        "target",
        "value",
        "limit",
        "margin",
        "unit",
        "time_ms",
    ]
    wanted = [
        [
            cell(v["name"]),
            *(cell(b[f]) for f in fields),
            *(cell(c) for c in b["point_mm"] or [None] * 3),
            *(cell(b[f]) for f in ("surface_known_to", "sphere", "polygon", "other_sphere")),
        ]
        for v in data["verdicts"]
        for b in v["breaches"]
    ]
    assert [list(row.values()) for row in table(folder, "breaches.csv")] == wanted
    assert len(wanted) > 3


def test_the_other_tables_are_the_json_too(folder, data):
    people = data["postures"][0]["people"]
    wanted = {
        ("verdicts.csv", "sentence"): [verdict["sentence"] for verdict in data["verdicts"]],
        ("contacts.csv", "distance_mm"): [
            contact["distance_mm"] for contact in data["postures"][0]["contacts"]
        ],
        ("stops.csv", "margin_deg"): [
            stop["margin_deg"] for person in people for stop in person["stops"]
        ],
        ("clearance.csv", "clearance_mm"): [
            value
            for person in people
            for case in person["clearance_mm"]
            for row in case
            for value in row
            if value is not None
        ],
    }
    for (name, column), values in wanted.items():
        assert [row[column] for row in table(folder, name)] == [cell(value) for value in values], (
            name
        )


def test_no_cell_of_a_table_is_a_formula(folder):
    for path in folder.glob("*.csv"):
        for row in csv.reader(io.StringIO(path.read_text())):
            assert not [c for c in row if re.match(r"[=+@]|-(?![\d.e-]+$)", c)]


def test_an_empty_cell_stays_empty():
    assert (
        csv_text(["a", "b", "c"], [["", "=1", "-2"], [None, -2, "x"]]) == "a,b,c\n,'=1,'-2\n,-2,x\n"
    )


def test_the_page_is_balanced_html_with_one_title(page):
    read = Page(page)
    assert read.faults == [] and read.open == []
    assert page.startswith("<!doctype html>")
    assert sum(tag == "title" for tag, _ in read.tags) >= 1
    assert [attrs.get("lang") for tag, attrs in read.tags if tag == "html"] == ["en"]
    identities = [attrs["id"] for _, attrs in read.tags if "id" in attrs]
    assert len(set(identities)) == len(identities)


def test_the_page_needs_nothing_from_outside(page, folder):
    names = r'xmlns(:\w+)?="[^"]*"|createElementNS\("[^"]*"'  # of a namespace, no address
    bare = re.sub(names + r"|data:image/png;base64,[\w+/=]+", "", page)
    assert not re.findall(r"https?://|(?<![:\w])//\w|@import|url\((?!#)", bare)
    for tag, attrs in Page(page).tags:
        assert tag not in ("link", "iframe", "object", "embed", "base")
        assert not [name for name in attrs if name.startswith("on")]
        if tag == "a" and "download" in attrs:  # the files that lie beside it
            assert (folder / attrs["href"]).is_file()
            continue
        for name in ("src", "href", "xlink:href", "srcset", "action", "poster"):
            assert attrs.get(name, "#").startswith(("#", "data:image/png;base64,"))


def test_every_picture_says_what_it_shows(page, data):
    read = Page(page)
    pictures = [attrs for tag, attrs in read.tags if tag == "img"]
    close = [attrs for attrs in pictures if attrs["alt"].startswith("close-up: ")]
    failed = [v for v in data["verdicts"] if not v["passed"] and v["worst"]["point_mm"]]
    assert len(close) == len(failed) > 0
    pictures = [attrs for attrs in pictures if attrs not in close]
    drawings = [attrs for tag, attrs in read.tags if tag == "svg"]
    assert len(pictures) == 4 * len(data["cases"]) + 2  # both cases side by side
    circles = [attrs for attrs in drawings if attrs["width"] == "520"]
    assert len(circles) == len(data["cases"])
    assert len(drawings) - len(circles) <= len(data["cases"])  # one where something is near
    assert len({attrs["alt"] for attrs in pictures}) == len(pictures)
    assert all(attrs["alt"].startswith(tuple(data["cases"])) for attrs in pictures)
    assert len(re.findall(r"<svg[^>]* role=\"img\"[^>]*>\s*<title>[^<]+</title>", page)) == len(
        drawings
    )


def test_pictures_are_png_of_the_stated_size_and_drawings_are_xml(page):
    read = Page(page)
    for attrs in (attrs for tag, attrs in read.tags if tag == "img"):
        picture = PIL.Image.open(io.BytesIO(base64.b64decode(attrs["src"].partition(",")[2])))
        assert picture.size == (int(attrs["width"]), int(attrs["height"]))
    for drawing in re.findall(r"<svg.*?</svg>", page, flags=re.DOTALL):
        assert ElementTree.fromstring(drawing).tag.endswith("svg")


def test_names_from_files_are_text_in_the_page_never_markup(page, data):
    assert data["cases"][0] == '=down "&" <script>'
    # the data of the turnable pictures, what turns them, and what sorts tables
    assert page.count("<script") == 3
    assert "=down &#34;&amp;&#34; &lt;script&gt;" in page
    assert '=down "&" <script>' in Page(page).text


def test_the_page_tells_every_verdict_and_every_breach(page, data):
    text = Page(page).text
    for verdict in data["verdicts"]:
        assert verdict["name"] in text and without_polygons(verdict["sentence"]) in text
        assert all(without_polygons(breach["sentence"]) in text for breach in verdict["breaches"])
    assert text.count("FAILED") == 4
    assert all(warning in text for warning in data["warnings"])


def test_the_same_result_gives_the_same_bytes(result, folder, tmp_path):
    with warnings.catch_warnings(action="error"):
        write_report(result, tmp_path / "again")
    for path in folder.iterdir():
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes(), path.name


def test_lengths_in_another_unit_give_the_same_numbers(tmp_path):
    metres = changed(changed(STUDY, "length: mm", "length: m"), "forward: 10,", "forward: 0.01,")
    metres = changed(
        changed(metres, "[0, 600, 900]", "[0, 60 cm, 0.9]"), "at_least: 100", "at_least: 0.1"
    )
    cab = ENVIRONMENT.replace("depth: 10", "depth: 0.01").replace("depth: 20", "depth: 0.02")
    cab = (
        cab.replace("400", "0.4")
        .replace("[-50, 50]", "[-0.05, 0.05]")
        .replace("[-20, 20]", "[-0.02, 0.02]")
    )
    one = wb.run(wb.load_study(write_cab(tmp_path / "one")))
    other = wb.run(
        wb.load_study(
            write_cab(
                tmp_path / "two", study=metres, environment=changed(cab, "length: mm", "length: m")
            )
        )
    )
    for a, b in zip(one.postures[0].people, other.postures[0].people, strict=True):
        assert a.clearance.distance == pytest.approx(b.clearance.distance, abs=1e-12)
    assert [v.passed for v in one.verdicts] == [v.passed for v in other.verdicts]
