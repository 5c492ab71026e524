"""Four numbers of double precision at a time: compiled they do what their definitions say."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from workbench.geometry import simd4

numbers = st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4)


@given(numbers, numbers)
def test_the_fours_do_compiled_what_their_definitions_say(a, b):
    from tests.lanes_compiled import every_quad_function

    a = np.array(a)
    b = np.array(b)
    out = np.zeros((12, 3))
    told = every_quad_function(a, b, out)
    wanted = [a + b, a - b, a * b, simd4.lower(a, b), simd4.upper(a, b), simd4.splat4(a[2])]
    assert np.array_equal(out[:4], np.stack(wanted[:3], axis=1))
    assert np.array_equal(out[4:8], np.stack(wanted[3:], axis=1))
    others = [simd4.divided(a, b), simd4.where_positive(a, b), np.full(4, simd4.least_of(a))]
    assert np.array_equal(out[8:], np.stack(others, axis=1), equal_nan=True)
    assert told == (simd4.first_of(b), simd4.below(a, b))


def test_points_are_written_one_after_the_other():
    out = np.zeros((4, 3))
    simd4.store_triples(out, 0, np.arange(4.0), np.arange(4.0) + 10, np.arange(4.0) + 20)
    assert out.tolist() == [[0, 10, 20], [1, 11, 21], [2, 12, 22], [3, 13, 23]]
