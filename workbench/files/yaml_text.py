"""YAML 1.2 with positions: `no` is a string, `010` is ten, `1e3` a number, and every value knows
its line.

Built from the parser's events with a loop of our own, not PyYAML's constructors: those speak YAML
1.1, forget where a value stood, keep the last of two equal keys, and recurse as deep as the file
says. Anchors are allowed but what they expand to is counted, so a small file cannot grow into a
large one.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from os.path import lexists
from pathlib import Path
from typing import Any
from unicodedata import normalize

import yaml

from workbench.errors import InputError, has_controls
from workbench.files.file_errors import read_whole
from workbench.files.names import spelled

__all__ = ["Document", "parse_yaml", "read_yaml"]

MOST_VALUES = 2_000_000
MOST_DEPTH = 64
MOST_BYTES = 64 * 2**20
LONGEST_INTEGER = 40

# YAML 1.2.2 section 10.3.2, core schema.
_NULL = re.compile(r"(?:null|Null|NULL|~|)\Z")
_TRUE = re.compile(r"(?:true|True|TRUE)\Z")
_FALSE = re.compile(r"(?:false|False|FALSE)\Z")
_INT = re.compile(r"[-+]?[0-9]+\Z")
_OCT = re.compile(r"0o[0-7]+\Z")
_HEX = re.compile(r"0x[0-9a-fA-F]+\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_INF = re.compile(r"([-+]?)\.(?:inf|Inf|INF)\Z")
_NAN = re.compile(r"\.(?:nan|NaN|NAN)\Z")
# YAML 1.2.2 section 5.1: all but these may stand in a file.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

Position = tuple[int, int]
Path_ = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """A parsed file: its plain value, and the position (line, column; from 1) of each value by its
    path of keys. What a call states has no positions; `file` is then the name of the call."""

    file: str
    value: Any
    positions: dict[Path_, Position] = field(repr=False)
    controls: tuple[Path_, ...] = ()
    """Paths of the texts and keys that hold control characters (YAML can write them as escapes)."""

    def where(self, path: Path_) -> str:
        """`file:line:column` of the value at this path, or of its nearest ancestor that is
        there; the file alone where nothing has a position."""
        if not self.positions:
            return self.file
        while path not in self.positions and path:
            path = path[:-1]
        line, column = self.positions.get(path, (1, 1))
        return f"{self.file}:{line}:{column}"


def read_yaml(path: str | Path) -> Document:
    """Read a YAML file; InputError says file, line and column of what is wrong."""
    source = Path(path)
    data = read_whole(source, "a YAML file", most=MOST_BYTES)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig")
        byte = f"byte {error.start} is {data[error.start]:#04x}"
        raise InputError(f"{source}:{_end(before)}: not a text file in UTF-8 ({byte})") from None
    if not text.strip():
        raise InputError(f"{source}:1:1: is empty")
    return parse_yaml(text, str(source))


def parse_yaml(text: str, file: str) -> Document:
    """Parse YAML text; `file` is the name that messages show."""
    builder = _Builder(file)
    text = text.removeprefix("\ufeff")  # a byte order mark
    try:
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            builder.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        spot = f"{file}:{mark.line + 1}:{mark.column + 1}" if mark else file
        problem = str(error.problem or error.context)
        if (
            "nesting depth" in problem
        ):  # PyYAML 6.0.4 has a limit of its own, met while it looks ahead
            raise InputError(f"{spot}: nested deeper than {MOST_DEPTH} levels") from None
        raise InputError(f"{spot}: not YAML: {problem}{_separators(text, file)}") from None
    except yaml.YAMLError as error:
        raise InputError(
            f"{_forbidden(text, file)}: not YAML: {str(error).splitlines()[0]}"
        ) from None
    if not builder.done:
        raise InputError(f"{file}:1:1: holds no value")
    return Document(file, builder.value, builder.positions, tuple(builder.controls))


def _forbidden(text: str, file: str) -> str:
    """`file:line:column` of the first character that YAML forbids: the parser itself counts only
    bytes there."""
    found = _FORBIDDEN.search(text)
    if not found:
        return file
    return f"{file}:{_end(text[: found.start()])}"


def _separators(text: str, file: str) -> str:
    """Where a character stands that the parser takes for the end of a line, in words to follow."""
    found = re.search("[\x85\u2028\u2029]", text)
    if not found:
        return ""
    return (
        f" (U+{ord(found[0]):04X} at {file}:{_end(text[: found.start()])} ends a line; write it as "
        f'"\\u{ord(found[0]):04x}" in double quotes)'
    )


def _end(before: str) -> str:
    """`line:column` of what follows this text."""
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def _integer(digits: str, base: int) -> int | float:
    """A whole number; what is too large for any use becomes a float, so that it cannot overflow
    later."""
    if len(digits) < LONGEST_INTEGER:
        return int(digits, base)
    if base == 10:
        return float(digits)
    return float(int(digits, base)) if len(digits) < 250 else math.inf


def _scalar(text: str) -> Any:
    """The value of a plain (unquoted) scalar in the core schema."""
    if _NULL.match(text):
        return None
    if _TRUE.match(text):
        return True
    if _FALSE.match(text):
        return False
    if _INT.match(text):
        return _integer(text, 10)
    if _OCT.match(text):
        return _integer(text[2:], 8)
    if _HEX.match(text):
        return _integer(text[2:], 16)
    if _FLOAT.match(text):
        return float(text)
    if inf := _INF.match(text):
        return float(inf[1] + "inf")
    return float("nan") if _NAN.match(text) else text


def _spot(event: yaml.Event) -> Position:
    """Line and column of an event, from 1."""
    mark = event.start_mark
    return (mark.line + 1, mark.column + 1) if mark else (1, 1)


@dataclass
class _Open:
    """A list or mapping that is still being filled."""

    value: Any
    path: Path_
    anchor: str | None
    key: Any = None
    has_key: bool = False
    height: int = 1


class _Builder:
    """Turns parser events into values, one at a time, without recursion."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.positions: dict[Path_, Position] = {}
        self.controls: list[Path_] = []
        self.value: Any = None
        self.done = False
        self._open: list[_Open] = []
        self._anchors: dict[str, Any] = {}
        self._sizes: dict[str, int] = {}
        self._heights: dict[str, int] = {}
        self._values = 0

    def take(self, event: yaml.Event) -> None:
        if isinstance(event, yaml.DocumentStartEvent) and self.done:
            raise self._wrong(event, "a second document starts here; one is allowed")
        if isinstance(event, yaml.NodeEvent):
            self._count(event, 1)
            self._node(event)
        elif isinstance(event, (yaml.SequenceEndEvent, yaml.MappingEndEvent)):
            closed = self._open.pop()
            self._raise(closed.height)
            if closed.anchor:
                self._anchors[closed.anchor] = closed.value
                self._heights[closed.anchor] = closed.height
                self._sizes[closed.anchor] = self._values - self._sizes[closed.anchor]

    def _node(self, event: yaml.NodeEvent) -> None:
        if isinstance(event, yaml.AliasEvent):
            self._alias(event)
        elif isinstance(event, yaml.ScalarEvent):
            self._text(event)
        else:
            self._begin(event)

    def _alias(self, event: yaml.AliasEvent) -> None:
        """Store the value of an anchor once more."""
        anchor = event.anchor
        if anchor not in self._anchors:
            raise self._wrong(event, f"alias *{anchor} has no finished anchor &{anchor} before it")
        self._count(event, self._sizes[anchor])
        self._deep(event, self._heights[anchor])
        self._raise(self._heights[anchor])
        self._put(event, self._anchors[anchor])

    def _text(self, event: yaml.ScalarEvent) -> None:
        """Store a text, or what a plain one stands for."""
        self._check_tag(event, event.tag, "str")
        plain = event.implicit[0]
        value = _scalar(event.value) if plain and not event.tag else event.value
        if isinstance(value, str) and not value.isascii():
            # as names of parts are; the name of a file that is there has the form that it has there
            folder = Path(self.file).parent
            there = spelled(folder, value)
            value = there if lexists(folder / there) else normalize("NFC", value)
        if event.anchor:
            self._anchors[event.anchor] = value
            self._sizes[event.anchor] = 1
            self._heights[event.anchor] = 0
        path = self._put(event, value)
        if has_controls(event.value):
            self.controls.append(path)

    def _begin(self, event: yaml.NodeEvent) -> None:
        """Store a list or a mapping that is still empty."""
        self._check_tag(event, getattr(event, "tag", None), "seq", "map")
        self._deep(event, 1)
        value: list[Any] | dict[str, Any] = []
        if not isinstance(event, yaml.SequenceStartEvent):
            value = {}
        path = self._put(event, value)
        if event.anchor:
            self._sizes[event.anchor] = self._values
        self._open.append(_Open(value, path, event.anchor))

    def _check_tag(self, event: yaml.NodeEvent, tag: str | None, *kinds: str) -> None:
        """Refuse a tag other than those that say what the value is anyway."""
        if tag not in (None, "!", *(f"tag:yaml.org,2002:{kind}" for kind in kinds)):
            raise self._wrong(event, f"tag {tag} is not supported; remove it")

    def _put(self, event: yaml.NodeEvent, value: Any) -> Path_:
        """Store a finished or opened value where it belongs; returns its path."""
        if not self._open:
            self.value = value
            self.done = True
            path: Path_ = ()
        elif isinstance(self._open[-1].value, list):
            top = self._open[-1]
            path = (*top.path, len(top.value))
            top.value.append(value)
        elif self._open[-1].has_key:
            top = self._open[-1]
            top.value[top.key] = value
            top.has_key = False
            return (*top.path, top.key)  # whose position is that of the key
        else:
            path = self._put_key(event, value)
        self.positions[path] = _spot(event)
        return path

    def _put_key(self, event: yaml.NodeEvent, value: Any) -> Path_:
        """Store the key of the mapping that is open; returns its path."""
        top = self._open[-1]
        if isinstance(value, (list, dict)):
            raise self._wrong(event, "a key must be a name, not a list or a mapping")
        key = value if isinstance(value, str) else self._raw(event)
        if key in top.value:
            raise self._wrong(event, f"key {key!r} stands twice in one mapping")
        top.key = key
        top.has_key = True
        return (*top.path, key)

    def _raw(self, event: yaml.NodeEvent) -> str:
        if isinstance(event, yaml.ScalarEvent):
            return str(event.value)
        raise self._wrong(event, "a key must be a name")

    def _count(self, event: yaml.NodeEvent, values: int) -> None:
        self._values += values
        if self._values > MOST_VALUES:
            raise self._wrong(
                event, f"the file grows past {MOST_VALUES} values; aliases may be nested too far"
            )

    def _deep(self, event: yaml.NodeEvent, levels: int) -> None:
        if len(self._open) + levels > MOST_DEPTH:
            raise self._wrong(event, f"nested deeper than {MOST_DEPTH} levels")

    def _raise(self, height: int) -> None:
        """The innermost open value holds something of this many levels."""
        if self._open:
            self._open[-1].height = max(self._open[-1].height, height + 1)

    def _wrong(self, event: yaml.Event, what: str) -> InputError:
        line, column = _spot(event)
        return InputError(f"{self.file}:{line}:{column}: {what}")
