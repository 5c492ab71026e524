"""Indexes on disk: believed only where they are whole and ours, and never in the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import environment_of
from tests.test_fast import soup
from workbench.contact import distance_fields
from workbench.contact.index_cache import MOST_FILES, cache_folder, cached
from workbench.model.content import content_key
from workbench.model.environment import Control

KEY = content_key("test", np.arange(3))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept"


def made_once(times):
    def make():
        times.append(1)
        return {"a": np.arange(5), "b": np.ones((2, 3), dtype=np.float32)}

    return make


def test_what_was_made_once_is_read_the_next_time(folder):
    times = []
    first, second = (cached(KEY, made_once(times)) for _ in range(2))
    assert len(times) == 1
    assert all(
        np.array_equal(first[name], second[name]) and first[name].dtype == second[name].dtype
        for name in "ab"
    )
    assert [path.suffix for path in folder.iterdir()] == [".index"]


DAMAGE = {
    "cut off": lambda data: data[:-9],
    "half": lambda data: data[: len(data) // 2],
    "empty": lambda data: b"",
    "another's": lambda data: b"hello",
    "zeroed": lambda data: bytes(len(data)),
    "garbage": lambda data: np.random.default_rng(1).bytes(len(data)),
    "a bit": lambda data: data[:100] + bytes([data[100] ^ 1]) + data[101:],
}


@pytest.mark.parametrize("change", DAMAGE)
def test_a_torn_or_foreign_file_is_made_anew(folder, change):
    times = []
    cached(KEY, made_once(times))
    path = next(folder.iterdir())
    path.write_bytes(DAMAGE[change](path.read_bytes()))
    assert np.array_equal(cached(KEY, made_once(times))["a"], np.arange(5))
    cached(KEY, made_once(times))
    assert len(times) == 2


def test_another_key_in_the_same_place_is_not_believed(folder):
    times = []
    cached(KEY, made_once(times))
    cached(KEY[:20] + bytes(len(KEY) - 20), made_once(times))
    assert len(times) == 2


@pytest.mark.parametrize("word", ["off", "0", ""])
def test_the_cache_can_be_switched_off(monkeypatch, word):
    monkeypatch.setenv("WORKBENCH_CACHE", word)
    assert cache_folder() is None
    times = []
    cached(KEY, made_once(times))
    cached(KEY, made_once(times))
    assert len(times) == 2


def test_a_folder_that_cannot_be_made_stops_nothing(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "file" / "kept"))
    assert np.array_equal(cached(KEY, made_once([]))["a"], np.arange(5))


def test_the_files_used_longest_ago_give_way(folder):
    for n in range(MOST_FILES + 3):
        cached(content_key("test", n), made_once([]))
    assert len(list(folder.iterdir())) == MOST_FILES


def test_a_field_from_disk_gives_the_same_answers_as_one_just_made(
    folder, one_arm, random_arm, monkeypatch
):
    monkeypatch.setattr(distance_fields, "WORTH_KEEPING", 10)
    placed = wb.place(one_arm, random_arm(80, 1))
    environment = environment_of(soup(1, 40))
    answers = []
    for _ in range(2):
        distance_fields._field_of.cache_clear()
        answers.append(wb.room(placed, environment, grid=True))
    assert len(list(folder.iterdir())) == 1
    assert np.array_equal(*answers, equal_nan=True)


def test_an_index_stays_where_a_control_moves_and_is_made_anew_where_a_part_does(
    folder, one_arm, random_arm, monkeypatch
):
    monkeypatch.setattr(distance_fields, "WORTH_KEEPING", 10)
    placed = wb.place(one_arm, random_arm(80, 1))
    environment = environment_of(soup(3, 40))
    knob = Control("knob", (0.0, 0.0, 1.0), "push", 1, environment.parts[0])
    others = [
        replace(environment, controls=(knob,), points={"eye": (0.0, 0.0, 1.0)}),
        replace(environment, circle_radius=environment.circle_radius + 1e-9),
    ]
    counts = []
    for one in (environment, *others):
        wb.room(placed, one, grid=True)
        counts.append(len(list(folder.iterdir())))
    assert counts == [1, 1, 2]


def test_environments_of_one_shape_share_one_index():
    environment = environment_of(soup(1, 40))
    seen = replace(environment, vertices=environment.vertices + 0.0, points={"eye": (0, 0, 1.0)})
    other = replace(environment, circle_radius=environment.circle_radius + 1e-9)
    one, same, another = (
        distance_fields.build_distance_field(each, ((0,),)) for each in (environment, seen, other)
    )
    assert same is one
    assert another is not one
