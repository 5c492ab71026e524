"""The shape of `studies/NAME.yaml`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from workbench.files.postures import AnglesFile, AttitudeFile
from workbench.files.schema import FileModel, Length, LengthUnit, Vector

__all__ = [
    "DRIVING",
    "PREDICTED",
    "CaseFile",
    "CasePersonFile",
    "CriterionFile",
    "DriverFile",
    "PersonFile",
    "SizeFile",
    "StudyFile",
    "population_name",
]

Name = Annotated[str, Field(min_length=1, max_length=200)]
Names = Annotated[list[str], Field(min_length=1)]
PREDICTED = "predicted"
DRIVING = "driving_statistical"


class AdjustFile(FileModel):
    """Where in its travel a seat stands."""

    forward: Length = 0.0
    up: Length = 0.0


class AtFile(FileModel):
    """A segment at a place."""

    segment: str
    position: Vector
    attitude: AttitudeFile = AttitudeFile()


class StandFile(FileModel):
    """A point the lowest sphere stands on, and the heading."""

    on: Vector
    yaw: Annotated[float, Field(ge=-360, le=360)] = 0.0


class SizeFile(FileModel):
    """A person's size: some measures, the rest as people of the population with these have them.

    With an age [years] the population is one of growth charts; a child may do without measures.
    """

    sex: Literal["male", "female"]
    age: Annotated[float, Field(gt=0, le=120)] | None = None
    population: str | None = None
    measures: dict[str, Annotated[Length, Field(gt=0)]] = {}
    mass_kg: Annotated[float, Field(gt=0, le=400)] | None = None

    @model_validator(mode="after")
    def _says_something(self) -> SizeFile:
        if self.age is None and not self.measures:
            raise ValueError("a size is one measure or more, or the age of a child")
        return self


def population_name(size: SizeFile) -> str:
    """The population of a size: as named, or ANSUR II, or the CDC's growth charts for a child."""
    return size.population or ("ansur2" if size.age is None else "cdc_growth")


class PersonFile(FileModel):
    """A body, perhaps to a size, and where it is: in a seat, at a place, or standing."""

    body: str
    size: SizeFile | None = None
    detail: Literal["coarse", "medium", "fine"] | None = None
    encumbrance: list[str] = []
    seat: str | None = None
    adjust: AdjustFile | None = None
    at: AtFile | None = None
    stand: StandFile | None = None

    @model_validator(mode="after")
    def _one_place(self) -> PersonFile:
        if [self.seat, self.at, self.stand].count(None) != 2:
            raise ValueError("exactly one of 'seat', 'at' and 'stand' says where a person is")
        if self.adjust and not self.seat:
            raise ValueError("'adjust' moves a seat; give 'seat' too")
        return self


class SidesFile(FileModel):
    """The controls that the left and the right hand or foot hold."""

    left: str | None = None
    right: str | None = None


class DriverFile(FileModel):
    """A driver's posture as people's is: the mean of such people, or drawn with a seed.

    wheel: the point at the steering wheel's centre; h_point: where the hip point of the seat is
    (SgRP) with the seat in its reference position; sex: as the size says where not given.
    """

    wheel: str
    h_point: str
    sex: Literal["male", "female"] | None = None
    age: Annotated[float, Field(ge=16, le=100)] = 40.0
    seed: Annotated[int, Field(ge=0, le=2**63)] | None = None


class CasePersonFile(FileModel):
    """The posture of one person in one case: a named one, and angles that replace the posture's.

    With posture: predicted, trunk and head are those of the posture `like`, and the limbs go to the
    controls they hold; the eyes come to the height of the point `eyes` as far as the seat goes, the
    heels stand at that of `heels`. With posture: driving_statistical, trunk, head and legs are a
    driver's by Park et al. (2016); `driver` says whose.
    """

    posture: str
    angles: AnglesFile = {}
    like: str = "driving"
    hands: SidesFile = SidesFile()
    feet: SidesFile = SidesFile()
    eyes: str | None = None
    heels: str | None = None
    driver: DriverFile | None = None

    @model_validator(mode="after")
    def _fits_the_posture(self) -> CasePersonFile:
        told = {"like", "hands", "feet", "eyes", "heels"} & self.model_fields_set
        if told and self.posture not in (PREDICTED, DRIVING):
            raise ValueError(f"{sorted(told)[0]!r} belongs to posture: {PREDICTED}")
        if (self.driver is not None) != (self.posture == DRIVING):
            raise ValueError(f"'driver' and posture: {DRIVING} go together")
        if self.driver is not None and (self.feet.right is None or self.heels is None):
            raise ValueError(
                "a driver's right foot is on the accelerator and the heel on the floor: give both 'feet: "
                "{right: ...}' and 'heels'"
            )
        return self

    @property
    def named(self) -> str:
        """The named posture that the case begins from."""
        return self.like if self.posture in (PREDICTED, DRIVING) else self.posture


class CaseFile(FileModel):
    """One case: everybody's posture."""

    name: Name
    people: dict[str, CasePersonFile]


class CriterionFile(FileModel):
    """Something that must hold in every case; what is not named means all."""

    name: Name
    check: Literal["contact", "clearance", "self_contact", "between_people", "stops", "reach"]
    people: Names | None = None
    segments: Names | None = None
    parts: Names | None = None
    at_least: Length | None = None
    degrees: Annotated[float, Field(ge=-180, le=180)] | None = None
    controls: Names | None = None
    zone: Annotated[int, Field(ge=1, le=3)] | None = None

    @model_validator(mode="after")
    def _fits_the_check(self) -> CriterionFile:
        if (self.check == "clearance") and self.at_least is None:
            raise ValueError("a clearance needs 'at_least'")
        if (
            self.check in ("contact", "self_contact", "stops", "reach")
            and self.at_least is not None
        ):
            raise ValueError(
                f"'at_least' is a length; {self.check} takes none"
                + (", use 'degrees'" if self.check == "stops" else "")
            )
        if self.degrees is not None and self.check != "stops":
            raise ValueError("'degrees' belongs to check: stops")
        if self.parts is not None and self.check not in ("contact", "clearance"):
            raise ValueError(f"'parts' belongs to contact and clearance, not to {self.check}")
        if (self.controls is not None or self.zone is not None) and self.check != "reach":
            raise ValueError("'controls' and 'zone' belong to check: reach")
        return self


class EnvelopeFile(FileModel):
    """A reach envelope about the seat reference point: whose, by which hand, grip and zone."""

    person: str
    hand: Literal["left", "right"] = "right"
    grip: Literal["push", "pinch", "grasp"] = "grasp"
    zone: Annotated[int, Field(ge=1, le=3)] = 1
    obstacles: bool = False


class StudyFile(FileModel):
    """A study file."""

    study: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,79}$")]
    kind: Literal["clearance", "reach"]
    title: str = ""
    description: str = ""
    length: LengthUnit
    environment: str
    people: Annotated[dict[str, PersonFile], Field(min_length=1)]
    cases: Annotated[list[CaseFile], Field(min_length=1)]
    criteria: Annotated[list[CriterionFile], Field(min_length=1)]
    envelopes: list[EnvelopeFile] = []

    @model_validator(mode="after")
    def _fits_the_kind(self) -> StudyFile:
        if self.kind != "reach" and self.envelopes:
            raise ValueError("'envelopes' belong to kind: reach")
        return self
