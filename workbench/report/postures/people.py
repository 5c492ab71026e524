"""The people of a study on its page: size and percentiles, seat, eyes, detail, joint angles."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.body.people.percentile import percentile_values
from workbench.draw.eye_view import eye_point
from workbench.draw.scene import SceneBody
from workbench.files.results.postures import PersonRow, PosturesRows
from workbench.model.person import Size
from workbench.model.population import MASS, PopulationModel
from workbench.model.result import PersonFound, PosturesFound
from workbench.model.units import plain
from workbench.report.joint_angles import angle_rows
from workbench.report.postures.held import posture_words
from workbench.report.section import Making, Section
from workbench.report.templates import template

__all__ = ["people_sections"]

_LEVELS = np.arange(1.0, 100.0)
"""Percentiles between which a measure is placed."""


def people_sections(
    result: PosturesFound, rows: PosturesRows, making: Making, *, end: str = ""
) -> list[Section]:
    """Who the people are, and how each of them is in each case.

    Parameters
    ----------
    making
        What the sections of the page share.
    end
        The end of the anchors of these sections.
    """
    people = [
        _person(found, row, result.cases)
        for found, row in zip(result.people, rows.people, strict=True)
    ]
    html = template("postures/people.html.j2").render(
        people=people, cases=result.cases, making=making
    )
    size = f": {rows.row}" if rows.row else ""
    return [Section("people", f"people{end}", f"People{size}", Markup(html))]


def _person(found: PersonFound, row: PersonRow, cases: tuple[str, ...]) -> dict[str, Any]:
    body = found.body
    size = found.role.size
    return {
        "name": row.name,
        "description": row.description,
        "detail": f"{len(body.sphere_names):,} spheres"
        + (f" (level of detail {body.detail})" if body.detail else ""),
        "measures": [_measure(size, name) for name in size.measures] if size is not None else [],
        "source": size.population.name if size is not None else "",
        "postures": [
            (case, posture_words(found, index), _eyes(found, index))
            for index, case in enumerate(cases)
        ],
        "angles": angle_rows(body, [posture.angles_deg for posture in row.postures]),
    }


def _measure(size: Size, name: str) -> tuple[str, str, str]:
    """A measure, its value, and its percentile among people of the same sex; "" where not known."""
    value = size.measures[name]
    text = f"{value:.1f} kg" if name == MASS else f"{1000 * value:,.0f} mm"
    return plain(name), text, _percentile(size, name, value)


def _percentile(size: Size, name: str, value: float) -> str:
    people = size.population
    if not isinstance(people, PopulationModel) or name not in people.names:
        return ""
    column = percentile_values(people, size.sex, _LEVELS)[:, people.names.index(name)]
    if value < column[0]:
        return "below the 1st"
    return "above the 99th" if value > column[-1] else f"{np.interp(value, column, _LEVELS):.0f}"


def _eyes(found: PersonFound, pose: int) -> str:
    """The point between the eyes [mm], "" of a body without eyes."""
    if not any(name.endswith("eye") for name in found.body.sphere_names):
        return ""
    point, _ = eye_point(SceneBody(found.placed, pose))
    x, y, z = (round(1000 * value) + 0 for value in point.tolist())
    return f"{x}, {y}, {z}"
