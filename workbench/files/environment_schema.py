"""The shape of `environment.yaml`: strict models, lengths in metres and angles in radians once
validated."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from workbench.files.schema import (
    LENGTH_SCHEMA,
    Degrees,
    FileModel,
    Length,
    LengthUnit,
    Vector,
    length_in_metres,
    metres_in,
    plausible,
    to_metres,
)

__all__ = [
    "MOST_TURN",
    "AdjustmentFile",
    "AllowFile",
    "ControlFile",
    "EnvironmentFile",
    "InstrumentFile",
    "MeshFile",
    "MirrorFile",
    "PartFile",
    "RestFile",
    "SeatFile",
    "unit_metres",
]

MOST_TURN = 45.0
"""Degrees that an adjustment may turn to either side: far more than any seat, wheel or pedal."""
Axis = Literal["x", "y", "z", "-x", "-y", "-z"]
SeatAngle = Annotated[float, Field(ge=-45, le=90), AfterValidator(math.radians)]
Depth = Annotated[Length, Field(ge=0, le=1)]
Range = Annotated[tuple[Length, Length], Field(strict=False)]
Name = Annotated[str, Field(min_length=1)]


def unit_metres(text: str) -> float:
    """Metres in one unit of a mesh: a unit's name, or a length such as "150 mm" for a file to an
    odd scale."""
    if text in metres_in:
        return metres_in[text]
    metres = to_metres(text)
    if not 1e-6 <= metres <= 1e3:
        raise ValueError("one unit of a mesh is between 0.000001 and 1000 m")
    return metres


def _unit(text: str) -> str:
    unit_metres(text)
    return text


def _rising(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] <= 0 <= pair[1]:
        raise ValueError(
            "two lengths are needed, the least (zero or below) and the greatest (zero or above)"
        )
    return pair


def _turning(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] <= 0 <= pair[1]:
        raise ValueError(
            "two angles are needed, the least (zero or below) and the greatest (zero or above)"
        )
    return math.radians(pair[0]), math.radians(pair[1])


TurnAngle = Annotated[float, Field(ge=-MOST_TURN, le=MOST_TURN)]
TurnRange = Annotated[
    Annotated[tuple[TurnAngle, TurnAngle], Field(strict=False)], AfterValidator(_turning)
]


class TurnFile(FileModel):
    """Turns [rad] about x (roll), then y (pitch), then z (yaw), after the axes are put right."""

    yaw: Degrees = 0.0
    pitch: Degrees = 0.0
    roll: Degrees = 0.0


class MeshFile(FileModel):
    """A mesh: its file beside the environment; its unit and axes where the file does not say them
    or is wrong; its parts where they are to be others than in the file.

    split, drop, join: see `workbench.files.environment_parts.face_parts`.
    """

    file: Name
    length: Annotated[str, AfterValidator(_unit)] | None = None
    up: Axis | None = None
    forward: Axis | None = None
    move: Vector = (0.0, 0.0, 0.0)
    turn: TurnFile = TurnFile()
    split: list[Name] = Field(default_factory=list)
    drop: list[Name] = Field(default_factory=list)
    join: dict[Name, Annotated[list[Name], Field(min_length=1)]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _square(self) -> MeshFile:
        if self.up and self.forward and self.up[-1] == self.forward[-1]:
            raise ValueError(f"forward ({self.forward}) must be at right angles to up ({self.up})")
        return self


class AllowFile(FileModel):
    """Contact that is allowed: these segments, or "all", down to this depth [m]."""

    segments: Literal["all"] | Annotated[list[Name], Field(min_length=1)]
    depth: Depth


class PartFile(FileModel):
    """Rules for a part, or for all parts of a pattern."""

    solid: Literal["auto"] | bool = "auto"
    hidden: bool = False
    see_through: bool = False
    allow: list[AllowFile] = Field(default_factory=list)


class RestFile(FileModel):
    """A surface that is sat on or leant against, by which segments and how deep [m].

    picked: the points [m] of the part that the figures of the seat were fitted to. Only describing
    by pointing reads them; what a seat is follows from its figures alone.
    """

    part: Name
    segments: Literal["all"] | Annotated[list[Name], Field(min_length=1)]
    depth: Depth
    picked: list[Vector] = Field(default_factory=list)


def _no_back() -> RestFile:
    """The back of a stool or a bench: nothing stands there. The plane by `back_angle` through the
    seat reference point still says where the sitter's back is."""
    return RestFile.model_construct(part="", segments=["LT", "CT", "UT"], depth=0.0, picked=[])


class TravelFile(FileModel):
    """How far a seat goes from where it stands: least and greatest [m]; and how far it tilts
    [rad], with the front edge up."""

    forward: Annotated[Range, AfterValidator(_rising)] = (0.0, 0.0)
    up: Annotated[Range, AfterValidator(_rising)] = (0.0, 0.0)
    tilt: TurnRange = (0.0, 0.0)


class SeatFile(FileModel):
    """A seat; see `workbench.model.environment.Seat`."""

    srp: Vector
    back_angle: SeatAngle
    cushion_angle: SeatAngle
    yaw: Degrees = 0.0
    cushion: RestFile
    back: RestFile = Field(default_factory=_no_back)
    travel: TravelFile = TravelFile()
    moves: list[Name] = Field(default_factory=list)


class ControlFile(FileModel):
    """A control: where it is reached, the grip, the reach zone, its part ("" where it has none).

    part: of a list, whose members may be patterns, the first is the one that it stands on, and all
    are its own. A name alone leaves it open which other parts are.
    """

    at: Vector
    grip: Literal["push", "pinch", "grasp", "foot"]
    zone: Annotated[int, Field(ge=1, le=3)]
    part: str | Annotated[list[Name], Field(min_length=1)] = ""

    @property
    def part_keys(self) -> tuple[str, ...]:
        """The names and patterns of its parts."""
        if isinstance(self.part, str):
            return (self.part,) if self.part else ()
        return tuple(self.part)


def _direction(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    """The unit vector of a direction; ValueError for one without length."""
    length = math.hypot(*vector)
    if not 1e-9 <= length <= 1e9:
        raise ValueError("a direction needs a length: one of its three numbers is not zero")
    x, y, z = (value / length for value in vector)
    return x, y, z


Direction = Annotated[
    Annotated[tuple[float, float, float], Field(strict=False)], AfterValidator(_direction)
]


def _legible(metres: float) -> float:
    if not 0.0005 <= metres <= 0.2:
        raise ValueError("characters 0.5 to 200 mm high are possible")
    return metres


class InstrumentFile(FileModel):
    """An instrument: its part, the direction in which its face looks where that is not plain, the
    height of its characters [m], whether it is lit; see `workbench.model.environment.Instrument`."""

    part: Name
    face: Direction | None = None
    characters: Annotated[Length, AfterValidator(_legible)] | None = None
    lit: bool = False


def _radius(value: Any, info: ValidationInfo) -> Any:
    """The radius [m] of a convex mirror, 0 of a flat one."""
    if value == "flat":
        return 0.0
    try:
        metres = length_in_metres(value, info)
    except ValueError as error:
        raise ValueError(f"'flat', or the radius of a convex surface: {error}") from None
    if not 0.1 <= metres <= 100.0:
        raise ValueError("'flat', or the radius of a convex surface, 0.1 to 100 m, is needed")
    return metres


Radius = Annotated[
    float,
    BeforeValidator(_radius),
    WithJsonSchema({"anyOf": [{"const": "flat"}, *LENGTH_SCHEMA["anyOf"]]}),
]


class MirrorFile(FileModel):
    """A mirror: its part, the direction in which it looks where that is not plain, the radius of its
    surface [m] (0: flat), the class of field that it is for, and the point [m] that whoever has set
    it sees in its middle; see `workbench.model.environment.Mirror`."""

    part: Name
    face: Direction | None = None
    radius: Radius
    field: Annotated[str, Field(alias="class")] = ""
    aims: Vector | None = None


class AboutFile(FileModel):
    """The axis of a turn, by the right-hand rule: a point on it [m] and its direction."""

    point: Vector
    axis: Direction


def _end_of_travel(value: Any, info: ValidationInfo) -> Any:
    """An end of the travel of an adjustment: an angle [rad] of a turn, else a length [m]."""
    if "about" not in info.data or info.data["about"] is None:
        return plausible(length_in_metres(value, info))
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError("a number of degrees is needed")
    if not -MOST_TURN <= value <= MOST_TURN:
        raise ValueError(f"{-MOST_TURN:g} to {MOST_TURN:g} degrees are possible")
    return math.radians(value)


End = Annotated[float, BeforeValidator(_end_of_travel), WithJsonSchema(LENGTH_SCHEMA)]


class AdjustmentFile(FileModel):
    """What an occupant sets: parts that slide `along` a direction, or turn `about` an axis.

    travel: least and greatest, of a slide [m], of a turn [rad]; see
    `workbench.model.environment.Adjustment`.
    """

    along: Direction | None = None
    about: AboutFile | None = None
    travel: Annotated[tuple[End, End], Field(strict=False)]
    parts: list[Name] = Field(default_factory=list)
    points: list[Name] = Field(default_factory=list)
    mounted_on: Name | None = None
    seat: Name | None = None

    @field_validator("travel")
    @classmethod
    def _holds_zero(cls, travel: tuple[float, float]) -> tuple[float, float]:
        low, high = travel
        if not low <= 0 <= high:
            raise ValueError(
                "the least (zero or below) and the greatest (zero or above) are needed: the mesh "
                "shows the nominal setting, which is 0"
            )
        if low == high:
            raise ValueError("an adjustment needs travel: this one stays where it is")
        return travel

    @model_validator(mode="after")
    def _slides_or_turns(self) -> AdjustmentFile:
        if (self.along is None) == (self.about is None):
            raise ValueError(
                "an adjustment slides or turns: give 'along', or 'about' with a point and an axis"
            )
        return self


class EnvironmentFile(FileModel):
    """The whole file.

    accepted: what doubts are about that are put away, or patterns of it.
    """

    environment: Name
    description: str = ""
    source: str = ""
    licence: str = ""
    length: LengthUnit
    meshes: Annotated[list[MeshFile], Field(min_length=1)]
    parts: dict[str, PartFile] = Field(default_factory=dict)
    seats: dict[str, SeatFile] = Field(default_factory=dict)
    points: dict[str, Vector] = Field(default_factory=dict)
    controls: dict[str, ControlFile] = Field(default_factory=dict)
    adjustments: dict[str, AdjustmentFile] = Field(default_factory=dict)
    instruments: dict[str, InstrumentFile] = Field(default_factory=dict)
    mirrors: dict[str, MirrorFile] = Field(default_factory=dict)
    accepted: list[Name] = Field(default_factory=list)
