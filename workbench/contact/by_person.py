"""Contacts of several people: those of each asked by themselves, and the answers put together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from workbench.errors import UsageError
from workbench.model.arrays import Ints
from workbench.model.contacts import Contacts
from workbench.model.poses import Placed

__all__ = ["by_person"]

P = ParamSpec("P")
T = TypeVar("T")


def by_person(function: Callable[P, T]) -> Callable[P, T]:
    """Let a function of placed bodies with one row be asked of bodies with many.

    Its leading arguments that are Placed have as many poses each. Its answer is an array with a row
    for each pose, a noun of such arrays, or Contacts; it is the same to the last bit as that of the
    poses of each person alone.
    """

    @wraps(function)
    def call(*args: P.args, **options: P.kwargs) -> T:
        placed = [one for one in (*args, *options.values()) if isinstance(one, Placed)]
        if all(len(one.body) == 1 for one in placed) or len({len(one) for one in placed}) > 1:
            return function(*args, **options)
        if options.get("rows") is not None:
            raise UsageError("rows: expected None for a body of several rows; ask for one person")
        answers = []
        for rows, some in _people(placed):
            own = [some.get(id(value), value) for value in args]
            named = {name: some.get(id(value), value) for name, value in options.items()}
            answers.append((rows, function(*own, **named)))
        return _together(answers, placed)  # type: ignore[no-any-return]

    return call


def _people(placed: list[Placed]) -> Iterator[tuple[Ints, dict[int, Any]]]:
    """The numbers of the poses of the same people, and by the id of each that is placed these poses
    of it, with one row of its body."""
    people = np.stack([one.person for one in placed], axis=1)
    chosen, which = np.unique(people, axis=0, return_inverse=True)
    if not len(chosen):
        chosen = np.zeros((1, len(placed)), dtype=np.int64)
    for k, person in enumerate(chosen.tolist()):
        rows = np.flatnonzero(which.reshape(-1) == k)
        yield rows, {id(one): one.of_person(b, rows) for one, b in zip(placed, person, strict=True)}


def _together(answers: list[tuple[Ints, Any]], placed: list[Placed]) -> Any:
    """The answers as one, of all bodies."""
    first = answers[0][1]
    order = np.concatenate([rows for rows, _ in answers])
    back = np.argsort(order, kind="stable")
    if isinstance(first, np.ndarray):
        return np.concatenate([answer for _, answer in answers])[back]
    values = {
        field.name: np.concatenate([getattr(answer, field.name) for _, answer in answers])
        for field in fields(first)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    if isinstance(first, Contacts):
        values["pose"] = np.concatenate([rows[answer.pose] for rows, answer in answers])
        back = np.argsort(values["pose"], kind="stable")
    whole: dict[str, Any] = {name: array[back] for name, array in values.items()}
    bodies = {name: one.body for name, one in zip(("body", "other"), (placed * 2)[:2], strict=True)}
    for name, body in bodies.items():
        known = getattr(first, name, None)
        if known is not None and hasattr(known, "topology"):
            whole[name] = body
    return replace(first, **whole)
