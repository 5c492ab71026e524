"""Read Wavefront OBJ.

Objects (`o`) and groups (`g`) become parts; faces of one name are one part wherever they stand.
Materials are never opened. trimesh is not used: it merges the objects, loses their names, counts
negative indices from the wrong end if objects follow one another, and folds concave faces.

References
----------
Wavefront, Advanced Visualizer manual, appendix B1.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath

import numpy as np

from workbench.errors import InputError
from workbench.files.file_errors import BYTE_ORDER_MARK
from workbench.files.meshes.parts import MAX_CORNERS, RawMesh, RawPart, triangulate
from workbench.model.arrays import Floats

__all__ = ["outside_folder", "read_obj"]

_SKIPPED = frozenset(
    [
        "vt",
        "vn",
        "vp",
        "s",
        "mg",
        "mtllib",
        "usemtl",
        "usemap",
        "maplib",
        "lod",
        "bevel",
        "c_interp",
        "d_interp",
        "shadow_obj",
        "trace_obj",
    ]
)
_NAMES = ("o", "g")
_CURVES = frozenset(
    [
        "l",
        "p",
        "ctech",
        "stech",
        "cstype",
        "deg",
        "bmat",
        "step",
        "curv",
        "curv2",
        "surf",
        "parm",
        "trim",
        "hole",
        "scrv",
        "sp",
        "end",
        "con",
    ]
)
_LINE_END = re.compile(r"\r\n|\n|\r")
_MAX_INDEX = 2**40
"""Largest index: more vertices than a file can have, and still fit for an array."""


def read_obj(path: Path, data: bytes) -> RawMesh:
    """Read the parts of an OBJ file, in its own units.

    The name of an object or group is all that follows on its line, `#` included: exporters number
    copies so ("seat #2"), and a name cut there would make one part of two.

    Raises
    ------
    InputError
        With file and line, if the file is broken.
    """
    reader = _Reader(path)
    for number, words in _lines(path, data):
        reader.take(number, words)
    return reader.finished(whole=data.endswith((b"\n", b"\r")))


def outside_folder(reference: str) -> bool:
    """Return whether a file name inside a mesh file leads out of its folder, or onto the network."""
    name = reference.strip().strip('"')
    if "://" in name or name.startswith(("\\\\", "//", "file:")):
        return True
    steps = PurePosixPath(name.replace("\\", "/"))
    return steps.is_absolute() or PureWindowsPath(name).drive != "" or ".." in steps.parts


def _lines(path: Path, data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yield number and words of each line, with continued lines joined and comments removed."""
    if b"\0" in data:
        raise InputError(f"{path}: not an OBJ file: it holds bytes that are not text")
    continued: list[str] = []
    text = data.removeprefix(BYTE_ORDER_MARK).decode("utf-8", errors="replace")
    for number, line in enumerate(_LINE_END.split(text), start=1):
        words = line.split()
        if words and words[0] not in _NAMES:
            words = line.partition("#")[0].split()
        if words and words[-1].endswith("\\"):
            continued += [*words[:-1], words[-1][:-1]]
            continue
        if continued or words:
            yield number, [word for word in continued + words if word]
        continued = []


class _Reader:
    """Collects vertices and faces line by line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.vertices = array("d")
        self.corners: dict[str, array[int]] = {}
        self.counts: dict[str, array[int]] = {}
        self.object = self.group = ""
        self.curves = 0

    def take(self, number: int, words: list[str]) -> None:
        """Read a line."""
        key = words[0]
        if key == "v":
            self._vertex(number, words[1:])
        elif key in ("f", "fo"):
            self._face(number, words[1:])
        elif key in _NAMES:
            self._name(key, " ".join(words[1:]))
        elif key == "call":
            raise self._wrong(number, "includes another file; put everything in one file")
        elif key in _CURVES:
            self.curves += 1
        elif key not in _SKIPPED:
            raise self._wrong(number, f"not a line of an OBJ file (begins with {key[:30]!r})")

    def _vertex(self, number: int, words: list[str]) -> None:
        try:
            x, y, z = words[:3]
            self.vertices.extend((float(x), float(y), float(z)))
        except ValueError:
            raise self._wrong(
                number, f"a vertex needs three numbers (got {' '.join(words)[:60]!r})"
            ) from None

    def _face(self, number: int, words: list[str]) -> None:
        line = " ".join(words)[:60]
        vertex_count = len(self.vertices) // 3
        try:
            given = [int(word.partition("/")[0]) for word in words]
        except ValueError:
            raise self._wrong(number, f"a face needs whole numbers (got {line!r})") from None
        # indices count from 1, negative ones back from the last vertex
        corners = [index - 1 if index > 0 else vertex_count + index for index in given]
        if len(corners) < 3 or 0 in given or min(corners) < 0:
            raise self._wrong(number, f"a face needs three vertices that are there (got {line!r})")
        self._check_face(number, corners)
        part = self._part()
        self.corners.setdefault(part, array("q")).extend(corners)
        self.counts.setdefault(part, array("q")).append(len(corners))

    def _check_face(self, number: int, corners: list[int]) -> None:
        """Refuse indices and faces that are too large."""
        if max(corners) > _MAX_INDEX:
            raise self._wrong(
                number, f"a face names vertex {str(max(corners) + 1)[:20]}, which no file can hold"
            )
        if len(corners) > MAX_CORNERS:
            raise self._wrong(
                number,
                f"a face has {len(corners)} corners, at most {MAX_CORNERS} are read: "
                "export it as triangles",
            )

    def _name(self, key: str, name: str) -> None:
        if key == "o":
            self.object = name
            self.group = ""
        else:
            self.group = "" if name in ("default", "off") else name

    def _part(self) -> str:
        """Return the name of the part that faces now belong to.

        Exporters often repeat the object's name in its groups.
        """
        if self.object and self.group and not self.group.startswith(self.object):
            return f"{self.object}_{self.group}"
        return self.group or self.object

    def _wrong(self, number: int, what: str) -> InputError:
        return InputError(f"{self.path}:{number}: {what}")

    def finished(self, *, whole: bool) -> RawMesh:
        """Return the mesh; whole: whether the last line has an end."""
        vertices = np.frombuffer(self.vertices, dtype=np.float64).reshape(-1, 3)
        notes = []
        if self.curves:
            notes.append(
                f"{self.curves} lines of curves or points are not surfaces and are left out"
            )
        if not whole:
            notes.append("the last line has no end: the file may be cut short")
        parts = tuple(self._surface(name, vertices) for name in self.corners)
        return RawMesh(str(self.path), "OBJ", parts, notes=tuple(notes))

    def _surface(self, name: str, vertices: Floats) -> RawPart:
        """Return the faces of a part; vertices (V, 3): of the whole file."""
        corners = np.frombuffer(self.corners[name], dtype=np.int64)
        if corners.max() >= len(vertices):
            raise InputError(
                f"{self.path}: part {name!r}: a face names vertex {corners.max() + 1}, "
                f"and there are {len(vertices)}"
            )
        used, corners = np.unique(corners, return_inverse=True)
        counts = np.frombuffer(self.counts[name], dtype=np.int64)
        return RawPart(name, vertices[used], triangulate(vertices[used], corners, counts))
