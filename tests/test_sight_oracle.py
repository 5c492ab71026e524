"""Sight against brute force: every ray against every triangle and sphere, by another formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

import workbench as wb
from tests.conftest import SHARED, real_input
from tests.test_sight import upright
from workbench.sight.eyes import eyes_of
from workbench.sight.obscuration import lines_of_sight
from workbench.sight.panorama import FACES, face_directions, panorama
from workbench.sight.scenery import enclosing_items, scenery_of

DEGREE = math.pi / 180.0
TIE = 1e-6
"""Distance [m] within which two surfaces are at one place, so that either may be named."""
WRONG = 5e-4
"""Largest share of rays that may find something else than brute force does: those that pass within
rounding of an edge."""


def triangle_hits(corners, eye, ways):
    """Distances (R, T) along rays to triangles, infinite where they miss: the plane is met first, then
    the point is inside by its barycentric coordinates in the plane."""
    a, one, two = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(one, two)
    g11, g12, g22 = (np.sum(p * q, axis=1) for p, q in ((one, one), (one, two), (two, two)))
    with np.errstate(all="ignore"):
        far = np.sum(normal * (a - eye), axis=1) / (ways @ normal.T)
        at = eye + far[..., None] * ways[:, None] - a
        p, q = np.sum(at * one, axis=2), np.sum(at * two, axis=2)
        v = (g22 * p - g12 * q) / (g11 * g22 - g12 * g12)
        w = (g11 * q - g12 * p) / (g11 * g22 - g12 * g12)
        hit = (v >= 0) & (w >= 0) & (v + w <= 1) & (far > 0)
    return np.where(hit, far, np.inf)


def sphere_hits(centre, radius, eye, ways):
    """Distances (R, S) along unit rays to spheres, infinite where they miss."""
    away = centre - eye
    along = ways @ away.T
    beside = np.linalg.norm(np.cross(ways[:, None], away[None]), axis=2)
    with np.errstate(invalid="ignore"):
        far = along - np.sqrt(radius**2 - beside**2)
        return np.where((beside <= radius) & (far > 0), far, np.inf)


def nearest(scenery, eye, ways, *, clear=False):
    """Distance (R, N) along unit rays to each item: opaque ones, or those that are looked through."""
    chosen = scenery.see_through[scenery.item] == clear
    found = np.full((len(ways), len(scenery.names)), np.inf)
    for k in range(0, len(ways), 64):
        hits = triangle_hits(scenery.corners(0)[chosen], eye, ways[k : k + 64])
        np.minimum.at(found[k : k + 64].T, scenery.item[chosen], hits.T)
    if not clear:
        hits = sphere_hits(scenery.centre[0], scenery.radius[0], eye, ways)
        np.minimum.at(found.T, scenery.sphere_item, hits.T)
    return found


def wrong(found, distance):
    """Which items (R,) are not the first of distances (R, N), nor as near."""
    first = distance.min(axis=1, initial=np.inf)
    own = np.where(found >= 0, distance[np.arange(len(found)), found], np.inf)
    return np.where(np.isinf(first), found >= 0, ~(own <= first + TIE))


def pixel_ways(view, count, random):
    """Unit directions through the middles of random pixels of a panorama."""
    n = view.item.shape[1]
    ways = np.stack([face_directions(view.axes, face, n) for face in range(len(FACES))])
    some = ways.reshape(-1, 3)[random.integers(0, 6 * n * n, count)]
    return some / np.linalg.norm(some, axis=1)[:, None]


def disagreement(scenery, eye, count, random):
    """Shares of rays that find something else than brute force: in a panorama, looked through, and of
    lines of sight to points at random distances."""
    view = panorama(scenery, eye, step=0.5 * DEGREE)
    ways = pixel_ways(view, count, random)
    opaque = nearest(scenery, eye, ways)
    clear = nearest(scenery, eye, ways, clear=True)
    before = np.where(clear < opaque.min(axis=1)[:, None] - TIE, clear, np.inf)
    far = random.uniform(0.05, 3.0, count)
    found = lines_of_sight(scenery, eye[None], eye + (far[:, None] * ways)[None])[0]
    reached = np.where(opaque < far[:, None] - 2e-6, opaque, np.inf)
    edge = np.abs(opaque - far[:, None]).min(axis=1) < 1e-5
    return (
        np.mean(wrong(view.look(ways), opaque)),
        np.mean(wrong(view.look_through(ways), before)),
        np.mean(wrong(found, reached) & ~edge),
    )


def free_eyes(scenery, around, spread, count, random):
    """Random eyes about a place that are inside nothing."""
    eyes = around + random.uniform(-1, 1, (20 * count, 3)) * spread
    return eyes[enclosing_items(scenery, eyes) < 0][:count]


def test_a_panorama_and_lines_of_sight_find_what_brute_force_finds(bubbleman):
    environment = wb.load_environment("trainer")
    placed = upright(bubbleman)
    move = environment.points["left_design_eye"] - eyes_of(placed).middle[0]
    placed = upright(bubbleman, at=move)
    scenery = scenery_of(environment, placed, {"other": upright(bubbleman, at=move - [0, 0.56, 0])})
    shares = disagreement(scenery, eyes_of(placed).left[0], 150, np.random.default_rng(3))
    assert max(shares) == 0.0


REAL = {
    "trainer": (lambda: wb.load_environment("trainer"), (0.02, 0.28, 1.05), 0.1),
    "compact_car": (lambda: wb.load_environment("compact_car"), (-0.1, 0.35, 0.9), 0.1),
    "grob": (lambda: wb.load_environment(SHARED.parent / "cases/grob/environment.yaml"), None, 0.1),
    "polaris": (lambda: mesh("polaris_ranger_ev/polaris.dae", up="z", forward="y"), None, 0.3),
    "suv": (lambda: mesh("gazebo_suv/suv.obj", length="50 mm", up="z", forward="x"), None, 0.3),
    "prius": (
        lambda: mesh("prius_cardemo/hybrid_body.obj", length="cm", up="z", forward="-y"),
        None,
        0.3,
    ),
}


def mesh(name, **options):
    """A real cockpit of a mesh."""
    return wb.environment_from_mesh(real_input(SHARED / "environments" / name), **options)


@pytest.mark.nightly
@pytest.mark.parametrize("name", REAL)
def test_real_cockpits_are_seen_as_brute_force_sees_them(name):
    load, around, spread = REAL[name]
    if name == "grob":
        real_input(SHARED.parent / "cases/grob/environment.yaml")
    environment = load()
    middle = environment.bounds.mean(axis=0) if around is None else np.array(around)
    scenery, random = scenery_of(environment), np.random.default_rng(5)
    rates = [
        disagreement(scenery, eye, 1000, random)
        for eye in free_eyes(scenery, middle, spread, 4, random)
    ]
    assert np.all(np.mean(rates, axis=0) <= WRONG)
