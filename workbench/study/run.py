"""Run a study: what it states decides how it is answered."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from workbench.errors import UsageError
from workbench.model.accommodation import Accommodation
from workbench.model.crash import CrashResult
from workbench.model.result import Result
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import accommodation_study
from workbench.study.accommodation.share_verdicts import with_share_verdicts
from workbench.study.clearance import clearance_study
from workbench.study.crash.crash import crash_study
from workbench.study.executors import dask_executor
from workbench.study.pipelines import motion_study, population_study, posture_study

__all__ = ["check_run", "passed", "run"]


def run(
    study: Study,
    *,
    keep: Path | None = None,
    say: Callable[[str], None] = lambda text: None,
    cluster: str | None = None,
    film: bool = False,
) -> Result | CrashResult | Accommodation:
    """Run a study.

    Parameters
    ----------
    study
        The study, as `load_study` returns it.
    keep
        A folder where finished chunks of a population are kept until it is done, so that a run that
        is cut off goes on from there.
    say
        Called with words on how far the run is.
    cluster
        The address of a Dask scheduler that works on a population, or "local" for one of its own.
    film
        Whether the report of a motion has a film.

    Returns
    -------
    Result, CrashResult or Accommodation
        Of people in postures, of a motion, or of a population.

    Raises
    ------
    InputError
        Where a file cannot be read, a chunk not be written, or the cluster does not answer.
    MissingPartError
        Where Dask or MuJoCo is needed and not installed.
    UsageError
        For a cluster without a population, and a film without a motion.
    """
    check_run(study, cluster=cluster, film=film)
    if study.crowd is None:
        return (
            crash_study(motion_study(study, film=film))
            if study.moves
            else clearance_study(posture_study(study))
        )
    people = population_study(study)
    if cluster is None:
        found = accommodation_study(people, keep=keep, say=say)
    else:
        with dask_executor(cluster) as executor:
            found = accommodation_study(people, keep=keep, say=say, executor=executor)
    return with_share_verdicts(found, study.criteria)


def passed(result: Result | CrashResult | Accommodation) -> bool:
    """Whether no criterion failed, of a second motion neither."""
    other = result.other if isinstance(result, CrashResult) else None
    return result.passed and (other is None or other.passed)


def check_run(study: Study, *, cluster: str | None = None, film: bool = False) -> None:
    """Raise UsageError for what a run of this study cannot be asked for."""
    if cluster is not None and study.crowd is None:
        raise UsageError(f"--cluster is for studies of a population; {study.name} has none")
    if film and not study.moves:
        raise UsageError(f"--film is for studies of a motion; {study.name} has none")
