"""The shape of `bodies/NAME.yaml`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from workbench.files.schema import Degrees, FileModel, Length, LengthUnit, Vector
from workbench.model.body import SEATED_FACTORS

__all__ = [
    "AllowanceFile",
    "BodyFile",
    "CouplingFile",
    "JointFile",
    "MotionFile",
    "PolygonFile",
    "SegmentFile",
]

Direction = Literal["front", "back", "left", "right", "top", "bottom"]


Axis = Annotated[
    Annotated[Literal["+x", "-x", "+y", "-y", "+z", "-z"], Tag("name")]
    | Annotated[tuple[float, float, float], Field(strict=False), Tag("vector")],
    Discriminator(lambda given: "vector" if isinstance(given, (list, tuple)) else "name"),
]
Name = Annotated[str, Field(min_length=1, max_length=80)]
Radius = Annotated[Length, Field(gt=0)]


Sphere = Annotated[
    Annotated[tuple[Length, Length, Length, Radius], Field(strict=False), Tag("4")]
    | Annotated[tuple[Length, Length, Length, Radius, Name], Field(strict=False), Tag("5")]
    | Annotated[
        tuple[Length, Length, Length, Radius, Name, Direction], Field(strict=False), Tag("6")
    ],
    Discriminator(
        lambda given: str(len(given)) if isinstance(given, (list, tuple)) else None,
        custom_error_type="sphere_row",
        custom_error_message="a sphere is [x, y, z, radius], then optionally a name and a direction",
    ),
]
Pair = Annotated[tuple[str, str], Field(strict=False)]
DegreePair = Annotated[tuple[Degrees, Degrees], Field(strict=False)]
Row = Annotated[str, Field(pattern=r"^[0-9]{1,6}$", description="a row of `spheres`, from 0")]
Share = Annotated[float, Field(ge=0, le=1)]
NonNegative = Annotated[Degrees, Field(ge=0)]


class FitErrorFile(FileModel):
    """How far the true surface may lie outside and inside the spheres."""

    outside: Annotated[Length, Field(ge=0)]
    inside: Annotated[Length, Field(ge=0)]


class SegmentFile(FileModel):
    """A segment: name, mass [kg], directions, spheres in its own frame.

    blend: by joint of the segment, how much of the motion of the segment across it a sphere takes,
    0 to 1, by row.
    """

    name: Name
    number: Annotated[int, Field(ge=1)]
    mass: Annotated[float, Field(ge=0)]
    directions: Annotated[dict[Direction, Axis], Field(min_length=3, max_length=6)]
    twist_along: str | None = None
    fit_error: FitErrorFile | None = None
    spheres: list[Sphere] = []
    blend: dict[str, dict[Row, Share]] = {}


class MotionFile(FileModel):
    """One axis of a joint: the names of the motion in both senses, the axis of the first, the
    limits of both."""

    motion: Pair
    axis: Axis
    limits: Annotated[tuple[NonNegative, NonNegative], Field(strict=False)]


class CouplingFile(FileModel):
    """A limit that depends on another motion: `to` degrees where the driver motion stands at
    `from`."""

    limit: str
    driver: Annotated[str, Field(pattern=r"^[^.]+\.[^.]+$", description="JOINT.motion")]
    from_: Annotated[DegreePair, Field(alias="from")]
    to: Annotated[tuple[NonNegative, NonNegative], Field(strict=False)]


class PolygonFile(FileModel):
    """The spherical polygon of a joint stop: greatest polar angle by clock angle about a centre
    direction."""

    frame: str
    centre: Annotated[tuple[float, float, float], Field(strict=False)]
    clock_0: Annotated[tuple[float, float, float], Field(strict=False)]
    clock_90: Annotated[tuple[float, float, float], Field(strict=False)]
    limits: Annotated[list[DegreePair], Field(min_length=3)]
    limb: Axis = "-z"


class JointFile(FileModel):
    """A joint: the two segments it joins, its coordinates in both, its motions and its stop."""

    name: Name
    number: Annotated[int, Field(ge=1)]
    between: Pair
    at: Annotated[dict[str, Vector], Field(min_length=2, max_length=2)]
    stop: Literal["free", "cone", "hinge", "polygon"]
    swing: Annotated[list[MotionFile], Field(min_length=2, max_length=2)]
    twist: MotionFile
    play: NonNegative = 0.0
    couplings: list[CouplingFile] = []
    polygon: PolygonFile | None = None

    @model_validator(mode="after")
    def _polygon_belongs_to_polygon_stop(self) -> JointFile:
        if (self.stop == "polygon") != (self.polygon is not None):
            raise ValueError("key 'polygon' is needed where stop is 'polygon', and only there")
        return self


class AllowanceFile(FileModel):
    """Overlap of two segments up to this depth is soft flesh, not a contact."""

    between: Pair
    depth: Annotated[Length, Field(ge=0)]


SeatedFactor = Annotated[float, Field(ge=SEATED_FACTORS[0], le=SEATED_FACTORS[1])]


class SeatedFile(FileModel):
    """How flesh spreads on a seat: breadth and thickness of hips and thighs as shares of those
    standing."""

    breadth: SeatedFactor
    thickness: SeatedFactor


class BodyFile(FileModel):
    """A body file. seated: how flesh spreads on a seat; basis: the family it belongs to, a file
    beside it; basis_at: its coefficients in that family."""

    body: Name
    description: str = ""
    source: str = ""
    licence: str = ""
    length: LengthUnit
    postures: str | None = None
    segments: Annotated[dict[str, SegmentFile], Field(min_length=1)]
    joints: dict[str, JointFile] = {}
    allowances: list[AllowanceFile] = []
    seated: SeatedFile | None = None
    basis: str | None = None
    basis_at: list[float] = []
