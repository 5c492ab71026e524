"""A body to given measures: every segment stretched along its three axes, radii along, until the measures are right.

For bodies without a basis of shapes. With the extreme spheres held fixed a measure is linear in the factors (see
shape.space), so the smallest change that gives the measures exactly is one linear system (the conditions of Karush,
Kuhn and Tucker); it is solved again with the extreme spheres of the new shape until the measures stay.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.shape.manikin import Length, Manikin, Shape
from workbench.shape.measure import lengths
from workbench.shape.space import KNOBS, ShapeSpace, shape_space

__all__ = ["LONGER", "scale"]

MOST_STEPS = 32
CLOSE, ENOUGH = 1e-5, 2e-4
"""[m] Stop at the first; after all steps the second is good enough."""
FACTORS = (0.4, 1.8)
TAPER = 0.45
PATIENCE, GIVE = 4, 1e-9
SOFT = 2.0e3
# (longer, shorter): pairs that cannot be the other way round, because the one holds the other.
LONGER: tuple[tuple[str, str], ...] = (
    ("stature", "sitting_height"),
    ("stature", "acromial_height"),
    ("stature", "cervicale_height"),
    ("stature", "trochanterion_height"),
    ("sitting_height", "eye_height_sitting"),
    ("sitting_height", "acromial_height_sitting"),
    ("sitting_height", "cervicale_height_sitting"),
    ("buttock_knee_length", "buttock_popliteal_length"),
    ("knee_height_sitting", "popliteal_height"),
    ("bideltoid_breadth", "biacromial_breadth"),
    ("forearm_hand_length", "hand_length"),
    ("forearm_hand_length", "forearm_center_of_grip_length"),
    ("shoulder_elbow_length", "acromion_radiale_length"),
    ("lateral_femoral_epicondyle_height", "lateral_malleolus_height"),
    ("trochanterion_height", "lateral_femoral_epicondyle_height"),
)


def scale(body: Body, measures: Mapping[str, float], *, others: Mapping[str, float] | None = None) -> Body:
    """The body with the given measures [m] (see measure.MEASURES), and the least change else.

    others: measures [m] that it should come near without having to, such as the means of people with the given ones.
    Masses go with the volume of each segment. InputError where measures contradict one another, are not positive, or
    would bend the body beyond any person.
    """
    _refuse(measures)
    space = shape_space(body)
    soft = {name: value for name, value in (others or {}).items() if name not in measures}
    factors = space.neutral
    miss: dict[str, float] = {}
    rivals: dict[str, list[Length]] = {name: [] for name in measures}
    best, nearest = np.inf, factors
    for step in range(MOST_STEPS):
        manikin = space.manikin(factors)
        hard = lengths(manikin, measures)
        miss = {name: manikin.value(length) - measures[name] for name, length in hard.items()}
        off = max(map(abs, miss.values()), default=0.0) if step else np.inf
        best, nearest = (off, factors) if off < best else (best, nearest)
        if best < CLOSE:
            break
        # extreme spheres may take turns; from then on the last few of them are held at the measure together
        for name, length in hard.items():
            rivals[name] = [length, *(other for other in rivals[name] if other != length)][: 1 + step // PATIENCE]
        rows = [(length, measures[name]) for name in measures for length in rivals[name]]
        factors = _solve(space, rows, [(length, soft[name]) for name, length in lengths(manikin, soft).items()])
    if best > ENOUGH:
        worst = max(miss, key=lambda name: abs(miss[name]))
        raise InputError(f"no shape of {body.name} found with these measures: {worst} stays "
                         f"{1000 * miss[worst]:+.1f} mm off")  # fmt: skip
    _check_factors(body, space.groups, nearest)
    return _rebuilt(body, space.manikin(nearest), (space.groups, nearest))


def _refuse(measures: Mapping[str, float]) -> None:
    faults = [f"{name}: a positive length is needed, got {1000 * value:g} mm" for name, value in measures.items()
              if not (np.isfinite(value) and value > 0)]  # fmt: skip
    for longer, shorter in LONGER:
        if longer in measures and shorter in measures and measures[longer] <= measures[shorter]:
            faults.append(f"{longer} {1000 * measures[longer]:g} mm is shorter than {shorter} "
                          f"{1000 * measures[shorter]:g} mm")  # fmt: skip
    if faults:
        raise InputError(faults)


def _solve(space: ShapeSpace, hard: list[tuple[Length, float]], soft: list[tuple[Length, float]]) -> Floats:
    """The factors of least price with the hard measures exact and the soft ones near."""
    count = len(space.price)
    rows = np.array([space.row(length) for length, _ in hard]).reshape(-1, count)
    near = np.array([space.row(length) for length, _ in soft]).reshape(-1, count)
    price = space.price + SOFT * near.T @ near
    pull = space.price @ space.neutral + SOFT * near.T @ np.array([value for _, value in soft])
    # a trace of give: rivals that cannot both be had must not make the system singular
    system = np.block([[price, rows.T], [rows, -GIVE * np.eye(len(rows))]])
    solution: Floats = np.linalg.solve(system, np.concatenate([pull, [value for _, value in hard]]))
    return solution[:count]


def _check_factors(body: Body, groups: Ints, factors: Floats) -> None:
    """A segment that would have to be less than half or nearly twice itself is no person's."""
    table = factors.reshape(-1, KNOBS)
    strain = np.abs(np.log(np.maximum(table[:, :4], 1e-9)))
    group, way = np.unravel_index(int(np.argmax(strain)), strain.shape)
    name = body.segment_names[int(np.flatnonzero(groups == group)[0])].removeprefix("left ")
    factor = float(table[group, way])
    if not FACTORS[0] <= factor <= FACTORS[1]:
        what = ("depth", "breadth", "length", "girth")[way]
        raise InputError(f"no such person: the {name}'s {what} would have to change by a factor of {factor:.2f} "
                         f"({FACTORS[0]} to {FACTORS[1]} is possible)")  # fmt: skip
    most = int(np.argmax(np.abs(table[:, 4])))
    if abs(table[most, 4]) > TAPER:
        name = body.segment_names[int(np.flatnonzero(groups == most)[0])].removeprefix("left ")
        raise InputError(f"no such person: the {name} would be {abs(table[most, 4]):.0%} thicker at one end than it is "
                         f"({TAPER:.0%} is possible)")  # fmt: skip


def _rebuilt(body: Body, manikin: Manikin, change: tuple[Ints, Floats]) -> Body:
    groups, factors = change
    shape = manikin.shape
    volume = factors.reshape(-1, KNOBS)[:, :3].prod(axis=1)[groups]
    around = factors.reshape(-1, KNOBS)[groups]
    return replace(
        body,
        centre=shape.centre,
        radius=shape.radius,
        joint_in_parent=_on_the_floor(body, manikin),
        joint_in_child=shape.in_child,
        mass=body.mass * volume,
        enclosing_centre=body.enclosing_centre * around[:, :3],
        enclosing_radius=_enclosing(body, shape, body.enclosing_centre * around[:, :3]),
        twist_point=_twist_lines(body, manikin.shape)[0],
        twist_axis=_twist_lines(body, manikin.shape)[1],
        allowance=_flesh(body, manikin),
    )


def _on_the_floor(body: Body, manikin: Manikin) -> Floats:
    """Joint coordinates in the parents, the first joints raised so that the zero pose stands on the floor."""
    in_parent = manikin.shape.in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= manikin.lowest()
    return in_parent


def _flesh(body: Body, manikin: Manikin) -> Floats:
    """(N, N) [m] the allowance for soft flesh: grown by what standing and sitting overlap more than they did.

    A stouter body presses more flesh together in the very postures in which the first one was not in contact.
    """
    before, after = shape_space(body).overlaps, manikin.overlaps()
    more = np.maximum(after - np.maximum(before, 0.0), 0.0)
    return np.where(body.adjacent, 0.0, np.maximum(body.allowance, body.allowance + more))


def _enclosing(body: Body, shape: Shape, centre: Floats) -> Floats:
    """(N,) radii about the scaled enclosing centres that hold every sphere at every twist."""
    segment = body.sphere_segment
    reach = np.linalg.norm(shape.centre - centre[segment], axis=1) + shape.radius
    radius = np.zeros(len(body.segments))
    np.maximum.at(radius, segment, reach)
    return np.where(radius > 0, radius + 1e-12, 0.0)


def _twist_lines(body: Body, shape: Shape) -> tuple[Floats, Floats]:
    """The lines that twist is shared along, from the scaled proximal to the scaled distal joints."""
    point, axis = body.twist_point.copy(), body.twist_axis.copy()
    for n in np.flatnonzero(body.twist_joint >= 0):
        point[n] = shape.in_child[n - 1] if n else np.zeros(3)
        span = shape.in_parent[body.twist_joint[n]] - point[n]
        axis[n] = span / np.linalg.norm(span)
    return point, axis
