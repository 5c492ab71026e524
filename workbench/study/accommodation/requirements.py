"""What an accommodation study asks of everybody, one by one: a control, a clearance, the view, the
seat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.accommodation import AccommodationStudy, Requirement
from workbench.model.arrays import Bools
from workbench.model.criterion import Criterion
from workbench.model.environment import Control

__all__ = ["Asked", "asked_of", "sets_of"]


@dataclass(frozen=True)
class Asked:
    """A requirement with the criterion it belongs to, and of a reach the control."""

    requirement: Requirement
    criterion: Criterion
    control: Control | None = None


def asked_of(study: AccommodationStudy) -> tuple[Asked, ...]:
    """The requirements of a study in the order of its criteria, each with a name of its own."""
    found: list[Asked] = []
    taken: set[str] = set()
    for one in _all(study):
        name = one.requirement.name
        row = one.requirement
        if name in taken and one.control is not None:
            name = f"{name} in zone {row.zone}"
        while name in taken:
            name = f"{name} ({row.criterion})" if row.criterion not in name else f"{name} again"
        taken.add(name)
        found.append(
            Asked(
                Requirement(name, row.criterion, row.check, row.target, row.zone),
                one.criterion,
                one.control,
            )
        )
    return tuple(found)


def _all(study: AccommodationStudy) -> Iterator[Asked]:
    controls = {control.name: control for control in study.environment.controls}
    for criterion in study.criteria:
        if criterion.check != "reach":
            row = Requirement(
                criterion.name, criterion.name, criterion.check, _target(study, criterion)
            )
            yield Asked(row, criterion)
            continue
        for name in criterion.controls:
            by = f" by the {criterion.hand} hand" if criterion.hand else ""
            zone = criterion.zone or controls[name].zone
            row = Requirement(f"reach {name}{by}", criterion.name, "reach", name, zone)
            yield Asked(row, criterion, controls[name])


def _target(study: AccommodationStudy, criterion: Criterion) -> str:
    """What a requirement is about: a part, several, the point of the eyes, the seat."""
    if criterion.check in ("pedals", "preferred_seat"):
        return study.seat
    if criterion.check == "eye_height":
        return study.aims.eyes or ""
    if criterion.check == "stops":
        return "joints"
    if criterion.check == "self_contact":
        return "segments"
    return (
        ", ".join(criterion.parts) if len(criterion.parts) <= 3 else f"{len(criterion.parts)} parts"
    )


def sets_of(study: AccommodationStudy, asked: Sequence[Asked]) -> Bools:
    """The sets of requirements that somebody may meet in a position of the seat of his own.

    Returns
    -------
    (R, K) array
        The requirements of each set: without each of the R requirements, without those of each
        criterion, and those of each share that the study asks for.
    """
    names = np.array([one.requirement.criterion for one in asked])
    without = ~np.eye(len(asked), dtype=np.bool_)
    criteria = [names != name for name in dict.fromkeys(names.tolist())]
    shares = [
        np.isin(names, criterion.of) if criterion.of else np.ones(len(asked), dtype=np.bool_)
        for criterion in study.share_criteria
    ]
    return np.column_stack([without, *criteria, *shares])
