"""The study as it was read or saved last, as the page shows it see-through beside what is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.draw.web.place_mesh import changed_parts
from workbench.draw.web.views import WebPlace
from workbench.live.frames import move_row, part_shifts
from workbench.live.protocol import packed
from workbench.live.replies import Made
from workbench.model.environment import Environment
from workbench.study.bench.placing import Placement, placed_environment, placed_people
from workbench.study.bench.state import Arrangement, OpenStudy

__all__ = ["SavedState"]

Arrays = list[tuple[str, NDArray[Any]]]


@dataclass(frozen=True, eq=False)
class SavedState:
    """Where everybody and everything is in the saved study.

    Parameters
    ----------
    arrangement
        As it is saved, in the case that is looked at.
    shown
        The environment that the page has a picture of.
    """

    opened: OpenStudy
    arrangement: Arrangement
    shown: Environment
    kind: str = "ghost"
    generation: None = None

    def made(self) -> Made:
        """Pack the people, the displacements of parts, the places of controls, and the parts whose
        shape in the picture is another because something is adjusted."""
        cases = self.opened.cases
        placement = placed_people(self.opened, self.arrangement)
        arranged = placement.parts
        adjusted = None
        if arranged.environment is not self.shown:  # the same object where it is adjusted alike
            adjusted = changed_parts(arranged.environment, self.shown)
        controls = placed_environment(self.opened, placement).controls
        head = {
            "kind": self.kind,
            "case": cases[self.arrangement.case] if cases else "",
            "moves": [move_row(move) for move in self.arrangement.moves],
            "shifts": part_shifts(arranged),
            "controls": [[round(float(value), 6) for value in one.at] for one in controls],
            "adjusted": [] if adjusted is None else list(adjusted.names),
        }
        arrays = _people(placement)
        if adjusted is not None:
            arrays += _mesh(adjusted, placement)
        return Made([packed(head, arrays)])


def _people(placement: Placement) -> Arrays:
    """The spheres of everybody, with the segment of each."""
    arrays: Arrays = []
    for row, person in enumerate(placement.people):
        arrays += [
            (f"centres{row}", person.placed.centres[0].astype(np.float32)),
            (f"radius{row}", person.body.radius[0].astype(np.float32)),
            (f"segment{row}", person.body.sphere_segment.astype(np.uint16)),
        ]
    return arrays


def _mesh(place: WebPlace, placement: Placement) -> Arrays:
    """Parts where they stand [m]."""
    arranged = placement.parts
    rows = [arranged.environment.part_index(name) for name in place.names]
    shift = arranged.by_part[rows]
    vertices = place.vertices + shift[place.part]
    return [
        ("vertices", vertices.astype(np.float32)),
        ("triangles", place.triangles.ravel().astype(np.uint32)),
        ("edges", place.edges.ravel().astype(np.uint32)),
    ]
