"""Turnable pictures in a browser: they open, turn, hide, name and look where a finding is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.one_arm_cab import STUDY, write_cab
from tests.web_page import launched, opened, pixels, started
from workbench.draw.web.case_view import compared_view
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import pair_html, place_html, scripts_html, standalone, style
from workbench.draw.web.views import WebMark, WebView, body_view
from workbench.report.page import page as report_page
from workbench.report.result_rows import result_file

PICTURE = ".turn canvas"
PAPER = (244, 246, 248)
"""The background of a picture in a light page."""
IN_THE_WALL = STUDY.replace("position: [0, 600, 900]", "position: [600, 500, 0]")


@pytest.fixture(scope="module")
def playwright():
    with started() as playwright:
        yield playwright


@pytest.fixture(scope="module")
def chromium(playwright):
    with launched(playwright) as running:
        yield running


@pytest.fixture(scope="module")
def view(one_arm, box_cab):
    """An arm with a red base before the wall of a cab, and a dimension line."""
    placed = wb.place(one_arm, wb.pose(one_arm, {"ELBOW": {"flexion": 90}}))
    marks = (WebMark((0.0, 0.0, 0.0), "200.0 mm", (0.0, 0.2, 0.0)),)
    return WebView("an arm", (body_view(placed, "anna", "warm", failing=(0,)),), box_cab, marks)


@pytest.fixture(scope="module")
def alone(view, tmp_path_factory):
    path = tmp_path_factory.mktemp("web") / "alone.html"
    path.write_text(standalone(view))
    return path


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The report of a study in which one of the people stands in the wall."""
    folder = tmp_path_factory.mktemp("web_report")
    result = wb.run(wb.load_study(write_cab(folder, study=IN_THE_WALL)))
    assert not result.passed
    path = folder / "report.html"
    path.write_text(report_page(result, result_file(result)))
    assert path.read_text() == report_page(result, result_file(result))
    return path


def count(image, *, red):
    """How many pixels are the red of what fails, or are not the colour of the background."""
    colour = np.asarray(image, dtype=np.int64)
    if red:
        return int(np.sum((colour[..., 0] > 110) & (colour[..., 1:].max(axis=2) < 75)))
    return int(np.sum(np.abs(colour - PAPER).max(axis=2) > 12))


def test_a_picture_opens_alone_and_shows_its_scene(chromium, alone):
    with opened(chromium, alone) as page:
        image = pixels(page, PICTURE)
        assert count(image, red=False) > 10_000 and count(image, red=True) > 300
        assert page.locator(".over span").first.text_content() == "200.0 mm"
        assert not page.locator("p.still").is_visible()
        assert page.faults == [] and page.evaluate("violations") == []
        assert page.requests == [alone.as_uri()]


def test_a_part_that_is_hidden_goes_from_the_picture(chromium, alone):
    with opened(chromium, alone) as page:
        before = count(pixels(page, PICTURE), red=False)
        page.get_by_role("button", name="parts").click()
        page.get_by_role("searchbox").fill("wal")
        assert page.locator(".list label:visible").all_text_contents() == [" wall"]
        page.get_by_label("wall").uncheck()
        page.get_by_role("searchbox").fill("floor")
        page.get_by_label("floor").uncheck()
        page.get_by_role("button", name="parts").click()
        assert count(pixels(page, PICTURE), red=False) < 0.7 * before
        page.locator(PICTURE).press("Escape")
        assert count(pixels(page, PICTURE), red=False) == pytest.approx(before, rel=0.02)


def test_a_click_names_what_is_there_and_hovering_too(chromium, one_arm, alone):
    with opened(chromium, alone) as page:
        pixels(page, PICTURE)
        page.get_by_role("button", name="front", exact=True).click()
        box = page.locator(PICTURE).bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.click(*middle)
        said = page.locator(".said").text_content()
        assert said.startswith("anna: ") or said in ("wall", "post", "floor")
        page.mouse.move(middle[0] + 1, middle[1])
        page.wait_for_timeout(500)
        assert page.locator(".tip").text_content() == said
        page.locator(PICTURE).press("Escape")
        assert page.locator(".said").text_content() == ""


def test_keys_turn_cut_and_show_views(chromium, alone):
    with opened(chromium, alone) as page:
        seen = [pixels(page, PICTURE)]
        for key in ("ArrowLeft", "3", "c", "x", "+", "0"):
            page.locator(PICTURE).press(key)
            seen.append(pixels(page, PICTURE))
        pictures = {image.tobytes() for image in seen}
        assert len(pictures) >= 5
        assert page.get_by_role("button", name="section").get_attribute("aria-pressed") == "true"
        assert page.faults == []


def test_a_failing_row_turns_the_picture_to_its_place(chromium, report):
    with opened(chromium, report) as page:
        page.locator("#view-1").scroll_into_view_if_needed()
        before = pixels(page, f"#view-1 {PICTURE[6:]}")
        link = page.locator('a.look[href="#view-1"]').first
        words = link.text_content()
        link.click()
        after = pixels(page, f"#view-1 {PICTURE[6:]}")
        assert before.tobytes() != after.tobytes()
        assert page.locator("#view-1 .said").text_content() == words
        assert count(after, red=True) > 300
        assert page.faults == [] and page.evaluate("violations") == []
        assert page.requests == [report.as_uri()]


@pytest.mark.parametrize("width", [420, 1000, 1500])
def test_a_report_fits_its_window_light_and_dark(chromium, report, width):
    papers = []
    for dark in (False, True):
        with opened(chromium, report, width=width, dark=dark) as page:
            page.locator("#view-0").scroll_into_view_if_needed()
            image = pixels(page, "#view-0 canvas")
            papers.append(np.mean(np.asarray(image)))
            assert page.locator("#view-0").bounding_box()["width"] <= width
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.faults == []
    assert papers[0] > 1.3 * papers[1]


def test_a_motion_is_scrubbed_and_red_while_it_touches(chromium, one_arm, box_cab, tmp_path):
    poses = [wb.pose(one_arm, {"SHOULDER": {"flexion": angle}}) for angle in (0, 45, 90)]
    placed = wb.place(one_arm, wb.join_poses(poses))
    hand = tuple((int(s), 0.15, 0.5) for s in np.flatnonzero(one_arm.sphere_segment >= 1))
    body = body_view(placed, "anna", "blue", frames=slice(0, 3), touching=hand)
    path = tmp_path / "film.html"
    path.write_text(standalone(WebView("m", (body,), box_cab, times=(0.0, 0.1, 0.2))))
    with opened(chromium, path) as page:
        first = pixels(page, PICTURE)
        assert count(first, red=True) == 0
        page.get_by_role("slider", name="time").fill("2")
        last = pixels(page, PICTURE)
        assert count(last, red=True) > 300
        assert page.locator("output").text_content() == "200.0 ms"
        page.locator(PICTURE).press(" ")
        page.get_by_role("button", name="play").wait_for()
        assert page.locator("output").text_content() == "200.0 ms"
        assert count(pixels(page, PICTURE), red=True) == pytest.approx(
            count(last, red=True), rel=0.1
        )


def test_the_picture_is_rough_while_it_moves_and_full_at_rest(chromium, alone):
    with opened(chromium, alone) as page:
        pixels(page, PICTURE)
        width = page.locator(PICTURE).bounding_box()["width"]
        sizes = page.evaluate(
            """async () => {
                const canvas = document.querySelector('.turn canvas');
                const key = new KeyboardEvent('keydown', { key: 'ArrowLeft' });
                const frame = () => new Promise(requestAnimationFrame);
                canvas.dispatchEvent(key);
                await frame();
                await frame();
                const moving = canvas.width;
                await new Promise((done) => setTimeout(done, 1500));
                return [moving, canvas.width];
            }"""
        )
        assert sizes == [pytest.approx(0.4 * width, abs=1), pytest.approx(width, abs=1)]


def test_a_lost_context_comes_back_with_the_same_picture(chromium, alone):
    with opened(chromium, alone) as page:
        before = pixels(page, PICTURE)
        page.evaluate(
            """async () => {
                const gl = document.querySelector('.turn canvas').getContext('webgl2');
                const held = gl.getExtension('WEBGL_lose_context');
                held.loseContext();
                await new Promise((done) => setTimeout(done, 300));
                held.restoreContext();
            }"""
        )
        after = np.asarray(pixels(page, PICTURE), dtype=np.int64)
        assert np.mean(np.abs(after - np.asarray(before, dtype=np.int64)) > 8) < 0.001
        assert page.faults == []


def test_without_webgl_the_still_picture_stays_and_says_why(playwright, report):
    with launched(playwright, "--disable-3d-apis") as running, opened(running, report) as page:
        page.wait_for_timeout(500)
        assert page.locator("#view-0 img.still").is_visible()
        assert "no WebGL 2" in page.locator("#view-0 .said").text_content()
        assert page.locator("canvas").count() == 0
        assert page.faults == []


def test_a_printed_page_shows_the_still_pictures(chromium, report):
    with opened(chromium, report) as page:
        pixels(page, "#view-0 canvas")
        page.emulate_media(media="print")
        assert page.locator("#view-0 img.still").is_visible()
        assert not page.locator("#view-0 canvas").is_visible()


def test_a_report_of_many_views_keeps_few_contexts(chromium, view, tmp_path):
    packing = Packing()
    places = [
        place_html(packing.add(replace(view, title=str(k))), still="", alt=str(k)) for k in range(9)
    ]
    path = tmp_path / "many.html"
    path.write_text("".join(f'<div style="height:1500px">{place}</div>' for place in places))
    path.write_text(f"<!doctype html><body>{path.read_text()}{scripts_html(packing)}")
    with opened(chromium, path) as page:
        for k in range(9):
            page.locator(f"#view-{k}").scroll_into_view_if_needed()
            page.wait_for_selector(f"#view-{k} canvas")
        assert page.locator("canvas").count() <= 4
        page.locator("#view-0").scroll_into_view_if_needed()
        page.wait_for_selector("#view-0 canvas")
        assert page.faults == []


def test_two_fingers_zoom_and_one_turns(chromium, view, tmp_path):
    touch = """(points) => {
        const canvas = document.querySelector('.turn canvas');
        canvas.setPointerCapture = () => {};
        for (const [type, id, x, y] of points) {
            const made = { pointerId: id, clientX: x, clientY: y, pointerType: 'touch', buttons: 1 };
            canvas.dispatchEvent(new PointerEvent(type, made));
        }
    }"""
    pinch = [("pointerdown", 1, 400, 300), ("pointerdown", 2, 500, 300)]
    pinch += [("pointermove", 2, 550, 300), ("pointerup", 1, 400, 300), ("pointerup", 2, 550, 300)]
    turn = [("pointerdown", 1, 400, 300), ("pointermove", 1, 500, 300), ("pointerup", 1, 500, 300)]
    path = tmp_path / "arm.html"
    path.write_text(standalone(replace(view, environment=None)))
    with opened(chromium, path) as page:
        before = pixels(page, PICTURE)
        page.evaluate(touch, pinch)
        nearer = pixels(page, PICTURE)
        assert count(nearer, red=False) > 1.4 * count(before, red=False)
        page.evaluate(touch, turn)
        assert pixels(page, PICTURE).tobytes() != nearer.tobytes()
        assert page.faults == []


def test_a_section_takes_the_labels_along_that_it_cuts_away(chromium, alone):
    with opened(chromium, alone) as page:
        pixels(page, PICTURE)
        label = page.locator(".over span").first
        section = page.get_by_role("button", name="section")
        for view, there in (("front", True), ("back", False)):
            page.get_by_role("button", name=view, exact=True).click()
            section.click()
            page.wait_for_timeout(500)
            assert label.is_visible() == there
            section.click()
        page.wait_for_timeout(500)
        assert label.is_visible()


def test_what_is_looked_at_has_a_ring_around_it_in_the_middle(chromium, report):
    with opened(chromium, report) as page:
        page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        page.locator("td.hit a.look").first.click()
        ring = page.locator(".over .ring:visible")
        ring.wait_for()
        box = page.locator(".turn canvas").first.bounding_box()
        found = ring.bounding_box()
        assert found["x"] + found["width"] / 2 == pytest.approx(box["x"] + box["width"] / 2, abs=2)
        assert " to " in page.locator(".said", has_text="mm").first.text_content()


def test_a_ghost_lets_through_what_is_behind_it(chromium, view, tmp_path):
    shown = []
    for ghost in (False, True):
        body = replace(view.bodies[0], ghost=ghost, failing=(), colour=(40, 60, 200))
        specks = np.full_like(body.radius, 1e-4)  # around all of it, so that both are as large
        base = replace(view.bodies[0], radius=specks, centres=2.0 * body.centres)
        path = tmp_path / f"{ghost}.html"
        path.write_text(standalone(WebView("g", (base, body))))
        with opened(chromium, path) as page:
            colour = np.asarray(pixels(page, PICTURE), dtype=np.int64)
            shown.append(int(np.sum(np.abs(colour - PAPER))))
    assert 0.3 * shown[0] < shown[1] < 0.8 * shown[0]


def test_a_slider_wipes_between_two_states_and_paper_shows_both(chromium, view, tmp_path):
    plain = replace(view.bodies[0], failing=())
    red = replace(plain, failing=tuple(range(len(plain.radius))))
    marks = (WebMark((0.0, 0.0, 0.1), "after", failing=True),)
    states = (WebView("arm", (plain,)), WebView("arm", (red,), marks=marks))
    packing = Packing()
    index = packing.add(compared_view(*states, names=("old", "new"), title="an arm"))
    dot = "data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA="
    place = pair_html(index, stills=(dot, dot), names=("old", "new"), alt="arm", caption="both")
    path = tmp_path / "pair.html"
    path.write_text(f"<!doctype html><style>{style()}</style><body>{place}{scripts_html(packing)}")
    with opened(chromium, path) as page:
        slider = page.get_by_role("slider", name="wipe between old and new")
        shares = []
        for key in ("", "End", "Home"):
            if key:
                slider.press(key)
            shares.append(count(pixels(page, PICTURE), red=True))
        assert shares[1] == 0 and shares[2] > 300
        assert 0.1 * shares[2] < shares[0] < 0.9 * shares[2]
        assert slider.get_attribute("aria-valuetext") == "new alone"
        assert page.locator(".over span.bad").is_visible()
        page.get_by_role("button", name="old alone").click()
        assert slider.input_value() == "100"
        page.wait_for_timeout(200)
        assert not page.locator(".over span.bad").is_visible()
        said = page.locator(".said")
        assert said.inner_text() == "both; the slider moves the line between the two"
        page.emulate_media(media="print")
        assert said.inner_text() == "both"
        boxes = [image.bounding_box() for image in page.locator(".pair img").all()]
        assert boxes[0]["y"] == boxes[1]["y"] and boxes[0]["x"] < boxes[1]["x"]
        assert page.faults == []
