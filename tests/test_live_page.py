"""The page of the live bench in a browser: Chromium where it and Playwright are installed."""

from __future__ import annotations

import base64
import io
import json
import math
import shutil

import numpy as np
import pytest
from PIL import Image

from tests.conftest import ROOT
from tests.web_page import CHROMIUM, launched, pixels, pixels_once, served

pytest.importorskip("starlette", reason="the extra `live` is not installed")
playwright = pytest.importorskip(
    "playwright.sync_api", reason="Playwright is not installed: pip install playwright"
)
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no Chromium: apt install chromium"
)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "trainer.yaml"
    shutil.copy(ROOT / "tests" / "data" / "two_men.yaml", path)
    return path


@pytest.fixture(scope="module")
def page(study):
    with (
        served(study) as address,
        playwright.sync_playwright() as running,
        launched(running) as browser,
    ):
        opened = browser.new_page(viewport={"width": 1400, "height": 900})
        opened.set_default_timeout(60_000)
        opened.said = []
        opened.asked = []
        opened.starter = running
        opened.entrance = address
        opened.on("console", lambda message: opened.said.append(message.text))
        opened.on("pageerror", lambda error: opened.said.append(str(error)))
        opened.on("request", lambda request: opened.asked.append(request.url))
        opened.goto(address, wait_until="commit")
        opened.wait_for_selector("#verdicts tr")
        yield opened


def elbow(page):
    return page.locator("fieldset", has_text="right elbow").get_by_role("slider").first


def faults(page):
    """What the page says of itself; drivers of graphics tell of their pace."""
    return [words for words in page.said if "GL Driver Message" not in words]


PANES = ("#picture", "#found", "#grips", "#who", "#seat", "#limb")
GOLDEN = ROOT / "tests" / "data" / "live_page_panes.txt"
"""What a screen reader is told of the panes; written anew where it is absent."""


def test_a_screen_reader_is_told_what_the_golden_file_says(page):
    page.wait_for_selector("#picture canvas")
    found = "\n".join(page.locator(pane).aria_snapshot() for pane in PANES) + "\n"
    if not GOLDEN.exists():
        GOLDEN.write_text(found)
    assert found == GOLDEN.read_text()


def focused(page):
    return page.evaluate("() => document.activeElement.getAttribute('aria-label') ?? ''")


def tabbed_to(page, words, most=20):
    for _ in range(most):
        page.keyboard.press("Tab")
        if words in focused(page):
            return
    raise AssertionError(f"no {words} within {most} tabs")


def test_by_keys_alone_a_joint_of_another_person_is_turned_judged_and_saved(page, study):
    before = study.read_text()
    page.locator("#person").focus()
    page.keyboard.press("ArrowDown")
    assert page.locator("#person").input_value() == "instructor"
    page.get_by_role("button", name="Envelope").focus()
    tabbed_to(page, "flexion / extension")
    assert page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    page.wait_for_selector("#verdicts:not(.waiting) tr")
    page.keyboard.press("Control+s")
    said(page, "saved")
    assert study.read_text() != before
    page.keyboard.press("Control+z")
    page.wait_for_function("() => document.title.startsWith('●')")
    page.keyboard.press("Control+s")
    page.wait_for_function("() => !document.title.startsWith('●')")
    assert study.read_text() == before
    page.locator("#person").select_option("pilot")


def test_the_list_of_parts_is_one_tab_stop_with_arrows(page):
    page.get_by_role("button", name="parts", exact=True).click()
    boxes = page.get_by_role("group", name="shown").get_by_role("checkbox")
    assert boxes.count() > 80
    page.get_by_label("find a part").focus()
    page.keyboard.press("Tab")
    page.keyboard.press("ArrowDown")
    assert boxes.nth(1).evaluate("(box) => box === document.activeElement")
    stops = "(boxes) => boxes.filter((box) => box.tabIndex === 0).length"
    assert boxes.evaluate_all(stops) == 1
    page.get_by_role("button", name="parts", exact=True).click()


def test_a_verdict_looks_at_its_place_in_its_case_with_its_person(page):
    row = page.locator("#verdicts tr", has_text="looking left").first
    page.locator("#person").select_option("instructor")
    row.get_by_role("button").click()
    page.wait_for_function("() => document.querySelector('#case').value === 'looking left'")
    assert page.locator("#person").input_value() == "pilot"
    assert "canopy" in page.locator("#picture .said").inner_text()
    page.locator("#case").select_option("cruise")
    page.wait_for_selector("#verdicts:not(.waiting) tr")


def first_slider(window, joint):
    return window.locator("fieldset", has_text=joint).get_by_role("slider").first


def shows(window, slider, value):
    """Wait until a slider of a window has a value."""
    window.wait_for_function("([one, value]) => one.value === value", arg=[slider, value])


def test_two_windows_see_each_others_edits_while_both_are_dragged(page, study):
    before = study.read_text()
    other = page.context.browser.new_page()
    other.goto(page.entrance, wait_until="commit")
    other.wait_for_selector("#verdicts tr")
    windows = (page, other)
    elbows = [first_slider(window, "right elbow").element_handle() for window in windows]
    knees = [first_slider(window, "right knee").element_handle() for window in windows]
    knee = knees[0].input_value()
    for _ in range(4):
        elbows[0].press("ArrowRight")
        knees[1].press("ArrowRight")
    for k, window in enumerate(windows):
        shows(window, elbows[k], "75.4")
        shows(window, knees[k], f"{float(knee) + 0.4:g}")
    page.get_by_role("button", name="Save").click()
    said(other, "saved")
    other.close()
    study.write_text(before)  # an editor puts the file back: it is read again
    said(page, "read again")
    shows(page, first_slider(page, "right knee").element_handle(), knee)


def test_without_webgl_the_bench_works_and_says_why_there_is_no_picture(page):
    with launched(page.starter, "--disable-3d-apis") as browser:
        opened = browser.new_page()
        opened.goto(page.entrance, wait_until="commit")
        opened.wait_for_selector("#verdicts tr")
        words = "There is no picture: this browser has no WebGL 2 here"
        opened.get_by_text(words).first.wait_for()


def test_the_picture_is_there_and_a_row_looks_at_its_place(page):
    page.wait_for_selector("#picture canvas")
    row = page.locator("#near button.look").first
    words = row.text_content()
    row.click()
    assert page.locator("#picture .said").text_content() == words
    page.locator("#picture .ring").wait_for()


def test_a_page_of_a_bench_that_was_started_anew_is_told_to_open_its_address(page):
    context = page.context.browser.new_context()
    other = context.new_page()
    other.goto(page.entrance, wait_until="commit")
    other.wait_for_selector("#verdicts tr")
    context.clear_cookies()  # as where the secret is another one
    found = other.evaluate(
        """async () => {
            const { connect } = await import("/page/connection.js");
            return new Promise((done) => connect(() => {}, done));
        }"""
    )
    context.close()
    assert found == "the bench was started anew: open the address that it has printed"


def test_the_page_speaks_to_its_server_alone_and_without_errors(page):
    assert faults(page) == []
    hosts = {address.split("/")[2] for address in page.asked}
    assert len(hosts) == 1 and "token" not in page.url


def test_a_slider_moves_by_keys_and_each_key_counts(page):
    slider = elbow(page)
    assert slider.input_value() == "75"
    for _ in range(12):
        slider.press("ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    assert slider.input_value() == "76.2"
    assert slider.get_attribute("aria-valuetext") == "76.2 °"
    page.wait_for_timeout(500)
    for _ in range(12):  # one step where the keys came within a second of each other
        if page.title().startswith("●"):
            page.get_by_role("button", name="Undo").click()
            page.wait_for_timeout(500)
    page.wait_for_function("() => !document.title.startsWith('●')")
    assert slider.input_value() == "75"


def test_a_hand_takes_hold_of_a_control_and_the_verdict_follows(page):
    page.locator("#limb-name").select_option("right hand")
    page.locator("#limb-control").select_option("propeller")
    before = page.locator("#limb-x").input_value()
    page.get_by_role("button", name="Reach").click()
    page.wait_for_function(
        "() => document.getElementById('status').textContent.includes('propeller')"
    )
    assert page.locator("#status").text_content() == "right hand on propeller"
    assert page.locator("#limb-x").input_value() != before
    page.wait_for_selector("#verdicts td.failed")
    assert "room between the two" in page.locator("#verdicts tr").first.inner_text()
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => document.getElementById('failed').textContent === '(all passed)'")


def saved(page):
    page.get_by_role("button", name="Save").click()
    page.wait_for_function(
        "() => document.getElementById('status').textContent.startsWith('saved')"
    )


def undone_and_saved(page):
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => document.title.startsWith('●')")
    page.get_by_role("button", name="Save").click()
    page.wait_for_function("() => !document.title.startsWith('●')")


def test_the_study_is_saved_from_the_page(page, study):
    before = study.read_text()
    elbow(page).press("ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    saved(page)
    assert "angles: {RE: {flexion: 75.1}}" in study.read_text()
    undone_and_saved(page)
    assert study.read_text() == before
    assert faults(page) == []


def grip(page):
    """Where the middle and the arrows are in the window."""
    page.get_by_role("button", name="corner").click()
    stage = page.locator("#picture .stage")
    seen = []
    for _ in range(50):  # until the picture stands still, however busy the machine is
        page.wait_for_timeout(300)
        seen.append(stage.get_attribute("data-grip"))
        if seen[-1] and seen[-3:] == [seen[-1]] * 3:
            break
    places = json.loads(seen[-1])
    box = page.locator("#picture canvas").bounding_box()
    return [(box["x"] + x, box["y"] + y) for x, y in places]


def drag(page, start, by, key=None):
    x, y = start
    page.mouse.move(x, y)
    page.mouse.down()
    for share in (0.4, 0.7, 1.0):
        page.mouse.move(x + share * by[0], y + share * by[1])
    page.wait_for_function("() => document.title.startsWith('●')")
    if key:
        page.keyboard.press(key)
        page.wait_for_function("() => !document.title.startsWith('●')")
    page.mouse.up()
    page.wait_for_timeout(300)


def numbers(page, form):
    return [float(page.locator(f"#{form}-{axis}").input_value()) for axis in "xyz"]


def undone(page):
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => !document.title.startsWith('●')")


def test_a_hand_is_dragged_and_escape_puts_it_back(page):
    page.get_by_label("hand or foot").check()
    page.locator("#limb-name").select_option("right hand")
    before = numbers(page, "limb")
    drag(page, grip(page)[0], (25, -20))
    after = numbers(page, "limb")
    assert math.dist(after, before) > 20.0
    undone(page)
    assert numbers(page, "limb") == before
    drag(page, grip(page)[0], (25, -20), key="Escape")
    page.wait_for_timeout(300)
    assert numbers(page, "limb") == before
    assert page.get_by_role("button", name="Undo").is_disabled()


def fingers(page, kind, *places):
    points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
    page.hands.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_a_finger_drags_a_hand_up_and_a_second_one_changes_nothing(page):
    page.hands = page.context.new_cdp_session(page)
    before = numbers(page, "limb")
    x, y = grip(page)[0]
    fingers(page, "touchStart", (x, y))
    for share in (0.4, 0.7):
        fingers(page, "touchMove", (x + 4 * share, y - 25 * share))
    fingers(page, "touchStart", (x + 4, y - 25), (x + 150, y))
    fingers(page, "touchMove", (x + 4, y - 25), (x + 150, y + 60))
    fingers(page, "touchEnd")
    page.wait_for_function("() => document.title.startsWith('●')")
    page.wait_for_timeout(300)
    seen = json.loads(page.locator("#picture .stage").get_attribute("data-grip"))[0]
    box = page.locator("#picture canvas").bounding_box()
    assert math.dist((box["x"] + seen[0], box["y"] + seen[1]), (x + 4, y - 25)) < 3.0
    undone(page)
    assert numbers(page, "limb") == before


def test_a_click_at_the_arrows_takes_what_is_there_and_moves_nothing(page):
    middle = grip(page)[0]
    page.mouse.click(*middle)
    name = page.locator("#picture .said").text_content()
    assert name.startswith("pilot: right hand") and page.get_by_label("hand or foot").is_checked()
    page.mouse.click(*middle)  # again: what stands before the hand
    assert page.locator("#picture .said").text_content() != name
    page.wait_for_timeout(200)
    assert page.get_by_role("button", name="Undo").is_disabled()


def test_a_part_is_dragged_along_its_arrow_alone(page):
    page.locator("#thing-name").select_option("parts throttle_lever")
    assert page.get_by_label("part or control").is_checked()
    middle, ahead, *_ = grip(page)
    drag(page, ahead, [0.5 * (a - b) for a, b in zip(ahead, middle, strict=True)])
    moved = numbers(page, "thing")
    assert moved[0] > 20.0 and moved[1:] == [0.0, 0.0]
    assert page.locator("#status").text_content() == "throttle goes along"
    page.get_by_role("button", name="Put back").click()
    page.wait_for_function("() => document.getElementById('thing-back').disabled")
    assert numbers(page, "thing") == [0.0, 0.0, 0.0]
    page.wait_for_function("() => !document.title.startsWith('●')")


def test_the_seat_is_dragged_within_its_travel(page):
    page.get_by_label("seat", exact=True).check()
    slider = page.locator("#seat").get_by_role("slider").first
    middle, ahead, *_ = grip(page)
    drag(page, ahead, [5.0 * (a - b) for a, b in zip(ahead, middle, strict=True)])
    assert slider.input_value() == slider.get_attribute("max")
    undone(page)
    page.get_by_label("nothing").check()


def test_a_control_is_moved_by_number_and_saved(page, study):
    before = study.read_text()
    page.locator("#thing-name").select_option("controls flaps")
    page.locator("#thing-z").fill("12.5")
    page.locator("#thing-z").press("Enter")
    page.wait_for_function("() => document.title.startsWith('●')")
    saved(page)
    assert "moved: [{controls: [flaps], alone: true, by: [0, 0, 12.5]}]\n" in study.read_text()
    undone_and_saved(page)
    assert study.read_text() == before
    assert faults(page) == []


def test_what_is_clicked_in_the_picture_is_chosen(page):
    page.get_by_label("nothing").check()
    page.get_by_role("button", name="corner").click()
    page.wait_for_timeout(800)
    box = page.locator("#picture canvas").bounding_box()
    page.mouse.click(box["x"] + 0.2 * box["width"], box["y"] + 0.62 * box["height"])
    assert page.get_by_label("part or control").is_checked()
    said = page.locator("#picture .said").text_content()
    assert page.locator("#thing-name option:checked").text_content() == said


def said(page, words):
    page.wait_for_function(
        "(words) => document.getElementById('status').textContent.includes(words)", arg=words
    )


def test_a_person_gets_another_size_and_clothes_and_they_are_saved(page, study):
    before = study.read_text()
    page.locator("#size-sex").select_option("female")
    said(page, "pilot: a woman")
    page.get_by_label("stature, percentile").fill("5")
    page.get_by_label("stature, percentile").press("Enter")
    said(page, "pilot: a woman, 1525 mm tall")
    assert page.get_by_label("stature in mm").input_value() == "1525"
    page.get_by_label("helmet").check()
    said(page, "with helmet")
    page.wait_for_timeout(1200)
    saved(page)
    line = "position: reference, size: {sex: female, measures: {stature: 1525}}, clothes: [helmet]}"
    assert line in study.read_text()
    while page.get_by_role("button", name="Undo").is_enabled():
        page.get_by_role("button", name="Undo").click()
        page.wait_for_timeout(300)
    assert page.locator("#size-sex").input_value() == ""
    page.get_by_role("button", name="Save").click()
    page.wait_for_function("() => !document.title.startsWith('●')")
    assert study.read_text() == before
    assert faults(page) == []


def test_a_smaller_person_is_off_the_pedals_and_a_button_predicts_the_posture(page):
    page.locator("#size-sex").select_option("female")
    off = page.locator("#trouble li", has_text="left foot")
    off.wait_for()
    assert "from left seat left pedal (19 mm as opened)" in off.text_content()
    page.wait_for_selector("#verdicts:not(.waiting) tr")
    assert "but see below" in page.locator("#failed").text_content()
    off.get_by_role("button", name="Predict the posture (pilot)").click()
    page.get_by_role("button", name="let the seat go along (pilot)").wait_for()
    assert page.locator("#posture-now").text_content() == "predicted"
    while page.get_by_role("button", name="Undo").is_enabled():
        page.get_by_role("button", name="Undo").click()
        page.wait_for_timeout(300)
    page.wait_for_selector("#trouble", state="hidden")


def test_the_view_of_a_person_says_its_field_and_is_left_by_escape(page):
    page.get_by_role("button", name="eye", exact=True).click()
    said = page.locator("#picture .said")
    page.wait_for_function(
        "() => document.querySelector('#picture .said').textContent.includes('75° high')"
    )
    assert said.text_content().startswith("pilot's view")
    free = "#field-free:text-matches('points[)]$')"  # counted finely, once it rests
    page.wait_for_selector(free)
    picture = page.locator("#field-picture")
    assert "within 60° of the line of sight: " in picture.get_attribute("aria-label")
    before = page.locator("#field-gaze").text_content()
    assert before == "Eyes 5° up in the head; head straight ahead"
    canvas = page.locator("#picture canvas")
    for _ in range(6):
        canvas.press("ArrowLeft")
    page.wait_for_selector("#field-gaze:text-matches('^Eyes 15° left.*head 1[0-9]° left')")
    row = page.locator("#field-rows tr", has_text="windscreen bow")
    assert row.get_by_role("cell").count() == 4
    page.locator("#field-within").select_option("30")
    page.wait_for_selector("#field-picture[aria-label*='within 30°']")
    page.wait_for_selector(free)
    words = page.locator("#field-free").text_content()
    page.locator("#thing-name").select_option("parts windscreen_bow")
    page.locator("#thing-y").fill("150")
    page.keyboard.press("Enter")
    page.wait_for_function(
        "(words) => document.querySelector('#field-free').textContent !== words", arg=words
    )
    undone(page)
    page.locator("#field-within").select_option("60")
    canvas.press("Escape")
    assert page.locator("#field").is_hidden()
    assert page.get_by_role("button", name="eye").get_attribute("aria-pressed") == "false"
    assert "75°" not in said.text_content()


def test_a_distance_becomes_a_criterion_that_is_undone(page):
    page.locator("#pair-of").select_option("segment\tpilot\thead")
    page.locator("#pair-to").select_option("part\tcanopy")
    page.get_by_role("button", name="Measure", exact=True).click()
    page.wait_for_selector("#measured:not([hidden])")
    assert "pilot: head to canopy: 81.6 mm; x +3.6" in page.locator("#measured-words").inner_text()
    page.locator("#pair-limit").fill("90")
    page.get_by_role("button", name="Make a criterion").click()
    page.wait_for_selector("#verdicts td.failed")
    assert (
        "pilot's head to canopy, at least 90 mm" in page.locator("#verdicts tr").first.inner_text()
    )
    undone(page)
    page.get_by_role("button", name="Dismiss").click()
    assert page.locator("#measured").is_hidden()


def test_two_points_are_clicked_and_measured(page):
    page.get_by_role("button", name="Measure two points").click()
    box = page.locator("#picture canvas").bounding_box()
    for share in (0.45, 0.55):
        page.mouse.click(box["x"] + share * box["width"], box["y"] + 0.55 * box["height"])
    page.wait_for_selector("#measured:not([hidden])")
    assert " mm; x " in page.locator("#measured-words").inner_text()
    assert page.locator("#picture .over span", has_text=" mm").is_visible()
    page.get_by_role("button", name="Dismiss").click()
    assert faults(page) == []


def test_what_is_refused_is_put_back_and_said(page):
    field = page.locator("#thing-x")
    for typed, words in (("99999", "a move of up to 10 m is possible"), ("", "a number of mm")):
        field.fill(typed)
        field.press("Enter")
        said(page, words)
        assert field.input_value() == "0.0"
    page.locator("#size-sex").select_option("female")
    said(page, "pilot: a woman")
    field = page.get_by_label("stature, percentile")
    field.fill("150")
    field.press("Enter")
    said(page, "a percentile lies between 0 and 100, got 150")
    assert field.input_value() == "50.0"
    undone(page)


def test_keys_go_to_cases_and_list_all_commands(page):
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("]")
    page.wait_for_function("() => document.getElementById('case').value === 'looking left'")
    page.keyboard.press("Control+k")
    page.keyboard.type("case: cruise")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.getElementById('case').value === 'cruise'")
    assert page.locator("#commands").is_hidden()
    page.keyboard.press("?")
    assert page.get_by_role("heading", name="Keys").is_visible()
    page.keyboard.press("Escape")
    assert page.locator("#keys").is_hidden()
    page.keyboard.press(" ")
    said(page, "this case is a posture")


def test_a_late_answer_leaves_what_the_page_refused_since(page):
    page.evaluate(
        """() => {
            document.activeElement.blur();
            document.getElementById("took").textContent = "";
            for (const key of ["]", " "]) document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
        }"""
    )
    page.wait_for_function("() => document.getElementById('took').textContent")
    assert "this case is a posture" in page.locator("#status").text_content()
    elbow(page).press("ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    assert page.locator("#status").text_content() == ""
    undone(page)


def test_escape_puts_a_slider_back_and_shift_takes_ten_steps(page):
    slider = elbow(page)
    slider.press("Shift+ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    assert slider.input_value() == "76"
    undone(page)
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.5 * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], y, steps=3)
    page.wait_for_function("() => document.title.startsWith('●')")
    page.keyboard.press("Escape")
    page.wait_for_function("() => !document.title.startsWith('●')")
    page.mouse.up()
    page.wait_for_timeout(200)
    assert slider.input_value() == "75"
    assert page.get_by_role("button", name="Undo").is_disabled()


def test_near_pairs_say_which_overlap_is_allowed(page):
    page.wait_for_selector("#near tr")
    rows = [row.split("\t") for row in page.locator("#near").inner_text().splitlines()]
    overlaps = [row for row in rows if row[0].startswith("−")]
    assert overlaps and all(row[1].strip().endswith("allowed") for row in overlaps)
    assert page.locator("#near td.failed").count() == 0


def legend(page, words):
    page.wait_for_function(
        "(words) => document.querySelector('.over .saved').textContent.includes(words)", arg=words
    )


def purple(found):
    """How many pixels of a picture have the colour of the ghost."""
    above = np.asarray(found).astype(int)[:-90]  # the legend
    red, green, blue = above.transpose(2, 0, 1)
    return int(((blue > green + 25) & (red > green + 12)).sum())


def test_the_saved_state_is_a_ghost_beside_what_is(page):
    page.evaluate("() => document.activeElement.blur()")
    page.get_by_role("button", name="left", exact=True).click()
    before = purple(pixels(page, "#picture canvas"))
    page.keyboard.press("g")
    legend(page, "nothing moved since saved")
    said(page, "nothing moved since saved")
    assert page.get_by_role("button", name="ghost").get_attribute("aria-pressed") == "true"
    as_saved = pixels_once(page, "#picture canvas", lambda found: purple(found) <= before + 20)
    assert purple(as_saved) <= before + 20  # it lies behind who is in the same place
    elbow(page).fill("20")
    legend(page, "moved since saved: pilot up to ")
    page.locator("#thing-name").select_option("parts instrument_panel")
    page.locator("#thing-z").fill("200")
    page.locator("#thing-z").press("Enter")
    legend(page, "instrument panel 200.0 mm")
    page.get_by_label("nothing").check()
    moved = pixels_once(page, "#picture canvas", lambda found: purple(found) > before + 300)
    assert purple(moved) > before + 300
    page.get_by_role("button", name="Undo").click()
    page.wait_for_timeout(300)
    undone(page)
    legend(page, "nothing moved since saved")
    page.get_by_role("button", name="ghost").click()
    assert page.locator(".over .saved").is_hidden()
    without = pixels_once(page, "#picture canvas", lambda found: purple(found) == before)
    assert purple(without) == before
    assert faults(page) == []


CLIPBOARD = """async () => {
  const [item] = await navigator.clipboard.read();
  const bytes = new Uint8Array(await (await item.getType("image/png")).arrayBuffer());
  return btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ""));
}"""
NEVER = "() => { navigator.clipboard.write = () => Promise.reject(new Error('not allowed')); }"


def orange(found):
    """How many pixels have the colour of the arrow ahead."""
    return int((np.abs(np.asarray(found).astype(int) - (206, 84, 20)).sum(axis=2) < 30).sum())


def test_the_picture_is_copied_in_full_without_handles_or_downloaded(page):
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.get_by_label("hand or foot").check()
    page.get_by_role("button", name="left", exact=True).click()
    page.locator("#pair-of").select_option("segment\tpilot\thead")
    page.get_by_role("button", name="Measure", exact=True).click()
    shown = pixels_once(page, "#picture canvas", lambda found: orange(found) > 50)
    box = page.locator("#picture canvas").bounding_box()
    size = (round(box["width"]), round(box["height"]))
    page.keyboard.press("p")
    said(page, f"copied: the picture is in the clipboard, {size[0]} × {size[1]} pixels")
    copied = Image.open(io.BytesIO(base64.b64decode(page.evaluate(CLIPBOARD))))
    assert (copied.format, copied.size) == ("PNG", size)
    copied = copied.convert("RGB")
    assert orange(shown) > orange(copied) + 50
    alike = np.abs(np.asarray(copied).astype(int) - np.asarray(shown.resize(size)))
    assert np.median(alike) <= 2 and len(copied.getcolors(1 << 24)) > 1000
    page.evaluate(NEVER)
    with page.expect_download() as found:
        page.get_by_role("button", name="copy").click()
    assert found.value.suggested_filename == "trainer_cruise.png"
    kept = Image.open(found.value.path()).convert("RGB")
    assert np.array_equal(np.asarray(kept), np.asarray(copied))
    said(page, "downloaded as trainer_cruise.png")
    page.get_by_label("nothing").check()
    page.get_by_role("button", name="Dismiss").click()
    assert faults(page) == []


def test_a_film_says_how_far_it_is_and_is_ended_by_its_button(page):
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("m")
    said(page, " of 150; M or the button ends it")
    page.get_by_role("button", name="end film").click()
    said(page, "the film was ended, nothing is kept of it")
    page.get_by_role("button", name="film", exact=True).wait_for()
    assert faults(page) == []


def frames_in(path, name):
    """The number of frames of a film."""
    if name.endswith(".mp4"):
        return pytest.importorskip("imageio_ffmpeg").count_frames_and_secs(str(path))[0]
    with Image.open(path) as film:
        return film.n_frames


def test_every_name_in_the_page_is_of_one_element(page):
    twice = page.evaluate("""() => {
      const names = [...document.querySelectorAll("[id]")].map((one) => one.id);
      return names.filter((name, k) => names.indexOf(name) !== k);
    }""")
    assert twice == []


def test_a_study_of_motions_alone_is_opened_without_errors(page):
    few = "import workbench.live.looking as looking\nlooking.FPS = 2.0"
    with served("trainer_crash", few) as address:
        opened = page.context.browser.new_page()
        opened.set_default_timeout(60_000)
        wrong = []
        opened.on("pageerror", lambda error: wrong.append(str(error)))
        opened.goto(address, wait_until="commit")
        opened.wait_for_function("() => document.getElementById('case').length === 2")
        opened.wait_for_function("() => document.getElementById('who').hidden")
        opened.keyboard.press(" ")  # played once it is there
        opened.wait_for_selector("#near tr")
        opened.wait_for_function("() => Number(document.querySelector('.film input').value) > 0")
        opened.keyboard.press(" ")
        opened.set_viewport_size({"width": 420, "height": 300})
        with opened.expect_download() as film:
            opened.keyboard.press("m")
        assert film.value.suggested_filename.startswith("trainer_crash_the_lap_belt_alone.")
        said(opened, "a film of 9 frames: downloaded as trainer_crash_the_lap_belt_alone.")
        assert frames_in(film.value.path(), film.value.suggested_filename) == 9
        assert wrong == []
        opened.close()


@pytest.mark.parametrize("width", [420, 1000, 1600])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_of_the_page_is_wider_than_the_window(page, width, scheme):
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(color_scheme=scheme)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width


STANDS = """study: stands
length: mm
environment: trainer
people:
  mechanic: {body: adult_male, detail: coarse, stand: {on: [400, 900, 0], yaw: -90}}
cases:
  - {name: beside, people: {mechanic: {posture: standing}}}
criteria:
  - {name: joints, check: stops}
  - {name: latch, check: reach, controls: [left_canopy_latch]}
"""


@pytest.mark.nightly
def test_of_who_stands_no_harness_and_no_seat_is_spoken(tmp_path):
    path = tmp_path / "stands.yaml"
    path.write_text(STANDS)
    with (
        served(path) as address,
        playwright.sync_playwright() as running,
        launched(running) as browser,
    ):
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.set_default_timeout(300_000)
        page.goto(address, wait_until="commit")
        page.wait_for_selector("#verdicts tr")
        words = page.locator("main").inner_text()
        assert "What moves in verdicts of reach" in words and "Harness" not in words
        assert "3: bends and steps" in page.locator("#harness").inner_text()
        assert page.locator("#seat").inner_text() == "" and page.locator("#prediction").is_hidden()
