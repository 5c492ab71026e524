"""Fit a body, or thousands of bodies, to given measures by the least change.

A body of a family changes within it, as probably as can be. What the family does not reach is
stretched, and so is a body without a family. With its extreme spheres held fixed, a measure is
linear in all parameters (see `scaling.space`), so that the least change is one linear system. It is
solved again with the extreme spheres of the new shape until the measures stay.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import repeat
from typing import NamedTuple

import numpy as np

from workbench.body.scaling.manikin import Length, Manikin
from workbench.body.scaling.measure import lengths, measure
from workbench.body.scaling.morph import morph
from workbench.body.scaling.space import ShapeSpace, shape_space, volumes
from workbench.body.scaling.stretch import PARAMETERS
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import SEATED_FACTORS, Body
from workbench.model.population import check_plausible
from workbench.model.skinning import with_derived_fields

__all__ = ["LONGER", "check_likely", "morph_to", "rebuilt", "scale", "scale_many"]

_DIRECT_STEPS = 2
"""Steps of the least change from the unchanged body."""
_CLOSING_STEPS = 14
"""Steps at most of the least change from the last step, if a measure is still off."""
_EXACT = 1e-5
"""Miss [m] of a measure at which the search stops."""
_MAX_MISS = 2e-4
"""Miss [m] that is accepted after all steps."""
_PATIENCE = 4
"""Steps after which one more extreme sphere is held for a measure, see `_Rivals`."""
_FACTOR_STEPS = 8
_WIDER = 1e-3
"""Steps at most of the search of a factor of breadth, and the change that its slope is taken over."""
_HARD_GIVE = 1e-9
"""Variance [m2] of a given measure, so that two spheres that cannot both be extreme do not make the
system singular."""
_SOFT_GIVE = {True: 1.6e-5, False: 5.0e-4}
"""Variance [m2] of a measure that should be near, for a body of a family and for another."""
_OF_FAMILIES = (
    "trochanterion_height",
    "lateral_femoral_epicondyle_height",
    "acromion_radiale_length",
)
"""Measures taken at joints that a family's bodies have where people do; a body of its own, drawn near
to them, would lose its trunk."""
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
"""Longer and shorter measures, where one contains the other."""

_ELBOW = ("elbow_rest_height", "acromial_height_sitting", "shoulder_elbow_length")
"""The first is the second less the third."""
Measures = Mapping[str, float]


class _Fit(NamedTuple):
    """Parameters and the body with them."""

    values: Floats
    """(K,)."""
    manikin: Manikin


def scale(
    body: Body, measures: Measures, *, others: Measures | None = None, detail: str | None = None
) -> Body:
    """Fit a body to given measures, and change it as little as possible else.

    Parameters
    ----------
    body
        One body.
    measures
        Measures by name [m], see `measure.MEASURES`.
    others
        Measures by name [m] that it should come near, such as the means of people with the given ones.
    detail
        Level of detail of the body's family, its own if None.

    Returns
    -------
    Body
        Masses are proportional to the volumes of the segments, and the same at every level of detail.

    Raises
    ------
    InputError
        If measures contradict each other, are no person's (see `model.measures`), or need a shape that
        no person has.

    Examples
    --------
    >>> import workbench as wb
    >>> small = wb.scale(wb.load_body("adult_female"), {"stature": 1.525, "sitting_height": 0.803})
    >>> {name: round(1000 * wb.measure(small)[name], 1) for name in ("stature", "sitting_height")}
    {'stature': 1525.0, 'sitting_height': 803.0}
    """
    return _person(_spaces(body, detail), measures, others or {})


def scale_many(
    body: Body,
    people: Iterable[Measures],
    *,
    others: Iterable[Measures] | None = None,
    detail: str | None = None,
) -> Iterator[Body | InputError]:
    """Fit a body to the measures of many people, one at a time in their order: each as `scale`
    does, whoever the others are.

    Parameters
    ----------
    body
        One body.
    people
        Measures by name [m] of each person.
    others
        As for `scale`, for each person.
    detail
        As for `scale`.

    Yields
    ------
    Body or InputError
        The error, not raised, where there is no such body.
    """
    spaces = _spaces(body, detail)
    each_others: Iterable[Measures | None] = others if others is not None else repeat(None)
    for measures, soft in zip(people, each_others, strict=False):
        try:
            yield _person(spaces, measures, soft or {})
        except InputError as error:
            yield error


def morph_to(body: Body, detail: str | None) -> Body:
    """Return a body at another level of detail of its family, the body itself if None or its own.

    Raises
    ------
    InputError
        If the body has no family, or the family no such level.
    """
    if detail is None or (detail and detail == body.detail):
        return body
    if body.basis is None:
        raise InputError(
            f"body {body.name} belongs to no family of bodies, so it has no other level of detail"
        )
    return morph(body, body.basis_at[0], detail)


def _spaces(body: Body, detail: str | None) -> tuple[ShapeSpace, ...]:
    """The shapes at the level of detail asked for, then those at the body's own where that is another."""
    shown = morph_to(body, detail)
    return tuple(shape_space(one) for one in ((shown,) if shown is body else (shown, body)))


def _person(spaces: tuple[ShapeSpace, ...], measures: Measures, others: Measures) -> Body:
    """Fit the shape in the first space.

    Mass is the person's, but every level of detail holds another volume, and its spheres show a
    measure by another shape. So the masses are those of the fit in the last space.
    """
    _refuse(measures)
    made = [_made(space, measures, others) for space in spaces]
    return replace(made[0], mass=made[-1].mass)


def _made(space: ShapeSpace, measures: Measures, others: Measures) -> Body:
    """Fit the shape; where hip breadth is given standing and sitting, its share on a seat too."""
    if not {"hip_breadth", "hip_breadth_sitting"} <= set(measures):
        return rebuilt(space, *_fitted(space, measures, others))
    rest = {name: value for name, value in measures.items() if name != "hip_breadth_sitting"}
    near = {name: value for name, value in others.items() if name != "hip_breadth_sitting"}
    made = rebuilt(space, *_fitted(space, rest, near))
    return _spread_to(made, measures["hip_breadth_sitting"])


def _spread_to(body: Body, wanted: float) -> Body:
    """The body whose hips are so broad [m] on a seat by its own factor of breadth.

    The breadth is that of the farthest spheres, each linear in the factor: Newton's steps end at it.
    """
    for _ in range(_FACTOR_STEPS):
        factor = float(body.seated_factors[0, 0])
        found = _breadth_on_a_seat(body)
        if abs(found - wanted) < _EXACT:
            break
        slope = (_breadth_on_a_seat(_with_breadth(body, factor + _WIDER)) - found) / _WIDER
        factor += (wanted - found) / slope
        least, greatest = SEATED_FACTORS
        if not least <= factor <= greatest:
            raise InputError(
                f"hip_breadth_sitting {1000 * wanted:g} mm would be {factor:.2f} times the breadth "
                f"standing; {least:g} to {greatest:g} times is possible"
            )
        body = _with_breadth(body, factor)
    return body


def _breadth_on_a_seat(body: Body) -> float:
    return measure(body, ["hip_breadth_sitting"])["hip_breadth_sitting"]


def _with_breadth(body: Body, factor: float) -> Body:
    """The body with another factor of breadth on a seat."""
    return replace(body, seated_factors=np.array([[factor, body.seated_factors[0, 1]]]))


def _refuse(measures: Measures) -> None:
    """Refuse measures that are no person's or contradict each other."""
    check_plausible(measures)
    errors = []
    for longer, shorter in LONGER:
        if longer in measures and shorter in measures and measures[longer] <= measures[shorter]:
            errors.append(
                f"{longer} {1000 * measures[longer]:g} mm is shorter than {shorter} "
                f"{1000 * measures[shorter]:g} mm"
            )
    if set(_ELBOW) <= set(measures):
        rest, shoulder, arm = (measures[name] for name in _ELBOW)
        if abs(shoulder - arm - rest) > _MAX_MISS:
            errors.append(
                f"elbow_rest_height {1000 * rest:g} mm is acromial_height_sitting less "
                f"shoulder_elbow_length on a body, here {1000 * (shoulder - arm):g} mm: give two of "
                f"the three"
            )
    if errors:
        raise InputError(errors)


def _fitted(space: ShapeSpace, measures: Measures, others: Measures) -> _Fit:
    """Find the least change of the neutral shape that gives the measures; `others` should be near.

    The search starts there for everybody: a person's body does not depend on who came before.
    """
    apart = () if space.family else _OF_FAMILIES
    soft = {name: value for name, value in others.items() if name not in (*measures, *apart)}
    if wrong := [name for name, value in soft.items() if not (math.isfinite(value) and value > 0)]:
        raise InputError(
            f"others: {wrong[0]}: expected a positive length, got {1000 * soft[wrong[0]]:g} mm"
        )
    neutral = _Fit(space.neutral, space.unchanged)
    miss, fit = _search(space, measures, soft, neutral, _DIRECT_STEPS)
    if miss > _EXACT:
        # close what is left from there, although the sum of both is not quite the least change
        closed_miss, closed = _search(space, measures, None, fit, _CLOSING_STEPS)
        if closed_miss < miss:
            miss, fit = closed_miss, closed
    if miss > _MAX_MISS:
        raise _unreached(space, measures, fit.manikin)
    check_likely(space, fit.values, fit.manikin, measures)
    return fit


def _unreached(space: ShapeSpace, measures: Measures, manikin: Manikin) -> InputError:
    """The error of measures that were not found, with the one that is off most."""
    miss = {
        name: manikin.value(length) - measures[name]
        for name, length in lengths(manikin, measures).items()
    }
    worst = max(miss, key=lambda name: abs(miss[name]))
    return InputError(
        f"no shape of {space.base.body.name} found with these measures: {worst} stays "
        f"{1000 * miss[worst]:+.1f} mm off"
    )


def _search(
    space: ShapeSpace, measures: Measures, soft: Measures | None, start: _Fit, max_steps: int
) -> tuple[float, _Fit]:
    """Search a shape with given measures by linearized steps.

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
    start, max_steps
        The shape to start from, and the number of shapes at most.

    Returns
    -------
    tuple of float and _Fit
        The greatest miss [m] of a hard measure, and the shape that has it.
    """
    fit = start
    best = np.inf
    nearest: _Fit | None = None
    rivals = _Rivals(measures)
    for step in range(max_steps):
        extremes = lengths(fit.manikin, measures)
        miss = _greatest_miss(fit.manikin, extremes, measures)
        # the start itself is not the least change from the unchanged body, so it does not count
        counts = step > 0 or soft is None
        if nearest is None or (miss < best and counts):
            nearest = fit
            best = miss if counts else np.inf
        if best < _EXACT or step == max_steps - 1:
            break
        rows = rivals.hold(extremes, step)
        if soft is None:
            values = _solve(space, fit.manikin, fit.values, rows, [])
        else:
            near = [(length, soft[name]) for name, length in lengths(fit.manikin, soft).items()]
            values = _solve(space, space.base, space.neutral, rows, near)
        fit = _Fit(values, space.manikin(values))
    assert nearest is not None
    return best, nearest


def _greatest_miss(manikin: Manikin, extremes: dict[str, Length], measures: Measures) -> float:
    """Greatest distance [m] of a body's measures from the given ones."""
    misses = (abs(manikin.value(length) - measures[name]) for name, length in extremes.items())
    return max(misses, default=0.0)


class _Rivals:
    """The last extreme spheres of each measure.

    Two spheres may take turns as the extreme one. From then on both are held at the measure, and
    one more every few steps.
    """

    def __init__(self, measures: Measures) -> None:
        self._measures = measures
        self._lengths: dict[str, list[Length]] = {name: [] for name in measures}

    def hold(self, extremes: dict[str, Length], step: int) -> list[tuple[Length, float]]:
        """Add the extreme spheres of a step; return what is held, with the wanted values [m]."""
        for name, length in extremes.items():
            others = [other for other in self._lengths[name] if other != length]
            self._lengths[name] = [length, *others][: 1 + step // _PATIENCE]
        return [
            (length, wanted)
            for name, wanted in self._measures.items()
            for length in self._lengths[name]
        ]


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
    give = np.repeat([_HARD_GIVE, _SOFT_GIVE[space.family > 0]], [len(hard), len(soft)])
    direction = space.cheap @ rows.T
    return values + direction @ np.linalg.solve(rows @ direction + np.diag(give), wanted)


_ENCLOSING_STEPS = 6
"""Iterations of the sphere around each segment."""


def rebuilt(space: ShapeSpace, values: Floats, manikin: Manikin) -> Body:
    """Build the body with given parameters: on the floor, with its masses and allowance for flesh.

    Parameters
    ----------
    space, values
        The shapes of a body, and the parameters (K,) of one.
    manikin
        The body with this shape.

    Returns
    -------
    Body
        Masses are proportional to the volumes of the segments.
    """
    body = space.base.body
    shape = manikin.shape
    made = replace(
        body,
        centre=shape.centre[None],
        radius=shape.radius[None],
        joint_in_parent=_on_the_floor(body, manikin)[None],
        joint_in_child=shape.in_child[None],
        mass=body.mass * volumes(body, shape) / np.maximum(space.volume, 1e-12),
        allowance=_flesh(space, manikin),
        basis_at=values[None, : space.family],
    )
    return with_derived_fields(made, steps=_ENCLOSING_STEPS)


def _on_the_floor(body: Body, manikin: Manikin) -> Floats:
    """(J, 3) [m] joint coordinates in the parents.

    The first joints are raised so that the zero pose stands on the floor.
    """
    in_parent = manikin.shape.in_parent.copy()
    in_parent[body.parent[1:] == 0, 2] -= manikin.lowest()
    return in_parent


def _flesh(space: ShapeSpace, manikin: Manikin) -> Floats:
    """(1, N, N) [m] the allowance for soft flesh.

    It grows by what standing and sitting overlap more than in the unchanged body: a stouter body
    presses more flesh together in postures in which the unchanged one is not in contact.
    """
    body = space.base.body
    more = np.maximum(manikin.overlaps() - space.overlaps, 0.0)
    return np.where(body.adjacent, 0.0, body.allowance + more)


# Check that a changed body is one that people have.
#
# The coefficients of its family must be probable, and no segment may be stretched beyond any person.

_FACTORS = (0.4, 1.8)
_TAPER = 0.45
"""Range of the factors, and greatest taper, for a body without a family."""
_FAMILY_FACTORS = (0.75, 1.33)
_FAMILY_TAPER = 0.25
"""The same for a body of a family. The family has the shapes of people, so stretching only closes
what is left."""
_MAX_DEVIATION = 8.0
"""Standard deviations from the mean, along the least probable direction of the coefficients, beyond
which nobody is."""
_MIN_RADIUS_SHARE = 0.2
"""Least radius of a sphere, as a share of its radius in the unchanged body."""


def check_likely(space: ShapeSpace, values: Floats, manikin: Manikin, measures: Measures) -> None:
    """Refuse a shape that no person has, with the measure that causes it.

    Parameters
    ----------
    space, values
        The shapes of a body, and the parameters (K,) of one.
    manikin
        The body with this shape.
    measures
        Given measures by name [m].

    Raises
    ------
    InputError
        If the shape is improbable, a segment is strained, or a sphere nearly vanishes.
    """
    for error in (_rare(space, values), _strained(space, values), _vanished(space, manikin)):
        if error:
            raise InputError(f"no such person: {error}{_cause(space, measures)}")


def _rare(space: ShapeSpace, values: Floats) -> str:
    """Whether the coefficients of the family are improbable, in words; empty if not."""
    if not space.family:
        return ""
    variance, axes = space.likely
    most = float(np.abs((values - space.neutral)[: space.family] @ axes / np.sqrt(variance)).max())
    if most <= _MAX_DEVIATION:
        return ""
    return f"this mix of measures is {most:.1f} standard deviations from people like {space.base.body.name}"


def _strained(space: ShapeSpace, values: Floats) -> str:
    """The segment whose factors or taper are beyond people's, in words; empty if none."""
    least, greatest = _FAMILY_FACTORS if space.family else _FACTORS
    max_taper = _FAMILY_TAPER if space.family else _TAPER
    table = values[space.family :].reshape(-1, PARAMETERS)
    strain = np.abs(np.log(np.maximum(table[:, :4], 1e-9)))
    group, quantity = divmod(int(np.argmax(strain)), strain.shape[1])
    factor = float(table[group, quantity])
    if not least <= factor <= greatest:
        what = ("depth", "breadth", "length", "girth")[quantity]
        return (
            f"the {_group_name(space, group)}'s {what} would have to change by a factor of {factor:.2f} "
            f"({least:g} to {greatest:g} is possible)"
        )
    group = int(np.argmax(np.abs(table[:, 4])))
    taper = abs(table[group, 4])
    if taper <= max_taper:
        return ""
    return f"the {_group_name(space, group)} would be {taper:.0%} thicker at one end than it is ({max_taper:.0%} is possible)"


def _group_name(space: ShapeSpace, group: int) -> str:
    """The name of a group's segments without their side."""
    first = int(np.flatnonzero(space.groups == group)[0])
    return space.base.body.segment_names[first].removeprefix("left ")


def _vanished(space: ShapeSpace, manikin: Manikin) -> str:
    """The segment that would vanish, in words; empty if none.

    Radii are linear in the parameters, so that they could become zero or negative.
    """
    share = manikin.shape.radius / space.base.shape.radius
    worst = int(np.argmin(share))
    if share[worst] > _MIN_RADIUS_SHARE:
        return ""
    name = space.base.body.segment_names[int(space.base.rig.segment[worst])]
    return f"the {name} would shrink to nothing in one place"


def _cause(space: ShapeSpace, measures: Measures) -> str:
    """The measure that changes the body most against the others, in words; empty for fewer than two.

    The least change that gives all measures has Lagrange multipliers l. A measure whose wanted change
    is b costs b l of it.
    """
    if len(measures) < 2:
        return ""
    found = lengths(space.base, measures)
    rows = np.array([space.row(length) for length in found.values()])
    wanted = np.array([measures[name] - space.base.value(length) for name, length in found.items()])
    multipliers = np.linalg.lstsq(rows @ space.cheap @ rows.T, wanted, rcond=1e-9)[0]
    name = list(measures)[int(np.argmax(multipliers * wanted))]
    return f"; {name} {1000 * measures[name]:.0f} mm does not go with the others"
