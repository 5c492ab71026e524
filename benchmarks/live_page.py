"""Time from a key on a slider of the live bench, and from a pointer that drags a hand, to the number on
its page, in Debian's chromium.

    python benchmarks/live_page.py [study]

WebGL is drawn in software. The picture is shown while the keys are pressed.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np
from playwright.sync_api import Page, sync_playwright

CHROMIUM = "/usr/bin/chromium"
KEYS = 80
PAUSE = 120
"""Time between two keys [ms]."""
WATCH = """(kind) => {
  window.taken = [];
  let begun = 0;
  addEventListener(kind, (event) => (begun ||= event.timeStamp), true);
  new MutationObserver(() => {
    if (begun) taken.push(performance.now() - begun);
    begun = 0;
  }).observe(document.getElementById("near"), { childList: true });
}"""
"""Notes the time from each key, or from the first move of a pointer after the last answer, to the next
list of what is nearest [ms]."""


def measure(page: Page, address: str) -> None:
    """Print how long the page takes to open, and to answer keys."""
    begin = time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_selector("#near tr")
    print(f"opened to first numbers {time.perf_counter() - begin:.2f} s")
    page.wait_for_selector("#verdicts tr")
    page.wait_for_timeout(3000)
    keys(page)
    hand(page)


def keys(page: Page) -> None:
    """Print how long keys on the slider of a joint take."""
    page.evaluate(WATCH, "keydown")
    page.locator("#joints input[type=range]").first.focus()
    for number in range(KEYS):
        page.keyboard.press("ArrowRight" if number % 20 < 10 else "ArrowLeft")
        page.wait_for_timeout(PAUSE)
    report("key to number", page)


def hand(page: Page) -> None:
    """Print how long a hand takes that is dragged in the picture, by the middle of its arrows."""
    page.get_by_label("hand or foot").check()
    page.locator("#limb-name").select_option("right hand")
    page.get_by_role("button", name="corner").click()
    page.wait_for_function("() => document.querySelector('#picture .stage').dataset.grip")
    page.wait_for_timeout(1000)
    middle = json.loads(page.locator("#picture .stage").get_attribute("data-grip") or "")[0]
    box = page.locator("#picture canvas").bounding_box()
    assert box is not None
    x, y = box["x"] + middle[0], box["y"] + middle[1]
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(WATCH, "pointermove")
    for number in range(KEYS):
        turn = 2.0 * np.pi * number / 20.0
        page.mouse.move(x + 12.0 * np.sin(turn), y - 12.0 * (1.0 - np.cos(turn)))
        page.wait_for_timeout(PAUSE)
    page.mouse.up()
    report("hand by its arrows to number", page)


def report(what: str, page: Page) -> None:
    """Print the times that were noted."""
    taken = np.array(page.evaluate("taken"))
    print(
        f"{what} median {np.median(taken):.1f} ms, 95th percentile "
        f"{np.quantile(taken, 0.95):.1f}, {len(taken)} of {KEYS} answered before the next"
    )


def main() -> None:
    """Serve a study and measure its page."""
    study = sys.argv[1] if len(sys.argv) > 1 else "trainer_clearance"
    command = [sys.executable, "-m", "workbench", "live", study, "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        address = next(word for word in server.stdout.readline().split() if "://" in word)
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=CHROMIUM, args=["--no-sandbox", "--enable-unsafe-swiftshader"]
            )
            measure(browser.new_page(viewport={"width": 1500, "height": 900}), address)
            browser.close()
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()
