"""A browser for tests of pages: Chromium by Playwright, and the Node that Playwright brings along."""

from __future__ import annotations

import contextlib
import io
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

__all__ = ["CHROMIUM", "launched", "node", "opened", "pixels", "pixels_once", "served", "started"]

_NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in _NAMES if (path := shutil.which(name))), None)
"""Path of the browser; None where none is installed."""
SOFTWARE = ("--no-sandbox", "--enable-unsafe-swiftshader")


def node():
    """Path of the Node in Playwright's package; skips where it is absent."""
    playwright = pytest.importorskip("playwright", reason="playwright is not installed")
    path = Path(next(iter(playwright.__path__))) / "driver" / "node"
    if not path.is_file():
        pytest.skip("playwright brings no Node along here")
    return path


def started():
    """Playwright, to be started once for all tests of a module; skips where it is absent."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    return api.sync_playwright()


@contextlib.contextmanager
def launched(playwright, *arguments):
    """A running Chromium with software WebGL."""
    running = playwright.chromium.launch(
        executable_path=CHROMIUM, args=[*SOFTWARE, *arguments], timeout=120_000
    )
    try:
        yield running
    finally:
        running.close()


@contextlib.contextmanager
def opened(running, path, *, width=1000, dark=False, touch=False):
    """A page of a file with what went wrong in it: `faults` and `requests` are lists on it."""
    page = running.new_page(
        viewport={"width": width, "height": 760},
        color_scheme="dark" if dark else "light",
        has_touch=touch,
    )
    page.set_default_timeout(60_000)
    page.faults = []
    page.requests = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.on("request", lambda asked: page.requests.append(asked.url))
    page.add_init_script(
        "window.violations = [];"
        "addEventListener('securitypolicyviolation', (e) => violations.push(e.violatedDirective));"
    )
    page.goto(path.as_uri())
    try:
        yield page
    finally:
        page.close()


def pixels(page, selector="canvas"):
    """The picture of an element (height, width, 3) as it is on the screen, at rest."""
    page.wait_for_timeout(900)
    data = page.locator(selector).first.screenshot()
    return Image.open(io.BytesIO(data)).convert("RGB")


def pixels_once(page, selector, holds):
    """The first picture of an element of which something holds; the last of 40 where it never does.
    A machine that is busy paints later than `pixels` waits."""
    for _ in range(40):
        found = pixels(page, selector)
        if holds(found):
            break
    return found


@contextlib.contextmanager
def served(source, before=""):
    """The address of a bench that is served until the context ends; before: what is done first."""
    run = (
        f"{before}\nfrom workbench.cli import main\nmain(['live', {str(source)!r}, '--no-browser'])"
    )
    command = [sys.executable, "-c", run]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        try:
            yield running.stdout.readline().strip()
        finally:
            running.terminate()
            running.wait(20)
