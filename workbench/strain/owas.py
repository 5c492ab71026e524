"""OWAS: the Ovako working posture analysing system [1]_.

Back (1 to 4), arms (1 to 3), legs (1 to 7) and load (1 to 3) make a code; a table gives its action
category, 1 to 4. It is not monotone in the legs by design.

References
----------
.. [1] O. Karhu, P. Kansi and I. Kuorinka (1977), Correcting working postures in industry,
   Applied Ergonomics 8, 199-201.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.files.study.rules import rule_set
from workbench.model.arrays import Ints
from workbench.model.criterion import Work
from workbench.model.poses import Placed
from workbench.model.rule_set import RuleSet
from workbench.strain.posture_score import (
    EDGE,
    Part,
    PostureScore,
    flagged,
    posture_score,
    tabled,
)
from workbench.strain.working_angles import WorkingAngles, working_angles

__all__ = ["owas", "owas_table"]

_FIXED = {"sitting": 1, "kneeling": 6, "walking": 7}
"""Codes of the legs that do not depend on the knees."""


def owas(
    placed: Placed | WorkingAngles,
    work: Work | None = None,
    *,
    rules: RuleSet | str = "strain_owas",
) -> PostureScore:
    """Score postures by OWAS.

    Parameters
    ----------
    placed
        P postures in the world, or their angles.
    work
        What a posture cannot say: load and stance. Who stands with one knee bent stands on the
        other leg.
    rules
        The table and thresholds; a rule set, or the name or path of one.

    Returns
    -------
    PostureScore
        Action categories from 1 to 4, alike for both sides: 1 normal, 2 change in near future, 3
        soon, 4 now. The parts are the code.

    Raises
    ------
    InputError
        If the body lacks trunk, head, arms or legs, or a value of the rule set has another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> bent = wb.pose(body, {"LH": {"flexion": 70}, "RH": {"flexion": 70}}, reference="LF")
    >>> found = wb.owas(wb.place(body, bent), wb.Work(load=12))
    >>> found.score.tolist(), [int(part[0, 0]) for part in found.parts.values()]
    ([2], [2, 1, 2, 2])
    """
    values = rule_set(rules)
    angles = placed if isinstance(placed, WorkingAngles) else working_angles(placed)
    work = work or Work()
    stated = work.stated()
    low, high = values.shaped("load_edges", 2)
    load = stated.load or 0.0
    unbanded = np.full(len(angles), np.inf)
    parts = {
        "back": _back(angles, values),
        "arms": _arms(angles, values),
        "legs": _legs(angles, str(stated.stance), values),
        "load": Part(np.full(len(angles), 1 + int(load >= low) + int(load > high)), unbanded),
    }
    category = owas_table({name: part.score for name, part in parts.items()}, rules=values)
    by_side = np.repeat(category[:, None], 2, axis=1)
    return posture_score(
        "OWAS", values, by_side, parts=parts, lowest=1, tables=("table",), work=work
    )


def owas_table(code: dict[str, Ints], *, rules: RuleSet) -> Ints:
    """The action categories of codes (...): back, arms, legs and load, from 1."""
    row = 3 * (code["back"] - 1) + code["arms"] - 1
    return tabled(rules, "table", row, 3 * (code["legs"] - 1) + code["load"] - 1)


def _back(angles: WorkingAngles, rules: RuleSet) -> Part:
    """1 straight, 2 bent, 3 twisted or bent sideways, 4 both."""
    bent = flagged(np.abs(angles.trunk_flexion), rules, "back_bent")
    turned = np.maximum(np.abs(angles.trunk_twist), np.abs(angles.trunk_side))
    sideways = flagged(turned, rules, "back_turned")
    return replace(bent + sideways, score=1 + bent.score + 2 * sideways.score)


def _arms(angles: WorkingAngles, rules: RuleSet) -> Part:
    """1 both below shoulder level, 2 one at it or above, 3 both."""
    level = rules.number("arm_level")
    above = (angles.arm_level >= level - EDGE).sum(axis=1)
    return Part(1 + above, np.abs(angles.arm_level - level).min(axis=1))


def _legs(angles: WorkingAngles, stance: str, rules: RuleSet) -> Part:
    """1 sitting, 2 on two straight legs, 3 on one straight, 4 on two bent, 5 on one bent, 6
    kneeling, 7 walking."""
    if stance in _FIXED:
        return Part(np.full(len(angles), _FIXED[stance]), np.full(len(angles), np.inf))
    knees = flagged(angles.knee, rules, "knee_bent")
    bent = knees.score.sum(axis=1)
    on_one = np.where(bent == 2, 5, 3)
    score = on_one if stance == "one_leg" else np.array([2, 3, 4])[bent]
    return Part(score, knees.distance.min(axis=1))
