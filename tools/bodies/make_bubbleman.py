"""Writes bubbleman.yaml from bubbleman_sections.yaml: cross sections chosen by hand become spheres.

Run `python tools/bodies/make_bubbleman.py [FOLDER]` from anywhere; the same sections always give the same
file. Lengths [mm], angles [deg], masses [kg]. The data file holds the left half in the world of the
zero pose; here it is filled with spheres, mirrored, moved into segment frames, and written one
sphere a line.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

__all__ = ["body_text", "main"]

Row = dict[str, Any]
Vector = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
BODIES = HERE.parents[1] / "bodies"
HEADER = """\
# Bubbleman: a man of median size made of {spheres} spheres, 20 segments and 19 joints.
# Segments, joints, numbers and mnemonics: Badler, O'Rourke & Toltzis, Proc. IEEE 67(10), 1979, tables 1 and 2.
# Report before the paper: Badler & O'Rourke, A Human Body Modelling System for Motion Studies, Movement Project
# Report 6, University of Pennsylvania, August 1977.
# Size: ANSUR II (NATICK/TR-15/007), median man. Masses: de Leva 1996, the shoulder masses taken from the upper trunk.
# Joint stops: Barter, Emanuel & Truett 1957 and later surveys. Licence: CC0-1.0.
# The mass is the survey's, the spheres are drawn by hand and too slim for it: 72 litres, 1,170 kg/m3 where people have
# 985 to 1,065. Thighs have 1,480, feet 1,400, hands 1,560, chest 1,310; where girth or depth counts, take adult_male.
# Made from tools/bodies/bubbleman_sections.yaml: change that, then run `python tools/bodies/make_bubbleman.py`.
body: bubbleman
description: adult man of median size, drawn by hand; a tenth too slim for his mass
source: shape drawn by hand to the median man of ANSUR II (NATICK/TR-15/007); masses after de Leva 1996
licence: CC0-1.0
length: mm
postures: human_postures.yaml
seated: {{breadth: 1.09, thickness: 0.95}} # breadth: hip breadth sitting over hip breadth, median man of ANSUR II
"""
DIRECTIONS = {
    "LHN": "{back: +y, top: -z, right: +x}",
    "RHN": "{back: -y, top: -z, left: +x}",
}
UPRIGHT = "{front: +x, left: +y, top: +z}"
MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Ball:
    """A sphere in the world of the zero pose [mm], with the name and direction of its subpart, or
    ""."""

    centre: tuple[float, float, float]
    radius: float
    name: str = ""
    direction: str = ""

    def mirrored(self) -> Ball:
        """The same sphere on the other side of the body."""
        x, y, z = self.centre
        swap = {"left": "right", "right": "left"}
        name = " ".join(swap.get(word, word) for word in self.name.split())
        return replace(
            self, centre=(x, -y, z), name=name, direction=swap.get(self.direction, self.direction)
        )


def main() -> None:
    """Write bubbleman.yaml into a folder, beside this file where none is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else BODIES
    data = yaml.safe_load((HERE / "bubbleman_sections.yaml").read_text(encoding="utf-8"))
    (folder / "bubbleman.yaml").write_text(body_text(data), encoding="utf-8")


def body_text(data: Row) -> str:
    """The body file as text."""
    segments = _both_sides(data["segments"])
    joints = _both_sides(data["joints"])
    balls = {name: _segment_balls(data["shape"], name) for name in segments}
    lines = [HEADER.format(spheres=sum(map(len, balls.values()))) + "segments:"]
    for name, row in segments.items():
        mass = row["share"] * data["body_mass"]
        lines += _segment_lines(name, row, mass)
        lines += [f"      - {_ball_text(ball, row['origin'])}" for ball in balls[name]]
    lines.append("joints:")
    for name, row in joints.items():
        lines += _joint_lines(name, row, segments)
        lines += _stop_lines(name, data)
    return "\n".join(lines + _allowance_lines(data["allowances"])) + "\n"


# ----------------------------------------------------------------------------------------------
# left and right


def _is_left(mnemonic: str) -> bool:
    """Whether a segment or joint stands on the left; LT is the lower torso."""
    return mnemonic.startswith("L") and mnemonic != "LT"


def _is_right(mnemonic: str) -> bool:
    return mnemonic.startswith("R")


def _left(mnemonic: str) -> str:
    """The left twin of what stands on the right, else the same."""
    return "L" + mnemonic[1:] if _is_right(mnemonic) else mnemonic


def _right(mnemonic: str) -> str:
    """The right twin of what stands on the left, else the same."""
    return "R" + mnemonic[1:] if _is_left(mnemonic) else mnemonic


def _both_sides(table: dict[str, Row]) -> dict[str, Row]:
    """The table with the right-hand rows added, in the order of the paper's numbers."""
    rows = dict(table)
    for name, row in table.items():
        if _is_left(name):
            rows[_right(name)] = _mirrored_row(row)
    return dict(sorted(rows.items(), key=lambda item: int(item[1]["number"])))


def _mirrored_row(row: Row) -> Row:
    twin = {**row, "number": row["number"] + 1, "name": row["name"].replace("left", "right")}
    for key in ("origin", "at"):
        if key in row:
            twin[key] = [float(v) for v in np.array(row[key]) * MIRROR]
    if "between" in row:
        twin["between"] = [_right(name) for name in row["between"]]
    if "twist_along" in row:
        twin["twist_along"] = _right(row["twist_along"])
    return twin


# -------------------------------------------------------------------------------------- cross
# sections to spheres


def _segment_balls(shape: dict[str, list[Any]], name: str) -> list[Ball]:
    """All spheres of a segment; a midline segment gets the mirror image of what stands left of the
    middle."""
    left = [ball for row in shape.get(_left(name), []) for ball in _row_balls(row)]
    if _is_right(name):
        return [ball.mirrored() for ball in left]
    if _is_left(name):
        return left
    return [twin for ball in left for twin in _with_mirror_image(ball, left)]


def _with_mirror_image(ball: Ball, others: list[Ball]) -> list[Ball]:
    """The ball, and its mirror image unless it lies in the middle or the image is there already."""
    image = ball.mirrored()
    return [ball] if ball.centre[1] == 0 or image in others else [ball, image]


def _row_balls(row: Any) -> Iterator[Ball]:
    if isinstance(row, list):
        name, direction = [*row[4:], "", ""][:2]
        yield Ball((row[0], row[1], row[2]), row[3], name, direction)
        return
    axes = [axis for axis in "xyz" if isinstance(row[axis], list)]
    spans = np.array([row[axis] for axis in axes], dtype=np.float64)
    along = _grid(spans, row) if isinstance(row["n"], list) else _ellipse(spans, row)
    for first, second, radius in along:
        place = {axis: float(row[axis]) for axis in "xyz" if axis not in axes}
        place |= {axes[0]: round(float(first), 1), axes[1]: round(float(second), 1)}
        yield Ball((place["x"], place["y"], place["z"]), round(float(radius), 1))


def _grid(spans: Vector, row: Row) -> Iterator[tuple[float, float, float]]:
    """Spheres of radius r whose outermost touch the sides of the section."""
    radius = float(row["r"])
    first, second = (
        np.linspace(span[0] + radius, span[1] - radius, n)
        for span, n in zip(spans, row["n"], strict=True)
    )
    yield from ((a, b, radius) for a in first for b in second)


def _ellipse(spans: Vector, row: Row) -> Iterator[tuple[float, float, float]]:
    """Spheres along the longer side of an elliptic section, on its medial axis.

    An ellipse of half axes a > b has there radius b sqrt(1 - t^2 / (a^2 - b^2)) for |t| <= (a^2 -
    b^2) / a; `full` moves the radius at the ends from that of the ellipse (0) to b (1), a stadium.
    """
    middle = spans.mean(axis=1)
    half = (spans[:, 1] - spans[:, 0]) / 2
    long = int(np.argmax(half))
    a = half[long]
    b = half[1 - long]
    end = b * row.get("full", 0.0) + b * b / a * (1 - row.get("full", 0.0))
    for share in np.linspace(-1, 1, row["n"]):
        place = middle.copy()
        place[long] += share * (a - end)
        yield place[0], place[1], b - (b - end) * share**2


# -------------------------------------------------------------------------------------------------------
# text


def _number(value: float) -> str:
    text = f"{value:.1f}"
    return "0" if text == "-0.0" else text.removesuffix(".0")


def _vector(values: Any) -> str:
    return "[" + ", ".join(_number(float(v)) for v in values) + "]"


def _ball_text(ball: Ball, origin: list[float]) -> str:
    place = [*(np.array(ball.centre) - np.array(origin)), ball.radius]
    words = [_number(v) for v in place] + [word for word in (ball.name, ball.direction) if word]
    return "[" + ", ".join(words) + "]"


def _segment_lines(name: str, row: Row, mass: float) -> list[str]:
    lines = [
        f"  {name}:",
        f"    name: {row['name']}",
        f"    number: {row['number']}",
        f"    mass: {mass:.3f}",
        f"    directions: {DIRECTIONS.get(name, UPRIGHT)}",
    ]
    if "twist_along" in row:
        lines.append(f"    twist_along: {row['twist_along']}")
    return [*lines, "    spheres:" if name != "STG" else "    spheres: []"]


def _joint_lines(name: str, row: Row, segments: dict[str, Row]) -> list[str]:
    at = {end: np.array(row["at"]) - np.array(segments[end]["origin"]) for end in row["between"]}
    places = ", ".join(f"{end}: {_vector(place)}" for end, place in at.items())
    return [
        f"  {name}:",
        f"    name: {row['name']}",
        f"    number: {row['number']}",
        f"    between: [{', '.join(row['between'])}]",
        f"    at: {{{places}}}",
    ]


def _stop_lines(name: str, data: Row) -> list[str]:
    row = data["stops"][_left(name)]
    right = _is_right(name)
    lines = [f"    stop: {row['stop']}", "    swing:"]
    lines += [f"      - {_motion(motion, right)}" for motion in row["swing"]]
    lines.append(f"    twist: {_motion(row['twist'], right)}")
    if "play" in row:
        lines.append(f"    play: {row['play']}")
    if "couplings" in row:
        lines.append("    couplings:")
        lines += [f"      - {_coupling(coupling, right)}" for coupling in row["couplings"]]
    return lines + (_polygon_lines(data["polygon"], right) if row["stop"] == "polygon" else [])


def _motion(motion: list[Any], right: bool) -> str:
    """A mirror image turns the other way about the axes that lie in the mirror."""
    first, second, axis, *limits = motion
    if right and axis[1] != "y":
        axis = {"+": "-", "-": "+"}[axis[0]] + axis[1]
    return f"{{motion: [{first}, {second}], axis: {axis}, limits: {_vector(limits)}}}"


def _coupling(coupling: list[Any], right: bool) -> str:
    limit, driver, angles, limits = coupling
    driver = _right(driver) if right else driver
    return f"{{limit: {limit}, driver: {driver}, from: {_vector(angles)}, to: {_vector(limits)}}}"


def _polygon_lines(polygon: Row, right: bool) -> list[str]:
    sides = np.array([1, 1, 1]) if right else MIRROR
    lines = ["    polygon:", f"      frame: {polygon['frame']}"]
    for key in ("centre", "clock_0", "clock_90"):
        values = ", ".join(f"{float(v) + 0.0:g}" for v in np.array(polygon[key]) * sides)
        lines.append(f"      {key}: [{values}]")
    return [*lines, f"      limits: [{', '.join(_vector(pair) for pair in polygon['limits'])}]"]


def _allowance_lines(allowances: list[list[Any]]) -> list[str]:
    """Each given pair, and its mirror image where that is another pair."""
    pairs: dict[tuple[str, str], float] = {}
    for first, second, depth in allowances:
        pairs[first, second] = depth
        image = (_other(first), _other(second))
        if image[::-1] not in pairs:
            pairs[image] = depth
    rows = [
        f"  - {{between: [{a}, {b}], depth: {_number(depth)}}}" for (a, b), depth in pairs.items()
    ]
    return ["allowances:", *rows] if rows else ["allowances: []"]


def _other(mnemonic: str) -> str:
    return _left(mnemonic) if _is_right(mnemonic) else _right(mnemonic)


if __name__ == "__main__":
    main()
