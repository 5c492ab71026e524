"""The six directions of a segment, by which the paper names sides and contacts."""

from __future__ import annotations

__all__ = ["DIRECTIONS", "OPPOSITE"]

DIRECTIONS: tuple[str, ...] = ("front", "back", "left", "right", "top", "bottom")
OPPOSITE: dict[str, str] = {
    "front": "back",
    "back": "front",
    "left": "right",
    "right": "left",
    "top": "bottom",
    "bottom": "top",
}
