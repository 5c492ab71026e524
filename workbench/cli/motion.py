"""`workbench motion show|convert|simulate`: recorded motion, looked through and written in another
form; a motion file from a simulated crash."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from workbench.cli.progress import Progress, emit, tell
from workbench.errors import UsageError, one_of

if TYPE_CHECKING:
    from workbench.files.crash.simulations import SimulationPlan
    from workbench.files.motions.number_rows import FrameRange
    from workbench.files.output_file import Content
    from workbench.model.body import Body
    from workbench.model.poses import Poses
    from workbench.model.simulation import Simulated
    from workbench.study.motions import MotionOptions

__all__ = [
    "Names",
    "Unit",
    "frame_range",
    "motion_app",
    "motion_options",
]

_MOST_HELD = 100_000
"""Frames of a model or a score at most: they are made in memory."""
motion_app = App(name="motion", help="Motion files: look through them, write them in another form.")

Start = Annotated[float | None, Parameter(help="first time wanted [s]")]
End = Annotated[float | None, Parameter(help="last time wanted [s]")]
Unit = Annotated[str | None, Parameter(help="one unit of a BVH or marker file, such as '1 cm'")]
Names = Annotated[
    Path | None,
    Parameter(
        help="YAML file that says which bone is which segment (LUA: lhumerus), or what a marker or "
        "coordinate is usually called (hip1: LASI; '' leaves it out)"
    ),
]
Scale = Annotated[
    Literal["body", "subject"],
    Parameter(help="subject: the body takes the lengths of limbs that the file tells"),
]

Frames = Annotated[
    Literal["as_stated", "as_read"],
    Parameter(help="as_read: accept a header that states a wrong number of frames"),
]


@motion_app.command
def show(
    motion: Path,
    *,
    body: str = "bubbleman",
    up: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    unit: Unit = None,
    names: Names = None,
    scale: Scale = "body",
    start: Start = None,
    end: End = None,
    every: int = 1,
    frames: Frames = "as_stated",
    as_json: Annotated[
        bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")
    ] = False,
) -> int:
    """Show what a motion file holds when a body makes its movement.

    Parameters
    ----------
    motion
        a CSV, BVH, TRC, C3D, MOT, STO or LABAN file
    body
        the body that moves, by name or file
    up
        the file's upward axis, where it is not told right: x, y, z, -x, -y, -z
    every
        keep every n-th frame
    """
    from workbench.report.motions.movement_summary import movement_sentences

    keep = frame_range(start, end, every, frames)
    who, poses, notes = _read(motion, body, up=up, unit=unit, names=names, scale=scale, frames=keep)
    time = poses.clock
    ranges = _ranges(who, poses)
    sentences = movement_sentences(who, poses)
    if as_json:
        data = {
            "file": str(motion),
            "body": who.name,
            "frames": len(poses),
            "start_s": float(time[0]),
            "end_s": float(time[-1]),
            "angles_deg": ranges,
            "movement": sentences,
            "notes": notes,
        }
        emit(json.dumps(data, indent=1))
        return 0
    emit(f"{motion}: {len(poses)} frames from {time[0]:g} to {time[-1]:g} s, told of {who.name}")
    _show_ranges(ranges)
    emit("\n".join(sentences))
    for note in notes:
        tell(f"note: {note}")
    return 0


def _show_ranges(ranges: dict[str, dict[str, list[float]]]) -> None:
    """A line for each joint: the least and greatest angle of each of its motions."""
    from workbench.model.units import plain

    emit(f"{'joint':<6} " + " ".join(f"{'motion':<20} {'from':>7} {'to':>7}" for _ in range(3)))
    for joint, row in ranges.items():
        cells = (
            f"{plain(name):<20} {least:>7.1f} {most:>7.1f}" for name, (least, most) in row.items()
        )
        emit(f"{joint:<6} " + " ".join(cells))


@motion_app.command
def convert(
    motion: Path,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    body: str = "bubbleman",
    up: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    unit: Unit = None,
    names: Names = None,
    scale: Scale = "body",
    start: Start = None,
    end: End = None,
    every: int = 1,
    frames: Frames = "as_stated",
    rate: float | None = None,
    speed: float = 1.0,
    tempo: float | None = None,
) -> int:
    """Write a motion file in another form: .csv (joint angles of the body), .bvh, .glb (a model
    that moves) or .laban (a score of direction signs).

    Parameters
    ----------
    motion
        a CSV, BVH, TRC, C3D, MOT, STO or LABAN file
    out
        the file to write; its ending says the form
    body
        the body that moves, by name or file
    up
        the file's upward axis, where it is not told right: x, y, z, -x, -y, -z
    every
        keep every n-th frame
    rate
        frames a second of the file written; those of the motion where not given
    speed
        seconds of the motion in a second of the file written; 0.1 is ten times slow motion
    tempo
        beats a minute of a score that is written
    """
    from workbench.files.output_file import check_file, write_file
    from workbench.study.motions import written_loss

    _check_form(out, tempo)
    check_file(out)
    keep = frame_range(start, end, every, frames)
    who, poses, notes = _read(motion, body, up=up, unit=unit, names=names, scale=scale, frames=keep)
    check_file(out)  # again, now that all inputs are known
    poses = _timed(poses, rate, speed)
    write_file(out, _written(who, poses, out.suffix.lower(), tempo))
    for note in notes:
        tell(f"note: {note}")
    lost = "" if out.suffix.lower() == ".glb" else written_loss(who, poses, out)
    if lost:
        tell(f"note: {out}: {lost}")
    emit(f"{out}: {len(poses)} frames")
    return 0


def _check_form(out: Path, tempo: float | None) -> None:
    """Raise where the ending of a file names no form of motion, or does not go with a tempo."""
    forms = (".csv", ".bvh", ".glb", ".laban")
    form = out.suffix.lower()
    if form not in forms:
        raise UsageError(
            f"{out}: {out.suffix or 'no ending'} is no form of motion to write; {one_of('', forms)}"
        )
    if (form == ".laban") != (tempo is not None):
        raise UsageError(
            f"{out}: a .laban file is written in beats and needs its --tempo; no other file has one"
        )


def frame_range(
    start: float | None, end: float | None, every: int = 1, frames: str = "as_stated"
) -> FrameRange:
    """The frames that are wanted, all those before or after where no end is given."""
    import math

    from workbench.files.motions.number_rows import FrameRange

    return FrameRange(
        -math.inf if start is None else start,
        math.inf if end is None else end,
        every,
        frames == "as_read",
    )


def _read(
    motion: Path,
    body: str,
    *,
    up: str | None,
    unit: str | None,
    names: Path | None,
    scale: Literal["body", "subject"],
    frames: FrameRange,
) -> tuple[Body, Poses, tuple[str, ...]]:
    """The body, sized as its subject where that is wanted, its motion, and notes on both."""
    from workbench.files.body.bodies import load_body
    from workbench.study.motions import load_motion, subject_body

    who = load_body(body)
    options = motion_options(up=up, unit=unit, names=names, frames=frames)
    sized: tuple[str, ...] = ()
    if scale == "subject":
        who, sized = subject_body(who, motion, options=options)
    poses, notes = load_motion(who, motion, options=options)
    return who, poses, sized + notes


def motion_options(
    *, up: str | None, unit: str | None, names: Path | None, frames: FrameRange
) -> MotionOptions:
    """How a motion file is read, by the options of a command."""
    from workbench.files.motions.reading import load_names
    from workbench.study.motions import MotionOptions

    return MotionOptions(
        names=None if names is None else load_names(names),
        up=up,
        metres=None if unit is None else _metres(unit),
        keep=frames,
    )


def _metres(unit: str) -> float:
    from workbench.files.schema import to_metres

    try:
        metres = to_metres(unit if unit[:1].isdigit() else f"1 {unit}")
    except ValueError as error:
        raise UsageError(f"unit {unit!r}: {error}") from None
    if not metres > 0:
        raise UsageError(f"unit {unit!r}: more than 0 is needed")
    return metres


def _ranges(who: Body, poses: Poses) -> dict[str, dict[str, list[float]]]:
    """Least and greatest angle [degrees] of each motion of each joint."""
    import numpy as np

    from workbench.model.arrays import pieces
    from workbench.model.joint_angles import ContinuousAngles, angles_of

    low = np.full((len(who.joints), 3), np.inf)
    high = -low
    continuous = ContinuousAngles()
    for rows in pieces(len(poses)):
        angles = np.degrees(continuous.take(angles_of(who, poses.rows(rows))))
        low = np.minimum(low, angles.min(axis=0))
        high = np.maximum(high, angles.max(axis=0))
    return {
        name: {
            motions[0]: [round(float(v[j, k]), 1) for v in (low, high)]
            for k, motions in enumerate(who.stops.motions[j])
        }
        for j, name in enumerate(who.joints)
    }


def _timed(poses: Poses, rate: float | None, speed: float) -> Poses:
    """The motion at another rate and speed."""
    from dataclasses import replace

    if not 1e-4 <= speed <= 1e4 or not (rate is None or 1e-3 <= rate <= 1e5):
        raise UsageError(f"rate {rate} and speed {speed}: both must be positive")
    if poses.time is None:
        raise UsageError("the motion has no times")
    if rate is not None:
        poses = _resampled(poses, speed / rate)
    time = poses.clock
    return replace(poses, time=time[0] + (time - time[0]) / speed)


def _resampled(poses: Poses, step: float) -> Poses:
    """The motion at times `step` [s] apart."""
    import numpy as np

    from workbench.model.arrays import pieces
    from workbench.model.joint_angles import poses_at
    from workbench.model.poses import stacked

    start = poses.clock[0]
    count = int(np.floor((poses.clock[-1] - start) / step + 1e-9)) + 1
    return stacked(poses_at(poses, start + step * np.arange(count)[rows]) for rows in pieces(count))


def _written(body: Body, poses: Poses, ending: str, tempo: float | None) -> Content:
    from workbench.body.forward import place
    from workbench.files.exports.gltf import Figure, glb_bytes
    from workbench.files.motions.bvh import bvh_text
    from workbench.files.motions.laban import score_text
    from workbench.files.motions.tables import angle_table_text
    from workbench.model.arrays import pieces
    from workbench.motion.laban.reading import read_motion_score

    if ending == ".csv":
        return angle_table_text(body, poses)
    if ending == ".bvh":
        return bvh_text(body, poses, (place(body, poses.rows(rows)) for rows in pieces(len(poses))))
    if len(poses) > _MOST_HELD:
        raise UsageError(
            f"{len(poses)} frames are too many for a {ending} file, {_MOST_HELD} are possible: write "
            "a part of them (--start, --end) or fewer (--rate, --every)"
        )
    if tempo is not None:
        return score_text(read_motion_score(body, poses, tempo=tempo))
    return glb_bytes([Figure(body.name, place(body, poses), (0.75, 0.55, 0.42))], times=poses.time)


@motion_app.command
def simulate(
    simulation: str,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    forces: Path | None = None,
) -> int:
    """Simulate a crash and write its motion, for a study of kind crash to read.

    A crude simulator: rigid segments on ball joints, springs for flesh, foam and webbing, no
    muscles that answer, no injury. It shows how a body goes and what it may reach, not what it
    suffers; a test or a validated model says more. Needs MuJoCo: pip install
    'bubbleman-workbench[dynamics]'.

    Parameters
    ----------
    simulation
        a simulation file, or the name of one in studies/simulations
    out
        the motion to write: a .csv of joint angles
    forces
        also a .csv of the belts' tensions over time
    """
    from workbench.files.crash.simulations import load_simulation
    from workbench.files.motions.tables import angle_table_text
    from workbench.files.output_file import check_file, write_file
    from workbench.study.motion_cases import run_simulation

    paths = [out, forces] if forces is not None else [out]
    for path in paths:
        if path.suffix.lower() != ".csv":
            raise UsageError(f"{path}: a simulated motion and its forces are written as .csv")
        check_file(path)
    if forces is not None and forces.resolve() == out.resolve():
        raise UsageError(f"{forces}: the motion and the forces need a file each")
    with Progress() as say:
        say(f"reading {simulation}")
        plan = load_simulation(simulation)
        for path in paths:
            check_file(path)  # again, now that all inputs are known
        say(f"simulating {plan.file.duration:g} ms")
        made = run_simulation(plan)
    first, *rest = angle_table_text(plan.body, made.motion)
    about = f"# made by: the simulation {plan.file.simulation}, crude rigid-body dynamics, no measured motion\n"
    write_file(out, "".join([first, about, *rest]))
    if forces is not None:
        write_file(forces, _forces(plan, made))
    for warning in made.warnings:
        tell(f"warning: {warning}")
    emit(_summary(plan, made))
    emit(out)
    return 0


def _forces(plan: SimulationPlan, made: Simulated) -> str:
    """Tensions and payouts of the belts over time as CSV."""
    head = [
        "time [ms]",
        *(f"{b.name} {what}" for b in plan.belts for what in ("tension [N]", "payout [mm]")),
    ]
    lines = [", ".join(head)]
    for time, tension, payout in zip(made.motion.clock, made.tension, made.payout, strict=True):
        cells = [f"{v:.1f}" for pair in zip(tension, 1000 * payout, strict=True) for v in pair]
        lines.append(", ".join([f"{1000 * time:.3f}", *cells]))
    return "\n".join(lines) + "\n"


def _summary(plan: SimulationPlan, made: Simulated) -> str:
    """What came of it, in a line for the motion and one for each belt."""
    from workbench.model.simulation import gained

    clock = made.motion.clock
    speed = float(gained(plan.pulse, clock[-1:])[0])
    lines = [f"{len(clock)} frames over {1000 * clock[-1]:g} ms; the vehicle loses {speed:.2f} m/s"]
    for b, belt in enumerate(plan.belts):
        most = int(made.tension[:, b].argmax())
        lines.append(
            f"{belt.name}: up to {made.tension[most, b]:.0f} N at {1000 * clock[most]:.0f} ms, "
            f"{1000 * made.payout[most, b]:.0f} mm longer"
        )
    return "\n".join(lines)
