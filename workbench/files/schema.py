"""What every file model shares: strict pydantic models, quantities with units, errors with
positions.

Lengths come out in metres and angles in radians: a number counts in the file's own `length` unit, a
string carries its unit ("17.7 in").
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from reprlib import Repr
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic_core import ErrorDetails

from workbench.errors import InputError, one_of
from workbench.files.yaml_text import Document

__all__ = [
    "LENGTH_SCHEMA",
    "CallFloat",
    "CallInt",
    "Degrees",
    "FileModel",
    "Length",
    "LengthUnit",
    "Vector",
    "error_at",
    "length_in_metres",
    "metres_in",
    "plausible",
    "to_metres",
    "validate",
]

metres_in: dict[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]+)\s*\Z")
_LONGEST = 1e4


class FileModel(BaseModel):
    """A strict model: no unknown keys, no guessing of types, frozen."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True
    )


class CallFloat(float):
    """A number of a call in Python that stands among those of a file: as a length it is in metres,
    whatever the unit of the file."""


class CallInt(int):
    """A whole number of a call in Python, see CallFloat."""


def to_metres(text: str) -> float:
    """Metres from a quantity such as "450 mm" or "17.7 in"; ValueError says what is valid."""
    match = _QUANTITY.match(text)
    if not match or match[2] not in metres_in:
        raise ValueError(
            f"a length such as '450 mm' or '17.7 in' is needed; units: {', '.join(metres_in)}"
        )
    return float(match[1]) * metres_in[match[2]]


def length_in_metres(value: Any, info: ValidationInfo) -> Any:
    """Metres from a number in the file's unit, or from a text with its unit; ValueError else."""
    if isinstance(value, str):
        return to_metres(value)
    if isinstance(value, (CallFloat, CallInt)):
        return float(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        scale = (info.context or {}).get("metres", math.nan)
        return float(value) * scale
    raise ValueError("a number or a length such as '450 mm' is needed")


def plausible(value: float) -> float:
    """A length that may stand in a file; ValueError for one that is farther than any is."""
    if abs(value) > _LONGEST:
        raise ValueError(f"{value:g} m is farther than {_LONGEST:g} m: a wrong unit?")
    return value


LENGTH_SCHEMA = {
    "anyOf": [
        {"type": "number"},
        {"type": "string", "pattern": r"^\s*[-+0-9.eE]+\s*(mm|cm|m|in|ft)\s*$"},
    ],
    "description": "a number in the file's unit of length, or a string with its unit",
}
Length = Annotated[
    float,
    BeforeValidator(length_in_metres),
    AfterValidator(plausible),
    WithJsonSchema(LENGTH_SCHEMA),
]
Degrees = Annotated[float, Field(ge=-720, le=720), AfterValidator(math.radians)]
Vector = Annotated[tuple[Length, Length, Length], Field(strict=False)]
LengthUnit = Annotated[str, Field(pattern=r"^(mm|cm|m|in|ft)$", description="mm, cm, m, in or ft")]

_SAID = {
    "dict_type": "a mapping of keys is needed",
    "model_type": "a mapping of keys is needed",
    "list_type": "a list is needed",
    "tuple_type": "a list is needed",
    "string_type": "a text is needed",
    "float_type": "a number is needed",
    "int_type": "a whole number is needed",
    "bool_type": "true or false is needed",
    "too_long": "at most {max_length} are possible",
    "too_short": "at least {min_length} are needed",
}
_shown_short = Repr()
_shown_short.maxlevel = 3
_shown_short.maxlist = 8
_shown_short.maxdict = 8
_shown_short.maxstring = _shown_short.maxother = _shown_short.maxlong = 60

Model = TypeVar("Model", bound=FileModel)


def validate(document: Document, model: type[Model]) -> Model:
    """Check a document against a model; InputError carries a line for every fault in the file."""
    if not isinstance(document.value, dict):
        raise InputError(
            f"{document.where(())}: a mapping of keys is needed, got {_shown(document.value)}"
        )
    if document.controls:
        what = "a text with control characters is not accepted: remove them"
        raise InputError([error_at(document, path, what) for path in document.controls])
    unit = document.value.get("length")
    scale = metres_in.get(unit, math.nan) if isinstance(unit, str) else math.nan
    faults = []
    if "length" in model.model_fields and math.isnan(scale):
        given = "it is missing" if "length" not in document.value else f"got {_shown(unit)}"
        faults.append(
            f"{document.where(('length',))}: length: the unit of length is needed ({given}), "
            f"one of {', '.join(metres_in)}"
        )
    try:
        # without a unit the rest is still checked, in the smallest one, in which nothing is too far
        # away
        valid = model.model_validate(
            document.value, context={"metres": 0.001 if math.isnan(scale) else scale}
        )
    except ValidationError as error:
        raise InputError(faults + _lines(document, model, error)) from None
    if faults:
        raise InputError(faults)
    return valid


def error_at(document: Document, path: Iterable[str | int], what: str) -> str:
    """One line of an InputError: where the value at `path` stands, its key, and what is wrong."""
    keys = tuple(path)
    return (
        f"{document.where(keys)}: {_dotted(keys)}: {what}"
        if keys
        else f"{document.where(keys)}: {what}"
    )


def _lines(document: Document, model: type[FileModel], error: ValidationError) -> list[str]:
    lines: dict[str, None] = {}
    for fault in error.errors(include_url=False):
        path = _real_path(document.value, fault["loc"])
        at_unit = path == ("length",) or fault["loc"] == ("length",)
        if at_unit and "length" in model.model_fields:
            continue  # reported already, with what was given
        if fault["type"] == "extra_forbidden":
            what = f"unknown key {path[-1]!r}; {one_of(str(path[-1]), _keys(model, path[:-1]))}"
        elif fault["type"] == "missing" and isinstance(fault["loc"][-1], str):
            what = f"key {fault['loc'][-1]!r} is missing"
        else:
            what = f"{_said(fault)} (got {_shown(fault['input'])})"
        lines[error_at(document, path, what)] = None
    return list(lines)


def _said(fault: ErrorDetails) -> str:
    """What is wrong in the words of the file, not of Python."""
    if fault["type"] == "missing":
        return f"value {int(fault['loc'][-1]) + 1} of the list is missing"
    if fault["type"] in _SAID:
        return _SAID[fault["type"]].format(**fault.get("ctx", {}))
    message = str(fault["msg"]).removeprefix("Value error, ")
    return message[:1].lower() + message[1:]


def _real_path(value: Any, loc: tuple[str | int, ...]) -> tuple[str | int, ...]:
    """The part of pydantic's location that exists in the file: tags of unions and validators drop
    out."""
    path: list[str | int] = []
    for step in loc:
        known = (
            value
            if isinstance(value, dict)
            else dict(enumerate(value))
            if isinstance(value, list)
            else {}
        )
        if step in known:
            value = known[step]
            path.append(step)
    return tuple(path)


def _keys(model: Any, path: tuple[str | int, ...]) -> list[str]:
    """The valid keys of the mapping at this path: walk the models' annotations along it."""
    kinds: list[Any] = [model]
    for step in path:
        kinds = [inner for kind in kinds for inner in _inside(kind, step)]
    return sorted({key for kind in kinds if _is_model(kind) for key in _file_keys(kind)})


def _file_keys(kind: Any) -> list[str]:
    return [info.alias or name for name, info in kind.model_fields.items()]


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _inside(kind: Any, step: str | int) -> list[Any]:
    if _is_model(kind):
        named = {info.alias or name: info.annotation for name, info in kind.model_fields.items()}
        return _flat(named[str(step)]) if step in named else []
    origin = get_origin(kind)
    arguments = get_args(kind)
    if origin is dict:
        return _flat(arguments[1])
    return (
        [inner for argument in arguments for inner in _flat(argument)]
        if origin in (list, tuple)
        else []
    )


def _flat(kind: Any) -> list[Any]:
    """A union or an annotated type as the list of the plain types in it."""
    origin = get_origin(kind)
    if origin is Annotated:
        return _flat(get_args(kind)[0])
    if origin in (Union, UnionType):
        return [inner for argument in get_args(kind) for inner in _flat(argument)]
    return [kind]


def _dotted(path: Iterable[str | int]) -> str:
    return "".join(
        f"[{step}]" if isinstance(step, int) else f".{_one_line(step)}" for step in path
    ).removeprefix(".")


def _one_line(key: str) -> str:
    return key if key.isprintable() and key else repr(key)


def _shown(value: Any) -> str:
    """A value for a message: never long, however much an alias makes of it."""
    text = _shown_short.repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
