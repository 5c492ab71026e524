"""The design that people were judged in, as facts in words by name: what a comparison of two says was
changed between them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields

import numpy as np

from workbench.model.criterion import Criterion, Work
from workbench.model.environment import Environment
from workbench.model.rule_set import RuleSet
from workbench.model.study import Study
from workbench.model.units import limit_unit_of, plain

__all__ = ["changed_words", "design_of"]

_PLACE = "place of "
"""Begins the name of the fact where a thing is; what it is stands under its own name."""
_CRITERION = "criterion "
_LIMITS = ("at_least", "below", "above", "at_most")


def design_of(study: Study) -> dict[str, str]:
    """Describe the parts, controls, seats, points, criteria and bodies of a study: what each is, in
    millimetres and degrees, by its name."""
    facts = dict(_environment_facts(study.environment))
    for criterion in study.criteria:
        asked = _criterion_facts(criterion, study.environment)
        facts[f"{_CRITERION}“{criterion.name}”"] = ", ".join(asked)
    for role in study.roles:
        clothes = [item.name for item in role.clothes]
        facts[f"role {role.name}"] = " with ".join([role.body.name, *clothes])
    return facts


def _environment_facts(environment: Environment) -> Iterator[tuple[str, str]]:
    for row, name in enumerate(environment.parts):
        if not environment.hidden[row]:
            corners = environment.part(name).vertices
            low, high = corners.min(axis=0), corners.max(axis=0)
            yield f"part {name}", f"{_mm(high - low, ' x ')} mm large, {len(corners)} corners"
            yield f"{_PLACE}part {name}", f"{_mm(0.5 * (low + high))} mm"
    for control in environment.controls:
        yield f"control {control.name}", f"{control.grip}, zone {control.zone}"
        yield f"{_PLACE}control {control.name}", f"{_mm(control.at)} mm"
    for seat in environment.seats:
        forward, up = (_mm(ends, " to ") for ends in (seat.travel_forward, seat.travel_up))
        back, cushion = np.degrees((seat.back_angle, seat.cushion_angle))
        yield (
            f"seat {seat.name}",
            f"travel {forward} mm forward and {up} mm up, back {back:.1f} and cushion {cushion:.1f} "
            "degrees",
        )
        yield f"{_PLACE}seat {seat.name}", f"{_mm(seat.srp)} mm"
    for name, point in environment.points.items():
        yield f"point {name}", f"{_mm(point)} mm"


def _criterion_facts(criterion: Criterion, environment: Environment) -> Iterator[str]:
    """What a criterion asks, as far as it differs from what is asked where nothing is stated."""
    every = (environment.parts, tuple(control.name for control in environment.controls))
    for one in fields(criterion):
        value = getattr(criterion, one.name)
        if one.name in ("name", "limits") or value == one.default or value in every:
            continue
        word = plain(one.name)
        if one.name in _LIMITS:
            unit = limit_unit_of(criterion.check)
            yield f"{word} {unit.scale * value:g}{unit.words}"
        elif isinstance(value, Work):
            stated = {name: fact for name, fact in vars(value).items() if fact is not None}
            yield from (f"{plain(name)} {fact}" for name, fact in stated.items())
        elif isinstance(value, tuple):
            yield from (f"{word.removesuffix('s')} {item}" for item in value)
        elif isinstance(value, RuleSet):
            yield f"{word} {value.name}"
        else:
            yield f"{word} {value:.4g}" if isinstance(value, float) else f"{word} {value}"


def _mm(values: Iterable[float], between: str = ", ") -> str:
    return between.join(f"{1000 * float(value) + 0.0:.1f}".removesuffix(".0") for value in values)


def changed_words(before: Mapping[str, str], after: Mapping[str, str]) -> list[str]:
    """Say what differs between two designs: "place of control flaps: 520, -12, 640 mm → 488, -12, 640
    mm", "part shelf: only after"."""
    words = []
    for name, fact in before.items():
        now = after.get(name, fact)
        if now == fact:
            continue
        if name.startswith(_CRITERION):
            words.append(f"{name}: {_without(fact, now)} → {_without(now, fact)}")
        else:
            words.append(f"{name}: {fact} → {now}")
    for one, other, when in ((before, after, "before"), (after, before, "after")):
        words += [
            f"{name}: only {when}"
            for name in one
            if name not in other and not name.startswith(_PLACE)
        ]
    return words


def _without(fact: str, beside: str) -> str:
    """What a criterion asks that another one does not."""
    also = beside.split(", ")
    return ", ".join(piece for piece in fact.split(", ") if piece not in also) or "not stated"
