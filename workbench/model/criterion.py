"""Criterion: something that must hold, and what is measured of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, nan

from workbench.model.arguments import short_repr
from workbench.model.rule_set import RuleSet
from workbench.model.work import Work

__all__ = ["Criterion", "Finding", "Limit"]


@dataclass(frozen=True)
class Limit:
    """A limit of a rule set. figure: hic, held or chest-like level; window or hold [s]; value in
    the figure's unit."""

    figure: str
    segment: str
    span: float
    value: float
    source: str


@dataclass(frozen=True)
class Criterion:
    """Something that must hold, in some cases, for some roles.

    check: contact, clearance, self_contact, between_people, stops, reach, pedals, preferred_seat,
    eye_height, view_over, over_nose, sees, reads, excursion, injury, score, force or share; "seated" is one that no study asks. people,
    segments, parts, controls: the names that it is about. at_least: [m] of clearance,
    between_people and preferred_seat, [rad] of stops, 0 to 1 of share. zone: the harness zone in
    which controls are to be reached, each control's own where None. hand: that must reach ("left",
    "right"), either where None. subparts: named spheres ("RLL/knee cap") instead of whole segments.
    below, above: how far [m] the eyes may be below and above their point, infinite where either
    may be any. at_most [m]: of contact, pedals and excursion. down [rad]: of view_over and over_nose. direction:
    (3,) unit vector along which an excursion is measured from origin (3,) [m]. limits: of the rule
    set `rules` of an injury criterion. of: the names of the criteria that a share must meet. cases:
    the names of the cases it is asked of, () for all.

    Of what is seen: instruments, points, beside parts and controls the things that it is about; size:
    the diameter [m] of what is at the points, 0 of mere points; eyes: by which they are seen, "left",
    "right", "either" or "both"; trunk: how far [rad] it may turn for that; visible: the share of instruments that are read that is seen, at
    least, 0 to 1; rule_set: how they are read, with `at_least` [rad] as the size of characters where
    that is not 0.

    Of rules of sight besides: mirrors; parts: of an outline none, the pillar, what the forward field
    exempts, the sides of the vehicle of mirrors, what mirrors instruments; side: of the driver or of
    the seat, "left" or "right"; points of the environment: eye_point to look from instead of the
    eyes, r_point of the seat, ground at its height; wheel: its parts, and inside_wheel
    what is seen inside its rim, exempt of a forward field where the wheel is low enough.

    Of scores of postures: method "rula", "reba" or "owas" by `rule_set`; at_most: points; work: what
    a posture cannot say.

    Of forces: at_least [N] along `direction`, exerted on `controls` by `capable` (0 to 1) of such
    people; of a foot by people of `ages`, whose push may `lean` [rad] from it.
    """

    name: str
    check: str
    people: tuple[str, ...]
    segments: tuple[str, ...]
    parts: tuple[str, ...]
    at_least: float
    controls: tuple[str, ...] = ()
    zone: int | None = None
    hand: str | None = None
    subparts: tuple[str, ...] = ()
    below: float = inf
    above: float = inf
    at_most: float = 0.0
    down: float = 0.0
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rules: str = ""
    limits: tuple[Limit, ...] = ()
    instruments: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    size: float = 0.0
    eyes: str = "either"
    trunk: float = 0.0
    visible: float = 0.0
    rule_set: RuleSet | None = None
    mirrors: tuple[str, ...] = ()
    side: str = ""
    eye_point: str = ""
    r_point: str = ""
    ground: str = ""
    wheel: tuple[str, ...] = ()
    inside_wheel: tuple[str, ...] = ()
    method: str = ""
    work: Work = field(default_factory=Work)
    capable: float = 0.0
    ages: str = ""
    lean: float = 0.0
    of: tuple[str, ...] = ()
    cases: tuple[str, ...] = ()

    __repr__ = short_repr

    def asks(self, case: str) -> bool:
        """Whether it is asked of a case, by its name."""
        return not self.cases or case in self.cases


@dataclass(frozen=True)
class Finding:
    """One measured value of a criterion.

    Parameters
    ----------
    case
        The name of the case.
    person, other_person
        Names of the roles, "" where there is none.
    subject, target
        Both sides in words.
    value, limit
        In `unit`. The value must not be below the limit: of what must not exceed something, both
        are negative.
    point
        (3,) [m] in the world, None where there is none.
    surface_known_to
        How far [m] the true surface may lie outside the spheres where the value is within its
        limit, inside them where it is beyond; of two bodies both together; NaN where not known.
    unit
        "m", "rad", "g", "share" (0 to 1), "points", or "" of a number without a unit.
    time
        When [s], NaN of a posture.
    source
        The rule set that a figure is made with, and which of its values are not sure; "" of others.
    about
        The control or point of the environment that the target is, "" of others.
    sphere, polygon, other_sphere
        The sphere of the body that is nearest or farthest, and what is nearest to it: the polygon
        of the part (by its number in the part), or the sphere of the other limb; -1 where there is
        none.
    """

    case: str
    person: str
    other_person: str
    subject: str
    target: str
    value: float
    limit: float
    point: tuple[float, float, float] | None = None
    surface_known_to: float = nan
    unit: str = "m"
    time: float = nan
    sphere: int = -1
    polygon: int = -1
    other_sphere: int = -1
    source: str = ""
    about: str = ""

    __repr__ = short_repr

    @property
    def margin(self) -> float:
        """What is to spare, negative where the criterion is not met."""
        return self.value - self.limit

    @property
    def doubt(self) -> float:
        """How far the body's surface, where it truly is, may lie beyond the limit [m]; negative
        where it cannot, NaN where it is not known."""
        return self.surface_known_to - abs(self.margin)
