"""Criterion: something that must hold, what is measured of it, and what limits somebody in it.

A reason is a noun, so that nothing has to be read out of its words. Names come from files and may
hold anything, commas and the word "at" included. They stand in fields of their own, and words are
made of these in one place. `Work` is what the posture of a person alone cannot say of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from math import inf, nan
from typing import Any, Literal

from workbench.errors import InputError
from workbench.model.arguments import check_fields, short_repr
from workbench.model.rule_set import RuleSet
from workbench.model.units import plain, tenths

__all__ = [
    "NO_REASON",
    "TOO_SHORT",
    "Criterion",
    "Finding",
    "Kind",
    "Limit",
    "Reason",
    "Work",
    "hider",
    "short_words",
]


@dataclass(frozen=True)
class Work:
    """What a posture alone cannot say. What is None is assumed, and each score says so.

    Parameters
    ----------
    load
        [kg] in the hands, or the force as the mass of that weight.
    shock, repeated, static, rapid
        Whether the load comes with a shock, the posture repeats more than 4 times a minute, is held
        for longer than 1 minute, or changes fast and far.
    coupling
        How well the hands hold it.
    arms_supported, trunk_supported, legs_balanced
        Whether the arms rest on something, a seat back carries the trunk, and both legs are
        supported alike.
    stance
        What the person stands or sits on; "one_leg" is straight or bent as the posture is.
    """

    load: float | None = None
    shock: bool | None = None
    repeated: bool | None = None
    static: bool | None = None
    rapid: bool | None = None
    coupling: Literal["good", "fair", "poor", "unacceptable"] | None = None
    arms_supported: bool | None = None
    trunk_supported: bool | None = None
    legs_balanced: bool | None = None
    stance: Literal["sitting", "standing", "one_leg", "kneeling", "walking"] | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if self.load is not None and self.load < 0.0:
            raise InputError(f"work.load: expected 0 kg or more, got {self.load:g}")

    def assumed(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Say which of some values are not stated, and what is taken for each."""
        return tuple(
            f"{plain(name)}: {_ASSUMED[name][1]} (assumed)"
            for name in names
            if getattr(self, name) is None
        )

    def stated(self) -> Work:
        """The same with the assumed values filled in."""
        lacking: dict[str, Any] = {
            field.name: _ASSUMED[field.name][0]
            for field in fields(self)
            if getattr(self, field.name) is None
        }
        return replace(self, **lacking)


_ASSUMED: dict[str, tuple[float | bool | str, str]] = {
    "load": (0.0, "nothing in the hands"),
    "shock": (False, "no shock"),
    "repeated": (False, "at most 4 times a minute"),
    "static": (False, "held for at most 1 minute"),
    "rapid": (False, "no large fast changes"),
    "coupling": ("good", "good"),
    "arms_supported": (False, "no"),
    "trunk_supported": (False, "no"),
    "legs_balanced": (True, "yes"),
    "stance": ("standing", "standing"),
}
"""What is taken where nothing is stated, and its words."""


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
    may be any. at_most [m]: of contact, self_contact, pedals and excursion. down [rad]: of view_over and over_nose. direction:
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


Kind = Literal[
    "",  # nothing limits
    "words",  # something of the seat, the eyes or the stance that has no name in a file
    "limb",  # the limb is too short
    "stop",  # the stop of a joint
    "segment",  # a segment of the body
    "near",  # a segment that is too near to a part or to another segment
    "part",  # a part is in the way
    "deep",  # a limb is where it should be, and its arm or leg too deep in something
    "own",  # the own body is
    "other",  # somebody else's is
    "beyond",  # eyes and head do not turn so far
    "outside",  # it is beside a mirror
    "reading",  # a limit of reading
    "cuts",  # the two cuts of a pillar
    "mirrored",  # panes mirror it
]


_LEADS = {
    "cuts": "its upper and its lower cut alone hide ",
    "mirrored": "mirrored by ",
}
"""How the words of some kinds begin."""


@dataclass(frozen=True)
class Reason:
    """What limits somebody in a requirement.

    kind: in which way. thing: the joint, part or segment by its name, else fixed words; of the cuts
    of a pillar their angles. at: of a segment that is too near, what it is too near to; of a limb that
    is too deep, what it is: "arm", "leg". foot: the
    foot that is limited, "" of none. share: of what is to be seen that the thing hides, 0 to 1; 0
    where it is not known or not told.
    """

    kind: Kind = ""
    thing: str = ""
    at: str = ""
    foot: str = ""
    share: float = 0.0

    def __bool__(self) -> bool:
        return self.kind != ""

    @property
    def part(self) -> str:
        """The part that is in the way, "" of every other kind."""
        return self.thing if self.kind in ("part", "deep") else ""

    @property
    def text(self) -> str:
        """In words, with names as in their files: "right knee at console", "left foot, the seat stops
        too far back", "left_stick hides 30 %"."""
        near = f" at {self.at}" if self.at and self.kind != "deep" else ""
        text = _LEADS.get(self.kind, "") + self.thing + near
        if self.share:
            share = f"{100 * self.share:.3g} %"
            text = f"{share} is {text}" if self.kind == "outside" else f"{text} hides {share}"
        return f"{self.foot}, {text}" if self.foot else text

    @property
    def why(self) -> str:
        """As a clause of its own: "canopy is in the way", "limited by right elbow (flexion)",
        "left_stick hides 30 %"; "" where nothing limits."""
        if not self or self.share or self.kind in ("cuts", "mirrored"):
            return self.text
        if self.kind in ("part", "own", "other") and not self.foot:
            return f"{'the ' if self.kind == 'own' else ''}{self.text} is in the way"
        if self.kind == "deep" and not self.foot:
            return f"on it the {self.at} is that much too deep in {self.text}"
        return f"{'it is' if self.kind == 'beyond' else 'limited by'} {self.text}"

    @property
    def clause(self) -> str:
        """The same at the end of a sentence: ", limited by right elbow (flexion)", "; canopy is in the
        way"."""
        why = self.why
        return f"{',' if why.startswith('limited by ') else ';'} {why}" if why else ""


def short_words(limb: str, control: str, miss: float, overlap: float, limit: Reason) -> str:
    """How far a limb stays from a control that it does not reach, and what keeps or limits it: "the
    right hand stays 8.7 mm short of flaps; canopy is in the way".

    miss, overlap: [m] how far it stays away, and how much deeper than allowed it is in something even
    there.
    """
    if limit.kind == "words":  # the thighs are too deep in the cushion
        miss, overlap = miss + overlap, 0.0
    if overlap > 0.0 and miss < SEEN:
        within = limit.text or "an obstacle"
        return f"the {limb} gets to {control} only {tenths(1e3 * overlap)} mm too deep in {within}"
    deep = (
        f", which it is {tenths(1e3 * overlap)} mm too deep in even there" if overlap > 0.0 else ""
    )
    return f"the {limb} stays {tenths(1e3 * miss)} mm short of {control}{limit.clause}{deep}"


SEEN = 5e-5
"""[m] What is smaller reads as 0.0 mm."""
NO_REASON = Reason()
TOO_SHORT = Reason("limb", "length of the limb")


def hider(name: str, parts: tuple[str, ...], share: float = 0.0) -> Reason:
    """What stands before something: a part, else "own ..." of the body that looks or somebody else's;
    share: that it hides, kept to a thousandth."""
    kind: Kind = "own" if name.startswith("own ") else "other"
    return (
        Reason("part" if name in parts else kind, name, share=round(share, 3))
        if name
        else NO_REASON
    )
