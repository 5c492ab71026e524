"""The part of result.json about a population."""

from __future__ import annotations

from workbench.files.results.postures import PostureRow, Row

__all__ = [
    "GainRow",
    "GroupRow",
    "HardRow",
    "MapRow",
    "OverlapRow",
    "PeopleRow",
    "PopulationRows",
    "RequirementRow",
]


class GroupRow(Row):
    """The share, 0 to 1, of a group that is served, and its interval; count: people in it.

    certain: the share that is served wherever the true surface of the body lies within its fit
    error; possible: that is served if it lies where it suits; null where the body states no fit
    error. clear: the share that is served and overlaps nothing by more than is allowed, whether a
    criterion asks about it or not; null in results from before that was counted.
    """

    group: str
    share: float
    low: float
    high: float
    count: int
    certain: float | None
    possible: float | None
    clear: float | None = None


class RequirementRow(Row):
    """One requirement: share: of those who meet it where their margins are taken; only: who miss it
    there and nothing else; without: who would be served, wherever, if it were dropped; spread_mm: margins at 1, 5, 50, 95 and 99 % of
    the people, null where it applies to nobody; unit: in which people read the margins, and unit_mm:
    the millimetres that one of it counts, as in all margins here: an angle or a share is compared with
    lengths; certain, possible: as of `GroupRow`, of those who
    meet it."""

    name: str
    criterion: str
    check: str
    target: str
    zone: int
    share: float
    only: float
    without: float
    certain: float | None
    possible: float | None
    spread_mm: list[float | None]
    unit: str = "mm"
    unit_mm: float = 1.0


class PeopleRow(Row):
    """Everybody, one entry a person in every list, and one a requirement in every list of margins
    and reasons.

    margin_mm: null where it does not apply, negative where it is not met, see `RequirementRow`; reason: index into
    `reasons`, -1 where nothing limits; seat_mm: forward and up in the position that the margins are
    of; comfortable_mm: in the comfortable one; window_mm: least and greatest forward, least and
    greatest up of the positions tried that fit, null where the comfortable one fits or none does;
    settings: by adjustment, with its unit in the name, where it is set; stature_mm: null where it is not
    known; limiting: the measure that leaves the person out, "" for whom all is met.

    certain: whether `served` holds wherever the true surface of the body lies within its fit error,
    in the position of the margins or another one, null where that is not known. clear: whether the
    person is served and overlaps nothing by more than is allowed; none in results from before that
    was counted. margin_from_mm, margin_to_mm: between which the margin truly lies,
    null where it does not depend on the surface or is not known.
    """

    label: list[str]
    sex: list[str]
    weight: list[float]
    stature_mm: list[float] | None
    served: list[bool]
    certain: list[bool | None]
    clear: list[bool] = []
    limiting: list[str]
    seat_mm: list[tuple[float, float]]
    comfortable_mm: list[tuple[float, float]]
    window_mm: list[tuple[float, float, float, float] | None]
    settings: dict[str, list[float]]
    margin_mm: list[list[float | None]]
    margin_from_mm: list[list[float | None]]
    margin_to_mm: list[list[float | None]]
    reason: list[list[int]]


class HardRow(Row):
    """One of the people hardest to serve, at the requirement that is missed by most; the first at the
    one that most people miss.

    row: of everybody, counted from 0; posture: as the picture shows the person, in the attempt
    where it is a reach, in the position of the seat and the setting that stand in that row; null
    where nobody is shown. -1 and null in results from before they were kept.
    """

    person: str
    sex: str
    requirement: str
    margin_mm: float
    reason: str
    limiting: str
    row: int = -1
    posture: PostureRow | None = None


class GainRow(Row):
    """What a change of the design gains, shares 0 to 1; rate_per_mm: the share of this requirement
    by a millimetre; margin_rate: millimetres of margin by a millimetre, mean of those who do not
    meet it, null where not known."""

    words: str
    requirement: str
    move_mm: float
    rate_per_mm: float
    margin_rate: float | None
    before: float
    after: float
    joint_before: float
    joint_after: float


class MapRow(Row):
    """A population map: for each point its place and the share of people who reach it, or who see it
    with either eye (`sees`; grip, zone and hand mean nothing then)."""

    part: str
    grip: str
    zone: int
    hand: str
    sees: bool
    points_mm: list[tuple[float, float, float]]
    flat_mm: list[tuple[float, float]]
    share: list[float]


class OverlapRow(Row):
    """Two things that overlap in some people more than is allowed, about which no criterion asks.

    segment: of the body, in words; part: that it is in, else other_segment of the same body, "" for
    the other one; people, share: how many, and their weighted share; deepest_mm: beyond what is
    allowed, of the person (counted from 0) of whom it is the most.
    """

    segment: str
    part: str
    other_segment: str
    people: int
    share: float
    deepest_mm: float
    person: int


class PopulationRows(Row):
    """A population in a role: shares, requirements, who is hardest to serve, and everybody.

    overlaps: none in results from before they were looked for.
    design: what the environment, the criteria and the bodies are, in words by name; none in results
    from before it was written.
    people_hash: SHA-256 of who the people are; seed: of those who are drawn, null of others.
    """

    role: str
    seat: str | None
    body: str
    population: str
    people_hash: str
    seed: int | None
    confidence: float
    shares: list[GroupRow]
    requirements: list[RequirementRow]
    hardest: list[HardRow]
    gains: list[GainRow]
    maps: list[MapRow]
    overlaps: list[OverlapRow] = []
    design: dict[str, str] = {}
    reasons: list[str]
    people: PeopleRow
