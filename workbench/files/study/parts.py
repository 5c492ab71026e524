"""What of a study file can be read, even where something in it is wrong.

A fault in one criterion must not hide a wrong name in another one. So each role, posture, action,
criterion and so on is read by itself: keys that are wrong in form are left out of it, and where
nothing sensible is left it is None.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from pydantic import ValidationError

from workbench.errors import InputError
from workbench.files.crash.simulation_schema import ContactFile
from workbench.files.schema import FileModel, metres_in, validate
from workbench.files.study.schema import (
    ActionFile,
    ChangeFile,
    CriterionFile,
    EnvelopeFile,
    MapFile,
    MovedFile,
    RoleFile,
    SharesFile,
    SignalsFile,
    StudyFile,
    StudyPostureFile,
)
from workbench.files.yaml_text import Document
from workbench.model.environment import Environment

__all__ = ["CaseParts", "StudyParts", "read_parts"]

Model = TypeVar("Model", bound=FileModel)


@dataclass(frozen=True)
class CaseParts:
    """A case: its name, and the actions that can be read by role."""

    name: str
    actions: dict[str, ActionFile | None]

    @property
    def moves(self) -> bool:
        """Whether any action is a motion."""
        return any(action is not None and action.moves for action in self.actions.values())


@dataclass
class StudyParts:
    """The parts of a study file that can be read.

    Of lists there are pairs of a row number and what stands there. file: the whole file, None where
    anything in it is wrong in form. people_whole: whether roles and cases are right in form;
    criteria_whole: the rows of the criteria that are. What roles, cases or criteria lack can be
    said only of those.
    """

    file: StudyFile | None
    people_whole: bool = True
    criteria_whole: frozenset[int] = frozenset()
    environment: str | Environment | None = None
    roles: dict[str, RoleFile | None] = field(default_factory=dict)
    postures: dict[str, StudyPostureFile | None] = field(default_factory=dict)
    cases: list[tuple[int, CaseParts]] = field(default_factory=list)
    criteria: list[tuple[int, CriterionFile]] = field(default_factory=list)
    criterion_names: list[tuple[int, str]] = field(default_factory=list)
    shares: SharesFile | None = None
    moved: list[tuple[int, MovedFile]] = field(default_factory=list)
    maps: list[tuple[int, MapFile]] = field(default_factory=list)
    envelopes: list[tuple[int, EnvelopeFile]] = field(default_factory=list)
    changes: list[tuple[int, ChangeFile]] = field(default_factory=list)
    compare: list[str] | None = None
    signals: SignalsFile | None = None
    forces: list[tuple[int, ContactFile]] = field(default_factory=list)

    @property
    def crowd(self) -> str | None:
        """The role that a population takes, None where there is none."""
        roles = self.roles.items()
        return next((name for name, role in roles if role and role.population is not None), None)

    @property
    def moves(self) -> bool:
        """Whether any action is a motion."""
        return any(case.moves for _, case in self.cases)

    @property
    def case_names(self) -> list[str]:
        """The names of the cases, in the order of the file."""
        return [case.name for _, case in self.cases]


def read_parts(document: Document) -> tuple[StudyParts, list[str]]:
    """Read the parts of a study file, and a line for each fault of its form.

    Raises
    ------
    InputError
        Where the file is no mapping at all.
    """
    faults: list[str] = []
    file = None
    try:
        file = validate(document, StudyFile)
    except InputError as error:
        faults = list(error.problems)
    if not isinstance(document.value, dict):
        raise InputError(faults)
    return _readable(file, document.value), faults


def _readable(file: StudyFile | None, value: dict[Any, Any]) -> StudyParts:
    """The parts of a mapping that can be read. file: the whole of it, where it has no fault."""
    unit = value.get("length")
    metres = metres_in.get(unit, 0.001) if isinstance(unit, str) else 0.001
    take = _Reading({"metres": metres})
    people = _Reading({"metres": metres})
    criteria = _Reading({"metres": metres})
    environment = value.get("environment")
    parts = StudyParts(
        file=file,
        environment=_environment(environment),
        roles={name: people.one(RoleFile, role) for name, role in _mapping(value.get("people"))},
        postures={
            name: take.one(StudyPostureFile, posture)
            for name, posture in _mapping(value.get("postures"))
        },
        cases=[
            (row, CaseParts(case["name"], people.actions(case.get("people"))))
            for row, case in _named(value.get("cases"))
        ],
        criteria=criteria.rows(CriterionFile, value.get("criteria")),
        criterion_names=[(row, entry["name"]) for row, entry in _named(value.get("criteria"))],
        moved=take.rows(MovedFile, value.get("moved")),
        shares=take.one(SharesFile, value.get("shares")),
        maps=take.rows(MapFile, value.get("reach_maps")),
        envelopes=take.rows(EnvelopeFile, value.get("reach_envelopes")),
        changes=take.rows(ChangeFile, value.get("changes")),
        compare=_names(value.get("compare")),
        signals=take.one(SignalsFile, value.get("signals")),
        forces=take.rows(ContactFile, value.get("contact_forces")),
    )
    parts.people_whole = not people.pruned and _has_all_cases(parts, value.get("cases"))
    rows = {row for row, _ in parts.criteria}
    parts.criteria_whole = frozenset(rows - set(criteria.pruned))
    return parts


def _environment(value: Any) -> str | Environment | None:
    """An environment or its name; None where it is anything else."""
    named = isinstance(value, str) and value
    return value if named or isinstance(value, Environment) else None


def _has_all_cases(parts: StudyParts, cases: Any) -> bool:
    """Whether there are roles, and every case of the file could be read and has an action."""
    return (
        isinstance(cases, list)
        and len(parts.cases) == len(cases) > 0
        and len(parts.roles) > 0
        and all(case.actions for _, case in parts.cases)
    )


@dataclass(frozen=True)
class _Reading:
    """Reads parts by their models. pruned: the rows (0 where there are none) of those that something
    was left out of."""

    context: Mapping[str, float]
    pruned: list[int] = field(default_factory=list)

    def one(self, model: type[Model], value: Any, row: int = 0) -> Model | None:
        """A part without the keys that are wrong in form; None where no such part is left."""
        given = dict(value) if isinstance(value, dict) else None
        if given is None:
            self.pruned.append(row)
        while given is not None:
            try:
                return model.model_validate(given, context=dict(self.context))
            except ValidationError as error:
                self.pruned.append(row)
                wrong = {fault["loc"][0] if fault["loc"] else None for fault in error.errors()}
                if not wrong <= set(given):
                    return None
                given = {key: kept for key, kept in given.items() if key not in wrong}
        return None

    def rows(self, model: type[Model], value: Any) -> list[tuple[int, Model]]:
        """The rows of a list that can be read, with their numbers."""
        found = ((row, self.one(model, entry, row)) for row, entry in _mappings(value))
        return [(row, part) for row, part in found if part is not None]

    def actions(self, value: Any) -> dict[str, ActionFile | None]:
        """The actions of a case by role."""
        return {name: self.one(ActionFile, action) for name, action in _mapping(value)}


def _mapping(value: Any) -> list[tuple[str, Any]]:
    return list(value.items()) if isinstance(value, dict) else []


def _mappings(value: Any) -> list[tuple[int, dict[str, Any]]]:
    """The mappings in a list, with their rows."""
    rows = enumerate(value) if isinstance(value, list) else ()
    return [(row, entry) for row, entry in rows if isinstance(entry, dict)]


def _named(value: Any) -> list[tuple[int, dict[str, Any]]]:
    """The mappings in a list that have a name, with their rows."""
    return [(row, entry) for row, entry in _mappings(value) if isinstance(entry.get("name"), str)]


def _names(value: Any) -> list[str] | None:
    """A list of names; None where it is anything else."""
    whole = isinstance(value, list) and all(isinstance(name, str) for name in value)
    return list(value) if whole else None
