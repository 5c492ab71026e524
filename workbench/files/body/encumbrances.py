"""Encumbrance files `bodies/encumbrance/NAME.yaml`: what people wear."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find
from workbench.files.schema import FileModel, Length, LengthUnit, Vector, fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.encumbrance import Encumbrance, Layer

__all__ = ["EncumbranceFile", "load_encumbrance", "worn"]

Direction = Literal["front", "back", "left", "right", "top", "bottom"]
Kilograms = Annotated[float, Field(ge=0, le=100)]


class BeyondFile(FileModel):
    """Spheres whose middles lie at least `by` along a direction of the segment from a named
    sphere."""

    direction: Direction
    of: str
    by: Length = 0.0


class LayerFile(FileModel):
    """Copies of spheres of some segments, grown by a thickness and shifted in the segment's
    frame."""

    segments: Annotated[list[str], Field(min_length=1)]
    subparts: list[str] = []
    beyond: list[BeyondFile] = []
    thickness: Length = 0.0
    shift: Vector = (0.0, 0.0, 0.0)


class EncumbranceFile(FileModel):
    """Something worn: layers over the body's spheres, and its mass [kg] by segment."""

    encumbrance: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.-]{0,39}$")]
    description: str = ""
    source: Annotated[
        str, Field(min_length=1, description="where the sizes come from, or that they are assumed")
    ]
    licence: str = ""
    length: LengthUnit
    layers: Annotated[list[LayerFile], Field(min_length=1)]
    mass: dict[str, Kilograms] = {}


def load_encumbrance(source: str | Path, *, near: Path | None = None) -> Encumbrance:
    """What is worn, by its name in bodies/encumbrance or by path; InputError lists all faults of
    the file."""
    document = read_yaml(find("bodies/encumbrance", str(source), near=near))
    file = validate(document, EncumbranceFile)
    if faults := _faults(document, file):
        raise InputError(faults)
    layers = tuple(
        Layer(
            segments=tuple(row.segments),
            subparts=tuple(row.subparts),
            beyond=tuple((rule.direction, rule.of, rule.by) for rule in row.beyond),
            thickness=row.thickness,
            shift=row.shift,
        )
        for row in file.layers
    )
    return Encumbrance(
        file.encumbrance, file.description, file.source, layers, tuple(file.mass.items())
    )


def worn(names: list[str], body: Body, *, near: Path | None = None) -> tuple[Encumbrance, ...]:
    """The encumbrances of these names, in order, that fit a body; InputError where one does not, or
    stands twice."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name!r} cannot be worn twice")
    found = tuple(load_encumbrance(name, near=near) for name in names)
    for item in found:
        for name in dict.fromkeys(
            s for s in (*(s for layer in item.layers for s in layer.segments), *dict(item.mass))
        ):
            if name not in body.segments:
                hint = one_of(name, body.segments)
                raise InputError(
                    f"{item.name} is worn on segment {name!r}, which body {body.name} does not have; {hint}"
                )
    return found


def _faults(document: Document, file: EncumbranceFile) -> list[str]:
    faults = []
    for row, layer in enumerate(file.layers):
        if layer.thickness < 0:
            faults.append(
                fail(
                    document,
                    ("layers", row, "thickness"),
                    f"0 or more is needed (got {layer.thickness:g} m)",
                )
            )
        if not layer.thickness and not any(layer.shift):
            faults.append(
                fail(document, ("layers", row), "a layer has a thickness, a shift or both")
            )
    return faults
