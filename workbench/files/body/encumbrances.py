"""Encumbrance files `bodies/encumbrance/NAME.yaml`: what people wear."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find
from workbench.files.schema import FileModel, Length, LengthUnit, Vector, error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.person import Encumbrance, Layer

__all__ = ["EncumbranceFile", "load_encumbrance", "load_encumbrances", "missing"]

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
    """Something worn: layers over the body's spheres, and its mass [kg] by segment.

    without: segments that the layers stand in place of, as a prosthesis does; only there may layers
    be thinner than the body.
    """

    encumbrance: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9 _.-]{0,39}$")]
    description: str = ""
    source: Annotated[
        str, Field(min_length=1, description="where the sizes come from, or that they are assumed")
    ]
    licence: str = ""
    length: LengthUnit
    layers: Annotated[list[LayerFile], Field(min_length=1)]
    mass: dict[str, Kilograms] = {}
    without: list[str] = []


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
        file.encumbrance,
        file.description,
        file.source,
        layers,
        tuple(file.mass.items()),
        tuple(file.without),
    )


def missing(names: list[str], body: Body) -> Encumbrance:
    """What is missing of a body: limbs, each with all that it carries.

    Raises
    ------
    InputError
        If a segment is none of a limb, or carries one that is not named too.
    """
    known = _limbs(body)
    for name in names:
        if name not in known:
            raise InputError(f"{name!r} is no segment of a limb; {one_of(name, known)}")
        n = body.segment(name)
        left = [s for k, s in enumerate(body.segments) if body.parent[k] == n and s not in names]
        if left:
            raise InputError(f"without {name} nothing holds {', '.join(left)}: name it too")
    words = ", ".join(body.segment_names[body.segment(name)] for name in names)
    return Encumbrance(f"no {words}", "", "a limb that is missing", (), (), tuple(names))


def _limbs(body: Body) -> list[str]:
    """The segments of arms and legs: those that have a twin on the other side."""
    twin = {"L": "R", "R": "L"}
    return [s for s in body.segments if twin.get(s[0], "") + s[1:] in body.segments and len(s) > 1]


def load_encumbrances(
    names: list[str], body: Body, *, near: Path | None = None
) -> tuple[Encumbrance, ...]:
    """The encumbrances of these names, in order, that fit a body; InputError where one does not, or
    stands twice."""
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name!r} cannot be worn twice")
    found = tuple(load_encumbrance(name, near=near) for name in names)
    for item in found:
        for name in dict.fromkeys(
            s
            for s in (
                *(s for layer in item.layers for s in layer.segments),
                *dict(item.mass),
                *item.without,
            )
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
        if layer.thickness < 0 and not set(layer.segments) <= set(file.without):
            faults.append(
                error_at(
                    document,
                    ("layers", row, "thickness"),
                    f"0 or more is needed (got {layer.thickness:g} m) on segments that are not 'without'",
                )
            )
        in_place = set(layer.segments) <= set(file.without)
        if not (layer.thickness or any(layer.shift) or in_place):
            faults.append(
                error_at(document, ("layers", row), "a layer has a thickness, a shift or both")
            )
    return faults
