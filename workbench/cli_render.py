"""`workbench render`: pictures, films and models of a body, an environment, a study or a result."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from workbench.cli_progress import Progress, tell

__all__ = ["render"]


def render(
    source: str,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    pose: str | None = None,
    case: str | None = None,
    display: str | None = None,
    style: str | None = None,
    view: str | None = None,
    size: str | None = None,
    angle: float | None = None,
    marks: str | None = None,
    fps: float | None = None,
    speed: float | None = None,
) -> int:
    """Draw a body, an environment, a study or a result; the ending of the file says what is made.

    .png and .svg are pictures, .gif, .webp and .mp4 films, .glb a model with its motion, .stl and .3mf the body as one
    solid. Several poses or cases stand side by side in a picture and move from one to the next in a film of a body; a
    film of what does not move goes round it.

    Parameters
    ----------
    source
        a body, an environment, a study or a result: a file, a folder or a name
    out
        the file to write
    pose
        the posture of a body, or several with commas between
    case
        the case of a study, or several with commas between; its first where not given
    display
        disks, scanline or pyvista for .png and films; outline or circles for .svg
    style
        of disks: flat, shaded, hidden_line, depth or id; of scanline: surface or front; of outline and circles: veiled
        (pale behind walls) or hidden_line
    view
        front, back, left, right, top, bottom, three_quarter, eye (of the first body) or eye:NAME
    size
        pixels, 800 or 1280x720
    angle
        of view from bottom to top in degrees, for a perspective picture; 0 is a parallel view
    marks
        axes, clearances, contacts, controls, segments, stops; with commas between
    fps
        frames a second of a film
    speed
        seconds of a motion in a second of its film; 0.1 is ten times slow motion
    """
    from workbench.draw.looks import look_for

    look = look_for(out, display=display, style=style, view=view, size=size, angle=angle, fps=fps, speed=speed)
    from workbench.draw.render import marked
    from workbench.draw.render import render as write
    from workbench.draw.sources import source_of

    with Progress() as say:
        say(f"reading {source}")
        found = source_of(source, poses=pose, case=case)
        if marks is not None:
            found = marked(found, tuple(name.strip() for name in marks.split(",")))
        write(found, look, out, progress=lambda done, count: say(f"frame {done} of {count}"))
    for note in found.notes:
        tell(note)
    print(out)
    return 0
