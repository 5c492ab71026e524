"""How well bodies show the measures of people: of typical ones, and of people who are not in the
sample that the bodies are predicted from.

    python -m benchmarks.measures [--people 100] [--detail medium] [--given stature,sitting_height,mass]
        [--survey FOLDER]

First table: measures of the median man and woman of the survey, and of the typical bodies. Second
table: the survey is halved. From one half come a population and, as a peer, a linear regression of
each measure. Of people of the other half only the given measures are known; bodies made from them
are measured and compared with the people, beside the regression: bias (mean difference) and root
mean square.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import workbench as wb
from workbench.body.people.sampling import fit_population
from workbench.body.scaling.measure import MEASURES
from workbench.files.ansur import read_ansur
from workbench.model.arrays import Floats
from workbench.model.population import SEXES, Population, PopulationModel

__all__ = ["Held", "held_out", "main", "raw_survey", "typical"]

ROOT = Path(__file__).resolve().parents[1]
RAW = ROOT.parent / "shared" / "data" / "anthropometry" / "ansur2"
GIVEN = ("stature", "sitting_height", "mass")
TYPICAL = {"male": "adult_male", "female": "adult_female"}


@dataclass(frozen=True, eq=False)
class Held:
    """People who were held out, by measure: differences (P,) [m] of body and person, and of
    regression and person."""

    sex: str
    body: dict[str, Floats]
    regression: dict[str, Floats]
    failed: int


def raw_survey(folder: Path = RAW) -> Population:
    """Read the survey's raw files."""
    return read_ansur(folder / "ANSUR_II_MALE_Public.csv", folder / "ANSUR_II_FEMALE_Public.csv")


def typical(people: Population, sex: str, detail: str) -> dict[str, tuple[float, float]]:
    """Return the survey's median and the typical body's measure [m], by measure."""
    rows = people.measures[people.sex == SEXES.index(sex)]
    median = dict(zip(people.names, np.median(rows, axis=0).tolist(), strict=True))
    body = wb.scale(wb.load_body(TYPICAL[sex]), {}, detail=detail)
    found = wb.measure(body)
    return {name: (median[name], value) for name, value in found.items() if name in median}


def held_out(
    people: Population, sex: str, count: int, *, detail: str, given: tuple[str, ...] = GIVEN
) -> Held:
    """Predict people of one half of the survey from the other half."""
    mine = np.flatnonzero(people.sex == SEXES.index(sex))
    known = people.rows(mine[::2])
    other = mine[1::2]
    rows = people.measures[other[:: max(1, len(other) // count)][:count]]
    others = np.flatnonzero(people.sex != SEXES.index(sex))
    both = people.rows(np.sort(np.concatenate([mine[::2], others])))  # a population has both sexes
    model = fit_population(both, name="half")
    template = wb.load_body(TYPICAL[sex])
    columns = [people.names.index(name) for name in given]
    wanted = [name for name in MEASURES if name in people.names and name not in given]
    fitted = _regression(known.measures, columns)(rows)
    body: dict[str, list[float]] = {name: [] for name in wanted}
    regression: dict[str, list[float]] = {name: [] for name in wanted}
    failed = 0
    for row, expected in zip(rows, fitted, strict=True):
        values = {name: float(row[at]) for name, at in zip(given, columns, strict=True)}
        try:
            found = wb.measure(_made(template, model, sex, values, detail))
        except wb.InputError:
            failed += 1
            continue
        for name in wanted:
            at = people.names.index(name)
            body[name].append(found[name] - row[at])
            regression[name].append(expected[at] - row[at])
    return Held(
        sex,
        {name: np.array(values) for name, values in body.items()},
        {name: np.array(values) for name, values in regression.items()},
        failed,
    )


def _made(
    template: wb.Body, model: PopulationModel, sex: str, values: dict[str, float], detail: str
) -> wb.Body:
    return wb.person_body(template, model, sex=sex, measures=values, detail=detail).body


def _regression(known: Floats, columns: list[int]):  # type: ignore[no-untyped-def]
    """A function that gives all measures (P, M) expected at given columns of rows (P, M)."""
    design = np.column_stack([np.ones(len(known)), known[:, columns]])
    share = np.linalg.lstsq(design, known, rcond=None)[0]

    def expected(rows: Floats) -> Floats:
        found: Floats = np.column_stack([np.ones(len(rows)), rows[:, columns]]) @ share
        return found

    return expected


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=100)
    parser.add_argument("--detail", default="medium")
    parser.add_argument("--given", default=",".join(GIVEN))
    parser.add_argument("--survey", type=Path, default=RAW)
    options = parser.parse_args()
    people = raw_survey(options.survey)
    both = {sex: typical(people, sex, options.detail) for sex in TYPICAL}
    print(f"Typical bodies at level {options.detail}: survey median, body less median [mm]")
    for name in both["male"]:
        cells = [
            f"{1000 * m:7.1f} {1000 * (v - m):+6.1f}" for m, v in (both[s][name] for s in both)
        ]
        print(f"{name:36s} {'   '.join(cells)}")
    given = tuple(options.given.split(","))
    found = [
        held_out(people, sex, options.people, detail=options.detail, given=given) for sex in TYPICAL
    ]
    print(
        f"\nPeople held out, of whom {', '.join(given)} are known: body: bias, RMS; regression: bias, RMS [mm]"
    )
    for name in found[0].body:
        cells = []
        for one in found:
            pairs = (one.body[name], one.regression[name])
            cells += [
                f"{1000 * d.mean():+6.1f} {1000 * np.sqrt((d**2).mean()):6.1f}" for d in pairs
            ]
        print(f"{name:36s} {'   '.join(cells)}")
    for one in found:
        print(
            f"{one.sex}: {len(next(iter(one.body.values())))} people, {one.failed} without a body"
        )


if __name__ == "__main__":
    main()
