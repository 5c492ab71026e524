"""Crash signals against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench import InputError, UsageError
from workbench.motion.signals import (
    GRAVITY,
    acceleration,
    cfc_filter,
    evenly,
    hic,
    sustained_level,
    velocity,
)

SHAPES = {
    "square": (lambda u: np.ones_like(u), 1.0),
    "half sine": (lambda u: np.sin(np.pi * u), 0.4146),
    "triangle": (lambda u: 1 - np.abs(2 * u - 1), 0.2464),
}


def pulse(shape, peak, length, samples=4001):
    time = np.linspace(0, length, samples)
    return time, peak * GRAVITY * SHAPES[shape][0](time / length)


@pytest.mark.parametrize("shape", SHAPES)
def test_hic_of_a_whole_pulse_is_its_closed_form(shape):
    """c A^2.5 T with A = 100 g, T = 10 ms."""
    assert hic(*pulse(shape, 100, 0.01), window=1).value == pytest.approx(
        SHAPES[shape][1] * 1000, rel=3e-4
    )


def test_hic_of_a_long_half_sine_depends_on_the_window():
    """60 g, 40 ms: HIC15 361.4, HIC36 462.5."""
    assert hic(*pulse("half sine", 60, 0.04), window=0.015).value == pytest.approx(361.4, abs=0.1)
    assert hic(*pulse("half sine", 60, 0.04), window=0.036).value == pytest.approx(462.5, abs=0.1)


@pytest.mark.parametrize(
    ("peak", "length", "hic15", "hic36"), [(100, 0.01, 414.5, 414.5), (80, 0.02, 434.9, 474.7)]
)
def test_the_longest_window_is_not_the_best(peak, length, hic15, hic36):
    """A half sine in the middle of 100 ms of rest: the window that counts is shorter than 36 ms."""
    time = np.linspace(0, 0.1, 10001)
    level = np.where(
        (time >= 0.04) & (time <= 0.04 + length),
        peak * GRAVITY * np.sin(np.pi * (time - 0.04) / length),
        0,
    )
    found = hic(time, level, window=0.036)
    assert found.value == pytest.approx(hic36, rel=2e-3)
    assert found.end - found.start == pytest.approx(0.67 * length, rel=0.02)
    del hic15


def test_hic_equals_every_pair_tried():
    rng = np.random.default_rng(1)
    time = np.arange(60) * 1e-3
    level = np.abs(rng.normal(0, 300, 60))
    total = np.concatenate([[0], np.cumsum(0.5 * (level[1:] + level[:-1])) * 1e-3]) / GRAVITY
    pairs = [
        (j - i) * 1e-3 * ((total[j] - total[i]) / ((j - i) * 1e-3)) ** 2.5
        for i in range(60)
        for j in range(i + 1, min(60, i + 16))
    ]
    assert hic(time, level, window=0.015).value == pytest.approx(max(pairs))


def test_the_3_ms_level_of_a_half_sine_is_its_height_1_5_ms_from_the_peak():
    time, level = pulse("half sine", 60, 0.04)
    assert sustained_level(time, level) / GRAVITY == pytest.approx(
        60 * np.cos(np.pi * 0.0015 / 0.04), rel=1e-9
    )


@given(st.floats(1, 200), st.floats(-50, 50))
def test_a_constant_level_is_held(level, shift):
    assert sustained_level(np.linspace(0, 0.01, 11), np.full(11, level) + shift) == pytest.approx(
        level + shift
    )


def test_free_fall_is_one_g():
    time = np.arange(101) * 1e-3
    fall = np.stack([time, 0 * time, -0.5 * GRAVITY * time**2], axis=-1)
    assert acceleration(time, fall) == pytest.approx(np.tile([0, 0, -GRAVITY], (101, 1)), abs=1e-6)
    assert velocity(time, fall)[:, 2] == pytest.approx(-GRAVITY * time, abs=1e-9)


@pytest.mark.parametrize("cfc", [60, 180, 600, 1000])
def test_a_filter_class_passes_low_tones_and_is_down_3_db_where_j211_says(cfc):
    """SAE J211: 3 dB down near 1.65 CFC, 0.5 dB at most at CFC / 2; a constant stays."""
    time = np.arange(40001) / 20000
    for tone, low, high in (
        (0.1 * cfc, 0.99, 1.001),
        (1.65 * cfc, 0.66, 0.76),
        (6 * cfc, 0.0, 0.03),
    ):
        passed = cfc_filter(time, np.sin(2 * np.pi * tone * time), cfc=cfc)[10000:30000]
        assert low <= np.sqrt(2 * np.mean(passed**2)) <= high
    assert cfc_filter(time, np.full(len(time), 3.0), cfc=cfc) == pytest.approx(3.0)


def test_hic_of_uneven_samples_is_that_of_every_pair_of_them():
    """Samples 0.2 to 1.8 ms apart: no window begins or ends between them."""
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.uniform(2e-4, 1.8e-3, 60))
    level = np.abs(rng.normal(0, 300, 60))
    area = np.concatenate([[0], np.cumsum(0.5 * (level[1:] + level[:-1]) * np.diff(time))])
    best, start, end = max(
        (span * ((area[j] - area[i]) / GRAVITY / span) ** 2.5, time[i], time[j])
        for i in range(60)
        for j in range(i + 1, 60)
        if (span := time[j] - time[i]) <= 0.015
    )
    found = hic(time, level, window=0.015)
    assert (found.value, found.start, found.end) == pytest.approx((best, start, end), rel=1e-12)


def test_free_fall_is_one_g_at_uneven_times():
    time = np.cumsum(np.random.default_rng(3).uniform(2e-4, 1.8e-3, 60))
    fall = np.stack([0 * time, 0 * time, -0.5 * GRAVITY * time**2], axis=-1)
    assert acceleration(time, fall)[:, 2] == pytest.approx(-GRAVITY, abs=1e-6)


def test_uneven_samples_are_made_even():
    time, values = evenly(np.array([0, 1.0, 2.0, 3.5, 4.0]), np.array([0, 1.0, 2.0, 3.5, 4.0]))
    assert time.tolist() == values.tolist() == [0, 1, 2, 3, 4]


def test_what_a_signal_cannot_give_is_refused():
    time = np.arange(100) / 100
    with pytest.raises(
        UsageError,
        match="cfc 60 needs 600 samples a second, the signal has 100; it can carry no class",
    ):
        cfc_filter(time, time, cfc=60)
    with pytest.raises(UsageError, match="the classes are 60"):
        cfc_filter(time, time, cfc=100)
    with pytest.raises(InputError, match="3 or more"):
        acceleration(time[:2], np.zeros((2, 3)))
    with pytest.raises(InputError, match="3 or more"):
        evenly(time[:2], time[:2])
    with pytest.raises(InputError, match="3 or more"):
        hic(time[:1], time[:1], window=0.015)
    with pytest.raises(InputError, match="cannot hold"):
        sustained_level(np.array([0, 0.001]), np.array([1.0, 1.0]))
    with pytest.raises(UsageError):
        hic(time, time, window=0)
