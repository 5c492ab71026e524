"""The instrument panel: three facets, what is set into them, and the coaming above. Lengths
[mm]."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray
from solids import box, disc, frame, hull, mirrored, place, prism, shell, sweep, union

__all__ = ["panel_parts"]

Floats = NDArray[np.float64]
Parts = dict[str, Manifold]

FOLD_X = 622.0
FOLD_Y = 180.0
FOOT_Z = 575.0  # where the facets meet at their foot
TILT = radians(10.0)
WRAP = radians(8.0)  # top away from the pilot; outer facets turned toward him
THICK = 5.0
BEZEL = 42.0


def facet(turn: float, y: float) -> Floats:
    """The placement of a facet as the pilot sees it: x to the right, y up the face, z out of it
    toward him."""
    right = np.array([sin(turn), -cos(turn), 0.0])
    away = np.array([cos(turn), sin(turn), 0.0])
    return frame((FOLD_X, y, FOOT_Z), right, sin(TILT) * away + [0.0, 0.0, cos(TILT)])


LEFT = facet(WRAP, FOLD_Y)
CENTRE = facet(0.0, 0.0)
RIGHT = facet(-WRAP, -FOLD_Y)

# Where each round instrument sits: its facet, x and y on it, its radius.
GAUGES = {
    "airspeed_indicator": (LEFT, -232.0, 200.0, BEZEL),
    "attitude_indicator": (LEFT, -140.0, 200.0, BEZEL),
    "altimeter": (LEFT, -48.0, 200.0, BEZEL),
    "turn_coordinator": (LEFT, -232.0, 110.0, BEZEL),
    "heading_indicator": (LEFT, -140.0, 110.0, BEZEL),
    "vertical_speed_indicator": (LEFT, -48.0, 110.0, BEZEL),
    "tachometer": (RIGHT, 48.0, 200.0, BEZEL),
    "manifold_pressure_gauge": (RIGHT, 140.0, 200.0, BEZEL),
    "oil_pressure_gauge": (RIGHT, 38.0, 118.0, 29.0),
    "oil_temperature_gauge": (RIGHT, 104.0, 118.0, 29.0),
    "fuel_gauge": (RIGHT, 38.0, 50.0, 29.0),
    "voltmeter": (RIGHT, 104.0, 50.0, 29.0),
}
# The radios from the top down: height of the foot of the front on the centre facet, height of the
# front.
RADIOS = {
    "audio_panel": (236.0, 32.0),
    "nav_com_radio": (166.0, 66.0),
    "nav_com_radio_two": (96.0, 66.0),
    "transponder": (52.0, 40.0),
}
SWITCHES = (
    "master",
    "alternator",
    "avionics",
    "fuel_pump",
    "nav_light",
    "strobe",
    "landing_light",
    "pitot_heat",
)
# Push-pull knobs: facet, x, y.
KNOBS = {
    "carb_heat": (CENTRE, -66.0, 4.0),
    "alternate_air": (CENTRE, -22.0, 4.0),
    "cabin_heat": (CENTRE, 22.0, 4.0),
    "defrost": (CENTRE, 66.0, 4.0),
}
AHEAD = (0.0, 0.0, 1.0)  # out of the face, in a facet's own axes


def behind(depth: float) -> Manifold:
    """All that lies at least so far behind the face of one of the facets."""
    slab = box((-1500.0, -900.0, -900.0), (1500.0, 900.0, -depth))
    return union([place(slab, placement) for placement in (LEFT, CENTRE, RIGHT)])


def plate() -> Manifold:
    """The panel without its holes."""
    half = [(0, 852), (120, 850), (260, 845), (380, 831), (470, 813), (510, 797), (528, 780)]
    half += [
        (530, 668),
        (554, 664),
        (556, 600),
        (538, 580),
        (505, 575),
        (118, 575),
        (104, 548),
        (0, 548),
    ]
    outline = half + [(-y, z) for y, z in half[-2:0:-1]]
    return (behind(0.0) - behind(THICK)) ^ prism(outline, "x", 300.0, 900.0)


def gauge(x: float, y: float, radius: float) -> Manifold:
    """A round instrument: a case behind the panel, a bezel before it, a sunk face with a
    pointer."""
    case = disc((x, y, -60.0), AHEAD, radius - 3.0, 61.0, sides=16)
    bezel = disc((x, y, 0.0), AHEAD, radius, 6.0) - disc((x, y, 2.0), AHEAD, 0.86 * radius, 20.0)
    turn = radians(x + 2.0 * y)  # no two pointers alike
    tip = np.array([sin(turn), cos(turn)])
    side = np.array([cos(turn), -sin(turn)])
    outline = [
        -8.0 * tip - 2.5 * side,
        -8.0 * tip + 2.5 * side,
        0.72 * radius * tip + side,
        0.72 * radius * tip - side,
    ]
    pointer = prism(np.array(outline) + np.array([x, y]), "z", 3.0, 4.5)  # free of the face
    return union([case, bezel, pointer])


def radio(foot: float, height: float) -> Manifold:
    """A radio: a case, a front and two knobs."""
    case = box((-76.0, foot + 2.0, -150.0), (76.0, foot + height - 2.0, 2.0))
    front = box((-80.0, foot, 0.0), (80.0, foot + height, 6.0))
    window = box((-50.0, foot + 0.55 * height, 4.0), (50.0, foot + 0.88 * height, 20.0))
    knobs = [
        disc((x, foot + 0.4 * height, 6.0), AHEAD, 0.2 * min(height, 45.0), 14.0, sides=8)
        for x in (-64.0, 64.0)
    ]
    return union([case, front - window, *knobs])


def knob(x: float, y: float) -> Manifold:
    """A push-pull knob on its shaft."""
    return union(
        [
            disc((x, y, -40.0), AHEAD, 4.0, 66.0, sides=10),
            disc((x, y, 24.0), AHEAD, 12.0, 16.0, sides=16),
        ]
    )


def rocker(x: float, y: float) -> Manifold:
    """A rocker switch, its upper end pressed."""
    return hull(
        [
            (x + a, y + b, c)
            for a in (-7.5, 7.5)
            for b, c in ((-13.0, 3.0), (13.0, 3.0), (13.0, 6.0), (-2.0, 9.0), (-13.0, 13.0))
        ]
    )


def switch_parts() -> Parts:
    """The switch panel with its row of switches, the key and the starter."""
    panel = box((-290.0, 14.0, 0.2), (-14.0, 60.0, 3.0))
    drawn = {f"{name}_switch": rocker(-268.0 + 33.0 * k, 37.0) for k, name in enumerate(SWITCHES)}
    key = disc((-326.0, 100.0, 0.0), AHEAD, 16.0, 6.0) + box(
        (-328.0, 88.0, 6.0), (-324.0, 112.0, 28.0)
    )
    starter = disc((-326.0, 50.0, 0.0), AHEAD, 15.0, 6.0) + disc(
        (-326.0, 50.0, 6.0), AHEAD, 10.0, 8.0, sides=16
    )
    drawn |= {"switch_panel": panel, "ignition_key": key, "starter_button": starter}
    return {name: place(solid, LEFT) for name, solid in drawn.items()}


def right_parts() -> Parts:
    """Glove box, circuit breakers and grab handle of the right facet."""
    lid = hull(
        [
            (x, y, z)
            for x0, x1, y0, y1, z in (
                (164, 332, 20, 104, 0.2),
                (164, 332, 20, 104, 2),
                (168, 328, 24, 100, 5),
            )
            for x in (x0, x1)
            for y in (y0, y1)
        ]
    )
    lid += disc((248.0, 88.0, 5.0), AHEAD, 8.0, 10.0, sides=16)
    breakers = [
        disc((200.0 + 22.0 * i, 132.0 + 24.0 * j, 2.5), AHEAD, 7.0, 11.0, sides=8)
        for i in range(5)
        for j in range(2)
    ]
    board = box((188.0, 116.0, 0.2), (300.0, 172.0, 3.0))
    handle = sweep(
        [
            (194.0, 210.0, 0.2),
            (194.0, 210.0, 34.0),
            (206.0, 210.0, 46.0),
            (284.0, 206.0, 46.0),
            (296.0, 205.0, 34.0),
            (296.0, 205.0, 0.2),
        ],
        8.0,
    )
    drawn = {"glove_box": lid, "circuit_breakers": union([board, *breakers]), "grab_handle": handle}
    return {name: place(solid, RIGHT) for name, solid in drawn.items()}


def vent() -> Manifold:
    """An eyeball vent."""
    outer = disc((0.0, 0.0, 0.0), AHEAD, 27.0, 8.0) - disc((0.0, 0.0, 3.0), AHEAD, 21.0, 20.0)
    return outer + sweep([(0, 0, 0), (0, 0, 9), (0, 0, 13)], [17.0, 14.0, 9.0], sides=20)


def coaming() -> Manifold:
    """The glare shield: falls away forward and to the sides, its edge aft of the panel's top."""
    edge = [(600.0, -522.0), (608.0, -440.0), (620.0, -300.0), (630.0, -180.0), (632.0, 0.0)]
    edge += [(x, -y) for x, y in reversed(edge[:-1])]
    top = np.array(
        [
            [(x + t * (962.0 - x), y * (1.0 - 0.17 * t), shelf(t, y)) for x, y in edge]
            for t in (0.0, 0.03, 0.5, 1.0)
        ]
    )
    top[0, :, 2] -= 7.0
    return shell(
        top - [0.0, 0.0, 14.0] + np.array([0.0, 0.0, 7.0]) * (np.arange(4) == 0)[:, None, None], top
    )


def shelf(t: float, y: float) -> float:
    """Height of the coaming, t of the way forward."""
    return 882.0 - 74.0 * t - (58.0 - 14.0 * t) * float(abs(y / 522.0) ** 2.4)


def compass() -> Manifold:
    """The magnetic compass, on the coaming."""
    return hull(
        [
            *sphere_points((780.0, 0.0, 890.0), 30.0),
            (752, -22, 857),
            (808, -22, 845),
            (752, 22, 857),
            (808, 22, 845),
        ]
    )


def sphere_points(centre: tuple[float, float, float], radius: float) -> Floats:
    """Points on a sphere, ring by ring."""
    lat, turn = np.meshgrid(np.radians([-40.0, 0.0, 40.0, 75.0]), np.arange(12) * np.pi / 6.0)
    unit = np.stack([np.cos(lat) * np.cos(turn), np.cos(lat) * np.sin(turn), np.sin(lat)], axis=-1)
    return radius * unit.reshape(-1, 3) + centre


def panel_parts() -> Parts:
    """The panel and all that is set into it, and the coaming."""
    panel = plate()
    parts = {}
    for name, (placement, x, y, radius) in GAUGES.items():
        parts[name] = place(gauge(x, y, radius), placement)
        panel -= place(disc((x, y, -90.0), AHEAD, radius - 2.0, 200.0, sides=16), placement)
    for name, (foot, height) in RADIOS.items():
        parts[name] = place(radio(foot, height), CENTRE)
    panel -= place(box((-77.0, 53.0, -90.0), (77.0, 267.0, 90.0)), CENTRE)
    for name, (placement, x, y) in KNOBS.items():
        parts[f"{name}_knob"] = place(knob(x, y), placement)
        panel -= place(disc((x, y, -90.0), AHEAD, 5.0, 200.0, sides=10), placement)
    vents = {"left_air_vent": place(vent().translate((-330.0, 176.0, 0.0)), LEFT)}
    vents["right_air_vent"] = mirrored(vents["left_air_vent"])
    return (
        {"instrument_panel": panel}
        | parts
        | switch_parts()
        | right_parts()
        | vents
        | {"coaming": coaming(), "compass": compass()}
    )
