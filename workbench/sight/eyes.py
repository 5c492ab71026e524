"""Eyes: where people look from, and how far they turn eyes and head to look at something."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints, for_rows, freeze_fields
from workbench.model.body import Body
from workbench.model.kept import kept_with_topology
from workbench.model.poses import Placed
from workbench.model.quaternions import exponential, rotate

__all__ = [
    "PIVOT_BEHIND",
    "TURNS",
    "USUAL_DOWN",
    "Eyes",
    "Gaze",
    "Limits",
    "eyes_of",
    "gaze",
    "given_eyes",
    "has_eyes",
    "head_of",
]

USUAL_DOWN = math.radians(10.0)
"""How far [rad] a usual line of sight is below straight ahead of the head."""
PIVOT_BEHIND = math.sqrt(0.104**2 - 0.0325**2)
"""Distance [m] of the middle of the eyes from the pivot of the head: UN R125 places the eyes 104 mm
from it, 65 mm apart."""
_ROUNDS = 60
"""Steps of `gaze`. Each leaves a part of the error that is the distance of the eyes from the pivot
over that of the target."""
_STILL = 1e-12
"""[rad] A head that turns by less from round to round has found its place."""
_NOTHING = 1e-300
"""[m] to the left that stands for nothing, so that what is straight behind is to one side."""
_TOLERANCE = 1e-6
"""Angle [rad] by which a turn may miss its limit and count as within it."""


@dataclass(frozen=True, eq=False)
class Eyes:
    """The eyes of B people.

    Parameters
    ----------
    left, right
        (B, 3) [m] the pupils.
    axes
        (B, 3, 3) of the head: forward, left, up as rows.
    pivot
        (B, 3) [m] where the head turns on the neck.
    """

    left: Floats
    right: Floats
    axes: Floats
    pivot: Floats

    def __post_init__(self) -> None:
        count = len(self.left)
        shapes = {"left": (count, 3), "right": (count, 3), "axes": (count, 3, 3)}
        shapes["pivot"] = (count, 3)
        arrays = {name: (np.float64, shape) for name, shape in shapes.items()}
        freeze_fields(self, arrays, "eyes")

    def __len__(self) -> int:
        return len(self.left)

    def rows(self, keep: Ints | slice) -> Eyes:
        """Return the eyes of some people, in their order."""
        return Eyes(self.left[keep], self.right[keep], self.axes[keep], self.pivot[keep])

    @property
    def middle(self) -> Floats:
        """(B, 3) [m] the point midway between the pupils."""
        return (self.left + self.right) / 2.0

    def line(self, *, down: float = USUAL_DOWN, left: float = 0.0) -> Floats:
        """(B, 3) the directions of the line of sight, so far [rad] from straight ahead of the
        head."""
        forward, leftward, up = (self.axes[:, k] for k in range(3))
        level = math.cos(left) * forward + math.sin(left) * leftward
        return np.asarray(math.cos(down) * level - math.sin(down) * up)


@kept_with_topology
def _eye_spheres(body: Body) -> list[int]:
    return [k for k, name in enumerate(body.sphere_names) if name.endswith("eye")]


def has_eyes(body: Body) -> bool:
    """Whether a body has eyes: spheres whose name ends with "eye"."""
    return bool(_eye_spheres(body))


def head_of(body: Body) -> int:
    """Return the index of the segment that has the eyes; InputError where there are none."""
    eyes = _eye_spheres(body)
    if not eyes:
        raise InputError(
            f"body {body.name}: no sphere is named an eye; name two spheres of the head 'left eye' "
            "and 'right eye', or give the point between the eyes"
        )
    return int(body.sphere_segment[eyes[0]])


def eyes_of(placed: Placed) -> Eyes:
    """Find the eyes of posed bodies.

    The eyes are the spheres "left eye" and "right eye"; the one eye of a body that has no such
    pair serves as both. The pupil is the front of the sphere, straight ahead of the head. The head
    turns about the joint of its segment.

    Parameters
    ----------
    placed
        B poses. Eyes outside the logical window are NaN.

    Raises
    ------
    InputError
        If the body has no eyes.

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> eyes = wb.eyes_of(wb.place(body, wb.pose(body, {})))
    >>> round(1000 * float(np.linalg.norm(eyes.left - eyes.right)))  # [mm] from pupil to pupil
    64
    """
    body = placed.body
    head = head_of(body)
    spheres = _eye_spheres(body)
    axes = placed.world_from_segment[:, head, :, :3].transpose(0, 2, 1)
    pupils = []
    for side in ("left eye", "right eye"):
        own = [k for k in spheres if body.sphere_names[k].endswith(side)] or spheres
        radius = body.radius[placed.person][:, own].mean(axis=1)
        pupils.append(placed.centres[:, own].mean(axis=1) + radius[:, None] * axes[:, 0])
    world = placed.world_from_segment[:, head]
    pivot = world[:, :, 3]
    if head:
        joint = body.joint_in_child[placed.person, head - 1]
        pivot = pivot + np.einsum("bij,bj->bi", world[:, :, :3], joint)
    return Eyes(pupils[0], pupils[1], axes, pivot)


def given_eyes(
    middle: ArrayLike, *, ahead: ArrayLike = (1.0, 0.0, 0.0), spacing: float = 0.065
) -> Eyes:
    """Place eyes at given points, upright, with the head's pivot `PIVOT_BEHIND` behind them.

    Parameters
    ----------
    middle
        (B, 3) or (3,) [m] the points midway between the pupils.
    ahead
        (3,) the direction straight ahead of the head.
    spacing
        Distance [m] between the pupils. UN R125 and SAE J1050 have 65 mm.

    Raises
    ------
    InputError
        If points, direction or spacing are not finite, or the direction is straight up or down.

    Examples
    --------
    >>> import workbench as wb
    >>> eyes = wb.given_eyes([0, 0, 1.2])
    >>> eyes.left, eyes.right  # 65 mm apart
    (array([[0.    , 0.0325, 1.2   ]]), array([[ 0.    , -0.0325,  1.2   ]]))
    """
    points = np.atleast_2d(np.asarray(middle, dtype=np.float64))
    forward = np.asarray(ahead, dtype=np.float64)
    if points.shape[1:] != (3,) or not np.isfinite(points).all():
        raise InputError(f"eyes: expected finite points (B, 3) [m], got shape {points.shape}")
    if forward.shape != (3,) or not np.linalg.norm(forward[:2]) > 1e-9 * np.linalg.norm(forward):
        raise InputError(f"eyes: expected a direction ahead that is not upright, got {ahead!r}")
    if not (math.isfinite(spacing) and spacing >= 0.0):
        raise InputError(f"eyes: expected a spacing of 0 m or more, got {spacing}")
    forward = forward / np.linalg.norm(forward)
    left = np.array([-forward[1], forward[0], 0.0]) / np.linalg.norm(forward[:2])
    frame = np.stack([forward, left, np.cross(forward, left)])
    axes = np.broadcast_to(frame, (len(points), 3, 3))
    aside = spacing / 2.0 * left
    return Eyes(points + aside, points - aside, axes, points - PIVOT_BEHIND * forward)


@dataclass(frozen=True)
class Limits:
    """How far eyes and head turn; angles [rad], all positive.

    Parameters
    ----------
    line_down
        The normal line of sight, from which the eyes turn, below straight ahead of the head.
    easy
        Eye turn to any side that is easy.
    eye_side, eye_up, eye_down, head_side, head_up, head_down
        Largest turns of the eyes in the head, and of the head about its pivot.
    source, status
        Where the values are from, and how sure that is.
    eye_centre
        How far [m] behind its pupil an eye turns.
    """

    line_down: float
    easy: float
    eye_side: float
    eye_up: float
    eye_down: float
    head_side: float
    head_up: float
    head_down: float
    source: str
    status: str
    eye_centre: float = 0.0


TURNS = Limits(
    line_down=math.radians(15.0),
    easy=math.radians(15.0),
    eye_side=math.radians(35.0),
    eye_up=math.radians(40.0),
    eye_down=math.radians(20.0),
    head_side=math.radians(60.0),
    head_up=math.radians(65.0),
    head_down=math.radians(35.0),
    source="MIL-STD-1472, vision of seated people; centre of the eye: physiological optics",
    status="from memory, high confidence: compare with the standard before certification",
    eye_centre=0.013,
)
"""The usual limits."""


@dataclass(frozen=True, eq=False)
class Gaze:
    """How B people look at a target each.

    Parameters
    ----------
    eyes
        Where the pupils are, and the axes of the head, after trunk, head and eyes have turned. Where
        a target is beyond the limits, pupils go along with the head only.
    trunk_turn
        (B,) [rad] of the trunk to the left, where that was asked.
    eye_turn, head_turn
        (B, 2) [rad] to the left and up: of the eyes from the normal line of sight in the head, of
        the head about its pivot. Both are parts of one turn about an axis across.
    lack
        (B,) [rad] by how much the eyes would have to turn beyond their limits, 0 where the target
        is within them.
    """

    eyes: Eyes
    eye_turn: Floats
    head_turn: Floats
    trunk_turn: Floats
    lack: Floats

    @property
    def within(self) -> np.ndarray:
        """(B,) whether eyes, head and trunk stay within their limits."""
        return np.asarray(self.lack == 0.0)


def gaze(eyes: Eyes, target: ArrayLike, limits: Limits = TURNS, *, trunk: ArrayLike = 0.0) -> Gaze:
    """Turn eyes and head, and the trunk where that is asked, to look at targets.

    The eyes turn first, as far as is easy; then the head, to its limits, to the side and up about
    its pivot; then the trunk to the side, which carries the head on about the same pivot; then the
    eyes, to their limits. Each eye turns about its centre, and its pupil moves round that.

    Parameters
    ----------
    eyes
        B people.
    target
        (B, 3) or (3,) [m] what each looks at.
    limits
        How far eyes and head turn.
    trunk
        How far [rad] the trunk may turn to either side, a number or (B,).

    Raises
    ------
    InputError
        If a target is not finite, or at the eyes themselves.

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> found = wb.gaze(wb.given_eyes([0, 0, 1.2]), [1, 1, 1.2])  # 45 degrees to the left
    >>> np.degrees(found.eye_turn).round(1), np.degrees(found.head_turn).round(1)
    (array([[15. , 14.7]]), array([[28.3,  0. ]]))
    """
    goal = for_rows(target, np.float64, (3,), rows=len(eyes), what="gaze: target")
    distance = np.linalg.norm(goal - eyes.middle, axis=1)
    if not np.isfinite(goal).all() or np.any(distance == 0.0):
        raise InputError("gaze: expected finite targets (B, 3) [m] away from the eyes")
    most = np.broadcast_to(np.asarray(trunk, np.float64), len(eyes))
    arrays = eyes.left, eyes.right, eyes.axes, eyes.pivot, goal, most
    return _known_gaze(limits, *(one.tobytes() for one in arrays))


@lru_cache(maxsize=16)
def _known_gaze(limits: Limits, *arrays: bytes) -> Gaze:
    """What `gaze` finds, once for the same eyes and goals: while a part is dragged, both stay."""
    shapes = [(-1, 3), (-1, 3), (-1, 3, 3), (-1, 3), (-1, 3), (-1,)]
    given = zip(arrays, shapes, strict=True)
    left, right, axes, pivot, goal, most = (np.frombuffer(a).reshape(shape) for a, shape in given)
    eyes = Eyes(left, right, axes, pivot)
    side = limits.head_side + most
    low = np.stack([-side, np.full(len(eyes), -limits.head_down)], axis=1)
    high = np.stack([side, np.full(len(eyes), limits.head_up)], axis=1)
    head = np.zeros((len(eyes), 2))
    turning = np.arange(len(eyes))
    for _ in range(_ROUNDS):
        before = head[turning]
        turned = _turned(eyes.rows(turning), before)
        whole = before + _eye_turn(turned, goal[turning], limits)
        wanted = whole - np.clip(whole, -limits.easy, limits.easy)
        head[turning] = np.clip(wanted, low[turning], high[turning])
        turning = turning[(np.abs(head[turning] - before) > _STILL).any(axis=1)]
        if not len(turning):
            break
    found = _turned(eyes, head)
    turn = _eye_turn(found, goal, limits)
    least = np.array([-limits.eye_side, -limits.eye_down])
    most = np.array([limits.eye_side, limits.eye_up])
    lack = np.abs(turn - np.clip(turn, least, most)).max(axis=1)
    lack = np.where(lack <= _TOLERANCE, 0.0, lack)
    of_head = np.clip(head[:, :1], -limits.head_side, limits.head_side)
    return Gaze(
        _looking(found, goal, limits.eye_centre * (lack == 0.0)),
        turn,
        np.hstack([of_head, head[:, 1:]]),
        head[:, 0] - of_head[:, 0],
        lack,
    )


def _looking(eyes: Eyes, goal: Floats, centre: Floats) -> Eyes:
    """Eyes that have turned to goals (B, 3) about their centres, so far (B,) [m] behind the pupils."""
    pupils = []
    for pupil in (eyes.left, eyes.right):
        middle = pupil - centre[:, None] * eyes.axes[:, 0]
        way = goal - middle
        way /= np.linalg.norm(way, axis=1)[:, None]
        pupils.append(middle + centre[:, None] * way)
    return Eyes(pupils[0], pupils[1], eyes.axes, eyes.pivot)


def _turned(eyes: Eyes, turn: Floats) -> Eyes:
    """Eyes after the head has turned (B, 2) [rad] to the left and up, at once, without roll."""
    rotation = exponential(turn[:, :1] * eyes.axes[:, 2] - turn[:, 1:] * eyes.axes[:, 1])
    return Eyes(
        eyes.pivot + rotate(rotation, eyes.left - eyes.pivot),
        eyes.pivot + rotate(rotation, eyes.right - eyes.pivot),
        rotate(rotation[:, None], eyes.axes),
        eyes.pivot,
    )


def _eye_turn(eyes: Eyes, goal: Floats, limits: Limits) -> Floats:
    """(B, 2) [rad] to the left and up from the normal line of sight to goals (B, 3), of an eye midway
    between the two.

    As parts of one turn, so that straight up is a turn up alone and straight left one to the left;
    what is exactly behind is a half turn to the left.
    """
    down = limits.line_down
    way = np.einsum("bki,bi->bk", eyes.axes, goal - eyes.middle)
    way[:, 0] += limits.eye_centre
    along = math.cos(down) * way[:, 0] - math.sin(down) * way[:, 2]
    above = math.sin(down) * way[:, 0] + math.cos(down) * way[:, 2]
    aside = np.where((way[:, 1] == 0.0) & (above == 0.0), _NOTHING, way[:, 1])
    beside = np.hypot(aside, above)
    share = np.arctan2(beside, along) / beside
    return np.stack([aside * share, above * share], axis=1)
