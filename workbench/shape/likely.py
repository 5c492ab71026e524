"""Whether a change of a body is one that people have: a family's coefficients within what is likely, no segment
stretched beyond any person."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.shape.manikin import Length
from workbench.shape.space import ShapeSpace
from workbench.shape.stretch import KNOBS

__all__ = ["check_likely"]

FACTORS, TAPER = (0.4, 1.8), 0.45
"""How far a body of no family may be stretched."""
CLOSED, CLOSED_TAPER = (0.75, 1.33), 0.25
"""How far a body of a family may be: its family has the shapes of people, stretching closes what is left."""
RAREST = 8.0
"""Standard deviations, along the most unlikely direction of the coefficients, beyond which nobody is."""

Given = Mapping[str, tuple[Length, float]]


def check_likely(space: ShapeSpace, values: Floats, given: Given) -> None:
    """InputError where the knobs (K,) make no person, with what is strained most and the measure that causes it.

    given: each measure as a length on the unchanged body, and its wanted value [m].
    """
    faults = [fault for fault in (_rare(space, values), _strained(space, values), _vanished(space, values)) if fault]
    if faults:
        raise InputError(f"no such person: {faults[0]}{_cause(space, values, given)}")


def _rare(space: ShapeSpace, values: Floats) -> str:
    """The direction of the family's coefficients in which this body is farthest from people like the first one."""
    if not space.family:
        return ""
    off = (values - space.neutral)[: space.family]
    inverse, axes = np.linalg.eigh(space.price[: space.family, : space.family])
    most = float(np.abs(np.sqrt(inverse) * (off @ axes)).max())
    if most <= RAREST:
        return ""
    return f"this mix of measures is {most:.1f} standard deviations from people like {space.base.body.name}"


def _strained(space: ShapeSpace, values: Floats) -> str:
    """A segment that would have to be less than half or nearly twice itself is no person's."""
    body, groups = space.base.body, space.groups
    (least, greatest), bend = (CLOSED, CLOSED_TAPER) if space.family else (FACTORS, TAPER)
    table = values[space.family :].reshape(-1, KNOBS)
    strain = np.abs(np.log(np.maximum(table[:, :4], 1e-9)))
    group, way = np.unravel_index(int(np.argmax(strain)), strain.shape)
    factor = float(table[group, way])
    if not least <= factor <= greatest:
        name = body.segment_names[int(np.flatnonzero(groups == group)[0])].removeprefix("left ")
        what = ("depth", "breadth", "length", "girth")[way]
        return (f"the {name}'s {what} would have to change by a factor of {factor:.2f} "
                f"({least:g} to {greatest:g} is possible)")  # fmt: skip
    most = int(np.argmax(np.abs(table[:, 4])))
    if abs(table[most, 4]) > bend:
        name = body.segment_names[int(np.flatnonzero(groups == most)[0])].removeprefix("left ")
        return f"the {name} would be {abs(table[most, 4]):.0%} thicker at one end than it is ({bend:.0%} is possible)"
    return ""


def _vanished(space: ShapeSpace, values: Floats) -> str:
    """Radii are linear in the knobs, so far out they could fall to nothing."""
    radius = space.shape(values).radius
    worst = int(np.argmin(radius / space.base.shape.radius))
    if radius[worst] > 0.2 * space.base.shape.radius[worst]:
        return ""
    name = space.base.body.segment_names[int(space.base.rig.segment[worst])]
    return f"the {name} would shrink to nothing in one place"


def _cause(space: ShapeSpace, values: Floats, given: Given) -> str:
    """The measure whose change costs most, being held against the others: b_i lambda_i of the least change."""
    if len(given) < 2:
        return ""
    rows = np.array([space.row(length) for length, _ in given.values()])
    wanted = np.array([value - space.base.value(length) for length, value in given.values()])
    system = rows @ space.cheap @ rows.T
    pull = np.linalg.lstsq(system, wanted, rcond=1e-9)[0]
    name = list(given)[int(np.argmax(pull * wanted))]
    return f"; {name} {1000 * given[name][1]:.0f} mm does not go with the others"
