"""Body: a tree of segments, each a union of spheres, joined at points; a row for each person."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.model.arguments import check_fields, check_index, chosen_rows
from workbench.model.arrays import ArrayKind, Bools, Floats, Ints, freeze_fields
from workbench.model.basis import ShapeBasis
from workbench.model.stops import Stops

__all__ = [
    "DIRECTIONS",
    "KEPT",
    "OPPOSITE",
    "ROW_FIELDS",
    "SEATED_FACTORS",
    "Body",
    "Topology",
    "body_of_rows",
    "check_one",
    "logical_window",
    "segment_words",
    "stack_bodies",
    "walk",
]


DIRECTIONS: tuple[str, ...] = ("front", "back", "left", "right", "top", "bottom")
OPPOSITE: dict[str, str] = {
    "front": "back",
    "back": "front",
    "left": "right",
    "right": "left",
    "top": "bottom",
    "bottom": "top",
}

KEPT = "_kept"
"""Where a body or a topology holds what is kept with it, see model.kept."""
SOURCE = "_source"
MOST_SOURCE_ROWS = 1024
"""Where a body holds `Body.source`, and of how many rows that may be: it is kept in memory as long."""
SEATED_FACTORS = (0.7, 1.4)
"""Range of `Body.seated_factors`. Hips of the people of ANSUR II are 0.98 to 1.33 times as broad on a
seat as standing."""


@dataclass(frozen=True, eq=False, repr=False)
class Topology:
    """What all rows of a body share: N segments, J = N - 1 joints and S spheres; angles [rad].

    Segments stand in depth-first order from the stage (the root, segment 0), so a subtree is a
    slice. Joint j joins segment j + 1 to its parent. Every segment frame has its origin at the
    segment's centre of gravity and is parallel to the world's in the zero pose.

    segments, joints: mnemonics; segment_names, joint_names: words; segment_numbers, joint_numbers:
    the paper's. parent (N,): -1 for the stage. start (N + 1,): spheres are grouped by segment,
    those of segment n are start[n]:start[n + 1]. sphere_names: "" where unnamed; sphere_direction
    (S,): index into DIRECTIONS or -1. directions (N, 6, 3): the six-direction table. twist_joint
    (N,): the distal joint whose twist the segment's spheres share, or -1. blend_joint (S,): a joint
    of the sphere's segment that the sphere is blended across, -1 where it is rigid (see
    model.blend); empty: all rigid. basis: the family of bodies that this one belongs to, None where
    there is none.
    """

    segments: tuple[str, ...]
    segment_names: tuple[str, ...]
    segment_numbers: tuple[int, ...]
    joints: tuple[str, ...]
    joint_names: tuple[str, ...]
    joint_numbers: tuple[int, ...]
    parent: Ints
    stops: Stops
    start: Ints
    sphere_names: tuple[str, ...]
    sphere_direction: Ints
    directions: Floats
    twist_joint: Ints
    blend_joint: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    basis: ShapeBasis | None = None

    def __repr__(self) -> str:
        return f"Topology({len(self.segments)} segments, {len(self.sphere_names)} spheres)"

    def __post_init__(self) -> None:
        check_fields(self)
        n = len(self.segments)
        s = len(self.sphere_names)
        if not np.size(self.blend_joint):
            object.__setattr__(self, "blend_joint", np.full(s, -1))
        arrays: dict[str, ArrayKind] = {
            "parent": (np.int64, (n,)),
            "start": (np.int64, (n + 1,)),
            "sphere_direction": (np.int64, (s,)),
            "directions": (np.float64, (n, len(DIRECTIONS), 3)),
            "twist_joint": (np.int64, (n,)),
            "blend_joint": (np.int64, (s,)),
        }
        freeze_fields(self, arrays, "body")
        self._check()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != KEPT}

    def _check(self) -> None:
        order = np.arange(len(self.segments))
        parent = self.parent
        if parent[0] != -1 or np.any(parent[1:] < 0) or np.any(parent[1:] >= order[1:]):
            raise InputError(
                "body.parent: segments must stand in depth-first order, each after its parent"
            )
        if len(self.joints) != len(self.segments) - 1:
            raise InputError(
                f"body.joints: expected {len(self.segments) - 1} joints for {len(self.segments)} "
                f"segments, got {len(self.joints)}"
            )
        if (
            self.start[0] != 0
            or self.start[-1] != len(self.sphere_names)
            or np.any(np.diff(self.start) < 0)
        ):
            raise InputError("body.start: expected numbers that rise from 0 to that of the spheres")
        joint = self.blend_joint
        segment = self.sphere_segment
        near = (joint == segment - 1) | (
            self.parent[np.minimum(joint + 1, len(self.segments) - 1)] == segment
        )
        if not np.all((joint == -1) | ((joint >= 0) & (joint < len(self.joints)) & near)):
            raise InputError(
                "body.blend_joint: a sphere can be blended across a joint of its own segment only"
            )

    @cached_property
    def sphere_segment(self) -> Ints:
        """(S,) the segment of each sphere."""
        found = np.repeat(np.arange(len(self.segments)), np.diff(self.start))
        found.flags.writeable = False
        return found

    @cached_property
    def subparts(self) -> tuple[str, ...]:
        """The S spheres as studies name them, "RLL/knee cap"; "" where unnamed."""
        pairs = zip(self.sphere_segment, self.sphere_names, strict=True)
        return tuple(f"{self.segments[segment]}/{name}" if name else "" for segment, name in pairs)

    @property
    def adjacent(self) -> Bools:
        """(N, N) True where two segments are the same or share a joint."""
        grid = np.eye(len(self.segments), dtype=np.bool_)
        child = np.arange(1, len(self.segments))
        grid[child, self.parent[1:]] = grid[self.parent[1:], child] = True
        return grid


@dataclass(frozen=True, eq=False, repr=False)
class Body:
    """B bodies of one topology, a row each; lengths [m], masses [kg]. The body of a file is B = 1.

    `body[rows]` gives some of the rows. topology: what the rows share; its fields can be read from
    the body itself. joint_in_parent, joint_in_child (B, J, 3): the joints' coordinates in both
    frames. mass (B, N). centre (B, S, 3), radius (B, S): spheres in their segments' frames.
    enclosing_centre (B, N, 3), enclosing_radius (B, N): a sphere around all spheres of the segment
    at every twist (radius 0 where there are none). twist_point, twist_axis (B, N, 3): the line that
    the segment's spheres turn about; twist_share (B, S): 0 at the proximal joint to 1 at the distal
    one. allowance (B, N, N): overlap of soft flesh that is no contact. fit_error (B, N, 2): how far
    the true surface may lie outside and inside the spheres; NaN where not known. blend_share (B,
    S): how much of the other segment's motion a blended sphere takes; empty: none. basis_at (B, K):
    coefficients in the family of bodies. seated_factors (B, 2): breadth and thickness of hips and
    thighs on a seat as shares of those standing; empty: 1, no flesh spreads.
    """

    name: str
    description: str
    topology: Topology
    joint_in_parent: Floats
    joint_in_child: Floats
    mass: Floats
    centre: Floats
    radius: Floats
    enclosing_centre: Floats
    enclosing_radius: Floats
    twist_point: Floats
    twist_axis: Floats
    twist_share: Floats
    allowance: Floats
    fit_error: Floats
    blend_share: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    basis_at: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    seated_factors: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    def __repr__(self) -> str:
        people = f"{len(self)} people, " if len(self) != 1 else ""
        words = f"{len(self.segments)} segments, {len(self.sphere_names)} spheres"
        return f"Body({self.name}: {people}{words})"

    def __post_init__(self) -> None:
        check_fields(self)
        b = len(self.centre)
        n = len(self.segments)
        s = len(self.sphere_names)
        if not np.size(self.blend_share):
            object.__setattr__(self, "blend_share", np.zeros((b, s)))
        if not np.size(self.basis_at):
            object.__setattr__(self, "basis_at", np.zeros((b, 0)))
        if not np.size(self.seated_factors):
            object.__setattr__(self, "seated_factors", np.ones((b, 2)))
        shapes: dict[str, tuple[int | None, ...]] = {
            "joint_in_parent": (b, n - 1, 3),
            "joint_in_child": (b, n - 1, 3),
            "mass": (b, n),
            "centre": (b, s, 3),
            "radius": (b, s),
            "enclosing_centre": (b, n, 3),
            "enclosing_radius": (b, n),
            "twist_point": (b, n, 3),
            "twist_axis": (b, n, 3),
            "twist_share": (b, s),
            "allowance": (b, n, n),
            "fit_error": (b, n, 2),
            "blend_share": (b, s),
            "basis_at": (b, len(self.basis) if self.basis else 0),
            "seated_factors": (b, 2),
        }
        arrays = {name: (np.float64, shape) for name, shape in shapes.items()}
        freeze_fields(self, arrays, "body")
        self._check()

    def _check(self) -> None:
        if not len(self):
            raise InputError(f"body {self.name}: expected one row at least, got none")
        if (
            not np.all(np.isfinite(self.centre))
            or not np.all(self.radius > 0)
            or not np.all(np.isfinite(self.radius))
        ):
            raise InputError(
                f"body {self.name}: spheres need finite centres and positive finite radii"
            )
        if not np.all((self.blend_share >= 0) & (self.blend_share <= 1)):
            raise InputError(f"body {self.name}: the shares of blended spheres lie between 0 and 1")

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in (KEPT, SOURCE)}

    def __len__(self) -> int:
        return len(self.centre)

    def __iter__(self) -> Iterator[Body]:
        return (self[row] for row in range(len(self)))

    def __getitem__(self, rows: int | slice | Ints | Bools) -> Body:
        """Some of the rows, of the same topology; the body itself where these are all of its rows.

        IndexError where there is no such row.
        """
        if isinstance(rows, (int, np.integer)):
            if not -len(self) <= rows < len(self):
                raise IndexError(f"body {self.name} has no row {rows}; it has {len(self)}")
            first = int(rows) % len(self)
            rows = slice(first, first + 1)
        rows = chosen_rows("rows", rows, len(self))
        if np.array_equal(np.arange(len(self))[rows], np.arange(len(self))):
            return self
        values = {name: getattr(self, name)[rows] for name in ROW_FIELDS}
        found = body_of_rows(self, values)
        whole, own = self.source or (self, np.arange(len(self)))
        if len(whole) <= MOST_SOURCE_ROWS:
            found.__dict__[SOURCE] = whole, own[rows]
        return found

    @property
    def source(self) -> tuple[Body, Ints] | None:
        """The body that this one was taken from, and which of its rows (B,) these are; None where it
        is not kept."""
        return self.__dict__.get(SOURCE)

    def segment(self, mnemonic: str) -> int:
        """Index of a segment by its mnemonic; InputError lists the valid ones."""
        if not isinstance(mnemonic, str) or mnemonic not in self.segments:
            hint = one_of(mnemonic, self.segments, words=segment_words(self))
            raise InputError(f"body {self.name}: no segment {mnemonic!r}; {hint}")
        return self.segments.index(mnemonic)

    def joint(self, mnemonic: str) -> int:
        """Index of a joint by its mnemonic; InputError lists the valid ones."""
        if not isinstance(mnemonic, str) or mnemonic not in self.joints:
            raise InputError(
                f"body {self.name}: no joint {mnemonic!r}; {one_of(mnemonic, self.joints)}"
            )
        return self.joints.index(mnemonic)

    def spheres(self, segment: int) -> slice:
        """The spheres of one segment, by its index."""
        segment = check_index("segment", segment, len(self.segments))
        return slice(int(self.start[segment]), int(self.start[segment + 1]))

    def has(self, mnemonic: str) -> bool:
        """Whether a body has a segment and spheres on it: False of a limb that is missing."""
        known = isinstance(mnemonic, str) and mnemonic in self.segments
        return known and bool(np.diff(self.start)[self.segment(mnemonic)])

    @property
    def detail(self) -> str:
        """The level of detail at which its family has these spheres; "" without a family, or with
        worn things on."""
        return self.basis.level(np.diff(self.start)) if self.basis is not None else ""

    @property
    def zero_origins(self) -> Floats:
        """(B, N, 3) [m] where each segment's origin is in the zero pose, the stage's at 0."""
        at = np.zeros((len(self), len(self.segments), 3))
        for n in range(1, len(self.segments)):
            joint = at[:, self.parent[n]] + self.joint_in_parent[:, n - 1]
            at[:, n] = joint - self.joint_in_child[:, n - 1]
        return at

    @property
    def segments(self) -> tuple[str, ...]:
        """Mnemonics of the N segments."""
        return self.topology.segments

    @property
    def segment_names(self) -> tuple[str, ...]:
        """The segments in words."""
        return self.topology.segment_names

    @property
    def segment_numbers(self) -> tuple[int, ...]:
        """The paper's numbers of the segments."""
        return self.topology.segment_numbers

    @property
    def joints(self) -> tuple[str, ...]:
        """Mnemonics of the J joints."""
        return self.topology.joints

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints in words."""
        return self.topology.joint_names

    @property
    def joint_numbers(self) -> tuple[int, ...]:
        """The paper's numbers of the joints."""
        return self.topology.joint_numbers

    @property
    def parent(self) -> Ints:
        """(N,) the parent of each segment, -1 for the stage."""
        return self.topology.parent

    @property
    def stops(self) -> Stops:
        """The joint stops."""
        return self.topology.stops

    @property
    def start(self) -> Ints:
        """(N + 1,) where the spheres of each segment begin."""
        return self.topology.start

    @property
    def sphere_names(self) -> tuple[str, ...]:
        """Names of the S spheres, "" where unnamed."""
        return self.topology.sphere_names

    @property
    def subparts(self) -> tuple[str, ...]:
        """The S spheres as studies name them, "RLL/knee cap"; "" where unnamed."""
        return self.topology.subparts

    @property
    def sphere_direction(self) -> Ints:
        """(S,) index into DIRECTIONS, or -1."""
        return self.topology.sphere_direction

    @property
    def sphere_segment(self) -> Ints:
        """(S,) the segment of each sphere."""
        return self.topology.sphere_segment

    @property
    def directions(self) -> Floats:
        """(N, 6, 3) the six-direction table."""
        return self.topology.directions

    @property
    def twist_joint(self) -> Ints:
        """(N,) the joint whose twist the segment's spheres share, or -1."""
        return self.topology.twist_joint

    @property
    def blend_joint(self) -> Ints:
        """(S,) the joint that a sphere is blended across, or -1."""
        return self.topology.blend_joint

    @property
    def basis(self) -> ShapeBasis | None:
        """The family of bodies, None where there is none."""
        return self.topology.basis

    @property
    def adjacent(self) -> Bools:
        """(N, N) True where two segments are the same or share a joint."""
        return self.topology.adjacent


ROW_FIELDS = tuple(
    f.name for f in fields(Body) if f.name not in ("name", "description", "topology")
)
"""Fields with a row for each body."""


def body_of_rows(template: Body, rows: dict[str, Floats]) -> Body:
    """The template with other rows (every field of ROW_FIELDS), which were checked when they were
    made: to check thousands again costs more than all else that is done with them."""
    made = object.__new__(Body)
    for name in ("name", "description", "topology"):
        made.__dict__[name] = getattr(template, name)
    for name in ROW_FIELDS:
        values = np.ascontiguousarray(rows[name])
        values.flags.writeable = False
        made.__dict__[name] = values
    return made


def stack_bodies(bodies: Sequence[Body]) -> Body:
    """One body with the rows of several, in their order.

    Its name, description and topology are those of the first. UsageError where there is no body, or
    where two have different topologies.

    Examples
    --------
    >>> import workbench as wb
    >>> woman = wb.load_body("adult_female")
    >>> people = wb.stack_bodies([woman, wb.scale(woman, {"stature": 1.525})])
    >>> people.radius.shape  # people, spheres
    (2, 409)
    """
    if not bodies:
        raise UsageError("bodies: expected one at least, got none")
    first = bodies[0]
    known = {id(first.topology)}
    for body in bodies:
        if id(body.topology) not in known:
            other = _difference(first.topology, body.topology)
            if other:
                raise UsageError(
                    f"bodies: {first.name!r} and {body.name!r} cannot be rows of one body, they differ "
                    f"in {other}"
                )
            known.add(id(body.topology))
    if len(bodies) == 1:
        return first
    return body_of_rows(
        first,
        {name: np.concatenate([getattr(body, name) for body in bodies]) for name in ROW_FIELDS},
    )


def _difference(one: Topology, other: Topology) -> str:
    """The first field in which two topologies differ; "" where they are the same."""
    if one.joints != other.joints or one.segments != other.segments:
        return "segments or joints"
    if one.sphere_names != other.sphere_names or not np.array_equal(one.start, other.start):
        return "spheres"
    for name in ("kind", "limits", "axes"):
        if not np.array_equal(getattr(one.stops, name), getattr(other.stops, name)):
            return "joint stops"
    for name in ("parent", "twist_joint", "blend_joint", "directions"):
        if not np.array_equal(getattr(one, name), getattr(other, name)):
            return name
    return "" if one.basis is other.basis else "basis"


def check_one(body: Body) -> None:
    """UsageError for a body of several rows, where one person is asked about."""
    if len(body) != 1:
        raise UsageError(
            f"body: expected one row, got {body.name} with {len(body)}; give one of them, as body[0]"
        )


def segment_words(body: Body) -> dict[str, str]:
    """The mnemonic of each segment by its name in words, for suggestions."""
    return dict(zip(body.segment_names, body.segments, strict=True))


def walk(body: Body | Topology, reference: int) -> list[tuple[int, int, int, bool]]:
    """The tree walked depth first from the reference segment: (to, came from, joint, upward) for
    each step.

    Upward is True where the step goes from a joint's distal segment to its proximal one. What hangs
    behind a step is the run of steps that follows it.
    """
    children: list[list[int]] = [[] for _ in body.segments]
    for child, parent in enumerate(body.parent[1:].tolist(), start=1):
        children[parent].append(child)
    steps: list[tuple[int, int, int, bool]] = []
    todo = [(reference, -1)]
    while todo:
        at, came = todo.pop()
        if came >= 0:
            upward = int(body.parent[came]) == at
            steps.append((at, came, (came if upward else at) - 1, upward))
        parent = int(body.parent[at])
        near = ([parent] if parent >= 0 else []) + children[at]
        todo += [(n, at) for n in reversed(near) if n != came]
    return steps


def logical_window(body: Body, segments: Iterable[str] | None, reference: int) -> Bools:
    """(N,) True for the named segments, the reference segment and all between them; None is the
    whole body.

    Source: Badler, O'Rourke & Toltzis 1979, the logical window (their Fig. 5). InputError for an
    unknown segment.
    """
    if segments is None:
        return np.ones(len(body.segments), dtype=np.bool_)
    came = {to: at for to, at, _, _ in walk(body, reference)}
    shown = np.zeros(len(body.segments), dtype=np.bool_)
    shown[reference] = True
    for name in segments:
        at = body.segment(name)
        while at != reference:
            shown[at] = True
            at = came[at]
    return shown
