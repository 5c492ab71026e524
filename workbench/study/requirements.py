"""What a workplace asks of everybody, one by one: a control, a clearance, the view, the seat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import OF_RULES, Requirement
from workbench.model.arrays import Bools
from workbench.model.criterion import Criterion
from workbench.model.workplace import Workplace
from workbench.study.checks.margins import Asked
from workbench.study.checks.sight import targets_of
from workbench.study.checks.sight_rules import things_of
from workbench.study.checks.table import CHECKS

__all__ = ["asked_of", "sets_of"]


_EACH = {
    "sees": "see",
    "reads": "read",
    "mirror": "ground in",
    "reflection": "no reflection of",
}
"""Checks that ask of each thing by itself, and what each is called."""


def asked_of(place: Workplace) -> tuple[Asked, ...]:
    """The requirements of a workplace in the order of its criteria, each with a name of its own."""
    found: list[Asked] = []
    taken: set[str] = set()
    for one in _all(place):
        name = _free_name(one, taken)
        taken.add(name)
        found.append(replace(one, requirement=replace(one.requirement, name=name)))
    return tuple(found)


def _free_name(one: Asked, taken: set[str]) -> str:
    """The name of a requirement, with what distinguishes it from those before."""
    row = one.requirement
    name = row.name
    if name in taken and one.control is not None:
        name = f"{name} in zone {row.zone}"
    while name in taken:
        name = f"{name} ({row.criterion})" if row.criterion not in name else f"{name} again"
    return name


def _all(place: Workplace) -> Iterator[Asked]:
    controls = {control.name: control for control in place.environment.controls}
    for criterion in place.criteria:
        check = CHECKS.get(criterion.check)
        if check is None or check.margins is None:
            continue
        cases = [k for k, case in enumerate(place.cases) if criterion.asks(case.name)]
        for case in cases:
            lead = f", {place.cases[case].name}" if len(cases) > 1 else ""
            if criterion.check in _EACH:
                of_rule = criterion.check in OF_RULES
                for target in things_of(criterion) if of_rule else targets_of(criterion):
                    words = f"{_EACH[criterion.check]} {target}{lead}"
                    row = Requirement(words, criterion.name, criterion.check, target)
                    yield Asked(row, criterion, None, case)
                continue
            if criterion.check == "force":
                for target in criterion.controls:
                    which = f" on {target}" if len(criterion.controls) > 1 else ""
                    row = Requirement(
                        f"{criterion.name}{which}{lead}", criterion.name, "force", target
                    )
                    yield Asked(row, criterion, None, case)
                continue
            if criterion.check != "reach":
                target = _target(place, criterion, case)
                name = f"{criterion.name}{lead}"
                row = Requirement(name, criterion.name, criterion.check, target)
                yield Asked(row, criterion, None, case)
                continue
            for name in criterion.controls:
                by = f" by the {criterion.hand} hand" if criterion.hand else ""
                zone = criterion.zone or controls[name].zone
                words = f"reach {name}{by}{lead}"
                row = Requirement(words, criterion.name, "reach", name, zone)
                yield Asked(row, criterion, controls[name], case)


def _target(place: Workplace, criterion: Criterion, case: int) -> str:
    """What a requirement is about: a part, several, the point of the eyes, the seat."""
    aims = place.cases[case].aims
    if criterion.check in ("pedals", "preferred_seat"):
        return place.seat or ""
    if criterion.check == "eye_height":
        return (aims.eyes if aims is not None else None) or ""
    if criterion.check == "stops":
        return "joints"
    if criterion.check == "score":
        return criterion.method
    if criterion.check in ("self_contact", "excursion"):
        return "segments"
    if criterion.check == "between_people":
        return ", ".join(beside.role for beside in place.beside)
    if criterion.check in OF_RULES:
        return things_of(criterion)[0]
    if criterion.check == "over_nose" and not criterion.parts:
        return "straight ahead"
    few = len(criterion.parts) <= 3
    return ", ".join(criterion.parts) if few else f"{len(criterion.parts)} parts"


def sets_of(asked: Sequence[Asked], shares: Sequence[Criterion]) -> Bools:
    """The sets of requirements that somebody may meet in a position of the seat of his own.

    Parameters
    ----------
    shares
        The criteria that ask for a share of the people.

    Returns
    -------
    (R, K) array
        The requirements of each set: without each of the R requirements, without those of each
        criterion, and those of each share that the study asks for.
    """
    names = np.array([one.requirement.criterion for one in asked])
    without = ~np.eye(len(asked), dtype=np.bool_)
    criteria = [names != name for name in dict.fromkeys(names.tolist())]
    shared = [
        np.isin(names, criterion.of) if criterion.of else np.ones(len(asked), dtype=np.bool_)
        for criterion in shares
    ]
    return np.column_stack([without, *criteria, *shared])
