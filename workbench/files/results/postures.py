"""The part of result.json about people in postures."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = [
    "ContactRow",
    "EnvelopeRayRow",
    "EnvelopeRow",
    "PersonRow",
    "PostureRow",
    "PosturesRows",
    "ReachRow",
    "Row",
    "StopRow",
]


class Row(BaseModel):
    """A row that has the keys of its class and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class ContactRow(Row):
    """One contact: the deepest of a case, a segment and a part (or other segment)."""

    case: str
    person: str
    other_person: str | None
    kind: str
    segment: str
    sphere: int
    subpart: str | None
    direction: str
    part: str | None
    polygon: int | None
    other_segment: str | None
    other_sphere: int | None
    distance_mm: float
    allowed_mm: float
    excess_mm: float
    point_mm: tuple[float, float, float]
    normal: tuple[float, float, float]
    sentence: str


class StopRow(Row):
    """Margin of one joint in one case; null where the joint is free."""

    case: str
    joint: str
    margin_deg: float | None
    motion: str | None


class PostureRow(Row):
    """How a person is in one case, as checked.

    name: of the posture, "predicted" or "driver". angles_deg: by joint and motion, as a file of
    postures has them; what is not named is 0. Placed by the segment `reference`: the position of its
    origin in the world, and its rotation as a quaternion w, x, y, z.
    """

    case: str
    name: str
    angles_deg: dict[str, dict[str, float]]
    reference: str
    position_mm: tuple[float, float, float]
    rotation: tuple[float, float, float, float]


class PersonRow(Row):
    """One person: body, size (measures in mm, mass in kg), place, postures by case.

    seat_mm: the position of the seat, forward and up; null without one. clearance_mm[case][segment]
    [part]: null where nothing is there.
    """

    name: str
    description: str
    body: str
    seat: str | None
    seat_mm: tuple[float, float] | None
    size: dict[str, float] | None
    postures: list[PostureRow]
    segments: list[str]
    clearance_mm: list[list[list[float | None]]]
    stops: list[StopRow]


class ReachRow(Row):
    """How one person reaches one control in one harness zone; miss_mm is 0 where it is reached.

    spare_mm: how much farther out from the shoulder or hip the limb would get, 200 at most and
    obstacles aside; null where it is missed or no criterion asks for it in this zone.
    doubt: how it ended where the posture without obstacles enters something, or is short by little:
    "clear after a few steps", "clear in another posture", "kept", or "kept for certain" where it is
    proved; "not in doubt" else.
    """

    person: str
    control: str
    zone: int
    own_zone: int
    limb: str
    reached: bool
    miss_mm: float
    overlap_mm: float
    limit: str
    spare_mm: float | None = None
    discomfort: float
    doubt: str
    sentence: str


class EnvelopeRayRow(Row):
    """One ray of an envelope: its azimuth, and its elevation about the seat reference point or its
    height above it.

    outer, inner: its outermost and innermost reached point, null where none is; clear_*: the same
    clear of obstacles; easy_*, moderate_*: within these grades of discomfort. lost: stretches that
    obstacles take, from and to, and the obstacle.
    """

    azimuth_deg: float
    elevation_deg: float
    height_mm: float
    outer_mm: float | None
    inner_mm: float | None
    clear_outer_mm: float | None
    clear_inner_mm: float | None
    easy_outer_mm: float | None
    easy_inner_mm: float | None
    moderate_outer_mm: float | None
    moderate_inner_mm: float | None
    lost: list[tuple[float, float, str]]


class EnvelopeRow(Row):
    """One reach envelope: rays about the seat reference point, and level rays about the upright
    axis through it.

    lost_litres_to: what each obstacle takes, by the part that the limb would enter deepest, the
    most first.
    """

    person: str
    limb: str
    zone: int
    people: int
    origin_mm: tuple[float, float, float]
    volume_litres: float
    obstacles: bool
    lost_litres: float
    lost_litres_to: dict[str, float]
    rays: list[EnvelopeRayRow]
    levels: list[EnvelopeRayRow]


class PosturesRows(Row):
    """People in postures: who they are, their contacts, reaches and envelopes.

    parts: the columns of the persons' clearances; row: the size of the person where several sizes
    take a role one at a time, else null. settings: by adjustment, with its unit in the name, where
    it is set.
    """

    row: str | None
    cases: list[str]
    parts: list[str]
    people: list[PersonRow]
    contacts: list[ContactRow]
    reaches: list[ReachRow] = []
    envelopes: list[EnvelopeRow] = []
    settings: dict[str, float] = {}
