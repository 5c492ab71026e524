"""What a notebook shows of a result: what it says in words, its verdicts and shares, its pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from workbench.body.people.proportions import percent
from workbench.draw.web.notebook import notebook_html
from workbench.model.result import PopulationFound, Result
from workbench.report.headline import headline
from workbench.report.sentences import verdict_sentence

__all__ = ["result_html"]

MOST_ROWS = 20
"""Rows of a table: a notebook shows the worst, a data frame all."""


def result_html(result: Result) -> str:
    """Return a result as HTML for a notebook."""
    failed_first = sorted(result.verdicts, key=lambda verdict: verdict.passed)
    verdicts = (
        (
            verdict.criterion.name,
            "passed" if verdict.passed else "FAILED",
            verdict_sentence(verdict),
        )
        for verdict in failed_first
    )
    parts = [f"<p><b>{escape(result.study.title)}</b> {escape(headline(result))}</p>"]
    if result.verdicts:
        parts.append(_table(("criterion", "verdict", "what was found"), verdicts))
    if result.population is not None:
        parts += _shares(result.population)
    if result.warnings:
        items = (f"<li>{escape(warning)}</li>" for warning in result.warnings[:MOST_ROWS])
        parts.append(f"<ul>{''.join(items)}</ul>")
    return "\n".join([*parts, notebook_html(result) or ""])


def _shares(found: PopulationFound) -> Iterable[str]:
    """The requirements that somebody misses, the one that fewest meet first, and how many others
    there are."""
    count = len(found.served)
    order = [r for r in found.single.argsort(kind="stable").tolist() if found.single[r] < 1.0]
    rows = (
        (
            found.requirements[r].name,
            percent(float(found.single[r]), count),
            percent(float(found.only[r]), count),
            percent(float(found.without[r]), count),
        )
        for r in order
    )
    if order:
        yield _table(("requirement", "met by", "only this missed by", "fit without it"), rows)
    others = len(found.requirements) - len(order)
    yield f"<p>{others} of {len(found.requirements)} requirements are met by everybody.</p>"


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts, of which the first rows are shown."""
    lines = [list(map(escape, row)) for row in rows]
    head = "".join(f'<th style="text-align:left">{name}</th>' for name in header)
    cells = (
        "".join(f'<td style="text-align:left">{c}</td>' for c in row) for row in lines[:MOST_ROWS]
    )
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    more = len(lines) - MOST_ROWS
    return f"{table}<p>and {more} more</p>" if more > 0 else table
