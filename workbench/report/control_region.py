"""Where a control may be so that enough people reach it: in words, as a table and as a picture."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np

from workbench.draw.control_region import control_region_svg
from workbench.files.output_folder import write_folder
from workbench.model.arrays import Floats
from workbench.model.control_region import ControlRegion
from workbench.model.units import plain

__all__ = [
    "ONE_PLACE",
    "ONE_POSITION",
    "place_words",
    "region_lines",
    "region_table",
    "write_region",
]

ONE_PLACE = "one place to stand for everything"
ONE_POSITION = "one position of the seat for everything"
"""Where people are who do everything that a study asks."""
_WAYS = (("forward", "aft"), ("to the left", "to the right"), ("up", "down"))


def write_region(
    region: ControlRegion, folder: Path, *, tell: Callable[[str], None] = lambda line: None
) -> list[str]:
    """Write region.csv and region.svg into a folder, all of it or nothing; returns the sentences.

    tell: see write_folder. InputError where the folder holds something else or cannot be written.
    """
    lines = region_lines(region)
    files = {
        "region.csv": region_table(region),
        "region.svg": control_region_svg(region, lines[0]),
    }
    write_folder(folder, files, holds="region", tell=tell)
    return lines


def region_lines(region: ControlRegion) -> list[str]:
    """What is to be said of a region: how many reach the control today, the nearest place that will
    do, moves along one axis that do, how large the region is, and what the answer holds for."""
    return [_headline(region), *_by_one_axis(region), *_extent(region), *_notes(region)]


def _headline(region: ControlRegion) -> str:
    """The answer in a sentence."""
    name = plain(region.control.name)
    people = f"{region.people} people"
    wanted = _percent(region.wanted)
    nearest = region.nearest
    best = region.best
    if best is None:
        return (
            f"Nobody of {people} reaches any place within {_mm(region.within)} of {name}: check where "
            "the control and the seat are."
        )
    share = _percent(region.known[region.today])
    today = f"{share} of {people} reach {name} where it is, {_from(region)}"
    twice = region.steps and not np.isnan(region.together)
    if twice:
        one = f"{_percent(region.together)} of {people} reach {name} where it is, each from {ONE_PLACE}"
        today = f"{one}; {share} do {_from(region)}"
    if nearest is None:
        return (
            f"No place within {_mm(region.within)} of {name} is reached by {wanted} of {people}, as "
            f"far as places every {_mm(region.spacing)} say: at most {_percent(region.known[best])} "
            f"reach one, {place_words(region.offset[best])}; {today}."
        )
    if nearest == region.today:
        more = f"; {_percent(region.together)} do, each from {ONE_PLACE}" * twice
        stay = f"{_first(name)} may stay{' where each steps for it alone' * twice}"
        return f"{stay}: {share} of {people} reach it there, and {wanted} must{more}."
    far = float(np.linalg.norm(region.offset[nearest]))
    return (
        f"{today}; {_percent(region.share[nearest])} do {_mm(far)} away, "
        f"{place_words(region.offset[nearest])}: the nearest place that {wanted} reach."
    )


def _from(region: ControlRegion) -> str:
    """Where people are for it."""
    if region.steps:
        return "each from the place in the area that suits this control alone"
    return f"each from {ONE_PLACE if region.standing else ONE_POSITION}"


def _first(name: str) -> str:
    """A name as the first word of a sentence."""
    return name[:1].upper() + name[1:]


def place_words(offset: Floats) -> str:
    """A place by how far it is from another: "30 mm aft and 60 mm up"."""
    words = [
        f"{1000 * abs(by):.0f} mm {ways[int(by < 0)]}"
        for by, ways in zip(offset.tolist(), _WAYS, strict=True)
        if abs(by) >= 5e-4
    ]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words) or "there"


def _by_one_axis(region: ControlRegion) -> list[str]:
    """The shortest moves along one axis that will do, where it cannot stay."""
    if region.nearest is None or region.nearest == region.today:
        return []
    words = []
    for axis in range(3):
        straight = (np.abs(np.delete(region.offset, axis, axis=1)) < 1e-9).all(axis=1)
        for sign in (1, -1):
            rows = np.flatnonzero(straight & region.enough & (sign * region.offset[:, axis] > 0))
            if len(rows):
                row = rows[np.argmin(np.abs(region.offset[rows, axis]))]
                words.append(place_words(region.offset[row]))
    if not words:
        return ["No move along one axis alone will do."]
    return [f"Moves along one axis that will do: {', '.join(words)}."]


def _extent(region: ControlRegion) -> list[str]:
    """How large the region is, and from where to where."""
    rows = np.flatnonzero(region.enough & region.on_lattice)
    if not len(rows):
        return []
    litres = 1000 * len(rows) * region.spacing**3
    low = region.offset[rows].min(axis=0)
    high = region.offset[rows].max(axis=0)
    ends = "; ".join(
        f"{_signed(low[axis], ways)} to {_signed(high[axis], ways)}"
        for axis, ways in enumerate(_WAYS)
    )
    some = f"{len(rows):,} of {int(region.on_lattice.sum()):,} places"
    return [
        f"{_percent(region.wanted)} reach {some} within {_mm(region.within)}, every "
        f"{_mm(region.spacing)}: {litres:.3g} litres, {ends}."
    ]


def _signed(by: float, ways: tuple[str, str]) -> str:
    return f"{1000 * abs(by):.0f} mm {ways[int(by < 0)]}"


def _notes(region: ControlRegion) -> list[str]:
    """How it was asked."""
    limb = "foot" if region.control.for_feet else "hand"
    by = f"either {limb}" if region.hand == "either" else f"the {region.hand} {limb}"
    bending = ", by the arms alone without bending" if region.standing else ""
    notes = [
        f"Computed for {by}, grip {region.control.grip}, zone {region.zone}, {_from(region)}{bending}; every part but "
        "the control's own counts as an obstacle."
    ]
    if region.inside[region.today] >= 0:
        part = plain(region.solids[region.inside[region.today]])
        notes.append(f"Its place today is inside the solid part {part}.")
    if region.behind[region.today]:
        notes.append("Its place today is behind everybody's backrest.")
    return notes


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _mm(length: float) -> str:
    return f"{1000 * length:,.0f} mm"


def region_table(region: ControlRegion) -> str:
    """region.csv: each place in the world and from today's, the share that reaches it (empty where it
    is too small and was not asked for), no less than it, and what it is."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    offsets = ["forward_mm", "left_mm", "up_mm"]
    writer.writerow(["x_mm", "y_mm", "z_mm", *offsets, "share", "share_at_most", "state"])
    enough = region.enough
    known = region.known
    exact = enough | (np.arange(len(enough)) == region.today) | ~enough.any()
    for row, (point, offset) in enumerate(zip(region.points, region.offset, strict=True)):
        writer.writerow(
            [
                *(f"{1000 * value + 0.0:.1f}" for value in (*point, *offset)),
                f"{known[row]:.4f}" if exact[row] else "",
                f"{known[row]:.4f}",
                _state(region, row, bool(enough[row])),
            ]
        )
    return text.getvalue()


def _state(region: ControlRegion, row: int, enough: bool) -> str:
    if region.inside[row] >= 0:
        return f"inside {region.solids[region.inside[row]]}"
    if region.behind[row]:
        return "behind the backrest"
    if enough:
        return "enough reach it"
    return "too few reach it" if np.isnan(region.share[row]) else "too few reach it past obstacles"
