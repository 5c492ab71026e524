"""Limits of what a mesh file may ask for, checked before memory is taken."""

from __future__ import annotations

import os
from pathlib import Path

from workbench.errors import InputError
from workbench.model.arrays import Ints

__all__ = ["MAX_CORNERS", "MAX_INSTANCES", "check_corners", "check_faces", "free_memory"]

MAX_CORNERS = 10_000
"""Corners of one face at most. The time to triangulate one grows with their square: 2 s for a
tangle of as many."""
MAX_INSTANCES = 100_000
"""Nodes or components placed at most: those within others can name one any number of times."""
_FACE_BYTES = 1100
"""Memory that a triangle takes until it is part of an environment (measured on meshes of a million
triangles)."""
_CORNER_BYTES = 96
"""Memory that a corner takes which no triangle names: its coordinates, a few times over."""


def free_memory() -> int | None:
    """Bytes of memory that can be had, with what the system would give back from its caches; None
    where unknown."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        return None


def check_faces(path: Path, faces: int, corners: int) -> None:
    """Raise InputError if a file places more triangles, or corners, than there is memory for.

    Copies cost a file next to nothing, so this is asked before they are made.
    """
    need = faces * _FACE_BYTES + corners * _CORNER_BYTES
    have = free_memory()
    if have is not None and need > have:
        raise InputError(
            f"{path}: places {faces} triangles with {corners} corners, which need up to {need / 2**30:.1f} GiB of "
            f"memory, {have / 2**30:.1f} GiB are free: simplify the mesh or split it"
        )


def check_corners(path: Path, counts: Ints) -> None:
    """Raise InputError if a face (counts: the corners of each) has more than `MOST_CORNERS`."""
    most = int(counts.max(initial=0))
    if most > MAX_CORNERS:
        raise InputError(
            f"{path}: a face has {most} corners, at most {MAX_CORNERS} are read: export it as triangles"
        )
