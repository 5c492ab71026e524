"""Run a study: one table from its kind to the function that answers it."""

from __future__ import annotations

from collections.abc import Callable

from workbench.errors import UsageError, one_of
from workbench.model.result import Result
from workbench.model.study import Study
from workbench.study.clearance import clearance_study

__all__ = ["run"]

KINDS: dict[str, Callable[[Study], Result]] = {"clearance": clearance_study}


def run(study: Study) -> Result:
    """The result of a study; UsageError for a kind that is not known."""
    if study.kind not in KINDS:
        raise UsageError(f"no study kind {study.kind!r}; {one_of(study.kind, KINDS)}")
    return KINDS[study.kind](study)
