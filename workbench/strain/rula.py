"""RULA: rapid upper limb assessment [1]_.

The arm and wrist of each side (table A) and neck, trunk and legs (table B) are scored by bands of
angles, muscle use and force are added, and table C gives the grand score, 1 to 7. Each side is
scored alone; the worse one counts.

References
----------
.. [1] L. McAtamney and E. N. Corlett (1993), RULA: a survey method for the investigation of
   work-related upper limb disorders, Applied Ergonomics 24, 91-99.
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
    EDGE,
    Part,
    PostureScore,
    banded,
    flagged,
    posture_score,
    tabled,
    upper_arm,
)
from workbench.strain.working_angles import WorkingAngles, working_angles

__all__ = ["rula", "rula_tables"]


def rula(
    placed: Placed | WorkingAngles,
    work: Work | None = None,
    *,
    rules: RuleSet | str = "strain_rula",
) -> PostureScore:
    """Score postures by RULA.

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
        Grand scores from 1 to 7, and action levels: 1 acceptable, 2 investigate, 3 change soon, 4
        now.

    Raises
    ------
    InputError
        If the body lacks trunk, head, arms or legs, or a value of the rule set has another shape.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> posed = wb.pose(body, {"RS": {"flexion": 60}, "RE": {"flexion": 80}, "NP": {"flexion": 15}})
    >>> found = wb.rula(wb.place(body, posed), wb.Work(load=0.5, static=True))
    >>> found.by_side.tolist(), found.score.tolist(), found.level.tolist()
    ([[3, 3]], [3], [2])
    """
    values = rule_set(rules)
    angles = placed if isinstance(placed, WorkingAngles) else working_angles(placed)
    work = work or Work()
    stated = work.stated()
    parts = _parts(angles, stated, values)
    tables = rula_tables(
        {name: part.score for name, part in parts.items()},
        muscle=int(bool(stated.static or stated.repeated)),
        force=_force(stated, values),
        rules=values,
    )
    found = posture_score(
        "RULA",
        values,
        tables["grand"],
        parts={**parts, **tables},
        lowest=1,
        tables=("table_a", "table_b", "table_c"),
        work=work,
    )
    if np.array_equal(values["table_a"], values["table_a_worksheet"]):
        early = f"{found.version}; table A of an early worksheet, not the published one"
        return replace(found, version=early)
    return found


def rula_tables(
    parts: dict[str, Ints], *, muscle: int, force: int, rules: RuleSet
) -> dict[str, Ints]:
    """The scores of tables A and B, the same with muscle use and force (C and D of the paper), and
    the grand score.

    Parameters
    ----------
    parts
        Scores (..., 2) or (...) of upper_arm, lower_arm, wrist, twist, neck, trunk and legs, from 1.
    muscle, force
        What is added to both tables.
    """
    trunk, legs, neck = (_column(parts[name]) for name in ("trunk", "legs", "neck"))
    arm = 3 * (np.minimum(parts["upper_arm"], 6) - 1) + np.minimum(parts["lower_arm"], 3) - 1
    hand = 2 * (np.minimum(parts["wrist"], 4) - 1) + parts["twist"] - 1
    a = tabled(rules, "table_a", arm, hand)
    b = tabled(rules, "table_b", neck - 1, 2 * (np.minimum(trunk, 6) - 1) + legs - 1)
    c, d = a + muscle + force, b + muscle + force
    grand = tabled(rules, "table_c", c - 1, d - 1)
    return {"A": a, "B": b, "C": c, "D": d, "grand": grand}


def _column(score: Ints) -> Ints:
    """(P, 1) of scores (P,) that both sides share."""
    return score[:, None] if score.ndim == 1 else score


def _parts(angles: WorkingAngles, work: Work, rules: RuleSet) -> dict[str, Part]:
    """The scores of the parts of the body."""
    beside = flagged(angles.forearm_out, rules, "out_to_side")
    beside = replace(beside, score=np.maximum(beside.score, angles.across))
    wrist = banded(np.abs(angles.wrist_bend), rules, "wrist")
    twist = flagged(np.abs(angles.forearm_twist), rules, "twist_end")
    neck = banded(angles.neck_flexion, rules, "neck")
    neck += _turned(angles.neck_twist, angles.neck_side, rules)
    sideways = _turned(angles.trunk_twist, angles.trunk_side, rules)
    legs = np.full(len(angles), 1 if work.legs_balanced else 2)
    return {
        "upper_arm": upper_arm(angles, work, rules),
        "lower_arm": banded(angles.elbow, rules, "lower_arm") + beside,
        "wrist": wrist + flagged(np.abs(angles.wrist_deviation), rules, "wrist_deviated"),
        "twist": replace(twist, score=1 + twist.score),
        "neck": neck,
        "trunk": _trunk(angles, work, rules) + sideways,
        "legs": Part(legs, np.full(len(angles), np.inf)),
    }


def _turned(twist: Floats, side: Floats, rules: RuleSet) -> Part:
    """1 for a twist and 1 for a side bend."""
    return flagged(np.abs(twist), rules, "twisted") + flagged(np.abs(side), rules, "side_bent")


def _trunk(angles: WorkingAngles, work: Work, rules: RuleSet) -> Part:
    """1 for a trunk that a seat back carries well, with hips as open as that takes; else by bands."""
    trunk = banded(angles.trunk_flexion, rules, "trunk")
    if not work.trunk_supported:
        return trunk
    hip = angles.hip_trunk.min(axis=1)
    limit = rules.number("trunk_supported_hip")
    open_hips = hip >= limit - EDGE
    return Part(
        np.where(open_hips, 1, trunk.score),
        np.minimum(np.abs(hip - limit), np.where(open_hips, np.inf, trunk.distance)),
    )


def _force(work: Work, rules: RuleSet) -> int:
    """0 below the first load now and then, 1 to the second, 2 if static or repeated or beyond it,
    3 if both, or with a shock."""
    low, high = rules.shaped("load_edges", 2)
    often = bool(work.static or work.repeated)
    load = work.load or 0.0
    if work.shock:
        return 3
    if load < low:
        return 0
    return (2 if load > high else 1) + int(often)
