"""An Inspection for reading."""

from __future__ import annotations

from collections.abc import Iterable

from workbench.files.inspection import Inspection, PartSize

__all__ = ["inspection_lines"]


def inspection_lines(found: Inspection) -> list[str]:
    """Lines of text: the file, its unit and size, a table of parts, warnings, and what would be
    refused."""
    scale, unit = (1000.0, "mm") if found.metres is not None else (1.0, "file units")
    lines = [*_head(found, scale, unit), ""]
    width = max([4, *(len(part.name) for part in found.parts)])
    lines.append(
        f"{'part':<{width}} {'faces':>8} {'polygons':>8} {'open':>6} {'degen.':>6} {'dupl.':>6}  solid  "
        f"size x y z, from x y z [{unit}]"
    )
    lines += [_row(part, width, scale) for part in found.parts]
    if any(_is_turned(part) for part in found.parts):
        lines.append(
            "* wound inside out, or not all alike; turned for the question of inside and outside"
        )
    lines += [f"warning: {warning}" for warning in found.warnings]
    lines += [f"assumed: {words}" for words in found.assumed]
    if found.problem:
        lines.append(f"would be refused as an environment: {found.problem}")
    return lines


def _head(found: Inspection, scale: float, unit: str) -> list[str]:
    """The file, its unit and axes, and its size. scale: the unit in units of the file."""
    known = "no unit of length is known"
    if found.metres is not None:
        known = f"file unit {found.metres:g} m"
    faces = sum(part.faces for part in found.parts)
    polygons = sum(part.polygons for part in found.parts)
    lines = [
        f"{found.file}: {found.format}, {known}, up {found.up}, forward {found.forward}",
        f"size {_numbers(found.size, scale, ' x ')} {unit} (x, y, z); {len(found.parts)} parts, "
        f"{faces} faces, {polygons} polygons",
    ]
    if found.format != "environment":
        sizes = ", ".join(f"{name} {metres:.4g} m" for name, metres in found.largest_if.items())
        lines.append(f"largest extent if the unit were: {sizes}")
    return lines


def _row(part: PartSize, width: int, scale: float) -> str:
    """A part in the table, its name so many letters wide."""
    kind = ("yes" if part.solid else "no") + ("*" if _is_turned(part) else "")
    return (
        f"{part.name:<{width}} {part.faces:>8} {part.polygons:>8} {part.open_edges:>6} "
        f"{part.degenerate:>6} {part.duplicate:>6}  {kind:<5}  "
        f"{_numbers(part.size, scale)}, from {_numbers(part.low, scale)}"
    )


def _is_turned(part: PartSize) -> bool:
    """Whether a closed part is wound inside out, or not all alike."""
    return bool(part.watertight and (part.inverted or part.against))


def _numbers(values: Iterable[float], scale: float, between: str = " ") -> str:
    return between.join(f"{scale * value:.5g}" for value in values)
