"""`workbench render`: pictures, films and models of a body, an environment, a mesh, a study or a
result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from workbench.cli.progress import Progress, emit, tell
from workbench.errors import UsageError

if TYPE_CHECKING:
    from workbench.draw.display_options import DisplayOptions
    from workbench.draw.source import Source

__all__ = ["MeshSays", "Movement", "Picture", "render"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Picture:
    """How it is drawn.

    Parameters
    ----------
    display
        disks, scanline or pyvista for .png and films; outline or circles for .svg; directions and
        ground for both: what somebody's two eyes see in every direction, and of the ground
    style
        of disks: flat, shaded, hidden_line, depth or id; of scanline: surface or front; of outline
        and circles: veiled (pale behind walls) or hidden_line; pyvista; of directions: equal_area
        or polar; of ground: plan, or mirrors (what is seen in each). Where no display is named, the style chooses it
    view
        front, back, left, right, top, bottom, corner; eye (between the eyes of the first body),
        left_eye, right_eye or both_eyes (one over the other); eye:NAME of a person, or of a point
        of the environment where eyes are
    size
        pixels, 800 or 1280x720
    angle
        of view from bottom to top in degrees, for a perspective picture; 0 is a parallel view
    cut
        opens the environment: the side that goes (left, right, front, back, top, bottom), by a
        plane through the middle of the bodies or at a place, left=0.3 or left=300mm; x=, y= or z=
        takes the viewer's side. Bodies stay whole
    look_at
        the control, part or point that these eyes look at
    ground
        height of the ground in metres, for the display ground; of the point ground, or the lowest
        point of the environment, where not given
    outline
        a rule set and the seat, such as sight_ac_25_773_1:left: drawn over the display directions,
        whose solid angles are then of the inside; sight_un_r46: the ground that it asks for in
        mirrors, drawn over the style mirrors
    marks
        axes, clearances, contacts, controls, segments, stops; with commas between
    fps
        frames a second of a film
    speed
        seconds of a motion in a second of its film; 0.1 is ten times slow motion
    """

    display: str | None = None
    style: str | None = None
    view: str | None = None
    size: str | None = None
    angle: float | None = None
    cut: str | None = None
    look_at: str | None = None
    ground: Annotated[float | None, Parameter(allow_leading_hyphen=True)] = None
    outline: str | None = None
    marks: str | None = None
    fps: float | None = None
    speed: float | None = None


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Movement:
    """What moves.

    Parameters
    ----------
    motion
        a motion file (CSV, BVH, TRC, C3D, MOT, STO) that the body makes, or the first person of the
        study, or NAME=FILE
    over
        what lies pale behind in a second colour, predicted over actual: another motion file, or
        another body, study or result
    at
        the moments of a motion that a picture shows side by side, in s or ms: 0,0.05,90ms; four
        where not given
    trail
        so many earlier positions are shown pale behind each
    start
        first time wanted of the motion files [s]
    end
        last time wanted of the motion files [s]
    up
        the upward axis of the motion files, or of a mesh, where it is not told right: x, y, z, -x,
        -y, -z
    unit
        one unit of the motion files, where they do not say it, such as '1 cm'
    names
        a YAML file that says what the bones, markers or coordinates of the motion files are
    """

    motion: str | None = None
    over: str | None = None
    at: str | None = None
    trail: int | None = None
    start: float | None = None
    end: float | None = None
    up: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    unit: str | None = None
    names: Path | None = None


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class MeshSays:
    """How a bare mesh is taken, where its file does not say it right.

    Parameters
    ----------
    units
        the unit of length of a mesh file: mm, cm, m, in or ft
    forward
        the forward axis of a mesh file, such as x or -y
    """

    units: str | None = None
    forward: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None


def render(
    *sources: str,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    pose: str | None = None,
    case: str | None = None,
    study: str | None = None,
    picture: Picture = Picture(),
    movement: Movement = Movement(),
    mesh: MeshSays = MeshSays(),
) -> int:
    """Draw a body, an environment, a mesh, a study or a result; the ending of the file says what is
    made.

    .png and .svg are pictures, .gif, .webp and .mp4 films, .glb a model with its motion, .stl and
    .3mf the body as one solid. Several poses or cases stand side by side in a picture and move from
    one to the next in a film of a body; a film of what does not move goes round it.

    Parameters
    ----------
    sources
        a body, an environment, a study or a result: a file, a folder or a name; or mesh files that
        stand in one frame, each with a move where it needs one (wheel.stl@400mm,0,250mm: so much
        forward, left and up)
    out
        the file to write
    pose
        the posture of a body, or several with commas between
    case
        the case of a study, or several with commas between; its first where not given
    study
        of a result: the file of its study, where it lies neither near the result nor in the
        catalogue
    """
    from workbench.files.output_file import check_file

    options = _options(out, picture, movement)
    bare = _are_meshes(sources, mesh, movement, {"--pose": pose, "--case": case, "--study": study})
    check_file(out)
    from workbench.draw.marks.annotations import with_marks
    from workbench.draw.render import left_out_words
    from workbench.draw.render import render as write
    from workbench.draw.scene_builder import mesh_source

    with Progress() as say:
        say(f"reading {' and '.join(sources)}")
        if bare:
            found = mesh_source(sources, length=mesh.units, up=movement.up, forward=mesh.forward)
        else:
            found = _found(_Shown(sources[0], pose, case, study), movement)
        check_file(out)  # again, now that all inputs are known
        if picture.marks is not None:
            found = with_marks(found, tuple(name.strip() for name in picture.marks.split(",")))
        write(found, options, out, progress=lambda done, count: say(f"frame {done} of {count}"))
        said = left_out_words(found, options)
    for note in (*found.notes, *said):
        tell(note)
    emit(out)
    return 0


def _are_meshes(
    sources: Sequence[str], mesh: MeshSays, movement: Movement, others: dict[str, str | None]
) -> bool:
    """Whether bare meshes are drawn.

    others: options that a mesh has no use for. UsageError where sources or options do not go
    together.
    """
    from workbench.files.kinds import is_mesh

    if not sources:
        raise UsageError(
            "workbench render: name a body, an environment, a mesh, a study or a result"
        )
    found = [is_mesh(source) for source in sources]
    if len(sources) > 1 and not all(found):
        odd = sources[found.index(False)]
        raise UsageError(f"{odd}: several sources are drawn together only where all are mesh files")
    if all(found):
        others = others | {"--motion": movement.motion, "--over": movement.over}
        for option, value in others.items():
            if value is not None:
                raise UsageError(f"{sources[0]} is a mesh: leave out {option}")
    elif (mesh.units, mesh.forward) != (None, None):
        raise UsageError("--units and --forward are for mesh files; an environment says its own")
    return all(found)


def _options(out: Path, picture: Picture, movement: Movement) -> DisplayOptions:
    from workbench.draw.display_options import check_ghosts, parse_display_options

    options = parse_display_options(
        out,
        display=picture.display,
        style=picture.style,
        view=picture.view,
        size=picture.size,
        angle=picture.angle,
        fps=picture.fps,
        speed=picture.speed,
        cut=picture.cut,
        at=movement.at,
        trail=movement.trail,
        look_at=picture.look_at,
        ground=picture.ground,
        outline=picture.outline,
    )
    if movement.over is not None:
        check_ghosts(options, "--over")
    return options


@dataclass(frozen=True)
class _Shown:
    """What is drawn: the source, the postures of a body, the cases of a study, the study of a
    result."""

    source: str
    pose: str | None
    case: str | None
    study: str | None


def _found(shown: _Shown, movement: Movement) -> Source:
    """What is to be drawn, in motion where that is asked for, and over what lies under it."""
    from workbench.cli.motion import frame_range, motion_options
    from workbench.draw.films.motion_clips import is_motion, overlay, with_motion
    from workbench.draw.scene_builder import build_source

    motion = movement.motion
    over = movement.over
    given = (movement.start, movement.end, movement.up, movement.unit, movement.names)
    if (
        any(value is not None for value in given)
        and motion is None
        and not (over and is_motion(over))
    ):
        raise UsageError(
            "--start, --end, --up, --unit and --names are about a motion file: give one by --motion"
        )
    clip = motion_options(
        up=movement.up,
        unit=movement.unit,
        names=movement.names,
        frames=frame_range(movement.start, movement.end),
    )
    if motion is not None and shown.pose is not None:
        raise UsageError(
            "a body stands in a posture or makes a motion: leave out --pose or --motion"
        )
    if motion is None:
        found = build_source(shown.source, poses=shown.pose, case=shown.case, study=shown.study)
    else:
        found = with_motion(shown.source, motion, clip=clip, case=shown.case)
    if over is None:
        return found
    if is_motion(over):
        under = with_motion(shown.source, over, clip=clip, case=shown.case)
    else:
        under = build_source(over, poses=shown.pose, case=shown.case)
    return overlay(found, under, _names(motion or shown.source, over))


def _names(first: str, second: str) -> tuple[str, str]:
    """The last parts of two paths, as many as tell them apart."""
    parts = [Path(path).parts for path in (first, second)]
    count = next((n for n in range(1, 9) if parts[0][-n:] != parts[1][-n:]), 1)
    one, two = (str(Path(*path[-count:])) for path in parts)
    return one, two
