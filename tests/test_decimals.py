"""Numbers of drawings as text: those of str.format, but for halves and for zero's sign."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench import InputError
from workbench.draw.lines.svg import number_rows


@given(st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=9))
def test_rows_are_those_of_str_format(rows):
    values = np.array(rows)
    near = (
        np.abs((np.abs(values) * [10.0, 1000.0]) % 1.0 - 0.5) < 1e-3
    )  # halves, in one arithmetic or the other
    for text, row, half in zip(
        number_rows("M{:.1f},{:.3f}z", values), rows, near.any(axis=1), strict=True
    ):
        want = f"M{row[0]:.1f},{row[1]:.3f}z".replace("M-0.0,", "M0.0,").replace(
            ",-0.000z", ",0.000z"
        )
        assert half or text == want


def test_rows_by_hand():
    assert number_rows("{:.0f} {:.2f}", np.array([[-0.4, 0.005], [12.0, -7.1]])) == [
        "0 0.01",
        "12 -7.10",
    ]
    assert number_rows("<{:.1f}>", np.empty((0, 1))) == []


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e9])
def test_what_no_picture_can_hold_is_refused(wrong):
    with pytest.raises(InputError, match="finite coordinates below a billion pixels"):
        number_rows("{:.1f}", np.array([[wrong]]))
