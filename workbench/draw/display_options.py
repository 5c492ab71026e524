"""Choose a display for an output file, and check that the options go together."""

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
    "EYE_VIEWS",
    "Display",
    "DisplayOptions",
    "FileKind",
    "check_ghosts",
    "parse_display_options",
]

_MIN_PIXELS = 16
_MAX_PIXELS = 8192
_MAX_GHOSTS = 50
EYE_VIEWS = ("eye", "left_eye", "right_eye", "both_eyes")
"""Views from between the eyes of a body, from one eye, and from both."""
_OLD_VIEWS = {"three_quarter": "corner"}
"""Views by the names that they had."""


@dataclass(frozen=True)
class Display:
    """A way to draw a scene."""

    kind: str
    """raster (pixels), vector (lines), or chart (either, without a camera)."""
    styles: tuple[str, ...]
    """The first one is the default."""


DISPLAYS: Mapping[str, Display] = {
    "disks": Display("raster", ("flat", "shaded", "hidden_line", "depth", "id")),
    "scanline": Display("raster", ("surface", "front")),
    "pyvista": Display("raster", ("pyvista",)),
    "outline": Display("vector", ("veiled", "hidden_line")),
    "circles": Display("vector", ("veiled", "hidden_line")),
    "directions": Display("chart", ("equal_area", "polar")),
    "ground": Display("chart", ("plan", "mirrors")),
}


@dataclass(frozen=True)
class FileKind:
    """What a file with some ending holds."""

    holds: str
    """raster, vector, film, model or solid."""
    display: str
    """The default display, "" for models and solids."""


ENDINGS: Mapping[str, FileKind] = {
    ".png": FileKind("raster", "disks"),
    ".svg": FileKind("vector", "outline"),
    ".gif": FileKind("film", "disks"),
    ".webp": FileKind("film", "disks"),
    ".mp4": FileKind("film", "disks"),
    ".glb": FileKind("model", ""),
    ".stl": FileKind("solid", ""),
    ".3mf": FileKind("solid", ""),
}


@dataclass(frozen=True)
class DisplayOptions:
    """How a scene becomes a file."""

    ending: str
    holds: str
    """raster, vector, film, model or solid."""
    display: str
    """A key of `DISPLAYS`, "" for models and solids."""
    style: str
    view: str = "corner"
    """A standard view, or one of `EYE_VIEWS`: of the first body, or with ":NAME" of another."""
    width: int = 800
    height: int = 800
    angle: float = 0.0
    """Angle of view [rad] from bottom to top; 0 for a parallel view."""
    fps: float = 25.0
    """Frames per second of a film."""
    speed: float = 1.0
    """Seconds of the motion in a second of its film."""
    cut: SectionPlane | None = None
    """The plane that opens the environment."""
    at: tuple[float, ...] = ()
    """Times [s] of a motion that a picture shows side by side; empty for four evenly spaced."""
    trail: int = 0
    """Number of ghosts of earlier positions."""
    look_at: str = ""
    """The control, part or point that the eyes look at; straight ahead and down as usual if ""."""
    ground: float | None = None
    """Height [m] of the ground of a plan, see `ground_plan.ground_level` if None."""
    outline: str = ""
    """The rule set whose outline is drawn over directions, with ":left" or ":right" for the seat."""

    @property
    def of_eyes(self) -> bool:
        """Whether it is seen from somebody's eyes."""
        return self.view.partition(":")[0] in EYE_VIEWS

    @property
    def onlooker(self) -> str:
        """Whose eyes those are, "" for the first body."""
        return self.view.partition(":")[2] if self.of_eyes else ""

    @property
    def is_chart(self) -> bool:
        """Whether its display has no camera."""
        return self.display in DISPLAYS and DISPLAYS[self.display].kind == "chart"


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
    look_at: str | None = None,
    ground: float | None = None,
    outline: str | None = None,
) -> DisplayOptions:
    """Read the options of `workbench render` for an output file; None is an option not given.

    Parameters
    ----------
    out
        The output file. Its ending decides what it holds.
    display, style
        A key of `DISPLAYS`, and one of its styles.
    view
        A standard view, or "eye", "left_eye", "right_eye" or "both_eyes", with ":NAME" of somebody.
    size
        "800" or "1280x720" [pixels].
    angle
        Angle of view [degrees].
    fps, speed
        Frames per second and speed of a film.
    cut
        See `section_planes.parse_section_plane`.
    at
        See `motion_clips.parse_times`.
    trail
        Number of ghosts.
    look_at
        A control, part or point that the eyes of an eye view look at.
    ground
        Height [m] of the ground of the display "ground".
    outline
        A rule set, and the seat: "sight_ac_25_773_1:left", of the display "directions".

    Raises
    ------
    UsageError
        If an option is out of range or does not suit the file or the display.
    """
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        raise UsageError(f"{out}: the ending says what to make; valid: {', '.join(ENDINGS)}")
    kind = ENDINGS[ending]
    pictures: dict[str, object] = {"display": display, "style": style, "view": view, "size": size}
    pictures |= {"angle": angle, "cut": cut, "trail": trail, "look-at": look_at, "ground": ground}
    pictures["outline"] = outline
    _check_file_kind(ending, kind.holds, pictures, {"fps": fps, "speed": speed}, at)
    chosen = _display(ending, kind.holds, display or _display_with_style(style, kind.display))
    width, height = _pixels(size)
    options = DisplayOptions(
        ending,
        kind.holds,
        chosen,
        _style(chosen, style),
        _view(view or "corner"),
        width,
        height,
        angle=_radians(angle or 0.0),
        fps=25.0 if fps is None else fps,
        speed=1.0 if speed is None else speed,
        cut=None if cut is None else parse_section_plane(cut),
        at=() if at is None else parse_times(at),
        trail=_ghosts(trail or 0),
        look_at=look_at or "",
        ground=ground,
        outline=outline or "",
    )
    if options.trail:
        check_ghosts(options, "--trail")
    _check_eyes(options)
    return options


def _check_eyes(options: DisplayOptions) -> None:
    """Refuse what eyes, and charts of what they see, have no use for."""
    kind = options.view.partition(":")[0]
    if options.is_chart and kind not in ("corner", "eye", "both_eyes"):
        raise UsageError(
            f"view {options.view}: the display {options.display} shows what both eyes of somebody "
            "see; leave out --view, or name the person by --view eye:NAME"
        )
    if options.is_chart and (options.cut or options.angle):
        raise UsageError(
            f"the display {options.display} has no camera: leave out --cut and --angle"
        )
    if options.ground is not None and options.display != "ground":
        raise UsageError("--ground: the height of the ground is for --display ground")
    mirrors = options.style == "mirrors"
    if options.outline and options.display != "directions" and not mirrors:
        raise UsageError(
            "--outline: the outline of a rule is for --display directions, the ground that it asks "
            "for in mirrors for --display ground --style mirrors"
        )
    if (
        options.outline
        and options.outline.partition(":")[2] not in ("left", "right")
        and not mirrors
    ):
        raise UsageError(
            f"--outline: a rule set and the seat are needed, such as sight_ac_25_773_1:left, got "
            f"{options.outline!r}"
        )
    if options.look_at and (options.is_chart or not options.of_eyes):
        raise UsageError(f"--look-at: eyes look at it; take a view of {', '.join(EYE_VIEWS)}")
    if kind == "both_eyes" and options.holds == "vector" and not options.is_chart:
        raise UsageError(
            f"view {options.view}: lines of two eyes over each other cannot be read; take .png, "
            "or left_eye or right_eye"
        )


def check_ghosts(options: DisplayOptions, flag: str) -> None:
    """Raise `UsageError` if the display cannot show the ghosts that `flag` asks for."""
    if options.is_chart or options.display == "scanline" or options.style in ("depth", "id"):
        raise UsageError(
            f"{flag}: the display {options.display} in the style {options.style} shows no pale "
            "bodies behind"
        )
    if options.holds == "solid":
        raise UsageError(
            f"{flag}: a {options.ending} file holds one pose of a body, nothing pale behind it"
        )


def _check_file_kind(
    ending: str,
    holds: str,
    pictures: Mapping[str, object],
    rates: Mapping[str, object],
    at: str | None,
) -> None:
    """Refuse options of pictures, of films and of moments for a file that has none."""
    if holds in ("model", "solid"):
        _refuse(pictures, f"a {ending} file holds a body in three dimensions, no picture")
    if holds != "film":
        _refuse(rates, f"a {ending} file is no film; films are .mp4, .gif and .webp")
    if holds in ("film", "model"):
        whole = f"a {ending} file shows the whole motion; --start and --end choose a part"
        _refuse({"at": at}, whole)


def _refuse(given: Mapping[str, object], reason: str) -> None:
    named = [f"--{option}" for option, value in given.items() if value is not None]
    if named:
        raise UsageError(f"{reason}: leave out {' and '.join(named)}")


def _ghosts(trail: int) -> int:
    if not 0 <= trail <= _MAX_GHOSTS:
        raise UsageError(f"--trail: 0 to {_MAX_GHOSTS} earlier positions are possible, got {trail}")
    return trail


def _display_with_style(style: str | None, default: str) -> str:
    """Return the display that has a style: the default of the file if it has, else the first."""
    kinds = (DISPLAYS[default].kind, "chart") if default else ()
    suitable = [
        name for name, entry in DISPLAYS.items() if entry.kind in kinds and style in entry.styles
    ]
    return suitable[0] if suitable and default not in suitable else default


def _display(ending: str, holds: str, display: str) -> str:
    if not display:
        return ""
    if display not in DISPLAYS:
        raise UsageError(f"no display {display!r}; {one_of(display, DISPLAYS)}")
    kind = "vector" if holds == "vector" else "raster"
    if DISPLAYS[display].kind not in (kind, "chart"):
        suitable = ", ".join(
            name for name, entry in DISPLAYS.items() if entry.kind in (kind, "chart")
        )
        other = ".svg" if kind == "raster" else ".png, .gif, .webp or .mp4"
        raise UsageError(
            f"the display {display} makes {other}, not {ending}; for {ending} take {suitable}"
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
    view = _OLD_VIEWS.get(view, view)
    if view not in VIEWS and view.partition(":")[0] not in EYE_VIEWS:
        valid = [*VIEWS, *EYE_VIEWS, *(f"{kind}:NAME" for kind in EYE_VIEWS)]
        raise UsageError(f"no view {view!r}; {one_of(view, valid)}")
    return view


def _pixels(size: str | None) -> tuple[int, int]:
    """Return width and height of "800" or "1280x720"; 800 x 800 if None."""
    match = re.fullmatch(r"(\d{1,9})(?:[xX](\d{1,9}))?", size or "800")
    if match is None:
        raise UsageError(f"--size: pixels such as 800 or 1280x720 are needed, got {size!r}")
    width = int(match[1])
    height = int(match[2] or match[1])
    if not all(_MIN_PIXELS <= side <= _MAX_PIXELS for side in (width, height)):
        raise UsageError(
            f"--size: a picture of {_MIN_PIXELS} to {_MAX_PIXELS} pixels each way is possible, "
            f"got {width}x{height}"
        )
    return width, height


def _radians(angle: float) -> float:
    if not 0.0 <= angle <= 170.0:
        raise UsageError(f"--angle: 0 (a parallel view) to 170 degrees are possible, got {angle:g}")
    return math.radians(angle)
