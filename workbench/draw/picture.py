"""Draw into a file, from Python."""

from __future__ import annotations

from pathlib import Path

from workbench.draw.display_options import parse_display_options
from workbench.draw.render import render as write
from workbench.draw.scene_builder import Drawn, source_of
from workbench.model.environment import Environment

__all__ = ["render"]


def render(
    source: Drawn,
    out: str | Path,
    *,
    environment: Environment | None = None,
    posture: str | None = None,
    case: str | None = None,
    view: str | None = None,
    size: str | None = None,
    display: str | None = None,
    style: str | None = None,
    cut: str | None = None,
    angle: float | None = None,
    look_at: str | None = None,
    ground: float | None = None,
    outline: str | None = None,
) -> Path:
    """Draw something into a file, whose ending says what is made.

    .png and .svg are pictures, .gif, .webp and .mp4 films, .glb a model, .stl and .3mf a body as one
    solid; as `workbench render` does it.

    Parameters
    ----------
    source
        A name of the catalogue, a path, an environment, a placed body (each pose a body), a study, a
        result or a scene.
    out
        The file, which is replaced.
    environment
        Around a placed body.
    posture, case
        Of a body's file or name, and of a study or result; with commas between.
    view
        A standard view ("left", "top", "corner", ...); or "eye", "left_eye", "right_eye" or
        "both_eyes", with ":NAME" of a person, or of a point where eyes are.
    size
        "800" or "1280x720" [pixels].
    display, style
        See docs/displays.md.
    cut
        The side that is cut away: "left", "left=0.3" [m], "left=300mm".
    angle
        Angle of view [degrees].
    look_at
        A control, part or point that these eyes look at.
    ground
        Height [m] of the ground of the display "ground".
    outline
        A rule set and the seat, "sight_ac_25_773_1:left": drawn over the display "directions".

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If a file or a name does not exist or cannot be read or written.
    UsageError
        If an option does not suit the file or the source.
    """
    path = Path(out)
    options = parse_display_options(
        path,
        view=view,
        size=size,
        display=display,
        style=style,
        cut=cut,
        angle=angle,
        look_at=look_at,
        ground=ground,
        outline=outline,
    )
    write(source_of(source, posture=posture, case=case, environment=environment), options, path)
    return path
