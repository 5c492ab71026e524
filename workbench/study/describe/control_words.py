"""Tell what a control is for by the words of its name, and of the part that it is on.

Names are split into whole words: at anything that is no letter, and where a small letter is
followed by a capital. Accents are dropped. "trim_wheel" is not steered with, and "gear stick" is
not flown with: words that say what else a thing is come before those that say its shape. Where the
control's own name says nothing, that of its part does.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from workbench.model.environment import Control

__all__ = ["Use", "is_for_eyes", "is_for_heels", "use_of", "words_of"]


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
EYES = _known(
    "eye eyes eyepoint dep derp auge augen augpunkt augenpunkt oeil yeux ojo ojos occhio occhi"
)
HEELS = _known("heel heels ahp ferse fersen talon talons talones tallone")
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


def words_of(name: str) -> list[str]:
    """The words of a name, small and without accents: "SteuerKnüppel_2" is steuer, knuppel."""
    apart = re.sub(r"(?<=[a-zß-ÿ])(?=[A-ZÀ-Þ])", " ", name)
    plain = unicodedata.normalize("NFKD", apart.casefold())
    return re.findall(r"[a-z]+", "".join(c for c in plain if not unicodedata.combining(c)))


def use_of(control: Control) -> Use:
    """Tell what a control is for, by its own name or else by that of its part."""
    tell = _foot_use if control.for_feet else _hand_use
    own = tell(words_of(control.name))
    return own if own.word else tell(words_of(control.part))


def is_for_eyes(name: str) -> bool:
    """Whether the name of a point is that of an eye point."""
    return not EYES.isdisjoint(words_of(name))


def is_for_heels(name: str) -> bool:
    """Whether the name of a point is that of a heel point."""
    return not HEELS.isdisjoint(words_of(name))


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
