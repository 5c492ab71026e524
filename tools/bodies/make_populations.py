"""Writes populations/ansur2.yaml, ansur2.csv and cdc_growth.yaml from raw public tables.

ansur2.csv holds the people of the survey: those columns of the public files that the measures of
the workbench are made of, men first, cell by cell as published. ansur2.yaml holds their figures.

Run `python tools/bodies/make_populations.py [FOLDER [OUT]]`. FOLDER holds
`ansur2/ANSUR_II_{MALE,FEMALE}_Public.csv` (US Army) and
`growth/{lhfa,wfa}_{boys,girls}_2_20_zscores.cdc.json` (CDC's LMS parameters as the package pygrowup
ships them). A table that is not there is reported, and its figures stay as they are. OUT is
`populations` beside this file by default. The same tables always give the same files.
"""

from __future__ import annotations

import csv
import io
import json
import sys
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

from workbench.body.people.sampling import fit_population
from workbench.files.ansur import raw_columns, read_ansur
from workbench.files.populations import load_growth, load_population_model
from workbench.model.population import MASS, MEASURES, PopulationModel

__all__ = ["growth_text", "main", "people_text", "population_text"]

ROOT = Path(__file__).resolve().parents[2]
RAW = ROOT.parent / "shared" / "data" / "anthropometry"
POPULATION = """\
# ANSUR II: {people}, {measures} measures. The people are the rows of ansur2.csv, these are their figures.
# From the public files of Gordon et al. 2014, 2012 Anthropometric Survey of U.S. Army Personnel, NATICK/TR-15/007.
# Each row of `quantiles` is one measure at `percentiles`; 0 and 100 are the least and the greatest person measured.
# `correlation` is the lower triangle of the correlation of normal (van der Waerden) scores: a Gaussian copula.
# acromial_height_sitting and cervicale_height_sitting are derived: sitting height - (stature - height standing).
# ansur2.csv has columns of the public files as published: lengths in mm, but weightkg in 0.1 kg and
# interpupillarybreadth in 0.1 mm.
# Erect, nude postures. Made by tools/bodies/make_populations.py: do not edit.
population: ansur2
description: {description}
source: 2012 Anthropometric Survey of U.S. Army Personnel (ANSUR II), NATICK/TR-15/007
licence: public domain (work of the US government)
length: mm
people: ansur2.csv
"""
GROWTH = """\
# CDC growth charts 2000, ages 2 to 20: rows are [age in months, L, M, S]; M in mm or kg.
# From Kuczmarski et al. 2002, Vital Health Stat 11(246). value = M (1 + L S z)^(1/L) (Cole & Green 1992).
# The package pygrowup that ships the table numbers its rows by completed months; the CDC's own age of row 24 is 24.5
# months (median boy 868.6 mm; at 24.0 months it is 864.5), and so on; only the last row stands at a whole month, 240.
# Made by tools/bodies/make_populations.py: do not edit.
growth: cdc_growth
description: stature and mass of children in the USA, 2 to 20 years
source: CDC growth charts 2000, LMS parameters of stature-for-age and weight-for-age
licence: public domain (work of the US government)
length: mm
"""


def main() -> None:
    """Write what the raw tables of the folder given allow, then read it back."""
    raw = Path(sys.argv[1]) if len(sys.argv) > 1 else RAW
    out = Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "bodies" / "populations"
    survey = [raw / "ansur2" / f"ANSUR_II_{sex}_Public.csv" for sex in ("MALE", "FEMALE")]
    if all(path.is_file() for path in survey):
        description = (
            "soldiers of the US Army, measured 2010 to 2012; fitter and leaner than civilians"
        )
        model = fit_population(read_ansur(*survey), name="ansur2", description=description)
        _write(out / "ansur2.csv", people_text(survey))
        _write(out / "ansur2.yaml", population_text(model))
        print(load_population_model(out / "ansur2.yaml"))
    else:
        print(f"{raw / 'ansur2'}: raw files not here; ansur2.yaml and .csv are left as they are")
    if (raw / "growth").is_dir():
        _write(out / "cdc_growth.yaml", growth_text(raw / "growth"))
        print(load_growth(out / "cdc_growth.yaml"))
    else:
        print(f"{raw / 'growth'}: raw files not here; cdc_growth.yaml is left as it is")


def people_text(survey: Sequence[Path]) -> str:
    """The people of raw public files as CSV: the columns that the measures are made of, as published."""
    columns = raw_columns(tuple(MEASURES))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for path in survey:
        with path.open(encoding="latin-1", newline="") as lines:
            rows = csv.reader(lines)
            header = [name.strip().lower() for name in next(rows)]
            at = [header.index(column) for column in columns]
            writer.writerows([row[k].strip() for k in at] for row in rows if row)
    return out.getvalue()


def population_text(model: PopulationModel) -> str:
    """The population file of a model: 0.1 mm, 0.1 kg, correlations to four places."""
    words = {"male": "men", "female": "women"}
    people = ", ".join(
        f"{n} {words[sex]}" for sex, n in zip(model.sexes, model.count.tolist(), strict=True)
    )
    text = POPULATION.format(
        people=people, measures=len(model.names), description=model.description
    )
    text += _row("percentiles", (f"{100 * level:.6g}" for level in model.levels), 0)
    for x, sex in enumerate(model.sexes):
        text += f"{sex}:\n  count: {model.count[x]}\n  quantiles:\n"
        for name, values in zip(model.names, model.quantiles[x], strict=True):
            scale = 1.0 if name == MASS else 1000.0
            text += _row(name, (_short(value * scale, 1) for value in values), 4)
        text += "  correlation:\n"
        for row, name in enumerate(model.names):
            text += _row(
                name, (_short(value, 4) for value in model.correlation[x, row, : row + 1]), 4
            )
    return text


def growth_text(folder: Path) -> str:
    """The growth file, from pygrowup's four tables of CDC's parameters."""
    text = GROWTH
    for sex, children in (("male", "boys"), ("female", "girls")):
        text += f"{sex}:\n"
        for measure, chart, scale in (("stature", "lhfa", 10.0), (MASS, "wfa", 1.0)):
            rows = json.loads(
                (folder / f"{chart}_{children}_2_20_zscores.cdc.json").read_text(encoding="utf-8")
            )
            text += f"  {measure}:\n"
            for row in rows:
                month = float(row["Month"])
                age = month if row is rows[-1] else month + 0.5
                power, median, spread = (float(row[key]) for key in "LMS")
                text += f"    - [{age:g}, {_short(power, 5)}, {_short(median * scale, 3)}, {_short(spread, 6)}]\n"
    return text


def _short(value: float, places: int) -> str:
    """A number rounded, without what says nothing: 1635.0 is 1635, -0.0 is 0."""
    text = f"{value:.{places}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _row(name: str, cells: Iterable[str], indent: int) -> str:
    """`name: [cells]`, wrapped at 120 columns."""
    pad = " " * indent
    return (
        textwrap.fill(
            f"{name}: [{', '.join(cells)}]",
            120,
            initial_indent=pad,
            subsequent_indent=pad + "  ",
            break_long_words=False,
            break_on_hyphens=False,
        )
        + "\n"
    )


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
