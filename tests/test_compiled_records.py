"""Tuples of arrays mean the same to compiled functions as to Python, and are passed by reference."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

import workbench as wb
from workbench.compiled import inner, njit
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.packing import packed_limbs, packed_links
from workbench.posture.seating.posture import Pedals
from workbench.posture.seating.stepping import foot_tasks, legs_of


class Pair(NamedTuple):
    """Two arrays and a number."""

    left: NDArray[np.float64]
    right: NDArray[np.float64]
    number: float


class Nest(NamedTuple):
    """A pair in a tuple."""

    pair: Pair
    other: NDArray[np.float64]


@inner
def first_of(pair):
    return pair.left[0] + pair.number


@inner
def exchanged(pair):
    return Pair(pair.right, pair.left, pair.number + 1.0)


@inner
def nested_sum(nest, scale):
    return first_of(nest.pair) + scale * nest.other[0] + first_of(exchanged(nest.pair))


@inner
def exchange_often(a, b, times, out):
    """Pairs change their names in a loop, and an old one is looked at after a new one is made."""
    before = a
    for k in range(times):
        a, b = b, a
        if k == 1:
            before = exchanged(a)
        c = exchanged(b)
        a = c if k % 2 == 0 else Pair(c.left, b.right, c.number)
        out[k, 0] = first_of(a)
        out[k, 1] = first_of(b)
        out[k, 2] = first_of(before)
        out[k, 3] = nested_sum(Nest(a, b.right), 2.0)


@inner
def look_back(pairs, times, out):
    """What a loop made in one turn is read in the next, after it was made again."""
    made = pairs[1]
    for k in range(times):
        last = made
        made = exchanged(pairs[k % 2]) if k % 3 else pairs[0]
        out[k] = 10.0 * first_of(last) + first_of(made)


@inner
def grow(pair, times, out):
    """A pair is another one after each turn; a function returns it."""
    for _ in range(times):
        pair = exchanged(pair)
    out[0] = pair.number
    out[1] = pair.left[0]
    out[2] = pair.right[0]


def anew(function):
    """The same kernel, not read from what was compiled before."""
    return njit(_nrt=False)(function.py_func)


def pairs():
    return (
        Pair(np.array([1.0, 2.0]), np.array([30.0]), 0.5),
        Pair(np.array([4.0]), np.array([70.0, 1.0]), 0.25),
    )


def test_pairs_that_change_names_in_a_loop_are_those_of_python():
    a, b = pairs()
    out = np.zeros((7, 4)), np.zeros((7, 4))
    exchange_often(a, b, 7, out[0])
    exchange_often.py_func(a, b, 7, out[1])
    assert np.array_equal(*out)


def test_a_pair_is_not_changed_by_what_takes_its_place_in_a_loop():
    out = np.zeros(9), np.zeros(9)
    look_back(pairs(), 9, out[0])
    look_back.py_func(pairs(), 9, out[1])
    assert np.array_equal(*out)


@pytest.mark.parametrize("times", [0, 1, 4])
def test_a_pair_is_returned_as_python_returns_it(times):
    out = np.zeros(3), np.zeros(3)
    grow(pairs()[0], times, out[0])
    grow.py_func(pairs()[0], times, out[1])
    assert np.array_equal(*out)


def test_a_tuple_of_arrays_is_one_argument_of_a_compiled_function():
    """Beside it there are where the answer goes and where an exception goes."""
    anew(nested_sum)(Nest(pairs()[0], np.ones(3)), 2.0)
    (made,) = first_of.inner.overloads.values()
    function = made.library.get_function(made.fndesc.llvm_func_name)
    assert len(list(function.arguments)) == 3


def test_a_function_for_compiled_callers_is_kept_without_wrappers_and_without_callees():
    anew(nested_sum)(Nest(pairs()[0], np.ones(3)), 2.0)
    (made,) = exchanged.inner.overloads.values()
    assert len(list(made.library.get_defined_functions())) == 1


@pytest.fixture(scope="module")
def sizes(bubbleman):
    """The body by itself, and two sizes of it."""
    return bubbleman, wb.stack_bodies([wb.scale(bubbleman, {"stature": h}) for h in (1.6, 1.9)])


def one_kind(packed):
    """Whether kernels are compiled once for all of these; a row apart is another kind of array."""
    kinds = {str(numba.typeof(each)).replace("readonly ", "") for each in packed}
    assert all(", A)" not in kind and ", F)" not in kind for kind in kinds)
    return len(kinds) == 1


def test_limbs_of_one_body_and_of_many_are_packed_alike(sizes):
    limbs = [packed_limbs(body, limb(body, "left hand")) for body in sizes]
    assert one_kind(limbs)
    assert one_kind([packed_links(body, limb(body, "left hand")) for body in sizes])


def test_legs_of_one_body_and_of_many_are_packed_alike(sizes):
    pedals = Pedals({"left foot": (0.8, 0.1, 0.1), "right foot": (0.8, -0.1, 0.1)}, floor=0.0)
    ahead = np.array([1.0, 0.0, 0.0])
    legs = []
    for body in sizes:
        poses = wb.join_poses([wb.pose(row, {}, reference="LT") for row in body])
        legs.append(legs_of(foot_tasks(body, poses, pedals, ahead), pedals))
    assert one_kind(legs)
