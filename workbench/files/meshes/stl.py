"""STL, binary and text. A binary file is one part, each solid of a text file is one."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.opening import BYTE_ORDER_MARK

__all__ = ["read_stl"]

_HEAD = 84
"""Bytes before the triangles of a binary file: a free text and the number of triangles."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_WORDS = ("facet", "outer", "endloop", "endfacet")
_LINE_END = re.compile(r"\r\n|\n|\r")


def read_stl(path: Path, data: bytes) -> RawMesh:
    """The solids of an STL file. InputError where it is cut short; in a text file it says the
    line."""
    count = int.from_bytes(data[80:84], "little") if len(data) >= _HEAD else -1
    if count >= 0 and len(data) == _HEAD + _TRIANGLE.itemsize * count:
        corners = np.frombuffer(data, _TRIANGLE, count, _HEAD)["corners"]
        faces = np.arange(3 * count).reshape(-1, 3)
        return RawMesh(
            str(path), "STL", (RawPart("", corners.reshape(-1, 3).astype(np.float64), faces),)
        )
    text = data.removeprefix(BYTE_ORDER_MARK)
    if text.lstrip()[:5].lower() == b"solid" and b"\0" not in text[:80].rstrip(b"\0 "):
        return _text_solids(path, text)
    raise InputError(
        f"{path}: not an STL file, or cut short: {len(data)} bytes, {_HEAD + 50 * count} are announced"
    )


def _text_solids(path: Path, data: bytes) -> RawMesh:
    solids: list[tuple[str, list[list[str]], int]] = []
    open_solid = False
    for number, line in enumerate(_LINE_END.split(data.decode("utf-8", errors="replace")), start=1):
        words = line.split()
        key = words[0].lower() if words else ""
        if key == "solid":
            solids.append((" ".join(words[1:]), [], number))
            open_solid = True
        elif key == "endsolid":
            open_solid = False
        elif key == "vertex" and open_solid and len(words) == 4:
            solids[-1][1].append(words[1:])
        elif key and not (open_solid and key in _WORDS):
            raise InputError(
                f"{path}:{number}: not a line of a text STL file ({line.strip()[:40]!r})"
            )
    if open_solid or not solids:
        raise InputError(f"{path}: cut short: solid {solids[-1][0] if solids else ''!r} has no end")
    return RawMesh(str(path), "STL", tuple(_solid(path, solid) for solid in solids if solid[1]))


def _solid(path: Path, solid: tuple[str, list[list[str]], int]) -> RawPart:
    name, corners, line = solid
    if len(corners) % 3:
        raise InputError(
            f"{path}:{line}: solid {name!r}: {len(corners)} vertices do not make triangles"
        )
    try:
        vertices = np.array(corners, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"{path}:{line}: solid {name!r}: a number is needed: {error}") from None
    return RawPart(name, vertices, np.arange(len(vertices)).reshape(-1, 3))
