"""Compiled code that is kept goes when any kernel changes, whichever file it was made from."""

from __future__ import annotations

import os

import pytest

from workbench.kernels.stale import forget_stale


@pytest.fixture
def folder(tmp_path):
    """Two kernels in two rooms, with compiled code of one of them."""
    (tmp_path / "limbs" / "__pycache__").mkdir(parents=True)
    (tmp_path / "lanes.py").write_text("one = 1\n")
    (tmp_path / "limbs" / "steps.py").write_text("two = 2\n")
    forget_stale(tmp_path)
    for ending in ("nbi", "1.nbc"):
        (tmp_path / "limbs" / "__pycache__" / f"steps.go-1.py311.{ending}").write_text("machine code")
    return tmp_path


def kept(folder):
    return sorted(path.suffix for path in folder.rglob("*.nb?"))


def test_what_was_compiled_stays_while_no_kernel_changes(folder):
    assert not forget_stale(folder) and kept(folder) == [".nbc", ".nbi"]


def test_a_change_of_one_kernel_forgets_what_was_made_of_another(folder):
    (folder / "lanes.py").write_text("one = 11\n")
    assert forget_stale(folder) and not kept(folder)
    assert not forget_stale(folder)


def test_a_file_that_comes_or_goes_or_is_touched_is_a_change(folder):
    for change in (
        lambda: (folder / "new.py").write_text(""),
        lambda: (folder / "new.py").unlink(),
        lambda: os.utime(folder / "lanes.py", (1, 1)),
    ):
        change()
        assert forget_stale(folder) and not forget_stale(folder)


def test_python_files_of_the_cache_are_left_alone(folder):
    (folder / "limbs" / "__pycache__" / "steps.cpython-311.pyc").write_text("")
    (folder / "lanes.py").write_text("one = 11\n")
    forget_stale(folder)
    assert (folder / "limbs" / "__pycache__" / "steps.cpython-311.pyc").is_file()
