"""State a study in Python: what a call says goes the way of a study's file, so that one check serves
both."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, UsageError, has_controls, one_of
from workbench.files.bare_mesh import (
    environment_of_scene,
    is_place,
    load_environment,
)
from workbench.files.meshes.scene import is_scene
from workbench.files.names import matching
from workbench.files.schema import CallFloat, CallInt, plausible, to_metres
from workbench.files.study.doubts import far_words
from workbench.files.study.moves import riding_words
from workbench.files.study.reader import read_study
from workbench.files.yaml_text import Document
from workbench.model.arguments import caller_level, given_words
from workbench.model.environment import Environment
from workbench.model.study import Study
from workbench.model.surroundings import Move, displaced

__all__ = ["changed_study", "moved_environment", "moved_kind", "study"]

_CALL = "study(...)"
_CHANGE = "study.with_(...)"
"""What messages call the two calls, in the place of a file."""
_NAMED = ("cases", "criteria", "changes")
"""Keys whose lists are of named things, which a call may give as a mapping of the names."""
_DEEPEST = 60
"""How deep mappings and lists may be nested: no key of a study is as deep."""
_MARKED: Mapping[type, Callable[[Any], Any]] = {int: CallInt, float: CallFloat}


def study(
    environment: Environment | str | Path,
    *,
    people: Mapping[str, Any],
    cases: Mapping[str, Any] | Sequence[Any],
    criteria: Mapping[str, Any] | Sequence[Any],
    name: str = "study",
    title: str = "",
    description: str = "",
    postures: Mapping[str, Any] | None = None,
    moved: Mapping[str, Any] | Sequence[Any] | None = None,
    shares: Mapping[str, Any] | None = None,
    reach_maps: Sequence[Any] | None = None,
    reach_envelopes: Sequence[Any] | None = None,
    changes: Mapping[str, Any] | Sequence[Any] | None = None,
    compare: Sequence[str] | None = None,
    signals: Mapping[str, Any] | None = None,
    contact_forces: Sequence[Any] | None = None,
) -> Study:
    """Make a study without a file.

    The arguments are the keys of a study's file (docs/studies.md), with the same checks. Lengths are
    numbers [m] or texts with their unit ("20 mm"); angles are degrees. Arrays, tuples and paths are
    as good as lists and texts. Names of files are looked for from the current folder.

    Parameters
    ----------
    environment
        Where it takes place: an environment, a name of the catalogue, or a path; of a mesh axes and
        unit are guessed, see `load_environment`.
    people
        The roles by name. A `body` may also be a Body, with the postures of the body file of its
        name; a `population` what `draw_people` or `read_ansur` returns.
    cases, criteria
        What everybody does, and what must hold: lists as in a file, or mappings of their names.
    name
        Of the study.
    moved
        What stands elsewhere: a list as in a file, or a mapping of names or patterns of parts, or
        names of controls, to displacements (3,) [m].
    title, description, postures, shares, reach_maps, reach_envelopes, changes, compare, signals, \
    contact_forces
        As in a study's file.

    Returns
    -------
    Study
        As `load_study` returns it.

    Raises
    ------
    InputError
        With a line for each fault, which names the argument and what of it is wrong.
    """
    place = _place(environment)
    given = {
        "study": name,
        "title": title,
        "description": description,
        "length": "m",
        "environment": place,
        "people": people,
        "postures": postures,
        "moved": moved,
        "cases": cases,
        "criteria": criteria,
        "shares": shares,
        "reach_maps": reach_maps,
        "reach_envelopes": reach_envelopes,
        "changes": changes,
        "compare": compare,
        "signals": signals,
        "contact_forces": contact_forces,
    }
    if isinstance(moved, Mapping):
        room = place if isinstance(place, Environment) else load_environment(place)
        given["moved"] = _moves(_CALL, moved, room)
    words = _Words(_CALL)
    value = {key: words.plain((key,), one) for key, one in given.items() if one is not None}
    value |= {key: _named_rows(value[key]) for key in _NAMED if key in value}
    return _read(words, value, Path.cwd() / "study.yaml")


def changed_study(before: Study, given: Mapping[str, Any]) -> Study:
    """Change what a study says, and derive it anew. See `Study.with_`.

    given: the keys of a study's file; those that are None stay as they are.
    """
    statement = before.check_derived()
    value = dict(statement.value)
    words = _Words(_CHANGE, among_others=True)
    for key, one in given.items():
        change = _place(one) if key == "environment" else one
        if change is None:
            continue
        if key == "moved" and isinstance(change, Mapping):
            change = _moves(_CHANGE, change, displaced(before.environment, (), before.moved))
        merged = _merged((key,), value.get(key), words.plain((key,), change))
        value.pop(key, None)
        if merged not in ([], {}):
            value[key] = merged
    return _read(words, value, statement.path)


def _place(environment: Any) -> Any:
    """An environment as a study can have it: itself, or its name or path as a text; a mesh becomes
    an environment."""
    if is_scene(environment):
        return environment_of_scene(environment)
    if isinstance(environment, Path) or (isinstance(environment, str) and is_place(environment)):
        return load_environment(environment)
    return environment


def _moves(call: str, moved: Mapping[str, Any], room: Environment) -> list[dict[str, Any]]:
    """The moves of a mapping of parts or controls to displacements, as a file has them."""
    try:
        return [{moved_kind(room, name): [name], "by": by} for name, by in moved.items()]
    except InputError as error:
        raise InputError(f"{call}: moved: {error}") from None


def _named_rows(value: Any) -> Any:
    """A mapping of names to what is called so as the list that a file has; anything else as it is."""
    if isinstance(value, dict) and all(isinstance(one, dict) for one in value.values()):
        return [{"name": name, **one} for name, one in value.items()]
    return value


@dataclass
class _Words:
    """What a call says, in the words that a file would have.

    call: what messages call it; among_others: whether its numbers stand among those of a file;
    controls: where texts with control characters stand.
    """

    call: str
    among_others: bool = False
    controls: list[tuple[str | int, ...]] = field(default_factory=list)

    def plain(self, key: tuple[str | int, ...], value: Any) -> Any:
        """Return a value as mappings, lists, numbers, texts and nouns.

        Raises
        ------
        InputError
            If it is nested too deep.
        """
        if len(key) > _DEEPEST:
            raise InputError(f"{self.call}: {key[0]}: nested deeper than {_DEEPEST} levels")
        if isinstance(value, (np.ndarray, np.generic)):
            value = value.tolist()
        if isinstance(value, Mapping):
            return {str(name): self.plain((*key, str(name)), one) for name, one in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.plain((*key, row), one) for row, one in enumerate(value)]
        if isinstance(value, (str, Path)):
            if has_controls(str(value)):
                self.controls.append(key)
            return str(value)
        if self.among_others and type(value) in _MARKED:
            return _MARKED[type(value)](value)
        return value


def _merged(key: tuple[str | int, ...], before: Any, change: Any) -> Any:
    """A value with a change made to it, as a merge patch of JSON does (RFC 7396), and named entries
    of a list by their names."""
    if not isinstance(change, dict):
        return change
    if isinstance(before, list):
        return _merged_rows(key, before, change)
    found = dict(before) if isinstance(before, dict) else {}
    for name, one in change.items():
        if one is None:
            found.pop(name, None)
        else:
            found[name] = _merged((*key, name), found.get(name), one)
    return found


def _merged_rows(key: tuple[str | int, ...], before: list[Any], change: dict[str, Any]) -> Any:
    """A list of named entries with those of some names changed; InputError for other names."""
    names = [str(row.get("name")) if isinstance(row, dict) else "" for row in before]
    for name in change:
        if name not in names:
            where = ".".join(map(str, key))
            raise InputError(
                f"{_CHANGE}: {where}: nothing is called {name!r}; {one_of(name, filter(None, names))}; "
                "give a list to replace them all"
            )
    rows = ((name, row) for name, row in zip(names, before, strict=True))
    kept = ((name, row) for name, row in rows if name not in change or change[name] is not None)
    return [_merged((*key, name), row, change.get(name, {})) for name, row in kept]


def _read(words: _Words, value: dict[str, Any], path: Path) -> Study:
    """The study of a call; faults name arguments."""
    document = Document(words.call, value, {}, tuple(words.controls))
    try:
        return read_study(document, path, {})
    except InputError as error:
        # the argument `name` is the key `study` of a file
        file, call = f"{words.call}: study: ", f"{words.call}: name: "
        lines = [line.replace(file, call, 1) for line in error.problems]
        raise InputError(lines) from None


# Environments with parts and controls elsewhere, as a call in Python says it: names to
# displacements.


def moved_environment(environment: Environment, displacements: Mapping[str, Any]) -> Environment:
    """Displace what is named. See `Environment.moved`."""
    moves = []
    taken: dict[str, str] = {}
    for name, by in displacements.items():
        kind = moved_kind(environment, name)
        names = matching([name], environment.parts) if kind == "parts" else (name,)
        if riding := riding_words(environment, names):
            raise InputError(f"environment {environment.name}: {riding}")
        for one in names:
            before = taken.setdefault(f"{kind} {one}", name)
            if before != name:
                raise InputError(f"displacements: {one!r} is moved by {before!r} and by {name!r}")
        shift = _shift(name, by)
        controls = names if kind == "controls" else ()
        moves.append(Move(names if kind == "parts" else (), controls, shift))
    for doubt in far_words("displacements", [move.by for move in moves], environment):
        warnings.warn(doubt, stacklevel=caller_level())
    return displaced(environment, moves)


def moved_kind(environment: Environment, name: object) -> str:
    """Whether a name means "parts", by a pattern too, or else "controls".

    Raises
    ------
    InputError
        If it means neither.
    """
    if isinstance(name, str) and matching([name], environment.parts):
        return "parts"
    controls = [control.name for control in environment.controls]
    if name in controls:
        return "controls"
    valid = one_of(str(name), [*environment.parts, *controls])
    raise InputError(f"environment {environment.name} has no part and no control {name!r}; {valid}")


def _shift(name: str, by: Any) -> tuple[float, float, float]:
    """A displacement [m] of three lengths."""
    row = by.tolist() if isinstance(by, np.ndarray) else by
    is_row = isinstance(row, (list, tuple)) and len(row) == 3
    if is_row and not any(isinstance(v, bool) for v in row):
        try:
            x, y, z = (plausible(to_metres(v) if isinstance(v, str) else v + 0.0) for v in row)
        except (ValueError, TypeError):
            pass
        else:
            if all(map(math.isfinite, (x, y, z))):
                return float(x), float(y), float(z)
    raise UsageError(
        f"displacements[{name!r}]: expected three lengths x, y, z ([m], or texts such as '20 mm'), "
        f"got {given_words(by)}"
    )
