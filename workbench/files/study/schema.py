"""The shape of `studies/NAME.yaml`, and of the rule sets that injury criteria name."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)

from workbench.files.crash.simulation_schema import AirbagFile, BeltFile, ContactFile, PulseFile
from workbench.files.postures import AnglesFile, AtFile, StandFile
from workbench.files.schema import (
    LENGTH_SCHEMA,
    Degrees,
    FileModel,
    Length,
    LengthUnit,
    Vector,
    length_in_metres,
    plausible,
)
from workbench.files.study.sizes import ADULTS, CHILDREN
from workbench.model.accommodation import MAP_POINTS
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.population import Population
from workbench.model.units import limit_unit_of

__all__ = [
    "ACTIONS",
    "CHECK_KEYS",
    "ActionFile",
    "CaseFile",
    "ChangeFile",
    "CriterionFile",
    "DisplacedFile",
    "DriverFile",
    "EnvelopeFile",
    "MapFile",
    "MotionFile",
    "MovedFile",
    "PopulationFile",
    "PositionFile",
    "PredictedFile",
    "RoleFile",
    "RuleValueFile",
    "RulesFile",
    "SettingFile",
    "SharesFile",
    "SignalsFile",
    "SimulatedFile",
    "SizeFile",
    "StatedRestraintsFile",
    "StudyFile",
    "StudyPostureFile",
]

Name = Annotated[str, Field(min_length=1, max_length=200)]
Names = Annotated[list[Name], Field(min_length=1)]
Percent = Annotated[float, Field(ge=0, le=100)]
Seconds = Annotated[float, Field(ge=-1e6, le=1e6)]
Seed = Annotated[int, Field(ge=0, le=2**63)]
Zone = Annotated[int, Field(ge=1, le=3)]
Side = Literal["left", "right", "either"]
Sex = Literal["male", "female"]
Direction = Annotated[tuple[float, float, float], Field(strict=False)]


def _named(value: object) -> str:
    """Which member of a union of a name and a mapping a value is meant to be."""
    return "a name" if isinstance(value, str) else "a mapping"


def _or_noun(kind: type) -> WrapValidator:
    """Let a noun that was made in Python stand in the place of what a file says of it."""
    return WrapValidator(lambda value, check: value if isinstance(value, kind) else check(value))


_POSSIBLE = {
    "deg": (-180, 180, "degrees"),
    "percent": (0, 100, "percent"),
    "arcmin": (0, 600, "arc minutes"),
    "points": (1, 15, "points"),
    "N": (1, 10_000, "newtons"),
}
"""What limits are possible in units that are no lengths."""


def _limit(value: Any, info: ValidationInfo) -> Any:
    """A limit in the unit of its check: a length, or a number of degrees, percent, arc minutes."""
    column = limit_unit_of(info.data.get("check", "")).column
    if column not in _POSSIBLE:
        return plausible(length_in_metres(value, info))
    low, high, unit = _POSSIBLE[column]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"a number of {unit} is needed")
    if not low <= value <= high:
        raise ValueError(f"{low} to {high} {unit} are possible")
    return float(value)


LimitOfCheck = Annotated[float, BeforeValidator(_limit), WithJsonSchema(LENGTH_SCHEMA)]
Everybody = BeforeValidator(lambda value: None if value == "all" else value)
MOST_PEOPLE = 250_000
ACTIONS = ("posture", "predicted", "driver", "motion", "simulated")


class SizeFile(FileModel):
    """A person's size: some measures, the rest as people of the population with these have them.

    With an age [years] the population is one of growth charts; a child may do without measures.
    """

    sex: Sex
    age: Annotated[float, Field(gt=0, le=120)] | None = None
    population: str | None = None
    measures: dict[str, Annotated[Length, Field(gt=0)]] = {}
    mass_kg: Annotated[float, Field(gt=0, le=400)] | None = None

    @model_validator(mode="after")
    def _says_something(self) -> SizeFile:
        if self.age is None and not self.measures:
            raise ValueError("a size is one measure or more, or the age of a child")
        return self

    @property
    def source(self) -> str:
        """The population of the size: as named, else ANSUR II, of a child the growth charts."""
        return self.population or (ADULTS if self.age is None else CHILDREN)


class PopulationFile(FileModel):
    """Many people: those of a population file, or the rows of CSV files.

    source: a population, of whose measured people `people` are drawn with `seed`, `women` percent
    of them women; `people: all` are all of them. synthetic: people like those measured are drawn
    instead, as they are of a population without measured people.
    files: CSV files with one row a person, in the layout of the public ANSUR II files, lengths in
    `unit` and weightkg in 0.1 kg; weights: the column that says for how many people each row
    stands; people: only so many rows, spread evenly over the files. sexes: only these.
    """

    source: str | None = None
    people: Annotated[Annotated[int, Field(ge=1, le=MOST_PEOPLE)] | None, Everybody] = None
    seed: Seed | None = None
    women: Percent | None = None
    synthetic: bool = False
    files: Names | None = None
    unit: LengthUnit = "mm"
    weights: str | None = None
    sexes: Annotated[list[Sex], Field(min_length=1)] = ["male", "female"]

    @model_validator(mode="after")
    def _one_source(self) -> PopulationFile:
        if self.files is None:
            self._check_source()
        elif self.source is not None or self._of_draws:
            raise ValueError(
                "'files' have people of their own: 'source', 'seed', 'women' and 'synthetic' "
                "belong to people who are drawn"
            )
        if len(set(self.sexes)) < len(self.sexes):
            raise ValueError("a sex stands twice in 'sexes'")
        if self.women is not None and len(self.sexes) == 1:
            raise ValueError("'women' is a share of both sexes")
        return self

    @property
    def _of_draws(self) -> bool:
        """Whether something is said that only people who are drawn have."""
        return self.seed is not None or self.women is not None or self.synthetic

    def _check_source(self) -> None:
        """Refuse what the people of a population file cannot have."""
        if self.weights is not None or "unit" in self.model_fields_set:
            raise ValueError("'unit' and 'weights' belong to 'files'")
        if self.everybody and self._of_draws:
            raise ValueError(
                "'people: all' are the measured people as they are: 'seed', 'women' and "
                "'synthetic' belong to people who are drawn; mixes of the sexes are asked for "
                "under 'shares'"
            )
        if not self.everybody and (self.seed is None or self.people is None):
            raise ValueError(
                "people that are drawn need 'people', how many, and a 'seed'; 'people: all' are "
                "all who were measured"
            )

    @property
    def everybody(self) -> bool:
        """Whether all people are asked for in so many words."""
        return self.people is None and "people" in self.model_fields_set


class PositionFile(FileModel):
    """Where in its travel a seat stands, and how far it is tilted [degrees]."""

    forward: Length = 0.0
    up: Length = 0.0
    tilt: Annotated[float, Field(ge=-90, le=90)] = 0.0


class SettingFile(NamedTuple):
    """Where an adjustment is set, before it is known whether it slides or turns: as an angle [rad],
    NaN of a length with a unit, and as a length [m]."""

    angle: float
    length: float


def _setting(value: Any, info: ValidationInfo) -> SettingFile:
    """A setting: a number of the file's unit or of degrees, or a length with its unit."""
    length = plausible(length_in_metres(value, info))
    return SettingFile(math.nan if isinstance(value, str) else math.radians(value), length)


Setting = Annotated[
    tuple[float, float],
    PlainValidator(_setting),
    WithJsonSchema(
        {
            "anyOf": [{"type": "number"}, {"type": "string"}],
            "description": "where it is set: of a slide a length, of a turn degrees",
        }
    ),
]


Share = Annotated[str, Field(pattern=r"^(100|[0-9]{1,2})(\.[0-9]+)? ?%$")]


class RoleFile(FileModel):
    """Somebody who takes part in every case: a body, its size or sizes, and its place.

    At most one of `size`, `sizes` and `population`, at most one of `seat`, `at` and `stand`.
    without: segments of limbs that are missing. stops: by joint how far its motions turn, in degrees
    or as "50 %" of what the body's file says; "50 %" alone is for all motions of the joint.
    adjust: where adjustments of the environment are set, by their names.
    """

    body: Annotated[str, _or_noun(Body)]
    detail: Literal["coarse", "medium", "fine"] | None = None
    clothes: list[Name] = []
    without: list[Name] = []
    stops: dict[str, Share | dict[str, Annotated[float, Field(ge=0, le=180)] | Share]] = {}
    size: SizeFile | None = None
    sizes: Annotated[dict[Name, SizeFile], Field(min_length=1)] | None = None
    population: Annotated[PopulationFile, _or_noun(Population)] | None = None
    seat: Name | None = None
    at: AtFile | None = None
    stand: StandFile | None = None
    position: (
        Annotated[
            Annotated[Literal["free", "reference"], Tag("a name")]
            | Annotated[PositionFile, Tag("a mapping")],
            Discriminator(_named),
        ]
        | None
    ) = None
    adjust: dict[Name, Setting] = {}

    @model_validator(mode="after")
    def _one_of_each(self) -> RoleFile:
        for keys in (("size", "sizes", "population"), ("seat", "at", "stand")):
            given = [key for key in keys if getattr(self, key) is not None]
            if len(given) > 1:
                raise ValueError(
                    f"{given[0]!r} and {given[1]!r} exclude each other: give one of "
                    f"'{keys[0]}', '{keys[1]}' and '{keys[2]}'"
                )
        if self.position is not None and self.seat is None:
            raise ValueError("'position' is that of a seat: give 'seat' too")
        if self.adjust and self.seat is None:
            raise ValueError("'adjust' is done from a seat: give 'seat' too")
        return self


class StudyPostureFile(FileModel):
    """A posture of the study: a posture of the body with some angles replaced."""

    like: Name
    angles: AnglesFile = {}


class SidesFile(FileModel):
    """The controls that the left and the right hand or foot hold."""

    left: Name | None = None
    right: Name | None = None

    def held(self, kind: str) -> dict[str, str]:
        """By limb ("left hand", "right foot") of a kind the control that it is on, the left one first."""
        sides = {"left": self.left, "right": self.right}
        return {f"{side} {kind}": name for side, name in sides.items() if name is not None}


class DriversFeetFile(SidesFile):
    """The controls under a driver's feet, one at least: the one nearer to the heel point is the
    accelerator."""

    @model_validator(mode="after")
    def _one_foot(self) -> DriversFeetFile:
        if self.left is None and self.right is None:
            raise ValueError("a driver has a foot on the accelerator: give 'left' or 'right'")
        return self


class PredictedFile(FileModel):
    """A posture to be predicted: trunk and head as in the posture `like`, hands and feet on these
    controls, the eyes at the height of one point as far as the seat goes, the heels at that of
    another. Of somebody who stands: from the posture `like`, `standing` where none is given, with the
    hands on these controls and the feet flat; trunk, hips and knees bend as that needs."""

    like: Name = "driving"
    hands: SidesFile = SidesFile()
    feet: SidesFile = SidesFile()
    eyes: Name | None = None
    heels: Name | None = None


class DriverFile(FileModel):
    """A driver's posture by Park and others (2016): the mean of such people, or drawn with a seed.

    wheel: the point at the steering wheel's centre; h_point: where the hip point of the seat is
    (SgRP) with the seat in its reference position; heels: on the floor at the accelerator; sex: as
    the size says where not given.
    """

    wheel: Name
    h_point: Name
    heels: Name
    feet: DriversFeetFile
    hands: SidesFile = SidesFile()
    eyes: Name | None = None
    like: Name = "driving"
    sex: Sex | None = None
    age: Annotated[float, Field(ge=16, le=100)] = 40.0
    seed: Seed | None = None


class StatedRestraintsFile(FileModel):
    """What holds the occupant of a recorded motion: belts through `anchors` and airbags become
    parts; `pulse` is added to what is measured in the vehicle."""

    pulse: PulseFile | None = None
    anchors: dict[Name, Vector] = {}
    belts: list[BeltFile] = []
    airbags: list[AirbagFile] = []


class MotionFile(FileModel):
    """A recorded motion: a file beside the study, and how it is read.

    Frames from `start` to `end` [s], every n-th; `map`: bones by segment or usual marker names by
    the file's; `up`: its upward axis; `unit`: one unit of a BVH or marker file; `gaps` [s]: the longest that
    is bridged; `frames: as_read`: the header may state a wrong number of frames; `move` and `yaw`:
    where it is put; `scale: subject`: the body takes the lengths that the file shows; `restraints`:
    those of a simulation by name, or stated here.
    """

    file: Name
    start: Seconds | None = None
    end: Seconds | None = None
    every: Annotated[int, Field(ge=1)] = 1
    map: dict[str, str] = {}
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None
    unit: Length | None = None
    gaps: Annotated[float, Field(ge=0, le=10)] = 0.1
    frames: Literal["as_stated", "as_read"] = "as_stated"
    move: Vector = (0.0, 0.0, 0.0)
    yaw: Degrees = 0.0
    scale: Literal["body", "subject"] = "body"
    restraints: (
        Annotated[
            Annotated[Name, Tag("a name")] | Annotated[StatedRestraintsFile, Tag("a mapping")],
            Discriminator(_named),
        ]
        | None
    ) = None


class SimulatedFile(FileModel):
    """A motion to be simulated, from a posture, in the seat or place that the simulation names."""

    start: Name
    simulation: Name


class ActionFile(FileModel):
    """What a role does in a case: exactly one of five. hands: the controls that hands hold in a
    `posture`."""

    posture: Name | None = None
    angles: AnglesFile | None = None
    hands: SidesFile | None = None
    predicted: PredictedFile | None = None
    driver: DriverFile | None = None
    motion: MotionFile | None = None
    simulated: SimulatedFile | None = None

    @model_validator(mode="after")
    def _one_action(self) -> ActionFile:
        given = [key for key in ACTIONS if getattr(self, key) is not None]
        if len(given) != 1:
            said = f"{given[0]!r} and {given[1]!r} are given" if given else "none is given"
            raise ValueError(f"exactly one of {', '.join(ACTIONS)} is needed, {said}")
        if self.angles is not None and self.posture is None:
            raise ValueError(
                f"'angles' replace those of a 'posture'; {given[0]} takes a posture of the study "
                "by its name"
            )
        if self.hands is not None and self.posture is None:
            inside = f"write them into {given[0]!r}" if self.predicts else "a motion has none"
            raise ValueError(f"'hands' beside the action are those of a 'posture'; {inside}")
        return self

    @property
    def kind(self) -> str:
        """Which of ACTIONS it is."""
        return next(key for key in ACTIONS if getattr(self, key) is not None)

    @property
    def moves(self) -> bool:
        """Whether it is a motion."""
        return self.motion is not None or self.simulated is not None

    @property
    def predicts(self) -> bool:
        """Whether the posture is predicted, a driver's too."""
        return self.predicted is not None or self.driver is not None


class CaseFile(FileModel):
    """One case: what every role does."""

    name: Name
    people: Annotated[dict[Name, ActionFile], Field(min_length=1)]


CHECK_KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "contact": ((), ("segments", "subparts", "parts", "at_most")),
    "clearance": (("at_least",), ("segments", "subparts", "parts")),
    "self_contact": ((), ("segments", "at_most")),
    "between_people": ((), ("segments", "at_least")),
    "stops": ((), ("segments", "at_least")),
    "reach": ((), ("controls", "zone", "hand")),
    "pedals": ((), ("at_most",)),
    "preferred_seat": ((), ("at_least",)),
    "eye_height": ((), ("below", "above")),
    "view_over": (("parts", "down"), ()),
    "over_nose": (("down",), ("parts",)),
    "sees": (
        ("at_least",),
        ("parts", "controls", "instruments", "points", "size", "eyes", "trunk"),
    ),
    "outline": (("rules", "side", "at_least"), ("eye_point",)),
    "pillar": (("rules", "parts", "side", "r_point"), ("at_most",)),
    "forward_field": (("rules", "side", "r_point"), ("parts", "wheel", "inside_wheel", "at_most")),
    "mirror": (("rules", "mirrors", "parts", "ground", "at_least"), ("eye_point",)),
    "reflection": (("rules", "instruments", "parts", "side"), ("at_most", "eye_point")),
    "reads": (("instruments", "rules"), ("at_least", "visible", "eyes", "trunk")),
    "excursion": (("segments", "direction", "origin", "at_most"), ()),
    "injury": (("rules",), ()),
    "score": (("method", "at_most"), ("rules", "work")),
    "force": (("controls", "direction", "at_least", "capable"), ("ages", "lean")),
    "share": (("at_least",), ("of",)),
}
"""The keys of each check beside name, check, people and cases: needed ones, and possible ones."""
_THINGS = ("parts", "controls", "instruments", "points")
"""What may be asked to be seen."""
_OWN = tuple(dict.fromkeys(key for pair in CHECK_KEYS.values() for keys in pair for key in keys))


class WorkFile(FileModel):
    """What a posture alone cannot say of work, for its score; what is left out is assumed and told.

    load [kg] in the hands; repeated: more than 4 times a minute; static: held for more than a minute;
    rapid: large fast changes.
    """

    load: Annotated[float, Field(ge=0)] | None = None
    shock: bool | None = None
    repeated: bool | None = None
    static: bool | None = None
    rapid: bool | None = None
    coupling: Literal["good", "fair", "poor", "unacceptable"] | None = None
    arms_supported: bool | None = None
    trunk_supported: bool | None = None
    legs_balanced: bool | None = None
    stance: Literal["sitting", "standing", "one_leg", "kneeling", "walking"] | None = None


class CriterionFile(FileModel):
    """Something that must hold. What `people` and `cases` leave out means all that it can be asked
    of; limits are in the unit of the check: a length, degrees, percent."""

    name: Name
    check: Literal[
        "contact",
        "clearance",
        "self_contact",
        "between_people",
        "stops",
        "reach",
        "pedals",
        "preferred_seat",
        "eye_height",
        "view_over",
        "over_nose",
        "sees",
        "reads",
        "outline",
        "pillar",
        "forward_field",
        "mirror",
        "reflection",
        "excursion",
        "injury",
        "score",
        "force",
        "share",
    ]
    people: Names | None = None
    cases: Names | None = None
    segments: Names | None = None
    subparts: Names | None = None
    parts: Names | None = None
    controls: Names | None = None
    zone: Zone | None = None
    hand: Side | None = None
    at_least: LimitOfCheck | None = None
    at_most: LimitOfCheck | None = None
    below: Annotated[Length, Field(ge=0)] | None = None
    above: Annotated[Length, Field(ge=0)] | None = None
    down: Annotated[float, Field(ge=-89, le=89)] | None = None
    direction: Direction | None = None
    origin: Vector | None = None
    rules: Name | None = None
    instruments: Names | None = None
    points: Names | None = None
    size: Annotated[Length, Field(gt=0)] | None = None
    eyes: Literal["left", "right", "either", "both"] | None = None
    trunk: Annotated[float, Field(ge=0, le=60)] | None = None
    visible: Percent | None = None
    mirrors: Names | None = None
    side: Literal["left", "right"] | None = None
    eye_point: Name | None = None
    r_point: Name | None = None
    ground: Name | None = None
    wheel: Names | None = None
    inside_wheel: Names | None = None
    method: Literal["rula", "reba", "owas"] | None = None
    work: WorkFile | None = None
    capable: Annotated[float, Field(gt=0, lt=100)] | None = None
    ages: Literal["18-25", "55-65", "65+"] | None = None
    lean: Annotated[float, Field(ge=0, le=80)] | None = None
    of: Names | None = None

    @model_validator(mode="after")
    def _fits_the_check(self) -> CriterionFile:
        needed, possible = CHECK_KEYS[self.check]
        given = [key for key in _OWN if getattr(self, key) is not None]
        for key in given:
            if key not in (*needed, *possible):
                fit = ", ".join((*needed, *possible)) or "none of its own"
                raise ValueError(
                    f"{key!r} does not belong to check: {self.check}, whose keys are {fit}"
                )
        for key in needed:
            if key not in given:
                raise ValueError(f"check: {self.check} needs {key!r}")
        if self.segments is not None and self.subparts is not None:
            raise ValueError("'segments' and 'subparts' exclude each other: give one of the two")
        if self.check == "eye_height" and self.below is None and self.above is None:
            raise ValueError("check: eye_height needs 'below' or 'above'")
        things = [name for name in _THINGS if getattr(self, name) is not None]
        if self.check == "sees" and len(things) != 1:
            said = " and ".join(things) or "none"
            raise ValueError(f"check: sees needs exactly one of {', '.join(_THINGS)}, got {said}")
        if self.size is not None and self.points is None:
            raise ValueError("'size' is the diameter of what is at 'points'")
        if self.check == "over_nose" and (self.down or 0.0) < 0:
            raise ValueError("'down' of check: over_nose is 0 to 89 degrees")
        if self.check == "share" and (self.people is not None or self.cases is not None):
            raise ValueError("a share is of the whole population: leave out 'people' and 'cases'")
        if self.check in ("contact", "self_contact", "pedals") and (self.at_most or 0.0) < 0:
            raise ValueError(f"'at_most' of check: {self.check} is 0 or more")
        if self.direction is not None and not any(self.direction):
            raise ValueError("'direction' must not be zero")
        return self


class IntervalFile(FileModel):
    """How the intervals of shares are found: Wilson's score interval, or that of the bootstrap."""

    method: Literal["wilson", "bootstrap"] = "wilson"
    seed: Seed | None = None
    draws: Annotated[int, Field(ge=100, le=1_000_000)] = 10_000

    @model_validator(mode="after")
    def _has_its_seed(self) -> IntervalFile:
        if self.method == "bootstrap" and self.seed is None:
            raise ValueError("a bootstrap needs a 'seed'")
        if self.method == "wilson" and self.model_fields_set & {"seed", "draws"}:
            raise ValueError("'seed' and 'draws' belong to method: bootstrap")
        return self


class SharesFile(FileModel):
    """How shares are reported: mixes (percent of women, by name) that the people are weighted to,
    and the confidence [percent] of intervals."""

    mixes: dict[Name, Percent] = {}
    confidence: Annotated[float, Field(gt=0, lt=100)] = 95.0
    interval: IntervalFile = IntervalFile()


class MapFile(FileModel):
    """A map of the share of people who reach each of so many points of a part; with `sees` of those
    who see it, who need no grip, zone or hand for that."""

    people: Name
    part: Name
    case: Name | None = None
    sees: bool = False
    grip: Literal["push", "pinch", "grasp"] = "push"
    zone: Zone = 1
    hand: Side = "either"
    points: Annotated[int, Field(ge=MAP_POINTS[0], le=MAP_POINTS[1])] = 200

    @model_validator(mode="after")
    def _hands_are_of_reach(self) -> MapFile:
        given = sorted(self.model_fields_set & {"grip", "zone", "hand"}) if self.sees else ()
        if given:
            raise ValueError(f"a map of who sees a part is of eyes: leave out {', '.join(given)}")
        return self


class EnvelopeFile(FileModel):
    """A reach envelope about the seat reference point."""

    people: Name
    case: Name | None = None
    hand: Literal["left", "right"] = "right"
    grip: Literal["push", "pinch", "grasp"] = "grasp"
    zone: Zone = 1
    obstacles: bool = False


class DisplacedFile(FileModel):
    """What of the environment stands elsewhere: controls, and parts with the controls on them.

    A control takes the part along that it is on, unless another control is on it that stays; with
    `alone` none does.
    """

    control: Name | None = None
    controls: Names | None = None
    parts: Names | None = None
    alone: bool = False

    @property
    def names_something(self) -> bool:
        """Whether anything is named that is moved."""
        return self.control is not None or self.controls is not None or self.parts is not None

    @model_validator(mode="after")
    def _alone_is_of_controls(self) -> DisplacedFile:
        if self.alone and self.control is None and self.controls is None:
            raise ValueError("'alone' says that controls leave their parts: give 'controls' too")
        return self


class MovedFile(DisplacedFile):
    """Controls and parts of the environment that are moved, and by how much from where the
    environment has them."""

    by: Vector

    @model_validator(mode="after")
    def _names_what(self) -> MovedFile:
        if not self.names_something:
            raise ValueError("'control', 'controls' or 'parts' says what is moved: give one")
        return self


class ChangeFile(DisplacedFile):
    """A change of the design whose gain is asked for: controls and parts moved, the ends of a seat's
    travel moved outward, or both at once. moved: more of them, each by its own way."""

    name: Name
    move: Vector | None = None
    moved: Annotated[list[MovedFile], Field(min_length=1)] | None = None
    seat: Name | None = None
    farther_back: Annotated[Length, Field(ge=0)] = 0.0
    farther_forward: Annotated[Length, Field(ge=0)] = 0.0
    lower: Annotated[Length, Field(ge=0)] = 0.0
    higher: Annotated[Length, Field(ge=0)] = 0.0

    @model_validator(mode="after")
    def _changes_something(self) -> ChangeFile:
        if not self.names_something and self.moved is None and self.seat is None:
            raise ValueError(
                "a change is of 'control', 'controls' or 'parts' with 'move', of several such in "
                "'moved', or of a 'seat'; give one at least"
            )
        ends = any((self.farther_back, self.farther_forward, self.lower, self.higher))
        if (self.seat is not None) != ends:
            raise ValueError(
                "'farther_back', 'farther_forward', 'lower' and 'higher' say how far the travel of "
                "a 'seat' goes on: give one of them with it, and only with it"
            )
        if self.names_something != (self.move is not None):
            raise ValueError("'move' says by how much controls or parts are moved: give both")
        return self


FilterClass = Literal[60, 180, 600, 1000, "j211"]


class SignalPointFile(FileModel):
    """A point whose signals are wanted; the segment's centre of gravity where `at` is not given, the
    filter class of all points where it has none of its own."""

    name: Name
    segment: Name
    at: Vector = (0.0, 0.0, 0.0)
    filter_class: FilterClass | None = None


class SignalsFile(FileModel):
    """The signals of motions: whose points, and the class of the filter; `j211`: for each segment
    the class that SAE J211-1 has for it, as far as the samples carry it."""

    points: list[SignalPointFile] = []
    filter_class: FilterClass | None = None


class StudyFile(FileModel):
    """A study: where, who, what each does, and what must hold."""

    study: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,79}$")]
    title: str = ""
    description: str = ""
    length: LengthUnit
    environment: Annotated[Name, _or_noun(Environment)]
    people: Annotated[dict[Name, RoleFile], Field(min_length=1)]
    moved: list[MovedFile] = []
    postures: dict[Name, StudyPostureFile] = {}
    cases: Annotated[list[CaseFile], Field(min_length=1)]
    criteria: Annotated[list[CriterionFile], Field(min_length=1)]
    shares: SharesFile | None = None
    reach_maps: list[MapFile] = []
    reach_envelopes: list[EnvelopeFile] = []
    changes: list[ChangeFile] = []
    compare: Annotated[list[Name], Field(min_length=2, max_length=2)] | None = None
    signals: SignalsFile | None = None
    contact_forces: list[ContactFile] = []


class LimitFile(FileModel):
    """A limit on a signal. figure: hic (limit without a unit; `window` in seconds, the whole pulse
    where not given) or held (limit in g; `hold` in seconds); segment: whose point it is about."""

    figure: Literal["hic", "held"]
    segment: str
    limit: Annotated[float, Field(gt=0)]
    window: Annotated[float, Field(gt=0)] | None = None
    hold: Annotated[float, Field(gt=0)] | None = None
    source: Annotated[str, Field(min_length=1)]


Rows = list[float] | list[list[float]]


class RuleValueFile(FileModel):
    """A value of a rule: a number, a list of numbers or of points in `axes`, and its `unit`.

    status: seen where it was read in the `source`, remembered where that was not at hand, chosen
    where the rule leaves it open. origin: of a field on the ground, from what it counts behind, and
    from what out. doubt: what was settled without the source, told with each figure. words: what it is
    called there, its key where it has none."""

    value: float | Rows
    unit: Literal[
        "mm",
        "m",
        "m2",
        "deg",
        "arcmin",
        "in",
        "lb",
        "kg",
        "kgf",
        "N",
        "h",
        "per min",
        "per cm",
        "per in",
        "per deg",
        "1",
    ]
    axes: Literal["forward left up", "rearward right up"] | None = None
    origin: tuple[Literal["eyes", "front"], Literal["side", "middle", "eyes"]] | None = Field(
        None, strict=False
    )
    status: Literal["seen", "remembered", "chosen"]
    source: Annotated[str, Field(min_length=1)]
    doubt: str = ""
    words: str = ""


class RulesFile(FileModel):
    """A rule set: limits on signals, or values of a rule of sight or strain, with their sources.
    credit: the words that the licence of the values asks for."""

    rules: Name
    description: str = ""
    credit: str = ""
    limits: list[LimitFile] = []
    values: dict[Name, RuleValueFile] = {}

    @model_validator(mode="after")
    def _holds_something(self) -> RulesFile:
        if not (self.limits or self.values):
            raise ValueError("'limits' or 'values' are needed")
        return self
