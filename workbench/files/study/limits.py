"""What the format can say and no run can answer yet: refused in one line each, never ignored."""

from __future__ import annotations

from workbench.files.study.work import Work

__all__ = ["limit_faults"]


def limit_faults(work: Work) -> None:
    """Report what cannot be run yet, and what can be asked instead."""
    roles = {name: role for name, role in work.parts.roles.items() if role is not None}
    crowd = work.parts.crowd
    if crowd is not None:
        _crowd_faults(work, crowd)
    if work.parts.moves:
        _motion_faults(work)
    for row, task in work.parts.maps:
        if task.people in roles and task.people != crowd:
            what = "a reach map is of a population; ask for 'reach_envelopes' of one person"
            work.fault(("reach_maps", row, "people"), what)


def _crowd_faults(work: Work, name: str) -> None:
    """A population takes a role in postures, and its answers are shares."""
    if work.parts.moves:
        what = "a population does not move yet: give one 'size' for a motion"
        work.fault(("people", name, "population"), what)
    for row, task in work.parts.envelopes:
        if task.people == name:
            what = "an envelope is of one person; ask for 'reach_maps' of a population"
            work.fault(("reach_envelopes", row, "people"), what)


def _motion_faults(work: Work) -> None:
    """In one case all roles move, or none does."""
    for row, case in work.parts.cases:
        moving = {name for name, action in case.actions.items() if action and action.moves}
        for name, action in case.actions.items():
            if moving and action is not None and not action.moves:
                what = (
                    f"{sorted(moving)[0]!r} moves in this case, so this role needs a motion too; "
                    "postures stand in cases of their own"
                )
                work.fault(("cases", row, "people", name), what)
