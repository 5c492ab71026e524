"""Limit the memory that a mesh file may need, before it is allocated."""

from __future__ import annotations

import os
from pathlib import Path

from workbench.errors import InputError
from workbench.model.arrays import Ints

__all__ = ["MAX_CORNERS", "MAX_INSTANCES", "check_corners", "check_faces", "free_memory"]

MAX_CORNERS = 10_000
"""Largest number of corners of a face. The time to triangulate one grows with their square: 2 s for
a self-crossing one of this size."""
MAX_INSTANCES = 100_000
"""Largest number of nodes or components placed: nested ones can repeat one any number of times."""
_FACE_BYTES = 1100
"""Bytes that a triangle takes until it is part of an environment (measured on meshes of a million
triangles)."""
_CORNER_BYTES = 96
"""Bytes that an unused corner takes: its coordinates, a few times over."""


def free_memory() -> int | None:
    """Return the available memory [bytes], with what caches would release; None if unknown."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        return None


def check_faces(path: Path, faces: int, corners: int) -> None:
    """Refuse a file that places more triangles and corners than there is memory for.

    Copies add almost nothing to the size of a file, so this is checked before they are made.
    """
    need = faces * _FACE_BYTES + corners * _CORNER_BYTES
    have = free_memory()
    if have is not None and need > have:
        raise InputError(
            f"{path}: places {faces} triangles with {corners} corners, which need up to {need / 2**30:.1f} GiB of "
            f"memory, {have / 2**30:.1f} GiB are free: simplify the mesh or split it"
        )


def check_corners(path: Path, counts: Ints) -> None:
    """Refuse faces with more corners than `MAX_CORNERS`; counts: the corners of each face."""
    most = int(counts.max(initial=0))
    if most > MAX_CORNERS:
        raise InputError(
            f"{path}: a face has {most} corners, at most {MAX_CORNERS} are read: export it as triangles"
        )
