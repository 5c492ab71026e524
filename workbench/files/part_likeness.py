"""Whether two parts are named as pieces of one thing.

A name is divided into words at signs, digits and capitals. Two parts are alike where they share a
word that tells their thing from others: `PropCap` and `PropLever`, `throttle_knob` and
`ThrotLever`. Words for kinds and places of parts, and those that programs add, tell nothing:
`prop_lever` and `mix_lever` are two levers. But `lever_knob` and `lever_stalk` are pieces of a
lever: they begin alike, and go on with pieces that many things have.
"""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["likeness", "name_words"]

_SHORTEST = 3
"""Letters of a word that tells one thing from others; `l`, `r`, `up` and `on` do not."""
_ABBREVIATED = 4
"""Letters of a word that another may begin with, and mean the same: `flap` and `flaps`."""


def name_words(name: str) -> tuple[str, ...]:
    """Return the words of a name in small letters, without its numbers."""
    spaced = []
    for k, letter in enumerate(name):
        before = name[k - 1 : k]
        behind = name[k + 1 : k + 2]
        new_word = letter.isupper() and (
            before.islower() or (before.isupper() and behind.islower())
        )
        spaced.append(f" {letter}" if new_word else letter if letter.isalpha() else " ")
    return tuple("".join(spaced).lower().split())


_PIECES = frozenset(
    name_words("""
    arm axis axle bar base bearing body bolt boot bottom bracket bush cap case casing clamp clip
    collar core cover detent disc disk edge foot frame gaiter gate grip guard guide handle head
    holder housing hub insert joint knob label link mark mount mounting neck needle nut pad pin
    pivot plate pointer rim ring rod root screw shaft shank side skirt sleeve slot socket spacer
    spindle spoke spring stalk stem strip stub surround tip top washer
    """)
)
"""Pieces that many things have."""
_KINDS = frozenset(
    name_words("""
    button control crank dial gauge indicator instrument key lamp led lever light meter pedal pull
    push selector slider switch toggle wheel
    bouton levier manette poignee pedale hebel knopf griff schalter taste palanca boton perilla
    """)
)
"""Kinds of controls and of what stands beside them."""
_PLACES = frozenset(
    name_words("""
    left right front rear fore aft near far centre center middle main upper lower inner outer inside
    outside inboard outboard driver passenger pilot copilot first second one two
    board bulkhead cab cabin chassis cockpit column console dash dashboard desk door facia fascia
    floor fuselage hull interior overhead panel pedestal pillar quadrant roof seat shell structure
    table wall
    assembly box circle component cone copy cube cylinder default geom geometry group instance line
    material mesh model new node obj object part piece plane polygon shape solid sphere surface
    torus
    """)
)
"""Places, structures, and words that programs add."""
_SAY_NOTHING = _PIECES | _KINDS | _PLACES


def likeness(part: str, others: Iterable[str]) -> str:
    """Return what the name of a part has in common with others of one thing.

    Parameters
    ----------
    part
        A name.
    others
        The names of the thing: of its part, of the controls on it.

    Returns
    -------
    str
        The word, "" where nothing makes it a piece of that thing.
    """
    words = name_words(part)
    for other in others:
        common = _common_word(words, name_words(other)) or _begun_alike(words, name_words(other))
        if common:
            return common
    return ""


def _common_word(one: tuple[str, ...], other: tuple[str, ...]) -> str:
    """The first word that tells a thing and is in both names, or begins one in the other."""
    for word in one:
        for like in other:
            short, long = sorted((word, like), key=len)
            if len(short) < _SHORTEST or {word, like} & _SAY_NOTHING:
                continue
            if word == like or (len(short) >= _ABBREVIATED and long.startswith(short)):
                return short
    return ""


def _begun_alike(one: tuple[str, ...], other: tuple[str, ...]) -> str:
    """The first word of two names that begin alike and differ in words for pieces alone."""
    first, *rest = [word for word in one if word not in _PLACES] or [""]
    same, *behind = [word for word in other if word not in _PLACES] or [""]
    alike = first == same and rest != behind and {*rest, *behind} <= _PIECES
    return first if alike else ""
