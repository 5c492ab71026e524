"""Body: a tree of segments, each a union of spheres, joined at points."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arguments import check_fields
from workbench.model.arrays import Bools, Floats, Ints, frozen
from workbench.model.basis import ShapeBasis
from workbench.model.stops import Stops
from workbench.model.vocabulary import DIRECTIONS

__all__ = ["Body", "segment_words"]


@dataclass(frozen=True, eq=False, repr=False)
class Body:
    """A body of N segments, J = N - 1 joints and S spheres; lengths [m], angles [rad], masses [kg].

    Segments stand in depth-first order from the stage (the root, segment 0), so a subtree is a
    slice. Joint j joins segment j + 1 to its parent. Every segment frame has its origin at the
    segment's centre of gravity and is parallel to the world's in the zero pose.

    segments, joints: mnemonics; segment_names, joint_names: words; segment_numbers, joint_numbers:
    the paper's. parent (N,): -1 for the stage. joint_in_parent, joint_in_child (J, 3): the joint's
    coordinates in both frames. centre (S, 3), radius (S,): spheres in their segment's frame,
    grouped by segment: those of segment n are start[n]:start[n + 1]. enclosing_centre (N, 3),
    enclosing_radius (N,): a sphere around all spheres of the segment at every twist (radius 0 where
    there are none). sphere_names: "" where unnamed; sphere_direction (S,): index into DIRECTIONS or
    -1. directions (N, 6, 3): the six-direction table. twist_joint (N,): the distal joint whose
    twist the segment's spheres share, or -1; twist_point, twist_axis (N, 3): the line they turn
    about; twist_share (S,): 0 at the proximal joint to 1 at the distal one. allowance (N, N) [m]:
    overlap of soft flesh that is no contact. fit_error (N, 2) [m]: how far the true surface may lie
    outside and inside the spheres; NaN where not known. blend_joint (S,): a joint of the sphere's
    segment that the sphere is blended across, -1 where it is rigid, and blend_share (S,): how much
    of the other segment's motion it takes (see model.blend); empty: all rigid. basis: the family of
    bodies this one belongs to, None where there is none; basis_at (K,): its own coefficients.
    """

    name: str
    description: str
    segments: tuple[str, ...]
    segment_names: tuple[str, ...]
    segment_numbers: tuple[int, ...]
    joints: tuple[str, ...]
    joint_names: tuple[str, ...]
    joint_numbers: tuple[int, ...]
    parent: Ints
    joint_in_parent: Floats
    joint_in_child: Floats
    stops: Stops
    mass: Floats
    centre: Floats
    radius: Floats
    start: Ints
    enclosing_centre: Floats
    enclosing_radius: Floats
    sphere_names: tuple[str, ...]
    sphere_direction: Ints
    directions: Floats
    twist_joint: Ints
    twist_point: Floats
    twist_axis: Floats
    twist_share: Floats
    allowance: Floats
    fit_error: Floats
    blend_joint: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    blend_share: Floats = field(default_factory=lambda: np.zeros(0))
    basis: ShapeBasis | None = None
    basis_at: Floats = field(default_factory=lambda: np.zeros(0))

    def __repr__(self) -> str:
        return f"Body({self.name}: {len(self.segments)} segments, {len(self.sphere_names)} spheres)"

    def __post_init__(self) -> None:
        check_fields(self)
        n = len(self.segments)
        s = len(self.sphere_names)
        shapes: dict[str, tuple[type, tuple[int, ...]]] = {
            "parent": (np.int64, (n,)),
            "joint_in_parent": (np.float64, (n - 1, 3)),
            "joint_in_child": (np.float64, (n - 1, 3)),
            "mass": (np.float64, (n,)),
            "centre": (np.float64, (s, 3)),
            "radius": (np.float64, (s,)),
            "start": (np.int64, (n + 1,)),
            "enclosing_centre": (np.float64, (n, 3)),
            "enclosing_radius": (np.float64, (n,)),
            "sphere_direction": (np.int64, (s,)),
            "directions": (np.float64, (n, len(DIRECTIONS), 3)),
            "twist_joint": (np.int64, (n,)),
            "twist_point": (np.float64, (n, 3)),
            "twist_axis": (np.float64, (n, 3)),
            "twist_share": (np.float64, (s,)),
            "allowance": (np.float64, (n, n)),
            "fit_error": (np.float64, (n, 2)),
            "blend_joint": (np.int64, (s,)),
            "blend_share": (np.float64, (s,)),
            "basis_at": (np.float64, (len(self.basis) if self.basis else 0,)),
        }
        if not len(self.blend_joint):
            object.__setattr__(self, "blend_joint", np.full(s, -1))
            object.__setattr__(self, "blend_share", np.zeros(s))
        for name, (dtype, shape) in shapes.items():
            object.__setattr__(
                self, name, frozen(getattr(self, name), dtype, shape, f"body.{name}")
            )
        self._check()

    def _check(self) -> None:
        order = np.arange(len(self.segments))
        if (
            self.parent[0] != -1
            or np.any(self.parent[1:] < 0)
            or np.any(self.parent[1:] >= order[1:])
        ):
            raise InputError(
                f"body {self.name}: segments must stand in depth-first order, each after its parent"
            )
        if len(self.joints) != len(self.segments) - 1:
            raise InputError(
                f"body {self.name}: {len(self.segments)} segments need {len(self.segments) - 1} joints"
            )
        if (
            not np.all(np.isfinite(self.centre))
            or not np.all(self.radius > 0)
            or not np.all(np.isfinite(self.radius))
        ):
            raise InputError(
                f"body {self.name}: spheres need finite centres and positive finite radii"
            )
        if (
            self.start[0] != 0
            or self.start[-1] != len(self.sphere_names)
            or np.any(np.diff(self.start) < 0)
        ):
            raise InputError(f"body {self.name}: start must rise from 0 to the number of spheres")
        joint = self.blend_joint
        segment = self.sphere_segment
        near = (joint == segment - 1) | (
            self.parent[np.minimum(joint + 1, len(self.segments) - 1)] == segment
        )
        if not np.all((joint == -1) | ((joint >= 0) & (joint < len(self.joints)) & near)):
            raise InputError(
                f"body {self.name}: a sphere can be blended across a joint of its own segment only"
            )
        if not np.all((self.blend_share >= 0) & (self.blend_share <= 1)):
            raise InputError(f"body {self.name}: the shares of blended spheres lie between 0 and 1")

    def segment(self, mnemonic: str) -> int:
        """Index of a segment by its mnemonic; InputError lists the valid ones."""
        if mnemonic not in self.segments:
            hint = one_of(mnemonic, self.segments, words=segment_words(self))
            raise InputError(f"body {self.name}: no segment {mnemonic!r}; {hint}")
        return self.segments.index(mnemonic)

    def joint(self, mnemonic: str) -> int:
        """Index of a joint by its mnemonic; InputError lists the valid ones."""
        if mnemonic not in self.joints:
            raise InputError(
                f"body {self.name}: no joint {mnemonic!r}; {one_of(mnemonic, self.joints)}"
            )
        return self.joints.index(mnemonic)

    def spheres(self, segment: int) -> slice:
        """The spheres of one segment."""
        return slice(int(self.start[segment]), int(self.start[segment + 1]))

    @property
    def sphere_segment(self) -> Ints:
        """(S,) the segment of each sphere."""
        return np.repeat(np.arange(len(self.segments)), np.diff(self.start))

    @property
    def detail(self) -> str:
        """The level of detail at which its family has these spheres; "" without a family, or with
        worn things on."""
        return self.basis.level(np.diff(self.start)) if self.basis is not None else ""

    @property
    def zero_origins(self) -> Floats:
        """(N, 3) [m] where each segment's origin is in the zero pose, the stage's at 0."""
        at = np.zeros((len(self.segments), 3))
        for n in range(1, len(self.segments)):
            at[n] = at[self.parent[n]] + self.joint_in_parent[n - 1] - self.joint_in_child[n - 1]
        return at

    @property
    def adjacent(self) -> Bools:
        """(N, N) True where two segments are the same or share a joint."""
        grid = np.eye(len(self.segments), dtype=np.bool_)
        child = np.arange(1, len(self.segments))
        grid[child, self.parent[1:]] = grid[self.parent[1:], child] = True
        return grid


def segment_words(body: Body) -> dict[str, str]:
    """The mnemonic of each segment by its name in words, for suggestions."""
    return dict(zip(body.segment_names, body.segments, strict=True))
