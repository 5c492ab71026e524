"""OFF and PLY, read here: general libraries misread binary PLY of mixed triangles and
quadrilaterals, take short PLY files for whole ones, and fold concave faces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.bounds import check_corners
from workbench.files.meshes.parts import RawMesh, RawPart, triangulate
from workbench.files.opening import BYTE_ORDER_MARK
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


def _whole(path: Path, numbers: Floats) -> Ints:
    """Numbers as indices; InputError where one is no whole number."""
    if not np.all((np.abs(numbers) < 2**53) & (numbers == np.trunc(numbers))):
        raise InputError(f"{path}: a face needs whole numbers")
    return numbers.astype(np.int64)


def read_off(path: Path, data: bytes) -> RawMesh:
    """The one part of an OFF file (plain or coloured; not binary)."""
    lines = [
        line.partition(b"#")[0].split() for line in data.removeprefix(BYTE_ORDER_MARK).splitlines()
    ]
    words = [word for line in lines for word in line]
    if not words or words[0] not in (b"OFF", b"COFF"):
        raise InputError(f"{path}: not an OFF file: it begins with {data[:12]!r}")
    rows = [line for line in lines if line]
    rows = rows[1:] if len(rows[0]) == 1 else [rows[0][1:], *rows[1:]]
    head = _numbers(path, rows[0]) if rows else np.zeros(0)
    if len(head) < 2 or not np.all(np.abs(head[:2] - len(rows) / 2) <= len(rows) / 2):
        raise InputError(f"{path}: cut short, or its counts of vertices and faces are wrong")
    have = int(head[0])
    count = int(head[1])
    points = rows[1 : have + 1]
    faces = rows[have + 1 : have + count + 1]
    if len(faces) < count or any(len(row) < 3 for row in points):
        raise InputError(f"{path}: cut short: {have} vertices and {count} faces are announced")
    vertices = _numbers(path, [word for row in points for word in row[:3]]).reshape(-1, 3)
    sizes = _whole(path, _numbers(path, [row[0] for row in faces]))
    if any(len(row) <= size for row, size in zip(faces, sizes, strict=True)):
        raise InputError(f"{path}: a face has fewer corners than it announces")
    corners = _numbers(
        path, [word for row, n in zip(faces, sizes, strict=True) for word in row[1 : n + 1]]
    )
    return _one_part(path, "OFF", (vertices, _whole(path, corners), sizes))


def _one_part(path: Path, form: str, shape: tuple[Floats, Ints, Ints]) -> RawMesh:
    vertices, corners, sizes = shape
    check_corners(path, sizes)
    if (
        sizes.min(initial=3) < 3
        or corners.min(initial=0) < 0
        or corners.max(initial=-1) >= len(vertices)
    ):
        raise InputError(
            f"{path}: a face names fewer than three vertices, or one that is not there"
        )
    return RawMesh(str(path), form, (RawPart("", vertices, triangulate(vertices, corners, sizes)),))


@dataclass
class _Element:
    """One kind of row of a PLY file; properties: (name, type, type of the length where it is a
    list)."""

    name: str
    count: int
    properties: list[tuple[str, str, str | None]]


def read_ply(path: Path, data: bytes) -> RawMesh:
    """The one part of a PLY file, text or binary, with faces of any number of corners."""
    data = data.removeprefix(BYTE_ORDER_MARK)
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise InputError(f"{path}: not a PLY file: it has no header from 'ply' to 'end_header'")
    body = data[data.find(b"\n", end) + 1 :] if b"\n" in data[end:] else b""
    try:
        form, elements = _header(data[:end].decode("ascii", errors="replace"), len(body))
        rows = (
            _TextRows(body) if form == "ascii" else _BinaryRows(body, ">" if "big" in form else "<")
        )
        found = {element.name: rows.take(element) for element in elements}
        vertices = np.column_stack([found["vertex"][axis] for axis in "xyz"]).astype(np.float64)
        faces = found.get("face", {})
        names = [name for name in ("vertex_indices", "vertex_index") if name in faces]
        corners, sizes = (
            (faces[names[0]], faces[names[0] + " sizes"]) if names else (np.zeros(0), np.zeros(0))
        )
    except (ValueError, KeyError, IndexError, MemoryError, OverflowError) as error:
        raise InputError(
            f"{path}: broken or cut short PLY: {error or type(error).__name__}"
        ) from None
    return _one_part(path, "PLY", (vertices, _whole(path, corners), _whole(path, sizes)))


def _header(text: str, most: int) -> tuple[str, list[_Element]]:
    """The format and the elements that a header announces, none with more than `most` rows."""
    form = ""
    elements = []
    for words in (line.split() for line in text.splitlines()[1:]):
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2]), []))
            if not 0 <= elements[-1].count <= most:
                raise ValueError(
                    f"element {words[1]} has the count {words[2][:20]}, more than the file can hold"
                )
        elif words[:2] == ["property", "list"]:
            elements[-1].properties.append((words[4], _TYPES[words[3]], _TYPES[words[2]]))
        elif words[:1] == ["property"]:
            elements[-1].properties.append((words[2], _TYPES[words[1]], None))
        elif words and words[0] not in ("comment", "obj_info"):
            raise ValueError(f"unknown line in its header: {words[0][:30]!r}")
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"unknown format {form!r}")
    return form, elements


class _TextRows:
    """Takes elements from the text of a PLY file, number by number."""

    def __init__(self, body: bytes) -> None:
        self.numbers = np.array(body.split(), dtype=np.float64)
        self.at = 0

    def take(self, element: _Element) -> dict[str, Floats]:
        if not any(length for _, _, length in element.properties):
            return self._table(element)
        columns: dict[str, list[Floats]] = {name: [] for name, _, _ in element.properties}
        for _ in range(element.count):
            for name, _, length in element.properties:
                size = int(self._next(1)[0]) if length else 1
                columns[name].append(self._next(size))
        return _packed(element, columns)

    def _table(self, element: _Element) -> dict[str, Floats]:
        width = len(element.properties)
        table = self._next(element.count * width).reshape(element.count, width)
        return {name: table[:, k] for k, (name, _, _) in enumerate(element.properties)}

    def _next(self, count: int) -> Floats:
        if count < 0 or self.at + count > len(self.numbers):
            raise ValueError("it holds fewer numbers than its header announces")
        self.at += count
        return self.numbers[self.at - count : self.at]


class _BinaryRows:
    """Takes elements from the bytes of a PLY file: all rows at once where their lists are equally
    long."""

    def __init__(self, body: bytes, order: str) -> None:
        self.body = body
        self.order = order
        self.at = 0

    def take(self, element: _Element) -> dict[str, Floats]:
        if not element.count:
            return _packed(element, {name: [] for name, _, _ in element.properties})
        row = self._row(element, self.at)
        size = row.itemsize * element.count
        if self.at + size <= len(self.body):
            table = np.frombuffer(self.body, row, element.count, self.at)
            lists = [name for name, _, length in element.properties if length]
            if all((table[name + " size"] == table[name].shape[1]).all() for name in lists):
                self.at += size
                return self._columns(element, table)
        elif not any(length for _, _, length in element.properties):
            raise ValueError("it holds fewer bytes than its header announces")
        return self._one_by_one(element)

    def _row(self, element: _Element, at: int) -> np.dtype[np.void]:
        """The layout of the row that starts at byte `at`."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for name, kind, length in element.properties:
            if length:
                (size,) = np.frombuffer(self.body, self.order + length, 1, at)
                fields += [
                    (name + " size", self.order + length),
                    (name, self.order + kind, (int(size),)),
                ]
                at += np.dtype(length).itemsize + int(size) * np.dtype(kind).itemsize
            else:
                fields.append((name, self.order + kind))
                at += np.dtype(kind).itemsize
        if at > len(self.body):
            raise ValueError("it holds fewer bytes than its header announces")
        return np.dtype(fields)

    def _columns(
        self, element: _Element, table: np.ndarray[tuple[int], np.dtype[np.void]]
    ) -> dict[str, Floats]:
        columns = {
            name: table[name].astype(np.float64).ravel() for name, _, _ in element.properties
        }
        lists = [name for name, _, length in element.properties if length]
        return columns | {
            name + " sizes": table[name + " size"].astype(np.float64) for name in lists
        }

    def _one_by_one(self, element: _Element) -> dict[str, Floats]:
        columns: dict[str, list[Floats]] = {name: [] for name, _, _ in element.properties}
        for _ in range(element.count):
            row = self._row(element, self.at)
            (values,) = np.frombuffer(self.body, row, 1, self.at)
            for name, _, _ in element.properties:
                columns[name].append(np.atleast_1d(values[name]).astype(np.float64))
            self.at += row.itemsize
        return _packed(element, columns)


def _packed(element: _Element, columns: dict[str, list[Floats]]) -> dict[str, Floats]:
    """Each property's values end to end; for a list, also how many belong to each row."""
    packed = {name: np.concatenate([np.zeros(0), *values]) for name, values in columns.items()}
    lists = [name for name, _, length in element.properties if length]
    return packed | {
        name + " sizes": np.array([len(v) for v in columns[name]], dtype=np.float64)
        for name in lists
    }
