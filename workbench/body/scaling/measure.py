"""Measure a sphere body by the definitions of ANSUR II (NATICK/TR-15/007).

There is one function for each measure. Its docstring defines the measure on the sphere body: from
where to where, in which posture. Measures are taken on the right side. Where a landmark of skin
over bone has no sphere of its own, the joint beneath it stands in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps

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

__all__ = ["MEASURES", "lengths", "measure"]

_TORSO = ("LT", "CT", "UT")
_FEET = ("LF", "RF")
_SEAT = ("LT",)
_RADIALE = 0.03
"""How far the head of the radius lies beyond the elbow joint, as a share of the forearm."""
_TROCHANTERION = 0.036
"""How far the trochanterion lies under the hip joint, as a share of the thigh: the thigh is .2405 to
.2425 of the stature from joint to joint (AnyBody's AMMR; de Leva 1996) and .2335 from trochanterion
to epicondyle (ANSUR II)."""


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


def stature(m: Manikin) -> Length:
    """Floor to the top of the head, standing."""
    return _height(m, m.farthest("standing", UP, ["H"]))


def acromial_height(m: Manikin) -> Length:
    """Floor to the top of the shoulder point, standing."""
    return _height(m, m.farthest("standing", UP, ["RSM/shoulder point"]))


def cervicale_height(m: Manikin) -> Length:
    """Floor to the seventh neck vertebra, standing; the neck pivot joint stands in for it."""
    return _height(m, m.joint("standing", UP, "NP"))


def trochanterion_height(m: Manikin) -> Length:
    """Floor to the top of the greater trochanter, standing: 3.6 % of the thigh under the hip joint."""
    return _height(m, _along(m, "RH", "RK", _TROCHANTERION))


def lateral_femoral_epicondyle_height(m: Manikin) -> Length:
    """Floor to the outer epicondyle of the thigh bone, standing; the knee joint stands in for
    it."""
    return _height(m, m.joint("standing", UP, "RK"))


def lateral_malleolus_height(m: Manikin) -> Length:
    """Floor to the outer ankle, standing: the middle of its sphere."""
    return _height(m, m.middle("standing", UP, "RLL/outer ankle"))


def sitting_height(m: Manikin) -> Length:
    """Seat to the top of the head, sitting."""
    return m.farthest("sitting", UP, ["H"]) - _seat(m)


def eye_height_sitting(m: Manikin) -> Length:
    """Seat to the eye, sitting."""
    return m.middle("sitting", UP, "H/right eye") - _seat(m)


def acromial_height_sitting(m: Manikin) -> Length:
    """Seat to the top of the shoulder point, sitting."""
    return m.farthest("sitting", UP, ["RSM/shoulder point"]) - _seat(m)


def cervicale_height_sitting(m: Manikin) -> Length:
    """Seat to the seventh neck vertebra, sitting; the neck pivot joint stands in for it."""
    return m.joint("sitting", UP, "NP") - _seat(m)


def elbow_rest_height(m: Manikin) -> Length:
    """Seat to the underside of the elbow, upper arm hanging, forearm level."""
    return m.farthest("sitting", DOWN, ["RUA", "RLA/elbow point"]) * -1.0 - _seat(m)


def thigh_clearance(m: Manikin) -> Length:
    """Seat to the highest point of the thigh in front of the belly, sitting: within 150 mm of the
    middle of the thigh."""
    middle = m.joint("sitting", FRONT, "RH") + _thigh(m) * 0.5
    return m.band("sitting", UP, Band(middle, 0.15, ["RUL"]), along=FRONT) - _seat(m)


def knee_height_sitting(m: Manikin) -> Length:
    """Sole to the top of the knee, sitting with the knee at a right angle: thigh and knee cap
    around the knee joint."""
    return m.band("sitting", UP, _knee(m, ["RUL", "RLL/knee cap"]), along=FRONT) - _sole(m)


def popliteal_height(m: Manikin) -> Length:
    """Sole to the underside of the thigh just behind the knee, sitting."""
    return m.band("sitting", DOWN, _knee(m, ["RUL"], behind=0.09), along=FRONT) * -1.0 - _sole(m)


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


def buttock_knee_length(m: Manikin) -> Length:
    """Rearmost point of the buttock to the front of the knee cap, sitting."""
    return m.farthest("sitting", FRONT, ["RLL/knee cap"]) - _rear(m)


def buttock_popliteal_length(m: Manikin) -> Length:
    """Rearmost point of the buttock to the back of the lower leg at the knee, sitting."""
    knee = m.joint("sitting", UP, "RK")
    return m.band("sitting", BACK, Band(knee, 0.09, ["RLL"])) * -1.0 - _rear(m)


def abdominal_extension_depth_sitting(m: Manikin) -> Length:
    """Back to the most protruding point of the belly, sitting."""
    return m.farthest("sitting", FRONT, ["CT"]) - m.farthest("sitting", BACK, ["CT"]) * -1.0


def hip_breadth_sitting(m: Manikin) -> Length:
    """Greatest breadth of hips and thighs, sitting."""
    where = ["LT", "LUL", "RUL"]
    return m.farthest("sitting", LEFT, where) + m.farthest("sitting", RIGHT, where)


def hip_breadth(m: Manikin) -> Length:
    """Greatest breadth of the hips, standing."""
    where = ["LT", "LUL", "RUL"]
    return m.farthest("standing", LEFT, where) + m.farthest("standing", RIGHT, where)


def bideltoid_breadth(m: Manikin) -> Length:
    """Breadth over the deltoids, standing: upper arms down to 140 mm below the shoulder joint."""
    level = m.joint("standing", UP, "RS")
    left = m.band("standing", LEFT, Band(level, 0.14, ["LUA", "LSM"]))
    return left + m.band("standing", RIGHT, Band(level, 0.14, ["RUA", "RSM"]))


def biacromial_breadth(m: Manikin) -> Length:
    """Between the two acromia: the middles of the shoulder point spheres."""
    return m.middle("standing", LEFT, "LSM/shoulder point") + m.middle(
        "standing", RIGHT, "RSM/shoulder point"
    )


def forearm_forearm_breadth(m: Manikin) -> Length:
    """Breadth over the elbows and forearms, sitting, upper arms hanging and forearms level."""
    return m.farthest("sitting", LEFT, ["LUA", "LLA"]) + m.farthest(
        "sitting", RIGHT, ["RUA", "RLA"]
    )


def shoulder_elbow_length(m: Manikin) -> Length:
    """Top of the shoulder point to the underside of the elbow, forearm level."""
    top = m.farthest("sitting", UP, ["RSM/shoulder point"])
    return top - m.farthest("sitting", DOWN, ["RUA", "RLA/elbow point"]) * -1.0


def acromion_radiale_length(m: Manikin) -> Length:
    """Top of the shoulder point to the edge of the radius's head, arm hanging (see `_radiale`)."""
    return m.farthest("standing", UP, ["RSM/shoulder point"]) - _radiale(m)


def radiale_stylion_length(m: Manikin) -> Length:
    """Edge of the radius's head to the wrist joint, arm hanging (see `_radiale`)."""
    return _radiale(m) - m.joint("standing", UP, "RW")


def _radiale(m: Manikin) -> Length:
    """Return the height of the edge of the radius's head, arm hanging.

    It turns about the axis of the elbow at the radius of the humerus's head, 3 % of the forearm's
    length, beyond the joint.
    """
    elbow = m.joint("standing", UP, "RE")
    return elbow * (1.0 - _RADIALE) + m.joint("standing", UP, "RW") * _RADIALE


def forearm_hand_length(m: Manikin) -> Length:
    """Back of the elbow point to the tip of the middle finger, forearm level."""
    return m.farthest("sitting", FRONT, ["RHN/middle fingertip"]) - _elbow_back(m)


def forearm_center_of_grip_length(m: Manikin) -> Length:
    """Back of the elbow point to the centre of a gripped rod, forearm level: midway from palm to
    index knuckle."""
    grip = (
        m.middle("sitting", FRONT, "RHN/palm") + m.middle("sitting", FRONT, "RHN/index knuckle")
    ) * 0.5
    return grip - _elbow_back(m)


def _elbow_back(m: Manikin) -> Length:
    return m.farthest("sitting", BACK, ["RLA/elbow point"]) * -1.0


def hand_length(m: Manikin) -> Length:
    """Wrist joint to the tip of the middle finger, hand hanging."""
    return m.joint("standing", UP, "RW") + m.farthest("standing", DOWN, ["RHN/middle fingertip"])


def hand_breadth(m: Manikin) -> Length:
    """Breadth of the hand across the knuckles: index knuckle to the little finger's edge, without
    the thumb."""
    return m.farthest("standing", FRONT, ["RHN/index knuckle"]) + m.farthest(
        "standing", BACK, ["RHN"]
    )


def thumb_tip_reach(m: Manikin) -> Length:
    """Wall behind the back to the tip of the thumb, arm level to the front, standing against the
    wall."""
    back = m.farthest("arm_forward", BACK, _TORSO) * -1.0
    return m.farthest("arm_forward", FRONT, ["RHN/thumb tip"]) - back


def overhead_fingertip_reach_sitting(m: Manikin) -> Length:
    """Seat to the tip of the middle finger, arm stretched overhead."""
    return m.farthest("overhead", UP, ["RHN/middle fingertip"]) - _seat(m, "overhead")


def foot_length(m: Manikin) -> Length:
    """Back of the heel to the tip of the toe."""
    return m.farthest("standing", FRONT, ["RF"]) + m.farthest("standing", BACK, ["RF"])


def foot_breadth_horizontal(m: Manikin) -> Length:
    """Greatest breadth of the foot."""
    return m.farthest("standing", LEFT, ["RF"]) + m.farthest("standing", RIGHT, ["RF"])


def head_length(m: Manikin) -> Length:
    """Forehead to the back of the head."""
    return m.farthest("standing", FRONT, ["H/forehead"]) + m.farthest("standing", BACK, ["H"])


def head_breadth(m: Manikin) -> Length:
    """Greatest breadth of the head above the ears: spheres at the height of the forehead."""
    level = m.middle("standing", UP, "H/forehead")
    return m.band("standing", LEFT, Band(level, 0.02, ["H"])) + m.band(
        "standing", RIGHT, Band(level, 0.02, ["H"])
    )


def tragion_top_of_head(m: Manikin) -> Length:
    """Ear to the top of the head: from the middle of the ear's sphere."""
    return m.farthest("standing", UP, ["H"]) - m.middle("standing", UP, "H/right ear")


def interpupillary_breadth(m: Manikin) -> Length:
    """Between the middles of the two eyes."""
    return m.middle("standing", LEFT, "H/left eye") + m.middle("standing", RIGHT, "H/right eye")


def chest_depth(m: Manikin) -> Length:
    """Depth of the chest at the height of the breasts, standing."""
    level = m.middle("standing", UP, "UT/right breast")
    return m.band("standing", FRONT, Band(level, 0.06, ["UT"])) + m.band(
        "standing", BACK, Band(level, 0.06, ["UT"])
    )


def waist_depth(m: Manikin) -> Length:
    """Depth of the waist at the height of the navel, standing."""
    level = m.middle("standing", UP, "CT/navel")
    return m.band("standing", FRONT, Band(level, 0.05, ["CT"])) + m.band(
        "standing", BACK, Band(level, 0.05, ["CT", "LT"])
    )


def waist_breadth(m: Manikin) -> Length:
    """Breadth of the waist at the height of the navel, standing."""
    level = m.middle("standing", UP, "CT/navel")
    return m.band("standing", LEFT, Band(level, 0.05, ["CT"])) + m.band(
        "standing", RIGHT, Band(level, 0.05, ["CT"])
    )


def buttock_depth(m: Manikin) -> Length:
    """Depth of the body at the most protruding point of the buttock, standing."""
    level = m.middle("standing", UP, "LT/right buttock")
    return m.band("standing", FRONT, Band(level, 0.05, ["LT", "RUL"])) + m.farthest(
        "standing", BACK, ["LT"]
    )


def chest_circumference(m: Manikin) -> Length:
    """Around the chest at the height of the breasts, standing, without the arms."""
    return m.tape(m.middle("standing", UP, "UT/right breast"), ["UT"])


def waist_circumference(m: Manikin) -> Length:
    """Around the waist at the height of the navel, standing."""
    return m.tape(m.middle("standing", UP, "CT/navel"), ["CT", "LT"])


def buttock_circumference(m: Manikin) -> Length:
    """Around hips and buttocks at the most protruding point of the buttock, standing."""
    return m.tape(m.middle("standing", UP, "LT/right buttock"), ["LT", "LUL", "RUL"])


def thigh_circumference(m: Manikin) -> Length:
    """Around the thigh below the fold of the buttock, standing: a sixth of its length below the hip
    joint."""
    return m.tape(_along(m, "RH", "RK", 1 / 6), ["RUL"])


def calf_circumference(m: Manikin) -> Length:
    """Around the calf where it is thickest, standing: three tenths down the lower leg."""
    return m.tape(_along(m, "RK", "RA", 0.3), ["RLL"])


def biceps_circumference_flexed(m: Manikin) -> Length:
    """Around the upper arm halfway from shoulder joint to elbow, arm hanging; the survey's is taken
    over a tensed muscle."""
    return m.tape(_along(m, "RS", "RE", 0.5), ["RUA"])


def _along(m: Manikin, first: str, second: str, share: float) -> Length:
    """Return the height of a place on the way between two joints, standing."""
    return m.joint("standing", UP, first) * (1.0 - share) + m.joint("standing", UP, second) * share


_ALL: tuple[Callable[[Manikin], Length], ...] = (
    stature,
    acromial_height,
    cervicale_height,
    trochanterion_height,
    lateral_femoral_epicondyle_height,
    lateral_malleolus_height,
    sitting_height,
    eye_height_sitting,
    acromial_height_sitting,
    cervicale_height_sitting,
    elbow_rest_height,
    thigh_clearance,
    knee_height_sitting,
    popliteal_height,
    buttock_knee_length,
    buttock_popliteal_length,
    abdominal_extension_depth_sitting,
    hip_breadth_sitting,
    hip_breadth,
    bideltoid_breadth,
    biacromial_breadth,
    forearm_forearm_breadth,
    shoulder_elbow_length,
    acromion_radiale_length,
    radiale_stylion_length,
    forearm_hand_length,
    forearm_center_of_grip_length,
    hand_length,
    hand_breadth,
    thumb_tip_reach,
    overhead_fingertip_reach_sitting,
    foot_length,
    foot_breadth_horizontal,
    head_length,
    head_breadth,
    tragion_top_of_head,
    interpupillary_breadth,
    chest_depth,
    waist_depth,
    waist_breadth,
    buttock_depth,
    chest_circumference,
    waist_circumference,
    buttock_circumference,
    thigh_circumference,
    calf_circumference,
    biceps_circumference_flexed,
)
MEASURES: dict[str, Callable[[Manikin], Length]] = {
    function.__name__: function for function in _ALL
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
            known[name,] = MEASURES[name](manikin)
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
