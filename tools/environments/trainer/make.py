"""Build trainer.obj, the cockpit of a two-seat side-by-side light trainer: python
tools/environments/trainer/make.py

Every length is in mm here; x is forward of the seat reference point, y left of the centre line, z
above the floor.
"""

from __future__ import annotations

import sys
from math import cos, radians, sin
from pathlib import Path

import numpy as np
from manifold3d import Manifold
from numpy.typing import ArrayLike, NDArray

# where the solids of all environments are
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from panel import panel_parts
from solids import (
    box,
    disc,
    frame,
    hull,
    loft,
    mirrored,
    place,
    prism,
    shell,
    sweep,
    union,
    write_obj,
)

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

# The fuselage, station by station: x, half width inside at the sill, height of the sill, height of
# the crown inside and the exponent of the superellipse between them.
STATIONS = np.array(
    [
        (-760, 452, 700, 950, 2.2),
        (-660, 487, 700, 1064, 2.25),
        (-550, 520, 700, 1164, 2.3),
        (-430, 546, 700, 1245, 2.35),
        (-300, 566, 700, 1302, 2.4),
        (-160, 578, 700, 1331, 2.5),
        (-20, 580, 700, 1337, 2.5),
        (120, 580, 700, 1328, 2.5),
        (240, 580, 700, 1306, 2.5),
        (340, 580, 700, 1276, 2.45),
        (430, 578, 700, 1240, 2.4),
        (540, 572, 699, 1184, 2.4),
        (650, 562, 698, 1115, 2.35),
        (760, 548, 696, 1029, 2.3),
        (870, 530, 693, 927, 2.25),
        (980, 508, 690, 806, 2.2),
        (1150, 470, 680, 752, 2.2),
    ],
    dtype=np.float64,
)
TAIL = -760.0
BOW = 430.0
DECK = 980.0
NOSE = 1150.0  # canopy from TAIL to BOW, windscreen from there to DECK
WALL = 22.0
PERSPEX = 4.0

FOLDER = Path(__file__).resolve().parents[3] / "environments" / "trainer"

SEAT_Y = 280.0
SRP_HEIGHT = 280.0
CUSHION = radians(7.0)
BACK = radians(15.0)  # cushion front up, back aft of vertical
PEDAL = radians(45.0)  # pedal face above the horizontal
HUB = (548.0, 402.0)  # x and z of the axis of the throttle quadrant
LEVER_Y = (26.0, 0.0, -26.0)  # throttle, propeller, mixture
ACROSS = (0.0, 1.0, 0.0)
UP = (0.0, 0.0, 1.0)
PEDAL_X = 930.0
PEDAL_Z = 144.0  # ball of the foot


def station(x: float) -> Floats:
    """Half width, sill, crown and exponent at x."""
    return np.array([np.interp(x, STATIONS[:, 0], STATIONS[:, k]) for k in range(1, 5)])


def arch(x: float, offset: float, *, count: int = 17) -> Floats:
    """Points (count, 3) evenly along the arch at x, from the left sill over the crown, `offset`
    outside of it."""
    width, sill, crown, power = station(x)
    t = np.linspace(0.0, np.pi, 1441)
    c = np.cos(t)
    s = np.sin(t)
    y = width * np.sign(c) * np.abs(c) ** (2.0 / power)
    z = (crown - sill) * np.abs(s) ** (2.0 / power)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    even = np.linspace(0.0, length[-1], count)
    y = np.interp(even, length, y)
    z = np.interp(even, length, z)
    normal = np.stack(
        [
            np.sign(y) * np.abs(y / width) ** (power - 1.0) / width,
            (z / (crown - sill)) ** (power - 1.0) / (crown - sill),
        ]
    )
    normal /= np.linalg.norm(normal, axis=0)
    return np.column_stack(
        [np.full(count, x), y + offset * normal[0], sill + z + offset * normal[1]]
    )


def stations(first: float, last: float) -> list[float]:
    """The two ends and the stations between them."""
    between = STATIONS[:, 0]
    return [first, *between[(between > first) & (between < last)].tolist(), last]


def skin(first: float, last: float, inner: float, outer: float) -> Manifold:
    """The arched shell from x = first to last between two offsets."""
    grids = [
        np.array([arch(x, offset) for x in stations(first, last)]) for offset in (inner, outer)
    ]
    return shell(grids[0], grids[1])


def side(x: float, offset: float) -> Floats:
    """The left wall's section (4, 3) from the floor to the sill."""
    width, height = station(x)[:2]
    profile = [(0.86, 0.0), (0.955, 180.0), (0.99, 400.0), (1.0, height)]
    return np.array([(x, share * width + offset, z) for share, z in profile])


def section(x: float, offset: float) -> Floats:
    """The whole closed section at x: wall, arch, wall."""
    left = side(x, offset)
    return np.vstack([left[:-1], arch(x, offset), (left * np.array([1.0, -1.0, 1.0]))[-2::-1]])


def cabin(first: float, last: float) -> Manifold:
    """The air inside the walls and below the canopy, less a gap of 1 mm."""
    return loft([section(x, -1.0) for x in stations(first, last)])


def hull_parts() -> Parts:
    """Floor, walls, bulkheads, decks and the rails of the canopy."""
    xs = stations(TAIL, NOSE)
    wall = shell(np.array([side(x, 0.0) for x in xs]), np.array([side(x, WALL) for x in xs]))
    outline = [(x, side(x, WALL)[0, 1]) for x in xs]
    outline += [(x, -y) for x, y in reversed(outline)]
    slope = [(-440.0, 0.0), (-424.0, 0.0), (-534.0, 640.0), (-550.0, 640.0)]
    rail = shell(
        np.array([sill_edge(x, 1.0) for x in stations(TAIL, DECK)]),
        np.array([sill_edge(x, 30.0) for x in stations(TAIL, DECK)]),
    )
    return {
        "floor": prism(outline, "z", -20.0, 0.0),
        "firewall": loft([section(NOSE, WALL), section(NOSE, WALL) + np.array([16.0, 0.0, 0.0])]),
        "left_side_wall": wall,
        "right_side_wall": mirrored(wall),
        "left_sill": rail,
        "right_sill": mirrored(rail),
        "aft_bulkhead": prism(slope, "y", -600.0, 600.0) ^ cabin(TAIL, 0.0),
        "baggage_shelf": box((TAIL, -600.0, 640.0), (-534.0, 600.0, 656.0)) ^ cabin(TAIL, 0.0),
        "turtle_deck": loft(
            [section(TAIL, WALL) - np.array([16.0, 0.0, 0.0]), section(TAIL, WALL)]
        ),
        "forward_deck": skin(DECK, NOSE, 0.0, WALL),
    }


def sill_edge(x: float, inward: float) -> Floats:
    """The sill's lower and upper edge, so far inside of the wall."""
    width, height = station(x)[:2]
    return np.array([(x, width - inward, height - 26.0), (x, width - inward, height)])


def glass_parts() -> Parts:
    """Canopy, windscreen, their frames and what is fixed to them."""
    thick = skin(TAIL + 2.0, BOW - 2.0, -26.0, -3.0)
    window = box((TAIL + 34.0, -700.0, 734.0), (BOW - 40.0, 700.0, 1400.0))
    latch = hull([*ring((352.0, 522.0, 728.0), 9.0), *ring((262.0, 520.0, 732.0), 7.0)])
    half = [(404, 62, 1222), (398, 62, 1194), (394, 52, 1184)]
    handle = sweep([*half, *[(x, -y, z) for x, y, z in reversed(half)]], 8.0)
    return {
        "canopy": skin(TAIL, BOW - 2.0, 0.0, PERSPEX),
        "canopy_frame": thick - window,
        "windscreen": skin(BOW + 2.0, DECK, 0.0, 1.4 * PERSPEX),
        "windscreen_bow": skin(BOW + 2.0, BOW + 34.0, -26.0, -3.0),
        "left_canopy_latch": latch,
        "right_canopy_latch": mirrored(latch),
        "canopy_handle": handle,
    }


def ring(centre: ArrayLike, radius: float, *, sides: int = 10) -> Floats:
    """Points of a level circle with a second one above it, for hulls."""
    turn = (np.arange(sides) + 0.5) * 2.0 * np.pi / sides
    circle = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(sides)])
    return np.vstack([circle, circle + np.array([0.0, 0.0, 12.0])]) + np.asarray(
        centre, dtype=np.float64
    )


# The seats are drawn from their reference point, in the planes that meet there: (0, 0) is that
# point, `back(u, n)` lies u up the back and n in front of it, `cushion(u, n)` u along the cushion
# and n above it.


def back(u: float, n: float, y: float) -> tuple[float, float, float]:
    """A point u up the back plane and n in front of it."""
    return (-u * sin(BACK) + n * cos(BACK), y, u * cos(BACK) + n * sin(BACK))


def cushion(u: float, n: float, y: float) -> tuple[float, float, float]:
    """A point u along the cushion plane and n above it."""
    return (u * cos(CUSHION) - n * sin(CUSHION), y, u * sin(CUSHION) + n * cos(CUSHION))


def seat_pan() -> Manifold:
    """The cushion, with a slot for the stick."""
    points = []
    for half, depth in ((208.0, 0.0), (230.0, 16.0), (230.0, 75.0), (216.0, 92.0)):
        front = 448.0 - (0.0 if 10.0 < depth < 80.0 else 12.0)
        lead = 410.0 if depth == 0.0 else front
        start = -depth * (sin(CUSHION + BACK) / cos(CUSHION + BACK))
        points += [cushion(u, -depth, s * half) for u in (-start, lead) for s in (-1.0, 1.0)]
    slot = union(
        [
            box((322.0, -52.0, -150.0), (600.0, 52.0, 200.0)),
            disc((322.0, 0.0, -150.0), (0.0, 0.0, 1.0), 52.0, 350.0),
        ]
    )
    return hull(points) - slot


def seat_back() -> Manifold:
    """The back: flat in front, its edges rounded off, narrower at the shoulders."""
    outline = [(-95.0, 212.0), (330.0, 228.0), (520.0, 206.0), (628.0, 128.0)]
    points = []
    for inset, n in ((14.0, 0.0), (0.0, -16.0), (0.0, -46.0), (20.0, -72.0)):
        for u, half in outline:
            end = inset if u > 600.0 else 0.0
            points += [back(u - end, n, s * (half - inset)) for s in (-1.0, 1.0)]
    return hull(points)


def headrest() -> Manifold:
    """The head rest on its two posts."""
    points = []
    for inset, n in ((14.0, -12.0), (0.0, -26.0), (0.0, -52.0), (16.0, -68.0)):
        for u, half in (
            (700.0 + inset, 92.0),
            (728.0, 114.0),
            (828.0, 108.0),
            (872.0 - inset, 66.0),
        ):
            points += [back(u, n, s * (half - inset)) for s in (-1.0, 1.0)]
    posts = [sweep([back(628.0, -40.0, y), back(720.0, -40.0, y)], 7.0) for y in (-55.0, 55.0)]
    return union([hull(points), *posts])


def seat_base() -> Manifold:
    """Two trestles that straddle the rails, two tubes between them."""
    trestles = []
    for y in (-175.0, 175.0):
        low = [(40.0, 24.0), (330.0, 24.0)]
        high = [(390.0, SRP_HEIGHT - 62.0), (12.0, SRP_HEIGHT - 112.0)]
        plate = prism(low + high, "y", y - 26.0, y + 26.0)
        trestles.append(plate - box((-200.0, y - 20.0, 0.0), (600.0, y + 20.0, 72.0)))
    tubes = [
        sweep([(x, -160.0, z), (x, 160.0, z)], 13.0) for x, z in ((80.0, 120.0), (310.0, 130.0))
    ]
    return union([*trestles, *tubes])


def seat_parts() -> Parts:
    """Both seats; the right one is the left one's mirror image."""
    rails = union([box((-260.0, y - 14.0, 0.0), (520.0, y + 14.0, 45.0)) for y in (-175.0, 175.0)])
    drawn = {"pan": seat_pan(), "back": seat_back(), "headrest": headrest()}
    seat = {name: solid.translate((0.0, SEAT_Y, SRP_HEIGHT)) for name, solid in drawn.items()}
    seat |= {
        "base": seat_base().translate((0.0, SEAT_Y, 0.0)),
        "rails": rails.translate((0.0, SEAT_Y, 0.0)),
    }
    return both(
        {name if name == "headrest" else f"seat_{name}": solid for name, solid in seat.items()}
    )


def both(parts: Parts) -> Parts:
    """Each part as left_NAME and, mirrored, as right_NAME."""
    named = {f"left_{name}": solid for name, solid in parts.items()}
    return named | {f"right_{name}": mirrored(solid) for name, solid in parts.items()}


def stick_parts() -> Parts:
    """The sticks, bent aft to the hand, with a grip and a boot at the floor."""
    path = [(505.0, 0.0, 70.0), (478.0, 0.0, 300.0), (408.0, 0.0, 446.0), (394.0, 0.0, 480.0)]
    path += [
        (391.0, 0.0, 487.0),
        (380.0, 0.0, 515.0),
        (368.0, 0.0, 548.0),
        (358.0, 0.0, 576.0),
        (350.0, 0.0, 598.0),
    ]
    shaft = sweep(path, [11.0, 11.0, 11.0, 11.0, 22.0, 18.0, 19.0, 22.0, 20.0], flat=0.8)
    button = disc((349.0, 0.0, 597.0), (-0.33, 0.0, 0.94), 7.0, 7.0, sides=12)
    boot = sweep([(505.0, 0.0, 0.0), (505.0, 0.0, 70.0)], [78.0, 24.0], sides=16)
    stick = shaft + button
    return both(
        {
            name: solid.translate((0.0, SEAT_Y, 0.0))
            for name, solid in (("stick", stick), ("stick_boot", boot))
        }
    )


def pedal() -> Manifold:
    """One pedal about the ball of the foot: a ribbed plate on an arm from the bar."""
    along = (cos(PEDAL), 0.0, sin(PEDAL))
    across = (0.0, 1.0, 0.0)
    placement = frame((PEDAL_X, 0.0, PEDAL_Z), along, across)
    plate = hull(
        [
            (u, v, n)
            for n, a in ((0.0, 4.0), (3.0, 0.0), (12.0, 0.0))
            for u in (-62.0 + a, 70.0 - a)
            for v in (-46.0 + a, 46.0 - a)
        ]
    )
    arm = sweep(
        [(976.0, 0.0, 45.0), (975.0, 0.0, 90.0), (966.0, 0.0, 108.0), (936.0, 0.0, 138.0)], 10.0
    )
    return union([place(plate.mirror((0.0, 0.0, 1.0)), placement), arm])


def pedal_parts() -> Parts:
    """Four rudder pedals on two bars."""
    parts = {
        f"{name}_pedal": pedal().translate((0.0, SEAT_Y + y, 0.0))
        for name, y in (("left", 85.0), ("right", -85.0))
    }
    left = {f"left_seat_{name}": solid for name, solid in parts.items()}
    right = {
        f"right_seat_{name}": solid.translate((0.0, -2.0 * SEAT_Y, 0.0))
        for name, solid in parts.items()
    }
    blocks = [
        box((956.0, y - 12.0, 0.0), (996.0, y + 12.0, 58.0))
        for y in (SEAT_Y - 140.0, SEAT_Y + 140.0)
    ]
    bar = union(
        [sweep([(976.0, SEAT_Y - 140.0, 38.0), (976.0, SEAT_Y + 140.0, 38.0)], 14.0), *blocks]
    )
    return left | right | both({"pedal_bar": bar})


def about_hub(y: float, radius: float, width: float) -> Manifold:
    """A disc about the hub of the quadrant, from y to the left."""
    return disc((HUB[0], y, HUB[1]), ACROSS, radius, width, sides=36)


def lever(angle: float, y: float, head: Manifold) -> Manifold:
    """A lever of the quadrant, `angle` degrees above the forward direction, with its head at the
    end."""
    out = np.array([cos(radians(angle)), 0.0, sin(radians(angle))])
    hub = np.array([HUB[0], y, HUB[1]])
    arm = sweep([hub + 60.0 * out, hub + 166.0 * out], 4.5, sides=8)
    placement = frame(hub + 162.0 * out, (out[2], 0.0, -out[0]), ACROSS)
    return union([arm, place(head, placement)])


def console_parts() -> Parts:
    """The console between the seats, and on it the quadrant with its slots and the trim wheel in
    its well."""
    rise = [(-170, 235), (-140, 262), (400, 290), (446, 322), (520, 420), (632, 540), (700, 540)]
    console = prism([(-170, 0), *rise, (700, 0)], "y", -45.0, 45.0)
    well = disc((230.0, -32.0, 245.0), ACROSS, 70.0, 20.0, sides=32)
    slots = union([about_hub(y - 6.0, 140.0, 12.0) for y in LEVER_Y]) - about_hub(
        -50.0, 58.0, 100.0
    )
    return {
        "centre_console": console - well,
        "throttle_quadrant": about_hub(-42.0, 100.0, 84.0) - console - slots,
        "trim_wheel": disc((230.0, -29.0, 245.0), ACROSS, 66.0, 14.0, sides=32),
    }


def lever_parts() -> Parts:
    """The three levers of the quadrant, and those of the console."""
    wing = hull([*ring((0, 0, 0), 13.0), *ring((0, 24, 4), 9.0), *ring((0, -4, 8), 14.0)])
    knob = disc((0, 0, 0), UP, 13.0, 10.0, sides=16) + disc((0, 0, 10), UP, 15.0, 16.0, sides=16)
    heads = (wing, knob, disc((0, 0, 0), UP, 15.0, 24.0, sides=6))
    throttle, propeller, mixture = (
        lever(angle, y, head)
        for angle, y, head in zip((118.0, 107.0, 96.0), LEVER_Y, heads, strict=True)
    )
    flap = sweep([(40.0, 22.0, 262.0), (60.0, 22.0, 292.0), (170.0, 22.0, 338.0)], 6.0, sides=8)
    handle = [
        (165.0, 22.0, 336.0),
        (172.0, 22.0, 339.0),
        (262.0, 22.0, 376.0),
        (268.0, 22.0, 379.0),
    ]
    brake = sweep([(40.0, -20.0, 264.0), (80.0, -20.0, 302.0)], 6.0, sides=6)
    pointer = hull([(356 + x, y, z) for x in (-34, 26) for y in (-6, 6) for z in (293, 314)])
    return {
        "throttle_lever": throttle,
        "propeller_lever": propeller,
        "mixture_lever": mixture,
        "flap_lever": flap + sweep(handle, [9.0, 13.0, 13.0, 8.0]),
        "parking_brake": brake + sweep([(80.0, -42.0, 302.0), (80.0, 2.0, 302.0)], 9.0),
        "fuel_selector": disc((356.0, 0.0, 287.0), UP, 30.0, 8.0) + pointer,
    }


def main() -> None:
    """Write trainer.obj into a folder, environments/trainer where none is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    parts = (
        hull_parts()
        | glass_parts()
        | seat_parts()
        | stick_parts()
        | pedal_parts()
        | console_parts()
        | lever_parts()
        | panel_parts()
    )
    write_obj(folder / "trainer.obj", parts, "two-seat side-by-side light trainer, made by make.py")


if __name__ == "__main__":
    main()
