"""An Inspection and a result for reading."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from workbench.files.mesh_report import Described, Inspection, PartSize
from workbench.files.results.result import ResultFile

__all__ = ["inspection_lines", "result_head", "verdict_lines"]


def inspection_lines(found: Inspection) -> list[str]:
    """Lines of text: the file, its unit and size, a table of parts, warnings, and what would be
    refused."""
    lines = [*_head(found), ""]
    width = max([4, *(len(part.name) for part in found.parts)])
    lines.append(
        f"{'part':<{width}} {'faces':>8} {'polygons':>8} {'open':>6} {'degen.':>6} {'dupl.':>6}  solid  "
        f"size x y z, from x y z [mm]"
    )
    lines += [_row(part, width) for part in found.parts]
    if any(_is_turned(part) for part in found.parts):
        lines.append(
            "* wound inside out, or not all alike; turned for the question of inside and outside"
        )
    lines += [_described_line(one) for one in found.described]
    lines += [f"warning: {warning}" for warning in found.warnings]
    if found.format == "environment":
        lines += [f"assumed: {words}" for words in found.assumed]
    if found.problem:
        lines.append(f"would be refused as an environment: {found.problem}")
    return lines


def result_head(path: Path, rows: ResultFile) -> list[str]:
    """Lines that say what a result is of, and where its page lies.

    path: the file or the folder that was named.
    """
    home = path if path.is_dir() else path.parent
    what = [f"environment {rows.environment}"]
    if rows.cases:
        what.append(f"cases: {', '.join(rows.cases)}")
    names = [name for posture in rows.postures[:1] for name in (one.name for one in posture.people)]
    if names:
        what.append(f"people: {', '.join(names)}")
    if rows.population is not None:
        what.append("a population")
    lines = [f"{path}: result of study {rows.study}: {rows.title}", "; ".join(what)]
    page = home / "report.html"
    if page.is_file():
        lines.append(f"its page: {page}")
    return lines


def verdict_lines(rows: ResultFile) -> list[str]:
    """A line for each verdict of a result."""
    several = len(rows.motions) > 1
    lines = []
    for verdict in rows.verdicts:
        about = (verdict.name, verdict.row, verdict.motion if several else None)
        name = ", ".join(word for word in about if word)
        lines.append(f"{'passed' if verdict.passed else 'FAILED'}  {name}: {verdict.sentence}")
    return lines


def _head(found: Inspection) -> list[str]:
    """The file, its unit and axes, what of these was assumed, and its size."""
    faces = sum(part.faces for part in found.parts)
    polygons = sum(part.polygons for part in found.parts)
    lines = [
        f"{found.file}: {found.format}, file unit {found.metres:g} m, up {found.up}, "
        f"forward {found.forward}",
        *(f"assumed: {words}" for words in found.assumed if found.format != "environment"),
        f"size {_numbers(found.size, ' x ')} mm (x forward, y left, z up); {len(found.parts)} "
        f"parts, {faces} faces, {polygons} polygons",
    ]
    if found.format != "environment":
        sizes = ", ".join(f"{name} {metres:.4g} m" for name, metres in found.largest_if.items())
        lines.append(f"largest extent if the unit were: {sizes}")
    return lines


def _row(part: PartSize, width: int) -> str:
    """A part in the table, its name so many letters wide."""
    kind = ("yes" if part.solid else "no") + ("*" if _is_turned(part) else "")
    return (
        f"{part.name:<{width}} {part.faces:>8} {part.polygons:>8} {part.open_edges:>6} "
        f"{part.degenerate:>6} {part.duplicate:>6}  {kind:<5}  "
        f"{_numbers(part.size)}, from {_numbers(part.low)}"
    )


def _described_line(one: Described) -> str:
    """A seat, a control or another thing with its place and its part."""
    away = "" if one.gap is None else f": {1e3 * one.gap:.0f} mm from {one.part!r}"
    nearest = "" if one.named or not away else ", the nearest part"
    return f"{one.kind} {one.name!r} at ({_numbers(one.at, ', ')}) mm{away}{nearest}"


def _is_turned(part: PartSize) -> bool:
    """Whether a closed part is wound inside out, or not all alike."""
    return bool(part.watertight and (part.inverted or part.against))


def _numbers(metres: Iterable[float], between: str = " ") -> str:
    return between.join(f"{round(1e3 * value, 3) + 0.0:.5g}" for value in metres)
