"""The shape of accommodation studies (`kind: accommodation`): a whole population through one
workplace."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from workbench.files.schema import FileModel, Length, LengthUnit, Vector
from workbench.files.study_schema import DriverFile, SidesFile
from workbench.model.accommodation import MAP_POINTS

__all__ = [
    "AccommodationFile",
    "ChangeFile",
    "DemandFile",
    "IntervalFile",
    "MapFile",
    "PopulationSourceFile",
    "SittingFile",
]

Name = Annotated[str, Field(min_length=1, max_length=200)]
Names = Annotated[list[str], Field(min_length=1)]
Share = Annotated[float, Field(ge=0, le=1)]
MOST_PEOPLE = 250_000
_BELONGS = {
    "reach": {"controls", "zone", "hand"},
    "vision": {"at_most_below", "at_most_above", "parts", "degrees"},
    "clearance": {"segments", "subparts", "parts", "at_least"},
    "contact": {"segments", "parts"},
    "seat": set(),
    "stops": {"degrees"},
}
_KEYS = (
    "controls",
    "zone",
    "hand",
    "at_most_below",
    "at_most_above",
    "parts",
    "degrees",
    "segments",
    "subparts",
    "at_least",
)


class PopulationSourceFile(FileModel):
    """Who is to be served: people drawn from a population file, or the rows of CSV files.

    source: a population (ansur2 where nothing is given), of which `people` are drawn with `seed`,
    the share `women` of them women. files: CSV files with one row a person, in the layout of the
    public ANSUR II files, lengths in `unit` (mm) and weightkg in 0.1 kg; weights: the column that
    says for how many people each row stands; people: only so many rows, spread evenly over the
    files. sexes: only these.
    """

    source: str | None = None
    people: Annotated[int, Field(ge=1, le=MOST_PEOPLE)] | None = None
    seed: Annotated[int, Field(ge=0, le=2**63)] | None = None
    women: Share | None = None
    files: Names | None = None
    unit: LengthUnit = "mm"
    weights: str | None = None
    sexes: Annotated[list[Literal["male", "female"]], Field(min_length=1)] = ["male", "female"]

    @model_validator(mode="after")
    def _one_source(self) -> PopulationSourceFile:
        if self.files is None:
            if self.people is None or self.seed is None:
                raise ValueError("people that are drawn need 'people', how many, and a 'seed'")
            if self.weights is not None or "unit" in self.model_fields_set:
                raise ValueError("'unit' and 'weights' belong to 'files'")
        elif self.source is not None or self.seed is not None or self.women is not None:
            raise ValueError(
                "'files' have people of their own: 'source', 'seed' and 'women' belong to people drawn"
            )
        if len(set(self.sexes)) < len(self.sexes):
            raise ValueError("a sex stands twice in 'sexes'")
        if self.women is not None and len(self.sexes) == 1:
            raise ValueError("'women' is a share of both sexes")
        return self


class SittingFile(FileModel):
    """How they sit: trunk and head as in the posture `like`, hands and feet at these controls, eyes
    at the height of a point as far as the seat goes, heels at that of another. With `driver` trunk,
    head and legs are drivers' by Park et al. (2016), each drawn with the driver's seed and the
    person's number."""

    like: str = "driving"
    hands: SidesFile = SidesFile()
    feet: SidesFile = SidesFile()
    eyes: str | None = None
    heels: str | None = None
    driver: DriverFile | None = None

    @model_validator(mode="after")
    def _drives(self) -> SittingFile:
        if self.driver is not None and (self.feet.right is None or self.heels is None):
            raise ValueError(
                "a driver's right foot is on the accelerator and the heel on the floor: give both 'feet: "
                "{right: ...}' and 'heels'"
            )
        if self.driver is not None and self.driver.sex is not None:
            raise ValueError("the sex of each driver is that of the person in the population")
        return self


class DemandFile(FileModel):
    """Something that is asked of everybody.

    reach: each control in its own zone or in `zone`, by either hand unless `hand` says which;
    vision: the eyes no more than `at_most_below` and `at_most_above` the point of the posture's
    eyes, or looking `degrees` down over `parts`; clearance: segments or subparts ("RLL/knee cap")
    to parts `at_least`; contact: no deeper in any part than it allows; seat: the pedals reached
    somewhere within the seat's travel; stops: joints so many `degrees` within theirs.
    """

    name: Name
    check: Literal["reach", "vision", "clearance", "contact", "seat", "stops"]
    controls: Names | None = None
    zone: Annotated[int, Field(ge=1, le=3)] | None = None
    hand: Literal["left", "right"] | None = None
    at_most_below: Annotated[Length, Field(ge=0)] | None = None
    at_most_above: Annotated[Length, Field(ge=0)] | None = None
    degrees: Annotated[float, Field(ge=-90, le=90)] | None = None
    segments: Names | None = None
    subparts: Names | None = None
    parts: Names | None = None
    at_least: Length | None = None

    @model_validator(mode="after")
    def _fits_the_check(self) -> DemandFile:
        for key in _KEYS:
            if getattr(self, key) is not None and key not in _BELONGS[self.check]:
                raise ValueError(f"{key!r} does not belong to check: {self.check}")
        if self.check == "clearance" and self.at_least is None:
            raise ValueError("a clearance needs 'at_least'")
        if self.segments is not None and self.subparts is not None:
            raise ValueError("'segments' or 'subparts', not both")
        if self.check == "vision":
            heights = self.at_most_below is not None or self.at_most_above is not None
            if heights == (self.degrees is not None) or (self.parts is not None) != (
                self.degrees is not None
            ):
                raise ValueError(
                    "a vision needs 'at_most_below' or 'at_most_above', or else 'parts' and 'degrees'"
                )
        return self


class MapFile(FileModel):
    """A map of the share of people who reach each of so many points of a part."""

    part: Name
    grip: Literal["push", "pinch", "grasp"] = "push"
    zone: Annotated[int, Field(ge=1, le=3)] = 1
    hand: Literal["left", "right", "either"] = "either"
    points: Annotated[int, Field(ge=MAP_POINTS[0], le=MAP_POINTS[1])] = 200


class ChangeFile(FileModel):
    """A change of the design whose gain is asked for: a control (with its part) or parts moved, or
    the ends of the seat's travel moved outward by so much."""

    name: Name
    control: str | None = None
    parts: Names | None = None
    move: Vector | None = None
    farther_back: Annotated[Length, Field(ge=0)] = 0.0
    farther_forward: Annotated[Length, Field(ge=0)] = 0.0
    lower: Annotated[Length, Field(ge=0)] = 0.0
    higher: Annotated[Length, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _one_thing(self) -> ChangeFile:
        moved = self.control is not None or self.parts is not None
        seat = any((self.farther_back, self.farther_forward, self.lower, self.higher))
        if moved == seat or (self.control is not None and self.parts is not None):
            raise ValueError(
                "a change moves one 'control', or 'parts', or the ends of the seat's travel"
            )
        if moved != (self.move is not None):
            raise ValueError("'move' says by how much a control or parts are moved")
        return self


class IntervalFile(FileModel):
    """How the intervals of shares are found: Wilson's score interval, or that of the bootstrap with
    its seed and number of draws."""

    method: Literal["wilson", "bootstrap"] = "wilson"
    seed: Annotated[int, Field(ge=0, le=2**63)] | None = None
    draws: Annotated[int, Field(ge=100, le=1_000_000)] = 10_000

    @model_validator(mode="after")
    def _has_its_seed(self) -> IntervalFile:
        if self.method == "bootstrap" and self.seed is None:
            raise ValueError("a bootstrap needs a 'seed'")
        if self.method == "wilson" and self.model_fields_set & {"seed", "draws"}:
            raise ValueError("'seed' and 'draws' belong to method: bootstrap")
        return self


class AccommodationFile(FileModel):
    """An accommodation study. mixes: the share of women, by name, that the people are weighted to;
    confidence and interval: of the shares, as in {method: bootstrap, seed: 1}."""

    study: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,79}$")]
    kind: Literal["accommodation"]
    title: str = ""
    description: str = ""
    length: LengthUnit
    environment: str
    seat: str
    body: str
    detail: Literal["coarse", "medium", "fine"] | None = None
    encumbrance: list[str] = []
    population: PopulationSourceFile
    posture: SittingFile = SittingFile()
    criteria: Annotated[list[DemandFile], Field(min_length=1)]
    mixes: dict[Name, Share] = {}
    confidence: Annotated[float, Field(gt=0, lt=1)] = 0.95
    interval: IntervalFile = IntervalFile()
    maps: list[MapFile] = []
    changes: list[ChangeFile] = []
