"""The order of a report, its tables and its warnings: what a reader meets from top to bottom."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import numpy as np
import pytest

import workbench as wb
from tests.one_arm_cab import STUDY, write_cab
from tests.web_page import launched, opened, started
from workbench.report.motions.charts import curves
from workbench.report.page import page
from workbench.report.page_script import page_script_html
from workbench.report.result_rows import result_file

IN_THE_WALL = STUDY.replace("position: [0, 600, 900]", "position: [600, 500, 0]").replace(
    "at_least: 100", "at_least: 5000"
)
"""One of the people stands in the wall, and the other has not the room that is asked for."""
ALLOWED = STUDY.replace("position: [0, 600, 900]", "position: [600, 500, 0]").replace(
    "check: contact", "check: contact, at_most: 60"
)
"""The same, but so much overlap is allowed."""


def result_of(folder, study):
    return wb.run(wb.load_study(write_cab(folder, study=study)))


def html_of(result, files=()):
    return page(result, result_file(result), files=files)


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    return result_of(tmp_path_factory.mktemp("failing"), IN_THE_WALL)


@pytest.fixture(scope="module")
def silent(failing):
    """The same people where the criteria that fail are not asked."""
    found = failing.postures[0]
    asked = {v.criterion.name: None for v in found.verdicts if not v.passed}
    assert 0 < len(asked) < len(failing.study.criteria)
    return wb.run(failing.study.with_(criteria=asked))


@pytest.fixture(scope="module")
def file(failing, tmp_path_factory):
    path = tmp_path_factory.mktemp("order") / "report.html"
    path.write_text(html_of(failing))
    return path


class Tables(HTMLParser):
    """The tables of a page: whether each has a caption, and the scopes of its headers."""

    def __init__(self, html):
        super().__init__()
        self.captions = []
        self.scopes = []
        self.sections = []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        known = dict(attrs)
        if tag == "table":
            self.captions.append(False)
        if tag == "caption":
            self.captions[-1] = True
        if tag == "th":
            self.scopes.append(known.get("scope"))
        if tag == "section":
            self.sections.append(known["id"])


def test_sections_stand_in_the_order_of_what_decides(failing):
    wanted = ["view", "failed", "warnings", "passed", "cases", "people", "clearance", "provenance"]
    sections = Tables(html_of(failing)).sections
    assert [name for name in sections if name in wanted] == wanted
    assert len(set(sections)) == len(sections)


def test_the_contents_lead_to_every_section(failing):
    html = html_of(failing)
    contents = re.search(r'<nav class="contents".*?</nav>', html, re.DOTALL).group()
    assert re.findall(r'href="#([^"]+)"', contents) == Tables(html).sections


def test_every_table_has_a_caption_and_every_header_its_scope(failing):
    tables = Tables(html_of(failing))
    assert len(tables.captions) > 8 and all(tables.captions)
    assert set(tables.scopes) == {"row", "col"}


def test_the_verdict_names_the_criterion_that_decides_with_its_number(failing):
    lead = re.search(r'<p class="lead">(.*?)</p>', html_of(failing), re.DOTALL).group(1)
    worst = [v.worst for v in failing.verdicts if not v.passed and v.worst.unit == "m"]
    deepest = min(worst, key=lambda finding: finding.margin)
    assert "fail, the worst “" in lead and f"{abs(1000 * deepest.value):.1f}" in lead


def test_each_failed_criterion_states_measured_limit_and_shortfall(failing):
    html = html_of(failing)
    failed = [v for v in failing.verdicts if not v.passed]
    cards = re.findall(r'<article class="failed".*?</article>', html, re.DOTALL)
    assert len(cards) == len(failed) > 1
    for card, verdict in zip(cards, failed, strict=True):
        assert verdict.criterion.name in card and card.count("<dt>") == 3
        assert ("<img" in card) == (verdict.worst.point is not None)


def test_overlaps_that_no_criterion_asks_about_are_warnings_and_no_green_page(failing, silent):
    assert silent.passed and not failing.passed
    told = [line for line in silent.warnings if "no criterion asks" in line]
    assert told and not any("no criterion asks" in line for line in failing.warnings)
    html = html_of(silent)
    assert 'class="badge warned">PASSED' in html and "Nothing to complain" not in html
    assert "overlaps that no criterion asks about, in the picture" in html
    said = re.sub(r", polygon \d+", "", told[0]).replace("_", " ")
    assert said in html.replace("&#39;", "'")


def test_the_headline_says_the_tightest_gap_and_the_deepest_overlap_nothing_asks_about(
    failing, silent
):
    # the wall is 50 mm thick, from x = 600 mm on: the base of 50 mm, at x = 600, leaves its front
    said = result_file(silent).headline
    assert "The deepest overlap that no criterion asks about: base" in said
    assert "is 50.0 mm into wall (" in said and "polygon" not in said
    assert "no criterion asks" not in result_file(failing).headline
    # the seat and its backrest are nearer, but may be touched
    room = failing.verdict("room for the hand").worst.value
    gap = f"The tightest gap is {1000 * room:.1f} mm: hand from wall (forward, anna)."
    assert gap in said and gap in result_file(failing).headline


def test_overlaps_that_a_criterion_allows_are_no_warnings(tmp_path):
    result = result_of(tmp_path, ALLOWED)
    assert result.passed
    assert not any("no criterion asks" in line for line in result.warnings)
    assert "Overlaps that no criterion" not in html_of(result)


def test_paper_keeps_tables_badges_and_folded_parts(failing):
    style = re.search(r"<style>(.*?)</style>", html_of(failing), re.DOTALL).group(1)
    paper = style.partition("@media print {")[2]
    hidden = re.findall(r"([^{}]*)\{[^{}]*display: none", paper)
    for rule in hidden:
        assert not re.search(r"\b(table|t[dhr]|details|\.badge|\.wide|section)\b(?![-:])", rule)
    narrow = re.findall(r"@media ([^{]*max-width[^{]*)\{", style)
    assert narrow and all(rule.startswith("screen") for rule in narrow)


def test_files_are_linked_from_the_tables_that_they_hold(failing):
    html = html_of(failing, files=["result.json", "clearance.csv"])
    caption = re.search(r"<caption>[^<]*farther parts.*?</caption>", html, re.DOTALL).group()
    assert 'href="clearance.csv" download' in caption
    assert 'href="contacts.csv"' not in html


@pytest.fixture(scope="module")
def chromium():
    with started() as playwright, launched(playwright) as running:
        yield running


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """A page with a table of twelve rows, a curve, and the script."""
    rows = "".join(
        f"<tr><th>part {chr(97 + k % 5)}</th><td>{7 * k % 12} mm</td></tr>" for k in range(12)
    )
    table = f"<table class=data><thead><tr><th>Part<th>Depth</thead><tbody>{rows}</tbody></table>"
    line = np.array([0.0, 10.0, 20.0])
    curve = curves(line / 100, [("head", 5 * line)], unit="mm", title="a curve")
    path = tmp_path_factory.mktemp("bare") / "bare.html"
    path.write_text(f"<body>{table}<div class=curve>{curve}</div>{page_script_html()}")
    return path


def test_a_table_is_sorted_by_numbers_and_searched_by_words(chromium, bare):
    with opened(chromium, bare) as browser:
        depth = browser.get_by_role("button", name="Depth")
        for order in ("ascending", "descending"):
            depth.press("Enter")
            head = browser.get_by_role("columnheader", name="Depth")
            assert head.get_attribute("aria-sort") == order
            cells = browser.locator("td").all_text_contents()
            numbers = [int(cell.split()[0]) for cell in cells]
            assert numbers == sorted(range(12), reverse=order == "descending")
        browser.get_by_role("searchbox").fill("Part d")
        assert browser.locator("tbody tr:visible").count() == 2
        assert browser.locator("output").text_content() == "2 of 12 rows"
        assert browser.faults == []


def test_a_curve_is_read_by_the_arrow_keys(chromium, bare):
    with opened(chromium, bare) as browser:
        curve = browser.locator("svg[data-across]")
        for _ in range(50):
            curve.press("ArrowRight")
        said = browser.locator(".read").text_content()
        assert said == "100.0 ms [mm]: head 50"
        curve.hover()
        assert browser.locator(".read").text_content() != said


@pytest.mark.parametrize("width", [420, 1600])
def test_no_page_scrolls_sideways_and_links_open_what_is_folded(chromium, file, width):
    with opened(chromium, file, width=width) as browser:
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        folded = browser.locator("#passed > details")
        assert folded.get_attribute("open") is None
        browser.locator('.contents a[href="#passed"]').click()
        browser.wait_for_function("document.querySelector('#passed > details').open")
        browser.emulate_media(media="print")
        assert browser.locator("#provenance table").is_visible()
        assert browser.faults == [] and browser.evaluate("violations") == []
        assert browser.requests[0] == file.as_uri() and len(browser.requests) == 1
