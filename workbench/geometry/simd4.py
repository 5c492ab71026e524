"""Four numbers of double precision at a time, as `lanes` takes eight of single precision.

Compiled, four numbers are one register, and +, - and * work on all of them. Not compiled they are
an array (4,), and the functions below say what is meant. Products and sums are rounded one by one,
as everywhere: so the digits are those of a loop by ones, on every machine.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import models, register_model

from workbench.geometry.simd8 import LaneType, compiles

__all__ = [
    "FOUR",
    "below",
    "divided",
    "first_of",
    "least_of",
    "load_four",
    "lower",
    "splat4",
    "store_triples",
    "upper",
    "where_positive",
]

FOUR = 4


def load_four(array, at):  # type: ignore[no-untyped-def]
    """The four numbers of an array, all its numbers in order, that begin at place `at`."""
    return array.reshape(-1)[at : at + FOUR].copy()


def least_of(a):  # type: ignore[no-untyped-def]
    """The least of four numbers, none of them NaN."""
    return a.min()


def below(a, b):  # type: ignore[no-untyped-def]
    """Bit k is set where a < b in place k."""
    return np.uint64(np.packbits(a < b, bitorder="little")[0])


def divided(a, b):  # type: ignore[no-untyped-def]
    """Each of four numbers divided; infinity or NaN where by zero."""
    with np.errstate(all="ignore"):
        return a / b


def where_positive(a, one):  # type: ignore[no-untyped-def]
    """The numbers of `one` where a > 0, else 0."""
    return np.where(a > 0.0, one, 0.0)


def lower(a, b):  # type: ignore[no-untyped-def]
    """The lesser of each of four numbers."""
    return np.minimum(a, b)


def upper(a, b):  # type: ignore[no-untyped-def]
    """The greater of each of four numbers."""
    return np.maximum(a, b)


def store_triples(array, at, x, y, z):  # type: ignore[no-untyped-def]
    """Write x, y, z of the first, then of the second and so on into an array, all its numbers in
    order, from place `at` on: twelve numbers."""
    array.reshape(-1)[at : at + 3 * FOUR] = np.stack([x, y, z], axis=1).reshape(-1)


def splat4(value):  # type: ignore[no-untyped-def]
    """The same number four times."""
    return np.full(FOUR, value, dtype=np.float64)


def first_of(a):  # type: ignore[no-untyped-def]
    """The first of four numbers."""
    return a[0]


class _FourType(LaneType):
    def __init__(self) -> None:
        super().__init__(name="Four")


_KIND = _FourType()
_VECTOR = ir.VectorType(ir.DoubleType(), FOUR)
_INDEX = ir.IntType(32)


@register_model(_FourType)
class _FourModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _VECTOR)


def _at(builder: Any, array: Any, at: Any, many: int) -> Any:
    return builder.bitcast(
        builder.gep(array.data, [at]), ir.VectorType(ir.DoubleType(), many).as_pointer()
    )


def _mixed(builder: Any, one: Any, other: Any, places: list[int]) -> Any:
    return builder.shuffle_vector(
        one, other, ir.Constant(ir.VectorType(_INDEX, len(places)), places)
    )


def _spread(builder: Any, value: Any) -> Any:
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, ir.Constant(_INDEX, 0))
    return _mixed(builder, one, ir.Constant(_VECTOR, ir.Undefined), [0] * FOUR)


def _triples(builder: Any, array: Any, at: Any, *axes: Any) -> Any:
    x, y, z = axes
    xy = _mixed(builder, x, y, [0, 4, 1, 5, 2, 6, 3, 7])
    zz = _mixed(builder, z, z, [0, 1, 2, 3, 0, 1, 2, 3])
    all_three = _mixed(builder, xy, zz, [0, 1, 8, 2, 3, 9, 4, 5, 10, 6, 7, 11])
    builder.store(all_three, _at(builder, array, at, 3 * FOUR), align=8)
    return ir.Constant(ir.IntType(8).as_pointer(), None)


def _least(builder: Any, value: Any) -> Any:
    for places in ([2, 3, 0, 1], [1, 0, 3, 2]):
        other = _mixed(builder, value, value, places)
        value = builder.select(builder.fcmp_ordered("<", value, other), value, other)
    return builder.extract_element(value, ir.Constant(_INDEX, 0))


def _below(builder: Any, a: Any, b: Any) -> Any:
    bits = builder.bitcast(builder.fcmp_ordered("<", a, b), ir.IntType(FOUR))
    return builder.zext(bits, ir.IntType(64))


def _where_positive(builder: Any, a: Any, one: Any) -> Any:
    none = ir.Constant(_VECTOR, [0.0] * FOUR)
    return builder.select(builder.fcmp_ordered(">", a, none), one, none)


_TWO = (_KIND, _KIND)
compiles(least_of, (_KIND,), types.float64, _least)
compiles(below, _TWO, types.uint64, _below)
compiles(divided, _TWO, _KIND, lambda b, x, y: b.fdiv(x, y))
compiles(where_positive, _TWO, _KIND, _where_positive)
compiles(lower, _TWO, _KIND, lambda b, x, y: b.select(b.fcmp_ordered("<", x, y), x, y))
compiles(upper, _TWO, _KIND, lambda b, x, y: b.select(b.fcmp_ordered(">", x, y), x, y))
compiles(
    load_four,
    (types.Array, types.uint64),
    _KIND,
    lambda b, a, at: b.load(_at(b, a, at, FOUR), align=8),
)
compiles(store_triples, (types.Array, types.uint64, _KIND, _KIND, _KIND), types.none, _triples)
compiles(splat4, (types.float64,), _KIND, _spread)
compiles(
    first_of, (_KIND,), types.float64, lambda b, x: b.extract_element(x, ir.Constant(_INDEX, 0))
)
compiles(operator.add, _TWO, _KIND, lambda b, x, y: b.fadd(x, y))
compiles(operator.sub, _TWO, _KIND, lambda b, x, y: b.fsub(x, y))
compiles(operator.mul, _TWO, _KIND, lambda b, x, y: b.fmul(x, y))
