"""`workbench body ...`: the bodies there are, their measures, bodies to measure, and spheres for a
closed mesh or for outlines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from workbench.cli.progress import emit, tell
from workbench.errors import UsageError, one_of

if TYPE_CHECKING:
    from workbench.body.fitting.candidates import FitBounds
    from workbench.model.person import Growth
    from workbench.model.population import PopulationModel

__all__ = [
    "body_app",
]

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
    from workbench.files.body.encumbrances import load_encumbrances
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
    dressed = dress(made.body, load_encumbrances(wear or [], made.body))
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


@body_app.command(name="fit")
def body_fit(
    source: Path,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    skeleton: str | None = None,
    posture: str | None = None,
    at: str | None = None,
    length: str | None = None,
    up: str = "z",
    forward: str = "x",
    outward: str = "4 mm",
    inward: str = "4 mm",
    least_radius: str = "2 mm",
    greatest_radius: str = "200 mm",
    count: int | None = None,
    seed: int = 0,
    bound: Annotated[bool, Parameter(negative="")] = False,
    as_json: Annotated[
        bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")
    ] = False,
) -> int:
    """Fit spheres to a closed mesh or to outlines and write a body file.

    Parameters
    ----------
    source
        a closed mesh (OBJ, STL, PLY, OFF, GLB, ...) or an outlines file (YAML)
    out
        the body file to write
    skeleton
        a body, by name or file, whose segments and joints the spheres are made for; without it, one
    segment posture
        the posture of the skeleton in which the mesh stands; without it, the zero pose
    at
        where the origin of the skeleton's reference segment lies in the mesh's frame, "0 mm, 0 mm,
    0 mm" where only a posture is stated; with neither, a skeleton of a family of bodies is sized, posed and placed as the
    standing person in the mesh
    length
        the mesh's unit of length where its file does not say it: mm, cm, m, in, ft
    up
        the axis of the mesh file that is up: x, y, z, -x, -y, -z
    forward
        the axis of the mesh file that is forward
    outward
        how far a sphere may leave the surface
    inward
        how far the surface may lie outside the spheres
    least_radius
        the smallest a sphere may be
    greatest_radius
        the largest a sphere may be
    count
        this many spheres, as near to the surface as they can be, instead of tolerances
    seed
        of the search
    bound
        say how few spheres could do at the very best
    """
    from workbench.files.output_file import check_file, write_file
    from workbench.study.fit_body import (
        bound_of,
        figures,
        fit_body,
        fitted_body_text,
        read_surface,
        skeleton_of,
    )

    if bound and count is not None:
        raise UsageError("--bound is about tolerances: leave --count out")
    limits = _limits(least_radius, greatest_radius, outward, inward)
    check_file(out)
    surface = read_surface(source, length=length, up=up, forward=forward)
    placed = None
    if skeleton is not None:
        placed = skeleton_of(
            skeleton, surface, posture=posture, at=None if at is None else _place(at)
        )
        for note in placed.notes:
            tell(f"note: {note}")
    check_file(out)  # again, now that all inputs are known
    cut = fit_body(surface, placed, limits, count=count, seed=seed)
    found = figures(surface, cut)
    if bound:
        found["fewest_spheres"] = bound_of(surface, placed, limits, seed=seed)
    text = fitted_body_text(
        surface,
        cut,
        placed,
        name=out.stem,
        source=f"spheres fitted to {source.name}",
        description=_description(source, skeleton, found),
    )
    write_file(out, text)
    if as_json:
        emit(json.dumps({"body": str(out)} | found, indent=1, allow_nan=False))
    else:
        _show(found)
        emit(out)
    return 0


def _limits(*texts: str) -> FitBounds:
    """Least and greatest radius, outward and inward tolerance."""
    from workbench.body.fitting.candidates import LONGEST, SHORTEST, FitBounds

    names = ("--least-radius", "--greatest-radius", "--outward", "--inward")
    least, greatest, outward, inward = (
        _option_metres(name, text) for name, text in zip(names, texts, strict=True)
    )
    for name, value in zip(names, (least, greatest, outward, inward), strict=True):
        if not SHORTEST <= value <= LONGEST:
            raise UsageError(f"{name}: 0.01 mm to 10 m is possible, got {value * 1e3:g} mm")
    if least > greatest:
        raise UsageError(f"--least-radius {texts[0]} is greater than --greatest-radius {texts[1]}")
    return FitBounds(least, greatest, outward, inward)


def _place(text: str) -> Any:
    parts = text.split(",")
    if len(parts) != 3:
        raise UsageError(
            f"--at: three lengths are needed, such as '0 mm, 0 mm, 950 mm', got {text!r}"
        )
    return [_option_metres("--at", part) for part in parts]


def _option_metres(option: str, text: str) -> float:
    from workbench.files.schema import to_metres

    try:
        return to_metres(text)
    except ValueError as error:
        raise UsageError(f"{option}: {error}, got {text!r}") from None


def _description(source: Path, skeleton: str | None, found: dict[str, Any]) -> str:
    whole = found["whole"]
    like = f", segments of {Path(skeleton).stem}" if skeleton else ""
    return f"{source.stem} as {whole['spheres']} spheres, {whole['mean_mm']:.2f} mm from it in the mean{like}"


_COLUMNS = {
    "spheres": ("spheres", ""),
    "mean": ("mean_mm", ".2f"),
    "95 %": ("p95_mm", ".2f"),
    "to spheres": ("to_spheres_mm", ".2f"),
    "to surface": ("to_surface_mm", ".2f"),
    "outside": ("outside_mm", ".2f"),
    "inside": ("inside_mm", ".2f"),
    "volume": ("volume_ratio", ".3f"),
    "IoU": ("iou", ".3f"),
}
"""The heads of the table, with the figure of each and how it is written."""


def _show(found: dict[str, Any]) -> None:
    """A row for each segment and one for the whole; what was mended goes to stderr."""
    for note in found["notes"]:
        tell(f"note: {note}")
    whole = found["whole"]
    emit(f"{'[mm]':<12}" + "".join(f"{head:>11}" for head in _COLUMNS))
    for name, row in [*found["segments"].items(), ("whole", whole)]:
        cells = (f"{row[figure]:>11{form}}" for figure, form in _COLUMNS.values())
        emit(f"{name:<12}" + "".join(cells))
    emit(f"{whole['seconds']:.1f} s of processor time")
    if (fewest := found.get("fewest_spheres")) is not None:
        more = 100 * (whole["spheres"] / fewest - 1)
        emit(
            f"of the spheres to choose from, no fewer than {fewest} can do: at most {more:.0f} % above the fewest"
        )
