"""The known people of the family: what they measure and weigh, and where the search for their
coefficients starts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from human.family import PLACES, YEARS
from human.source import Person

__all__ = ["KNOWN", "Known"]

MM = 1e-3
# NATICK/TR-15/007 (ANSUR II), medians of 4082 men and 1986 women [mm]; computed from the public
# data
_MEDIAN = {
    "stature": (1755, 1626),
    "acromial_height": (1439, 1332),
    "cervicale_height": (1517, 1393),
    "trochanterion_height": (899, 844),
    "lateral_femoral_epicondyle_height": (491, 465),
    "lateral_malleolus_height": (73, 63),
    "sitting_height": (918, 857),
    "eye_height_sitting": (804, 748),
    "acromial_height_sitting": (603, 564),
    "cervicale_height_sitting": (679, 624),
    "elbow_rest_height": (246, 233),
    "thigh_clearance": (180, 167),
    "knee_height_sitting": (553, 510),
    "popliteal_height": (430, 387),
    "buttock_knee_length": (617, 589),
    "buttock_popliteal_length": (502, 483),
    "abdominal_extension_depth_sitting": (251, 227),
    "hip_breadth_sitting": (378, 397),
    "hip_breadth": (344, 353),
    "bideltoid_breadth": (509, 450),
    "biacromial_breadth": (415, 365),
    "forearm_forearm_breadth": (579, 492),
    "shoulder_elbow_length": (363, 334),
    "acromion_radiale_length": (335, 311),
    "radiale_stylion_length": (267, 240.5),
    "forearm_hand_length": (480, 438),
    "forearm_center_of_grip_length": (348.5, 316),
    "hand_length": (193, 180),
    "hand_breadth": (88, 78),
    "thumb_tip_reach": (811, 742),
    "overhead_fingertip_reach_sitting": (1426, 1309),
    "foot_length": (271, 246),
    "foot_breadth_horizontal": (102, 93),
    "head_length": (200, 190),
    "head_breadth": (154, 147),
    "tragion_top_of_head": (131, 127),
    "interpupillary_breadth": (64, 62),
    "chest_depth": (253, 245),
    "waist_depth": (234, 209),
    "waist_breadth": (325, 298),
    "buttock_depth": (246, 231),
}
_LOOSE = {
    "acromial_height_sitting": 5,
    "elbow_rest_height": 4,
    "thumb_tip_reach": 4,
    "cervicale_height": 5,
    "overhead_fingertip_reach_sitting": 6,
    "forearm_forearm_breadth": 6,
    "acromion_radiale_length": 4,
    "cervicale_height_sitting": 5,
    "trochanterion_height": 60,
    "lateral_femoral_epicondyle_height": 8,
    "abdominal_extension_depth_sitting": 4,
    "buttock_popliteal_length": 4,
    "waist_depth": 5,
    "waist_breadth": 5,
    "buttock_depth": 4,
    "forearm_center_of_grip_length": 4,
    "hand_breadth": 2.5,
    "hip_breadth_sitting": 10,
    "hip_breadth": 15,
    "thigh_clearance": 3,
    "foot_breadth_horizontal": 2.5,
}
"""Tolerances [mm] of measures whose landmark the sphere body stands in for; 2.5 for the others."""
_SHARE = {
    "LT": (0.1117, 0.1247),
    "CT": (0.1633, 0.1465),
    "UT": (0.133, 0.1279),
    "LSM": (0.0133, 0.0133),
    "N": (0.0139, 0.0134),
    "H": (0.0555, 0.0534),
    "LUA": (0.0271, 0.0255),
    "LLA": (0.0162, 0.0138),
    "LHN": (0.0061, 0.0056),
    "LUL": (0.1416, 0.1478),
    "LLL": (0.0433, 0.0481),
    "LF": (0.0137, 0.0129),
}
"""Shares of the body's mass, men and women: de Leva 1996, table 4; shoulder masses from the upper
trunk, a fifth of head and neck the neck."""


_HEIGHTS = {
    "LH": (914.5, 857),
    "LK": (491.5, 464.5),
    "LA": (69, 63.5),
    "LS": (1401, 1294),
    "LE": (1112, 1028),
    "LW": (837, 781),
}
"""Heights [mm] of the joints of a man and a woman over the soles. Knee and ankle are at the lateral
epicondyle of the femur and the lateral malleolus (491 and 465, 73 and 63 in ANSUR II), the wrist at
the stylion, the elbow 3 % of the forearm over the radiale, the shoulder 38 mm under the acromion.
The hip joint is 15 mm over the trochanterion (899 and 844), in the middle of what is published: -7 mm
(tip of the bone) to 33 (de Leva 1996), see docs/human-family.md. The thigh is .241 and .242 of the
stature (.234 to .2425), the shank .241 and .247 (.24 to .25)."""
_SEATED = ((1.096, 0.75), (1.124, 0.73))
"""Breadth and thickness of hips and thighs on a seat as shares of those standing, men and women.
The breadths are the medians of hip breadth sitting over hip breadth in ANSUR II, computed from the
public data; with the thicknesses the thighs' undersides are level with the buttocks'."""


@dataclass(frozen=True)
class Known:
    """description; start: person and stature [m]; mass [kg]; share of the mass by segment (empty:
    as volumes); measures: value and tolerance [m]; like: sex and ages [years] of people like this
    one; seated: breadth and thickness of hips and thighs on a seat as shares of those standing;
    heights: of left joints [m], standing."""

    description: str
    source: str
    start: Person
    stature: float
    mass: float
    share: dict[str, float]
    measures: dict[str, tuple[float, float]]
    like: tuple[float, float, float]
    masses: dict[str, float] = field(default_factory=dict)
    seated: tuple[float, float] = (1.0, 1.0)
    heights: dict[str, float] = field(default_factory=dict)

    @property
    def hips(self) -> float:
        """How far the hip joints are apart [m]: 176 mm at a stature of 1.75 m (the AnyBody
        repository's model, after measured people)."""
        return 0.176 * self.stature / 1.75


def _age(years: float) -> float:
    return float(np.interp(years, YEARS, PLACES))


def _adult(k: int, description: str, start: Person, mass: float) -> Known:
    measures = {name: (MM * row[k], MM * _LOOSE.get(name, 2.5)) for name, row in _MEDIAN.items()}
    share = {name: row[k] for name, row in _SHARE.items()}
    source = (
        "spheres fitted to the MakeHuman base mesh (CC0, MPFB2 assets); size: medians of ANSUR II "
        "(NATICK/TR-15/007); masses: de Leva 1996"
    )
    like = (1.0 - k, 18.0, 66.0)
    masses = {name: mass * part for name, part in share.items()}
    return Known(
        description,
        source,
        start,
        MM * _MEDIAN["stature"][k],
        mass,
        share,
        measures,
        like,
        masses,
        _SEATED[k],
        {name: MM * row[k] for name, row in _HEIGHTS.items()},
    )


def _child(years: int, mass: float, sizes: dict[str, tuple[float, float]], start: Person) -> Known:
    source = (
        "spheres fitted to the MakeHuman base mesh (CC0, MPFB2 assets); size and mass: Hybrid III "
        f"{years}-year-old dummy (NHTSA physical data)"
    )
    measures = {name: (MM * value, MM * tolerance) for name, (value, tolerance) in sizes.items()}
    like = (0.5, years - 1.5, years + 2.5)
    return Known(
        f"child of {years} years", source, start, measures["stature"][0], mass, {}, measures, like
    )


KNOWN = {
    "adult_male": _adult(
        0, "adult man of median size", Person(male=1, age=_age(32), muscle=0.62, weight=0.85), 84.6
    ),
    "adult_female": _adult(
        1,
        "adult woman of median size",
        Person(male=0, age=_age(30), muscle=0.5, weight=0.75, firmness=0.6),
        66.8,
    ),
    "child_6": _child(
        6,
        23.41,
        {
            "stature": (1143, 2),
            "sitting_height": (635, 3),
            "shoulder_elbow_length": (224, 5),
            "head_length": (173, 3),
            "head_breadth": (142, 3),
            "buttock_knee_length": (382, 8),
        },
        Person(male=0.5, age=_age(6), weight=0.55),
    ),
    "child_3": _child(
        3,
        15.47,
        {
            "stature": (945, 2),
            "sitting_height": (546, 3),
            "shoulder_elbow_length": (193, 5),
            "thigh_clearance": (86, 8),
            "elbow_rest_height": (141, 8),
            "buttock_knee_length": (295, 6),
            "popliteal_height": (235, 8),
            "buttock_popliteal_length": (226, 15),
            "chest_depth": (117, 8),
            "foot_length": (143, 4),
        },
        Person(male=0.5, age=_age(3), weight=0.55),
    ),
}
