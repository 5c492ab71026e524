"""Compare the sizes of parts with those of the things they are named after, and find the unit.

A name is divided into words (at capitals, digits and signs). Words for the place or the owner of a
part are dropped. The last words that are left name a thing: `Front_Wheel_Left` is a wheel,
`left_door_handle` a handle. A name that only begins with a thing (`seat_rails`, `wheel_arch`) is a
piece of it and at most as large. A name of a whole vehicle or a person among other words
(`main_bus`, `headset_pilot`) says what a part is for, so that only parts with no other word in their
names are held against its size, and only where some unit makes it one without making the mesh none
of anything: a label of 10 mm called `Bus` on a panel is no coach. A name with a plural may mean several things in one part, and is
at least as large as one. The name of a file tells what the whole of it is.

The ranges are this project's assumptions, wide on purpose: of what is built for people, from
children's and model sizes of real use up to buses, airliners and tractors. They are there to tell
centimetres from inches and metres, not to judge a design.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawPart
from workbench.files.meshes.reading import LARGEST
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats

__all__ = ["SIZE_RANGES", "NamedFits", "implausible_sizes", "named_fits", "person_size"]


@dataclass(frozen=True)
class SizeRange:
    """Plausible sizes of a thing."""

    least: float
    """Least size [m] of its largest extent, or of the middle one of three."""
    greatest: float
    """Greatest size [m]."""
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
_MAX_NAMES = 3
"""Number of parts that a warning names."""
_NO_PLURAL = frozenset({"chassis", "bus", "glass", "compass"})


@dataclass(frozen=True)
class _Size:
    """The size of a part that is named after a thing."""

    name: str
    thing: str
    size: float
    """[m]."""
    least: float
    """Least plausible size [m]."""
    greatest: float
    """Greatest plausible size [m], infinite if unknown."""

    def fits(self, scale: float) -> bool:
        """Return whether the part, scaled by a factor, has a plausible size."""
        return self.least <= scale * self.size <= self.greatest


def implausible_sizes(
    parts: Iterable[RawPart], metres: float, *, file: str = "", unnamed: Collection[str] = ()
) -> tuple[str, ...]:
    """Return a warning if named parts, or the whole, have an implausible size.

    Parameters
    ----------
    parts
        The parts of one mesh file [m].
    metres
        The unit of length [m] with which the file was read.
    file
        The name of the file without its ending, which may name the whole.
    unnamed
        Parts whose names tell nothing.
    """
    sizes = _meant_sizes(list(parts), metres, file, unnamed)
    wrong = [size for size in sizes if not size.fits(1.0)]
    if not wrong:
        return ()
    shown = "; ".join(_size_sentence(size) for size in wrong[:_MAX_NAMES])
    more = f"; {len(wrong) - _MAX_NAMES} more named parts too" if len(wrong) > _MAX_NAMES else ""
    return (f"{shown}{more}: {_unit_advice(sizes, wrong, metres)}",)


@dataclass(frozen=True)
class NamedFits:
    """What a mesh that is read with some unit has of things that its names tell.

    Parameters
    ----------
    fits, of
        How many are as large as their names say, of how many.
    whole
        The thing that the file is called, or that all parts are of half the mesh's size and more, where
        its size is that of one; "" else.
    """

    fits: int
    of: int
    whole: str


def named_fits(parts: Iterable[RawPart], metres: float, *, file: str = "") -> NamedFits:
    """Count what has a plausible size of the parts, and the whole, that are named after a thing.

    Parameters
    ----------
    parts, metres, file
        As of `implausible_sizes`.
    """
    known = list(parts)
    sizes = _meant_sizes(known, metres, file, ())
    right = [size for size in sizes if size.fits(1.0)]
    fitting = {size.name: size.thing for size in right}
    half = 0.5 * _extents(known)[2]
    large = [part.name for part in known if _extents([part])[2] >= half]
    whole = fitting.get(file, "")
    if large and set(large) <= fitting.keys():
        whole = fitting[large[0]]
    return NamedFits(len(right), len(sizes), whole)


def _meant_sizes(
    parts: list[RawPart], metres: float, file: str, unnamed: Collection[str]
) -> list[_Size]:
    """The sizes of what is named after a thing, as far as the name is meant so."""
    extents = _extents(parts)
    telling = [part for part in parts if part.name not in unnamed]
    named = [size for part in telling if (size := _named_size(part.name, _extents([part])))]
    sizes = [size for size in named if _is_meant(size, float(extents[2]), metres)]
    whole = _whole_size(file, extents)
    if whole is not None and whole.thing not in {size.thing for size in sizes}:
        sizes.append(whole)
    return sizes


def _is_meant(size: _Size, largest: float, metres: float) -> bool:
    """Whether a part is what its name says, as far as other words and the mesh tell.

    size: of the part; largest: extent [m] of its mesh, read with a unit of `metres`.
    """
    if size.thing not in _WHOLES or size.fits(1.0):
        return True
    if not all(word in _WHOLES for word in _words(size.name)):
        return False
    scales = [unit / metres for unit in metres_in.values()]
    return any(size.fits(scale) and largest * scale <= LARGEST for scale in scales)


def _unit_advice(sizes: list[_Size], wrong: list[_Size], metres: float) -> str:
    """Return the unit that would fit all named parts, or most of them."""
    scales = {unit: size / metres for unit, size in metres_in.items()}
    fits = {unit: sum(size.fits(scale) for size in sizes) for unit, scale in scales.items()}
    fitting = [unit for unit in scales if fits[unit] == len(sizes)]
    if fitting:
        first = wrong[0]
        would_be = ", ".join(f"{first.size * metres_in[u] / metres:.3g} m in {u}" for u in fitting)
        return (
            f"a wrong unit of length? {first.name} would be {would_be}, which fits all named parts"
        )
    best = max(fits, key=lambda unit: fits[unit])
    if fits[best] > len(sizes) - len(wrong):
        return f"a wrong unit of length? most named parts would fit in {best}"
    return "is the unit of length right, and the part's own scale?"


def person_size(size: float, metres: float) -> tuple[str, ...]:
    """Return a warning if the surface of a body is too large for a person.

    Parameters
    ----------
    size
        Largest extent [m].
    metres
        The unit of length [m] with which the file was read.
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


def _size_sentence(row: _Size) -> str:
    plausible = (
        f"{row.least:g} to {row.greatest:g} m"
        if np.isfinite(row.greatest)
        else f"at least {row.least:g} m"
    )
    plausible = plausible if row.least > 0 else f"at most {row.greatest:g} m"
    return f"{row.name!r} is {row.size:.3g} m large, and {plausible} is plausible for {row.thing!r}"


def _extents(parts: Iterable[RawPart]) -> Floats:
    """Return the extents (3,) [m] of parts together, ascending."""
    points = np.concatenate([part.vertices[part.faces.ravel()] for part in parts])
    return np.sort(np.ptp(points, axis=0))


def _named_size(name: str, extents: Floats) -> _Size | None:
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


def _whole_size(file: str, extents: Floats) -> _Size | None:
    """Return the size of all parts by the last word of a file's name that can name a whole."""
    for word in reversed(_words(file)):
        if (word,) in SIZE_RANGES:
            return _row(file, word, SIZE_RANGES[(word,)], extents) if word in _WHOLES else None
    return None


def _row(name: str, thing: str, known: SizeRange, extents: Floats) -> _Size:
    return _Size(name, thing, float(extents[1 if known.middle else 2]), known.least, known.greatest)


def _words(name: str) -> list[str]:
    """Return the words of a name that name a thing; a child of either sex is a child."""
    words = [word.lower() for word in _WORD.findall(name)]
    child = next((word for word in words if word in _CHILDREN), None)
    kept = [child if child and SIZE_RANGES.get((word,)) is _ADULT else word for word in words]
    return [word for word in kept if word not in _PLACES]


def _singular(word: str) -> str:
    return word[:-1] if word.endswith("s") and word not in _NO_PLURAL else word
