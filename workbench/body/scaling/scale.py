"""A body to given measures, or thousands of bodies: the least change that shows every given
measure.

A body of a family moves within it, as likely as can be; what the family does not reach, and any
body without one, is stretched. With the extreme spheres held fixed a measure is linear in all these
knobs (see scaling.space), so the least change that gives the measures exactly is one linear system;
it is solved again with the extreme spheres of the new shape until the measures stay.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from workbench.body.scaling.likely import check_likely
from workbench.body.scaling.manikin import Length, Manikin
from workbench.body.scaling.measure import lengths
from workbench.body.scaling.morph import morph
from workbench.body.scaling.rebuilt import rebuilt
from workbench.body.scaling.space import ShapeSpace, shape_space
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.measures import check_plausible

__all__ = ["LONGER", "morph_to", "scale", "scale_many"]

LEAST_STEPS = 2
MOST_STEPS = 14
"""Steps of the least change from the unchanged body, then of the least change from the last
step."""
CLOSE = 1e-5
ENOUGH = 2e-4
"""[m] Stop at the first; after all steps the second is good enough."""
PATIENCE = 4
GIVE = 1e-9
"""Rivals that cannot both be had must not make the system singular."""
SOFT = {True: 1.0e-4, False: 5.0e-4}
"""[m2] Variance of what is near without having to be, for a body of a family and for another."""
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


Measures = Mapping[str, float]
Fitted = tuple[Floats, Manikin]


def scale(
    body: Body, measures: Measures, *, others: Measures | None = None, detail: str | None = None
) -> Body:
    """The body with the given measures [m] (see measure.MEASURES), and the least change else.

    others: measures [m] that it should come near without having to, such as the means of people
    with the given ones. detail: the level of detail of its family to make it in, its own where
    None. Masses go with the volume of each segment. InputError where measures contradict one
    another, are no person's (see model.measures), or would bend the body beyond any person.
    """
    _refuse(measures)
    space = shape_space(morph_to(body, detail))
    return rebuilt(space, *_fitted(space, measures, others or {}, space.neutral))


def scale_many(
    body: Body,
    people: Iterable[Measures],
    *,
    others: Iterable[Measures] | None = None,
    detail: str | None = None,
) -> Iterator[Body | InputError]:
    """Bodies to the measures of many people, in their order, one at a time; the error where there
    is no such body.

    Each is sought from the person before that is most like it, in fewer steps than from `body`; the
    figures are those of `scale` to within the tolerance of both.
    """
    space = shape_space(morph_to(body, detail))
    known: dict[tuple[str, ...], tuple[list[list[float]], list[Floats]]] = {}
    near: Iterable[Measures | None] = others if others is not None else _nothing()
    for measures, soft in zip(people, near, strict=False):
        rows, found = known.setdefault(tuple(measures), ([], []))
        given = list(measures.values())
        start = space.neutral
        if rows:
            start = found[int(np.argmin(((np.array(rows) - given) ** 2).sum(axis=1)))]
        try:
            _refuse(measures)
            values, manikin = _fitted(space, measures, soft or {}, start)
            yield rebuilt(space, values, manikin)
        except InputError as error:
            yield error
            continue
        rows.append(given)
        found.append(values)


def morph_to(body: Body, detail: str | None) -> Body:
    """The body at another level of detail of its family, itself where None."""
    if detail is None:
        return body
    if body.basis is None:
        raise InputError(
            f"body {body.name} belongs to no family of bodies, so it has no other level of detail"
        )
    return morph(body, body.basis_at[0], detail)


def _nothing() -> Iterator[None]:
    while True:
        yield None


def _refuse(measures: Measures) -> None:
    check_plausible(measures)
    faults = []
    for longer, shorter in LONGER:
        if longer in measures and shorter in measures and measures[longer] <= measures[shorter]:
            faults.append(
                f"{longer} {1000 * measures[longer]:g} mm is shorter than {shorter} "
                f"{1000 * measures[shorter]:g} mm"
            )
    if faults:
        raise InputError(faults)


def _fitted(space: ShapeSpace, measures: Measures, others: Measures, start: Floats) -> Fitted:
    """The knobs (K,) of the least change that shows the measures, and the body with them;
    InputError where there are none."""
    soft = {name: value for name, value in others.items() if name not in measures}
    if wrong := [name for name, value in soft.items() if not (math.isfinite(value) and value > 0)]:
        raise InputError(
            f"others: {wrong[0]}: expected a positive length, got {1000 * soft[wrong[0]]:g} mm"
        )
    off, found = _sought(space, measures, soft, start, LEAST_STEPS)
    if off > CLOSE:  # closed from where it is smallest, be it a trace dearer than the least change
        off, found = min(
            (off, found),
            _sought(space, measures, None, found[0], MOST_STEPS),
            key=lambda each: each[0],
        )
    values, manikin = found
    if off > ENOUGH:
        miss = {
            name: manikin.value(length) - measures[name]
            for name, length in lengths(manikin, measures).items()
        }
        worst = max(miss, key=lambda name: abs(miss[name]))
        raise InputError(
            f"no shape of {space.base.body.name} found with these measures: {worst} stays "
            f"{1000 * miss[worst]:+.1f} mm off"
        )
    check_likely(space, values, manikin, measures)
    return found


def _sought(
    space: ShapeSpace, measures: Measures, soft: Measures | None, start: Floats, most: int
) -> tuple[float, Fitted]:
    """Search a shape with given measures, by linearized steps.

    Parameters
    ----------
    space
        The shapes.
    measures
        Hard measures by name [m].
    soft
        Measures that should be near. With some, or none of them ({}), each step is the least change
        from the unchanged body, with the extreme spheres of the last step. With None it is the
        least change from the last step.
    start, most
        Parameters to start from, and the number of steps at most.

    Returns
    -------
    tuple[float, Fitted]
        The greatest miss [m] on a hard measure, and the shape that has it.
    """
    values = start
    best = np.inf
    nearest: Fitted | None = None
    rivals: dict[str, list[Length]] = {name: [] for name in measures}
    for step in range(most):
        manikin = space.manikin(values)
        hard = lengths(manikin, measures)
        off = max(
            (abs(manikin.value(length) - measures[name]) for name, length in hard.items()),
            default=0.0,
        )
        if nearest is None or (off < best and (step or soft is None)):
            nearest = (values, manikin)
            best = off if step or soft is None else np.inf
        if best < CLOSE:
            break
        # extreme spheres may take turns; from then on the last few of them are held at the measure
        # together
        for name, length in hard.items():
            rivals[name] = [length, *(other for other in rivals[name] if other != length)][
                : 1 + step // PATIENCE
            ]
        rows = [(length, measures[name]) for name in measures for length in rivals[name]]
        if soft is None:
            values = _solve(space, manikin, values, rows, [])
        else:
            near = [(length, soft[name]) for name, length in lengths(manikin, soft).items()]
            values = _solve(space, space.base, space.neutral, rows, near)
    assert nearest is not None
    return best, nearest


def _solve(
    space: ShapeSpace,
    manikin: Manikin,
    values: Floats,
    hard: list[tuple[Length, float]],
    soft: list[tuple[Length, float]],
) -> Floats:
    """Return the parameters of the cheapest change from a manikin with parameters `values`.

    hard, soft: measures that become exact and near, with the wanted values [m].
    """
    # Minimize (v - n)' P (v - n) subject to R (v - n) = b, with n = values, D the give of each row:
    #     v = n + P^-1 R' (R P^-1 R' + D)^-1 b.
    both = hard + soft
    if not both:
        return values
    rows = np.array([space.row(length) for length, _ in both])
    wanted = np.array([value - manikin.value(length) for length, value in both])
    give = np.repeat([GIVE, SOFT[space.family > 0]], [len(hard), len(soft)])
    toward = space.cheap @ rows.T
    solution: Floats = values + toward @ np.linalg.solve(rows @ toward + np.diag(give), wanted)
    return solution
