"""The check of what public functions are called with: each argument against its annotation, before
the call.

`import workbench` hands out every public function inside `checked`. So a wrong type, a number that
is not finite or a ragged array is refused in one place and in one way: the argument's name, what is
expected, what was given. What only the function itself can know (a name that must exist, numbers of
rows that must agree) it says itself.
"""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import lru_cache, wraps
from importlib import import_module
from inspect import Parameter, Signature, currentframe, signature
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from workbench.errors import InputError, UsageError, one_of

__all__ = [
    "above",
    "argument_fault",
    "caller_level",
    "check_fields",
    "check_index",
    "checked",
    "chosen_rows",
    "given_words",
    "short_repr",
]

F = TypeVar("F", bound=Callable[..., Any])
_LONGEST = 60


class _Finite:
    """Stands for the annotation of arrays that are given: finite numbers."""


class _Numbers:
    """Stands for the annotations of arrays that come out of other functions, with NaN and infinity
    where nothing is."""


_ARRAYS = {"ArrayLike": _Finite, "Floats": _Numbers, "Ints": _Numbers, "Bools": _Numbers}


def checked(function: F) -> F:
    """The function, with its arguments checked against its annotations; it raises UsageError for
    the first that does not fit, for one that is missing and for one that it does not take."""

    @wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        names, kinds = _annotated(function)
        _check_call(function, args, options)
        args = tuple(map(_taken, args, map(kinds.get, (*names, *names[-1:] * len(args)))))
        options = {name: _taken(value, kinds.get(name)) for name, value in options.items()}
        rest = names[-1:] * (len(args) - len(names))  # what a last *name takes
        for name, value in [*zip((*names, *rest), args, strict=False), *options.items()]:
            if name in kinds and (fault := argument_fault(name, value, kinds[name])):
                raise UsageError(fault)
        placed = [
            _plain(value, kinds.get(name))
            for name, value in zip((*names, *rest), args, strict=False)
        ]
        return function(
            *placed, **{name: _plain(value, kinds.get(name)) for name, value in options.items()}
        )

    return call  # type: ignore[return-value]


def _taken(value: Any, kind: Any) -> Any:
    """What is given, a mesh of trimesh as an environment where one is expected."""
    if not type(value).__module__.startswith("trimesh."):
        return value
    kinds = [getattr(one, "__name__", "") for one in (kind, *get_args(kind))]
    return (
        above("files.bare_mesh", "environment_of_scene")(value) if "Environment" in kinds else value
    )


def _check_call(function: Callable[..., Any], args: Sequence[Any], options: Iterable[str]) -> None:
    """UsageError for arguments that are missing, too many or unknown."""
    named = _signature(function)
    try:
        named.bind(*args, **dict.fromkeys(options))
    except TypeError as error:
        taken = [name for name in named.parameters if name != "self"]
        unknown = [name for name in options if name not in taken]
        hint = one_of(unknown[0], taken) if unknown else f"it takes {', '.join(taken)}"
        raise UsageError(f"{function.__name__}(...): {error}; {hint}") from None


@lru_cache(maxsize=256)
def _signature(function: Callable[..., Any]) -> Signature:
    return signature(function)


@lru_cache(maxsize=256)
def _annotated(function: Callable[..., Any]) -> tuple[tuple[str, ...], dict[str, Any]]:
    """The names of what a function takes by place, and the annotations of all that it takes."""
    named = signature(function).parameters.values()
    placed = tuple(
        p.name for p in named if p.kind not in (Parameter.KEYWORD_ONLY, Parameter.VAR_KEYWORD)
    )
    kinds = get_type_hints(function, localns=_ARRAYS)
    kinds.pop("return", None)
    return placed, kinds


def check_fields(noun: Any) -> None:
    """InputError for the first field of a dataclass that does not fit its annotation."""
    kinds = _annotated_fields(type(noun))  # type: ignore[arg-type]
    for name, kind in kinds.items():
        value = getattr(noun, name)
        fault = argument_fault(name, value, kind)
        if not fault and kind is _Numbers and np.ndim(value) == 0:
            fault = f"{name}: expected an array, got {given_words(value)}"
        if fault:
            raise InputError(f"{type(noun).__name__.lower()}.{fault}")


@lru_cache(maxsize=64)
def _annotated_fields(noun: type) -> dict[str, Any]:
    kinds = get_type_hints(noun, localns=_ARRAYS)
    return {field.name: kinds[field.name] for field in fields(noun) if field.init}


def caller_level() -> int:
    """The `stacklevel` of a warning that is about what somebody outside the workbench called."""
    level = 0
    frame = currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").startswith("workbench."):
        level += 1
        frame = frame.f_back
    return level


def check_index(name: str, value: Any, count: int) -> int:
    """Return an index into `count` things, counted from the end where it is negative.

    Raises
    ------
    UsageError
        If it is no whole number, or there is no such thing.
    """
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool):
        what = f"expected an index, 0 to {count - 1}, got {given_words(value)}"
    elif not -count <= value < count:
        what = f"there are {count}, with the indices 0 to {count - 1}; got {given_words(value)}"
    else:
        return int(value) % count
    raise UsageError(f"{name}: {what}")


def chosen_rows(name: str, keep: Any, count: int) -> Any:
    """Return a slice, a mask or indices that choose some of `count` rows.

    Raises
    ------
    UsageError
        If it is something else, or there is no such row.
    """
    if isinstance(keep, slice):
        return keep
    try:
        rows = np.asarray(keep)
    except (ValueError, TypeError):
        rows = np.zeros(())
    if rows.shape == (0,):
        return rows.astype(np.int64)
    is_mask = rows.dtype.kind == "b" and rows.shape == (count,)
    if is_mask or (rows.dtype.kind in "iu" and rows.ndim == 1 and _within(rows, count)):
        return rows
    raise UsageError(
        f"{name}: expected a slice, a mask ({count},) or indices from 0 to {count - 1} in a row, got "
        f"{given_words(keep)}"
    )


def _within(rows: np.ndarray[Any, Any], count: int) -> bool:
    return bool(rows.min() >= -count and rows.max() < count)


def _plain(value: Any, kind: Any) -> Any:
    """A whole number as a number with a fraction where one is expected: compiled code tells them
    apart."""
    wants = kind is float or (
        get_origin(kind) in (Union, types.UnionType) and float in get_args(kind)
    )
    return float(value) if wants and isinstance(value, Integral) else value


def argument_fault(name: str, value: object, kind: Any) -> str:
    """What is wrong with an argument, in words; "" where nothing is."""
    origin = get_origin(kind)
    inner = get_args(kind)
    if kind is Any:
        return ""
    if origin in (Union, types.UnionType):
        faults = [argument_fault(name, value, one) for one in inner]
        return "" if "" in faults else _nearest(name, value, kind, faults)
    if kind in (_Finite, _Numbers):
        return _numbers_fault(name, value, finite=kind is _Finite)
    if origin is Sequence and inner == (float,):
        is_array = isinstance(value, np.ndarray) and value.ndim > 0
        is_row = is_array or isinstance(value, (list, tuple))
        return _numbers_fault(name, value, finite=True) if is_row else _words(name, value, kind)
    if origin is Literal:
        kinds = tuple(type(one) for one in inner)  # an array is compared element by element
        return "" if isinstance(value, kinds) and value in inner else _words(name, value, kind)
    if origin is not None:
        return _container_fault(name, value, kind)
    return _plain_fault(name, value, kind)


def _plain_fault(name: str, value: object, kind: Any) -> str:
    """What is wrong with a value for an annotation without arguments, as float or Body."""
    is_truth = isinstance(value, bool) and kind in (int, float)
    if isinstance(value, _LIKE.get(kind, ())) and not is_truth:
        return _number_fault(name, value, kind)
    same = kind in (None, type(None)) and value is None
    plain = isinstance(kind, type) and kind not in _LIKE and isinstance(value, kind)
    return "" if same or plain else _words(name, value, kind)


def _number_fault(name: str, value: Any, kind: Any) -> str:
    """What is wrong with a value of a right type: a number that is not finite, or too large to
    count with."""
    if kind is int and not -(2**63) <= value < 2**63:
        return f"{name}: expected a whole number of 64 bits, got {given_words(value)}"
    if kind is not float:
        return ""
    try:
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    return "" if finite else f"{name}: expected a finite number, got {given_words(value)}"


_LIKE: dict[Any, tuple[type, ...]] = {
    float: (Real,),
    int: (Integral,),
    bool: (bool, np.bool_),
    str: (str,),
    Path: (Path,),
}
"""What may be given for plain annotations."""


def _container_fault(name: str, value: object, kind: Any) -> str:
    """What is wrong with a function, a mapping, a tuple or a sequence, and what is in it."""
    origin = get_origin(kind)
    inner = get_args(kind)
    if origin is Callable:
        return "" if callable(value) else _words(name, value, kind)
    if not isinstance(value, Iterable) or isinstance(value, (str, bytes)):
        return _words(name, value, kind)
    if isinstance(value, np.ndarray) and inner[0] is not str:  # nouns in an array are a slip
        return _words(name, value, kind)
    if not isinstance(value, Collection) and origin is Iterable:
        return ""  # a stream is read once, by the function itself
    items = _items(name, value, origin, inner)
    if items is None:
        return _words(name, value, kind)
    return next((fault for item in items if (fault := argument_fault(*item))), "")


def _items(
    name: str, value: Iterable[Any], origin: Any, inner: tuple[Any, ...]
) -> list[tuple[str, Any, Any]] | None:
    """What is in a container: its name, itself and its annotation; None for a wrong container."""
    if origin in (Mapping, dict):
        if not isinstance(value, Mapping):
            return None
        keys = [(f"{name}: a key", key, inner[0]) for key in value]
        return keys + [(f"{name}[{key!r}]", item, inner[1]) for key, item in value.items()]
    if origin is tuple and inner[-1] is not Ellipsis:
        if not isinstance(value, (tuple, list)) or len(value) != len(inner):
            return None
        pairs = enumerate(zip(value, inner, strict=True))
        return [(f"{name}[{n}]", item, one) for n, (item, one) in pairs]
    if not isinstance(value, Collection):
        return None
    one = inner[0]
    plain = isinstance(one, type) and one not in (float, int, Any)
    if plain and all(isinstance(item, one) for item in value):
        return []  # the usual case, decided fast
    return [(f"{name}[{n}]", item, one) for n, item in enumerate(value)]


def _numbers_fault(name: str, value: object, *, finite: bool) -> str:
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):
        return f"{name}: expected numbers in rows of equal length, got {given_words(value)}"
    if array.dtype.kind not in "fiub":
        return f"{name}: expected numbers, got {given_words(value)}"
    if finite and array.dtype.kind == "f" and not np.all(np.isfinite(array)):
        place = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        where = f" at {place}" if place else ""
        return f"{name}: expected finite numbers, got {array[place]}{where}"
    return ""


def _nearest(name: str, value: object, kind: Any, faults: Sequence[str]) -> str:
    """The fault of the one alternative that the value comes near to; else all alternatives in
    words."""
    plain = [_words(name, value, one) for one in get_args(kind)]
    inside = [fault for fault in faults if fault not in plain]
    return inside[0] if inside else _words(name, value, kind)


def _words(name: str, value: object, kind: Any) -> str:
    words = f"{name}: expected {_kind_words(kind)}, got {given_words(value)}"
    kinds = [getattr(one, "__name__", "") for one in (kind, *get_args(kind))]
    loader = next((_LOADERS[one] for one in kinds if one in _LOADERS), None)
    if loader is None or not isinstance(value, (str, Path)):
        return words
    return f"{words}; wb.{loader}({str(value)!r}) loads one"


_LOADERS = {
    "Body": "load_body",
    "Environment": "load_environment",
    "PopulationModel": "load_population_model",
    "Study": "load_study",
}
"""What loads a noun of which the name is given, by its class."""
_PLAIN = {
    Any: "anything",
    float: "a number",
    int: "a whole number",
    bool: "True or False",
    str: "a text",
    Path: "a path",
    None: "None",
    type(None): "None",
    _Numbers: "numbers",
    _Finite: "numbers",
}


def _kind_words(kind: Any) -> str:
    origin = get_origin(kind)
    inner = get_args(kind)
    if origin in (Union, types.UnionType):
        return " or ".join(_kind_words(one) for one in inner)
    if origin is Literal:
        return " or ".join(repr(one) for one in inner)
    if origin is Callable:
        return "a function"
    if origin in (Mapping, dict):
        return f"a mapping of {_kind_words(inner[0])} to {_kind_words(inner[1])}"
    if origin is tuple and inner[-1] is not Ellipsis:
        return f"({', '.join(_kind_words(one) for one in inner)})"
    if origin is not None and inner:
        return f"a sequence of which each is {_kind_words(inner[0])}"
    name = getattr(kind, "__name__", str(kind))
    return _PLAIN.get(kind, f"{'an' if name[:1] in 'AEIOU' else 'a'} {name}")


def given_words(value: object) -> str:
    """What was given, in a few words."""
    if isinstance(value, np.ndarray) and value.ndim:
        return f"an array {value.shape} of {value.dtype}"
    text = repr(value)
    if len(text) <= _LONGEST and "\n" not in text and " at 0x" not in text:
        return text
    size = f" of {len(value)}" if isinstance(value, Collection) else ""
    return f"a {type(value).__name__}{size}"


# Functions of the rooms above the nouns, for the methods by which nouns offer them.
#
# Reading and drawing lie above the nouns, so no noun may import them. They are looked up by name, and
# only when somebody calls such a method.


def above(module: str, function: str) -> Any:
    """Return a function by its module (below `workbench`) and its name."""
    return getattr(import_module(f"workbench.{module}"), function)


LONGEST = 300
"""Characters of a line; what fields are longer than that are left out, and dots stand for them."""
_LONGEST_VALUE = 60


def short_repr(noun: Any) -> str:
    """Return a dataclass in a line of at most LONGEST characters: for its `__repr__`."""
    name = type(noun).__name__
    line = ""
    for field in fields(noun):
        if not field.repr:
            continue
        shown = f"{', ' if line else ''}{field.name}={_value_words(getattr(noun, field.name))}"
        if len(name) + len(line) + len(shown) + len("(, ...)") > LONGEST:
            return f"{name}({line}, ...)"
        line += shown
    return f"{name}({line})"


def _value_words(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray) and value.size > 3:
        return f"<array {value.shape}>"
    if isinstance(value, str) and len(value) > _LONGEST_VALUE:
        return repr(value[: _LONGEST_VALUE - 3] + "...")
    if isinstance(value, Collection) and not isinstance(value, (str, bytes, np.ndarray)):
        return _collection_words(value)
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else f"<{type(value).__name__}>"


def _collection_words(value: Collection[Any]) -> str:
    """A collection as it is where that is short, else how many of what there are."""
    if len(value) <= 3 and not isinstance(value, Mapping):
        items = [_value_words(item) for item in value]
        text = f"({', '.join(items)}{',' if len(items) == 1 else ''})"
        if len(text) <= _LONGEST_VALUE:
            return text
    return f"<{type(value).__name__} of {len(value)}>" if len(value) else repr(value)
