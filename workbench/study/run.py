"""Run a study: people in postures, motions, a population; and what a result was made from and by."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from workbench.errors import UsageError
from workbench.model.content import content_hash
from workbench.model.environment import HARMLESS
from workbench.model.motion_case import Agreement, MotionCase
from workbench.model.population import Population
from workbench.model.result import MotionFound, PopulationFound, PosturesFound, Result, Verdict
from workbench.model.study import Study
from workbench.model.surroundings import displaced
from workbench.study.checks.sight_rules import check_rules
from workbench.study.checks.table import between_verdict
from workbench.study.people import people_found, present_people
from workbench.study.warnings import lost_seats

__all__ = [
    "between_motions",
    "check_run",
    "hashes",
    "people_hash",
    "run",
    "unmoved_postures",
    "versions",
]

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
        Where a field of the study was changed by hand (see `Study.with_`), a file cannot be read, a chunk not be written, the cluster does not answer, or the
        motions to be compared have no time in common.
    MissingPartError
        Where Dask or MuJoCo is needed and not installed.
    UsageError
        For a cluster without a population.

    Examples
    --------
    >>> import workbench as wb
    >>> result = wb.run(wb.load_study("wheelchair_counter"))
    >>> print(result)
    Result(wheelchair_counter: 5 of 5 criteria hold)
    """
    check_run(study, cluster=cluster)
    if study.crowd is not None:
        return _population(study, keep, say, cluster)
    return _people(study)


def _people(study: Study) -> Result:
    """Single people in postures and motions, those of several sizes one at a time."""
    postures = _postures(study)
    motions = _motions(study) if study.motions else ()
    verdicts = [verdict for posture in postures for verdict in posture.verdicts]
    verdicts += [verdict for motion in motions for verdict in motion.verdicts]
    verdicts += between_motions(study, [motion.study for motion in motions])
    sections = [(found.row, found.warnings) for found in postures]
    sections += [(found.study.name, found.warnings) for found in motions]
    return Result(
        study=study,
        verdicts=tuple(verdicts),
        warnings=_in_order(study, (*_warnings(sections), *study.warnings)),
        provenance=_provenance(study),
        postures=tuple(postures),
        motions=motions,
        agreements=_agreements(study, motions),
    )


def _postures(study: Study) -> list[PosturesFound]:
    """Single people in postures, those of several sizes one at a time."""
    return [
        _of_size(people_found(single, present_people(single)), size)
        for size, single in (study.by_size() if study.postures else ())
    ]


def unmoved_postures(study: Study) -> list[PosturesFound]:
    """Find the single people of a study in postures with everything where the environment's file
    has it; reach envelopes are left out."""
    environment = displaced(study.environment, (), study.moved)
    return _postures(replace(study, environment=environment, moved=(), reach_envelopes=()))


def _motions(study: Study) -> tuple[MotionFound, ...]:
    """The motions of a study, each found by itself."""
    from workbench.study.crash.crash import motion_found  # not loaded for other studies
    from workbench.study.motion_cases import motion_cases

    return tuple(motion_found(case) for case in motion_cases(study))


def between_motions(study: Study, motions: Sequence[MotionCase]) -> Iterator[Verdict]:
    """The verdicts of the criteria between people who move, case by case."""
    for criterion in study.criteria:
        for case in study.motions:
            if criterion.check == "between_people" and criterion.asks(case.name):
                there = [motion for motion in motions if motion.case == case.name]
                yield between_verdict(criterion, case.name, there)


def _of_size(found: PosturesFound, size: str) -> PosturesFound:
    """What was found of one of several sizes, by its name."""
    verdicts = tuple(replace(verdict, row=size) for verdict in found.verdicts)
    return replace(found, verdicts=verdicts, row=size)


def _agreements(study: Study, motions: Sequence[MotionFound]) -> tuple[Agreement, ...]:
    """How near the second of two motions that are compared is to the first, of the first role."""
    if study.compare is None:
        return ()
    from workbench.study.crash.crash import motions_agree  # not loaded for other studies

    role = study.roles[0].name
    one, two = (
        next(m.study for m in motions if (m.study.case, m.study.person) == (name, role))
        for name in (study.cases[case].name for case in study.compare)
    )
    return motions_agree(one, two)


def _in_order(study: Study, warnings: Sequence[str]) -> tuple[str, ...]:
    """Warnings, each once, first those of seats from which others follow; without notes about meshes
    on which nothing depends."""
    lost = lost_seats(study.environment, study.roles).values()
    told = dict.fromkeys((*(doubt.said for doubt in lost), *warnings))
    return tuple(one for one in told if not one.endswith(HARMLESS))


def _warnings(sections: Sequence[tuple[str, tuple[str, ...]]]) -> list[str]:
    """The warnings of all sections: what each of several says stands once, the rest with the
    section's name."""
    found = []
    for name, warnings in sections:
        for warning in warnings:
            general = all(warning in others for _, others in sections)
            found.append(warning if general or not name else f"{name}: {warning}")
    return found


def _population(study: Study, keep: Path | None, say: Say, cluster: str | None) -> Result:
    """A population, by this machine or by a cluster; and who is beside it."""
    # not loaded for other studies
    from workbench.study.accommodation.accommodation import accommodation
    from workbench.study.accommodation.shares import share_verdicts
    from workbench.study.executors import dask_executor

    there = present_people(study) if len(study.roles) > 1 else None
    beside = () if there is None else (people_found(study, there),)
    if cluster is None:
        found = accommodation(study, there, keep=keep, say=say)
    else:
        with dask_executor(cluster) as executor:
            found = accommodation(study, there, keep=keep, say=say, executor=executor)
    verdicts = [verdict for postures in beside for verdict in postures.verdicts]
    warnings = [warning for postures in beside for warning in postures.warnings]
    return Result(
        study=study,
        verdicts=(*verdicts, *share_verdicts(found)),
        warnings=_in_order(study, (*warnings, *found.warnings)),
        provenance=_provenance(study, found),
        postures=beside,
        population=found,
    )


def _provenance(
    study: Study, population: PopulationFound | None = None
) -> dict[str, dict[str, str]]:
    """Hashes of the input files and of who the people are, and the versions of what computed."""
    found = {"inputs": hashes(study.inputs)}
    if study.statement is not None and "study" not in study.inputs:
        found["call"] = {"study": content_hash(study.statement.value)}
    if population is not None:
        found["people"] = {"measures": people_hash(population.people)}
    return found | {"versions": versions()}


def check_run(study: Study, *, cluster: str | None = None, film: bool = False) -> None:
    """Raise UsageError for what a run of this study cannot be asked for, InputError for a study
    whose fields were changed by hand, or with rules that cannot be judged from its seats."""
    study.check_derived()
    check_rules(study)
    if cluster is not None and study.crowd is None:
        raise UsageError(f"--cluster is for studies of a population; {study.name} has none")
    if film and not study.motions:
        raise UsageError(f"--film is for studies of a motion; {study.name} has none")


PACKAGES = ("bubbleman-workbench", "numpy", "scipy", "numba", "trimesh", "manifold3d")


def hashes(inputs: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of each input file, by its role."""
    return {
        f"{role}": hashlib.sha256(path.read_bytes()).hexdigest()
        for role, path in sorted(inputs.items())
    }


def people_hash(people: Population) -> str:
    """SHA-256 of who the people are: the measures' names and values, sexes and weights; not of what
    they are called."""
    digest = hashlib.sha256("\n".join(people.names).encode())
    for array in (people.sex, people.weight, people.measures):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def versions() -> dict[str, str]:
    """Versions of Python and of the packages whose numbers a result rests on."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
