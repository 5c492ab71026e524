"""Many people as bodies: one for each person of a population, in order, with files' names that say
who they are."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from workbench.body.scaling.measure import MEASURES
from workbench.body.scaling.scale import scale, scale_many
from workbench.errors import InputError
from workbench.model.body import Body
from workbench.model.population import MASS, SEXES, Population, check_measures
from workbench.study.persons import APART, SizedBody

__all__ = ["SHOWN", "file_names", "people_bodies"]

# What a person's body shows exactly where nothing else is asked for: those that a workplace is
# fitted to.
SHOWN = (
    "stature",
    "sitting_height",
    "bideltoid_breadth",
    "buttock_knee_length",
    "knee_height_sitting",
    "popliteal_height",
    "hip_breadth",
    "hip_breadth_sitting",
    "thigh_clearance",
    "elbow_rest_height",
    "shoulder_elbow_length",
    "radiale_stylion_length",
    "hand_length",
    "foot_length",
    "chest_depth",
)


def people_bodies(
    bodies: Mapping[str, Body], people: Population, shown: Sequence[str]
) -> Iterator[SizedBody]:
    """The body of each person: of a man from bodies["male"], of a woman from bodies["female"].

    shown: the measures it shows exactly (see scaling.measure); the person's others are drawn near,
    masses add up to the person's. InputError names the person of whom there is no such body.
    """
    exact = check_measures(shown, [name for name in people.names if name in MEASURES])
    near = [name for name in people.names if name in MEASURES and name not in (*exact, *APART)]
    rows = [dict(zip(people.names, row.tolist(), strict=True)) for row in people.measures]
    made = {}
    for sex in {SEXES[int(code)] for code in people.sex}:
        own = [row for row, code in zip(rows, people.sex, strict=True) if SEXES[int(code)] == sex]
        given, rest = (
            [{name: row[name] for name in names} for row in own] for names in (exact, near)
        )
        made[sex] = scale_many(bodies[sex], given, others=rest)
    for row, code, label in zip(rows, people.sex, people.labels, strict=True):
        sex = SEXES[int(code)]
        yield _person(bodies[sex], next(made[sex]), row, exact, f"{sex}, {label}")


def _person(
    template: Body,
    body: Body | InputError,
    row: Mapping[str, float],
    exact: Sequence[str],
    label: str,
) -> SizedBody:
    """The body of a person with measures `row`, or the template with the exact ones alone where no
    body shows all."""
    notes: tuple[str, ...] = ()
    if isinstance(body, InputError):
        try:
            body = scale(template, {name: row[name] for name in exact})
        except InputError as error:
            raise InputError([f"{label}: {problem}" for problem in error.problems]) from None
        notes = ("the measures that are not shown could not be drawn near",)
    if MASS in row:
        body = replace(body, mass=body.mass * (row[MASS] / body.mass.sum()))
    return SizedBody(body, row, notes)


def file_names(people: Population) -> list[str]:
    """A file name for each person, by sex and label: "male_5.yaml"; numbered where two would be the
    same."""
    names: list[str] = []
    for code, label in zip(people.sex, people.labels, strict=True):
        sex = SEXES[int(code)]
        plain = re.sub(r"[^a-z0-9.]+", "_", label.lower()).strip("_.")
        stem = plain if plain.startswith(sex) else f"{sex}_{plain}"
        same = sum(name == f"{stem}.yaml" or name.startswith(f"{stem}-") for name in names)
        names.append(f"{stem}-{same + 1}.yaml" if same else f"{stem}.yaml")
    return names
