"""Check that a changed body is one that people have.

The coefficients of its family must be probable, and no segment may be stretched beyond any person.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.body.scaling.measure import lengths
from workbench.body.scaling.space import ShapeSpace
from workbench.body.scaling.stretch import PARAMETERS
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["check_likely"]

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

Measures = Mapping[str, float]


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
