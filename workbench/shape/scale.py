"""A body to given measures: every segment stretched along its three axes, radii along, until the measures are right.

For bodies without a basis of shapes. The parameters are four factors for each pair of segments: along x, y, z, and for
the radii. Centres, joints and radii are linear in them, so a measure with its extreme spheres held fixed is linear
too. The smallest change that gives the measures exactly is one linear system (the conditions of Karush, Kuhn and
Tucker); it is solved again with the extreme spheres of the new shape until the measures stay.
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

__all__ = ["LONGER", "scale"]

MOST_STEPS = 40
CLOSE = 1e-5
FACTORS = (0.4, 1.8)
ROUND, SMOOTH, LEAST = 4.0, 1.0, 0.25
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
    soft = {name: value for name, value in (others or {}).items() if name not in measures}
    groups = _groups(body)
    basis = _basis(body, groups)
    bending = _bending(body, groups)
    factors = np.ones(4 * (int(groups.max()) + 1))
    base = Manikin(body)
    for _ in range(MOST_STEPS):
        manikin = base.changed(_combined(basis, factors))
        hard = lengths(manikin, measures)
        miss = {name: manikin.value(length) - measures[name] for name, length in hard.items()}
        if max(map(abs, miss.values()), default=0.0) < CLOSE and _ > 0:
            return _rebuilt(body, manikin.shape, (groups, factors))
        wanted = (hard, measures, lengths(manikin, soft), soft)
        factors = _solve(base, basis, (bending, wanted))
        _check_factors(body, groups, factors)
    worst = max(miss, key=lambda name: abs(miss[name]))
    raise InputError(f"no shape of {body.name} found with these measures: {worst} stays {1000 * miss[worst]:+.1f} mm off")


def _refuse(measures: Mapping[str, float]) -> None:
    faults = [f"{name}: a positive length is needed, got {1000 * value:g} mm" for name, value in measures.items()
              if not (np.isfinite(value) and value > 0)]  # fmt: skip
    for longer, shorter in LONGER:
        if longer in measures and shorter in measures and measures[longer] <= measures[shorter]:
            faults.append(f"{longer} {1000 * measures[longer]:g} mm is shorter than {shorter} "
                          f"{1000 * measures[shorter]:g} mm")  # fmt: skip
    if faults:
        raise InputError(faults)


def _groups(body: Body) -> Ints:
    """(N,) the group of each segment: left and right twins, known by their names, change together."""
    plain = [name.removeprefix("left ").removeprefix("right ") for name in body.segment_names]
    order = list(dict.fromkeys(plain))
    return np.array([order.index(name) for name in plain])


def _basis(body: Body, groups: Ints) -> list[Shape]:
    """The shapes whose sums with the factors as weights are all the shapes there are."""
    segment = body.sphere_segment
    parent, child = groups[body.parent[1:]], groups[1:]
    shapes = []
    for group in range(int(groups.max()) + 1):
        for axis in range(4):
            along = np.eye(4)[axis, :3]
            of_spheres, is_radius = (groups[segment] == group)[:, None], float(axis == 3)
            shapes.append(Shape(
                body.centre * of_spheres * along,
                body.radius * of_spheres[:, 0] * is_radius,
                body.joint_in_parent * (parent == group)[:, None] * along,
                body.joint_in_child * (child == group)[:, None] * along,
            ))  # fmt: skip
    return shapes


def _combined(basis: list[Shape], factors: Floats) -> Shape:
    def total(field: str) -> Floats:
        return np.tensordot(factors, np.stack([getattr(shape, field) for shape in basis]), axes=1)

    return Shape(total("centre"), total("radius"), total("in_parent"), total("in_child"))


def _bending(body: Body, groups: Ints) -> Floats:
    """(F, F) the quadratic price of factors that leave 1, that differ within a segment, or between neighbours.

    Cross sections stay round (radius against the two axes across), lengths are free to go their own way.
    """
    count = int(groups.max()) + 1
    rows = [LEAST * row for row in np.eye(4 * count)]
    unit = np.eye(4 * count)
    size = [np.ptp(body.centre[np.isin(body.sphere_segment, np.flatnonzero(groups == g))], axis=0)
            if np.any(np.isin(body.sphere_segment, np.flatnonzero(groups == g))) else np.ones(3)
            for g in range(count)]  # fmt: skip
    for group in range(count):
        long = int(np.argmax(size[group]))
        for axis in range(3):
            rows.append((ROUND if axis != long else 0.5) * (unit[4 * group + axis] - unit[4 * group + 3]))
    for child in range(1, len(groups)):
        one, other = groups[child], groups[body.parent[child]]
        if one != other:
            rows.append(SMOOTH * (unit[4 * one + 3] - unit[4 * other + 3]))
    stacked = np.array(rows)
    return stacked.T @ stacked


Wanted = tuple[Mapping[str, Length], Mapping[str, float], Mapping[str, Length], Mapping[str, float]]


def _solve(base: Manikin, basis: list[Shape], problem: tuple[Floats, Wanted]) -> Floats:
    """The factors of least price with the hard measures exact and the soft ones near."""
    bending, (hard, exact, near, soft) = problem
    placed = [base.changed(shape) for shape in basis]
    rows = np.array([[m.value(length) for m in placed] for length in hard.values()]).reshape(-1, len(basis))
    soft_rows = np.array([[m.value(length) for m in placed] for length in near.values()]).reshape(-1, len(basis))
    ones = np.ones(len(basis))
    price = bending + SOFT * soft_rows.T @ soft_rows
    pull = bending @ ones + SOFT * soft_rows.T @ np.array([soft[name] for name in near])
    zero = np.zeros((len(rows), len(rows)))
    system = np.block([[price, rows.T], [rows, zero - 1e-12 * np.eye(len(rows))]])
    right = np.concatenate([pull, [exact[name] for name in hard]])
    solution: Floats = np.linalg.solve(system, right)
    return solution[: len(basis)]


def _check_factors(body: Body, groups: Ints, factors: Floats) -> None:
    worst = int(np.argmax(np.abs(np.log(np.maximum(factors, 1e-9)))))
    if not FACTORS[0] <= factors[worst] <= FACTORS[1]:
        name = body.segment_names[int(np.flatnonzero(groups == worst // 4)[0])].removeprefix("left ")
        way = ("depth", "breadth", "length", "girth")[worst % 4]
        raise InputError(f"no such person: the {name}'s {way} would have to change by a factor of {factors[worst]:.2f} "
                         f"({FACTORS[0]} to {FACTORS[1]} is possible)")  # fmt: skip


def _rebuilt(body: Body, shape: Shape, change: tuple[Ints, Floats]) -> Body:
    groups, factors = change
    volume = factors.reshape(-1, 4)[:, :3].prod(axis=1)[groups]
    around = factors.reshape(-1, 4)[groups]
    return replace(
        body,
        centre=shape.centre,
        radius=shape.radius,
        joint_in_parent=_on_the_floor(body, shape),
        joint_in_child=shape.in_child,
        mass=body.mass * volume,
        enclosing_centre=body.enclosing_centre * around[:, :3],
        enclosing_radius=_enclosing(body, shape, body.enclosing_centre * around[:, :3]),
        twist_point=body.twist_point * around[:, :3],
        twist_axis=_unit(body.twist_axis * around[:, :3]),
        allowance=_flesh(body, shape),
    )


def _on_the_floor(body: Body, shape: Shape) -> Floats:
    """Joint coordinates in the parents, the first joints raised so that the zero pose stands on the floor."""
    low = Manikin(body, shape).lowest()
    in_parent = shape.in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= low
    return in_parent


def _flesh(body: Body, shape: Shape) -> Floats:
    """(N, N) [m] the allowance for soft flesh: grown by what standing and sitting overlap more than they did.

    A stouter body presses more flesh together in the very postures in which the first one was not in contact.
    """
    before, after = Manikin(body).overlaps(), Manikin(body, shape).overlaps()
    more = np.maximum(after - np.maximum(before, 0.0), 0.0)
    return np.where(body.adjacent, 0.0, np.maximum(body.allowance, body.allowance + more))


def _enclosing(body: Body, shape: Shape, centre: Floats) -> Floats:
    """(N,) radii about the scaled enclosing centres that hold every sphere at every twist."""
    segment = body.sphere_segment
    reach = np.linalg.norm(shape.centre - centre[segment], axis=1) + shape.radius
    radius = np.zeros(len(body.segments))
    np.maximum.at(radius, segment, reach)
    return np.where(radius > 0, radius + 1e-12, 0.0)


def _unit(vector: Floats) -> Floats:
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(length > 0, vector / np.maximum(length, 1e-300), 0.0)

