"""The parts of an environment from the parts of its mesh: pieces split off, parts left out, joined
and renamed.

Every face keeps its number, so that who knows a face of the mesh knows its part, whatever that is
called.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.meshes.parts import RawMesh, RawPart, weld
from workbench.geometry.components import component_labels
from workbench.model.arrays import Ints

__all__ = [
    "MOST_PIECES",
    "FaceParts",
    "arranged_mesh",
    "face_parts",
    "is_piece",
    "matching_parts",
    "pieces",
]

MOST_PIECES = 1000
"""Pieces that one part may be split into: a mesh of loose triangles has no parts."""


@dataclass(frozen=True, eq=False)
class FaceParts:
    """The part of each face of a mesh.

    Parameters
    ----------
    names
        The parts that are in the environment.
    part
        (T,) index into `names` of each face, part after part of the mesh; -1 where it is left out.
    """

    names: tuple[str, ...]
    part: Ints


def matching_parts(key: str, names: Iterable[str]) -> list[str]:
    """The parts a key means: the one of that name, else those the pattern fits."""
    known = list(names)
    return [key] if key in known else [name for name in known if fnmatchcase(name, key)]


def is_piece(name: str, split: Iterable[str]) -> bool:
    """Whether a name is that of a numbered piece of a part that is split, by names or patterns of
    such parts."""
    stem, _, number = name.rpartition("_")
    return number.isdigit() and any(fnmatchcase(stem, key) for key in split)


def pieces(part: RawPart) -> Ints:
    """Number the connected pieces of a part, in the order of their first faces.

    Returns
    -------
    Ints
        (T,) the piece of each face, from 0. Faces that share a corner are of one piece.
    """
    a, b, c = part.faces.T
    ends = np.concatenate([a, b]), np.concatenate([b, c])
    label = component_labels(ends[0], ends[1], len(part.vertices))[a]
    order, first = np.unique(label, return_index=True)
    rank = np.empty(int(order.max(initial=-1)) + 1, dtype=np.int64)
    rank[order[np.argsort(first)]] = np.arange(len(order))
    return rank[label]


def face_parts(
    raw: RawMesh, split: Sequence[str], drop: Sequence[str], join: Mapping[str, Sequence[str]]
) -> FaceParts:
    """Find the part of each face of a mesh.

    Parameters
    ----------
    raw
        The mesh.
    split
        Names or patterns of parts that are split into their connected pieces, which are called
        NAME_1, NAME_2 and so on in the order of their first faces.
    drop
        Names or patterns of parts, after the split, that are left out.
    join
        By a new name the names or patterns of parts, after the split, that become one; of one part
        alone a new name.

    Raises
    ------
    InputError
        If no part has a name, a part has two new names, a name is taken, a part falls into too many
        pieces, or nothing is left.
    """
    names = [part.name for part in raw.parts]
    owner = np.repeat(np.arange(len(names)), [len(part.faces) for part in raw.parts])
    names, owner = _split(raw, names, owner, split)
    left = [name for name in names if name not in _meant("drop", drop, names)]
    if not left:
        raise InputError("drop: nothing is left of the mesh")
    called: dict[str, str] = {}
    for new, keys in join.items():
        members = _meant(f"join: {new}", keys, left)
        if new in left and new not in members:
            raise InputError(f"join: there is a part {new!r} already; take another name")
        for name in members:
            if name in called:
                raise InputError(f"join: part {name!r} is in {called[name]!r} and in {new!r}")
            called[name] = new
    called = {name: called.get(name, name) for name in left}
    final = list(dict.fromkeys(called.values()))
    index = {name: final.index(new) for name, new in called.items()}
    part = np.array([index.get(name, -1) for name in names], dtype=np.int64)
    return FaceParts(tuple(final), part[owner])


def _split(
    raw: RawMesh, names: list[str], owner: Ints, split: Sequence[str]
) -> tuple[list[str], Ints]:
    """Names, and the name of each face by its number, with some parts in pieces."""
    wanted = _meant("split", split, names)
    found: list[str] = []
    number = np.empty_like(owner)
    for k, part in enumerate(raw.parts):
        faces = owner == k
        piece = pieces(part) if part.name in wanted else np.zeros(len(part.faces), dtype=np.int64)
        count = int(piece.max()) + 1
        if count > MOST_PIECES:
            raise InputError(
                f"split: part {part.name!r} falls into {count} pieces, and {MOST_PIECES} are "
                f"possible: its triangles are not connected"
            )
        number[faces] = len(found) + piece
        found += [part.name] if count == 1 else _piece_names(part.name, count, names)
    return found, number


def _piece_names(name: str, count: int, taken: Sequence[str]) -> list[str]:
    """Names of the pieces of a part; a number that is in another part's name is passed over."""
    named: list[str] = []
    k = 1
    while len(named) < count:
        if f"{name}_{k}" not in taken:
            named.append(f"{name}_{k}")
        k += 1
    return named


def _meant(what: str, keys: Sequence[str], names: Sequence[str]) -> list[str]:
    """The parts that keys mean. InputError where one means none."""
    found: dict[str, None] = {}
    for key in keys:
        matched = matching_parts(key, names)
        if not matched:
            raise InputError(f"{what}: no part of the name {key!r}; {one_of(key, names)}")
        found |= dict.fromkeys(matched)
    return list(found)


def arranged_mesh(
    raw: RawMesh, split: Sequence[str], drop: Sequence[str], join: Mapping[str, Sequence[str]]
) -> RawMesh:
    """Return a mesh with other parts; the same where nothing is asked. Arguments and errors as of
    `face_parts`."""
    if not (split or drop or join):
        return raw
    of = face_parts(raw, split, drop, join)
    first = np.cumsum([0, *(len(part.vertices) for part in raw.parts)])
    vertices = np.concatenate([part.vertices for part in raw.parts])
    faces = np.concatenate(
        [part.faces + start for part, start in zip(raw.parts, first, strict=False)]
    )
    parts = tuple(
        RawPart(name, *weld(vertices, faces[of.part == k])) for k, name in enumerate(of.names)
    )
    return replace(raw, parts=parts)
