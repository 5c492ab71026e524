"""Kernels that call every function of eight lanes, for the tests."""

from __future__ import annotations

import numpy as np
from numba import njit

from workbench.contact.kernels.bounding_cylinders import cylinders_within
from workbench.contact.kernels.wide_bvh import boxes_within, point_lanes
from workbench.geometry.simd4 import (
    below,
    divided,
    first_of,
    least_of,
    load_four,
    lower,
    splat4,
    store_triples,
    upper,
    where_positive,
)
from workbench.geometry.simd8 import (
    codes,
    corners,
    greatest,
    horizontal_sum,
    how_many,
    larger,
    load,
    lowest_set_bit,
    not_above,
    root,
    splat8,
    store,
)


@njit
def every_lane_function(a, b, out):
    """Rows of eight into out; bits of a <= b, the first of those and how many."""
    u = load(a, 0)
    v = load(b, 0)
    zero = splat8(0.0)
    rows = (
        u + v,
        u - v,
        u * v,
        larger(u, v),
        root(larger(u, zero - u)),
        splat8(a[3]),
        splat8(greatest(v)),
    )
    at = 0
    for row in rows:
        store(out, at, row)
        at += 8
    below = not_above(u, v)
    return below, lowest_set_bit(below), how_many(below)


@njit
def every_quad_function(a, b, out):
    """Triples of fours of double precision into out; the first of b, and the bits of a < b."""
    u = load_four(a, np.uint64(0))
    v = load_four(b, np.uint64(0))
    store_triples(out, np.uint64(0), u + v, u - v, u * v)
    store_triples(out, np.uint64(12), lower(u, v), upper(u, v), splat4(a[2]))
    store_triples(out, np.uint64(24), divided(u, v), where_positive(u, v), splat4(least_of(u)))
    return first_of(v), below(u, v)


@njit
def cell_mix(short, r, s, t, out):
    """The eight codes and the weights of a point's corners into out (16,); the sum of their
    products."""
    values = codes(short, np.uint64(0))
    weights = corners(np.float32(r), np.float32(s), np.float32(t))
    store(out, np.uint64(0), values)
    store(out, np.uint64(8), weights)
    return horizontal_sum(values * weights)


@njit
def node_bounds(x, box, head, m, many, limit, gaps):
    """`boxes_within` and `cylinders_within` for a point (3,), as a search calls them."""
    bits = boxes_within(point_lanes(x[0], x[1], x[2]), box, m, many, limit, gaps)
    return bits & cylinders_within(x[0], x[1], x[2], head, m, limit, gaps)
