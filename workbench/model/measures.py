"""Measures: the anthropometric dimensions the workbench knows, named as ANSUR II names them.

Definitions and landmarks: Hotzman et al. 2011, NATICK/TR-11/017 (the measurer's handbook of ANSUR
II). A name is the column of the public ANSUR II files with its words set apart. Three differ:
`mass` is `weightkg`, and `acromial_height_sitting` and `cervicale_height_sitting` are derived:
sitting height - (stature - standing height).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from workbench.errors import InputError, one_of

__all__ = [
    "COCKPIT",
    "GIRTHS",
    "MASS",
    "MEASURES",
    "ON_THE_BODY",
    "WORDS",
    "check_measures",
    "check_plausible",
]

MASS = "mass"
# The six of the boundary manikins of cockpits: Zehner, Meindl & Hudson 1993, AL-TR-1992-0164.
COCKPIT = (
    "thumb_tip_reach",
    "buttock_knee_length",
    "knee_height_sitting",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
)
# Taken by a tape around the body.
GIRTHS = (
    "chest_circumference",
    "waist_circumference",
    "buttock_circumference",
    "thigh_circumference",
    "calf_circumference",
    "biceps_circumference_flexed",
)
# Those that the virtual anthropometer takes, and that a body can be scaled to.
ON_THE_BODY = (
    "stature",
    "acromial_height",
    "cervicale_height",
    "trochanterion_height",
    "lateral_femoral_epicondyle_height",
    "lateral_malleolus_height",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
    "cervicale_height_sitting",
    "elbow_rest_height",
    "thigh_clearance",
    "knee_height_sitting",
    "popliteal_height",
    "buttock_knee_length",
    "buttock_popliteal_length",
    "abdominal_extension_depth_sitting",
    "hip_breadth_sitting",
    "hip_breadth",
    "bideltoid_breadth",
    "biacromial_breadth",
    "forearm_forearm_breadth",
    "shoulder_elbow_length",
    "acromion_radiale_length",
    "radiale_stylion_length",
    "forearm_hand_length",
    "forearm_center_of_grip_length",
    "hand_length",
    "hand_breadth",
    "thumb_tip_reach",
    "overhead_fingertip_reach_sitting",
    "foot_length",
    "foot_breadth_horizontal",
    "head_length",
    "head_breadth",
    "tragion_top_of_head",
    "interpupillary_breadth",
    "chest_depth",
    "waist_depth",
    "waist_breadth",
    "buttock_depth",
    *GIRTHS,
)
# (least, greatest) that a person may measure [m; kg for mass]: 0.45 times the least and 1.4 times
# the greatest of the 6068 people of ANSUR II (mass by hand), so that a child and a giant pass and a
# wrong unit does not.
MEASURES: dict[str, tuple[float, float]] = {
    "stature": (0.63, 2.8),
    "mass": (8, 250),
    "sitting_height": (0.34, 1.5),
    "eye_height_sitting": (0.29, 1.3),
    "acromial_height_sitting": (0.21, 1),
    "cervicale_height_sitting": (0.24, 1.1),
    "elbow_rest_height": (0.062, 0.48),
    "thigh_clearance": (0.054, 0.36),
    "knee_height_sitting": (0.18, 0.93),
    "popliteal_height": (0.14, 0.73),
    "buttock_knee_length": (0.21, 1),
    "buttock_popliteal_length": (0.17, 0.85),
    "abdominal_extension_depth_sitting": (0.07, 0.63),
    "hip_breadth_sitting": (0.13, 0.76),
    "bideltoid_breadth": (0.16, 0.89),
    "biacromial_breadth": (0.13, 0.68),
    "forearm_forearm_breadth": (0.17, 1.1),
    "shoulder_elbow_length": (0.12, 0.59),
    "acromion_radiale_length": (0.11, 0.55),
    "radiale_stylion_length": (0.076, 0.46),
    "forearm_hand_length": (0.15, 0.8),
    "forearm_center_of_grip_length": (0.12, 0.58),
    "hand_length": (0.065, 0.33),
    "hand_breadth": (0.03, 0.15),
    "thumb_tip_reach": (0.27, 1.4),
    "overhead_fingertip_reach_sitting": (0.5, 2.3),
    "span": (0.6, 3),
    "foot_length": (0.089, 0.45),
    "foot_breadth_horizontal": (0.035, 0.18),
    "head_length": (0.076, 0.32),
    "head_breadth": (0.059, 0.25),
    "tragion_top_of_head": (0.047, 0.21),
    "interpupillary_breadth": (0.023, 0.11),
    "menton_sellion_length": (0.041, 0.22),
    "bizygomatic_breadth": (0.052, 0.24),
    "trochanterion_height": (0.3, 1.5),
    "crotch_height": (0.27, 1.4),
    "lateral_femoral_epicondyle_height": (0.16, 0.83),
    "lateral_malleolus_height": (0.019, 0.13),
    "shoulder_length": (0.048, 0.26),
    "chest_breadth": (0.096, 0.51),
    "chest_depth": (0.076, 0.54),
    "waist_breadth": (0.095, 0.65),
    "waist_depth": (0.062, 0.57),
    "hip_breadth": (0.12, 0.66),
    "buttock_depth": (0.076, 0.49),
    "head_circumference": (0.23, 0.89),
    "neck_circumference": (0.12, 0.72),
    "chest_circumference": (0.31, 2.1),
    "waist_circumference": (0.27, 1.9),
    "buttock_circumference": (0.33, 1.9),
    "thigh_circumference": (0.19, 1.2),
    "calf_circumference": (0.12, 0.73),
    "ankle_circumference": (0.07, 0.41),
    "biceps_circumference_flexed": (0.097, 0.69),
    "forearm_circumference_flexed": (0.09, 0.56),
    "wrist_circumference": (0.056, 0.3),
}


# What people say for them.
WORDS: dict[str, str] = {
    "height": "stature",
    "body height": "stature",
    "tall": "stature",
    "weight": MASS,
    "body weight": MASS,
    "seated height": "sitting_height",
    "height sitting": "sitting_height",
    "eye height": "eye_height_sitting",
    "shoulder height": "acromial_height",
    "shoulder breadth": "bideltoid_breadth",
    "shoulder width": "bideltoid_breadth",
    "hip width": "hip_breadth",
    "waist width": "waist_breadth",
    "knee height": "knee_height_sitting",
    "thigh height": "thigh_clearance",
    "elbow height": "elbow_rest_height",
    "arm reach": "thumb_tip_reach",
    "reach": "thumb_tip_reach",
    "overhead reach": "overhead_fingertip_reach_sitting",
    "hip to knee": "buttock_knee_length",
    "upper arm length": "shoulder_elbow_length",
    "forearm length": "radiale_stylion_length",
    "hand width": "hand_breadth",
    "foot width": "foot_breadth_horizontal",
    "foot breadth": "foot_breadth_horizontal",
    "chest girth": "chest_circumference",
    "waist girth": "waist_circumference",
    "hip circumference": "buttock_circumference",
    "upper arm circumference": "biceps_circumference_flexed",
    "belly depth": "abdominal_extension_depth_sitting",
}


def check_measures(names: Iterable[str], known: Iterable[str] = MEASURES) -> tuple[str, ...]:
    """The names as a tuple; InputError for one that is not known or stands twice."""
    chosen = tuple(names)
    valid = tuple(known)
    faults = [
        f"no measure {name!r}; {one_of(name, valid, words=WORDS)}"
        for name in chosen
        if not isinstance(name, str) or name not in valid
    ]
    faults += [
        f"measure {name!r} is named twice"
        for name in dict.fromkeys(name for name in chosen if isinstance(name, str))
        if chosen.count(name) > 1
    ]
    if faults:
        raise InputError(faults)
    return chosen


def check_plausible(measures: Mapping[str, float]) -> None:
    """InputError for a measure [m; mass in kg] that nobody has: most likely a wrong unit."""
    faults = []
    for name, value in measures.items():
        low, high = MEASURES.get(name, (0.0, math.inf))
        if not (math.isfinite(value) and value > 0 and low <= value <= high):
            unit, factor = ("kg", 1.0) if name == MASS else ("mm", 1000.0)
            faults.append(
                f"{name} {factor * value:g} {unit} is not a person's ({factor * low:g} to {factor * high:g} "
                f"{unit} is): a wrong unit?"
            )
    if faults:
        raise InputError(faults)
