"""People as folders of bodies: named, measured right, the same bytes again, all of them or none."""

from __future__ import annotations

import csv
from functools import lru_cache

import pytest

import workbench as wb
from tests.conftest import REFERENCE, needs_real_input
from tests.family import write_family
from workbench import measure
from workbench.cli import main
from workbench.model.population import COCKPIT

BOUNDARY_CASES = REFERENCE / "boundary_cases_ansur2_95.csv"


def run(*words):
    return main(["people", *map(str, words)])


def rows_of(folder):
    return list(csv.DictReader((folder / "people.csv").read_text().splitlines()))


def test_percentile_people_are_bodies_that_show_their_measures(tmp_path, capsys):
    out = tmp_path / "men"
    assert (
        run(
            "percentile",
            "--sex",
            "male",
            "--p",
            5,
            95,
            "--measures",
            "stature,sitting_height",
            "--bodies",
            out,
        )
        == 0
    )
    assert sorted(path.name for path in out.iterdir()) == [
        "male_5.yaml",
        "male_95.yaml",
        "manifest.json",
        "people.csv",
    ]
    assert capsys.readouterr().out == f"{out}\n"
    for row in rows_of(out):
        body = wb.load_body(out / row["file"])
        assert 1000 * measure(body, ["stature"])["stature"] == pytest.approx(
            float(row["stature_mm"]), abs=0.06
        )
        assert body.mass[0].sum() == pytest.approx(float(row["mass_kg"]), abs=0.01)
        assert body.name == row["file"].removesuffix(".yaml")


def test_the_same_people_give_the_same_bytes_and_replace_earlier_ones(tmp_path):
    write_family(tmp_path)
    words = (
        "draw",
        "--count",
        4,
        "--seed",
        3,
        "--body",
        tmp_path / "adult.yaml",
        "bubbleman",
        "--bodies",
    )
    for name in ("one", "two", "two"):
        assert run(*words, tmp_path / name) == 0
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    drawn = wb.draw_people(wb.load_population_model("ansur2"), 4, seed=3)
    men, women = (
        [f"{sex}_{label}.yaml" for label in drawn.of_sex(sex).labels] for sex in ("male", "female")
    )
    assert files == sorted([*men, *women, "manifest.json", "people.csv"]) and len(files) == 6
    assert all(
        (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
        for name in files
    )


def test_boundary_people_are_called_what_they_are(tmp_path):
    assert (
        run("boundary", "--sex", "female", "--bodies", tmp_path / "women", "--wear", "shoes") == 0
    )
    names = {path.stem for path in (tmp_path / "women").glob("*.yaml")}
    assert {"female_overall_small", "female_longest_limbs", "female_tallest_torso"} < names
    assert len(names) == 8
    body = wb.load_body(tmp_path / "women" / "female_overall_small.yaml")
    assert "heel (shoes)" in body.sphere_names


def test_children_are_made_by_their_stature_and_mass(tmp_path):
    write_family(tmp_path)
    assert (
        run(
            "growth",
            "--sex",
            "female",
            "--age",
            17,
            "--p",
            50,
            "--body",
            tmp_path / "adult.yaml",
            "--bodies",
            tmp_path / "girls",
        )
        == 0
    )
    (row,) = rows_of(tmp_path / "girls")
    body = wb.load_body(tmp_path / "girls" / row["file"])
    assert 1000 * measure(body, ["stature"])["stature"] == pytest.approx(
        float(row["stature_mm"]), abs=0.06
    )


def test_nothing_is_written_where_one_person_cannot_be(tmp_path, capsys):
    # a child of two is no stretched man
    out = tmp_path / "children"
    assert run("growth", "--sex", "male", "--age", 2, "--bodies", out) == 3
    assert "male, 5 %: no such person" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_folder_with_something_else_in_it_is_left_alone(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    assert run("percentile", "--sex", "male", "--bodies", tmp_path) == 3
    assert "is there already" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--body", "bubbleman"), "--bodies FOLDER says where to"),
        (("--bodies", "x", "--body", "a", "b", "c"), "got 3"),
        (("--bodies", "x", "--body", "bubbelman"), "did you mean 'bubbleman'"),
        (("--bodies", "x", "--detail", "fine"), "belongs to no family"),
        (("--bodies", "x", "--wear", "hat"), "no bodies/encumbrance entry named 'hat'"),
        (("--bodies", "x", "--measures", "span"), "no measure 'span'"),
    ],
)
def test_what_cannot_be_made_is_told(tmp_path, monkeypatch, capsys, words, told):
    monkeypatch.chdir(tmp_path)
    assert run("percentile", "--sex", "male", *words) in (2, 3)
    assert told in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def cases():
    if not BOUNDARY_CASES.exists():
        return [pytest.param({}, id="none", marks=needs_real_input(BOUNDARY_CASES))]
    rows = csv.DictReader(BOUNDARY_CASES.read_text().splitlines())
    return [pytest.param(row, id=f"{row['sex']}{row['angle']}") for row in rows]


@pytest.mark.parametrize("row", cases())
def test_every_boundary_case_shows_the_six_measures_of_a_cockpit(bubbleman, row):
    wanted = {name: float(row[name.replace("_", "")]) / 1000 for name in COCKPIT}
    found = measure(wb.scale(bubbleman, wanted), COCKPIT)
    assert max(abs(found[name] - wanted[name]) for name in COCKPIT) < 5e-5


@pytest.mark.parametrize("row", cases())
def test_every_boundary_case_is_a_member_of_the_human_family(row):
    name = {"M": "adult_male", "F": "adult_female"}[row["sex"]]
    wanted = {name: float(row[name.replace("_", "")]) / 1000 for name in COCKPIT}
    body = load(name)
    made = wb.scale(body, wanted)
    found = measure(made, COCKPIT)
    assert max(abs(found[name] - wanted[name]) for name in COCKPIT) < 5e-5
    assert abs(made.basis_at[0] - body.basis_at[0]).max() < 4


@lru_cache(maxsize=2)
def load(name):
    """A body of the catalogue, once: its space of shapes is worked out once a body."""
    return wb.load_body(name)
