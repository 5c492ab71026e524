"""Environment: named parts made of planar polygons, with their rules, seats, points, controls,
instruments and mirrors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Any, SupportsIndex, overload

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arguments import above, check_fields, check_index, checked, short_repr
from workbench.model.arrays import ArrayKind, Bools, Floats, Ints, freeze_fields

__all__ = [
    "HARMLESS",
    "Adjustment",
    "Allowance",
    "Control",
    "Doubt",
    "Environment",
    "Instrument",
    "Mirror",
    "OwnPiece",
    "Part",
    "PartNames",
    "Quality",
    "Rest",
    "Seat",
    "open_doubts",
]


@dataclass(frozen=True)
class Allowance:
    """Contact with a part that is allowed: by these segments ("all": any), down to `depth` [m]."""

    part: int
    segments: tuple[str, ...]
    depth: float


@dataclass(frozen=True)
class OwnPiece:
    """A part that belongs to a control beside the one that it stands on, as a stalk to its knob.

    beside: the part, or other piece, that it touches; why: what makes it belong to it, in words.
    Both are "" where the environment's file names it.
    """

    part: str
    beside: str = ""
    why: str = ""


@dataclass(frozen=True)
class Control:
    """A control: where it is reached [m], the grip (push, pinch, grasp, foot), the harness zone
    (1-3), the part that it stands on and goes along with ("" for none), and the other parts that
    are its own: who uses it may be as deep in these."""

    name: str
    at: tuple[float, float, float]
    grip: str
    zone: int
    part: str
    pieces: tuple[OwnPiece, ...] = ()

    @property
    def own_parts(self) -> tuple[str, ...]:
        """Its part, then its other pieces; nothing where it stands on no part."""
        return (self.part, *(piece.part for piece in self.pieces)) if self.part else ()

    @property
    def for_feet(self) -> bool:
        """Whether feet use it, not hands."""
        return self.grip == "foot"

    @property
    def limbs(self) -> str:
        """The limbs that it is for: "feet" or "hands"."""
        return "feet" if self.for_feet else "hands"

    def is_for(self, limb: str) -> bool:
        """Whether it is for "left hand", "right hand", "left foot" or "right foot"."""
        return limb.endswith("foot") == self.for_feet


@dataclass(frozen=True)
class Instrument:
    """An instrument or display that is read: its part, the middle `at` [m] of its face, the unit
    normal `face` of that, out of it toward who reads it; the height of its characters [m], 0 where
    the file does not say it; whether it is lit."""

    name: str
    part: str
    at: tuple[float, float, float]
    face: tuple[float, float, float]
    characters: float = 0.0
    lit: bool = False


@dataclass(frozen=True)
class Mirror:
    """A mirror: its part, the middle `at` [m] of its surface, the unit normal there, out of it
    toward who looks in, and the radius [m] of a convex surface, inf of a flat one.

    field: the class of field that it is for, "" where the file names none. aims: the point [m] that
    whoever has set it sees in its middle, None where it stays as it is drawn.
    """

    name: str
    part: str
    at: tuple[float, float, float]
    normal: tuple[float, float, float]
    radius: float = math.inf
    field: str = ""
    aims: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Rest:
    """A seat surface: its part ("" where only its plane is there, as the back of a stool), the
    segments that rest on it, how deep a sitter sinks in [m]."""

    part: str
    segments: tuple[str, ...]
    depth: float


@dataclass(frozen=True)
class CushionFront:
    """The front half of a cushion in section, down to its front edge: what thighs rest on.

    faces (along, above, offset): outward unit normals in the section, whose axes are the cushion's
    length and its normal, and the distance of each face from the seat reference point [m].
    gives [m]: how deep thighs may press in.
    """

    faces: tuple[tuple[float, float, float], ...]
    gives: float


@dataclass(frozen=True)
class Seat:
    """A seat: back and cushion planes meet in the seat reference point `srp` [m] on the centre
    line.

    back_angle: aft of vertical; cushion_angle: front edge up; yaw: heading about +z; all [rad].
    travel_forward, travel_up: (least, greatest) [m]; moves: the parts that go along with the seat.
    front: of its cushion, None where thighs may hang as they will.
    """

    name: str
    srp: tuple[float, float, float]
    back_angle: float
    cushion_angle: float
    yaw: float
    cushion: Rest
    back: Rest
    travel_forward: tuple[float, float]
    travel_up: tuple[float, float]
    moves: tuple[str, ...]
    front: CushionFront | None = None

    __repr__ = short_repr

    @property
    def parts(self) -> tuple[str, ...]:
        """The parts that are sat on and leant against."""
        return tuple(rest.part for rest in (self.cushion, self.back) if rest.part)

    @property
    def nominal_eye(self) -> tuple[float, float, float]:
        """About where the eyes of its occupant are [m]: 800 mm up the back plane from the seat
        reference point, and 227 mm ahead of that (AFSC DH 2-2)."""
        ahead = 0.227 - 0.80 * math.sin(self.back_angle)
        x, y, z = self.srp
        return (
            x + ahead * math.cos(self.yaw),
            y + ahead * math.sin(self.yaw),
            z + 0.80 * math.cos(self.back_angle),
        )

    def held(self, forward: float, up: float) -> Seat:
        """The seat in one position [m], without travel."""
        return replace(self, travel_forward=(forward, forward), travel_up=(up, up))


@dataclass(frozen=True)
class Adjustment:
    """What an occupant sets: parts that slide along an axis or turn about one.

    axis (3,): unit, of the slide or the turn; pivot (3,) [m]: a point of the axis of a turn, None
    of a slide. travel: (least, greatest), at: where it is set; [m] of a slide, [rad] of a turn, 0
    the nominal setting. parts, points: what moves; controls go along with their parts. mounted_on:
    the adjustment that carries this one, "" where none does. seat: whose occupant sets it, ""
    where the first may who acts on controls. tilts: the seat that this is the tilt of, "" of all
    others.
    """

    name: str
    axis: tuple[float, float, float]
    pivot: tuple[float, float, float] | None
    travel: tuple[float, float]
    parts: tuple[str, ...]
    points: tuple[str, ...] = ()
    mounted_on: str = ""
    seat: str = ""
    tilts: str = ""
    at: float = 0.0

    @property
    def turns(self) -> bool:
        """Whether its unit is the radian, not the metre."""
        return self.pivot is not None

    @property
    def column(self) -> str:
        """What a table calls it: its name with the unit, mm or deg."""
        return f"{self.name}_{'deg' if self.turns else 'mm'}"

    @property
    def shown_unit(self) -> float:
        """The unit in which it is shown, millimetre or degree [m or rad]."""
        return math.radians(1.0) if self.turns else 1e-3


@dataclass(frozen=True)
class Quality:
    """What was found in the mesh of one part: counts of faces and of faults, reported and never
    silently mended."""

    part: str
    faces: int
    polygons: int
    degenerate: int
    duplicate: int
    open_edges: int
    against: int
    """Faces wound against most of those they are connected with."""
    one_sided: int
    """Patches with one side only, as a Moebius strip has."""
    cavities: int
    """Closed shells that bound a cavity."""
    nested: int
    """Closed shells inside others and wound alike."""
    crossing: int
    """Closed shells that cross others or themselves."""
    tangled: int
    """Solids that cross themselves: depths in the part are lower bounds."""
    inverted: bool
    watertight: bool
    declared: bool
    """True where the environment's file says whether the part is solid."""


@dataclass(frozen=True, eq=False, repr=False)
class Environment:
    """K parts made of F planar polygons with E edges over V vertices; lengths [m].

    part_start (K + 1,): polygons of part k are part_start[k]:part_start[k + 1]. A polygon may be
    concave and have holes: edge_start (F + 1,), edges (E, 2) are the edges of all its loops, outer
    loop counter-clockwise about the normal, holes clockwise. normal (F, 3) unit, offset (F,):
    normal . x = offset on the plane. circle_centre (F, 3), circle_radius (F,): the minimum
    enclosing circle. triangles (T, 3), triangle_start (F + 1,): the triangles each polygon was made
    from, wound like the normal. solid, hidden, see_through (K,).
    """

    name: str
    description: str
    parts: tuple[str, ...]
    part_start: Ints
    vertices: Floats
    edges: Ints
    edge_start: Ints
    normal: Floats
    offset: Floats
    circle_centre: Floats
    circle_radius: Floats
    triangles: Ints
    triangle_start: Ints
    solid: Bools
    hidden: Bools
    see_through: Bools
    allowances: tuple[Allowance, ...] = ()
    seats: tuple[Seat, ...] = ()
    points: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    controls: tuple[Control, ...] = ()
    adjustments: tuple[Adjustment, ...] = ()
    instruments: tuple[Instrument, ...] = ()
    mirrors: tuple[Mirror, ...] = ()
    quality: tuple[Quality, ...] = ()
    warnings: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    """Sentences about what its file leaves open and the loader took to be so."""

    def __repr__(self) -> str:
        doubts = f"; {len(self.warnings)} warnings" if self.warnings else ""
        polygons = f"{len(self.normal)} polygons"
        return f"Environment({self.name}: {len(self.parts)} parts, {polygons}{doubts})"

    def _repr_html_(self) -> str | None:
        return above("draw.web.notebook", "notebook_html")(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._bind_parts()

    def _bind_parts(self) -> None:
        """Let the names of the parts give the parts."""
        object.__setattr__(self, "parts", PartNames(self.parts, self.part))

    def __post_init__(self) -> None:
        check_fields(self)
        self._bind_parts()
        k = len(self.parts)
        f = len(self.normal)
        arrays: dict[str, ArrayKind] = {
            "part_start": (np.int64, (k + 1,)),
            "vertices": (np.float64, (None, 3)),
            "edges": (np.int64, (None, 2)),
            "edge_start": (np.int64, (f + 1,)),
            "normal": (np.float64, (f, 3)),
            "offset": (np.float64, (f,)),
            "circle_centre": (np.float64, (f, 3)),
            "circle_radius": (np.float64, (f,)),
            "triangles": (np.int64, (None, 3)),
            "triangle_start": (np.int64, (f + 1,)),
            "solid": (np.bool_, (k,)),
            "hidden": (np.bool_, (k,)),
            "see_through": (np.bool_, (k,)),
        }
        freeze_fields(self, arrays, "environment")
        if not np.all(np.isfinite(self.vertices)):
            raise InputError(f"environment {self.name}: vertices must be finite")

    def part_index(self, name: str) -> int:
        """Index of a part by name; InputError lists the valid ones."""
        return self._index("part", name, self.parts)

    def part(self, name: str) -> Part:
        """A part by name, with its mesh; `parts[name]` is the same. InputError lists the valid
        names."""
        k = self.part_index(name)
        first, last = self.triangle_start[[self.part_start[k], self.part_start[k + 1]]]
        used, faces = np.unique(self.triangles[first:last], return_inverse=True)
        return Part(
            name,
            self.vertices[used],
            faces.reshape(-1, 3),
            bool(self.solid[k]),
            bool(self.hidden[k]),
            bool(self.see_through[k]),
            tuple(control.name for control in self.controls if control.part == name),
        )

    @checked
    def moved(self, displacements: Mapping[str, Any]) -> Environment:
        """The environment with parts, or controls alone, standing elsewhere.

        Controls, instruments and mirrors on a part go along with it, and so do pivots and points of an adjustment whose
        parts all go the same way.

        Parameters
        ----------
        displacements
            (3,) [m] by the name of a part, a pattern of names of parts (`*` for any letters), or the
            name of a control; numbers, or texts with their unit ("20 mm").

        Raises
        ------
        InputError
            If nothing is called so, something is moved twice or goes with a seat, or a displacement
            is none.
        """
        return above("files.study.stating", "moved_environment")(self, displacements)

    def to_trimesh(self) -> Any:
        """Return a trimesh.Scene with a mesh for each part, by its name, in metres; x is forward, y
        left, z up."""
        return above("files.meshes.scene", "environment_scene")(self)

    def seat(self, name: str) -> Seat:
        """A seat by name; InputError lists the valid ones."""
        return self.seats[self._index("seat", name, [one.name for one in self.seats])]

    def control(self, name: str) -> Control:
        """A control by name; InputError lists the valid ones."""
        return self.controls[self._index("control", name, [one.name for one in self.controls])]

    def adjustment(self, name: str) -> Adjustment:
        """An adjustment by name; InputError lists the valid ones."""
        names = [one.name for one in self.adjustments]
        return self.adjustments[self._index("adjustment", name, names)]

    def instrument(self, name: str) -> Instrument:
        """An instrument by name; InputError lists the valid ones."""
        names = [one.name for one in self.instruments]
        return self.instruments[self._index("instrument", name, names)]

    def mirror(self, name: str) -> Mirror:
        """A mirror by name; InputError lists the valid ones."""
        return self.mirrors[self._index("mirror", name, [one.name for one in self.mirrors])]

    def _index(self, kind: str, name: str, names: Sequence[str]) -> int:
        """Index of a name among those of a kind; InputError lists the valid ones."""
        if not isinstance(name, str) or name not in names:
            hint = one_of(name, names)
            raise InputError(f"environment {self.name}: no {kind} {name!r}; {hint}")
        return names.index(name)

    def with_seat(self, seat: Seat) -> Environment:
        """The environment with another seat in the place of the one of that name."""
        seats = tuple(seat if one.name == seat.name else one for one in self.seats)
        return replace(self, seats=seats)

    def polygons(self, part: int) -> slice:
        """The polygons of one part, by its index."""
        part = check_index("part", part, len(self.parts))
        return slice(int(self.part_start[part]), int(self.part_start[part + 1]))

    def triangle_corners(self, part: int) -> Floats:
        """(T, 3, 3) [m] the corners of the triangles of one part."""
        polygons = self.polygons(part)
        first, last = self.triangle_start[[polygons.start, polygons.stop]]
        return self.vertices[self.triangles[first:last]]

    @property
    def undecided(self) -> tuple[int, ...]:
        """The parts that are surfaces only because their mesh is not closed: nobody says that they
        are no solids."""
        loose = {found.part for found in self.quality if not (found.watertight or found.declared)}
        return tuple(k for k, name in enumerate(self.parts) if name in loose and not self.solid[k])

    @property
    def tangled(self) -> tuple[int, ...]:
        """The solid parts in which a depth is a lower bound, since faces inside could not be
        removed."""
        crossed = {found.part for found in self.quality if found.tangled}
        return tuple(k for k, name in enumerate(self.parts) if name in crossed and self.solid[k])

    @property
    def polygon_part(self) -> Ints:
        """(F,) the part of each polygon."""
        return np.repeat(np.arange(len(self.parts)), np.diff(self.part_start))

    @property
    def bounds(self) -> Floats:
        """(2, 3) least and greatest coordinates [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


@dataclass(frozen=True, eq=False, repr=False)
class Part:
    """A part of an environment with its mesh.

    Parameters
    ----------
    name
        As in the environment.
    vertices
        (V, 3) [m].
    faces
        (T, 3) triangles, indices into the vertices.
    solid, hidden, see_through
        As in the environment.
    controls
        The names of the controls on it.
    """

    name: str
    vertices: Floats
    faces: Ints
    solid: bool
    hidden: bool
    see_through: bool
    controls: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        arrays: dict[str, ArrayKind] = {
            "vertices": (np.float64, (None, 3)),
            "faces": (np.int64, (None, 3)),
        }
        freeze_fields(self, arrays, "part")

    def __repr__(self) -> str:
        size = " x ".join(f"{1e3 * length:.0f}" for length in np.ptp(self.bounds, axis=0))
        kind = "solid" if self.solid else "surface"
        return f"Part({self.name}: {kind} of {len(self.faces)} triangles, {size} mm)"

    @property
    def bounds(self) -> Floats:
        """(2, 3) least and greatest coordinates [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def area(self) -> float:
        """Of all triangles [m2]."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def to_trimesh(self) -> Any:
        """Return its mesh as a trimesh.Trimesh, in metres."""
        return above("files.meshes.scene", "part_mesh")(self)


class PartNames(tuple[str, ...]):
    """The names of the parts of an environment, in their order; by a name it gives the part."""

    _part: Callable[[str], Part] | None

    def __new__(cls, names: Iterable[str], part: Callable[[str], Part] | None = None) -> PartNames:
        """part: gives the part of a name."""
        made = super().__new__(cls, names)
        made._part = part
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        # the environment, which binds them again, is not to be pickled with its names
        return PartNames, (tuple(self),)

    @overload
    def __getitem__(self, key: SupportsIndex) -> str: ...
    @overload
    def __getitem__(self, key: slice) -> tuple[str, ...]: ...
    @overload
    def __getitem__(self, key: str) -> Part: ...
    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str) and self._part is not None:
            return self._part(key)
        return super().__getitem__(key)


@dataclass(frozen=True)
class Doubt:
    """Something that is probably a mistake.

    Parameters
    ----------
    about
        What is doubted, such as "place of control throttle". It stays whatever the numbers are:
        an environment that lists it under `accepted` is doubted no more in this.
    words
        A sentence with the numbers.
    """

    about: str
    words: str

    @property
    def said(self) -> str:
        """The sentence, with the name by which it is put away."""
        return f"{self.words} [{self.about}]"


HARMLESS = "; nothing that is found depends on it"
"""What notes about a mesh end with that a run need not repeat: `check` and `inspect` say them."""


def open_doubts(doubts: Iterable[Doubt], accepted: Sequence[str]) -> list[Doubt]:
    """Return the doubts that are not put away, each once.

    Parameters
    ----------
    doubts
        All that were found.
    accepted
        What they are about, or patterns of it.
    """
    return [
        doubt
        for doubt in dict.fromkeys(doubts)
        if not any(doubt.about == key or fnmatchcase(doubt.about, key) for key in accepted)
    ]
