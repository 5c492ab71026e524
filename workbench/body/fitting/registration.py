"""Find the size, posture and place in which a body of a family stands inside a scan of a person.

The unknowns are the family's coefficients z, the joint angles q, and the place of the lower torso.
They minimize, by damped Gauss-Newton steps [1]_,

    sum over points p of the scan     (min_s |p - c_s(z, q)| - r_s(z))^2 / SKIN^2
    + sum over spheres s              max(0, d(c_s) + r_s)^2 / SKIN^2
    + (z - z_0)' C^-1 (z - z_0) + sum over angles (q / spread)^2

where d is the signed distance to the scan: the skin lies on the spheres, no sphere leaves it, and
the person is a probable one who stands upright. A point's nearest sphere is sought again in each
step, as in the iterative closest point method [2]_. Several openings of arms and legs are starts.

References
----------
.. [1] J. J. More (1978), The Levenberg-Marquardt algorithm, Lecture Notes in Mathematics 630.
.. [2] P. J. Besl, N. D. McKay (1992), A method for registration of 3-D shapes, IEEE PAMI 14(2).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from workbench.body.scaling.morph import morph
from workbench.body.surface import Surface
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import ShapeBasis
from workbench.model.body import Body
from workbench.model.joint_angles import compose
from workbench.model.poses import Poses
from workbench.model.quaternions import exponential, matrices

__all__ = ["Registration", "register"]

_LEVEL = "coarse"
"""Level of detail of the family: enough to find where the segments are."""
_POINTS = 1_000
"""Points of the scan."""
_SKIN = 0.01
"""Spread [m] of a gap; neighbouring points say the same, so that _INDEPENDENT of all count."""
_INDEPENDENT = 400
_FAR = 0.03
"""Gap [m] from which on a point counts less (Huber): hair, a hand in another posture."""
_FACING = 0.3
"""Cosine up to which a sphere's surface may face away from the scan's, unless there is none other."""
_SHORT_STEPS = 4
_STEPS = 30
_AT_REST = 1e-4
"""Change of the cost, as a share of it, at which the steps end."""
_WORST = 0.02
"""Mean gap [m] from which on the scan is not that of a standing person."""
_FEET = 0.035
_SHANKS = (0.08, 0.2)
"""Heights of feet and shanks, as shares of the stature."""
_FOOT = 0.02
"""How far feet are ahead of shanks at least, as a share of the stature."""
_ARMS = (8.0, 30.0, 55.0, 80.0)
_LEGS = (6.0,)
"""Openings [deg] of shoulders and hips that are tried."""
_SPREAD = {
    "W": 6.0,
    "SP": 6.0,
    "NP": 10.0,
    "HP": 10.0,
    "LC RC": 6.0,
    "LS RS": 30.0,
    "LE RE": 30.0,
    "LW RW": 15.0,
    "LH RH": 15.0,
    "LK RK": 10.0,
    "LA RA": 8.0,
}
"""Spread [deg] of the angles of a standing person; joints that are not named are not turned."""
_TURNED = {"NP", "LS", "RS", "LH", "RH"}
"""Joints that twist too. The twist of the others is shared by the spheres of a segment."""


@dataclass(frozen=True, eq=False)
class Registration:
    """A body in a scan.

    Parameters
    ----------
    body
        The member of the family, at the level of detail of the template.
    poses
        Its posture and place, one row.
    gap
        Mean distance [m] of the scan's points from the spheres of the coarse level.
    """

    body: Body
    poses: Poses
    gap: float


@dataclass(frozen=True, eq=False)
class _State:
    """Values of the unknowns: where the pelvis joint is (3,) [m], attitude (3, 3), angles (J, 3)
    [rad], coefficients (K,)."""

    place: Floats
    attitude: Floats
    angles: Floats
    z: Floats


@dataclass(frozen=True, eq=False)
class _Problem:
    """P points of the scan with their outward normals (P, 3), the family, and what is free in it."""

    body: Body
    basis: ShapeBasis
    surface: Surface
    point: Floats
    normal: Floats
    free: Ints
    """(A, 2) joint and axis of each free angle."""
    spread: Floats
    """(A,) [rad]."""
    z: Floats
    """(K,) the coefficients that are likely."""
    likely: Floats
    """(K, K) L' where L L' is the inverse of their covariance."""


@dataclass(frozen=True, eq=False)
class _Spheres:
    """S spheres in the world, and how they change with the D unknowns."""

    centre: Floats
    """(S, 3) [m]."""
    radius: Floats
    centre_rate: Floats
    """(D, S, 3): place, attitude, angles, coefficients."""
    radius_rate: Floats
    """(D, S)."""


def register(template: Body, surface: Surface, *, seed: int = 0) -> Registration:
    """Find size, posture and place of a body of a family in the scan of a standing person.

    Parameters
    ----------
    template
        A body of a family of people.
    surface
        The scan: x forward, y left, z up.
    seed
        Of the choice of points.

    Raises
    ------
    InputError
        If the body has no family, or the scan is not that of a standing person who faces forward.
    """
    problem = _problem(template, surface, seed)
    _refuse_turned(problem.point)
    found = [
        _descend(problem, _start(problem, arm, leg), _SHORT_STEPS)
        for arm, leg in product(_ARMS, _LEGS)
    ]
    state = _descend(problem, min(found, key=lambda one: one[0])[1], _STEPS)[1]
    gap = float(np.abs(_nearest(problem, _spheres(problem, state))[1]).mean())
    if gap > _WORST:
        raise InputError(
            f"skeleton: no size and standing posture of {template.name} comes nearer to the surface "
            f"than {1e3 * gap:.0f} mm in the mean, {1e3 * _WORST:.0f} mm are most: does a person stand "
            "upright in it, facing forward (--up, --forward, --length)? Otherwise say with --at and "
            "--posture where and how the skeleton stands"
        )
    level = problem.basis.level(np.diff(template.start)) or _LEVEL
    body = morph(template, state.z, level)
    # the stage stands as in the zero pose: upright, the pelvis joint at its place in it
    world = np.concatenate([state.attitude, state.place[:, None]], axis=1)
    world[:, 3] -= state.attitude @ body.joint_in_parent[0, 0]
    return Registration(body, Poses(compose(body, state.angles)[None], 0, world[None]), gap)


def _refuse_turned(point: Floats) -> None:
    """Refuse a scan (P, 3) whose feet don't point forward: seen from the shanks they are ahead."""
    low = point[:, 2].min()
    share = (point[:, 2] - low) / np.ptp(point[:, 2])
    feet = np.flatnonzero(share < _FEET)
    shanks = np.flatnonzero((share > _SHANKS[0]) & (share < _SHANKS[1]))
    if not (len(feet) and len(shanks)):
        return
    ahead = point[feet, :2].mean(axis=0) - point[shanks, :2].mean(axis=0)
    far = float(np.linalg.norm(ahead))
    if far > _FOOT * np.ptp(point[:, 2]) and ahead[0] < abs(ahead[1]):
        aside = "left" if ahead[1] > 0 else "right"
        side = "backward" if -ahead[0] > abs(ahead[1]) else f"to the {aside}"
        raise InputError(
            f"skeleton: the feet in the surface point {side}, {1e3 * far:.0f} mm "
            "from the shanks in the mean, and should point forward: state the mesh's axes (--up, "
            "--forward), or with --at and --posture where and how the skeleton stands"
        )


def _problem(template: Body, surface: Surface, seed: int) -> _Problem:
    basis = template.basis
    if basis is None:
        raise InputError(f"skeleton: body {template.name} belongs to no family of bodies")
    corner = surface.vertices[surface.faces]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(seed)
    # evenly spread over the area: a random place in each of equal pieces
    level = (np.arange(_POINTS) + rng.random(_POINTS)) / _POINTS
    face = np.searchsorted(np.cumsum(area) / area.sum(), level)
    share = rng.dirichlet(np.ones(3), _POINTS)
    spread = {name: value for names, value in _SPREAD.items() for name in names.split()}
    free = [
        (j, axis)
        for j, name in enumerate(template.joints)
        for axis in range(3 if name in _TURNED else 2)
        if name in spread and np.ptp(_range(template, j, axis)) > 0
    ]
    z0 = template.basis_at[0]
    covariance = basis.anchor_spread[basis.nearest_anchor(z0)]
    return _Problem(
        body=template,
        basis=basis,
        surface=surface,
        point=np.einsum("pk,pkc->pc", share, corner[face]),
        normal=cross[face] / area[face, None],
        free=np.array(free),
        spread=np.radians([spread[template.joints[j]] for j, _ in free]),
        z=_as_tall(basis, z0, covariance, float(np.ptp(surface.vertices[:, 2]))),
        likely=np.linalg.cholesky(np.linalg.inv(covariance)).T,
    )


def _range(body: Body, joint: int, axis: int) -> Floats:
    """(2,) [rad] least and greatest angle of a joint about one of its axes."""
    first, second = body.stops.limits[joint, axis]
    return np.array([-second, first])


def _as_tall(basis: ShapeBasis, z: Floats, covariance: Floats, height: float) -> Floats:
    """(K,) the most likely coefficients of a person of a height: the conditional mean of normal
    variables, z + C g (h - h(z)) / (g' C g), with the gradient g of the height."""
    detail = basis.detail(_LEVEL)
    top = detail.centre_mean[:, 2] + detail.radius_mean
    bottom = detail.centre_mean[:, 2] - detail.radius_mean
    high = int(top.argmax())
    low = int(bottom.argmin())
    rate = detail.centre_basis[:, high, 2] + detail.radius_basis[:, high]
    rate = rate - detail.centre_basis[:, low, 2] + detail.radius_basis[:, low]
    now = top[high] - bottom[low] + z @ rate
    toward = covariance @ rate
    return z + toward * (height - now) / (rate @ toward)


def _start(problem: _Problem, arm: float, leg: float) -> _State:
    """Upright, arms and legs open by so many degrees, the pelvis joint in the middle of the hips."""
    angles = np.zeros((len(problem.body.joints), 3))
    for names, opening in (("LS RS", arm), ("LH RH", leg)):
        for name in names.split():
            angles[problem.body.joint(name), 1] = np.radians(opening)
    joint = problem.basis.joint_mean[0] + problem.z @ problem.basis.joint_basis[:, 0]
    floor = problem.surface.vertices[:, 2].min()
    beside = np.abs(problem.point[:, 2] - floor - joint[2]) < 0.08
    middle = np.median(problem.point[beside | ~beside.any()], axis=0)
    return _State(np.array([middle[0], middle[1], floor + joint[2]]), np.eye(3), angles, problem.z)


def _spheres(problem: _Problem, state: _State) -> _Spheres:
    """Place the spheres of the coarse level, and find how they change.

    Without blends and shared twists a point c of segment n, and the joint x_n it turns about, are
    linear in z: x_n = x_p + R_p (X_n - X_p), c = x_n + R_n (C - X_n), capitals in the zero pose.
    """
    body = problem.body
    basis = problem.basis
    detail = basis.detail(_LEVEL)
    rotations = matrices(compose(body, state.angles))
    values = np.concatenate([[np.tensordot(state.z, basis.joint_basis, 1)], basis.joint_basis])
    values[0] += basis.joint_mean
    spheres = np.concatenate([[np.tensordot(state.z, detail.centre_basis, 1)], detail.centre_basis])
    spheres[0] += detail.centre_mean
    rotation = [state.attitude, state.attitude]
    joint = [np.zeros_like(values[:, 0])]
    joint[0][0] = state.place
    behind = np.eye(len(body.segments), dtype=np.bool_)
    for n in range(2, len(body.segments)):
        p = int(body.parent[n])
        behind[n] |= behind[p]
        rotation.append(rotation[p] @ rotations[n - 1])
        joint.append(joint[p - 1] + (values[:, n - 1] - values[:, p - 1]) @ rotation[p].T)
    own = detail.segment
    arm = spheres - values[:, own - 1]
    centre = np.stack(joint, axis=1)[:, own - 1]
    centre = centre + np.einsum("sij,ksj->ksi", np.stack(rotation)[own], arm)
    rates = [np.broadcast_to(axis, centre[0].shape) for axis in np.eye(3)]
    rates += [np.cross(axis, centre[0] - state.place) for axis in np.eye(3)]
    for j, axis in problem.free:
        frame = rotation[j + 1] if axis == 2 else rotation[int(body.parent[j + 1])]
        about = np.cross(frame @ body.stops.axes[j, axis], centre[0] - joint[j][0])
        rates.append(np.where(behind[own, j + 1, None], about, 0.0))
    fixed = np.zeros((len(rates), len(own)))
    return _Spheres(
        centre[0],
        detail.radius_mean + state.z @ detail.radius_basis,
        np.concatenate([np.stack(rates), centre[1:]]),
        np.concatenate([fixed, detail.radius_basis]),
    )


def _nearest(problem: _Problem, spheres: _Spheres) -> tuple[Ints, Floats, Floats]:
    """Of each point of the scan the nearest sphere (P,) that faces alike, the gap (P,) [m], and the
    direction (P, 3) from its centre."""
    away = problem.point[:, None] - spheres.centre
    far = np.linalg.norm(away, axis=2)
    facing = np.einsum("psc,pc->ps", away, problem.normal) > _FACING * far
    gap = far - spheres.radius
    row = np.arange(len(gap))
    sphere = np.where(facing | ~facing.any(axis=1, keepdims=True), gap, np.inf).argmin(axis=1)
    return sphere, gap[row, sphere], away[row, sphere] / far[row, sphere, None]


def _descend(problem: _Problem, state: _State, steps: int) -> tuple[float, _State]:
    """Take so many steps at most; return the cost and the state where they end."""
    damping = 1e-2
    cost, residual, rate = _residuals(problem, state)
    for _ in range(steps):
        normal = rate.T @ rate
        normal[np.diag_indices(len(normal))] *= 1.0 + damping
        step: Floats = np.linalg.solve(normal, -rate.T @ residual).astype(np.float64)
        tried = _moved(problem, state, step)
        next_cost, next_residual, next_rate = _residuals(problem, tried)
        if next_cost >= cost:
            damping *= 8.0
            if damping > 1e6:
                break
            continue
        rests = cost - next_cost < _AT_REST * cost
        state, cost, residual, rate = tried, next_cost, next_residual, next_rate
        damping *= 0.3
        if rests:
            break
    return cost, state


def _residuals(problem: _Problem, state: _State) -> tuple[float, Floats, Floats]:
    """The cost, the residuals (M,) and their derivatives (M, D) by the unknowns."""
    spheres = _spheres(problem, state)
    sphere, gap, away = _nearest(problem, spheres)
    gap_rate = -np.einsum("dpc,pc->pd", spheres.centre_rate[:, sphere], away)
    gap_rate -= spheres.radius_rate[:, sphere].T
    distance, _, foot = problem.surface.nearest(spheres.centre)
    beyond = distance + spheres.radius
    out = np.flatnonzero(beyond > 0)
    skin = (spheres.centre[out] - foot[out]) / np.where(distance[out] == 0, 1.0, distance[out])[
        :, None
    ]
    out_rate = np.einsum("dsc,sc->sd", spheres.centre_rate[:, out], skin)
    out_rate += spheres.radius_rate[:, out].T
    weight = np.sqrt(_INDEPENDENT / len(gap)) / _SKIN
    # Huber's weights: a point that is FAR or farther pulls as strong as one at FAR
    pull = weight * np.sqrt(np.minimum(1.0, _FAR / np.maximum(np.abs(gap), 1e-9)))
    push = np.sqrt(_INDEPENDENT / len(beyond)) / _SKIN
    count = len(spheres.centre_rate)
    angles = np.zeros((len(problem.free), count))
    angles[:, 6 : 6 + len(problem.free)] = np.diag(1.0 / problem.spread)
    shape = np.zeros((len(state.z), count))
    shape[:, 6 + len(problem.free) :] = problem.likely
    turned = state.angles[problem.free[:, 0], problem.free[:, 1]]
    residual = np.concatenate(
        [
            pull * gap,
            push * beyond[out],
            turned / problem.spread,
            problem.likely @ (state.z - problem.z),
        ]
    )
    rate = np.concatenate([pull[:, None] * gap_rate, push * out_rate, angles, shape])
    return float(residual @ residual), residual, rate


def _moved(problem: _Problem, state: _State, step: Floats) -> _State:
    """The state after a step (D,); angles stay within their ranges."""
    angles = state.angles.copy()
    last = 6 + len(problem.free)
    for (j, axis), change in zip(problem.free, step[6:last], strict=True):
        low, high = _range(problem.body, j, axis)
        angles[j, axis] = np.clip(angles[j, axis] + change, low, high)
    attitude = matrices(exponential(step[3:6])) @ state.attitude
    return _State(state.place + step[:3], attitude, angles, state.z + step[last:])
