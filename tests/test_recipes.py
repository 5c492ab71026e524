"""Stored files are made from what is there now (`tools/recipes.py`)."""

from __future__ import annotations

import pytest

from tests.conftest import tracked
from tools import recipes


def test_what_is_stored_was_made_from_what_is_there():
    assert "\n".join(recipes.report(recipes.stored())) == ""


def test_every_stored_motion_and_body_has_a_recipe_or_is_made_by_a_test():
    made = {path for recipe in recipes.RECIPES for path in recipe.makes}
    by_tests = {"bodies/bubbleman.yaml"}
    by_hand = {"bodies/dog_postures.yaml", "bodies/human_postures.yaml"}
    there = {
        path.relative_to(recipes.ROOT).as_posix()
        for pattern in ("bodies/*.yaml", "bodies/*.npz", "studies/motions/*")
        for path in tracked(pattern)
    }
    assert there - by_tests - by_hand <= made


def kept(folder, monkeypatch):
    """A recipe of one file that reads a script and a table, and its digests."""
    monkeypatch.setattr(recipes, "ROOT", folder)
    (folder / "made.csv").write_text("# of today\n1, 2\n")
    (folder / "make.py").write_text('"""Makes it."""\nSIZE = 2\n')
    (folder / "table.yaml").write_text("# a table\nsize: 2  # mm\n")
    recipe = recipes.Recipe(("made.csv",), "make", ("make.py", "*.yaml"))
    return recipe, {"made.csv": recipes.digests(recipe)}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("make.py", "SIZE = 3\n"),
        ("table.yaml", "size: 3\n"),
        ("made.csv", "1, 3\n"),
        ("other.yaml", "size: 2\n"),
    ],
)
def test_a_changed_or_added_input_or_a_changed_file_is_told(tmp_path, monkeypatch, name, text):
    recipe, stamps = kept(tmp_path, monkeypatch)
    assert recipes.stale(recipe, stamps) == []
    (tmp_path / name).write_text(text)
    assert recipes.stale(recipe, stamps) == [name]
    monkeypatch.setattr(recipes, "RECIPES", (recipe,))
    (line,) = recipes.report(stamps)
    assert name in line
    assert "python tools/recipes.py made.csv" in line


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("make.py", '"""Writes it."""\n\nSIZE = (\n    2  # mm\n)\n'),
        ("table.yaml", "size: 2\n# a table\n"),
    ],
)
def test_comments_and_layout_do_not_count(tmp_path, monkeypatch, name, text):
    recipe, stamps = kept(tmp_path, monkeypatch)
    (tmp_path / name).write_text(text)
    assert recipes.stale(recipe, stamps) == []
