"""Four numbers of double precision at a time: compiled they do what their definitions say."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from workbench.geometry import quads

numbers = st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4)


@given(numbers, numbers)
def test_the_fours_do_compiled_what_their_definitions_say(a, b):
    from tests.lanes_compiled import every_quad_function

    a = np.array(a)
    b = np.array(b)
    out = np.zeros((16, 3))
    single = np.zeros(6, dtype=np.float32)
    told = every_quad_function(a, b, out, single)
    wanted = [a + b, a - b, a * b, quads.lower(a, b), quads.upper(a, b), quads.four(a[2])]
    assert np.array_equal(out[:4], np.stack(wanted[:3], axis=1))
    assert np.array_equal(out[4:8], np.stack(wanted[3:], axis=1))
    assert np.array_equal(out[8:12], out[:4, ::-1])
    others = [quads.divided(a, b), quads.where_positive(a, b), np.full(4, quads.least_of(a))]
    assert np.array_equal(out[12:], np.stack(others, axis=1), equal_nan=True)
    assert np.array_equal(single, np.concatenate([[0], a, [0]]).astype(np.float32))
    assert told == (quads.greatest_of(a), quads.first_of(b), quads.below(a, b))


def test_points_are_written_one_after_the_other_and_read_so():
    out = np.zeros((4, 3))
    quads.store_triples(out, 0, np.arange(4.0), np.arange(4.0) + 10, np.arange(4.0) + 20)
    assert out.tolist() == [[0, 10, 20], [1, 11, 21], [2, 12, 22], [3, 13, 23]]
    x, y, z = quads.load_triples(out, 0)
    assert (x.tolist(), y.tolist(), z.tolist()) == (
        [0, 1, 2, 3],
        [10, 11, 12, 13],
        [20, 21, 22, 23],
    )
