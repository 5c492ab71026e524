"""Build compact_car.obj, the front of a compact car inside: python tools/environments/compact_car/make.py

Every length is in mm here; x is forward of the driver's seating reference point, y left of the
centre line, z above the floor at the heel. `dimensions` says where each dimension is from.
"""

from __future__ import annotations

import sys
from math import cos, sin
from pathlib import Path

import numpy as np
from dimensions import A27, A40, ROOF, SRP, W20
from manifold3d import Manifold
from numpy.typing import NDArray

# where the solids of all environments are
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cockpit import both, cockpit_parts
from mirrors import outside_parts
from solids import box, disc, hull, loft, mirrored, prism, shell, sweep, union, write_obj

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

FOLDER = Path(__file__).resolve().parents[3] / "environments" / "compact_car"

TAIL = -820.0
TOE = 990.0
FIRE = 1150.0
# The roof's lining above the centre line: x and z; it falls toward the rails.
CROWN = [
    (TAIL, 1074.0),
    (-600.0, 1098.0),
    (-380.0, 1112.0),
    (ROOF[0], ROOF[2] + 6.0),
    (80.0, 1114.0),
    (230.0, 1100.0),
    (352.0, 1076.0),
]
ACROSS = [
    (-575.0, -46.0),
    (-480.0, -20.0),
    (-W20, -6.0),
    (0.0, 0.0),
    (W20, -6.0),
    (480.0, -20.0),
    (575.0, -46.0),
]
LEAN = 0.36  # how far the side glass leans in by its height
BELT = 705.0  # height of the belt line


def shell_parts() -> Parts:
    """Floor, toe board, walls of the footwell, roof, rails, pillars and glass."""
    toe = [
        (TOE, 0.0),
        (FIRE, 340.0),
        (FIRE + 10, 560.0),
        (FIRE + 24, 560.0),
        (FIRE + 14, 336.0),
        (TOE + 16, -4.0),
    ]
    inner = np.array([[(x, y, z + drop) for y, drop in ACROSS] for x, z in CROWN])
    rail = sweep(
        [
            (TAIL, 590.0, 1010.0),
            (-380.0, 592.0, 1046.0),
            (80.0, 592.0, 1052.0),
            (352.0, 585.0, 1020.0),
        ],
        24.0,
    )
    a_pillar = sweep(
        [(352.0, 585.0, 1020.0), (560.0, 630.0, 930.0), (955.0, 700.0, 775.0)],
        [32.0, 42.0, 51.0],
        flat=0.9,
    )
    b_pillar = sweep([(-420.0, 745.0, 0.0), (-418.0, 742.0, 500.0), (-412.0, 724.0, BELT), (-396.0, 600.0, 1040.0)],
                     [48.0, 46.0, 38.0, 30.0], flat=0.55)  # fmt: skip
    base = (944.0, 690.0, 796.0)
    top = (372.0, 574.0, 1072.0)
    glass = [np.array([(x, -y, z), (x, y, z)]) for x, y, z in (base, top)]
    lift = np.array([2.6, 0.0, 5.4])
    return {
        "floor": box((TAIL, -700.0, -20.0), (TOE + 20.0, 700.0, 0.0)),
        "toe_board": prism(toe, "y", -690.0, 690.0),
        "roof_lining": shell(inner, inner + np.array([0.0, 0.0, 14.0])),
        "front_header": sweep(
            [(362.0, -570.0, 1046.0), (364.0, 0.0, 1068.0), (362.0, 570.0, 1046.0)], 20.0, flat=0.7
        ),
        "windscreen": loft([np.array([*g, *(g[::-1] + lift)]) for g in glass]),
        **both(
            {
                "roof_rail": rail,
                "a_pillar": a_pillar,
                "b_pillar": b_pillar,
                "side_glass": side_glass(),
            }
        ),
        **both({"sun_visor": box((238.0, 210.0, 1042.0), (352.0, 500.0, 1054.0))}),
    }


def side_glass() -> Manifold:
    """The left door's window in its leaning plane."""
    outline = [
        (-372.0, BELT),
        (760.0, BELT + 22.0),
        (560.0, 900.0),
        (352.0, 996.0),
        (80.0, 1028.0),
        (-366.0, 1022.0),
    ]
    pane = prism(outline, "y", 0.0, 4.0)
    lean = np.array(
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, -LEAN, 724.0 + LEAN * BELT], [0.0, 0.0, 1.0, 0.0]]
    )
    return pane.transform(lean)


def door_parts() -> Parts:
    """The doors: trim with a pocket, armrest with the window switches, handle, pull."""
    section = [
        (724, 40),
        (690, 60),
        (686, 240),
        (706, 330),
        (706, 560),
        (700, BELT - 14),
        (724, BELT),
        (760, BELT),
        (770, 40),
    ]
    trim = prism(section, "x", -372.0, 960.0)
    rest = [(712, 305), (664, 327), (626, 367), (624, 389), (632, 399), (712, 405)]
    armrest = prism(rest, "x", -150.0, 250.0)
    nose = hull(
        [
            (x, y, z)
            for x, low in ((248.0, 305.0), (350.0, 375.0))
            for y in (640.0, 712.0)
            for z in (low, 404.0)
        ]
    )
    switches = union([box((x, 640.0, 399.0), (x + 26.0, 676.0, 411.0)) for x in (178.0, 212.0)])
    handle = sweep(
        [
            (270.0, 704.0, 560.0),
            (280.0, 668.0, 562.0),
            (350.0, 666.0, 566.0),
            (368.0, 704.0, 568.0),
        ],
        8.0,
    )
    latch = disc((250.0, 708.0, 640.0), (0.0, -1.0, 0.0), 12.0, 18.0, sides=14)
    sill = box((-372.0, 640.0, 0.0), (960.0, 688.0, 62.0))
    return both(
        {
            "door_trim": trim,
            "armrest": armrest + nose,
            "window_switches": switches,
            "door_handle": handle,
            "door_lock": latch,
            "sill": sill,
        }
    )


# The seats are drawn from the corner of their planes: `back(u, n)` lies u up the back and n in
# front of it, `cushion(u, n)` u along the cushion and n above it.


def back(u: float, n: float, y: float) -> tuple[float, float, float]:
    """A point u up the back plane and n in front of it."""
    return (-u * sin(A40) + n * cos(A40), y, u * cos(A40) + n * sin(A40))


def cushion(u: float, n: float, y: float) -> tuple[float, float, float]:
    """A point u along the cushion plane and n above it."""
    return (u * cos(A27) - n * sin(A27), y, u * sin(A27) + n * cos(A27))


def seat_pan() -> Manifold:
    """The cushion, flat on top, with its front edge rounded off."""
    points = []
    for half, depth in ((215.0, 0.0), (248.0, 20.0), (252.0, 70.0), (236.0, 100.0)):
        lead = (
            372.0
            if depth == 0.0
            else 400.0
            if 10.0 < depth < 30.0
            else 412.0
            if depth < 80.0
            else 380.0
        )
        start = -depth * (sin(A27 + A40) / cos(A27 + A40))
        points += [cushion(u, -depth, s * half) for u in (-start, lead) for s in (-1.0, 1.0)]
    bolsters = []
    for s in (-1.0, 1.0):
        ends = [
            cushion(u, n, s * w)
            for u in (60.0, 350.0)
            for n, w in ((-40.0, 214.0), (22.0, 246.0), (-40.0, 262.0))
        ]
        bolsters.append(hull(ends))
    return union([hull(points), *bolsters])


def seat_back() -> Manifold:
    """The back: flat in front, its edges rounded off, wings at the sides."""
    outline = [(-60.0, 205.0), (300.0, 225.0), (480.0, 205.0), (588.0, 140.0)]
    points = []
    for inset, n in ((14.0, 0.0), (0.0, -18.0), (0.0, -60.0), (24.0, -92.0)):
        for u, half in outline:
            end = inset if u > 500.0 else 0.0
            points += [back(u - end, n, s * (half - inset)) for s in (-1.0, 1.0)]
    wings = []
    for s in (-1.0, 1.0):
        at = [
            (u, n, w)
            for u, lead in ((70.0, 38.0), (400.0, 30.0))
            for n, w in ((-60, 208), (lead, 246), (-60, 262))
        ]
        ends = [back(u, n, s * w) for u, n, w in at]
        wings.append(hull(ends))
    return union([hull(points), *wings])


def headrest() -> Manifold:
    """The head restraint on its two posts, in front of the back's plane."""
    points = []
    for inset, n in ((12.0, 42.0), (0.0, 30.0), (0.0, -8.0), (16.0, -26.0)):
        for u, half in (
            (640.0 + inset, 96.0),
            (668.0, 122.0),
            (770.0, 116.0),
            (814.0 - inset, 74.0),
        ):
            points += [back(u, n, s * (half - inset)) for s in (-1.0, 1.0)]
    posts = [
        sweep([back(560.0, -44.0, y), back(640.0, -34.0, y), back(690.0, 6.0, y)], 7.0)
        for y in (-60.0, 60.0)
    ]
    return union([hull(points), *posts])


def seat_parts() -> Parts:
    """Driver's and passenger's seat, alike."""
    drawn = {"pan": seat_pan(), "back": seat_back()}
    seat = {f"seat_{name}": solid.translate(SRP) for name, solid in drawn.items()}
    seat["headrest"] = headrest().translate(SRP)
    trestles = [
        prism([(-150, 34), (230, 34), (260, 92), (-130, 78)], "y", y - 20.0, y + 20.0)
        for y in (W20 - 190, W20 + 190)
    ]
    tubes = [sweep([(x, W20 - 190, 60.0), (x, W20 + 190, 60.0)], 12.0) for x in (-100.0, 190.0)]
    seat["seat_base"] = union([*trestles, *tubes])
    seat["seat_rails"] = union(
        [box((-300.0, y - 16.0, 0.0), (330.0, y + 16.0, 30.0)) for y in (W20 - 190, W20 + 190)]
    )
    named = {f"driver_{name}": solid for name, solid in seat.items()}
    return named | {f"passenger_{name}": mirrored(solid) for name, solid in seat.items()}


def main() -> None:
    """Write compact_car.obj into a folder, environments/compact_car where none is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    parts = shell_parts() | door_parts() | seat_parts() | cockpit_parts() | outside_parts()
    write_obj(folder / "compact_car.obj", parts, "front of a compact car inside, made by make.py")


if __name__ == "__main__":
    main()
