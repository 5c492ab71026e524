"""Eight numbers of single precision at a time, for loops that the compiler does not take several at once by itself.

Compiled, eight lanes are one register (or two of four, where the machine has those), and +, - and * work lane by lane.
Not compiled they are an array (8,), and the functions below say what is meant.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model
from numba.np.arrayobj import make_array
from numpy.typing import NDArray

__all__ = ["LANES", "LaneType", "compiles", "eight", "equal", "first_bit", "greatest", "how_many", "larger", "least",
           "load", "not_above", "pack", "root", "smaller", "store", "where_below"]  # fmt: skip

LANES = 8


def load(array, at):  # type: ignore[no-untyped-def]
    """The eight numbers of an array, all its numbers in order, that begin at place `at`."""
    return array.reshape(-1)[at : at + LANES].copy()


def store(array, at, values):  # type: ignore[no-untyped-def]
    """Write eight numbers into a flat array from place `at` on."""
    array[at : at + LANES] = values


def eight(value):  # type: ignore[no-untyped-def]
    """The same number eight times."""
    return np.full(LANES, value, dtype=np.float32)


def smaller(a, b):  # type: ignore[no-untyped-def]
    """The smaller of each lane."""
    return np.minimum(a, b)


def larger(a, b):  # type: ignore[no-untyped-def]
    """The larger of each lane."""
    return np.maximum(a, b)


def root(a):  # type: ignore[no-untyped-def]
    """The square root of each lane."""
    return np.sqrt(a)


def where_below(a, b, one, other):  # type: ignore[no-untyped-def]
    """The lanes of `one` where a < b, else those of `other`."""
    return np.where(a < b, one, other)


def not_above(a, b):  # type: ignore[no-untyped-def]
    """Bit k is set where a <= b in lane k."""
    return np.uint64(np.packbits(a <= b, bitorder="little")[0])


def equal(a, b):  # type: ignore[no-untyped-def]
    """Bit k is set where a == b in lane k."""
    return np.uint64(np.packbits(a == b, bitorder="little")[0])


def least(a):  # type: ignore[no-untyped-def]
    """The least of all lanes; none of them may be NaN."""
    return a.min()


def greatest(a):  # type: ignore[no-untyped-def]
    """The greatest of all lanes; none of them may be NaN."""
    return a.max()


def first_bit(bits):  # type: ignore[no-untyped-def]
    """The number of the lowest bit that is set; 64 where none is."""
    return np.uint64((int(bits) & -int(bits)).bit_length() - 1 if bits else 64)


def how_many(bits):  # type: ignore[no-untyped-def]
    """How many bits are set."""
    return np.uint64(int(bits).bit_count())


def _places() -> NDArray[np.float32]:
    """Row by row the numbers of the bits that are set in 0, 1, 2, ... 255, then zeros."""
    rows = [[k for k in range(LANES) if bits >> k & 1] for bits in range(256)]
    return np.array([row + [0] * (LANES - len(row)) for row in rows], dtype=np.float32).reshape(-1)


_PLACES = _places()


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def pack(array, at, bits, base):  # type: ignore[no-untyped-def]
    """Write base + k for every bit k < 8 that is set, in order, into a flat array from place `at` on; returns the place
    behind the last. What stands in the seven places behind that is spoilt: there is no branch to go wrong."""
    store(array, at, load(_PLACES, bits * np.uint64(LANES)) + eight(base))
    return at + how_many(bits)


class LaneType(types.Type):  # type: ignore[misc]
    """Several numbers as one value."""


class _EightType(LaneType):
    def __init__(self) -> None:
        super().__init__(name="Eight")


_EIGHT = _EightType()
_VECTOR = ir.VectorType(ir.FloatType(), LANES)
_WORD = ir.IntType(64)
Build = Callable[..., Any]


@register_model(_EightType)
class _EightModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _VECTOR)


def compiles(function: Any, given: tuple[Any, ...], result: Any, build: Build) -> None:
    """Have calls of a function with arguments of the types `given` compiled by build(builder, *arguments)."""

    def generic(_: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        del kws
        lanes = [[t if isinstance(t, LaneType) else None for t in some] for some in (args, given)]
        if len(args) != len(given) or lanes[0] != lanes[1]:
            return None
        return signature(result, *(a if g is types.Array else g for a, g in zip(args, given, strict=True)))

    def lower(context: Any, builder: Any, sig: Any, args: tuple[Any, ...]) -> Any:
        values = [make_array(kind)(context, builder, value) if isinstance(kind, types.Array) else value
                  for kind, value in zip(sig.args, args, strict=True)]  # fmt: skip
        return build(builder, *values)

    template = type(f"Lanes_{function.__name__}", (AbstractTemplate,), {"key": function, "generic": generic})
    infer_global(function, types.Function(template))
    lower_builtin(function, *given)(lower)


def _at(builder: Any, array: Any, at: Any) -> Any:
    return builder.bitcast(builder.gep(array.data, [at]), _VECTOR.as_pointer())


def _spread(builder: Any, value: Any) -> Any:
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), zeros)


def _call(name: str, result: Any, *, fast: tuple[str, ...] = ()) -> Build:
    """A builder's call of one of LLVM's own functions on eight lanes."""

    def build(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(result, [value.type])
        made = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        return builder.call(made, [value], fastmath=fast)

    return build


def _bits(order: str) -> Build:
    def build(builder: Any, a: Any, b: Any) -> Any:
        mask = builder.fcmp_ordered(order, a, b)
        return builder.zext(builder.bitcast(mask, ir.IntType(LANES)), _WORD)

    return build


def _first(builder: Any, bits: Any) -> Any:
    return builder.cttz(bits, ir.Constant(ir.IntType(1), 0))


def _stored(builder: Any, array: Any, at: Any, value: Any) -> Any:
    builder.store(value, _at(builder, array, at), align=4)
    return ir.Constant(ir.IntType(8).as_pointer(), None)


_TWO = (_EIGHT, _EIGHT)
_NO_NAN = ("nnan", "nsz")
compiles(load, (types.Array, types.uint64), _EIGHT, lambda b, array, at: b.load(_at(b, array, at), align=4))
compiles(store, (types.Array, types.uint64, _EIGHT), types.none, _stored)
compiles(eight, (types.float32,), _EIGHT, _spread)
compiles(operator.add, _TWO, _EIGHT, lambda b, x, y: b.fadd(x, y))
compiles(operator.sub, _TWO, _EIGHT, lambda b, x, y: b.fsub(x, y))
compiles(operator.mul, _TWO, _EIGHT, lambda b, x, y: b.fmul(x, y))
compiles(smaller, _TWO, _EIGHT, lambda b, x, y: b.select(b.fcmp_ordered("<", x, y), x, y))
compiles(larger, _TWO, _EIGHT, lambda b, x, y: b.select(b.fcmp_ordered(">", x, y), x, y))
compiles(root, (_EIGHT,), _EIGHT, _call("llvm.sqrt.v8f32", _VECTOR))
compiles(where_below, _TWO * 2, _EIGHT, lambda b, x, y, u, v: b.select(b.fcmp_ordered("<", x, y), u, v))
compiles(not_above, _TWO, types.uint64, _bits("<="))
compiles(equal, _TWO, types.uint64, _bits("=="))
compiles(least, (_EIGHT,), types.float32, _call("llvm.vector.reduce.fmin.v8f32", ir.FloatType(), fast=_NO_NAN))
compiles(greatest, (_EIGHT,), types.float32, _call("llvm.vector.reduce.fmax.v8f32", ir.FloatType(), fast=_NO_NAN))
compiles(how_many, (types.uint64,), types.uint64, lambda b, bits: b.ctpop(bits))
compiles(first_bit, (types.uint64,), types.uint64, _first)
