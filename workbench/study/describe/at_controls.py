"""Guess what the occupant of a seat does with hands and feet, and where eyes and heels belong.

A control belongs to the seat that is nearest to its place. Whoever operates may also use those that
lie between the seats. Each guess says by what it was made.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.files.names import is_for_eyes, is_for_heels, words_of
from workbench.model.arrays import Floats
from workbench.model.environment import Control, Environment, Seat

__all__ = [
    "SeatFrame",
    "Sitter",
    "Use",
    "left_out",
    "sitters_of",
    "use_of",
]

WORK = (0.45, 0.30)
"""How far [m] ahead of and above the seat reference point hands are at work, about."""
ARM = 0.85
"""A control farther [m] than this from where hands are at work is none to rest a hand on."""
APART = 0.25
"""Seats nearer [m] than this to each other are taken one at a time."""
MOST_SEATS = 4
"""More people than this are not put in at once."""
BETWEEN = 0.65
"""A control no farther than this share of the way to another seat is between the two."""
EYE_NEAR = 0.35
"""An eye point farther [m] from where the eyes of a seat's occupant are belongs to somebody else."""
ASIDE = 0.3
"""Points farther aside [m] from the middle of a seat belong to somebody else."""
HEELS_AHEAD = (0.2, 1.5)
"""Between these distances [m] ahead of the seat reference point heels stand."""
TO_SIDE = 0.02
"""A control nearer [m] to the middle of a seat is to neither side."""
STEERS = ("wheel", "stick")


class SeatFrame:
    """Places as the occupant of a seat sees them: ahead, to the left, above its reference point."""

    def __init__(self, seat: Seat) -> None:
        self.seat = seat
        self.srp = np.array(seat.srp)
        self.ahead = np.array([math.cos(seat.yaw), math.sin(seat.yaw), 0.0])
        self.left = np.array([-math.sin(seat.yaw), math.cos(seat.yaw), 0.0])

    def seen(self, at: Sequence[float]) -> Floats:
        """(3,) [m] how far a place is ahead, to the left and above."""
        way = np.array(at) - self.srp
        return np.array([way @ self.ahead, way @ self.left, way[2]])

    def world(self, ahead: float, left: float, above: float) -> Floats:
        """(3,) [m] a place in the world."""
        found: Floats = self.srp + ahead * self.ahead + left * self.left
        found[2] += above
        return found


@dataclass(frozen=True, eq=False)
class Sitter:
    """What the occupant of a seat is guessed to do.

    Parameters
    ----------
    frame
        The seat.
    hands, feet
        Control by side, "left" and "right".
    eyes, heels
        Points of the environment, "" where none is found.
    asked
        The controls that the occupant is asked to reach.
    wheels
        Parts that the occupant steers with by hand.
    why
        Sentences that say by what this was guessed.
    """

    frame: SeatFrame
    hands: dict[str, str]
    feet: dict[str, str]
    eyes: str
    heels: str
    asked: tuple[Control, ...]
    wheels: tuple[str, ...]
    why: tuple[str, ...]

    @property
    def operates(self) -> bool:
        """Whether hands or feet are on controls."""
        return bool(self.hands or self.feet)


@dataclass
class _Guess:
    """Controls of each side so far, and why."""

    at: dict[str, str] = field(default_factory=dict)
    why: list[str] = field(default_factory=list)

    def take(self, side: str, control: Control, reason: str, limb: str) -> None:
        """Put a hand or a foot on a control."""
        self.at[side] = control.name
        self.why.append(f"{side} {limb} on {control.name}: {reason}")

    @property
    def free(self) -> list[str]:
        """The sides without a control."""
        return [side for side in ("left", "right") if side not in self.at]


def sitters_of(environment: Environment) -> dict[str, Sitter]:
    """Guess for each seat, by its name, what its occupant does; of many seats for the first few.

    Nobody takes a control that somebody in an earlier seat of the file has taken.
    """
    taken: set[str] = set()
    found: dict[str, Sitter] = {}
    for seat in _apart(environment)[:MOST_SEATS]:
        found[seat.name] = _sitter(environment, seat, taken)
        taken |= {*found[seat.name].hands.values(), *found[seat.name].feet.values()}
    return found


def left_out(environment: Environment, asked: Collection[str]) -> Iterator[str]:
    """Sentences about seats that nobody takes, and controls that nobody is asked to reach."""
    apart = _apart(environment)
    for seat in environment.seats:
        if seat not in apart:
            near = next(one for one in apart if math.dist(one.srp, seat.srp) < APART)
            yield (
                f"seat {seat.name}: left empty, for it is "
                f"{1000 * math.dist(near.srp, seat.srp):.0f} mm from seat {near.name}, where "
                f"somebody sits"
            )
    if len(apart) > MOST_SEATS:
        names = ", ".join(seat.name for seat in apart[MOST_SEATS:])
        yield f"{len(apart)} seats, of which the first {MOST_SEATS} are taken; empty: {names}"
    missing = [one.name for one in environment.controls if one.name not in asked]
    if missing:
        yield f"nobody is asked to reach {', '.join(missing)}: nearest to who does not operate"


def _apart(environment: Environment) -> list[Seat]:
    """The seats that people can take at the same time."""
    found: list[Seat] = []
    for seat in environment.seats:
        if all(math.dist(one.srp, seat.srp) >= APART for one in found):
            found.append(seat)
    return found


def _sitter(environment: Environment, seat: Seat, taken: set[str]) -> Sitter:
    frame = SeatFrame(seat)
    within = [one for one in environment.controls if _share(environment, seat, one) <= BETWEEN]
    own = [one for one in within if _share(environment, seat, one) <= 0.5]
    free = [one for one in within if one.name not in taken]
    feet = _feet(frame, [one for one in own if one.for_feet and one.name not in taken])
    hands = _hands(frame, free, own)
    operates = bool(hands.at or feet.at)
    asked = within if operates else [one for one in own if not _steers(one)]
    eyes, heels = "", ""
    why = [*hands.why, *feet.why]
    if operates:
        eyes = _eye_point(environment, frame)
        heels = _heel_point(environment, frame) if feet.at else ""
        why += [f"eyes at the height of {eyes}: by its name and place"] if eyes else []
        why += [f"heels at the height of {heels}: by its name and place"] if heels else []
        why += [
            f"{side} hand at rest above the lap: nothing to hold is on its side"
            for side in hands.free
        ]
    else:
        why.append("hands in the lap: no wheel, stick, lever in zone 1 or pedal is nearest to it")
    wheels = {one.part for one in within if not one.for_feet and use_of(one).kind == "wheel"}
    wheels -= {*seat.parts}
    return Sitter(
        frame,
        {side: hands.at[side] for side in ("left", "right") if side in hands.at},
        {side: feet.at[side] for side in ("left", "right") if side in feet.at},
        eyes,
        heels,
        tuple(asked),
        tuple(sorted(wheels & set(environment.parts))) if operates else (),
        tuple(why),
    )


def _share(environment: Environment, seat: Seat, control: Control) -> float:
    """The share of the way from a seat to another one at which a control lies, the greatest; 0.5 is
    as far from either."""
    others = [one.srp for one in _apart(environment) if one.srp != seat.srp]
    if not others:
        return 0.0
    way = np.array(others) - seat.srp
    size = np.maximum(np.einsum("si,si->s", way, way), 1e-12)
    return float(np.max(way @ (np.array(control.at) - seat.srp) / size))


def _steers(control: Control) -> bool:
    return control.for_feet or use_of(control).kind in (*STEERS, "power")


def _by(use: Use) -> str:
    return f"by its name, {use.word!r}"


def _hands(frame: SeatFrame, free: Iterable[Control], own: Sequence[Control]) -> _Guess:
    """Hands on the wheel or the stick, and on what is nearest for the other."""
    guess = _Guess()
    work = frame.world(WORK[0], 0.0, WORK[1])
    near = sorted(
        (one for one in free if not one.for_feet and math.dist(work, one.at) <= ARM),
        key=lambda one: (math.dist(work, one.at), one.name),
    )
    mine = [one for one in near if one in own]
    uses = {one.name: use_of(one) for one in near}
    power = [one for one in near if uses[one.name].kind == "power"]
    wheels = [one for one in mine if uses[one.name].kind == "wheel"]
    sticks = [one for one in mine if uses[one.name].kind == "stick"]
    if wheels:
        _on_wheel(guess, frame, wheels, power, uses)
    elif sticks:
        stick = sticks[0]
        _take(guess, _stick_side(frame, stick, power), stick, _by(uses[stick.name]))
    # footplates that go along with a wheelchair are no pedals
    pedals = [one for one in own if one.for_feet and one.part not in frame.seat.moves]
    if not (wheels or sticks or pedals):
        _nearest_by_side(guess, frame, [one for one in power if one in mine], "", uses)
        levers = [one for one in mine if uses[one.name].kind == "lever" and one.zone == 1]
        _nearest_by_side(guess, frame, levers, "nearest to where hands are at work, in zone 1")
        return guess
    if guess.free:
        _nearest_by_side(guess, frame, power, "", uses)
    levers = [
        one
        for one in mine
        if uses[one.name].kind == "lever" and one.zone == 1 and one.grip == "grasp"
    ]
    _nearest_by_side(guess, frame, levers, "a lever in zone 1, the nearest of that side")
    return guess


def _take(guess: _Guess, side: str, control: Control, reason: str) -> None:
    guess.take(side, control, reason, "hand")


def _on_wheel(
    guess: _Guess,
    frame: SeatFrame,
    wheels: Sequence[Control],
    power: Sequence[Control],
    uses: dict[str, Use],
) -> None:
    """Both hands on the two places of a wheel that are farthest apart; one hand where there is one
    place alone."""
    across = sorted(wheels, key=lambda one: (-frame.seen(one.at)[1], one.name))
    left, right = across[0], across[-1]
    if frame.seen(left.at)[1] - frame.seen(right.at)[1] > 2 * TO_SIDE:
        _take(guess, "left", left, _by(uses[left.name]) + ", the place farthest to the left")
        _take(guess, "right", right, _by(uses[right.name]) + ", the place farthest to the right")
        return
    one = wheels[0]
    _take(guess, _stick_side(frame, one, power), one, _by(uses[one.name]))


def _stick_side(frame: SeatFrame, stick: Control, power: Sequence[Control]) -> str:
    """The hand for a stick: the one on its side, of one in the middle the one away from the
    throttle, else the right."""
    aside = float(frame.seen(stick.at)[1])
    if abs(aside) > 0.15:
        return "left" if aside > 0 else "right"
    if power:
        return "right" if frame.seen(power[0].at)[1] > aside else "left"
    return "right"


def _nearest_by_side(
    guess: _Guess,
    frame: SeatFrame,
    controls: Sequence[Control],
    reason: str,
    uses: dict[str, Use] | None = None,
) -> None:
    """The free hands on the first controls on their side of the seat's middle."""
    for one in controls:
        aside = float(frame.seen(one.at)[1])
        if one.name in guess.at.values() or abs(aside) < TO_SIDE:
            continue
        side = "left" if aside > 0 else "right"
        if side in guess.free:
            _take(guess, side, one, reason or _by(uses[one.name] if uses else use_of(one)))


def _feet(frame: SeatFrame, pedals: Sequence[Control]) -> _Guess:
    """Right foot on the accelerator, left on the rest, the clutch or the brake by name; else the
    outer pedals."""
    guess = _Guess()
    across = sorted(pedals, key=lambda one: (-frame.seen(one.at)[1], one.name))
    by_use: dict[str, Control] = {}
    for one in across:
        if use_of(one).word and not {"parking", "park", "hand"} & set(words_of(one.name)):
            by_use.setdefault(use_of(one).kind, one)
    if "accelerator" in by_use or "brake" in by_use:
        _driving_feet(guess, by_use)
        return guess
    outer = [one for one in across if use_of(one).kind == "pedal"]
    if len(outer) >= 2:
        guess.take("left", outer[0], "the pedal farthest to the left", "foot")
        guess.take("right", outer[-1], "the pedal farthest to the right", "foot")
    elif outer:
        side = "left" if frame.seen(outer[0].at)[1] > TO_SIDE else "right"
        guess.take(side, outer[0], "the only pedal, the foot of its side", "foot")
    return guess


def _driving_feet(guess: _Guess, by_use: dict[str, Control]) -> None:
    """The feet of a driver, by the names of the pedals."""
    right = by_use.get("accelerator") or by_use["brake"]
    guess.take("right", right, _by(use_of(right)), "foot")
    for kind in ("foot rest", "clutch", "brake"):
        left = by_use.get(kind)
        if left is not None and left is not right:
            guess.take("left", left, _by(use_of(left)), "foot")
            return


def _eye_point(environment: Environment, frame: SeatFrame) -> str:
    """The eye point of a seat: by name, a design eye first, then the nearest to where eyes are."""
    wanted = frame.seat.nominal_eye
    rows = [
        ("design" not in words_of(name), math.dist(wanted, at), name)
        for name, at in environment.points.items()
        if is_for_eyes(name)
        and math.dist(wanted, at) <= EYE_NEAR
        and abs(frame.seen(at)[1]) <= ASIDE
    ]
    return min(rows)[2] if rows else ""


def _heel_point(environment: Environment, frame: SeatFrame) -> str:
    """The heel point of a seat: by name, the nearest to its middle."""
    near, far = HEELS_AHEAD
    rows = []
    for name, at in environment.points.items():
        ahead, left, above = frame.seen(at).tolist()
        if is_for_heels(name) and near <= ahead <= far and abs(left) <= ASIDE and above < 0.1:
            rows.append((abs(left), name))
    return min(rows)[1] if rows else ""


# Tell what a control is for by the words of its name, and of the part that it is on.
#
# Names are split into whole words: at anything that is no letter, and where a small letter is
# followed by a capital. Accents are dropped. "trim_wheel" is not steered with, and "gear stick" is
# not flown with: words that say what else a thing is come before those that say its shape. Where the
# control's own name says nothing, that of its part does.


def _known(words: str) -> frozenset[str]:
    return frozenset(words.split())


NOT_HELD = _known(
    "latch lock catch switch switches button buttons breaker breakers fuse key ignition starter "
    "brake brakes handbrake ebrake parkbrake door window canopy hatch grab handhold buckle harness "
    "belt eject ejection emergency fire horn hooter indicator signal wiper wipers blinker stalk "
    "vent blower fan heat heater temperature climate light lights lamp mirror visor radio screen "
    "display audio volume trim valve cock shutoff fuel tank glove box hazard landing "
    "parking park mouse keyboard "
    "schalter taste knopf riegel bremse handbremse feststellbremse hupe tur fenster sicherung trimm "
    "bouton interrupteur loquet frein porte klaxon interruptor boton freno cerrojo puerta bocina "
    "pulsante interruttore porta clacson"
)
"""A hand does not rest on what is called so."""
STEERED = _known(
    "wheel steering steeringwheel yoke handlebar handlebars tiller rim "
    "lenkrad lenker steuerhorn steuerrad volant guidon volante manillar timone stuur ratt"
)
STICKS = _known("stick joystick sidestick cyclic controlstick steuerknuppel knuppel manche cloche")
POWER = _known(
    "throttle throttles thrust power collective gear gears gearshift gearstick gearlever shifter "
    "shift gashebel leistungshebel schalthebel schaltknauf manette gaz vitesse vitesses acelerador "
    "gas cambio manetta"
)
ACCELERATORS = _known(
    "accelerator gas throttle speed treadle gaspedal fahrpedal accelerateur accelerador acelerador "
    "acceleratore"
)
BRAKES = _known("brake bremse bremspedal frein freno rem broms")
CLUTCHES = _known("clutch kupplung kupplungspedal embrayage embrague frizione")
FOOT_RESTS = _known("rest footrest deadpedal dead fussstutze")
DIALS = frozenset({"selector", "knob", "dial", "drehknopf"})
COLUMN = frozenset({"column", "control"})
NO_STEERING = _known("hand road tyre tire spare nose tail front rear hub well thumb")
"""A wheel that is called so as well does not steer by hand."""


@dataclass(frozen=True)
class Use:
    """What a control is for.

    kind: "wheel", "stick", "power" (throttle or gear lever), "not held" or "lever" of hands;
    "accelerator", "brake", "clutch", "foot rest" or "pedal" of feet. word: by which word, "" where
    none says it.
    """

    kind: str
    word: str


def use_of(control: Control) -> Use:
    """Tell what a control is for, by its own name or else by that of its part."""
    tell = _foot_use if control.for_feet else _hand_use
    own = tell(words_of(control.name))
    return own if own.word else tell(words_of(control.part))


def _first(words: list[str], known: frozenset[str]) -> str:
    return next((word for word in words if word in known), "")


def _hand_use(words: list[str]) -> Use:
    if found := _first(words, NOT_HELD):
        return Use("not held", found)
    if COLUMN.issubset(words):
        return Use("stick", "control column")
    if found := _first(words, POWER):  # before the shape: a gear stick, a thrust wheel
        return Use("power", found)
    if found := _first(words, STICKS):
        return Use("stick", found)
    if (found := _first(words, STEERED)) and not _first(words, NO_STEERING):
        return Use("wheel", found)
    if found := _first(words, DIALS):  # but a gear selector
        return Use("not held", found)
    return Use("lever", "")


def _foot_use(words: list[str]) -> Use:
    for kind, known in (
        ("clutch", CLUTCHES),
        ("brake", BRAKES),
        ("foot rest", FOOT_RESTS),
        ("accelerator", ACCELERATORS),
    ):
        if found := _first(words, known):
            return Use(kind, found)
    return Use("pedal", "")
