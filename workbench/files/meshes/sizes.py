"""Compare the sizes of named parts with those of the things they are named after, and say which
unit would fit.

A name is cut into words (at capitals, digits and signs), and words that say where or whose a part
is are left out. What is left names a thing by its last words: `Front_Wheel_Left` is a wheel,
`left_door_handle` a handle. A name that only begins with a thing (`seat_rails`, `wheel_arch`) is a
piece of it and at most as large. A name with a plural may mean several things in one part, and is
at least as large as one. The name of a file tells what the whole of it is.

The ranges are this project's assumptions, wide on purpose: of what is built for people, from
children's and model sizes of real use up to buses, airliners and tractors. They are there to tell
centimetres from inches and metres, not to judge a design.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats

__all__ = ["SIZE_RANGES", "implausible_sizes", "person_size"]


@dataclass(frozen=True)
class SizeRange:
    """A thing of a known size: least and greatest [m] of its largest extent, or of the middle one
    of three."""

    least: float
    greatest: float
    middle: bool = False
    """Measured by the middle extent: of a wheel the diameter, also where two of them on an axle are
    one part."""


_ADULT = SizeRange(0.8, 2.5)
_CHILD = SizeRange(0.4, 1.95)
_WHEEL = SizeRange(0.1, 1.7, middle=True)
SIZE_RANGES: dict[tuple[str, ...], SizeRange] = {
    # people: crouching or seated 0.8 m, arms raised or held out 2.5 m; children from newborn ones
    # of 0.5 m
    ("human",): _ADULT,
    ("person",): _ADULT,
    ("man",): _ADULT,
    ("woman",): _ADULT,
    ("adult",): _ADULT,
    ("male",): _ADULT,
    ("female",): _ADULT,
    ("mannequin",): _ADULT,
    ("manikin",): _ADULT,
    ("pilot",): _ADULT,
    ("occupant",): _ADULT,
    ("child",): _CHILD,
    ("boy",): _CHILD,
    ("girl",): _CHILD,
    ("baby",): _CHILD,
    # wheels: trolleys 0.1 m, cars 0.55 to 0.8 m, lorries 1.1 m, tractors up to 1.6 m
    ("wheel",): _WHEEL,
    ("tyre",): _WHEEL,
    ("tire",): _WHEEL,
    # what is sat on: child seats 0.3 m, a seat with its headrest up to 1.4 m
    ("seat",): SizeRange(0.25, 1.45),
    ("seat", "pan"): SizeRange(0.2, 0.9),
    ("seat", "back"): SizeRange(0.2, 1.2),
    ("seat", "cushion"): SizeRange(0.2, 0.9),
    ("headrest",): SizeRange(0.08, 0.7),
    ("armrest",): SizeRange(0.08, 0.9),
    ("chair",): SizeRange(0.3, 1.7),
    ("bench",): SizeRange(0.3, 6.0),
    # what is held, pushed and turned: a steering wheel 0.25 m (racing) to 0.55 m (bus)
    ("steering", "wheel"): SizeRange(0.2, 0.65),
    ("handwheel",): SizeRange(0.04, 1.0),
    ("pedal",): SizeRange(0.04, 0.5),
    ("lever",): SizeRange(0.03, 1.2),
    ("joystick",): SizeRange(0.05, 0.8),
    ("handle",): SizeRange(0.03, 1.0),
    ("knob",): SizeRange(0.005, 0.2),
    ("button",): SizeRange(0.003, 0.2),
    ("switch",): SizeRange(0.005, 0.3),
    ("handlebar",): SizeRange(0.25, 1.2),
    ("handrail",): SizeRange(0.2, 12.0),
    ("console",): SizeRange(0.1, 4.0),
    # what is looked through and at
    ("mirror",): SizeRange(0.05, 1.2),
    ("windscreen",): SizeRange(0.35, 3.2),
    ("windshield",): SizeRange(0.35, 3.2),
    ("canopy",): SizeRange(0.6, 6.0),
    ("dashboard",): SizeRange(0.4, 2.7),
    ("instrument", "panel"): SizeRange(0.2, 2.7),
    # what is walked through: a car's door from 0.7 m, an aircraft's or a hall's to 4 m
    ("door",): SizeRange(0.35, 4.0),
    ("hatch",): SizeRange(0.3, 3.0),
    ("interior",): SizeRange(0.8, 7.0),
    ("cockpit",): SizeRange(0.8, 7.0),
    ("cabin",): SizeRange(0.8, 40.0),
    # whole vehicles, and the front of a car by itself
    ("car",): SizeRange(1.8, 7.0),
    ("suv",): SizeRange(3.0, 7.0),
    ("van",): SizeRange(3.0, 9.0),
    ("truck",): SizeRange(3.5, 26.0),
    ("lorry",): SizeRange(3.5, 26.0),
    ("bus",): SizeRange(4.5, 26.0),
    ("tractor",): SizeRange(2.0, 9.0),
    ("motorcycle",): SizeRange(1.2, 3.2),
    ("motorbike",): SizeRange(1.2, 3.2),
    ("bicycle",): SizeRange(0.9, 2.6),
    ("wheelchair",): SizeRange(0.6, 1.8),
    ("helicopter",): SizeRange(5.0, 45.0),
    ("forklift",): SizeRange(1.8, 7.0),
}
"""Plausible sizes of things by the words that name them, in lower case."""

_PLACES = frozenset(
    [
        "left",
        "right",
        "front",
        "rear",
        "fore",
        "aft",
        "upper",
        "lower",
        "inner",
        "outer",
        "inside",
        "outside",
        "centre",
        "center",
        "middle",
        "main",
        "near",
        "far",
        "driver",
        "passenger",
        "gas",
        "brake",
        "clutch",
        "fl",
        "fr",
        "rl",
        "rr",
        "lf",
        "rf",
        "lr",
        "lh",
        "rh",
        "l",
        "r",
        "f",
        "geom",
        "geometry",
        "mesh",
        "object",
        "group",
        "part",
        "node",
        "shape",
        "default",
    ]
)
"""Words that say where a part is or what it works, and those that programs add."""
_WHOLES = frozenset(
    [
        "car",
        "suv",
        "van",
        "truck",
        "lorry",
        "bus",
        "tractor",
        "motorcycle",
        "motorbike",
        "bicycle",
        "wheelchair",
        "helicopter",
        "forklift",
        "human",
        "person",
        "man",
        "woman",
        "adult",
        "male",
        "female",
        "mannequin",
        "manikin",
        "pilot",
        "occupant",
        "child",
        "boy",
        "girl",
        "baby",
    ]
)
"""Things that a file may be as a whole."""
_CHILDREN = frozenset({"child", "boy", "girl", "baby"})
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_NAMED = 3
_NO_PLURAL = frozenset({"chassis", "bus", "glass", "compass"})


@dataclass(frozen=True)
class _Size:
    """A part that is named after a thing: its size and what is plausible [m]; infinite where
    nothing is known."""

    name: str
    thing: str
    size: float
    least: float
    greatest: float

    def fits(self, scale: float) -> bool:
        """True where the part, so many times as large, is of a plausible size."""
        return self.least <= scale * self.size <= self.greatest


def implausible_sizes(
    parts: Iterable[RawPart], metres: float, *, file: str = ""
) -> tuple[str, ...]:
    """A sentence where named parts, or the whole, have an implausible size; nothing where none has.

    Parameters
    ----------
    parts
        The parts of one mesh file [m].
    metres
        The file's unit of length that was used [m].
    file
        The name of the file without its ending, which may say what the whole is.
    """
    known = list(parts)
    rows = [row for part in known if (row := _sized(part.name, _extents([part]))) is not None]
    whole = _whole(file, _extents(known))
    if whole is not None and whole.thing not in {row.thing for row in rows}:
        rows.append(whole)
    wrong = [row for row in rows if not row.fits(1.0)]
    if not wrong:
        return ()
    shown = "; ".join(_said(row) for row in wrong[:_NAMED])
    more = f"; {len(wrong) - _NAMED} more named parts too" if len(wrong) > _NAMED else ""
    fitting = [
        unit for unit, one in metres_in.items() if all(row.fits(one / metres) for row in rows)
    ]
    best = max(metres_in, key=lambda unit: sum(row.fits(metres_in[unit] / metres) for row in rows))
    if fitting:
        sizes = ", ".join(
            f"{wrong[0].size * metres_in[unit] / metres:.3g} m in {unit}" for unit in fitting
        )
        return (
            f"{shown}{more}: a wrong unit of length? {wrong[0].name} would be {sizes}, which fits all named parts",
        )
    if sum(row.fits(metres_in[best] / metres) for row in rows) > len(rows) - len(wrong):
        return (f"{shown}{more}: a wrong unit of length? most named parts would fit in {best}",)
    return (f"{shown}{more}: is the unit of length right, and the part's own scale?",)


def person_size(size: float, metres: float) -> tuple[str, ...]:
    """What to say of the surface of a body whose largest extent is `size` [m], nothing where it may
    be a person.

    metres: the file's unit of length that was used [m].
    """
    if size <= _ADULT.greatest:
        return ()
    fitting = [
        f"{size * one / metres:.3g} m in {unit}"
        for unit, one in metres_in.items()
        if _ADULT.least <= size * one / metres <= _ADULT.greatest
    ]
    hint = f"it would be {', '.join(fitting)}" if fitting else "no unit makes it one"
    return (
        f"is {size:.3g} m large, and a person is up to {_ADULT.greatest:g} m: a wrong unit of length? {hint}",
    )


def _said(row: _Size) -> str:
    plausible = (
        f"{row.least:g} to {row.greatest:g} m"
        if np.isfinite(row.greatest)
        else f"at least {row.least:g} m"
    )
    plausible = plausible if row.least > 0 else f"at most {row.greatest:g} m"
    return f"{row.name!r} is {row.size:.3g} m large, and {plausible} is plausible for {row.thing!r}"


def _extents(parts: Iterable[RawPart]) -> Floats:
    """(3,) extents of parts together, ascending [m]."""
    points = np.concatenate([part.vertices[part.faces.ravel()] for part in parts])
    extents: Floats = np.sort(np.ptp(points, axis=0))
    return extents


def _sized(name: str, extents: Floats) -> _Size | None:
    words = _words(name)
    for first in range(len(words)):
        thing = SIZE_RANGES.get(tuple(words[first:]))
        if thing is not None:
            return _row(name, " ".join(words[first:]), thing, extents)
    many = _singular(words[-1]) if words else ""
    for first in range(len(words)):
        plural = (*words[first:-1], many)
        if plural in SIZE_RANGES:
            row = _row(name, " ".join(plural), SIZE_RANGES[plural], extents)
            return (
                row
                if SIZE_RANGES[plural].middle
                else _Size(name, row.thing, row.size, row.least, np.inf)
            )
    for last in range(len(words) - 1, 0, -1):
        thing = SIZE_RANGES.get(tuple(words[:last]))
        if thing is not None:
            return _Size(
                name, f"piece of {' '.join(words[:last])}", float(extents[2]), 0.0, thing.greatest
            )
    return None


def _whole(file: str, extents: Floats) -> _Size | None:
    """What the name of a file says of all its parts together: the last of its words that can name a
    whole."""
    for word in reversed(_words(file)):
        if (word,) in SIZE_RANGES:
            return _row(file, word, SIZE_RANGES[(word,)], extents) if word in _WHOLES else None
    return None


def _row(name: str, thing: str, known: SizeRange, extents: Floats) -> _Size:
    return _Size(name, thing, float(extents[1 if known.middle else 2]), known.least, known.greatest)


def _words(name: str) -> list[str]:
    """The words of a name that do not say where a part is; a child of either sex is a child."""
    words = [word.lower() for word in _WORD.findall(name)]
    child = next((word for word in words if word in _CHILDREN), None)
    kept = [child if child and SIZE_RANGES.get((word,)) is _ADULT else word for word in words]
    return [word for word in kept if word not in _PLACES]


def _singular(word: str) -> str:
    return word[:-1] if word.endswith("s") and word not in _NO_PLURAL else word
