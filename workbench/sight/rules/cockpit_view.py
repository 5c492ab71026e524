"""The view from a cockpit by AC 25.773-1: what of the outline is clear to at least one eye, and what
hides the rest.

A direction is hidden where something opaque stands before each eye in it, be it two things. So it is
for what is far away. Half of it is then put down to each of the two.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.rule_set import RuleSet
from workbench.sight.eyes import Eyes
from workbench.sight.kernels.bands import Items
from workbench.sight.obscuration import lines_of_sight
from workbench.sight.panorama import Lookout, look_out, lookout
from workbench.sight.regions import Region, azimuth_elevation, direction_of, outline
from workbench.sight.rules.eye_points import SIGN, Side
from workbench.sight.scenery import Scenery

__all__ = [
    "COARSE",
    "ClearView",
    "CockpitView",
    "Hidden",
    "clear_view",
    "cockpit_outline",
    "cockpit_view",
]

STEP = np.radians(0.25)
"""Spacing [rad] of the directions that are asked about."""
COARSE = np.radians(0.75)
"""The same where it is only asked whether more may be clear than asked for: a ninth of the pixels."""
_FAR = 1e4
"""Distance [m] of what is looked for: eyes 65 mm apart look at it in one direction within 0.0004
degrees."""
_HALVINGS = 12
"""Halvings of a step in which an edge is found: to 0.0001 degrees."""


@dataclass(frozen=True)
class Hidden:
    """A patch or a strip that both eyes miss: its size [rad], its middle in azimuth to the left and
    elevation [rad], and what the eyes meet there: of a strip most of it."""

    size: float
    azimuth: float
    elevation: float
    name: str


@dataclass(frozen=True, eq=False)
class CockpitView:
    """What two eyes see of an outline.

    clear: share of its solid angle that one eye at least sees. hidden [sr]: by what hides it.
    hole: the widest round patch inside the outline that is hidden, its size is the diameter, within
    two steps; None where nothing is. posts: strips hidden along elevation 0, from left to right, their size is the
    width. over_nose [rad]: how far down the view at azimuth 0 goes on from elevation 0 without a
    gap, negative where elevation 0 is hidden and the view begins above it; None where it is hidden
    all the way up.
    """

    clear: float
    hidden: dict[str, float]
    hole: Hidden | None
    posts: tuple[Hidden, ...]
    over_nose: float | None


def cockpit_outline(rules: RuleSet, *, seat: Side, axes: Floats | None = None) -> Region:
    """Return the outline of a seat: that of the right is mirrored.

    axes (3, 3): forward, left and up of the aircraft as rows; the world's if None.
    """
    corners = rules.shaped("outline_left_seat", None, 2) * np.array(
        [-SIGN[seat], 1.0]
    )  # azimuth positive left
    return outline(f"outline of AC 25.773-1, {seat} seat", corners, axes)


def cockpit_view(
    scenery: Scenery, eyes: Eyes, region: Region, *, row: int = 0, step: float = STEP
) -> CockpitView:
    """Measure what the eyes of one person, or of a design eye point, see of an outline.

    Parameters
    ----------
    scenery
        What may hide something.
    eyes
        Of B people; eyes 0 m apart are one.
    region
        Of `cockpit_outline`.
    row
        Who of them, and whose scenery.
    step
        [rad] between directions, and width of the pixels: what is thinner may be missed. Posts and
        the view over the nose are refined from there.

    Raises
    ------
    InputError
        If an eye is inside a solid part or a sphere, or the region has no outline.
    """
    view = clear_view(scenery, eyes, region, row=row, step=step)
    lattice = _lattice(region, step)
    own = scenery.of_row(row)

    def blocker(azimuth: Floats, elevation: Floats) -> Ints:
        """What the eyes meet (2, M) at angles (M,), -1 where one of them meets nothing."""
        far = _FAR * direction_of(azimuth, elevation) @ region.axes
        met = np.concatenate(
            [
                lines_of_sight(own, eye[row : row + 1], (eye[row] + far)[None])
                for eye in (eyes.left, eyes.right)
            ]
        )
        return np.where((met >= 0).all(axis=0), met, -1)

    across = _runs(
        lambda at: blocker(-at, 0.0 * at), -region.corners[:, 0].max(), -region.corners[:, 0].min()
    )
    upward = _runs(lambda at: blocker(0.0 * at, at), -np.pi / 2, np.pi / 2)
    top = max((run.end for run in upward if run.begin <= 0.0), default=-np.pi / 2)
    return CockpitView(
        clear=view.clear,
        hidden=view.hidden,
        hole=_hole(view.items, lattice, scenery.names, region=region),
        posts=tuple(
            Hidden(run.end - run.begin, -(run.begin + run.end) / 2, 0.0, scenery.names[run.item])
            for run in across
        ),
        over_nose=None if top >= np.pi / 2 else -top,
    )


@dataclass(frozen=True, eq=False)
class ClearView:
    """What of an outline is clear.

    clear: share of its solid angle that one eye at least sees. most: the same at a fine step at most,
    as far as patches are not thinner than a step: as if all that is hidden beside a border were clear.
    hidden [sr]: by what hides it. items (2, M, N): what each eye meets in the directions of the
    lattice, -1 for nothing.
    """

    clear: float
    most: float
    hidden: dict[str, float]
    items: Items


def clear_view(
    scenery: Scenery, eyes: Eyes, region: Region, *, row: int = 0, step: float = STEP
) -> ClearView:
    """Measure how much of an outline is clear, as `cockpit_view` does, and nothing else."""
    lattice = _lattice(region, step)
    items = np.stack(
        [look_out(scenery, eye[row], lattice.view, row=row)[0] for eye in (eyes.left, eyes.right)]
    )
    hidden = np.all(items >= 0, axis=0)
    border = np.zeros_like(hidden)
    for axis in (1, 2):
        changes = np.diff(items, axis=axis).any(axis=0)
        before = [slice(None)] * 2
        after = [slice(None)] * 2
        before[axis - 1] = slice(None, -1)
        after[axis - 1] = slice(1, None)
        border[tuple(before)] |= changes
        border[tuple(after)] |= changes
    hides: Bools = hidden[lattice.inside]
    inner: Bools = hides & ~border[lattice.inside]
    halves = np.tile(0.5 * lattice.weight[hides], 2)
    met = items[:, lattice.inside][:, hides]
    by_item = np.bincount(met.ravel(), halves, len(scenery.names))
    return ClearView(
        clear=1.0 - float(lattice.weight[hides].sum()) / region.solid_angle,
        most=1.0 - float(lattice.weight[inner].sum()) / region.solid_angle,
        hidden={scenery.names[k]: float(by_item[k]) for k in np.flatnonzero(by_item)},
        items=items,
    )


class _Lattice(NamedTuple):
    """Directions in equal steps of azimuth and elevation over an outline and a little beyond."""

    ways: Floats
    """(M, N, 3)."""
    inside: Bools
    """(M, N) whether they are in the outline, K of them."""
    weight: Floats
    """(K,) [sr]: with cos(elevation), and the outline's own solid angle in all."""
    view: Lookout


@lru_cache(maxsize=8)
def _lattice(region: Region, step: float) -> _Lattice:
    """The lattice of an outline; InputError where the region has none."""
    if not len(region.corners):
        raise InputError(f"{region.name}: an outline of azimuths and elevations is needed")
    return _known_lattice(region.corners.tobytes(), region.axes.tobytes(), step)


@lru_cache(maxsize=4)
def _known_lattice(corners: bytes, axes: bytes, step: float) -> _Lattice:
    """The lattice of an outline, once for all that are alike."""
    region = outline(
        "outline", np.frombuffer(corners).reshape(-1, 2), np.frombuffer(axes).reshape(3, 3)
    )
    low = region.corners.min(axis=0) - 1.5 * step
    high = region.corners.max(axis=0) + 1.5 * step
    azimuth, elevation = np.meshgrid(*(np.arange(low[k], high[k], step) for k in range(2)))
    ways = direction_of(azimuth, elevation) @ region.axes
    inside = region.contains(ways)
    weight = np.cos(elevation[inside])
    share = region.solid_angle / weight.sum()
    return _Lattice(ways, inside, weight * share, lookout(ways, step))


class _Run(NamedTuple):
    """A strip that is hidden from one angle [rad] to another, and what hides most of it."""

    begin: float
    end: float
    item: int


def _runs(blocker: Callable[[Floats], Ints], low: float, high: float) -> list[_Run]:
    """The strips hidden between two angles, their edges found by halving."""
    at = np.linspace(low, high, math.ceil((high - low) / STEP) + 1)
    item = blocker(at)
    hides = item[0] >= 0
    change = np.flatnonzero(hides[1:] != hides[:-1])
    before = at[change]
    after = at[change + 1]
    for _ in range(_HALVINGS if len(change) else 0):
        half = 0.5 * (before + after)
        alike = (blocker(half)[0] >= 0) == hides[change]
        before = np.where(alike, half, before)
        after = np.where(alike, after, half)
    ends = [low] * bool(hides[0]) + (0.5 * (before + after)).tolist() + [high] * bool(hides[-1])
    found = []
    for begin, end in zip(ends[::2], ends[1::2], strict=True):
        within = item[:, (at >= begin) & (at <= end) & hides]
        found.append(_Run(begin, end, int(np.bincount(within.ravel()).argmax())))
    return found


def _hole(
    items: Items, lattice: _Lattice, names: tuple[str, ...], *, region: Region
) -> Hidden | None:
    """The widest cone about a hidden direction inside an outline that holds no other.

    items (2, M, N): of `ClearView`.
    """
    hidden = lattice.inside & np.all(items >= 0, axis=0)
    if not hidden.any():
        return None
    from scipy.spatial import cKDTree

    # the nearest direction that is seen or outside is beside a hidden one
    beside = np.zeros_like(hidden)
    for axis in (0, 1):
        beside |= np.roll(hidden, 1, axis) | np.roll(hidden, -1, axis)
    tree = cKDTree(lattice.ways[beside & ~hidden])
    chord = np.asarray(tree.query(lattice.ways[hidden])[0])
    widest = np.argmax(chord)
    way = lattice.ways[hidden][widest]
    angles = azimuth_elevation(way, region.axes)
    met = sorted({names[int(one[hidden][widest])] for one in items})
    # a chord c is the angle 2 asin(c / 2)
    size = 4.0 * math.asin(0.5 * float(chord.max()))
    return Hidden(size, float(angles[0]), float(angles[1]), " and ".join(met))
