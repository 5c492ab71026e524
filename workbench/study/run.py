"""Run a study: one table from its kind to what loads it and what answers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from workbench.errors import InputError, UsageError, one_of
from workbench.files.accommodation.studies import AccommodationPlan, load_accommodation
from workbench.files.catalogue import find
from workbench.files.crash.studies import CrashPlan, load_crash
from workbench.files.schema import fail
from workbench.files.studies import load_study
from workbench.files.yaml_text import read_yaml
from workbench.model.accommodation import Accommodation
from workbench.model.crash import CrashResult
from workbench.model.result import Result
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import accommodation_study
from workbench.study.accommodation.cluster import cluster_at
from workbench.study.clearance import clearance_study
from workbench.study.crash.crash import crash_study

__all__ = ["KINDS", "Loaded", "filmed", "load", "run"]


class Loaded(NamedTuple):
    """A study with everything it names, and the name of its kind."""

    name: str
    kind: str
    what: Study | CrashPlan | AccommodationPlan
    warnings: tuple[str, ...]


def _clearance(source: str | Path) -> Loaded:
    study = load_study(source)
    return Loaded(study.name, study.kind, study, study.warnings)


def _crash(source: str | Path) -> Loaded:
    plan = load_crash(source)
    return Loaded(plan.file.study, plan.file.kind, plan, plan.environment.warnings)


def _accommodation(source: str | Path) -> Loaded:
    plan = load_accommodation(source)
    return Loaded(plan.file.study, plan.file.kind, plan, plan.environment.warnings)


KINDS: dict[str, Callable[[str | Path], Loaded]] = {
    "clearance": _clearance,
    "reach": _clearance,
    "crash": _crash,
    "accommodation": _accommodation,
}


def load(source: str | Path) -> Loaded:
    """Load a study of any kind, by catalogue name or path; InputError lists what is wrong with
    it."""
    document = read_yaml(find("studies", str(source)))
    kind = document.value.get("kind") if isinstance(document.value, dict) else None
    if isinstance(kind, str) and kind not in KINDS:
        raise InputError(
            fail(document, ("kind",), f"no study kind {kind!r}; {one_of(kind, KINDS)}")
        )
    return KINDS[kind if isinstance(kind, str) else "clearance"](source)


def filmed(study: Loaded) -> Loaded:
    """A crash study with a film in its report; UsageError for other kinds, which do not move."""
    if not isinstance(study.what, CrashPlan):
        raise UsageError(f"--film is for crash studies; {study.name} is one of kind {study.kind}")
    return study._replace(
        what=replace(study.what, file=study.what.file.model_copy(update={"film": True}))
    )


def run(
    study: Study | CrashPlan | AccommodationPlan | Loaded,
    *,
    keep: Path | None = None,
    say: Callable[[str], None] = lambda text: None,
    cluster: str | None = None,
) -> Result | CrashResult | Accommodation:
    """The result of a study; UsageError for a kind that is not known.

    Of an accommodation study, which may take long: keep: a folder where finished chunks of people
    are kept until it is done, so that a run that is cut off goes on from there; say: told how far
    it is; cluster: the address of a Dask scheduler, or "local" for one of its own, to do the work.
    MissingPartError where Dask is not installed, InputError where the cluster does not answer,
    UsageError for a cluster for a study of another kind.
    """
    what = study.what if isinstance(study, Loaded) else study
    if isinstance(what, AccommodationPlan):
        if cluster is None:
            return accommodation_study(what, keep=keep, say=say)
        with cluster_at(cluster) as workers:
            return accommodation_study(what, keep=keep, say=say, workers=workers)
    if cluster is not None:
        raise UsageError("a cluster is for accommodation studies, which are about many people")
    if isinstance(what, CrashPlan):
        return crash_study(what)
    if what.kind not in ("clearance", "reach"):
        raise UsageError(f"no study kind {what.kind!r}; {one_of(what.kind, KINDS)}")
    return clearance_study(what)
