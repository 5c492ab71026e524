"""Eight numbers of single precision at a time, for loops that the compiler does not take several at
once by itself.

Compiled, eight lanes are one register (or two of four, where the machine has those), and +, - and *
work lane by lane. Not compiled they are an array (8,), and the functions below say what is meant.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model
from numba.np.arrayobj import make_array

__all__ = [
    "LANES",
    "LaneType",
    "codes",
    "compiles",
    "corners",
    "greatest",
    "horizontal_sum",
    "how_many",
    "larger",
    "load",
    "lowest_set_bit",
    "not_above",
    "root",
    "splat8",
    "store",
]

LANES = 8


def load(array, at):  # type: ignore[no-untyped-def]
    """The eight numbers of an array, all its numbers in order, that begin at place `at`."""
    return array.reshape(-1)[at : at + LANES].copy()


def codes(array, at):  # type: ignore[no-untyped-def]
    """The eight numbers of 16 bits that begin at place `at`, each as the single-precision number
    whose exponent is its upper 5 bits, less 127, and whose mantissa begins with its lower 11."""
    return (array.reshape(-1)[int(at) : int(at) + LANES].astype(np.uint32) << np.uint32(12)).view(
        np.float32
    )


def corners(r, s, t):  # type: ignore[no-untyped-def]
    """The weights of the eight corners of a unit cube for a point (r, s, t) in it, t changing
    first."""
    return np.array(
        [
            (r if k & 4 else 1 - r) * (s if k & 2 else 1 - s) * (t if k & 1 else 1 - t)
            for k in range(LANES)
        ],
        dtype=np.float32,
    )


def horizontal_sum(a):  # type: ignore[no-untyped-def]
    """The sum of all lanes, in any order."""
    return a.sum()


def store(array, at, values):  # type: ignore[no-untyped-def]
    """Write eight numbers into a flat array from place `at` on."""
    array[at : at + LANES] = values


def splat8(value):  # type: ignore[no-untyped-def]
    """The same number eight times."""
    return np.full(LANES, value, dtype=np.float32)


def larger(a, b):  # type: ignore[no-untyped-def]
    """The larger of each lane."""
    return np.maximum(a, b)


def root(a):  # type: ignore[no-untyped-def]
    """The square root of each lane."""
    return np.sqrt(a)


def not_above(a, b):  # type: ignore[no-untyped-def]
    """Bit k is set where a <= b in lane k."""
    return np.uint64(np.packbits(a <= b, bitorder="little")[0])


def greatest(a):  # type: ignore[no-untyped-def]
    """The greatest of all lanes; none of them may be NaN."""
    return a.max()


def lowest_set_bit(bits):  # type: ignore[no-untyped-def]
    """The number of the lowest bit that is set; 64 where none is."""
    return np.uint64((int(bits) & -int(bits)).bit_length() - 1 if bits else 64)


def how_many(bits):  # type: ignore[no-untyped-def]
    """How many bits are set."""
    return np.uint64(int(bits).bit_count())


class LaneType(types.Type):  # type: ignore[misc]
    """Several numbers as one value."""


class _EightType(LaneType):
    def __init__(self) -> None:
        super().__init__(name="Eight")


_EIGHT = _EightType()
_VECTOR = ir.VectorType(ir.FloatType(), LANES)
_WHOLE = ir.VectorType(ir.IntType(32), LANES)
_WORD = ir.IntType(64)
Build = Callable[..., Any]


@register_model(_EightType)
class _EightModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _VECTOR)


def compiles(function: Any, given: tuple[Any, ...], result: Any, build: Build) -> None:
    """Have calls of a function with arguments of the types `given` compiled by build(builder,
    *arguments)."""

    def generic(_: Any, args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        del kws
        lanes = [[t if isinstance(t, LaneType) else None for t in some] for some in (args, given)]
        if len(args) != len(given) or lanes[0] != lanes[1]:
            return None
        return signature(
            result, *(a if g is types.Array else g for a, g in zip(args, given, strict=True))
        )

    def lower(context: Any, builder: Any, sig: Any, args: tuple[Any, ...]) -> Any:
        values = [
            make_array(kind)(context, builder, value) if isinstance(kind, types.Array) else value
            for kind, value in zip(sig.args, args, strict=True)
        ]
        return build(builder, *values)

    template = type(
        f"Lanes_{function.__name__}", (AbstractTemplate,), {"key": function, "generic": generic}
    )
    infer_global(function, types.Function(template))
    lower_builtin(function, *given)(lower)


def _at(builder: Any, array: Any, at: Any) -> Any:
    return builder.bitcast(builder.gep(array.data, [at]), _VECTOR.as_pointer())


def _spread(builder: Any, value: Any) -> Any:
    one = builder.insert_element(
        ir.Constant(_VECTOR, ir.Undefined), value, ir.Constant(ir.IntType(32), 0)
    )
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), zeros)


def _call(name: str, result: Any) -> Build:
    """A builder's call of one of LLVM's own functions on eight lanes."""

    def build(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(result, [value.type])
        made = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        return builder.call(made, [value])

    return build


def _larger(builder: Any, x: Any, y: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", x, y), x, y)


def _codes(builder: Any, array: Any, at: Any) -> Any:
    short = ir.VectorType(ir.IntType(16), LANES)
    found = builder.load(
        builder.bitcast(builder.gep(array.data, [at]), short.as_pointer()), align=2
    )
    return builder.bitcast(
        builder.shl(builder.zext(found, _WHOLE), ir.Constant(_WHOLE, [12] * LANES)), _VECTOR
    )


def _corners(builder: Any, r: Any, s: Any, t: Any) -> Any:
    one = ir.Constant(_VECTOR, [1.0] * LANES)
    weights = None
    for value, bit in ((r, 4), (s, 2), (t, 1)):
        far = _spread(builder, value)
        turn = ir.Constant(
            ir.VectorType(ir.IntType(1), LANES), [int(k & bit > 0) for k in range(LANES)]
        )
        mine = builder.select(turn, far, builder.fsub(one, far))
        weights = mine if weights is None else builder.fmul(weights, mine)
    return weights


def _folded(join: Callable[[Any, Any, Any], Any]) -> Build:
    """All lanes joined two by two: LLVM's own reductions do not exist for every target."""

    def build(builder: Any, a: Any) -> Any:
        for step in (4, 2, 1):
            order = ir.Constant(
                ir.VectorType(ir.IntType(32), LANES), [(k + step) % LANES for k in range(LANES)]
            )
            a = join(
                builder, a, builder.shuffle_vector(a, ir.Constant(_VECTOR, ir.Undefined), order)
            )
        return builder.extract_element(a, ir.Constant(ir.IntType(32), 0))

    return build


def _not_above(builder: Any, a: Any, b: Any) -> Any:
    bits = builder.bitcast(builder.fcmp_ordered("<=", a, b), ir.IntType(LANES))
    return builder.zext(bits, _WORD)


def _first(builder: Any, bits: Any) -> Any:
    return builder.cttz(bits, ir.Constant(ir.IntType(1), 0))


def _stored(builder: Any, array: Any, at: Any, value: Any) -> Any:
    builder.store(value, _at(builder, array, at), align=4)
    return ir.Constant(ir.IntType(8).as_pointer(), None)


_TWO = (_EIGHT, _EIGHT)
compiles(
    load,
    (types.Array, types.uint64),
    _EIGHT,
    lambda b, array, at: b.load(_at(b, array, at), align=4),
)
compiles(codes, (types.Array, types.uint64), _EIGHT, _codes)
compiles(corners, (types.float32,) * 3, _EIGHT, _corners)
compiles(horizontal_sum, (_EIGHT,), types.float32, _folded(lambda b, x, y: b.fadd(x, y)))
compiles(store, (types.Array, types.uint64, _EIGHT), types.none, _stored)
compiles(splat8, (types.float32,), _EIGHT, _spread)
compiles(operator.add, _TWO, _EIGHT, lambda b, x, y: b.fadd(x, y))
compiles(operator.sub, _TWO, _EIGHT, lambda b, x, y: b.fsub(x, y))
compiles(operator.mul, _TWO, _EIGHT, lambda b, x, y: b.fmul(x, y))
compiles(larger, _TWO, _EIGHT, _larger)
compiles(root, (_EIGHT,), _EIGHT, _call("llvm.sqrt.v8f32", _VECTOR))
compiles(not_above, _TWO, types.uint64, _not_above)
compiles(greatest, (_EIGHT,), types.float32, _folded(_larger))
compiles(how_many, (types.uint64,), types.uint64, lambda b, bits: b.ctpop(bits))
compiles(lowest_set_bit, (types.uint64,), types.uint64, _first)
