"""Measure a sphere body by the definitions of ANSUR II (NATICK/TR-15/007).

There is one row for each measure, with its definition on the sphere body: from where to where, in
which posture. Measures are taken on the right side. Where a landmark of skin
over bone has no sphere of its own, the joint beneath it stands in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from typing import NamedTuple

from workbench.body.scaling.manikin import (
    BACK,
    DOWN,
    FRONT,
    LEFT,
    RIGHT,
    UP,
    Band,
    Length,
    Manikin,
)
from workbench.errors import InputError, one_of
from workbench.model.body import Body
from workbench.model.population import WORDS

__all__ = ["MEASURES", "Measure", "lengths", "measure"]

_TORSO = ("LT", "CT", "UT")
_FEET = ("LF", "RF")
_SEAT = ("LT",)
_HIPS = ("LT", "LUL", "RUL")
_ACROSS = (LEFT, RIGHT)
_THROUGH = (FRONT, BACK)
_RADIALE = 0.03
"""How far the head of the radius lies beyond the elbow joint, as a share of the forearm."""
_TROCHANTERION = 0.036
"""How far the trochanterion lies under the hip joint, as a share of the thigh: the middle of what is
published, see docs/human-family.md."""


def _once(function: Callable[..., Length]) -> Callable[..., Length]:
    """A level that many measures are taken from, in a posture where it is given, found once for each
    manikin."""

    @wraps(function)
    def known(m: Manikin, *posture: str) -> Length:
        key = (function.__name__, *posture)
        if key not in m.lengths:
            m.lengths[key] = function(m, *posture)
        return m.lengths[key]

    return known


@_once
def _floor(m: Manikin, posture: str = "standing") -> Length:
    return m.farthest(posture, DOWN, _FEET) * -1.0


@_once
def _seat(m: Manikin, posture: str = "sitting") -> Length:
    return m.farthest(posture, DOWN, _SEAT) * -1.0


@_once
def _rear(m: Manikin, posture: str = "sitting") -> Length:
    return m.farthest(posture, BACK, _SEAT) * -1.0


def _height(m: Manikin, landmark: Length) -> Length:
    return landmark - _floor(m)


@_once
def _sole(m: Manikin) -> Length:
    return m.farthest("sitting", DOWN, ["RF"]) * -1.0


def _knee(m: Manikin, where: list[str], behind: float = 0.0) -> Band:
    """Return the band of 60 mm on either side of a sitter's knee joint.

    behind: distance [m] behind the joint at which the band is.
    """
    share = behind / max(m.value(_thigh(m)), 1e-9)
    return Band(m.joint("sitting", FRONT, "RK") - _thigh(m) * share, 0.06, where)


@_once
def _thigh(m: Manikin) -> Length:
    return m.joint("sitting", FRONT, "RK") - m.joint("sitting", FRONT, "RH")


def _radiale(m: Manikin) -> Length:
    """Return the height of the edge of the radius's head, arm hanging.

    It turns about the axis of the elbow at the radius of the humerus's head, 3 % of the forearm's
    length, beyond the joint.
    """
    elbow = m.joint("standing", UP, "RE")
    return elbow * (1.0 - _RADIALE) + m.joint("standing", UP, "RW") * _RADIALE


def _elbow_back(m: Manikin) -> Length:
    return m.farthest("sitting", BACK, ["RLA/elbow point"]) * -1.0


def _along(m: Manikin, first: str, second: str, share: float) -> Length:
    """Return the height of a place on the way between two joints, standing."""
    return m.joint("standing", UP, first) * (1.0 - share) + m.joint("standing", UP, second) * share


def _span(
    m: Manikin,
    posture: str,
    ways: tuple[int, int],
    first: Sequence[str],
    second: Sequence[str] | None = None,
) -> Length:
    """From what is farthest one way to what is farthest the other way, of the same where second is
    not given."""
    one, other = ways
    return m.farthest(posture, one, first) + m.farthest(posture, other, second or first)


def _span_at(
    m: Manikin,
    level: Length,
    within: float,
    ways: tuple[int, int],
    first: Sequence[str],
    second: Sequence[str] | None = None,
) -> Length:
    """The same at a level, standing, of what is within a distance [m] of it."""
    one, other = (Band(level, within, where) for where in (first, second or first))
    return m.band("standing", ways[0], one) + m.band("standing", ways[1], other)


class Measure(NamedTuple):
    """A measure: its definition, and how it is taken."""

    definition: str
    length: Callable[[Manikin], Length]


MEASURES: Mapping[str, Measure] = {
    "stature": Measure(
        "Floor to the top of the head, standing.",
        lambda m: _height(m, m.farthest("standing", UP, ["H"])),
    ),
    "acromial_height": Measure(
        "Floor to the top of the shoulder point, standing.",
        lambda m: _height(m, m.farthest("standing", UP, ["RSM/shoulder point"])),
    ),
    "cervicale_height": Measure(
        "Floor to the seventh neck vertebra, standing; the neck pivot joint stands in for it.",
        lambda m: _height(m, m.joint("standing", UP, "NP")),
    ),
    "trochanterion_height": Measure(
        "Floor to the top of the greater trochanter, standing: 3.6 % of the thigh under "
        "the hip joint.",
        lambda m: _height(m, _along(m, "RH", "RK", _TROCHANTERION)),
    ),
    "lateral_femoral_epicondyle_height": Measure(
        "Floor to the outer epicondyle of the thigh bone, standing; the knee joint stands "
        "in for it.",
        lambda m: _height(m, m.joint("standing", UP, "RK")),
    ),
    "lateral_malleolus_height": Measure(
        "Floor to the outer ankle, standing: the middle of its sphere.",
        lambda m: _height(m, m.middle("standing", UP, "RLL/outer ankle")),
    ),
    "sitting_height": Measure(
        "Seat to the top of the head, sitting.",
        lambda m: m.farthest("sitting", UP, ["H"]) - _seat(m),
    ),
    "eye_height_sitting": Measure(
        "Seat to the eye, sitting.", lambda m: m.middle("sitting", UP, "H/right eye") - _seat(m)
    ),
    "acromial_height_sitting": Measure(
        "Seat to the top of the shoulder point, sitting.",
        lambda m: m.farthest("sitting", UP, ["RSM/shoulder point"]) - _seat(m),
    ),
    "cervicale_height_sitting": Measure(
        "Seat to the seventh neck vertebra, sitting; the neck pivot joint stands in for it.",
        lambda m: m.joint("sitting", UP, "NP") - _seat(m),
    ),
    "elbow_rest_height": Measure(
        "Seat to the underside of the elbow, upper arm hanging, forearm level.",
        lambda m: m.farthest("sitting", DOWN, ["RUA", "RLA/elbow point"]) * -1.0 - _seat(m),
    ),
    "thigh_clearance": Measure(
        "Seat to the highest point of the thigh in front of the belly, sitting: within "
        "150 mm of the middle of the thigh.",
        lambda m: (
            m.band(
                "sitting",
                UP,
                Band(m.joint("sitting", FRONT, "RH") + _thigh(m) * 0.5, 0.15, ["RUL"]),
                along=FRONT,
            )
            - _seat(m)
        ),
    ),
    "knee_height_sitting": Measure(
        "Sole to the top of the knee, sitting with the knee at a right angle: thigh and "
        "knee cap around the knee joint.",
        lambda m: m.band("sitting", UP, _knee(m, ["RUL", "RLL/knee cap"]), along=FRONT) - _sole(m),
    ),
    "popliteal_height": Measure(
        "Sole to the underside of the thigh just behind the knee, sitting.",
        lambda m: (
            m.band("sitting", DOWN, _knee(m, ["RUL"], behind=0.09), along=FRONT) * -1.0 - _sole(m)
        ),
    ),
    "buttock_knee_length": Measure(
        "Rearmost point of the buttock to the front of the knee cap, sitting.",
        lambda m: m.farthest("sitting", FRONT, ["RLL/knee cap"]) - _rear(m),
    ),
    "buttock_popliteal_length": Measure(
        "Rearmost point of the buttock to the back of the lower leg at the knee, sitting.",
        lambda m: (
            m.band("sitting", BACK, Band(m.joint("sitting", UP, "RK"), 0.09, ["RLL"])) * -1.0
            - _rear(m)
        ),
    ),
    "abdominal_extension_depth_sitting": Measure(
        "Back to the most protruding point of the belly, sitting.",
        lambda m: m.farthest("sitting", FRONT, ["CT"]) - m.farthest("sitting", BACK, ["CT"]) * -1.0,
    ),
    "hip_breadth_sitting": Measure(
        "Greatest breadth of hips and thighs, sitting.",
        lambda m: _span(m, "sitting", _ACROSS, _HIPS),
    ),
    "hip_breadth": Measure(
        "Greatest breadth of the hips, standing.", lambda m: _span(m, "standing", _ACROSS, _HIPS)
    ),
    "bideltoid_breadth": Measure(
        "Breadth over the deltoids, standing: upper arms down to 140 mm below the shoulder joint.",
        lambda m: _span_at(
            m, m.joint("standing", UP, "RS"), 0.14, _ACROSS, ["LUA", "LSM"], ["RUA", "RSM"]
        ),
    ),
    "biacromial_breadth": Measure(
        "Between the two acromia: the middles of the shoulder point spheres.",
        lambda m: (
            m.middle("standing", LEFT, "LSM/shoulder point")
            + m.middle("standing", RIGHT, "RSM/shoulder point")
        ),
    ),
    "forearm_forearm_breadth": Measure(
        "Breadth over the elbows and forearms, sitting, upper arms hanging and forearms level.",
        lambda m: _span(m, "sitting", _ACROSS, ["LUA", "LLA"], ["RUA", "RLA"]),
    ),
    "shoulder_elbow_length": Measure(
        "Top of the shoulder point to the underside of the elbow, forearm level.",
        lambda m: (
            m.farthest("sitting", UP, ["RSM/shoulder point"])
            - m.farthest("sitting", DOWN, ["RUA", "RLA/elbow point"]) * -1.0
        ),
    ),
    "acromion_radiale_length": Measure(
        "Top of the shoulder point to the edge of the radius's head, arm hanging (see `_radiale`).",
        lambda m: m.farthest("standing", UP, ["RSM/shoulder point"]) - _radiale(m),
    ),
    "radiale_stylion_length": Measure(
        "Edge of the radius's head to the wrist joint, arm hanging (see `_radiale`).",
        lambda m: _radiale(m) - m.joint("standing", UP, "RW"),
    ),
    "forearm_hand_length": Measure(
        "Back of the elbow point to the tip of the middle finger, forearm level.",
        lambda m: m.farthest("sitting", FRONT, ["RHN/middle fingertip"]) - _elbow_back(m),
    ),
    "forearm_center_of_grip_length": Measure(
        "Back of the elbow point to the centre of a gripped rod, forearm level: midway "
        "from palm to index knuckle.",
        lambda m: (
            (
                m.middle("sitting", FRONT, "RHN/palm")
                + m.middle("sitting", FRONT, "RHN/index knuckle")
            )
            * 0.5
            - _elbow_back(m)
        ),
    ),
    "hand_length": Measure(
        "Wrist joint to the tip of the middle finger, hand hanging.",
        lambda m: (
            m.joint("standing", UP, "RW") + m.farthest("standing", DOWN, ["RHN/middle fingertip"])
        ),
    ),
    "hand_breadth": Measure(
        "Breadth of the hand across the knuckles: index knuckle to the little finger's "
        "edge, without the thumb.",
        lambda m: _span(m, "standing", _THROUGH, ["RHN/index knuckle"], ["RHN"]),
    ),
    "thumb_tip_reach": Measure(
        "Wall behind the back to the tip of the thumb, arm level to the front, standing "
        "against the wall.",
        lambda m: (
            m.farthest("arm_forward", FRONT, ["RHN/thumb tip"])
            - m.farthest("arm_forward", BACK, _TORSO) * -1.0
        ),
    ),
    "overhead_fingertip_reach_sitting": Measure(
        "Seat to the tip of the middle finger, arm stretched overhead.",
        lambda m: m.farthest("overhead", UP, ["RHN/middle fingertip"]) - _seat(m, "overhead"),
    ),
    "foot_length": Measure(
        "Back of the heel to the tip of the toe.", lambda m: _span(m, "standing", _THROUGH, ["RF"])
    ),
    "foot_breadth_horizontal": Measure(
        "Greatest breadth of the foot.", lambda m: _span(m, "standing", _ACROSS, ["RF"])
    ),
    "head_length": Measure(
        "Forehead to the back of the head.",
        lambda m: _span(m, "standing", _THROUGH, ["H/forehead"], ["H"]),
    ),
    "head_breadth": Measure(
        "Greatest breadth of the head above the ears: spheres at the height of the forehead.",
        lambda m: _span_at(m, m.middle("standing", UP, "H/forehead"), 0.02, _ACROSS, ["H"]),
    ),
    "tragion_top_of_head": Measure(
        "Ear to the top of the head: from the middle of the ear's sphere.",
        lambda m: m.farthest("standing", UP, ["H"]) - m.middle("standing", UP, "H/right ear"),
    ),
    "interpupillary_breadth": Measure(
        "Between the middles of the two eyes.",
        lambda m: (
            m.middle("standing", LEFT, "H/left eye") + m.middle("standing", RIGHT, "H/right eye")
        ),
    ),
    "chest_depth": Measure(
        "Depth of the chest at the height of the breasts, standing.",
        lambda m: _span_at(m, m.middle("standing", UP, "UT/right breast"), 0.06, _THROUGH, ["UT"]),
    ),
    "waist_depth": Measure(
        "Depth of the waist at the height of the navel, standing.",
        lambda m: _span_at(
            m, m.middle("standing", UP, "CT/navel"), 0.05, _THROUGH, ["CT"], ["CT", "LT"]
        ),
    ),
    "waist_breadth": Measure(
        "Breadth of the waist at the height of the navel, standing.",
        lambda m: _span_at(m, m.middle("standing", UP, "CT/navel"), 0.05, _ACROSS, ["CT"]),
    ),
    "buttock_depth": Measure(
        "Depth of the body at the most protruding point of the buttock, standing.",
        lambda m: (
            m.band(
                "standing",
                FRONT,
                Band(m.middle("standing", UP, "LT/right buttock"), 0.05, ["LT", "RUL"]),
            )
            + m.farthest("standing", BACK, ["LT"])
        ),
    ),
    "chest_circumference": Measure(
        "Around the chest at the height of the breasts, standing, without the arms.",
        lambda m: m.tape(m.middle("standing", UP, "UT/right breast"), ["UT"]),
    ),
    "waist_circumference": Measure(
        "Around the waist at the height of the navel, standing.",
        lambda m: m.tape(m.middle("standing", UP, "CT/navel"), ["CT", "LT"]),
    ),
    "buttock_circumference": Measure(
        "Around hips and buttocks at the most protruding point of the buttock, standing.",
        lambda m: m.tape(m.middle("standing", UP, "LT/right buttock"), ["LT", "LUL", "RUL"]),
    ),
    "thigh_circumference": Measure(
        "Around the thigh below the fold of the buttock, standing: a sixth of its length "
        "below the hip joint.",
        lambda m: m.tape(_along(m, "RH", "RK", 1 / 6), ["RUL"]),
    ),
    "calf_circumference": Measure(
        "Around the calf where it is thickest, standing: three tenths down the lower leg.",
        lambda m: m.tape(_along(m, "RK", "RA", 0.3), ["RLL"]),
    ),
    "biceps_circumference_flexed": Measure(
        "Around the upper arm halfway from shoulder joint to elbow, arm hanging; the "
        "survey's is taken over a tensed muscle.",
        lambda m: m.tape(_along(m, "RS", "RE", 0.5), ["RUA"]),
    ),
}
"""The measures by name."""


def lengths(manikin: Manikin, names: Iterable[str] | None = None) -> dict[str, Length]:
    """Return measures as lengths, with the extreme spheres of a manikin.

    Parameters
    ----------
    manikin
        The body in the postures of anthropometry.
    names
        Names of measures, all if None.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    wanted = list(MEASURES) if names is None else list(names)
    for name in wanted:
        if name not in MEASURES:
            raise InputError(f"no measure {name!r}; {one_of(name, MEASURES, words=WORDS)}")
    known = manikin.lengths
    for name in wanted:
        if (name,) not in known:
            known[name,] = MEASURES[name].length(manikin)
    return {name: known[name,] for name in wanted}


def measure(body: Body, names: Iterable[str] | None = None) -> dict[str, float]:
    """Measure a body.

    Parameters
    ----------
    body
        One body with the landmarks of a person.
    names
        Names of measures, all if None.

    Returns
    -------
    dict
        Measures by name [m].

    Raises
    ------
    InputError
        If a name is unknown, or the body lacks a landmark.

    Examples
    --------
    >>> import workbench as wb
    >>> found = wb.measure(wb.load_body("adult_female"), ["stature", "sitting_height"])
    >>> {name: round(1000 * length) for name, length in found.items()}  # [mm]
    {'stature': 1625, 'sitting_height': 858}
    """
    manikin = Manikin(body)
    return {name: manikin.value(length) for name, length in lengths(manikin, names).items()}
