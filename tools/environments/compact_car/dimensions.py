"""The dimensions of the compact car, by SAE J1100 code, and the points that follow from them.
Lengths [mm].

The mesh has x forward of the driver's seating reference point (SgRP), y left of the centre line, z
above the floor where the heel stands. Where a value is from:

* H-Point book (Macey & Wardle, chapter 6), "small" and "medium" car: H30, H5, A40, H61, A61; W20
  within its range.
* SAE J1517 as coded in the public program Primary_18.m: L53 with A47, from X95 and the 203 mm of
  the manikin's foot.
* this project's choice, usual for such a car but taken from no source: L6 (so that Park's posture
  angles are at the middle of their range), H17, W9, A18, A27, L23, A19 = 0 with a lift apart from
  the track, W3, and all shapes.
"""

from __future__ import annotations

from math import cos, radians, sin

__all__ = [
    "A18",
    "A27",
    "A40",
    "A47",
    "BACK_GAP",
    "BALL",
    "CUSHION_GAP",
    "H5",
    "H17",
    "H30",
    "H61",
    "HEEL",
    "L6",
    "L23",
    "L53",
    "ROOF",
    "SIDE",
    "SRP",
    "W3",
    "W9",
    "W20",
    "WHEEL",
]

H30 = 250.0
H5 = 475.0
H61 = 975.0  # seat over heel, seat over ground, headroom with the 102 mm it is told with
A40 = radians(24.0)
A27 = radians(14.0)
A18 = radians(24.0)  # back, cushion, wheel plane from the vertical
L6 = 560.0
H17 = 650.0
W9 = 370.0  # ball of foot aft to the wheel's centre; its height; the wheel's diameter
W20 = 350.0
W3 = 1400.0  # the seat from the centre line; room at the shoulders
L23 = (-40.0, 200.0)  # travel of the track about the SgRP; level (A19 = 0)

X95 = 913.7 + 0.672316 * H30 - 0.0019553 * H30**2
A47 = radians(78.96 - 0.15 * H30 / 10 - 0.0173 * (H30 / 10) ** 2)
L53 = X95 - 203.0 * cos(A47)

SIDE = W20 - 130.0  # across, where the accelerator is
HEEL = (L53, SIDE, 0.0)  # AHP
BALL = (X95, SIDE, 203.0 * sin(A47))  # BOFRP
WHEEL = (X95 - L6, W20, H17)
ROOF = (
    -(H61 - 102.0) * sin(radians(8.0)),
    W20,
    H30 + (H61 - 102.0) * cos(radians(8.0)),
)  # where H61 ends

# Cushion and back are planes in front of which sitters' flesh gives way. Bodies in Park's mean
# posture have their lowest 95 mm below the hip point along the cushion's normal and their rearmost
# 112 mm behind it along the back's; they are to sink in by 20 and 15 mm.
CUSHION_GAP = 75.0
BACK_GAP = 97.0


def _corner() -> tuple[float, float, float]:
    """Where the planes meet on the seat's centre line: -sin A27 x + cos A27 z = -CUSHION_GAP and
    cos A40 x + sin A40 z = -BACK_GAP about the hip point."""
    det = -sin(A27) * sin(A40) - cos(A27) * cos(A40)
    x = (-CUSHION_GAP * sin(A40) + BACK_GAP * cos(A27)) / det
    z = (BACK_GAP * sin(A27) + CUSHION_GAP * cos(A40)) / det
    return (x, W20, H30 + z)


SRP = _corner()
