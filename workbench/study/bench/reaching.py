"""How far a hand reaches all around in a state of an open study."""

from __future__ import annotations

from workbench.errors import InputError
from workbench.model.envelope import ReachTask
from workbench.posture.reaching.limbs import HANDS
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study
from workbench.study.people import present_people
from workbench.study.situation import Situation

__all__ = ["check_reach", "reaching_situation"]


def check_reach(opened: OpenStudy, arrangement: Arrangement, task: ReachTask) -> None:
    """InputError where a state has no such person, or the body no such hand."""
    body = arrangement.body(arrangement.row(task.person))
    side = task.limb[0].upper()
    if task.limb not in HANDS or f"{side}HN" not in body.segments:
        raise InputError(f"a hand of {task.person} is needed, got {task.limb!r}")


def reaching_situation(opened: OpenStudy, arrangement: Arrangement, task: ReachTask) -> Situation:
    """Where somebody is who reaches, as in a run of a state's study; then `situation_envelope`.

    Parameters
    ----------
    task
        Its case is one of the postures.

    Raises
    ------
    InputError
        As `check_reach`.
    """
    check_reach(opened, arrangement, task)
    there = present_people(arranged_study(opened, arrangement), arrangement.occupants)
    return there.situations[arrangement.row(task.person)][task.case]
