"""The shape of crash studies (`kind: crash`) and of rule sets (`studies/rules/NAME.yaml`)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from workbench.files.crash.simulation_schema import AirbagFile, BeltFile, ContactFile, PulseFile
from workbench.files.schema import Degrees, FileModel, Length, LengthUnit, Vector

__all__ = ["CrashFile", "MotionSource", "RulesFile"]

Name = Annotated[str, Field(min_length=1, max_length=200)]
Names = Annotated[list[str], Field(min_length=1)]
Seconds = Annotated[float, Field(ge=-1e6, le=1e6)]


class MotionSource(FileModel):
    """A motion file beside the study, and how it is read: frames from `start` to `end` [s], every
    n-th; `map`: bones by segment or usual marker names by the file's; `up`: its upward axis;
    `unit`: one unit of a BVH file; `gaps` [s]: the longest that is bridged; `move` and `yaw`: where
    it is put; `scale: subject`: the body takes the lengths that the file tells (of `motion` only);
    `simulation`: the one that made it, whose pulse, belts and airbags then hold for it."""

    file: Name
    start: Seconds | None = None
    end: Seconds | None = None
    every: Annotated[int, Field(ge=1)] = 1
    map: dict[str, str] = {}
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None
    unit: Length | None = None
    gaps: Annotated[float, Field(ge=0, le=10)] = 0.1
    move: Vector = (0.0, 0.0, 0.0)
    yaw: Degrees = 0.0
    scale: Literal["body", "subject"] = "body"
    name: str = ""
    simulation: str | None = None


class PointFile(FileModel):
    """A point whose signals are wanted; the segment's centre of gravity where `at` is not given."""

    name: Name
    segment: str
    at: Vector = (0.0, 0.0, 0.0)


class CrashCriterionFile(FileModel):
    """Something that must hold. contact: no contact of these segments and parts deeper than
    `at_most` (0) beyond what is allowed; excursion: no surface of these segments farther than
    `at_most` along `direction` from `origin`; stops: no joint farther past its stop than `degrees`;
    rules: the limits of the study's rule set."""

    name: Name
    check: Literal["contact", "excursion", "stops", "rules"]
    segments: Names | None = None
    parts: Names | None = None
    at_most: Length | None = None
    direction: Annotated[tuple[float, float, float], Field(strict=False)] | None = None
    origin: Vector | None = None
    degrees: Annotated[float, Field(ge=0, le=180)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> CrashCriterionFile:
        wanted = {
            "contact": {"segments", "parts", "at_most"},
            "stops": {"degrees"},
            "rules": set(),
            "excursion": {"segments", "at_most", "direction", "origin"},
        }[self.check]
        given = {
            key
            for key in ("segments", "parts", "at_most", "direction", "origin", "degrees")
            if getattr(self, key) is not None
        }
        if given - wanted:
            raise ValueError(
                f"{sorted(given - wanted)[0]!r} does not belong to check: {self.check}"
            )
        if self.check == "excursion" and given != wanted:
            raise ValueError("an excursion needs 'segments', 'at_most', 'direction' and 'origin'")
        if self.direction is not None and not any(self.direction):
            raise ValueError("'direction' must not be zero")
        return self


class CrashFile(FileModel):
    """A crash study. `pulse` (added to what is measured in the vehicle, so that accelerations are
    against the ground), `belts` through `anchors` and `airbags` (parts): of motions that name no
    simulation. `forces`: laws of contact by part; without one no force is told. `film`: a film with
    the report."""

    study: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,79}$")]
    kind: Literal["crash"]
    title: str = ""
    description: str = ""
    length: LengthUnit
    environment: str
    person: Name = "occupant"
    body: str
    motion: MotionSource
    against: MotionSource | None = None
    points: list[PointFile] = []
    filter_class: Literal[60, 180, 600, 1000] | None = None
    rules: str | None = None
    pulse: PulseFile | None = None
    anchors: dict[str, Vector] = {}
    belts: list[BeltFile] = []
    airbags: list[AirbagFile] = []
    forces: list[ContactFile] = []
    film: bool = False
    criteria: Annotated[list[CrashCriterionFile], Field(min_length=1)]


class LimitFile(FileModel):
    """A limit on a signal. figure: hic (limit without a unit; `window` in seconds, the whole pulse
    where not given) or held (limit in g; `hold` in seconds); segment: whose point it is about."""

    figure: Literal["hic", "held"]
    segment: str
    limit: Annotated[float, Field(gt=0)]
    window: Annotated[float, Field(gt=0)] | None = None
    hold: Annotated[float, Field(gt=0)] | None = None
    source: Annotated[str, Field(min_length=1)]


class RulesFile(FileModel):
    """A rule set: limits with their sources."""

    rules: Name
    description: str = ""
    limits: Annotated[list[LimitFile], Field(min_length=1)]
