"""Choose candidate spheres: large ones inside a surface, with a bounded protrusion.

A sphere of radius r = d(c) + outward, with the exact depth d(c) of its centre, leaves the surface
by no more than `outward`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.fitting.regions import Regions
from workbench.body.kernels.poisson_disk import sample_poisson_disk
from workbench.body.surface import Surface
from workbench.errors import UsageError
from workbench.geometry.nearest import medial_balls, morton_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "LONGEST",
    "SHORTEST",
    "Candidates",
    "FitBounds",
    "Samples",
    "bounded_radius",
    "even_samples",
    "inner_balls",
    "joined_candidates",
    "random_samples",
]

SHORTEST = 1e-5
LONGEST = 10.0
"""Range [m] of radii and tolerances."""
_RETREATS = 8
"""Steps at most by which a centre leaves another segment's part."""
_RETREAT = 0.7
"""Factor on the depth of a centre in each of these steps."""


@dataclass(frozen=True)
class FitBounds:
    """Bounds of radii and tolerances [m]."""

    least: float
    """Least radius."""
    greatest: float
    """Greatest radius."""
    outward: float
    """How far spheres may leave the surface."""
    inward: float
    """How far the surface may lie outside the spheres."""

    @classmethod
    def checked(
        cls, *, least_radius: float, greatest_radius: float, outward: float, inward: float
    ) -> FitBounds:
        """Check and take given lengths [m].

        Raises
        ------
        UsageError
            If a length is out of SHORTEST to LONGEST, or the least radius exceeds the greatest.
        """
        given = {
            "least_radius": least_radius,
            "greatest_radius": greatest_radius,
            "outward": outward,
            "inward": inward,
        }
        for name, value in given.items():
            if not SHORTEST <= value <= LONGEST:
                raise UsageError(
                    f"{name}: expected a length of {SHORTEST:g} to {LONGEST:g} m, got {value:g}"
                )
        if least_radius > greatest_radius:
            raise UsageError(
                f"least_radius ({least_radius:g} m) is greater than greatest_radius ({greatest_radius:g} m)"
            )
        return cls(least_radius, greatest_radius, outward, inward)

    def scaled(self, factor: float) -> FitBounds:
        """Return the limits with both tolerances multiplied."""
        return FitBounds(self.least, self.greatest, self.outward * factor, self.inward * factor)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidate spheres without their radii, which depend on the limits."""

    centre: Floats
    """(m, 3) [m]."""
    depth: Floats
    """(m,) depth of the centres under the surface [m]."""
    bits: Ints
    """(m,) bits of the segments to which they belong."""

    def __len__(self) -> int:
        return len(self.depth)

    def at(self, index: Ints | Bools) -> Candidates:
        """Return some of the candidates."""
        return Candidates(self.centre[index], self.depth[index], self.bits[index])


def bounded_radius(depth: Floats, limits: FitBounds) -> Floats:
    """Return the radii (m,) [m] that use up the outward tolerance, of centres at depths (m,) [m].

    The radius is 0 where the least radius would protrude by more than the tolerance.
    """
    radius = np.minimum(depth + limits.outward, limits.greatest)
    return np.where(radius >= limits.least, radius, 0.0)


def inner_balls(
    surface: Surface,
    samples: Samples,
    limits: FitBounds,
    *,
    slack: Floats,
    bits: Ints,
    regions: Regions,
) -> Candidates:
    """Find a candidate under each of n samples.

    A ball that touches the surface at the sample shrinks from the greatest radius until the surface is
    at most `slack` deep in it. Its centre lies no deeper than about the bones of its segment, and not
    far inside another segment's part, since it would leave its place when the joint turns.

    Parameters
    ----------
    surface, samples, limits
        The surface, samples of it, and the bounds of the spheres.
    slack
        (n,) [m].
    bits
        (n,) the segment that each candidate serves, as a bit.
    regions
        The parts of the segments.
    """
    order = morton_order(samples.point)
    point = samples.point[order]
    normal = samples.normal[order]
    bits = bits[order]
    slack = slack[order]
    centre = np.empty((len(order), 3))
    start = np.full(len(order), max(limits.greatest - limits.outward, limits.least))
    start = np.minimum(start, np.maximum(regions.reach(point, bits), limits.least))
    medial_balls(point, normal, start, slack, surface.solid, centre)
    for _ in range(_RETREATS):
        away = regions.foreign(centre, bits)
        if not away.any():
            break
        centre[away] = point[away] + _RETREAT * (centre[away] - point[away])
    # whole nanometres: the greedy choice among them must not hang on the last digits
    centre = np.round(centre, 9)
    return Candidates(centre, np.round(-surface.distance(centre), 9), bits)


def joined_candidates(parts: list[Candidates]) -> Candidates:
    """Concatenate lists of candidates."""
    return Candidates(
        np.concatenate([p.centre for p in parts]),
        np.concatenate([p.depth for p in parts]),
        np.concatenate([p.bits for p in parts]),
    )


_DARTS = 4.0
"""Random points for each one that is kept; 4 leave no hole wider than about 1.3 spacings (measured)."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n points on a surface."""

    point: Floats
    """(n, 3) [m]."""
    normal: Floats
    """(n, 3) outward unit normals, smoothed over the faces."""
    face: Ints
    """(n,) number of the face."""

    def __len__(self) -> int:
        return len(self.face)

    def at(self, index: Ints) -> Samples:
        """Return some of the samples."""
        return Samples(self.point[index], self.normal[index], self.face[index])


def random_samples(surface: Surface, count: int, *, seed: int = 0) -> Samples:
    """Return points that are uniform over the area: one at random in each of `count` equal shares of it."""
    rng = np.random.default_rng(seed)
    corner = surface.vertices[surface.faces]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(cross, axis=1)
    edge = np.cumsum(area)
    at = (np.arange(count) + rng.random(count)) / count * edge[-1]
    face = np.minimum(np.searchsorted(edge, at), len(area) - 1)
    return _on_faces(surface, face, rng.random((2, count)))


def even_samples(surface: Surface, spacing: float, *, seed: int = 0) -> Samples:
    """Return points no two of which are nearer than `spacing` [m], with no room for many more.

    This is dart throwing (Poisson-disk sampling). Near points are together.
    """
    count = max(64, int(_DARTS * 0.7 * surface.area / spacing**2))
    darts = random_samples(surface, count, seed=seed)
    shuffled = darts.at(np.random.default_rng(seed + 1).permutation(count))
    kept = shuffled.at(sample_poisson_disk(shuffled.point, spacing))
    return kept.at(morton_order(kept.point))


def _on_faces(surface: Surface, face: Ints, uniform: Floats) -> Samples:
    """Points at random places (2, n) of faces (n,).

    Weights (1 - sqrt u, sqrt u (1 - v), v sqrt u) are uniform over a triangle.
    """
    root = np.sqrt(uniform[0])
    weight = np.stack([1 - root, root * (1 - uniform[1]), root * uniform[1]], axis=1)
    point = np.einsum("nk,nkc->nc", weight, surface.vertices[surface.faces[face]])
    normal = np.einsum("nk,nkc->nc", weight, corner_normals(surface)[surface.faces[face]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    return Samples(point, normal, face)


def corner_normals(surface: Surface) -> Floats:
    """Return unit normals (V, 3) at the vertices: means over the faces, weighted by their angles there."""
    solid = surface.solid
    normal = np.zeros_like(surface.vertices)
    for k in range(3):
        normal[surface.faces[solid.face, k]] = solid.normal[:, 1 + k]
    return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
