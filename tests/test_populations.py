"""Populations as files: what comes along agrees with the raw survey, and what is wrong is named
with its line."""

from __future__ import annotations

import csv
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import REFERENCE, ROOT, SHARED, real_input, tracked
from workbench import InputError, UsageError, load_population_model, read_ansur
from workbench.body.people.percentile import percentile_values
from workbench.body.people.sampling import fit_population
from workbench.cli import main
from workbench.files.populations import load_growth
from workbench.model.population import MEASURES, SEXES, Population, PopulationModel

RAW = [
    SHARED / "anthropometry" / "ansur2" / f"ANSUR_II_{sex}_Public.csv" for sex in ("MALE", "FEMALE")
]

TINY = """\
population: tiny
length: mm
percentiles: [0, 50, 100]
male:
  count: 100
  quantiles:
    stature: [1500, 1750, 2000]
    mass: [40, 80, 150]
    span: [1500, 1760, 2050]
  correlation:
    stature: [1]
    mass: [0.5, 1]
    span: [0.8, 0.4, 1]
"""
CSV = """\
SubjectId,stature,weightkg,interpupillarybreadth,sittingheight,acromialheight,Gender
a,1756,855,640,918,1440,Male
b,1628,678,620,857,1335,Female
"""
FEW = ["stature", "mass", "interpupillary_breadth", "acromial_height_sitting"]


@pytest.fixture(scope="module")
def raw():
    return read_ansur(*map(real_input, RAW))


@pytest.fixture
def people(tmp_path):
    """Read a CSV text as a file."""

    def read(text, measures=FEW):
        path = tmp_path / "people.csv"
        path.write_bytes(text.encode("latin-1"))
        return read_ansur(path, measures=measures)

    return read


@pytest.fixture
def model(tmp_path):
    """Read a population file's text."""

    def read(text):
        path = tmp_path / "tiny.yaml"
        path.write_text(text)
        return load_population_model(path)

    return read


def test_ansur2_has_both_sexes_and_all_measures():
    ansur2 = load_population_model("ansur2")
    assert (ansur2.sexes, ansur2.count.tolist(), ansur2.names) == (
        SEXES,
        [4082, 1986],
        tuple(MEASURES),
    )
    assert len(MEASURES) >= 40
    assert repr(ansur2) == "PopulationModel(ansur2: 4082 male, 1986 female, 57 measures)"


def test_the_correlation_that_comes_along_is_symmetric_and_positive_definite():
    for matrix in load_population_model("ansur2").correlation:
        assert np.array_equal(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > 0.005


@pytest.mark.parametrize("sex", SEXES)
def test_quantiles_that_come_along_are_those_of_the_reference_table_within_a_millimetre(sex):
    path = real_input(REFERENCE / "ansur2_percentiles.csv")
    model = load_population_model("ansur2")
    columns = {name.replace("_", ""): k for k, name in enumerate(MEASURES)}
    table = percentile_values(model, sex, [5, 50, 95])
    rows = [row for row in csv.DictReader(path.read_text().splitlines()) if row["dim"] in columns]
    assert len(rows) >= 30
    for row in rows:
        want = np.array([float(row[f"{sex[0].upper()}{p}"]) for p in (5, 50, 95)])
        unit = 0.0001 if row["dim"] == "interpupillarybreadth" else 0.001
        assert table[:, columns[row["dim"]]] == pytest.approx(want * unit, abs=0.001), row["dim"]


@pytest.mark.parametrize("sex", SEXES)
def test_quantiles_that_come_along_are_those_of_the_raw_survey_within_a_millimetre(raw, sex):
    model = load_population_model("ansur2")
    levels = [5, 25, 50, 75, 95]
    off = percentile_values(model, sex, levels) - percentile_values(raw, sex, levels)
    assert np.abs(off[:, np.array(raw.names) != "mass"]).max() < 0.001
    assert np.abs(off[:, raw.names.index("mass")]).max() < 0.15


def test_populations_are_made_by_their_script_to_the_byte(raw, tmp_path):
    command = [
        sys.executable,
        ROOT / "tools" / "bodies" / "make_populations.py",
        SHARED / "anthropometry",
        tmp_path,
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and "not here" not in done.stdout
    shipped = {path.name: path.read_bytes() for path in tracked("bodies/populations/*")}
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == shipped
    assert len(shipped) == 3


def test_populations_stay_small():
    for path in tracked("bodies/populations/*.yaml"):
        assert path.stat().st_size < 120_000
        assert max(map(len, path.read_text().splitlines())) <= 120
    (people,) = tracked("bodies/populations/*.csv")
    assert people.stat().st_size < 1_600_000 and people.read_bytes().isascii()


def test_the_raw_survey_is_read_whole_in_si_units(raw):
    assert repr(raw).endswith("4082 men, 1986 women, 57 measures)")
    for name, middle in (("stature", 1.719), ("mass", 78.5), ("interpupillary_breadth", 0.0635)):
        assert np.median(raw.column(name)) == pytest.approx(middle, abs=1e-9)


def test_a_raw_file_gives_kilograms_and_metres_and_derives_the_acromial_height_sitting(people):
    two = people(CSV)
    assert two.measures[0] == pytest.approx([1.756, 85.5, 0.064, 0.602])
    assert (two.sex.tolist(), two.labels) == ([0, 1], ("a", "b"))
    assert two.column("mass")[1:] == pytest.approx([67.8])


def test_a_raw_file_may_be_latin_1_with_a_byte_order_mark(people):
    assert (
        len(
            people(
                "\xef\xbb\xbf"
                + CSV.replace("a,1756", "Fort Buchanan, Peña".replace(", ", " ") + ",1756")
            )
        )
        == 2
    )


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("stature,", "height,", "people.csv:1: missing columns: stature"),
        ("Gender", "Group", "people.csv:1: missing columns: gender"),
        (
            "b,1628",
            "b,16280",
            "people.csv:3: stature: 16280 mm is absurd for a person; 630 to 2800 mm is plausible",
        ),
        ("a,1756", "a,tall", "people.csv:2: stature: a number is needed (got 'tall')"),
        ("a,1756", "a,nan", "people.csv:2: stature: a number is needed (got 'nan')"),
        (",678,", ",67.8,", "people.csv:3: weightkg: 6.78 kg is absurd"),
        (",640,", ",64,", "people.csv:2: interpupillarybreadth: 6.4 mm is absurd"),
        (
            ",1440,",
            ",440,",
            "people.csv:2: acromialheight (acromial_height_sitting): -398 mm is absurd",
        ),
        ("Female", "other", "people.csv:3: gender: got 'other'; valid: male, female"),
        ("1335,Female", "1335", "people.csv:3: 7 cells are needed, one a column (got 6)"),
        ("weightkg", "stature", "people.csv:1: column 'stature' stands twice"),
        ("a,", '"a,', "people.csv:3: not a CSV file: unexpected end of data"),
    ],
)
def test_what_is_wrong_in_a_raw_file_is_named_with_line_and_column(people, old, new, told):
    with pytest.raises(InputError) as error:
        people(CSV.replace(old, new, 1))
    assert len(error.value.problems) == 1 and told in error.value.problems[0]


@pytest.mark.parametrize(
    ("sitting", "acromial", "told"),
    [
        # sitting heights from the floor, on a seat 430 mm high: 1756 - 1348 = 408 < 553
        (
            1348,
            1330,
            "people.csv:2: kneeheightsitting: the knee height sitting is 553 mm where the stature "
            "less sitting height, which it is a part of, is 408 mm",
        ),
        (
            780,
            1440,
            "people.csv:2: eyeheightsitting: the eye height sitting is 804 mm where the sitting",
        ),
        (
            918,
            1800,
            "people.csv:2: acromialheight: the acromial height sitting is 962 mm where the eye",
        ),
    ],
)
def test_a_measure_longer_than_what_it_is_a_part_of_is_refused_with_its_line(
    people, sitting, acromial, told
):
    text = (
        "sex,stature,sittingheight,eyeheightsitting,kneeheightsitting,acromialheight\n"
        f"male,1756,{sitting},804,553,{acromial}\nfemale,1628,857,748,510,1335\n"
    )
    wanted = ["stature", "sitting_height", "eye_height_sitting", "knee_height_sitting"]
    with pytest.raises(InputError) as error:
        people(text, [*wanted, "acromial_height_sitting"])
    assert any(told in problem for problem in error.value.problems)
    assert all("people.csv:2:" in problem for problem in error.value.problems)


@pytest.mark.parametrize(
    ("sign", "encoding", "told"),
    [
        (";", "utf-8", "parted by ';'"),
        ("\t", "utf-8", "parted by '\\t'"),
        (",", "utf-16", "UTF-16"),
    ],
)
def test_a_raw_file_that_a_spreadsheet_wrote_otherwise_says_what_to_do(
    tmp_path, sign, encoding, told
):
    path = tmp_path / "people.csv"
    path.write_text(CSV.replace(",", sign), encoding=encoding)
    with pytest.raises(InputError, match="save it") as error:
        read_ansur(path, measures=["stature"])
    assert told in str(error.value)


def test_a_raw_file_without_people_is_refused(people, tmp_path):
    with pytest.raises(InputError, match="holds no people"):
        people(CSV.splitlines()[0])
    with pytest.raises(InputError, match="no such file"):
        read_ansur(tmp_path / "gone.csv")
    with pytest.raises(UsageError, match="name one CSV file"):
        read_ansur()


def test_a_small_population_file_is_read(model):
    tiny = model(TINY)
    assert tiny.quantiles[0, :, 1] == pytest.approx([1.75, 80, 1.76])
    assert tiny.correlation[0, 1].tolist() == [0.5, 1, 0.4]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("length: mm\n", "", "length: the unit of length is needed"),
        ("50, 100]", "100, 100]", "tiny.yaml:3:23: percentiles[2]: percentiles must rise"),
        ("[0, 50,", "[1, 50,", "percentiles: must go from 0 to 100 (got 1 to 100)"),
        ("count: 100", "count: few", "tiny.yaml:5:3: male.count: a whole number is needed"),
        ("[0, 50, 100]", "[0, 0.1, 100]", "male.count: 100 people cannot tell"),
        ("1750, 2000]", "1750]", "tiny.yaml:7:5: male.quantiles.stature: 3 values are needed"),
        ("1750", "1490", "tiny.yaml:7:21: male.quantiles.stature[1]: quantiles must rise"),
        ("1750", "17500", "17500 is absurd for a person; 630 to 2800 is plausible"),
        ("    span: [1500", "    spam: [1500", "no such measure; did you mean 'span'?"),
        ("    span: [0.8, 0.4, 1]\n", "", "same measures in the same order (span is missing)"),
        (
            "mass: [0.5, 1]",
            "mass: [1]",
            "tiny.yaml:12:5: male.correlation.mass: a row has one value for each",
        ),
        ("[0.5, 1]", "[1.5, 1]", "male.correlation.mass[0]: a correlation lies between -1 and 1"),
        ("[0.8, 0.4, 1]", "[0.99, -0.9, 1]", "male.correlation: they contradict one another"),
        ("male:", "man:", "tiny.yaml:4:1: man: unknown key 'man'"),
    ],
)
def test_what_is_wrong_in_a_population_file_is_named_with_its_line(model, old, new, told):
    with pytest.raises(InputError) as error:
        model(TINY.replace(old, new, 1))
    assert any(told in line for line in error.value.problems), error.value.problems


@pytest.mark.parametrize(
    ("masses", "told"),
    [
        (
            "[9, 18, 34]",  # 4.0, 5.9 and 8.5 kg/m^2
            "tiny.yaml:8:12: male.quantiles.mass[0]: 9 kg does not go with a stature of 1500 mm, both at "
            "percentile 0, and so at 2 more percentiles: mass / stature^2 is 4.0 kg/m^2 where 12 to 70 is a "
            "person's, 5.9 in the middle",
        ),
        ("[20, 80, 150]", "mass[0]: 20 kg does not go with a stature of 1500 mm, both at percentile 0: "),
        ("[88, 176, 240]", "mass[1]: 176 kg does not go with a stature of 1750 mm, both at percentile 50: "),
    ],
)  # fmt: skip
def test_quantiles_of_mass_that_do_not_go_with_stature_are_refused(model, masses, told):
    """In pounds 40, 80 and 110 kg are 88, 176 and 240: 39, 57 and 60 kg/m^2, of nobody in the middle."""
    with pytest.raises(InputError) as error:
        model(TINY.replace("[40, 80, 150]", masses))
    (line,) = error.value.problems
    assert told in line and line.endswith("convert pounds (0.4536 kg) or tenths of a kilogram")


def test_an_unknown_population_is_told_which_there_are():
    with pytest.raises(InputError, match="did you mean 'ansur2'"):
        load_population_model("ansur")


def test_a_growth_file_with_two_rows_swapped_is_refused(tmp_path):
    lines = (
        (ROOT / "bodies" / "populations" / "cdc_growth.yaml").read_text().splitlines(keepends=True)
    )
    row = next(k for k, line in enumerate(lines) if "- [25.5" in line)
    lines[row], lines[row + 1] = lines[row + 1], lines[row]
    path = tmp_path / "growth.yaml"
    path.write_text("".join(lines))
    with pytest.raises(
        InputError, match=rf"growth.yaml:{row + 2}:7: male.stature\[2\]: ages must rise"
    ):
        load_growth(path)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"sex": [2]}, "a sex is an index"),
        ({"weight": [0.0]}, "every weight must be positive"),
        ({"measures": [[-1.0]]}, "person 0: stature: must be positive, got -1.0"),
        ({"names": ("height",)}, "no measure 'height'"),
        ({"labels": ("a", "b")}, "2 labels for 1 people"),
    ],
)
def test_a_population_keeps_its_invariants(change, told):
    fields = {
        "names": ("stature",),
        "sex": [0],
        "weight": [1.0],
        "measures": [[1.75]],
        "source": "test",
    }
    with pytest.raises(InputError, match=told):
        Population(**(fields | change))


def test_a_model_fitted_to_few_people_leaves_out_what_they_cannot_tell():
    chance = np.random.default_rng(1)
    measures = np.exp(chance.normal(size=(60, 2)) * 0.05) * [1.75, 80]
    few = Population(("stature", "mass"), np.ones(60), np.ones(60), measures, "sixty women")
    model = fit_population(few, name="few")
    assert isinstance(model, PopulationModel) and model.sexes == ("female",)
    assert model.levels[[0, 1, -2, -1]].tolist() == [0, 0.025, 0.975, 1]


@pytest.mark.parametrize(
    ("column", "factor", "told"),
    [
        ("weightkg", 2.2046, "the column counts tenths of a kilogram; call it mass"),
        ("mass", 2.2046, "the column counts kilograms"),
        ("mass", 10.0, "750 kg is absurd for a person"),
    ],
)
def test_masses_that_are_nobodys_of_their_stature_are_refused_with_their_line(
    tmp_path, column, factor, told
):
    """75 kg at 1.75 m is 24.5 kg/m^2. In pounds: 16.5 kg for tenths, or 165 kg for kilograms."""
    file = tmp_path / "p.csv"
    lines = [f"male,{1750 + k},{75 * factor:g}" for k in range(6)]
    file.write_text("\n".join([f"gender,stature,{column}", *lines]))
    with pytest.raises(InputError, match=told) as caught:
        read_ansur(file, measures=("stature", "mass"))
    assert str(caught.value).startswith(f"{file}:")


def test_people_that_are_drawn_are_read_back(tmp_path, capsys):
    """Lengths are in mm by the names of their columns, whatever the unit of the others is."""
    assert main(["people", "draw", "--count", "6", "--csv"]) == 0
    file = tmp_path / "drawn.csv"
    file.write_text(text := capsys.readouterr().out)
    rows = list(csv.DictReader(text.splitlines()))
    people = read_ansur(file, measures=("stature", "mass", "hand_length"), unit=0.01)
    assert people.labels == tuple(row["label"] for row in rows)
    assert [SEXES[sex] for sex in people.sex] == [row["sex"] for row in rows]
    for k, (name, unit) in enumerate(
        [("stature_mm", 1e3), ("mass_kg", 1), ("hand_length_mm", 1e3)]
    ):
        assert people.measures[:, k] * unit == pytest.approx([float(row[name]) for row in rows])
