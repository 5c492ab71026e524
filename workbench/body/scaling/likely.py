"""Whether a change of a body is one that people have: a family's coefficients within what is
likely, no segment stretched beyond any person."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.body.scaling.manikin import Manikin
from workbench.body.scaling.measure import lengths
from workbench.body.scaling.space import ShapeSpace
from workbench.body.scaling.stretch import KNOBS
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["check_likely"]

FACTORS = (0.4, 1.8)
TAPER = 0.45
"""How far a body of no family may be stretched."""
CLOSED = (0.75, 1.33)
CLOSED_TAPER = 0.25
"""How far a body of a family may be: its family has the shapes of people, stretching closes what is
left."""
RAREST = 8.0
"""Standard deviations, along the most unlikely direction of the coefficients, beyond which nobody
is."""
SMALLEST = 0.2
"""Share of its own radius that no sphere falls below."""

Measures = Mapping[str, float]


def check_likely(space: ShapeSpace, values: Floats, manikin: Manikin, measures: Measures) -> None:
    """InputError where the knobs (K,) make no person, with what is strained most and the measure
    that causes it.

    manikin: the body with these knobs; measures [m]: the given ones.
    """
    for fault in (_rare(space, values), _strained(space, values), _vanished(space, manikin)):
        if fault:
            raise InputError(f"no such person: {fault}{_cause(space, measures)}")


def _rare(space: ShapeSpace, values: Floats) -> str:
    """The direction of the family's coefficients in which this body is farthest from people like
    the first one."""
    if not space.family:
        return ""
    variance, axes = space.likely
    most = float(np.abs((values - space.neutral)[: space.family] @ axes / np.sqrt(variance)).max())
    if most <= RAREST:
        return ""
    return f"this mix of measures is {most:.1f} standard deviations from people like {space.base.body.name}"


def _strained(space: ShapeSpace, values: Floats) -> str:
    """A segment that would have to be less than half or nearly twice itself is no person's."""
    body = space.base.body
    groups = space.groups
    (least, greatest), bend = (CLOSED, CLOSED_TAPER) if space.family else (FACTORS, TAPER)
    table = values[space.family :].reshape(-1, KNOBS)
    strain = np.abs(np.log(np.maximum(table[:, :4], 1e-9)))
    group, way = np.unravel_index(int(np.argmax(strain)), strain.shape)
    factor = float(table[group, way])
    if not least <= factor <= greatest:
        name = body.segment_names[int(np.flatnonzero(groups == group)[0])].removeprefix("left ")
        what = ("depth", "breadth", "length", "girth")[way]
        return (
            f"the {name}'s {what} would have to change by a factor of {factor:.2f} "
            f"({least:g} to {greatest:g} is possible)"
        )
    most = int(np.argmax(np.abs(table[:, 4])))
    if abs(table[most, 4]) > bend:
        name = body.segment_names[int(np.flatnonzero(groups == most)[0])].removeprefix("left ")
        return f"the {name} would be {abs(table[most, 4]):.0%} thicker at one end than it is ({bend:.0%} is possible)"
    return ""


def _vanished(space: ShapeSpace, manikin: Manikin) -> str:
    """Radii are linear in the knobs, so far out they could fall to nothing."""
    share = manikin.shape.radius / space.base.shape.radius
    worst = int(np.argmin(share))
    if share[worst] > SMALLEST:
        return ""
    name = space.base.body.segment_names[int(space.base.rig.segment[worst])]
    return f"the {name} would shrink to nothing in one place"


def _cause(space: ShapeSpace, measures: Measures) -> str:
    """The measure whose change costs most, being held against the others: b_i lambda_i of the least
    change."""
    if len(measures) < 2:
        return ""
    found = lengths(space.base, measures)
    rows = np.array([space.row(length) for length in found.values()])
    wanted = np.array([measures[name] - space.base.value(length) for name, length in found.items()])
    pull = np.linalg.lstsq(rows @ space.cheap @ rows.T, wanted, rcond=1e-9)[0]
    name = list(measures)[int(np.argmax(pull * wanted))]
    return f"; {name} {1000 * measures[name]:.0f} mm does not go with the others"
