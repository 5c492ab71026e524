"""What the page on displays says is run, and its pictures are there."""

from __future__ import annotations

import re

from tests.conftest import ROOT

PAGE = (ROOT / "docs" / "displays.md").read_text()


def test_the_code_on_the_page_runs() -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    assert len(blocks) == 1
    made: dict[str, object] = {}
    exec(blocks[0], made)
    assert made["picture"].size == (320, 320)  # type: ignore[attr-defined]


def test_every_picture_on_the_page_is_there_and_small() -> None:
    pictures = re.findall(r"\]\((images/[^)]+)\)", PAGE)
    assert len(pictures) == 9
    assert all((ROOT / "docs" / name).stat().st_size < 100_000 for name in pictures)


def test_the_sizes_of_difference_on_the_page_are_those_of_its_formula() -> None:
    for t, k, share in ((0, 0.1, 0.005), (0, 0.2, 0.02), (0.36, 0.1, 0.10), (0.7, 0.05, 0.25)):
        assert abs(((1 + t * t - k * k) ** 0.5 + t * k) / (1 - k * k) - 1 - share) < 0.015
