"""Run a study: one table from its kind to what loads it and what answers it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from workbench.errors import InputError, UsageError, one_of
from workbench.files.catalogue import find
from workbench.files.crash_studies import CrashPlan, load_crash
from workbench.files.schema import fail
from workbench.files.studies import load_study
from workbench.files.yaml_text import read_yaml
from workbench.model.crash import CrashResult
from workbench.model.result import Result
from workbench.model.study import Study
from workbench.study.clearance import clearance_study
from workbench.study.crash import crash_study

__all__ = ["KINDS", "Loaded", "load", "run"]


class Loaded(NamedTuple):
    """A study with everything it names, and the name of its kind."""

    name: str
    kind: str
    what: Study | CrashPlan
    warnings: tuple[str, ...]


def _clearance(source: str | Path) -> Loaded:
    study = load_study(source)
    return Loaded(study.name, study.kind, study, study.warnings)


def _crash(source: str | Path) -> Loaded:
    plan = load_crash(source)
    return Loaded(plan.file.study, plan.file.kind, plan, plan.environment.warnings)


KINDS: dict[str, Callable[[str | Path], Loaded]] = {"clearance": _clearance, "reach": _clearance, "crash": _crash}


def load(source: str | Path) -> Loaded:
    """Load a study of any kind, by catalogue name or path; InputError lists what is wrong with it."""
    document = read_yaml(find("studies", str(source)))
    kind = document.value.get("kind") if isinstance(document.value, dict) else None
    if isinstance(kind, str) and kind not in KINDS:
        raise InputError(fail(document, ("kind",), f"no study kind {kind!r}; {one_of(kind, KINDS)}"))
    return KINDS[kind if isinstance(kind, str) else "clearance"](source)


def run(study: Study | CrashPlan | Loaded) -> Result | CrashResult:
    """The result of a study; UsageError for a kind that is not known."""
    what = study.what if isinstance(study, Loaded) else study
    if isinstance(what, CrashPlan):
        return crash_study(what)
    if what.kind not in ("clearance", "reach"):
        raise UsageError(f"no study kind {what.kind!r}; {one_of(what.kind, KINDS)}")
    return clearance_study(what)
