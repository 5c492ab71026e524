"""`workbench body ...`: the bodies there are, their measures, and bodies to measure."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from workbench.cli.progress import emit, tell
from workbench.errors import UsageError, one_of

if TYPE_CHECKING:
    from workbench.model.person import Growth
    from workbench.model.population import PopulationModel

__all__ = ["body_app"]

body_app = App(
    name="body", help="List the bodies there are, show or measure one, or make one to measures."
)
Json = Annotated[bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")]


@body_app.command(name="list")
def body_list(*, as_json: Json = False) -> int:
    """List the bodies there are."""
    from workbench.report.body_sheet import body_list as listed

    rows = listed()
    if as_json:
        emit(_json(rows))
    for row in [] if as_json else rows:
        emit(
            f"{row['name']}: {row['description']} ({row['segments']} segments, {row['spheres']} spheres, "
            f"{row['mass_kg']} kg)"
        )
    return 0


@body_app.command(name="show")
def body_show(body: str, *, as_json: Json = False) -> int:
    """Show a body: its segments, joints and postures.

    Parameters
    ----------
    body
        a body file, or the name of one that comes with the workbench
    """
    from workbench.report.body_sheet import body_sheet, body_text

    sheet = body_sheet(body)
    emit(_json(sheet) if as_json else body_text(sheet))
    return 0


@body_app.command(name="measure")
def body_measure(body: str, *, as_json: Json = False) -> int:
    """Measure a body as an anthropometer does, by the definitions of ANSUR II.

    Parameters
    ----------
    body
        a body file, or the name of one that comes with the workbench
    """
    from workbench.body.scaling.measure import measure
    from workbench.files.body.bodies import load_body

    found = {name: round(1000 * value, 1) for name, value in measure(load_body(body)).items()}
    if as_json:
        emit(_json({"body": body, "measures_mm": found}))
    for name, value in {} if as_json else found.items():
        emit(f"{name:<34} {value:>7.1f} mm")
    return 0


@body_app.command(name="scale")
def body_scale(
    body: str,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    sex: Literal["male", "female"] = "male",
    age: float | None = None,
    population: str | None = None,
    detail: Literal["coarse", "medium", "fine"] | None = None,
    wear: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    **measures: str,
) -> int:
    """Make a body with given measures, one flag each: --stature "1625 mm" --sitting-height "33.8
    in" --mass "60 kg".

    Measures that are not given follow from those that are, as people of the population have them.

    Parameters
    ----------
    body
        the body to start from: a file, or the name of one that comes with the workbench
    out
        the body file to write
    sex
        male or female: whose figures the other measures follow
    age
        of a child, in years: growth charts tell stature and mass where they are not given
    population
        the population whose figures they are: ansur2, or cdc_growth with an age
    detail
        how many spheres, of a body that comes in several levels
    wear
        what it wears: helmet, shoes, boots, gloves, vest, or encumbrance files
    measures
        measures by name, with units
    """
    from workbench.body.wear import wear as dress
    from workbench.files.body.bodies import body_path, load_body
    from workbench.files.body.encumbrances import worn
    from workbench.files.body.writer import body_text
    from workbench.files.output_file import check_file, write_file
    from workbench.study.persons import person_body

    if not measures and age is None:
        raise UsageError(
            'workbench body scale: give one measure or more, such as --stature "1625 mm"'
        )
    check_file(out)
    names = {name: name.replace("-", "_") for name in measures}
    wanted = {names[name]: _quantity(names[name], text) for name, text in measures.items()}
    people = _people(population, age)
    made = person_body(load_body(body), people, sex=sex, measures=wanted, age=age, detail=detail)
    dressed = dress(made.body, worn(wear or [], made.body))
    for warning in made.warnings:
        tell(f"warning: {warning}")
    given = [f"{name} {text}" for name, text in measures.items()]
    given += [f"{age:g} years"] if age else []
    words = f"{body}, {sex}, to {', '.join(given)}"
    words += f", with {', '.join(wear)}" if wear else ""
    text = body_text(dressed, body_path(body), name=out.stem, description=words, folder=out.parent)
    write_file(out, text)
    emit(out)
    return 0


def _people(population: str | None, age: float | None) -> PopulationModel | Growth:
    """Whose figures measures follow: those of grown people, of children where an age is given."""
    from workbench.files.populations import load_growth, load_population_model

    if age is None:
        return load_population_model(population or "ansur2", people=False)
    return load_growth(population or "cdc_growth")


def _quantity(name: str, text: str) -> float:
    """Metres, or kilograms of a mass."""
    from workbench.body.scaling.measure import MEASURES
    from workbench.files.schema import to_metres
    from workbench.model.population import WORDS

    if name == "mass":
        number, _, unit = text.strip().partition(" ")
        factor = {"kg": 1.0, "lb": 0.45359237}.get(unit.strip())
        if factor is None or not number.replace(".", "", 1).isdigit():
            raise UsageError(f"--mass: a mass such as '60 kg' or '132 lb' is needed, got {text!r}")
        return float(number) * factor
    if name not in MEASURES:
        raise UsageError(f"no measure {name!r}; {one_of(name, [*MEASURES, 'mass'], words=WORDS)}")
    try:
        return to_metres(text)
    except ValueError as error:
        raise UsageError(f"--{name.replace('_', '-')}: {error}, got {text!r}") from None


def _json(data: Any) -> str:
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
