"""Static loads: what the joints of a person bear who holds a posture, and what bears the person.

All forces on the segments are added up: their weight, what is held, the pushes of hands and feet, and
the reactions of seat and floor. The moment at a joint balances all those beyond it:

    M_j = - sum over segments n beyond joint j of (r_n - c_j) x F_n

Nothing moves, and muscles that pull against each other are not in it. The reactions are the smallest
forces, in the sense of least squares, that balance the rest, as if all points that bear were
equally stiff: how a person shares the weight between seat and feet is not known [1]_.

References
----------
.. [1] D. B. Chaffin, G. B. J. Andersson and B. J. Martin (2006), Occupational biomechanics, 4th ed.,
   Wiley, chapter 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arguments import check_fields
from workbench.model.arrays import Bools, Floats, Ints, for_rows, read_only
from workbench.model.body import Body
from workbench.model.poses import Placed
from workbench.model.quaternions import cross
from workbench.model.simulation import STANDARD_GRAVITY
from workbench.posture.balance import bearing, hull_margins
from workbench.strain.working_angles import check_segments

__all__ = ["Push", "StaticLoad", "Supports", "static_load", "supports_of"]

_RANK = 1e-9
"""Share of the largest singular value below which supports cannot bear a load: points in a line bear
no moment about it."""
_ROUNDS = 20
"""How often points that would pull are let go."""
_BALANCED = 1e-6
"""Forces and moments that are left over, as a share of the weight, that count as balanced."""


@dataclass(frozen=True, eq=False)
class Push:
    """A force on a person, from what is touched: who pushes a lever forward feels it backward.

    Parameters
    ----------
    segment
        The segment that is pushed, by its mnemonic.
    force
        (3,) or (P, 3) [N] in the world, on the person.
    point
        (3,) or (P, 3) [m] in the world; the segment's centre of gravity where None.
    """

    segment: str
    force: ArrayLike
    point: ArrayLike | None = None

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, eq=False)
class Supports:
    """Points of P people that seat or floor may bear.

    Parameters
    ----------
    points
        (P, K, 3) [m] in the world.
    segment
        (K,) the segment that each is on.
    bears
        (P, K) which of them touch.
    toward
        (K, 3) unit directions toward what they touch; it can push only the other way.
    """

    points: Floats
    segment: Ints
    bears: Bools
    toward: Floats

    def __add__(self, other: Supports) -> Supports:
        """All points of both."""
        return Supports(
            np.concatenate([self.points, other.points], axis=1),
            np.concatenate([self.segment, other.segment]),
            np.concatenate([self.bears, other.bears], axis=1),
            np.concatenate([self.toward, other.toward]),
        )


@dataclass(frozen=True, eq=False)
class StaticLoad:
    """The static load of P postures of a body with J joints.

    Parameters
    ----------
    moment
        (P, J, 3) [Nm] in the world: what each joint exerts on the segment beyond it.
    about_axes
        (P, J, 3) [Nm] its parts about the two swing axes and the twist axis of each joint, positive
        where the muscles of the first motion of the axis are at work.
    centre
        (P, 3) [m] the centre of mass with what is held.
    pressure
        (P, 2) [m] where weight and pushes meet the level of the lowest point that bears, seen from
        above; NaN without supports, and where nothing presses down.
    margin
        (P,) [m] how far that is inside the hull of the points that bear, negative outside.
    reaction
        (P, K, 3) [N] of each support.
    pulls
        (P,) True where no forces that push were found to balance the rest, and `reaction` pulls at
        some points: the posture does not hold, or something else bears.
    left_over
        (P, 6) [N, Nm] force, and moment about the origin, that no support balances: those that hold
        the person in space.
    """

    moment: Floats
    about_axes: Floats
    centre: Floats
    pressure: Floats
    margin: Floats
    reaction: Floats
    pulls: Bools
    left_over: Floats

    @property
    def balanced(self) -> Bools:
        """(P,) whether the supports balance weight and pushes."""
        return np.asarray(np.abs(self.left_over).max(axis=1) == 0.0)


def supports_of(
    placed: Placed, segments: Sequence[str], *, toward: ArrayLike = (0.0, 0.0, -1.0)
) -> Supports:
    """Find the points of some segments that bear on a floor, a seat pan or a back.

    They are the fronts of the spheres that come within 10 mm of the farthest one. Add up those of
    several surfaces: the feet of one, thighs and pelvis of another.

    Parameters
    ----------
    placed
        P postures in the world.
    segments
        The segments that touch one surface, by mnemonic.
    toward
        (3,) the direction from the person toward it; down where not given.

    Raises
    ------
    InputError
        If there is no such segment, it has no spheres or is outside the logical window, or the
        direction is none.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> feet = wb.supports_of(standing, ["LF", "RF"])
    >>> int(feet.bears.sum()), feet.bears.shape  # how many of the spheres of both feet bear
    (38, (1, 52))
    """
    body = placed.body
    way = read_only(toward, np.float64, (3,), "supports: toward")
    length = float(np.linalg.norm(way))
    if not length > 0.0:
        raise InputError("supports: expected a direction toward the surface, got (0, 0, 0)")
    way = way / length
    numbers = [body.segment(name) for name in segments]
    check_segments(placed, tuple(segments), "supports")
    spheres = np.flatnonzero(np.isin(body.sphere_segment, numbers))
    if not len(spheres):
        raise InputError(f"supports: the segments {', '.join(segments)} have no spheres")
    radius = body.radius[placed.person][:, spheres, None]
    return Supports(
        placed.centres[:, spheres] + radius * way,
        body.sphere_segment[spheres],
        bearing(placed, spheres, way),
        np.broadcast_to(way, (len(spheres), 3)),
    )


def static_load(
    placed: Placed,
    supports: Supports | None,
    *,
    pushes: Sequence[Push] = (),
    held: Mapping[str, float] | None = None,
) -> StaticLoad:
    """Compute the moments at all joints, the reactions of supports, and the balance of postures.

    Parameters
    ----------
    placed
        P postures in the world, z upward.
    supports
        What bears the person, see `supports_of`. None: nothing does, the first segment is held, so
        legs hang from it.
    pushes
        Forces of what hands and feet touch.
    held
        [kg] masses that are fixed to segments, by mnemonic, at their centres of gravity: a tool in a
        hand, a helmet.

    Raises
    ------
    InputError
        If the body has no mass, a segment is unknown or outside the logical window, a mass is
        negative, or supports are of other postures.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> arm = wb.place(body, wb.pose(body, {"RS": {"flexion": 90}}))
    >>> found = wb.static_load(arm, wb.supports_of(arm, ["LF", "RF"]), held={"RHN": 2.0})
    >>> float(found.about_axes[0, body.joint("RS"), 0].round(1))  # [Nm] by the flexors
    24.7
    >>> round(1000 * float(found.margin[0]))  # [mm] inside the soles
    58
    """
    body = placed.body
    if not placed.window.all():
        raise InputError("static loads need all segments, some are outside the logical window")
    mass = _masses(placed, held or {})
    force = np.zeros((len(placed), len(body.segments), 3))
    force[..., 2] = -STANDARD_GRAVITY * mass
    origin = placed.world_from_segment[..., 3]
    moment = cross(origin, force)
    for push in pushes:
        _add_push(placed, push, force, moment)
    applied = np.concatenate([force.sum(axis=1), moment.sum(axis=1)], axis=1)
    total = mass.sum(axis=1)
    centre = np.einsum("pn,pni->pi", mass, origin) / total[:, None]
    count = len(placed)
    if supports is None:
        reaction, left_over = np.zeros((count, 0, 3)), applied
        pressure, margin = np.full((count, 2), np.nan), np.full(count, np.nan)
        pulls = np.zeros(count, dtype=np.bool_)
    else:
        _check_supports(placed, supports)
        reaction, left_over, pulls = _pushing(supports, applied, STANDARD_GRAVITY * total)
        pressure, margin = _balance(supports, applied)
        on = np.eye(len(body.segments))[supports.segment]
        force += np.einsum("kn,pki->pni", on, reaction)
        moment += np.einsum("kn,pki->pni", on, cross(supports.points, reaction))
    at_joints = _joint_moments(placed, force, moment)
    return StaticLoad(
        at_joints,
        _about_axes(placed, at_joints),
        centre,
        pressure,
        margin,
        reaction,
        pulls,
        left_over,
    )


def _masses(placed: Placed, held: Mapping[str, float]) -> Floats:
    """(P, N) [kg] the masses of the segments with what is held."""
    body = placed.body
    mass = body.mass[placed.person]
    if not np.all(mass.sum(axis=1) > 0.0):
        raise InputError(f"body {body.name} has no mass, so it has no static load")
    for name, extra in held.items():
        if extra < 0.0:
            raise InputError(f"held: {name}: expected 0 kg or more, got {extra:g}")
        mass[:, body.segment(name)] += extra
    return mass


def _add_push(placed: Placed, push: Push, force: Floats, moment: Floats) -> None:
    """Add a push to the forces and moments (P, N, 3) about the origin."""
    n = placed.body.segment(push.segment)
    point = placed.world_from_segment[:, n, :, 3] if push.point is None else push.point
    vectors = []
    for what, given in (("force", push.force), ("point", point)):
        called = f"push on {push.segment}: {what}"
        vectors.append(for_rows(given, np.float64, (3,), rows=len(placed), what=called))
    force[:, n] += vectors[0]
    moment[:, n] += cross(vectors[1], vectors[0])


def _check_supports(placed: Placed, supports: Supports) -> None:
    """InputError where supports are of other postures."""
    count, points = supports.bears.shape
    if count != len(placed) or supports.points.shape != (count, points, 3):
        raise InputError(f"supports: expected those of {len(placed)} postures, got {count}")
    if not supports.bears.any(axis=1).all():
        raise InputError("supports: expected a point that bears of each posture")


def _pushing(supports: Supports, applied: Floats, weight: Floats) -> tuple[Floats, Floats, Bools]:
    """Reactions (P, K, 3), what is left over (P, 6), and where a support would have to pull (P,).

    Points that would pull are let go and the others asked again, as under a foundation that does
    not stick. Where too few are left to balance the rest, all points bear, and some pull.
    """
    bears = supports.bears.copy()
    reaction, left_over = _reactions(supports, bears, applied, weight)
    whole, left_whole = reaction.copy(), left_over.copy()
    some = np.arange(len(bears))
    for _ in range(_ROUNDS):
        toward = np.einsum("pki,ki->pk", reaction[some], supports.toward)
        pulling = toward > 1e-9 * weight[some, None]
        some, pulling = some[pulling.any(axis=1)], pulling[pulling.any(axis=1)]
        if not len(some):
            break
        bears[some] &= ~pulling
        fewer = Supports(
            supports.points[some], supports.segment, supports.bears[some], supports.toward
        )
        reaction[some], left_over[some] = _reactions(
            fewer, bears[some], applied[some], weight[some]
        )
    toward = np.einsum("pki,ki->pk", reaction, supports.toward)
    lost = (left_over != left_whole).any(axis=1) | (toward > 1e-9 * weight[:, None]).any(axis=1)
    reaction[lost], left_over[lost] = whole[lost], left_whole[lost]
    return reaction, left_over, lost


def _reactions(
    supports: Supports, bears: Bools, applied: Floats, weight: Floats
) -> tuple[Floats, Floats]:
    """Reactions (P, K, 3) of least squares of the points that bear, and what is left over (P, 6).

    With A (6, 3K) that adds up forces and moments: f = A^T (A A^T)^-1 (-applied). Moments count
    about the middle of the points, so that they are of the size of forces.
    """
    count = np.maximum(bears.sum(axis=1), 1)
    middle = np.sum(supports.points * bears[..., None], axis=1) / count[:, None]
    arm = (supports.points - middle[:, None]) * bears[..., None]
    wanted = -applied
    wanted[:, 3:] -= cross(middle, wanted[:, :3])
    # rows of A^T: for each point and direction the force and the moment that a newton makes
    unit = np.eye(3) * bears[..., None, None]
    turns = cross(np.broadcast_to(arm[:, :, None], unit.shape), unit)
    add = np.concatenate([unit, turns], axis=-1).reshape(len(arm), -1, 6)
    gram = add.transpose(0, 2, 1) @ add
    solved = (np.linalg.pinv(gram, rcond=_RANK, hermitian=True) @ wanted[..., None])[..., 0]
    reaction = np.einsum("pki,pi->pk", add, solved).reshape(*arm.shape)
    missing = wanted - np.einsum("pki,pk->pi", add, reaction.reshape(len(arm), -1))
    missing[np.abs(missing) < _BALANCED * weight[:, None]] = 0.0
    missing[:, 3:] += cross(middle, missing[:, :3])
    return reaction, -missing


def _balance(supports: Supports, applied: Floats) -> tuple[Floats, Floats]:
    """The centre of pressure (P, 2) and its margin (P,) in the hull of the points that bear.

    At the level of the lowest of them, o, the moment of what is applied about it has no level part:
    x = -M_y / F_z, y = M_x / F_z.
    """
    low = np.where(supports.bears, supports.points[..., 2], np.inf).min(axis=1)
    moment = applied[:, 3:].copy()
    moment[:, 0] += low * applied[:, 1]  # (0, 0, low) x F is taken away
    moment[:, 1] -= low * applied[:, 0]
    down = np.where(applied[:, 2] < 0.0, applied[:, 2], np.nan)
    pressure = np.stack([-moment[:, 1] / down, moment[:, 0] / down], axis=1)
    margin = hull_margins(supports.points[..., :2], supports.bears, pressure)
    return pressure, np.where(np.isnan(down), np.nan, margin)


def _joint_moments(placed: Placed, force: Floats, moment: Floats) -> Floats:
    """(P, J, 3) [Nm] M_j = -(sum of moments about the origin - c_j x sum of forces) beyond joint j."""
    body = placed.body
    beyond = _beyond(body)
    forces = np.einsum("jn,pni->pji", beyond, force)
    moments = np.einsum("jn,pni->pji", beyond, moment)
    child = placed.world_from_segment[:, 1:]
    local = body.joint_in_child[placed.person]
    centre = np.einsum("pjik,pjk->pji", child[..., :3], local) + child[..., 3]
    return cross(centre, forces) - moments


def _beyond(body: Body) -> Floats:
    """(J, N) 1 where a segment is beyond a joint. Parents come before their children."""
    under = np.eye(len(body.segments))
    for n in range(len(body.segments) - 1, 0, -1):
        under[body.parent[n]] += under[n]
    return under[1:]


def _about_axes(placed: Placed, moment: Floats) -> Floats:
    """(P, J, 3) [Nm] moments about the joints' axes, which turn with the parents."""
    parent = placed.world_from_segment[:, placed.body.parent[1:], :, :3]
    axes = np.einsum("pjik,jak->pjai", parent, placed.body.stops.axes)
    return np.einsum("pjai,pji->pja", axes, moment)
