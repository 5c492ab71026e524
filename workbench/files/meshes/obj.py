"""Wavefront OBJ, read here and not by trimesh, which merges the objects, loses their names, counts
negative indices from the wrong end where objects follow one another, and folds concave faces.

Objects (`o`) and groups (`g`) become parts; faces of one name are one part wherever they stand.
Materials are never opened. Source of the format: Wavefront, Advanced Visualizer manual, appendix
B1.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.bounds import MAX_CORNERS
from workbench.files.meshes.parts import RawMesh, RawPart, triangulate
from workbench.files.opening import BYTE_ORDER_MARK

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
_LARGEST_INDEX = 2**40
"""Vertices that a file cannot have; the number of a larger index would not fit into an array."""


def read_obj(path: Path, data: bytes) -> RawMesh:
    """The parts of an OBJ file, in its own units. InputError says file and line.

    The name of an object or group is all that follows on its line, `#` included: exporters number
    copies so ("seat #2"), and a name cut there would make one part of two.
    """
    reader = _Reader(path)
    for number, words in _lines(path, data):
        reader.take(number, words)
    return reader.finished(whole=data.endswith((b"\n", b"\r")))


def outside_folder(reference: str) -> bool:
    """Whether a file name inside a mesh file leads out of the folder of that file, or onto the
    network."""
    name = reference.strip().strip('"')
    if "://" in name or name.startswith(("\\\\", "//", "file:")):
        return True
    steps = PurePosixPath(name.replace("\\", "/"))
    return steps.is_absolute() or PureWindowsPath(name).drive != "" or ".." in steps.parts


def _lines(path: Path, data: bytes) -> Iterator[tuple[int, list[str]]]:
    if b"\0" in data:
        raise InputError(f"{path}: not an OBJ file: it holds bytes that are not text")
    held: list[str] = []
    text = data.removeprefix(BYTE_ORDER_MARK).decode("utf-8", errors="replace")
    for number, line in enumerate(_LINE_END.split(text), start=1):
        words = line.split()
        if words and words[0] not in _NAMES:
            words = line.partition("#")[0].split()
        if words and words[-1].endswith("\\"):
            held += [*words[:-1], words[-1][:-1]]
            continue
        if held or words:
            yield number, [word for word in held + words if word]
        held = []


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
        have = len(self.vertices) // 3
        try:
            given = [int(word.partition("/")[0]) for word in words]
        except ValueError:
            raise self._wrong(
                number, f"a face needs whole numbers (got {' '.join(words)[:60]!r})"
            ) from None
        corners = [index - 1 if index > 0 else have + index for index in given]
        if len(corners) < 3 or 0 in given or min(corners) < 0:
            raise self._wrong(
                number, f"a face needs three vertices that are there (got {' '.join(words)[:60]!r})"
            )
        if max(corners) > _LARGEST_INDEX:
            raise self._wrong(
                number, f"a face names vertex {str(max(corners) + 1)[:20]}, which no file can hold"
            )
        if len(corners) > MAX_CORNERS:
            raise self._wrong(
                number,
                f"a face has {len(corners)} corners, at most {MAX_CORNERS} are read: "
                "export it as triangles",
            )
        part = self._part()
        self.corners.setdefault(part, array("q")).extend(corners)
        self.counts.setdefault(part, array("q")).append(len(corners))

    def _name(self, key: str, name: str) -> None:
        if key == "o":
            self.object = name
            self.group = ""
        else:
            self.group = "" if name in ("default", "off") else name

    def _part(self) -> str:
        """The name of the part that faces now belong to: exporters often repeat the object's name
        in its groups."""
        if self.object and self.group and not self.group.startswith(self.object):
            return f"{self.object}_{self.group}"
        return self.group or self.object

    def _wrong(self, number: int, what: str) -> InputError:
        return InputError(f"{self.path}:{number}: {what}")

    def finished(self, *, whole: bool) -> RawMesh:
        vertices = np.frombuffer(self.vertices, dtype=np.float64).reshape(-1, 3)
        parts = []
        for name, flat in self.corners.items():
            corners = np.frombuffer(flat, dtype=np.int64)
            if corners.max() >= len(vertices):
                raise InputError(
                    f"{self.path}: part {name!r}: a face names vertex {corners.max() + 1}, "
                    f"and there are {len(vertices)}"
                )
            used, corners = np.unique(corners, return_inverse=True)
            counts = np.frombuffer(self.counts[name], dtype=np.int64)
            parts.append(
                RawPart(name, vertices[used], triangulate(vertices[used], corners, counts))
            )
        notes = (
            [f"{self.curves} lines of curves or points are not surfaces and are left out"]
            if self.curves
            else []
        )
        notes += [] if whole else ["the last line has no end: the file may be cut short"]
        return RawMesh(str(self.path), "OBJ", tuple(parts), notes=tuple(notes))
