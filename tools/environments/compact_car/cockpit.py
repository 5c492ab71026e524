"""What the driver works with: pedals, steering wheel and column, instrument panel, centre stack,
console. Lengths [mm].

All shapes and places are this project's choice but for what `dimensions` says.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np
from dimensions import A18, A47, BALL, HEEL, W9, WHEEL
from manifold3d import CrossSection, Manifold
from numpy.typing import NDArray
from solids import box, disc, frame, hull, mirrored, place, prism, sweep, union

__all__ = ["both", "cockpit_parts"]

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

RIM = 15.0  # radius of the rim's section
AFT = np.array([-cos(A18), 0.0, sin(A18)])  # out of the wheel's plane toward the driver
HALF = 690.0  # half width of the panel
REST_ANGLE = np.radians(50.0)  # the foot rest's face rises from beside the heel
REST_Y = 515.0


def both(parts: Parts) -> Parts:
    """Each part as left_NAME and, mirrored, as right_NAME."""
    named = {f"left_{name}": solid for name, solid in parts.items()}
    return named | {f"right_{name}": mirrored(solid) for name, solid in parts.items()}


def cockpit_parts() -> Parts:
    """All of it."""
    return wheel_parts() | pedal_parts() | panel_parts() | stack_parts() | console_parts()


def at_wheel(right: float, up: float, aft: float) -> Floats:
    """A point by the wheel's own axes as the driver sees it: to the right, up in its plane, toward
    the driver."""
    centre: Floats = np.array(WHEEL) + right * np.array([0.0, -1.0, 0.0]) + aft * AFT
    return centre + up * np.array([sin(A18), 0.0, cos(A18)])


def wheel_parts() -> Parts:
    """The steering wheel as a torus with three spokes and a hub, its column and shroud, and the
    stalks."""
    placement = frame(WHEEL, (0.0, -1.0, 0.0), (sin(A18), 0.0, cos(A18)))
    middle = 0.5 * W9 - RIM
    rim = CrossSection.circle(RIM, 10).translate((middle, 0.0)).revolve(40)
    spokes = [
        hull(
            [
                (x, y, z)
                for x, w in ((s * 40.0, 34.0), (s * middle, 20.0))
                for y in (-w, w)
                for z in (-22, -8)
            ]
        )
        for s in (-1.0, 1.0)
    ]
    spokes.append(
        hull(
            [
                (x, y, z)
                for y, w in ((-40.0, 30.0), (-middle, 18.0))
                for x in (-w, w)
                for z in (-22, -8)
            ]
        )
    )
    hub = hull(
        [
            (r * np.cos(t), 0.8 * r * np.sin(t), z)
            for r, z in ((74.0, -34.0), (78.0, -14.0), (62.0, 4.0))
            for t in (np.arange(20) + 0.5) * np.pi / 10
        ]
    )
    wheel = place(union([rim, *spokes, hub]), placement)
    shroud = sweep(
        [at_wheel(0, 0, -66), at_wheel(0, 0, -90), at_wheel(0, -6, -270)],
        [46.0, 56.0, 62.0],
        flat=0.85,
    )
    stalks = {}
    for name, side in (("turn_signal_stalk", -1.0), ("wiper_stalk", 1.0)):
        path = [
            at_wheel(side * x, up, -78.0) for x, up in ((40, 6), (120, 14), (150, 17), (196, 22))
        ]
        stalks[name] = sweep(path, [8.0, 7.0, 10.0, 9.0], sides=10, flat=0.8)
    return {
        "steering_wheel": wheel,
        "steering_column": sweep([at_wheel(0, 0, -30), at_wheel(0, 0, -420)], 24.0),
        "column_shroud": shroud,
        **stalks,
    }


def pad(centre: Floats, width: float, length: float) -> Manifold:
    """A pedal's plate whose face is the accelerator's plane through a point."""
    placement = frame(centre, (cos(A47), 0.0, sin(A47)), (0.0, 1.0, 0.0))
    points = []
    for n, a in ((0.0, 4.0), (3.0, 0.0), (11.0, 0.0)):
        u = 0.5 * length - a
        v = 0.5 * width - a
        points += [(s * u, t * v, n) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    plate = hull(points)
    return place(plate, placement)


def on_pedals(along: float, toward: float, y: float) -> Floats:
    """A point so far up the accelerator's plane from the heel, and in front of it toward the
    driver."""
    return np.array(
        [HEEL[0] + along * cos(A47) - toward * sin(A47), y, along * sin(A47) + toward * cos(A47)]
    )


def pedal_parts() -> Parts:
    """Accelerator, brake and clutch hung from above, the foot rest beside them."""
    parts = {}
    for name, y, toward, along, size in (
        ("accelerator", BALL[1], 0.0, 180.0, (54.0, 150.0)),
        ("brake", 297.0, 45.0, 205.0, (76.0, 62.0)),
        ("clutch", 405.0, 45.0, 205.0, (64.0, 62.0)),
    ):
        top = on_pedals(along + 0.3 * size[1], toward - 9.0, y)
        arm = sweep(
            [on_pedals(along, toward - 9.0, y), top, (1085.0, y, 380.0), (1092.0, y, 480.0)],
            8.0,
            sides=8,
        )
        parts[name] = pad(on_pedals(along, toward, y), *size) + arm
    face = (cos(REST_ANGLE), 0.0, sin(REST_ANGLE))
    rest = hull([(u, v, n) for u in (60.0, 260.0) for v in (-45.0, 45.0) for n in (0.0, 26.0)])
    foot_rest = place(rest, frame((HEEL[0], REST_Y, 0.0), face, (0.0, -1.0, 0.0)))
    return parts | {"foot_rest": foot_rest}


def vent(y: float, z: float, x: float, width: float) -> Manifold:
    """An air vent: a frame with three fins."""
    whole = box((x, y - 0.5 * width, z - 28.0), (x + 16.0, y + 0.5 * width, z + 28.0))
    gaps = [
        box((x - 1.0, y - 0.5 * width + 6.0, z + k), (x + 10.0, y + 0.5 * width - 6.0, z + k + 8.0))
        for k in (-22.0, -10.0, 2.0, 14.0)
    ]
    return whole - union(gaps)


def panel_parts() -> Parts:
    """The instrument panel across the car, the hood over the instruments, vents, light switch,
    glove box."""
    profile = [(690, 470), (655, 492), (642, 520), (650, 590), (640, 640), (646, 712), (662, 742), (700, 762),
               (830, 778), (955, 790), (1140, 780), (1150, 440), (800, 440)]  # fmt: skip
    body = prism(profile, "y", -HALF, HALF)
    hood_line = [(622, 742), (618, 782), (628, 806), (652, 812), (760, 800), (840, 776), (700, 740)]
    hood = prism(hood_line, "y", WHEEL[1] - 170.0, WHEEL[1] + 170.0)
    ends = ((610.0, 152.0, 660.0, 798.0), (690.0, 140.0, 672.0, 786.0))
    hole = hull(
        [(x, WHEEL[1] + y, z) for x, w, low, high in ends for y in (-w, w) for z in (low, high)]
    )
    dials = [
        disc((678.0, WHEEL[1] + y, 726.0), (1.0, 0.0, 0.0), r, 9.0, sides=28)
        for y, r in ((72, 46), (-72, 46), (0, 24))
    ]
    column = sweep([at_wheel(0, -4, -200), at_wheel(0, -4, -460)], 76.0)
    vents = union(
        [
            body ^ box((600, y - w, 650), (700, y + w, 712))
            for y, w in ((620, 58), (-620, 58), (72, 62), (-72, 62))
        ]
    )
    lid = box((634.0, -520.0, 520.0), (676.0, -190.0, 612.0))
    return {
        "instrument_panel": (body + hood) - hole - column - vents - lid,
        "instrument_cluster": union(
            [*dials, box((687.0, WHEEL[1] - 138, 674), (694.0, WHEEL[1] + 138, 785))]
        ),
        "left_air_vent": vent(620.0, 680.0, 634.0, 112.0),
        "right_air_vent": vent(-620.0, 680.0, 634.0, 112.0),
        "centre_air_vents": vent(72.0, 680.0, 634.0, 120.0) + vent(-72.0, 680.0, 634.0, 120.0),
        "glove_box": box((636.0, -517.0, 523.0), (674.0, -193.0, 609.0)),
        "glove_box_handle": box((624.0, -400.0, 584.0), (636.0, -310.0, 604.0)),
        "light_switch": disc((646.0, 565.0, 600.0), (-1.0, 0.0, 0.0), 21.0, 20.0, sides=18),
        "start_button": disc((644.0, 176.0, 622.0), (-1.0, 0.0, 0.0), 17.0, 9.0, sides=18),
    }


def on_stack(right: float, up: float, out: float) -> Floats:
    """A point of the centre stack's face: to the right, up the face from its foot, out of it toward
    the driver."""
    slope = np.radians(75.0)
    face = np.array([cos(slope), 0.0, sin(slope)])
    away = np.array([-sin(slope), 0.0, cos(slope)])
    point: Floats = np.array([590.0, -right, 430.0]) + up * face + out * away
    return point


def stack_knob(right: float, up: float, radius: float) -> Manifold:
    """A turning knob on the stack's face."""
    base = on_stack(right, up, 0.0)
    tip = on_stack(right, up, 24.0)
    return sweep(
        [base, 0.4 * base + 0.6 * tip, tip], [radius, radius - 2.0, radius - 4.0], sides=18
    )


def stack_parts() -> Parts:
    """The centre stack with the touch screen on top, the row of climate knobs, the hazard
    button."""
    low = on_stack(0, 0, 0)
    high = on_stack(0, 240, 0)
    side = [
        (low[0], low[2]),
        (high[0], high[2]),
        (700.0, high[2]),
        (700.0, low[2] - 60.0),
        (572.0, low[2] - 60.0),
    ]
    screen = [
        on_screen(right, up, out) for right in (-128, 128) for up in (-80, 80) for out in (-16, 0)
    ]
    return {
        "centre_stack": prism(side, "y", -118.0, 118.0),
        "touch_screen": hull(screen),
        "temperature_knob": stack_knob(-80.0, 70.0, 24.0),
        "fan_knob": stack_knob(0.0, 70.0, 24.0),
        "air_knob": stack_knob(80.0, 70.0, 24.0),
        "hazard_button": hull(
            [on_stack(r, u, n) for r in (-16, 16) for u in (152, 176) for n in (-4, 6)]
        ),
    }


def on_screen(right: float, up: float, out: float) -> Floats:
    """A point of the touch screen's face, from its middle; the top leans away by 12 degrees."""
    lean = np.radians(12.0)
    middle = np.array([608.0, 0.0, 762.0])
    point: Floats = middle + right * np.array([0, -1, 0]) + up * np.array([sin(lean), 0, cos(lean)])
    return point + out * np.array([-cos(lean), 0.0, sin(lean)])


def console_parts() -> Parts:
    """The console between the seats with gear lever, park brake and the belt's buckle."""
    top = [
        (-420, 0),
        (-420, 190),
        (-380, 205),
        (250, 205),
        (360, 232),
        (490, 292),
        (590, 400),
        (700, 400),
        (700, 0),
    ]
    console = prism(top, "y", -92.0, 92.0)
    slot = box((-170.0, 18.0, 150.0), (130.0, 62.0, 260.0))
    boot = sweep([(330.0, 30.0, 200.0), (322.0, 30.0, 262.0)], [62.0, 20.0], sides=16)
    lever = sweep([(322.0, 30.0, 255.0), (305.0, 30.0, 345.0)], [9.0, 8.0], sides=10)
    knob = sweep([(307.0, 30.0, 334.0), (304.0, 30.0, 348.0), (301.0, 30.0, 366.0), (298.0, 30.0, 378.0)],
                 [14.0, 22.0, 25.0, 15.0], sides=14)  # fmt: skip
    brake = sweep([(-150.0, 40.0, 190.0), (-60.0, 40.0, 216.0), (-10.0, 40.0, 232.0), (108.0, 40.0, 268.0),
                   (122.0, 40.0, 272.0)], [11.0, 11.0, 15.0, 15.0, 9.0])  # fmt: skip
    buckle = hull(
        [
            (x, y, z)
            for x, z, w in ((-95, 150, 12), (-55, 150, 12), (-88, 236, 16), (-44, 236, 16))
            for y in (112.0 - w + 8, 112.0 + w - 8)
        ]
    )
    return {
        "centre_console": console - slot,
        "gear_lever_boot": boot,
        "gear_lever": lever + knob,
        "park_brake": brake,
        "belt_buckle": buckle,
    }
