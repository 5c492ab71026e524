"""The page of the live bench in a browser: Chromium where it and Playwright are installed."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest

from tests.conftest import ROOT

pytest.importorskip("starlette", reason="the extra `live` is not installed")
playwright = pytest.importorskip(
    "playwright.sync_api", reason="Playwright is not installed: pip install playwright"
)
CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="there is no Chromium: apt install chromium"
)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    return path


@pytest.fixture(scope="module")
def page(study):
    command = [sys.executable, "-m", "workbench", "live", str(study), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        try:
            address = running.stdout.readline().strip()
            with playwright.sync_playwright() as started:
                browser = started.chromium.launch(
                    executable_path=CHROMIUM, args=["--no-sandbox", "--enable-unsafe-swiftshader"]
                )
                opened = browser.new_page(viewport={"width": 1400, "height": 900})
                opened.set_default_timeout(120_000)
                opened.said = []
                opened.asked = []
                opened.on("console", lambda message: opened.said.append(message.text))
                opened.on("pageerror", lambda error: opened.said.append(str(error)))
                opened.on("request", lambda request: opened.asked.append(request.url))
                opened.goto(address)
                opened.wait_for_selector("#verdicts tr")
                yield opened
                browser.close()
        finally:
            running.terminate()
            running.wait(20)


def elbow(page):
    return page.locator("fieldset", has_text="right elbow").get_by_role("slider").first


def faults(page):
    """What the page says of itself; drivers of graphics tell of their pace."""
    return [words for words in page.said if "GL Driver Message" not in words]


def test_the_picture_is_there_and_a_row_looks_at_its_place(page):
    page.wait_for_selector("#picture canvas")
    row = page.locator("#near button.look").first
    words = row.text_content()
    row.click()
    assert page.locator("#picture .said").text_content() == words
    assert page.locator("#picture .ring").is_visible()


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
    page.wait_for_timeout(500)
    assert slider.input_value() == "76.2"
    assert slider.get_attribute("aria-valuetext") == "76.2 °"
    for _ in range(12):  # one step where the keys came within a second of each other
        if page.title().startswith("●"):
            page.get_by_role("button", name="Undo").click()
            page.wait_for_timeout(500)
    page.wait_for_function("() => !document.title.startsWith('●')")
    assert slider.input_value() == "75"


def test_a_hand_takes_hold_of_a_control_and_the_verdict_follows(page):
    page.locator("#limb-name").select_option("right hand")
    page.locator("#limb-control").select_option("propeller")
    page.get_by_role("button", name="Reach").click()
    page.wait_for_function(
        "() => document.getElementById('status').textContent.includes('propeller')"
    )
    assert page.locator("#status").text_content() == "right hand on propeller"
    page.wait_for_selector("#verdicts td.failed")
    assert "room between the two" in page.locator("#verdicts tr").first.inner_text()
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => document.getElementById('failed').textContent === '(all passed)'")


def test_the_study_is_saved_from_the_page(page, study):
    before = study.read_text()
    elbow(page).press("ArrowRight")
    page.wait_for_function("() => document.title.startsWith('●')")
    page.get_by_role("button", name="Save").click()
    page.wait_for_function(
        "() => document.getElementById('status').textContent.startsWith('saved')"
    )
    assert "angles: {RE: {flexion: 75.1}}" in study.read_text()
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => document.title.startsWith('●')")
    page.get_by_role("button", name="Save").click()
    page.wait_for_function("() => !document.title.startsWith('●')")
    assert study.read_text() == before
    assert faults(page) == []


@pytest.mark.parametrize("width", [420, 1000, 1600])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_of_the_page_is_wider_than_the_window(page, width, scheme):
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(color_scheme=scheme)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
