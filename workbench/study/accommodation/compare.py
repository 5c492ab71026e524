"""Compare two designs with the same people: who gains, who loses, person by person and requirement
by requirement."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from workbench.body.people.proportions import paired_share
from workbench.errors import InputError
from workbench.files.results.result import ResultFile
from workbench.model.arrays import Bools
from workbench.model.comparison import Comparison, Judged, PairedShare
from workbench.model.population import SEXES, sex_index
from workbench.model.result import Result
from workbench.model.units import unit_in
from workbench.study.accommodation.design import changed_words, design_of
from workbench.study.run import people_hash

__all__ = ["compare", "evaluate_people", "judged_file"]

_GROUPS = {"male": "men", "female": "women"}


def evaluate_people(result: Result) -> Judged:
    """The population of a result as it is compared. InputError where there is none."""
    found = result.population
    if found is None:
        raise InputError(f"{result.study.name} has no population to compare")
    people = found.people
    tall = people.column("stature") if "stature" in people.names else np.full(len(people), np.nan)
    return Judged(
        name=result.study.name,
        title=result.study.title,
        requirements=tuple(r.name for r in found.requirements),
        labels=people.labels or tuple(str(row + 1) for row in range(len(people))),
        sex=people.sex,
        weight=people.weight,
        stature=tall,
        margin=found.margin,
        units=tuple(r.unit for r in found.requirements),
        who=people_hash(people),
        confidence=found.study.shares.confidence,
        design=design_of(found.study),
    )


def judged_file(rows: ResultFile) -> Judged:
    """The population of a result.json as it is compared. InputError where there is none."""
    found = rows.population
    if found is None:
        raise InputError(f"the result of {rows.study} has no population to compare")
    people = found.people
    count = len(people.label)
    unknown = [math.nan] * count
    margin = [[math.nan if v is None else v / 1000 for v in row] for row in people.margin_mm]
    return Judged(
        name=rows.study,
        title=rows.title,
        requirements=tuple(r.name for r in found.requirements),
        labels=tuple(people.label),
        sex=np.array([sex_index(sex) for sex in people.sex]),
        weight=np.array(people.weight),
        stature=np.array(unknown if people.stature_mm is None else people.stature_mm) / 1000,
        margin=np.array(margin).reshape(count, len(found.requirements)),
        units=tuple(unit_in(r.unit) for r in found.requirements),
        who=found.people_hash,
        confidence=found.confidence,
        design=found.design,
    )


def compare(before: Judged | Result, after: Judged | Result) -> Comparison:
    """What the second design changes for the people of the first. InputError where they are not the
    same people, or the two have no requirement in common."""
    one = evaluate_people(before) if isinstance(before, Result) else before
    two = evaluate_people(after) if isinstance(after, Result) else after
    _check_people(one, two)
    shared = [name for name in one.requirements if name in two.requirements]
    if not shared:
        asked = f"the first asks for {_some(one.requirements)}, the second for {_some(two.requirements)}"
        raise InputError(
            f"{one.name} and {two.name} have no requirement in common to compare: {asked}"
        )
    was = one.served
    now = two.served
    return Comparison(
        before=one,
        after=two,
        groups=tuple(_groups(one, two)),
        pairs=tuple(_pair(name, one, *_met(name, one, two)) for name in shared),
        gained=tuple(np.flatnonzero(~was & now).tolist()),
        lost=tuple(np.flatnonzero(was & ~now).tolist()),
        only_before=tuple(name for name in one.requirements if name not in shared),
        only_after=tuple(name for name in two.requirements if name not in shared),
        changes=tuple(changed_words(one.design, two.design) if one.design and two.design else ()),
    )


def _groups(one: Judged, two: Judged) -> Iterator[PairedShare]:
    """The shares that fit of everybody, and of each sex where there are both."""
    yield _pair("everybody", one, one.served, two.served)
    present = [code for code in range(len(SEXES)) if (one.sex == code).any()]
    for code in present if len(present) > 1 else []:
        yield _pair(_GROUPS[SEXES[code]], one, one.served, two.served, one.sex == code)


def _met(name: str, one: Judged, two: Judged) -> tuple[Bools, Bools]:
    """(P,) who meets a requirement in each of two designs."""
    first, second = (judged.requirements.index(name) for judged in (one, two))
    return one.met[:, first], two.met[:, second]


def _pair(name: str, who: Judged, was: Bools, now: Bools, rows: Bools | None = None) -> PairedShare:
    """The shares before and after, of those in some rows."""
    if rows is None:
        rows = np.ones(len(was), dtype=np.bool_)
    return paired_share(
        was[rows], now[rows], weight=who.weight[rows], confidence=who.confidence, name=name
    )


def _check_people(one: Judged, two: Judged) -> None:
    """InputError that names the first difference between the people of two results."""
    lead = f"{one.name} and {two.name} are not about the same people"
    if len(one.labels) != len(two.labels):
        raise InputError(
            f"{lead}: {len(one.labels)} people in the first, {len(two.labels)} in the second"
        )
    for row, (first, second) in enumerate(zip(one.labels, two.labels, strict=True)):
        if one.sex[row] != two.sex[row]:
            kinds = (
                f"{SEXES[int(one.sex[row])]} in the first, {SEXES[int(two.sex[row])]} in the second"
            )
            raise InputError(f"{lead}: person {row + 1} ({first}) is {kinds}")
        tall = one.stature[row], two.stature[row]
        if np.isfinite(tall).all() and abs(tall[0] - tall[1]) > 1e-6:
            raise InputError(
                f"{lead}: person {row + 1} ({first}) has a stature of {1000 * tall[0]:.3f} mm in the "
                f"first, {1000 * tall[1]:.3f} mm in the second ({second})"
            )
        if one.weight[row] != two.weight[row]:
            raise InputError(
                f"{lead}: person {row + 1} ({first}) has the weight {one.weight[row]:g} in the first, "
                f"{two.weight[row]:g} in the second"
            )
    if one.who != two.who:
        raise InputError(
            f"{lead}: they agree in sex, stature and weight in the sample, but not in all measures; run "
            "both with the same population, seed and measures"
        )


def _some(names: tuple[str, ...]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
