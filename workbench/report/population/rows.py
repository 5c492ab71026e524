"""A population as the rows of result.json and of the CSV tables, rounded for reading."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from workbench.body.people.share import percent, percent_number
from workbench.files.results.population import (
    GainRow,
    GroupRow,
    HardRow,
    MapRow,
    PeopleRow,
    PopulationRows,
    RequirementRow,
)
from workbench.model.arrays import Floats
from workbench.model.measures import MASS
from workbench.model.population import SEXES
from workbench.model.population_found import PopulationFound
from workbench.model.study import PeopleDrawn, Study
from workbench.report.population.words import (
    gain_sentence,
    no_gain_words,
)
from workbench.report.tables import csv_text

__all__ = ["people_table", "population_lines", "population_rows", "population_tables"]


def population_lines(result: PopulationFound) -> list[str]:
    """What the command line says: requirements that leave anybody out, worst first, gains, then
    groups."""
    order = [r for r in np.argsort(result.single, kind="stable") if result.single[r] < 1.0]
    count = len(result.served)
    lines = [
        f"{percent(float(result.single[r]), count):>7}  {result.requirements[r].name}"
        f" (alone leaves out {percent(float(result.alone[r]), count)})"
        for r in order
    ]
    lines += [gain_sentence(gain, count) for gain in result.gains] or no_gain_words(result)
    for row in result.shares:
        low, high = (percent_number(value, row.count) for value in (row.low, row.high))
        lines.append(f"{percent(row.share, row.count):>7}  {row.group} ({low} to {high} %)")
    return lines


def population_rows(result: PopulationFound, people_hash: str) -> PopulationRows:
    """Convert what was found of a population: lengths in mm, shares 0 to 1."""
    return PopulationRows(
        role=result.place.role,
        seat=result.place.seat,
        body=result.body.name,
        population=result.people.source,
        people_hash=people_hash,
        seed=_seed(result.study),
        confidence=result.study.shares.confidence,
        shares=[
            GroupRow(
                group=s.group,
                share=_share(s.share),
                low=_share(s.low),
                high=_share(s.high),
                count=s.count,
            )
            for s in result.shares
        ],
        requirements=[_requirement(result, r) for r in range(len(result.requirements))],
        hardest=[_hard(result, row) for row in result.hardest],
        gains=[
            GainRow(
                words=g.words,
                requirement=g.requirement,
                move_mm=_mm(g.move),
                rate_per_mm=_share(g.rate / 1000),
                margin_rate=None if math.isnan(g.margin_rate) else round(g.margin_rate, 4) + 0.0,
                before=_share(g.before),
                after=_share(g.after),
                joint_before=_share(g.joint_before),
                joint_after=_share(g.joint_after),
            )
            for g in result.gains
        ],
        maps=[
            MapRow(
                part=m.task.part,
                grip=m.task.grip,
                zone=m.task.zone,
                hand=m.task.hand,
                points_mm=_rows(m.points),
                flat_mm=_rows(m.flat),
                share=[_share(v) for v in m.share.tolist()],
            )
            for m in result.maps
        ],
        reasons=list(result.reasons),
        people=_people(result),
    )


def _seed(study: Study) -> int | None:
    """The seed that the people are drawn with, None where they are given."""
    crowd = study.crowd
    drawn = crowd.population if crowd is not None else None
    return drawn.seed if isinstance(drawn, PeopleDrawn) else None


def _requirement(result: PopulationFound, r: int) -> RequirementRow:
    row = result.requirements[r]
    return RequirementRow(
        name=row.name,
        criterion=row.criterion,
        check=row.check,
        target=row.target,
        zone=row.zone,
        share=_share(float(result.single[r])),
        without=_share(float(result.without[r])),
        alone=_share(float(result.alone[r])),
        spread_mm=[_number(value) for value in result.spread[r].tolist()],
    )


def _people(result: PopulationFound) -> PeopleRow:
    people = result.people
    return PeopleRow(
        label=_labels(result),
        sex=[SEXES[int(code)] for code in people.sex],
        weight=people.weight.tolist(),
        stature_mm=[_mm(v) for v in people.column("stature").tolist()]
        if "stature" in people.names
        else None,
        served=result.served.tolist(),
        limiting=list(result.limiting),
        seat_mm=_rows(result.seat),
        comfortable_mm=_rows(result.comfortable),
        window_mm=[
            _row(window) if math.isfinite(window[0]) else None for window in result.window.tolist()
        ],
        margin_mm=_cells(result.margin),
        reason=result.reason.tolist(),
    )


def _hard(result: PopulationFound, row: int) -> HardRow:
    r = int(np.nanargmin(result.margin[row]))
    reason = int(result.reason[row, r])
    return HardRow(
        person=_labels(result)[row],
        sex=SEXES[int(result.people.sex[row])],
        requirement=result.requirements[r].name,
        margin_mm=_mm(float(result.margin[row, r])),
        reason=result.reasons[reason] if reason >= 0 else "",
        limiting=result.limiting[row],
    )


def population_tables(result: PopulationFound, rows: PopulationRows) -> dict[str, str]:
    """File name to CSV text: shares, requirements, gains, and everybody with measures, margins and
    what limits."""
    header, body = people_table(result)
    levels = [
        "margin_1_percent_mm",
        "margin_5_percent_mm",
        "margin_50_percent_mm",
        "margin_95_percent_mm",
        "margin_99_percent_mm",
    ]
    return {
        "shares.csv": csv_text(
            ["group", "share", "low", "high", "people"],
            ([s.group, s.share, s.low, s.high, s.count] for s in rows.shares),
        ),
        "requirements.csv": csv_text(
            [
                "requirement",
                "criterion",
                "check",
                "target",
                "zone",
                "share",
                "without",
                "alone",
                *levels,
            ],
            (
                [
                    q.name,
                    q.criterion,
                    q.check,
                    q.target,
                    q.zone,
                    q.share,
                    q.without,
                    q.alone,
                    *q.spread_mm,
                ]
                for q in rows.requirements
            ),
        ),
        "gains.csv": csv_text(
            [
                "change",
                "requirement",
                "move_mm",
                "share_per_mm",
                "margin_per_mm",
                "before",
                "after",
                "joint_before",
                "joint_after",
            ],
            (
                [
                    g.words,
                    g.requirement,
                    g.move_mm,
                    g.rate_per_mm,
                    g.margin_rate,
                    g.before,
                    g.after,
                    g.joint_before,
                    g.joint_after,
                ]
                for g in rows.gains
            ),
        ),
        "people.csv": csv_text(header, body),
    }


def people_table(result: PopulationFound) -> tuple[list[str], Iterable[list[object]]]:
    """Header and rows of everybody: who, seat, verdict, a margin and what limits for each
    requirement, measures."""
    people = result.people
    names = [row.name for row in result.requirements]
    measures = [f"{name}_{'kg' if name == MASS else 'mm'}" for name in people.names]
    header = [
        "person",
        "sex",
        "weight",
        "served",
        "limiting",
        "seat_forward_mm",
        "seat_up_mm",
        "comfortable_forward_mm",
        "comfortable_up_mm",
        "fits_forward_from_mm",
        "fits_forward_to_mm",
        "fits_up_from_mm",
        "fits_up_to_mm",
        *(f"{name} [mm]" for name in names),
        *(f"{name}: limited by" for name in names),
        *measures,
    ]
    factor = np.array([1.0 if name == MASS else 1000.0 for name in people.names])
    sizes = np.round(people.measures * factor, 1).tolist()

    def rows() -> Iterable[list[object]]:
        words = np.array([*result.reasons, ""], dtype=object)[
            result.reason
        ].tolist()  # -1: the last, nothing
        served = result.served.tolist()
        seat = _cells(np.hstack([result.seat, result.comfortable, result.window]))
        margins = _cells(result.margin)
        for p, label in enumerate(_labels(result)):
            yield [
                label,
                SEXES[int(people.sex[p])],
                float(people.weight[p]),
                "yes" if served[p] else "no",
                result.limiting[p],
                *seat[p],
                *margins[p],
                *words[p],
                *sizes[p],
            ]

    return header, rows()


def _labels(result: PopulationFound) -> list[str]:
    people = result.people
    return list(people.labels) or [str(row + 1) for row in range(len(people))]


def _rows(values: Floats) -> list[Any]:
    """Lengths [m] as rows of millimetres."""
    return [_row(row) for row in values.tolist()]


def _row(metres: Iterable[float]) -> Any:
    return tuple(_mm(value) for value in metres)


def _cells(metres: Floats) -> list[list[float | None]]:
    """A table of lengths [m] in millimetres, None for NaN: many at once."""
    cells = (np.round(1000 * metres, 3) + 0.0).astype(object)
    cells[np.isnan(metres)] = None
    found: list[list[float | None]] = cells.tolist()
    return found


def _number(metres: float) -> float | None:
    return None if math.isnan(metres) else _mm(metres)


def _mm(metres: float) -> float:
    return round(1000 * metres, 3) + 0.0


def _share(share: float) -> float:
    return round(share, 6) + 0.0
