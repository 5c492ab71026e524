"""Read STL, binary and text. A binary file is one part, each solid of a text file is one."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.errors import InputError, printable
from workbench.files.file_errors import BYTE_ORDER_MARK
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.model.arrays import Floats

__all__ = ["read_stl"]

_HEAD = 84
"""Bytes before the triangles of a binary file: a free text and the number of triangles."""
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_WORDS = ("facet", "outer", "endloop", "endfacet")
_BEGIN = 4096
_TEXT = re.compile(rb"facet|endsolid")
"""Words of which a text file has one in its first `_BEGIN` bytes."""
_LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass
class _Solid:
    """A solid of a text file."""

    name: str
    line: int
    """Number of its first line."""
    corners: list[list[str]] = field(default_factory=list)
    """Three words for each corner."""


def read_stl(path: Path, data: bytes) -> RawMesh:
    """Read the solids of an STL file.

    Raises
    ------
    InputError
        If it is cut short or broken; in a text file with the line.
    """
    count = int.from_bytes(data[80:84], "little") if len(data) >= _HEAD else -1
    size = _HEAD + _TRIANGLE.itemsize * count
    text = data.removeprefix(BYTE_ORDER_MARK)
    is_text = text.lstrip()[:5].lower() == b"solid" and _TEXT.search(text[:_BEGIN].lower())
    if count >= 0 and (len(data) == size or (len(data) > size and count and not is_text)):
        corners = np.frombuffer(data, _TRIANGLE, count, _HEAD)["corners"]
        part = _triangle_soup("", corners.reshape(-1, 3).astype(np.float64))
        more = len(data) - size
        notes = (f"{more} bytes behind its {count} triangles are left out",) if more else ()
        return RawMesh(str(path), "STL", (part,), notes=notes)
    if is_text:
        solids = _text_solids(path, text)
        parts = tuple(_part(path, solid) for solid in solids if solid.corners)
        return RawMesh(str(path), "STL", parts)
    raise InputError(
        f"{path}: not an STL file, or cut short: {len(data)} bytes, {_HEAD + 50 * count} are announced"
    )


def _triangle_soup(name: str, corners: Floats) -> RawPart:
    """Return a part of triangles that share no vertices, from their corners (3 T, 3)."""
    return RawPart(name, corners, np.arange(len(corners)).reshape(-1, 3))


def _text_solids(path: Path, data: bytes) -> list[_Solid]:
    solids: list[_Solid] = []
    inside = False
    for number, line in enumerate(_LINE_END.split(data.decode("utf-8", errors="replace")), start=1):
        words = line.split()
        key = words[0].lower() if words else ""
        if key == "solid":
            solids.append(_Solid(" ".join(words[1:]), number))
            inside = True
        elif key == "endsolid":
            inside = False
        elif key == "vertex" and inside and len(words) == 4:
            solids[-1].corners.append(words[1:])
        elif key and not (inside and key in _WORDS):
            raise InputError(
                f"{path}:{number}: not a line of a text STL file ({printable(line.strip()[:40])})"
            )
    if inside or not solids:
        name = solids[-1].name if solids else ""
        raise InputError(f"{path}: cut short: solid {name!r} has no end")
    return solids


def _part(path: Path, solid: _Solid) -> RawPart:
    here = f"{path}:{solid.line}: solid {solid.name!r}"
    if len(solid.corners) % 3:
        raise InputError(f"{here}: {len(solid.corners)} vertices do not make triangles")
    try:
        return _triangle_soup(solid.name, np.array(solid.corners, dtype=np.float64))
    except ValueError as error:
        raise InputError(f"{here}: a number is needed: {error}") from None
