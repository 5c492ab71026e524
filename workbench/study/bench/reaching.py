"""How far a hand reaches all around in a state of an open study."""

from __future__ import annotations

from workbench.errors import InputError
from workbench.model.envelope import Envelope, ReachTask
from workbench.posture.reaching.limbs import HANDS
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study
from workbench.study.envelope.envelope import situation_envelope
from workbench.study.people import present_people

__all__ = ["check_reach", "state_envelope"]


def check_reach(opened: OpenStudy, arrangement: Arrangement, task: ReachTask) -> None:
    """InputError where a state has no such person, or the body no such hand."""
    body = opened.body(arrangement.row(task.person))
    side = task.limb[0].upper()
    if task.limb not in HANDS or f"{side}HN" not in body.segments:
        raise InputError(f"a hand of {task.person} is needed, got {task.limb!r}")


def state_envelope(opened: OpenStudy, arrangement: Arrangement, task: ReachTask) -> Envelope:
    """Find the reach envelope of a hand of a state as a run of its study does; it takes seconds.

    Parameters
    ----------
    task
        Its case is one of the postures.

    Raises
    ------
    InputError
        As `check_reach`, or where the body lacks the landmarks of the grip.
    """
    check_reach(opened, arrangement, task)
    there = present_people(arranged_study(opened, arrangement), opened.occupants)
    situation = there.situations[arrangement.row(task.person)][task.case]
    return situation_envelope(situation, task)
