"""The commands `workbench people ...`; lengths come out in millimetres, masses in kilograms."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from workbench.cli.progress import emit, tell
from workbench.errors import UsageError

if TYPE_CHECKING:
    from workbench.model.population import Population, PopulationModel

__all__ = ["people_app"]

people_app = App(
    name="people", help="Percentile persons, boundary cases, random people, growing children."
)

Sex = Literal["male", "female"]
Json = Annotated[bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")]
Csv = Annotated[
    bool, Parameter(name="--csv", negative="", help="print one row a person as CSV on stdout")
]
Names = Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")]
Numbers = Annotated[list[float] | None, Parameter(consume_multiple=True, negative="")]
LONGEST_HEADING = 9


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Made:
    """People as body files.

    Parameters
    ----------
    bodies
        a folder to write a body file for each person into, with a table of who they are
    body
        the body they are made from, or two: for men and for women; bubbleman where not given
    detail
        how many spheres, of a body that comes in several levels
    wear
        what they wear: helmet, shoes, boots, gloves, vest, or encumbrance files
    """

    bodies: Path | None = None
    body: Names = None
    detail: Literal["coarse", "medium", "fine"] | None = None
    wear: Names = None


@people_app.command
def percentile(
    *,
    sex: Sex,
    p: Numbers = None,
    measures: Names = None,
    population: Names = None,
    made: Made | None = None,
    as_json: Json = False,
) -> int:
    """Show the measures of one sex at percentiles, each measure by itself.

    Parameters
    ----------
    sex
        male or female
    p
        one percentile or more; 5 50 95 where not given
    measures
        the measures to show; all where not given
    population
        a population file, the name of one that comes along, or raw CSV files of ANSUR II
    """
    from workbench.body.people.percentile import percentile_people

    _check(made)
    people = percentile_people(_measured(population), sex, p or [5, 50, 95])
    if _write(made, people, _split(measures)):
        return 0
    _show(_chosen(people, measures), as_json=as_json)
    return 0


@people_app.command
def boundary(
    *,
    sex: Sex,
    share: float = 95,
    measures: Names = None,
    population: Names = None,
    made: Made | None = None,
    as_json: Json = False,
) -> int:
    """Show the eight boundary cases of one sex.

    Parameters
    ----------
    sex
        male or female
    share
        per cent of the people that the ellipse holds
    measures
        the measures that span it; the six of a cockpit where not given
    population
        a population file, the name of one that comes along, or raw CSV files of ANSUR II
    """
    from workbench.body.people.boundary import boundary_cases
    from workbench.model.population import COCKPIT

    _check(made)
    chosen = tuple(_split(measures)) or COCKPIT
    cases = boundary_cases(_measured(population), sex, share=share / 100, measures=chosen)
    if _write(made, cases.people, list(chosen)):
        return 0
    others = [name for name in cases.people.names if name not in chosen]
    _show(cases.people.of([*chosen, *others]), as_json=as_json)
    return 0


@people_app.command
def draw(
    *,
    count: int,
    seed: int = 1,
    men: float = 0.5,
    synthetic: Annotated[bool, Parameter(negative="")] = False,
    measures: Names = None,
    population: Names = None,
    made: Made | None = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> int:
    """Draw measured people at random, each at most once; without --json or --csv, show the
    percentiles of those drawn.

    Parameters
    ----------
    count
        how many people
    seed
        the same seed gives the same people
    men
        the share of men, 0 to 1
    synthetic
        draw people like those measured instead, as many as you like
    measures
        the measures to show; all where not given
    population
        a population file, the name of one that comes along, or raw CSV files of ANSUR II
    """
    from workbench.body.people.percentile import percentile_people
    from workbench.body.people.sampling import draw_people

    if as_json and as_csv:
        raise UsageError("one of --json and --csv can be printed, not both")
    _check(made)
    people = draw_people(_source(population), count, seed=seed, men=men, synthetic=synthetic)
    if _write(made, people, _split(measures)):
        return 0
    people = _chosen(people, measures)
    if as_json or as_csv:
        _show(people, as_json=as_json, as_csv=as_csv)
        return 0
    for code, sex in enumerate(("male", "female")):
        if (people.sex == code).any():
            _show(percentile_people(people, sex, [5, 50, 95]))
    return 0


@people_app.command
def growth(
    *, sex: Sex, age: float, p: Numbers = None, made: Made | None = None, as_json: Json = False
) -> int:
    """Show stature and mass of children at percentiles of the CDC growth charts.

    Parameters
    ----------
    sex
        male or female
    age
        2 to 20 years
    p
        one percentile or more; 5 50 95 where not given
    """
    from workbench.body.people.growth_charts import growth_people
    from workbench.files.populations import load_growth

    _check(made)
    people = growth_people(load_growth(), sex, p or [5, 50, 95], age=age)
    if not _write(made, people, ["stature"]):
        _show(people, as_json=as_json)
    return 0


def _check(made: Made | None) -> None:
    """InputError, before any work, where a folder of bodies is asked for and cannot be written."""
    from workbench.files.output_folder import check_folder

    if made is not None and made.bodies is not None:
        check_folder(made.bodies, holds="people")


def _write(made: Made | None, people: Population, shown: list[str]) -> bool:
    """Write people as bodies where that is asked for; True where it was."""
    if made is None or made == Made():
        return False
    if made.bodies is None:
        raise UsageError(
            "--body, --detail and --wear say how bodies are made; --bodies FOLDER says where to"
        )
    from workbench.report.people_folder import write_people
    from workbench.study.population_files import SHOWN

    sources = made.body or ["bubbleman"]
    if len(sources) > 2:
        raise UsageError(
            f"--body takes one body, or one for men and one for women, got {len(sources)}"
        )
    warnings = write_people(
        made.bodies,
        people,
        {"male": sources[0], "female": sources[-1]},
        shown=shown or SHOWN,
        detail=made.detail,
        wears=made.wear or [],
    )
    for line in warnings:
        tell(f"warning: {line}")
    emit(made.bodies)
    return True


def _source(population: list[str] | None) -> Population | PopulationModel:
    """The population that is asked for: CSV files together, or one model."""
    from workbench.files.ansur import read_ansur
    from workbench.files.populations import load_population_model

    sources = population or ["ansur2"]
    if all(Path(source).suffix.lower() == ".csv" for source in sources):
        return read_ansur(*sources)
    if len(sources) > 1:
        raise UsageError("--population takes one population, or CSV files")
    return load_population_model(sources[0])


def _measured(population: list[str] | None) -> Population | PopulationModel:
    """The measured people of the population that is asked for; its figures where nobody is known."""
    from workbench.model.population import PopulationModel

    source = _source(population)
    if isinstance(source, PopulationModel) and source.people is not None:
        return source.people
    return source


def _split(names: list[str] | None) -> list[str]:
    """Measures apart by commas or spaces; dashes may stand for underscores."""
    return [
        name.replace("-", "_") for word in names or [] for name in word.replace(",", " ").split()
    ]


def _chosen(people: Population, measures: list[str] | None) -> Population:
    return people.of(_split(measures) or people.names)


def _show(people: Population, *, as_json: bool = False, as_csv: bool = False) -> None:
    """Print people as JSON, as CSV or as a table."""
    rows = _rows(people)
    if as_json:
        text = json.dumps({"source": people.source, "people": rows}, indent=1, allow_nan=False)
    elif as_csv:
        text = _csv(rows, [f"{name}_{_unit(name)[0]}" for name in people.names])
    else:
        text = _table(people.source, rows)
    emit(text)


def _rows(people: Population) -> list[dict[str, Any]]:
    """Label, sex and measures of each person."""
    from workbench.model.population import SEXES

    units = [_unit(name) for name in people.names]
    names = [f"{name}_{unit}" for name, (unit, _, _) in zip(people.names, units, strict=True)]
    return [
        {
            "label": label,
            "sex": SEXES[sex],
            "measures": {
                name: round(float(value) * factor, digits)
                for name, (_, factor, digits), value in zip(names, units, values, strict=True)
            },
        }
        for label, sex, values in zip(people.labels, people.sex, people.measures, strict=True)
    ]


def _unit(name: str) -> tuple[str, float, int]:
    """The unit that a measure is shown in, how many there are in a metre or kilogram, and digits."""
    return ("kg", 1.0, 2) if name == "mass" else ("mm", 1000.0, 1)


def _csv(rows: list[dict[str, Any]], names: list[str]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["label", "sex", *names])
    writer.writerows([row["label"], row["sex"], *row["measures"].values()] for row in rows)
    return out.getvalue().rstrip("\n")


def _table(source: str, rows: list[dict[str, Any]]) -> str:
    """A column a person; where their labels are long, numbers head the columns and the labels stand
    above."""
    if not rows:
        return f"{source}\n  "
    heads = [row["label"] for row in rows]
    lines = [f"{source}, {rows[0]['sex']}"]
    if any(len(head) > LONGEST_HEADING for head in heads):
        lines += [f"  {n}  {head}" for n, head in enumerate(heads, 1)]
        heads = [str(n) for n in range(1, len(rows) + 1)]
    names = list(rows[0]["measures"])
    width = max(map(len, names), default=0)
    lines.append(" " * (width + 2) + "".join(f"{head:>{LONGEST_HEADING}}" for head in heads))
    for name in names:
        measure, unit = name.rsplit("_", 1)
        cells = "".join(f"{row['measures'][name]:>{LONGEST_HEADING}.1f}" for row in rows)
        lines.append(f"{measure:<{width - 1}} {unit:<2}{cells}")
    return "\n".join(lines)
