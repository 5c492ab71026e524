"""What the page is sent that describes an environment: lengths in metres, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from workbench.draw.scene import Colour
from workbench.draw.web.place_mesh import CONTROL_PART, GLASS_PART, PLAIN_PART, SEAT_PART, ThinMesh
from workbench.draw.web.views import WebPlace
from workbench.errors import InputError
from workbench.files.environment_controls import found_controls
from workbench.files.environment_parts import MOST_PIECES, matching_parts
from workbench.files.environment_schema import EnvironmentFile, PartFile
from workbench.files.environments import part_rules
from workbench.live.describe_protocol import GRIPS, UNITS, ZONES
from workbench.live.protocol import packed
from workbench.model.arrays import Floats
from workbench.study.describe.edits_files import AXES
from workbench.study.describe.edits_parts import large_part, left_out
from workbench.study.describe.state import (
    Description,
    OpenPlace,
    figures_of,
    open_sizes,
    standing_of,
)

__all__ = ["describe_hello", "description_frame", "drawn_place"]

MOST_LINES = 20_000
"""Border lines of what was picked that are sent."""


def describe_hello(opened: OpenPlace, person: str, *, saves: bool) -> bytes:
    """Pack what stays as long as an environment is open."""
    meshes = [
        {"file": raw.file, "format": raw.format, "unit": raw.metres, "up": raw.up}
        for raw in opened.meshes.raws
    ]
    return packed(
        {
            "kind": "hello",
            "file": opened.target.name,
            "folder": opened.target.absolute().parent.name,
            "saves": saves,
            "new": opened.text is None,
            "person": person,
            "meshes": meshes,
            "units": UNITS,
            "axes": AXES,
            "grips": GRIPS,
            "zones": ZONES,
        }
    )


def description_frame(
    opened: OpenPlace, description: Description, head: Mapping[str, Any]
) -> bytes:
    """Pack a description: what is in it, how it was got, and the borders of what was picked."""
    file = description.file
    stands = standing_of(opened, description)
    rules = part_rules(file, stands.names)
    count = np.bincount(stands.part[stands.part >= 0], minlength=len(stands.names))
    size = stands.boxes[:, 1] - stands.boxes[:, 0]
    parts = [
        {
            "name": name,
            "faces": int(count[k]),
            "size": _rounded(size[k]),
            "at": _rounded(stands.boxes[k].mean(axis=0)),
            "hidden": rules[k].hidden,
            "see_through": rules[k].see_through,
            "solid": rules[k].solid,
        }
        for k, name in enumerate(stands.names)
    ]
    seats = [_seat(opened, description, name) for name in _seat_names(description)]
    hidden = [name for name, rule in zip(stands.names, rules, strict=True) if rule.hidden]
    found = found_controls(file, stands.touching, hidden)
    sent = {
        "kind": "description",
        **head,
        "name": description.says["environment"],
        "length": description.says["length"],
        "meshes": [_mesh(opened, description, row) for row in range(len(file.meshes))],
        "sizes": [
            {"words": doubt.words, "about": doubt.about}
            for doubt in open_sizes(opened, description)
        ],
        "size": _rounded(stands.bounds[1] - stands.bounds[0]),
        "parts": parts,
        "large": _large(opened, description),
        "left": [{"row": row, "name": name} for row, name in left_out(description)],
        "seats": seats,
        "controls": [
            {
                "name": one.name,
                "at": _rounded(one.at),
                "grip": one.grip,
                "zone": one.zone,
                "part": one.part,
                "pieces": [asdict(piece) for piece in one.pieces],
                "stated": file.controls[one.name].part != one.part,
                "how": description.why.get(("controls", one.name), ""),
            }
            for one in found.controls
        ],
        "points": [
            {"name": name, "at": _rounded(at), "how": description.why.get(("points", name), "")}
            for name, at in file.points.items()
        ],
        "adjustments": list(file.adjustments),
    }
    arrays = []
    for k, name in enumerate(_seat_names(description)):
        for surface in ("cushion", "back"):
            lines = _borders(opened, description, name, surface)
            arrays.append((f"{surface}{k}", lines.astype(np.float32)))
    return packed(sent, arrays)


def _large(opened: OpenPlace, description: Description) -> dict[str, Any] | None:
    """The part that is better split before anything is picked."""
    found = large_part(opened, description)
    if found is None:
        return None
    can = found.pieces <= MOST_PIECES
    return {"name": found.name, "share": found.share, "pieces": found.pieces, "can": can}


def _seat_names(description: Description) -> list[str]:
    """Seats that are in the environment, then those of which something was picked."""
    return list(dict.fromkeys([*description.file.seats, *description.picks]))


def _mesh(opened: OpenPlace, description: Description, row: int) -> dict[str, Any]:
    """Unit and axes of a mesh as they are taken."""
    raw = opened.meshes.raws[row]
    mesh = description.file.meshes[row]
    return {
        "file": mesh.file,
        "length": mesh.length or _unit_name(raw.metres),
        "up": mesh.up or raw.up,
        "forward": mesh.forward or raw.forward,
        "move": _rounded(mesh.move),
        "how": [
            description.why.get(("meshes", row, key), "") for key in ("length", "up", "forward")
        ],
    }


def _unit_name(metres: float | None) -> str:
    return "" if metres is None else f"{1e3 * metres:.9g} mm"


def _seat(opened: OpenPlace, description: Description, name: str) -> dict[str, Any]:
    """A seat in numbers, and what was picked of it."""
    picks = description.picks.get(name)
    found: dict[str, Any] = {"name": name, "there": name in description.file.seats}
    found |= {"doubts": [], "notes": []}
    for surface in ("cushion", "back"):
        found[f"{surface}_faces"] = 0
        if picks is not None and picks.faces(surface):
            found[f"{surface}_faces"] = len(opened.meshes.grown(picks.faces(surface)))
    if picks is not None and picks.cushion and picks.back:
        try:
            figures = figures_of(opened, description, name)
            found |= {"doubts": list(figures.doubts), "notes": list(figures.notes)}
        except InputError as error:
            found["doubts"] = [str(error)]
    if not found["there"]:
        return found
    seat = description.file.seats[name]
    return found | {
        "srp": _rounded(seat.srp),
        "cushion_angle": _degrees(seat.cushion_angle),
        "back_angle": _degrees(seat.back_angle),
        "yaw": _degrees(seat.yaw),
        "cushion": seat.cushion.part,
        "back": seat.back.part,
        "cushion_depth": round(seat.cushion.depth, 6),
        "back_depth": round(seat.back.depth, 6),
        "forward": _rounded(seat.travel.forward),
        "up": _rounded(seat.travel.up),
        "tilt": [_degrees(angle) for angle in seat.travel.tilt],
        "moves": list(seat.moves),
        "how": {
            key: description.why.get(("seats", name, key), "")
            for key in ("srp", "cushion_angle", "back_angle", "yaw")
        },
    }


def _borders(opened: OpenPlace, description: Description, seat: str, surface: str) -> Floats:
    """(E, 6) [m] the border lines of a surface that was picked, from end to end."""
    picks = description.picks.get(seat)
    chosen = () if picks is None else picks.faces(surface)
    if not chosen:
        return np.zeros((0, 6))
    stands = standing_of(opened, description)
    return stands.vertices[opened.meshes.borders(chosen)[:MOST_LINES]].reshape(-1, 6)


def drawn_place(opened: OpenPlace, description: Description, thin: ThinMesh) -> WebPlace:
    """Return the meshes as a picture has them.

    Parameters
    ----------
    thin
        All meshes in the units and axes of their files.
    """
    stands = standing_of(opened, description)
    file = description.file
    vertices = np.empty_like(thin.vertices)
    mesh = np.zeros(len(thin.vertices), dtype=np.int64)
    mesh[thin.faces] = opened.meshes.mesh[thin.source][:, None]
    for row in range(len(file.meshes)):
        own = mesh == row
        vertices[own] = opened.meshes.all_in_world(file.meshes, row, thin.vertices[own])
    rules = part_rules(file, stands.names)
    part = stands.part[thin.source]
    kept = part >= 0
    triangles = thin.faces[kept]
    of_vertex = np.full(len(vertices), -1, dtype=np.int64)
    of_vertex[triangles] = part[kept][:, None]
    edges = thin.edges[(of_vertex[thin.edges] >= 0).all(axis=1)]
    used = np.flatnonzero(of_vertex >= 0)
    number = np.zeros(len(vertices), dtype=np.int64)
    number[used] = np.arange(len(used))
    colours = [_colour(file, name, rule) for name, rule in zip(stands.names, rules, strict=True)]
    return WebPlace(
        vertices[used],
        of_vertex[used],
        number[triangles],
        number[edges],
        stands.names,
        tuple(colours),
        tuple(rule.see_through for rule in rules),
    )


def _colour(file: EnvironmentFile, name: str, rule: PartFile) -> Colour:
    """The colour of a part, as in the pictures of environments."""
    if rule.see_through:
        return GLASS_PART
    if any(matching_parts(key, [name]) for one in file.controls.values() for key in one.part_keys):
        return CONTROL_PART
    seats = file.seats.values()
    if any(name in (*seat.moves, seat.cushion.part, seat.back.part) for seat in seats):
        return SEAT_PART
    return PLAIN_PART


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 4) + 0.0


def _rounded(values: Floats | Sequence[float]) -> list[float]:
    return [round(float(value), 6) + 0.0 for value in values]
