"""REBA: rapid entire body assessment [1]_.

Trunk, neck and legs (table A, with the load) and the arm of each side (table B, with the coupling)
are scored by bands of angles; table C and what the activity adds give the score, 1 to 15. Each side
is scored alone; the worse one counts. Rotation of the upper arm does not count here, abduction does.

References
----------
.. [1] S. Hignett and L. McAtamney (2000), Rapid entire body assessment (REBA), Applied Ergonomics
   31, 201-205.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.files.study.rules import rule_set
from workbench.model.arrays import Floats, Ints
from workbench.model.criterion import Work
from workbench.model.poses import Placed
from workbench.model.rule_set import RuleSet
from workbench.strain.posture_score import (
    Part,
    PostureScore,
    banded,
    flagged,
    posture_score,
    tabled,
    upper_arm,
)
from workbench.strain.working_angles import WorkingAngles, working_angles

__all__ = ["reba", "reba_tables"]

_COUPLING = ("good", "fair", "poor", "unacceptable")


def reba(
    placed: Placed | WorkingAngles,
    work: Work | None = None,
    *,
    rules: RuleSet | str = "strain_reba",
) -> PostureScore:
    """Score postures by REBA.

    Parameters
    ----------
    placed
        P postures in the world, or their angles.
    work
        What a posture cannot say.
    rules
        The tables and bands; a rule set, or the name or path of one.

    Returns
    -------
    PostureScore
        Scores from 1 to 15, and action levels: 0 none needed, 1 may be, 2 needed, 3 soon, 4 now.

    Raises
    ------
    InputError
        If the body lacks trunk, head, arms or legs, or a value of the rule set has another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> bent = wb.pose(body, {"LH": {"flexion": 70}, "RH": {"flexion": 70}}, reference="LF")
    >>> found = wb.reba(wb.place(body, bent), wb.Work(load=12, stance="standing"))
    >>> found.score.tolist(), found.level.tolist()
    ([4], [2])
    """
    values = rule_set(rules)
    angles = placed if isinstance(placed, WorkingAngles) else working_angles(placed)
    work = work or Work()
    stated = work.stated()
    low, high = values.shaped("load_edges", 2)
    load = stated.load or 0.0
    parts = _parts(angles, stated, values)
    tables = reba_tables(
        {name: part.score for name, part in parts.items()},
        load=int(load >= low) + int(load > high) + int(bool(stated.shock)),
        coupling=_COUPLING.index(stated.coupling or "good"),
        activity=sum(bool(one) for one in (stated.static, stated.repeated, stated.rapid)),
        rules=values,
    )
    return posture_score(
        "REBA",
        values,
        tables["score"],
        parts={**parts, **tables},
        lowest=0,
        tables=("table_a", "table_b", "table_c"),
        work=work,
    )


def reba_tables(
    parts: dict[str, Ints], *, load: int, coupling: int, activity: int, rules: RuleSet
) -> dict[str, Ints]:
    """Score A with the load, score B with the coupling, score C, and the score with the activity.

    Parameters
    ----------
    parts
        Scores (..., 2) or (...) of trunk, neck, legs, upper_arm, lower_arm and wrist, from 1.
    load, coupling, activity
        What is added to A, to B and to C.
    """
    trunk, neck, legs = (parts[name] for name in ("trunk", "neck", "legs"))
    row = 3 * (np.minimum(trunk, 5) - 1) + np.minimum(neck, 3) - 1
    a = tabled(rules, "table_a", row, legs - 1) + load
    arm = 2 * (np.minimum(parts["upper_arm"], 6) - 1) + parts["lower_arm"] - 1
    b = tabled(rules, "table_b", arm, parts["wrist"] - 1) + coupling
    a = a[:, None] if a.ndim < b.ndim else a
    c = tabled(rules, "table_c", a - 1, b - 1)
    return {"A": a, "B": b, "C": c, "score": c + activity}


def _parts(angles: WorkingAngles, work: Work, rules: RuleSet) -> dict[str, Part]:
    """The scores of the parts of the body."""
    away = _either(
        flagged(np.abs(angles.wrist_deviation), rules, "wrist_deviated"),
        flagged(np.abs(angles.forearm_twist), rules, "twist_end"),
    )
    return {
        "trunk": banded(angles.trunk_flexion, rules, "trunk")
        + _turned(angles.trunk_twist, angles.trunk_side, rules),
        "neck": banded(angles.neck_flexion, rules, "neck")
        + _turned(angles.neck_twist, angles.neck_side, rules),
        "legs": _legs(angles, work, rules),
        "upper_arm": upper_arm(angles, work, rules),
        "lower_arm": banded(angles.elbow, rules, "lower_arm"),
        "wrist": banded(np.abs(angles.wrist_bend), rules, "wrist") + away,
    }


def _turned(twist: Floats, side: Floats, rules: RuleSet) -> Part:
    """1 for a twist, a side bend or both."""
    return _either(
        flagged(np.abs(twist), rules, "twisted"), flagged(np.abs(side), rules, "side_bent")
    )


def _either(one: Part, other: Part) -> Part:
    """1 where one or the other or both are."""
    return Part(np.maximum(one.score, other.score), np.minimum(one.distance, other.distance))


def _legs(angles: WorkingAngles, work: Work, rules: RuleSet) -> Part:
    """1 on both legs, sitting or walking, 2 on one; and what the more bent knee adds, not sitting."""
    one_leg = work.stance == "one_leg" or not work.legs_balanced
    base = np.full(len(angles), 2 if one_leg else 1)
    if work.stance == "sitting":
        return Part(base, np.full(len(angles), np.inf))
    knee = banded(angles.knee.max(axis=1), rules, "knee")
    return replace(knee, score=base + knee.score)
