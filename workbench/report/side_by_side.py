"""Criteria in several states side by side: in each of several motions, before and after parts were
moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from workbench.files.results.result import VerdictRow
from workbench.report.criteria import asked_words, measured_words, none_measured_words
from workbench.report.templates import template

__all__ = ["Verdicts", "comes_out_differently", "side_by_side"]

Verdicts = Mapping[str, Mapping[str, VerdictRow]]
"""For each criterion its verdicts by the names of the states."""


def side_by_side(
    criteria: Verdicts, names: Sequence[str], *, what: str, picture: Markup | str = ""
) -> Markup:
    """Return the table of criteria in several states, those that come out differently first.

    Parameters
    ----------
    criteria
        The verdicts.
    names
        The states in their order.
    what
        The caption up to what comes first: "Each criterion, motion by motion".
    picture
        The place of a picture of two of the states, "" for none.
    """
    lines = []
    for name, mine in criteria.items():
        known = [verdict for verdict in mine.values() if verdict.worst is not None]
        first = next(iter(mine.values()))
        lines.append(
            {
                "name": name,
                "cells": [_cell(mine.get(state)) for state in names],
                "asked": asked_words(known[0]) if known else none_measured_words(first),
                "differs": comes_out_differently(mine),
            }
        )
    lines.sort(key=lambda line: not line["differs"])
    html = template("side_by_side.html.j2").render(
        names=names,
        lines=lines,
        picture=picture,
        what=what,
        differ=any(line["differs"] for line in lines),
    )
    return Markup(html)


def comes_out_differently(verdicts: Mapping[str, VerdictRow]) -> bool:
    """Whether a criterion fails in one state and holds in another."""
    return len({verdict.passed for verdict in verdicts.values()}) > 1


def _cell(verdict: VerdictRow | None) -> dict[str, Any]:
    """What a criterion comes to in one state."""
    if verdict is None:
        return {"text": "not asked", "passed": True, "asked": False}
    measured = measured_words(verdict)
    text = measured if verdict.worst is not None else verdict.sentence.rstrip(".").lower()
    return {"text": text, "passed": verdict.passed, "asked": True}
