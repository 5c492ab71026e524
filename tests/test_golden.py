"""Vector pictures are the very texts that were looked at: tests/data/golden, renewed by python -m
tests.golden."""

from __future__ import annotations

import pytest

from tests.golden import FOLDER, PICTURES


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_its_golden_text_to_the_byte(name: str) -> None:
    assert PICTURES[name]() == (FOLDER / f"{name}.svg").read_text()


def test_golden_pictures_are_small_texts_and_none_is_left_over() -> None:
    files = sorted(FOLDER.iterdir())
    assert [path.stem for path in files] == sorted(PICTURES)
    assert all(path.stat().st_size < 8_000 for path in files)
