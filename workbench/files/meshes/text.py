"""Read OFF and PLY.

General libraries misread binary PLY of mixed triangles and quadrilaterals, accept PLY files that
are cut short, and fold concave faces.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.files.file_errors import BYTE_ORDER_MARK
from workbench.files.meshes.parts import RawMesh, RawPart, check_corners, triangulate
from workbench.model.arrays import Floats, Ints

__all__ = ["read_off", "read_ply"]

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}


def _numbers(path: Path, words: list[str] | list[bytes]) -> Floats:
    try:
        return np.array(words, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"{path}: a number is needed: {error}") from None


def _integers(path: Path, numbers: Floats) -> Ints:
    """Return numbers as indices; refuse any that is not a whole number."""
    if not np.all((np.abs(numbers) < 2**53) & (numbers == np.trunc(numbers))):
        raise InputError(f"{path}: a face needs whole numbers")
    return numbers.astype(np.int64)


def read_off(path: Path, data: bytes) -> RawMesh:
    """Read the one part of an OFF file (plain or coloured; not binary)."""
    rows = _off_rows(path, data)
    point_count, face_count = _off_counts(path, rows)
    points = rows[1 : point_count + 1]
    faces = rows[point_count + 1 : point_count + face_count + 1]
    if len(faces) < face_count or any(len(row) < 3 for row in points):
        raise InputError(
            f"{path}: cut short: {point_count} vertices and {face_count} faces are announced"
        )
    vertices = _numbers(path, [word for row in points for word in row[:3]]).reshape(-1, 3)
    sizes = _integers(path, _numbers(path, [row[0] for row in faces]))
    if any(len(row) <= size for row, size in zip(faces, sizes, strict=True)):
        raise InputError(f"{path}: a face has fewer corners than it announces")
    words = [word for row, size in zip(faces, sizes, strict=True) for word in row[1 : size + 1]]
    return _one_part(path, "OFF", vertices, _integers(path, _numbers(path, words)), sizes)


def _off_rows(path: Path, data: bytes) -> list[list[bytes]]:
    """Return the words of each line that has any, from the line of the counts."""
    lines = (
        line.partition(b"#")[0].split() for line in data.removeprefix(BYTE_ORDER_MARK).splitlines()
    )
    rows = [line for line in lines if line]
    if not rows or rows[0][0] not in (b"OFF", b"COFF"):
        raise InputError(f"{path}: not an OFF file: it begins with {data[:12]!r}")
    return rows[1:] if len(rows[0]) == 1 else [rows[0][1:], *rows[1:]]


def _off_counts(path: Path, rows: list[list[bytes]]) -> tuple[int, int]:
    """Return the numbers of vertices and faces that an OFF file states, at most one for each row."""
    stated = _numbers(path, rows[0]) if rows else np.zeros(0)
    if len(stated) < 2 or not np.all((stated[:2] >= 0) & (stated[:2] <= len(rows))):
        raise InputError(f"{path}: cut short, or its counts of vertices and faces are wrong")
    return int(stated[0]), int(stated[1])


def _one_part(path: Path, form: str, vertices: Floats, corners: Ints, sizes: Ints) -> RawMesh:
    """Return a mesh of one part.

    Parameters
    ----------
    path, form
        The file and its format.
    vertices
        (V, 3).
    corners, sizes
        Corners of the faces one after the other, and the number of corners of each.
    """
    check_corners(path, sizes)
    named = corners.min(initial=0) >= 0 and corners.max(initial=-1) < len(vertices)
    if sizes.min(initial=3) < 3 or not named:
        raise InputError(
            f"{path}: a face names fewer than three vertices, or one that is not there"
        )
    part = RawPart("", vertices, triangulate(vertices, corners, sizes))
    return RawMesh(str(path), form, (part,))


class _Property(NamedTuple):
    """A property of a PLY element."""

    name: str
    kind: str
    """Type of its values, as NumPy writes it."""
    length: str | None
    """Type of the length of a list, None for a single value."""


@dataclass
class _Element:
    """One kind of row of a PLY file."""

    name: str
    count: int
    properties: list[_Property]

    @property
    def lists(self) -> list[str]:
        """Names of the properties that are lists."""
        return [each.name for each in self.properties if each.length]


def read_ply(path: Path, data: bytes) -> RawMesh:
    """Read the one part of a PLY file, text or binary, with faces of any number of corners."""
    data = data.removeprefix(BYTE_ORDER_MARK)
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{path}: not a PLY file: it has no header from 'ply' to 'end_header'")
    body = data[data.find(b"\n", end) + 1 :] if b"\n" in data[end:] else b""
    try:
        columns = _ply_columns(data[:end].decode("ascii", errors="replace"), body)
        vertices = np.column_stack([columns["vertex"][axis] for axis in "xyz"]).astype(np.float64)
    except (ValueError, KeyError, IndexError, MemoryError, OverflowError) as error:
        raise InputError(
            f"{path}: broken or cut short PLY: {error or type(error).__name__}"
        ) from None
    corners, sizes = (_integers(path, numbers) for numbers in _ply_faces(columns.get("face", {})))
    strips, lengths = (
        _integers(path, numbers) for numbers in _ply_faces(columns.get("tristrips", {}))
    )
    triangles = [_strip_triangles(row) for row in np.split(strips, np.cumsum(lengths)[:-1])]
    if len(strips):
        corners = np.concatenate([corners, *(part.ravel() for part in triangles)])
        sizes = np.concatenate([sizes, *(np.full(len(part), 3) for part in triangles)])
    return _one_part(path, "PLY", vertices, corners, sizes)


def _strip_triangles(corners: Ints) -> Ints:
    """The triangles (T, 3) of strips of corners with -1 between them; every second one of a strip
    runs the other way, and one with two equal corners is none."""
    triangle = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    ends = np.flatnonzero(corners < 0)
    start = np.zeros(len(corners), dtype=np.int64)
    start[ends] = ends + 1
    odd = (np.arange(len(corners)) - np.maximum.accumulate(start))[: len(triangle)] % 2 == 1
    triangle[odd] = triangle[odd][:, [1, 0, 2]]
    a, b, c = triangle.T
    return np.asarray(triangle[(triangle >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)])


def _ply_faces(faces: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Return the corners of the faces one after the other, and the number of corners of each."""
    corners = sizes = np.zeros(0)
    for name in ("vertex_index", "vertex_indices"):
        if name in faces:
            corners = faces[name]
            sizes = faces[name + " sizes"]
    return corners, sizes


def _ply_columns(header: str, body: bytes) -> dict[str, dict[str, Floats]]:
    """Return the properties of each element by their names; see `_packed`."""
    form, elements = _ply_header(header, len(body))
    if form == "ascii":
        reader: _TextRows | _BinaryRows = _TextRows(body)
    else:
        reader = _BinaryRows(body, ">" if "big" in form else "<")
    return {element.name: reader.take(element) for element in elements}


def _ply_header(text: str, max_rows: int) -> tuple[str, list[_Element]]:
    """Return the format and the elements of a header, none with more than `max_rows` rows."""
    form = ""
    elements: list[_Element] = []
    for words in (line.split() for line in text.splitlines()[1:]):
        key = words[0] if words else "comment"
        if key == "format":
            form = words[1]
        elif key == "element":
            elements.append(_Element(words[1], int(words[2]), []))
            if not 0 <= elements[-1].count <= max_rows:
                raise ValueError(
                    f"element {words[1]} has the count {words[2][:20]}, more than the file can hold"
                )
        elif key == "property":
            elements[-1].properties.append(_ply_property(words))
        elif key not in ("comment", "obj_info"):
            raise ValueError(f"unknown line in its header: {key[:30]!r}")
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"unknown format {form!r}")
    return form, elements


def _ply_property(words: list[str]) -> _Property:
    if words[1:2] == ["list"]:
        return _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
    return _Property(words[2], _TYPES[words[1]], None)


class _TextRows:
    """Reads elements from the text of a PLY file, number by number."""

    def __init__(self, body: bytes) -> None:
        self.numbers = np.array(body.split(), dtype=np.float64)
        self.position = 0

    def take(self, element: _Element) -> dict[str, Floats]:
        """Read all rows of an element."""
        if not element.lists:
            return self._table(element)
        columns: dict[str, list[Floats]] = {each.name: [] for each in element.properties}
        for _ in range(element.count):
            for each in element.properties:
                size = int(self._next(1)[0]) if each.length else 1
                columns[each.name].append(self._next(size))
        return _packed(element, columns)

    def _table(self, element: _Element) -> dict[str, Floats]:
        width = len(element.properties)
        table = self._next(element.count * width).reshape(element.count, width)
        return {each.name: table[:, k] for k, each in enumerate(element.properties)}

    def _next(self, count: int) -> Floats:
        if count < 0 or self.position + count > len(self.numbers):
            raise ValueError("it holds fewer numbers than its header announces")
        self.position += count
        return self.numbers[self.position - count : self.position]


class _BinaryRows:
    """Reads elements from the bytes of a PLY file: all rows at once if their lists are equally
    long."""

    def __init__(self, body: bytes, order: str) -> None:
        self.body = body
        self.order = order
        self.position = 0

    def take(self, element: _Element) -> dict[str, Floats]:
        """Read all rows of an element."""
        if not element.count:
            return _packed(element, {each.name: [] for each in element.properties})
        row = self._row_layout(element, self.position)
        size = row.itemsize * element.count
        if self.position + size <= len(self.body):
            table = np.frombuffer(self.body, row, element.count, self.position)
            if all((table[n + " size"] == table[n].shape[1]).all() for n in element.lists):
                self.position += size
                return self._columns(element, table)
        elif not element.lists:
            raise ValueError("it holds fewer bytes than its header announces")
        return self._row_by_row(element)

    def _row_layout(self, element: _Element, start: int) -> np.dtype[np.void]:
        """Return the layout of the row that starts at byte `start`."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        end = start
        for name, kind, length in element.properties:
            if length:
                (size,) = np.frombuffer(self.body, self.order + length, 1, end)
                fields.append((name + " size", self.order + length))
                fields.append((name, self.order + kind, (int(size),)))
                end += np.dtype(length).itemsize + int(size) * np.dtype(kind).itemsize
            else:
                fields.append((name, self.order + kind))
                end += np.dtype(kind).itemsize
        if end > len(self.body):
            raise ValueError("it holds fewer bytes than its header announces")
        return np.dtype(fields)

    def _columns(
        self, element: _Element, table: np.ndarray[tuple[int], np.dtype[np.void]]
    ) -> dict[str, Floats]:
        names = [each.name for each in element.properties]
        columns = {name: table[name].astype(np.float64).ravel() for name in names}
        return columns | {
            name + " sizes": table[name + " size"].astype(np.float64) for name in element.lists
        }

    def _row_by_row(self, element: _Element) -> dict[str, Floats]:
        columns: dict[str, list[Floats]] = {each.name: [] for each in element.properties}
        for _ in range(element.count):
            row = self._row_layout(element, self.position)
            (values,) = np.frombuffer(self.body, row, 1, self.position)
            for name, column in columns.items():
                column.append(np.atleast_1d(values[name]).astype(np.float64))
            self.position += row.itemsize
        return _packed(element, columns)


def _packed(element: _Element, columns: dict[str, list[Floats]]) -> dict[str, Floats]:
    """Join the values of each property; of a list named n, "n sizes" is the length in each row."""
    packed = {name: np.concatenate([np.zeros(0), *values]) for name, values in columns.items()}
    return packed | {
        name + " sizes": np.array([len(row) for row in columns[name]], dtype=np.float64)
        for name in element.lists
    }
