"""Time from a key on a slider of the live bench to the number on its page, in Debian's chromium.

    python benchmarks/live_page.py [study]

WebGL is drawn in software. The picture is shown while the keys are pressed.
"""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np
from playwright.sync_api import Page, sync_playwright

CHROMIUM = "/usr/bin/chromium"
KEYS = 80
PAUSE = 120
"""Time between two keys [ms]."""
WATCH = """() => {
  window.taken = [];
  let pressed = 0;
  addEventListener("keydown", (event) => (pressed = event.timeStamp), true);
  new MutationObserver(() => {
    if (pressed) taken.push(performance.now() - pressed);
    pressed = 0;
  }).observe(document.getElementById("near"), { childList: true });
}"""
"""Notes the time from each key, as it is pressed, to the next list of what is nearest [ms]."""


def measure(page: Page, address: str) -> None:
    """Print how long the page takes to open, and to answer keys."""
    begin = time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_selector("#near tr")
    print(f"opened to first numbers {time.perf_counter() - begin:.2f} s")
    page.wait_for_selector("#verdicts tr")
    page.wait_for_timeout(3000)
    page.evaluate(WATCH)
    page.locator("#joints input[type=range]").first.focus()
    for number in range(KEYS):
        page.keyboard.press("ArrowRight" if number % 20 < 10 else "ArrowLeft")
        page.wait_for_timeout(PAUSE)
    taken = np.array(page.evaluate("taken"))
    print(
        f"key to number median {np.median(taken):.1f} ms, 95th percentile "
        f"{np.quantile(taken, 0.95):.1f}, {len(taken)} of {KEYS} keys answered before the next"
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
