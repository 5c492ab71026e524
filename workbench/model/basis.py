"""ShapeBasis: a family of human bodies as a mean and principal components of spheres, joints and
segment origins."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats, Ints, read_only

__all__ = ["Detail", "ShapeBasis", "in_order"]


@dataclass(frozen=True, eq=False, repr=False)
class Detail:
    """The S spheres of a family at one level of detail, standing in the zero pose, in the world
    [m].

    segment (S,): rising; centre_mean (S, 3), centre_basis (K, S, 3), radius_mean (S,), radius_basis
    (K, S): linear in the coefficients. blend_joint (S,), blend_share (S,), names and direction (S,)
    as a Body has them. fit_error (N, 2): how far the true surface may lie outside and inside, NaN
    where not known.
    """

    segment: Ints
    centre_mean: Floats
    centre_basis: Floats
    radius_mean: Floats
    radius_basis: Floats
    blend_joint: Ints
    blend_share: Floats
    names: tuple[str, ...]
    direction: Ints
    fit_error: Floats

    def __repr__(self) -> str:
        return f"Detail({len(self.names)} spheres)"

    def __post_init__(self) -> None:
        s = len(self.names)
        k = len(self.centre_basis)
        shapes: dict[str, tuple[type, tuple[int | None, ...]]] = {
            "segment": (np.int64, (s,)),
            "centre_mean": (np.float64, (s, 3)),
            "centre_basis": (np.float64, (k, s, 3)),
            "radius_mean": (np.float64, (s,)),
            "radius_basis": (np.float64, (k, s)),
            "blend_joint": (np.int64, (s,)),
            "blend_share": (np.float64, (s,)),
            "direction": (np.int64, (s,)),
            "fit_error": (np.float64, (None, 2)),
        }
        for field, (dtype, shape) in shapes.items():
            object.__setattr__(
                self, field, read_only(getattr(self, field), dtype, shape, f"basis.{field}")
            )


@dataclass(frozen=True, eq=False, repr=False)
class ShapeBasis:
    """A family of bodies with N segments and J joints, spanned by K coefficients of unit variance
    in the family.

    name: of the file; segments, joints: mnemonics in body order; joint_mean (J, 3), joint_basis (K,
    J, 3) and origin_mean (N, 3), origin_basis (K, N, 3): joints and segment origins in the world of
    the zero pose [m]; details: the spheres by level of detail; density (N,) [kg/m3]; anchor_names,
    anchors (A, K): the coefficients of known bodies of the family; anchor_spread (A, K, K): the
    covariance of the coefficients among people like each anchor; anchor_seated (A, 2): breadth and
    thickness of their hips and thighs on a seat as shares of those standing.
    """

    name: str
    segments: tuple[str, ...]
    joints: tuple[str, ...]
    joint_mean: Floats
    joint_basis: Floats
    origin_mean: Floats
    origin_basis: Floats
    details: dict[str, Detail]
    density: Floats
    anchor_names: tuple[str, ...]
    anchors: Floats
    anchor_spread: Floats
    anchor_seated: Floats

    def __len__(self) -> int:
        return len(self.joint_basis)

    def __repr__(self) -> str:
        return f"ShapeBasis({self.name}: {len(self)} coefficients, {', '.join(self.details)})"

    def __post_init__(self) -> None:
        n = len(self.segments)
        j = len(self.joints)
        k = len(self.joint_basis)
        a = len(self.anchor_names)
        shapes = {
            "joint_mean": (j, 3),
            "joint_basis": (k, j, 3),
            "origin_mean": (n, 3),
            "origin_basis": (k, n, 3),
            "density": (n,),
            "anchors": (a, k),
            "anchor_spread": (a, k, k),
            "anchor_seated": (a, 2),
        }
        for field, shape in shapes.items():
            object.__setattr__(
                self, field, read_only(getattr(self, field), np.float64, shape, f"basis.{field}")
            )
        for level, detail in self.details.items():
            if len(detail.centre_basis) != k:
                raise InputError(
                    f"basis {self.name}: {level} has {len(detail.centre_basis)} components, not {k}"
                )

    def detail(self, level: str) -> Detail:
        """The spheres of a level; InputError lists the valid ones."""
        if level not in self.details:
            raise InputError(
                f"basis {self.name}: no detail {level!r}; {one_of(level, self.details)}"
            )
        return self.details[level]

    def level(self, counts: Ints) -> str:
        """The level of detail with so many spheres in each segment (N,); "" where no level has."""
        for level, detail in self.details.items():
            if np.array_equal(np.bincount(detail.segment, minlength=len(self.segments)), counts):
                return level
        return ""

    def nearest_anchor(self, z: Floats) -> int:
        """The anchor that coefficients (K,) are nearest to."""
        return int(np.argmin(np.linalg.norm(self.anchors - z, axis=1)))


@lru_cache(maxsize=16)
def in_order(basis: ShapeBasis, segments: tuple[str, ...], joints: tuple[str, ...]) -> ShapeBasis:
    """The same basis with its segments and joints in the order of a body; the same noun for the
    same body order.

    InputError where the names are not those of the basis.
    """
    if (basis.segments, basis.joints) == (segments, joints):
        return basis
    if (sorted(basis.segments), sorted(basis.joints)) != (sorted(segments), sorted(joints)):
        raise InputError(f"{basis.name} is of other segments or joints than this body")
    seg = np.array([basis.segments.index(name) for name in segments])
    joint = np.array([basis.joints.index(name) for name in joints])
    return replace(
        basis,
        segments=segments,
        joints=joints,
        joint_mean=basis.joint_mean[joint],
        joint_basis=basis.joint_basis[:, joint],
        origin_mean=basis.origin_mean[seg],
        origin_basis=basis.origin_basis[:, seg],
        density=basis.density[seg],
        details={
            level: _detail_in_order(detail, seg, joint) for level, detail in basis.details.items()
        },
    )


def _detail_in_order(detail: Detail, seg: Ints, joint: Ints) -> Detail:
    """seg, joint: the old index of each new segment and joint."""
    segment = np.argsort(seg)[detail.segment]
    order = np.argsort(segment, kind="stable")
    blend = np.where(
        detail.blend_joint >= 0, np.argsort(joint)[np.maximum(detail.blend_joint, 0)], -1
    )
    return Detail(
        segment=segment[order],
        centre_mean=detail.centre_mean[order],
        centre_basis=detail.centre_basis[:, order],
        radius_mean=detail.radius_mean[order],
        radius_basis=detail.radius_basis[:, order],
        blend_joint=blend[order],
        blend_share=detail.blend_share[order],
        names=tuple(detail.names[i] for i in order),
        direction=detail.direction[order],
        fit_error=detail.fit_error[seg],
    )
