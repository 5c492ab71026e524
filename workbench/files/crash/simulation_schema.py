"""The shape of simulations (`studies/simulations/NAME.yaml`), and what crash studies share with
them: pulses, belts, airbags and force laws. Times in ms, decelerations in g, forces in N."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from workbench.files.postures import AdjustFile, AnglesFile, AtFile
from workbench.files.schema import FileModel, Length, LengthUnit, Vector

__all__ = [
    "AirbagFile",
    "BeltFile",
    "BeltPointFile",
    "ContactFile",
    "LawFile",
    "PulseFile",
    "SimulationFile",
]

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_. -]{0,79}$")]
Names = Annotated[list[str], Field(min_length=1)]
Milliseconds = Annotated[float, Field(ge=0, le=1e5)]
Level = Annotated[float, Field(ge=-1000, le=1000)]
Share = Annotated[float, Field(gt=0, le=1)]
Direction = Annotated[tuple[float, float, float], Field(strict=False)]


class PulseFile(FileModel):
    """How the vehicle is decelerated. half_sine: `peak` [g] and `duration` [ms]; trapezoid: `peak`,
    `rise`, `hold` and `fall` [ms]; table: a CSV `file` with columns `time [ms]` (or [s]) and
    `acceleration [g]` (or [m/s2]) that begins and ends at 0. `toward`: the way in which occupants
    are thrown, x forward where not given."""

    shape: Literal["half_sine", "trapezoid", "table"]
    peak: Level | None = None
    duration: Annotated[float, Field(gt=0, le=1e5)] | None = None
    rise: Milliseconds | None = None
    hold: Milliseconds | None = None
    fall: Milliseconds | None = None
    file: str | None = None
    start: Milliseconds = 0.0
    toward: Direction = (1.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _fits(self) -> PulseFile:
        wanted = {
            "half_sine": {"peak", "duration"},
            "trapezoid": {"peak", "rise", "hold", "fall"},
            "table": {"file"},
        }[self.shape]
        given = {
            key
            for key in ("peak", "duration", "rise", "hold", "fall", "file")
            if getattr(self, key) is not None
        }
        if given != wanted:
            wrong = (
                f"{sorted(given - wanted)[0]!r} does not belong to"
                if given - wanted
                else f"{sorted(wanted - given)[0]!r} is missing in"
            )
            raise ValueError(f"{wrong} a {self.shape} pulse, which has {', '.join(sorted(wanted))}")
        if (
            self.shape == "trapezoid"
            and not (self.rise or 0) + (self.hold or 0) + (self.fall or 0) > 0
        ):
            raise ValueError("a trapezoid pulse must last longer than 0 ms")
        if not any(self.toward):
            raise ValueError("'toward' must not be zero")
        return self


class BeltPointFile(FileModel):
    """A point of a belt on a segment: from the segment's origin toward `at`, on the surface of its
    spheres."""

    segment: str
    at: Vector


class LawFile(FileModel):
    """A force over a depth d [mm]: stiffness [N/mm^exponent] d^exponent while it grows; `returned`:
    the share of the work that comes back on the way out."""

    stiffness: Annotated[float, Field(ge=0, le=1e6)]
    exponent: Annotated[float, Field(ge=1, le=10)] = 1.0
    returned: Share = 1.0
    friction: Annotated[float, Field(ge=0, le=10)] = 0.0


class BeltFile(FileModel):
    """Webbing through points in order: anchors by name, places in the world, points of segments.
    Tension is `stiffness` [N/mm] times the elongation beyond `slack`; as a part it allows `allow`
    of depth."""

    name: Name
    route: Annotated[list[str | Vector | BeltPointFile], Field(min_length=2)]
    stiffness: Annotated[float, Field(gt=0, le=1e6)]
    returned: Share = 1.0
    slack: Annotated[Length, Field(ge=0)] = 0.0
    width: Annotated[Length, Field(gt=0)] = 0.048
    allow: Annotated[Length, Field(ge=0)] = 0.15


class AirbagFile(FileModel):
    """A deployed airbag: an ellipsoid that stands still, into which all segments may go as deep as
    `allow`."""

    name: Name
    centre: Vector
    half_axes: Annotated[
        tuple[
            Annotated[Length, Field(gt=0)],
            Annotated[Length, Field(gt=0)],
            Annotated[Length, Field(gt=0)],
        ],
        Field(strict=False),
    ]
    pitch: Annotated[float, Field(ge=-360, le=360)] = 0.0
    allow: Annotated[Length, Field(ge=0)] = 0.25


class ContactFile(LawFile):
    """The force law of some segments (all) against some parts."""

    parts: Names
    segments: Names | None = None


class JointFile(FileModel):
    """Passive stiffness [Nm/rad] toward the posture at the start, and damping [Nm s/rad], of some
    joints."""

    joints: Names
    stiffness: Annotated[float, Field(ge=0, le=1e6)] | None = None
    damping: Annotated[float, Field(ge=0, le=1e6)] | None = None


class SimulationFile(FileModel):
    """A crash to be simulated by rigid-body dynamics. `duration`, `frames` (between frames of the
    motion), `step` and `settle` (at most) in ms. While the occupant settles, joints hold his
    posture, but for those `relaxed`."""

    simulation: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,79}$")]
    title: str = ""
    description: str = ""
    length: LengthUnit
    environment: str
    body: str
    seat: str | None = None
    adjust: AdjustFile | None = None
    at: AtFile | None = None
    posture: str
    angles: AnglesFile = {}
    pulse: PulseFile
    anchors: dict[str, Vector] = {}
    belts: list[BeltFile] = []
    airbags: list[AirbagFile] = []
    contact: list[ContactFile] = []
    others: LawFile = LawFile(stiffness=150.0, returned=0.2, friction=0.3)
    flesh: LawFile = LawFile(stiffness=40.0, returned=0.2, friction=0.3)
    joints: list[JointFile] = []
    relaxed: list[str] = []
    tone: Annotated[float, Field(ge=0, le=100)] = 1.0
    gravity: Annotated[float, Field(ge=0, le=100)] = 9.80665
    duration: Annotated[float, Field(gt=0, le=5000)] = 200.0
    frames: Annotated[float, Field(gt=0, le=1000)] = 1.0
    step: Annotated[float, Field(gt=0, le=100)] = 0.2
    settle: Annotated[float, Field(ge=0, le=5000)] = 600.0

    @model_validator(mode="after")
    def _fits(self) -> SimulationFile:
        if (self.seat is None) == (self.at is None):
            raise ValueError("exactly one of 'seat' and 'at' says where the occupant is")
        if self.adjust and not self.seat:
            raise ValueError("'adjust' moves a seat; give 'seat' too")
        if self.step > self.frames or self.frames > self.duration:
            raise ValueError("'step' must not exceed 'frames', nor 'frames' the 'duration'")
        return self
