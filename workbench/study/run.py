"""Run a study: people in postures, motions, a population."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from workbench.errors import UsageError
from workbench.model.accommodation import PopulationFound
from workbench.model.motion_case import Agreement
from workbench.model.result import MotionFound, Result
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import accommodation_study
from workbench.study.accommodation.cluster import cluster_at
from workbench.study.accommodation.share_verdicts import share_verdicts
from workbench.study.clearance import clearance_study
from workbench.study.crash.crash import motion_found, motions_agree
from workbench.study.pipelines import motion_cases, population_study, posture_study
from workbench.study.provenance import hashes, people_hash, versions

__all__ = ["check_run", "run"]

Say = Callable[[str], None]


def run(
    study: Study,
    *,
    keep: Path | None = None,
    say: Say = lambda text: None,
    cluster: str | None = None,
) -> Result:
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

    Returns
    -------
    Result
        What was found of people in postures, of motions or of a population, with the verdicts.

    Raises
    ------
    InputError
        Where a file cannot be read, a chunk not be written, the cluster does not answer, or the
        motions to be compared have no time in common.
    MissingPartError
        Where Dask or MuJoCo is needed and not installed.
    UsageError
        For a cluster without a population.
    """
    check_run(study, cluster=cluster)
    if study.crowd is not None:
        return _population(study, keep, say, cluster)
    if study.moves:
        return _motions(study)
    return _postures(study)


def _postures(study: Study) -> Result:
    """People in postures, together."""
    found = clearance_study(posture_study(study))
    return Result(
        study=study,
        verdicts=found.verdicts,
        warnings=found.warnings,
        provenance=_provenance(study),
        postures=found,
    )


def _motions(study: Study) -> Result:
    """Each motion, and how near the second of two that are compared is to the first."""
    found = tuple(motion_found(case) for case in motion_cases(study))
    agreements: tuple[Agreement, ...] = ()
    if study.compare is not None:
        one, two = (found[case].study for case in study.compare)
        agreements = motions_agree(one, two)
    return Result(
        study=study,
        verdicts=tuple(verdict for motion in found for verdict in motion.verdicts),
        warnings=(*_motion_warnings(found), *study.warnings),
        provenance=_provenance(study),
        motions=found,
        agreements=agreements,
    )


def _population(study: Study, keep: Path | None, say: Say, cluster: str | None) -> Result:
    """A population, by this machine or by a cluster."""
    people = population_study(study)
    if cluster is None:
        found = accommodation_study(people, keep=keep, say=say)
    else:
        with cluster_at(cluster) as workers:
            found = accommodation_study(people, keep=keep, say=say, workers=workers)
    return Result(
        study=study,
        verdicts=share_verdicts(found, study.criteria, _crowd(study)),
        warnings=found.warnings,
        provenance=_provenance(study, found),
        population=found,
    )


def _crowd(study: Study) -> str:
    return study.crowd.name if study.crowd is not None else ""


def _provenance(
    study: Study, population: PopulationFound | None = None
) -> dict[str, dict[str, str]]:
    """Hashes of the input files and of who the people are, and the versions of what computed."""
    found = {"inputs": hashes(study.inputs)}
    if population is not None:
        found["people"] = {"measures": people_hash(population.study.people)}
    return found | {"versions": versions()}


def _motion_warnings(found: Sequence[MotionFound]) -> tuple[str, ...]:
    """The warnings of all motions: what is said of each of several stands once, the rest with the
    motion's name."""
    told = []
    for motion in found:
        for warning in motion.warnings:
            general = all(warning in other.warnings for other in found)
            told.append(warning if general else f"{motion.study.name}: {warning}")
    return tuple(dict.fromkeys(told))


def check_run(study: Study, *, cluster: str | None = None, film: bool = False) -> None:
    """Raise UsageError for what a run of this study cannot be asked for."""
    if cluster is not None and study.crowd is None:
        raise UsageError(f"--cluster is for studies of a population; {study.name} has none")
    if film and not study.moves:
        raise UsageError(f"--film is for studies of a motion; {study.name} has none")
