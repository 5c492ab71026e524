"""The figures of a seat whose cushion and back are named: found as if both had been clicked on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.bare_mesh import placed_file
from workbench.files.catalogue import find
from workbench.files.names import unique_names
from workbench.files.seat_doubts import rest_lines
from workbench.files.seat_search import PartFaces, found_seat
from workbench.model.arrays import xyz
from workbench.study.describe.edits_files import added_file, framed, moved_file
from workbench.study.describe.edits_seats import faced
from workbench.study.describe.meshes import Ray
from workbench.study.describe.saving import description_text
from workbench.study.describe.state import (
    INNER,
    SURFACES,
    Description,
    OpenPlace,
    figures_of,
    fitted_seat,
    open_place,
    standing_of,
)

__all__ = ["NamedSeat", "named_seat"]


@dataclass(frozen=True)
class NamedSeat:
    """A seat as its cushion and back give it.

    Parameters
    ----------
    lines
        What an environment's file says of it, in YAML: for a bare mesh the whole file, for an
        environment the seat and its parts.
    checks
        What was measured of it, in sentences.
    doubts
        What is odd about it.
    """

    lines: str
    checks: tuple[str, ...]
    doubts: tuple[str, ...]


def named_seat(
    sources: Sequence[str | Path],
    cushion: str,
    back: str,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> NamedSeat:
    """Compute the figures of a seat of an environment or of bare meshes.

    Parameters
    ----------
    sources
        The file or folder of an environment or its name in the catalogue, or mesh files as of `read_bare`.
    cushion, back
        Names of parts, as describing by pointing has them; one name for both where they are one part.
    length, up, forward
        Of bare meshes, as of `read_bare`.

    Raises
    ------
    InputError
        If something cannot be read, a part is not there, or the two are no seat's.
    """
    files = [placed_file(source) for source in sources]
    first = files[0][0]
    opened = open_place(first if first.exists() else find("environments", str(first), INNER))
    description = opened.start
    for row, (path, move) in enumerate(files):
        if row:
            added = added_file(opened, description, path)
            opened = added.opened
            description = added.edit.description
        if any(move) or (row and any(files[0][1])):
            description = moved_file(opened, description, row, move).description
        if (length, up, forward) != (None, None, None):
            frame = {"length": length, "up": up, "forward": forward}
            description = framed(opened, description, row, frame).description
    stands = standing_of(opened, description)
    names = stands.names
    for part in (cushion, back):
        if part not in names:
            raise InputError(f"there is no part {part!r}; {one_of(part, names)}")
    seats = list(description.says.get("seats") or {})
    name = unique_names([*seats, "seat"], "seat")[-1]
    found = found_seat(*(PartFaces(part, stands.part_corners(part)) for part in (cushion, back)))
    for surface, part, met in (("cushion", cushion, found.cushion), ("back", back, found.back)):
        ray = Ray(part, xyz(met.point - met.way), xyz(met.way), 1.0)
        description = faced(opened, description, name, surface, ray).description
    return _told(opened, description, name)


def _told(opened: OpenPlace, description: Description, name: str) -> NamedSeat:
    """What there is to say about a seat that is in a description."""
    figures = figures_of(opened, description, name)
    stands = standing_of(opened, description)
    seat = description.says["seats"][name]
    parts = {seat[surface]["part"] for surface in SURFACES}
    checks = rest_lines(
        fitted_seat(name, figures), figures.cushion_sides, figures.back_sides, stands.ground
    )
    if opened.text is not None:
        rules = {key: rule for key, rule in description.says["parts"].items() if key in parts}
        description = replace(description, says={"parts": rules, "seats": {name: seat}})
    lines = description_text(description, None)
    return NamedSeat(lines, (*checks, *figures.notes), figures.doubts)
