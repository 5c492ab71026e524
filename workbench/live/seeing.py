"""The field of view of somebody at the bench: where eyes and head turn to, what hides how much of the
field from which eye, and a picture of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.draw.zones import OWN, Zones, spread, zones
from workbench.errors import WorkbenchError
from workbench.live.protocol import packed
from workbench.live.replies import Made
from workbench.model.arrays import Bools, Floats
from workbench.model.figures import plain
from workbench.sight.obscuration import obscuration
from workbench.sight.panorama import look_out, lookout
from workbench.study.bench.placing import Placement
from workbench.study.bench.sights import Field, field_of
from workbench.study.bench.state import OpenStudy

__all__ = ["COARSE", "FINE", "WITHIN", "Colours", "FieldWork"]

WITHIN = (30, 60, 90, 180)
"""How far [degrees] from the line of sight a field may go."""
COARSE = math.radians(0.5)
FINE = math.radians(0.1)
"""Width [rad] of the pixels that are counted while the eyes turn, and once they rest."""
_SHOWN = math.radians(1.0)
"""Width [rad] of what the picture looks at in one piece."""
_COLOURED = math.radians(3.0)
"""Width [rad] of the pixels by which colours are given."""
_SIZE = 180
"""Pixels of the picture along an edge."""
_MOST = 8
"""Items that are listed."""
Colours = dict[tuple[str, ...], Zones]


@dataclass(frozen=True, eq=False)
class FieldWork:
    """The field of view of a person of a state who looks in a direction (3,), within so many degrees
    of it."""

    opened: OpenStudy
    placement: Placement
    number: int
    person: str
    toward: tuple[float, float, float]
    within: int
    fine: bool
    known: Colours
    """The colours that items were given before, by the names of all, so that they stay."""
    kind: str = "field"
    generation: None = None
    """It is shown as that of the state `number` also once the state is another."""

    def made(self) -> Made:
        """Pack the figures and the picture; why there are none in words."""
        head: dict[str, Any] = {
            "kind": "field",
            "generation": self.number,
            "person": self.person,
            "within": self.within,
            "fine": self.fine,
            "words": "",
        }
        try:
            found = field_of(
                self.opened,
                self.placement,
                self.placement.arrangement.row(self.person),
                self.toward,
                within=math.radians(self.within),
                step=FINE if self.fine else COARSE,
            )
            names = found.hidden.names
            if names not in self.known:
                self.known[names] = _coloured(found)
            rows, picture = _shown(found, self.known[names])
        except WorkbenchError as error:
            return Made([packed(head | {"words": str(error)})])
        arrays = [("picture", picture), ("centres", found.placed.centres[0].astype(np.float32))]
        return Made([packed(head | _figures(found, rows), arrays)])


def _figures(found: Field, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How eyes and head are turned, and shares of the field in percent, from left, right, either and
    both eyes."""
    looks, hidden = found.gaze, found.hidden
    share = 100.0 / hidden.region.solid_angle
    return {
        "at": looks.eyes.middle[0].round(5).tolist(),
        "head": np.degrees(looks.head_turn[0]).round(1).tolist(),
        "eyes": np.degrees(looks.eye_turn[0]).round(1).tolist(),
        "trunk": round(math.degrees(float(looks.trunk_turn[0])), 1),
        "lack": round(math.degrees(float(looks.lack[0])), 1),
        "free": (share * hidden.free).round(2).tolist(),
        "error": round(share * hidden.free_error, 2),
        "rows": rows,
        "more": int((hidden.either > 0.0).sum()) - len(rows),
        "size": _SIZE,
    }


def _coloured(found: Field) -> Zones:
    """Colours of what bounds and hides all that somebody could see from there; the own body has one."""
    names = [OWN if name.startswith("own ") else name for name in found.hidden.names]
    around = obscuration(found.scenery, found.gaze.eyes, step=_COLOURED)
    return zones(names, around.both, around.either - around.both, float(around.free[3]))


def _shown(found: Field, coloured: Zones) -> tuple[list[dict[str, Any]], np.ndarray]:
    """The items that hide most, each with its colour, and the picture (H, W, 3) as 8 bits: what hides
    a direction from one eye only is pale."""
    hidden = found.hidden
    region = hidden.region
    share = 100.0 / region.solid_angle
    rows = []
    for k in np.argsort(-hidden.either, kind="stable")[:_MOST].tolist():
        if hidden.either[k] <= 0.0:
            break
        shares = [hidden.left[k], hidden.right[k], hidden.either[k], hidden.both[k]]
        rows.append(
            {
                "name": plain(hidden.names[k]),
                "colour": list(coloured.rows[int(coloured.row[k])].colour),
                "shares": [round(share * float(value), 2) for value in shares],
                "error": round(share * float(hidden.error[k]), 2),
            }
        )
    ways, inside = _disc(region.half_angle)
    view = lookout(ways @ region.axes, _SHOWN)
    eyes = found.gaze.eyes
    left, glass = look_out(found.scenery, eyes.left[0], view, through=True)
    right, _ = look_out(found.scenery, eyes.right[0], view)
    images = (spread(items, inside) for items in (left, right, glass))
    painted = coloured.paint(*images)
    painted[~inside] = 255
    return rows, painted


@lru_cache(maxsize=len(WITHIN))
def _disc(half_angle: float) -> tuple[Floats, Bools]:
    """Directions (K, 3) forward, left, up of the pixels of a disc that shows a cone about forward,
    equal areas for equal solid angles, r = 2 sin(off / 2); and which pixels (H, W) these are."""
    radius = 2.0 * math.sin(half_angle / 2.0)
    across = ((np.arange(_SIZE) + 0.5) * (2.0 / _SIZE) - 1.0) * radius
    right, down = np.meshgrid(across, across)
    square = right**2 + down**2
    inside = square <= radius**2
    k = np.sqrt(np.maximum(1.0 - square / 4.0, 0.0))
    ways = np.stack([1.0 - square / 2.0, -k * right, -k * down], axis=-1)
    return ways[inside], inside
