"""What a notebook shows of an environment, a placed body and a result."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.one_arm_cab import write_cab
from tests.web_page import launched, opened, pixels, started


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """The result of the small cab."""
    return wb.run(wb.load_study(write_cab(tmp_path_factory.mktemp("notebook"))))


def page_of(shown):
    """The page inside the frame that a notebook gets."""
    (frame,) = re.findall(r'<iframe sandbox="allow-scripts" [^>]*srcdoc="([^"]*)"></iframe>', shown)
    return html.unescape(frame)


def test_each_noun_is_a_page_in_a_sandboxed_frame_the_same_bytes_twice(result, box_cab, one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    for noun in (box_cab, placed, result):
        shown = noun._repr_html_()
        assert shown == noun._repr_html_()
        page = page_of(shown)
        assert page.startswith("<!doctype html>") and "default-src &#x27;none&#x27;" in page


def test_a_result_shows_its_cases(result):
    page = page_of(result._repr_html_())
    places = re.findall(r'id="(view-\d)"', page)
    assert places == ["view-0", "view-1"]
    assert "anna and bert in cab, down" in page and "anna and bert in cab, forward" in page


def test_what_has_nothing_to_be_drawn_has_no_picture(box_cab):
    nothing = replace(box_cab, hidden=np.ones(len(box_cab.parts), dtype=bool))
    assert nothing._repr_html_() is None


def test_a_frame_in_a_notebook_shows_the_picture(box_cab, tmp_path):
    path = tmp_path / "notebook.html"
    path.write_text(f"<!doctype html><body>{box_cab._repr_html_()}</body>")
    with started() as playwright, launched(playwright) as running, opened(running, path) as page:
        page.frame_locator("iframe").locator("canvas").wait_for()
        image = pixels(page, "iframe")
        assert len(image.getcolors(image.width * image.height)) > 20
        assert page.faults == []


def test_a_result_lets_choose_a_case_and_keeps_its_people(result, one_arm):
    pytest.importorskip(
        "anywidget",
        reason="anywidget is not installed: pip install 'bubbleman-workbench[notebook]'",
    )
    shown = wb.view(result)
    assert [title.split(", ")[1] for title in shown.titles] == ["down", "forward"]
    shown.picture = 1
    assert repr(shown) == "PictureWidget(anna and bert in cab, forward)"
    with pytest.raises(wb.UsageError, match="people: those of a result are as they were measured"):
        shown.people = wb.place(one_arm, wb.pose(one_arm, {}))
