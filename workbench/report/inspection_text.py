"""An Inspection for reading."""

from __future__ import annotations

from workbench.files.inspection import Inspection

__all__ = ["inspection_lines"]


def inspection_lines(found: Inspection) -> list[str]:
    """Lines of text: the file, its unit and size, a table of parts, warnings, and what would be
    refused."""
    scale, unit = (1000 * 1.0, "mm") if found.metres is not None else (1.0, "file units")
    size = " x ".join(f"{scale * s:.5g}" for s in found.size)
    told = (
        f"file unit {found.metres:g} m"
        if found.metres is not None
        else "no unit of length is known"
    )
    lines = [
        f"{found.file}: {found.format}, {told}, up {found.up}, forward {found.forward}",
        f"size {size} {unit} (x, y, z); {len(found.parts)} parts, {sum(p.faces for p in found.parts)} faces, "
        f"{sum(p.polygons for p in found.parts)} polygons",
    ]
    if found.format != "environment":
        sizes = ", ".join(f"{unit} {metres:.4g} m" for unit, metres in found.largest_if.items())
        lines.append(f"largest extent if the unit were: {sizes}")

    def numbers(values: tuple[float, ...]) -> str:
        return " ".join(f"{scale * value:.5g}" for value in values)

    width = max([4, *(len(p.name) for p in found.parts)])
    lines += [
        "",
        f"{'part':<{width}} {'faces':>8} {'polygons':>8} {'open':>6} {'degen.':>6} {'dupl.':>6}  solid  "
        f"size x y z, from x y z [{unit}]",
    ]
    for p in found.parts:
        kind = "yes" if p.solid else "no"
        kind += "*" if p.watertight and (p.inverted or p.against) else ""
        lines.append(
            f"{p.name:<{width}} {p.faces:>8} {p.polygons:>8} {p.open_edges:>6} {p.degenerate:>6} "
            f"{p.duplicate:>6}  {kind:<5}  {numbers(p.size)}, from {numbers(p.low)}"
        )
    if any(p.watertight and (p.inverted or p.against) for p in found.parts):
        lines.append(
            "* wound inside out, or not all alike; turned for the question of inside and outside"
        )
    lines += [f"warning: {warning}" for warning in found.warnings]
    if found.problem:
        lines.append(f"would be refused as an environment: {found.problem}")
    return lines
