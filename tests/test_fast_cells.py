"""Cells of 16 bits a corner: bounds that hold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.lanes_compiled import cell_mix
from tests.test_fast import ZOO
from workbench.contact.distance_fields import build_distance_field, packed_faces, packed_shells
from workbench.contact.kernels.distance_field import square_bound
from workbench.contact.kernels.point_in_solid import inside_part
from workbench.geometry import simd8

part = st.floats(0, 1, width=32)


@given(st.lists(st.integers(0, 65535), min_size=8, max_size=8), part, part, part)
def test_codes_and_corner_weights_are_compiled_as_defined(values, r, s, t):
    short = np.array(values, dtype=np.uint16)
    out = np.zeros(16, dtype=np.float32)
    mix = cell_mix(short, r, s, t, out)
    assert np.array_equal(out[:8], simd8.codes(short, 0))
    assert np.allclose(out[8:], simd8.corners(r, s, t), rtol=3e-7, atol=1e-12)
    assert out[8:].sum() == pytest.approx(1.0, abs=1e-6)
    assert mix == pytest.approx(
        float(np.dot(out[:8].astype(float), out[8:].astype(float))), rel=1e-6
    )


def test_a_code_is_a_number_of_five_bits_of_exponent_and_eleven_of_mantissa():
    # exponent 3 and mantissa 1 + 1024 / 2048: 1.5 * 2^(3 - 127)
    short = np.full(8, (3 << 11) | 1024, dtype=np.uint16)
    assert simd8.codes(short, 0)[0] == np.float32(1.5 * 2.0**-124)


@pytest.mark.parametrize("kind", ZOO)
def test_what_is_sure_to_be_outside_all_solids_is(kind):
    environment = ZOO[kind](8)
    field = build_distance_field(environment, (tuple(range(len(environment.parts))),))
    faces = packed_faces(environment)
    shells = packed_shells(environment)
    stack = np.empty(64, dtype=np.int64)
    seen = 0
    for x in np.random.default_rng(1).uniform(-0.5, 0.5, (400, 3)):
        if any(inside_part(*x, faces, shells, k, stack) for k in range(len(environment.parts))):
            assert not square_bound(*x, field, 0)[1]
            seen += 1
    assert (seen > 0) == (kind in ("boxes", "needles", "pierced"))
