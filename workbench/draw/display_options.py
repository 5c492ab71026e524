"""Which displays and files there are, and whether what is asked for goes together: one table, one
message a fault."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.draw.camera import VIEWS
from workbench.draw.films.motion_clips import parse_times
from workbench.draw.section_planes import SectionPlane, parse_section_plane
from workbench.errors import UsageError, one_of

__all__ = [
    "DISPLAYS",
    "ENDINGS",
    "Display",
    "DisplayOptions",
    "check_ghosts",
    "parse_display_options",
]

_LEAST = 16
_MOST = 8192  # [pixels]
_MOST_GHOSTS = 50


@dataclass(frozen=True)
class Display:
    """kind: raster (pixels) or vector (lines). styles: the first one is used where none is asked
    for."""

    kind: str
    styles: tuple[str, ...]


DISPLAYS: Mapping[str, Display] = {
    "disks": Display("raster", ("flat", "shaded", "hidden_line", "depth", "id")),
    "scanline": Display("raster", ("surface", "front")),
    "pyvista": Display("raster", ("pyvista",)),
    "outline": Display("vector", ("veiled", "hidden_line")),
    "circles": Display("vector", ("veiled", "hidden_line")),
}
ENDINGS: Mapping[
    str, tuple[str, str]
] = {  # ending -> what it holds, the display used where none is asked for
    ".png": ("raster", "disks"),
    ".svg": ("vector", "outline"),
    ".gif": ("film", "disks"),
    ".webp": ("film", "disks"),
    ".mp4": ("film", "disks"),
    ".glb": ("model", ""),
    ".stl": ("solid", ""),
    ".3mf": ("solid", ""),
}


@dataclass(frozen=True)
class DisplayOptions:
    """How a scene becomes a file. holds: raster, vector, film, model or solid; display, style: ""
    for the last two.

    view: a standard view, or eye (of the first body) or eye:NAME. width, height [pixels]. angle
    [rad]: of view from bottom to top; 0 is a parallel view. fps [frames/s], speed: of films, see
    motion.frame_times. cut: the plane that opens the environment. at [s]: the moments of a motion
    that a picture shows, (): four. trail: ghosts of earlier positions.
    """

    ending: str
    holds: str
    display: str
    style: str
    view: str = "three_quarter"
    width: int = 800
    height: int = 800
    angle: float = 0.0
    fps: float = 25.0
    speed: float = 1.0
    cut: SectionPlane | None = None
    at: tuple[float, ...] = ()
    trail: int = 0


def parse_display_options(
    out: Path,
    *,
    display: str | None = None,
    style: str | None = None,
    view: str | None = None,
    size: str | None = None,
    angle: float | None = None,
    fps: float | None = None,
    speed: float | None = None,
    cut: str | None = None,
    at: str | None = None,
    trail: int | None = None,
) -> DisplayOptions:
    """The look of the file `out`, whose ending decides what it holds. UsageError for the first
    thing that cannot be.

    size: "800" or "1280x720" [pixels]. angle [degrees]. cut: see cutting.cut_of. at: see
    recorded.instants_of.
    """
    ending = _ending(out)
    holds, usual = ENDINGS[ending]
    picture = {
        "--display": display,
        "--style": style,
        "--view": view,
        "--size": size,
        "--angle": angle,
        "--cut": cut,
        "--trail": trail,
    }
    _check_holds(ending, holds, picture, {"--fps": fps, "--speed": speed}, at)
    chosen = _display(ending, holds, display or _display_of(style, usual))
    width, height = _pixels(size)
    look = DisplayOptions(
        ending=ending,
        holds=holds,
        display=chosen,
        style=_style(chosen, style),
        view=_view(view or "three_quarter"),
        width=width,
        height=height,
        angle=_radians(angle or 0.0),
        fps=25.0 if fps is None else fps,
        speed=1.0 if speed is None else speed,
        cut=None if cut is None else parse_section_plane(cut),
        at=() if at is None else parse_times(at),
        trail=0 if trail is None else _ghosts(trail),
    )
    if look.trail:
        check_ghosts(look, "--trail")
    return look


def _ending(out: Path) -> str:
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        raise UsageError(f"{out}: the ending says what to make; valid: {', '.join(ENDINGS)}")
    return ending


def check_ghosts(look: DisplayOptions, flag: str) -> None:
    """UsageError where a look's display shows no ghosts, which `flag` asks for."""
    if look.display == "scanline" or look.style in ("depth", "id"):
        raise UsageError(
            f"{flag}: the display {look.display} in the style {look.style} shows no pale bodies behind"
        )
    if look.holds == "solid":
        raise UsageError(
            f"{flag}: a {look.ending} file holds one pose of a body, nothing pale behind it"
        )


def _check_holds(
    ending: str,
    holds: str,
    picture: Mapping[str, object],
    rates: Mapping[str, object],
    at: str | None,
) -> None:
    if holds in ("model", "solid"):
        _refuse(picture, f"a {ending} file holds a body in three dimensions, no picture")
    if holds != "film":
        _refuse(rates, f"a {ending} file is no film; films are .mp4, .gif and .webp")
    if holds in ("film", "model"):
        _refuse(
            {"--at": at}, f"a {ending} file shows the whole motion; --start and --end choose a part"
        )


def _ghosts(trail: int) -> int:
    if not 0 <= trail <= _MOST_GHOSTS:
        raise UsageError(
            f"--trail: 0 to {_MOST_GHOSTS} earlier positions are possible, got {trail}"
        )
    return trail


def _refuse(given: Mapping[str, object], why: str) -> None:
    named = [flag for flag, value in given.items() if value is not None]
    if named:
        raise UsageError(f"{why}: leave out {' and '.join(named)}")


def _display_of(style: str | None, usual: str) -> str:
    """The display that has a style, where none is named; the usual one of the file first."""
    kind = DISPLAYS[usual].kind if usual else ""
    having = [
        name for name, entry in DISPLAYS.items() if entry.kind == kind and style in entry.styles
    ]
    return having[0] if having and usual not in having else usual


def _display(ending: str, holds: str, display: str) -> str:
    if not display:
        return ""
    if display not in DISPLAYS:
        raise UsageError(f"no display {display!r}; {one_of(display, DISPLAYS)}")
    kind = "vector" if holds == "vector" else "raster"
    if DISPLAYS[display].kind != kind:
        fit = ", ".join(name for name, entry in DISPLAYS.items() if entry.kind == kind)
        other = ".svg" if kind == "raster" else ".png, .gif, .webp or .mp4"
        raise UsageError(
            f"the display {display} makes {other}, not {ending}; for {ending} take {fit}"
        )
    return display


def _style(display: str, style: str | None) -> str:
    if not display:
        return ""
    styles = DISPLAYS[display].styles
    if style is not None and style not in styles:
        raise UsageError(f"the display {display} has no style {style!r}; {one_of(style, styles)}")
    return style or styles[0]


def _view(view: str) -> str:
    if view not in VIEWS and view != "eye" and not view.startswith("eye:"):
        raise UsageError(f"no view {view!r}; {one_of(view, [*VIEWS, 'eye', 'eye:NAME'])}")
    return view


def _pixels(size: str | None) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,9})(?:[xX](\d{1,9}))?", size or "800")
    if found is None:
        raise UsageError(f"--size: pixels such as 800 or 1280x720 are needed, got {size!r}")
    width = int(found[1])
    height = int(found[2] or found[1])
    if not (_LEAST <= width <= _MOST and _LEAST <= height <= _MOST):
        raise UsageError(
            f"--size: a picture of {_LEAST} to {_MOST} pixels each way is possible, got {width}x{height}"
        )
    return width, height


def _radians(angle: float) -> float:
    if not 0.0 <= angle <= 170.0:
        raise UsageError(f"--angle: 0 (a parallel view) to 170 degrees are possible, got {angle:g}")
    return math.radians(angle)
